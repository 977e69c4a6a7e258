//! What lies in shared memory: plain structures of fixed size, the same in every language. The contract is `docs/wire.md`.
//!
//! Nothing in them is to be believed before `read` has checked it.

pub mod read;
pub(crate) mod write;

use ambidex_model::{ARGUMENTS_MAX, NAME_MAX};
use iceoryx2::prelude::ZeroCopySend;

/// Version of everything in this file; also part of every type's and service's name.
pub const WIRE_VERSION: u32 = 3;

/// Way points that fit into one message.
pub const PATH_MAX: usize = 64;

/// Numbers that describe a controller: an arm has the most.
pub const LIMITS_MAX: usize = 11;

/// Robot seconds per wall second that a controller takes at most.
pub const SPEED_MAX: f64 = 10_000.0;

/// Greatest number that says where something is, how fast it moves or within which limits: meters, radians, per second.
pub const NUMBER_MAX: f64 = 1e6;

/// Longest text of a call's arguments, bytes.
pub const WITH_MAX: usize = ARGUMENTS_MAX;

/// Longest time that a call is said to take, seconds.
pub const TAKES_MAX_S: f64 = 1e6;

/// Codes of [`WireRequest::kind`].
pub mod request_kind {
    /// `ToController::Configure`.
    pub const CONFIGURE: u32 = 1;
    /// `ToController::Goal`.
    pub const GOAL: u32 = 2;
    /// `ToController::Cancel`.
    pub const CANCEL: u32 = 3;
}

/// Codes of [`WireRequest::mode`].
pub mod mode {
    /// `Mode::Achieve`.
    pub const ACHIEVE: u32 = 1;
    /// `Mode::Maintain`.
    pub const MAINTAIN: u32 = 2;
}

/// Codes of [`WireRequest::command`].
pub mod command {
    /// `Command::Drive`: `path`, `place`.
    pub const DRIVE: u32 = 1;
    /// `Command::Stand`.
    pub const STAND: u32 = 2;
    /// `Command::Grasp`: `object`, `at`, and `place` or `holder`.
    pub const GRASP: u32 = 3;
    /// `Command::Put`: `object`, `at`, and `place` or `holder`.
    pub const PUT: u32 = 4;
    /// `Command::Look`: `at`, `place`.
    pub const LOOK: u32 = 5;
    /// `Command::Call`: `call`, `with`, `takes`.
    pub const CALL: u32 = 6;
}

/// Codes of [`WireResponse::kind`].
pub mod response_kind {
    /// `FromController::Configured`.
    pub const CONFIGURED: u32 = 1;
    /// `FromController::Accepted`.
    pub const ACCEPTED: u32 = 2;
    /// `FromController::Rejected`.
    pub const REJECTED: u32 = 3;
    /// `FromController::Feedback`.
    pub const FEEDBACK: u32 = 4;
    /// `FromController::Result`.
    pub const RESULT: u32 = 5;
}

/// Codes of [`WireResponse::end`].
pub mod end {
    /// `PartEnd::Succeeded`.
    pub const SUCCEEDED: u32 = 1;
    /// `PartEnd::Aborted`.
    pub const ABORTED: u32 = 2;
    /// `PartEnd::Canceled`.
    pub const CANCELED: u32 = 3;
    /// `PartEnd::Inhibited`; `inhibited` says by what.
    pub const INHIBITED: u32 = 4;
}

/// Codes of [`WireResponse::why`].
pub mod rejection {
    /// `Rejection::Version`.
    pub const VERSION: u32 = 1;
    /// `Rejection::Stale`.
    pub const STALE: u32 = 2;
    /// `Rejection::Unknown`.
    pub const UNKNOWN: u32 = 3;
    /// `Rejection::Malformed`.
    pub const MALFORMED: u32 = 4;
    /// `Rejection::NotFinite`.
    pub const NOT_FINITE: u32 = 5;
    /// `Rejection::NotConfigured`.
    pub const NOT_CONFIGURED: u32 = 6;
    /// `Rejection::Unsupported`.
    pub const UNSUPPORTED: u32 = 7;
    /// `Rejection::OutOfReach`.
    pub const OUT_OF_REACH: u32 = 8;
    /// `Rejection::Busy`.
    pub const BUSY: u32 = 9;
    /// `Rejection::NoSuchName`.
    pub const NO_SUCH_NAME: u32 = 10;
    /// `Rejection::Inhibited`; `inhibited` says by what.
    pub const INHIBITED: u32 = 11;
}

/// Codes of [`WirePulse::inhibited`] and [`WireResponse::inhibited`].
pub mod inhibited {
    /// It may move.
    pub const NOT: u32 = 0;
    /// `Inhibition::EmergencyStop`.
    pub const EMERGENCY_STOP: u32 = 1;
    /// `Inhibition::Fault`.
    pub const FAULT: u32 = 2;
    /// `Inhibition::ByHand`.
    pub const BY_HAND: u32 = 3;
}

