//! Every key that is described is read: misspelt, given a wrong value or left out where it must be, it is told.

use std::collections::BTreeSet;
use std::path::Path;

use super::super::document::{Located, Node, Value, parse};
use super::super::format::Format;
use super::super::shape::{Form, Shape};
use super::super::{InMemory, check, load_task, load_world};

const MISSION: &str = "\
mission: everything
robot: robot.yaml
bypass: 3
include: [library.yaml]
parameters: {thing: {type: object, default: cup}}
behaviors:
  scan:
    label: scan $area $effort
    parameters: {area: {type: place, default: shelf}, what: object, by: offset, effort: number}
    claims:
      eye: {type: head, shared: at $area, keep: {for: at $area}}
      one: {resource: left, empty: true}
      two: {resource: right, reaches: $what, keep: physical}
      none: {type: antenna, optional: true}
      reader: {type: reader}
    potential: {constant: $effort, scale_by: gripper}
    goal: [{fact: clean}, {not_fact: dusty}, {at: {place: $area, offset: $by}}, {held: $what}]
    precondition: [{path: $area}, {free: $what}, {lies: {object: $what, at: $area}}]
    effects: [{set: clean}, {clear: dusty}, {taken: {object: $what, by: one}}]
    commands:
      - {claim: eye, maintain: {look_at: $area}}
      - {claim: one, achieve: {grasp: $what}}
      - {claim: reader, achieve: {call: read, with: {what: $what, how: 2}}}
    takes: 3 s
    timeout: 5 s
    retries: 1
    backoff: 1 s
    while: [{not_fact: dusty}]
    interruptible: false
  lay:
    parameters: {what: object, where: place}
    claims: {hand: {type: gripper, holds: $what}, base: {type: base, keep: {for: there}, shared: there}}
    potential: {table: {by: $what, values: {cup: 3}, otherwise: 1}}
    effects: [{lies: {object: $what, at: $where}}]
    commands:
      - {claim: hand, achieve: {put: {object: $what, at: $where}}}
      - {claim: base, achieve: {drive_to: $where}}
  wait: {potential: {nearness: shelf}, claims: all}
  pass:
    parameters: {what: object}
    claims:
      from: {resource: left, holds: $what}
      to: {resource: right, reaches: $what, keep: physical}
    potential: 1
    goal: [{held: {object: $what, resource: right, alone: true}}]
    precondition: [{held: {object: $what, hands: 1, type: gripper}}]
    effects: [{taken: {object: $what, by: to}}, {let_go: {object: $what, by: from}}]
    commands:
      - {claim: to, achieve: {grasp: {object: $what, from: from}}}
      - {claim: from, achieve: {put: {object: $what, into: to}}}
subtrees:
  twice: {parameters: {first: place}, task: {and: [{move: $first}, {move: $first}]}}
world:
  tolerance: 0.3 m
  distance: path
  robot: {at: [0, 0], heading: 90 deg}
  places:
    shelf: {stand: [1, 2], heading: 0 deg, surface: [0.5, 0, 0.7]}
    table: {stand: [3, 2]}
    desk: {table: {at: [-3, 2], heading: 90 deg, size: [1, 0.5, 0.7], side: left}}
    bench: {table: {at: [-3, 5], size: [1, 0.5, 0.7], stands: {near: {side: front}, far: {side: back, along: 0.1}}}}
  objects:
    cup: {at: shelf, offset: [0, 0.1, 0], heading: 10 deg, shape: {cylinder: {radius: 4 cm, height: 8 cm}}, grasps: [above]}
    pot: {held: [left, tray]}
    box: {at: desk, shape: {box: [0.1, 0.1, 0.1]}}
  walls: [{from: [9, -9], to: [9, 9], thickness: 20 cm}]
  obstacles: [{min: [5, 5], max: [6, 6]}, {at: [7, 7], size: [1, 1], heading: 10 deg}]
  facts: {clean: {holds: false, outside: yes}, dusty: true}
task:
  then:
    - use: {twice: shelf}
    - or: [{move: shelf}, {wait: , name: rest, retries: 2, backoff: 2 s, timeout: 1 min}]
    - {pick: $thing, priority: 2, cleanup: {wait: }}
    - {place: {object: cup, at: table}, repeat: 2, every: 5 s}
";
const WORLD: &str = "\
mission: room
robot: robot.yaml
bypass: 3
include: [library.yaml]
parameters: {thing: object}
behaviors: {wipe: {potential: 1}}
subtrees: {tidy: {task: {wipe: }}}
world:
  robot: {at: [0, 0]}
  places: {shelf: {stand: [1, 2]}}
  objects: {cup: {at: shelf}}
task: nothing
";
const TASK: &str = "\
mission: errand
robot: robot.yaml
bypass: 3
include: [library.yaml]
parameters: {thing: {type: object, default: cup}}
behaviors: {dust: {potential: 1}}
subtrees: {clean: {task: {dust: }}}
world:
  robot: {at: [0, 0]}
  places: {shelf: {stand: [5, 5]}}
