//! The auditor: logs of real runs come clean, and a planted fault of each kind is found.

use std::collections::BTreeMap;
use std::sync::Arc;

use ambidex::model::motion::FromController as Said;
use ambidex::model::{
    Access, Change, CommandId, ControllerId, ControllerMessage, ControllerState, Failures, FromController, Grant,
    Labels, Location, Loss, Mishap, MissionEnd, MissionSpec, Name, Origin, PartEnd, PlaceId, Record, Service, Time,
    ToController,
};
use ambidex::record::audit::{Audit, AuditReport, OwnEvent, OwnLine, OwnRecords, Rule};
use ambidex::sim::{self, Chance};
use ambidex::tree::Settings;
use nalgebra::{Point3, Vector3};

use crate::fixtures::{file, load, simulate_failures};
use crate::home::Home;

fn run(mission: &str) -> (Arc<MissionSpec>, Vec<Record>) {
    let mission = load(&file(&format!("config/missions/{mission}.yaml")));
    let records = simulate_failures(&mission, &Failures::default()).1;
    (mission, records)
}

fn audit(mission: &Arc<MissionSpec>, records: &[Record], own: Option<&OwnRecords>) -> AuditReport {
    let Record::Header(header) = &records[0] else { panic!("a log begins with a header") };
    let mut audit = Audit::new(header, Some(Arc::clone(mission)));
    records.iter().for_each(|record| audit.take(record));
    audit.finish(own, true)
}

/// Plants a fault into the log of experiment 1; it is found as one of its rule, in a sentence with these words.
fn finds(rule: Rule, words: &str, plant: impl FnOnce(&mut Vec<Record>)) {
    let (mission, mut records) = run("experiment-1");
    assert_eq!(audit(&mission, &records, None).findings, []);
    plant(&mut records);
    let findings = audit(&mission, &records, None).findings;
    let is_meant = |said: &str| said.contains(words);
    assert!(findings.iter().any(|found| found.rule == rule && is_meant(&found.said)), "{words}: {findings:#?}");
}

fn position(records: &[Record], is_meant: impl Fn(&Record) -> bool) -> usize {
    records.iter().position(is_meant).expect("the log has it")
}

/// The grant of a behavior, by its name.
fn granting(records: &[Record], name: &str) -> usize {
    let Record::Header(header) = &records[0] else { panic!("a log begins with a header") };
    let names = header.names.clone();
    let is_of = |grant: &Grant| names.node(grant.leaf()) == name;
    position(records, |record| matches!(record, Record::Decided { granted, .. } if granted.iter().any(is_of)))
}

fn releasing(records: &[Record], name: &str) -> usize {
    let Record::Header(header) = &records[0] else { panic!("a log begins with a header") };
    let names = header.names.clone();
    position(records, |record| matches!(record, Record::Released { leaf, .. } if names.node(*leaf) == name))
}

fn grants(record: &mut Record) -> &mut Vec<Grant> {
    let Record::Decided { granted, .. } = record else { panic!("it grants") };
    granted
}

#[test]
fn two_owners_are_found() {
    finds(Rule::Owners, "is granted to pick 2 and serves pick 1", |records| {
        let at = granting(records, "pick 1");
        let granted = grants(&mut records[at]);
        assert_eq!(granted.len(), 2, "both are picked at once");
        let hand = |grant: &Grant| grant.bindings.iter().position(|bound| bound.access == Access::Exclusive).unwrap();
        let (one, two) = (hand(&granted[0]), hand(&granted[1]));
        granted[1].bindings[two].resource = granted[0].bindings[one].resource;
    });
    finds(Rule::Owners, "runs already", |records| {
        let at = granting(records, "pick 1");
        let twice = records[at].clone();
        records.insert(at + 1, twice);
    });
    finds(Rule::Owners, "run at once in the THEN", |records| {
        let (later, at) = (granting(records, "place 1"), granting(records, "pick 1"));
        let place = grants(&mut records[later].clone())[0].clone();
        grants(&mut records[at]).push(place);
    });
}

