//! The nodes of a dHTT task as one tree: who hangs from target, and every reason why that is none.

use std::collections::BTreeMap;

use super::entry::{Entry, Kind, NO_PARENT, Parent};
use super::form::NODES;
use super::notes;
use crate::fault::Faults;

/// Deepest tree that a mission can hold.
const MAX_LEVELS: usize = 64;

/// A tree over entries.
#[derive(Debug)]
pub(super) struct Tree {
    pub(super) top: usize,
    /// The children of each entry in their order.
    pub(super) children: Vec<Vec<usize>>,
}

/// What is known of the parent of an entry.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Above {
    Nothing,
    Node(usize),
    /// It is wrong, and has its fault.
    Unknown,
}

impl Tree {
    /// Builds it from entries in the order of their list; `None` when they are no tree.
    pub(super) fn of(entries: &[Entry], faults: &mut Faults) -> Option<Self> {
        let before = faults.errors();
        let above = parents(entries, faults);
        let mut children = vec![Vec::new(); entries.len()];
        for (index, above) in above.iter().enumerate() {
            if let Above::Node(parent) = above {
                children[*parent].push(index);
            }
        }
        check_kinds(entries, &above, &children, faults);
        let is_reached = reached(entries, &above, &children, faults);
        check_circles(entries, &above, &is_reached, faults);
        let top = top(entries, &above, faults)?;
        (faults.errors() == before).then_some(Self { top, children })
    }
}

fn parents(entries: &[Entry], faults: &mut Faults) -> Vec<Above> {
    let names: Vec<&str> = entries.iter().map(|entry| entry.name.value.as_str()).collect();
    let places: BTreeMap<&str, usize> = names.iter().enumerate().map(|(at, name)| (*name, at)).collect();
    let parent = |entry: &Entry| match entry.parent.as_ref() {
        None => Above::Unknown,
        Some(Parent::None(_)) => Above::Nothing,
        Some(Parent::Node(name)) => match places.get(name.value.as_str()) {
            Some(at) => Above::Node(*at),
            None => {
                let message = format!("there is no node `{}`", name.value);
                let allowed = [NO_PARENT].into_iter().chain(names.iter().copied());
                let help = notes::suggested(&name.value, "parent", allowed, faults);
                faults.push_or_with((name.span, &entry.name.value), message, help);
                Above::Unknown
            }
        },
    };
    entries.iter().map(parent).collect()
}

/// Behaviors have no children, and everything else has some.
fn check_kinds(entries: &[Entry], above: &[Above], children: &[Vec<usize>], faults: &mut Faults) {
    // An entry whose parent is wrong may be the child that is missed.
    let is_complete = !above.contains(&Above::Unknown);
    for (entry, children) in entries.iter().zip(children) {
        let Some(kind) = entry.kind else { continue };
        match (kind, children.first()) {
            (Kind::Behavior, Some(&child)) => {
                let message = format!("a behavior cannot have children, and `{}` is one", entries[child].name.value);
                let help = "give it type 1 (AND), 2 (THEN) or 3 (OR), or the child another parent".to_owned();
                faults.push_with((entry.name.span, &entry.name.value), message, help);
            }
            (Kind::And | Kind::Or | Kind::Then, None) if is_complete => {
                let help = "only a behavior (type 4) has none: name it as the `parent` of others".to_owned();
                faults.push_with((entry.name.span, &entry.name.value), "it has no children", help);
            }
            (Kind::Behavior, None) | (Kind::And | Kind::Or | Kind::Then, _) => {}
        }
    }
}

/// Which entries hang from one without a parent; a fault where that is too far below.
fn reached(entries: &[Entry], above: &[Above], children: &[Vec<usize>], faults: &mut Faults) -> Vec<bool> {
    let mut is_reached = vec![false; entries.len()];
    let tops = (0..entries.len()).filter(|&at| !matches!(above[at], Above::Node(_)));
    let mut open: Vec<(usize, usize)> = tops.map(|top| (top, 1)).collect();
    while let Some((at, level)) = open.pop() {
        is_reached[at] = true;
        if level == MAX_LEVELS + 1 {
            let message = format!("more than {MAX_LEVELS} nodes one below another");
            faults.push((entries[at].name.span, &entries[at].name.value), message);
        }
        open.extend(children[at].iter().map(|child| (*child, level + 1)));
    }
    is_reached
}

/// What hangs from nothing is in a circle of parents, or below one.
fn check_circles(entries: &[Entry], above: &[Above], is_reached: &[bool], faults: &mut Faults) {
    let mut walks: Vec<Option<usize>> = vec![None; entries.len()];
    for start in (0..entries.len()).filter(|&start| !is_reached[start]) {
        let mut at = start;
        while let (None, Above::Node(parent)) = (walks[at], above[at]) {
            walks[at] = Some(start);
            at = parent;
        }
        if walks[at] == Some(start) {
            circle(entries, above, at, faults);
        }
    }
}

fn circle(entries: &[Entry], above: &[Above], from: usize, faults: &mut Faults) {
    const MAX_NAMED: usize = 6;
    let mut names = vec![entries[from].name.value.as_str()];
    let mut at = from;
    while let Above::Node(parent) = above[at] {
        at = parent;
        names.push(&entries[at].name.value);
        if at == from || names.len() > MAX_NAMED {
            break;
        }
    }
    if at != from {
        names.push("…");
    }
    let span = match &entries[from].parent {
        Some(Parent::Node(name)) => name.span,
        Some(Parent::None(_)) | None => entries[from].name.span,
    };
    let message = format!("it is above itself: {}", names.join(" → "));
    faults.push_with((span, names[0]), message, "each arrow leads to a parent; the topmost node has the parent NONE");
}

/// The one entry without a parent.
fn top(entries: &[Entry], above: &[Above], faults: &mut Faults) -> Option<usize> {
    let mut tops = (0..entries.len()).filter(|&at| above[at] == Above::Nothing);
    let Some(first) = tops.next() else {
        if let Some(entry) = entries.first().filter(|_| !above.contains(&Above::Unknown)) {
            let message = "no node is the topmost".to_owned();
            faults.push_with((entry.name.span, NODES), message, "give the topmost node the parent NONE");
        }
        return None;
    };
    for other in tops {
        let Some(Parent::None(span)) = entries[other].parent else { continue };
        let message = format!("a second topmost node beside `{}`", entries[first].name.value);
        let help = "one node stands above all: put both below one of type 1 (AND) or 2 (THEN)".to_owned();
        faults.push_with((span, &entries[other].name.value), message, help);
    }
    Some(first)
}
