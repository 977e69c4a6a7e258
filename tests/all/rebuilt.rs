//! Steps, skips and last reasons rebuilt from the lines of the log file, with nothing of the program but its output.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use ambidex::model::{Names, Reason};
use ambidex::record::{History, Reader};
use serde_json::Value;

use crate::fixtures::{HANDS_FULL, experiment_file, mission, too_slow};
use crate::home::{Finished, Home, flat};

/// What the log tells.
#[derive(Debug, Default)]
struct Story {
    header: Value,
    steps: Vec<BTreeSet<u64>>,
    skipped: Vec<u64>,
    succeeded: BTreeSet<u64>,
    reasons: BTreeMap<u64, Value>,
    end: Value,
    is_closed: bool,
}

impl Story {
    fn read(path: &Path) -> Self {
        let text = std::fs::read_to_string(path).expect("a log");
        let mut story = Self { is_closed: true, ..Self::default() };
        for line in text.lines() {
            story.add(&serde_json::from_str(line).expect("a record"));
        }
        story
    }

    fn add(&mut self, record: &Value) {
        match record["record"].as_str() {
            Some("header") => self.header = record.clone(),
            Some("decided") => self.decide(record),
            Some("released") => {
                self.is_closed = true;
                if record["end"] == "succeeded" {
                    self.succeeded.insert(id(&record["leaf"]));
                }
            }
            Some("ended") if self.end.is_null() => {
                self.end = record["end"].clone();
                let met = self.reasons.iter().filter(|(_, reason)| **reason == "satisfied");
                let met: Vec<_> = met.map(|(leaf, _)| *leaf).collect();
                if self.end == "done" {
                    met.into_iter().for_each(|leaf| self.skip(leaf));
                }
            }
            _ => {}
        }
    }

    fn decide(&mut self, record: &Value) {
        for grant in list(&record["granted"]) {
            if std::mem::take(&mut self.is_closed) {
                self.steps.push(BTreeSet::new());
            }
            let leaf = id(&grant["leaf"]);
            self.steps.last_mut().expect("an open step").insert(leaf);
            self.reasons.remove(&leaf);
            self.skipped.retain(|skipped| *skipped != leaf);
            for skip in list(&grant["skips"]) {
                (id(&skip["from"])..id(&skip["to"])).for_each(|leaf| self.skip(leaf));
            }
        }
        for refused in list(&record["refused"]) {
            self.reasons.insert(id(&refused["leaf"]), refused["reason"].clone());
        }
        if let Some(reopened) = record["reopened"].as_object() {
            self.skipped.retain(|skipped| *skipped != id(&reopened["node"]));
            self.is_closed |= !reopened["cause"]["lapse"].is_null();
        }
    }

    fn skip(&mut self, node: u64) {
        let kind = self.header["nodes"][node as usize]["kind"].as_str();
        let is_leaf = !matches!(kind, Some("root" | "and" | "or" | "then"));
        if is_leaf && !self.succeeded.contains(&node) && !self.skipped.contains(&node) {
            self.skipped.push(node);
        }
    }

    fn name(&self, node: &u64) -> &str {
        self.header["names"]["nodes"][*node as usize].as_str().expect("a name")
    }

    fn named_steps(&self) -> Vec<BTreeSet<&str>> {
        let named = |step: &BTreeSet<u64>| step.iter().map(|node| self.name(node)).collect();
        self.steps.iter().map(named).collect()
    }
}

fn id(value: &Value) -> u64 {
    value.as_u64().expect("an id")
}

fn list(value: &Value) -> &[Value] {
    value.as_array().expect("a list")
}

/// Compares the log with the report, and its reasons with the program's own and with what it printed.
fn check(home: &Home, log: &Path, finished: &Finished) -> Story {
    let story = Story::read(log);
    let report: Value = serde_json::from_str(&finished.stdout).expect("a report");
    assert_eq!(serde_json::json!(story.named_steps()), report["steps"]);
    let skipped: Vec<_> = story.skipped.iter().map(|node| story.name(node)).collect();
    assert_eq!(serde_json::json!(skipped), report["skipped"]);
    let reader = Reader::open(log).expect("a journal");
    let mut history = History::new(reader.header());
    reader.for_each(|record| history.apply(&record.expect("a record")));
    let told = history.leaves().filter_map(|leaf| Some((u64::from(leaf.0), history.leaf(leaf)?.reason()?)));
    let reasons: BTreeMap<u64, Value> =
        told.map(|(leaf, reason)| (leaf, serde_json::to_value(reason).expect("JSON"))).collect();
    assert_eq!(story.reasons, reasons);
    home.is_empty();
    story
}

/// The sentence of every last reason of a leaf that is not done stands in what was printed.
fn check_printed(story: &Story, finished: &Finished) {
    let names: Names = serde_json::from_value(story.header["names"].clone()).expect("names");
    let printed = finished.words();
    let open = story.reasons.iter().filter(|(_, reason)| **reason != "satisfied");
    for (leaf, reason) in open {
        let reason: Reason = serde_json::from_value(reason.clone()).expect("a reason");
        let sentence = flat(&reason.sentence(&names));
        assert!(printed.contains(&sentence), "{}: {sentence}\n{}", story.name(leaf), finished.stderr);
    }
}

fn played(home: &Home, verb: &[&str], mission: &Path, code: i32) -> (Story, Finished) {
    let log = home.path("log.jsonl");
    let args = verb.iter().map(AsRef::as_ref).chain(["--json", "--log"].map(AsRef::as_ref));
    let args = args.chain([log.as_os_str(), mission.as_os_str()]);
    let finished = home.start(args).ends(code);
    (check(home, &log, &finished), finished)
}

#[test]
fn the_log_of_an_experiment_tells_its_report() {
    let home = Home::new();
    for number in 1..=4 {
        for verb in [&["run", "--speed", "100"][..], &["simulate"], &["simulate", "--allocator", "serial"]] {
            let (story, _) = played(&home, verb, &experiment_file(number), 0);
            assert_eq!(story.end, "done");
        }
    }
}

#[test]
fn the_log_of_a_stalled_mission_tells_every_reason() {
    let home = Home::new();
    let mission = home.write("mission.yaml", &mission(HANDS_FULL));
    for verb in [&["run", "--speed", "100"][..], &["simulate"]] {
        let (story, finished) = played(&home, verb, &mission, 3);
        assert_eq!(story.end, "stalled");
        assert!(!story.reasons.is_empty());
        check_printed(&story, &finished);
    }
}

#[test]
fn the_log_of_a_failed_mission_tells_its_report() {
    let home = Home::new();
    let mission = home.write("slow.yaml", &too_slow("pick: {object: 2}"));
    let log = home.path("log.jsonl");
    let args = ["--json", "--speed", "100", "--log", log.to_str().expect("a path in UTF-8")];
    let finished = home.carry("run", &mission, &args).ends(1);
    let story = check(&home, &log, &finished);
    let failed = id(&story.end["failed"]);
    assert_eq!(story.name(&failed), "pick 2", "the left arm takes object 2");
}
