//! Where the base stands, where things are put down and from where they are taken (`semantics` 3): each sentence with its
//! missions, and others of its kind.

use std::sync::Arc;

use ambidex::model::{
    Blocked, Change, Command, End, Grant, MissionEnd, MissionSpec, NodeId, ObjectId, Obstacle, Origin, Outcome,
    PlaceId, Record, ResourceId, SpotId, StandId, Time, Told,
};
use ambidex::tree::{Input, Settings};

use crate::driver::{Driver, Lockstep, Rng};
use crate::fixtures::{file, load, simulate_wrongs, steps};
use crate::home::{Home, flat};

const LEFT: ResourceId = ResourceId(0);
const RIGHT: ResourceId = ResourceId(1);

/// A table that can be reached over from two sides, a smaller one beside it, and the robot of the paper.
fn room(start: &str, objects: &str, task: &str) -> String {
    format!(
        "mission: room\nrobot: {}\nworld:\n  robot: {{at: {start}}}\n  places:\n    \
         table: {{table: {{at: [3, 0], size: [1.6, 1.6, 0.75], stands: {{near: {{side: front}}, far: {{side: back}}}}}}}}\n    \
         shelf: {{table: {{at: [0, 4], heading: 90 deg, size: [0.5, 1.0, 0.75]}}}}\n  \
         objects: {{{objects}}}\ntask:\n  {task}\n",
        file("config/robots/pr2.yaml").display()
    )
}

fn run(home: &Home, text: &str) -> (Arc<MissionSpec>, MissionEnd, Vec<Record>) {
    let mission = load(&home.write("mission.yaml", text));
    let (end, records) = simulate_wrongs(&mission, &Settings::default(), "");
    (mission, end, records)
}

fn done(home: &Home, text: &str) -> (Arc<MissionSpec>, Vec<Record>) {
    let (mission, end, records) = run(home, text);
    assert_eq!(end, MissionEnd::Done, "{}: {:?}", steps(&mission, &records), said(&mission, &records));
    (mission, records)
}

fn granted(records: &[Record]) -> impl Iterator<Item = &Grant> {
    records.iter().flat_map(|record| match record {
        Record::Decided { granted, .. } => granted.as_slice(),
        _ => &[],
    })
}

/// The stands that a behavior was granted, one after the other.
fn stands(mission: &MissionSpec, records: &[Record], behavior: &str) -> Vec<StandId> {
    let grants = granted(records).filter(|grant| mission.names.node(grant.leaf()) == behavior);
    grants.filter_map(|grant| grant.request.stand).collect()
}

/// Every reason why something waited.
fn said(mission: &MissionSpec, records: &[Record]) -> Vec<String> {
    let refusals = records.iter().flat_map(|record| record.refusals());
    let mut said: Vec<_> = refusals.map(|blocked: &Blocked| blocked.reason.sentence(&mission.names)).collect();
    said.sort();
    said.dedup();
    said
}

/// Where things were put down: the object, its place and spot, and the hand that did it.
fn laid(records: &[Record]) -> Vec<(ObjectId, PlaceId, SpotId, ResourceId)> {
    let mut all = Vec::new();
    for record in records {
        let Record::Released { leaf, changes, .. } = record else { continue };
        let grant = granted(records).find(|grant| grant.leaf() == *leaf).expect("what ends was granted");
        let hands = grant.bindings.iter().map(|binding| binding.resource);
        let hand = hands.into_iter().find(|resource| [LEFT, RIGHT].contains(resource));
        for change in changes {
            if let (Change::Laid(object, place, spot), Some(hand)) = (*change, hand) {
                all.push((object, place, spot, hand));
            }
        }
    }
    all
}

const NEAR: StandId = StandId(0);
const FAR: StandId = StandId(1);

