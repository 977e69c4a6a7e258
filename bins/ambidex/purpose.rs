//! What goes wrong on purpose: the file of it, what is told of it, and in a run the doing.

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::path::Path;

use ambidex::files::{self, Disk};
use ambidex::model::{
    Change, ControllerId, Disk as LogDisk, Failures, Flaw, FlawKind, Location, Mishap, MissionSpec, Names, NodeId,
    Record, Time,
};
use ambidex::runtime::{Clock, Control};
use miette::{Result, miette};
use tokio::sync::{mpsc, watch};
use tokio::time::sleep_until;

use crate::diagnostics::report_all;
use crate::keeping::Keeper;
use crate::terminal::Terminal;

/// What is told of failures as the records of a run come by.
#[derive(Debug, Default)]
pub struct Purpose {
    /// Mishaps that nobody else tells, by their moment since the beginning.
    mishaps: VecDeque<(Time, String)>,
    /// What the disk of the log does when.
    disks: VecDeque<(Time, LogDisk)>,
    flaws: Vec<Flaw>,
    attempts: BTreeMap<NodeId, u32>,
    begun: Option<Time>,
}

/// Mishaps to be done in a run with processes.
pub struct Doing {
    pub failures: Failures,
    pub names: Names,
    pub clock: Clock,
    /// Tells when the mission has begun, which is when their time begins.
    pub begun: watch::Receiver<Option<Time>>,
    /// To the run.
    pub run: mpsc::UnboundedSender<Control>,
    pub terminal: Terminal,
    /// With the children, where controllers are children.
    pub keeper: Option<Keeper>,
    pub is_quiet: bool,
}

/// What is done to a controller's process, to the world, or to the run.
enum Deed {
    ToController(ControllerId, Act),
    Change(Change),
    Disk(LogDisk),
    Cancel,
}

/// What is done to a controller's process.
#[derive(Clone, Copy)]
enum Act {
    Kill,
    Hold,
    PressStop,
    ReleaseStop,
    Restart,
    Release,
}

/// Loads what goes wrong on purpose in a mission; nothing without a file.
pub fn load(file: Option<&Path>, mission: &MissionSpec) -> Result<Failures> {
    let loaded = file.map(|file| files::load_failures(&Disk, file, mission));
    loaded.transpose().map(Option::unwrap_or_default).map_err(|error| report_all(&error))
}

/// The same for a daemon, which has no controllers of its own that could be killed.
pub fn load_for_daemon(file: Option<&Path>, mission: &MissionSpec) -> Result<Failures> {
    let failures = load(file, mission)?;
    let of_controller = deeds(&failures).find_map(|(at, deed)| match deed {
        Deed::ToController(id, _) => Some((at, id)),
        Deed::Change(_) | Deed::Disk(_) | Deed::Cancel => None,
    });
    let Some((at, id)) = of_controller else { return Ok(failures) };
    Err(miette!(
        help = "kill or stop its process instead, or let `ambidex run` start the controllers",
        "what happens to {} at {} s is not the daemon's to do: others start its controllers",
        mission.names.controller(id),
        at.seconds()
    ))
}

