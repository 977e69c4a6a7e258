//! The runtime over a link in memory decides as the simulation does: same missions, same controllers, whose commands
//! take a random time, are rejected and fail. Time is tokio's paused clock, so that an hour takes no time at all.
//!
//! Ends never come at the same instant here: which of two comes first is then for the runtime to say. `AMBIDEX_CASES=500`
//! sets how many missions, `AMBIDEX_SEED=17` runs one alone.

mod memory;
mod missions;
mod scripted;

use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use ambidex::dispatch::Script;
use ambidex::files::{Disk, load_mission};
use ambidex::model::{
    BehaviorSpec, Change, ControllerSpec, End, Failures, Flaw, FlawKind, Inhibition, MissionEnd, MissionSpec, Record,
    Time,
};
use ambidex::motion;
use ambidex::replay::Replay;
use ambidex::runtime::{self, Clock, Control, Ended, Options, Port};
use ambidex::sim::{self, Body, Event};
use ambidex::tree::Settings;
use tokio::sync::mpsc;

use crate::digests::decisions;
use crate::driver::Rng;
use crate::fixtures::{file, load, simulate_failures};
use memory::{Memory, Stop};
use scripted::Scripted;

const CASES: u64 = 60;

/// By controller.
type Stops = BTreeMap<usize, Vec<Stop>>;

fn seeds() -> std::ops::Range<u64> {
    let number = |name| std::env::var(name).ok()?.parse::<u64>().ok();
    match number("AMBIDEX_SEED") {
        Some(seed) => seed..seed + 1,
        None => 0..number("AMBIDEX_CASES").unwrap_or(CASES),
    }
}

#[test]
fn the_runtime_decides_as_the_simulation_does() {
    let folder = tempfile::tempdir().expect("a folder");
    let (mut compared, mut decided, mut failed, mut rejected) = (0, 0, 0, 0);
    for seed in seeds() {
        let path = folder.path().join(format!("case-{seed}.yaml"));
        std::fs::write(&path, missions::text(seed)).expect("a file");
        let mission = match load_mission(&Disk, &path, None, &[]) {
            Ok(loaded) => loaded.mission,
            Err(faults) => panic!("AMBIDEX_SEED={seed}: {faults:?}"),
        };
        let simulated = simulated(&mission, seed);
        if has_ends_at_once(&simulated) {
            continue;
        }
        let (_, live) = live(&mission, seed, Vec::new(), Script::default());
        let expected = compare(&mission, seed, &simulated, &live);
        compared += 1;
        decided += expected.lines().count();
        failed += expected.matches("Failed(Aborted").count();
        rejected += expected.matches("Failed(Rejected").count();
    }
    println!("{compared} missions, {decided} decisions, {failed} behaviors aborted, {rejected} rejected");
    assert!(seeds().count() == 1 || compared * 3 > seeds().count(), "too few missions are left to compare");
    assert!(seeds().count() == 1 || (failed > 0 && rejected > 0), "nothing fails");
}

/// Behaviors fail, hang and drop things on purpose: in both alike.
#[test]
fn what_goes_wrong_on_purpose_does_so_in_both() {
    let folder = tempfile::tempdir().expect("a folder");
    let (mut compared, mut wrong, mut dropped) = (0, 0, 0);
    for seed in seeds().filter(|seed| seed % 3 == 0) {
        let path = folder.path().join(format!("case-{seed}.yaml"));
        std::fs::write(&path, missions::text(seed)).expect("a file");
        let mission = load(&path);
        let flaws = flaws(&mission, seed);
        let failures = Failures { mishaps: Vec::new(), flaws: flaws.clone() };
        let (_, simulated) = simulate_failures(&mission, &failures);
        if has_ends_at_once(&simulated) {
            continue;
        }
        let (_, live) = live(&mission, seed, Vec::new(), Script::new(flaws));
        let expected = compare(&mission, seed, &simulated, &live);
        compared += 1;
        wrong += expected.matches("Failed(Aborted").count() + expected.matches("Failed(TimedOut").count();
        dropped += simulated.iter().filter(|record| matches!(record, Record::World { .. })).count();
    }
    println!("{compared} missions, {wrong} behaviors aborted or timed out, {dropped} objects dropped");
    assert!(seeds().count() == 1 || (compared > 5 && wrong > 5 && dropped > 2), "{compared}, {wrong}, {dropped}");
}

