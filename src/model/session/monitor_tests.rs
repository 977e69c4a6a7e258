//! A controller under a virtual clock: a real session and the daemon's presence, and what the monitor makes of both.

use super::super::{Attendance, BEAT_EVERY, Beat, ClockOrigin, Presence, Received, Session};
use super::*;
use crate::motion::{Controller, simulated};
use crate::{CommandId, ControllerKind, ControllerState, Inhibition, Labels, Level, Misreport, Names, Report, Time};

const MS: u64 = 1_000_000;
const EPOCH: u64 = 5;
const STATE: ControllerState = ControllerState::Device;

/// A controller's process and the daemon's end of its link, both at one moment.
struct Scene {
    session: Session<Box<dyn Controller + Send>>,
    presence: Presence,
    monitor: Monitor,
    now_ms: u64,
    generation: u32,
    /// Whether the process does anything.
    is_running: bool,
}

impl Scene {
    fn new() -> Self {
        Self {
            session: Session::new(simulated(&ControllerKind::Device)),
            presence: Presence::new(EPOCH),
            monitor: Monitor::new(ControllerId(3), 0),
            now_ms: 0,
            generation: 3,
            is_running: true,
        }
    }

    /// The same with a configured controller, after its first diagnosis.
    fn configured() -> Self {
        let mut scene = Self::new();
        scene.pass(1000);
        assert_eq!(scene.diagnose().message, Diagnosis::Serves);
        scene
    }

    /// Lets time pass: the process pulses as an idle one does, the daemon looks with every beat.
    fn pass(&mut self, ms: u64) {
        for _ in 0..ms / 100 {
            self.now_ms += 100;
            let now_ns = self.now_ms * MS;
            if self.is_running && self.now_ms.is_multiple_of(PULSE_EVERY.as_millis() as u64) {
                self.pulse(7);
            }
            if self.now_ms.is_multiple_of(BEAT_EVERY.as_millis() as u64) {
                self.attend(now_ns, false);
            }
        }
    }

    fn pulse(&mut self, pid: u32) {
        let now_ns = self.now_ms * MS;
        self.session.hear_beat(Beat { pid: 1, epoch: EPOCH, sent_ns: now_ns });
        self.session.tick(now_ns);
        let pulse = StampedPulse { pid, sent_ns: now_ns, pulse: self.session.pulse() };
        let hearing = self.presence.hear(&pulse, now_ns);
        self.monitor.pulsed(&pulse, hearing);
    }

    /// What the daemon sees now; one that attaches is configured at once.
    fn attend(&mut self, now_ns: u64, has_ended: bool) {
        match self.presence.attend(now_ns, has_ended) {
            Some(Attendance::Attached { .. }) => {
                self.monitor.note(&ControllerMessage::Attached);
                self.configure(now_ns);
            }
            Some(Attendance::Inhibited { why, .. }) => self.lose(Loss::Inhibited(why)),
            Some(Attendance::Lost(why)) => self.lose(why),
            None => {}
        }
    }

    fn configure(&mut self, now_ns: u64) {
        let (limits, start) = (ControllerKind::Device, STATE);
        self.generation += 1;
        let message = ToController::Configure { generation: self.generation, speed: 1.0, limits, start };
        let labels = Labels::new(&Names::default());
        let received = labels.told(&message);
        self.monitor.note(&ControllerMessage::Told { leaf: None, message });
        self.session.take(Received { message: received, epoch: EPOCH, origin: ClockOrigin(0) }, now_ns);
        self.session.tick(now_ns);
        for reply in self.session.replies() {
            self.hear(labels.heard(reply.message).expect("it holds nothing"));
        }
    }

    fn hear(&mut self, message: FromController) {
        self.monitor.note(&ControllerMessage::Heard { message });
    }

    fn lose(&mut self, why: Loss) {
        self.monitor.note(&ControllerMessage::Lost { why });
    }

