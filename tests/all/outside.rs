//! Facts and objects from outside (`semantics` 8): who may change what, when it counts, and that it is told.

use std::sync::Arc;
use std::time::Duration;

use ambidex::model::{
    Change, ControllerId, ControllerMessage, FactId, Location, Misreport, MissionEnd, MissionSpec, NodeId, ObjectId,
    Objection, Origin, PlaceId, Record, Reportable, ResourceId, Time, Told, Uptake,
};
use ambidex::motion::{self, Report};
use ambidex::replay::Replay;
use ambidex::show::{Palette, live, timeline};
use ambidex::sim::{self, Body, Event};
use ambidex::tree::Settings;

use crate::driver::{Driver, Rng};
use crate::fixtures::{file, history, load, mission};
use crate::home::Home;
use crate::sensor::Sensor;

const ROOT: NodeId = NodeId(0);
const OPEN: FactId = FactId(0);
const ENTERED: FactId = FactId(1);
const CUP: ObjectId = ObjectId(0);
const SHELF: PlaceId = PlaceId(0);
const TABLE: PlaceId = PlaceId(1);

const ROOM: &str = "objects: {cup: {at: shelf}}
  facts: {door open: {outside: true}, entered: false}
behaviors:
  enter: {claims: {hand: {type: gripper}}, potential: 3, precondition: [{fact: door open}], effects: [{set: entered}], takes: 2 s}
  shut: {claims: {hand: {type: gripper}}, potential: 2, effects: [{clear: door open}], takes: 4 s}
task:
";

fn room(home: &Home, task: &str) -> Arc<MissionSpec> {
    load(&home.write("room.yaml", &mission(&format!("{ROOM}  {task}"))))
}

fn at(seconds: u64, change: Change, origin: Origin) -> (Time, Event) {
    (Time::ZERO + Duration::from_secs(seconds), Event::World(change, origin))
}

fn lies(at: PlaceId) -> Change {
    Change::Object(CUP, Location::At(at))
}

/// A simulated mission; every decision follows from its log.
fn simulated(mission: &Arc<MissionSpec>, bodies: Vec<Body>, events: Vec<(Time, Event)>) -> (MissionEnd, Vec<Record>) {
    let mut records = Vec::new();
    let end = sim::simulate_bodies(mission, &Settings::default(), bodies, events, &mut |record| {
        records.push(record.clone());
    });
    replayed(mission, &records);
    (end, records)
}

fn replayed(mission: &Arc<MissionSpec>, records: &[Record]) -> Replay {
    let mut replay = Replay::new(mission, &Settings::default());
    records.iter().for_each(|record| replay.take(record).expect("every decision follows"));
    replay
}

fn bodies(mission: &MissionSpec) -> Vec<Body> {
    mission.robot.controllers.iter().map(|spec| motion::simulated(&spec.kind)).collect()
}

type Changed = Vec<(Change, Origin)>;
type Refused = Vec<(Change, Objection)>;

/// What was changed from outside, and what was refused.
fn told(records: &[Record]) -> (Changed, Refused) {
    let (mut changed, mut denied) = (Vec::new(), Vec::new());
    for record in records {
        match record {
            Record::World { change, origin, .. } => changed.push((*change, *origin)),
            Record::Denied { change, why, .. } => denied.push((*change, *why)),
            _ => {}
        }
    }
    (changed, denied)
}

fn rounds(records: &[Record]) -> usize {
    records.iter().filter(|record| matches!(record, Record::Decided { .. })).count()
}