#[test]
fn the_base_stands_where_what_comes_next_is_reached() {
    let home = Home::new();
    let (before, behind) = ("[0, 0]", "[6, 0]");
    let fetch = "then: [{move: table}, {pick: cup}]";
    // The surface is before the near side: what lies there is reached from there, and what lies a meter on from the far side.
    for (start, offset, stand) in [
        (before, "[0, 0.1]", NEAR),
        (behind, "[0, 0.1]", NEAR),
        (before, "[1.2, 0.1]", FAR),
        (behind, "[1.2, -0.1]", FAR),
    ] {
        let (mission, records) = done(&home, &room(start, &format!("cup: {{at: table, offset: {offset}}}"), fetch));
        assert_eq!(stands(&mission, &records, "move to table"), [stand], "{start} {offset}");
        // What comes later is done at the same stand, whose name is that of what the base is kept for.
        assert_eq!(stands(&mission, &records, "pick cup"), [stand]);
        let name = ["at table (near)", "at table (far)"][stand.index()];
        assert!(mission.names.channels.iter().any(|channel| channel == name), "{:?}", mission.names.channels);
    }
    // Where all of them will do, the nearest one.
    for (start, stand) in [(before, NEAR), (behind, FAR)] {
        let (mission, records) = done(&home, &room(start, "cup: {at: shelf}", "move: table"));
        assert_eq!(stands(&mission, &records, "move to table"), [stand], "{start}");
    }
    // What can be reached next counts, in the order of the THEN, and wherever in the tree that stands.
    let both = "cup: {at: table, offset: [1.2, 0.1]}, pot: {at: table, offset: [0, -0.1]}";
    let then = "then: [{then: [{move: table}, {pick: cup}]}, {then: [{move: table, name: back}, {pick: pot}]}]";
    let (mission, records) = done(&home, &room(before, both, then));
    assert_eq!(stands(&mission, &records, "move to table"), [FAR]);
    assert_eq!(stands(&mission, &records, "back"), [NEAR]);
}

#[test]
fn who_stands_at_another_stand_stands_somewhere_else() {
    let home = Home::new();
    let both = "cup: {at: table, offset: [1.2, 0.1]}, pot: {at: table, offset: [0, -0.1]}";
    let task = "and: [{then: [{move: table}, {pick: cup}]}, {then: [{move: table, name: other}, {pick: pot}]}]";
    let (mission, records) = done(&home, &room("[0, 0]", both, task));
    // Two drives, and neither pick joins the other one's stand.
    assert_eq!(steps(&mission, &records), "other, pick pot, move to table, pick cup");
    let said = said(&mission, &records);
    assert!(said.iter().any(|said| said.ends_with("for \"at table (near)\"")), "{said:?}");
    // At one stand they join.
    let both = "cup: {at: table, offset: [0, 0.1]}, pot: {at: table, offset: [0, -0.1]}";
    let (mission, records) = done(&home, &room("[0, 0]", both, task));
    assert_eq!(steps(&mission, &records), "move to table, pick cup + pick pot");
}

#[test]
fn what_no_single_stand_reaches_is_said_beforehand() {
    let home = Home::new();
    let both = "cup: {at: table, offset: [1.2, 0.1]}, pot: {at: table, offset: [0, -0.1]}";
    for (task, is_said) in [
        ("then: [{move: table}, {and: [{pick: cup}, {pick: pot}]}]", true),
        ("then: [{move: table}, {pick: cup}, {pick: pot}]", true),
        ("then: [{move: table}, {pick: cup}, {move: table, name: back}, {pick: pot}]", false),
        ("then: [{move: table}, {or: [{pick: cup}, {pick: pot}]}]", false),
        ("and: [{then: [{move: table}, {pick: cup}]}, {then: [{move: table, name: back}, {pick: pot}]}]", false),
    ] {
        let path = home.write("mission.yaml", &room("[0, 0]", both, task));
        let said = flat(&home.start(["check", path.to_str().expect("a path")]).ends(0).words());
        let words = "no stand to which move to table goes reaches both this and all else that comes behind it";
        assert_eq!(said.contains(words), is_said, "{task}: {said}");
    }
}

#[test]
fn a_hand_counts_that_reaches_from_some_stand() {
    let home = Home::new();
    // At the left end of the far side only one hand reaches, and which that is depends on the side.
    for (offset, hand) in [("[1.2, 0.7]", RIGHT), ("[1.2, -0.7]", LEFT), ("[0, 0.7]", LEFT), ("[0, -0.7]", RIGHT)] {
        let objects = format!("cup: {{at: table, offset: {offset}}}");
        let (mission, records) = done(&home, &room("[0, 0]", &objects, "then: [{move: table}, {pick: cup}]"));
        let pick = granted(&records).find(|grant| mission.names.node(grant.leaf()) == "pick cup").expect("granted");
        assert!(pick.bindings.iter().any(|binding| binding.resource == hand), "{offset}: {:?}", pick.bindings);
    }
}

