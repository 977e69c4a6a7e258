//! A controller of the simulation with both sides of its session.

use std::sync::Arc;

use ambidex_model::motion::Controller;
use ambidex_model::session::{Attendance, Beat, ClockOrigin, Presence, Received, Session, StampedPulse};
use ambidex_model::{FromController, Inhibition, Labels, Refusal, Report, Time, ToController};

/// What a simulated controller moves.
pub type Body = Box<dyn Controller + Send>;

/// The one life of the daemon, and the process that stands for any.
const EPOCH: u64 = 1;
const PID: u32 = 1;

/// A controller and what the daemon knows of it.
pub(super) struct Plant {
    session: Session<Body>,
    presence: Presence,
    labels: Arc<Labels>,
    life: Life,
    /// What it is told while it hangs, for when it goes on.
    unheard: Vec<ToController>,
    /// The attachment that it was told of last, and the last one that is over: what it says of that goes nowhere.
    generation: u32,
    over: u32,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Life {
    Absent,
    Alive,
    /// Its process is there and does nothing.
    Hung,
    Ended,
}

/// What came over the link.
#[derive(Debug, Default)]
pub(super) struct Exchanged {
    pub(super) heard: Vec<Result<FromController, Refusal>>,
    pub(super) attendance: Option<Attendance>,
    pub(super) reports: Vec<Report>,
}

impl Plant {
    pub(super) fn new(body: Body, labels: &Arc<Labels>) -> Self {
        Self {
            session: Session::new(body),
            presence: Presence::new(EPOCH),
            labels: Arc::clone(labels),
            life: Life::Absent,
            unheard: Vec::new(),
            generation: 0,
            over: 0,
        }
    }

    /// Its process is there: started, started again, one that hung and goes on, or one that may move again.
    pub(super) fn start(&mut self) {
        match self.life {
            Life::Absent | Life::Ended => self.session.restart(),
            Life::Alive | Life::Hung => {}
        }
        self.session.inhibit(None);
        self.life = Life::Alive;
    }

    /// From now on it may not move.
    pub(super) fn inhibit(&mut self, why: Inhibition) {
        self.session.inhibit(Some(why));
    }

    pub(super) fn hang(&mut self) {
        self.life = Life::Hung;
    }

    pub(super) fn end(&mut self) {
        self.life = Life::Ended;
        self.unheard.clear();
    }

    /// Whether it moves, so that it must be stepped.
    pub(super) fn is_moving(&self) -> bool {
        self.life == Life::Alive && !self.session.is_at_rest()
    }

    /// When the daemon gives it up, if that is all that will happen.
    pub(super) fn silent_at(&self) -> Option<Time> {
        let at_ns = self.presence.silent_at_ns().filter(|_| self.life == Life::Hung)?;
        Some(Time(at_ns.div_ceil(1000)))
    }

    /// The daemon forgets what it knows of the attachment.
    pub(super) fn reset(&mut self) {
        self.presence = Presence::new(EPOCH);
    }

    /// Brings the session to this moment, with a message for it if there is one.
    pub(super) fn exchange(&mut self, now: Time, message: Option<ToController>) -> Exchanged {
        let now_ns = now.0 * 1000;
        let (mut heard, mut reports) = (Vec::new(), Vec::new());
        if matches!(self.life, Life::Alive | Life::Hung) {
            self.unheard.extend(message);
        }
        if self.life == Life::Alive {
            self.session.hear_beat(Beat { pid: PID, epoch: EPOCH, sent_ns: now_ns });
            for message in self.unheard.drain(..) {
                if let ToController::Configure { generation, .. } = message {
                    self.generation = generation;
                }
                let message = self.labels.told(&message);
                self.session.take(Received { message, epoch: EPOCH, origin: ClockOrigin(0) }, now_ns);
            }
            self.session.tick(now_ns);
            let said = self.session.replies().into_iter().map(|reply| reply.message);
            let said = said.filter(|message| message.id().is_none_or(|id| id.generation > self.over));
            heard.extend(said.map(|message| {
                let (id, is_last) = (message.id(), message.is_last());
                self.labels.heard(message).map_err(|why| Refusal { id, why, is_last })
            }));
            reports.extend(self.session.reports(now_ns).into_iter().map(|reported| reported.report));
            self.presence.hear(&StampedPulse { pid: PID, sent_ns: now_ns, pulse: self.session.pulse() }, now_ns);
        }
        let attendance = self.presence.attend(now_ns, self.life == Life::Ended);
        if matches!(attendance, Some(Attendance::Lost(_) | Attendance::Inhibited { .. })) {
            // What was meant for an attachment that is over is not told to the next.
            self.unheard.clear();
            self.over = self.generation;
        }
        Exchanged { heard, attendance, reports }
    }
}
