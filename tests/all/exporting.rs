//! Logs for other programs: trace events whose spans nest, tables that add up, and files that are replaced at once.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

use ambidex::files::{self, Disk};
use ambidex::model::{ControllerMessage, End, Header, Record, ToController};
use ambidex::show::export::{Rows, Table, Trace};
use serde_json::Value;
use strum::VariantArray;

use crate::fixtures::{experiment_file, file, load, simulate_failures};
use crate::home::Home;

/// Shipped missions, and files of what goes wrong in them.
const RUNS: &[(&str, Option<&str>)] = &[
    ("experiment-1", None),
    ("experiment-1", Some("arm")),
    ("experiment-1", Some("stop")),
    ("battery", None),
    ("patrol", None),
    ("put-down", Some("cancel")),
    ("read-a-label", Some("mug")),
    ("read-a-label", Some("label")),
    ("door", Some("door")),
    ("two-hands", None),
    ("tray", None),
];

/// The records of a shipped mission.
fn records(mission: &str, failures: Option<&str>) -> Vec<Record> {
    let mission = load(&file(&format!("config/missions/{mission}.yaml")));
    let failures = failures.map(|name| file(&format!("config/failures/{name}.yaml")));
    let failures = failures.map(|path| files::load_failures(&Disk, &path, &mission).expect("failures"));
    simulate_failures(&mission, &failures.unwrap_or_default()).1
}

fn header(records: &[Record]) -> &Header {
    let Some(Record::Header(header)) = records.first() else { panic!("a header comes first") };
    header
}

fn events(records: &[Record]) -> Vec<Value> {
    let mut trace = Trace::new(header(records));
    let mut events: Vec<_> = records.iter().flat_map(|record| trace.take(record)).collect();
    events.extend(trace.finish());
    events.iter().map(|event| serde_json::to_value(event).expect("an event is plain")).collect()
}

fn rows(table: Table, records: &[Record]) -> Vec<BTreeMap<&'static str, String>> {
    let mut rows = Rows::new(table, header(records));
    let mut all: Vec<_> = records.iter().flat_map(|record| rows.take(record)).collect();
    all.extend(rows.finish());
    let named = |row: Vec<String>| {
        assert_eq!(row.len(), table.columns().len(), "{table:?}: {row:?}");
        std::iter::zip(table.columns().iter().copied(), row).collect()
    };
    all.into_iter().map(named).collect()
}

fn granted(records: &[Record]) -> usize {
    let of = |record: &Record| if let Record::Decided { granted, .. } = record { granted.len() } else { 0 };
    records.iter().map(of).sum()
}

fn goals(records: &[Record]) -> usize {
    let told = records.iter().filter_map(|record| match record {
        Record::Controller { message: ControllerMessage::Told { message, .. }, .. } => Some(message),
        _ => None,
    });
    told.filter(|message| matches!(message, ToController::Goal { .. })).count()
}

fn track(event: &Value) -> (u64, u64) {
    (event["pid"].as_u64().expect("a group"), event["tid"].as_u64().expect("a row"))
}

/// What is under way on each row, as the events of one run open and close it.
#[derive(Default)]
struct Open {
    spans: BTreeMap<(u64, u64), Vec<Value>>,
    /// Until when what stands on a row as a whole lasts.
    whole_until: BTreeMap<(u64, u64), u64>,
    arrows: BTreeMap<String, u64>,
    names: BTreeSet<(u64, u64)>,
}

