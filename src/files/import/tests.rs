//! Tables of what becomes of files, and files that nobody would write.

use std::path::Path;

use proptest::prelude::*;

use super::super::document::{self, Value};
use super::super::fault::Fault;
use super::super::sources::InMemory;
use super::super::text::scalar;
use super::write::flow;
use super::{ImportError, Imported, import};

const TASK: &str = "\
NodeList: [TOP, CUT, DRINKS, TEA, MILK]
Nodes:
  TOP: {type: 1, behavior_type: 'a::AndBehavior', robot: 0, parent: 'NONE', params: []}
  CUT: {type: 4, behavior_type: 'a::TestBehavior', robot: 0, parent: TOP, params: ['activation_potential: 4.0']}
  DRINKS: {type: 3, behavior_type: 'a::OrBehavior', robot: 0, parent: TOP}
  TEA: {type: 4, behavior_type: 'b::FetchBehavior', robot: 0, parent: DRINKS, params: ['object: tea', 'dest: home']}
  MILK: {type: 4, behavior_type: 'a::TestBehavior', robot: 0, parent: DRINKS, params: ['activation_potential: 2']}
";
const ROBOT: &str = "\
robot_name: R2
robot_resources:
  number_of_resources: 3
  resource_0: {type: 1, name: hand}
  resource_2: {type: 3, name: wheels}
  resource_1: {type: 2, name: eyes}
";

fn import_text(task: &str, robot: Option<&str>) -> Result<Imported, ImportError> {
    let mut files = InMemory::default();
    files.insert("task.yaml", task);
    files.insert("robot.yaml", robot.unwrap_or_default());
    import(&files, Path::new("task.yaml"), robot.map(|_| Path::new("robot.yaml")), None)
}

fn told(faults: &[Fault]) -> Vec<String> {
    let line = |fault: &Fault| fault.position().map_or(0, |at| at.0);
    faults.iter().map(|fault| format!("{}:{fault} {}", line(fault), fault.help().unwrap_or_default())).collect()
}

/// What is replaced by what, the line and the words of the mistake.
type Mistake<'a> = (&'a str, &'a str, usize, &'a str);

