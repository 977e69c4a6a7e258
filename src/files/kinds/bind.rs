//! A declared behavior with its arguments, bound to robot and world: every name an id, every place a stand.

use std::collections::BTreeSet;
use std::sync::Arc;

use nalgebra::Vector2;

use super::hands::ObjectBy;
use super::terms::{Base, ConditionTerm, Constant, Effect, ObjectAt, PotentialTerm, Stand, Table};
use super::{Declared, NameOrParam, Stop, Text};
use crate::document::SourceSpan;
use crate::fault::Faults;
use crate::names::Register;
use crate::parameter::{Argument, BEFORE, Known, Meaning, Parameter, START};
use crate::reader::{Item, Name};
use crate::robot::RobotFile;
use crate::text::scalar;
use crate::types::Type;
use crate::world::Built;
use ambidex_model::{
    BehaviorSpec, ChannelId, Condition, EffectTerm, Elsewhere, FactId, ObjectId, PlaceId, Pose, Potential, RobotSpec,
    StandId, TypeId, suggestion,
};

/// Binds behaviors to a robot in a world.
pub(crate) struct Binder<'a> {
    pub(super) robot: &'a RobotFile,
    world: &'a Built,
    pub(super) known: Known<'a>,
    /// Channels that there are already.
    channels: &'a Register,
    /// Further ones, whose ids follow.
    more_channels: Register,
    /// Facts that some behavior needs and that nobody declared, each told already.
    undeclared: BTreeSet<String>,
    /// Behaviors that were bound for each place, all together.
    variants: usize,
}

/// Most behaviors that are bound for each place, each counted as often as there are places.
const MAX_VARIANTS: usize = 100_000;

/// Where in the task a behavior stands.
pub(crate) struct Site<'a> {
    pub(crate) span: SourceSpan,
    pub(crate) arguments: &'a [Option<Argument>],
    /// Where the nearest `move` before it in its THEN goes.
    pub(crate) before: Option<Stop>,
    /// Whether something after it in its THEN claims a type.
    pub(crate) is_claimed_after: &'a dyn Fn(TypeId) -> bool,
}

impl<'a> Binder<'a> {
    pub(crate) fn new(robot: &'a RobotFile, world: &'a Built, known: Known<'a>, channels: &'a Register) -> Self {
        Self {
            channels,
            more_channels: Register::new("channel"),
            undeclared: BTreeSet::new(),
            variants: 0,
            robot,
            world,
            known,
        }
    }

    /// The channels that there were not, by id behind those that there were.
    pub(crate) fn into_channels(self) -> Vec<String> {
        self.more_channels.into_names()
    }

    /// The behavior of a node; `None` when it has faults. One that is about the place of an object is bound for each place
    /// where that may lie.
    pub(crate) fn bind(&mut self, kind: &Declared, site: &Site<'_>, faults: &mut Faults) -> Option<BehaviorSpec> {
        let told = site.arguments.iter().flatten().find_map(|argument| argument.value.followed());
        let Some(object) = told.or_else(|| site.before?.follows) else {
            return self.bind_at_stands(kind, site, faults);
        };
        // What is held at the start lies nowhere: any place will do until it does.
        let start = self.world.starts.get(object.index())?.unwrap_or(PlaceId(0));
        self.world.spec.places.get(start.index())?;
        let mut behavior = self.bind_at(kind, site, object, start, faults)?;
        let places = (0..self.world.spec.places.len()).map(PlaceId::from);
        let mut at = places.map(|place| self.bind_at(kind, site, object, place, faults)).collect::<Option<Vec<_>>>()?;
        if at.iter().all(|other| *other == behavior) {
            return Some(behavior);
        }
        self.variants += at.len();
        if self.variants > MAX_VARIANTS {
            let message = format!("more than {MAX_VARIANTS} places in all that behaviors follow objects to");
            faults.push((site.span, kind.name.value.as_str()), message);
            return None;
        }
        // Wherever it lies it may be there already; where it lies nowhere, nobody is there.
        if at.iter().any(|other| other.satisfied != behavior.satisfied) {
            only_somewhere(&mut behavior, object, |one| &mut one.satisfied);
        }
        for one in at.iter_mut().chain([&mut behavior]) {
            only_somewhere(one, object, |one| &mut one.precondition);
        }
        behavior.elsewhere = Some(Arc::new(Elsewhere { object, at }));
        Some(behavior)
    }

