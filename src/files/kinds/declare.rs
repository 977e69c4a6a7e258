//! An entry of `behaviors`, to a kind whose terms make sense.

use std::collections::BTreeSet;
use std::time::Duration;

use super::named::TEMPLATE;
use super::terms::{CLAIMS, Command, ConditionTerm, Effect, POTENTIAL_TERM, PotentialTerm};
use super::{Claims, Declared};
use crate::describe::{At, Count, Custom, Described, Flag, Later, List, Map, Reads, described};
use crate::fault::Faults;
use crate::parameter::{PARAMETERS, Parameter, warn_of_unused};
use crate::quantity::{BACKOFF, DURATION, TIMEOUT};
use crate::reader::{Item, Name, Written};
use crate::scope::{Reading, Scope};
use crate::shape::{Form, Shape};

/// How often a behavior may try again at most.
pub(crate) const MAX_RETRIES: u32 = 1000;

const TIMEOUT_S: f64 = 120.0;
const RETRIES: u32 = 2;
/// How long something waits before it tries again after it failed once, seconds.
pub(crate) const BACKOFF_S: f64 = 0.5;

const CONDITIONS: List<Map<ConditionTerm>> = List(MAPS, Map::new());
/// Conditions that are looked at while a behavior runs, on what others can change.
const LASTING: Custom<Vec<ConditionTerm>> = Custom(
    || CONDITIONS.form(),
    |item, reading| {
        let terms = CONDITIONS.read(item, reading)?;
        for term in &terms {
            if let ConditionTerm::At(stand) | ConditionTerm::Path(stand) = term {
                let help = "only `held`, `free`, `lies`, `fact` and `not_fact` are looked at while it runs";
                reading.faults.push_with(&stand.place.written, "where the base is cannot be wanted to last", help);
            }
        }
        Some(terms)
    },
);
const MAPS: &str = "a list of maps, each with a dash";

described! {
    /// An entry of `behaviors` as it is written.
    struct Behavior<'a>: "a behavior", "A kind of behavior. `$name` stands for an argument." {
        label: Option<Item<'a>> = maybe(
            "label",
            "What a node of it is called; without one the kind and its first argument.",
            Later(|| Form::Word)
        ),
        parameters: Vec<Parameter> = maybe_all(
            "parameters",
            "What a node tells it; the first one can be written without its name.",
            OWN_PARAMETERS
        ),
        claims: Option<Claims> = maybe_or(
            "claims",
            "The resources it needs, by names that its commands use; `all` is the whole robot.",
            CLAIMS,
            Claims::Some(Vec::new())
        ),
        potential: Option<PotentialTerm> = wanted(
            "potential",
            "How efficient it looks to run it now: a number, one that a node tells (`$name`), `high` (above all that is \
             told by nearness), or more.",
            POTENTIAL_TERM
        ),
        goal: Option<Vec<ConditionTerm>> = maybe("goal", "When it is done; without it only by running.", CONDITIONS),
        precondition: Vec<ConditionTerm> = maybe_all("precondition", "What must be so for it to run.", CONDITIONS),
        lasting: Vec<ConditionTerm> = maybe_all(
            "while",
            "What of facts and objects must be so for it to run, and stay so: else it is interrupted.",
            LASTING
        ),
        interruptible: Option<bool> = optional(
            "interruptible",
            "Whether something more urgent may interrupt it; `true` for what claims no gripper and changes no object.",
            Flag
        ),
        effects: Vec<Effect> =
            maybe_all("effects", "What is so when it succeeded.", List(MAPS, Map::<Effect>::new())),
        commands: Vec<Command> = maybe_all(
            "commands",
            "Which controllers do what while it runs.",
            List(MAPS, Map::<Command>::new())
        ),
        takes_s: Option<Written<f64>> = maybe("takes", "How long it runs at least; 0 s.", At(&DURATION)),
        timeout_s: Option<f64> = maybe_or("timeout", "How long it may run; 2 min.", &TIMEOUT, TIMEOUT_S),
        retries: Option<u32> =
            maybe_or("retries", "How often it tries again after it failed; 2.", Count(MAX_RETRIES), RETRIES),
        backoff_s: Option<f64> = maybe_or(
            "backoff",
            "How long it waits before it tries again, twice as long each further time; 0.5 s.",
            &BACKOFF,
            BACKOFF_S
        ),
    }
}

/// The description of an entry of `behaviors`.
pub(crate) fn behavior_shape() -> &'static Shape {
    Behavior::shape()
}

/// The parameters of the behavior at hand, which all terms behind them can use.
const OWN_PARAMETERS: Custom<Vec<Parameter>> = Custom(
    || PARAMETERS.form(),
    |item, reading| {
        let parameters = PARAMETERS.read(item, reading)?;
        reading.scope.parameters = parameters.iter().map(|known| (known.name.value.clone(), known.ty)).collect();
        Some(parameters)
    },
);

impl Declared {
    /// Reads an entry of `behaviors`; `None` when it has faults.
    pub(super) fn read(name: Name, item: Item<'_>, faults: &mut Faults) -> Option<Self> {
        let before = faults.errors();
        let mut reading = Reading::new(faults);
        let read = Behavior::read(item, &mut reading)?;
        let label = read.label.and_then(|item| TEMPLATE.read(item, &mut reading));
        let Scope { used, claims, .. } = reading.scope;
        refuse_second_commands(&read.commands, &claims, faults);
        let takes_s = read.takes_s.as_ref().map_or(0.0, |takes| takes.value);
        if let (Some(takes), Some(timeout_s)) =
            (&read.takes_s, read.timeout_s.filter(|timeout_s| takes_s >= *timeout_s))
        {
            let message = format!("it takes {takes_s} s, and its timeout is {timeout_s} s");
            faults.push_with(takes, message, "give it a greater `timeout`");
        }
        warn_of_unused(&read.parameters, &used, before, faults);
        let declared = Self {
            label,
            claims: read.claims?,
            potential: read.potential?,
            goal: read.goal,
            precondition: read.precondition,
            lasting: read.lasting,
            interruptible: read.interruptible,
            effects: read.effects,
            commands: read.commands,
            takes: Duration::from_secs_f64(takes_s),
            timeout: Duration::from_secs_f64(read.timeout_s?),
            retries: read.retries?,
            backoff: Duration::from_secs_f64(read.backoff_s?),
            written: item.node(),
            name,
            parameters: read.parameters,
        };
        (faults.errors() == before).then_some(declared)
    }
}

/// A controller does one thing at a time.
fn refuse_second_commands(commands: &[Command], claims: &[Name], faults: &mut Faults) {
    let mut seen = BTreeSet::new();
    for command in commands.iter().filter(|command| !seen.insert(command.claim)) {
        let task = command.order.task();
        let message = format!("`{}` has a command already", claims[command.claim].value);
        faults.push_with(task, message, "a controller does one thing at a time: one command for each claim");
    }
}
