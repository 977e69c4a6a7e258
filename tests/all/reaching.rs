//! What hands reach, from wherever the base comes to stand, and where the one body of a robot can be (`semantics` 3, 6).

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::sync::Arc;

use ambidex::model::{Blocked, Change, Clash, Location, MissionEnd, MissionSpec, Reason, Record};
use ambidex::tree::Settings;

use crate::fixtures::{file, load, simulate_wrongs, steps};
use crate::home::{Home, flat};

fn pr2() -> String {
    file("config/robots/pr2.yaml").display().to_string()
}

fn done(path: &Path) -> (Arc<MissionSpec>, Vec<Record>) {
    let mission = load(path);
    let (end, records) = simulate_wrongs(&mission, &Settings::default(), "");
    assert_eq!(end, MissionEnd::Done, "{}: {}", path.display(), steps(&mission, &records));
    (mission, records)
}

/// A surface of which only the middle is told has room for what there is, and for each thing its own.
#[test]
fn nothing_is_put_into_another_on_a_surface_without_a_table() {
    let home = Home::new();
    let objects = ["cup", "pot", "jar", "pan", "mug", "can"];
    let then =
        |object: &&str| format!("{{then: [{{move: shelf}}, {{pick: {object}}}, {{move: rack}}, {{place: {object}}}]}}");
    let task = format!("and: [{}]", objects.iter().map(then).collect::<Vec<_>>().join(", "));
    // Two of them were told to lie in the same spot of whatever they lie on.
    for told in ["", ", offset: [0, 0.05]"] {
        let listed = objects.iter().enumerate().map(|(index, object)| match index {
            0 => format!("{object}: {{at: shelf{told}}}"),
            1 => format!("{object}: {{at: board{told}}}"),
            _ => format!("{object}: {{at: shelf}}"),
        });
        let task = task.replacen("{move: shelf}, {pick: pot}", "{move: board}, {pick: pot}", 1);
        let text = format!(
            "mission: rack\nrobot: {}\nworld:\n  robot: {{at: [0, 0]}}\n  places:\n    shelf: {{table: {{at: [0, 4], heading: 90 deg, size: \
             [0.5, 1.2, 0.75]}}}}\n    rack: {{stand: [-1.5, 1], heading: 180 deg, surface: [0.6, 0, 0.75]}}\n    board: {{stand: [-1.5, -1], \
             heading: 180 deg, surface: [0.6, 0, 0.75]}}\n  objects: {{{}}}\ntask:\n  {task}\n",
            pr2(),
            listed.collect::<Vec<_>>().join(", ")
        );
        let (mission, records) = done(&home.write("mission.yaml", &text));
        let mut lie = BTreeMap::new();
        for change in records.iter().flat_map(|record| match record {
            Record::Released { changes, .. } => changes.as_slice(),
            _ => &[],
        }) {
            match *change {
                Change::Laid(object, place, spot) => lie.insert(object, mission.world.spot(object, place, Some(spot))),
                Change::Object(object, Location::At(place)) => {
                    lie.insert(object, mission.world.own_spot(object, place))
                }
                _ => None,
            };
        }
        let lie: Vec<_> = lie.into_values().collect();
        assert_eq!(lie.len(), 6, "{lie:?}");
        for (index, one) in lie.iter().enumerate() {
            assert!(lie[..index].iter().all(|other| (one - other).norm() > 0.09), "{lie:?}");
        }
    }
}

/// The robot of the paper with a second base.
fn two_bases(home: &Home) -> String {
    let text = fs::read_to_string(file("config/robots/pr2.yaml")).expect("a robot");
    let text = text.replacen("  base:", "  second: {type: base, controller: second}\n  base:", 1);
    let base = text.rfind("\n  base:").expect("its controller");
    let second = text[base..].replacen("\n  base:", "\n  second:", 1);
    home.write("two.yaml", &format!("{}{second}{}", &text[..base], &text[base..])).display().to_string()
}

