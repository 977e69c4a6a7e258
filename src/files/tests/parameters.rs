//! Parameters of a mission: what is set, what is left to a default, and what is said of the rest.

use std::sync::Arc;

use super::super::{FilesError, Setting, load_mission};
use super::{GOOD, PATH, ROBOT, written};
use ambidex_model::{MissionSpec, NodeId, Potential};

/// A mission that fetches what it is told.
fn fetching() -> String {
    let head = &GOOD[..GOOD.find("task:").unwrap()];
    let parameters = "parameters: {object: {type: object, default: cup}, to: place, by: {type: offset, default: [0, 0]}, \
                      wish: {type: number, default: 2}}";
    format!(
        "{head}{parameters}\nbehaviors: {{wave: {{parameters: {{p: number}}, potential: $p}}}}\nsubtrees:\n  bring: \
         {{parameters: {{what: object, to: place}}, task: {{place: {{object: $what, at: $to}}}}}}\ntask:\n  then:\n    - \
         {{move: shelf, name: go for $object}}\n    - pick: $object\n    - {{move: {{to: $to, offset: $by}}}}\n    - {{use: \
         {{bring: {{what: $object, to: $to}}}}}}\n    - wave: $wish\n"
    )
}

fn load(mission: &str, settings: &[&str]) -> Result<Arc<MissionSpec>, FilesError> {
    let settings: Vec<Setting> = settings.iter().map(|setting| setting.parse().expect("a setting")).collect();
    load_mission(&written(mission, ROBOT), PATH.as_ref(), None, &settings).map(|loaded| {
        let said: Vec<_> = loaded.warnings.iter().map(ToString::to_string).collect();
        assert!(said.iter().all(|said| !said.contains("is not used")), "{said:?}");
        loaded.mission
    })
}

#[test]
fn what_is_set_stands_in_the_task() {
    let names = |settings: &[&str]| {
        let mission = load(&fetching(), settings).unwrap_or_else(|error| panic!("{:?}", error.faults()));
        (mission.names.nodes.to_vec()[2..].join(", "), mission.tree.behavior(NodeId(6)).unwrap().potential)
    };
    let of_cup = "go for cup, pick cup, move to table, bring cup, wave 2";
    let of_pot = "go for pot, pick pot, move to shelf, bring pot, wave 4.5";
    assert_eq!(names(&["to=table"]), (of_cup.to_owned(), Potential::Constant(2.0)));
    let all = ["to=shelf", "object = pot", "wish=4.5", "by=[1 m, 20 cm]"];
    assert_eq!(names(&all), (of_pot.to_owned(), Potential::Constant(4.5)));
    let mission = load(&fetching(), &all).unwrap();
    let Potential::Nearness { to, .. } = mission.tree.behavior(NodeId(4)).unwrap().potential else { panic!("a move") };
    assert_eq!((to.at.x, to.at.y), (2.0, 2.2));
}

#[test]
fn what_cannot_be_set_is_told() {
    let check = |settings: &[&str], expected: &[&str]| {
        let error = load(&fetching(), settings).expect_err(expected[0]);
        let line = |at: Option<(usize, usize)>| at.map_or(String::new(), |(line, _)| format!("{line}:"));
        let said: Vec<_> = error
            .faults()
            .iter()
            .map(|fault| format!("{}{fault}; {}", line(fault.position()), fault.help().unwrap_or_default()))
            .collect();
        assert_eq!(said.len(), expected.len(), "{settings:?}: {said:#?}");
        for (said, expected) in said.iter().zip(expected) {
            assert!(said.starts_with(expected), "{settings:?}: {said} without `{expected}`");
        }
    };
    check(&[], &["12:to: nothing tells a place: `to`; tell it with `--set to=PLACE`, or give it a `default`"]);
    check(&["to=tabel"], &["--set to=tabel: there is no place `tabel`; did you mean `table`?"]);
    check(
        &["to=table", "obect=pot"],
        &["--set obect=pot: the mission has no parameter `obect`; did you mean `object`?"],
    );
    check(&["to=table", "wish=much"], &["--set wish=much: found `much` instead of a number"]);
    check(&["to=table", "wish=-1"], &["--set wish=-1: `-1` is out of bounds"]);
    check(&["to=table", "by=1 m"], &["--set by=1 m: found `1 m` instead of two numbers: [x, y]"]);
    check(&["to=table", "by=[1, far]"], &["--set by=[1, far]: found `far` instead of a length"]);
    check(&["to=table", "to=shelf"], &["--set to=shelf: `to` is set twice"]);
    check(&["to="], &["--set to=: a name cannot be empty"]);
    check(&["to=$before"], &["--set to=$before: there is no place `$before`"]);
    let both = ["--set to=spoon: there is no place `spoon`", "--set object=table: there is no object `table`"];
    check(&["to=spoon", "object=table"], &both);
}

#[test]
fn what_is_wrong_is_told_once_and_nothing_that_follows_from_it() {
    let text = fetching().replacen("{move: shelf, name: go for $object}", "{move: $object}", 1);
    let error = load(&text, &["to=table", "object=nope"]).expect_err("there is no such object");
    let said: Vec<_> = error.faults().iter().map(ToString::to_string).collect();
    assert_eq!(said, ["--set object=nope: there is no object `nope`"]);
}

#[test]
fn parameters_of_a_mission_are_checked_like_all_others() {
    let check = |from: &str, by: &str, expected: &str| {
        let text = fetching();
        assert!(text.contains(from), "{from}");
        let error = load(&text.replacen(from, by, 1), &["to=table"]).expect_err(expected);
        let said = error.faults().iter().map(|fault| format!("{fault}; {}", fault.help().unwrap_or_default()));
        let said: Vec<_> = said.collect();
        assert!(said.iter().any(|said| said.contains(expected)), "{said:?}");
    };
    check("default: cup", "default: cub", "object: there is no object `cub`; did you mean `cup`?");
    check("default: cup", "default: $start", "a mission has one plain value as a default");
    check("to: place", "to: plaice", "did you mean `place`?");
    check("pick: $object", "pick: $objekt", "there is no parameter `objekt` here; did you mean `object`?");
    check("pick: $object", "pick: $to", "`$to` is a place, not an object");
    let unused = fetching().replacen("    - wave: $wish\n", "", 1);
    let loaded = load_mission(&written(unused, ROBOT), PATH.as_ref(), None, &["to=table".parse().unwrap()]).unwrap();
    assert_eq!(loaded.warnings[0].to_string(), "wish: parameter `wish` is not used");
}

#[test]
fn a_setting_is_a_name_and_a_value() {
    for text in ["object", "=cup", "", " = "] {
        let said = text.parse::<Setting>().expect_err(text).to_string();
        assert_eq!(said, "write NAME=VALUE, such as object=cup");
    }
    let setting: Setting = "a=b=c".parse().unwrap();
    assert_eq!((setting.name.as_str(), setting.value.as_str()), ("a", "b=c"));
}
