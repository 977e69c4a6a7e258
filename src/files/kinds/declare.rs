//! A declared behavior as read, to terms that make sense: every parameter known and of the fitting type.

use std::collections::{BTreeMap, BTreeSet};
use std::time::Duration;

use super::super::fault::Faults;
use super::super::parameter::{Parameter, Type};
use super::super::quantity::{NEAR, POTENTIAL};
use super::super::raw::each;
use super::super::reader::{Fields, Item, Name};
use super::super::template::{self, pieces};
use super::shape::{
    BEHAVIOR, CLAIM, COMMAND, CONDITION, EFFECT, KEEP, MAX_RETRIES, OBJECT_AT, POTENTIAL_OF, STAND_OF, TABLE, TAKEN,
    TASK,
};
use super::{
    Base, ClaimTerm, Claims, Command, ConditionTerm, Declared, Effect, Filter, KeepTerm, Offset, Piece, PotentialTerm,
    Slot, Stand, TaskTerm, Text, Whom,
};
use ambidex_model::{Mode, suggestion};

const TIMEOUT_S: f64 = 120.0;
const RETRIES: u32 = 2;

impl Declared {
    /// Reads an entry of `behaviors`; `None` when it has faults.
    pub(super) fn read(name: Name, item: Item<'_>, faults: &mut Faults) -> Option<Self> {
        let before = faults.errors();
        let fields = item.fields(&BEHAVIOR, faults)?;
        let parameters = Parameter::read_all(fields.get("parameters"), faults);
        let mut terms = Terms { parameters: &parameters, used: BTreeSet::new(), claims: Vec::new(), faults };
        let label = fields.get("label").and_then(|item| terms.text(item));
        let claims = terms.claims(fields.get("claims"));
        let potential = fields.get("potential").and_then(|item| terms.potential(item));
        let goal = fields.get("goal").map(|item| terms.list(item, Terms::condition));
        let precondition = fields.get("precondition").map(|item| terms.list(item, Terms::condition));
        let effects = fields.get("effects").map(|item| terms.list(item, Terms::effect));
        let commands = fields.get("commands").map(|item| terms.list(item, Terms::command));
        terms.refuse_second_commands(commands.as_deref().unwrap_or_default());
        let used = terms.used;
        let takes_s = fields.number_or("takes", 0.0, faults)?;
        let timeout_s = fields.number_or("timeout", TIMEOUT_S, faults)?;
        if let Some(takes) = fields.get("takes").filter(|_| takes_s >= timeout_s) {
            let message = format!("it takes {takes_s} s, and its timeout is {timeout_s} s");
            faults.push(takes.spot, takes.key, message, Some("give it a greater `timeout`".to_owned()));
        }
        let retries = match fields.get("retries") {
            Some(item) => item.count(MAX_RETRIES, faults)?,
            None => RETRIES,
        };
        let unused = parameters.iter().enumerate().filter(|(index, _)| !used.contains(index));
        // What is wrong in it may be the use that is missed.
        let unused: Vec<_> = unused.filter(|_| faults.errors() == before).collect();
        for (_, parameter) in unused {
            let message = format!("parameter `{}` is not used", parameter.name.value);
            faults.warn(parameter.name.spot, &parameter.name.key, message, None);
        }
        let declared = Self {
            label,
            claims: claims?,
            potential: potential?,
            goal,
            precondition: precondition.unwrap_or_default(),
            effects: effects.unwrap_or_default(),
            commands: commands.unwrap_or_default(),
            takes: Duration::from_secs_f64(takes_s),
            timeout: Duration::from_secs_f64(timeout_s),
            retries,
            name,
            parameters,
        };
        (faults.errors() == before).then_some(declared)
    }
}

/// Reads the terms of one behavior.
struct Terms<'a> {
    parameters: &'a [Parameter],
    used: BTreeSet<usize>,
    claims: Vec<Name>,
    faults: &'a mut Faults,
}

