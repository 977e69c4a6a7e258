//! The status at moments of experiment 1, as values.

mod pages;

use nalgebra::{Point3, Vector3};

use super::*;
use crate::Palette;
use crate::sample::{self, decided, experiment_1, grant, named, released, seconds};
use ambidex_model::*;
use ambidex_record::LeafState;

const LIVES: Daemon = Daemon::Running { pid: Some(7) };

fn controller(at_s: f64, controller: u32, message: ControllerMessage) -> Record {
    Record::Controller { at: seconds(at_s), controller: ControllerId(controller), message }
}

fn heard(at_s: f64, from: u32, message: FromController) -> Record {
    controller(at_s, from, ControllerMessage::Heard { message })
}

fn id(number: u32) -> CommandId {
    CommandId { generation: 1, number }
}

fn state(of: u32) -> ControllerState {
    let (at, velocity) = (Point3::origin(), Vector3::zeros());
    match of {
        0 => ControllerState::Base { pose: Pose::new(2.0, -1.0, 0.0), velocity },
        1 => ControllerState::Head { angles: [0.0; 2], velocity: [0.0; 2] },
        _ => ControllerState::Arm { gripper: at, velocity, holds: None },
    }
}

/// It attaches, is configured at twice the wall's speed, and answers.
fn attach(of: u32) -> [Record; 3] {
    let head = HeadSpec { neck: Point3::origin(), speed: 1.0, acceleration: 1.0 };
    let limits = ControllerKind::Head(head);
    let message = ToController::Configure { generation: 1, speed: 2.0, limits, start: state(of) };
    [
        controller(0.0, of, ControllerMessage::Attached),
        controller(0.0, of, ControllerMessage::Told { leaf: None, message }),
        heard(0.1, of, FromController::Configured { generation: 1, state: state(of) }),
    ]
}

fn goal(to: u32, leaf: &str, mode: Mode, command: Command) -> Record {
    let message = ToController::Goal { id: id(1), mode, command };
    controller(7.4, to, ControllerMessage::Told { leaf: Some(named(leaf)), message })
}

fn feedback(at_s: f64, of: u32, progress: f64) -> Record {
    heard(at_s, of, FromController::Feedback { id: id(1), progress, state: state(of) })
}

fn answer(from: &str, running: bool, potential: Option<f64>) -> Record {
    let message = Message::Answer {
        running,
        satisfied: false,
        potential,
        asking: Vec::new(),
        request: None,
        blocked: Vec::new(),
    };
    Record::Sent { at: seconds(7.4), round: 2, from: named(from), to: named("object 1"), message }
}

fn held(resource: u32, access: Access, leases: &[(&str, &str, LeaseKind)]) -> Record {
    let lease = |(holder, behavior, hold): &(&str, &str, LeaseKind)| serde_json::json!({"holder": named(holder), "behavior": named(behavior), "kind": hold, "from": null});
    let leases: Vec<_> = leases.iter().map(lease).collect();
    let state = serde_json::json!({"access": access, "leases": leases});
    let state = serde_json::from_value(state).expect("a resource as the journal has it");
    Record::Resource { at: seconds(7.4), resource: ResourceId(resource), state }
}

/// The robot picks two objects at once; the third move waits, the right gripper already holds object 4.
fn picking() -> Vec<Record> {
    let at = Point3::origin();
    let mut records = vec![experiment_1().swap_remove(0)];
    records.extend((0..4).flat_map(attach));
    records.extend(experiment_1().into_iter().skip(1).take(2));
    let why = Reason::Held { resource: ResourceId(0), by: named("pick 1"), channel: Some(ChannelId(0)) };
    let refused = vec![Blocked { leaf: named("move 3-1"), reason: why }];
    let granted = vec![grant("pick 1", &[0, 1], &[2], &["move 1-1"]), grant("pick 2", &[0, 1], &[3], &[])];
    records.extend([
        answer("pick 1", false, Some(9.0)),
        answer("pick 1", true, None),
        answer("move 4-1", false, Some(0.25)),
        Record::Decided {
            at: seconds(7.4),
            round: 2,
            granted,
            refused,
            reopened: None,
            deadlines: Vec::new(),
            urged: None,
            overdue: None,
        },
        held(
            0,
            Access::Shared(ChannelId(0)),
            &[("pick 1", "pick 1", LeaseKind::Running), ("pick 2", "pick 2", LeaseKind::Running)],
        ),
        held(2, Access::Exclusive, &[("pick 1", "pick 1", LeaseKind::Running)]),
        held(3, Access::Exclusive, &[("object 4", "pick 4", LeaseKind::Physical)]),
        Record::World { at: seconds(7.4), change: Change::Taken(ObjectId(3), ResourceId(3)), origin: Origin::Script },
        goal(0, "pick 1", Mode::Maintain, Command::Stand),
        controller(7.4, 0, ControllerMessage::Joined { leaf: named("pick 2"), id: id(1) }),
        goal(2, "pick 1", Mode::Achieve, Command::Grasp { object: ObjectId(0), at, place: None, holder: None }),
        feedback(8.0, 0, 1.0),
        feedback(8.0, 2, 0.45),
    ]);
    records
}

