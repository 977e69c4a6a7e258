//! The daemon's side of the link to one controller, over shared memory.

use std::fmt;
use std::os::fd::{AsFd, AsRawFd, BorrowedFd, RawFd};
use std::time::Duration;

use iceoryx2::pending_response::PendingResponse;
use iceoryx2::port::client::RequestSendError;
use iceoryx2::port::{LoanError, SendError};

use super::clock::{ClockOrigin, monotonic_ns};
use super::error::IpcError;
use super::instance::check_controller_name;
use super::link::{Heard, Link, LinkError};
use super::services::{BeatPublisher, Bell, Ear, Goals, Pulses, Services, ring};
use super::station::{Station, Transport};
use super::wire::{WIRE_VERSION, WireBeat, WireId, WirePulse, WireRequest, WireResponse, request_kind};
use super::{DEAD_MAN, wire_in, wire_out};
use ambidex_model::{FromController, Rejection, Time, ToController};

type Stream = PendingResponse<Transport, WireRequest, (), WireResponse, ()>;

/// The link to one controller. Readable when it should be drained.
pub struct DaemonPort {
    streams: Vec<Asked>,
    goals: Goals,
    pulses: Pulses,
    beats: BeatPublisher,
    bell: Bell,
    ear: Ear,
    controller: String,
    epoch: u64,
    origin: ClockOrigin,
    generation: u32,
    seen: Option<Seen>,
    _station: Station,
}

/// A request whose stream is open.
struct Asked {
    stream: Stream,
    kind: u32,
    id: WireId,
    is_answered: bool,
}

#[derive(Debug, Clone, Copy)]
struct Seen {
    pid: u32,
    sent_ns: u64,
}

impl DaemonPort {
    /// Opens the link to the controller of that name, whether it is there yet or not.
    ///
    /// `epoch` is this life of the daemon, one for all its ports: [`fresh_epoch`](super::fresh_epoch).
    ///
    /// # Errors
    /// [`IpcError`] when the name is none or the services cannot be had.
    ///
    /// # Panics
    /// When the epoch is 0, which stands for no daemon.
    pub fn open(station: &Station, controller: &str, epoch: u64, origin: ClockOrigin) -> Result<Self, IpcError> {
        assert_ne!(epoch, 0, "an epoch of 0 stands for no daemon");
        check_controller_name(controller)?;
        let services = Services::new(station, controller);
        let mut port = Self {
            ear: services.daemon_ear()?,
            bell: services.controller_bell()?,
            pulses: services.pulses()?,
            beats: services.beat_publisher()?,
            goals: services.client()?,
            streams: Vec::new(),
            controller: controller.to_owned(),
            epoch,
            origin,
            generation: 0,
            seen: None,
            _station: station.clone(),
        };
        port.beat();
        ring(&port.bell);
        Ok(port)
    }

    /// The controller's name.
    pub fn controller(&self) -> &str {
        &self.controller
    }

    fn post(&self, wire: WireRequest) -> Result<Stream, LinkError> {
        let loaned = self.goals.loan_uninit().map_err(|error| refused(error.into()))?;
        let stream = loaned.write_payload(wire).send().map_err(refused)?;
        if stream.number_of_server_connections() == 0 {
            return Err(LinkError::Absent);
        }
        ring(&self.bell);
        Ok(stream)
    }

    fn hear_pulses(&mut self, heard: &mut Vec<Heard>) {
        loop {
            match self.pulses.receive() {
                Ok(Some(sample)) => heard.extend(self.hear_pulse(&sample)),
                Ok(None) => return,
                Err(error) => {
                    tracing::warn!(controller = self.controller, %error, "cannot read the pulse");
                    return;
                }
            }
        }
    }

    fn hear_pulse(&mut self, wire: &WirePulse) -> Option<Heard> {
        // What an earlier, dead controller published may still lie there.
        let is_fresh = age(wire.sent_ns) < DEAD_MAN;
        let is_newest = self.seen.is_none_or(|seen| seen.sent_ns <= wire.sent_ns);
        if !is_fresh || !is_newest {
            return None;
        }
        let state = match wire_in::pulse(wire) {
            Ok(state) => state,
            Err(why) => return Some(self.refuse(why, "a pulse")),
        };
        self.seen = Some(Seen { pid: wire.pid, sent_ns: wire.sent_ns });
        let is_ours = wire.epoch == self.epoch;
        Some(Heard::State {
            at: if is_ours { Time(wire.at_us) } else { Time::ZERO },
            state,
            pid: wire.pid,
            generation: if is_ours { wire.generation } else { 0 },
        })
    }

    fn hear_streams(&mut self, heard: &mut Vec<Heard>) {
        let mut streams = std::mem::take(&mut self.streams);
        streams.retain_mut(|asked| self.hear_stream(asked, heard));
        self.streams = streams;
    }

