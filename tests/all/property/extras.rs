//! What a part of the random trees has beside: urgent work, what must last, repetitions, cleanups, fairness.

use std::collections::BTreeMap;
use std::time::Duration;

use ambidex::model::{
    BehaviorSpec, Condition, EffectTerm, FactId, MissionSpec, NodeId, NodeKind, ObjectId, Repeat, Selector,
};

use crate::driver::Rng;
use crate::support::{GRIPPER, Tree};

/// Most nodes of one tree that repeat.
const MOST_REPEATING: usize = 3;

/// Which of these a tree has.
#[derive(Debug, Clone, Copy, Default)]
pub struct Extras {
    pub priorities: bool,
    pub lasting: bool,
    pub repeats: bool,
    pub cleanups: bool,
    pub fairness: bool,
    pub endless: bool,
    pub repeated_cleanups: bool,
}

impl Extras {
    /// `AMBIDEX_EXTRAS=priorities,lasting` leaves out all others.
    pub fn of(seed: u64) -> Self {
        let only = std::env::var("AMBIDEX_EXTRAS").ok();
        let has = |rng: &mut Rng, name: &str, percent: usize| {
            let is_it = rng.is(percent);
            is_it && only.as_ref().is_none_or(|only| only.split(',').any(|other| other == name))
        };
        let (mut rng, mut others) = (Rng::of(&[seed, 16]), Rng::of(&[seed, 19]));
        Self {
            priorities: has(&mut rng, "priorities", 40),
            lasting: has(&mut rng, "lasting", 25),
            repeats: has(&mut rng, "repeats", 25),
            cleanups: has(&mut rng, "cleanups", 30),
            fairness: has(&mut rng, "fairness", 25),
            endless: has(&mut others, "endless", 6),
            repeated_cleanups: has(&mut others, "repeated_cleanups", 50),
        }
    }
}

/// Adds what is no part of the shape of a tree.
pub fn add(seed: u64, extras: Extras, mission: &mut MissionSpec) {
    let mut rng = Rng::of(&[seed, 17]);
    if extras.priorities {
        add_priorities(&mut rng, mission);
    }
    if extras.lasting {
        add_lasting(&mut rng, mission);
    }
    if extras.repeats {
        add_repeats(&mut rng, mission);
    }
    let mut others = Rng::of(&[seed, 20]);
    if extras.repeated_cleanups {
        add_repeats_to_cleanups(&mut others, mission);
    }
    if extras.endless {
        add_endless(&mut others, mission);
    }
    if extras.fairness && mission.tree.nodes[1] == NodeKind::And {
        mission.tree.tasks = mission.tree.topology.children(NodeId(1)).collect();
        mission.tree.bypass = 1 + rng.below(3) as u32;
    }
}

/// In some THENs a behavior that waits for a fact, and behind it one whose goal others may reach.
pub fn add_shortcuts(seed: u64, mission: &mut MissionSpec) {
    let mut rng = Rng::of(&[seed, 14]);
    if !rng.is(20) {
        return;
    }
    let facts = mission.start.facts.len();
    let (needed, reached) = (rng.below(facts / 2), facts / 2 + rng.below(facts / 2));
    mission.world.outside.resize(facts, false);
    (mission.world.outside[needed], mission.world.outside[reached]) = (true, rng.is(60));
    let (needed, reached) = (FactId::from(needed), FactId::from(reached));
    for node in (1..mission.tree.nodes.len()).map(NodeId::from) {
        let is_gadget = |child: &NodeId| mission.tree.behavior(*child).is_some_and(|spec| spec.kind == "gadget");
        let gadgets: Vec<_> = mission.tree.topology.children(node).filter(is_gadget).collect();
        if mission.tree.nodes[node.index()] != NodeKind::Then || gadgets.len() < 2 {
            continue;
        }
        if let NodeKind::Behavior(spec) = &mut mission.tree.nodes[gadgets[0].index()] {
            spec.effects.push(EffectTerm::Fact(reached, true));
            let precondition = std::mem::replace(&mut spec.precondition, Condition::Never);
            spec.precondition = Condition::All(vec![precondition, Condition::Fact(needed, true)]);
        }
        if let NodeKind::Behavior(spec) = &mut mission.tree.nodes[gadgets[1].index()] {
            spec.satisfied = Condition::Fact(reached, true);
        }
    }
}

/// Few nodes say how urgent they are; what holds an arm or changes an object is mostly left alone.
fn add_priorities(rng: &mut Rng, mission: &mut MissionSpec) {
    let nodes = (1..mission.tree.nodes.len()).map(NodeId::from);
    let mut told = BTreeMap::new();
    for node in nodes {
        if rng.is(25) {
            told.insert(node, rng.one(&[-1, 0, 1, 1, 2, 5]));
        }
    }
    mission.tree = mission.tree.clone().with_priorities(&told);
    for_each_behavior(mission, |spec, gripper| {
        let is_held = gripper || !spec.changes.is_empty();
        spec.is_interruptible = is_held == rng.is(12);
    });
}

