//! A small run with every turn that a story can take, and experiment 1.

use super::{Account, Story};
use crate::Palette;
use crate::sample::{decided, experiment_1, grant, header, named, released, seconds};
use crate::text::columns;
use ambidex_model::*;

fn story(records: &[Record], width: usize) -> String {
    let mut story = Story::new(&header());
    records.iter().for_each(|record| story.add(record));
    story.text(width, &Palette::plain())
}

fn account(records: &[Record], name: &str, round: Option<u32>) -> Result<String, String> {
    let account = Account::new(&header(), name, round);
    let mut account = account.map_err(|error| format!("{error}: {}", error.help()))?;
    records.iter().for_each(|record| account.add(record));
    account.text(90, &Palette::plain()).map_err(|error| format!("{error}: {}", error.help()))
}

fn refused(mut record: Record, reasons: &[(&str, Reason)]) -> Record {
    if let Record::Decided { refused, .. } = &mut record {
        refused.extend(reasons.iter().map(|(leaf, reason)| Blocked { leaf: named(leaf), reason: reason.clone() }));
    }
    record
}

/// A resource held for what comes after a behavior.
fn kept(at_s: f64, resource: u32, holder: &str, behavior: &str) -> Record {
    let state = serde_json::json!({
        "access": {"shared": 0},
        "leases": [{"holder": named(holder), "behavior": named(behavior), "kind": "intention", "from": null}],
    });
    let state = serde_json::from_value(state).unwrap();
    Record::Resource { at: seconds(at_s), resource: ResourceId(resource), state }
}

/// move 2-1 wins; pick 2 fails once; move 1-1 lapses; the mission fails.
fn turns() -> Vec<Record> {
    let base = ResourceId(0);
    let outbid = |own| Reason::Outbid { by: named("move 2-1"), resource: base, own, theirs: 0.5 };
    let held = |by| Reason::Held { resource: base, by: named(by), channel: None };
    let fault = End::Failed(Fault::Aborted(ControllerId(3)));
    let mut lapse = decided(9.0, 5, Vec::new());
    if let Record::Decided { reopened, .. } = &mut lapse {
        let lacks = Blocked { leaf: named("pick 1"), reason: Reason::OutOfReach { object: ObjectId(0) } };
        let cause = Cause::Lapse { resource: base, heir: Box::new(lacks) };
        *reopened = Some(Reopened::new(named("move 1-1"), named("object 1"), cause));
    }
    vec![
        Record::Header(Box::new(header())),
        refused(
            decided(0.0, 1, vec![grant("move 2-1", &[], &[0], &[])]),
            &[("move 1-1", outbid(0.49)), ("move 3-1", outbid(0.5))],
        ),
        refused(decided(0.0, 2, Vec::new()), &[("move 1-1", held("move 2-1")), ("move 3-1", held("move 2-1"))]),
        released(7.4, "move 2-1", End::Succeeded),
        kept(7.4, 0, "object 2", "move 2-1"),
        refused(
            decided(7.4, 3, vec![grant("pick 1", &[0, 1], &[2], &["move 1-1"]), grant("pick 2", &[0, 1], &[3], &[])]),
            &[("move 1-1", Reason::Satisfied), ("move 3-1", held("object 2"))],
        ),
        released(8.4, "pick 2", fault),
        refused(
            decided(8.4, 4, vec![grant("pick 2", &[0, 1], &[3], &[])]),
            &[("move 3-1", Reason::NothingAvailable { of: TypeId(2) })],
        ),
        refused(lapse, &[("move 3-1", Reason::NothingAvailable { of: TypeId(2) })]),
        Record::Controller {
            at: seconds(9.5),
            controller: ControllerId(3),
            message: ControllerMessage::Lost { why: ambidex_model::Loss::Ended },
        },
        released(9.5, "pick 2", End::Canceled),
        Record::Ended { at: seconds(9.5), end: MissionEnd::ControllerLost(ControllerId(3)) },
    ]
}

const STORY: &str = "\
experiment 1 on pr2, greedy: failed: right_arm was lost
  3 steps in 9.50 s of robot time, 5 rounds, 0 behaviors skipped

  0.00 s  ● move 2-1 starts with base alone. Its potential of 1.000 beats move 3-1 (0.500)
            and move 1-1 (0.490).
  7.40 s  ✓ move 2-1 is done after 7.40 s.
          ● pick 1 and pick 2 start together. They share base and head for \"at shelf\".
            pick 1 has left_gripper alone and pick 2 has right_gripper alone.
          ◇ move 1-1 is skipped: its goal is met already.
          ○ move 3-1 waits: base is kept for \"at shelf\" by object 2, for what comes after
            move 2-1.
  8.40 s  ✗ pick 2 fails after 1.00 s: right_arm gave up.
          ● pick 2 starts with right_gripper alone, base and head for \"at shelf\". pick 1
            still runs.
          ○ move 1-1 counts as done no more: base was kept for pick 1, which cannot come
            now, since no free resource reaches object 1.
          ○ move 3-1 waits: no gripper would be available to it there.
  9.50 s  ✗ The controller right_arm is lost: its process ended.
          ⊘ pick 2 is canceled after 1.10 s.
          ✗ The mission is over: failed: right_arm was lost.