/// Controllers come to be inhibited and may move again: both take it alike.
#[test]
fn who_is_inhibited_is_so_in_both() {
    let folder = tempfile::tempdir().expect("a folder");
    let (mut compared, mut interrupted, mut served) = (0, 0, 0);
    for seed in seeds().filter(|seed| seed % 2 == 0) {
        let path = folder.path().join(format!("case-{seed}.yaml"));
        std::fs::write(&path, missions::text(seed)).expect("a file");
        let mission = load(&path);
        let (events, stops) = inhibitions(&mission, seed);
        let simulated = simulated_with(&mission, seed, events);
        if has_ends_at_once(&simulated) || has_interrupted_drives(&mission, &simulated) {
            continue;
        }
        let (_, live) = live_with(&mission, seed, Vec::new(), Script::default(), &stops);
        let expected = compare(&mission, seed, &simulated, &live);
        let services = |records: &[Record]| {
            let served = records.iter().filter_map(|record| match record {
                Record::Served { controller, service, .. } => Some((*controller, service.outage())),
                _ => None,
            });
            served.collect::<Vec<_>>()
        };
        assert_eq!(services(&simulated), services(&live), "AMBIDEX_SEED={seed}");
        compared += 1;
        interrupted += expected.matches("Interrupted").count();
        served += services(&simulated).len();
    }
    println!("{compared} missions, {interrupted} behaviors interrupted, {served} times away or back");
    assert!(seeds().count() == 1 || (compared > 5 && interrupted > 3), "{compared}, {interrupted}, {served}");
}

/// Where a base comes to a stand on its way depends on the very step at which it began.
fn has_interrupted_drives(mission: &MissionSpec, records: &[Record]) -> bool {
    records.iter().any(|record| {
        let Record::Released { leaf, end: End::Interrupted, .. } = record else { return false };
        mission.tree.behavior(*leaf).is_some_and(BehaviorSpec::is_drive)
    })
}

/// Every controller twice at moments on no grid, so that nothing else happens at them; for the simulation and for links.
fn inhibitions(mission: &MissionSpec, seed: u64) -> (Vec<(Time, Event)>, Stops) {
    let mut rng = Rng::of(&[seed, 23]);
    let (mut events, mut stops) = (Vec::new(), Stops::new());
    for index in 0..mission.robot.controllers.len() {
        let mut at_us = 0;
        for why in [Inhibition::EmergencyStop, Inhibition::Fault] {
            for what in [Some(why), None] {
                at_us += 500_000 + 10_000 * rng.below(1_500) + 1 + 3 * index;
                let at = Duration::from_micros(at_us as u64);
                let event = what.map_or(Event::Return(index.into()), |why| Event::Inhibit(index.into(), why));
                events.push((Time::ZERO + at, event));
                stops.entry(index).or_default().push((at, what));
            }
        }
    }
    (events, stops)
}

fn flaws(mission: &MissionSpec, seed: u64) -> Vec<Flaw> {
    let mut rng = Rng::of(&[seed, 22]);
    let drops = FlawKind::Drops(None);
    let kinds = [FlawKind::Fails, FlawKind::Hangs, drops, drops, drops];
    let leaves = mission.tree.leaves().filter(|_| rng.is(30)).collect::<Vec<_>>();
    leaves.into_iter().map(|leaf| Flaw { leaf, attempt: Some(1), kind: rng.one(&kinds) }).collect()
}

