//! The daemon's side of the link to one controller, over shared memory.

use std::error::Error;
use std::fmt;
use std::mem::{self, ManuallyDrop};
use std::os::fd::{AsFd, AsRawFd, BorrowedFd, RawFd};
use std::sync::Arc;
use std::time::Duration;

use iceoryx2::pending_response::PendingResponse;
use iceoryx2::port::client::RequestSendError;
use iceoryx2::port::{LoanError, SendError};

use super::answer::Answer;
use super::services::{
    BeatPublisher, Goals, Listener, Notifier, Pulses, REPORTS_MAX, RESPONSES_MAX, Reports, Services, WRITERS_MAX, ring,
};
use crate::clock::monotonic_ns;
use crate::error::IpcError;
use crate::instances::{Transport, check_controller_name};
use crate::link::{Heard, Link, LinkError};
use crate::node::IpcNode;
use crate::wire::{
    WIRE_VERSION, WireBeat, WireId, WirePulse, WireReport, WireRequest, WireResponse, read, response_kind, write,
};
use ambidex_model::session::{ClockOrigin, Pace};
use ambidex_model::{CommandId, FromController, Labels, Refusal, Rejection, ToController};

/// More reports than any honest controller has to tell; a full buffer fits twice.
const INTAKE_MAX: u32 = 2 * REPORTS_MAX as u32;
const INTAKE_WINDOW: Duration = Duration::from_millis(10);
/// Refusals that are told of, so that no log grows by them: enough to see what is wrong.
const REFUSALS_MAX: u32 = 8;
const REFUSALS_WINDOW: Duration = Duration::from_secs(1);

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
    /// Robot seconds per wall second, as the controller was told it.
    speed: f64,
    /// How many reports are read.
    intake: Pace,
    /// How many refusals are told of; last words always are.
    refusals: Pace,
    _node: IpcNode,
}

/// A request whose stream is open.
struct Asked {
    stream: Stream,
    answer: Answer,
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
            speed: 1.0,
            intake: Pace::new(INTAKE_MAX, INTAKE_WINDOW),
            refusals: Pace::new(REFUSALS_MAX, REFUSALS_WINDOW),
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

