//! No deadlock: all small trees over two grippers and a head, with and without the certificate, and random larger ones.
//!
//! Nobody is refused in vain: where the certificate refuses somebody, a run without it comes to a deadlock.

mod schedules;

use std::sync::Arc;

use ambidex::model::{
    Access, End, MissionEnd, MissionSpec, NodeId, Outcome, Reason, Record, Retention, Selector, Told,
};
use ambidex::tree::{Input, Settings};

use crate::driver::{Driver, Rng};
use crate::support::{self, Body, GRIPPER, HEAD, Tree, blank, claim};
use schedules::{Needs, Shape, is_solvable};

const BODY: Body = Body { grippers: 2, heads: 1, bases: 0, tools: 0, reach_m: 5.0 };

/// What all trees of one size came to.
#[derive(Debug, Default, PartialEq, Eq)]
struct Tally {
    trees: usize,
    solvable: usize,
    /// Solvable trees that come to a deadlock in some order of ends where nothing prevents it.
    deadlocks: usize,
    /// Solvable trees in which somebody was refused for a deadlock.
    refused: usize,
}

/// A head alone; one gripper or two, with a head or without, keeping any number of them.
fn behaviors() -> Vec<Needs> {
    let mut all = vec![Needs { grippers: 0, head: true, keeps: 0 }];
    for grippers in 1..=2 {
        for keeps in 0..=grippers {
            all.extend([false, true].map(|head| Needs { grippers, head, keeps }));
        }
    }
    all
}

fn tree(shape: &Shape, count: &mut usize) -> Tree {
    let mut all = |children: &[Shape]| children.iter().map(|child| tree(child, count)).collect();
    match shape {
        Shape::And(children) => Tree::And(all(children)),
        Shape::Then(children) => Tree::Then(all(children)),
        Shape::Leaf(needs) => {
            *count += 1;
            let keep = |index| match index < needs.keeps {
                true => Retention::Physical(Access::Exclusive),
                false => Retention::Release,
            };
            let gripper = |index| claim(Selector::Any(GRIPPER), Access::Exclusive, keep(index));
            let head = BODY.first(HEAD).expect("it has a head");
            let head = needs.head.then(|| claim(Selector::Named(head), Access::Exclusive, Retention::Release));
            let claims = (0..needs.grippers).map(gripper).chain(head).collect();
            let name = ["first", "second", "third", "fourth", "fifth", "sixth", "seventh"][*count - 1];
            Tree::Leaf(name.into(), Box::new(ambidex::model::BehaviorSpec { claims, ..blank("needs") }))
        }
    }
}

fn mission(tree: &Tree) -> Arc<MissionSpec> {
    Arc::new(support::mission(BODY, 1, Vec::new(), Vec::new(), tree))
}

fn settings(prevents_deadlock: bool) -> Settings {
    Settings { prevents_deadlock, ..Settings::default() }
}

/// Runs a mission in which everything succeeds; `choices` says which of those that run ends next, and is made longer.
/// Each entry has the choice and among how many it was.
fn run(mission: &Arc<MissionSpec>, prevents_deadlock: bool, choices: &mut Vec<(usize, usize)>) -> Driver {
    let settings = settings(prevents_deadlock);
    let mut driver = Driver::new(mission, &settings, Rng::of(&[1]));
    driver.give(NodeId(0), Told::Begin { changes: Vec::new() }.into());
    driver.rest();
    for step in 0.. {
        let running: Vec<NodeId> = driver.goals.keys().copied().collect();
        if running.is_empty() {
            break;
        }
        if step == choices.len() {
            choices.push((0, running.len()));
        }
        let ended = Outcome { end: End::Succeeded, changes: Vec::new() };
        driver.give(running[choices[step].0], Input::Ended(Box::new(ended)));
        driver.rest();
    }
    driver
}

