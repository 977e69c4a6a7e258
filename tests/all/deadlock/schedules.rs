//! Whether a tree can be finished at all: every serial schedule is tried. It knows nothing of the core.

use std::collections::BTreeSet;

/// What a behavior needs of two grippers and a head, and how many grippers it keeps.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Needs {
    pub grippers: usize,
    pub head: bool,
    pub keeps: usize,
}

/// A tree of such behaviors.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub enum Shape {
    Leaf(Needs),
    And(Vec<Shape>),
    Then(Vec<Shape>),
}

/// How far a tree is.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
struct Progress {
    is_done: bool,
    /// Grippers that this node holds.
    holds: usize,
    below: Vec<Progress>,
}

const GRIPPERS: usize = 2;

/// Whether some schedule ends with everything done. At most one runs at a time: what runs beside it only holds more.
pub fn is_solvable(shape: &Shape) -> bool {
    let mut seen = BTreeSet::new();
    finish(shape, start(shape), &mut seen)
}

fn start(shape: &Shape) -> Progress {
    let below = match shape {
        Shape::Leaf(_) => Vec::new(),
        Shape::And(children) | Shape::Then(children) => children.iter().map(start).collect(),
    };
    Progress { is_done: false, holds: 0, below }
}

fn finish(shape: &Shape, now: Progress, seen: &mut BTreeSet<Progress>) -> bool {
    if now.is_done {
        return true;
    }
    if !seen.insert(now.clone()) {
        return false;
    }
    let free = GRIPPERS - held(&now);
    next(shape, &now, free, 0).into_iter().any(|(after, _, _)| finish(shape, after, seen))
}

fn held(now: &Progress) -> usize {
    now.holds + now.below.iter().map(held).sum::<usize>()
}

/// What can come next below a node: how it is then, how many free grippers are taken or given back, and how many it
/// took of what is inherited.
fn next(shape: &Shape, now: &Progress, free: usize, inherited: usize) -> Vec<(Progress, isize, usize)> {
    let children = match shape {
        Shape::Leaf(needs) => return run(*needs, free, inherited),
        Shape::And(children) | Shape::Then(children) => children,
    };
    let is_then = matches!(shape, Shape::Then(_));
    let mut all = Vec::new();
    for (index, child) in children.iter().enumerate() {
        if now.below[index].is_done {
            continue;
        }
        for (below, taken, inherits) in next(child, &now.below[index], free, inherited + now.holds) {
            let mut after = now.clone();
            // The nearest is taken first.
            let own = inherits.min(after.holds);
            after.holds -= own;
            after.below[index] = below;
            let is_complete = after.below.iter().all(|child| child.is_done);
            if after.below[index].is_done && (is_then || is_complete) {
                after.holds += drain(&mut after.below[index]);
            }
            if is_complete {
                after.is_done = true;
                after.holds += after.below.iter_mut().map(drain).sum::<usize>();
            }
            all.push((after, taken, inherits - own));
        }
        if is_then {
            break;
        }
    }
    all
}

fn run(needs: Needs, free: usize, inherited: usize) -> Vec<(Progress, isize, usize)> {
    let done = Progress { is_done: true, holds: needs.keeps, below: Vec::new() };
    let ways = (0..=needs.grippers.min(inherited)).filter(|own| needs.grippers - own <= free);
    ways.map(|own| (done.clone(), needs.keeps as isize - own as isize, own)).collect()
}

fn drain(now: &mut Progress) -> usize {
    std::mem::take(&mut now.holds) + now.below.iter_mut().map(drain).sum::<usize>()
}
