//! What goes wrong by chance: the same for a seed, and the same again from the file that says what it was.

use std::path::Path;
use std::time::Duration;

use ambidex::files::{self, Disk, failures_text};
use ambidex::model::{End, Failures, Fault, Flaw, FlawKind, Mishap, MissionEnd, Record, Time};
use ambidex::sim::{self, Chance};
use ambidex::tree::Settings;

use crate::fixtures::{file, load, simulate_failures};

/// Missions in which all kinds of failure are possible.
const MISSIONS: [&str; 4] = ["experiment-1", "battery", "tray", "door"];

fn until_400() -> Failures {
    let end = (Time::ZERO + Duration::from_secs(400), Mishap::Cancel);
    Failures { mishaps: vec![end], flaws: Vec::new() }
}

fn by_chance(mission: &str, probability: f64, seed: u64) -> (MissionEnd, Failures, Vec<Record>) {
    let mission = load(&file(&format!("config/missions/{mission}.yaml")));
    let chance = Chance { probability, seed };
    let mut records = Vec::new();
    let mut take = |record: &Record| records.push(record.clone());
    let (end, drawn) = sim::simulate_chance(&mission, &Settings::default(), &until_400(), chance, &mut take);
    (end, drawn, records)
}

#[test]
fn what_was_drawn_comes_to_the_same_records() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("drawn.yaml");
    let mut wrong = 0;
    for name in MISSIONS {
        let mission = load(&file(&format!("config/missions/{name}.yaml")));
        for seed in 0..25 {
            let (end, drawn, records) = by_chance(name, 0.1, seed);
            wrong += drawn.flaws.len() + drawn.mishaps.len() - 1;
            std::fs::write(&path, failures_text(&drawn, &mission.names).expect("an end")).expect("a file");
            let read = files::load_failures(&Disk, Path::new(&path), &mission)
                .unwrap_or_else(|error| panic!("{name}, seed {seed}: {:?}", error.faults()));
            assert_eq!(read, drawn, "{name}, seed {seed}");
            let again = simulate_failures(&mission, &read);
            assert!(again == (end, records), "{name}, seed {seed}: another run");
        }
    }
    assert!(wrong > 100, "only {wrong} things went wrong");
}

#[test]
fn nothing_goes_wrong_without_a_chance() {
    let (end, drawn, _) = by_chance("experiment-1", 0.0, 7);
    assert_eq!((end, drawn), (MissionEnd::Done, until_400()));
}

#[test]
fn everything_goes_wrong_where_it_is_certain() {
    let (_, drawn, records) = by_chance("experiment-1", 1.0, 3);
    let granted = records.iter().filter_map(|record| match record {
        Record::Decided { granted, .. } => Some(granted.len()),
        _ => None,
    });
    let is_away = |(_, mishap): &&(Time, Mishap)| !matches!(mishap, Mishap::Return(_) | Mishap::Cancel);
    let wrong = drawn.flaws.len() + drawn.mishaps.iter().filter(is_away).count();
    assert_eq!(wrong, granted.sum::<usize>());
}

#[test]
fn each_kind_of_failure_happens() {
    let kinds = |drawn: &Failures| {
        let flaws = drawn.flaws.iter().map(|flaw| format!("{:?}", flaw.kind));
        let all: Vec<String> = flaws.chain(drawn.mishaps.iter().map(|(_, mishap)| format!("{mishap:?}"))).collect();
        all
    };
    let drawn: Vec<String> = ["door", "tray"]
        .into_iter()
        .flat_map(|mission| (0..50).flat_map(move |seed| kinds(&by_chance(mission, 0.3, seed).1)))
        .collect();
    for kind in ["Fails", "Hangs", "Late", "Drops", "Lose", "Hang(", "Inhibit", "Return", "World(Fact", "World(Object"]
    {
        assert!(drawn.iter().any(|one| one.starts_with(kind)), "no {kind}");
    }
}

/// What is dropped on the way to be put down is taken once more, by the same hands too.
#[test]
fn what_is_dropped_as_it_is_put_down_is_taken_again() {
    let mission = load(&file("config/missions/tray.yaml"));
    let names = &mission.names;
    let place = mission.tree.leaves().find(|leaf| names.node(*leaf) == "place tray with both hands");
    let flaw = Flaw { leaf: place.expect("it is put down"), attempt: Some(1), kind: FlawKind::Drops(None) };
    let (end, records) = simulate_failures(&mission, &Failures { mishaps: Vec::new(), flaws: vec![flaw] });
    let contradicted = records
        .iter()
        .any(|record| matches!(record, Record::Released { end: End::Failed(Fault::Contradicted(_)), .. }));
    assert!(contradicted && end == MissionEnd::Done, "{end:?}");
}