const IN_TASKS: &[Mistake<'_>] = &[
    ("TEA, MILK]", "TEA]", 7, "MILK: not in `NodeList`"),
    ("TEA, MILK]", "TEA, MILK, MLIK]", 1, "`MLIK` has no entry in `Nodes` did you mean `MILK`?"),
    ("TEA, MILK]", "TEA, MILK, TEA]", 1, "`TEA` comes twice"),
    ("[TOP, CUT, DRINKS, TEA, MILK]", "[]", 1, "an empty list instead of a list of the names of nodes"),
    (
        "[TOP, CUT, DRINKS, TEA, MILK]",
        "[TOP, [CUT], DRINKS, TEA, MILK]",
        1,
        "found a list instead of the name of a node",
    ),
    ("NodeList:", "NodList:", 1, "a dHTT task has no key `NodList` did you mean `NodeList`?"),
    ("  MILK:", "  TEA:", 7, "duplicate"),
    ("parent: 'NONE'", "parent: ''", 3, "a name cannot be empty"),
    ("parent: 'NONE'", "parent: NNOE", 3, "there is no node `NNOE` did you mean `NONE`?"),
    ("parent: 'NONE'", "parent: DRINKS", 3, "it is above itself: TOP → DRINKS → TOP"),
    ("parent: 'NONE'", "parent: TOP", 3, "it is above itself: TOP → TOP"),
    ("parent: 'NONE'", "parent: DRINKS", 3, "Nodes: no node is the topmost"),
    ("parent: TOP, params", "parent: NONE, params", 4, "a second topmost node beside `TOP`"),
    ("parent: DRINKS, params: ['object", "parent: CUT, params: ['object", 4, "cannot have children, and `TEA` is one"),
    ("{type: 4, behavior_type: 'b::", "{type: 2, behavior_type: 'b::", 6, "TEA: it has no children"),
    ("{type: 3", "{type: 0", 5, "type 0 is the root"),
    ("{type: 3", "{type: 5", 5, "type 5 is the tree of another file"),
    ("{type: 3", "{type: 6", 5, "found `6` instead of 1 (AND), 2 (THEN), 3 (OR) or 4"),
    ("{type: 3", "{type: OR", 5, "found `OR` instead of 1 (AND)"),
    ("{type: 3", "{tpye: 3", 5, "a dHTT node has no key `tpye` did you mean `type`?"),
    ("behavior_type: 'b::FetchBehavior', ", "", 6, "a behavior lacks the key `behavior_type`"),
    ("['activation_potential: 2']", "['activation_potential: -2']", 7, "`-2` is out of bounds allowed: 0 to"),
    ("['activation_potential: 2']", "['activation_potential: inf']", 7, "`inf` is out of bounds"),
    ("['activation_potential: 2']", "['activation_potential: nan']", 7, "`nan` is out of bounds"),
    ("['activation_potential: 2']", "['activation_potential: high']", 7, "instead of a number"),
    ("['activation_potential: 2']", "['activation_potential 2']", 7, "is not of the form 'key: value'"),
    ("['activation_potential: 2']", "[activation_potential: 2]", 7, "a parameter is a text of the form 'key: value'"),
    ("['activation_potential: 2']", "['activation_potential:']", 7, "is not of the form 'key: value'"),
    ("['activation_potential: 2']", "'activation_potential: 2'", 7, "instead of a list of texts"),
    ("'activation_potential: 2'", "'activation_potential: 2', 'activation_potential: 3'", 7, "comes twice"),
    ("robot: 0, parent: 'NONE'", "robot: [0], parent: 'NONE'", 3, "instead of the number or the name of a robot"),
    ("  CUT: {", "  root: {", 4, "a node cannot be called `root`"),
    ("  CUT: {", "  $cut: {", 4, "a node cannot be called `$cut`"),
    ("  CUT: {type", "  CUT: {type: [", 4, "a key is a word, a number or quoted text"),
    ("NodeList:", "task: {}\nNothing:", 1, "a dHTT task has no key `task`"),
];

fn mistakes(result: Result<Imported, ImportError>) -> Vec<String> {
    match result {
        Err(ImportError::Faulty(error)) => told(error.faults()),
        Err(ImportError::Defect(error)) => panic!("a defect: {:?}", told(error.faults())),
        Err(error @ ImportError::TooLarge(_)) => vec![error.to_string()],
        Ok(imported) => panic!("imported as\n{}", imported.text),
    }
}

fn assert_found(found: &[String], (from, by, line, words): &Mistake<'_>) {
    assert!(!words.is_empty(), "every mistake is told with words");
    let begin = format!("{line}:");
    let is_found = found.iter().any(|fault| fault.starts_with(&begin) && fault.contains(words));
    assert!(is_found, "`{from}` -> `{by}`: expected line {line} and `{words}` in {found:#?}");
}

#[test]
fn mistakes_in_a_task_are_found() {
    for mistake in IN_TASKS {
        assert!(TASK.contains(mistake.0), "{}", mistake.0);
        let found = mistakes(import_text(&TASK.replacen(mistake.0, mistake.1, 1), None));
        assert_found(&found, mistake);
    }
}

#[test]
fn mistakes_come_at_once_and_without_warnings() {
    let task =
        TASK.replace("parent: 'NONE'", "parent: 'NUN'").replace("{type: 3", "{type: 9").replace(": 2']", ": -1']");
    let found = mistakes(import_text(&task, None));
    assert_eq!(found.len(), 3, "{found:#?}");
}