/// Codes of [`WireState::kind`].
pub mod state_kind {
    /// `ControllerState::Base`: x, y, heading.
    pub const BASE: u32 = 1;
    /// `ControllerState::Arm`: x, y, z of the gripper, and `holds`.
    pub const ARM: u32 = 2;
    /// `ControllerState::Head`: pan, tilt, 0.
    pub const HEAD: u32 = 3;
    /// `ControllerState::Device`: 0, 0, 0.
    pub const DEVICE: u32 = 4;
}

/// Codes of [`WireReport::kind`].
pub mod report_kind {
    /// `Report::Fact`: `name`, `holds`.
    pub const FACT: u32 = 1;
    /// `Report::Object`: `name`, `place`.
    pub const OBJECT: u32 = 2;
}

/// Identity of a request, over all lives of daemon and controller.
#[repr(C)]
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, ZeroCopySend)]
#[type_name("ambidex.Id.v3")]
pub struct WireId {
    /// The life of the daemon.
    pub epoch: u64,
    /// The attachment, counted by the daemon.
    pub generation: u32,
    /// The command, 0 for `CONFIGURE`.
    pub number: u32,
}

/// A pose in the map frame.
#[repr(C)]
#[derive(Debug, Clone, Copy, Default, PartialEq, ZeroCopySend)]
#[type_name("ambidex.Pose.v3")]
pub struct WirePose {
    /// Map frame, meters.
    pub x: f64,
    /// Map frame, meters.
    pub y: f64,
    /// Radians, counter-clockwise from x.
    pub heading: f64,
}

/// Name of an object, a place, a fact, a resource or a call: UTF-8, without a zero at its end.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, ZeroCopySend)]
#[type_name("ambidex.Name.v3")]
pub struct WireName {
    /// Bytes of `text` that are used; 0 for none.
    pub len: u32,
    /// What follows the name is not looked at.
    pub text: [u8; NAME_MAX],
}

/// State of a controller.
#[repr(C)]
#[derive(Debug, Clone, Copy, Default, PartialEq, ZeroCopySend)]
#[type_name("ambidex.State.v3")]
pub struct WireState {
    /// One of [`state_kind`]; says what the numbers are.
    pub kind: u32,
    /// Arm: the object in the gripper; empty for none.
    pub holds: WireName,
    /// Meters and radians.
    pub position: [f64; 3],
    /// The same per second.
    pub velocity: [f64; 3],
}

/// From the daemon to a controller.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, ZeroCopySend)]
#[type_name("ambidex.ToController.v3")]
pub struct WireRequest {
    /// [`WIRE_VERSION`].
    pub version: u32,
    /// One of [`request_kind`].
    pub kind: u32,
    /// What it is about.
    pub id: WireId,
    /// `CONFIGURE`: `CLOCK_MONOTONIC` of robot time zero, nanoseconds.
    pub origin_ns: u64,
    /// `CONFIGURE`: robot seconds per wall second.
    pub speed: f64,
    /// `CONFIGURE`: where a simulated controller starts.
    pub start: WireState,
    /// `GOAL`: one of [`mode`].
    pub mode: u32,
    /// `GOAL`: one of [`command`].
    pub command: u32,
    /// `GOAL`: the object of `GRASP` and `PUT`.
    pub object: WireName,
    /// `GOAL`: the place of `DRIVE`, `GRASP`, `PUT` and `LOOK`; empty for none.
    pub place: WireName,
    /// `GOAL`: what `CALL` calls.
    pub call: WireName,
    /// `GOAL`: the gripper or slot that `GRASP` takes from and `PUT` lets go into; empty for none.
    pub holder: WireName,
    /// `GOAL`: way points of `DRIVE`.
    pub path_len: u32,
    /// `GOAL`: bytes of `with` that are used.
    pub with_len: u32,
    /// `GOAL`: how long `CALL` takes as the robot file says, seconds of robot time.
    pub takes: f64,
    /// `GOAL`: the point of `GRASP`, `PUT` and `LOOK`, base frame, meters.
    pub at: [f64; 3],
    /// `GOAL`: the way points, the goal last.
    pub path: [WirePose; PATH_MAX],
    /// `CONFIGURE`: what it moves within which limits, in the order of the model's fields; `start` says of which kind.
    pub limits: [f64; LIMITS_MAX],
    /// `GOAL`: the arguments of `CALL`, an object of JSON in UTF-8.
    pub with: [u8; WITH_MAX],
}

/// From a controller to the daemon.
#[repr(C)]
#[derive(Debug, Clone, Copy, Default, PartialEq, ZeroCopySend)]
#[type_name("ambidex.FromController.v3")]
pub struct WireResponse {
    /// [`WIRE_VERSION`].
    pub version: u32,
    /// One of [`response_kind`].
    pub kind: u32,
    /// The request's.
    pub id: WireId,
    /// `REJECTED`: one of [`rejection`].
    pub why: u32,
    /// `RESULT`: one of [`end`].
    pub end: u32,
    /// `REJECTED` and `RESULT` by being inhibited: one of [`inhibited`], not 0.
    pub inhibited: u32,
    /// Always 0; keeps what follows aligned.
    pub reserved: u32,
    /// `FEEDBACK`: from 0 to 1.
    pub progress: f64,
    /// `ACCEPTED` and `RESULT`: when it began, robot time, microseconds.
    pub began_us: u64,
    /// `RESULT`: when it ended, robot time, microseconds.
    pub ended_us: u64,
    /// `CONFIGURED`, `FEEDBACK` and `RESULT`: the state then.
    pub state: WireState,
}

