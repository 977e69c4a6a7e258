//! The display at moments of experiment 1, and its plain lines.

use nalgebra::Vector3;

use ambidex_model::*;
use ambidex_record::History;

use super::{line, rows, stage};
use crate::Palette;
use crate::sample::{self, named, seconds};
use crate::text::{MIN_WIDTH, columns};

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
fn picking() -> History {
    let at = nalgebra::Point3::origin();
    let grasp = |object| Command::Grasp { object: ObjectId(object), at, place: None, holder: None };
    let feedback = |from, progress| {
        let state = ControllerState::Arm { gripper: at, velocity: Vector3::zeros(), holds: None };
        let id = id(1);
        heard(from, FromController::Feedback { id, progress, state })
    };
    let mut history = History::new(&sample::header());
    let attached = (0..4).map(|id| controller(id, ControllerMessage::Attached));
    let begun = sample::experiment_1().into_iter().take(4);
    let under_way = [
        goal(0, "pick 1", Mode::Maintain, Command::Stand),
        goal(1, "pick 1", Mode::Maintain, Command::Look { at, place: None }),
        goal(2, "pick 1", Mode::Achieve, grasp(0)),
        goal(3, "pick 2", Mode::Achieve, grasp(1)),
        feedback(2, 0.45),
        feedback(3, 0.8),
    ];
    for record in attached.chain(begun).chain(under_way) {
        history.apply(&record);
    }
    history
}

fn check(history: &History, width: usize, expected: &[&str]) {
    let lines = rows(history, width, &Palette::plain());
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
    let held = Change::Taken(ObjectId(0), ResourceId(2));
    let (at, change) = (seconds(9.0), held);
    let mut history = History::new(&sample::header());
    let mut records = Vec::new();
    records.extend((1..4).map(|id| controller(id, ControllerMessage::Attached)));
    records.extend([
        Record::World { at, change, origin: Origin::Script },
        controller(3, ControllerMessage::Lost { why: ambidex_model::Loss::Ended }),
    ]);
    records.iter().for_each(|record| history.apply(record));
    check(
        &history,
        80,
        &[
            "experiment 1  0.00 s · step 0 · 0/16 done",
            "  base           waiting for base",
            "  head           free",
            "  left_gripper   holds object 1",
            "  right_gripper  lost right_arm",
        ],
    );
    let row = |history: &History| rows(history, 80, &Palette::plain())[3].trim_end().to_owned();
    let change = Change::Emptied(ResourceId(2));
    history.apply(&Record::World { at, change, origin: Origin::Script });
    assert_eq!(row(&history), "  left_gripper   free");
    let (gripper, velocity) = (nalgebra::Point3::origin(), Vector3::zeros());
    let state = ControllerState::Arm { gripper, velocity, holds: Some(ObjectId(1)) };
    history.apply(&heard(2, FromController::Configured { generation: 1, state }));
    assert_eq!(row(&history), "  left_gripper   holds object 2");
}

#[test]
fn a_run_without_a_display_is_told_line_by_line() {
    let mut history = History::new(&sample::header());
    let mut lines = Vec::new();
    for record in sample::experiment_1() {
        history.apply(&record);
        lines.extend(line(&history, &record));
    }
    assert_eq!(
        lines[..6],
        [
            "   0.00 s  experiment 1: 16 behaviors on pr2, greedy",
            "   0.00 s  step 1: move 2-1 (base)",
            "   7.40 s  done move 2-1",
            "   7.40 s  step 2: pick 1 (base, head, left_gripper), pick 2 (base, head, right_gripper); skipped move 1-1",
            "  13.50 s  done pick 1",
            "  14.00 s  done pick 2",
        ]
    );
    assert_eq!(lines.last().unwrap(), "  77.70 s  done in 10 steps");
}

#[test]
fn what_goes_wrong_has_its_line() {
    let mut history = picking();
    let mut check = |record: Record, expected: Option<&str>| {
        history.apply(&record);
        assert_eq!(line(&history, &record).as_deref(), expected);
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
        Some("   9.00 s  lost right_arm: its process ended"),
    );
    let why = Rejection::Stale;
    check(
        controller(0, ControllerMessage::Refused { id: None, why }),
        Some(
            "   9.00 s  refused a message of base: \
             it is from an earlier life of the daemon or the controller",
        ),
    );
    let heir = Box::new(Blocked { leaf: named("pick 1"), reason: Reason::OutOfReach { object: ObjectId(0) } });
    let cause = Cause::Lapse { resource: ResourceId(0), heir };
    let (node, up_to) = (named("move 1-1"), named("object 1"));
    let reopened = Reopened::new(node, up_to, cause);
    check(
        Record::Decided {
            at: seconds(9.5),
            round: 4,
            granted: Vec::new(),
            refused: Vec::new(),
            reopened: Some(reopened),
            deadlines: Vec::new(),
            urged: None,
            overdue: None,
        },
        Some("   9.50 s  reopened move 1-1, base lapsed"),
    );
    check(sample::decided(9.5, 5, Vec::new()), None);
}

#[test]
fn how_far_a_run_is_takes_one_line() {
    let mut history = History::new(&sample::header());
    assert_eq!(stage(&history), "experiment 1: waiting for base, head, left_arm, right_arm");
    history.apply(&controller(1, ControllerMessage::Attached));
    history.apply(&controller(2, ControllerMessage::Attached));
    history.apply(&controller(2, ControllerMessage::Lost { why: Loss::Ended }));
    assert_eq!(stage(&history), "experiment 1: waiting for base, left_arm, right_arm");
    let mut history = picking();
    assert_eq!(stage(&history), "experiment 1: 2 of 16 behaviors done, step 2");
    let (end, until) = (MissionEnd::Canceled, seconds(20.0));
    history.apply(&Record::Ending { at: seconds(10.0), end, until });
    assert_eq!(stage(&history), "experiment 1: is to end (canceled), 2 of 16 behaviors done");
    history.apply(&Record::Ended { at: seconds(11.0), end });
    assert_eq!(stage(&history), "experiment 1: canceled");
}
