//! From the wire to the model: every number is doubted, and what is wrong has a [`Rejection`].

use std::time::Duration;

use nalgebra::{Point3, Vector3};

use super::{
    LIMITS_MAX, NUMBER_MAX, PATH_MAX, SPEED_MAX, TAKES_MAX_S, WIRE_VERSION, WireBeat, WireId, WireName, WirePose,
    WirePulse, WireReport, WireRequest, WireResponse, WireState, command, end, inhibited, mode, rejection, report_kind,
    request_kind, response_kind, state_kind,
};
use ambidex_model::motion::{Command, ControllerState, FromController, ToController};
use ambidex_model::session::{Beat, ClockOrigin, Pulse, Received, Reported, StampedPulse};
use ambidex_model::{
    ArmSpec, BaseSpec, Call, CommandId, ControllerKind, HeadSpec, Inhibition, Mode, Name, PartEnd, Pose, Rejection,
    Report, Time,
};

/// What the daemon says to a controller.
///
/// # Errors
/// What a controller answers where it is none.
pub fn request(wire: &WireRequest) -> Result<Received, Rejection> {
    check_version(wire.version)?;
    if wire.id.epoch == 0 || wire.id.generation == 0 {
        return Err(Rejection::Malformed);
    }
    let message = match wire.kind {
        request_kind::CONFIGURE => ToController::Configure {
            generation: wire.id.generation,
            speed: speed(wire.speed)?,
            limits: limits(wire.start.kind, wire.limits)?,
            start: state(&wire.start)?,
        },
        request_kind::GOAL => {
            ToController::Goal { id: command_id(wire.id), mode: mode_of(wire.mode)?, command: command_of(wire)? }
        }
        request_kind::CANCEL => ToController::Cancel { id: command_id(wire.id) },
        _ => return Err(Rejection::Malformed),
    };
    Ok(Received { message, epoch: wire.id.epoch, origin: ClockOrigin(wire.origin_ns) })
}

/// What a controller says to the daemon; `latest` is the last moment of robot time that can have been when it was sent.
///
/// # Errors
/// What is wrong with it.
pub fn response(wire: &WireResponse, latest: Time) -> Result<FromController, Rejection> {
    check_version(wire.version)?;
    let id = command_id(wire.id);
    let stamp = |us| if us <= latest.0 { Ok(Time(us)) } else { Err(Rejection::Malformed) };
    Ok(match wire.kind {
        response_kind::CONFIGURED => {
            FromController::Configured { generation: id.generation, state: state(&wire.state)? }
        }
        response_kind::ACCEPTED => FromController::Accepted { id, at: stamp(wire.began_us)? },
        response_kind::REJECTED => FromController::Rejected { id, why: rejection(wire)? },
        response_kind::FEEDBACK => {
            FromController::Feedback { id, progress: progress(wire.progress)?, state: state(&wire.state)? }
        }
        response_kind::RESULT => {
            if wire.ended_us < wire.began_us {
                return Err(Rejection::Malformed);
            }
            FromController::Result {
                id,
                end: end_of(wire)?,
                began: stamp(wire.began_us)?,
                ended: stamp(wire.ended_us)?,
                state: state(&wire.state)?,
            }
        }
        _ => return Err(Rejection::Malformed),
    })
}

/// A controller's sign of life; `now_ns` is a moment after it was received: what is stamped later would count as a sign of
/// life until then.
///
/// # Errors
/// What is wrong with it.
pub fn pulse(wire: &WirePulse, now_ns: u64) -> Result<StampedPulse, Rejection> {
    check_version(wire.version)?;
    if wire.pid == 0 || wire.sent_ns > now_ns {
        return Err(Rejection::Malformed);
    }
    let (epoch, generation, at) = (wire.epoch, wire.generation, Time(wire.at_us));
    let inhibited = inhibition(wire.inhibited)?;
    let pulse = Pulse { epoch, generation, at, inhibited, state: state(&wire.state)? };
    Ok(StampedPulse { pid: wire.pid, sent_ns: wire.sent_ns, pulse })
}

/// The daemon's sign of life; `now_ns` as for a pulse.
///
/// # Errors
/// What is wrong with it.
pub fn beat(wire: &WireBeat, now_ns: u64) -> Result<Beat, Rejection> {
    check_version(wire.version)?;
    if wire.pid == 0 || wire.epoch == 0 || wire.sent_ns > now_ns {
        return Err(Rejection::Malformed);
    }
    Ok(Beat { pid: wire.pid, epoch: wire.epoch, sent_ns: wire.sent_ns })
}