    fn diagnose(&mut self) -> Diagnostics {
        self.monitor.diagnose(self.now_ms * MS)
    }
}

fn id() -> CommandId {
    CommandId { generation: 4, number: 1 }
}

#[test]
fn a_controller_comes_serves_falls_silent_and_comes_back() {
    let mut scene = Scene::new();
    scene.is_running = false;
    scene.pass(1000);
    let absent = scene.diagnose();
    assert_eq!((absent.level, absent.message), (Level::Stale, Diagnosis::Absent));
    assert_eq!(absent.values, Vitals::default());

    scene.is_running = true;
    scene.pass(2000);
    scene.diagnose();
    scene.pass(1000);
    let serving = scene.diagnose();
    assert_eq!((serving.level, serving.message), (Level::Ok, Diagnosis::Serves));
    let Vitals { heartbeat_age_ms, worst_gap_ms, states_per_s, attachments, generation, .. } = serving.values;
    assert_eq!((heartbeat_age_ms, worst_gap_ms), (Some(0), Some(400)));
    assert_eq!((states_per_s, attachments, generation), (3, 1, 4));
    assert_eq!(serving.controller, ControllerId(3));

    // Nothing for longer than the dead-man allows.
    scene.is_running = false;
    scene.pass(1000);
    let late = scene.diagnose();
    assert_eq!((late.level, late.message, late.values.heartbeat_age_ms), (Level::Warn, Diagnosis::Late, Some(1000)));
    scene.pass(1000);
    let silent = scene.diagnose();
    assert_eq!((silent.level, silent.message), (Level::Stale, Diagnosis::Lost(Loss::Silent)));
    assert_eq!((silent.values.heartbeat_age_ms, silent.values.states_per_s), (Some(2000), 0));
    scene.pass(5000);
    assert!(silent.agrees_with(&scene.diagnose()), "numbers alone are no news");

    // How long it was away is no gap of the new attachment.
    scene.is_running = true;
    scene.pass(1000);
    let back = scene.diagnose();
    assert_eq!((back.level, back.message, back.values.attachments), (Level::Ok, Diagnosis::Serves, 2));
    assert_eq!(back.values.last_fault, Some(Trouble::Lost(Loss::Silent)));
    assert!(back.values.worst_gap_ms < Some(800), "{back:?}");
}

#[test]
fn one_late_sign_of_life_is_a_warning_for_that_second() {
    let mut scene = Scene::configured();
    scene.is_running = false;
    scene.pass(500);
    scene.is_running = true;
    scene.pass(500);
    let late = scene.diagnose();
    assert_eq!((late.level, late.message, late.values.worst_gap_ms), (Level::Warn, Diagnosis::Late, Some(800)));
    scene.pass(1000);
    assert_eq!(scene.diagnose().message, Diagnosis::Serves);
}

#[test]
fn what_came_late_while_the_daemon_did_not_run_is_not_the_controllers_doing() {
    let mut scene = Scene::configured();
    scene.now_ms += 5000;
    let away = scene.diagnose();
    assert_eq!((away.message, away.values.heartbeat_age_ms), (Diagnosis::Serves, Some(5200)));
}

#[test]
fn losses_are_errors_and_silence_is_stale() {
    let stop = Inhibition::EmergencyStop;
    for (why, level) in [
        (Loss::Ended, Level::Error),
        (Loss::Left { away_ms: 0 }, Level::Error),
        (Loss::Unanswered, Level::Error),
        (Loss::Broken, Level::Error),
        (Loss::Hung, Level::Error),
        (Loss::HoldsUnknown, Level::Error),
        (Loss::Inhibited(stop), Level::Error),
        (Loss::Silent, Level::Stale),
    ] {
        let mut scene = Scene::configured();
        scene.lose(why);
        let lost = scene.diagnose();
        assert_eq!((lost.level, lost.message), (level, Diagnosis::Lost(why)));
        assert_eq!(lost.values.hung, why == Loss::Hung);
        assert_eq!(lost.values.inhibited, (why == Loss::Inhibited(stop)).then_some(stop));
        assert_eq!(lost.values.last_fault, Some(Trouble::Lost(why)));
    }
}