/// All orders in which what runs can end; gives whether all come to the end, and whether somebody was refused.
fn runs(mission: &Arc<MissionSpec>, prevents_deadlock: bool) -> (bool, bool) {
    let mut choices = Vec::new();
    let (mut are_done, mut is_refused) = (true, false);
    loop {
        let driver = run(mission, prevents_deadlock, &mut choices);
        are_done &= driver.finished == Some(MissionEnd::Done);
        is_refused |= refusals(&driver.records).next().is_some();
        while choices.last().is_some_and(|(choice, of)| choice + 1 == *of) {
            choices.pop();
        }
        match choices.last_mut() {
            Some((choice, _)) => *choice += 1,
            None => return (are_done, is_refused),
        }
    }
}

fn refusals(records: &[Record]) -> impl Iterator<Item = &Reason> {
    let blocked = records.iter().flat_map(Record::refusals);
    blocked.map(|blocked| &blocked.reason).filter(|reason| matches!(reason, Reason::WouldDeadlock { .. }))
}

/// With the certificate every solvable tree is done, in whatever order things end.
fn tally(shapes: impl Iterator<Item = Shape>) -> Tally {
    let mut tally = Tally::default();
    for shape in shapes {
        tally.trees += 1;
        if !is_solvable(&shape) {
            continue;
        }
        tally.solvable += 1;
        let mission = mission(&tree(&shape, &mut 0));
        let (is_done, _) = runs(&mission, false);
        tally.deadlocks += usize::from(!is_done);
        let (is_done, is_refused) = runs(&mission, true);
        assert!(is_done, "solvable, and not done: {shape:?}");
        tally.refused += usize::from(is_refused);
    }
    println!("{tally:?}");
    tally
}

#[test]
fn no_tree_of_two_leaves_comes_to_a_deadlock() {
    let all = behaviors();
    let pairs = || all.iter().flat_map(|one| all.iter().map(|other| [Shape::Leaf(*one), Shape::Leaf(*other)].to_vec()));
    let tally = tally(pairs().map(Shape::And).chain(pairs().map(Shape::Then)));
    assert_eq!(tally, Tally { trees: 242, solvable: 218, deadlocks: 20, refused: 20 });
}

#[test]
fn no_tree_of_three_leaves_comes_to_a_deadlock() {
    let all = behaviors();
    let leaf = |needs: &Needs| Shape::Leaf(*needs);
    let mut shapes = Vec::new();
    for one in &all {
        for two in &all {
            for three in &all {
                let [a, b, c] = [leaf(one), leaf(two), leaf(three)];
                let then = Shape::Then(vec![b.clone(), c.clone()]);
                let and = Shape::And(vec![b.clone(), c.clone()]);
                shapes.push(Shape::And(vec![a.clone(), then]));
                shapes.push(Shape::Then(vec![a.clone(), and.clone()]));
                shapes.push(Shape::Then(vec![and, a.clone()]));
                shapes.push(Shape::And(vec![a.clone(), b.clone(), c.clone()]));
                shapes.push(Shape::Then(vec![a, b, c]));
            }
        }
    }
    let tally = tally(shapes.into_iter());
    assert_eq!(tally, Tally { trees: 6_655, solvable: 5_223, deadlocks: 1_042, refused: 1_042 });
}

fn random(rng: &mut Rng, leaves: usize, is_and: bool) -> Shape {
    if leaves == 1 {
        return Shape::Leaf(rng.one(&behaviors()));
    }
    let mut left = leaves;
    let mut children = Vec::new();
    while left > 0 {
        let most = if children.is_empty() { left - 1 } else { left };
        let size = 1 + rng.below(most);
        children.push(random(rng, size, !is_and));
        left -= size;
    }
    if is_and { Shape::And(children) } else { Shape::Then(children) }
}

#[test]
fn no_larger_tree_comes_to_a_deadlock() {
    let mut rng = Rng::of(&[5, 7]);
    let tally = tally((0..1_500).map(|index| random(&mut rng, 5 + index % 3, index % 4 != 0)));
    assert_eq!(tally, Tally { trees: 1_500, solvable: 592, deadlocks: 326, refused: 323 });
}
