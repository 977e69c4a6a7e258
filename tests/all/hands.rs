//! Objects in several hands (`semantics` 2), each sentence with a mission: in simulation, and with processes.

use std::sync::Arc;

use ambidex::model::{
    Change, ControllerId, Failures, Location, Mishap, MissionEnd, MissionSpec, ObjectId, Origin, Record, ResourceId,
    Time,
};
use ambidex::record::Phase;
use ambidex::tree::Settings;

use crate::fixtures::{file, history, load, simulate_failures, simulate_wrongs, steps};
use crate::home::{Home, flat};

const LEFT: ResourceId = ResourceId(0);
const RIGHT: ResourceId = ResourceId(1);
const TRAY: ObjectId = ObjectId(0);

/// What came of a mission.
struct Told {
    mission: Arc<MissionSpec>,
    records: Vec<Record>,
    end: MissionEnd,
    steps: String,
}

impl Told {
    /// Why a behavior did not run in the end.
    fn reason(&self, behavior: &str) -> String {
        let mut leaves = self.mission.tree.leaves();
        let leaf = leaves.find(|leaf| self.mission.names.node(*leaf) == behavior).expect("a behavior");
        let reason = history(&self.records).reason(leaf);
        reason.map(|reason| reason.sentence(&self.mission.names)).unwrap_or_default()
    }

    /// Where the first object was, each time that this changed.
    fn ways(&self) -> Vec<Location> {
        let mut ways = Vec::new();
        for count in 1..=self.records.len() {
            if let Record::Released { .. } | Record::World { .. } | Record::Began { .. } = self.records[count - 1] {
                let at = history(&self.records[..count]).world().objects[TRAY.index()];
                if ways.last() != Some(&at) {
                    ways.push(at);
                }
            }
        }
        ways
    }
}

/// A mission of the robot of the paper around the kitchen, from what stands below `world` and behind it.
fn text(objects: &str, rest: &str) -> String {
    format!(
        "mission: small\nrobot: {}\ninclude: [{}]\nworld:\n  robot: {{at: [0, 0]}}\n  places:\n    \
         kitchen: {{stand: [2, 0]}}\n    table: {{stand: [2, 3]}}\n    window: {{stand: [4, 0]}}\n  {objects}\n{rest}\n",
        file("config/robots/pr2.yaml").display(),
        file("config/behaviors/household.yaml").display(),
    )
}

/// Simulates a mission in which things go wrong; every decision follows from its log.
fn told(home: &Home, text: &str, failures: &str) -> Told {
    let mission = load(&home.write("mission.yaml", text));
    let (end, records) = simulate_wrongs(&mission, &Settings::default(), failures);
    let steps = steps(&mission, &records);
    Told { mission, records, end, steps }
}

fn held(by: &[ResourceId]) -> Location {
    Location::In(by.to_vec().try_into().expect("some hold it"))
}

const TRAY_AT: &str = "objects: {tray: {at: kitchen, offset: [0, 0]}}";

#[test]
fn an_object_is_held_by_several_at_once() {
    let home = Home::new();
    let task = "task: {then: [{move: kitchen}, {pick_both: tray}, {move: table}, {place_both: tray}]}";
    let told = told(&home, &text(TRAY_AT, task), "");
    let steps = "move to kitchen, pick tray with both hands, move to table, place tray with both hands";
    assert_eq!((told.end, told.steps.as_str()), (MissionEnd::Done, steps));
    assert_eq!(told.ways(), [Location::At(0.into()), held(&[LEFT, RIGHT]), Location::At(1.into())]);
}

#[test]
fn one_hand_is_not_two() {
    let home = Home::new();
    let task = "task: {then: [{move: kitchen}, {pick: tray}, {place_both: {object: tray, at: kitchen}}]}";
    let told = told(&home, &text(TRAY_AT, task), "");
    assert_eq!((matches!(told.end, MissionEnd::Failed(_)), told.steps.as_str()), (true, "move to kitchen, pick tray"));
    let reason = told.reason("place tray with both hands");
    assert_eq!(reason, "tray is held by 1 of this branch of the task, and has to be by 2");
}

