//! What of a mission can be kept physically, and who needs it: all that a certificate looks at, found once.

use std::collections::BTreeSet;
use std::ops::Range;
use std::sync::Arc;

use ambidex_model::{
    Access, BehaviorSpec, Claim, EffectTerm, MissionSpec, NodeId, NodeKind, NodeRange, ObjectId, ResourceId, Retention,
    Selector, Topology, match_claims,
};

/// The part of a mission on which it depends whether it can come to a deadlock.
#[derive(Debug)]
pub(super) struct Needs {
    pub(super) topology: Topology,
    /// Where in lists by node each stands.
    pub(super) slots: Slots,
    /// What each node is, by node.
    kinds: Vec<Kind>,
    /// By node, those of its children that concern what can be kept, in their order.
    children: Vec<Vec<NodeId>>,
    /// All nodes that concern what can be kept, in tree order.
    pub(super) nodes: Vec<NodeId>,
    /// By node, what a behavior needs of it; none where it needs nothing of the kind.
    leaves: Vec<Option<Box<LeafNeeds>>>,
    /// Which resources can be kept, by id.
    pub(super) is_kept: Vec<bool>,
    /// By resource the first one that is like it: nobody wants the one and not the other.
    pub(super) class: Vec<ResourceId>,
}

/// Lists by node that have room only for those nodes that are looked at: some runs of ids one behind the other.
#[derive(Debug)]
pub(super) struct Slots {
    runs: Vec<(Range<NodeId>, usize)>,
    count: usize,
}

impl Slots {
    fn new(runs: impl Iterator<Item = Range<NodeId>>) -> Self {
        let mut slots = Self { runs: Vec::new(), count: 0 };
        let mut runs: Vec<Range<NodeId>> = runs.collect();
        runs.sort_by_key(|run| run.start);
        for run in runs {
            let from = slots.count;
            slots.count += run.end.index() - run.start.index();
            slots.runs.push((run, from));
        }
        slots
    }

    pub(super) fn count(&self) -> usize {
        self.count
    }

    /// The slot of a node that is looked at, if it is.
    fn find(&self, node: NodeId) -> Option<usize> {
        let behind = self.runs.partition_point(|(run, _)| run.start <= node);
        let (run, from) = self.runs.get(behind.checked_sub(1)?)?;
        (node < run.end).then(|| from + node.index() - run.start.index())
    }

    /// The slot of a node that is looked at.
    pub(super) fn of(&self, node: NodeId) -> usize {
        self.find(node).expect("what is looked at has a slot")
    }
}

/// What a node is to its children.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    /// Root and AND: all, in any order.
    All,
    /// OR.
    One,
    /// THEN.
    InOrder,
    /// A behavior.
    Leaf,
}

/// What one behavior needs, and what it changes.
#[derive(Debug, Default)]
pub(super) struct LeafNeeds {
    pub(super) needs: Vec<Need>,
    /// Objects that it takes, with the need of the gripper that has them then.
    pub(super) takes: Vec<(ObjectId, usize)>,
    /// Objects that nothing holds afterwards.
    pub(super) puts: Vec<ObjectId>,
    /// Needs whose resources hold nothing afterwards, unless they take something.
    pub(super) lets_go: Vec<usize>,
}

/// A claim on what can be kept.
#[derive(Debug)]
pub(super) struct Need {
    /// Its index among the claims of the behavior.
    pub(super) claim: usize,
    pub(super) wanted: Wanted,
    pub(super) access: Access,
    /// How it is kept physically; none where it is given back.
    pub(super) keep: Option<Access>,
}

/// Which resources serve a need.
#[derive(Debug)]
pub(super) enum Wanted {
    /// One of these, those that nobody wants by name first; empty, where only such a one will do.
    OneOf { all: Vec<ResourceId>, is_empty: bool },
    /// One of these with the object in it.
    Holding { object: ObjectId, all: Vec<ResourceId> },
}

