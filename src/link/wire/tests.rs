//! Every message there and back, and every way to be wrong.

use ambidex_model::{NAME_MAX, NO_ARGUMENTS};

use super::super::{WITH_MAX, write};
use super::*;

const EPOCH: u64 = 7_000_000_000;
const ID: CommandId = CommandId { generation: 3, number: 41 };

/// Robot time and nanoseconds when what is read here was received.
const NOW: u64 = 1_000;

fn response(wire: &WireResponse) -> Result<FromController, Rejection> {
    super::response(wire, Time(NOW))
}

fn pulse(wire: &WirePulse) -> Result<StampedPulse, Rejection> {
    super::pulse(wire, NOW)
}

fn beat(wire: &WireBeat) -> Result<Beat, Rejection> {
    super::beat(wire, NOW)
}

fn named(name: &str) -> Name {
    Name::from(name).expect("it fits")
}

fn states() -> Vec<ControllerState> {
    let velocity = Vector3::new(0.1, -0.2, 0.3);
    let gripper = Point3::new(0.7, 0.2, 0.9);
    vec![
        ControllerState::Base { pose: Pose::new(1.0, -2.0, 0.5), velocity },
        ControllerState::Arm { gripper, velocity, holds: None },
        ControllerState::Arm { gripper, velocity, holds: Some(named("red cup é")) },
        ControllerState::Head { angles: [0.1, 0.2], velocity: [0.3, 0.4] },
        ControllerState::Device,
    ]
}

fn limits(start: &ControllerState) -> ControllerKind {
    match start {
        ControllerState::Base { .. } => {
            ControllerKind::Base(BaseSpec { speed: 1.0, acceleration: 0.5, turn_speed: 0.75, turn_acceleration: 0.25 })
        }
        ControllerState::Arm { .. } => ControllerKind::Arm(ArmSpec {
            shoulder: Point3::new(-0.05, 0.2, 0.8),
            tuck: Point3::new(0.2, 0.3, 0.9),
            reach_m: 0.95,
            speed: 0.5,
            acceleration: 0.6,
            grip_s: 0.7,
            lift_m: 0.1,
        }),
        ControllerState::Head { .. } => {
            ControllerKind::Head(HeadSpec { neck: Point3::new(0.0, 0.1, 1.2), speed: 2.0, acceleration: 3.0 })
        }
        ControllerState::Device => ControllerKind::Device,
    }
}

fn commands() -> Vec<Command> {
    let (object, at, place) = (named("cup"), Point3::new(0.5, 0.1, 0.8), Some(named(&"é".repeat(NAME_MAX / 2))));
    let path = |length: usize| (0..length).map(|i| Pose::new(i as f64, 1.0, -0.5)).collect();
    vec![
        Command::Drive { path: path(1), place },
        Command::Drive { path: path(PATH_MAX), place: None },
        Command::Stand,
        Command::Grasp { object, at, place: None, holder: None },
        Command::Put { object, at, place, holder: None },
        Command::Look { at, place },
        Command::Call(call("{\"object\":\"cup\"}")),
        Command::Call(call(&"x".repeat(WITH_MAX))),
        Command::Grasp { object, at, place, holder: None },
        Command::Grasp { object, at, place: None, holder: place },
        Command::Put { object, at, place: None, holder: Some(named("crate")) },
    ]
}

fn call(with: &str) -> Call {
    Call { name: "scan".into(), with: with.into(), takes: Duration::from_millis(2500) }
}

fn goal(command: Command) -> ToController {
    ToController::Goal { id: ID, mode: Mode::Achieve, command }
}

fn configure() -> ToController {
    let start = states()[0];
    ToController::Configure { generation: ID.generation, speed: 20.0, limits: limits(&start), start }
}

fn to_wire(message: &ToController) -> WireRequest {
    write::request(message, EPOCH, ClockOrigin(99), ID.generation).unwrap()
}

#[test]
fn every_request_comes_back_as_it_was() {
    let mut messages: Vec<_> = commands().into_iter().map(goal).collect();
    messages.push(ToController::Goal { id: ID, mode: Mode::Maintain, command: Command::Stand });
    messages.push(ToController::Cancel { id: ID });
    messages.extend(states().into_iter().map(|start| ToController::Configure {
        generation: ID.generation,
        speed: 0.5,
        limits: limits(&start),
        start,
    }));
    for message in messages {
        let received = request(&to_wire(&message)).unwrap();
        assert_eq!((&received.message, received.epoch), (&message, EPOCH));
        if matches!(message, ToController::Configure { .. }) {
            assert_eq!(received.origin, ClockOrigin(99));
        }
    }
}

