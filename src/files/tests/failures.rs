//! Failure files: what they come to, and a table of mistakes with the line and the words that each is told with.

use std::time::Duration;

use super::super::{Checked, FilesError, check, failures_text, load_failures};
use super::{GOOD, ROBOT, load, written};
use ambidex_model::{
    Change, ControllerId, Disk, FactId, Failures, Flaw, FlawKind, Location, Mishap, NodeId, ObjectId, PlaceId, Time,
};

const PATH: &str = "failures.yaml";
const FILE: &str = "\
failures:
  - {at: 2 min, return: arm}
  - {at: 3 min, disk: slow}
  - {at: 1500 ms, lose: arm}
  - {at: 3, clear: door_open}
  - {at: 3, lies: {object: cup, at: table}}
  - {behavior: pick cup, fails: aborted}
  - {behavior: pick cup, attempt: 2, hangs: true}
  - {behavior: move to table, attempt: every, drops: cup}
  - {behavior: place cup, drops: all}
  - {behavior: place cup, attempt: 3, late: 2.5 s}
";

fn loaded(text: &str) -> Result<Failures, FilesError> {
    let mission = load(&mission(), ROBOT).unwrap_or_else(|error| panic!("{:?}", error.faults()));
    let mut files = written(GOOD, ROBOT);
    files.insert(PATH, text);
    load_failures(&files, PATH.as_ref(), &mission)
}

/// The good one with a behavior that no controller works on.
fn mission() -> String {
    format!("{GOOD}    - wait\nbehaviors: {{wait: {{potential: 1, takes: 3 s}}}}\n")
}

#[test]
fn what_is_written_is_what_goes_wrong() {
    let (arm, second) = (ControllerId(0), |seconds: f64| Time((seconds * 1e6) as u64));
    let flaw = |leaf, attempt, kind| Flaw { leaf: NodeId(leaf), attempt, kind };
    let expected = Failures {
        mishaps: vec![
            (second(1.5), Mishap::Lose(arm)),
            (second(3.0), Mishap::World(Change::Fact(FactId(0), false))),
            (second(3.0), Mishap::World(Change::Object(ObjectId(0), Location::At(PlaceId(1))))),
            (second(120.0), Mishap::Return(arm)),
            (second(180.0), Mishap::Disk(Disk::Slow)),
        ],
        flaws: vec![
            flaw(3, Some(1), FlawKind::Fails),
            flaw(3, Some(2), FlawKind::Hangs),
            flaw(4, None, FlawKind::Drops(Some(ObjectId(0)))),
            flaw(5, Some(1), FlawKind::Drops(None)),
            flaw(5, Some(3), FlawKind::Late(Duration::from_millis(2500))),
        ],
    };
    assert_eq!(loaded(FILE).unwrap_or_else(|error| panic!("{:?}", error.faults())), expected);
    let mut files = written(GOOD, ROBOT);
    files.insert(PATH, FILE);
    assert!(matches!(check(&files, PATH.as_ref(), &[]), Ok(Checked::Failures(10, _))), "its names are not looked up");
}

#[test]
fn what_is_written_again_comes_to_the_same() {
    let mission = load(&mission(), ROBOT).unwrap_or_else(|error| panic!("{:?}", error.faults()));
    let expected = loaded(FILE).unwrap_or_else(|error| panic!("{:?}", error.faults()));
    let text = failures_text(&expected, &mission.names).unwrap();
    assert_eq!(loaded(&text).unwrap_or_else(|error| panic!("{text}\n{:?}", error.faults())), expected);
    assert!(text.contains("  - {at: 1.5 s, lose: \"arm\"}\n"), "{text}");
    assert_eq!(failures_text(&Failures::default(), &mission.names), None);
}

