//! What is done to one run, drawn from its seed.

use std::f64::consts::TAU;
use std::time::Duration;

use ambidex::model::{
    Change, Disk, Failures, Flaw, FlawKind, Location, Mishap, MissionSpec, NodeId, ObjectId, Obstacle, PlaceSpec,
    TALL_M, Time,
};
use nalgebra::Vector3;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

/// Of a behavior's attempt, to go wrong.
const FLAWED: f64 = 0.08;
/// How many attempts are drawn for each behavior.
const ATTEMPTS: u32 = 3;
/// Of a run, that its disk is full or slow.
const BAD_DISK: f64 = 0.15;
/// Of a run, that it is told to end before its time.
const CANCELED: f64 = 0.08;
/// Of a controller that was killed or stopped, never to come back; and of what came to stand in the room, never to go.
const FOR_GOOD: f64 = 0.12;
/// Most that is done to processes in one run.
const MOST_DEEDS: usize = 6;

/// Something that is done to the processes of a run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Deed {
    /// SIGKILL to a controller, which is started again after that time, or not at all.
    Kill(usize, Option<Duration>),
    /// SIGSTOP to a controller, and SIGCONT after that time, or not at all.
    Stop(usize, Option<Duration>),
    /// SIGHUP to a controller, which ends in order, and is started again after that time.
    HangUp(usize, Duration),
    /// The emergency stop of a controller is pressed for that time.
    PressStop(usize, Duration),
    /// SIGKILL to the daemon; another goes on in its log after that time.
    KillDaemon(Duration),
    /// SIGSTOP to the daemon, and SIGCONT after that time.
    StopDaemon(Duration),
    /// SIGHUP to the daemon: the mission is told to end.
    HangUpDaemon,
    /// An operator says that something of the world is different.
    Change(Change),
}

impl Deed {
    /// What it is called in a table.
    pub fn word(self) -> &'static str {
        match self {
            Self::Kill(..) => "kill -9 of a controller",
            Self::Stop(..) => "SIGSTOP of a controller",
            Self::HangUp(..) => "SIGHUP to a controller",
            Self::PressStop(..) => "emergency stop",
            Self::KillDaemon(_) => "kill -9 of the daemon, and resume",
            Self::StopDaemon(_) => "SIGSTOP of the daemon",
            Self::HangUpDaemon => "SIGHUP to the daemon",
            Self::Change(_) => "a change from outside",
        }
    }
}

/// All that is done to one run.
#[derive(Debug, Clone)]
pub struct Plan {
    /// What behaviors do wrong, and the disk, as a file for `--fail`.
    pub failures: Failures,
    /// What is done to processes, at moments of the wall clock since all of them are there.
    pub deeds: Vec<(Duration, Deed)>,
}

impl Plan {
    /// For a mission that takes about so much of the wall clock when nothing goes wrong.
    pub fn draw(seed: u64, mission: &MissionSpec, wall: Duration, speed: f64) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let span = wall.mul_f64(1.2).max(Duration::from_secs(1));
        let failures = failures(&mut rng, mission, span.mul_f64(speed));
        let count = rng.random_range(0..=MOST_DEEDS);
        let mut deeds = Vec::new();
        for _ in 0..count {
            let at = span.mul_f64(rng.random_range(0.0..1.0));
            let Some(deed) = deed(&mut rng, mission) else { continue };
            if let Deed::Change(Change::Blocked(obstacle)) = deed
                && !rng.random_bool(FOR_GOOD)
            {
                let stays = Duration::from_secs_f64(rng.random_range(0.05..2.5));
                deeds.push((at + stays, Deed::Change(Change::Cleared(obstacle.pose()))));
            }
            deeds.push((at, deed));
        }
        if rng.random_bool(CANCELED) {
            deeds.push((span.mul_f64(rng.random_range(0.0..1.0)), Deed::HangUpDaemon));
        }
        deeds.sort_by_key(|(at, _)| *at);
        Self { failures, deeds }
    }
}

