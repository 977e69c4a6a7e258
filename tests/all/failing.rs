//! What goes wrong on purpose in simulations of shipped missions: what comes of it, and that it can be verified.

use std::sync::Arc;
use std::time::Duration;

use ambidex::model::{
    Change, ControllerId, ControllerKind, ControllerMessage, End, Fault, Location, Loss, MissionEnd, MissionSpec, Mode,
    Name, NodeId, Record, Rejection, Time,
};
use ambidex::motion::{self, Command, Controller, ControllerState, Progress};
use ambidex::sim::{self, Body, Event};
use ambidex::tree::Settings;

use crate::fixtures::{experiment_file, file, load, simulate, simulate_wrongs};
use crate::home::Home;

/// Simulates a mission with failures; every decision follows from the log.
fn failing(mission: &Arc<MissionSpec>, failures: &str) -> (MissionEnd, Vec<Record>) {
    simulate_wrongs(mission, &Settings::default(), failures)
}

/// How the goals of a behavior ended, each with its moment.
fn ends(mission: &MissionSpec, records: &[Record], name: &str) -> Vec<(End, f64)> {
    let ends = records.iter().filter_map(|record| match record {
        Record::Released { at, leaf, end, .. } if mission.names.node(*leaf) == name => Some((*end, at.seconds())),
        _ => None,
    });
    ends.collect()
}

fn controller(mission: &MissionSpec, name: &str) -> ControllerId {
    mission.names.controllers.iter().position(|known| known == name).expect("such a controller").into()
}

#[test]
fn what_fails_is_tried_again() {
    let mission = load(&file("config/missions/desk.yaml"));
    let (end, records) = failing(&mission, "  - {behavior: inspect tray, fails: aborted}\n");
    assert_eq!(end, MissionEnd::Done);
    let aborted = End::Failed(Fault::Aborted(controller(&mission, "head")));
    let ends = ends(&mission, &records, "inspect tray");
    assert_eq!(ends.iter().map(|(end, _)| *end).collect::<Vec<_>>(), [aborted, End::Succeeded]);
    assert_eq!(ends[0].1, 3.0, "it gives up in the end");
    let (end, records) = failing(&mission, "  - {behavior: inspect tray, attempt: every, fails: aborted}\n");
    let tray = mission.names.nodes.iter().position(|name| name == "inspect tray").map(NodeId::from);
    assert_eq!(Some(end), tray.map(MissionEnd::Failed), "no attempt is left");
    assert_eq!(self::ends(&mission, &records, "inspect tray").len(), 3, "two retries");
}

#[test]
fn what_hangs_is_ended_by_its_timeout() {
    let mission = load(&file("config/missions/desk.yaml"));
    let (end, records) = failing(&mission, "  - {behavior: inspect pad, attempt: 1, hangs: true}\n");
    assert_eq!(end, MissionEnd::Done);
    let ends = ends(&mission, &records, "inspect pad");
    let [(first, at), (End::Succeeded, later)] = ends[..] else { panic!("{ends:?}") };
    assert_eq!(first, End::Failed(Fault::TimedOut));
    assert!((123.0..124.0).contains(&at) && later > at, "two minutes from its beginning: {ends:?}");
}

#[test]
fn a_hanging_behavior_is_canceled_where_its_controllers_still_work() {
    let mission = load(&experiment_file(1));
    let (_, records) = failing(&mission, "  - {behavior: pick 2, hangs: true}\n");
    let [(End::Failed(Fault::TimedOut), _)] = ends(&mission, &records, "pick 2")[..] else { panic!("it timed out") };
    // The arm had done its part, and what it holds is known.
    assert!(ends(&mission, &records, "place 2").iter().any(|(end, _)| *end == End::Succeeded));
}

#[test]
fn what_is_dropped_lies_at_the_nearest_place() {
    let mission = load(&experiment_file(1));
    for drops in ["1", "all"] {
        let (end, records) = failing(&mission, &format!("  - {{behavior: move 1-2, drops: {drops}}}\n"));
        let dropped: Vec<Change> = records
            .iter()
            .filter_map(|record| match record {
                Record::World { change, .. } => Some(*change),
                _ => None,
            })
            .collect();
        let at_shelf = |object: usize| Change::Object(object.into(), Location::At(0.into()));
        // The left arm comes first.
        let expected = if drops == "all" { vec![at_shelf(1), at_shelf(0)] } else { vec![at_shelf(0)] };
        assert_eq!(dropped, expected, "{drops}");
        assert_eq!(ends(&mission, &records, "move 1-2")[0].0, End::Succeeded, "it goes on");
        // It is fetched again from where it lies, which is where the task fetches it from.
        assert_eq!(end, MissionEnd::Done);
        let picks = ends(&mission, &records, "pick 1");
        assert_eq!(picks.iter().filter(|(end, _)| *end == End::Succeeded).count(), 2, "{picks:?}");
    }
}

