//! A table of mistakes, each with the line and the words that it is told with.

use super::super::FilesError;
use super::{GOOD, ROBOT, load};

/// What a mistake is: in the mission (or in the robot file), what is replaced by what, and the line and words expected.
type Mistake<'a> = (&'a str, &'a str, usize, &'a str);

fn assert_found(error: &FilesError, (found, by, line, words): &Mistake<'_>) {
    let rendered: Vec<String> = error
        .faults()
        .iter()
        .map(|fault| {
            let help = fault.help().unwrap_or_default();
            format!("{}:{fault} {help}", fault.position().map_or(0, |at| at.0))
        })
        .collect();
    assert!(!words.is_empty(), "every mistake is told with words");
    let expected = format!("{line}:");
    assert!(
        rendered.iter().any(|fault| fault.starts_with(&expected) && fault.contains(words)),
        "`{found}` -> `{by}`: expected line {line} and `{words}` in {rendered:#?}"
    );
}

const IN_MISSIONS: &[Mistake<'_>] = &[
    ("mission: good\n", "", 1, "a mission lacks the key `mission`"),
    ("mission: good", "mision: good", 1, "no key `mision` did you mean `mission`?"),
    ("mission: good", "mission: [good]", 1, "found a list instead of the name"),
    ("mission: good", "mission: ''", 1, "a name cannot be empty"),
    ("mission: good", "mission:", 1, "found nothing"),
    ("robot: robot.yaml", "robot: rowboat.yaml", 2, "cannot read"),
    ("at: [0, 0]", "at: [0, 0, 1]", 4, "found 3 numbers instead of two numbers"),
    ("at: [0, 0]", "at: [0]", 4, "found 1 number instead of two numbers"),
    ("at: [0, 0]", "at: [0, zero]", 4, "found `zero` instead of a length"),
    ("at: [0, 0]", "at: [.inf, 0]", 4, "out of bounds"),
    ("at: [0, 0]", "at: [1e99 m, 0]", 4, "allowed: -10000 to 10000 m"),
    ("90 deg", "90 degrees", 4, "did you mean `90 deg`? Units: rad, deg"),
    ("90 deg", "90", 4, "`90` is out of bounds did you mean `90 deg`? Allowed: -6.28319 to 6.28319 rad"),
    ("90 deg", "90 rad", 4, "did you mean `90 deg`?"),
    ("90 deg", "90 m", 4, "found `90 m` instead of an angle such as `90 deg` units: rad"),
    ("offset: [0, 0.1]", "offset: [0, 100]", 9, "did you mean `100 cm`? Allowed: -10 to 10 m"),
    ("offset: [0, 0.1]", "offset: [0, 10 metres]", 9, "did you mean `10 m`?"),
    ("timeout: 2 min", "timeout: 120000", 17, "did you mean `120000 ms`? Allowed: 0.01 to 86400 s"),
    ("timeout: 2 min", "timeout: 2 minutes", 17, "did you mean `2 min`?"),
    ("{stand: [3, 2]}", "{stand: [9 km, 9 km]}", 7, "stand: 12.7 km from the origin of the map at most 10 km"),
    ("{stand: [3, 2]}", "{stand: [3, 12 km]}", 7, "`12 km` is out of bounds allowed: -10000 to 10000 m"),
    ("{stand: [3, 2]}", "{stand: [3, -10001]}", 7, "Allowed: -10000 to 10000 m"),
    ("at: [0, 0]", "at: [9000, -9000]", 4, "at: 12.7 km from the origin"),
    ("90 deg", "1 m", 4, "found `1 m` instead of an angle"),
    ("1 m, 200 cm", "1 m, deg(90)", 6, "found `deg(90)` instead of a length"),
    ("{stand: [3, 2]}", "{stand: 3}", 7, "found `3` instead of two numbers"),
    ("{stand: [3, 2]}", "{}", 7, "a place that does not say what it is write exactly one of: stand, table"),
    ("    table: {", "    shelf: {", 7, "duplicate key: it stands on line 6 already"),
    ("    table: {", "    'shelf': {", 7, "duplicate key"),
    ("mission: good", "mission: good\n'mission': bad", 2, "duplicate key: it stands on line 1 already"),
    ("    pot:", "    null:", 10, "a key is a word, a number or quoted text"),
    ("    pot:", "    [a, b]:", 10, "a key is a word, a number or quoted text"),
    ("    pot:", "    \"p\\u202et\":", 10, "a name is one line of printable letters"),
    ("retries: 0\n", "retries: 0\n---\nmission: two\n", 20, "a second document"),
    ("cup: {at: shelf,", "cup: {at: shelve,", 9, "there is no place `shelve` did you mean `shelf`?"),
    ("cup: {at: shelf,", "cup: {at: moon,", 9, "allowed: `shelf`, `table`"),
    ("door_open: true", "door_open: 7", 11, "instead of `true` or `false`"),
    ("    - move: shelf", "    - moev: shelf", 14, "no kind of node `moev` did you mean `move`?"),
    ("    - move: shelf", "    - move: shelf\n      pick: cup", 14, "2 things instead of one"),
    ("    - move: shelf", "    - move:", 14, "`move` lacks its parameter `to`, a place"),
    ("    - move: shelf", "    - move", 14, "then: `move` lacks its parameter `to`, a place write `{move: PLACE}`"),
    ("    - move: shelf", "    - place: {at: shelf}", 14, "`object`, an object write `{place: OBJECT}`"),
    ("    - move: shelf", "    - moev", 14, "there is no kind of node `moev` did you mean `move`?"),
    ("    - move: shelf", "    - sequence: [{move: shelf}]", 14, "did you mean `then`? Allowed: `and`"),
    ("    - move: shelf", "    - Selector: [{move: shelf}]", 14, "did you mean `or`?"),
    ("    - move: shelf", "    - parallel: [{move: shelf}]", 14, "did you mean `and`?"),
    ("    - move: shelf", "    - go-to: shelf", 14, "did you mean `move`?"),
    (
        "    - move: shelf",
        "    - {or: [{move: shelf}], naem: a}",
        14,
        "has no key `naem` did you mean `name`? Allowed: `name`",
    ),
    (
        "    - move: shelf",
        "    - {or: [{move: shelf}], until: a}",
        14,
        "has no key `until` allowed: `name`, `retries`, `backoff`, `timeout`",
    ),
    ("    - move: shelf", "    - {or: [{move: shelf}], timeout: 0 s}", 14, "out of bounds"),
    ("    - move: shelf", "    - {move: shelf, until: a}", 14, "allowed: `name`, `retries`, `backoff`, `timeout`"),
    ("    - move: shelf", "    - or: []", 14, "an empty list"),
    ("    - move: shelf", "    - {or: [{move: shelf}], retries: 1.5}", 14, "a whole number"),
    ("    - move: shelf", "    - {move: shelf, name: root}", 14, "`root` is what stands above every task"),
    ("    - pick: cup", "    - pick: cub", 15, "did you mean `cup`?"),
    ("    - pick: cup", "    - pick: {objekt: cup}", 15, "did you mean `object`?"),
    ("scale_by: gripper", "scale_by: griper", 16, "did you mean `gripper`?"),
    ("timeout: 2 min", "timeout: -1 s", 17, "out of bounds"),
    ("retries: 0", "repeat: 1001", 18, "repeat: repeated 1001 times without a pause write `every: TIME`"),
    (
        "  then:\n",
        "  repeat: 501\n  then:\n    - {move: table, repeat: 2}\n",
        15,
        "repeated 1002 times without a pause",
    ),
    ("retries: 0", "retries: 0.5", 19, "a whole number"),
    (
        "    - pick: cup",
        "    - pick: 1\n      grasp: 2",
        16,
        "has no key `grasp` allowed: `name`, `retries`, `backoff`, `timeout`",
    ),
    (
        "    - move: {to: table, scale_by: gripper}\n      timeout: 2 min",
        "    - place: {object: pot, at: tabel}",
        16,
        "did you mean `table`?",
    ),
    ("  then:", "  and:", 18, "not told a place: `at`"),
    ("facts: {door_open: true}", "obstacles: [{min: [0, 0], max: [1, 0]}]", 11, "`max` is not beyond `min`"),
    ("facts: {door_open: true}", "obstacles: [{min: [0, 0], size: [1, 1]}]", 11, "`min` and `max`, or `at` and `size`"),
    ("facts: {door_open: true}", "walls: [{from: [0, 1], to: [0, 1]}]", 11, "`to` is not 1 cm away from `from`"),
    ("{stand: [3, 2]}", "{stand: [3, 2], table: {at: [3, 2], size: [1, 1, 0.7]}}", 7, "2 things instead of one"),
    ("facts: {door_open: true}", "distance: paths", 11, "did you mean `path`?"),
    ("{stand: [3, 2]}", "{table: {at: [3, 2], size: [1, 1, 0.7], side: lft}}", 7, "no side `lft` did you mean `left`?"),
    ("facts: {door_open: true}", "tolerance: 1 mm", 11, "allowed: 0.02 to"),
    ("facts: {door_open: true}", "facts: {door_open: true", 12, "did not find expected"),
];

