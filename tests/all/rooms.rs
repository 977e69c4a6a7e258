//! The paper's experiments and forty random rooms, simulated: steps and skips as foretold.

use std::sync::Arc;

use ambidex::tree::{Serial, Settings};

use crate::fixtures::{Expected, experiment_file, experiments, load, rooms, simulate};

/// The number of steps it took.
fn check(name: &str, file: &std::path::Path, expected: &Expected) -> usize {
    let (_, report) = simulate(&load(file), &Settings::default(), Vec::new());
    assert_eq!(report.outcome.word(), "done", "{name}");
    assert_eq!(report.steps, expected.steps, "{name}");
    assert_eq!(report.skipped, expected.skipped, "{name}");
    report.steps.len()
}

#[test]
fn experiments_come_out_as_in_the_paper() {
    for (number, expected) in experiments() {
        check(&format!("experiment {number}"), &experiment_file(number), &expected);
    }
}

#[test]
fn forty_rooms_come_out_as_foretold() {
    let folder = tempfile::tempdir().expect("a folder");
    let (mut taken, mut fewest, mut best) = (0, 0, 0);
    for (number, room) in rooms() {
        let path = folder.path().join(format!("room-{number}.yaml"));
        std::fs::write(&path, room.mission(number)).expect("a file");
        let steps = check(&format!("room {number}"), &path, &room.expected);
        assert!(steps >= room.fewest, "room {number}: {steps} steps, and {} is the least there is", room.fewest);
        (taken, fewest, best) = (taken + steps, fewest + room.fewest, best + usize::from(steps == room.fewest));
    }
    println!("{taken} steps where {fewest} would do; {best} of forty rooms could not be done in fewer");
    assert_eq!((taken, fewest, best), (606, 499, 7));
}

#[test]
fn serial_delivers_everything_one_behavior_at_a_time() {
    let settings = Settings { allocator: Arc::new(Serial), ..Settings::default() };
    for number in experiments().into_keys() {
        let (records, report) = simulate(&load(&experiment_file(number)), &settings, Vec::new());
        assert_eq!(report.outcome.word(), "done");
        assert!(report.steps.iter().all(|step| step.len() == 1), "{:?}", report.steps);
        let mut running = 0;
        for record in records {
            match record {
                ambidex::model::Record::Decided { granted, .. } => running += granted.len(),
                ambidex::model::Record::Released { .. } => running -= 1,
                _ => {}
            }
            assert!(running <= 1, "two behaviors run at once in experiment {number}");
        }
        println!("experiment {number}: {} steps, {} skipped", report.steps.len(), report.skipped.len());
    }
}