impl Needs {
    /// Of a mission as a whole, or of some tasks of a run that takes work. None where no deadlock is possible: nothing is
    /// kept, or there is enough for everybody at once.
    pub(super) fn of(mission: &MissionSpec, tasks: Option<&BTreeSet<NodeId>>) -> Option<Arc<Self>> {
        let (robot, tree) = (&mission.robot, &mission.tree);
        let mut is_kept = vec![false; robot.resources.len()];
        let tops = tasks.map_or_else(|| vec![NodeId(0)], |tasks| tasks.iter().copied().collect());
        let all: Vec<NodeId> = tops.iter().flat_map(|top| tree.leaves_below(*top)).collect();
        let leaves = || all.iter().copied().filter(|leaf| !tree.topology.is_in_cleanup(*leaf));
        let behaviors = || leaves().filter_map(|leaf| Some((leaf, tree.behavior(leaf)?)));
        for claim in behaviors().flat_map(|(_, spec)| &spec.claims).filter(|claim| kept(claim).is_some()) {
            // What holds something was kept before.
            let taken = Some(claim.selector).filter(|selector| !matches!(selector, Selector::Holding { .. }));
            let all = taken.into_iter().flat_map(|selector| robot.could_serve(selector));
            all.for_each(|id| is_kept[id.index()] = true);
        }
        if !is_kept.contains(&true) {
            return None;
        }
        for location in &mission.start.objects {
            location.holders().iter().for_each(|id| is_kept[id.index()] = true);
        }
        let named = named(behaviors().map(|(_, spec)| spec));
        // Root and its child stand above all tasks.
        let stem = tasks.map(|_| NodeId(0)..NodeId(2));
        let slots = Slots::new(stem.into_iter().chain(tops.iter().flat_map(|top| tree.topology.below(*top))));
        let mut leaves: Vec<Option<Box<LeafNeeds>>> = (0..slots.count).map(|_| None).collect();
        for (leaf, spec) in behaviors() {
            let needs = leaf_needs(mission, spec, &is_kept, &named);
            leaves[slots.of(leaf)] = (!needs.needs.is_empty()).then(|| Box::new(needs));
        }
        let wanted: Vec<_> = leaves.iter().flatten().flat_map(|leaf| leaf.needs.iter().filter_map(Need::all)).collect();
        if wanted.len() <= is_kept.len() && match_claims(&wanted).is_ok() {
            return None;
        }
        let like = |id: ResourceId| {
            let is_like = |other: &ResourceId| !named.contains(other) && is_kept[other.index()];
            let first = robot.of_type(robot.resources[id.index()].ty).find(is_like);
            if named.contains(&id) { id } else { first.unwrap_or(id) }
        };
        let class = (0..robot.resources.len()).map(|index| like(ResourceId::from(index))).collect();
        let ids = slots.runs.iter().flat_map(|(run, _)| (run.start.0..run.end.0).map(NodeId));
        let ids: Vec<NodeId> = ids.collect();
        let kinds = ids.iter().map(|node| tree.nodes.get(node.index()).map_or(Kind::All, kind)).collect();
        let (children, nodes) = concerned(&tree.topology, &slots, &ids, &leaves);
        Some(Arc::new(Self { topology: tree.topology.clone(), slots, kinds, children, nodes, leaves, is_kept, class }))
    }

    /// The children of a node that concern what can be kept, in their order.
    pub(super) fn children(&self, node: NodeId) -> &[NodeId] {
        &self.children[self.slots.of(node)]
    }

    /// What a behavior needs of what can be kept, if it does.
    pub(super) fn leaf(&self, leaf: NodeId) -> Option<&LeafNeeds> {
        self.leaves[self.slots.find(leaf)?].as_deref()
    }

    /// Whether a node concerns what can be kept.
    pub(super) fn concerns(&self, node: NodeId) -> bool {
        let has_children = self.slots.find(node).is_some_and(|slot| !self.children[slot].is_empty());
        has_children || self.leaf(node).is_some()
    }

    /// Whether a run of nodes has one that concerns what can be kept.
    pub(super) fn has_within(&self, range: NodeRange) -> bool {
        let first = self.nodes.partition_point(|node| *node < range.from);
        self.nodes.get(first).is_some_and(|node| *node < range.to)
    }

    /// Whether a node is an OR that concerns what can be kept.
    pub(super) fn is_choice(&self, node: NodeId) -> bool {
        self.kind(node) == Kind::One && self.concerns(node)
    }

    pub(super) fn kind(&self, node: NodeId) -> Kind {
        self.kinds[self.slots.of(node)]
    }
}

impl Need {
    fn all(&self) -> Option<Vec<ResourceId>> {
        match &self.wanted {
            Wanted::OneOf { all, .. } => Some(all.clone()),
            Wanted::Holding { .. } => None,
        }
    }
}