#[test]
fn things_are_put_down_apart_and_on_the_side_of_the_arm() {
    let home = Home::new();
    let objects = ["cup", "pot", "jar", "pan"];
    let orders = [[0, 1, 2, 3], [3, 1, 0, 2], [2, 3, 1, 0]];
    for order in orders {
        let listed = order.map(|object: usize| format!("{}: {{at: table}}", objects[object])).join(", ");
        let then = |object: &str| {
            format!("{{then: [{{move: table}}, {{pick: {object}}}, {{move: shelf}}, {{place: {object}}}]}}")
        };
        let task = format!("and: [{}]", objects.map(then).join(", "));
        let (mission, records) = done(&home, &room("[0, 0]", &listed, &task));
        let laid = laid(&records);
        assert_eq!(laid.len(), 4, "{laid:?}");
        let stand = mission.world.places[1].stand;
        let mut at = Vec::new();
        for (object, place, spot, hand) in laid {
            let point = mission.world.spot(object, place, Some(spot));
            let side_m = stand.to_local(point).y;
            assert!(if hand == LEFT { side_m > -0.1 } else { side_m < 0.1 }, "{hand:?} at {side_m}");
            at.push(point);
        }
        for (index, one) in at.iter().enumerate() {
            assert!(at[..index].iter().all(|other| (one - other).norm() > 0.1), "{at:?}");
        }
    }
}

#[test]
fn a_full_table_is_said_to_be_full_and_is_used_once_it_is_not() {
    let home = Home::new();
    // A board that has room for one thing.
    let board = |objects: &str, task: &str| {
        room("[0, 0]", objects, task).replace("size: [0.5, 1.0, 0.75]", "size: [0.2, 0.2, 0.75]")
    };
    let objects = "cup: {at: table, offset: [0, 0.1]}, pot: {at: shelf, offset: [0.05, 0]}";
    let bring = "then: [{move: table}, {pick: cup}, {move: shelf}, {place: cup}]";
    let (mission, end, records) = run(&home, &board(objects, bring));
    assert_eq!(end, MissionEnd::Stalled);
    let reasons = said(&mission, &records);
    assert!(reasons.iter().any(|said| said == "every spot of shelf within reach is taken"), "{reasons:?}");
    let clear = "{then: [{move: shelf, name: clear}, {pick: pot}]}";
    let (mission, records) = done(&home, &board(objects, &format!("and: [{{{bring}}}, {clear}]")));
    assert!(steps(&mission, &records).ends_with("place cup"), "{}", steps(&mission, &records));
    assert_eq!(laid(&records).len(), 1);
}

#[test]
fn two_do_not_put_something_into_one_spot() {
    let home = Home::new();
    let objects = "cup: {at: table, offset: [0, 0.15]}, pot: {at: table, offset: [0, -0.15]}";
    let then =
        |object: &str| format!("{{then: [{{move: table}}, {{pick: {object}}}, {{move: shelf}}, {{place: {object}}}]}}");
    let text = room("[0, 0]", objects, &format!("and: [{}, {}]", then("cup"), then("pot")));
    let (mission, end, records) = run(&home, &text.replace("size: [0.5, 1.0, 0.75]", "size: [0.2, 0.2, 0.75]"));
    assert_eq!(end, MissionEnd::Stalled, "there is room for one");
    let said = said(&mission, &records);
    let clashes = said.iter().any(|said| said.ends_with("puts something down in the same spot"));
    assert!(clashes && said.iter().any(|said| said.contains("is taken")), "{said:?}");
    let (mission, records) = done(&home, &text);
    assert!(steps(&mission, &records).ends_with("place cup + place pot"), "{}", steps(&mission, &records));
}