#[test]
fn trouble_lasts_until_a_goal_is_taken_and_is_remembered_after() {
    let result = |end| FromController::Result { id: id(), end, began: Time::ZERO, ended: Time::ZERO, state: STATE };
    let heard = |message| ControllerMessage::Heard { message };
    for (message, trouble) in [
        (heard(result(PartEnd::Aborted)), Some(Trouble::Aborted)),
        (heard(result(PartEnd::Succeeded)), None),
        (heard(result(PartEnd::Canceled)), None),
        (heard(FromController::Rejected { id: id(), why: Rejection::Busy }), Some(Trouble::Rejected(Rejection::Busy))),
        (
            ControllerMessage::Misreported { report: Report::fact("x", true), why: Misreport::NoSuchFact },
            Some(Trouble::Misreported(Misreport::NoSuchFact)),
        ),
        (
            ControllerMessage::Refused { id: None, why: Rejection::NotFinite },
            Some(Trouble::Refused(Rejection::NotFinite)),
        ),
    ] {
        let mut scene = Scene::configured();
        scene.monitor.note(&message);
        for _ in 0..2 {
            scene.pass(1000);
            let expected = trouble.map_or(Diagnosis::Serves, Diagnosis::Troubled);
            assert_eq!(scene.diagnose().message, expected, "{message:?}");
        }
        scene.hear(FromController::Accepted { id: id(), at: Time::ZERO });
        scene.pass(1000);
        let after = scene.diagnose();
        assert_eq!((after.level, after.values.last_fault), (Level::Ok, trouble), "{message:?}");
    }
}

#[test]
fn what_is_not_used_is_counted_and_a_stranger_is_no_controller() {
    let version = ControllerMessage::Refused { id: None, why: Rejection::Version };
    let mut scene = Scene::new();
    scene.is_running = false;
    scene.monitor.note(&version);
    scene.monitor.passed_over(41);
    scene.pass(1000);
    let stranger = scene.diagnose();
    assert_eq!((stranger.level, stranger.message), (Level::Error, Diagnosis::Unheard(Rejection::Version)));
    assert_eq!((stranger.values.refused, stranger.values.attachments), (42, 0));
    scene.pass(1000);
    assert_eq!(scene.diagnose().message, Diagnosis::Absent, "it has gone");

    let mut scene = Scene::configured();
    scene.pulse(8);
    let doubled = scene.diagnose();
    assert_eq!((doubled.level, doubled.message, doubled.values.foreign), (Level::Warn, Diagnosis::Doubled, 1));
}

#[test]
fn what_it_does_not_take_is_a_backlog() {
    let mut scene = Scene::configured();
    scene.monitor.queued(5);
    scene.monitor.queued(2);
    let full = scene.diagnose();
    assert_eq!((full.level, full.message, full.values.queued), (Level::Warn, Diagnosis::Backlog, 5));
    scene.monitor.queued(0);
    let taken = scene.diagnose();
    assert_eq!((taken.level, taken.values.queued), (Level::Ok, 2), "two waited into this second");
    assert_eq!(scene.diagnose().values.queued, 0);
}

#[test]
fn every_message_with_a_state_counts_as_one() {
    let mut scene = Scene::configured();
    scene.pass(1000);
    let idle = scene.diagnose().values.states_per_s;
    for _ in 0..10 {
        scene.hear(FromController::Feedback { id: id(), progress: 0.5, state: STATE });
        scene.hear(FromController::Accepted { id: id(), at: Time::ZERO });
    }
    // Twice as long: a rate, and no count.
    scene.pass(2000);
    assert_eq!((idle, scene.diagnose().values.states_per_s), (3, 8));
}