/// What a controller sees of the world.
///
/// # Errors
/// What is wrong with it.
pub fn report(wire: &WireReport) -> Result<Reported, Rejection> {
    check_version(wire.version)?;
    if wire.id.epoch == 0 || wire.id.generation == 0 {
        return Err(Rejection::Malformed);
    }
    let report = match (wire.kind, wire.holds) {
        (report_kind::FACT, holds @ (0 | 1)) => Report::Fact { fact: name(&wire.name)?, holds: holds == 1 },
        (report_kind::OBJECT, _) => Report::Object { object: name(&wire.name)?, at: optional_name(&wire.place)? },
        _ => return Err(Rejection::Malformed),
    };
    Ok(Reported { epoch: wire.id.epoch, generation: wire.id.generation, report })
}

pub(crate) fn command_id(id: WireId) -> CommandId {
    CommandId { generation: id.generation, number: id.number }
}

fn check_version(version: u32) -> Result<(), Rejection> {
    if version == WIRE_VERSION { Ok(()) } else { Err(Rejection::Version) }
}

fn speed(speed: f64) -> Result<f64, Rejection> {
    let speed = finite(speed)?;
    if speed > 0.0 && speed <= SPEED_MAX { Ok(speed) } else { Err(Rejection::Malformed) }
}

fn progress(progress: f64) -> Result<f64, Rejection> {
    let progress = finite(progress)?;
    if (0.0..=1.0).contains(&progress) { Ok(progress) } else { Err(Rejection::Malformed) }
}

fn state(wire: &WireState) -> Result<ControllerState, Rejection> {
    let (position, velocity) = (all_sane(wire.position)?, all_sane(wire.velocity)?);
    match wire.kind {
        state_kind::BASE => Ok(ControllerState::Base {
            pose: Pose::new(position[0], position[1], position[2]),
            velocity: Vector3::from(velocity),
        }),
        state_kind::ARM => Ok(ControllerState::Arm {
            gripper: Point3::from(position),
            velocity: Vector3::from(velocity),
            holds: optional_name(&wire.holds)?,
        }),
        state_kind::DEVICE => Ok(ControllerState::Device),
        state_kind::HEAD => {
            Ok(ControllerState::Head { angles: [position[0], position[1]], velocity: [velocity[0], velocity[1]] })
        }
        _ => Err(Rejection::Malformed),
    }
}

fn limits(kind: u32, numbers: [f64; LIMITS_MAX]) -> Result<ControllerKind, Rejection> {
    let numbers = all_sane(numbers)?;
    let point = |from: usize| Point3::new(numbers[from], numbers[from + 1], numbers[from + 2]);
    let (kind, bounds) = match kind {
        state_kind::BASE => {
            let [speed, acceleration, turn_speed, turn_acceleration, ..] = numbers;
            (ControllerKind::Base(BaseSpec { speed, acceleration, turn_speed, turn_acceleration }), &numbers[..4])
        }
        state_kind::ARM => {
            let [.., reach_m, speed, acceleration, grip_s, lift_m] = numbers;
            let (shoulder, tuck) = (point(0), point(3));
            let arm = ArmSpec { shoulder, tuck, reach_m, speed, acceleration, grip_s, lift_m };
            (ControllerKind::Arm(arm), &numbers[6..9])
        }
        state_kind::HEAD => {
            let (speed, acceleration) = (numbers[3], numbers[4]);
            (ControllerKind::Head(HeadSpec { neck: point(0), speed, acceleration }), &numbers[3..5])
        }
        state_kind::DEVICE => (ControllerKind::Device, &numbers[..0]),
        _ => return Err(Rejection::Malformed),
    };
    if bounds.iter().all(|bound| *bound > 0.0) { Ok(kind) } else { Err(Rejection::Malformed) }
}

fn command_of(wire: &WireRequest) -> Result<Command, Rejection> {
    match wire.command {
        command::DRIVE => Ok(Command::Drive { path: path(wire)?, place: optional_name(&wire.place)? }),
        command::STAND => Ok(Command::Stand),
        command::GRASP => {
            let (object, at) = (name(&wire.object)?, point(wire.at)?);
            let (place, holder) = (optional_name(&wire.place)?, optional_name(&wire.holder)?);
            Ok(Command::Grasp { object, at, place, holder })
        }
        command::PUT => {
            let (object, at) = (name(&wire.object)?, point(wire.at)?);
            let (place, holder) = (optional_name(&wire.place)?, optional_name(&wire.holder)?);
            Ok(Command::Put { object, at, place, holder })
        }
        command::LOOK => Ok(Command::Look { at: point(wire.at)?, place: optional_name(&wire.place)? }),
        command::CALL => Ok(Command::Call(call(wire)?)),
        _ => Err(Rejection::Malformed),
    }
}