#[test]
fn every_mistake_is_told() {
    let entries: &[(&str, &str)] = &[
        ("{at: 1 s, lose: amr}", "lose: there is no controller `amr` did you mean `arm`? Allowed: `arm`"),
        ("{at: 1 s, lose: hand}", "there is no controller `hand`"),
        ("{at: 1 s, return: arm}", "`arm` is there at that moment"),
        ("{at: 1 s, inhibit: amr}", "inhibit: there is no controller `amr` did you mean `arm`?"),
        ("{at: 1 m, hang: arm}", "found `1 m` instead of a time"),
        ("{at: -1 s, hang: arm}", "`-1 s` is out of bounds"),
        ("{lose: arm}", "a mishap lacks the key `at`"),
        ("{at: 1 s}", "a mishap that does not say what it is write exactly one of: lose, hang, inhibit, return, set"),
        ("{at: 1 s, lose: arm, hang: arm}", "a mishap that is 2 things instead of one"),
        ("{at: 1 s, loose: arm}", "a mishap has no key `loose` did you mean `lose`?"),
        ("{at: 1 s, set: door open}", "there is no fact `door open` did you mean `door_open`?"),
        ("{at: 1 s, disk: ful}", "found `ful` instead of what a disk does did you mean `full`?"),
        ("{behavior: pick cup, late: 2 m}", "found `2 m` instead of a time"),
        ("{at: 1 s, lies: cup}", "found `cup` instead of an object at a place"),
        ("{at: 1 s, lies: {object: cap, at: table}}", "there is no object `cap` did you mean `cup`?"),
        ("{at: 1 s, lies: {object: cup, at: tabel}}", "there is no place `tabel` did you mean `table`?"),
        ("{behavior: pick cap, hangs: true}", "there is no behavior `pick cap` did you mean `pick cup`?"),
        ("{behavior: root, hangs: true}", "there is no behavior `root`"),
        ("{behaviour: pick cup, hangs: true}", "a flaw has no key `behaviour` did you mean `behavior`?"),
        ("{behavior: pick cup}", "a flaw that does not say what it is write exactly one of: fails, hangs, late, drops"),
        ("{behavior: pick cup, fail: aborted}", "a flaw has no key `fail` did you mean `fails`?"),
        ("{behavior: pick cup, fails: abort}", "found `abort` instead of `aborted` did you mean `aborted`?"),
        ("{behavior: pick cup, hangs: false}", "a flaw that does not happen"),
        (
            "{behavior: pick cup, attempt: 0, hangs: true}",
            "found `0` instead of a whole number from 1 to 1001, or `every`",
        ),
        ("{behavior: pick cup, attempt: all, hangs: true}", "found `all` instead of a whole number"),
        ("{behavior: pick cup, drops: cap}", "there is no object `cap` did you mean `cup`?"),
        ("{behavior: wait, fails: aborted}", "nobody can give up `wait` no controller does anything in it"),
        ("{at: 1 s, behavior: pick cup, hangs: true}", "a flaw has no key `at`"),
        ("lose: arm", "found a map instead of a list"),
    ];
    for (entry, words) in entries {
        let text = if entry.starts_with('{') {
            format!("failures:\n  - {entry}\n")
        } else {
            format!("failures:\n  {entry}\n")
        };
        told(&text, &[(if entry.starts_with('{') { 2 } else { 1 }, words)]);
    }
}

#[test]
fn all_are_told_at_once() {
    told(
        "failures:\n  - {at: 9 s, lose: arm}\n  - {at: 5 s, hang: arm}\n  - {at: 10 s, hang: arm}\n  - {at: 12 s, lose: arn}\n",
        &[(4, "`arm` is lost since 9 s write `return: arm` at a moment between"), (5, "did you mean `arm`?")],
    );
    told(
        "failures:\n  - {at: 1 s, inhibit: arm}\n  - {at: 2 s, inhibit: arm}\n",
        &[(3, "`arm` is inhibited since 1 s write `return: arm` at a moment between")],
    );
    told(
        "failures:\n  - {behavior: pick cup, hangs: true}\n  - {behavior: pick cup, attempt: every, fails: aborted}\n  - {at: 3}\n",
        &[(4, "does not say what it is")],
    );
    told(
        "failures:\n  - {behavior: pick cup, hangs: true}\n  - {behavior: pick cup, attempt: every, fails: aborted}\n",
        &[(3, "an attempt of `pick cup` ends in one way only")],
    );
    told("failures: []\n", &[(1, "an empty list instead of a list of what goes wrong")]);
    told(GOOD, &[(1, "this is a mission, not a failure file")]);
    told("failuers: []\n", &[(1, "a failure file has no key `failuers` did you mean `failures`?")]);
}

fn told(text: &str, expected: &[(usize, &str)]) {
    let error = loaded(text).expect_err(text);
    let found: Vec<(usize, String)> = error
        .faults()
        .iter()
        .map(|fault| (fault.position().map_or(0, |at| at.0), format!("{fault} {}", fault.help().unwrap_or_default())))
        .collect();
    for (line, words) in expected {
        assert!(found.iter().any(|(at, said)| at == line && said.contains(words)), "{text}{line}: {words}: {found:#?}");
    }
}
