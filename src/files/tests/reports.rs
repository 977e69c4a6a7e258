//! What controllers may report: what it becomes, and what is said of it.

use super::super::load_mission;
use super::{GOOD, PATH, ROBOT, load, written};
use ambidex_model::Reportable;

/// The robot with a sensor.
fn with_sensor(reports: &str) -> String {
    format!("{ROBOT}  eye: {{device: {{{reports}}}}}\n")
}

/// What is said of a mission that is sound.
fn warnings(mission: &str, robot: &str) -> Vec<String> {
    let loaded = load_mission(&written(mission, robot), PATH.as_ref(), None, &[]);
    let warnings = loaded.unwrap_or_else(|error| panic!("{:#?}", error.faults())).warnings;
    warnings.iter().map(|warning| format!("{warning} {}", warning.help().unwrap_or_default())).collect()
}

#[test]
fn a_sensor_moves_nothing_and_says_what_it_sees() {
    let robot = with_sensor("reports: {facts: [door_open, rain], objects: [cup]}");
    let open = GOOD.replace("{door_open: true}", "{door_open: {holds: true, outside: true}}");
    let mission = load(&open, &robot).unwrap_or_else(|error| panic!("{:#?}", error.faults()));
    let list = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect::<Vec<_>>();
    let expected = Reportable { facts: list(&["door_open", "rain"]), objects: list(&["cup"]) };
    assert_eq!(mission.robot.controllers[1].reports, expected);
    assert!(mission.robot.controllers[0].reports.is_empty());
    assert_eq!(warnings(&open, &robot), [""; 0], "what the mission does not have is for others");
}

#[test]
fn what_could_never_be_heard_is_told() {
    let rows = [
        ("reports: {facts: [door_open]}", "`door_open` is reported, and the mission does not declare it `outside`"),
        ("reports: {facts: [door_opn]}", "there is no fact `door_opn` did you mean `door_open`?"),
        ("reports: {objects: [cups]}", "there is no object `cups` did you mean `cup`?"),
    ];
    for (reports, words) in rows {
        let said = warnings(GOOD, &with_sensor(reports));
        assert!(said.len() == 1 && said[0].contains(words), "{reports}: {said:?}");
    }
    for (device, words) in [
        ("cancel_grace: 2 s", "a device that can do nothing and says nothing"),
        ("reports: {fact: [door_open]}", "reports has no key `fact`"),
        ("reports: {facts: door_open}", "a list of facts"),
        ("calls: {beep: {takes: 1 s}}", "no resource has this controller"),
    ] {
        let error = load(GOOD, &with_sensor(device)).expect_err(device);
        assert!(
            error.faults().iter().any(|fault| fault.to_string().contains(words)),
            "{device}: {:#?}",
            error.faults()
        );
    }
}