fn snapshot(records: &[Record], daemon: Daemon) -> Snapshot {
    let history = sample::history(records);
    Snapshot::new(&history, daemon, history.now())
}

#[test]
fn a_node_tells_state_potential_and_reason() {
    let nodes = snapshot(&picking(), LIVES).nodes;
    let check = |name: &str, state: LeafState, potential: Option<f64>, reason: Option<&str>| {
        let node = nodes.iter().find(|node| node.name == name).expect("a node");
        assert_eq!((node.state, node.potential, node.reason.as_deref()), (state, potential, reason), "{name}");
    };
    check("move 2-1", LeafState::Done, None, None);
    check("move 1-1", LeafState::Skipped, None, None);
    check("pick 1", LeafState::Active, Some(9.0), None);
    check("move 1-2", LeafState::Waiting, None, Some("its turn comes after pick 1"));
    check("move 3-1", LeafState::Waiting, None, Some("base is held by pick 1 for \"at shelf\""));
    check("move 4-1", LeafState::Waiting, Some(0.25), None);
    check("object 1", LeafState::Active, None, None);
    check("object 4", LeafState::Waiting, None, None);
    let root = &nodes[0];
    assert_eq!((root.state, root.done, root.of), (LeafState::Active, 2, 16));
}

#[test]
fn a_failure_is_told_of_leaf_and_nodes() {
    let aborted = End::Failed(Fault::Aborted(ControllerId(2)));
    let consequences =
        Consequences { completed: None, failed: Some(named("all objects")), failing: None, cleaned: None };
    let mut records = picking();
    records.push(released(9.0, "pick 1", aborted));
    let again = snapshot(&records, LIVES);
    let pick = |snapshot: &Snapshot| {
        let node = &snapshot.nodes[named("pick 1").index()];
        (node.state, node.reason.clone().unwrap_or_default())
    };
    assert_eq!(pick(&again), (LeafState::Waiting, "left_arm gave up".into()), "it is tried again");
    records.extend([
        decided(9.0, 3, vec![grant("pick 1", &[0, 1], &[2], &[])]),
        Record::Released {
            at: seconds(9.5),
            leaf: named("pick 1"),
            end: aborted,
            consequences,
            changes: Vec::new(),
            waits_until: None,
            unfit: Vec::new(),
        },
        released(9.6, "pick 2", End::Canceled),
        Record::Ended { at: seconds(9.6), end: MissionEnd::Failed(named("pick 1")) },
    ]);
    let over = snapshot(&records, Daemon::Gone);
    assert_eq!(pick(&over), (LeafState::Failed, "left_arm gave up".into()));
    assert_eq!(over.nodes[1].state, LeafState::Failed);
    assert_eq!(over.nodes[named("object 2").index()].state, LeafState::Canceled);
    assert_eq!((over.phase, over.outcome), (Phase::Ended, Some(MissionOutcome::Failed)));
    assert_eq!(over.why.as_deref(), Some("pick 1 failed 2 times, at last at 9.50 s: left_arm gave up"));
}

fn diagnosed(at_s: f64, of: u32, message: Diagnosis) -> Record {
    let values = Vitals { worst_gap_ms: Some(830), ..Vitals::default() };
    controller(at_s, of, ControllerMessage::Diagnosed { level: message.level(), message, values: Box::new(values) })
}