#[test]
fn hands_come_from_where_a_thing_may_be_grasped() {
    let home = Home::new();
    let narrow = |objects: &str| {
        let text = room("[0, 0]", objects, "then: [{move: table}, {pick: cup}]");
        text.replace("size: [1.6, 1.6, 0.75]", "size: [0.6, 1.6, 0.75]")
    };
    let middle = "offset: [0.1, 0]";
    for (cup, stand) in [
        (middle.to_owned(), NEAR),
        (format!("{middle}, grasps: [front]"), NEAR),
        (format!("{middle}, grasps: [back]"), FAR),
        (format!("{middle}, grasps: [front, back]"), NEAR),
        // Turned half around, its front is its back.
        (format!("{middle}, heading: 180 deg, grasps: [front]"), FAR),
        (format!("{middle}, heading: -170 deg, grasps: [back, above]"), NEAR),
        // From above the arm must be nearer.
        ("offset: [-0.1, 0], grasps: [above]".to_owned(), NEAR),
        ("offset: [0.3, 0], grasps: [above]".to_owned(), FAR),
    ] {
        let (mission, records) = done(&home, &narrow(&format!("cup: {{at: table, {cup}}}")));
        assert_eq!(stands(&mission, &records, "move to table"), [stand], "{cup}");
    }
    // To what is taken from a side the arm on that side comes.
    for (side, hand) in [("left", LEFT), ("right", RIGHT)] {
        let objects = format!("cup: {{at: shelf, offset: [-0.1, 0], grasps: [{side}]}}");
        let (mission, records) = done(&home, &room("[0, 0]", &objects, "then: [{move: shelf}, {pick: cup}]"));
        let pick = granted(&records).find(|grant| mission.names.node(grant.leaf()) == "pick cup").expect("granted");
        assert!(pick.bindings.iter().any(|binding| binding.resource == hand), "{side}: {:?}", pick.bindings);
    }
    // Putting it down the hand turns it, but from above it must be nearer.
    for (grasps, most_m) in [("[front]", 0.9), ("[above]", 0.75)] {
        let objects = format!("cup: {{at: shelf, offset: [-0.1, 0], grasps: {grasps}}}");
        let task = "then: [{move: shelf}, {pick: cup}, {move: table}, {place: cup}]";
        let (mission, records) = done(&home, &room("[0, 0]", &objects, task));
        let (object, place, spot, _) = laid(&records)[0];
        let stand = mission.world.places[place.index()].stand(stands(&mission, &records, "place cup")[0]);
        assert!(stand.to_local(mission.world.spot(object, place, Some(spot))).x < most_m, "{grasps}");
    }
    // Where no hand can come from it is not taken, which is known beforehand.
    let (mission, end, records) =
        run(&home, &room("[0, 0]", "cup: {at: shelf, grasps: [back]}", "then: [{move: shelf}, {pick: cup}]"));
    assert!(matches!(end, MissionEnd::Failed(_)), "{end:?}");
    assert_eq!(steps(&mission, &records), "", "nothing moves");
}