const IN_ROBOTS: &[Mistake<'_>] = &[
    ("type: 1", "type: 4", 4, "found `4` instead of 1 (a gripper), 2 (a head) or 3 (a base)"),
    ("type: 1", "type: gripper", 4, "found `gripper` instead of 1"),
    ("name: eyes", "name: hand", 6, "another resource is called `hand`"),
    (", name: eyes", "", 6, "a dHTT resource lacks the key `name`"),
    ("number_of_resources: 3", "number_of_resources: 4", 3, "4 resources are announced, and there are 3"),
    ("number_of_resources: 3", "number_of_resources: some", 3, "a whole number"),
    ("resource_0: {type: 1, name: hand}", "resource_0: hand", 4, "found `hand` instead of a dHTT resource"),
];

#[test]
fn mistakes_in_a_robot_are_found() {
    for mistake in IN_ROBOTS {
        assert!(ROBOT.contains(mistake.0), "{}", mistake.0);
        let robot = ROBOT.replacen(mistake.0, mistake.1, 1);
        assert_found(&mistakes(import_text(&robot, None)), mistake);
        assert_found(&mistakes(import_text(TASK, Some(&robot))), mistake);
    }
}

#[test]
fn other_files_are_told_what_they_are() {
    for (text, words) in [
        ("mission: a\n", "a mission of Ambidex already"),
        ("robot: a\nresources: {}\n", "a robot file of Ambidex already"),
        ("library: a\n", "a library of Ambidex already"),
        ("a: b\n", "no file of the dHTT software a task file has `NodeList`"),
        ("- a\n", "no file of the dHTT software"),
        ("", "no file of the dHTT software"),
    ] {
        let found = mistakes(import_text(text, None));
        assert!(found[0].contains(words), "{text}: {found:?}");
    }
    let found = mistakes(import_text(TASK, Some(TASK)));
    assert!(found[0].contains("this is no robot file"), "{found:?}");
    let found = mistakes(import_text(ROBOT, Some(ROBOT)));
    assert!(found[0].contains("`--robot` is for task files"), "{found:?}");
}

/// What is replaced by what, the line and the words of the warning, and what stands in the mission.
type Left<'a> = (&'a str, &'a str, usize, &'a str, &'a str);

const LEFT_OUT: &[Left<'_>] = &[
    ("", "", 3, "`robot: 0` is left out wherever it stands", "# dHTT: `robot: 0` is left out"),
    ("", "", 6, "TEA: `b::FetchBehavior` computes its potential", "activation_potential: {type: number, default: 1}"),
    ("", "", 6, "`object: tea`, `dest: home` are kept as texts", "- FetchBehavior: {object: tea, dest: home}"),
    ("", "", 6, "`object: tea`", "# Named as `object` in the task: tea."),
    ("robot: 0, parent: TOP}", "robot: B, parent: TOP}", 5, "DRINKS: `robot: B` is left out", "# dHTT: `robot: B`"),
    ("Nodes:\n", "order: [CUT, {a: b}]\nNodes:\n", 2, "`order: [CUT, {a: b}]` is left out", "# dHTT: `order: [CUT"),
    ("parent: TOP}", "parent: TOP, goitr_type: g}", 5, "while it runs are not in the file", "# dHTT: `goitr_type: g`"),
    ("parent: TOP}", "parent: TOP, parms: []}", 5, "`parms: []` is left out did you mean `params`?", "`parms: []`"),
    ("parent: TOP}", "parent: TOP, params: ['a: b']}", 5, "`or` has no parameters", "# dHTT: `a: b` is left out"),
    ("a::OrBehavior", "a::Auction", 5, "its plugin `a::Auction` is left out", "it becomes a plain `or`"),
    ("'dest: home'", "'dest: $home'", 6, "`dest: $home` is left out: `$` stands", "# dHTT: `dest: $home`"),
    ("'dest: home'", "'!on: home'", 6, "`!on: home` is left out", "# dHTT: `!on: home`"),
    ("'dest: home'", "'object: b'", 6, "`object` comes twice: `object: b` is left out", "{object: tea}"),
    (
        "potential: 2'",
        "potential: 0'",
        7,
        "a potential of 0 means to run last: it is 0.001 now",
        "{activation_potential: 0.001}",
    ),
    (
        "potential: 4.0'",
        "potential: 0', 'x: 0'",
        4,
        "in a mission a potential of 0",
        "# dHTT: a potential of 0 means to run",
    ),
    ("potential: 2'", "potential: 2', 'a: b'", 7, "`a: b` is kept as a text", "{activation_potential: 2, a: b}"),
];