#[test]
fn what_only_the_diagnosis_knows_is_told_beside_the_records() {
    let check = |records: &[Record], of: usize, health: Level, why: &str| {
        let row = &snapshot(records, LIVES).controllers[of];
        assert_eq!((row.health, row.why.as_str()), (health, why), "{}", row.name);
    };
    let with = |more: &[Record]| [picking(), more.to_vec()].concat();
    check(&with(&[diagnosed(8.1, 3, Diagnosis::Late)]), 3, Level::Warn, "its signs of life come late");
    check(&with(&[diagnosed(8.1, 3, Diagnosis::Late), diagnosed(8.2, 3, Diagnosis::Serves)]), 3, Level::Ok, "idle");
    let trouble = Diagnosis::Troubled(Trouble::Aborted);
    check(&with(&[diagnosed(8.1, 3, trouble)]), 3, Level::Ok, "idle");
    let lost = controller(8.1, 3, ControllerMessage::Lost { why: Loss::Ended });
    check(&with(&[lost, diagnosed(8.2, 3, Diagnosis::Late)]), 3, Level::Error, "lost at 8.10 s: its process ended");
    let version = "what comes under its name is not used: it speaks another version of the wire";
    let stranger = [picking()[..1].to_vec(), vec![diagnosed(1.0, 1, Diagnosis::Unheard(Rejection::Version))]].concat();
    check(&stranger, 1, Level::Error, version);

    let late = with(&[diagnosed(8.1, 3, Diagnosis::Late)]);
    let of_log = snapshot(&late, LIVES).controllers[3].diagnostics.clone().expect("it was diagnosed");
    assert_eq!((of_log.level, of_log.live, of_log.values.worst_gap_ms), (Level::Warn, false, Some(830)));
    assert_eq!(snapshot(&late, Daemon::Gone).controllers[3].health, Level::Stale);
}

#[test]
fn what_the_daemon_tells_of_the_last_second_has_a_column() {
    let values = Vitals { worst_gap_ms: Some(1234), ..Vitals::default() };
    let (controller, message) = (ControllerId(2), Diagnosis::Serves);
    let told = Diagnostics { controller, level: message.level(), message, values };
    let heads = |snapshot: &Snapshot, width| {
        let lines = snapshot.lines(width, 100, &Palette::plain());
        lines.into_iter().filter(|line| line.starts_with("controller") || line.starts_with("left_arm")).collect()
    };
    let without: Vec<String> = heads(&snapshot(&picking(), LIVES), 80);
    assert!(without.iter().all(|line| !line.contains("gap ms")), "{without:?}");
    let snapshot = snapshot(&picking(), LIVES).with_diagnostics(&[told]);
    let with: Vec<String> = heads(&snapshot, 80);
    assert!(with[0].starts_with("controller  health  gap ms  why"), "{with:?}");
    assert!(with[1].starts_with("left_arm    OK        1234  grasping"), "{with:?}");
    assert_eq!(heads(&snapshot, 50), heads(&self::snapshot(&picking(), LIVES), 50), "a narrow page has no room for it");
    assert!(snapshot.controllers[2].diagnostics.as_ref().is_some_and(|row| row.live));
}

#[test]
fn health_is_told_in_the_words_of_diagnostics() {
    let check = |records: &[Record], daemon: Daemon, now_s: f64, of: usize, health: Level, why: &str| {
        let snapshot = Snapshot::new(&sample::history(records), daemon, seconds(now_s));
        let row = &snapshot.controllers[of];
        assert_eq!((row.health, row.why.as_str()), (health, why), "{}", row.name);
    };
    let header = &picking()[..1];
    check(header, LIVES, 0.0, 1, Level::Stale, "not yet attached");
    check(header, Daemon::Gone, 0.0, 1, Level::Stale, "it never attached");
    check(&picking()[..3], LIVES, 0.0, 0, Level::Warn, "attached, not yet configured");
    check(&picking()[..4], LIVES, 0.1, 0, Level::Ok, "idle");
    check(&picking(), LIVES, 8.9, 2, Level::Ok, "grasping");
    // At twice the wall's speed.
    check(&picking(), LIVES, 9.6, 2, Level::Stale, "silent for 0.8 s while it has a goal");
    check(&picking(), LIVES, 9.6, 3, Level::Ok, "idle");
    check(&picking(), Daemon::Gone, 8.0, 2, Level::Stale, "the daemon is gone");
    let with = |more: &[Record]| [picking(), more.to_vec()].concat();
    let lost = with(&[controller(8.1, 2, ControllerMessage::Lost { why: ambidex_model::Loss::Ended })]);
    check(&lost, LIVES, 8.1, 2, Level::Error, "lost at 8.10 s: its process ended");
    let why = Loss::Inhibited(Inhibition::EmergencyStop);
    let inhibited = with(&[controller(8.1, 2, ControllerMessage::Lost { why })]);
    check(&inhibited, LIVES, 8.1, 2, Level::Error, "inhibited since 8.10 s: emergency stop");
    let why = Rejection::OutOfReach;
    let rejected = with(&[heard(8.1, 2, FromController::Rejected { id: id(1), why })]);
    check(&rejected, LIVES, 8.1, 2, Level::Warn, "rejected pick 1: the point is out of reach");
    let (began, ended, end) = (seconds(7.5), seconds(8.1), PartEnd::Aborted);
    let aborted = with(&[heard(8.1, 2, FromController::Result { id: id(1), end, began, ended, state: state(2) })]);
    check(&aborted, LIVES, 8.1, 2, Level::Warn, "gave up pick 1");
    let refused = with(&[controller(8.1, 2, ControllerMessage::Refused { id: None, why: Rejection::NotFinite })]);
    let said = "a message of it was not used: a number in it is not finite";
    check(&refused, LIVES, 8.1, 2, Level::Warn, said);
    let accepted = FromController::Accepted { id: id(1), at: seconds(8.2) };
    let again = [refused, vec![heard(8.2, 2, accepted)]].concat();
    check(&again, LIVES, 8.2, 2, Level::Ok, "grasping");
    let stopping = ControllerMessage::Told { leaf: None, message: ToController::Cancel { id: id(1) } };
    check(&with(&[controller(8.1, 2, stopping)]), LIVES, 8.1, 2, Level::Ok, "stopping");
}

