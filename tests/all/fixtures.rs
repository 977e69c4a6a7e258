//! The paper's experiments and forty random rooms as data, and missions made from them.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use ambidex::files::{self, InMemory};
use ambidex::model::{Failures, MissionEnd, MissionSpec, Record};
use ambidex::record::{History, MissionReport};
use ambidex::replay::Replay;
use ambidex::sim::{self, Event};
use ambidex::tree::Settings;
use serde::Deserialize;

/// A file of the project.
pub fn file(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

/// Experiments and rooms with the steps that must come out.
#[derive(Debug, Deserialize)]
pub struct Expected {
    pub steps: Vec<Vec<String>>,
    pub skipped: Vec<String>,
}

/// One of the forty rooms.
#[derive(Debug, Deserialize)]
pub struct Room {
    robot: [f64; 2],
    places: BTreeMap<String, [f64; 2]>,
    objects: BTreeMap<u32, Way>,
    #[serde(flatten)]
    pub expected: Expected,
    /// Fewest steps of any order, by a search over all.
    pub fewest: usize,
}

#[derive(Debug, Deserialize)]
struct Way {
    from: String,
    to: String,
}

#[derive(Debug, Deserialize)]
struct Rooms {
    rooms: BTreeMap<u32, Room>,
}

#[derive(Debug, Deserialize)]
struct Experiments {
    experiments: BTreeMap<u32, Expected>,
}

/// The forty rooms by number.
pub fn rooms() -> BTreeMap<u32, Room> {
    let text = std::fs::read_to_string(file("tests/data/layouts.yaml")).expect("the rooms are there");
    serde_saphyr::from_str::<Rooms>(&text).expect("the rooms parse").rooms
}

/// What must come out of the four experiments, by number.
pub fn experiments() -> BTreeMap<u32, Expected> {
    let text = std::fs::read_to_string(file("tests/data/experiments.yaml")).expect("they are there");
    serde_saphyr::from_str::<Experiments>(&text).expect("they parse").experiments
}

/// A shipped mission.
pub fn experiment_file(number: u32) -> PathBuf {
    file(&format!("config/missions/experiment-{number}.yaml"))
}

/// Three objects to take with two grippers and nowhere to put them: it stalls.
pub const HANDS_FULL: &str = "\
objects: {1: {at: shelf}, 2: {at: shelf}, 3: {at: shelf}}
task:
  and:
    - then: [{move: {to: shelf}, name: move 1}, {pick: {object: 1}}]
    - then: [{move: {to: shelf}, name: move 2}, {pick: {object: 2}}]
    - then: [{move: {to: shelf}, name: move 3}, {pick: {object: 3}}]
";

/// A mission file for the robot of the paper in a small room, from its objects and its task.
pub fn mission(objects_and_task: &str) -> String {
    let robot = file("config/robots/pr2.yaml");
    let (objects, task) = objects_and_task.split_once('\n').expect("objects first");
    format!(
        "mission: small\nrobot: {}\nworld:\n  robot: {{at: [0, 0]}}\n  places: {{shelf: {{stand: [2, 0]}}, table: {{stand: [0, 2]}}}}\n  {objects}\n{task}",
        robot.display()
    )
}

impl Room {
    /// The room as a mission file.
    pub fn mission(&self, number: u32) -> String {
        let mut text = format!("mission: room-{number}\nrobot: {}\n", file("config/robots/pr2.yaml").display());
        let [x, y] = self.robot;
        let mut line = |line: String| writeln!(text, "{line}").expect("a string takes all");
        line(format!("world:\n  tolerance: 0.25 m\n  robot: {{at: [{x}, {y}]}}\n  places:"));
        for (place, [x, y]) in &self.places {
            line(format!("    {place}: {{stand: [{x}, {y}]}}"));
        }
        line("  objects:".into());
        for (object, way) in &self.objects {
            line(format!("    {object}: {{at: {}}}", way.from));
        }
        line("task:\n  and:".into());
        for (object, Way { from, to }) in &self.objects {
            line("    - then:".into());
            line(format!("        - {{move: {{to: {from}}}, name: move {object}-1}}"));
            line(format!("        - pick: {{object: {object}}}"));
            line(format!("        - {{move: {{to: {to}}}, name: move {object}-2}}"));
            line(format!("        - place: {{object: {object}}}"));
        }
        text
    }
}

/// Loads a mission and says what is wrong with it if it is.
pub fn load(path: &Path) -> Arc<MissionSpec> {
    match files::load_mission(&files::Disk, path, None, &[]) {
        Ok(loaded) => loaded.mission,
        Err(error) => panic!("{error}: {:#?}", error.faults()),
    }
}

/// Simulates a mission; the records it wrote and the report.
pub fn simulate(
    mission: &Arc<MissionSpec>,
    settings: &Settings,
    events: Vec<(ambidex::model::Time, Event)>,
) -> (Vec<Record>, MissionReport) {
    let mut records = Vec::new();
    sim::simulate(mission, settings, events, &mut |record| records.push(record.clone()));
    let report = history(&records).report().expect("a simulation ends");
    (records, report)
}

/// Simulates a mission in which things go wrong on purpose.
pub fn simulate_failures(mission: &Arc<MissionSpec>, failures: &Failures) -> (MissionEnd, Vec<Record>) {
    let mut records = Vec::new();
    let mut take = |record: &Record| records.push(record.clone());
    let end = sim::simulate_failures(mission, &Settings::default(), failures, &mut take);
    (end, records)
}

/// Simulates a mission in which things go wrong as a list in YAML says, or nothing does; every decision follows from its
/// log.
pub fn simulate_wrongs(mission: &Arc<MissionSpec>, settings: &Settings, failures: &str) -> (MissionEnd, Vec<Record>) {
    let mut files = InMemory::default();
    files.insert("failures.yaml", format!("failures:\n{failures}"));
    let failures = match failures {
        "" => Ok(Failures::default()),
        _ => files::load_failures(&files, Path::new("failures.yaml"), mission),
    };
    let failures = failures.unwrap_or_else(|error| panic!("{:#?}", error.faults()));
    let mut records = Vec::new();
    let end = sim::simulate_failures(mission, settings, &failures, &mut |record| records.push(record.clone()));
    let mut replay = Replay::new(mission, settings);
    records.iter().for_each(|record| replay.take(record).expect("every decision follows"));
    (end, records)
}

/// What was granted, round by round.
pub fn steps(mission: &MissionSpec, records: &[Record]) -> String {
    let steps = records.iter().filter_map(|record| match record {
        Record::Decided { granted, .. } if !granted.is_empty() => {
            let names = granted.iter().map(|grant| mission.names.node(grant.leaf()));
            Some(names.collect::<Vec<_>>().join(" + "))
        }
        _ => None,
    });
    steps.collect::<Vec<_>>().join(", ")
}

/// What records from a header on come to.
pub fn history(records: &[Record]) -> History {
    History::of(records).expect("a header comes first")
}

/// Experiment 1 in which one behavior may take no time at all.
pub fn too_slow(behavior: &str) -> String {
    let text = std::fs::read_to_string(experiment_file(1)).expect("it is there");
    let robot = file("config/robots/pr2.yaml");
    let text = text.replace("../robots/pr2.yaml", robot.to_str().expect("a path in UTF-8"));
    text.replace(&format!("- {behavior}"), &format!("- {{{behavior}, timeout: 100 ms}}"))
}
