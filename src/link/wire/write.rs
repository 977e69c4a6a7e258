//! From the model to the wire: infallible but for what does not fit.

use nalgebra::Point3;

use super::{
    LIMITS_MAX, NO_OBJECT, PATH_MAX, WIRE_VERSION, WireId, WirePose, WireRequest, WireResponse, WireState, command,
    end, mode, rejection, request_kind, response_kind, state_kind,
};
use crate::link::LinkError;
use ambidex_model::session::ClockOrigin;
use ambidex_model::{
    Command, CommandId, ControllerKind, ControllerState, FromController, Mode, ObjectId, PartEnd, Pose, Rejection,
    ToController,
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
        FromController::Rejected { why, .. } => wire.why = rejection_code(*why),
        FromController::Feedback { progress, state: now, .. } => {
            wire.progress = *progress;
            wire.state = state(now);
        }
        FromController::Result { end, began, ended, state: then, .. } => {
            wire.end = end_code(*end);
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
        ..WireResponse::default()
    }
}

pub(crate) fn state(state: &ControllerState) -> WireState {
    match *state {
        ControllerState::Base { pose, velocity } => WireState {
            kind: state_kind::BASE,
            holds: NO_OBJECT,
            position: [pose.at.x, pose.at.y, pose.heading],
            velocity: velocity.into(),
        },
        ControllerState::Arm { gripper, velocity, holds } => WireState {
            kind: state_kind::ARM,
            holds: holds.map_or(NO_OBJECT, |object| object.0),
            position: gripper.into(),
            velocity: velocity.into(),
        },
        ControllerState::Head { angles, velocity } => WireState {
            kind: state_kind::HEAD,
            holds: NO_OBJECT,
            position: [angles[0], angles[1], 0.0],
            velocity: [velocity[0], velocity[1], 0.0],
        },
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
    }
    numbers
}

fn write_command(what: &Command, wire: &mut WireRequest) -> Result<(), LinkError> {
    match what {
        Command::Drive { path } => {
            if !(1..=PATH_MAX).contains(&path.len()) {
                return Err(LinkError::PathLength(path.len()));
            }
            wire.command = command::DRIVE;
            wire.path_len = path.len() as u32;
            for (slot, pose) in wire.path.iter_mut().zip(path) {
                *slot = wire_pose(pose);
            }
        }
        Command::Stand => wire.command = command::STAND,
        Command::Grasp { object, at } => {
            wire.command = command::GRASP;
            write_target(Some(*object), at, wire);
        }
        Command::Put { object, at } => {
            wire.command = command::PUT;
            write_target(Some(*object), at, wire);
        }
        Command::Look { at } => {
            wire.command = command::LOOK;
            write_target(None, at, wire);
        }
    }
    Ok(())
}

fn write_target(object: Option<ObjectId>, at: &Point3<f64>, wire: &mut WireRequest) {
    wire.object = object.map_or(NO_OBJECT, |object| object.0);
    wire.at = (*at).into();
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

fn end_code(what: PartEnd) -> u32 {
    match what {
        PartEnd::Succeeded => end::SUCCEEDED,
        PartEnd::Aborted => end::ABORTED,
        PartEnd::Canceled => end::CANCELED,
    }
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
    }
}
