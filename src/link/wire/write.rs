//! From the model to the wire: infallible but for what does not fit.

use nalgebra::Point3;

use super::{
    LIMITS_MAX, PATH_MAX, WIRE_VERSION, WITH_MAX, WireId, WireName, WirePose, WireReport, WireRequest, WireResponse,
    WireState, command, end, inhibited, mode, rejection, report_kind, request_kind, response_kind, state_kind,
};
use crate::link::LinkError;
use ambidex_model::motion::{Command, ControllerState, FromController, ToController};
use ambidex_model::session::{ClockOrigin, Reported};
use ambidex_model::{
    Call, CommandId, ControllerKind, Inhibition, Mode, NAME_MAX, Name, PartEnd, Pose, Rejection, Report,
};

pub(crate) fn request(
    message: &ToController,
    epoch: u64,
    origin: ClockOrigin,
    generation: u32,
) -> Result<WireRequest, LinkError> {
    let mut wire = WireRequest::default();
    match message {
        ToController::Configure { generation, speed, limits, start } => {
            wire.kind = request_kind::CONFIGURE;
            wire.id = WireId { epoch, generation: *generation, number: 0 };
            wire.origin_ns = origin.0;
            wire.speed = *speed;
            wire.limits = wire_limits(limits);
            wire.start = state(start);
        }
        ToController::Goal { id, mode, command } => {
            wire.kind = request_kind::GOAL;
            wire.id = wire_id(epoch, *id);
            wire.mode = mode_code(*mode);
            write_command(command, &mut wire)?;
        }
        ToController::Cancel { id } => {
            wire.kind = request_kind::CANCEL;
            wire.id = wire_id(epoch, *id);
        }
    }
    if wire.id.generation != generation {
        return Err(LinkError::Generation(wire.id.generation));
    }
    Ok(wire)
}

pub(crate) fn response(message: &FromController, epoch: u64) -> WireResponse {
    let (id, kind) = match message {
        FromController::Configured { generation, .. } => {
            let id = CommandId { generation: *generation, number: 0 };
            (id, response_kind::CONFIGURED)
        }
        FromController::Accepted { id, .. } => (*id, response_kind::ACCEPTED),
        FromController::Rejected { id, .. } => (*id, response_kind::REJECTED),
        FromController::Feedback { id, .. } => (*id, response_kind::FEEDBACK),
        FromController::Result { id, .. } => (*id, response_kind::RESULT),
    };
    let mut wire = WireResponse { version: WIRE_VERSION, kind, id: wire_id(epoch, id), ..WireResponse::default() };
    match message {
        FromController::Configured { state: now, .. } => wire.state = state(now),
        FromController::Accepted { at, .. } => wire.began_us = at.0,
        FromController::Rejected { why, .. } => {
            wire.why = rejection_code(*why);
            wire.inhibited = inhibition_of_rejection(*why);
        }
        FromController::Feedback { progress, state: now, .. } => {
            wire.progress = *progress;
            wire.state = state(now);
        }
        FromController::Result { end, began, ended, state: then, .. } => {
            (wire.end, wire.inhibited) = end_codes(*end);
            wire.began_us = began.0;
            wire.ended_us = ended.0;
            wire.state = state(then);
        }
    }
    wire
}

/// A refusal of something that could not even be read.
pub(crate) fn refusal(id: WireId, why: Rejection) -> WireResponse {
    WireResponse {
        version: WIRE_VERSION,
        kind: response_kind::REJECTED,
        id,
        why: rejection_code(why),
        inhibited: inhibition_of_rejection(why),
        ..WireResponse::default()
    }
}

pub(crate) fn report(said: &Reported) -> WireReport {
    let id = WireId { epoch: said.epoch, generation: said.generation, number: 0 };
    let (kind, holds, name, place) = match said.report {
        Report::Fact { fact, holds } => (report_kind::FACT, u32::from(holds), fact, None),
        Report::Object { object, at } => (report_kind::OBJECT, 0, object, at),
    };
    WireReport { version: WIRE_VERSION, kind, id, holds, reserved: 0, name: text(&name), place: wire_name(place) }
}

pub(crate) fn state(state: &ControllerState) -> WireState {
    match *state {
        ControllerState::Base { pose, velocity } => WireState {
            kind: state_kind::BASE,
            holds: WireName::default(),
            position: [pose.at.x, pose.at.y, pose.heading],
            velocity: velocity.into(),
        },
        ControllerState::Arm { gripper, velocity, holds } => WireState {
            kind: state_kind::ARM,
            holds: wire_name(holds),
            position: gripper.into(),
            velocity: velocity.into(),
        },
        ControllerState::Head { angles, velocity } => WireState {
            kind: state_kind::HEAD,
            holds: WireName::default(),
            position: [angles[0], angles[1], 0.0],
            velocity: [velocity[0], velocity[1], 0.0],
        },
        ControllerState::Device => WireState { kind: state_kind::DEVICE, ..WireState::default() },
    }
}