#[test]
fn what_is_put_down_is_let_go_by_all_that_hold_it() {
    let home = Home::new();
    let task = "task: {then: [{move: kitchen}, {pick_both: tray}, {place: {object: tray, at: kitchen}}]}";
    let told = told(&home, &text(TRAY_AT, task), "");
    assert_eq!((told.end, told.steps.as_str()), (MissionEnd::Stalled, "move to kitchen, pick tray with both hands"));
    assert_eq!(told.reason("place tray"), "tray is in right_gripper too, which would not let go of it");
}

#[test]
fn a_claim_on_what_holds_it_is_served_by_any_holder() {
    let home = Home::new();
    let kinds = "behaviors:
  tap: {claims: {hand: {type: gripper, holds: tray, keep: physical}}, potential: 1, effects: [{set: tapped}]}
  tip:
    claims: {one: {type: gripper, holds: tray, keep: physical}, other: {resource: left_gripper, holds: tray, keep: physical}}
    potential: 1
    effects: [{set: tipped}]
task: {then: [{move: kitchen}, {pick_both: tray}, tap, tip]}";
    let objects = format!("{TRAY_AT}\n  facts: {{tapped: false, tipped: false}}");
    let told = told(&home, &text(&objects, kinds), "");
    assert_eq!(
        (told.end, told.steps.as_str()),
        (MissionEnd::Done, "move to kitchen, pick tray with both hands, tap, tip")
    );
    let mut grants = told.records.iter().filter_map(|record| match record {
        Record::Decided { granted, .. } => granted.iter().find(|grant| told.mission.names.node(grant.leaf()) == "tip"),
        _ => None,
    });
    let tip = grants.next_back().expect("it was granted");
    let hands: Vec<_> = tip.bindings.iter().map(|binding| binding.resource).collect();
    assert_eq!(hands, [RIGHT, LEFT], "each claim has a holder of its own");
}