fn failures(rng: &mut ChaCha8Rng, mission: &MissionSpec, span: Duration) -> Failures {
    let mut failures = Failures::default();
    for leaf in mission.tree.leaves() {
        for attempt in 1..=ATTEMPTS {
            if rng.random_bool(FLAWED) {
                failures.flaws.push(flaw(rng, mission, leaf, attempt));
            }
        }
    }
    if rng.random_bool(BAD_DISK) {
        let at = Time::ZERO + rounded(span.mul_f64(rng.random_range(0.0..1.0)));
        let is_full = rng.random_bool(0.5);
        failures.mishaps.push((at, Mishap::Disk(if is_full { Disk::Full } else { Disk::Slow })));
    }
    failures
}

fn flaw(rng: &mut ChaCha8Rng, mission: &MissionSpec, leaf: NodeId, attempt: u32) -> Flaw {
    let has_commands = mission.tree.behavior(leaf).is_some_and(|spec| !spec.commands.is_empty());
    let kind = match rng.random_range(0..4) {
        0 if has_commands => FlawKind::Fails,
        0 | 1 => FlawKind::Late(rounded(Duration::from_secs_f64(rng.random_range(0.5..8.0)))),
        2 => FlawKind::Drops(None),
        _ => FlawKind::Hangs,
    };
    Flaw { leaf, attempt: Some(attempt), kind }
}

/// As exactly as a failure file says it.
fn rounded(time: Duration) -> Duration {
    Duration::from_millis(time.as_millis() as u64)
}

fn deed(rng: &mut ChaCha8Rng, mission: &MissionSpec) -> Option<Deed> {
    let controller = rng.random_range(0..mission.robot.controllers.len().max(1));
    let soon = Duration::from_secs_f64(rng.random_range(0.05..2.5));
    let back = (!rng.random_bool(FOR_GOOD)).then_some(soon);
    let has_any = !mission.robot.controllers.is_empty();
    Some(match rng.random_range(0..16) {
        0..4 if has_any => Deed::Kill(controller, back),
        4..7 if has_any => Deed::Stop(controller, back),
        7 if has_any => Deed::HangUp(controller, soon),
        8 if has_any => Deed::PressStop(controller, soon),
        9..12 => Deed::KillDaemon(soon.min(Duration::from_millis(800))),
        12 => Deed::StopDaemon(soon),
        _ => Deed::Change(change(rng, mission)?),
    })
}

/// Something that an operator may say, taken or not; none where the mission has nothing of the kind.
fn change(rng: &mut ChaCha8Rng, mission: &MissionSpec) -> Option<Change> {
    let names = &mission.names;
    if rng.random_bool(0.3)
        && let Some(obstacle) = obstacle(rng, mission)
    {
        return Some(Change::Blocked(obstacle));
    }
    let has_object = !names.objects.is_empty() && !names.places.is_empty();
    if names.facts.is_empty() || has_object && rng.random_bool(0.5) {
        return has_object.then(|| {
            let object = ObjectId::from(rng.random_range(0..names.objects.len()));
            Change::Object(object, Location::At(rng.random_range(0..names.places.len()).into()))
        });
    }
    Some(Change::Fact(rng.random_range(0..names.facts.len()).into(), rng.random_bool(0.5)))
}

/// Something that comes to stand between two places, or at one.
fn obstacle(rng: &mut ChaCha8Rng, mission: &MissionSpec) -> Option<Obstacle> {
    let stands: Vec<_> = mission.world.places.iter().flat_map(PlaceSpec::stands).map(|stand| stand.at).collect();
    let [from, to] = [(); 2].map(|()| stands.get(rng.random_range(0..stands.len().max(1))));
    let at = from?.coords.lerp(&to?.coords, rng.random_range(0.0..1.0)).into();
    let [length, width] = [(); 2].map(|()| rng.random_range(0.1..0.8));
    Some(Obstacle::on_floor(at, Vector3::new(length, width, TALL_M), rng.random_range(0.0..TAU)))
}