#[test]
fn what_is_left_out_is_said_twice() {
    for (from, by, line, words, written) in LEFT_OUT {
        assert!(TASK.contains(from), "{from}");
        let imported = import_text(&TASK.replacen(from, by, 1), None).unwrap();
        assert!(imported.warnings.iter().all(Fault::is_warning));
        assert_found(&told(&imported.warnings), &(from, by, *line, words));
        assert!(imported.text.contains(written), "`{written}` in\n{}", imported.text);
    }
}

#[test]
fn a_task_becomes_a_mission() {
    let imported = import_text(TASK, None).unwrap();
    let task = &imported.text[imported.text.find("\ntask:").unwrap()..];
    let expected = "
task:
  name: TOP
  and:
    - TestBehavior: {activation_potential: 4}
      name: CUT
    - name: DRINKS
      or:
        - FetchBehavior: {object: tea, dest: home}
          name: TEA
        - TestBehavior: {activation_potential: 2}
          name: MILK
";
    assert_eq!(task, expected);
    assert!(imported.text.starts_with("# Imported from task.yaml, a task file of the dHTT software.\n"));
    assert!(imported.text.contains("\nmission: task\nrobot: task.robot.yaml\n"), "{}", imported.text);
    assert_eq!(imported.summary, "a mission of 5 nodes: 3 behaviors of 2 kinds");
    assert_eq!(import_text(TASK, None).unwrap().text, imported.text);
}

/// A task as the software before dHTT wrote it.
const OLDER: &str = "\
NodeList: [ROOT_4_0_000, THEN_0_0_001, OR_1_0_002, PLACE_3_0_003, PLACE_3_0_004, PICK_5_0_005]
Nodes:
  ROOT_4_0_000: {mask: {type: 4, robot: 0, node: 0}, parent: NONE, children: [THEN_0_0_001], peers: [NONE]}
  THEN_0_0_001: {mask: {type: 0, robot: 0, node: 1}, parent: ROOT_4_0_000, children: [PICK_5_0_005, OR_1_0_002]}
  OR_1_0_002: {mask: {type: 1, robot: 0, node: 2}, parent: THEN_0_0_001, children: [PLACE_3_0_003, PLACE_3_0_004]}
  PLACE_3_0_003: {mask: {type: 3, robot: 0, node: 3}, parent: OR_1_0_002, children: [NONE], object: tea}
  PLACE_3_0_004: {mask: {type: 3, robot: 0, node: 4}, parent: OR_1_0_002, children: ['NONE'], object: mug}
  PICK_5_0_005: {mask: {type: 5, robot: 0, node: 5}, parent: THEN_0_0_001, children: [], peers: [PICK_5_1_005]}
";