    /// The behavior while an object that it follows lies at a place.
    fn bind_at(
        &mut self,
        kind: &Declared,
        site: &Site<'_>,
        object: ObjectId,
        place: PlaceId,
        faults: &mut Faults,
    ) -> Option<BehaviorSpec> {
        let follows = |argument: &Argument| argument.value.followed() == Some(object);
        let there = |argument: Argument| if follows(&argument) { self.place(place) } else { Some(argument) };
        let arguments: Vec<_> = site.arguments.iter().cloned().map(|argument| argument.and_then(there)).collect();
        let before = site.before.map(|before| match before.follows == Some(object) {
            true => Stop { place, ..before },
            false => before,
        });
        self.bind_at_stands(kind, &Site { arguments: &arguments, before, ..*site }, faults)
    }

    /// The behavior, which is bound for each stand where the place that it is about has several.
    fn bind_at_stands(&mut self, kind: &Declared, site: &Site<'_>, faults: &mut Faults) -> Option<BehaviorSpec> {
        let (mut behavior, several) = self.bind_one(kind, site, None, faults)?;
        let Some(place) = several else { return Some(behavior) };
        let stands = (0..self.world.spec.places[place.index()].stands().len()).map(StandId::from);
        let bound = stands.map(|stand| Some(self.bind_one(kind, site, Some((place, stand)), faults)?.0));
        let stands = bound.collect::<Option<Arc<[_]>>>()?;
        self.variants += stands.len();
        behavior.stands = Some(stands);
        Some(behavior)
    }

    /// The behavior at one stand of a place, or at any; with the place of several stands that it is about.
    fn bind_one(
        &mut self,
        kind: &Declared,
        site: &Site<'_>,
        stand: Option<(PlaceId, StandId)>,
        faults: &mut Faults,
    ) -> Option<(BehaviorSpec, Option<PlaceId>)> {
        let before = faults.errors();
        let arguments = self.with_defaults(kind, site, faults)?;
        let claims = Vec::new();
        let mut bound = Bound { binder: self, kind, site, arguments, claims, stand, several: None, faults };
        let claims = bound.claims()?;
        let (effects, changes) = bound.effects();
        let mut behavior = BehaviorSpec {
            kind: kind.name.value.clone(),
            claims,
            potential: bound.potential(&kind.potential)?,
            satisfied: kind.goal.as_ref().map_or(Condition::Never, |goal| bound.conditions(goal)),
            precondition: bound.precondition(),
            lasting: bound.conditions(&kind.lasting),
            is_interruptible: true,
            effects,
            commands: Vec::new(),
            changes,
            takes: kind.takes,
            timeout: kind.timeout,
            retries: kind.retries,
            backoff: kind.backoff,
            elsewhere: None,
            stands: None,
        };
        bound.commands(&mut behavior);
        if bound.faults.errors() == before {
            bound.check_holders(&behavior);
        }
        bound.check_claims(&behavior.claims);
        let uses_hands = || !behavior.changes.is_empty() || behavior.claims.iter().any(|claim| bound.is_hand(claim));
        behavior.is_interruptible = kind.interruptible.unwrap_or_else(|| !uses_hands());
        let several = bound.several;
        (faults.errors() == before).then_some((behavior, several))
    }