#[test]
fn only_what_is_declared_outside_is_set_and_cleared() {
    let home = Home::new();
    let mission = room(&home, "then: [{move: table}, {enter: }]");
    let say = |seconds, change| at(seconds, change, Origin::Operator);
    let events = vec![
        say(1, Change::Fact(ENTERED, true)),
        say(2, Change::Fact(OPEN, true)),
        say(3, Change::Emptied(ResourceId(0))),
        say(3, Change::Object(CUP, Location::held(ResourceId(0)))),
    ];
    let (end, records) = simulated(&mission, bodies(&mission), events);
    assert_eq!(end, MissionEnd::Done);
    let (changed, denied) = told(&records);
    assert_eq!(changed, [(Change::Fact(OPEN, true), Origin::Operator)]);
    let expected = [
        (Change::Fact(ENTERED, true), Objection::NotOutside),
        (Change::Emptied(ResourceId(0)), Objection::NotTheirs),
        (Change::Object(CUP, Location::held(ResourceId(0))), Objection::NotTheirs),
    ];
    assert_eq!(denied, expected, "only who moves a gripper says what is in it");
    // What goes wrong on purpose is no user of the robot: it changes what it likes.
    let (_, records) = simulated(&mission, bodies(&mission), vec![at(1, Change::Fact(ENTERED, true), Origin::Script)]);
    assert_eq!(told(&records).0, [(Change::Fact(ENTERED, true), Origin::Script)]);
}

#[test]
fn an_object_is_moved_unless_a_gripper_holds_it() {
    let home = Home::new();
    let mission = room(&home, "then: [{move: cup}, {pick: cup}, {move: table}, {place: {object: cup, at: table}}]");
    let (_, undisturbed) = simulated(&mission, bodies(&mission), Vec::new());
    let picked = undisturbed.iter().find_map(|record| match record {
        Record::Released { at, leaf, .. } if mission.names.node(*leaf) == "pick cup" => Some(*at),
        _ => None,
    });
    let held = picked.expect("it is picked") + Duration::from_millis(10);
    for origin in [Origin::Operator, Origin::Controller(ControllerId(2))] {
        let (end, records) = simulated(&mission, bodies(&mission), vec![(held, Event::World(lies(SHELF), origin))]);
        let (changed, denied) = told(&records);
        assert_eq!((end, changed.len()), (MissionEnd::Done, 0));
        assert!(matches!(denied[..], [(_, Objection::Held { .. })]), "{denied:?}");
    }
    // Moved while it lies, it is fetched from where it is now.
    let (end, records) = simulated(&mission, bodies(&mission), vec![at(1, lies(TABLE), Origin::Operator)]);
    assert_eq!((end, told(&records).0), (MissionEnd::Done, vec![(lies(TABLE), Origin::Operator)]));
}

#[test]
fn it_counts_once_the_mission_has_begun_and_before_it_is_over() {
    let home = Home::new();
    let mission = room(&home, "then: [{move: table}]");
    let attach = |id| (Time::ZERO + Duration::from_secs(2), Event::Attach(ControllerId(id)));
    let mut events = vec![at(1, Change::Fact(OPEN, true), Origin::Operator)];
    events.extend((0..4).map(attach));
    let (_, records) = simulated(&mission, bodies(&mission), events);
    assert_eq!(told(&records), (vec![], vec![(Change::Fact(OPEN, true), Objection::NotBegun)]));

    let mut driver = Driver::new(&mission, &Settings::default(), Rng::of(&[1]));
    driver.give(ROOT, Told::Begin { changes: Vec::new() }.into());
    driver.give(ROOT, Told::End { end: MissionEnd::Canceled }.into());
    driver.rest();
    let records = driver.records.len();
    driver.give(ROOT, Told::World { change: Change::Fact(OPEN, true), origin: Origin::Operator }.into());
    driver.rest();
    assert_eq!(driver.records.len(), records, "the log is closed");
    assert_eq!(driver.taken_up, [(Change::Fact(OPEN, true), Uptake::Refused(Objection::Over))]);
}

