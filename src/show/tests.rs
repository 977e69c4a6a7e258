//! Diagram, summary and tree of whole runs, as people see them without color.

use ambidex_model::*;
use ambidex_record::{History, LeafState};

use super::explain::Account;
use super::live::{rows, summary};
use super::sample::{self, decided, experiment_1, grant, history, named, released, seconds};
use super::status::{Daemon, Snapshot};
use super::text::{columns, mark};
use super::{Palette, timeline, tree};

fn check(text: &str, expected: &str) {
    assert_eq!(text, expected, "\n{text}");
}

const TIMING_80: &str = " step     ╷1     ╷2   ╷3   ╷4   ╷5           ╷6   ╷7    ╷8   ╷9           ╷10
 move 1-1 ·······◇─────────────────────────────────────────────────────────────
 pick 1   ·······█████─────────────────────────────────────────────────────────
 move 1-2 ············█████────────────────────────────────────────────────────
 place 1  ·················█████───────────────────────────────────────────────
 move 2-1 ███████──────────────────────────────────────────────────────────────
 pick 2   ·······█████─────────────────────────────────────────────────────────
 move 2-2 ······················█████████████──────────────────────────────────
 place 2  ···································█████─────────────────────────────
 move 3-1 ···································◇─────────────────────────────────
 pick 3   ···································█████─────────────────────────────
 move 3-2 ···················································█████████████─────
 place 3  ································································█████
 move 4-1 ········································██████───────────────────────
 pick 4   ··············································█████──────────────────
 move 4-2 ································································◇────
 place 4  ································································█████
          ┴────────┴────────┴────────┴────────┴───────┴────────┴────────┴──────
  seconds 0        10       20       30       40      50       60       70
 · waiting  █ active  ─ done  ◇ skipped
";

#[test]
fn the_diagram_of_experiment_1() {
    let text = timeline::text(&history(&experiment_1()), 80, &Palette::plain());
    check(&text, TIMING_80);
}

#[test]
fn every_width_is_kept_to() {
    let records = [experiment_1(), stalled(), failed()];
    for history in records.map(|records| history(&records)) {
        for width in (40..=120).chain([200]) {
            let plain = Palette::plain();
            let text = timeline::text(&history, width, &plain)
                + &summary(&history, width, &plain)
                + &tree::text(history.header(), Some(&history), width, &plain)
                + &rows(&history, width, &plain).join("\n");
            for line in text.lines() {
                assert!(columns(line) <= width, "{width}: {line:?}");
            }
        }
    }
}

#[test]
fn nothing_is_drawn_of_nothing() {
    let mut header = sample::header();
    header.nodes = header.nodes.to_vec()[..1].to_vec().into();
    header.names = Names::default();
    let empty = History::with_past(&header);
    for palette in [Palette::plain(), Palette::ansi()] {
        for width in [0, 1, 40, 80, 200] {
            let text = timeline::text(&empty, width, &palette) + &summary(&empty, width, &palette);
            assert!(text.contains("not ended"), "{text}");
            assert_eq!(rows(&empty, width, &palette).len(), 1);
        }
    }
    assert_eq!(empty.causes(), []);
    assert_eq!(History::of(&experiment_1()[1..]).map(drop), None);
    let waiting = history(&experiment_1()[..1]);
    let text = timeline::text(&waiting, 40, &Palette::plain());
    assert!(text.contains(" move 1-1 ····"), "{text}");
}

#[test]
fn the_summary_of_experiment_1() {
    check(
        &summary(&history(&experiment_1()), 80, &Palette::plain()),
        "\
experiment 1: done
  10 steps in 77.7 s of robot time, 10 rounds, 0 messages between nodes

   1  move 2-1
   2  pick 1 + pick 2
   3  move 1-2
   4  place 1
   5  move 2-2
   6  pick 3 + place 2
   7  move 4-1
   8  pick 4
   9  move 3-2
  10  place 3 + place 4

skipped
  ◇ move 1-1  its goal was met already (7.40 s)
  ◇ move 3-1  its goal was met already (39.40 s)
  ◇ move 4-2  its goal was met already (71.70 s)
",
    );
}

/// Object 1 is fetched, then nothing can go on.
fn stalled() -> Vec<Record> {
    let blocked = |name, reason| Blocked { leaf: named(name), reason };
    let mut records = vec![Record::Header(Box::new(sample::header()))];
    records.extend([
        decided(0.0, 1, vec![grant("move 1-1", &[], &[0], &[])]),
        released(8.0, "move 1-1", End::Succeeded),
        decided(8.0, 2, vec![grant("pick 1", &[0, 1], &[2], &[])]),
        released(14.0, "pick 1", End::Succeeded),
        Record::World { at: seconds(14.0), change: Change::Taken(ObjectId(0), ResourceId(2)), origin: Origin::Script },
        Record::Decided {
            at: seconds(14.0),
            round: 3,
            granted: Vec::new(),
            refused: vec![
                blocked("move 1-2", Reason::NoPath { place: PlaceId(1) }),
                blocked("move 2-1", Reason::NothingAvailable { of: TypeId(2) }),
                blocked("move 3-1", Reason::NoPath { place: PlaceId(2) }),
                blocked("move 4-1", Reason::NoPath { place: PlaceId(3) }),
            ],
            reopened: None,
            deadlines: Vec::new(),
            urged: None,
            overdue: None,
        },
        Record::Ended { at: seconds(14.0), end: MissionEnd::Stalled },
    ]);
    records
}

