//! The daemon's side of the link to one controller, over shared memory.

use std::fmt;
use std::os::fd::{AsFd, AsRawFd, BorrowedFd, RawFd};
use std::sync::Arc;

use iceoryx2::pending_response::PendingResponse;
use iceoryx2::port::client::RequestSendError;
use iceoryx2::port::{LoanError, SendError};

use super::services::{BeatPublisher, Goals, Listener, Notifier, Pulses, REPORTS_MAX, Reports, Services, ring};
use crate::clock::monotonic_ns;
use crate::error::IpcError;
use crate::instances::{Transport, check_controller_name};
use crate::link::{Heard, Link, LinkError};
use crate::node::IpcNode;
use crate::wire::{
    WIRE_VERSION, WireBeat, WireId, WirePulse, WireReport, WireRequest, WireResponse, read, request_kind,
    response_kind, write,
};
use ambidex_model::session::ClockOrigin;
use ambidex_model::{CommandId, FromController, Labels, Refusal, Rejection, ToController};

type Stream = PendingResponse<Transport, WireRequest, (), WireResponse, ()>;

/// The link to one controller. Readable when it should be drained.
pub struct DaemonPort {
    streams: Vec<Asked>,
    goals: Goals,
    pulses: Pulses,
    reports: Reports,
    beats: BeatPublisher,
    notifier: Notifier,
    listener: Listener,
    controller: String,
    labels: Arc<Labels>,
    epoch: u64,
    origin: ClockOrigin,
    generation: u32,
    _node: IpcNode,
}

/// A request whose stream is open.
struct Asked {
    stream: Stream,
    kind: u32,
    id: WireId,
    is_answered: bool,
}

impl DaemonPort {
    /// Opens the link to the controller of that name, whether it is there yet or not.
    ///
    /// `labels` are what objects and places of the mission are called; what the controller says of others is refused.
    /// `epoch` is this life of the daemon, one for all its ports: [`fresh_epoch`](crate::fresh_epoch).
    ///
    /// # Errors
    /// [`IpcError`] when the name is none or the services cannot be had.
    ///
    /// # Panics
    /// When the epoch is 0, which stands for no daemon.
    pub fn open(
        node: &IpcNode,
        controller: &str,
        labels: &Arc<Labels>,
        epoch: u64,
        origin: ClockOrigin,
    ) -> Result<Self, IpcError> {
        assert_ne!(epoch, 0, "an epoch of 0 stands for no daemon");
        check_controller_name(controller)?;
        let services = Services::new(node, controller);
        let mut port = Self {
            listener: services.daemon_listener()?,
            notifier: services.controller_notifier()?,
            pulses: services.pulses()?,
            reports: services.reports()?,
            beats: services.beat_publisher()?,
            goals: services.client()?,
            streams: Vec::new(),
            controller: controller.to_owned(),
            labels: Arc::clone(labels),
            epoch,
            origin,
            generation: 0,
            _node: node.clone(),
        };
        node.restrict();
        port.beat();
        ring(&port.notifier);
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
        ring(&self.notifier);
        Ok(stream)
    }

    fn hear_pulses(&mut self, heard: &mut Vec<Heard>) {
        loop {
            match self.pulses.receive() {
                Ok(Some(sample)) => heard.push(self.hear_pulse(&sample)),
                Ok(None) => return,
                Err(error) => {
                    tracing::warn!(controller = self.controller, %error, "cannot read the pulse");
                    return;
                }
            }
        }
    }

    fn hear_pulse(&self, wire: &WirePulse) -> Heard {
        match read::pulse(wire) {
            Ok(pulse) => Heard::Pulse(pulse),
            Err(why) => self.refuse(None, why, "a pulse"),
        }
    }

    /// As many as can wait; who reports faster than that is heard again at the next wake-up.
    fn hear_reports(&mut self, heard: &mut Vec<Heard>) {
        for _ in 0..REPORTS_MAX {
            match self.reports.receive() {
                Ok(Some(sample)) => heard.extend(self.hear_report(&sample)),
                Ok(None) => return,
                Err(error) => {
                    tracing::warn!(controller = self.controller, %error, "cannot read reports");
                    return;
                }
            }
        }
    }