#[test]
fn a_task_of_the_older_form_becomes_a_mission() {
    let imported = import_text(OLDER, None).unwrap_or_else(|error| panic!("{error}"));
    let task = &imported.text[imported.text.find("\ntask:").unwrap()..];
    let expected = "
task:
  name: THEN_0_0_001
  then:
    # dHTT: `peers: [PICK_5_1_005]` are left out: a mission is for one robot
    - PICK: {}
      name: PICK_5_0_005
    - name: OR_1_0_002
      or:
        - PLACE: {object: tea}
          name: PLACE_3_0_003
        - PLACE: {object: mug}
          name: PLACE_3_0_004
";
    assert_eq!(task, expected);
    for mistake in [
        ("mask: {type: 1,", "mask: {type: or,", 5, "found `or` instead of 0 (THEN), 1 (OR), 2 (AND), 4 (the root)"),
        ("mask: {type: 1,", "mask: {tpye: 1,", 5, "a mask has no key `tpye` did you mean `type`?"),
        ("mask: {type: 1,", "mask: {", 5, "a mask lacks the key `type`"),
        ("children: [PICK_5_0_005,", "children: [PICK_5_0_006,", 4, "`PICK_5_0_006` is no node whose parent is `THEN"),
        ("children: [PICK_5_0_005,", "children: [PLACE_3_0_003,", 4, "`PLACE_3_0_003` is no node whose parent is"),
        ("parent: OR_1_0_002, children: ['NONE']", "parent: NONE, children: []", 5, "`PLACE_3_0_004` is no node whose"),
    ] {
        assert!(OLDER.contains(mistake.0), "{}", mistake.0);
        assert_found(&mistakes(import_text(&OLDER.replacen(mistake.0, mistake.1, 1), None)), &mistake);
    }
}

#[test]
fn long_names_have_robots_of_their_own() {
    let robot_of = |target: &str| {
        let mut files = InMemory::default();
        files.insert("task.yaml", TASK);
        let imported = import(&files, Path::new("task.yaml"), None, Some(Path::new(target))).unwrap();
        let path = imported.beside.unwrap().path.display().to_string();
        assert!(imported.text.contains(&format!("robot: {}\n", scalar(&path))), "{}", imported.text);
        path
    };
    let long = "x".repeat(100);
    let [one, two] = [robot_of(&format!("{long}-one.yaml")), robot_of(&format!("{long}-two.yaml"))];
    assert_eq!([one, two], [format!("{long}-one.robot.yaml"), format!("{long}-two.robot.yaml")]);
}

#[test]
fn a_robot_becomes_one_whose_resources_stand_in_their_order() {
    let alone = import_text(ROBOT, None).unwrap();
    let expected = "resources:\n  hand: {type: gripper}\n  eyes: {type: head}\n  wheels: {type: base}\n";
    assert!(alone.text.ends_with(expected), "{}", alone.text);
    assert!(alone.text.contains("\nrobot: R2\n"));
    assert_eq!((alone.summary.as_str(), alone.is_mission), ("a robot of 3 resources", false));
    let with = import_text(TASK, Some(ROBOT)).unwrap();
    assert!(with.beside.unwrap().text.ends_with(expected));
}

#[test]
fn plugins_of_one_name_are_several_kinds() {
    let long = "x".repeat(60);
    let task = TASK
        .replacen("a::TestBehavior", "b::FetchBehavior", 1)
        .replacen("b::FetchBehavior', robot: 0, parent: DRINKS", "c::FetchBehavior', robot: 0, parent: DRINKS", 1)
        .replacen("a::TestBehavior", &format!("{long}::FetchBehavior"), 1);
    let text = import_text(&task, None).unwrap().text;
    for kind in ["FetchBehavior", "'c::FetchBehavior'", "FetchBehavior 2"] {
        assert!(text.contains(&format!("\n  {kind}:\n")), "{kind} in\n{text}");
    }
    for plugin in ["move", "and", "name", "a::pick", "*", "$x", long.repeat(3).as_str()] {
        let text = import_text(&TASK.replace("a::TestBehavior", plugin), None);
        assert!(text.is_ok(), "{plugin}: {:?}", text.err());
    }
}