impl Open {
    fn take(&mut self, event: &Value) {
        let (row, at) = (track(event), event["ts"].as_u64().expect("a moment"));
        let is_named = self.names.contains(&row);
        let spans = self.spans.entry(row).or_default();
        match event["ph"].as_str().expect("a phase") {
            "M" => drop(self.names.insert(row)),
            "B" => spans.push(event.clone()),
            "E" => {
                let begun = spans.pop().unwrap_or_else(|| panic!("{event} ends what never began"));
                assert!(begun["name"] == event["name"] && begun["ts"].as_u64() <= Some(at), "{begun} {event}");
            }
            "X" => {
                let until = at + event["dur"].as_u64().expect("never negative");
                let before = self.whole_until.insert(row, until);
                assert!(before.is_none_or(|before| before <= at), "{event} overlaps what ended at {before:?}");
            }
            "s" => {
                assert!(!spans.is_empty(), "{event} begins in nothing");
                self.arrows.insert(event["id"].to_string(), at);
            }
            "f" => {
                assert!(!spans.is_empty(), "{event} ends in nothing");
                assert_eq!(self.arrows.remove(&event["id"].to_string()), Some(at), "{event}");
            }
            "i" => assert_eq!(event["s"], "t"),
            other => panic!("{other} is no phase"),
        }
        assert!(event["ph"] == "M" || is_named, "{event} is on a row without a name");
    }
}

#[test]
fn spans_nest_and_arrows_have_two_ends() {
    for (mission, failures) in RUNS {
        let records = records(mission, *failures);
        let events = events(&records);
        let mut open = Open::default();
        events.iter().for_each(|event| open.take(event));
        assert!(open.spans.values().all(Vec::is_empty) && open.arrows.is_empty(), "{mission} {failures:?}");
        let count = |phase: &str, category: &str| {
            events.iter().filter(|event| event["ph"] == phase && event["cat"] == category).count()
        };
        assert_eq!(count("B", "behavior"), granted(&records), "{mission}");
        assert_eq!(count("B", "command"), goals(&records), "{mission}");
        let rounds = records.iter().filter(|record| matches!(record, Record::Decided { .. })).count();
        assert_eq!(count("i", "decision"), rounds, "{mission}");
        let failed = records.iter().filter(|record| matches!(record, Record::Released { end: End::Failed(_), .. }));
        assert!(count("i", "failure") >= failed.count(), "{mission}");
    }
}

#[test]
fn a_trace_says_who_and_why() {
    let events = events(&records("experiment-1", Some("arm")));
    let find = |phase: &str, name: &str| {
        let mut found = events.iter().filter(|event| event["ph"] == phase && event["name"] == name);
        found.next().unwrap_or_else(|| panic!("no {phase} {name}")).clone()
    };
    let pick = find("B", "pick 2");
    assert_eq!((pick["ts"].as_u64(), &pick["args"]["round"]), (Some(6_580_000), &3.into()));
    assert_eq!(pick["args"]["resources"], "left_gripper;head;base");
    assert_eq!(find("E", "pick 2")["args"]["fault"], "left_arm was lost");
    assert_eq!(
        find("i", "round 1")["args"]["refused"]["move 1-1"],
        "outbid by move 2-1 for base (0.502 against 0.490)"
    );
    assert_eq!(find("i", "failed pick 2: left_arm was lost")["cat"], "failure");
    let grasp = find("B", "grasp object 2");
    assert_eq!((&grasp["cat"], &grasp["args"]["for"]), (&"command".into(), &"pick 2".into()));
    let away = find("X", "its process ended");
    assert!(away["cat"] == "outage" && away["dur"].as_u64() > Some(1_000_000), "{away}");
    let kept = find("X", "kept for object 1");
    assert_eq!((&kept["args"]["hold"], &kept["args"]["behavior"]), (&"physical".into(), &"pick 1".into()));
}