fn path(wire: &WireRequest) -> Result<Vec<Pose>, Rejection> {
    let length = wire.path_len as usize;
    if !(1..=PATH_MAX).contains(&length) {
        return Err(Rejection::Malformed);
    }
    wire.path[..length].iter().map(pose).collect()
}

fn pose(wire: &WirePose) -> Result<Pose, Rejection> {
    let [x, y, heading] = all_sane([wire.x, wire.y, wire.heading])?;
    Ok(Pose::new(x, y, heading))
}

fn point(at: [f64; 3]) -> Result<Point3<f64>, Rejection> {
    all_sane(at).map(Point3::from)
}

fn call(wire: &WireRequest) -> Result<Call, Rejection> {
    let takes_s = finite(wire.takes)?;
    if !(0.0..=TAKES_MAX_S).contains(&takes_s) {
        return Err(Rejection::Malformed);
    }
    Ok(Call {
        name: name(&wire.call)?.as_str().to_owned(),
        with: text(&wire.with, wire.with_len)?.to_owned(),
        takes: Duration::from_secs_f64(takes_s),
    })
}

/// A name that must be there.
fn name(wire: &WireName) -> Result<Name, Rejection> {
    optional_name(wire)?.ok_or(Rejection::Malformed)
}

fn optional_name(wire: &WireName) -> Result<Option<Name>, Rejection> {
    let name = Name::from(text(&wire.text, wire.len)?).map_err(|_| Rejection::Malformed)?;
    Ok((!name.is_empty()).then_some(name))
}

fn text(bytes: &[u8], len: u32) -> Result<&str, Rejection> {
    let used = bytes.get(..len as usize).ok_or(Rejection::Malformed)?;
    str::from_utf8(used).map_err(|_| Rejection::Malformed)
}

fn mode_of(code: u32) -> Result<Mode, Rejection> {
    match code {
        mode::ACHIEVE => Ok(Mode::Achieve),
        mode::MAINTAIN => Ok(Mode::Maintain),
        _ => Err(Rejection::Malformed),
    }
}

fn end_of(wire: &WireResponse) -> Result<PartEnd, Rejection> {
    match wire.end {
        end::SUCCEEDED => Ok(PartEnd::Succeeded),
        end::ABORTED => Ok(PartEnd::Aborted),
        end::CANCELED => Ok(PartEnd::Canceled),
        end::INHIBITED => inhibition(wire.inhibited)?.map(PartEnd::Inhibited).ok_or(Rejection::Malformed),
        _ => Err(Rejection::Malformed),
    }
}

fn inhibition(code: u32) -> Result<Option<Inhibition>, Rejection> {
    match code {
        inhibited::NOT => Ok(None),
        inhibited::EMERGENCY_STOP => Ok(Some(Inhibition::EmergencyStop)),
        inhibited::FAULT => Ok(Some(Inhibition::Fault)),
        inhibited::BY_HAND => Ok(Some(Inhibition::ByHand)),
        _ => Err(Rejection::Malformed),
    }
}

fn rejection(wire: &WireResponse) -> Result<Rejection, Rejection> {
    match wire.why {
        rejection::VERSION => Ok(Rejection::Version),
        rejection::STALE => Ok(Rejection::Stale),
        rejection::UNKNOWN => Ok(Rejection::Unknown),
        rejection::MALFORMED => Ok(Rejection::Malformed),
        rejection::NOT_FINITE => Ok(Rejection::NotFinite),
        rejection::NOT_CONFIGURED => Ok(Rejection::NotConfigured),
        rejection::UNSUPPORTED => Ok(Rejection::Unsupported),
        rejection::OUT_OF_REACH => Ok(Rejection::OutOfReach),
        rejection::BUSY => Ok(Rejection::Busy),
        rejection::NO_SUCH_NAME => Ok(Rejection::NoSuchName),
        rejection::INHIBITED => inhibition(wire.inhibited)?.map(Rejection::Inhibited).ok_or(Rejection::Malformed),
        _ => Err(Rejection::Malformed),
    }
}

fn all_sane<const N: usize>(numbers: [f64; N]) -> Result<[f64; N], Rejection> {
    for number in numbers {
        if finite(number)?.abs() > NUMBER_MAX {
            return Err(Rejection::Malformed);
        }
    }
    Ok(numbers)
}

fn finite(number: f64) -> Result<f64, Rejection> {
    if number.is_finite() { Ok(number) } else { Err(Rejection::NotFinite) }
}

#[cfg(test)]
#[path = "tests.rs"]
mod tests;
