//! What a controller does with messages and time: attachments, one command at a time, steps, the dead-man.
//!
//! No port and no clock in here: both are handed in, and replies are handed out.

use std::time::Duration;

use super::reporter::{Reported, Reporter};
use super::{Beat, ClockOrigin, DEAD_MAN, PULSE_EVERY, Pulse, REPORT_EVERY, Received};
use crate::motion::{Command, Controller, ControllerState, Executor, FromController, STEP, ToController};
use crate::{CommandId, ControllerKind, Inhibition, Mode, Rejection, Report, Time};

/// The shortest wait between two wakes in motion, wall time.
const WAKE_MIN: Duration = Duration::from_millis(1);
/// How often a command tells how far it is, wall time.
const FEEDBACK_EVERY: Duration = Duration::from_millis(100);

/// A controller and whatever daemon it serves.
#[derive(Debug)]
pub struct Session<C> {
    executor: Executor<C>,
    daemon: Option<Daemon>,
    attached: Option<Attachment>,
    /// A configuration that waits for the motion of the attachment before it to end.
    next: Option<Attachment>,
    is_stopping: bool,
    /// Why it may not move, whatever its body says.
    inhibited: Option<Inhibition>,
    /// Why its body may not move, as it said in the last turn: all that is told in a turn goes by one answer.
    body_inhibited: Option<Inhibition>,
    /// When the last feedback was given.
    told_ns: u64,
    replies: Vec<Reply>,
    reporter: Reporter,
}

/// A message for the daemon of that epoch.
#[derive(Debug, PartialEq)]
pub struct Reply {
    /// Life of the daemon that it answers.
    pub epoch: u64,
    /// What it is told.
    pub message: FromController,
}

#[derive(Debug)]
struct Daemon {
    epoch: u64,
    heard_ns: u64,
    is_gone: bool,
}

#[derive(Debug)]
struct Attachment {
    epoch: u64,
    generation: u32,
    origin: ClockOrigin,
    speed: f64,
    limits: ControllerKind,
    start: ControllerState,
    /// Steps of robot time since its zero: one grid for all controllers.
    step: u64,
    last_number: Option<u32>,
    /// It was inhibited meanwhile.
    is_void: bool,
}

impl<C: Controller> Session<C> {
    /// A controller that serves nobody yet.
    pub fn new(body: C) -> Self {
        let executor = Executor::new(body);
        Self {
            body_inhibited: executor.inhibited(),
            executor,
            daemon: None,
            attached: None,
            told_ns: 0,
            next: None,
            is_stopping: false,
            inhibited: None,
            replies: Vec::new(),
            reporter: Reporter::default(),
        }
    }

    /// A daemon lives.
    pub fn hear_beat(&mut self, beat: Beat) {
        let is_known = self.daemon.as_ref().is_some_and(|daemon| daemon.epoch == beat.epoch && daemon.is_gone);
        self.daemon = Some(Daemon { epoch: beat.epoch, heard_ns: beat.sent_ns, is_gone: is_known });
    }

    /// The process of the daemon that was heard last has ended.
    pub fn hear_end(&mut self) {
        if let Some(daemon) = &mut self.daemon {
            daemon.is_gone = true;
        }
    }

    /// The controller is to end: it brakes, and is [`at_rest`](Self::is_at_rest) by and by.
    pub fn stop(&mut self) {
        self.is_stopping = true;
        self.executor.cancel();
    }

    /// From now on it may not move, or may again as far as its body lets it. Moved on, the session acts by it.
    pub fn inhibit(&mut self, why: Option<Inhibition>) {
        self.inhibited = why;
    }

    /// Why it may not move.
    pub fn inhibited(&self) -> Option<Inhibition> {
        self.inhibited.or(self.body_inhibited)
    }

    /// The controller's process is started anew: it serves nobody and does nothing.
    pub fn restart(&mut self) {
        self.executor.forget();
        (self.daemon, self.attached, self.next) = (None, None, None);
        (self.is_stopping, self.inhibited, self.told_ns) = (false, None, 0);
        self.replies.clear();
        self.reporter.forget_all();
    }

    /// Takes a message from a daemon.
    pub fn take(&mut self, received: Received, now_ns: u64) {
        let Received { message, epoch, origin } = received;
        match message {
            ToController::Configure { generation, speed, limits, start } => self.take_configuration(
                Attachment {
                    epoch,
                    generation,
                    origin,
                    speed,
                    limits,
                    start,
                    step: step_at(origin, speed, now_ns),
                    last_number: None,
                    is_void: false,
                },
                now_ns,
            ),
            ToController::Goal { id, mode, command } => match self.start(epoch, id, mode, &command, now_ns) {
                Ok(at) => self.reply(epoch, FromController::Accepted { id, at }),
                Err(why) => self.reply(epoch, FromController::Rejected { id, why }),
            },
            ToController::Cancel { id } => self.take_cancel(epoch, id),
        }
    }