fn wire_limits(kind: &ControllerKind) -> [f64; LIMITS_MAX] {
    let mut numbers = [0.0; LIMITS_MAX];
    match kind {
        ControllerKind::Base(base) => {
            numbers[..4].copy_from_slice(&[base.speed, base.acceleration, base.turn_speed, base.turn_acceleration]);
        }
        ControllerKind::Arm(arm) => {
            numbers[..3].copy_from_slice(arm.shoulder.coords.as_slice());
            numbers[3..6].copy_from_slice(arm.tuck.coords.as_slice());
            numbers[6..].copy_from_slice(&[arm.reach_m, arm.speed, arm.acceleration, arm.grip_s, arm.lift_m]);
        }
        ControllerKind::Head(head) => {
            numbers[..3].copy_from_slice(head.neck.coords.as_slice());
            numbers[3..5].copy_from_slice(&[head.speed, head.acceleration]);
        }
        ControllerKind::Device => {}
    }
    numbers
}

fn write_command(what: &Command, wire: &mut WireRequest) -> Result<(), LinkError> {
    match what {
        Command::Drive { path, place } => {
            if !(1..=PATH_MAX).contains(&path.len()) {
                return Err(LinkError::PathLength(path.len()));
            }
            wire.command = command::DRIVE;
            wire.path_len = path.len() as u32;
            wire.place = wire_name(*place);
            for (slot, pose) in wire.path.iter_mut().zip(path) {
                *slot = wire_pose(pose);
            }
        }
        Command::Stand => wire.command = command::STAND,
        Command::Grasp { object, at, place, holder } => {
            wire.command = command::GRASP;
            wire.holder = wire_name(*holder);
            write_target(Some(*object), at, *place, wire);
        }
        Command::Put { object, at, place, holder } => {
            wire.command = command::PUT;
            wire.holder = wire_name(*holder);
            write_target(Some(*object), at, *place, wire);
        }
        Command::Look { at, place } => {
            wire.command = command::LOOK;
            write_target(None, at, *place, wire);
        }
        Command::Call(call) => write_call(call, wire)?,
    }
    Ok(())
}

fn write_target(object: Option<Name>, at: &Point3<f64>, place: Option<Name>, wire: &mut WireRequest) {
    (wire.object, wire.place) = (wire_name(object), wire_name(place));
    wire.at = (*at).into();
}

fn write_call(call: &Call, wire: &mut WireRequest) -> Result<(), LinkError> {
    let (name, with) = (call.name.as_bytes(), call.with.as_bytes());
    if name.len() > NAME_MAX || with.len() > WITH_MAX {
        return Err(LinkError::CallLength { name: name.len(), with: with.len() });
    }
    wire.command = command::CALL;
    wire.call = text(&call.name);
    wire.with[..with.len()].copy_from_slice(with);
    wire.with_len = with.len() as u32;
    wire.takes = call.takes.as_secs_f64();
    Ok(())
}

fn wire_name(name: Option<Name>) -> WireName {
    name.map_or_else(WireName::default, |name| text(&name))
}

/// A text that is known to fit.
fn text(name: &str) -> WireName {
    let mut wire = WireName { len: name.len() as u32, ..WireName::default() };
    wire.text[..name.len()].copy_from_slice(name.as_bytes());
    wire
}

fn wire_id(epoch: u64, id: CommandId) -> WireId {
    WireId { epoch, generation: id.generation, number: id.number }
}

fn wire_pose(pose: &Pose) -> WirePose {
    WirePose { x: pose.at.x, y: pose.at.y, heading: pose.heading }
}

fn mode_code(what: Mode) -> u32 {
    match what {
        Mode::Achieve => mode::ACHIEVE,
        Mode::Maintain => mode::MAINTAIN,
    }
}

/// How it ended, and what inhibited it.
fn end_codes(what: PartEnd) -> (u32, u32) {
    match what {
        PartEnd::Succeeded => (end::SUCCEEDED, inhibited::NOT),
        PartEnd::Aborted => (end::ABORTED, inhibited::NOT),
        PartEnd::Canceled => (end::CANCELED, inhibited::NOT),
        PartEnd::Inhibited(why) => (end::INHIBITED, inhibition_code(Some(why))),
    }
}

pub(crate) fn inhibition_code(why: Option<Inhibition>) -> u32 {
    match why {
        None => inhibited::NOT,
        Some(Inhibition::EmergencyStop) => inhibited::EMERGENCY_STOP,
        Some(Inhibition::Fault) => inhibited::FAULT,
        Some(Inhibition::ByHand) => inhibited::BY_HAND,
    }
}

fn inhibition_of_rejection(why: Rejection) -> u32 {
    let inhibition = if let Rejection::Inhibited(inhibition) = why { Some(inhibition) } else { None };
    inhibition_code(inhibition)
}

fn rejection_code(why: Rejection) -> u32 {
    match why {
        Rejection::Version => rejection::VERSION,
        Rejection::Stale => rejection::STALE,
        Rejection::Unknown => rejection::UNKNOWN,
        Rejection::Malformed => rejection::MALFORMED,
        Rejection::NotFinite => rejection::NOT_FINITE,
        Rejection::NotConfigured => rejection::NOT_CONFIGURED,
        Rejection::Unsupported => rejection::UNSUPPORTED,
        Rejection::OutOfReach => rejection::OUT_OF_REACH,
        Rejection::Busy => rejection::BUSY,
        Rejection::NoSuchName => rejection::NO_SUCH_NAME,
        Rejection::Inhibited(_) => rejection::INHIBITED,
    }
}
