//! The daemon's side of a session: whether the controller is there, serves, or is gone.

use std::time::Duration;

use super::{DEAD_MAN, StampedPulse};
use crate::{Inhibition, Loss};

/// What a daemon knows of one controller's life.
#[derive(Debug, Clone, Copy)]
pub struct Presence {
    epoch: u64,
    seen: Option<Seen>,
    phase: Phase,
    /// It has shown that it is configured by this daemon.
    serves: bool,
    has_left: bool,
    /// When this daemon ran again after it had not for a while, nanoseconds, and for how long it had not.
    back: Option<(u64, Duration)>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Phase {
    Away,
    Attached,
    /// It is there, and says that it may not move.
    Inhibited(Inhibition),
}

#[derive(Debug, Clone, Copy)]
struct Seen {
    pid: u32,
    sent_ns: u64,
    inhibited: Option<Inhibition>,
}

/// What a daemon makes of a sign of life.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Hearing {
    /// It counts.
    Taken,
    /// It says nothing: what an earlier, dead controller published may still lie there.
    Old,
    /// It is of another process than the one that has the name, which is not known to be gone.
    Foreign {
        /// Who has the name.
        pid: u32,
    },
}

/// What became of a controller's attachment.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Attendance {
    /// It is there, in this process, and can be configured.
    Attached {
        /// Process id, to be watched for its end.
        pid: u32,
    },
    /// It is there, in this process, and may not move: nothing is to be sent to it.
    Inhibited {
        /// Process id, to be watched for its end.
        pid: u32,
        /// What keeps it.
        why: Inhibition,
    },
    /// It ended, fell silent, or gave this daemon up.
    Lost(Loss),
}

impl Presence {
    /// Of a controller that was not seen yet, for the daemon of this epoch.
    pub fn new(epoch: u64) -> Self {
        Self { epoch, seen: None, phase: Phase::Away, serves: false, has_left: false, back: None }
    }

    /// Takes a sign of life. Who has come first keeps the name until it is gone.
    pub fn hear(&mut self, pulse: &StampedPulse, now_ns: u64) -> Hearing {
        let is_newest = self.seen.is_none_or(|seen| seen.sent_ns <= pulse.sent_ns);
        if let Some(Seen { pid, .. }) = self.seen.filter(|seen| self.phase != Phase::Away && seen.pid != pulse.pid) {
            return Hearing::Foreign { pid };
        }
        if !is_fresh(pulse.sent_ns, now_ns) || !is_newest {
            return Hearing::Old;
        }
        self.seen = Some(Seen { pid: pulse.pid, sent_ns: pulse.sent_ns, inhibited: pulse.pulse.inhibited });
        let serves = self.generation(pulse) != 0;
        // It gave this daemon up, as one that was silent for too long.
        self.has_left |= self.serves && !serves;
        self.serves = serves;
        Hearing::Taken
    }

    /// The attachment to this daemon that a pulse tells of, 0 if none.
    pub fn generation(&self, pulse: &StampedPulse) -> u32 {
        if pulse.pulse.epoch == self.epoch { pulse.pulse.generation } else { 0 }
    }

    /// The controller's process, if it showed a sign of life within [`DEAD_MAN`].
    pub fn pid(&self, now_ns: u64) -> Option<u32> {
        self.seen.filter(|seen| is_fresh(seen.sent_ns, now_ns)).map(|seen| seen.pid)
    }

    /// When the controller counts as gone if nothing more is heard, nanoseconds; none while it is away.
    pub fn silent_at_ns(&self) -> Option<u64> {
        let dead_man_ns = u64::try_from(DEAD_MAN.as_nanos()).unwrap_or(u64::MAX);
        let seen = self.seen.filter(|_| self.phase != Phase::Away)?;
        let last_ns = self.back.map_or(seen.sent_ns, |(back_ns, _)| back_ns.max(seen.sent_ns));
        Some(last_ns.saturating_add(dead_man_ns))
    }

    /// This daemon itself did not run for a while: nobody could be heard, so nobody's silence counts from before.
    pub fn was_away(&mut self, now_ns: u64, length: Duration) {
        self.back = Some((now_ns, length));
    }

