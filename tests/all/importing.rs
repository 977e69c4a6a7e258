//! Files of the dHTT software, imported by the program and simulated: the order is the one that their potentials say.

use std::collections::BTreeSet;
use std::fmt::Write;
use std::fs;
use std::path::Path;

use ambidex::files::{Disk, import};
use ambidex::tree::Settings;
use proptest::prelude::*;

use crate::fixtures::{file, load, simulate};
use crate::home::{Finished, Home};

const BREAKFAST: &str = "tests/data/dhtt-breakfast.yaml";
const ROBOT: &str = "\
robot_name: one-armed
robot_resources:
  number_of_resources: 2
  resource_0: {type: 1, name: arm}
  resource_1: {type: 3, name: wheels}
";

/// Runs the program in the folder of the home.
fn ambidex(home: &Home, args: &[&str], code: i32) -> Finished {
    home.start_with(args, |command| {
        command.current_dir(home.path(""));
    })
    .ends(code)
}

fn breakfast(home: &Home) {
    home.write("breakfast.yaml", &fs::read_to_string(file(BREAKFAST)).expect("the example"));
}

/// The steps of a mission as the program simulates it.
fn steps(home: &Home, mission: &str) -> Vec<Vec<String>> {
    let log = home.path("journal.jsonl");
    let args = ["simulate", mission, "--json", "--log", log.to_str().expect("a path")];
    let report: serde_json::Value = serde_json::from_str(&ambidex(home, &args, 0).stdout).expect("a report");
    assert_eq!(report["outcome"], "done");
    serde_json::from_value(report["steps"].clone()).expect("steps")
}

#[test]
fn the_example_runs_in_the_order_of_its_potentials() {
    let home = Home::new();
    breakfast(&home);
    let said = ambidex(&home, &["import", "breakfast.yaml", "-o", "b.yaml"], 0);
    assert_eq!(said.stdout, "");
    for words in [
        "⚠ `robot: 0` is left out wherever it stands",
        "⚠ SIT_DOWN_10: `dhtt_plugins::MoveBehavior` computes its potential",
        "breakfast.yaml:79:20",
        "imported breakfast.yaml: a mission of 11 nodes: 7 behaviors of 2 kinds",
        "wrote b.yaml and b.robot.yaml",
        "try: ambidex simulate b.yaml",
    ] {
        assert!(said.words().contains(words), "`{words}` in\n{}", said.stderr);
    }
    let order = ["COVER_TABLE_1", "BOIL_7", "COFFEE_5", "BREAD_9", "PEEL_8", "SIT_DOWN_10"];
    assert_eq!(steps(&home, "b.yaml"), order.map(|name| vec![name.to_owned()]));
    let machine = home.path("").display().to_string();
    for name in ["b.yaml", "b.robot.yaml"] {
        let text = fs::read_to_string(home.path(name)).expect("it was written");
        assert!(!text.contains(&machine), "{text}");
    }
}

#[test]
fn what_is_there_is_not_overwritten() {
    let home = Home::new();
    breakfast(&home);
    for there in ["b.yaml", "b.robot.yaml"] {
        home.write(there, "mine");
        let said = ambidex(&home, &["import", "breakfast.yaml", "-o", "b.yaml"], 2);
        assert!(said.words().contains(&format!("{there} is there already, so nothing was written")), "{}", said.stderr);
        assert_eq!(fs::read_to_string(home.path(there)).expect("it"), "mine");
        let other = if there == "b.yaml" { "b.robot.yaml" } else { "b.yaml" };
        assert!(!home.path(other).exists());
        fs::remove_file(home.path(there)).expect("removed");
    }
    home.write("b.yaml", "mine");
    ambidex(&home, &["import", "breakfast.yaml", "-o", "b.yaml", "--force"], 0);
    assert_eq!(steps(&home, "b.yaml").len(), 6);
    let said = ambidex(&home, &["import", "breakfast.yaml", "-o", "breakfast.yaml", "--force"], 2);
    assert!(said.words().contains("is read by this import"), "{}", said.stderr);
    let said = ambidex(&home, &["import", "breakfast.yaml", "-o", "nowhere/b.yaml"], 2);
    assert!(said.words().contains("cannot write nowhere/b.robot.yaml"), "{}", said.stderr);
}

