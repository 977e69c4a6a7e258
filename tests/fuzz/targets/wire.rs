//! What lies in shared memory, and what both sides of a session make of it.

use std::sync::{Arc, LazyLock};
use std::time::Duration;

use ambidex::dispatch::{Dispatch, Input, Limits, at_start};
use ambidex::link::wire::read;
use ambidex::link::wire::{
    WIRE_VERSION, WireBeat, WireName, WirePose, WirePulse, WireReport, WireRequest, WireResponse, WireState, command,
    mode, request_kind, response_kind, state_kind,
};
use ambidex::model::session::{ClockOrigin, Presence, Session};
use ambidex::model::{ControllerId, Labels, MissionSpec, Rejection, Time};
use ambidex::motion::{self, Controller};

use super::Taken;
use super::fields::{Fields, From, Into};
use super::files::loaded;

/// The life of the daemon that is spoken of in what is sound.
const EPOCH: u64 = 7;

/// Messages one behind the other, each behind a word that says for whom it is and one that says when it comes.
pub fn wire(bytes: &[u8]) -> Taken {
    let mut both = Both::new();
    let (mut from, mut taken) = (From(bytes), Taken::default());
    while !from.0.is_empty() {
        let (mut which, mut later_us) = (0, 0);
        from.u32(&mut which);
        from.u32(&mut later_us);
        both.now_ns = both.now_ns.saturating_add(u64::from(later_us) * 1000);
        match both.take(which, &mut from) {
            Ok(()) => taken.accepted = true,
            Err(why) => taken.said(&format!("{} {why:?}", which % 5)),
        }
        both.go_on();
    }
    taken
}

/// A controller of each kind, and the daemon.
struct Both {
    now_ns: u64,
    sessions: Vec<Session<Box<dyn Controller + Send>>>,
    presence: Presence,
    labels: Labels,
    dispatch: Dispatch,
}

impl Both {
    fn new() -> Self {
        static MISSION: LazyLock<Arc<MissionSpec>> = LazyLock::new(|| {
            let text = include_str!("../../../config/missions/scan.yaml");
            loaded(text.as_bytes()).expect("a shipped mission loads").mission
        });
        let controllers = &MISSION.robot.controllers;
        let mut dispatch = Dispatch::new(&MISSION, at_start(&MISSION), Limits::at_speed(1.0));
        for index in 0..controllers.len() {
            dispatch.handle(Time::ZERO, Input::Attached(ControllerId::from(index)));
        }
        Self {
            now_ns: 1,
            sessions: controllers.iter().map(|spec| Session::new(motion::simulated(&spec.kind))).collect(),
            presence: Presence::new(EPOCH),
            labels: Labels::new(&MISSION.names),
            dispatch,
        }
    }

    fn take(&mut self, which: u32, from: &mut From<'_>) -> Result<(), Rejection> {
        let of = which as usize / 5 % self.sessions.len();
        let (session, id) = (&mut self.sessions[of], ControllerId::from(of));
        let now = ClockOrigin(0).time_at(self.now_ns, 1.0);
        let input = match which % 5 {
            0 => {
                let mut wire = WireRequest::default();
                from.request(&mut wire);
                session.take(read::request(&wire)?, self.now_ns);
                return Ok(());
            }
            1 => {
                let mut wire = WireResponse::default();
                from.response(&mut wire);
                Input::Heard(id, self.labels.heard(read::response(&wire, now + Duration::from_secs(1))?)?)
            }
            2 => {
                let mut wire = WirePulse::default();
                from.pulse(&mut wire);
                self.presence.hear(&read::pulse(&wire, self.now_ns)?, self.now_ns);
                return Ok(());
            }
            3 => {
                let mut wire = WireBeat::default();
                from.beat(&mut wire);
                session.hear_beat(read::beat(&wire, self.now_ns)?);
                return Ok(());
            }
            _ => {
                let mut wire = WireReport::default();
                from.report(&mut wire);
                Input::Reported(id, read::report(&wire)?.report)
            }
        };
        drop(self.dispatch.handle(now, input));
        Ok(())
    }