fn kept(claim: &Claim) -> Option<Access> {
    match claim.keep {
        Retention::Physical(access) => Some(access),
        Retention::Release | Retention::Intention(_) => None,
    }
}

/// What somebody wants and would not take another for.
fn named<'a>(behaviors: impl Iterator<Item = &'a BehaviorSpec>) -> BTreeSet<ResourceId> {
    let claims = behaviors.flat_map(|spec| &spec.claims);
    let resources = claims.filter_map(|claim| match claim.selector {
        Selector::Named(resource) | Selector::Empty { resource, .. } => Some(resource),
        Selector::Any(_) | Selector::AnyEmpty { .. } | Selector::Holding { .. } => None,
    });
    resources.collect()
}

fn leaf_needs(mission: &MissionSpec, spec: &BehaviorSpec, is_kept: &[bool], named: &BTreeSet<ResourceId>) -> LeafNeeds {
    let mut leaf = LeafNeeds::default();
    for (index, claim) in spec.claims.iter().enumerate() {
        let mut all = mission.robot.could_serve(claim.selector);
        let wanted = match claim.selector {
            Selector::Holding { object, .. } => Wanted::Holding { object, all },
            // One that nobody keeps will do, sooner or later.
            Selector::Named(_) | Selector::Any(_) | Selector::AnyEmpty { .. } | Selector::Empty { .. }
                if !all.iter().all(|id| is_kept[id.index()]) || all.is_empty() =>
            {
                continue;
            }
            Selector::Named(_) | Selector::Any(_) | Selector::AnyEmpty { .. } | Selector::Empty { .. } => {
                all.sort_by_key(|id| (named.contains(id), *id));
                let is_empty = matches!(claim.selector, Selector::AnyEmpty { .. } | Selector::Empty { .. });
                Wanted::OneOf { all, is_empty }
            }
        };
        leaf.needs.push(Need { claim: index, wanted, access: claim.access, keep: kept(claim) });
    }
    let need = |claim: usize| leaf.needs.iter().position(|need| need.claim == claim);
    let (mut takes, mut puts, mut lets_go) = (Vec::new(), Vec::new(), Vec::new());
    for effect in &spec.effects {
        match *effect {
            EffectTerm::Taken(object, claim) => takes.extend(need(claim).map(|need| (object, need))),
            EffectTerm::LetGo(_, claim) => lets_go.extend(need(claim)),
            EffectTerm::Lies(object, _) => puts.push(object),
            EffectTerm::Stands(_) | EffectTerm::Fact(..) => {}
        }
    }
    for term in &spec.commands {
        let need = need(term.claim);
        takes.extend(term.task.grasped().zip(need));
        lets_go.extend(need.filter(|_| term.task.put().is_some()));
    }
    LeafNeeds { takes, puts, lets_go, ..leaf }
}

fn kind(node: &NodeKind) -> Kind {
    match node {
        NodeKind::Root | NodeKind::Tasks | NodeKind::And | NodeKind::Cleanup => Kind::All,
        NodeKind::Or => Kind::One,
        NodeKind::Then => Kind::InOrder,
        NodeKind::Behavior(_) => Kind::Leaf,
    }
}

/// By node the children that concern what can be kept, and all such nodes.
fn concerned(
    topology: &Topology,
    slots: &Slots,
    ids: &[NodeId],
    leaves: &[Option<Box<LeafNeeds>>],
) -> (Vec<Vec<NodeId>>, Vec<NodeId>) {
    let mut children = vec![Vec::new(); slots.count];
    let mut nodes = Vec::new();
    // Whatever is below a node has a greater id.
    for node in ids.iter().copied().rev().filter(|node| node.0 > 0 && topology.has(*node)) {
        let slot = slots.of(node);
        if leaves[slot].is_some() || !children[slot].is_empty() {
            children[slots.of(topology.parent(node))].push(node);
            nodes.push(node);
        }
    }
    for (parent, children) in std::iter::zip(ids, &mut children) {
        children.reverse();
        if topology.is_edited(*parent) && children.len() > 1 {
            let known: BTreeSet<NodeId> = children.drain(..).collect();
            children.extend(topology.children(*parent).filter(|child| known.contains(child)));
        }
    }
    nodes.reverse();
    (children, nodes)
}
