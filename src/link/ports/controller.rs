//! The controller's side of the link, over shared memory.

use std::collections::VecDeque;
use std::fmt;
use std::os::fd::{AsFd, BorrowedFd};

use iceoryx2::active_request::ActiveRequest;

use super::services::{Beats, GoalServer, Listener, Notifier, PulsePublisher, ReportPublisher, Services, ring};
use crate::clock::monotonic_ns;
use crate::error::IpcError;
use crate::instances::Transport;
use crate::node::IpcNode;
use crate::wire::{
    WIRE_VERSION, WireId, WirePulse, WireRequest, WireResponse, read, request_kind, response_kind, write,
};
use ambidex_model::Rejection;
use ambidex_model::motion::FromController;
use ambidex_model::session::{Beat, DEAD_MAN, Pulse, Received, Reported};

type Request = ActiveRequest<Transport, WireRequest, (), WireResponse, ()>;

/// Responses of one stream that may wait for a slow daemon: accepted, the last feedback, the result.
const UNSENT_MAX: usize = 4;

/// A controller's link to whatever daemon its instance has. Readable when something has come.
pub struct ControllerPort {
    streams: Vec<Stream>,
    server: GoalServer,
    pulses: PulsePublisher,
    beats: Beats,
    reports: ReportPublisher,
    notifier: Notifier,
    listener: Listener,
    controller: String,
    _node: IpcNode,
}

/// A request that is being answered, and what of the answer could not be sent yet.
struct Stream {
    request: Request,
    id: WireId,
    unsent: VecDeque<WireResponse>,
    is_over: bool,
}

impl ControllerPort {
    /// Opens the link under the name whose lock the node holds.
    ///
    /// # Errors
    /// [`IpcError`] when the services cannot be had.
    pub fn open(node: &IpcNode, controller: &str) -> Result<Self, IpcError> {
        let services = Services::new(node, controller);
        let port = Self {
            // The listener before the server: a goal may come as soon as that is there.
            listener: services.controller_listener()?,
            notifier: services.daemon_notifier()?,
            beats: services.beats()?,
            reports: services.report_publisher()?,
            pulses: services.pulse_publisher()?,
            server: services.server()?,
            streams: Vec::new(),
            controller: controller.to_owned(),
            _node: node.clone(),
        };
        node.restrict();
        Ok(port)
    }

    /// The newest sign of life of a daemon, if one came since the last call.
    pub fn beat(&mut self) -> Option<Beat> {
        let mut newest: Option<Beat> = None;
        loop {
            match self.beats.receive() {
                Ok(Some(sample)) => {
                    let beat = match read::beat(&sample, monotonic_ns()) {
                        Ok(beat) => beat,
                        Err(why) => {
                            tracing::warn!(controller = self.controller, %why, "a beat was refused");
                            continue;
                        }
                    };
                    // What an earlier, dead daemon published may still lie there.
                    let age_ns = monotonic_ns().saturating_sub(beat.sent_ns);
                    let is_newest = newest.is_none_or(|other| other.sent_ns < beat.sent_ns);
                    if u128::from(age_ns) < DEAD_MAN.as_nanos() && is_newest {
                        newest = Some(beat);
                    }
                }
                Ok(None) => return newest,
                Err(error) => {
                    tracing::warn!(controller = self.controller, %error, "cannot read beats");
                    return newest;
                }
            }
        }
    }

    /// Takes every request that has come; those that cannot be believed are refused here.
    pub fn receive(&mut self) -> Vec<Received> {
        if let Err(error) = self.listener.try_wait(|_| {}) {
            tracing::warn!(controller = self.controller, %error, "cannot listen");
        }
        let mut received = Vec::new();
        loop {
            match self.server.receive() {
                Ok(Some(request)) => received.extend(self.take(request)),
                Ok(None) => return received,
                Err(error) => {
                    tracing::warn!(controller = self.controller, %error, "cannot read requests");
                    return received;
                }
            }
        }
    }

    /// Answers a request of that daemon. What cannot be sent now is sent by [`flush`](Self::flush); feedback is dropped.
    pub fn reply(&mut self, epoch: u64, message: &FromController) {
        let wire = write::response(message, epoch);
        let Some(stream) = self.streams.iter_mut().find(|stream| stream.id == wire.id) else {
            tracing::warn!(controller = self.controller, ?message, "nobody waits for this");
            return;
        };
        stream.push(wire);
        self.flush();
        ring(&self.notifier);
    }