task: {then: [{use: tidy}, {use: clean}, {move: shelf}, {pick: $thing}]}
";
const LIBRARY: &str = "\
library: small
include: [more.yaml]
behaviors: {rest: {potential: 0.5}}
subtrees: {nap: {task: {rest: }}}
";
const ROBOT: &str = "\
robot: small
radius: 0.3 m
resources:
  left: {type: gripper, controller: left_arm}
  right: {type: gripper, controller: right_arm}
  eyes: {type: head, controller: neck}
  base: {type: base, controller: wheels}
  reader: {type: reader, controller: reader}
  tray: {type: slot, at: [0.1, 0, 0.5]}
controllers:
  left_arm:
    arm: {shoulder: [0, 0, 0.8], tuck: [0.3, 0, 0.9], reach: 0.9, speed: 0.5, acceleration: 1, grip: 1 s, lift: 10 cm, cancel_grace: 2 s, calls: {wave: {takes: 1 s}}, reports: {facts: [clean], objects: [cup]}}
  right_arm:
    arm: {shoulder: [0, 0, 0.8], tuck: [0.3, 0, 0.9], hand: 0.1, reach: 0.9, speed: 0.5, acceleration: 1, grip: 1 s, lift: 10 cm, radius: 5 cm, cancel_grace: 2 s}
  neck: {head: {neck: [0, 0, 1.2], speed: 90 deg/s, acceleration: 90 deg/s^2, cancel_grace: 2 s, calls: {nod: {takes: 1 s}}, reports: {facts: [clean]}}}
  wheels: {base: {speed: 1, acceleration: 1, turn_speed: 1, turn_acceleration: 1, cancel_grace: 2 s, calls: {honk: {takes: 1 s}}, reports: {objects: [cup]}}}
  reader: {device: {cancel_grace: 2 s, reports: {facts: [clean]}, calls: {read: {parameters: {what: object, how: number}, takes: 2 s}}}}
";

const FAILURES: &str = "\
failures:
  - {at: 1 s, lose: left_arm}
  - {at: 2 s, return: left_arm}
  - {at: 3 s, hang: wheels}
  - {at: 3 s, inhibit: neck}
  - {at: 4 s, disk: full}
  - {behavior: rest, attempt: 9, late: 2 s}
  - {at: 4 s, set: clean}
  - {at: 5 s, clear: dusty}
  - {at: 6 s, lies: {object: cup, at: shelf}}
  - {at: 6 s, block: {min: [2, 4], max: [3, 5]}}
  - {at: 6 s, unblock: [2.5, 4.5]}
  - {behavior: rest, attempt: every, fails: aborted}
  - {behavior: rest, attempt: 2, hangs: true}
  - {behavior: rest, drops: all}
  - {at: 7 s, cancel: true}
";

/// One key in one map of a file.
#[derive(Debug)]
struct Use {
    what: &'static str,
    key: &'static str,
    is_required: bool,
    /// Which entry of which map leads to it, from the top.
    way: Vec<usize>,
}

fn files() -> InMemory {
    let mut files = InMemory::default();
    for (path, text) in [
        ("mission.yaml", MISSION),
        ("library.yaml", LIBRARY),
        ("robot.yaml", ROBOT),
        ("world.yaml", WORLD),
        ("more.yaml", "library: more\nbehaviors: {more: {potential: 1}}\n"),
    ] {
        files.insert(path, text);
    }
    files
}

/// Every key of a file as its description calls it.
fn uses(form: &Form, node: &Node, way: &mut Vec<usize>, found: &mut Vec<Use>) {
    match (form, &node.value) {
        (Form::Map(shape), Value::Map(entries)) => {
            for (index, (key, value)) in entries.iter().enumerate() {
                let known = shape().others.iter().flat_map(|others| &others.known);
                let mut fields = shape().fields.iter().chain(known);
                let Some(field) = fields.find(|field| field.key == key.value) else { continue };
                way.push(index);
                found.push(Use {
                    what: shape().what,
                    key: field.key,
                    is_required: field.is_required,
                    way: way.clone(),
                });
                uses(&field.form, value, way, found);
                way.pop();
            }
        }
        (Form::Each(inner), Value::Map(entries)) => {
            for (index, (_, value)) in entries.iter().enumerate() {
                way.push(index);
                uses(inner, value, way, found);
                way.pop();
            }
        }
        (Form::List(inner), Value::List(items)) => {
            for (index, item) in items.iter().enumerate() {
                way.push(index);
                uses(inner, item, way, found);
                way.pop();
            }
        }
        (Form::Either(forms), _) => forms.iter().for_each(|form| uses(form, node, way, found)),
        _ => {}
    }
}

