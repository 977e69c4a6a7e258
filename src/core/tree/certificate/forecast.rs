//! What tree and table come to when behaviors end one after the other, each with success; only of what can be kept.

use std::collections::BTreeMap;

use super::needs::{Kind, LeafNeeds, Need, Needs, Wanted};
use ambidex_model::state::{Phase, State};
use ambidex_model::{Access, Grant, LeaseKind, NodeId, ObjectId, ResourceId};

/// The top of the task.
const TOP: NodeId = NodeId(1);

/// A moment at which nothing runs.
#[derive(Debug, Clone)]
pub(super) struct Forecast<'a> {
    needs: &'a Needs,
    /// By node, whether nothing of it that matters is left to be done, or it is out.
    is_complete: Vec<bool>,
    /// By node, how many of its children are not complete.
    left: Vec<u32>,
    /// By OR the child that it is committed to.
    ways: BTreeMap<NodeId, NodeId>,
    leases: Vec<Kept>,
    /// What is in each resource, by resource.
    content: Vec<Option<ObjectId>>,
}

/// A lease that is kept physically.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Kept {
    pub(super) resource: ResourceId,
    pub(super) holder: NodeId,
    /// The behavior that got it.
    pub(super) behavior: NodeId,
    access: Access,
}

/// Which resource serves each need of a behavior; none for an object that its line does not have.
pub(super) type Served = Vec<Option<ResourceId>>;

impl<'a> Forecast<'a> {
    /// What a state comes to when all that runs has succeeded; intentions have lapsed by then.
    pub(super) fn new(needs: &'a Needs, state: &State) -> Self {
        let count = needs.slots.count();
        let mut content = vec![None; needs.is_kept.len()];
        for (object, location) in state.world().objects.iter().enumerate() {
            for id in location.holders() {
                content[id.index()] = Some(ObjectId::from(object));
            }
        }
        let mut ahead = Self {
            needs,
            is_complete: vec![false; count],
            left: vec![0; count],
            ways: BTreeMap::new(),
            leases: Vec::new(),
            content,
        };
        needs.nodes.iter().rev().for_each(|node| ahead.begin(state, *node));
        for (resource, lease) in state.table().leases() {
            let access = state.table().resource(resource).access().unwrap_or(Access::Exclusive);
            if lease.kind == LeaseKind::Physical && needs.is_kept[resource.index()] {
                let holder = if ahead.is_over(lease.holder) { ahead.heir(lease.holder) } else { lease.holder };
                ahead.leases.push(Kept { resource, holder, behavior: lease.behavior, access });
            }
        }
        for (&leaf, grant) in state.running() {
            if let Some(spec) = needs.leaf(leaf) {
                ahead.end(leaf, spec, &served(spec, grant));
            }
        }
        ahead
    }

    /// Takes over how far a node is; its children come before it.
    fn begin(&mut self, state: &State, node: NodeId) {
        let is_out = match state.phase(node) {
            Phase::Pending => false,
            Phase::Failing(failing) => !failing.finishes,
            Phase::Done | Phase::Failed | Phase::Ending | Phase::Cleaning(_) => true,
        };
        let needs = self.needs;
        let is_over = |child: &NodeId| !needs.concerns(*child) || self.is_over(*child);
        let (left, is_complete) = match needs.kind(node) {
            Kind::Leaf => (0, false),
            Kind::All | Kind::InOrder => {
                let left = needs.children(node).iter().filter(|child| !is_over(child)).count();
                (left, left == 0)
            }
            Kind::One => {
                let is_alive = |way: &NodeId| matches!(state.phase(*way), Phase::Pending | Phase::Done);
                let way = state.status(node).way.filter(is_alive);
                let is_complete = match way {
                    Some(way) => is_over(&way),
                    None => needs.topology.children(node).filter(is_alive).any(|way| is_over(&way)),
                };
                if let Some(way) = way {
                    self.ways.insert(node, way);
                }
                (1, is_complete)
            }
        };
        let slot = needs.slots.of(node);
        self.left[slot] = left as u32;
        self.is_complete[slot] = is_out || is_complete;
    }