#[test]
fn mistakes_in_a_mission_are_found() {
    for mistake in IN_MISSIONS {
        assert!(GOOD.contains(mistake.0), "{}", mistake.0);
        let error = load(&GOOD.replacen(mistake.0, mistake.1, 1), ROBOT).unwrap_err();
        assert_found(&error, mistake);
    }
}

const IN_ROBOTS: &[Mistake<'_>] = &[
    ("radius: 0.3 m", "radius: 0 m", 2, "out of bounds"),
    ("controller: arm", "controller: amr", 4, "there is no controller `amr` did you mean `arm`?"),
    (", controller: arm", "", 7, "no resource has this controller"),
    ("type: gripper", "type: head", 4, "moves an arm, not a head"),
    ("{type: base}", "{type: base, controller: arm}", 5, "moves `hand` already"),
    ("{type: base}", "{type: gripper}", 5, "some have a controller and some have none"),
    ("{type: base}", "{type: wheels}", 14, "the robot has no resource of type `base`"),
    ("  arm:\n", "  a/b:\n", 7, "at most 32 letters"),
    ("    arm: {", "    leg: {", 8, "no key `leg`"),
    ("reach: 0.9", "reach: 90", 8, "did you mean `90 cm`?"),
    ("reach: 0.9", "reach: 0", 8, "allowed: 0.01 to 10 m"),
    ("reach: 0.9", "reach: -1 m", 8, "allowed: 0.01 to 10 m"),
    ("speed: 0.5", "speed: 0", 8, "allowed: 0.001 to 100 m/s"),
    ("lift: 10 cm", "lift: 10 s", 8, "instead of a length"),
    ("tuck: [0.3, 0, 0.9]", "tuck: [3, 0, 0.9]", 8, "farther from the shoulder"),
    (", grip: 1 s", "", 8, "an arm lacks the key `grip`"),
];