#[test]
fn it_waits_for_the_open_round_and_only_a_difference_opens_one() {
    let home = Home::new();
    let mission = room(&home, "then: [{move: table}, {enter: }]");
    let open = |holds| Told::World { change: Change::Fact(OPEN, holds), origin: Origin::Operator };
    let mut driver = Driver::new(&mission, &Settings::default(), Rng::of(&[1]));
    driver.give(ROOT, Told::Begin { changes: Vec::new() }.into());
    driver.turn();
    driver.give(ROOT, open(true).into());
    assert!(!driver.root().wants_turn(), "a round is open");
    assert!(!driver.root().state().world().facts[OPEN.index()]);
    driver.rest();
    let is_world = |record: &Record| matches!(record, Record::World { .. });
    let (decided, world) = (
        driver.records.iter().position(|record| matches!(record, Record::Decided { .. })),
        driver.records.iter().position(is_world),
    );
    assert!(decided.is_some() && decided < world, "{decided:?} {world:?}");
    // The same once more: root is told, and nothing comes of it.
    let before = rounds(&driver.records);
    driver.give(ROOT, open(true).into());
    driver.rest();
    assert_eq!(rounds(&driver.records), before);
    driver.give(ROOT, open(false).into());
    driver.rest();
    assert!(rounds(&driver.records) > before);
    let open = |holds, uptake| (Change::Fact(OPEN, holds), uptake);
    assert_eq!(driver.taken_up, [open(true, Uptake::Changed), open(true, Uptake::Same), open(false, Uptake::Changed)]);
}

#[test]
fn the_result_of_a_running_behavior_overrules_it() {
    let home = Home::new();
    let mission = room(&home, "then: [{shut: }, {move: table}]");
    let facts = |events| history(&simulated(&mission, bodies(&mission), events).1).world().facts.clone();
    let set = |seconds| at(seconds, Change::Fact(OPEN, true), Origin::Operator);
    assert_eq!(facts(vec![set(1)]), [false, false], "it was shut after that");
    assert_eq!(facts(vec![set(1), set(5)]), [true, false], "what is said later counts again");
}

#[test]
fn a_change_survives_the_runtime() {
    let home = Home::new();
    let mission = room(&home, "then: [{move: table}, {enter: }]");
    let (_, records) = simulated(&mission, bodies(&mission), vec![at(1, Change::Fact(OPEN, true), Origin::Operator)]);
    let told = records.iter().position(|record| matches!(record, Record::Told { input: Told::World { .. }, .. }));
    let told = told.expect("root was told");
    // Killed when it was told and had not decided, when it had, and later.
    for stop in [told + 1, told + 2, told + 3, told + 20] {
        let mut log = records[..stop].to_vec();
        let resumed = replayed(&mission, &log).finish();
        let end = sim::resume(&mission, resumed, &mut |record| log.push(record.clone()));
        assert_eq!(end, MissionEnd::Done, "stopped behind record {stop}");
        replayed(&mission, &log);
        assert!(history(&log).world().facts[OPEN.index()]);
    }
}

#[test]
fn who_says_what_is_told() {
    let home = Home::new();
    let mission = room(&home, "then: [{move: table}, {enter: }]");
    let events =
        vec![at(1, Change::Fact(ENTERED, true), Origin::Operator), at(2, Change::Fact(OPEN, true), Origin::Operator)];
    let (_, records) = simulated(&mission, bodies(&mission), events);
    let lines: Vec<String> =
        (1..=records.len()).filter_map(|count| live::line(&history(&records[..count]), &records[count - 1])).collect();
    let said = lines.join("\n");
    assert!(said.contains("2.00 s  \"door open\" holds now: set by an operator"), "{said}");
    let refused =
        "an operator says that \"entered\" holds now, which is refused: \"entered\" is not declared `outside`";
    assert!(said.contains(refused), "{said}");
    let text = timeline::text(&history(&records), 100, &Palette::plain());
    assert!(text.contains("2.00 s  \"door open\" holds now: set by an operator"), "{text}");
}

const DOOR: ControllerId = ControllerId(2);