#[test]
fn a_stall_says_what_is_a_cause_and_what_is_still_held() {
    let text = summary(&history(&stalled()), 60, &Palette::plain());
    check(
        &text,
        "\
experiment 1: stalled
  nothing runs and nothing can
  2 steps in 14.0 s of robot time, 3 rounds, 0 messages
  between nodes
  left_gripper still holds object 1

   1  move 1-1
   2  pick 1

what cannot run, and why
  ○ move 1-2  no free path leads to counter
  ○ move 2-1  no gripper would be available to it there
  ○ move 3-1  no free path leads to sink
  ○ move 4-1  no free path leads to cart
",
    );
}

#[test]
fn what_is_canceled_says_what_was_waiting() {
    let mut records = stalled();
    records.pop();
    records.push(Record::Ended { at: seconds(14.0), end: MissionEnd::Canceled });
    let text = summary(&history(&records), 60, &Palette::plain());
    let (_, told) = text.split_once("what was waiting, and why\n").expect("a head");
    assert!(told.starts_with("  ○ move 1-2  no free path leads to counter\n"), "{text}");
    assert!(!text.contains("cannot run"), "{text}");
}

/// The left arm gives up twice; what runs beside it is told to end.
fn failed() -> Vec<Record> {
    let aborted = End::Failed(Fault::Aborted(ControllerId(2)));
    let pick = || grant("pick 1", &[0, 1], &[2], &[]);
    let beside = grant("pick 2", &[0, 1], &[3], &["move 2-1"]);
    vec![
        Record::Header(Box::new(sample::header())),
        decided(0.0, 1, vec![grant("move 1-1", &[], &[0], &[])]),
        released(10.0, "move 1-1", End::Succeeded),
        decided(10.0, 2, vec![pick(), beside]),
        released(15.0, "pick 1", aborted),
        decided(17.0, 3, vec![pick()]),
        released(20.0, "pick 1", aborted),
        released(20.5, "pick 2", End::Canceled),
        Record::Ended { at: seconds(20.5), end: MissionEnd::Failed(named("pick 1")) },
    ]
}

#[test]
fn a_failure_names_leaf_moment_and_fault() {
    let history = history(&failed());
    let text = summary(&history, 80, &Palette::plain());
    let head = "experiment 1: failed\n  pick 1 failed 2 times, at last at 20.00 s: left_arm gave up\n";
    assert!(text.starts_with(head), "{text}");
    let text = timeline::text(&history, 52, &Palette::plain());
    let rows: Vec<&str> = text.lines().collect();
    assert_eq!(rows[1], " move 1-1 ████████████████████─────────────────────", "\n{text}");
    assert_eq!(rows[2], " pick 1   ····················█████████✗····█████✗", "\n{text}");
    assert_eq!(rows[6], " pick 2   ····················████████████████████⊘", "\n{text}");
    let legend = " · waiting  █ active  ─ done  ◇ skipped  ✗ failed\n ⊘ canceled\n";
    assert!(text.ends_with(legend), "{text}");
}

#[test]
fn every_product_says_the_same_of_every_leaf() {
    for records in [experiment_1(), stalled(), failed(), failed()[..5].to_vec()] {
        let history = history(&records);
        let snapshot = Snapshot::new(&history, Daemon::Gone, history.now());
        let tree = tree::text(history.header(), Some(&history), 120, &Palette::plain());
        for leaf in history.leaves() {
            let (name, state) = (history.names().node(leaf), history.state(leaf));
            assert_eq!(snapshot.nodes[leaf.index()].state, state, "{name}");
            assert!(tree.contains(&format!("{} {name}\n", mark(state))), "{name}: {state:?}\n{tree}");
            let mut account = Account::new(history.header(), name, None).unwrap();
            records.iter().for_each(|record| account.add(record));
            let text = account.text(400, &Palette::plain()).unwrap();
            let last = text.lines().last().and_then(|line| line.trim_start().chars().next());
            assert!(history.end().is_none() || last == Some(mark(state)), "{name}: {state:?}\n{text}");
        }
    }
}

#[test]
fn a_loss_is_told_with_its_own_moment() {
    let lost = ControllerId(2);
    let records = [
        Record::Header(Box::new(sample::header())),
        decided(0.0, 1, vec![grant("pick 1", &[0, 1], &[2], &[])]),
        Record::Controller {
            at: seconds(1.0),
            controller: lost,
            message: ControllerMessage::Lost { why: ambidex_model::Loss::Ended },
        },
        released(1.5, "pick 1", End::Failed(Fault::Lost(lost))),
        Record::Ended { at: seconds(1.5), end: MissionEnd::ControllerLost(lost) },
    ];
    let text = summary(&history(&records), 80, &Palette::plain());
    assert!(
        text.starts_with("experiment 1: failed\n  the controller left_arm was lost at 1.00 s: its process ended\n"),
        "{text}"
    );
}

