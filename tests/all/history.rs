//! The history of a run against the state of root, of which the records tell.

use std::sync::Arc;

use ambidex::model::{Header, MissionEnd, MissionSpec, NodeId, Outcome, Record, Told};
use ambidex::record::{History, LeafState};
use ambidex::tree::{Input, Settings};

use crate::driver::{Driver, Rng};
use crate::fixtures::{file, history, load, simulate};
use crate::property;

/// How many generated trees are looked at, each with and without a cancel.
const TREES: u64 = 400;

/// A history that hears every record which a driver makes.
struct Heard {
    history: History,
    seen: usize,
    compared: usize,
}

impl Heard {
    fn new(mission: &MissionSpec) -> Self {
        Self { history: History::with_past(&Header::new(mission, "greedy", false)), seen: 0, compared: 0 }
    }

    /// What is granted was waiting for it: what is done once more was reopened before, what failed for good or is not
    /// asked any more never comes again.
    fn hear(&mut self, record: &Record) {
        if let Record::Decided { granted, .. } = record {
            for leaf in granted.iter().map(|grant| grant.leaf()) {
                assert_eq!(self.history.state(leaf), LeafState::Waiting, "{leaf:?} {record:?}");
            }
        }
        self.history.apply(record);
    }

    /// Takes what one input to a node made, and compares. Root makes several records of one input, and its state is
    /// ahead of all but the last of them.
    fn compare(&mut self, driver: &Driver) {
        let new = &driver.records[self.seen..];
        new.iter().for_each(|record| self.hear(record));
        self.seen = driver.records.len();
        self.compared += usize::from(!new.is_empty());
        let (root, history) = (driver.root(), &self.history);
        let last = || format!("after {:?}", driver.records.last());
        assert!(*root.state() == *history.state_of_run(), "{}", last());
        let table = root.state().table();
        assert!(table.iter().map(|(_, resource)| resource).eq(history.resources()), "{}", last());
        let active = history.leaves().filter(|leaf| history.state(*leaf) == LeafState::Active);
        assert!(root.state().running().keys().copied().eq(active), "{}", last());
        assert_eq!(driver.finished, history.end(), "{}", last());
        let task = history.state(NodeId(1));
        match history.end() {
            Some(MissionEnd::Done) => assert!(task.is_done(), "{task:?} {}", last()),
            Some(MissionEnd::Failed(_)) => assert_eq!(task, LeafState::Failed, "{}", last()),
            Some(MissionEnd::Stalled | MissionEnd::Canceled | MissionEnd::ControllerLost(_)) => {
                assert!(!task.is_done(), "{task:?} {}", last())
            }
            // One that was told to end and succeeded all the same may leave nothing to be done in a further attempt.
            None => {}
            other => panic!("no mission of this test ends so: {other:?}"),
        }
    }
}

#[test]
fn it_is_at_every_moment_what_root_is_of_generated_trees() {
    let mut compared = 0;
    for seed in 0..TREES {
        for is_canceled in [false, true] {
            let mut heard = None;
            property::watched(seed, is_canceled, |mission, driver| {
                heard.get_or_insert_with(|| Heard::new(mission)).compare(driver);
            });
            compared += heard.expect("something happened").compared;
        }
    }
    assert!(compared > 10_000, "{compared}");
}

/// Every behavior ends as it did in a simulation, one after the other.
fn driven(mission: &Arc<MissionSpec>, simulated: &[Record]) -> Heard {
    let ends = simulated.iter().filter_map(|record| match record {
        Record::Released { leaf, end, changes, .. } => Some((*leaf, Outcome { end: *end, changes: changes.clone() })),
        Record::Added { .. } | Record::Removed { .. } | Record::Granting { .. } => None,
        Record::Canceled { .. } | Record::TaskEnded { .. } | Record::Stalled { .. } => None,
        Record::ObjectAdded { .. }
        | Record::ObjectRemoved { .. }
        | Record::Declined { .. }
        | Record::Checkpoint { .. } => None,
        Record::Told { .. } | Record::Observed { .. } | Record::Turn { .. } | Record::Began { .. } => None,
        Record::Header(_) | Record::Stopped { .. } | Record::Sent { .. } => None,
        Record::Decided { .. } | Record::World { .. } | Record::Denied { .. } => None,
        Record::Infeasible { .. } | Record::TimedOut { .. } => None,
        Record::Reopened { .. } | Record::Overtaken { .. } => None,
        Record::Ending { .. } | Record::Leaving { .. } | Record::Cleaning { .. } | Record::Cleaned { .. } => None,
        Record::Resource { .. }
        | Record::Woke { .. }
        | Record::Served { .. }
        | Record::Awaited { .. }
        | Record::Controller { .. }
        | Record::Ended { .. } => None,
    });
    let mut ends: Vec<(NodeId, Outcome)> = ends.collect();
    let mut heard = Heard::new(mission);
    let mut driver = Driver::new(mission, &Settings::default(), Rng::of(&[1]));
    driver.give(NodeId(0), Told::Begin { changes: Vec::new() }.into());
    loop {
        heard.compare(&driver);
        if driver.step() {
            continue;
        }
        if driver.is_turn_due() {
            driver.turn();
            continue;
        }
        let Some(next) = ends.iter().position(|(leaf, _)| driver.goals.contains_key(leaf)) else { break };
        let (leaf, outcome) = ends.remove(next);
        driver.now = driver.now + std::time::Duration::from_secs(1);
        driver.give(leaf, Input::Ended(Box::new(outcome)));
    }
    heard
}

#[test]
fn it_is_at_every_moment_what_root_is_of_the_shipped_missions() {
    let folder = std::fs::read_dir(file("config/missions")).expect("the shipped missions");
    let paths = folder.map(|entry| entry.expect("an entry").path());
    // Somebody else opens the door.
    for path in paths.filter(|path| !path.ends_with("door.yaml")) {
        let mission = load(&path);
        let (records, _) = simulate(&mission, &Settings::default(), Vec::new());
        let driven = driven(&mission, &records);
        assert!(driven.compared > 10, "{path:?}: {}", driven.compared);
        let simulated = history(&records);
        assert_eq!(simulated.end(), Some(MissionEnd::Done), "{path:?}");
        assert!(simulated.running().is_empty() && simulated.resources().iter().all(|resource| !resource.is_locked()));
        assert_eq!(simulated.state(NodeId(0)), LeafState::Done, "{path:?}");
        whole(&records, &simulated);
    }
}

/// What is kept over time tells the same as what is kept of the moment.
fn whole(records: &[Record], history: &History) {
    let mut now = History::new(history.header());
    records.iter().for_each(|record| now.apply(record));
    assert_eq!(now.skipped(), history.skipped());
    assert_eq!((now.step_count(), now.last_moment()), (history.steps().len(), history.last_moment()));
    for leaf in now.leaves() {
        let (short, long) = (now.leaf(leaf).expect("a leaf"), history.leaf(leaf).expect("a leaf"));
        assert!(short.phases().is_empty() && short.state() == long.state());
        assert_eq!(long.phases().last().map(|(at, phase)| (*at, phase.state())), Some((long.since(), long.state())));
    }
}