    fn hear_report(&self, wire: &WireReport) -> Option<Heard> {
        match read::report(wire) {
            // What was said in an earlier attachment is said again in this one.
            Ok(said) if (said.epoch, said.generation) != (self.epoch, self.generation) => None,
            Ok(said) => Some(Heard::Report(said.report)),
            Err(why) => Some(self.refuse(None, why, "a report")),
        }
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
            heard.push(Heard::Closed(read::command_id(asked.id)));
        }
        is_open
    }

    fn hear_response(&self, asked: &mut Asked, wire: &WireResponse) -> Heard {
        let message = match read::response(wire).and_then(|message| self.labels.heard(message)) {
            Ok(message) => message,
            Err(why) => return self.refuse_response(asked, wire, why),
        };
        if wire.id != asked.id {
            return self.refuse(None, self.misdirection(wire.id), "a response");
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
            FromController::Configured { .. } => self.refuse(message.id(), Rejection::Unknown, "a response"),
        }
    }

    fn hear_of_other(&self, message: FromController) -> Heard {
        match message {
            FromController::Configured { .. } => Heard::Message(message),
            FromController::Rejected { why, .. } => Heard::Refused(Refusal { id: None, why, is_last: false }),
            FromController::Accepted { .. } | FromController::Feedback { .. } | FromController::Result { .. } => {
                self.refuse(message.id(), Rejection::Unknown, "a response")
            }
        }
    }

    /// A response that cannot be believed. If it was to be the last on a goal, nothing better will come.
    fn refuse_response(&self, asked: &mut Asked, wire: &WireResponse, why: Rejection) -> Heard {
        let is_ours = wire.id == asked.id && asked.kind == request_kind::GOAL;
        let is_last = is_ours && matches!(wire.kind, response_kind::RESULT | response_kind::REJECTED);
        asked.is_answered |= is_last;
        tracing::warn!(controller = self.controller, %why, "a response was refused");
        Heard::Refused(Refusal { id: is_ours.then(|| read::command_id(wire.id)), why, is_last })
    }

    /// Why a response whose id is not its request's is wrong.
    fn misdirection(&self, id: WireId) -> Rejection {
        if (id.epoch, id.generation) == (self.epoch, self.generation) { Rejection::Unknown } else { Rejection::Stale }
    }

    fn refuse(&self, id: Option<CommandId>, why: Rejection, what: &str) -> Heard {
        tracing::warn!(controller = self.controller, %why, "{what} was refused");
        Heard::Refused(Refusal { id, why, is_last: false })
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
        let wire = write::request(&self.labels.told(message), self.epoch, self.origin, self.generation)?;
        let stream = self.post(wire)?;
        self.streams.push(Asked { stream, kind: wire.kind, id: wire.id, is_answered: false });
        Ok(())
    }

    fn drain(&mut self) -> Vec<Heard> {
        if let Err(error) = self.listener.try_wait(|_| {}) {
            tracing::warn!(controller = self.controller, %error, "cannot listen");
        }
        let mut heard = Vec::new();
        self.hear_streams(&mut heard);
        self.hear_pulses(&mut heard);
        self.hear_reports(&mut heard);
        heard
    }

    fn epoch(&self) -> u64 {
        self.epoch
    }

    fn beat(&mut self) {
        let beat =
            WireBeat { version: WIRE_VERSION, pid: std::process::id(), epoch: self.epoch, sent_ns: monotonic_ns() };
        if let Err(error) = self.beats.send_copy(beat) {
            tracing::warn!(controller = self.controller, %error, "cannot beat");
        }
    }

    fn forget(&mut self) {
        self.streams.clear();
    }
}

impl AsRawFd for DaemonPort {
    fn as_raw_fd(&self) -> RawFd {
        super::fd_of(&self.listener).as_raw_fd()
    }
}

impl AsFd for DaemonPort {
    fn as_fd(&self) -> BorrowedFd<'_> {
        super::fd_of(&self.listener)
    }
}

impl fmt::Debug for DaemonPort {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("DaemonPort")
            .field("controller", &self.controller)
            .field("epoch", &self.epoch)
            .field("generation", &self.generation)
            .finish_non_exhaustive()
    }
}

fn refused(error: RequestSendError) -> LinkError {
    match error {
        RequestSendError::ExceedsMaxActiveRequests
        | RequestSendError::SendError(SendError::UnableToDeliver | SendError::LoanError(LoanError::ExceedsMaxLoans)) => {
            LinkError::Full
        }
        RequestSendError::SendError(other) => LinkError::Transport(Box::new(other)),
    }
}