/// Published by a controller: sign of life and state.
#[repr(C)]
#[derive(Debug, Clone, Copy, Default, PartialEq, ZeroCopySend)]
#[type_name("ambidex.Pulse.v3")]
pub struct WirePulse {
    /// [`WIRE_VERSION`].
    pub version: u32,
    /// Process id of the controller.
    pub pid: u32,
    /// Epoch of the daemon that it is attached to, 0 if none.
    pub epoch: u64,
    /// The attachment, 0 if none.
    pub generation: u32,
    /// One of [`inhibited`].
    pub inhibited: u32,
    /// `CLOCK_MONOTONIC` when it was sent, nanoseconds.
    pub sent_ns: u64,
    /// Robot time of the state, microseconds; 0 while not attached.
    pub at_us: u64,
    /// Of the kind of the controller.
    pub state: WireState,
}

/// Published by the daemon to each controller: sign of life.
#[repr(C)]
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, ZeroCopySend)]
#[type_name("ambidex.Beat.v3")]
pub struct WireBeat {
    /// [`WIRE_VERSION`].
    pub version: u32,
    /// Process id of the daemon.
    pub pid: u32,
    /// The life of the daemon, never 0.
    pub epoch: u64,
    /// `CLOCK_MONOTONIC` when it was sent, nanoseconds.
    pub sent_ns: u64,
}

/// Published by a controller: what it sees of the world beyond what it moves.
#[repr(C)]
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, ZeroCopySend)]
#[type_name("ambidex.Report.v3")]
pub struct WireReport {
    /// [`WIRE_VERSION`].
    pub version: u32,
    /// One of [`report_kind`].
    pub kind: u32,
    /// The attachment in which it is said; the number is 0.
    pub id: WireId,
    /// `FACT`: 1 it holds, 0 it does not.
    pub holds: u32,
    /// Always 0.
    pub reserved: u32,
    /// The fact or the object; never none.
    pub name: WireName,
    /// `OBJECT`: where it lies; empty where nobody knows.
    pub place: WireName,
}

impl Default for WireName {
    fn default() -> Self {
        Self { len: 0, text: [0; NAME_MAX] }
    }
}

impl Default for WireRequest {
    fn default() -> Self {
        Self {
            version: WIRE_VERSION,
            kind: 0,
            id: WireId::default(),
            origin_ns: 0,
            speed: 0.0,
            start: WireState::default(),
            mode: 0,
            command: 0,
            object: WireName::default(),
            place: WireName::default(),
            call: WireName::default(),
            holder: WireName::default(),
            path_len: 0,
            with_len: 0,
            takes: 0.0,
            at: [0.0; 3],
            path: [WirePose::default(); PATH_MAX],
            limits: [0.0; LIMITS_MAX],
            with: [0; WITH_MAX],
        }
    }
}

#[cfg(test)]
mod tests {
    use std::mem::offset_of;

    use super::*;

    /// The sizes in `docs/wire.md`.
    #[test]
    fn sizes_are_those_of_the_contract() {
        assert_eq!(size_of::<WireId>(), 16);
        assert_eq!(size_of::<WirePose>(), 24);
        assert_eq!(size_of::<WireName>(), 68);
        assert_eq!(size_of::<WireState>(), 120);
        assert_eq!(size_of::<WireRequest>(), 3128);
        assert_eq!(size_of::<WireResponse>(), 184);
        assert_eq!(size_of::<WirePulse>(), 160);
        assert_eq!(size_of::<WireBeat>(), 24);
        assert_eq!(size_of::<WireReport>(), 168);
    }

    /// The offsets in `docs/wire.md`, where something could slip.
    #[test]
    fn fields_lie_where_the_contract_says() {
        assert_eq!((offset_of!(WireState, holds), offset_of!(WireState, position)), (4, 72));
        let names = (offset_of!(WireRequest, object), offset_of!(WireRequest, place), offset_of!(WireRequest, call));
        assert_eq!((offset_of!(WireRequest, mode), names), (160, (168, 236, 304)));
        let lengths = (offset_of!(WireRequest, path_len), offset_of!(WireRequest, with_len));
        assert_eq!((lengths, offset_of!(WireRequest, takes)), ((440, 444), 448));
        let arrays = (offset_of!(WireRequest, path), offset_of!(WireRequest, limits), offset_of!(WireRequest, with));
        assert_eq!((offset_of!(WireRequest, at), arrays), (456, (480, 2016, 2104)));
        assert_eq!((offset_of!(WireResponse, inhibited), offset_of!(WireResponse, state)), (32, 64));
        assert_eq!((offset_of!(WireReport, name), offset_of!(WireReport, place)), (32, 100));
        assert_eq!((offset_of!(WirePulse, inhibited), offset_of!(WirePulse, state)), (20, 40));
    }
}