/// Two bases of one body do not drive at once, be it to one place.
#[test]
fn one_body_does_not_come_to_a_place_from_two() {
    let home = Home::new();
    let robot = two_bases(&home);
    let text = format!(
        "mission: two\nrobot: {robot}\nworld:\n  robot: {{at: [0, 0]}}\n  places: {{a: {{stand: [2, 0]}}, b: {{stand: [-2, 0]}}}}\n  \
         objects: {{cup: {{at: a}}, pot: {{at: b}}}}\ntask:\n  and:\n    - then: [{{move: a}}, {{pick: cup}}, {{move: b, name: one}}, \
         {{place: cup}}]\n    - then: [{{move: b}}, {{pick: pot}}, {{move: b, name: other}}, {{place: pot}}]\n"
    );
    let (mission, records) = done(&home.write("mission.yaml", &text));
    let mut driving = 0_i32;
    for record in &records {
        match record {
            Record::Decided { granted, .. } => {
                driving += granted.iter().filter(|grant| !grant.way.is_empty()).count() as i32
            }
            Record::Released { leaf, .. } if mission.tree.behavior(*leaf).is_some_and(|spec| spec.is_drive()) => {
                driving -= 1
            }
            _ => {}
        }
        assert!(driving <= 1, "{}", steps(&mission, &records));
    }
}

/// What no hand reaches is known before anything moves, and an OR does not go there.
#[test]
fn what_is_out_of_reach_from_everywhere_never_runs() {
    let home = Home::new();
    let world = |objects: &str, task: &str| {
        format!(
            "mission: reach\nrobot: {}\nworld:\n  robot: {{at: [0, 0]}}\n  places:\n    deep: {{table: {{at: [3, 0], size: [1.6, 1.6, 0.75]}}}}\n    \
             high: {{table: {{at: [0, 3], heading: 90 deg, size: [0.6, 1.2, 2.5]}}}}\n    near: {{table: {{at: [0, -3], heading: -90 deg, \
             size: [0.6, 1.2, 0.75]}}}}\n    shut: {{table: {{at: [-4, 0], heading: 180 deg, size: [0.8, 1.2, 0.75], stands: {{open: {{side: \
             back}}, closed: {{side: front}}}}}}}}\n  walls: [{{from: [-3.4, 1], to: [-2.2, 1]}}, {{from: [-2.2, 1], to: [-2.2, -1]}}, {{from: \
             [-2.2, -1], to: [-3.4, -1]}}]\n  objects: {{{objects}}}\ntask:\n  {task}\n",
            pr2()
        )
    };
    let fetch = |object: &str, place: &str| format!("{{then: [{{move: {place}}}, {{pick: {object}}}]}}");
    for (objects, task, said) in [
        ("cup: {at: deep, offset: [0.9, 0]}", fetch("cup", "deep"), "no hand reaches cup from where it could be taken"),
        ("cup: {at: high}", fetch("cup", "high"), "no hand reaches cup from where it could be taken"),
        ("cup: {at: near, grasps: [back]}", fetch("cup", "near"), "no hand reaches cup from where it could be taken"),
        (
            "cup: {at: shut, grasps: [back], offset: [0.3, 0]}",
            fetch("cup", "shut"),
            "no free path leads to where cup can be taken",
        ),
        (
            "cup: {held: left_gripper}",
            "{then: [{move: high}, {place: cup}]}".into(),
            "no hand that can take cup reaches high",
        ),
    ] {
        let path = home.write("mission.yaml", &world(objects, &task));
        let checked = home.start(["check".as_ref(), path.as_os_str()]).ends(0);
        assert!(flat(&checked.stderr).contains(said), "{said}: {checked:#?}");
        let mission = load(&path);
        let (end, records) = simulate_wrongs(&mission, &Settings::default(), "");
        assert!(matches!(end, MissionEnd::Failed(_)) && steps(&mission, &records).is_empty(), "{said}: {end:?}");
        // The other way is gone at once.
        let either = format!("or: [{task}, {{move: near, name: other}}]");
        let (mission, records) = done(&home.write("either.yaml", &world(objects, &either)));
        assert_eq!(steps(&mission, &records), "other", "{said}");
    }
    // From where a drive brings it that stops nearer it can be.
    let told = "deep: {stand: [3, 0], surface: [1.0, 0, 0.75]}";
    for (offset, is_silent) in [("0.2, 0", true), ("0, 0", false)] {
        let task = format!("then: [{{move: {{to: deep, offset: [{offset}]}}}}, {{pick: cup}}]");
        let text = world("cup: {at: deep, offset: [0, 0]}", &task)
            .replace("deep: {table: {at: [3, 0], size: [1.6, 1.6, 0.75]}}", told);
        let path = home.write("mission.yaml", &text);
        let checked = home.start(["check".as_ref(), path.as_os_str()]).ends(0);
        assert_eq!(!checked.stderr.contains("can never run"), is_silent, "{checked:#?}");
    }
}

