//! What is wrong about objects in several hands, each with the line and the words that it is told with.

use super::super::FilesError;
use super::{GOOD, load, robot};

/// A robot with two hands, a scanner, and two slots of which one has no position.
fn small() -> String {
    let slots = "  crate: {type: slot, at: [-0.3, 0, 0.6]}\n  hook: {type: hook}\n  scanner: {type: scanner, controller: laser}\n";
    let scanner = "  laser: {device: {calls: {scan: {takes: 1 s}}}}\n";
    robot(2).replace("controllers:\n", &format!("{slots}controllers:\n{scanner}"))
}

fn said(loaded: Result<std::sync::Arc<ambidex_model::MissionSpec>, FilesError>) -> Vec<String> {
    let error = loaded.err();
    let faults = error.iter().flat_map(|error| error.faults()).filter(|fault| !fault.is_warning());
    faults
        .map(|fault| {
            let line = fault.position().map_or(0, |at| at.0);
            format!("{line}:{fault} {}", fault.help().unwrap_or_default())
        })
        .collect()
}

/// What is said of a kind whose node is the task; none where nothing is wrong.
fn check_kind(kind: &str, expected: Option<&str>) {
    let head = &GOOD[..GOOD.find("task:").unwrap()];
    let said = said(load(&format!("{head}behaviors:\n  it: {kind}\ntask: it\n"), &small()));
    match expected {
        None => assert!(said.is_empty(), "{kind}: {said:#?}"),
        Some(words) => {
            let is_found = said
                .iter()
                .any(|fault| (fault.starts_with("13:") || fault.starts_with("14:it")) && fault.contains(words));
            assert!(is_found && said.len() == 1, "{kind}: expected `{words}` alone, on line 13, in {said:#?}");
        }
    }
}

const TWO: &str = "{a: {resource: hand, holds: cup}, b: {resource: hand1, reaches: cup, keep: physical}}";
const BOTH: &str = "{a: {type: gripper, holds: cup}, b: {type: gripper, holds: cup}}";

#[test]
fn whoever_holds_something_hears_of_it() {
    let kind = |claims: &str, effects: &str, commands: &str| {
        format!("{{claims: {claims}, potential: 1, effects: [{effects}], commands: [{commands}]}}")
            .replace(", commands: []", "")
    };
    let one = "{a: {type: gripper, empty: true, keep: physical}}";
    let taken = "{taken: {object: cup, by: a}}";
    check_kind(&kind(one, taken, "{claim: a, achieve: {grasp: cup}}"), None);
    let untold = "taken: controller `arm` of the claim `a` hears nothing of `cup` add to `commands`: \
                  `{claim: a, achieve: {grasp: cup}}`";
    check_kind(&kind(one, taken, ""), Some(untold));
    check_kind(&kind(one, taken, "{claim: a, achieve: {grasp: pot}}"), Some(untold));
    check_kind(&kind(one, taken, "{claim: a, maintain: stand}"), Some(untold));
    let (lies, put) = ("{lies: {object: cup, at: table}}", "{claim: a, achieve: {put: {object: cup, at: table}}}");
    check_kind(&kind(BOTH, lies, &format!("{put}, {}", put.replace("claim: a", "claim: b"))), None);
    let untold = "lies: controller `arm` of the claim `b` hears nothing of `cup` add to `commands`: \
                  `{claim: b, achieve: {put: {object: cup, at: table}}}`";
    check_kind(&kind(BOTH, lies, put), Some(untold));
    let let_go = "{let_go: {object: cup, by: a}}";
    let put = "{claim: a, achieve: {put: {object: cup, into: b}}}";
    check_kind(&kind(BOTH, let_go, put), None);
    let untold = "let_go: controller `arm` of the claim `a` hears nothing of `cup` add to `commands`: \
                  `{claim: a, achieve: {put: {object: cup, into: b}}}`";
    check_kind(&kind(BOTH, let_go, ""), Some(untold));
    // A slot hears nothing, and need not.
    let slot = "{a: {type: slot, empty: true, keep: physical}, b: {type: gripper, holds: cup}}";
    let stowed = "{taken: {object: cup, by: a}}, {let_go: {object: cup, by: b}}";
    check_kind(&kind(slot, stowed, "{claim: b, achieve: {put: {object: cup, into: a}}}"), None);
    let scanner = "{a: {type: scanner}}";
    check_kind(&kind(scanner, taken, ""), Some("taken: controller `laser` moves a device, which cannot hold"));
}

#[test]
fn something_holds_what_is_let_go() {
    let kind = |more: &str| {
        format!(
            "{{claims: {{a: {{type: gripper, holds: cup}}, b: {{type: gripper, empty: true}}}}, potential: 1, effects: [{{let_go: \
             {{object: cup, by: a}}}}], commands: [{{claim: a, achieve: {{put: {{object: cup, into: b}}}}}}]{more}}}"
        )
    };
    let falls = "let_go: nothing need hold `cup` then, so that it could fall claim what holds it too, write \
                 `held: {object: cup, hands: 2}` as a precondition";
    check_kind(&kind(""), Some(falls));
    check_kind(&kind(", precondition: [{held: cup}]"), Some(falls));
    check_kind(&kind(", precondition: [{held: {object: cup, hands: 2}}]"), None);
}