#[test]
fn a_big_tree_shows_what_ran() {
    let mut header = sample::header();
    for extra in 0..100 {
        let entry = NodeEntry { parent: NodeId(1), kind: EntryKind::Behavior("move".into()) };
        header.nodes.add(header.nodes.len(), vec![entry]);
        header.names.nodes.add(header.names.nodes.len(), vec![format!("move {extra}")]);
    }
    let mut records = experiment_1();
    records[0] = Record::Header(Box::new(header));
    let text = timeline::text(&history(&records), 80, &Palette::plain());
    assert_eq!(text.lines().count(), 13 + 5, "{text}");
    assert!(text.ends_with("\n 103 behaviors that did not run left out\n"), "{text}");
}

#[test]
fn a_tree_of_any_depth_is_drawn_at_once() {
    let mut header = sample::header();
    let then = |node: u32| NodeEntry { parent: NodeId(node.saturating_sub(1)), kind: EntryKind::Then };
    header.nodes = (0..100_000).map(then).collect();
    let text = tree::text(&header, None, 60, &Palette::plain());
    assert_eq!(text.lines().count(), 100_000);
    assert!(text.lines().all(|line| columns(line) <= 60), "{}", text.lines().last().unwrap());
    let snapshot = Snapshot::new(&History::new(&header), Daemon::Gone, Time::ZERO);
    let lines = snapshot.lines(80, 50, &Palette::plain());
    assert!(lines.len() <= 50 && lines.iter().any(|line| line.contains("not shown")), "{}", lines.join("\n"));
}

#[test]
fn the_tree_shows_kinds_and_states() {
    let records = stalled();
    let history = history(&records[..4]);
    let header = sample::header();
    let text = tree::text(&header, Some(&history), 60, &Palette::plain());
    let expected = "\
● root
└─ ● all objects  and
   ├─ ● object 1  then
   │  ├─ ✓ move 1-1
   │  ├─ ● pick 1
   │  ├─ ○ move 1-2
   │  └─ ○ place 1
   ├─ ○ object 2  then
";
    assert!(text.starts_with(expected), "\n{text}");
    let last = "   └─ object 4  then\n      ├─ move 4-1\n      ├─ pick 4\n      ├─ move 4-2\n      └─ place 4\n";
    let bare = tree::text(&header, None, 60, &Palette::plain());
    assert!(bare.ends_with(last), "\n{bare}");
}

/// Any of the four behaviors of object 4 would do, and the pick does.
fn one_of_four() -> Vec<Record> {
    let mut header = sample::header();
    header.nodes[named("object 4").index()].kind = EntryKind::Or;
    let completed = Some(Completion { node: named("object 4"), heir: None });
    let consequences = Consequences { completed, failed: None, failing: None, cleaned: None };
    let (at, leaf, end) = (seconds(5.0), named("pick 4"), End::Succeeded);
    vec![
        Record::Header(Box::new(header)),
        decided(0.0, 1, vec![grant("pick 4", &[0, 1], &[3], &[])]),
        Record::Released { at, leaf, end, consequences, changes: Vec::new(), waits_until: None, unfit: Vec::new() },
        decided(5.0, 2, vec![grant("move 1-1", &[], &[0], &[])]),
        released(10.0, "move 1-1", End::Canceled),
        Record::Ended { at: seconds(10.0), end: MissionEnd::Canceled },
    ]
}

#[test]
fn a_way_that_was_not_needed_says_what_did_it() {
    let records = one_of_four();
    let history = history(&records);
    let plain = Palette::plain();
    let summary = summary(&history, 80, &plain);
    assert!(summary.contains("\nnot needed\n  ∅ move 4-1  pick 4 did it\n  ∅ move 4-2  pick 4 did it\n"), "{summary}");
    let tree = tree::text(history.header(), Some(&history), 80, &plain);
    assert!(tree.contains("∅ move 4-1  not needed: pick 4 did it\n") && tree.contains("✓ pick 4\n"), "{tree}");
    let timeline = timeline::text(&history, 80, &plain);
    let row = timeline.lines().find(|line| line.starts_with(" move 4-1 ")).expect("a row");
    assert!(row.contains("·∅ pick 4 did it"), "{timeline}");
    assert!(timeline.contains("∅ not needed"), "{timeline}");
    let snapshot = Snapshot::new(&history, Daemon::Gone, history.now());
    let way = &snapshot.nodes[named("move 4-1").index()];
    assert_eq!((way.state, way.reason.as_deref()), (LeafState::NotNeeded, Some("pick 4 did it")));
    let mut account = Account::new(history.header(), "move 4-1", None).unwrap();
    records.iter().for_each(|record| account.add(record));
    let told = account.text(80, &plain).unwrap();
    assert!(told.ends_with("5.00 s  It is not needed: pick 4 did it.\n"), "{told}");
    for picture in [timeline::picture(&history), tree::picture(history.header(), Some(&history))] {
        assert!(picture.contains("not needed") && picture.contains("pick 4 did it"), "{picture}");
    }
}