#[test]
fn what_is_too_much_is_refused() {
    let deep = |levels: usize| {
        let names: Vec<_> = (0..levels).map(|level| format!("N{level}")).collect();
        let node = |level: usize| {
            let ty = if level + 1 == levels { 4 } else { 2 };
            let parent = if level == 0 { "NONE".to_owned() } else { names[level - 1].clone() };
            format!("  N{level}: {{type: {ty}, behavior_type: a, parent: {parent}}}\n")
        };
        format!("NodeList: [{}]\nNodes:\n{}", names.join(", "), (0..levels).map(node).collect::<String>())
    };
    assert!(import_text(&deep(64), None).is_ok());
    let found = mistakes(import_text(&deep(65), None));
    assert_eq!(found, ["67:N64: more than 64 nodes one below another "]);
    let found = mistakes(import_text(&format!("{TASK}#{}", " ".repeat(1 << 20)), None));
    assert!(found[0].contains("larger than"), "{found:?}");
    let found = mistakes(import_text(&format!("a: {}1{}", "[".repeat(200), "]".repeat(200)), None));
    assert!(found[0].contains("nested more than"), "{found:?}");
    let names: Vec<_> = (0..5000).map(|at| format!("N{at}")).collect();
    let node = |name: &String| format!("  {name}: {{type: 4, behavior_type: {name}::{}, parent: T}}\n", "x".repeat(48));
    let nodes: String = names.iter().map(node).collect();
    let task = format!("NodeList: [T, {}]\nNodes:\n  T: {{type: 1, parent: NONE}}\n{nodes}", names.join(", "));
    let found = mistakes(import_text(&task, None));
    assert!(found[0].starts_with("the mission would have "), "{found:?}");
}

#[test]
fn more_warnings_than_are_shown_are_counted() {
    let names: Vec<_> = (0..150).map(|at| format!("B{at}")).collect();
    let nodes: String =
        names.iter().map(|name| format!("  {name}: {{type: 4, behavior_type: a, parent: T, x: 1}}\n")).collect();
    let task = format!("NodeList: [T, {}]\nNodes:\n  T: {{type: 1, parent: NONE}}\n{nodes}", names.join(", "));
    let imported = import_text(&task, None).unwrap();
    assert_eq!((imported.warnings.len(), imported.unshown), (100, 200));
    assert_eq!(imported.text.matches("# dHTT: `x: 1` is left out").count(), 150);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn every_line_of_text_can_be_written_and_read(text in "\\PC{1,60}") {
        let yaml = format!("- {}\n- {}\n", scalar(&text), flow([(text.as_str(), scalar(&text))]));
        let Value::List(items) = document::parse(0, &yaml).unwrap().value else { panic!("{yaml}") };
        let Value::Scalar { text: found, .. } = &items[0].value else { panic!("{yaml}") };
        prop_assert_eq!(found, &text);
        let Value::Map(entries) = &items[1].value else { panic!("{yaml}") };
        let Value::Scalar { text: found, .. } = &entries[0].1.value else { panic!("{yaml}") };
        prop_assert_eq!((&entries[0].0.value, found), (&text, &text));
    }

    #[test]
    fn no_file_makes_it_panic_or_write_what_does_not_load(
        cuts in prop::collection::vec((0..700usize, 0..8usize, "[-a-z0-9 :\\[\\]{},&*!|>'\"#~%@.$é\n]{0,4}"), 1..5),
        is_robot in any::<bool>(),
    ) {
        let mut text = if is_robot { ROBOT } else { TASK }.to_owned();
        for (at, length, by) in cuts {
            let floor = |mut at: usize| {
                at = at.min(text.len());
                while !text.is_char_boundary(at) {
                    at -= 1;
                }
                at
            };
            let range = floor(at)..floor(at + length);
            text.replace_range(range, &by);
        }
        match import_text(&text, None) {
            Ok(_) => {}
            Err(ImportError::Faulty(error)) => prop_assert!(!error.faults().is_empty()),
            Err(ImportError::TooLarge(bytes)) => prop_assert!(false, "{bytes} bytes of {text}"),
            Err(ImportError::Defect(error)) => prop_assert!(false, "{text}\n{:?}", told(error.faults())),
        }
    }
}
