//! What controllers wrote down themselves: what they were told, what they did, and what they held when.

use std::collections::{BTreeMap, BTreeSet};
use std::io::{self, BufRead};

use ambidex_model::motion::{FromController, ToController};
use ambidex_model::{CommandId, ControllerId, Name, PartEnd};
use serde::{Deserialize, Serialize};

use super::commands::{Commands, shown};
use super::run::Run;
use super::{Finding, Rule};

/// A line of a controller's own record.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct OwnLine {
    /// Nanoseconds of the monotonic clock, which all processes of a machine share.
    pub at_ns: u64,
    /// The process.
    pub pid: u32,
    /// What happened.
    pub event: OwnEvent,
}

/// What happens to a controller.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum OwnEvent {
    /// It has its place.
    Ready,
    /// A daemon has configured it.
    Attached,
    /// Its daemon is gone.
    Left,
    /// A daemon told it something.
    Told(ToController),
    /// It answered.
    Said(FromController),
    /// It ended in order: the record of this process lacks nothing.
    Ended,
}

/// The records of the controllers of a run, by the controllers' names.
#[derive(Debug, Default)]
pub struct OwnRecords {
    controllers: BTreeMap<String, Vec<OwnLine>>,
}

/// How long something was held by whom, monotonic nanoseconds.
struct Held<'a> {
    controller: &'a str,
    object: Name,
    from_ns: u64,
    until_ns: u64,
}

impl OwnRecords {
    /// Takes the record of a controller; a last line that was cut off is left out.
    ///
    /// # Errors
    /// When it cannot be read, or a line before the last is none of such a record.
    pub fn read(&mut self, controller: &str, record: impl BufRead) -> io::Result<()> {
        let mut lines = Vec::new();
        let mut broken = None;
        for (index, line) in record.lines().enumerate() {
            let line = line?;
            if let Some(error) = broken.take() {
                return Err(error);
            }
            match serde_json::from_str(&line) {
                Ok(line) => lines.push(line),
                Err(error) => broken = Some(io::Error::other(format!("line {}: {error}", index + 1))),
            }
        }
        self.controllers.entry(controller.to_owned()).or_default().extend(lines);
        Ok(())
    }

    /// How many lines there are.
    pub(super) fn lines(&self) -> u64 {
        self.controllers.values().map(|lines| lines.len() as u64).sum()
    }

    /// What does not fit to the log, or within itself. Where the log lacks its end, what it does not know proves nothing.
    pub(super) fn compare(&self, run: &Run, commands: &Commands, is_whole: bool) -> Vec<Finding> {
        let mut findings = Vec::new();
        let mut push = |said| findings.push(Finding { rule: Rule::Records, line: None, at: None, said });
        for (name, lines) in &self.controllers {
            let Some(id) = run.controller(name) else {
                push(format!("{name} has a record, and the log has no such controller"));
                continue;
            };
            alone(name, lines, &mut push);
            told_alike(name, id, lines, commands, is_whole, &mut push);
        }
        self.apart(run, commands, &mut push);
        findings
    }

    /// No object is in the hands of two controllers at once unless it is taken so.
    fn apart(&self, run: &Run, commands: &Commands, push: &mut impl FnMut(String)) {
        let held = self.controllers.iter().flat_map(|(name, lines)| {
            let id = run.controller(name);
            holdings(name, lines, move |message| match message {
                FromController::Configured { .. } => true,
                FromController::Result { id: command, .. } => {
                    id.is_some_and(|id| commands.ended.contains_key(&(id, *command)))
                }
                FromController::Accepted { .. } | FromController::Rejected { .. } => false,
                FromController::Feedback { .. } => false,
            })
        });
        let held: Vec<Held<'_>> = held.collect();
        let is_shared = |name: &Name| {
            let object = run.names.objects.iter().position(|object| object == name.as_str());
            object.is_some_and(|object| run.is_shared(object.into()))
        };
        for (index, one) in held.iter().enumerate() {
            for two in &held[index + 1..] {
                let overlaps = one.from_ns < two.until_ns && two.from_ns < one.until_ns;
                if one.object == two.object && one.controller != two.controller && overlaps && !is_shared(&one.object) {
                    push(format!(
                        "{} was in the hands of {} and {} at once",
                        one.object, one.controller, two.controller
                    ));
                }
            }
        }
    }
}