#[test]
fn a_mission_goes_to_stdout() {
    let home = Home::new();
    breakfast(&home);
    let said = ambidex(&home, &["import", "breakfast.yaml", "-o", "-"], 0);
    assert!(said.words().contains("note: the mission names breakfast.robot.yaml"), "{}", said.stderr);
    ambidex(&home, &["import", "breakfast.yaml", "-o", "breakfast.mission.yaml"], 0);
    let written = fs::read_to_string(home.path("breakfast.mission.yaml")).expect("it was written");
    assert_eq!(said.stdout.replace("breakfast.robot.yaml", "breakfast.mission.robot.yaml"), written);
}

#[test]
fn a_robot_file_is_imported_and_used() {
    let home = Home::new();
    breakfast(&home);
    home.write("arm.yaml", ROBOT);
    let said = ambidex(&home, &["import", "arm.yaml", "-o", "robot.yaml"], 0);
    assert!(said.words().ends_with("imported arm.yaml: a robot of 2 resources wrote robot.yaml"), "{}", said.stderr);
    fs::create_dir(home.path("missions")).expect("a folder");
    for (robot, named) in [("arm.yaml", "b.robot.yaml"), ("robot.yaml", "../robot.yaml")] {
        let args = ["import", "breakfast.yaml", "--robot", robot, "-o", "missions/b.yaml", "--force"];
        ambidex(&home, &args, 0);
        let text = fs::read_to_string(home.path("missions/b.yaml")).expect("it was written");
        assert!(text.contains(&format!("\nrobot: {named}\n")), "{text}");
        let mission = load(&home.path("missions/b.yaml"));
        assert_eq!(
            (mission.robot.name.as_str(), &mission.names.resources[..]),
            ("one-armed", &["arm", "wheels"].map(String::from)[..])
        );
        assert_eq!(steps(&home, "missions/b.yaml").len(), 6);
    }
}

#[test]
fn the_robot_of_the_paper_can_be_used() {
    let home = Home::new();
    breakfast(&home);
    fs::copy(file("config/robots/pr2.yaml"), home.path("pr2.yaml")).expect("a copy");
    ambidex(&home, &["import", "breakfast.yaml", "--robot", "pr2.yaml", "-o", "b.yaml"], 0);
    assert!(!home.path("b.robot.yaml").exists());
    assert_eq!(steps(&home, "b.yaml").len(), 6);
}

#[test]
fn broken_files_are_told_and_nothing_is_written() {
    let home = Home::new();
    let text = fs::read_to_string(file(BREAKFAST)).expect("the example");
    let text = text.replacen(
        "'SET_AND_2'\n    params: ['activation_potential: 5.0'",
        "'SET_ADN_2'\n    params: ['activation_potential: five'",
        1,
    );
    home.write("broken.yaml", &text.replacen("type: 3", "type: 33", 1));
    let said = ambidex(&home, &["import", "broken.yaml", "-o", "b.yaml"], 2);
    for words in [
        "3 mistakes in the files",
        "broken.yaml:36:11",
        "type: found `33` instead of 1 (AND), 2 (THEN), 3 (OR) or 4 (a behavior)",
        "BREAD_9: there is no node `SET_ADN_2`",
        "did you mean `SET_AND_2`?",
        "activation_potential: found `five` instead of a number such as `4.5`",
    ] {
        assert!(said.words().contains(words), "`{words}` in\n{}", said.stderr);
    }
    assert!(!said.stderr.contains('⚠'), "{}", said.stderr);
    let said = ambidex(&home, &["import", "nothing.yaml", "-o", "b.yaml"], 2);
    assert!(said.words().contains("cannot read nothing.yaml"), "{}", said.stderr);
    assert!(!home.path("b.yaml").exists() && !home.path("b.robot.yaml").exists());
}

/// A tree in the form of dHTT; what is below a node, or its potential.
#[derive(Debug, Clone)]
enum Plan {
    Behavior(f64),
    Composite(u8, Vec<Plan>),
}

/// A plan whose nodes have names and parents.
#[derive(Debug)]
struct Node {
    name: String,
    parent: Option<usize>,
    /// 1 AND, 2 THEN, 3 OR, 4 behavior.
    ty: u8,
    potential: f64,
    children: Vec<usize>,
}

fn plan() -> impl Strategy<Value = Plan> {
    // Few values, so that many are alike and the order of the nodes decides.
    let potential = prop_oneof![1 => (0..6_u8).prop_map(f64::from), 1 => 0.001..1000.0];
    let behavior = potential.prop_map(Plan::Behavior);
    behavior.prop_recursive(4, 24, 4, |inner| {
        (1..=3_u8, prop::collection::vec(inner, 1..5)).prop_map(|(ty, below)| Plan::Composite(ty, below))
    })
}