    /// Takes what a stream holds; false when it has ended.
    fn hear_stream(&self, asked: &mut Asked, heard: &mut Vec<Heard>) -> bool {
        // Asked before the reading: what came before the end is read, what is open is read again.
        let is_open = asked.stream.is_connected();
        loop {
            match asked.stream.receive() {
                Ok(Some(response)) => heard.push(self.hear_response(asked, &response)),
                Ok(None) => break,
                Err(error) => {
                    tracing::warn!(controller = self.controller, %error, "cannot read a response");
                    break;
                }
            }
        }
        if !is_open && !asked.is_answered && asked.kind == request_kind::GOAL {
            heard.push(Heard::Closed(wire_in::command_id(asked.id)));
        }
        is_open
    }

    fn hear_response(&self, asked: &mut Asked, wire: &WireResponse) -> Heard {
        let message = match wire_in::response(wire) {
            Ok(message) => message,
            Err(why) => return self.refuse(why, "a response"),
        };
        if wire.id != asked.id {
            return self.refuse(self.misdirection(wire.id), "a response");
        }
        match asked.kind {
            request_kind::GOAL => self.hear_of_goal(asked, message),
            _ => self.hear_of_other(message),
        }
    }

    fn hear_of_goal(&self, asked: &mut Asked, message: FromController) -> Heard {
        match message {
            FromController::Rejected { .. } | FromController::Result { .. } => {
                asked.is_answered = true;
                Heard::Message(message)
            }
            FromController::Accepted { .. } | FromController::Feedback { .. } => Heard::Message(message),
            FromController::Configured { .. } => self.refuse(Rejection::Unknown, "a response"),
        }
    }

    fn hear_of_other(&self, message: FromController) -> Heard {
        match message {
            FromController::Configured { .. } => Heard::Message(message),
            FromController::Rejected { why, .. } => Heard::Refused(why),
            FromController::Accepted { .. } | FromController::Feedback { .. } | FromController::Result { .. } => {
                self.refuse(Rejection::Unknown, "a response")
            }
        }
    }

    /// Why a response whose id is not its request's is wrong.
    fn misdirection(&self, id: WireId) -> Rejection {
        if (id.epoch, id.generation) == (self.epoch, self.generation) { Rejection::Unknown } else { Rejection::Stale }
    }

    fn refuse(&self, why: Rejection, what: &str) -> Heard {
        tracing::warn!(controller = self.controller, %why, "{what} was refused");
        Heard::Refused(why)
    }
}

impl Link for DaemonPort {
    fn send(&mut self, message: &ToController) -> Result<(), LinkError> {
        if let ToController::Configure { generation, .. } = message {
            self.forget();
            self.generation = *generation;
            // The controller takes a configuration only from a daemon whose beat it has.
            self.beat();
        }
        let wire = wire_out::request(message, self.epoch, self.origin, self.generation)?;
        let stream = self.post(wire)?;
        self.streams.push(Asked { stream, kind: wire.kind, id: wire.id, is_answered: false });
        Ok(())
    }

    fn drain(&mut self) -> Vec<Heard> {
        if let Err(error) = self.ear.try_wait(|_| {}) {
            tracing::warn!(controller = self.controller, %error, "cannot listen");
        }
        let mut heard = Vec::new();
        self.hear_streams(&mut heard);
        self.hear_pulses(&mut heard);
        heard
    }

    fn beat(&mut self) {
        let beat =
            WireBeat { version: WIRE_VERSION, pid: std::process::id(), epoch: self.epoch, sent_ns: monotonic_ns() };
        if let Err(error) = self.beats.send_copy(beat) {
            tracing::warn!(controller = self.controller, %error, "cannot beat");
        }
    }

    fn is_attached(&self) -> Option<u32> {
        let seen = self.seen?;
        (age(seen.sent_ns) < DEAD_MAN).then_some(seen.pid)
    }

    fn forget(&mut self) {
        self.streams.clear();
    }
}

impl AsRawFd for DaemonPort {
    fn as_raw_fd(&self) -> RawFd {
        super::fd_of(&self.ear).as_raw_fd()
    }
}

impl AsFd for DaemonPort {
    fn as_fd(&self) -> BorrowedFd<'_> {
        super::fd_of(&self.ear)
    }
}

impl fmt::Debug for DaemonPort {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("DaemonPort")
            .field("controller", &self.controller)
            .field("epoch", &self.epoch)
            .field("generation", &self.generation)
            .field("seen", &self.seen)
            .finish_non_exhaustive()
    }
}

fn age(sent_ns: u64) -> Duration {
    Duration::from_nanos(monotonic_ns().saturating_sub(sent_ns))
}

fn refused(error: RequestSendError) -> LinkError {
    match error {
        RequestSendError::ExceedsMaxActiveRequests
        | RequestSendError::SendError(SendError::UnableToDeliver | SendError::LoanError(LoanError::ExceedsMaxLoans)) => {
            LinkError::Full
        }
        RequestSendError::SendError(other) => LinkError::Transport(other.to_string()),
    }
}