    /// What has changed by now; `has_ended` says that its process has.
    pub fn attend(&mut self, now_ns: u64, has_ended: bool) -> Option<Attendance> {
        let has_left = std::mem::take(&mut self.has_left);
        let is_there = |seen: &Seen| !has_ended && is_fresh(seen.sent_ns, now_ns);
        match (self.seen.filter(is_there), self.phase) {
            (Some(Seen { pid, inhibited: Some(why), .. }), phase) => {
                (self.phase, self.serves) = (Phase::Inhibited(why), false);
                return (self.phase != phase).then_some(Attendance::Inhibited { pid, why });
            }
            (Some(Seen { pid, inhibited: None, .. }), Phase::Away | Phase::Inhibited(_)) if !has_left => {
                self.phase = Phase::Attached;
                return Some(Attendance::Attached { pid });
            }
            (_, Phase::Away) => return None,
            (Some(_) | None, Phase::Attached | Phase::Inhibited(_)) => {}
        }
        let away = self.back.filter(|(back_ns, _)| is_fresh(*back_ns, now_ns));
        let loss = if has_ended {
            // What it published last says nothing of whoever comes after it.
            self.seen = None;
            Loss::Ended
        } else if has_left {
            let away_ms = away.map_or(0, |(_, length)| u32::try_from(length.as_millis()).unwrap_or(u32::MAX));
            Loss::Left { away_ms }
        } else if self.pid(now_ns).is_none() && away.is_none() {
            Loss::Silent
        } else {
            return None;
        };
        (self.phase, self.serves) = (Phase::Away, false);
        Some(Attendance::Lost(loss))
    }
}

fn is_fresh(sent_ns: u64, now_ns: u64) -> bool {
    Duration::from_nanos(now_ns.saturating_sub(sent_ns)) < DEAD_MAN
}

#[cfg(test)]
mod tests {
    use super::super::Pulse;
    use super::*;
    use crate::Time;
    use crate::motion::ControllerState;

    const MS: u64 = 1_000_000;

    fn pulse(sent_ms: u64, epoch: u64, generation: u32) -> StampedPulse {
        let state = ControllerState::Head { angles: [0.0; 2], velocity: [0.0; 2] };
        let pulse = Pulse { epoch, generation, at: Time::ZERO, inhibited: None, state };
        StampedPulse { pid: 7, sent_ns: sent_ms * MS, pulse }
    }