#[test]
fn tables_add_up() {
    let moment = |row: &BTreeMap<&str, String>, column: &str| row[column].parse::<f64>().ok();
    for (mission, failures) in RUNS {
        let records = records(mission, *failures);
        let behaviors = rows(Table::Behaviors, &records);
        assert_eq!(behaviors.len(), granted(&records), "{mission}");
        for row in &behaviors {
            assert!(moment(row, "granted_s") <= moment(row, "ended_s"), "{mission}: {row:?}");
            assert_eq!(row["end"] == "failed", !row["fault"].is_empty(), "{mission}: {row:?}");
        }
        let commands = rows(Table::Commands, &records);
        assert_eq!(commands.len(), goals(&records), "{mission}");
        for row in commands.iter().filter(|row| !row["accepted_s"].is_empty()) {
            assert!(moment(row, "told_s") <= moment(row, "accepted_s"), "{mission}: {row:?}");
            assert!(moment(row, "accepted_s") <= moment(row, "ended_s"), "{mission}: {row:?}");
        }
        let leases = rows(Table::Resources, &records);
        let running = leases.iter().filter(|row| row["hold"] == "running");
        let bound: usize =
            behaviors.iter().map(|row| row["resources"].split(';').filter(|name| !name.is_empty()).count()).sum();
        assert!(running.count() <= bound && !leases.is_empty(), "{mission}");
        assert!(leases.iter().all(|row| row["to_s"].is_empty() || moment(row, "from_s") <= moment(row, "to_s")));
        let rounds = rows(Table::Rounds, &records);
        let decided = rounds.iter().flat_map(|row| row["granted"].split(';')).filter(|name| !name.is_empty());
        assert_eq!(decided.count(), behaviors.len(), "{mission}");
        assert!(!rows(Table::World, &records).is_empty(), "{mission}");
    }
}

#[test]
fn rows_are_as_they_were() {
    let records = records("experiment-1", Some("arm"));
    let check = |table: Table, at: usize, expected: &[(&str, &str)]| {
        let rows = rows(table, &records);
        for (column, value) in expected {
            assert_eq!(rows[at][column], *value, "{table:?} {column}: {:?}", rows[at]);
        }
    };
    let failed = [("task", "object 2"), ("node", "9"), ("name", "pick 2"), ("kind", "pick"), ("attempt", "1")];
    check(Table::Behaviors, 1, &failed);
    let failed = [("granted_s", "6.58"), ("ended_s", "8"), ("end", "failed"), ("fault", "left_arm was lost")];
    check(Table::Behaviors, 1, &failed);
    let again = [("name", "move 2-1"), ("attempt", "2"), ("waited_for", "no gripper would be available to it there")];
    check(Table::Behaviors, 5, &again);
    let lost = [("controller", "left_arm"), ("does", "grasp object 2"), ("end", "lost"), ("why", "its process ended")];
    check(Table::Commands, 1, &lost);
    let shared = [("resource", "head"), ("hold", "running"), ("holder", "pick 2"), ("channel", "at shelf")];
    check(Table::Resources, 2, &shared);
    check(Table::Rounds, 2, &[("at_s", "6.58"), ("granted", "pick 1;pick 2"), ("refused", "3")]);
    check(Table::World, 1, &[("what", "object"), ("name", "1"), ("is", "at"), ("where", "shelf"), ("by", "start")]);
}

/// A name that a table must quote.
const ODD: &str = "move, \"first\"; of 2";

/// The log of a mission in which a behavior has an odd name.
fn odd(home: &Home) -> String {
    let text = fs::read_to_string(experiment_file(1)).expect("a mission");
    let robot = file("config/robots/pr2.yaml");
    let text = text.replace("../robots/pr2.yaml", robot.to_str().expect("UTF-8"));
    let text = text.replace("name: move 2-1", &format!("name: '{ODD}'"));
    assert!(text.contains(ODD), "the mission names its moves");
    let (mission, log) = (home.write("odd.yaml", &text), home.path("log.jsonl"));
    let args = ["simulate", "--quiet", "--log"].map(AsRef::as_ref);
    home.start(args.into_iter().chain([log.as_os_str(), mission.as_os_str()])).ends(0);
    log.to_str().expect("UTF-8").to_owned()
}

