//! Random streams of work for a robot that works, under random orders of messages: tasks that come, are held back, edited
//! and canceled while behaviors end.

use std::collections::BTreeSet;
use std::sync::Arc;
use std::time::Duration;

use ambidex::model::{
    Branch, Change, Command, End, Granting, Location, MissionEnd, MissionSpec, NodeId, ObjectId, Obstacle, Origin,
    Outcome, PlaceId, Record, Submission, Told, Work, Worked,
};
use ambidex::record::audit::Audit;
use ambidex::tree::{Input, Settings};

use crate::driver::{Driver, Lockstep, Outside, Rng};
use crate::fixtures::{file, load};
use crate::home::Home;
use crate::lines::bench;
use crate::tasks::{branch, follows, follows_as_read, fragment, standing, told};

const ROOT: NodeId = NodeId(0);
/// So many things happen in a stream.
const EVENTS: usize = 80;
/// More follow when nothing more comes than what can go on and be woken: what never rests fails.
const REST: usize = 3000;

/// Tasks of the bench, by their texts.
const TASKS: [&str; 12] = [
    "short: a",
    "long: {n: b, of: tool}",
    "then: [{short: a}, {pair: b}, {three: c}]",
    "and: [{short: {n: a, of: tool}}, {long: b}]",
    "or: [{never: a}, {short: b}]",
    "never: a",
    "pair: a",
    "then: [{short: {n: a, of: tool}}, {never: b}], cleanup: {short: wipe}",
    "and: [{long: a}, {pair: b}], cleanup: {short: {n: wipe, of: tool}}",
    "short: a, repeat: 3, every: 4 s",
    "then: [{short: a}, {or: [{pair: b}, {long: c}]}], priority: 2",
    "firm: {n: a, of: tool}",
];

/// Tasks of a room whose table can be reached over from two sides.
const ERRANDS: [&str; 8] = [
    "then: [{move: table}, {pick: cup}, {move: shelf}, {place: cup}]",
    "then: [{move: table}, {pick: pot}, {move: shelf}, {place: pot}]",
    "then: [{move: table}, {pick: pan}, {move: shelf}, {place: pan}, {move: table}]",
    "then: [{move: table}, {or: [{pick: jug}, {pick: pan}]}]",
    "then: [{move: table}, {and: [{pick: cup}, {pick: jug}]}]",
    "then: [{move: table}, {move: shelf}, {pick: pot}, {move: table, name: back}, {place: pot}]",
    "then: [{move: table}, {pick: cup}, {place: cup}], retries: 2",
    "or: [{then: [{move: table}, {pick: jug}]}, {move: shelf}]",
];

const ROOM: &str = "world:
  robot: {at: [0, 0]}
  places:
    table: {table: {at: [3, 0], size: [0.9, 1.6, 0.75], stands: {near: {side: front}, far: {side: back}}}}
    shelf: {table: {at: [0, 3], heading: 90 deg, size: [0.35, 0.5, 0.75]}}
  objects:
    cup: {at: table, offset: [0, 0.1], grasps: [front]}
    pot: {at: table, offset: [0.5, 0.1], shape: {cylinder: {radius: 0.08, height: 0.2}}}
    pan: {at: table, offset: [0.2, -0.3], heading: 90 deg, grasps: [left, above]}
    jug: {at: shelf}
";

/// Where tasks come and go, and which.
#[derive(Clone)]
struct Ground {
    mission: Arc<MissionSpec>,
    branches: Vec<Branch>,
    /// Whether things come and go in it.
    is_room: bool,
}

impl Ground {
    fn bench() -> Self {
        let branches = TASKS.iter().map(|task| branch(task)).collect();
        Self { mission: Arc::new(standing(bench("set: x"))), branches, is_room: false }
    }

    fn room() -> Self {
        let branches = ERRANDS.iter().map(|task| told(task, fragment(&in_room(task)))).collect();
        Self { mission: Arc::new(standing(in_room("move: table"))), branches, is_room: true }
    }
}

fn in_room(task: &str) -> MissionSpec {
    let home = Home::new();
    let robot = file("config/robots/pr2.yaml");
    let text = format!("mission: room\nrobot: {}\n{ROOM}task: {{{task}}}\n", robot.display());
    MissionSpec::clone(&load(&home.write("room.yaml", &text)))
}

/// A stream on its way.
struct Stream {
    mission: Arc<MissionSpec>,
    ground: Ground,
    rng: Rng,
    driver: Driver,
    stopping: BTreeSet<NodeId>,
    /// Whether messages may be under way when something happens.
    is_at_once: bool,
}

impl Stream {
    fn new(seed: u64, interleaving: u64, is_at_once: bool) -> Self {
        Self::on(Ground::bench(), seed, interleaving, is_at_once)
    }

    fn on(ground: Ground, seed: u64, interleaving: u64, is_at_once: bool) -> Self {
        let mission = Arc::clone(&ground.mission);
        let settings = Settings::default();
        let driver = Driver::new(&mission, &settings, Rng::of(&[seed, interleaving]));
        let mut driver = driver.in_lockstep(Lockstep::new(&mission, &settings));
        driver.give(ROOT, Told::Begin { changes: Vec::new() }.into());
        driver.rest();
        Self { mission, ground, rng: Rng::of(&[seed, 1]), driver, stopping: BTreeSet::new(), is_at_once }
    }