#[test]
fn bodies_of_things_take_their_room() {
    let home = Home::new();
    let check = |objects: &str, words: &[&str]| {
        let path = home.write("mission.yaml", &room("[0, 0]", objects, "move: table"));
        let code = if words.is_empty() { 0 } else { 2 };
        let said = flat(&home.start(["check", path.to_str().expect("a path")]).ends(code).words());
        words.iter().for_each(|word| assert!(said.contains(word), "{word}: {said}"));
    };
    let two = |one: &str, other: &str| {
        format!("box: {{at: table, offset: [0, 0], shape: {one}}}, can: {{at: table, {other}}}")
    };
    let (cube, round) = ("{box: [0.2, 0.1, 0.3]}", "shape: {cylinder: {radius: 0.05, height: 0.1}}");
    check(&two(cube, &format!("offset: [0.2, 0], {round}")), &[]);
    check(&two(cube, &format!("offset: [0.1, 0], {round}")), &["can: it lies in the same spot as box"]);
    check(&two(cube, &format!("offset: [0, 0.12], {round}")), &[]);
    check(&two(cube, "offset: [0, 0.12], heading: 90 deg, shape: {box: [0.2, 0.1, 0.3]}"), &["in the same spot"]);
    check(
        &two(cube, &format!("offset: [0.3, 0, 0.1], {round}")),
        &["can: it floats above the table of table, by 0.10 m"],
    );
    check(&two(cube, &format!("offset: [0.3, 0, -0.1], {round}")), &["can: it is sunk into the table of table"]);
    check(&two(cube, &format!("offset: [1.5, 0], {round}")), &["can: it floats beside the table of table"]);
    check("can: {at: table, shape: {cylinder: {radius: 0.05}}}", &["`height`"]);
    check("can: {at: table, shape: {ball: 1}}", &["ball"]);
    check("can: {at: table, grasps: [below]}", &["below", "above"]);
    // What stands on a table is taken in its middle, and put down so that it stands.
    let objects = "can: {at: table, offset: [0, 0.1], shape: {cylinder: {radius: 0.05, height: 0.2}}}";
    let task = "then: [{move: table}, {pick: can}, {move: shelf}, {place: can}]";
    let (mission, records) = done(&home, &room("[0, 0]", objects, task));
    let lies = mission.world.object(&mission.start, ObjectId(0)).expect("it lies somewhere");
    assert!((lies.z - 0.85).abs() < 1e-9);
    let (object, place, spot, _) = laid(&records)[0];
    assert!((mission.world.spot(object, place, Some(spot)).z - 0.85).abs() < 1e-9);
}

#[test]
fn what_cannot_be_told_of_stands_is_said() {
    let home = Home::new();
    let check = |from: &str, to: &str, words: &[&str]| {
        let text = room("[0, 0]", "cup: {at: table}", "move: table");
        assert!(text.contains(from), "{from}");
        let path = home.write("mission.yaml", &text.replace(from, to));
        let said = flat(&home.start(["check", path.to_str().expect("a path")]).ends(2).words());
        words.iter().for_each(|word| assert!(said.contains(word), "{word}: {said}"));
    };
    check("{side: back}", "{side: top}", &["top", "`front`, `back`, `left`, `right`"]);
    check("{side: back}", "{}", &["`side`"]);
    check(
        "stands: {near: {side: front}, far: {side: back}}",
        "stands: {}",
        &["no stands, where a table has at least one"],
    );
    check("stands: {", "side: left, stands: {", &["`side` and `stands` both tell where the base stands"]);
    check("[0, 4], heading", "[4.6, 0], heading", &["table: the base cannot stand there at its stand 2"]);
}

/// A run in which goals end one after the other, with messages in any order.
fn decided(mission: &Arc<MissionSpec>, interleaving: u64) -> Vec<Record> {
    let settings = Settings::default();
    let mut driver = Driver::new(mission, &settings, Rng::of(&[interleaving]));
    driver = driver.in_lockstep(Lockstep::new(mission, &settings));
    driver.give(NodeId(0), Told::Begin { changes: Vec::new() }.into());
    driver.rest();
    let mut order = Rng::of(&[7]);
    for step in 0.. {
        let running: Vec<NodeId> = driver.goals.keys().copied().collect();
        if running.is_empty() || driver.finished.is_some() {
            break;
        }
        driver.now = Time(1_000_000 * (step + 1));
        if step == 2 {
            let change = Change::Blocked(Obstacle::on_floor([1.0, 2.0].into(), [0.2, 0.2, 1.0].into(), 0.3));
            driver.give(NodeId(0), Told::World { change, origin: Origin::Operator }.into());
            driver.rest();
        }
        let leaf = order.one(&running);
        let drives = driver.goals[&leaf].parts.iter().filter_map(|part| match &part.command {
            Command::Drive { path, .. } => path.last().copied().map(Change::Base),
            _ => None,
        });
        let outcome = Outcome { end: End::Succeeded, changes: drives.collect() };
        driver.give(leaf, Input::Ended(Box::new(outcome)));
        driver.rest();
    }
    assert_eq!(driver.difference(), None, "each round is that of plain recursion");
    driver.records
}

