//! What is counted of a controller, and what the counts of a second say of it. It hears of what happens and decides
//! nothing.

use std::time::Duration;

use super::{BEAT_EVERY, Hearing, PULSE_EVERY, StampedPulse};
use crate::{ControllerId, ControllerMessage, Diagnosis, Diagnostics, FromController, Loss, PartEnd, Rejection};
use crate::{ToController, Trouble, Vitals};

/// How often a controller is diagnosed, wall time. It is the time without a sign of life after which one counts as gone.
pub const DIAGNOSE_EVERY: Duration = Duration::from_secs(1);

/// Wall time without a sign of life that is late: at least one did not come.
const LATE: Duration = PULSE_EVERY.saturating_mul(2);

/// So long after the last diagnosis, which may wait for a beat, the daemon itself did not run: what came late was not late because of the controller.
const AWAY: Duration = DIAGNOSE_EVERY.saturating_add(BEAT_EVERY.saturating_mul(2));

/// What is counted of one controller. Time is handed in, nanoseconds of the clock that both sides share.
#[derive(Debug, Clone)]
pub struct Monitor {
    controller: ControllerId,
    stand: Stand,
    vitals: Vitals,
    /// What went wrong since it took a goal last.
    trouble: Option<Trouble>,
    /// When the newest sign of life was sent.
    sent_ns: Option<u64>,
    /// Messages that wait for it now.
    waiting: u32,
    window: Window,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Stand {
    Absent,
    Attached,
    Configured,
    Away(Loss),
}

/// What is counted anew after each diagnosis.
#[derive(Debug, Clone, Copy, Default)]
struct Window {
    began_ns: u64,
    worst_gap_ns: u64,
    states: u32,
    queued: u32,
    is_doubled: bool,
    refused: Option<Rejection>,
}

impl Monitor {
    /// Of a controller that was not seen yet.
    pub fn new(controller: ControllerId, now_ns: u64) -> Self {
        Self {
            controller,
            stand: Stand::Absent,
            vitals: Vitals::default(),
            trouble: None,
            sent_ns: None,
            waiting: 0,
            window: Window { began_ns: now_ns, ..Window::default() },
        }
    }

    /// A sign of life came, and this is what the daemon made of it.
    pub fn pulsed(&mut self, pulse: &StampedPulse, hearing: Hearing) {
        match hearing {
            Hearing::Taken => {
                let gap_ns = self.sent_ns.map_or(0, |last_ns| pulse.sent_ns.saturating_sub(last_ns));
                self.window.worst_gap_ns = self.window.worst_gap_ns.max(gap_ns);
                self.window.states = self.window.states.saturating_add(1);
                self.sent_ns = Some(pulse.sent_ns);
            }
            Hearing::Old => {}
            Hearing::Foreign { .. } => {
                self.vitals.foreign += 1;
                self.window.is_doubled = true;
            }
        }
    }

    /// So much more came that was not used, and is told of nowhere else.
    pub fn passed_over(&mut self, count: u64) {
        self.vitals.refused = self.vitals.refused.saturating_add(count);
    }

    /// So many messages wait for it now.
    pub fn queued(&mut self, waiting: usize) {
        self.waiting = u32::try_from(waiting).unwrap_or(u32::MAX);
        self.window.queued = self.window.queued.max(self.waiting);
    }

    /// Something was told to it, or heard of it.
    pub fn note(&mut self, message: &ControllerMessage) {
        match message {
            ControllerMessage::Attached => {
                (self.stand, self.trouble) = (Stand::Attached, None);
                self.vitals.attachments += 1;
                // How long it had been away before is no lateness.
                self.window.worst_gap_ns = 0;
            }
            ControllerMessage::Told { message: ToController::Configure { generation, .. }, .. } => {
                self.vitals.generation = *generation;
            }
            ControllerMessage::Told { .. } | ControllerMessage::Joined { .. } => {}
            ControllerMessage::Heard { message } => self.heard(message),
            ControllerMessage::Refused { why, .. } => {
                self.passed_over(1);
                self.window.refused = Some(*why);
                self.fail(Trouble::Refused(*why));
            }
            ControllerMessage::Misreported { why, .. } => self.fail(Trouble::Misreported(*why)),
            ControllerMessage::Lost { why } => {
                self.fail(Trouble::Lost(*why));
                self.stand = Stand::Away(*why);
            }
            ControllerMessage::Diagnosed { .. } => {}
        }
    }