    /// Lets go of a port whose memory is damaged: what the transport would do in the end is not done.
    pub(super) fn abandon(self) {
        let Self { streams, goals, pulses, reports, beats, notifier, listener, .. } = self;
        mem::forget((streams, goals, pulses, reports, beats, notifier, listener));
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

    /// One of each writer, and one that came meanwhile: who pulses faster than that is heard again at the next wake-up.
    fn hear_pulses(&mut self, heard: &mut Vec<Heard>) {
        for _ in 0..2 * WRITERS_MAX {
            match self.pulses.receive() {
                Ok(Some(sample)) => heard.extend(self.hear_pulse(&sample)),
                Ok(None) => return,
                Err(error) => return self.complain(&error, "cannot read the pulse"),
            }
        }
    }

    fn hear_pulse(&mut self, wire: &WirePulse) -> Option<Heard> {
        match read::pulse(wire, monotonic_ns()) {
            Ok(pulse) => Some(Heard::Pulse(pulse)),
            Err(why) => self.refuse(None, why, "a pulse"),
        }
    }

    /// What comes beyond the pace waits in its buffer, where its sender sees that it is full.
    fn hear_reports(&mut self, heard: &mut Vec<Heard>) {
        while self.intake.spent_until(monotonic_ns()).is_none() {
            match self.reports.receive() {
                Ok(Some(sample)) => {
                    self.intake.takes(monotonic_ns());
                    heard.extend(self.hear_report(&sample));
                }
                Ok(None) => return,
                Err(error) => return self.complain(&error, "cannot read reports"),
            }
        }
    }

    fn hear_report(&mut self, wire: &WireReport) -> Option<Heard> {
        match read::report(wire) {
            // What was said in an earlier attachment is said again in this one.
            Ok(said) if (said.epoch, said.generation) != (self.epoch, self.generation) => None,
            Ok(said) => Some(Heard::Report(said.report)),
            Err(why) => self.refuse(None, why, "a report"),
        }
    }

    fn hear_streams(&mut self, heard: &mut Vec<Heard>) {
        // One that panics over damaged memory must not end them on its way out: their end touches that memory, too.
        let mut streams = ManuallyDrop::new(mem::take(&mut self.streams));
        streams.retain_mut(|asked| self.hear_stream(asked, heard));
        self.streams = ManuallyDrop::into_inner(streams);
    }

    /// Takes what a stream holds; false when it has ended.
    fn hear_stream(&mut self, asked: &mut Asked, heard: &mut Vec<Heard>) -> bool {
        // Asked before the reading: what came before the end is read, what is open is read again.
        let is_open = asked.stream.is_connected();
        for _ in 0..RESPONSES_MAX {
            match asked.stream.receive() {
                Ok(Some(response)) => heard.extend(self.hear_response(&mut asked.answer, &response)),
                Ok(None) => break,
                Err(error) => {
                    self.complain(&error, "cannot read a response");
                    break;
                }
            }
        }
        heard.extend(asked.answer.news(monotonic_ns()).map(Heard::Message));
        let is_over = asked.answer.is_over();
        if !is_open && !is_over && asked.answer.is_of_goal() {
            heard.push(Heard::Closed(read::command_id(asked.answer.id)));
        }
        is_open && !is_over
    }

    fn hear_response(&mut self, answer: &mut Answer, wire: &WireResponse) -> Option<Heard> {
        if answer.is_over() {
            return self.refuse(None, Rejection::Unknown, "a response after the last word");
        }
        // The clocks are one, and a second is more than any rounding.
        let latest = self.origin.time_at(monotonic_ns().saturating_add(1_000_000_000), self.speed);
        let message = match read::response(wire, latest).and_then(|message| self.labels.heard(message)) {
            Ok(message) => message,
            Err(why) => return self.refuse_response(answer, wire, why),
        };
        if wire.id != answer.id {
            return self.refuse(None, self.misdirection(wire.id), "a response");
        }
        let id = message.id();
        match answer.take(message) {
            // Nobody's goal: who does not take a configuration is asked again.
            Ok(Some(FromController::Rejected { why, .. })) if !answer.is_of_goal() => {
                self.refuse(None, why, "a configuration")
            }
            Ok(message) => message.map(Heard::Message),
            Err(why) => self.refuse(id, why, "a response"),
        }
    }

    /// A response that cannot be believed. If it was to be the last on a goal, nothing better will come.
    fn refuse_response(&mut self, answer: &mut Answer, wire: &WireResponse, why: Rejection) -> Option<Heard> {
        let is_ours = wire.id == answer.id && answer.is_of_goal();
        let id = is_ours.then(|| read::command_id(wire.id));
        if is_ours && matches!(wire.kind, response_kind::RESULT | response_kind::REJECTED) {
            answer.end();
            tracing::warn!(controller = self.controller, %why, "a last word was refused");
            return Some(Heard::Refused(Refusal { id, why, is_last: true }));
        }
        self.refuse(id, why, "a response")
    }

    /// Why a response whose id is not its request's is wrong.
    fn misdirection(&self, id: WireId) -> Rejection {
        if (id.epoch, id.generation) == (self.epoch, self.generation) { Rejection::Unknown } else { Rejection::Stale }
    }

    /// Nothing at all if more was refused than is told of.
    fn refuse(&mut self, id: Option<CommandId>, why: Rejection, what: &str) -> Option<Heard> {
        if !self.refusals.takes(monotonic_ns()) {
            return None;
        }
        tracing::warn!(controller = self.controller, %why, "{what} was refused");
        Some(Heard::Refused(Refusal { id, why, is_last: false }))
    }

    fn complain(&mut self, error: &dyn Error, what: &str) {
        if self.refusals.takes(monotonic_ns()) {
            tracing::warn!(controller = self.controller, %error, "{what}");
        }
    }

    fn tell_what_was_passed_over(&mut self) -> Option<Heard> {
        let count = self.refusals.passed_over(monotonic_ns())?;
        tracing::warn!(controller = self.controller, count, "as many more were refused");
        Some(Heard::PassedOver(count))
    }
}

impl Link for DaemonPort {
    fn know(&mut self, labels: &Arc<Labels>) {
        self.labels = Arc::clone(labels);
    }

    fn send(&mut self, message: &ToController) -> Result<(), LinkError> {
        if let ToController::Configure { generation, speed, .. } = message {
            self.forget();
            (self.generation, self.speed) = (*generation, *speed);
            // The controller takes a configuration only from a daemon whose beat it has.
            self.beat();
        }
        let wire = write::request(&self.labels.told(message), self.epoch, self.origin, self.generation)?;
        let stream = self.post(wire)?;
        self.streams.push(Asked { stream, answer: Answer::new(wire.kind, wire.id) });
        Ok(())
    }

    fn drain(&mut self) -> Vec<Heard> {
        if let Err(error) = self.listener.try_wait(|_| {}) {
            self.complain(&error, "cannot listen");
        }
        let mut heard = Vec::from_iter(self.tell_what_was_passed_over());
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

#[cfg(test)]
mod tests {
    use std::thread;
    use std::time::Instant;

    use ambidex_model::Names;

    use super::*;
    use crate::clock::fresh_epoch;
    use crate::instances::Instance;

    #[test]
    fn what_is_refused_beyond_the_pace_is_counted() {
        let node = IpcNode::open(Instance::fresh().lock_daemon().unwrap()).unwrap();
        let labels = Arc::new(Labels::new(&Names::default()));
        let mut port = DaemonPort::open(&node, "arm", &labels, fresh_epoch(), ClockOrigin(monotonic_ns())).unwrap();
        let mut told = 0;
        for _ in 0..REFUSALS_MAX + 12 {
            told += u32::from(port.refuse(None, Rejection::Version, "a pulse").is_some());
        }
        assert_eq!(told, REFUSALS_MAX);
        let by = Instant::now() + 10 * REFUSALS_WINDOW;
        let heard = loop {
            let heard = port.drain();
            assert!(Instant::now() < by, "it is never told");
            if !heard.is_empty() {
                break heard;
            }
            thread::sleep(REFUSALS_WINDOW / 10);
        };
        assert_eq!(heard, [Heard::PassedOver(12)]);
        assert_eq!(port.drain(), [], "told once");
    }
}