#[test]
fn from_and_into_are_claims_with_a_place() {
    let kind = |claims: &str, command: &str| {
        format!(
            "{{claims: {claims}, potential: 1, effects: [{{taken: {{object: cup, by: b}}}}], commands: [{{claim: b, achieve: {command}}}]}}"
        )
    };
    check_kind(&kind(TWO, "{grasp: {from: a}}"), None);
    check_kind(&kind(TWO, "{grasp: {object: cup, from: a}}"), None);
    check_kind(&kind(TWO, "{grasp: {object: pot, from: a}}"), Some("object: the claim `a` holds another object"));
    check_kind(&kind(TWO, "{grasp: {from: c}}"), Some("from: there is no claim `c` allowed: `a`, `b`"));
    check_kind(&kind(TWO, "{grasp: {object: cup}}"), Some("a grasp lacks the key `from`"));
    let empty = TWO.replace("holds: cup", "empty: true");
    check_kind(&kind(&empty, "{grasp: {from: a}}"), Some("`a` is no claim on what holds an object"));
    let put = |to: &str| {
        let claims = "{a: {type: gripper, holds: cup}, b: {type: gripper, holds: cup}, hook: {type: hook}, eye: {type: scanner}}";
        format!("{{claims: {claims}, potential: 1, commands: [{{claim: b, achieve: {{put: {{object: cup, {to}}}}}}}]}}")
    };
    check_kind(&put("into: a"), None);
    check_kind(&put("into: b"), Some("put: `b` is the hand itself"));
    check_kind(&put("into: hook"), Some("put: nothing tells where `hook` is give it a position in the robot file"));
    check_kind(&put("into: eye"), Some("put: `scanner` holds nothing, since no arm moves it"));
    check_kind(
        &put("into: a, at: table"),
        Some("a put that is 2 things instead of one write exactly one of: at, into"),
    );
    let missing = put("").replace("cup, }", "cup}");
    check_kind(&missing, Some("a put that does not say what it is"));
}

#[test]
fn how_it_is_held_makes_sense() {
    let kind = |held: &str| format!("{{claims: {{}}, potential: 1, precondition: [{{held: {held}}}]}}");
    check_kind(&kind("cup"), None);
    check_kind(&kind("{object: cup, hands: 2}"), None);
    check_kind(&kind("{object: cup, hands: 0}"), Some("held: held by nobody"));
    check_kind(&kind("{object: cup, hands: 5}"), Some("hands: "));
    check_kind(&kind("{object: cup, resource: hand, hands: 2}"), Some("held: one resource is one hand"));
    check_kind(&kind("{object: cup, resource: hand, type: gripper}"), Some("held: held by a `type` or by one"));
    check_kind(&kind("{object: cup, resource: hnad}"), Some("did you mean `hand`?"));
    check_kind(&kind("{object: cup, type: griper}"), Some("the robot has no resource of type `griper`"));
}

#[test]
fn what_is_held_at_the_start_is_held_by_what_can() {
    let check = |cup: &str, pot: &str, expected: Option<&str>| {
        let objects = GOOD.replace("cup: {at: shelf, offset: [0, 0.1]}", &format!("cup: {cup}"));
        let head = objects[..objects.find("task:").unwrap()].replace("pot: {at: shelf}", &format!("pot: {pot}"));
        let said = said(load(&format!("{head}task:\n  move: shelf\n"), &small()));
        match expected {
            None => assert!(said.is_empty(), "{cup}, {pot}: {said:#?}"),
            Some(words) => assert!(said.iter().any(|fault| fault.contains(words)), "{cup}, {pot}: {said:#?}"),
        }
    };
    let on_shelf = "{at: shelf}";
    check("{held: hand}", on_shelf, None);
    check("{held: [hand, hand1]}", "{held: crate}", None);
    check("{held: hnad}", on_shelf, Some("9:held: there is no resource `hnad` did you mean `hand`?"));
    check("{held: [hand, hook, scanner]}", on_shelf, Some("`scanner` is no gripper and no slot"));
    check(
        "{held: hand, at: shelf}",
        on_shelf,
        Some("an object that is 2 things instead of one write exactly one of: at, held"),
    );
    check("{}", on_shelf, Some("an object that does not say what it is"));
    check("{held: hand}", "{held: [hand1, hand]}", Some("10:held: `hand` holds `cup` already"));
    check("{held: []}", on_shelf, Some("held: an empty list"));
    check("{held: [hand, hand]}", on_shelf, Some("`hand` holds `cup` already"));
}

#[test]
fn only_a_slot_has_a_position() {
    let robot = small().replace("controller: arm}", "controller: arm, at: [0, 0, 1]}");
    let said = said(load(GOOD, &robot));
    assert_eq!(said.len(), 1, "{said:#?}");
    assert!(said[0].contains("at: only what has no controller has a fixed position"), "{said:#?}");
}

#[test]
fn what_is_full_at_the_start_is_not_there_to_take_more() {
    let picks = |cup: &str| {
        let text = GOOD.replace("cup: {at: shelf, offset: [0, 0.1]}", &format!("cup: {cup}"));
        let text = format!("{}task:\n  then: [{{move: shelf}}, {{pick: pot}}]\n", &text[..text.find("task:").unwrap()]);
        let files = super::written(text, super::ROBOT);
        let loaded = super::super::load_mission(&files, super::PATH.as_ref(), None, &[]).expect("no mistake");
        loaded.warnings.iter().map(ToString::to_string).collect::<Vec<_>>().join("; ")
    };
    assert_eq!(picks("{at: shelf}"), "");
    let said = picks("{held: hand}");
    assert!(said.contains("it must run out: 2 of `hand` would be in use, and the robot has 1"), "{said}");
}