#[test]
fn mistakes_in_a_robot_are_found() {
    for mistake in IN_ROBOTS {
        assert!(ROBOT.contains(mistake.0), "{}", mistake.0);
        let error = load(GOOD, &ROBOT.replacen(mistake.0, mistake.1, 1)).unwrap_err();
        assert_found(&error, mistake);
    }
}

#[test]
fn all_mistakes_come_at_once_with_their_files() {
    let mission =
        GOOD.replace("90 deg", "90 dog").replace("at: shelf}", "at: shell}").replace("pick: cup", "pick: cub");
    let error = load(&mission, &ROBOT.replace("0.3 m", "big")).unwrap_err();
    let lines: Vec<_> = error.faults().iter().map(|fault| fault.position().unwrap().0).collect();
    assert_eq!(lines, [4, 10, 15, 2]);
    assert!(error.faults()[3].file().ends_with("robot.yaml"));
    assert_eq!(error.faults()[2].key(), "pick");
    assert_eq!(error.to_string(), "4 mistakes in the files");
    assert!(error.faults()[1].help().unwrap().starts_with("did you mean `shelf`?"), "{error:?}");
}

#[test]
fn duplicate_keys_hide_nothing_else() {
    let mission = GOOD.replace("    table: {", "    shelf: {").replace("pick: cup", "pick: cub");
    let error = load(&mission, ROBOT).unwrap_err();
    let lines: Vec<_> = error.faults().iter().map(|fault| fault.position().unwrap().0).collect();
    assert_eq!(lines, [7, 15, 16], "{error:?}");
}

#[test]
fn a_text_of_several_lines_is_pointed_at_once() {
    let error = load(&GOOD.replace("pick: cup", "pick: |\n        cup\n"), ROBOT).unwrap_err();
    let fault = &error.faults()[0];
    assert!(fault.message().contains("printable"), "{fault}");
    assert_eq!(&fault.text()[fault.bytes().unwrap()], "cup", "{fault:?}");
}

#[test]
fn no_letter_of_a_file_moves_the_terminal() {
    let error = load(&GOOD.replace("    pot:", "    \"a\\n\\eb\":"), ROBOT).unwrap_err();
    let said = error.faults()[0].to_string();
    assert_eq!(said, "a��b: a name is one line of printable letters");
}
