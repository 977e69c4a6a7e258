//! What goes wrong on purpose: the file of it, what is told of it, and in a run the doing.

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::path::Path;

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

/// What is done to a controller's process, or to the world.
enum Deed {
    Kill(ControllerId),
    Hold(ControllerId),
    PressStop(ControllerId),
    ReleaseStop(ControllerId),
    Restart(ControllerId),
    Release(ControllerId),
    Change(Change),
    Cancel,
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
        let mishaps = deeds(failures).map(|(at, deed)| (at, deed.words(names))).collect();
        Self { mishaps, ..Self::of_run(failures) }
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
        for (at, deed) in deeds(&self.failures) {
            sleep_until(self.clock.instant(begun + at.since(Time::ZERO))).await;
            if !self.is_quiet {
                terminal.say(&line(at, &deed.words(names)));
            }
            let mut children = self.keeper.children();
            match deed {
                Deed::Kill(id) => children.kill(id.index()),
                Deed::Hold(id) => children.hold(id.index()),
                Deed::PressStop(id) => children.press_stop(id.index()),
                Deed::ReleaseStop(id) => children.release_stop(id.index()),
                Deed::Release(id) => children.release(id.index()),
                Deed::Restart(id) => match children.restart(id.index()) {
                    Ok(pid) => self.keeper.keep(id.index(), pid),
                    Err(error) => terminal.say(&format!("error: {} is not started: {error}", names.controller(id))),
                },
                Deed::Cancel => drop(self.keeper.run.send(Control::Cancel)),
                Deed::Change(change) => drop(self.keeper.run.send(Control::World(change))),
            }
        }
    }
}

impl Deed {
    fn words(&self, names: &Names) -> String {
        match *self {
            Self::Kill(id) => format!("{} is killed", names.controller(id)),
            Self::Hold(id) => format!("{} is stopped", names.controller(id)),
            Self::PressStop(id) => format!("the emergency stop of {} is pressed", names.controller(id)),
            Self::ReleaseStop(id) => format!("the emergency stop of {} is released", names.controller(id)),
            Self::Restart(id) => format!("{} is started again", names.controller(id)),
            Self::Release(id) => format!("{} goes on", names.controller(id)),
            Self::Change(change) => changed(change, names),
            Self::Cancel => "the mission is told to end".to_owned(),
        }
    }
}

/// What every mishap takes: who was killed returns by a restart, who was inhibited or only held goes on.
fn deeds(failures: &Failures) -> impl Iterator<Item = (Time, Deed)> {
    let (mut killed, mut stopped) = (BTreeSet::new(), BTreeSet::new());
    failures.mishaps.iter().map(move |&(at, mishap)| {
        let deed = match mishap {
            Mishap::Lose(id) => {
                killed.insert(id);
                stopped.remove(&id);
                Deed::Kill(id)
            }
            Mishap::Inhibit(id) => {
                stopped.insert(id);
                Deed::PressStop(id)
            }
            Mishap::Hang(id) => Deed::Hold(id),
            Mishap::Return(id) if killed.remove(&id) => Deed::Restart(id),
            Mishap::Return(id) if stopped.remove(&id) => Deed::ReleaseStop(id),
            Mishap::Return(id) => Deed::Release(id),
            Mishap::World(change) => Deed::Change(change),
            Mishap::Cancel => Deed::Cancel,
        };
        (at, deed)
    })
}

fn line(at: Time, text: &str) -> String {
    format!("{:>7.2} s  on purpose: {text}", at.seconds())
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
        Change::Taken(object, by) => {
            format!("somebody puts {} into {}", names.thing(object), names.resource(by))
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