#[test]
fn every_response_comes_back_as_it_was() {
    let state = states()[1];
    let mut messages = vec![
        FromController::Accepted { id: ID, at: Time(12) },
        FromController::Feedback { id: ID, progress: 0.25, state },
    ];
    messages.extend(states().into_iter().map(|state| FromController::Configured { generation: ID.generation, state }));
    let inhibited = PartEnd::Inhibited(Inhibition::ByHand);
    let ends = [PartEnd::Succeeded, PartEnd::Aborted, PartEnd::Canceled, inhibited];
    messages.extend(ends.map(|end| FromController::Result { id: ID, end, began: Time(12), ended: Time(13), state }));
    let whys = [
        Rejection::Version,
        Rejection::Stale,
        Rejection::Unknown,
        Rejection::Malformed,
        Rejection::NotFinite,
        Rejection::NotConfigured,
        Rejection::Unsupported,
        Rejection::OutOfReach,
        Rejection::Busy,
        Rejection::NoSuchName,
        Rejection::Inhibited(Inhibition::EmergencyStop),
        Rejection::Inhibited(Inhibition::Fault),
    ];
    messages.extend(whys.map(|why| FromController::Rejected { id: ID, why }));
    for message in messages {
        assert_eq!(response(&write::response(&message, EPOCH)), Ok(message));
    }
}

#[test]
fn what_does_not_fit_is_not_sent() {
    use crate::LinkError;
    for length in [0, PATH_MAX + 1] {
        let path = vec![Pose::new(0.0, 0.0, 0.0); length];
        let sent = write::request(&goal(Command::Drive { path, place: None }), EPOCH, ClockOrigin(0), ID.generation);
        assert!(matches!(sent, Err(LinkError::PathLength(other)) if other == length));
    }
    let long = Call { name: "x".repeat(NAME_MAX + 1), ..call(NO_ARGUMENTS) };
    for call in [long, call(&"x".repeat(WITH_MAX + 1))] {
        let sent = write::request(&goal(Command::Call(call)), EPOCH, ClockOrigin(0), ID.generation);
        assert!(matches!(sent, Err(LinkError::CallLength { .. })));
    }
    let sent = write::request(&goal(Command::Stand), EPOCH, ClockOrigin(0), 4);
    assert!(matches!(sent, Err(LinkError::Generation(3))));
}