#[test]
fn what_is_printed_reads_back() {
    let home = Home::new();
    let log = odd(&home);
    for table in Table::VARIANTS {
        let option = format!("--csv={}", table.word());
        let printed = home.start(["export", &log, &option]).ends(0);
        assert_eq!(printed.stderr, "");
        let mut reader = csv::Reader::from_reader(printed.stdout.as_bytes());
        assert_eq!(reader.headers().expect("a head").iter().collect::<Vec<_>>(), table.columns());
        let rows: Vec<_> = reader.records().map(|row| row.expect("a row")).collect();
        assert!(rows.len() > 5, "{table:?}");
    }
    let behaviors = home.start(["export", &log, "--csv"]).ends(0).stdout;
    let mut reader = csv::Reader::from_reader(behaviors.as_bytes());
    let first = reader.records().next().expect("a row").expect("a row");
    assert_eq!((&first[2], &first[3]), (ODD, "move"));
    let printed = home.start(["export", &log, "--chrome-trace"]).ends(0).stdout;
    let trace: Value = serde_json::from_str(&printed).expect("JSON");
    let records: Vec<Record> = ambidex::record::Reader::open(&log).expect("a log").map(Result::unwrap).collect();
    assert_eq!(trace["traceEvents"], Value::from(events(&records)));
}

fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).expect("a folder").flatten();
    let mut names: Vec<_> = entries.map(|entry| entry.file_name().into_string().expect("UTF-8")).collect();
    names.sort();
    names
}

#[test]
fn a_file_is_replaced_when_all_is_written() {
    let home = Home::new();
    let log = odd(&home);
    fs::create_dir(home.path("out")).expect("a folder");
    let old = home.write("out/table.csv", "before");
    let out = old.to_str().expect("UTF-8");
    home.start(["export", &log, "--csv", "-o", out]).ends(0);
    assert!(fs::read_to_string(&old).expect("a file").starts_with("task,node,name,kind,"));
    let broken =
        fs::read_to_string(&log).expect("a log").replacen("\"record\":\"decided\"", "\"record\":\"derided\"", 1);
    let broken = home.write("broken.jsonl", &broken);
    let said = home.start(["export", broken.to_str().expect("UTF-8"), "--csv=rounds", "-o", out]).ends(2).words();
    assert!(said.contains("is not a record"), "{said}");
    assert!(fs::read_to_string(&old).expect("a file").starts_with("task,"), "what was there stays");
    assert_eq!(names(&home.path("out")), ["table.csv"], "nothing half-written is left");
}

#[test]
fn what_cannot_be_is_said() {
    let home = Home::new();
    let log = odd(&home);
    let check = |args: &[&str], words: &str| {
        let finished = home.start(["export"].iter().chain(args)).ends(2);
        assert_eq!(finished.stdout, "", "{args:?}");
        assert!(finished.words().contains(words), "{args:?}: {}", finished.words());
    };
    check(&[&log], "<--chrome-trace|--csv[=<TABLE>]|--mcap>");
    check(&[&log, "--csv", "--mcap", "-o", "x"], "cannot be used with");
    check(&[&log, "--mcap"], "--output <FILE>");
    check(&[&log, "--csv=wings"], "possible values: behaviors, resources, commands, rounds, world");
    check(&[&log, "--csv", "-o", &log], "would be written over with what is made of it");
    check(&[&log, "--csv", "-o", "/none/x.csv"], "cannot write /none/x.csv: there is no folder /none");
    check(&[&log, "--csv", "-o", "/dev/full"], "cannot write /dev/full");
    check(&["no-such-log", "--csv"], "there is no log `no-such-log`");
    let records = fs::read_to_string(&log).expect("a log").lines().count();
    let cut = fs::read(&log).expect("a log");
    let cut = home.write("cut.jsonl", &String::from_utf8_lossy(&cut[..cut.len() - 20]));
    let finished = home.start(["export", cut.to_str().expect("UTF-8"), "--chrome-trace"]).ends(0);
    assert_eq!(finished.words(), format!("the log was cut off in its last line; {} records read", records - 1));
    assert!(serde_json::from_str::<Value>(&finished.stdout).is_ok());
}