/// Asserts that both decided alike, and that the log of the runtime follows from itself; gives the decisions.
fn compare(mission: &Arc<MissionSpec>, seed: u64, simulated: &[Record], live: &[Record]) -> String {
    let (expected, found) = (decisions(&mission.names, simulated), decisions(&mission.names, live));
    let differs = std::iter::zip(expected.lines(), found.lines()).find(|(expected, found)| expected != found);
    assert!(
        expected == found,
        "AMBIDEX_SEED={seed}\n{}\nfirst difference (simulation, runtime): {differs:#?}\n{} and {} decisions",
        missions::text(seed),
        expected.lines().count(),
        found.lines().count()
    );
    let mut replay = Replay::new(mission, &Settings::default());
    live.iter().for_each(|record| replay.take(record).expect("the log of the runtime follows from itself"));
    expected
}

#[test]
fn any_number_of_changes_from_outside_is_taken() {
    let mission = load(&file("config/missions/hand-over.yaml"));
    let base = mission.start.base;
    let changes = || (0..1_000).map(|_| Control::World(Change::Base(base))).collect();
    assert_eq!(live(&mission, 0, changes(), Script::default()).0, Ended::Mission(MissionEnd::Done));
    let cancels = (0..1_000).map(|_| Control::Cancel).collect();
    assert_eq!(live(&mission, 0, cancels, Script::default()).0, Ended::Mission(MissionEnd::Canceled));
}

fn bodies(mission: &MissionSpec, seed: u64) -> Vec<Body> {
    let controllers = mission.robot.controllers.iter().enumerate();
    let body = |(index, spec): (usize, &ControllerSpec)| match seed % 3 {
        // What moves the shipped robot; some surfaces are out of its reach.
        0 => motion::simulated(&spec.kind),
        _ => Box::new(Scripted::new(seed, index as u64)) as Body,
    };
    controllers.map(body).collect()
}

fn simulated(mission: &Arc<MissionSpec>, seed: u64) -> Vec<Record> {
    simulated_with(mission, seed, Vec::new())
}

fn simulated_with(mission: &Arc<MissionSpec>, seed: u64, events: Vec<(Time, Event)>) -> Vec<Record> {
    let mut records = Vec::new();
    sim::simulate_bodies(mission, &Settings::default(), bodies(mission, seed), events, &mut |record| {
        records.push(record.clone());
    });
    records
}

/// Whether two behaviors end at one instant.
fn has_ends_at_once(records: &[Record]) -> bool {
    let mut seen = BTreeSet::new();
    let mut ends = records.iter().filter(|record| matches!(record, Record::Released { .. }));
    !ends.all(|record| seen.insert(record.at()))
}

fn live(mission: &Arc<MissionSpec>, seed: u64, controls: Vec<Control>, script: Script) -> (Ended, Vec<Record>) {
    live_with(mission, seed, controls, script, &Stops::new())
}

fn live_with(
    mission: &Arc<MissionSpec>,
    seed: u64,
    controls: Vec<Control>,
    script: Script,
    stops: &Stops,
) -> (Ended, Vec<Record>) {
    let executor = tokio::runtime::Builder::new_current_thread().enable_all().start_paused(true).build();
    let records = Arc::new(Mutex::new(Vec::new()));
    let to_records = Arc::clone(&records);
    let ended = executor.expect("an executor").block_on(async {
        let clock = Clock::start(1.0);
        let link = |(index, body)| {
            let stops = stops.get(&index).map(Vec::as_slice).unwrap_or_default();
            Box::new(Memory::new(body, &mission.names, stops, clock)) as Box<dyn Port>
        };
        let links = bodies(mission, seed).into_iter().enumerate().map(link).collect();
        let (control, controlled) = mpsc::unbounded_channel();
        controls.into_iter().for_each(|told| control.send(told).expect("it is not over"));
        let journal = Box::new(move |record: &Record| to_records.lock().expect("no poison").push(record.clone()));
        let options = Options {
            reader: None,
            settings: Settings::default(),
            clock,
            attach_timeout: Some(Duration::from_secs(10)),
            grace: Duration::from_secs(3),
            journal: Some(journal),
            resumed: None,
            script,
            diagnostics: Default::default(),
        };
        runtime::run(Arc::clone(mission), links, options, controlled).await
    });
    (ended, records.lock().expect("no poison").clone())
}
