//! The display at moments of experiment 1, and its plain lines.

use nalgebra::Vector3;

use crate::sample::{self, named, seconds};
use crate::text::{MIN_WIDTH, columns};
use crate::{Palette, Progress};
use ambidex_model::*;

fn controller(controller: u32, message: ControllerMessage) -> Record {
    Record::Controller { at: seconds(9.0), controller: ControllerId(controller), message }
}

fn id(number: u32) -> CommandId {
    CommandId { generation: 1, number }
}

fn goal(to: u32, leaf: &str, mode: Mode, command: Command) -> Record {
    let message = ToController::Goal { id: id(1), mode, command };
    let leaf = Some(named(leaf));
    controller(to, ControllerMessage::Told { leaf, message })
}

fn heard(from: u32, message: FromController) -> Record {
    controller(from, ControllerMessage::Heard { message })
}

/// The robot picks two objects at once: the left arm is at 45 %, the right arm at 80 %.
fn picking() -> Progress {
    let at = nalgebra::Point3::origin();
    let grasp = |object| Command::Grasp { object: ObjectId(object), at };
    let feedback = |from, progress| {
        let state = ControllerState::Arm { gripper: at, velocity: Vector3::zeros(), holds: None };
        let id = id(1);
        heard(from, FromController::Feedback { id, progress, state })
    };
    let mut progress = Progress::default();
    let attached = (0..4).map(|id| controller(id, ControllerMessage::Attached));
    let begun = sample::experiment_1().into_iter().take(4);
    let under_way = [
        goal(0, "pick 1", Mode::Maintain, Command::Stand),
        goal(1, "pick 1", Mode::Maintain, Command::Look { at }),
        goal(2, "pick 1", Mode::Achieve, grasp(0)),
        goal(3, "pick 2", Mode::Achieve, grasp(1)),
        feedback(2, 0.45),
        feedback(3, 0.8),
    ];
    for record in attached.chain(begun).chain(under_way) {
        progress.add(&record);
    }
    progress
}

fn check(progress: &Progress, width: usize, expected: &[&str]) {
    let lines = progress.lines(width, &Palette::plain());
    let trimmed: Vec<&str> = lines.iter().map(|line| line.trim_end()).collect();
    assert_eq!(trimmed, expected, "\n{}", trimmed.join("\n"));
    assert!(lines.iter().all(|line| columns(line) <= width), "{lines:#?}");
}

#[test]
fn each_resource_says_who_uses_it_and_how_far_it_is() {
    check(
        &picking(),
        80,
        &[
            "experiment 1  9.00 s · step 2 · 2/16 done",
            "  base           pick 1 + pick 2 · at shelf           standing",
            "  head           pick 1 + pick 2 · at shelf           looking",
            "  left_gripper   pick 1                               ━━━━━━━━━───────────  45 %",
            "  right_gripper  pick 2                               ━━━━━━━━━━━━━━━━────  80 %",
        ],
    );
    check(
        &picking(),
        MIN_WIDTH,
        &[
            "experiment 1  9.00 s · step 2 · 2/16 do…",
            "  base           pick 1 + …  standing",
            "  head           pick 1 + …  looking",
            "  left_gripper   pick 1      ━━───  45 %",
            "  right_gripper  pick 2      ━━━━─  80 %",
        ],
    );
}

#[test]
fn absent_controllers_and_held_objects_are_told() {
    let mut progress = Progress::default();
    check(&progress, 80, &["no mission yet"]);
    let held = Change::Object(ObjectId(0), Location::In(ResourceId(2)));
    let (at, change) = (seconds(9.0), held);
    let mut records = vec![Record::Header(Box::new(sample::header()))];
    records.extend((1..4).map(|id| controller(id, ControllerMessage::Attached)));
    records.extend([
        Record::World { at, change },
        controller(3, ControllerMessage::Lost { why: ambidex_model::Loss::Ended }),
    ]);
    for record in &records {
        progress.add(record);
    }
    check(
        &progress,
        80,
        &[
            "experiment 1  9.00 s · step 0 · 0/16 done",
            "  base           waiting for base",
            "  head           free",
            "  left_gripper   holds object 1",
            "  right_gripper  lost right_arm",
        ],
    );
}

#[test]
fn a_run_without_a_display_is_told_line_by_line() {
    let mut progress = Progress::default();
    let mut lines = Vec::new();
    for record in sample::experiment_1() {
        progress.add(&record);
        lines.extend(progress.plain_line(&record));
    }
    assert_eq!(
        lines[..6],
        [
            "   0.00 s  experiment 1: 16 behaviors on pr2, greedy",
            "   0.00 s  step 1: move 2-1 (base)",
            "   7.40 s  done move 2-1",
            "   7.40 s  step 2: pick 1 (left_gripper), pick 2 (right_gripper); skipped move 1-1",
            "  13.50 s  done pick 1",
            "  14.00 s  done pick 2",
        ]
    );
    assert_eq!(lines.last().unwrap(), "  77.70 s  done in 10 steps");
}

#[test]
fn what_goes_wrong_has_its_line() {
    let mut progress = picking();
    let mut check = |record: Record, expected: Option<&str>| {
        progress.add(&record);
        assert_eq!(progress.plain_line(&record).as_deref(), expected);
    };
    let why = Rejection::OutOfReach;
    check(
        heard(2, FromController::Rejected { id: id(1), why }),
        Some("   9.00 s  left_arm rejected pick 1: the point is out of reach"),
    );
    let end = End::Failed(Fault::Rejected(ControllerId(2), Rejection::Busy));
    check(
        sample::released(9.0, "pick 1", end),
        Some("   9.00 s  failed pick 1: left_arm would not take its goal: it is doing something else"),
    );
    check(
        controller(3, ControllerMessage::Lost { why: ambidex_model::Loss::Ended }),
        Some("   9.00 s  lost right_arm"),
    );
    let why = Rejection::Stale;
    check(
        controller(0, ControllerMessage::Refused { id: None, why }),
        Some(
            "   9.00 s  refused a message of base: \
             it is from an earlier life of the daemon or the controller",
        ),
    );
    let reopened =
        Reopened { holder: named("object 1"), leaf: named("move 1-1"), lapsed: Some(ResourceId(0)), lacks: None };
    check(
        Record::Decided {
            at: seconds(9.5),
            round: 4,
            granted: Vec::new(),
            refused: Vec::new(),
            reopened: Some(reopened),
        },
        Some("   9.50 s  reopened move 1-1, base lapsed"),
    );
    check(sample::decided(9.5, 5, Vec::new()), None);
}