    fn with_defaults(&self, kind: &Declared, site: &Site<'_>, faults: &mut Faults) -> Option<Vec<Option<Argument>>> {
        let before = faults.errors();
        let mut arguments = site.arguments.to_vec();
        let start = || {
            let object = site.arguments.iter().flatten().find_map(|argument| argument.value.object())?;
            self.world.starts.get(object.index()).copied().flatten()
        };
        for (parameter, argument) in kind.parameters.iter().zip(&mut arguments) {
            let Some(defaults) = parameter.defaults.as_ref().filter(|_| argument.is_none()) else { continue };
            *argument = defaults.iter().find_map(|default| {
                let item = Item::of(&parameter.name.value, default);
                match item.text() {
                    Some(BEFORE) => self.place(site.before?.place),
                    Some(START) => self.place(start()?),
                    Some(word) if parameter.ty == Type::Kind && !self.has_type(word) => None,
                    Some(_) | None => self.known.argument(item, parameter.ty, faults),
                }
            });
            if argument.is_none() && parameter.ty != Type::Kind {
                self.not_told(kind, parameter, site, faults);
            }
        }
        (faults.errors() == before).then_some(arguments)
    }

    fn has_type(&self, word: &str) -> bool {
        self.known.robot.is_some_and(|names| names.types.id(word).is_some())
    }

    fn place(&self, place: PlaceId) -> Option<Argument> {
        let text = self.known.world?.places.name(place.index()).to_owned();
        Some(Argument { text, value: Meaning::Place(place) })
    }

    fn not_told(&self, kind: &Declared, parameter: &Parameter, site: &Site<'_>, faults: &mut Faults) {
        let name = &parameter.name.value;
        let help = format!("write `{name}`, or let it follow a `move` in a `then`");
        faults.push_with((site.span, &kind.name.value), format!("not told {}: `{name}`", parameter.ty.what()), help);
    }
}

/// One behavior on its way to a node.
pub(super) struct Bound<'a, 'b> {
    pub(super) binder: &'b mut Binder<'a>,
    pub(super) kind: &'b Declared,
    pub(super) site: &'b Site<'b>,
    pub(super) arguments: Vec<Option<Argument>>,
    /// Where each declared claim stands among those of the robot; none for one that it leaves out.
    pub(super) claims: Vec<Option<usize>>,
    /// The stand that is meant, where a place has several.
    stand: Option<(PlaceId, StandId)>,
    /// The place of several stands that it is about.
    several: Option<PlaceId>,
    pub(super) faults: &'b mut Faults,
}

impl Bound<'_, '_> {
    pub(super) fn robot(&self) -> &RobotSpec {
        &self.binder.robot.robot
    }

    pub(super) fn meaning(&mut self, name: &NameOrParam, ty: Type) -> Option<Meaning> {
        match name.parameter {
            Some(index) => self.arguments[index].as_ref().map(|argument| argument.value),
            None => self.binder.known.named(&name.written, ty, self.faults),
        }
    }

    pub(super) fn object(&mut self, name: &NameOrParam) -> Option<ObjectId> {
        self.meaning(name, Type::Object)?.object()
    }

    pub(super) fn place(&mut self, name: &NameOrParam) -> Option<PlaceId> {
        self.meaning(name, Type::Place)?.place()
    }

    /// A place with the stands that are meant, the first of which it is unless one is as good: where the move before went, if
    /// it went there and nothing else is told.
    pub(super) fn stop(&mut self, stand: &Stand) -> Option<(PlaceId, Vec<Pose>)> {
        let place = self.place(&stand.place)?;
        let before = self.site.before.filter(|before| before.place == place);
        let offset = stand.offset(&self.arguments).or(before.and_then(|before| before.offset));
        let spec = &self.binder.world.spec.places[place.index()];
        let stands: Vec<_> = match self.stand {
            Some((at, stand)) if at == place => vec![spec.stand(stand)],
            Some(_) | None => spec.stands().collect(),
        };
        self.several = self.several.or(Some(place).filter(|_| stands.len() > 1));
        let offset = Vector2::from(offset.unwrap_or_default());
        Some((place, stands.into_iter().map(|stand| Pose { at: stand.at + offset, ..stand }).collect()))
    }