    /// Moves on to the moment; returns whether the state changed.
    pub fn tick(&mut self, now_ns: u64) -> bool {
        let is_orphan = self.attached.is_some() && self.is_deserted(now_ns);
        if is_orphan || self.next.is_some() {
            self.executor.cancel();
        }
        let has_moved = self.run_steps(now_ns);
        self.body_inhibited = self.executor.inhibited();
        if let Some(why) = self.inhibited() {
            self.halt(why);
        }
        self.feed_back(now_ns);
        if !self.executor.is_busy() {
            if is_orphan {
                self.attached = None;
            }
            if let Some(next) = self.next.take() {
                self.attach(next, now_ns);
            }
        }
        has_moved
    }

    /// What is to be told since the last call, in order.
    pub fn replies(&mut self) -> Vec<Reply> {
        std::mem::take(&mut self.replies)
    }

    /// What is to be told of the world now: what is new, and what was told long ago.
    pub fn reports(&mut self, now_ns: u64) -> Vec<Reported> {
        let Some(attachment) = self.attached.as_ref().filter(|attachment| !attachment.is_void) else {
            return Vec::new();
        };
        let (epoch, generation) = (attachment.epoch, attachment.generation);
        let due = self.reporter.due(self.executor.reports(), now_ns);
        due.into_iter().map(|report| Reported { epoch, generation, report }).collect()
    }

    /// A report could not be sent: it is told again.
    pub fn untold(&mut self, report: &Report) {
        self.reporter.forget(report);
    }

    /// Whether it serves a daemon.
    pub fn is_attached(&self) -> bool {
        self.attached.is_some()
    }

    /// Whether nothing moves.
    pub fn is_at_rest(&self) -> bool {
        !self.executor.is_busy()
    }

    /// State and its moment, as they are published.
    pub fn pulse(&self) -> Pulse {
        let attached = self.attached.as_ref();
        Pulse {
            epoch: attached.map_or(0, |attachment| attachment.epoch),
            generation: attached.filter(|attachment| !attachment.is_void).map_or(0, |attachment| attachment.generation),
            at: attached.map_or(Time::ZERO, Attachment::time),
            inhibited: self.inhibited(),
            state: self.executor.state(),
        }
    }

    /// How long nothing need be done from now on if nothing comes, wall time: until the next step, the next pulse, or the
    /// moment at which the daemon counts as gone.
    pub fn rest(&self, now_ns: u64) -> Duration {
        let most = if self.reporter.is_used() { REPORT_EVERY } else { PULSE_EVERY };
        let rest = match (&self.attached, &self.daemon) {
            (Some(attachment), _) if self.executor.is_busy() => {
                // The speed is any number above 0: a step may last longer than a span can.
                let step = Duration::try_from_secs_f64(STEP.as_secs_f64() / attachment.speed);
                step.map_or(PULSE_EVERY, |step| step.clamp(WAKE_MIN, PULSE_EVERY))
            }
            (Some(_), Some(daemon)) => {
                let silent_for = Duration::from_nanos(now_ns.saturating_sub(daemon.heard_ns));
                DEAD_MAN.saturating_sub(silent_for).clamp(WAKE_MIN, PULSE_EVERY)
            }
            (Some(_) | None, _) => PULSE_EVERY,
        };
        rest.min(most)
    }

    fn take_configuration(&mut self, next: Attachment, now_ns: u64) {
        let is_of_the_living = self.daemon.as_ref().is_some_and(|daemon| {
            let silent_ns = u128::from(now_ns.saturating_sub(daemon.heard_ns));
            daemon.epoch == next.epoch && !daemon.is_gone && silent_ns <= DEAD_MAN.as_nanos()
        });
        let is_newer = |old: &Option<Attachment>| {
            old.as_ref().is_none_or(|old| old.epoch != next.epoch || old.generation < next.generation)
        };
        let is_new = is_newer(&self.attached) && is_newer(&self.next);
        let id = CommandId { generation: next.generation, number: 0 };
        let why = match self.inhibited() {
            Some(why) => Rejection::Inhibited(why),
            None if is_of_the_living && is_new && !self.is_stopping => {
                self.next = Some(next);
                return;
            }
            None => Rejection::Stale,
        };
        self.reply(next.epoch, FromController::Rejected { id, why });
    }