/// A controller does one thing at a time, and no command twice.
fn alone(name: &str, lines: &[OwnLine], push: &mut impl FnMut(String)) {
    let (mut told, mut open): (BTreeSet<CommandId>, Option<CommandId>) = (BTreeSet::new(), None);
    let mut last_ns = 0;
    for line in lines {
        if line.at_ns < last_ns {
            push(format!("time goes backwards in the record of {name}"));
        }
        last_ns = line.at_ns;
        match &line.event {
            // Another life of either side counts anew.
            OwnEvent::Ready | OwnEvent::Attached | OwnEvent::Left | OwnEvent::Ended => {
                (told, open) = (BTreeSet::new(), None);
            }
            OwnEvent::Said(FromController::Accepted { id, .. }) => {
                if !told.insert(*id) {
                    push(format!("{name} did command {} twice", shown(*id)));
                }
                if let Some(other) = open.replace(*id) {
                    push(format!("{name} began command {} within {}", shown(*id), shown(other)));
                }
            }
            OwnEvent::Said(FromController::Result { id, .. }) => {
                if open == Some(*id) {
                    open = None;
                }
            }
            OwnEvent::Told(_)
            | OwnEvent::Said(
                FromController::Configured { .. } | FromController::Rejected { .. } | FromController::Feedback { .. },
            ) => {}
        }
    }
}

/// What the log says that a controller said, it did say; what it did, the log told it.
fn told_alike(
    name: &str,
    id: ControllerId,
    lines: &[OwnLine],
    commands: &Commands,
    is_whole: bool,
    push: &mut impl FnMut(String),
) {
    let mut results: BTreeMap<CommandId, PartEnd> = BTreeMap::new();
    for line in lines {
        match &line.event {
            OwnEvent::Said(FromController::Result { id, end, .. }) => drop(results.insert(*id, *end)),
            OwnEvent::Said(FromController::Accepted { id: command, .. }) => {
                let is_known = commands.is_told(id, *command) || commands.is_before(id, *command);
                if is_whole && !commands.was_resumed && !is_known {
                    push(format!("{name} did command {}, which the log does not know", shown(*command)));
                }
            }
            OwnEvent::Ready | OwnEvent::Attached | OwnEvent::Left | OwnEvent::Ended => {}
            OwnEvent::Told(_) | OwnEvent::Said(_) => {}
        }
    }
    // A process that was killed may not have written down its last words.
    let of_process = lines.iter().map(|line| line.pid).collect::<BTreeSet<_>>();
    let ended = lines.iter().filter(|line| line.event == OwnEvent::Ended).map(|line| line.pid).collect();
    let is_cut = of_process != ended;
    let own = commands.ended.iter().filter(|((controller, _), _)| *controller == id);
    for ((_, command), end) in own {
        match results.get(command) {
            Some(said) if said == end => {}
            Some(said) => {
                push(format!(
                    "the log has {end:?} as the end of command {} of {name}, which said {said:?}",
                    shown(*command)
                ));
            }
            None if is_cut => {}
            None => push(format!("the log has the end of command {} of {name}, which never said it", shown(*command))),
        }
    }
}

/// When a controller held what, by its own states that the log has heard: who is lost while it takes something has it, and
/// nobody knows. A process that ends holds nothing any more.
fn holdings<'a>(name: &'a str, lines: &[OwnLine], is_heard: impl Fn(&FromController) -> bool) -> Vec<Held<'a>> {
    let mut held = Vec::new();
    let mut now: Option<(Name, u64)> = None;
    let mut close = |now: &mut Option<(Name, u64)>, until_ns: u64| {
        if let Some((object, from_ns)) = now.take() {
            held.push(Held { controller: name, object, from_ns, until_ns });
        }
    };
    let mut last_ns = 0;
    for line in lines {
        match &line.event {
            OwnEvent::Ready | OwnEvent::Ended => close(&mut now, last_ns),
            OwnEvent::Said(message) => {
                if let Some(state) = message.state() {
                    let holds = state.holds();
                    if now.map(|(object, _)| object) != holds {
                        close(&mut now, line.at_ns);
                        now = holds.filter(|_| is_heard(message)).map(|object| (object, line.at_ns));
                    }
                }
            }
            OwnEvent::Attached | OwnEvent::Left | OwnEvent::Told(_) => {}
        }
        last_ns = line.at_ns;
    }
    close(&mut now, last_ns);
    held
}