    fn work(&mut self) -> Work {
        let rng = &mut self.rng;
        let next = self.driver.root().state().topology().next().0;
        let node = NodeId(rng.below(next as usize + 2) as u32);
        let tasks: Vec<NodeId> = self.driver.root().state().tasks().keys().copied().collect();
        let task = if tasks.is_empty() || rng.is(10) { node } else { rng.one(&tasks) };
        let branch = rng.one(&self.ground.branches);
        match rng.below(12) {
            0..=4 => {
                let granting = if rng.is(15) { Granting::Paused } else { Granting::Freely };
                let priority = rng.is(20).then_some(1);
                Work::Submit(Box::new(Submission { name: format!("task {next}"), priority, granting, branch }))
            }
            5 => Work::Cancel { task },
            6 => {
                let task = (!rng.is(20)).then_some(task);
                Work::Grant { task, granting: rng.one(&[Granting::Paused, Granting::Step]) }
            }
            7 | 8 => Work::Grant { task: (!rng.is(60)).then_some(task), granting: Granting::Freely },
            9 => Work::Add { under: node, behind: rng.is(50).then(|| rng.below(3) as u32), branch },
            10 => Work::Remove { node },
            _ => Work::Replace { node, branch },
        }
    }

    /// Something is different in the room.
    fn change(&mut self) {
        let rng = &mut self.rng;
        let mut number = |from: f64, to: f64| from + (to - from) * rng.below(100) as f64 / 100.0;
        let (x, y, size, turn) = (number(-1.0, 5.0), number(-2.0, 3.0), number(0.1, 0.8), number(0.0, 3.0));
        let came = self.driver.root().state().world().obstacles.clone();
        let object = ObjectId(rng.below(4) as u32);
        let change = match rng.below(8) {
            0 | 1 => Change::Blocked(Obstacle::on_floor([x, y].into(), [size, 0.2, 1.0].into(), turn)),
            2 | 3 if !came.is_empty() => Change::Cleared(rng.one(&came).pose()),
            4 => Change::Object(object, Location::Unknown),
            _ => Change::Object(object, Location::At(PlaceId(rng.below(2) as u32))),
        };
        self.driver.give(ROOT, Told::World { change, origin: Origin::Operator }.into());
    }

    fn tell(&mut self, work: Work) {
        self.driver.give(ROOT, Told::Work { work }.into());
    }

    /// A behavior that runs ends, else a moment comes that root waits for; false if there is neither.
    fn go_on(&mut self) -> bool {
        for told in std::mem::take(&mut self.driver.outside) {
            if let Outside::Stop(leaf) = told {
                self.stopping.insert(leaf);
            }
        }
        let running: Vec<NodeId> = self.driver.goals.keys().copied().collect();
        let due = self.driver.root().deadline();
        let is_time = running.is_empty() || (due.is_some() && self.rng.is(30));
        if !is_time {
            let leaf = self.rng.one(&running);
            let end = if self.stopping.remove(&leaf) { End::Canceled } else { End::Succeeded };
            self.driver.now = self.driver.now + Duration::from_secs(1);
            let parts = &self.driver.goals[&leaf].parts;
            let driven = parts.iter().filter(|_| end == End::Succeeded).filter_map(|part| match &part.command {
                Command::Drive { path, .. } => path.last().copied().map(Change::Base),
                _ => None,
            });
            let outcome = Outcome { end, changes: driven.collect() };
            self.driver.give(leaf, Input::Ended(Box::new(outcome)));
            return true;
        }
        let Some(due) = due else { return false };
        self.driver.now = self.driver.now.max(due);
        self.driver.give(ROOT, Told::Woke.into());
        true
    }

    /// What is under way arrives: all of it, or some.
    fn settle(&mut self) {
        if !self.is_at_once || self.rng.is(30) {
            self.driver.rest();
            return;
        }
        for _ in 0..self.rng.below(30) {
            if !self.driver.step() && self.driver.root().wants_turn() {
                self.driver.turn();
            }
        }
    }

    fn run(self) -> Self {
        self.events(EVENTS).rest()
    }

    fn events(mut self, count: usize) -> Self {
        for _ in 0..count {
            if self.ground.is_room && self.rng.is(25) {
                self.change();
            } else if self.rng.is(35) || !self.go_on() {
                let work = self.work();
                self.tell(work);
            }
            self.settle();
        }
        self
    }

    fn rest(mut self) -> Self {
        self.driver.rest();
        self.tell(Work::Grant { task: None, granting: Granting::Freely });
        let tasks: Vec<NodeId> = self.driver.root().state().tasks().keys().copied().collect();
        tasks.into_iter().for_each(|task| self.tell(Work::Grant { task: Some(task), granting: Granting::Freely }));
        self.driver.rest();
        for _ in 0..REST {
            if !self.go_on() {
                break;
            }
            self.driver.rest();
        }
        self
    }