/// A file in which the key at the end of a way becomes another, or is left out.
fn with(node: &Node, way: &[usize], change: &dyn Fn(&str, &str) -> Option<String>) -> String {
    let next = |index| way.split_first().filter(|(at, _)| **at == index).map(|(_, rest)| rest);
    match &node.value {
        Value::Null => "null".to_owned(),
        Value::Scalar { text, number: Some(_) } => text.clone(),
        Value::Scalar { text, .. } => serde_json::to_string(text).unwrap(),
        Value::List(items) => {
            // What is not on the way has none.
            let items = items.iter().enumerate().map(|(index, item)| with(item, next(index).unwrap_or(&[99]), change));
            format!("[{}]", items.collect::<Vec<_>>().join(", "))
        }
        Value::Map(entries) => {
            let entry = |(index, (key, value)): (usize, &(Located<String>, Node))| {
                let written = with(value, next(index).unwrap_or(&[99]), change);
                let quoted = serde_json::to_string(&key.value).unwrap();
                if next(index) == Some(&[]) {
                    change(&key.value, &written)
                } else {
                    Some(format!("{quoted}: {written}"))
                }
            };
            let entries: Vec<_> = entries.iter().enumerate().filter_map(entry).collect();
            format!("{{{}}}", entries.join(", "))
        }
    }
}

/// Every key that a format can have.
fn described(shape: &'static Shape, found: &mut BTreeSet<(&'static str, &'static str)>) {
    let known = shape.others.iter().flat_map(|others| &others.known);
    for field in shape.fields.iter().chain(known) {
        if found.insert((shape.what, field.key)) {
            described_by(&field.form, found);
        }
    }
}

fn described_by(form: &Form, found: &mut BTreeSet<(&'static str, &'static str)>) {
    match form {
        Form::Map(shape) => described(shape(), found),
        Form::List(inner) | Form::Each(inner) => described_by(inner, found),
        Form::Either(forms) => forms.iter().for_each(|form| described_by(form, found)),
        Form::Word | Form::Words(_) | Form::Flag | Form::Count(_) | Form::Whole(_) | Form::Quantity(_) => {}
        Form::Vector(..) | Form::Arguments => {}
    }
}

/// What is said of a file where it is used: each fault with its key.
fn said(path: &Path, format: Format, text: String) -> Vec<(String, String)> {
    let mut files = files();
    let robot = Path::new("robot.yaml");
    let base = (format == Format::Task).then(|| load_world(&files, robot, "world.yaml".as_ref(), &[]).unwrap().mission);
    files.insert(path, text);
    let error = match (format, base) {
        (Format::World, _) => load_world(&files, robot, path, &[]).err(),
        (_, Some(base)) => load_task(&files, path, &[], &base, &base.start).err(),
        (_, None) => check(&files, path, &[]).err(),
    };
    let faults = error.iter().flat_map(|error| error.faults());
    faults.map(|fault| (fault.key().to_owned(), fault.to_string())).collect()
}

#[test]
fn every_described_key_is_read() {
    let (mut all, mut tried) = (BTreeSet::new(), BTreeSet::new());
    let mut wrong = Vec::new();
    for (path, text, format) in [
        ("mission.yaml", MISSION, Format::Mission),
        ("world.yaml", WORLD, Format::World),
        ("task.yaml", TASK, Format::Task),
        ("library.yaml", LIBRARY, Format::Behaviors),
        ("robot.yaml", ROBOT, Format::Robot),
        ("failures.yaml", FAILURES, Format::Failures),
    ] {
        described(format.shape(), &mut all);
        let (path, node) = (Path::new(path), parse(0, text).unwrap());
        assert_eq!(said(path, format, with(&node, &[], &|_, _| None)), [], "{path:?}");
        let mut found = Vec::new();
        uses(
            &Form::Map(match format {
                Format::Mission => || Format::Mission.shape(),
                Format::World => || Format::World.shape(),
                Format::Task => || Format::Task.shape(),
                Format::Behaviors => || Format::Behaviors.shape(),
                Format::Robot => || Format::Robot.shape(),
                Format::Failures => || Format::Failures.shape(),
            }),
            &node,
            &mut Vec::new(),
            &mut found,
        );
        for Use { what, key, is_required, way } in &found {
            let misspelt = said(path, format, with(&node, way, &|key, value| Some(format!("{key}zz: {value}"))));
            if !misspelt.iter().any(|(found, _)| *found == format!("{key}zz")) {
                wrong.push(format!("{what}: {key} misspelt: {misspelt:?}"));
            }
            let bad = said(path, format, with(&node, way, &|key, _| Some(format!("{key}: [[1]]"))));
            if !bad.iter().any(|(found, _)| found == key) {
                wrong.push(format!("{what}: {key} with a wrong value: {bad:?}"));
            }
            let lacks = format!("{what} lacks the key `{key}`");
            let left_out = said(path, format, with(&node, way, &|_, _| None));
            // Without that key nobody can tell what the file is.
            let is_sign = ["library", "failures"].contains(key);
            let lacks = if is_sign { "a mission lacks the key `mission`" } else { &lacks };
            if left_out.iter().any(|(_, said)| said.contains(lacks)) != *is_required {
                wrong.push(format!("{what}: {key} left out: {left_out:?}"));
            }
        }
        tried.extend(found.iter().map(|Use { what, key, .. }| (*what, *key)));
    }
    assert_eq!(tried, all, "keys that no file here has");
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
