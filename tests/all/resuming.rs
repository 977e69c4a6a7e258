//! Runs that end anywhere and go on: the mission comes to the same, and nothing whose end was recorded is done again.
//!
//! `AMBIDEX_STRIDE=1` stops the simulated ones at every record; without it every few are taken.

use std::path::PathBuf;
use std::sync::Arc;

use ambidex::files::{self, Disk};
use ambidex::model::state::State;
use ambidex::model::{MissionEnd, MissionSpec, Record};
use ambidex::replay::Replay;
use ambidex::sim;
use ambidex::tree::Settings;

use crate::fixtures::{file, load, simulate, simulate_failures};

fn replayed(mission: &Arc<MissionSpec>, records: &[Record]) -> Replay {
    let mut replay = Replay::new(mission, &Settings::default());
    for (line, record) in records.iter().enumerate() {
        replay.take(record).unwrap_or_else(|difference| panic!("line {}: {difference:#?}", line + 1));
    }
    replay
}

/// The state after all records; nothing is granted that is done.
pub fn state(mission: &MissionSpec, records: &[Record]) -> State {
    let resources = mission.robot.resources.len();
    let mut state = State::new(Arc::new(mission.tree.topology.clone()), resources, mission.start.clone());
    for record in records {
        if let Record::Decided { granted, .. } = record {
            let again = granted.iter().find(|grant| state.is_done(grant.leaf()));
            assert!(again.is_none(), "done and granted again: {again:?}");
        }
        assert!(state.apply(record), "{record:?} contradicts what stands before it");
    }
    state
}

fn missions() -> Vec<PathBuf> {
    let folder = std::fs::read_dir(file("config/missions")).expect("the shipped missions");
    let mut paths: Vec<_> = folder.map(|entry| entry.expect("an entry").path()).collect();
    // Somebody else opens the door.
    paths.retain(|path| !path.ends_with("door.yaml"));
    paths.sort();
    paths
}

/// Every shipped mission, and those of what goes wrong: an arm that is away, a mug that falls, what fails and waits.
fn runs() -> Vec<(PathBuf, Arc<MissionSpec>, Vec<Record>)> {
    let undisturbed = missions().into_iter().map(|path| {
        let mission = load(&path);
        let records = simulate(&mission, &Settings::default(), Vec::new()).0;
        (path, mission, records)
    });
    let failing = [("experiment-1", "arm"), ("read-a-label", "mug"), ("read-a-label", "label")];
    let failing = failing.map(|(mission, failures)| {
        let mission = load(&file(&format!("config/missions/{mission}.yaml")));
        let path = file(&format!("config/failures/{failures}.yaml"));
        let failures = files::load_failures(&Disk, &path, &mission).expect("it is sound");
        let records = simulate_failures(&mission, &failures).1;
        (path, mission, records)
    });
    undisturbed.chain(failing).collect()
}

#[test]
fn a_simulated_run_goes_on_from_every_record() {
    let stride = std::env::var("AMBIDEX_STRIDE").ok().and_then(|stride| stride.parse().ok()).unwrap_or(37);
    let mut stops = 0;
    for (path, mission, records) in runs() {
        let whole = state(&mission, &records);
        let over = records.iter().position(|record| matches!(record, Record::Ended { .. })).expect("it ends");
        for stop in (1..=over).step_by(stride) {
            stops += 1;
            let resumed = replayed(&mission, &records[..stop]).finish();
            let mut log = records[..stop].to_vec();
            let resumed_end = sim::resume(&mission, resumed, &mut |record| log.push(record.clone()));
            let at = || format!("{} stopped behind record {stop}", path.display());
            assert_eq!(resumed_end, MissionEnd::Done, "{}", at());
            assert_eq!(replayed(&mission, &log).finish().missing, [], "{}", at());
            let state = state(&mission, &log);
            // What went wrong on purpose does not again.
            if path.parent().is_some_and(|folder| folder.ends_with("failures")) {
                continue;
            }
            assert_eq!(state.world().objects, whole.world().objects, "{}", at());
            assert_eq!(state.world().facts, whole.world().facts, "{}", at());
        }
    }
    println!("{stops} stops");
}
