//! The program with real processes.

mod asking;
mod by_hand;
mod deaths;
mod doctor;
mod exits;
mod failing;
mod kills;
mod logs;
mod outside;
mod runs;
mod service;
mod shutdown;
mod talk;
mod tasks;

use serde_json::Value;

use crate::fixtures::Expected;
use crate::home::Finished;

/// Names of the robot's controllers.
const CONTROLLERS: [&str; 4] = ["left_arm", "right_arm", "head", "base"];

/// The keys of a report, in order.
const KEYS: [&str; 7] = ["makespan_s", "messages", "mission", "outcome", "rounds", "skipped", "steps"];

/// The report on stdout, where nothing else may stand.
fn report(finished: &Finished) -> Value {
    let lines: Vec<_> = finished.stdout.lines().collect();
    assert_eq!(lines.len(), 1, "{finished:#?}");
    let report: Value = serde_json::from_str(lines[0]).expect("a JSON object");
    let mut keys: Vec<_> = report.as_object().expect("an object").keys().collect();
    keys.sort();
    assert_eq!(keys, KEYS);
    report
}

/// Asserts that a mission came out as foretold.
fn came_out(finished: &Finished, expected: &Expected) {
    let report = report(finished);
    assert_eq!(report["outcome"], "done");
    assert_eq!(report["steps"], serde_json::json!(expected.steps));
    assert_eq!(report["skipped"], serde_json::json!(expected.skipped));
    assert!(report["makespan_s"].as_f64().is_some_and(|seconds| seconds > 10.0));
}