impl Terms<'_> {
    fn list<T>(&mut self, item: Item<'_>, read: impl Fn(&mut Self, Item<'_>) -> Option<T>) -> Vec<T> {
        let items = item.list("a list of maps, each with a dash", self.faults);
        items.into_iter().flatten().filter_map(|item| read(self, item)).collect()
    }

    /// The parameter of a name; a fault if there is none.
    fn parameter(&mut self, name: &str, at: &Name) -> Option<usize> {
        let found = self.parameters.iter().position(|parameter| parameter.name.value == name);
        self.used.extend(found);
        if found.is_none() {
            let allowed = self.parameters.iter().map(|parameter| parameter.name.value.as_str());
            let help = suggestion(name, "parameter", allowed);
            self.faults.push(at.spot, &at.key, format!("there is no parameter `{name}`"), Some(help));
        }
        found
    }

    /// A name, or a parameter of that type.
    fn slot(&mut self, item: Item<'_>, ty: Type) -> Option<Slot> {
        let written = item.name(ty.what(), self.faults)?;
        let Some(name) = template::parameter(&written.value).map(str::to_owned) else {
            return Some(Slot { written, parameter: None });
        };
        let index = self.parameter(&name, &written)?;
        let found = self.parameters[index].ty;
        if found != ty {
            let message = format!("`${name}` is {}, not {}", found.what(), ty.what());
            self.faults.push(written.spot, &written.key, message, None);
            return None;
        }
        Some(Slot { written, parameter: Some(index) })
    }

    fn slot_of(&mut self, fields: &Fields<'_>, key: &str, ty: Type) -> Option<Slot> {
        self.slot(fields.get(key)?, ty)
    }

    fn text(&mut self, item: Item<'_>) -> Option<Text> {
        let written = item.name("a text", self.faults)?;
        let mut found = Vec::new();
        for piece in pieces(&written.value) {
            found.push(match piece {
                template::Piece::Plain(text) => Piece::Plain(text.to_owned()),
                template::Piece::Parameter(name) => Piece::Parameter(self.parameter(name, &written)?),
            });
        }
        Some(Text { pieces: found, written })
    }

    fn stand(&mut self, item: Item<'_>) -> Option<Stand> {
        if !item.is_map() {
            return Some(Stand { place: self.slot(item, Type::Place)?, offset: Offset::None });
        }
        let fields = item.fields(&STAND_OF, self.faults)?;
        let place = self.slot_of(&fields, "place", Type::Place);
        let offset = match fields.get("offset") {
            None => Some(Offset::None),
            Some(item) if item.is_scalar() => {
                let slot = self.slot(item, Type::Offset)?;
                if slot.parameter.is_none() {
                    item.wrong(Type::Offset.what(), self.faults);
                }
                slot.parameter.map(Offset::Parameter)
            }
            Some(item) => item.vector(2..=2, &NEAR, self.faults).map(|at| Offset::By([at[0], at[1]])),
        };
        Some(Stand { place: place?, offset: offset? })
    }

    fn claims(&mut self, item: Option<Item<'_>>) -> Option<Claims> {
        let Some(item) = item else {
            return Some(Claims::Some(Vec::new()));
        };
        if item.is_scalar() {
            return item.word(&["all"], "a map of claims, or `all`", self.faults).map(|_| Claims::All);
        }
        let entries = item.named("a map of claims, or `all`", self.faults)?;
        self.claims = entries.iter().map(|(name, _)| name.clone()).collect();
        let claims: Vec<_> = entries.into_iter().map(|(name, item)| self.claim(name, item)).collect();
        claims.into_iter().collect::<Option<_>>().map(Claims::Some)
    }

    fn claim(&mut self, name: Name, item: Item<'_>) -> Option<ClaimTerm> {
        let fields = item.fields(&CLAIM, self.faults)?;
        let whom = fields.one().and_then(|whom| match whom.key {
            "type" => self.slot(whom, Type::Kind).map(Whom::Type),
            _ => self.slot(whom, Type::Resource).map(Whom::Resource),
        });
        let filter = self.filter(&fields);
        let shared = fields.get("shared").map(|item| self.text(item));
        let keep = self.keep(&fields);
        let optional = fields.get("optional").map(|item| item.flag(self.faults));
        let claim = ClaimTerm {
            whom: whom?,
            filter: filter?,
            shared: match shared {
                Some(text) => Some(text?),
                None => None,
            },
            keep: keep?,
            is_optional: optional.unwrap_or(Some(false))?,
            name,
        };
        if let (Some(shared), KeepTerm::For(kept)) = (&claim.shared, &claim.keep)
            && shared.written.value != kept.written.value
        {
            let message = format!("used for `{}`, it cannot be kept for another", shared.written.value);
            self.faults.push(kept.written.spot, &kept.written.key, message, None);
        }
        Some(claim)
    }

    fn filter(&mut self, fields: &Fields<'_>) -> Option<Filter> {
        let found = fields.among(&["empty", "reaches", "holds"]);
        if let Some(second) = fields.get("holds").filter(|_| found.len() > 1) {
            let message = "what holds an object is not empty".to_owned();
            self.faults.push(second.spot, second.key, message, None);
        }
        let empty = fields.get("empty").map_or(Some(false), |item| item.flag(self.faults))?;
        match (fields.get("holds"), fields.get("reaches")) {
            (Some(item), _) => self.slot(item, Type::Object).map(Filter::Holds),
            (None, Some(item)) => self.slot(item, Type::Object).map(Filter::Reaches),
            (None, None) => Some(if empty { Filter::Empty } else { Filter::Any }),
        }
    }

    fn keep(&mut self, fields: &Fields<'_>) -> Option<KeepTerm> {
        let Some(item) = fields.get("keep") else {
            return Some(KeepTerm::Release);
        };
        if !item.is_map() {
            let word = item.word(&["physical"], "`physical`, or `for` an intention", self.faults);
            return word.map(|_| KeepTerm::Physical);
        }
        let keep = item.fields(&KEEP, self.faults)?;
        self.text(keep.get("for")?).map(KeepTerm::For)
    }

    fn potential(&mut self, item: Item<'_>) -> Option<PotentialTerm> {
        if !item.is_map() {
            return Some(PotentialTerm { base: self.constant(item)?, scale_by: None });
        }
        let fields = item.fields(&POTENTIAL_OF, self.faults)?;
        let scale_by = match fields.get("scale_by") {
            Some(item) => Some(self.slot(item, Type::Kind)?),
            None => None,
        };
        let base = fields.one()?;
        let base = match base.key {
            "constant" => self.constant(base),
            "nearness" => self.stand(base).map(Base::Nearness),
            _ => self.table(base),
        };
        Some(PotentialTerm { base: base?, scale_by })
    }

    fn constant(&mut self, item: Item<'_>) -> Option<Base> {
        if item.text() == Some("high") {
            return Some(Base::High);
        }
        if item.text().and_then(template::parameter).is_some() {
            return self.slot(item, Type::Number)?.parameter.map(Base::Parameter);
        }
        item.quantity(&POTENTIAL, self.faults).map(Base::Constant)
    }

    fn table(&mut self, item: Item<'_>) -> Option<Base> {
        let fields = item.fields(&TABLE, self.faults)?;
        let by = fields.get("by")?.name("a parameter such as `$object`", self.faults)?;
        let by = match template::parameter(&by.value) {
            Some(name) => self.parameter(name, &by),
            None => {
                let message = format!("found `{}` instead of a parameter such as `$object`", by.value);
                self.faults.push(by.spot, &by.key, message, None);
                None
            }
        };
        let number = |item: Item<'_>, faults: &mut Faults| item.quantity(&POTENTIAL, faults);
        let values = each(fields.get("values"), "a map from arguments to numbers", self.faults, number);
        let values: BTreeMap<_, _> =
            values.into_iter().filter_map(|(name, value)| Some((name.value, value?))).collect();
        let otherwise = fields.number("otherwise", self.faults);
        Some(Base::Table { by: by?, values, otherwise: otherwise? })
    }

    fn object_at(&mut self, item: Item<'_>) -> Option<(Slot, Slot)> {
        let fields = item.fields(&OBJECT_AT, self.faults)?;
        let object = self.slot_of(&fields, "object", Type::Object);
        let place = self.slot_of(&fields, "at", Type::Place);
        Some((object?, place?))
    }

    fn condition(&mut self, item: Item<'_>) -> Option<ConditionTerm> {
        let term = item.fields(&CONDITION, self.faults)?.one()?;
        match term.key {
            "at" => self.stand(term).map(ConditionTerm::At),
            "path" => self.stand(term).map(ConditionTerm::Path),
            "held" => self.slot(term, Type::Object).map(ConditionTerm::Held),
            "free" => self.slot(term, Type::Object).map(ConditionTerm::Free),
            "lies" => self.object_at(term).map(|(object, place)| ConditionTerm::Lies(object, place)),
            "fact" => self.text(term).map(|fact| ConditionTerm::Fact(fact, true)),
            _ => self.text(term).map(|fact| ConditionTerm::Fact(fact, false)),
        }
    }

    fn effect(&mut self, item: Item<'_>) -> Option<Effect> {
        let term = item.fields(&EFFECT, self.faults)?.one()?;
        match term.key {
            "taken" => {
                let fields = term.fields(&TAKEN, self.faults)?;
                let object = self.slot_of(&fields, "object", Type::Object);
                let by = self.claimed(fields.get("by")?);
                Some(Effect::Taken(object?, by?))
            }
            "lies" => self.object_at(term).map(|(object, place)| Effect::Lies(object, place)),
            "set" => self.text(term).map(|fact| Effect::Fact(fact, true)),
            _ => self.text(term).map(|fact| Effect::Fact(fact, false)),
        }
    }

    /// The claim of a name.
    fn claimed(&mut self, item: Item<'_>) -> Option<usize> {
        let name = item.name("the name of a claim", self.faults)?;
        let found = self.claims.iter().position(|claim| claim.value == name.value);
        if found.is_none() {
            let message = format!("there is no claim `{}`", name.value);
            let help = suggestion(&name.value, "claim", self.claims.iter().map(|claim| claim.value.as_str()));
            self.faults.push(name.spot, &name.key, message, Some(help));
        }
        found
    }

    fn command(&mut self, item: Item<'_>) -> Option<Command> {
        let fields = item.fields(&COMMAND, self.faults)?;
        let claim = fields.get("claim").and_then(|item| self.claimed(item));
        let what = fields.one()?;
        let mode = if what.key == "achieve" { Mode::Achieve } else { Mode::Maintain };
        let task = self.task(what)?;
        let ends = matches!(task, TaskTerm::Drive(_) | TaskTerm::Grasp(_) | TaskTerm::Put(..));
        if mode == Mode::Maintain && ends {
            let message = "what ends by itself cannot be maintained".to_owned();
            self.faults.push(what.spot, what.key, message, Some("write `achieve`".to_owned()));
        }
        Some(Command { spot: what.spot, claim: claim?, mode, task })
    }

    /// A controller does one thing at a time.
    fn refuse_second_commands(&mut self, commands: &[Command]) {
        let mut seen = BTreeSet::new();
        for command in commands.iter().filter(|command| !seen.insert(command.claim)) {
            let key = if command.mode == Mode::Achieve { "achieve" } else { "maintain" };
            let message = format!("`{}` has a command already", self.claims[command.claim].value);
            let help = "a controller does one thing at a time: one command for each claim".to_owned();
            self.faults.push(command.spot, key, message, Some(help));
        }
    }

    fn task(&mut self, item: Item<'_>) -> Option<TaskTerm> {
        if !item.is_map() {
            return item.word(&["stand"], "`stand`, or a map", self.faults).map(|_| TaskTerm::Stand);
        }
        let task = item.fields(&TASK, self.faults)?.one()?;
        match task.key {
            "drive_to" => self.stand(task).map(TaskTerm::Drive),
            "grasp" => self.slot(task, Type::Object).map(TaskTerm::Grasp),
            "put" => self.object_at(task).map(|(object, place)| TaskTerm::Put(object, place)),
            _ => self.slot(task, Type::Place).map(TaskTerm::Look),
        }
    }
}