    fn attach(&mut self, mut next: Attachment, now_ns: u64) {
        let state = self.executor.configure(&next.limits, next.start);
        next.step = step_at(next.origin, next.speed, now_ns);
        let (epoch, generation) = (next.epoch, next.generation);
        // Whoever is new has heard nothing yet.
        self.reporter.forget_all();
        self.attached = Some(next);
        self.reply(epoch, FromController::Configured { generation, state });
    }

    fn start(
        &mut self,
        epoch: u64,
        id: CommandId,
        mode: Mode,
        command: &Command,
        now_ns: u64,
    ) -> Result<Time, Rejection> {
        let inhibited = self.inhibited();
        let attachment = self.attached.as_mut().ok_or(Rejection::NotConfigured)?;
        let is_ours = (attachment.epoch, attachment.generation) == (epoch, id.generation);
        let is_new = attachment.last_number.is_none_or(|last| last < id.number);
        if !is_ours || !is_new {
            return Err(Rejection::Stale);
        }
        attachment.last_number = Some(id.number);
        match inhibited {
            Some(why) => return Err(Rejection::Inhibited(why)),
            None if attachment.is_void => return Err(Rejection::NotConfigured),
            None => {}
        }
        if self.next.is_some() || self.is_stopping {
            return Err(Rejection::Busy);
        }
        if !self.executor.is_busy() {
            attachment.step = attachment.step_at(now_ns);
        }
        let began = attachment.time();
        self.executor.begin(id, mode, command, began)?;
        self.told_ns = now_ns;
        Ok(began)
    }

    fn take_cancel(&mut self, epoch: u64, id: CommandId) {
        let is_epoch = |attachment: &Attachment| attachment.epoch == epoch;
        let is_ours = self.attached.as_ref().is_some_and(is_epoch);
        // A cancel may cross the result on its way.
        if is_ours && self.executor.is_doing(id) {
            self.executor.cancel();
        }
    }

    /// Whether the daemon of the attachment shows no life any more.
    fn is_deserted(&self, now_ns: u64) -> bool {
        let (Some(attachment), Some(daemon)) = (&self.attached, &self.daemon) else {
            return true;
        };
        let silent_ns = now_ns.saturating_sub(daemon.heard_ns);
        daemon.is_gone || daemon.epoch != attachment.epoch || u128::from(silent_ns) > DEAD_MAN.as_nanos()
    }

    /// Runs the steps that robot time demands; true if there were any.
    fn run_steps(&mut self, now_ns: u64) -> bool {
        let Some(attachment) = self.attached.as_mut().filter(|_| self.executor.is_busy()) else {
            return false;
        };
        let target = attachment.step_at(now_ns);
        if attachment.is_late(target) {
            // Whoever sleeps for longer than the dead-man allows moves no further.
            attachment.step = target;
            self.executor.cancel();
            return false;
        }
        let before = attachment.step;
        while attachment.step < target {
            attachment.step += 1;
            if let Some(result) = self.executor.step(attachment.time()) {
                let epoch = attachment.epoch;
                self.reply(epoch, result);
                return true;
            }
        }
        attachment.step > before
    }

    /// What is under way ends, and nothing more is taken before the next configuration.
    fn halt(&mut self, why: Inhibition) {
        let Some(attachment) = &mut self.attached else { return };
        attachment.is_void = true;
        let epoch = attachment.epoch;
        if let Some(result) = self.executor.halt(attachment.time(), why) {
            self.reply(epoch, result);
        }
    }

    fn feed_back(&mut self, now_ns: u64) {
        let silent_ns = now_ns.saturating_sub(self.told_ns);
        if u128::from(silent_ns) < FEEDBACK_EVERY.as_nanos() {
            return;
        }
        if let (Some(attachment), Some(feedback)) = (&self.attached, self.executor.feedback()) {
            self.told_ns = now_ns;
            let epoch = attachment.epoch;
            self.reply(epoch, feedback);
        }
    }

    fn reply(&mut self, epoch: u64, message: FromController) {
        self.replies.push(Reply { epoch, message });
    }
}

impl Attachment {
    fn step_at(&self, now_ns: u64) -> u64 {
        step_at(self.origin, self.speed, now_ns)
    }

    /// Robot time of the last step.
    fn time(&self) -> Time {
        Time(self.step.saturating_mul(step_us()))
    }

    /// Whether more robot time has passed than the dead-man allows.
    fn is_late(&self, target: u64) -> bool {
        let behind = target.saturating_sub(self.step) as f64 * STEP.as_secs_f64();
        behind / self.speed > DEAD_MAN.as_secs_f64()
    }
}

fn step_at(origin: ClockOrigin, speed: f64, now_ns: u64) -> u64 {
    origin.time_at(now_ns, speed).0 / step_us()
}

fn step_us() -> u64 {
    STEP.as_micros() as u64
}

#[cfg(test)]
#[path = "controller_tests.rs"]
mod tests;