#[test]
fn stands_and_spots_do_not_depend_on_the_order_of_messages() {
    for name in ["island", "experiment-1-room", "bin-picking", "detour"] {
        let mission = load(&file(&format!("config/missions/{name}.yaml")));
        let first = decided(&mission, 0);
        assert!(first.iter().any(|record| matches!(record, Record::Ended { end: MissionEnd::Done, .. })), "{name}");
        for interleaving in 1..6 {
            assert!(decided(&mission, interleaving) == first, "{name}, interleaving {interleaving}");
        }
    }
}

#[test]
fn the_island_is_used_from_both_sides() {
    let mission = load(&file("config/missions/island.yaml"));
    let (end, records) = simulate_wrongs(&mission, &Settings::default(), "");
    assert_eq!(end, MissionEnd::Done);
    assert_eq!(stands(&mission, &records, "go for the pan"), [NEAR]);
    assert_eq!(stands(&mission, &records, "go for the jug"), [FAR]);
}

/// A room that is told whole.
fn whole(home: &Home, text: &str) -> (Arc<MissionSpec>, MissionEnd, Vec<Record>) {
    run(home, &format!("mission: whole\n{}", text.replace("ROBOTS", file("config/robots").to_str().expect("UTF-8"))))
}

const TWO_SIDES: &str =
    "table: {table: {at: [3, 0], size: [1.6, 1.6, 0.75], stands: {near: {side: front}, far: {side: back}}}}";

#[test]
fn one_open_stand_is_enough() {
    let home = Home::new();
    // The near stand lies in a room without a door.
    let walls = "[{from: [0, -3], to: [3, -3]}, {from: [3, -3], to: [3, -0.87]}, {from: [0, -3], to: [0, 3]}, \
                 {from: [0, 3], to: [3, 3]}, {from: [3, 3], to: [3, 0.87]}]";
    let text = |start: &str| {
        format!(
            "robot: ROBOTS/pr2.yaml\nworld:\n  robot: {{at: {start}}}\n  places:\n    {TWO_SIDES}\n  walls: {walls}\n\
             task: {{move: table}}\n"
        )
    };
    for (start, stand) in [("[6, 0]", FAR), ("[0.7, 0]", NEAR)] {
        let (mission, end, records) = whole(&home, &text(start));
        assert_eq!((end, stands(&mission, &records, "move to table")), (MissionEnd::Done, vec![stand]), "{start}");
    }
    let (mission, end, records) = whole(&home, &text("[3, 5]").replace("to: [3, 0.87]}]", "to: [3, 0.87]}, {from: [3, -1.5], to: [7, -1.5]}, {from: [7, -1.5], to: [7, 1.5]}, {from: [7, 1.5], to: [3, 1.5]}]"));
    assert_ne!(end, MissionEnd::Done, "both are shut: {}", steps(&mission, &records));
}

#[test]
fn whoever_follows_what_lies_nowhere_drives_nowhere() {
    let home = Home::new();
    let text = format!(
        "robot: ROBOTS/pr2.yaml\nworld:\n  robot: {{at: [-1, 0]}}\n  places:\n    {TWO_SIDES}\n    \
         shelf: {{table: {{at: [0, 8], heading: 90 deg, size: [0.5, 1.0, 0.75]}}}}\n  \
         objects: {{cup: {{held: left_gripper}}}}\n\
         task: {{and: [{{then: [{{move: shelf}}, {{place: cup}}]}}, {{then: [{{move: cup}}, {{pick: cup}}]}}]}}\n"
    );
    let (mission, end, records) = whole(&home, &text);
    assert_eq!((end, steps(&mission, &records).as_str()), (MissionEnd::Done, "move to shelf, place cup"));
}

#[test]
fn a_stand_counts_for_the_hand_that_will_put_it_down() {
    let home = Home::new();
    // From the slot or out of the hand: the table is reached from its middle, and not from far aside.
    for (held, task) in [("left_slot", "{unstow: cup}, {place: cup}"), ("gripper", "{place: cup}")] {
        let text = format!(
            "robot: ROBOTS/carrier.yaml\ninclude: [ROBOTS/../behaviors/household.yaml]\nworld:\n  robot: {{at: [0, 3]}}\n  \
             places:\n    table:\n      table: {{at: [3, 0], size: [0.6, 1.6, 0.75], stands: {{mid: {{side: front}}, off: \
             {{side: front, along: 3}}}}}}\n  objects: {{cup: {{held: {held}}}}}\ntask: {{then: [{{move: table}}, {task}]}}\n"
        );
        let (mission, end, records) = whole(&home, &text);
        assert_eq!(end, MissionEnd::Done, "{held}: {:?}", said(&mission, &records));
        assert_eq!(stands(&mission, &records, "move to table"), [NEAR], "{held}");
    }
}