    /// A fact; the first time that one is not declared, that is a fault with the line to add.
    pub(super) fn fact(&mut self, text: &Text) -> Option<FactId> {
        let value = text.filled(&self.arguments);
        let facts = &self.binder.known.world?.facts;
        if let Some(found) = facts.id(&value) {
            return Some(found.into());
        }
        if self.binder.undeclared.insert(value.clone()) {
            let line = match facts.names() {
                [] => format!("`facts: {{{}: false}}` under `world:`", scalar(&value)),
                _ => format!("`{}: false` under `facts:` of the `world:`", scalar(&value)),
            };
            let add = match facts.meant(&value) {
                Some(meant) => format!("{meant} Else add {line}"),
                None => format!("add {line}"),
            };
            let is_made = value != text.written.value;
            let of_node =
                if is_made { format!("; the node on line {} needs it", self.site.span.line) } else { String::new() };
            self.faults.push_with(&text.written, facts.lacks(&value), format!("{add}{of_node}"));
        }
        None
    }

    pub(super) fn channel(&mut self, text: &Text) -> ChannelId {
        let name = match self.stand {
            Some((place, stand)) => text.filled(&self.at_stand(place, stand)),
            None => text.filled(&self.arguments),
        };
        let further = || self.binder.channels.names().len() + self.binder.more_channels.intern(&name);
        self.binder.channels.id(&name).unwrap_or_else(further).into()
    }

    /// Its arguments, with the stand behind the place that it is about: who stands at another one is somewhere else.
    fn at_stand(&self, place: PlaceId, stand: StandId) -> Vec<Option<Argument>> {
        let names = self.binder.known.world.and_then(|world| world.stands.get(place.index()));
        let name = names.and_then(|names| names.get(stand.index())).map_or("", String::as_str);
        let mut arguments = self.arguments.clone();
        for argument in arguments.iter_mut().flatten().filter(|argument| argument.value.place() == Some(place)) {
            argument.text = format!("{} ({name})", argument.text);
        }
        arguments
    }

    /// The type of a name; a robot may well have none, but then the name may be misspelt.
    fn scale(&mut self, written: &Name) -> Option<TypeId> {
        let types = &self.binder.known.robot?.types;
        let found = types.id(&written.value);
        if found.is_none() {
            let message = format!("the robot has no resource of type `{}`, so nothing is scaled", written.value);
            let help = suggestion(&written.value, "type", types.names().iter().map(String::as_str));
            self.faults.warn(written, message, Some(help));
        }
        found.map(TypeId::from)
    }

    pub(super) fn potential(&mut self, term: &PotentialTerm) -> Option<Potential> {
        let scale_by = match &term.scale_by {
            None => None,
            Some(NameOrParam { parameter: Some(index), .. }) => {
                self.arguments[*index].as_ref().and_then(|argument| argument.value.ty())
            }
            Some(name) => self.scale(&name.written),
        };
        let value = match &term.base {
            Base::Nearness(stand) => {
                let to = self.stop(stand)?.1[0];
                let scale_by = scale_by.filter(|of| (self.site.is_claimed_after)(*of));
                return Some(Potential::Nearness { to, floor_m: self.binder.world.tolerance_m, scale_by });
            }
            Base::Constant(Constant::Value(value)) => *value,
            Base::Constant(Constant::Told(index)) => self.arguments[*index].as_ref()?.value.number()?,
            Base::Constant(Constant::High) => self.high(),
            Base::Table(Table { by, values, otherwise }) => {
                let text = self.arguments[*by].as_ref().map(|argument| &argument.text);
                let value = values.iter().find(|(name, _)| Some(&name.value) == text);
                value.and_then(|(_, value)| *value).unwrap_or(*otherwise)
            }
        };
        Some(match scale_by {
            Some(by) => Potential::Scaled { value, by },
            None => Potential::Constant(value),
        })
    }