#[test]
fn wrong_requests_are_refused() {
    type Spoil = fn(&mut WireRequest);
    let rows: [(ToController, Spoil, Rejection); 34] = [
        (configure(), |w| w.limits[1] = f64::NAN, Rejection::NotFinite),
        (configure(), |w| w.limits[0] = 0.0, Rejection::Malformed),
        (configure(), |w| w.version = 0, Rejection::Version),
        (configure(), |w| w.version = 1, Rejection::Version),
        (configure(), |w| w.kind = 0, Rejection::Malformed),
        (configure(), |w| w.kind = 4, Rejection::Malformed),
        (configure(), |w| w.id.epoch = 0, Rejection::Malformed),
        (configure(), |w| w.id.generation = 0, Rejection::Malformed),
        (configure(), |w| w.speed = f64::NAN, Rejection::NotFinite),
        (configure(), |w| w.speed = 0.0, Rejection::Malformed),
        (configure(), |w| w.speed = -1.0, Rejection::Malformed),
        (configure(), |w| w.speed = 1e9, Rejection::Malformed),
        (configure(), |w| w.start.kind = 9, Rejection::Malformed),
        (configure(), |w| w.start.position[2] = f64::INFINITY, Rejection::NotFinite),
        (configure(), |w| w.start.velocity[0] = f64::NAN, Rejection::NotFinite),
        (goal(Command::Stand), |w| w.mode = 0, Rejection::Malformed),
        (goal(Command::Stand), |w| w.mode = 3, Rejection::Malformed),
        (goal(Command::Stand), |w| w.command = 7, Rejection::Malformed),
        (goal(commands()[0].clone()), |w| w.path_len = 0, Rejection::Malformed),
        (goal(commands()[0].clone()), |w| w.path_len = 65, Rejection::Malformed),
        (goal(commands()[1].clone()), |w| w.path[63].x = f64::NAN, Rejection::NotFinite),
        (goal(commands()[3].clone()), |w| w.object.len = 0, Rejection::Malformed),
        (goal(commands()[3].clone()), |w| w.object.len = NAME_MAX as u32 + 1, Rejection::Malformed),
        (goal(commands()[3].clone()), |w| w.object.len = u32::MAX, Rejection::Malformed),
        (goal(commands()[3].clone()), |w| w.object.text[1] = 0xff, Rejection::Malformed),
        (goal(commands()[4].clone()), |w| w.place.len = 3, Rejection::Malformed),
        (goal(commands()[6].clone()), |w| w.call.len = 0, Rejection::Malformed),
        (goal(commands()[6].clone()), |w| w.with_len = WITH_MAX as u32 + 1, Rejection::Malformed),
        (goal(commands()[6].clone()), |w| w.with[0] = 0x80, Rejection::Malformed),
        (goal(commands()[6].clone()), |w| w.takes = -1.0, Rejection::Malformed),
        (goal(commands()[6].clone()), |w| w.takes = f64::NAN, Rejection::NotFinite),
        (goal(commands()[6].clone()), |w| w.takes = 1e300, Rejection::Malformed),
        (goal(commands()[4].clone()), |w| w.at[1] = f64::NAN, Rejection::NotFinite),
        (goal(commands()[5].clone()), |w| w.at[0] = f64::INFINITY, Rejection::NotFinite),
    ];
    for (row, (message, spoil, why)) in rows.into_iter().enumerate() {
        let mut wire = to_wire(&message);
        spoil(&mut wire);
        assert_eq!(request(&wire), Err(why), "row {row}");
    }
    // What is not used is not looked at.
    let mut wire = to_wire(&goal(commands()[0].clone()));
    wire.path[1].x = f64::NAN;
    (wire.object.len, wire.call.text[0]) = (u32::MAX, 0xff);
    assert!(request(&wire).is_ok());
    let mut wire = to_wire(&goal(commands()[3].clone()));
    wire.object.text[3..].fill(0xff);
    assert!(request(&wire).is_ok());
}

#[test]
fn wrong_responses_are_refused() {
    type Spoil = fn(&mut WireResponse);
    let state = states()[0];
    let result = FromController::Result { id: ID, end: PartEnd::Succeeded, began: Time(5), ended: Time(6), state };
    let feedback = FromController::Feedback { id: ID, progress: 0.5, state };
    let rejected = FromController::Rejected { id: ID, why: Rejection::Busy };
    let inhibited = FromController::Rejected { id: ID, why: Rejection::Inhibited(Inhibition::Fault) };
    let holding = FromController::Configured { generation: ID.generation, state: states()[2] };
    let accepted = FromController::Accepted { id: ID, at: Time(5) };
    let rows: [(&FromController, Spoil, Rejection); 23] = [
        (&accepted, |w| w.began_us = NOW + 1, Rejection::Malformed),
        (&result, |w| w.ended_us = NOW + 1, Rejection::Malformed),
        (&result, |w| (w.began_us, w.ended_us) = (u64::MAX, u64::MAX), Rejection::Malformed),
        (&result, |w| w.state.position[2] = 1e308, Rejection::Malformed),
        (&result, |w| w.state.velocity[0] = -1e308, Rejection::Malformed),
        (&feedback, |w| w.state.position[1] = -1.1 * NUMBER_MAX, Rejection::Malformed),
        (&result, |w| w.version = 9, Rejection::Version),
        (&result, |w| w.kind = 0, Rejection::Malformed),
        (&result, |w| w.kind = 6, Rejection::Malformed),
        (&result, |w| w.end = 0, Rejection::Malformed),
        (&result, |w| w.ended_us = 4, Rejection::Malformed),
        (&result, |w| w.state.position[0] = f64::NAN, Rejection::NotFinite),
        (&feedback, |w| w.progress = f64::NAN, Rejection::NotFinite),
        (&feedback, |w| w.progress = 1.5, Rejection::Malformed),
        (&feedback, |w| w.state.kind = 0, Rejection::Malformed),
        (&rejected, |w| w.why = 0, Rejection::Malformed),
        (&rejected, |w| w.why = 12, Rejection::Malformed),
        (&rejected, |w| w.why = 11, Rejection::Malformed),
        (&inhibited, |w| w.inhibited = 4, Rejection::Malformed),
        (&result, |w| w.end = 4, Rejection::Malformed),
        (&result, |w| w.end = 5, Rejection::Malformed),
        (&holding, |w| w.state.holds.len = 65, Rejection::Malformed),
        (&holding, |w| w.state.holds.text[0] = 0xc3, Rejection::Malformed),
    ];
    for (row, (message, spoil, why)) in rows.into_iter().enumerate() {
        let mut wire = write::response(message, EPOCH);
        spoil(&mut wire);
        assert_eq!(response(&wire), Err(why), "row {row}");
    }
}