#[test]
fn large_things_are_put_down_apart() {
    let home = Home::new();
    let plates = |radius_m: f64| {
        let plate = |hand: &str| format!("{{held: {hand}, shape: {{cylinder: {{radius: {radius_m}, height: 0.03}}}}}}");
        format!(
            "robot: ROBOTS/pr2.yaml\nworld:\n  robot: {{at: [0, 0]}}\n  places: {{table: {{table: {{at: [3, 0], size: \
             [0.8, 2.4, 0.75]}}}}}}\n  objects: {{cup: {}, pot: {}}}\n\
             task: {{then: [{{move: table}}, {{and: [{{place: cup}}, {{place: pot}}]}}]}}\n",
            plate("left_gripper"),
            plate("right_gripper")
        )
    };
    for (radius_m, at_once) in [(0.05, true), (0.25, false)] {
        let (mission, end, records) = whole(&home, &plates(radius_m));
        assert_eq!(end, MissionEnd::Done, "{radius_m}: {:?}", said(&mission, &records));
        assert_eq!(steps(&mission, &records).contains(" + "), at_once, "{radius_m}");
        let at: Vec<_> = laid(&records).iter().map(|l| mission.world.spot(l.0, l.1, Some(l.2))).collect();
        assert!((at[0] - at[1]).norm() >= 2.0 * radius_m, "{at:?}");
    }
    // A tray fits a shelf that is as deep as it is, whatever the circle around it.
    let tray = "robot: ROBOTS/pr2.yaml\nworld:\n  robot: {at: [0, 0]}\n  places:\n    \
                table: {table: {at: [3, 0], size: [0.5, 1.6, 0.75]}}\n    \
                shelf: {table: {at: [0, 4], heading: 90 deg, size: [0.4, 1.0, 0.75]}}\n  \
                objects: {tray: {at: table, shape: {box: [0.3, 0.4, 0.03]}}}\n\
                task: {then: [{move: table}, {pick: tray}, {move: shelf}, {place: tray}]}\n";
    let (mission, end, records) = whole(&home, tray);
    assert_eq!(end, MissionEnd::Done, "{:?}", said(&mission, &records));
}

/// One behavior that puts down two things.
#[test]
fn two_things_of_one_behavior_come_to_two_spots() {
    let home = Home::new();
    let text = "robot: ROBOTS/pr2.yaml\nbehaviors:\n  place_two:\n    \
                parameters: {a: object, b: object, at: {type: place, default: $before}}\n    claims:\n      \
                base: {type: base, shared: at $at}\n      one: {type: gripper, holds: $a}\n      \
                other: {type: gripper, holds: $b}\n    potential: high\n    \
                goal: [{lies: {object: $a, at: $at}}, {lies: {object: $b, at: $at}}]\n    \
                precondition: [{at: $at}, {held: $a}, {held: $b}]\n    \
                effects: [{lies: {object: $a, at: $at}}, {lies: {object: $b, at: $at}}]\n    commands:\n      \
                - {claim: one, achieve: {put: {object: $a, at: $at}}}\n      \
                - {claim: other, achieve: {put: {object: $b, at: $at}}}\n      - {claim: base, maintain: stand}\n\
                world:\n  robot: {at: [0, 0]}\n  places: {table: {table: {at: [3, 0], size: [0.8, 1.6, 0.75]}}}\n  \
                objects: {cup: {held: left_gripper}, pot: {held: right_gripper}}\n\
                task: {then: [{move: table}, {place_two: {a: cup, b: pot}}]}\n";
    let (mission, end, records) = whole(&home, text);
    assert_eq!(end, MissionEnd::Done, "{:?}", said(&mission, &records));
    let laid = laid(&records);
    assert!(laid.len() == 2 && laid[0].2 != laid[1].2, "{laid:?}");
}