    fn heard(&mut self, message: &FromController) {
        if message.state().is_some() {
            self.window.states = self.window.states.saturating_add(1);
        }
        match message {
            FromController::Configured { .. } => self.stand = Stand::Configured,
            FromController::Accepted { .. } => self.trouble = None,
            FromController::Rejected { why, .. } => self.fail(Trouble::Rejected(*why)),
            FromController::Feedback { .. } => {}
            FromController::Result { end, .. } => match end {
                PartEnd::Aborted => self.fail(Trouble::Aborted),
                PartEnd::Succeeded | PartEnd::Canceled | PartEnd::Inhibited(_) => {}
            },
        }
    }

    fn fail(&mut self, trouble: Trouble) {
        self.trouble = Some(trouble);
        self.vitals.last_fault = Some(trouble);
    }

    /// How well it was since the last diagnosis; counting begins anew.
    pub fn diagnose(&mut self, now_ns: u64) -> Diagnostics {
        let window = std::mem::replace(&mut self.window, Window { began_ns: now_ns, ..Window::default() });
        self.window.queued = self.waiting;
        let length = Duration::from_nanos(now_ns.saturating_sub(window.began_ns));
        let age_ns = self.sent_ns.map(|sent_ns| now_ns.saturating_sub(sent_ns));
        let gap_ns = age_ns.map(|age_ns| age_ns.max(window.worst_gap_ns));
        let inhibited = match self.stand {
            Stand::Away(Loss::Inhibited(why)) => Some(why),
            Stand::Away(_) | Stand::Absent | Stand::Attached | Stand::Configured => None,
        };
        self.vitals = Vitals {
            heartbeat_age_ms: age_ns.map(milliseconds),
            worst_gap_ms: gap_ns.map(milliseconds),
            states_per_s: per_second(window.states, length),
            queued: window.queued,
            inhibited,
            hung: self.stand == Stand::Away(Loss::Hung),
            ..self.vitals
        };
        let is_late = gap_ns.is_some_and(|gap_ns| Duration::from_nanos(gap_ns) >= LATE) && length < AWAY;
        let message = self.diagnosis(&window, is_late);
        Diagnostics { controller: self.controller, level: message.level(), message, values: self.vitals }
    }

    /// The worst that can be said.
    fn diagnosis(&self, window: &Window, is_late: bool) -> Diagnosis {
        match (self.stand, window.refused, self.trouble) {
            (Stand::Away(why), _, _) => Diagnosis::Lost(why),
            (Stand::Absent, Some(why), _) => Diagnosis::Unheard(why),
            (Stand::Absent, None, _) => Diagnosis::Absent,
            (Stand::Attached | Stand::Configured, _, _) if is_late => Diagnosis::Late,
            (Stand::Attached | Stand::Configured, _, _) if window.is_doubled => Diagnosis::Doubled,
            (Stand::Attached, _, _) => Diagnosis::Unconfigured,
            (Stand::Configured, _, _) if self.waiting > 0 => Diagnosis::Backlog,
            (Stand::Configured, _, Some(trouble)) => Diagnosis::Troubled(trouble),
            (Stand::Configured, _, None) => Diagnosis::Serves,
        }
    }
}

fn milliseconds(ns: u64) -> u32 {
    u32::try_from(ns / 1_000_000).unwrap_or(u32::MAX)
}

/// So many within a time, as a rate; rounded.
fn per_second(count: u32, length: Duration) -> u32 {
    if length.is_zero() { 0 } else { (f64::from(count) / length.as_secs_f64()).round() as u32 }
}

#[cfg(test)]
#[path = "monitor_tests.rs"]
mod tests;