    /// Whether nothing is left to be done that matters.
    pub(super) fn is_complete(&self) -> bool {
        self.is_over(TOP)
    }

    pub(super) fn is_over(&self, node: NodeId) -> bool {
        self.is_complete[self.needs.slots.of(node)]
    }

    /// How many behaviors are left.
    pub(super) fn left_to_do(&self) -> usize {
        let nodes = self.needs.nodes.iter();
        nodes.filter(|node| self.needs.kind(**node) == Kind::Leaf && !self.is_over(**node)).count()
    }

    pub(super) fn needs(&self) -> &'a Needs {
        self.needs
    }

    pub(super) fn leases(&self) -> &[Kept] {
        &self.leases
    }

    /// What is in a resource.
    pub(super) fn content(&self, resource: ResourceId) -> Option<ObjectId> {
        self.content[resource.index()]
    }

    /// The way that an OR is committed to.
    pub(super) fn way(&self, or: NodeId) -> Option<NodeId> {
        self.ways.get(&or).copied()
    }

    /// Whether a line of inheritance uses a holder's leases as its own.
    pub(super) fn is_in_line(&self, leaf: NodeId, holder: NodeId) -> bool {
        self.needs.topology.is_within(leaf, holder)
    }

    /// Behaviors whose turn it is, in tree order.
    pub(super) fn open(&self) -> Vec<NodeId> {
        let mut open = Vec::new();
        let mut nodes = vec![TOP];
        while let Some(node) = nodes.pop() {
            if self.is_over(node) {
                continue;
            }
            let children = self.needs.children(node);
            let is_left = |child: &&NodeId| !self.is_over(**child);
            match self.needs.kind(node) {
                Kind::Leaf => open.push(node),
                Kind::All => nodes.extend(children.iter().rev().filter(is_left)),
                Kind::InOrder => nodes.extend(children.iter().find(is_left)),
                Kind::One => {
                    let way = self.way(node);
                    nodes.extend(
                        children.iter().rev().filter(is_left).filter(|child| way.is_none_or(|way| way == **child)),
                    );
                }
            }
        }
        open
    }

    /// Whether it is a behavior's turn.
    fn is_open(&self, leaf: NodeId) -> bool {
        let mut child = leaf;
        !self.is_over(leaf)
            && self.needs.topology.path(leaf).skip(1).take_while(|node| *node >= TOP).all(|node| {
                let child = std::mem::replace(&mut child, node);
                let is_next = match self.needs.kind(node) {
                    Kind::All | Kind::Leaf => true,
                    Kind::One => self.way(node).is_none_or(|way| way == child),
                    Kind::InOrder => {
                        let mut earlier = self.needs.children(node).iter().take_while(|other| **other != child);
                        earlier.all(|other| self.is_over(*other))
                    }
                };
                is_next && !self.is_over(node)
            })
    }

    /// Whether an OR above would be committed by it.
    pub(super) fn commits(&self, leaf: NodeId) -> bool {
        let mut above = self.needs.topology.path(leaf).skip(1);
        above.any(|node| self.needs.kind(node) == Kind::One && self.way(node).is_none())
    }

    /// Every way to serve a behavior that is different from the others, the best first; none where there is none.
    pub(super) fn ways_to_serve(&self, leaf: NodeId, most: usize) -> Vec<Served> {
        let mut ways = Vec::new();
        if let Some(spec) = self.needs.leaf(leaf) {
            self.serve(leaf, &spec.needs, &mut Vec::new(), most, &mut ways);
        }
        ways
    }

    fn serve(&self, leaf: NodeId, needs: &[Need], chosen: &mut Served, most: usize, ways: &mut Vec<Served>) {
        let Some(need) = needs.get(chosen.len()) else {
            ways.push(chosen.clone());
            return;
        };
        let mut go_on = |choice, chosen: &mut Served| {
            chosen.push(choice);
            self.serve(leaf, needs, chosen, most, ways);
            chosen.pop();
            ways.len() < most
        };
        match &need.wanted {
            Wanted::Holding { object, all } => {
                let is_holder =
                    |id: &ResourceId| self.content(*id) == Some(*object) && self.fits(leaf, *id, need, chosen);
                let holders: Vec<ResourceId> = all.iter().copied().filter(is_holder).collect();
                // An object that its line does not have is no matter of grippers: others say why it cannot run.
                if holders.is_empty() {
                    go_on(None, chosen);
                }
                for holder in holders {
                    if !go_on(Some(holder), chosen) {
                        return;
                    }
                }
            }
            Wanted::OneOf { all, .. } => {
                let fitting = all.iter().copied().filter(|resource| self.fits(leaf, *resource, need, chosen));
                let mut fitting: Vec<ResourceId> = fitting.collect();
                fitting.sort_by_key(|resource| self.preference(leaf, *resource));
                for (index, &resource) in fitting.iter().enumerate() {
                    let is_new = fitting[..index].iter().all(|other| !self.is_alike(leaf, *other, resource));
                    if is_new && !go_on(Some(resource), chosen) {
                        return;
                    }
                }
            }
        }
    }

    /// What its line has already takes nothing of what others could have; what is full may be wanted for that.
    fn preference(&self, leaf: NodeId, resource: ResourceId) -> u8 {
        let mut leases = self.leases.iter().filter(|lease| lease.resource == resource);
        let is_inherited = leases.any(|lease| self.is_in_line(leaf, lease.holder));
        match (is_inherited, self.content[resource.index()]) {
            (true, None) => 0,
            (false, _) => 1,
            (true, Some(_)) => 2,
        }
    }

    fn fits(&self, leaf: NodeId, resource: ResourceId, need: &Need, chosen: &Served) -> bool {
        let is_full = || self.content[resource.index()].is_some();
        let must_be_empty = matches!(need.wanted, Wanted::OneOf { is_empty: true, .. });
        let mut others = self.leases.iter().filter(|lease| lease.resource == resource);
        !chosen.contains(&Some(resource))
            && others.all(|lease| lease.access.joins(need.access) || self.is_in_line(leaf, lease.holder))
            && !(must_be_empty && is_full())
    }

    /// Whether it makes no difference which of two resources a behavior gets.
    fn is_alike(&self, leaf: NodeId, one: ResourceId, other: ResourceId) -> bool {
        let holders = |resource| {
            let leases = self.leases.iter().filter(move |lease| lease.resource == resource);
            leases.filter(|lease| self.is_in_line(leaf, lease.holder)).map(|lease| lease.holder)
        };
        self.needs.class[one.index()] == self.needs.class[other.index()]
            && self.content[one.index()].is_none()
            && self.content[other.index()].is_none()
            && holders(one).eq(holders(other))
    }

    /// Runs a behavior to its end, as it is served best; false where it is not its turn or nothing serves it.
    pub(super) fn run(&mut self, leaf: NodeId) -> bool {
        if !self.is_open(leaf) {
            return false;
        }
        let ways = self.ways_to_serve(leaf, 1);
        let is_served = !ways.is_empty();
        ways.into_iter().for_each(|served| self.run_with(leaf, &served));
        is_served
    }

    /// Runs a behavior to its end, served so.
    pub(super) fn run_with(&mut self, leaf: NodeId, served: &Served) {
        let mut child = leaf;
        for node in self.needs.topology.path(leaf).skip(1).take_while(|node| *node >= TOP) {
            if self.needs.kind(node) == Kind::One {
                self.ways.insert(node, child);
            }
            child = node;
        }
        let spec = self.needs.leaf(leaf).expect("only those are run that need something");
        self.end(leaf, spec, served);
    }

    fn end(&mut self, leaf: NodeId, spec: &LeafNeeds, served: &Served) {
        let topology = &self.needs.topology;
        for (need, resource) in std::iter::zip(&spec.needs, served) {
            let Some(resource) = *resource else { continue };
            self.leases.retain(|lease| lease.resource != resource || !topology.is_within(leaf, lease.holder));
            if let Some(access) = need.keep.filter(|_| self.needs.is_kept[resource.index()]) {
                self.leases.push(Kept { resource, holder: leaf, behavior: leaf, access });
            }
        }
        for object in &spec.puts {
            for resource in (0..self.content.len()).map(ResourceId::from) {
                if self.content(resource) == Some(*object) {
                    self.empty(resource);
                }
            }
        }
        for need in &spec.lets_go {
            if let Some(Some(resource)) = served.get(*need) {
                self.empty(*resource);
            }
        }
        for (object, need) in &spec.takes {
            if let Some(Some(resource)) = served.get(*need) {
                self.content[resource.index()] = Some(*object);
            }
        }
        self.complete(leaf);
    }

    fn empty(&mut self, resource: ResourceId) {
        self.content[resource.index()] = None;
        self.leases.retain(|lease| lease.resource != resource);
    }

    /// A behavior is done, and what is done with it; kept leases go where the semantics says.
    fn complete(&mut self, leaf: NodeId) {
        let needs = self.needs;
        let (slots, topology) = (&needs.slots, &needs.topology);
        self.is_complete[slots.of(leaf)] = true;
        let mut top = leaf;
        while top > TOP {
            let parent = topology.parent(top);
            if !self.is_over(parent) {
                let left = &mut self.left[slots.of(parent)];
                *left = left.saturating_sub(1);
                if *left > 0 {
                    break;
                }
                self.is_complete[slots.of(parent)] = true;
            }
            top = parent;
        }
        if top == TOP {
            self.leases.clear();
            return;
        }
        // A task that comes and goes keeps nothing when it is over.
        if topology.parent(top) == topology.stem() {
            self.leases.retain(|lease| !topology.is_within(lease.holder, top));
            return;
        }
        let heir = self.heir(top);
        for lease in &mut self.leases {
            if topology.is_within(lease.holder, top) {
                lease.holder = heir;
            }
        }
    }

    /// Who holds what a complete node holds: a THEN above that goes on, else the topmost node that is complete with it.
    fn heir(&self, node: NodeId) -> NodeId {
        let mut top = node;
        while top > TOP && self.is_over(self.needs.topology.parent(top)) {
            top = self.needs.topology.parent(top);
        }
        let parent = self.needs.topology.parent(top);
        if self.needs.kind(parent) == Kind::InOrder { parent } else { top }
    }

    /// Whether as much is free as in `before`, of which it came, and nothing is full that was not.
    pub(super) fn is_no_worse(&self, before: &Self) -> bool {
        let was_kept = |lease: &Kept| {
            let same = |other: &&Kept| other.resource == lease.resource && other.behavior == lease.behavior;
            before.leases.iter().any(|other| same(&other))
        };
        let contents = std::iter::zip(&self.content, &before.content);
        self.leases.iter().all(was_kept) && contents.into_iter().all(|(now, then)| now.is_none() || now == then)
    }

    /// The same for two moments from which the same can follow.
    pub(super) fn key(&self) -> Vec<u32> {
        let leaves = self.needs.nodes.iter().filter(|node| self.needs.kind(**node) == Kind::Leaf);
        let mut key = Vec::new();
        for (index, leaf) in leaves.enumerate() {
            if index % 32 == 0 {
                key.push(0);
            }
            let bits = key.last_mut().expect("one was pushed");
            *bits |= u32::from(self.is_over(*leaf)) << (index % 32);
        }
        let mut resources: Vec<Vec<u32>> = (0..self.content.len())
            .map(|index| {
                let channel = |access: Access| access.channel().map_or(u32::MAX, |channel| channel.0);
                let leases = self.leases.iter().filter(|lease| lease.resource.index() == index);
                let mut holders: Vec<[u32; 2]> = leases.map(|lease| [lease.holder.0, channel(lease.access)]).collect();
                holders.sort_unstable();
                let content = self.content[index].map_or(u32::MAX, |object| object.0);
                [vec![self.needs.class[index].0, content, holders.len() as u32], holders.concat()].concat()
            })
            .collect();
        resources.sort_unstable();
        key.extend(resources.concat());
        key
    }
}

fn served(spec: &LeafNeeds, grant: &Grant) -> Served {
    spec.needs.iter().map(|need| grant.bindings.get(need.claim).map(|binding| binding.resource)).collect()
}