    /// All that is left of it is over or stalls, and the log says what follows.
    fn check(self) -> Vec<Record> {
        assert_eq!(self.driver.difference(), None);
        let state = self.driver.root().state();
        assert!(state.running().is_empty(), "still runs: {:?}", state.running());
        for (task, known) in state.tasks() {
            assert!(known.is_stalled, "{task:?} neither ended nor stalls: {known:?}");
        }
        self.end()
    }

    /// The run is canceled, whatever goes on.
    fn end(mut self) -> Vec<Record> {
        self.driver.give(ROOT, Told::End { end: MissionEnd::Canceled }.into());
        self.driver.rest();
        while self.driver.finished.is_none() && self.go_on() {
            self.driver.rest();
        }
        assert_eq!(self.driver.finished, Some(MissionEnd::Canceled));
        let header = Settings::default().header(&self.mission);
        let mut records = vec![Record::Header(Box::new(header.clone()))];
        records.extend(
            std::mem::take(&mut self.driver.records).into_iter().filter(|record| !matches!(record, Record::Header(_))),
        );
        match self.ground.is_room {
            true => follows_as_read(&self.mission, &Settings::default(), &records, |task| fragment(&in_room(task))),
            false => follows(&self.mission, &Settings::default(), &records),
        }
        let mut audit = Audit::new(&header, Some(Arc::clone(&self.mission)));
        records.iter().for_each(|record| audit.take(record));
        let findings = audit.finish(None, true).findings;
        assert!(findings.is_empty(), "{findings:#?}");
        records
    }
}

/// How many streams: `AMBIDEX_STREAMS`, else a few.
fn seeds(usual: u64) -> std::ops::Range<u64> {
    let count = std::env::var("AMBIDEX_STREAMS").ok().and_then(|count| count.parse().ok());
    0..count.unwrap_or(usual)
}

fn each(check: impl Fn(u64) + std::panic::RefUnwindSafe) {
    each_of(20, check);
}

fn each_of(usual: u64, check: impl Fn(u64) + std::panic::RefUnwindSafe) {
    for seed in seeds(usual) {
        if let Err(panic) = std::panic::catch_unwind(|| check(seed)) {
            eprintln!("stream {seed} failed");
            std::panic::resume_unwind(panic);
        }
    }
}

#[test]
fn whatever_is_asked_whenever_every_task_ends_or_stalls() {
    each(|seed| drop(Stream::new(seed, 2, true).run().check()));
}

#[test]
fn a_run_can_be_ended_at_any_moment() {
    each(|seed| {
        for events in [3, 10, 25, 60] {
            Stream::new(seed, 5, true).events(events).end();
        }
    });
}

#[test]
fn decisions_do_not_depend_on_the_order_of_messages() {
    each(|seed| {
        let first = Stream::new(seed, 3, false).run().check();
        for interleaving in 4..6 {
            assert!(Stream::new(seed, interleaving, false).run().check() == first, "interleaving {interleaving}");
        }
    });
}

/// The same where things come and go, are moved, and stand in the way.
#[test]
fn in_a_room_that_changes_every_task_ends_or_stalls_too() {
    let ground = Ground::room();
    let room = std::panic::AssertUnwindSafe(&ground);
    each_of(6, move |seed| {
        let run = |interleaving| Stream::on(room.clone(), seed, interleaving, interleaving == 2).run().check();
        run(2);
        assert!(run(3) == run(4), "the order of messages");
    });
}

/// Whatever comes after it, a task waits for no more than a bounded number of grants to others.
#[test]
fn nobody_waits_for_ever_however_much_is_submitted() {
    let mut stream = Stream::new(1, 7, false);
    let submit = |name: String, text: &str| {
        let (priority, granting) = (None, Granting::Freely);
        Work::Submit(Box::new(Submission { name, priority, granting, branch: branch(text) }))
    };
    // Both tools are in use, and there is always somebody who wants the one that comes free.
    for tool in 0..3 {
        stream.tell(submit(format!("early {tool}"), "long: {n: b, of: tool}"));
    }
    stream.driver.rest();
    stream.tell(submit("both".into(), "pair: a"));
    stream.driver.rest();
    let both = stream.driver.worked.iter().filter_map(|(_, worked): &(_, Worked)| worked.ok().flatten()).next_back();
    let both = both.expect("it was taken");
    for turn in 0..200 {
        if stream.driver.root().state().running().contains_key(&both)
            || !stream.driver.root().state().tasks().contains_key(&both)
        {
            assert!(turn > 2, "nobody was before it");
            return;
        }
        stream.tell(submit(format!("late {turn}"), "long: {n: b, of: tool}"));
        stream.driver.rest();
        stream.go_on();
        stream.driver.rest();
        let granted = |record: &&Record| matches!(record, Record::Decided { granted, .. } if !granted.is_empty());
        assert!(stream.driver.records.iter().filter(granted).count() < 40, "it is passed over without end");
    }
    panic!("it never runs");
}
