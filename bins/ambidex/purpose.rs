//! What goes wrong on purpose: the file of it, what is told of it, and in a run the doing.

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::path::Path;
use std::sync::PoisonError;

use ambidex::files::{self, Disk};
use ambidex::model::{
    Change, ControllerId, Failures, Flaw, FlawKind, Location, Mishap, MissionSpec, Names, NodeId, Record, Time,
};
use ambidex::runtime::{Clock, Control};
use miette::Result;
use tokio::time::sleep_until;

use crate::diagnostics::report_all;
use crate::keeping::Keeper;

/// What is told of failures as the records of a run come by.
#[derive(Debug, Default)]
pub struct Purpose {
    /// Mishaps that nobody else tells, by their moment since the beginning.
    mishaps: VecDeque<(Time, String)>,
    flaws: Vec<Flaw>,
    attempts: BTreeMap<NodeId, u32>,
    begun: Option<Time>,
}

/// Mishaps to be done to the processes of a run.
pub struct Doing {
    pub failures: Failures,
    pub names: Names,
    pub clock: Clock,
    /// With the children, and the moment at which the mission began, which is when their time begins.
    pub keeper: Keeper,
    pub is_quiet: bool,
}

/// Loads what goes wrong on purpose in a mission; nothing without a file.
pub fn load(file: Option<&Path>, mission: &MissionSpec) -> Result<Failures> {
    let loaded = file.map(|file| files::load_failures(&Disk, file, mission));
    loaded.transpose().map(Option::unwrap_or_default).map_err(|error| report_all(&error))
}

impl Purpose {
    /// In a run with processes whoever does a mishap tells of it.
    pub fn of_run(failures: &Failures) -> Self {
        Self { flaws: failures.flaws.clone(), ..Self::default() }
    }

    /// In a simulation nobody else does.
    pub fn of_simulation(failures: &Failures, names: &Names) -> Self {
        let moments = failures.mishaps.iter().map(|(at, _)| *at);
        Self { mishaps: moments.zip(said(failures, names)).collect(), ..Self::of_run(failures) }
    }

    /// What is to be told before a record: what happened until then.
    pub fn before(&mut self, record: &Record) -> Vec<String> {
        if let Record::Began { at, .. } = record {
            self.begun.get_or_insert(*at);
        }
        let now = self.moment(record);
        let mut lines = Vec::new();
        while let Some((at, text)) = self.mishaps.pop_front_if(|(at, _)| Some(*at) <= now) {
            lines.push(line(at, &text));
        }
        lines
    }

    /// What is to be told after a record: what is going to come of what it grants.
    pub fn after(&mut self, record: &Record, names: &Names) -> Vec<String> {
        let (Record::Decided { granted, .. }, Some(now)) = (record, self.moment(record)) else { return Vec::new() };
        let mut lines = Vec::new();
        for leaf in granted.iter().map(|grant| grant.leaf()) {
            let attempt = self.attempts.entry(leaf).or_default();
            *attempt += 1;
            let attempt = *attempt;
            let meant = self.flaws.iter().filter(|flaw| flaw.is_of(leaf, attempt));
            lines.extend(meant.map(|flaw| line(now, &flawed(flaw, attempt, names))));
        }
        lines
    }

    /// The moment of a record since the beginning; none before that.
    fn moment(&self, record: &Record) -> Option<Time> {
        self.begun.map(|begun| Time::ZERO + (record.at() - begun))
    }
}

impl Doing {
    /// Does every mishap at its moment.
    pub async fn done(self) {
        let (names, terminal) = (&self.names, &self.keeper.terminal);
        let mut begun = self.keeper.begun.clone();
        let Some(begun) = begun.wait_for(Option::is_some).await.ok().and_then(|begun| *begun) else { return };
        let mut lost = BTreeSet::new();
        for ((at, mishap), text) in self.failures.mishaps.iter().zip(said(&self.failures, names)) {
            sleep_until(self.clock.instant(begun + at.since(Time::ZERO))).await;
            if !self.is_quiet {
                terminal.say(&line(*at, &text));
            }
            let mut children = self.keeper.children.lock().unwrap_or_else(PoisonError::into_inner);
            match *mishap {
                Mishap::Lose(id) => {
                    lost.insert(id);
                    children.kill(id.index());
                }
                Mishap::Hang(id) => children.hold(id.index()),
                Mishap::Return(id) if !lost.remove(&id) => children.release(id.index()),
                Mishap::Return(id) => match children.restart(id.index()) {
                    Ok(()) => self.keeper.keep(id.index(), children.pids()[id.index()]),
                    Err(error) => terminal.say(&format!("error: {} is not started: {error}", names.controller(id))),
                },
                Mishap::World(change) => drop(self.keeper.run.send(Control::World(change))),
            }
        }
    }
}

fn line(at: Time, text: &str) -> String {
    format!("{:>7.2} s  on purpose: {text}", at.seconds())
}

/// Every mishap in words.
fn said(failures: &Failures, names: &Names) -> Vec<String> {
    let mut lost: BTreeSet<ControllerId> = BTreeSet::new();
    let mut said = |mishap: &Mishap| match *mishap {
        Mishap::Lose(id) => {
            lost.insert(id);
            format!("{} is killed", names.controller(id))
        }
        Mishap::Hang(id) => format!("{} is stopped", names.controller(id)),
        Mishap::Return(id) if lost.remove(&id) => format!("{} is started again", names.controller(id)),
        Mishap::Return(id) => format!("{} goes on", names.controller(id)),
        Mishap::World(change) => changed(change, names),
    };
    failures.mishaps.iter().map(|(_, mishap)| said(mishap)).collect()
}

fn changed(change: Change, names: &Names) -> String {
    match change {
        Change::Fact(fact, true) => format!("somebody sets {}", names.fact(fact)),
        Change::Fact(fact, false) => format!("somebody clears {}", names.fact(fact)),
        Change::Object(object, Location::At(place)) => {
            format!("somebody lays {} at {}", names.thing(object), names.place(place))
        }
        Change::Object(object, Location::In(_) | Location::Unknown) => {
            format!("somebody takes {}", names.thing(object))
        }
        Change::Base(_) => "somebody moves the robot".to_owned(),
        Change::Emptied(resource) => format!("somebody empties {}", names.resource(resource)),
    }
}

fn flawed(flaw: &Flaw, attempt: u32, names: &Names) -> String {
    let name = names.node(flaw.leaf);
    let what = match flaw.kind {
        FlawKind::Fails => "gives up in the end".to_owned(),
        FlawKind::Hangs => "does not end by itself".to_owned(),
        FlawKind::Drops(Some(object)) => format!("drops {}", names.thing(object)),
        FlawKind::Drops(None) => "drops all that is held".to_owned(),
    };
    format!("{name} {what}, attempt {attempt}")
}