    /// A potential that nearness does not reach, whatever type it is scaled by.
    pub(super) fn high(&self) -> f64 {
        let robot = self.robot();
        let types = robot.resources.iter().map(|resource| resource.ty);
        let most = types.map(|ty| robot.of_type(ty).count()).max().unwrap_or(1);
        1.0 + most as f64 / self.binder.world.tolerance_m
    }

    pub(super) fn conditions(&mut self, terms: &[ConditionTerm]) -> Condition {
        let parts: Vec<_> = terms.iter().filter_map(|term| self.condition(term)).collect();
        all(parts)
    }

    pub(super) fn precondition(&mut self) -> Condition {
        let kind = self.kind;
        // What is to last has to be so at the beginning.
        let parts: Vec<_> =
            kind.precondition.iter().chain(&kind.lasting).filter_map(|term| self.condition(term)).collect();
        all(parts)
    }

    pub(super) fn condition(&mut self, term: &ConditionTerm) -> Option<Condition> {
        Some(match term {
            ConditionTerm::At(stand) => {
                let (place, stands) = self.stop(stand)?;
                Condition::At { place, stands, tolerance_m: self.binder.world.tolerance_m }
            }
            ConditionTerm::Path(stand) => {
                let (place, stands) = self.stop(stand)?;
                Condition::Path { place, stands }
            }
            ConditionTerm::Held(held) => Condition::Held(self.hold(held)?),
            ConditionTerm::Free(object) => Condition::Free(self.object(object)?),
            ConditionTerm::Lies(ObjectAt { object, place }) => {
                Condition::Lies(self.object(object)?, self.place(place)?)
            }
            ConditionTerm::Fact(fact) => Condition::Fact(self.fact(fact)?, true),
            ConditionTerm::NotFact(fact) => Condition::Fact(self.fact(fact)?, false),
        })
    }

    /// The effects, and the objects that they change.
    pub(super) fn effects(&mut self) -> (Vec<EffectTerm>, Vec<ObjectId>) {
        let kind = self.kind;
        let mut changes = Vec::new();
        let mut effects = Vec::new();
        for term in &kind.effects {
            effects.extend(self.effect(term));
        }
        for effect in &effects {
            if let EffectTerm::Taken(object, _) | EffectTerm::LetGo(object, _) | EffectTerm::Lies(object, _) = effect
                && !changes.contains(object)
            {
                changes.push(*object);
            }
        }
        (effects, changes)
    }

    pub(super) fn effect(&mut self, term: &Effect) -> Option<EffectTerm> {
        Some(match term {
            Effect::Taken(taken) => {
                let ObjectBy { object, claim } = &taken.value;
                EffectTerm::Taken(self.object(object)?, self.claims[*claim]?)
            }
            Effect::LetGo(let_go) => {
                let ObjectBy { object, claim } = &let_go.value;
                EffectTerm::LetGo(self.object(object)?, self.claims[*claim]?)
            }
            Effect::Lies(lies) => {
                let ObjectAt { object, place } = &lies.value;
                EffectTerm::Lies(self.object(object)?, self.place(place)?)
            }
            Effect::Set(fact) => EffectTerm::Fact(self.fact(fact)?, true),
            Effect::Clear(fact) => EffectTerm::Fact(self.fact(fact)?, false),
        })
    }
}

/// A condition of a behavior, at whichever stand, is met only while an object lies somewhere.
fn only_somewhere(behavior: &mut BehaviorSpec, object: ObjectId, condition: fn(&mut BehaviorSpec) -> &mut Condition) {
    let stands = behavior.stands.iter_mut().flat_map(|stands| Arc::make_mut(stands).iter_mut());
    stands.for_each(|one| only_somewhere(one, object, condition));
    let condition = condition(behavior);
    let own = std::mem::replace(condition, Condition::Never);
    *condition = Condition::All(vec![Condition::Somewhere(object), own]);
}

fn all(parts: Vec<Condition>) -> Condition {
    match <[Condition; 1]>::try_from(parts) {
        Ok([only]) => only,
        Err(parts) => Condition::All(parts),
    }
}
