//! The daemon's side of a session: whether the controller is there, serves, or is gone.

use std::time::Duration;

use super::{DEAD_MAN, StampedPulse};

/// What a daemon knows of one controller's life.
#[derive(Debug, Clone, Copy)]
pub struct Presence {
    epoch: u64,
    seen: Option<Seen>,
    is_attached: bool,
    /// It has shown that it is configured by this daemon.
    serves: bool,
    has_left: bool,
}

#[derive(Debug, Clone, Copy)]
struct Seen {
    pid: u32,
    sent_ns: u64,
}

/// What became of a controller's attachment.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Attendance {
    /// It is there, in this process, and can be configured.
    Attached {
        /// Process id, to be watched for its end.
        pid: u32,
    },
    /// It ended, fell silent, or gave this daemon up.
    Lost,
}

impl Presence {
    /// Of a controller that was not seen yet, for the daemon of this epoch.
    pub fn new(epoch: u64) -> Self {
        Self { epoch, seen: None, is_attached: false, serves: false, has_left: false }
    }

    /// Takes a sign of life. True if it says anything: what an earlier, dead controller published may still lie there.
    pub fn hear(&mut self, pulse: &StampedPulse, now_ns: u64) -> bool {
        let is_newest = self.seen.is_none_or(|seen| seen.sent_ns <= pulse.sent_ns);
        if !is_fresh(pulse.sent_ns, now_ns) || !is_newest {
            return false;
        }
        self.seen = Some(Seen { pid: pulse.pid, sent_ns: pulse.sent_ns });
        let serves = self.generation(pulse) != 0;
        // It gave this daemon up, as one that was silent for too long.
        self.has_left |= self.serves && !serves;
        self.serves = serves;
        true
    }

    /// The attachment to this daemon that a pulse tells of, 0 if none.
    pub fn generation(&self, pulse: &StampedPulse) -> u32 {
        if pulse.pulse.epoch == self.epoch { pulse.pulse.generation } else { 0 }
    }

    /// The controller's process, if it showed a sign of life within [`DEAD_MAN`].
    pub fn pid(&self, now_ns: u64) -> Option<u32> {
        self.seen.filter(|seen| is_fresh(seen.sent_ns, now_ns)).map(|seen| seen.pid)
    }

    /// When the controller counts as gone if nothing more is heard, nanoseconds; none while it is not attached.
    pub fn silent_at_ns(&self) -> Option<u64> {
        let dead_man_ns = u64::try_from(DEAD_MAN.as_nanos()).unwrap_or(u64::MAX);
        self.seen.filter(|_| self.is_attached).map(|seen| seen.sent_ns.saturating_add(dead_man_ns))
    }

    /// What has changed by now; `has_ended` says that its process has.
    pub fn attend(&mut self, now_ns: u64, has_ended: bool) -> Option<Attendance> {
        let is_gone = std::mem::take(&mut self.has_left) || has_ended;
        match (self.is_attached, self.pid(now_ns)) {
            (false, Some(pid)) if !is_gone => {
                self.is_attached = true;
                Some(Attendance::Attached { pid })
            }
            (true, Some(_)) if !is_gone => None,
            (true, _) => {
                (self.is_attached, self.serves) = (false, false);
                Some(Attendance::Lost)
            }
            (false, _) => None,
        }
    }
}

fn is_fresh(sent_ns: u64, now_ns: u64) -> bool {
    Duration::from_nanos(now_ns.saturating_sub(sent_ns)) < DEAD_MAN
}

#[cfg(test)]
mod tests {
    use super::super::Pulse;
    use super::*;
    use crate::{ControllerState, Time};

    const MS: u64 = 1_000_000;

    fn pulse(sent_ms: u64, epoch: u64, generation: u32) -> StampedPulse {
        let state = ControllerState::Head { angles: [0.0; 2], velocity: [0.0; 2] };
        let pulse = Pulse { epoch, generation, at: Time::ZERO, state };
        StampedPulse { pid: 7, sent_ns: sent_ms * MS, pulse }
    }

    #[test]
    fn a_controller_comes_serves_and_goes() {
        let mut presence = Presence::new(5);
        assert_eq!(presence.attend(0, false), None);
        assert!(presence.hear(&pulse(10, 0, 0), 10 * MS));
        assert_eq!(presence.attend(10 * MS, false), Some(Attendance::Attached { pid: 7 }));
        assert_eq!(presence.attend(20 * MS, false), None);
        assert!(presence.hear(&pulse(20, 5, 1), 20 * MS));
        assert_eq!(presence.silent_at_ns(), Some(1020 * MS));
        assert_eq!(presence.attend(1019 * MS, false), None);
        assert_eq!(presence.attend(1020 * MS, false), Some(Attendance::Lost), "silent for the dead-man's time");
        assert_eq!((presence.silent_at_ns(), presence.attend(1020 * MS, false)), (None, None));
    }

    #[test]
    fn an_ended_process_and_a_deserter_are_lost_at_once() {
        for (deserts, has_ended) in [(true, false), (false, true)] {
            let mut presence = Presence::new(5);
            presence.hear(&pulse(10, 5, 1), 10 * MS);
            assert!(presence.attend(10 * MS, false).is_some());
            if deserts {
                // Attached to another daemon now.
                presence.hear(&pulse(11, 6, 1), 11 * MS);
            }
            assert_eq!(presence.attend(11 * MS, has_ended), Some(Attendance::Lost));
        }
    }

    #[test]
    fn what_the_dead_left_says_nothing() {
        let mut presence = Presence::new(5);
        assert!(!presence.hear(&pulse(10, 5, 1), 1010 * MS), "too old");
        assert!(presence.hear(&pulse(1000, 0, 0), 1010 * MS));
        assert!(!presence.hear(&pulse(999, 5, 1), 1010 * MS), "older than what was heard");
        assert_eq!(presence.pid(1010 * MS), Some(7));
    }
}