/// Of three picks at once the second would cross the first, and the third would not: it is not kept waiting by the second.
#[test]
fn who_crosses_others_does_not_stand_before_who_does_not() {
    let home = Home::new();
    let offset = |object: &str| match object {
        "cup" => -0.2,
        "pot" => -0.1,
        _ => 0.2,
    };
    for order in [["cup", "pot", "jar"], ["cup", "jar", "pot"], ["jar", "pot", "cup"]] {
        let objects =
            order.map(|object| format!("{object}: {{at: table, offset: [0, {}]}}", offset(object))).join(", ");
        let both = |object: &str| format!("{{then: [{{pick: {object}}}, {{place: {object}}}]}}");
        let text = format!(
            "mission: three\nrobot: {}\nworld:\n  robot: {{at: [0, 0]}}\n  places: {{table: {{table: {{at: [2, 0], size: [0.6, 1.2, 0.75]}}}}}}\n  \
             objects: {{{objects}}}\ntask:\n  then: [{{move: table}}, {{and: [{}]}}]\n",
            pr2(),
            order.map(both).join(", ")
        );
        let (mission, records) = done(&home.write("mission.yaml", &text));
        let mut picked = BTreeMap::<_, usize>::new();
        for record in &records {
            if let Record::Decided { at, granted, .. } = record {
                let picks = granted.iter().filter(|grant| mission.names.node(grant.leaf()).starts_with("pick"));
                *picked.entry(*at).or_default() += picks.count();
            }
        }
        let first = picked.values().find(|picks| **picks > 0);
        assert_eq!(first, Some(&2), "{order:?}");
    }
}

/// Who waits for an arm to be out of its way, and for nothing else of it, goes on when that has ended.
#[test]
fn who_was_in_the_way_of_what_ran_goes_on_behind_it() {
    let home = Home::new();
    let kinds = fs::read_to_string(file("config/missions/bin-picking.yaml")).expect("a mission");
    let from = kinds.find("behaviors:").expect("its kinds");
    let kinds = &kinds[from..kinds.find("\ntask:").expect("its task")];
    let text = format!(
        "mission: across\nrobot: {}\nworld:\n  robot: {{at: [0, 0]}}\n  places:\n    bin: {{stand: [0, 0], surface: [0.55, 0, 0.75]}}\n    \
         right box: {{stand: [0, 0], surface: [0.4, -0.4, 0.75]}}\n  objects:\n    cup: {{held: left_gripper}}\n    duck: {{at: bin, offset: [0, \
         0.2]}}\n{kinds}\ntask:\n  and: [{{pull: duck}}, {{drop: {{object: cup, at: right box}}}}]\n",
        file("config/robots/picker.yaml").display()
    );
    let (mission, records) = done(&home.write("mission.yaml", &text));
    let crosses = |blocked: &Blocked| {
        mission.names.node(blocked.leaf).starts_with("drop")
            && matches!(blocked.reason, Reason::Clash { over: Clash::Arms, .. })
    };
    assert!(records.iter().any(|record| record.refusals().iter().any(crosses)), "{}", steps(&mission, &records));
}