#[test]
fn the_world_changes_from_outside() {
    let mission = load(&file("config/missions/desk.yaml"));
    let undisturbed = simulate(&mission, &Settings::default(), Vec::new()).0;
    assert_eq!(ends(&mission, &undisturbed, "inspect pad").len(), 1);
    let (end, records) = failing(&mission, "  - {at: 1 s, set: seen pad}\n  - {at: 2 s, clear: seen tray}\n");
    assert_eq!(end, MissionEnd::Done);
    assert_eq!(ends(&mission, &records, "inspect pad"), [], "somebody has done it");
}

fn second(seconds: f64) -> Time {
    Time::ZERO + Duration::from_secs_f64(seconds)
}

/// When an undisturbed mission ends that begins at a moment.
fn ended(records: &[Record]) -> (f64, f64) {
    let began = records.iter().find_map(|record| match record {
        Record::Began { at, .. } => Some(at.seconds()),
        _ => None,
    });
    let end = records.iter().find_map(|record| match record {
        Record::Ended { at, end: MissionEnd::Done } => Some(at.seconds()),
        _ => None,
    });
    (began.expect("it began"), end.expect("it is done"))
}

#[test]
fn a_controller_that_was_lost_or_hung_attaches_anew() {
    let mission = load(&experiment_file(1));
    let (_, undisturbed) = ended(&simulate(&mission, &Settings::default(), Vec::new()).0);
    let attach = |id, at| (second(at), Event::Attach(ControllerId(id)));
    for gone in [Event::Lose(ControllerId(0)), Event::Hang(ControllerId(0))] {
        // The others come when it is known to be gone, so that the mission does not begin without it.
        let mut events = vec![attach(0, 0.0), (second(1.0), gone.clone())];
        events.extend((1..4).map(|id| attach(id, 3.0)));
        events.push((second(5.0), Event::Return(ControllerId(0))));
        let (records, _) = simulate(&mission, &Settings::default(), events);
        let (began, end) = ended(&records);
        assert_eq!(began, 5.0, "{gone:?}");
        assert!((end - began - undisturbed).abs() < 0.02, "{gone:?}: {began} to {end}, not {undisturbed}");
    }
}

#[test]
fn who_hangs_for_a_moment_only_goes_on_where_it_was() {
    let mission = load(&experiment_file(1));
    let (_, undisturbed) = ended(&failing(&mission, "  - {at: 500 s, lose: base}\n").1);
    for (from, to) in [(3.0, 3.9), (0.0, 0.5), (6.5, 7.3)] {
        let failures = format!("  - {{at: {from} s, hang: base}}\n  - {{at: {to} s, return: base}}\n");
        let (end, records) = failing(&mission, &failures);
        assert_eq!(end, MissionEnd::Done, "{failures}");
        let (_, end) = ended(&records);
        assert!((undisturbed..undisturbed + 1.0).contains(&end), "{failures}: {end}, not {undisturbed}");
    }
}

#[test]
fn a_controller_is_lost_at_its_moment() {
    let mission = load(&experiment_file(1));
    for (failure, at) in [("lose", 3.0), ("hang", 4.0)] {
        let (_, records) = failing(&mission, &format!("  - {{at: 3 s, {failure}: base}}\n"));
        let lost = ends(&mission, &records, "move 2-1");
        assert_eq!(lost, [(End::Failed(Fault::Lost(controller(&mission, "base"))), at)], "{failure}");
    }
}

#[test]
fn a_mission_goes_on_with_what_is_back() {
    let mission = load(&experiment_file(1));
    for failures in [
        "  - {at: 8 s, lose: left_arm}\n  - {at: 20 s, return: left_arm}\n",
        "  - {at: 3 s, lose: base}\n  - {at: 5 s, return: base}\n",
        "  - {at: 3 s, hang: base}\n  - {at: 8 s, return: base}\n",
        "  - {at: 8 s, hang: right_arm}\n  - {at: 9500 ms, lose: right_arm}\n  - {at: 11 s, return: right_arm}\n",
    ] {
        let (end, records) = failing(&mission, failures);
        assert_eq!(end, MissionEnd::Done, "{failures}");
        let is_refusal =
            |record: &&Record| matches!(record, Record::Controller { message: ControllerMessage::Refused { .. }, .. });
        assert_eq!(records.iter().find(is_refusal), None, "{failures}: what is over is not heard of again");
    }
}