/// The nodes in preorder.
fn lay_out(plan: &Plan, parent: Option<usize>, nodes: &mut Vec<Node>) -> usize {
    let at = nodes.len();
    let (ty, potential, below): (_, _, &[Plan]) = match plan {
        Plan::Behavior(potential) => (4, *potential, &[]),
        Plan::Composite(ty, below) => (*ty, 0.0, below),
    };
    let word = ["AND", "THEN", "OR", "DO"][usize::from(ty) - 1];
    nodes.push(Node { name: format!("{word}_{at:03}"), parent, ty, potential, children: Vec::new() });
    let children = below.iter().map(|child| lay_out(child, Some(at), nodes)).collect();
    nodes[at].children = children;
    at
}

/// A task file whose entries stand in another order than its list.
fn task_file(nodes: &[Node]) -> String {
    let mut text = "NodeList:\n".to_owned();
    for node in nodes {
        writeln!(text, "  - '{}'", node.name).expect("a string takes all");
    }
    text += "Nodes:\n";
    for Node { name, parent, ty, potential, .. } in nodes.iter().rev() {
        let plugin = ["And", "Then", "Or", "Test"][usize::from(*ty) - 1];
        let parent = parent.map_or("NONE", |parent| nodes[parent].name.as_str());
        let params = if *ty == 4 { format!("'activation_potential: {potential}'") } else { String::new() };
        writeln!(
            text,
            "  {name}:\n    type: {ty}\n    behavior_type: 'dhtt_plugins::{plugin}Behavior'\n    robot: 0\n    \
             parent: '{parent}'\n    params: [{params}]"
        )
        .expect("a string takes all");
    }
    text
}

/// Whether nothing of a node is left to do.
fn is_done(at: usize, nodes: &[Node], done: &BTreeSet<usize>) -> bool {
    let mut below = nodes[at].children.iter().map(|child| is_done(*child, nodes, done));
    match nodes[at].ty {
        3 => below.any(|is_done| is_done),
        4 => done.contains(&at),
        _ => below.all(|is_done| is_done),
    }
}

fn has_begun(at: usize, nodes: &[Node], done: &BTreeSet<usize>) -> bool {
    done.contains(&at) || nodes[at].children.iter().any(|child| has_begun(*child, nodes, done))
}

/// The behavior that a node wants to run next: greatest potential, and the first of the greatest.
fn wanted(at: usize, nodes: &[Node], done: &BTreeSet<usize>) -> Option<usize> {
    let node = &nodes[at];
    let open = || node.children.iter().copied().filter(|child| !is_done(*child, nodes, done));
    let among: Vec<usize> = match node.ty {
        4 => return Some(at),
        2 => open().take(1).collect(),
        3 => match open().find(|child| has_begun(*child, nodes, done)) {
            Some(chosen) => vec![chosen],
            None => open().collect(),
        },
        _ => open().collect(),
    };
    let wishes = among.into_iter().filter_map(|child| wanted(child, nodes, done));
    wishes.reduce(|best, next| if nodes[next].potential > nodes[best].potential { next } else { best })
}

/// The order of the behaviors, from the tree and the potentials alone.
fn order(nodes: &[Node]) -> Vec<Vec<String>> {
    let mut done = BTreeSet::new();
    let mut order = Vec::new();
    while !is_done(0, nodes, &done) {
        let next = wanted(0, nodes, &done).expect("somebody wants to run");
        done.insert(next);
        order.push(vec![nodes[next].name.clone()]);
    }
    order
}

fn imported_steps(folder: &Path, text: &str) -> Vec<Vec<String>> {
    let (task, mission) = (folder.join("task.yaml"), folder.join("mission.yaml"));
    fs::write(&task, text).expect("a file");
    let imported = import(&Disk, &task, None, Some(&mission)).expect("an import");
    let beside = imported.beside.expect("a robot file");
    fs::write(&beside.path, beside.text).expect("a file");
    fs::write(&mission, imported.text).expect("a file");
    let (_, report) = simulate(&load(&mission), &Settings::default(), Vec::new());
    assert_eq!(report.outcome.word(), "done");
    report.steps
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(120))]

    #[test]
    fn any_task_runs_in_the_order_of_its_potentials(plan in plan()) {
        let mut nodes = Vec::new();
        lay_out(&plan, None, &mut nodes);
        let text = task_file(&nodes);
        let folder = tempfile::tempdir().expect("a folder");
        prop_assert_eq!(imported_steps(folder.path(), &text), order(&nodes), "{}", text);
    }
}