#[test]
fn wrong_signs_of_life_are_refused() {
    let good = WireBeat { version: WIRE_VERSION, pid: 1, epoch: 1, sent_ns: 0 };
    assert_eq!(beat(&good), Ok(Beat { pid: 1, epoch: 1, sent_ns: 0 }));
    assert_eq!(beat(&WireBeat { sent_ns: NOW, ..good }).map(|beat| beat.sent_ns), Ok(NOW));
    assert_eq!(beat(&WireBeat { sent_ns: NOW + 1, ..good }), Err(Rejection::Malformed), "of the future");
    assert_eq!(beat(&WireBeat { version: 0, ..good }), Err(Rejection::Version));
    assert_eq!(beat(&WireBeat { pid: 0, ..good }), Err(Rejection::Malformed));
    assert_eq!(beat(&WireBeat { epoch: 0, ..good }), Err(Rejection::Malformed));

    let good = WirePulse { version: WIRE_VERSION, pid: 1, state: write::state(&states()[3]), ..WirePulse::default() };
    assert_eq!(pulse(&good).map(|pulse| pulse.pulse.state), Ok(states()[3]));
    assert_eq!(pulse(&WirePulse { sent_ns: NOW, ..good }).map(|pulse| pulse.sent_ns), Ok(NOW));
    for ahead in [NOW + 1, u64::MAX] {
        assert_eq!(pulse(&WirePulse { sent_ns: ahead, ..good }), Err(Rejection::Malformed), "of the future");
    }
    assert_eq!(pulse(&WirePulse { version: 0, ..good }), Err(Rejection::Version));
    assert_eq!(pulse(&WirePulse { pid: 0, ..good }), Err(Rejection::Malformed));
    let stopped = WirePulse { inhibited: 1, ..good };
    assert_eq!(pulse(&stopped).map(|pulse| pulse.pulse.inhibited), Ok(Some(Inhibition::EmergencyStop)));
    assert_eq!(pulse(&WirePulse { inhibited: 4, ..good }), Err(Rejection::Malformed));
    let state = WireState::default();
    assert_eq!(pulse(&WirePulse { state, ..good }), Err(Rejection::Malformed));
}

#[test]
fn every_report_comes_back_and_wrong_ones_are_refused() {
    let long = "é".repeat(NAME_MAX / 2);
    let reports = [
        Report::fact("door open", true),
        Report::fact(&long, false),
        Report::object("red cup", Some(&long)),
        Report::object("red cup", None),
    ];
    let said = |report| Reported { epoch: EPOCH, generation: ID.generation, report };
    for sent in reports.map(said) {
        assert_eq!(report(&write::report(&sent)), Ok(sent));
    }
    type Spoil = fn(&mut WireReport);
    let rows: [(Report, Spoil, Rejection); 11] = [
        (reports[0], |w| w.version = 2, Rejection::Version),
        (reports[0], |w| w.id.epoch = 0, Rejection::Malformed),
        (reports[0], |w| w.id.generation = 0, Rejection::Malformed),
        (reports[0], |w| w.kind = 0, Rejection::Malformed),
        (reports[0], |w| w.kind = 3, Rejection::Malformed),
        (reports[0], |w| w.holds = 2, Rejection::Malformed),
        (reports[0], |w| w.name.len = 0, Rejection::Malformed),
        (reports[0], |w| w.name.len = u32::MAX, Rejection::Malformed),
        (reports[0], |w| w.name.text[0] = 0xff, Rejection::Malformed),
        (reports[2], |w| w.place.len = NAME_MAX as u32 + 1, Rejection::Malformed),
        (reports[2], |w| w.place.text[1] = 0xff, Rejection::Malformed),
    ];
    for (row, (sent, spoil, why)) in rows.into_iter().enumerate() {
        let mut wire = write::report(&said(sent));
        spoil(&mut wire);
        assert_eq!(report(&wire), Err(why), "row {row}");
    }
    // What is not used is not looked at.
    let mut wire = write::report(&said(reports[0]));
    (wire.place.len, wire.reserved) = (u32::MAX, 7);
    assert!(report(&wire).is_ok());
}