#[test]
fn an_inhibited_controller_is_awaited_and_used_again() {
    let mission = load(&file("config/missions/scan.yaml"));
    let (end, records) = failing(&mission, "  - {at: 6 s, inhibit: scanner}\n  - {at: 60 s, return: scanner}\n");
    assert_eq!(end, MissionEnd::Done);
    let scanned = ends(&mission, &records, "scan blood");
    // The lamp, which lights what is scanned, takes a step to go out.
    let [(End::Interrupted, 6.01), (End::Succeeded, later)] = scanned[..] else { panic!("{scanned:?}") };
    assert!(later > 60.0, "however long it takes: {later}");
    let is_awaited = |record: &&Record| matches!(record, Record::Awaited { until: None, .. });
    assert_eq!(records.iter().filter(is_awaited).count(), 1, "told once");
    // What one arm cannot do the other does.
    let (end, records) = failing(&mission, "  - {at: 1 s, inhibit: left_arm}\n  - {at: 8 s, return: left_arm}\n");
    let fetched = ends(&mission, &records, "fetch blood");
    assert_eq!((end, fetched[0]), (MissionEnd::Done, (End::Interrupted, 1.0)), "{fetched:?}");
    assert!(ends(&mission, &records, "scan water")[0].1 < 8.0, "the other arm carries on");
    // An interruption is no failure: it costs no retry.
    let stop =
        |time: u32| format!("  - {{at: 4.{time} s, inhibit: left_arm}}\n  - {{at: 4.{time}5 s, return: left_arm}}\n");
    let (end, records) = failing(&mission, &(0..6).map(stop).collect::<String>());
    let shaken = ends(&mission, &records, "shake blood");
    assert_eq!((end, shaken.len()), (MissionEnd::Done, 7), "{shaken:?}");
}

#[test]
fn one_that_stays_inhibited_is_a_stall_with_its_reason() {
    let mission = load(&file("config/missions/scan.yaml"));
    let (end, records) = failing(&mission, "  - {at: 1 s, inhibit: scanner}\n");
    assert_eq!(end, MissionEnd::Stalled);
    assert!(matches!(records.last(), Some(Record::Ended { end: MissionEnd::Stalled, .. })), "{:?}", records.last());
    let reasons = records.iter().filter_map(|record| match record {
        Record::Decided { refused, .. } => Some(refused),
        _ => None,
    });
    let said: Vec<_> = reasons.flatten().map(|blocked| blocked.reason.sentence(&mission.names)).collect();
    let expected = "scanner is unavailable (its controller is inhibited: emergency stop)";
    assert!(said.iter().any(|said| said == expected), "{said:#?}");
    // Whoever is lost beside it is awaited for its time, and the other goes on being awaited.
    let (end, records) = failing(
        &mission,
        "  - {at: 1 s, inhibit: scanner}\n  - {at: 1 s, inhibit: left_arm}\n  - {at: 2 s, lose: right_arm}\n  - {at: 90 s, return: left_arm}\n",
    );
    assert_eq!(end, MissionEnd::Stalled);
    let awaited: Vec<_> = records
        .iter()
        .filter_map(|record| match record {
            Record::Awaited { until, .. } => Some(until.map(|until| until.seconds())),
            _ => None,
        })
        .collect();
    assert!(matches!(awaited[..], [Some(_), None, None]), "{awaited:?}");
    let fetched = ends(&mission, &records, "fetch blood");
    assert!(matches!(fetched[..], [(End::Interrupted, _), (End::Succeeded, _)]), "{fetched:?}");
}

#[test]
fn one_that_dies_while_it_is_inhibited_is_awaited_like_any_other() {
    let mission = load(&file("config/missions/scan.yaml"));
    let (end, records) = failing(&mission, "  - {at: 1 s, inhibit: scanner}\n  - {at: 20 s, lose: scanner}\n");
    assert_eq!(end, MissionEnd::ControllerLost(controller(&mission, "scanner")));
    let awaited = records.iter().rev().find_map(|record| match record {
        Record::Awaited { until, .. } => *until,
        _ => None,
    });
    assert_eq!(awaited.map(Time::seconds), Some(30.0), "from its end on");
}

/// An arm that finds a key in its gripper once it has taken something, and does not get rid of it.
struct Surprised {
    body: Body,
    has_key: bool,
}

impl Controller for Surprised {
    fn configure(&mut self, limits: &ControllerKind, start: ControllerState) -> ControllerState {
        self.body.configure(limits, start);
        self.state()
    }

    fn start(&mut self, command: &Command, mode: Mode) -> Result<(), Rejection> {
        self.body.start(command, mode)
    }