#[test]
fn what_is_granted_though_it_is_away_is_found() {
    finds(Rule::Available, "base is granted to", |records| {
        let at = granting(records, "place 1");
        let Record::Header(header) = &records[0] else { panic!("a log begins with a header") };
        let base = header.names.resources.iter().position(|name| name == "base").unwrap().into();
        let since = records[at].at();
        let service = Service::Unavailable { why: Loss::Hung, since };
        let gone = Record::Served { at: since, controller: ControllerId(0), resources: vec![base], service };
        records.insert(at, gone);
    });
}

#[test]
fn what_is_done_twice_is_found() {
    finds(Rule::Twice, "place 1 is granted again", |records| {
        let (at, after) = (granting(records, "place 1"), releasing(records, "place 1"));
        let mut again = records[at].clone();
        again.set_at(records[after].at());
        records.insert(after + 1, again);
    });
}

#[test]
fn lost_and_doubled_objects_are_found() {
    finds(Rule::Objects, "something else is put there", |records| {
        let (one, two) = (releasing(records, "pick 1"), releasing(records, "pick 2"));
        let taken = |record: &Record| match record {
            Record::Released { changes, .. } => changes.iter().find_map(|change| match change {
                Change::Taken(_, by) => Some(*by),
                _ => None,
            }),
            _ => None,
        };
        let (first, second) = (one.min(two), one.max(two));
        let full = taken(&records[first]).expect("it takes something");
        let Record::Released { changes, .. } = &mut records[second] else { panic!("it ends") };
        for change in changes {
            if let Change::Taken(_, by) = change {
                *by = full;
            }
        }
    });
    finds(Rule::Objects, "is not where it was to bring it", |records| {
        let at = releasing(records, "place 1");
        let Record::Released { changes, .. } = &mut records[at] else { panic!("it ends") };
        changes.clear();
    });
    finds(Rule::Objects, "moved from outside while it is held", |records| {
        let at = releasing(records, "pick 1");
        let Record::Released { changes, at: moment, .. } = &records[at] else { panic!("it ends") };
        let object = changes.iter().find_map(|change| match change {
            Change::Taken(object, _) => Some(*object),
            _ => None,
        });
        let place = Location::At(PlaceId(0));
        let change = Change::Object(object.expect("it takes something"), place);
        let moved = Record::World { at: *moment, change, origin: Origin::Operator };
        records.insert(at + 1, moved);
    });
}

#[test]
fn refusals_without_reasons_are_found() {
    finds(Rule::Reasons, "without a reason", |records| {
        let at = position(records, |record| record.refusals().len() > 1);
        let Record::Decided { refused, .. } = &mut records[at] else { panic!("it refuses") };
        refused.pop();
    });
    finds(Rule::Reasons, "nobody is told why", |records| {
        records.iter_mut().for_each(Record::forget_refusals);
        for record in records.iter_mut() {
            if let Record::Ended { end, .. } = record {
                *end = MissionEnd::Stalled;
            }
        }
    });
}

#[test]
fn time_that_goes_backwards_is_found() {
    finds(Rule::Time, "stands behind a line of", |records| {
        let last = records.len() - 1;
        records[last].set_at(Time(1));
    });
}

#[test]
fn commands_that_are_told_twice_or_never_end_are_found() {
    let is_goal = |record: &Record| {
        matches!(
            record,
            Record::Controller { message: ControllerMessage::Told { message: ToController::Goal { .. }, .. }, .. }
        )
    };
    let is_result = |record: &Record| {
        matches!(
            record,
            Record::Controller { message: ControllerMessage::Heard { message: FromController::Result { .. } }, .. }
        )
    };
    finds(Rule::Commands, "twice", |records| {
        let at = position(records, is_goal);
        let twice = records[at].clone();
        records.insert(at, twice);
    });
    finds(Rule::Commands, "never ends", |records| drop(records.remove(position(records, is_result))));
    finds(Rule::Commands, "which is not under way", |records| {
        let at = position(records, is_result);
        let twice = records[at].clone();
        records.insert(at + 1, twice);
    });
    finds(Rule::Commands, "which does not run", |records| {
        let (at, after) = (position(records, is_goal), records.len() - 1);
        let mut late = records[at].clone();
        late.set_at(records[after].at());
        let Record::Controller { message: ControllerMessage::Told { message, .. }, .. } = &mut late else { return };
        let ToController::Goal { id, .. } = message else { return };
        id.number += 1000;
        records.push(late);
    });
}

