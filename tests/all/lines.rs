//! Small missions on a robot of one rail and two tools, which nobody moves: what is told of them, line by line.

use std::path::Path;
use std::sync::Arc;

use ambidex::files::{self, InMemory};
use ambidex::model::{MissionSpec, Record};
use ambidex::record::History;
use ambidex::show::live;
use ambidex::tree::Settings;

use crate::fixtures::simulate_wrongs;

const ROBOT: &str = "\
robot: bench
radius: 0.3 m
resources: {rail: {type: rail}, one: {type: tool}, two: {type: tool}}
controllers: {}
";

/// `$n` claims the rail, or one of what `of` says.
const MISSION: &str = "\
mission: bench
robot: bench.yaml
world:
  robot: {at: [0 m, 0 m]}
  places: {here: {stand: [0 m, 0 m]}}
  facts: {rang: {holds: false, outside: true}, lacking: false}
behaviors:
  short: {label: $n, parameters: {n: text, of: {type: type, default: rail}}, claims: {it: {type: $of}}, potential: 1, takes: 2 s}
  long: {label: $n, parameters: {n: text, of: {type: type, default: rail}}, claims: {it: {type: $of}}, potential: 2, takes: 10 s}
  firm: {label: $n, parameters: {n: text, of: {type: type, default: rail}}, claims: {it: {type: $of}}, potential: 2, takes: 10 s, interruptible: false}
  ring: {potential: 1, effects: [{set: rang}], takes: 3 s}
  answer: {label: $n, parameters: {n: text, of: {type: type, default: rail}}, claims: {it: {type: $of}}, potential: 1, precondition: [{fact: rang}], takes: 2 s}
  answer_both: {label: $n, parameters: {n: text}, claims: {it: {type: rail}, with: {type: tool}}, potential: 1, precondition: [{fact: rang}], takes: 2 s}
  three: {label: $n, parameters: {n: text, of: {type: type, default: rail}}, claims: {it: {type: $of}}, potential: 1, takes: 3 s}
  pair: {label: $n, parameters: {n: text}, claims: {it: {type: tool}, other: {type: tool}}, potential: 1, takes: 2 s}
  quiet: {label: $n, parameters: {n: text}, claims: {it: {type: rail}}, potential: 1, while: [{not_fact: rang}], takes: 10 s}
  once: {label: $n, parameters: {n: text, of: {type: type, default: rail}}, claims: {it: {type: $of}}, potential: 1, takes: 2 s, timeout: 4 s, retries: 0}
  set: {label: $n, parameters: {n: text}, goal: [{fact: lacking}], potential: 1, effects: [{set: lacking}], takes: 1 s}
  never: {label: $n, parameters: {n: text}, potential: 1, precondition: [{fact: lacking}], takes: 1 s}
";

/// A mission of the bench from its task.
pub fn bench(task: &str) -> MissionSpec {
    let mut files = InMemory::default();
    files.insert("bench.yaml", ROBOT.to_owned());
    files.insert("mission.yaml", format!("{MISSION}task: {{{task}}}\n"));
    match files::load_mission(&files, Path::new("mission.yaml"), None, &[]) {
        Ok(loaded) => (*loaded.mission).clone(),
        Err(error) => panic!("{error}: {:#?}", error.faults()),
    }
}

/// What is told of a simulation, but for the ends of what succeeded; every decision follows from its log.
pub fn told(mission: MissionSpec, settings: &Settings, failures: &str) -> Vec<String> {
    let mission = Arc::new(mission);
    lines(&simulate_wrongs(&mission, settings, failures).1)
}

/// The lines of a log, but for its first and for the ends of what succeeded, each with its second.
pub fn lines(records: &[Record]) -> Vec<String> {
    let Some(Record::Header(header)) = records.first() else { panic!("a header comes first") };
    let mut history = History::with_past(header);
    let lines = records.iter().filter_map(|record| {
        history.apply(record);
        let line = live::line(&history, record)?;
        let (at, said) = line.trim().split_once(" s  ").expect("a moment comes first");
        let is_news = !said.starts_with("done ") || said.starts_with("done in");
        is_news.then(|| format!("{at} {said}"))
    });
    lines.skip(1).collect()
}

/// Compares what is told with lines that must come.
#[track_caller]
pub fn check(task: &str, failures: &str, expected: &str) {
    check_mission(bench(task), &Settings::default(), failures, expected);
}

/// The same of a mission.
#[track_caller]
pub fn check_mission(mission: MissionSpec, settings: &Settings, failures: &str, expected: &str) {
    let told = told(mission, settings, failures);
    let expected: Vec<&str> = expected.trim().lines().map(str::trim).collect();
    assert_eq!(told, expected, "\n{}", told.join("\n"));
}