#[test]
fn what_a_released_behavior_shared_goes_on_for_the_others() {
    let records = [picking(), vec![released(9.0, "pick 1", End::Succeeded)]].concat();
    let base = &snapshot(&records, LIVES).controllers[0];
    assert_eq!(base.goals[0].behaviors, ["pick 2"]);
}

#[test]
fn json_has_the_five_properties_and_the_words_of_the_report() {
    let told = serde_json::to_value(snapshot(&picking(), LIVES)).unwrap();
    assert_eq!(
        told["resources"][3],
        serde_json::json!({
            "name": "right_gripper", "type": "gripper", "owners": 1, "channel": null, "locked": true,
            "unavailable": null,
            "holders": [{"node": "object 4", "behavior": "pick 4", "kind": "physical"}],
            "holds": "object 4", "controller": "right_arm",
        })
    );
    assert_eq!(
        told["controllers"][0],
        serde_json::json!({
            "name": "base", "health": "OK", "why": "standing", "diagnostics": null,
            "goals": [{"behaviors": ["pick 1", "pick 2"], "verb": "standing", "mode": "maintain", "progress": 1.0}],
        })
    );
    assert_eq!(told["daemon"], serde_json::json!({"state": "running", "pid": 7}));
    assert_eq!(told["world"]["objects"][0], serde_json::json!({"name": "object 1", "at": "shelf", "in": []}));
    let ended = experiment_1();
    let report = serde_json::to_value(sample::history(&ended).report()).unwrap();
    let told = serde_json::to_value(snapshot(&ended, Daemon::Gone)).unwrap();
    for key in ["mission", "outcome", "rounds", "messages", "makespan_s"] {
        assert_eq!(told[key], report[key], "{key}");
    }
}

#[test]
fn a_configured_controller_knows_better_what_it_holds() {
    let mut records = picking()[..2].to_vec();
    let holds = Some(ObjectId(1));
    let state = ControllerState::Arm { gripper: Point3::origin(), velocity: Vector3::zeros(), holds };
    records.push(heard(0.1, 2, FromController::Configured { generation: 1, state }));
    let told = snapshot(&records, LIVES);
    assert_eq!(told.resources[2].holds.as_deref(), Some("object 2"));
    assert_eq!(told.world.objects[1].held_by, ["left_gripper"]);
}

#[test]
fn a_journal_of_odd_ids_is_no_reason_to_break() {
    let far = 1_000_000;
    let mut records = experiment_1()[..1].to_vec();
    let Record::Header(header) = &mut records[0] else { panic!("the header is the first") };
    header.movers.clear();
    header.start = None;
    let at = seconds(1.0);
    records.extend([
        Record::World { at, change: Change::Taken(ObjectId(far), ResourceId(far)), origin: Origin::Script },
        Record::World { at, change: Change::Fact(FactId(far), true), origin: Origin::Script },
        Record::Resource { at, resource: ResourceId(far), state: Resource::default() },
        Record::Sent { at, round: 1, from: NodeId(far), to: NodeId(far), message: Message::Activation },
        controller(1.0, far, ControllerMessage::Attached),
        Record::Ended { at, end: MissionEnd::Failed(NodeId(far)) },
    ]);
    let told = snapshot(&records, Daemon::Gone);
    for width in [40, 100] {
        let lines = told.lines(width, 24, &Palette::plain());
        assert!(lines[0].starts_with("experiment 1  failed"), "{lines:?}");
    }
}