#[test]
fn an_end_that_is_missing_or_leaves_something_is_found() {
    finds(Rule::End, "there is no end", |records| {
        let at = position(records, |record| matches!(record, Record::Ended { .. }));
        records.truncate(at);
    });
    finds(Rule::End, "is still held", |records| {
        let end = position(records, |record| matches!(record, Record::Ended { .. }));
        let held = |record: &&Record| matches!(record, Record::Resource { state, .. } if state.is_locked());
        let mut held = records[..end].iter().find(held).expect("something is held").clone();
        held.set_at(records[end].at());
        records.insert(end, held);
    });
    let (mission, mut records) = run("experiment-1");
    records.truncate(granting(&records, "pick 1") + 1);
    let report = audit(&mission, &records, None);
    assert_eq!((report.findings, report.open.as_deref()), (Vec::new(), Some("pick 1 and pick 2 runs")));
}

/// What a controller said, in its own words.
fn named(message: &FromController, labels: &Labels) -> Said {
    match *message {
        FromController::Configured { generation, state } => Said::Configured { generation, state: labels.named(state) },
        FromController::Accepted { id, at } => Said::Accepted { id, at },
        FromController::Rejected { id, why } => Said::Rejected { id, why },
        FromController::Feedback { id, progress, state } => Said::Feedback { id, progress, state: labels.named(state) },
        FromController::Result { id, end, began, ended, state } => {
            Said::Result { id, end, began, ended, state: labels.named(state) }
        }
    }
}

/// Own records that fit to a log, each result with the state that it told.
fn own_lines(records: &[Record]) -> BTreeMap<String, Vec<OwnLine>> {
    let Record::Header(header) = &records[0] else { panic!("a log begins with a header") };
    let mut lines: BTreeMap<String, Vec<OwnLine>> = BTreeMap::new();
    for record in records {
        let Record::Controller { at, controller, message: ControllerMessage::Heard { message } } = record else {
            continue;
        };
        let message = named(message, &Labels::new(&header.names));
        let line = OwnLine { at_ns: at.0 * 1000, pid: 1, event: OwnEvent::Said(message) };
        lines.entry(header.names.controller(*controller).to_owned()).or_default().push(line);
    }
    for lines in lines.values_mut() {
        lines.push(OwnLine { at_ns: u64::MAX, pid: 1, event: OwnEvent::Ended });
    }
    lines
}

fn own(lines: &BTreeMap<String, Vec<OwnLine>>) -> OwnRecords {
    let mut own = OwnRecords::default();
    for (name, lines) in lines {
        let text: String = lines.iter().map(|line| serde_json::to_string(line).expect("it is plain") + "\n").collect();
        own.read(name, text.as_bytes()).expect("a record");
    }
    own
}

