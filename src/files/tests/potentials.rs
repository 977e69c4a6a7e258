//! Potentials that a node tells: `$name` where a number is wanted.

use super::super::FilesError;
use super::{GOOD, ROBOT, load};
use ambidex_model::{NodeId, Potential, TypeId};

/// A mission with one behavior more, which is its task.
fn with(behavior: &str, task: &str) -> String {
    let head = &GOOD[..GOOD.find("task:").unwrap()];
    format!("{head}behaviors: {{wave: {behavior}}}\n{task}\n")
}

fn potential(behavior: &str, task: &str) -> Result<Potential, FilesError> {
    let mission = load(&with(behavior, task), ROBOT)?;
    let leaf = mission.tree.leaves().next().unwrap_or(NodeId(0));
    Ok(mission.tree.behavior(leaf).unwrap().potential)
}

#[test]
fn a_node_tells_its_potential() {
    let told = "{parameters: {p: number}, potential: $p}";
    let scaled = "{parameters: {p: number}, potential: {constant: $p, scale_by: gripper}}";
    let usual = "{parameters: {p: {type: number, default: 2.5}}, potential: {constant: $p}}";
    let used = "subtrees: {twice: {parameters: {q: number}, task: {wave: $q}}}\ntask: {use: {twice: 7}}";
    for (behavior, task, expected) in [
        (told, "task: {wave: 4}", Potential::Constant(4.0)),
        (told, "task: {wave: {p: 0.001}}", Potential::Constant(0.001)),
        (told, used, Potential::Constant(7.0)),
        (scaled, "task: {wave: 4}", Potential::Scaled { value: 4.0, by: TypeId(0) }),
        (usual, "task: {wave: {}}", Potential::Constant(2.5)),
        (usual, "task: {wave: {p: 3}}", Potential::Constant(3.0)),
    ] {
        let found = potential(behavior, task);
        assert_eq!(found.map_err(|error| format!("{:?}", error.faults())), Ok(expected), "{behavior} {task}");
    }
}

#[test]
fn what_is_no_number_is_refused() {
    for (behavior, task, words) in [
        ("{parameters: {p: text}, potential: $p}", "task: {wave: 4}", "`$p` is a text, not a number"),
        ("{parameters: {p: number}, potential: $q}", "task: {wave: 4}", "there is no parameter `q`"),
        ("{parameters: {p: number}, potential: $p m}", "task: {wave: 4}", "found `$p m` instead of a number"),
        ("{parameters: {p: number}, potential: $p}", "task: {wave: -4}", "`-4` is out of bounds"),
        ("{parameters: {p: number}, potential: $p}", "task: {wave: .inf}", "out of bounds"),
        ("{parameters: {p: number}, potential: $p}", "task: {wave: {}}", "lacks its parameter `p`, a number"),
    ] {
        let error = potential(behavior, task).unwrap_err();
        let found: Vec<_> = error.faults().iter().map(ToString::to_string).collect();
        assert!(found.iter().any(|fault| fault.contains(words)), "{behavior}: {found:?}");
    }
}