";

#[test]
fn a_story_tells_every_turn() {
    let text = story(&turns(), 90);
    assert_eq!(text, STORY, "\n{text}");
}

#[test]
fn a_story_keeps_to_its_width_and_to_a_page() {
    for width in 40..130 {
        let text = story(&experiment_1(), width);
        assert!(text.lines().all(|line| columns(line) <= width), "{width}:\n{text}");
    }
    assert!(story(&experiment_1(), 100).lines().count() <= 50);
    let long = story(&std::iter::repeat_n(experiment_1(), 100).flatten().collect::<Vec<_>>(), 100);
    assert!(long.contains("further steps left out") && long.lines().count() < 120, "{long}");
    assert!(story(&[], 80).starts_with("experiment 1 on pr2, greedy: the log ends before the mission did"));
    let cut = story(&turns()[..6], 80);
    assert!(cut.contains("Still under way: pick 1 and pick 2."), "{cut}");
}

#[test]
fn an_account_tells_round_by_round() {
    let check = |name: &str, expected: &str| {
        let text = account(&turns(), name, None).unwrap();
        assert_eq!(text, expected, "\n{text}");
    };
    check(
        "move 3-1",
        "\
move 3-1 (move in object 3)
  ○ round 1        0.00 s  It waits: outbid by move 2-1 for base (both have 0.500, and
                           move 2-1 comes first).
  ○ round 2        0.00 s  It waits: base is held by move 2-1.
  ○ round 3        7.40 s  It waits: base is kept for \"at shelf\" by object 2, for what
                           comes after move 2-1.
  ○ rounds 4 to 5  8.40 s  It waits: no gripper would be available to it there.
  ○                9.50 s  The mission is over: failed: right_arm was lost.
",
    );
    check(
        "move 1-1",
        "\
move 1-1 (move in object 1)
  ○ round 1  0.00 s  It waits: outbid by move 2-1 for base (0.500 against 0.490).
  ○ round 2  0.00 s  It waits: base is held by move 2-1.
  ◇ round 3  7.40 s  It is skipped: its goal is met already, and pick 1 goes on from
                     there.
  ○ round 5  9.00 s  It counts as done no more: base was kept for pick 1, which cannot
                     come now, since no free resource reaches object 1.
  ○          9.50 s  The mission is over: failed: right_arm was lost.
",
    );
    check(
        "pick 2",
        "\
pick 2 (pick in object 2)
  ○ rounds 1 to 2  0.00 s  It is not asked: its turn comes after move 2-1.
  ● round 3        7.40 s  It starts with potential 1.000 and has right_gripper alone,
                           base and head for \"at shelf\". pick 1 starts with it.
  ✗                8.40 s  It fails after 1.00 s: right_arm gave up.
  ● round 4        8.40 s  It starts with potential 1.000 and has right_gripper alone,
                           base and head for \"at shelf\". pick 1 still runs.
  ⊘                9.50 s  It is canceled after 1.10 s.
  ⊘                9.50 s  The mission is over: failed: right_arm was lost.
",
    );
}

#[test]
fn an_account_is_readable_in_few_columns() {
    let mut account = Account::new(&header(), "move 3-1", None).unwrap();
    turns().iter().for_each(|record| account.add(record));
    let text = account.text(40, &Palette::plain()).unwrap();
    let first = "  ○ round 2        0.00 s\n    It waits: base is held by move 2-1.\n";
    assert!(text.contains(first) && text.lines().all(|line| columns(line) <= 40), "{text}");
}

#[test]
fn an_account_may_be_of_one_round_or_of_a_part() {
    let round = |name, round| account(&turns(), name, Some(round));
    let told = round("move 3-1", 5).unwrap();
    assert!(told.contains("rounds 4 to 5") && !told.contains("round 3"), "{told}");
    let told = round("pick 1", 5).unwrap();
    assert!(told.contains("round 5: nothing was decided about it; it was active."), "{told}");
    assert_eq!(round("pick 1", 6).unwrap_err(), "there is no round 6: the log has rounds 1 to 5");
    let error = account(&turns(), "pik 1", None).unwrap_err();
    assert!(error.starts_with("there is no node `pik 1`: did you mean `pick 1`? Allowed: "), "{error}");
    let part = account(&turns(), "object 2", None).unwrap();
    for leaf in ["\nmove 2-1\n", "\npick 2\n", "\nmove 2-2\n", "\nplace 2\n"] {
        assert!(part.contains(leaf), "{part}");
    }
    assert!(!part.contains("\npick 1\n"), "{part}");
}