#[test]
fn a_hand_takes_it_from_another_which_then_lets_go() {
    let home = Home::new();
    let task = "task:
  then: [{move: kitchen}, {pick_with: {object: tray, hand: left_gripper}}, {use: {pass: {object: tray, hand: right_gripper}}},
         {move: table}, {place: tray}]";
    let told = told(&home, &text(TRAY_AT, task), "");
    let steps = "move to kitchen, pick tray with left_gripper, take over tray with right_gripper, leave tray to \
                 right_gripper, move to table, place tray";
    assert_eq!((told.end, told.steps.as_str()), (MissionEnd::Done, steps));
    let ways = [Location::At(0.into()), held(&[LEFT]), held(&[LEFT, RIGHT]), held(&[RIGHT]), Location::At(1.into())];
    assert_eq!(told.ways(), ways);
    // The giver is told where the other hand is, and whose it is.
    let log = told.records.iter().map(|record| serde_json::to_string(record).expect("text")).collect::<String>();
    assert!(log.contains(r#""grasp":{"object":0,"at":[0.35,0.25,0.9],"holder":0}"#), "{log}");
    assert!(log.contains(r#""put":{"object":0,"at":[0.35,-0.25,0.9],"holder":1}"#), "{log}");
}

#[test]
fn the_last_hand_does_not_let_go() {
    let home = Home::new();
    let slip = |precondition: &str| {
        format!(
            "behaviors:
  slip:
    claims: {{hand: {{type: gripper, holds: tray}}, other: {{type: gripper, empty: true}}}}
    potential: 1{precondition}
    effects: [{{let_go: {{object: tray, by: hand}}}}]
    commands: [{{claim: hand, achieve: {{put: {{object: tray, into: other}}}}}}]
task: {{then: [{{move: kitchen}}, {{pick: tray}}, slip]}}"
        )
    };
    let mission = home.write("mission.yaml", &text(TRAY_AT, &slip("")));
    let refused = flat(&home.start(["check".as_ref(), mission.as_os_str()]).ends(2).stderr);
    assert!(refused.contains("nothing need hold `tray` then, so that it could fall"), "{refused}");
    let known = told(&home, &text(TRAY_AT, &slip("\n    precondition: [{held: {object: tray, hands: 2}}]")), "");
    assert_eq!(
        (matches!(known.end, MissionEnd::Failed(_)), known.steps.as_str()),
        (true, "move to kitchen, pick tray")
    );
}

#[test]
fn what_the_robot_begins_with_is_put_first_or_on_the_way() {
    let home = Home::new();
    let objects = "objects: {bag: {held: left_gripper}, cup: {at: kitchen}}";
    let task = "task: {and: [{then: [{move: table}, {place: bag}]}, {then: [{move: kitchen}, {pick: cup}]}]}";
    let known = told(&home, &text(objects, task), "");
    assert_eq!(
        (known.end, known.steps.as_str()),
        (MissionEnd::Done, "move to kitchen, pick cup, move to table, place bag")
    );
    assert_eq!(known.ways(), [held(&[LEFT]), Location::At(1.into())]);
    // With the other hand full too the cup has to wait, however near it is.
    let objects = "objects: {bag: {held: left_gripper}, cup: {at: kitchen}, pot: {held: right_gripper}}";
    let known = told(&home, &text(objects, task), "");
    assert_eq!(
        (known.end, known.steps.as_str()),
        (MissionEnd::Done, "move to kitchen, move to table, place bag, move to kitchen, pick cup")
    );
    // Both hands, and whoever claims what holds it takes it.
    let objects = "objects: {tray: {held: [right_gripper, left_gripper]}}";
    let task = "task: {then: [{pick_both: {object: tray, at: kitchen}}, {move: table}, {place_both: tray}]}";
    let known = told(&home, &text(objects, task), "");
    assert_eq!((known.end, known.steps.as_str()), (MissionEnd::Done, "move to table, place tray with both hands"));
    assert_eq!(known.ways(), [held(&[LEFT, RIGHT]), Location::At(1.into())]);
}

#[test]
fn what_one_hand_took_before_the_other_failed_is_in_that_hand() {
    let home = Home::new();
    let objects = "objects: {tray: {at: kitchen, offset: [0, 0.3]}}";
    let task = "task: {then: [{move: kitchen}, {pick_both: tray}, {move: table}, {place_both: tray}]}";
    let failures = "\n  - {at: 6500 ms, lose: right_arm}\n  - {at: 7 s, return: right_arm}";
    let known = told(&home, &text(objects, task), failures);
    assert_eq!(known.ways(), [Location::At(0.into()), held(&[LEFT])]);
    assert!(matches!(known.end, MissionEnd::Failed(_)), "{:?}", known.end);
    let path = home.write("mission.yaml", &text(objects, task));
    let failures = home.write("failures.yaml", &format!("failures:{failures}\n"));
    let said = home.start(["simulate".as_ref(), path.as_os_str(), "--fail".as_ref(), failures.as_os_str()]).ends(1);
    let said = flat(&said.stderr);
    assert!(said.contains("failed pick tray with both hands: right_arm was lost"), "{said}");
    assert!(said.contains("pick tray with both hands can never run: tray is in left_gripper already"), "{said}");
}

#[test]
fn what_falls_from_one_of_two_hands_is_in_the_other() {
    let home = Home::new();
    let task = "task: {then: [{move: kitchen}, {pick_both: tray}, {move: table}, {place_both: tray}]}";
    let all = told(&home, &text(TRAY_AT, task), "\n  - {behavior: move to table, drops: tray}");
    assert_eq!(all.end, MissionEnd::Done, "it is picked with both hands again: {}", all.steps);
    assert!(all.ways().starts_with(&[Location::At(0.into()), held(&[LEFT, RIGHT]), Location::At(0.into())]));
    // A hand that comes back empty holds nothing; the other one still does.
    let lost = "\n  - {at: 9 s, lose: right_arm}\n  - {at: 9500 ms, return: right_arm}";
    let one = told(&home, &text(TRAY_AT, task), lost);
    assert!(one.ways().contains(&held(&[LEFT, RIGHT])), "{:?}", one.ways());
}

#[test]
fn a_slot_of_the_robot_holds_what_the_hand_has_no_room_for() {
    let mission = load(&file("config/missions/crate.yaml"));
    let (end, records) = simulate_failures(&mission, &Default::default());
    assert_eq!(end, MissionEnd::Done);
    let fullest = (1..=records.len()).filter_map(|count| match records[count - 1] {
        Record::Released { .. } => Some(history(&records[..count]).world().clone()),
        _ => None,
    });
    let carried = fullest.map(|world| world.objects.iter().filter(|at| !at.holders().is_empty()).count()).max();
    assert_eq!(carried, Some(3), "two in the crate, one in the hand");
}

#[test]
fn arms_and_heads_keep_still_while_the_base_drives() {
    let home = Home::new();
    let rest = "behaviors:
  escort:
    label: escort to $to
    parameters: {to: place, watch: place}
    claims: {base: {type: base}, eyes: {type: head}, arm: {resource: left_gripper}, other: {resource: right_gripper}}
    potential: 3
    goal: [{at: $to}]
    commands:
      - {claim: base, achieve: {drive_to: $to}}
      - {claim: eyes, maintain: {look_at: $watch}}
      - {claim: arm, maintain: stand}
      - {claim: other, achieve: stand}
task: {then: [{escort: {to: table, watch: window}}]}";
    let known = told(&home, &text(TRAY_AT, rest), "");
    assert_eq!((known.end, known.steps.as_str()), (MissionEnd::Done, "escort to table"));
}

#[test]
fn all_of_it_works_with_processes() {
    for name in ["tray", "pass-on", "crate"] {
        let home = Home::new();
        let mission = file(&format!("config/missions/{name}.yaml"));
        let log = home.path("run.jsonl");
        let args = ["run".as_ref(), mission.as_os_str(), "--log".as_ref(), log.as_os_str()];
        let finished = home.start(args.into_iter().chain(["--speed", "20"].map(AsRef::as_ref))).ends(0);
        assert!(!finished.stderr.contains("failed"), "{}", finished.stderr);
        let verified = home.start(["verify".as_ref(), log.as_os_str()]).ends(0);
        assert!(verified.stdout.starts_with("same: "), "{}", verified.stdout);
        home.is_empty();
    }
}

#[test]
fn a_process_is_configured_with_what_its_hand_holds() {
    let home = Home::new();
    let objects = "objects: {bag: {held: left_gripper}, cup: {at: kitchen}}";
    let task = "task: {and: [{then: [{move: table}, {place: bag}]}, {then: [{move: kitchen}, {pick: cup}]}]}";
    let mission = home.write("mission.yaml", &text(objects, task));
    let finished = home.start(["run".as_ref(), mission.as_os_str(), "--speed".as_ref(), "20".as_ref()]).ends(0);
    assert!(flat(&finished.stderr).contains("done place bag"), "{}", finished.stderr);
    home.is_empty();
}

#[test]
fn a_hand_that_comes_back_with_what_a_slot_held_has_taken_it_out() {
    let mission = load(&file("config/missions/crate.yaml"));
    let unstow = "unstow red";
    let failures = |at_s: f64| {
        let (lost, back) = (Time((at_s * 1e6) as u64), Time(((at_s + 4.0) * 1e6) as u64));
        let arm = ControllerId(0);
        Failures { mishaps: vec![(lost, Mishap::Hang(arm)), (back, Mishap::Return(arm))], flaws: Vec::new() }
    };
    let (_, undisturbed) = simulate_failures(&mission, &Failures::default());
    let history = history(&undisturbed);
    let leaf = history.leaves().find(|leaf| history.names().node(*leaf) == unstow).expect("it unstows");
    let phases = history.leaf(leaf).expect("a leaf").phases().to_vec();
    let begun = phases.iter().find(|(_, phase)| *phase == Phase::Active).expect("it ran").0.seconds();
    // Some of these moments are before it has closed its hand, some after.
    let mut taken_out = 0;
    for tenth in 1..55 {
        let (end, records) = simulate_failures(&mission, &failures(begun + f64::from(tenth) / 10.0));
        assert_eq!(end, MissionEnd::Done, "hung {tenth} tenths after it began");
        taken_out += usize::from(records.iter().any(|record| {
            matches!(record, Record::World { change: Change::Emptied(_), origin: Origin::Controller(_), .. })
        }));
    }
    assert!(taken_out > 5, "only {taken_out} times it had it");
}