/// Facts that must be so, and objects that must be where they are, as long as something runs.
fn add_lasting(rng: &mut Rng, mission: &mut MissionSpec) {
    let facts = mission.start.facts.len();
    for_each_behavior(mission, |spec, _| {
        let mut parts = Vec::new();
        if rng.is(if spec.kind == "gadget" { 20 } else { 5 }) {
            parts.push(Condition::Fact(FactId::from(rng.below(facts)), rng.is(50)));
        }
        let needs = match std::mem::replace(&mut spec.precondition, Condition::Never) {
            Condition::All(needs) => needs,
            need => vec![need],
        };
        let of_objects = needs.iter().filter(|part| {
            matches!(part, Condition::Lies(..) | Condition::Held(_) | Condition::Free(_) | Condition::Somewhere(_))
        });
        parts.extend(of_objects.filter(|_| rng.is(50)).cloned().collect::<Vec<_>>());
        spec.precondition = Condition::All([needs, parts.clone()].concat());
        spec.lasting = Condition::All(parts);
    });
}

fn for_each_behavior(mission: &mut MissionSpec, mut change: impl FnMut(&mut BehaviorSpec, bool)) {
    let grippers: Vec<_> = mission.robot.of_type(GRIPPER).collect();
    let is_gripper = |selector: Selector| match selector {
        Selector::Named(resource) | Selector::Empty { resource, .. } => grippers.contains(&resource),
        Selector::AnyEmpty { of, .. } | Selector::Any(of) => of == GRIPPER,
        Selector::Holding { .. } => true,
    };
    for node in mission.tree.nodes.iter_mut() {
        if let NodeKind::Behavior(spec) = node {
            let has_gripper = spec.claims.iter().any(|claim| is_gripper(claim.selector));
            change(spec, has_gripper);
        }
    }
}

/// Some are done twice or three times, some of them at their time.
fn add_repeats(rng: &mut Rng, mission: &mut MissionSpec) {
    let nodes: Vec<_> = (1..mission.tree.nodes.len()).map(NodeId::from).collect();
    let can = |node: &&NodeId| {
        let topology = &mission.tree.topology;
        mission.tree.nodes[node.index()] != NodeKind::Cleanup && !topology.is_in_cleanup(**node)
    };
    let can: Vec<_> = nodes.iter().filter(can).copied().collect();
    for _ in 0..1 + rng.below(MOST_REPEATING) {
        let every = rng.is(40).then(|| Duration::from_millis(100 + rng.below(12_000) as u64));
        let times = Some(2 + rng.below(2) as u32);
        mission.tree.repeats.insert(rng.one(&can), Repeat { times, every });
    }
}

/// In cleanups too, also the whole of one.
fn add_repeats_to_cleanups(rng: &mut Rng, mission: &mut MissionSpec) {
    let topology = &mission.tree.topology;
    let is_in_cleanup = |node: &NodeId| topology.is_in_cleanup(*node) || topology.is_cleanup(*node);
    let can: Vec<_> = (1..mission.tree.nodes.len()).map(NodeId::from).filter(is_in_cleanup).collect();
    for node in can {
        if rng.is(40) {
            let every = rng.is(25).then(|| Duration::from_millis(100 + rng.below(4_000) as u64));
            mission.tree.repeats.insert(node, Repeat { times: Some(2 + rng.below(2) as u32), every });
        }
    }
}

/// One node without end, which the plan of such a mission cancels.
fn add_endless(rng: &mut Rng, mission: &mut MissionSpec) {
    let can_repeat = |node: &NodeId| mission.tree.nodes[node.index()] != NodeKind::Cleanup;
    let can: Vec<_> = (1..mission.tree.nodes.len()).map(NodeId::from).filter(can_repeat).collect();
    let every = Some(Duration::from_millis(1000 + rng.below(8_000) as u64));
    mission.tree.repeats.insert(rng.one(&can), Repeat { times: None, every });
}

/// Whether something is done without end.
pub fn is_endless(mission: &MissionSpec) -> bool {
    mission.tree.repeats.values().any(|repeat| repeat.times.is_none())
}

/// An object that something in a tree takes.
pub fn taken(tree: &Tree) -> Option<ObjectId> {
    match tree {
        Tree::And(children) | Tree::Or(children) | Tree::Then(children) => children.iter().find_map(taken),
        Tree::Cleanup(children) => taken(&children[0]),
        Tree::Leaf(_, spec) => spec.effects.iter().find_map(|effect| match *effect {
            EffectTerm::Taken(object, _) => Some(object),
            EffectTerm::Lies(..) | EffectTerm::LetGo(..) | EffectTerm::Stands(_) | EffectTerm::Fact(..) => None,
        }),
    }
}