    /// What happens by itself.
    fn go_on(&mut self) {
        for session in &mut self.sessions {
            session.tick(self.now_ns);
            drop((session.replies(), session.pulse(), session.reports(self.now_ns), session.rest(self.now_ns)));
        }
        let _ = self.presence.attend(self.now_ns, false);
        let now = ClockOrigin(0).time_at(self.now_ns, 1.0);
        if self.dispatch.deadline().is_some_and(|due| due <= now) {
            drop(self.dispatch.handle(now, Input::Woke));
        }
    }
}

/// A session from its beginning: a daemon lives, configures, and wants something done; and what is said back.
pub fn seeds() -> Vec<Vec<u8>> {
    let kinds = [state_kind::ARM, state_kind::HEAD, state_kind::BASE, state_kind::DEVICE];
    let commands = [command::DRIVE, command::STAND, command::GRASP, command::PUT, command::LOOK, command::CALL];
    let sessions = kinds.iter().flat_map(|kind| commands.map(|command| session(*kind, command)));
    sessions.chain([said()]).collect()
}

fn begin(into: &mut Into, which: u32, later_us: u32) {
    into.u32(&mut { which });
    into.u32(&mut { later_us });
}

fn session(kind: u32, command: u32) -> Vec<u8> {
    let mut into = Into(Vec::new());
    for of in 0..8 {
        begin(&mut into, 5 * of + 3, 1000);
        into.beat(&mut WireBeat { version: WIRE_VERSION, pid: 9, epoch: EPOCH, sent_ns: 1_000_000 });
        let start = WireState { kind, ..WireState::default() };
        let mut wire = WireRequest { kind: request_kind::CONFIGURE, speed: 1.0, start, ..WireRequest::default() };
        (wire.id.epoch, wire.id.generation) = (EPOCH, 1);
        wire.limits = [0.5; 11];
        begin(&mut into, 5 * of, 1000);
        into.request(&mut wire);
        let mut goal = WireRequest { kind: request_kind::GOAL, mode: mode::ACHIEVE, command, ..WireRequest::default() };
        (goal.id, goal.id.number) = (wire.id, 1);
        (goal.path_len, goal.takes, goal.at) = (2, 1.0, [0.5, 0.1, 0.8]);
        goal.path[1] = WirePose { x: 1.0, y: 2.0, heading: 3.0 };
        (goal.object, goal.call) = (name("blood"), name("scan"));
        begin(&mut into, 5 * of, 1000);
        into.request(&mut goal);
        for _ in 0..4 {
            begin(&mut into, 5 * of + 3, 400_000);
            into.beat(&mut WireBeat { version: WIRE_VERSION, pid: 9, epoch: EPOCH, sent_ns: u64::MAX });
        }
    }
    into.0
}

fn said() -> Vec<u8> {
    let mut into = Into(Vec::new());
    let kinds = [
        response_kind::CONFIGURED,
        response_kind::ACCEPTED,
        response_kind::FEEDBACK,
        response_kind::RESULT,
        response_kind::REJECTED,
    ];
    for (of, kind) in (0..8).flat_map(|of| kinds.map(|kind| (of, kind))) {
        let state = WireState { kind: state_kind::ARM, ..WireState::default() };
        let mut wire = WireResponse { version: WIRE_VERSION, kind, state, end: 1, why: 1, ..WireResponse::default() };
        (wire.id.epoch, wire.id.generation) = (EPOCH, 1);
        begin(&mut into, 5 * of + 1, 1000);
        into.response(&mut wire);
        let mut pulse = WirePulse { version: WIRE_VERSION, pid: 3, epoch: EPOCH, state, ..WirePulse::default() };
        begin(&mut into, 5 * of + 2, 1000);
        into.pulse(&mut pulse);
        let mut report = WireReport { version: WIRE_VERSION, kind: 1, id: wire.id, ..WireReport::default() };
        report.name = name("spun");
        begin(&mut into, 5 * of + 4, 1000);
        into.report(&mut report);
    }
    into.0
}

fn name(text: &str) -> WireName {
    let mut name = WireName { len: text.len() as u32, ..WireName::default() };
    name.text[..text.len()].copy_from_slice(text.as_bytes());
    name
}