    fn cancel(&mut self) {
        self.body.cancel();
    }

    fn step(&mut self) -> Progress {
        let progress = self.body.step();
        self.has_key |= self.body.state().holds().is_some();
        progress
    }

    fn state(&self) -> ControllerState {
        match self.body.state() {
            ControllerState::Arm { gripper, velocity, .. } if self.has_key => {
                ControllerState::Arm { gripper, velocity, holds: Name::from("key").ok() }
            }
            other => other,
        }
    }
}

#[test]
fn who_holds_what_the_mission_does_not_know_is_not_used() {
    let mission = load(&file("config/missions/scan.yaml"));
    let mut bodies: Vec<Body> = mission.robot.controllers.iter().map(|spec| motion::simulated(&spec.kind)).collect();
    let left = bodies.remove(0);
    bodies.insert(0, Box::new(Surprised { body: left, has_key: false }));
    let mut records = Vec::new();
    let end = sim::simulate_bodies(&mission, &Settings::default(), bodies, Vec::new(), &mut |record: &Record| {
        records.push(record.clone());
    });
    let fetched = ends(&mission, &records, "fetch blood");
    let refused = End::Failed(Fault::Refused(controller(&mission, "left_arm"), Rejection::NoSuchName));
    assert_eq!((end, fetched[0].0), (MissionEnd::Done, refused), "the other arm does it: {fetched:?}");
    let away = records.iter().find_map(|record| match record {
        Record::Served { service, .. } => service.outage(),
        _ => None,
    });
    assert_eq!(away, Some(Loss::HoldsUnknown));
}

#[test]
fn calls_fail_and_hang_on_purpose() {
    let mission = load(&file("config/missions/scan.yaml"));
    let (end, records) = failing(
        &mission,
        "  - {behavior: scan water, fails: aborted}\n  - {behavior: shake blood, attempt: 1, hangs: true}\n",
    );
    assert_eq!(end, MissionEnd::Done);
    let scanned = ends(&mission, &records, "scan water");
    let aborted = End::Failed(Fault::Aborted(controller(&mission, "scanner")));
    assert_eq!(scanned.iter().map(|(end, _)| *end).collect::<Vec<_>>(), [aborted, End::Succeeded]);
    let shaken = ends(&mission, &records, "shake blood");
    assert!(matches!(shaken[..], [(End::Failed(Fault::TimedOut), _), (End::Succeeded, _)]), "{shaken:?}");
}

#[test]
fn the_verb_tells_what_was_done_on_purpose() {
    let home = Home::new();
    let (mission, log) = (file("config/missions/desk.yaml"), home.path("run.jsonl"));
    let text = "failures:\n  - {at: 1 s, set: seen pad}\n  - {behavior: inspect tray, fails: aborted}\n";
    let failures = home.write("failures.yaml", text);
    let args = |verb: &'static str| [verb.as_ref(), mission.as_os_str(), "--fail".as_ref(), failures.as_os_str()];
    let simulate = |more: &[&'static str]| {
        let more = more.iter().map(AsRef::as_ref);
        home.start(args("simulate").into_iter().chain(["--log".as_ref(), log.as_os_str()]).chain(more)).ends(0).stderr
    };
    let said = simulate(&[]);
    let lines = [
        "0.00 s  on purpose: inspect tray gives up in the end, attempt 1",
        "1.00 s  on purpose: somebody sets seen pad",
    ];
    assert!(lines.iter().all(|line| said.contains(line)), "{said}");
    assert!(home.start(["verify".as_ref(), log.as_os_str()]).ends(0).stdout.starts_with("same: "));
    assert_eq!(simulate(&["--quiet"]), "");
    let wrong = home.write("failures.yaml", "failures:\n  - {at: 1 s, lose: neck}\n  - {at: 1 s, set: seen pads}\n");
    for verb in ["simulate", "run", "daemon"] {
        let finished = home.start(args(verb)).ends(2);
        let words = ["there is no controller `neck`", "did you mean `seen pad`?", "failures.yaml:3:20"];
        assert!(words.iter().all(|words| finished.words().contains(words)), "{}", finished.stderr);
    }
    home.write("failures.yaml", "failures:\n  - {at: 1 s, lose: head}\n");
    let refused = home.start(args("daemon")).ends(2).words();
    assert!(refused.contains("what happens to head at 1 s is not the daemon's to do"), "{refused}");
    let resumed = ["run".as_ref(), "--resume".as_ref(), log.as_os_str(), "--fail".as_ref(), wrong.as_os_str()];
    assert!(home.start(resumed).ends(2).stderr.contains("cannot be used with"));
    home.is_empty();
}