    /// Tries again what could not be sent, and closes the streams that are complete.
    pub fn flush(&mut self) {
        self.streams.retain_mut(|stream| !stream.flush());
    }

    /// Closes all streams: their daemon is gone.
    pub fn detach(&mut self) {
        self.streams.clear();
    }

    /// Publishes the state; `wakes` the daemon or lets it find out by and by.
    pub fn publish(&self, pulse: &Pulse, wakes: bool) {
        let wire = WirePulse {
            version: WIRE_VERSION,
            pid: std::process::id(),
            epoch: pulse.epoch,
            generation: pulse.generation,
            inhibited: write::inhibition_code(pulse.inhibited),
            sent_ns: monotonic_ns(),
            at_us: pulse.at.0,
            state: write::state(&pulse.state),
        };
        if let Err(error) = self.pulses.send_copy(wire) {
            tracing::warn!(controller = self.controller, %error, "cannot publish the state");
        }
        if wakes {
            ring(&self.notifier);
        }
    }

    /// Tells the daemon what is seen of the world, and wakes it; false where it has not read the earlier ones yet.
    pub fn report(&self, said: &Reported) -> bool {
        let sent = self.reports.send_copy(write::report(said));
        if let Err(error) = &sent {
            tracing::debug!(controller = self.controller, %error, "a report waits");
        }
        ring(&self.notifier);
        sent.is_ok()
    }

    fn take(&mut self, request: Request) -> Option<Received> {
        let wire = *request.payload();
        // A cancel's stream may be given up at once; a goal that the daemon gave up must not begin late.
        if wire.kind != request_kind::CANCEL && !request.is_connected() {
            tracing::warn!(controller = self.controller, id = ?wire.id, "its daemon gave it up before it was read");
            return None;
        }
        let mut stream = Stream { request, id: wire.id, unsent: VecDeque::new(), is_over: false };
        let received = match read::request(&wire) {
            Ok(received) => received,
            Err(why) => {
                tracing::warn!(controller = self.controller, id = ?wire.id, %why, "a request was refused");
                stream.push(write::refusal(wire.id, why));
                self.keep(stream);
                return None;
            }
        };
        // A cancel has no answer of its own: the command's stream ends with the result.
        if wire.kind == request_kind::CANCEL {
            return Some(received);
        }
        if self.streams.iter().any(|other| other.id == wire.id) {
            tracing::warn!(controller = self.controller, id = ?wire.id, "an id came twice");
            stream.push(write::refusal(wire.id, Rejection::Stale));
            self.keep(stream);
            return None;
        }
        self.streams.push(stream);
        Some(received)
    }

    fn keep(&mut self, mut stream: Stream) {
        // Under an id that no reply can find, since another stream may have the same.
        stream.id.epoch = 0;
        self.streams.push(stream);
        self.flush();
        ring(&self.notifier);
    }
}

impl Stream {
    fn push(&mut self, wire: WireResponse) {
        let is_feedback = wire.kind == response_kind::FEEDBACK;
        if is_feedback && !self.unsent.is_empty() || self.unsent.len() >= UNSENT_MAX {
            return;
        }
        self.is_over |=
            matches!(wire.kind, response_kind::CONFIGURED | response_kind::REJECTED | response_kind::RESULT);
        self.unsent.push_back(wire);
    }

    /// Sends what waits; true when the stream is complete or nobody reads it.
    fn flush(&mut self) -> bool {
        if !self.request.is_connected() {
            return true;
        }
        while let Some(wire) = self.unsent.front() {
            if let Err(error) = self.request.send_copy(*wire) {
                tracing::debug!(%error, "a response waits");
                return false;
            }
            self.unsent.pop_front();
        }
        self.is_over
    }
}

impl AsFd for ControllerPort {
    fn as_fd(&self) -> BorrowedFd<'_> {
        super::fd_of(&self.listener)
    }
}

impl fmt::Debug for ControllerPort {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("ControllerPort")
            .field("controller", &self.controller)
            .field("streams", &self.streams.len())
            .finish_non_exhaustive()
    }
}
