//! What of a mission can be kept physically, and who needs it: all that a certificate looks at, found once.

use std::collections::BTreeSet;
use std::sync::Arc;

use ambidex_model::{
    Access, BehaviorSpec, Claim, EffectTerm, MissionSpec, NodeId, NodeKind, NodeRange, ObjectId, ResourceId, Retention,
    Selector, Topology, match_claims,
};

/// The part of a mission on which it depends whether it can come to a deadlock.
#[derive(Debug)]
pub(super) struct Needs {
    pub(super) topology: Topology,
    /// What each node is, by id.
    pub(super) kinds: Vec<Kind>,
    /// By node, those of its children that concern what can be kept.
    pub(super) children: Vec<Vec<NodeId>>,
    /// All nodes that concern what can be kept, in tree order.
    pub(super) nodes: Vec<NodeId>,
    /// By node, what a behavior needs of it; none where it needs nothing of the kind.
    leaves: Vec<Option<Box<LeafNeeds>>>,
    /// Which resources can be kept, by id.
    pub(super) is_kept: Vec<bool>,
    /// By resource the first one that is like it: nobody wants the one and not the other.
    pub(super) class: Vec<ResourceId>,
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
    /// None where no deadlock is possible: nothing is kept, or there is enough for everybody at once.
    pub(super) fn of(mission: &MissionSpec) -> Option<Arc<Self>> {
        let (robot, tree) = (&mission.robot, &mission.tree);
        let mut is_kept = vec![false; robot.resources.len()];
        let leaves = || tree.leaves().filter(|leaf| !tree.topology.is_in_cleanup(*leaf));
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
        let mut leaves: Vec<Option<Box<LeafNeeds>>> = tree.nodes.iter().map(|_| None).collect();
        for (leaf, spec) in behaviors() {
            let needs = leaf_needs(mission, spec, &is_kept, &named);
            leaves[leaf.index()] = (!needs.needs.is_empty()).then(|| Box::new(needs));
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
        let kinds = tree.nodes.iter().map(kind).collect();
        let (children, nodes) = concerned(&tree.topology, &leaves);
        Some(Arc::new(Self { topology: tree.topology.clone(), kinds, children, nodes, leaves, is_kept, class }))
    }

    /// What a behavior needs of what can be kept, if it does.
    pub(super) fn leaf(&self, leaf: NodeId) -> Option<&LeafNeeds> {
        self.leaves[leaf.index()].as_deref()
    }

    /// Whether a node concerns what can be kept.
    pub(super) fn concerns(&self, node: NodeId) -> bool {
        !self.children[node.index()].is_empty() || self.leaf(node).is_some()
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
        self.kinds[node.index()]
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
        NodeKind::Root | NodeKind::And | NodeKind::Cleanup => Kind::All,
        NodeKind::Or => Kind::One,
        NodeKind::Then => Kind::InOrder,
        NodeKind::Behavior(_) => Kind::Leaf,
    }
}

/// By node the children that concern what can be kept, and all such nodes.
fn concerned(topology: &Topology, leaves: &[Option<Box<LeafNeeds>>]) -> (Vec<Vec<NodeId>>, Vec<NodeId>) {
    let mut children = vec![Vec::new(); topology.count()];
    let mut nodes = Vec::new();
    for node in (1..topology.count()).rev().map(NodeId::from) {
        if leaves[node.index()].is_some() || !children[node.index()].is_empty() {
            children[topology.parent(node).index()].push(node);
            nodes.push(node);
        }
    }
    children.iter_mut().for_each(|children| children.reverse());
    nodes.reverse();
    (children, nodes)
}