#[test]
fn own_records_that_say_otherwise_are_found() {
    let (mission, records) = run("experiment-1");
    let lines = own_lines(&records);
    assert_eq!(audit(&mission, &records, Some(&own(&lines))).findings, []);
    let finds = |words: &str, plant: &dyn Fn(&mut Vec<OwnLine>)| {
        let mut lines = lines.clone();
        plant(lines.get_mut("left_arm").expect("an arm"));
        let findings = audit(&mission, &records, Some(&own(&lines))).findings;
        let is_found = findings.iter().any(|found| found.rule == Rule::Records && found.said.contains(words));
        assert!(is_found, "{words}: {findings:#?}");
    };
    let is_result = |line: &OwnLine| matches!(&line.event, OwnEvent::Said(Said::Result { .. }));
    let is_accepted = |line: &OwnLine| matches!(&line.event, OwnEvent::Said(Said::Accepted { .. }));
    let of_other = lines["right_arm"].iter().filter_map(|line| match &line.event {
        OwnEvent::Said(message) => message.state(),
        _ => None,
    });
    let other_holds: Option<Name> = of_other.filter_map(|state| state.holds()).next();
    assert!(other_holds.is_some(), "the other arm takes something");
    finds("which never said it", &|lines| {
        let at = lines.iter().position(is_result).unwrap();
        lines.remove(at);
    });
    finds("as the end of command", &|lines| {
        let at = lines.iter().position(is_result).unwrap();
        if let OwnEvent::Said(Said::Result { end, .. }) = &mut lines[at].event {
            *end = PartEnd::Aborted;
        }
    });
    finds("twice", &|lines| {
        let at = lines.iter().position(is_accepted).unwrap();
        lines.insert(at, lines[at].clone());
    });
    finds("which the log does not know", &|lines| {
        let at = lines.iter().position(is_accepted).unwrap();
        if let OwnEvent::Said(Said::Accepted { id, .. }) = &mut lines[at].event {
            *id = CommandId { generation: 9, number: 9 };
        }
    });
    finds("in the hands of", &|lines| {
        let holds = other_holds;
        let state = ControllerState::Arm { gripper: Point3::origin(), velocity: Vector3::zeros(), holds };
        let said = OwnEvent::Said(Said::Configured { generation: 1, state });
        let first = OwnLine { at_ns: 0, pid: 1, event: said };
        lines.insert(0, first);
        lines.iter_mut().for_each(|line| {
            if let OwnEvent::Said(Said::Feedback { state: other, .. } | Said::Result { state: other, .. }) =
                &mut line.event
            {
                *other = state;
            }
        });
    });
    finds("time goes backwards", &|lines| lines.last_mut().expect("a line").at_ns = 0);
}

#[test]
fn whatever_goes_wrong_the_auditor_finds_nothing() {
    let mut looked_at = 0;
    for name in ["experiment-1", "battery", "tray", "pass-on", "crate", "door", "patrol", "put-down"] {
        let mission = load(&file(&format!("config/missions/{name}.yaml")));
        let end = (Time(400_000_000), Mishap::Cancel);
        let failures = Failures { mishaps: vec![end], flaws: Vec::new() };
        for seed in 0..8 {
            let mut records = Vec::new();
            let mut take = |record: &Record| records.push(record.clone());
            let chance = Chance { probability: 0.15, seed };
            sim::simulate_chance(&mission, &Settings::default(), &failures, chance, &mut take);
            let report = audit(&mission, &records, None);
            assert_eq!(report.findings, [], "{name}, seed {seed}");
            looked_at += report.looked_at.goals;
        }
    }
    assert!(looked_at > 200, "only {looked_at} goals were looked at");
}

#[test]
fn the_verb_says_what_holds_and_what_does_not() {
    let home = Home::new();
    let mission = file("config/missions/experiment-1.yaml");
    let log = home.path("run.jsonl");
    home.start(["simulate".as_ref(), mission.as_os_str(), "--log".as_ref(), log.as_os_str()]).ends(0);
    let said = home.start(["audit".as_ref(), log.as_os_str()]).ends(0).stdout;
    assert!(said.contains("✓ twice      nothing is done twice while its goal holds"), "{said}");
    assert!(said.contains("looked at ") && !said.contains('✗'), "{said}");
    let text = std::fs::read_to_string(&log).expect("a log");
    let without_result: Vec<&str> = text.lines().collect();
    let at = without_result.iter().position(|line| line.contains("\"result\"")).expect("a result");
    let planted: String = without_result
        .iter()
        .enumerate()
        .filter(|(line, _)| *line != at)
        .map(|(_, line)| format!("{line}\n"))
        .collect();
    std::fs::write(&log, planted).expect("a log");
    let said = home.start(["audit".as_ref(), log.as_os_str()]).ends(1).stdout;
    assert!(said.contains("✗ commands") && said.contains("never ends"), "{said}");
    home.start(["audit".as_ref(), "--json".as_ref(), log.as_os_str()]).ends(1);
    home.start(["audit".as_ref(), log.as_os_str(), "--records".as_ref(), home.path("none").as_os_str()]).ends(2);
    home.is_empty();
}