    #[test]
    fn a_controller_comes_serves_and_goes() {
        let mut presence = Presence::new(5);
        assert_eq!(presence.attend(0, false), None);
        assert_eq!(presence.hear(&pulse(10, 0, 0), 10 * MS), Hearing::Taken);
        assert_eq!(presence.attend(10 * MS, false), Some(Attendance::Attached { pid: 7 }));
        assert_eq!(presence.attend(20 * MS, false), None);
        assert_eq!(presence.hear(&pulse(20, 5, 1), 20 * MS), Hearing::Taken);
        assert_eq!(presence.silent_at_ns(), Some(1020 * MS));
        assert_eq!(presence.attend(1019 * MS, false), None);
        assert_eq!(
            presence.attend(1020 * MS, false),
            Some(Attendance::Lost(Loss::Silent)),
            "silent for the dead-man's time"
        );
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
            let why = if has_ended { Loss::Ended } else { Loss::Left { away_ms: 0 } };
            assert_eq!(presence.attend(11 * MS, has_ended), Some(Attendance::Lost(why)));
            // A dead one is not attached again; one that serves somebody else may come back.
            let next = presence.attend(12 * MS, false);
            assert_eq!(next, deserts.then_some(Attendance::Attached { pid: 7 }));
        }
    }

    #[test]
    fn a_daemon_that_was_stopped_blames_nobody_for_it() {
        let mut presence = Presence::new(5);
        presence.hear(&pulse(10, 5, 1), 10 * MS);
        assert!(presence.attend(10 * MS, false).is_some());
        // Stopped for 1.2 s: it has heard nothing, and could not.
        presence.was_away(1210 * MS, Duration::from_millis(1200));
        assert_eq!(presence.attend(1210 * MS, false), None);
        assert_eq!(presence.hear(&pulse(1200, 5, 1), 1210 * MS), Hearing::Taken);
        assert_eq!(presence.attend(2209 * MS, false), None);
        assert_eq!(presence.attend(2210 * MS, false), Some(Attendance::Lost(Loss::Silent)));
        // The controller has heard nothing either, and went: that is this daemon's doing.
        let mut presence = Presence::new(5);
        presence.hear(&pulse(10, 5, 1), 10 * MS);
        assert!(presence.attend(10 * MS, false).is_some());
        presence.was_away(1210 * MS, Duration::from_millis(1200));
        presence.hear(&pulse(1205, 0, 0), 1210 * MS);
        assert_eq!(presence.attend(1210 * MS, false), Some(Attendance::Lost(Loss::Left { away_ms: 1200 })));
    }

    #[test]
    fn an_inhibited_controller_is_there_and_not_attached() {
        let inhibited = |sent_ms, why| {
            let mut pulse = pulse(sent_ms, 5, 0);
            pulse.pulse.inhibited = Some(why);
            pulse
        };
        let mut presence = Presence::new(5);
        presence.hear(&pulse(10, 5, 1), 10 * MS);
        assert_eq!(presence.attend(10 * MS, false), Some(Attendance::Attached { pid: 7 }));
        let why = Inhibition::EmergencyStop;
        presence.hear(&inhibited(20, why), 20 * MS);
        assert_eq!(presence.attend(20 * MS, false), Some(Attendance::Inhibited { pid: 7, why }));
        assert_eq!(presence.attend(30 * MS, false), None, "told once");
        let why = Inhibition::Fault;
        presence.hear(&inhibited(40, why), 40 * MS);
        assert_eq!(presence.attend(40 * MS, false), Some(Attendance::Inhibited { pid: 7, why }));
        let mut silent = presence;
        assert_eq!(silent.attend(1040 * MS, false), Some(Attendance::Lost(Loss::Silent)));
        let mut dead = presence;
        assert_eq!(dead.attend(50 * MS, true), Some(Attendance::Lost(Loss::Ended)));
        presence.hear(&pulse(60, 5, 0), 60 * MS);
        assert_eq!(presence.attend(60 * MS, false), Some(Attendance::Attached { pid: 7 }));
        assert_eq!(presence.attend(60 * MS, false), None);
    }

    #[test]
    fn what_the_dead_left_says_nothing() {
        let mut presence = Presence::new(5);
        assert_eq!(presence.hear(&pulse(10, 5, 1), 1010 * MS), Hearing::Old, "too old");
        assert_eq!(presence.hear(&pulse(1000, 0, 0), 1010 * MS), Hearing::Taken);
        assert_eq!(presence.hear(&pulse(999, 5, 1), 1010 * MS), Hearing::Old, "older than what was heard");
        assert_eq!(presence.pid(1010 * MS), Some(7));
    }

    #[test]
    fn who_came_first_keeps_the_name_until_it_is_gone() {
        let foreign = |sent_ms| StampedPulse { pid: 8, ..pulse(sent_ms, 0, 0) };
        for has_ended in [true, false] {
            let mut presence = Presence::new(5);
            presence.hear(&pulse(10, 5, 1), 10 * MS);
            assert_eq!(presence.attend(10 * MS, false), Some(Attendance::Attached { pid: 7 }));
            assert_eq!(presence.hear(&foreign(20), 20 * MS), Hearing::Foreign { pid: 7 });
            assert_eq!((presence.attend(20 * MS, false), presence.pid(20 * MS)), (None, Some(7)));
            let gone_ms = if has_ended { 30 } else { 1010 };
            assert!(matches!(presence.attend(gone_ms * MS, has_ended), Some(Attendance::Lost(_))));
            assert_eq!(presence.hear(&foreign(gone_ms), gone_ms * MS), Hearing::Taken);
            assert_eq!(presence.attend(gone_ms * MS, false), Some(Attendance::Attached { pid: 8 }));
        }
    }
}