fn seeing(mission: &Arc<MissionSpec>, reports: Vec<Report>) -> (MissionEnd, Vec<Record>) {
    let mut bodies = bodies(mission);
    bodies[DOOR.index()] = Box::new(Sensor(move || reports.clone()));
    // It attaches long before the mission begins.
    let others = [0, 1].map(|id| (Time::ZERO + Duration::from_secs(3), Event::Attach(ControllerId(id))));
    let events = [(Time::ZERO, Event::Attach(DOOR))].into_iter().chain(others).collect();
    simulated(mission, bodies, events)
}

#[test]
fn controllers_report_what_their_robot_file_lets_them() {
    let mut mission = (*load(&file("config/missions/door.yaml"))).clone();
    let check = |mission: &MissionSpec, report, expected: Option<Misreport>| {
        let mission = Arc::new(mission.clone());
        let (end, records) = seeing(&mission, vec![report]);
        let misreported = records.iter().find_map(|record| match record {
            Record::Controller { controller: DOOR, message: ControllerMessage::Misreported { why, .. }, .. } => {
                Some(*why)
            }
            _ => None,
        });
        assert_eq!(misreported, expected, "{report}");
        (end, told(&records))
    };
    let from_door = Origin::Controller(DOOR);
    let open = Report::fact("door open", true);
    let (end, (changed, _)) = check(&mission, open, None);
    assert_eq!((end, changed), (MissionEnd::Done, vec![(Change::Fact(OPEN, true), from_door)]), "it waits for nobody");
    let (_, (changed, _)) = check(&mission, Report::object("parcel", Some("office")), None);
    assert_eq!(changed, [(Change::Object(CUP, Location::At(PlaceId(1))), from_door)]);
    let (_, (changed, _)) = check(&mission, Report::object("parcel", None), None);
    assert_eq!(changed, [(Change::Object(CUP, Location::Unknown), from_door)]);
    check(&mission, Report::object("parcel", Some("ofice")), Some(Misreport::NoSuchPlace));
    check(&mission, Report::object("chair", Some("office")), Some(Misreport::NotAllowed));
    check(&mission, Report::fact("door shut", true), Some(Misreport::NotAllowed));
    let allowed = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect::<Vec<_>>();
    mission.robot.controllers[DOOR.index()].reports =
        Reportable { facts: allowed(&["door shut", "door open"]), objects: allowed(&["chair"]) };
    check(&mission, Report::fact("door shut", true), Some(Misreport::NoSuchFact));
    check(&mission, Report::object("chair", Some("office")), Some(Misreport::NoSuchObject));
    mission.world.outside = vec![false];
    let (_, (changed, denied)) = check(&mission, open, None);
    assert_eq!((changed, denied), (vec![], vec![(Change::Fact(OPEN, true), Objection::NotOutside)]));
}

#[test]
fn what_a_controller_repeats_is_no_news() {
    let home = Home::new();
    let mission = room(&home, "then: [{move: table}, {enter: }]");
    let say = |seconds, change| at(seconds, change, Origin::Controller(ControllerId(2)));
    let (open, shut, entered) = (Change::Fact(OPEN, true), Change::Fact(OPEN, false), Change::Fact(ENTERED, true));
    let events = vec![say(1, shut), say(2, entered), say(2, entered), say(2, entered), say(2, open), say(2, open)];
    let (_, records) = simulated(&mission, bodies(&mission), events);
    let words =
        records.iter().filter(|record| matches!(record, Record::Told { input: Told::World { .. }, .. })).count();
    let (changed, denied) = told(&records);
    assert_eq!((words, changed.len(), denied.len()), (2, 1, 1), "each is told once");
    // Refused once more after the world has changed it is told once more.
    let events = vec![say(2, entered), say(2, open), say(2, entered), say(2, entered)];
    let (_, records) = simulated(&mission, bodies(&mission), events);
    assert_eq!(told(&records).1.len(), 2);
}