impl Purpose {
    /// In a run with processes whoever does a mishap tells of it.
    pub fn of_run(failures: &Failures) -> Self {
        let disks = failures.mishaps.iter().filter_map(|(at, mishap)| match mishap {
            Mishap::Disk(disk) => Some((*at, *disk)),
            Mishap::Lose(_) | Mishap::Hang(_) | Mishap::Inhibit(_) | Mishap::Return(_) => None,
            Mishap::World(_) | Mishap::Cancel => None,
        });
        Self { flaws: failures.flaws.clone(), disks: disks.collect(), ..Self::default() }
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

    /// What the disk of the log does from a record on, if it is different.
    pub fn disk(&mut self, record: &Record) -> Option<LogDisk> {
        let now = self.moment(record);
        let mut last = None;
        while let Some((_, disk)) = self.disks.pop_front_if(|(at, _)| Some(*at) <= now) {
            last = Some(disk);
        }
        last
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
    pub async fn done(mut self) {
        let begun = self.begun.wait_for(Option::is_some).await.ok().and_then(|begun| *begun);
        let Some(begun) = begun else { return };
        for (at, deed) in deeds(&self.failures) {
            sleep_until(self.clock.instant(begun + at.since(Time::ZERO))).await;
            if !self.is_quiet {
                self.terminal.say(&line(at, &deed.words(&self.names)));
            }
            match deed {
                Deed::ToController(id, act) => {
                    if let Some(keeper) = &self.keeper {
                        act.done(id, keeper, &self.names);
                    }
                }
                Deed::Cancel => drop(self.run.send(Control::Cancel)),
                Deed::Change(change) => drop(self.run.send(Control::World(change))),
                // Whoever writes the log does that.
                Deed::Disk(_) => {}
            }
        }
    }
}

impl Act {
    fn done(self, id: ControllerId, keeper: &Keeper, names: &Names) {
        let mut children = keeper.children();
        match self {
            Self::Kill => children.kill(id.index()),
            Self::Hold => children.hold(id.index()),
            Self::PressStop => children.press_stop(id.index()),
            Self::ReleaseStop => children.release_stop(id.index()),
            Self::Release => children.release(id.index()),
            Self::Restart => match children.restart(id.index()) {
                Ok(pid) => keeper.keep(id.index(), pid),
                Err(error) => keeper.terminal.say(&format!("error: {} is not started: {error}", names.controller(id))),
            },
        }
    }

    fn words(self, name: &str) -> String {
        match self {
            Self::Kill => format!("{name} is killed"),
            Self::Hold => format!("{name} is stopped"),
            Self::PressStop => format!("the emergency stop of {name} is pressed"),
            Self::ReleaseStop => format!("the emergency stop of {name} is released"),
            Self::Restart => format!("{name} is started again"),
            Self::Release => format!("{name} goes on"),
        }
    }
}

impl Deed {
    fn words(&self, names: &Names) -> String {
        match *self {
            Self::ToController(id, act) => act.words(names.controller(id)),
            Self::Change(change) => changed(change, names),
            Self::Disk(LogDisk::Full) => "the disk of the log is full".to_owned(),
            Self::Disk(LogDisk::Slow) => "the disk of the log is slow".to_owned(),
            Self::Disk(LogDisk::Well) => "the disk of the log is well again".to_owned(),
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
                Deed::ToController(id, Act::Kill)
            }
            Mishap::Inhibit(id) => {
                stopped.insert(id);
                Deed::ToController(id, Act::PressStop)
            }
            Mishap::Hang(id) => Deed::ToController(id, Act::Hold),
            Mishap::Return(id) if killed.remove(&id) => Deed::ToController(id, Act::Restart),
            Mishap::Return(id) if stopped.remove(&id) => Deed::ToController(id, Act::ReleaseStop),
            Mishap::Return(id) => Deed::ToController(id, Act::Release),
            Mishap::World(change) => Deed::Change(change),
            Mishap::Disk(disk) => Deed::Disk(disk),
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
        Change::Object(object, Location::At(place)) | Change::Laid(object, place, _) => {
            format!("somebody lays {} at {}", names.thing(object), names.place(place))
        }
        Change::Object(object, Location::In(_) | Location::Unknown) => {
            format!("somebody takes {}", names.thing(object))
        }
        Change::Taken(object, by) => {
            format!("somebody puts {} into {}", names.thing(object), names.resource(by))
        }
        Change::Blocked(obstacle) => {
            format!("something comes to stand at ({:.2}, {:.2})", obstacle.middle.x, obstacle.middle.y)
        }
        Change::Cleared(around) => format!("what stands at ({:.2}, {:.2}) is taken away", around.at.x, around.at.y),
        Change::Base(_) => "somebody moves the robot".to_owned(),
        Change::Emptied(resource) => format!("somebody empties {}", names.resource(resource)),
    }
}

fn flawed(flaw: &Flaw, attempt: u32, names: &Names) -> String {
    let name = names.node(flaw.leaf);
    let what = match flaw.kind {
        FlawKind::Fails => "gives up in the end".to_owned(),
        FlawKind::Hangs => "does not end by itself".to_owned(),
        FlawKind::Late(by) => format!("takes {:.1} s longer", by.as_secs_f64()),
        FlawKind::Drops(Some(object)) => format!("drops {}", names.thing(object)),
        FlawKind::Drops(None) => "drops all that is held".to_owned(),
    };
    format!("{name} {what}, attempt {attempt}")
}
