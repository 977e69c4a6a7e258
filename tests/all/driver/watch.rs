//! What must always hold (`semantics` 7), looked at after every input that a node has handled.

use std::collections::{BTreeMap, BTreeSet};

use ambidex::model::{
    Access, Consequences, End, Goal, Grant, LeaseKind, MissionEnd, MissionSpec, NodeId, NodeKind, NodeRange, Reason,
    Record, ResourceTable, Retention, Told, WorldState,
};
use ambidex::tree::{Down, Input, Root, Up};

/// Follows a run from outside.
pub struct Watch {
    mission: MissionSpec,
    before: Option<(ResourceTable, WorldState)>,
    /// Nodes that were activated and have not answered.
    unanswered: BTreeSet<NodeId>,
    /// Leaves that asked in this round.
    asking: BTreeSet<NodeId>,
    done: BTreeSet<NodeId>,
    failed: BTreeSet<NodeId>,
    granted: BTreeMap<NodeId, Grant>,
    /// Nothing is granted or refused any more; there is no reason for "the mission is being canceled".
    is_canceling: bool,
    /// Resources that a behavior may have left a lease on by an earlier success.
    left: BTreeSet<(NodeId, u32)>,
}

impl Watch {
    pub fn new(mission: &MissionSpec) -> Self {
        Self {
            mission: mission.clone(),
            before: None,
            unanswered: BTreeSet::new(),
            asking: BTreeSet::new(),
            done: BTreeSet::new(),
            failed: BTreeSet::new(),
            granted: BTreeMap::new(),
            is_canceling: false,
            left: BTreeSet::new(),
        }
    }

    /// The tree is another one.
    pub fn know(&mut self, mission: &MissionSpec) {
        self.mission = mission.clone();
    }

    pub fn given(&mut self, node: NodeId, input: &Input) {
        match input {
            Input::Ended(_) => {
                let is_granted = self.granted.contains_key(&node);
                assert!(is_granted, "{node:?} ran without a grant");
            }
            Input::Told(told) => self.is_canceling |= matches!(**told, Told::End { .. }),
            Input::Observed(_) | Input::Turn => {}
            Input::Down(_) | Input::Up(..) => {}
        }
    }

    pub fn said_down(&mut self, child: NodeId, down: &Down) {
        match down {
            Down::Activation(_) => {
                assert!(self.unanswered.insert(child), "{child:?} is asked twice");
            }
            Down::Verdict(verdict) => {
                assert!(!self.unanswered.contains(&child), "{child:?} is judged before it answered");
                let starts = verdict.topology.within(child, &verdict.granted).next().is_some();
                let stops = verdict.topology.of_set(child, &verdict.stopped).next().is_some();
                assert!(starts || stops, "{child:?} hears a verdict that is not about it");
            }
        }
    }

    pub fn said_up(&mut self, node: NodeId, up: &Up) {
        if let Up::Answer { answer, .. } = up {
            assert!(self.unanswered.remove(&node), "{node:?} answers unasked, or twice");
            if answer.requests.iter().any(|request| request.leaf == node) {
                self.asking.insert(node);
            }
        }
    }

    pub fn recorded(&mut self, record: &Record) {
        match record {
            Record::Decided { granted, refused, reopened, .. } => {
                for leaf in std::mem::take(&mut self.asking) {
                    let is_granted = granted.iter().any(|grant| grant.leaf() == leaf);
                    let is_refused = refused.iter().any(|blocked| blocked.leaf == leaf);
                    assert!(
                        is_granted != is_refused || self.is_canceling,
                        "{leaf:?} asked: granted {is_granted}, refused {is_refused}"
                    );
                }
                for blocked in refused {
                    assert!(!blocked.reason.sentence(&self.mission.names).contains('?'), "{blocked:?}");
                }
                for blocked in refused {
                    if let Reason::Outbid { by, .. } | Reason::WholeRobot { by } = blocked.reason {
                        let wins = self.granted.contains_key(&by) || granted.iter().any(|grant| grant.leaf() == by);
                        assert!(wins, "{blocked:?}: the other one did not get it either");
                    }
                }
                granted.iter().for_each(|grant| self.skip(grant));
                granted.iter().for_each(|grant| self.start(grant));
                if let Some(reopened) = reopened {
                    let kept = reopened.ended.iter().map(|kept| (kept.behavior, kept.holder));
                    for (mut node, up_to) in kept.chain([(reopened.node, reopened.up_to)]) {
                        while node != up_to {
                            self.done.remove(&node);
                            node = self.mission.tree.topology.parent(node);
                        }
                    }
                }
            }
            Record::Released { leaf, end, consequences, .. } => self.release(*leaf, *end, consequences),
            Record::Added { .. } | Record::Removed { .. } | Record::Granting { .. } => {}
            Record::Canceled { .. } | Record::TaskEnded { .. } | Record::Stalled { .. } => {}
            Record::ObjectAdded { .. }
            | Record::ObjectRemoved { .. }
            | Record::Declined { .. }
            | Record::Checkpoint { .. } => {}
            Record::Told { .. } | Record::Observed { .. } | Record::Turn { .. } | Record::Began { .. } => {}
            Record::Header(_) | Record::Stopped { .. } | Record::Sent { .. } => {}
            Record::World { .. } | Record::Denied { .. } => {}
            Record::Resource { .. } | Record::Woke { .. } | Record::Served { .. } | Record::Awaited { .. } => {}
            Record::Controller { .. } | Record::Ended { .. } => {}
            Record::Infeasible { consequences, .. } | Record::TimedOut { consequences, .. } => self.fail(consequences),
            Record::Reopened { reopened, .. } => {
                for node in &reopened.reset {
                    self.done.remove(node);
                    self.failed.remove(node);
                }
            }
            Record::Overtaken { skips, goal, consequences, .. } => {
                self.overtake(skips, *goal, consequences);
            }
            Record::Ending { .. } | Record::Leaving { .. } | Record::Cleaning { .. } => {}
            Record::Cleaned { consequences, .. } => self.fail(consequences),
        }
    }

    pub fn rested(&mut self) {
        assert!(self.unanswered.is_empty(), "never answered: {:?}", self.unanswered);
    }

    /// The table, the world and what runs, against each other and against what was granted.
    pub fn check(&mut self, handled: NodeId, root: &Root, goals: &BTreeMap<NodeId, Goal>, end: Option<MissionEnd>) {
        let now = (&**root.state().table(), root.state().world());
        if handled != NodeId(0) {
            let before = self.before.as_ref().expect("root began");
            assert!((&before.0, &before.1) == now, "{handled:?} wrote what is root's");
            assert!(goals.keys().all(|leaf| self.granted.contains_key(leaf)), "runs without a grant");
            return;
        }
        self.before = Some((now.0.clone(), now.1.clone()));
        let running = root.state().running();
        assert!(running.keys().eq(self.granted.keys()), "{running:?} is not what was granted");
        for (leaf, goal) in goals {
            let grant = running.get(leaf).expect("no leaf runs without a grant");
            for part in &goal.parts {
                let mut bindings = grant.bindings.iter();
                assert!(bindings.any(|binding| binding.resource == part.resource && binding.access == part.access));
            }
        }
        running.values().for_each(|grant| self.check_alone(grant, root));
        self.check_leases(root);
        if end == Some(MissionEnd::Done) {
            assert_eq!(root.state().table().leases().count(), 0, "a complete task leaves none");
            assert!(running.is_empty());
        }
    }

    fn check_alone(&self, grant: &Grant, root: &Root) {
        for other in root.state().running().values().filter(|other| other.leaf() != grant.leaf()) {
            let both = other.request.changes.iter().find(|object| grant.request.changes.contains(object));
            assert!(both.is_none(), "{both:?} is changed by {:?} and {:?}", grant.leaf(), other.leaf());
            for (a, b) in grant.bindings.iter().flat_map(|a| other.bindings.iter().map(move |b| (a, b))) {
                let shares = a.access == b.access && a.access != Access::Exclusive;
                assert!(a.resource != b.resource || shares, "{a:?} and {b:?} go on at once");
            }
        }
        for binding in &grant.bindings {
            let resource = root.state().table().resource(binding.resource);
            assert_eq!(resource.access(), Some(binding.access), "{:?}", grant.leaf());
            let mut leases = resource.leases().iter();
            assert!(leases.any(|lease| lease.holder == grant.leaf() && lease.kind == LeaseKind::Running));
        }
    }

    fn check_leases(&self, root: &Root) {
        for (id, lease) in root.state().table().leases() {
            let is_known = match lease.kind {
                LeaseKind::Running => self.granted.contains_key(&lease.behavior) && lease.holder == lease.behavior,
                LeaseKind::Intention => {
                    let kind = &self.mission.tree.nodes[lease.holder.index()];
                    *kind == NodeKind::Then
                        && !self.done.contains(&lease.holder)
                        && self.may_leave(lease.behavior, id.0)
                }
                LeaseKind::Physical => {
                    self.may_leave(lease.behavior, id.0) || root.state().world().held_by(id).is_some()
                }
            };
            assert!(is_known, "nobody keeps {lease:?} on {id:?}");
        }
        for (id, resource) in root.state().table().iter() {
            let sound = match resource.access() {
                None => resource.owners() == 0,
                Some(Access::Exclusive) => resource.owners() == 1,
                Some(Access::Shared(_)) => resource.owners() > 0,
            };
            assert!(sound, "{id:?}: {resource:?}");
        }
    }

    fn may_leave(&self, behavior: NodeId, resource: u32) -> bool {
        self.left.contains(&(behavior, resource))
    }

    fn skip(&mut self, grant: &Grant) {
        let topology = &self.mission.tree.topology;
        for skip in &grant.request.skips {
            let then = topology.parent(skip.from);
            assert_eq!(self.mission.tree.nodes[then.index()], NodeKind::Then, "only a THEN skips");
            let skipped = topology.children(then).filter(|child| skip.contains(*child));
            self.done.extend(skipped);
        }
    }

    fn start(&mut self, grant: &Grant) {
        let topology = &self.mission.tree.topology;
        let mut child = grant.leaf();
        while child.0 > 0 {
            let node = topology.parent(child);
            assert!(!self.done.contains(&child), "{child:?} is done and runs again");
            assert!(!self.failed.contains(&child), "{child:?} has failed and runs again");
            match self.mission.tree.nodes[node.index()] {
                NodeKind::Then => {
                    let mut before = topology.children(node).take_while(|&other| other != child);
                    assert!(before.all(|other| self.done.contains(&other)), "{child:?} is before its turn");
                    let mut others = topology.children(node).filter(|&other| other != child);
                    assert!(!others.any(|other| self.is_busy(other)), "two children of {node:?} at once");
                }
                NodeKind::Or => {
                    let mut others = topology.children(node).filter(|&other| other != child);
                    let busy = others.find(|&other| self.done.contains(&other) || self.is_busy(other));
                    assert_eq!(busy, None, "beside {child:?} of an OR");
                }
                // Whatever a cleanup is for has failed, or is given up.
                NodeKind::Cleanup if topology.is_cleanup(child) => {
                    assert!(!self.is_busy(NodeId(node.0 + 1)), "{child:?} runs beside what it cleans up");
                    break;
                }
                NodeKind::Root | NodeKind::And | NodeKind::Tasks | NodeKind::Cleanup => {}
                NodeKind::Behavior(_) => unreachable!("behaviors have no children"),
            }
            child = node;
        }
        let before = self.granted.insert(grant.leaf(), grant.clone());
        assert!(before.is_none(), "{:?} is granted while it runs", grant.leaf());
    }

    /// Whether something below a node runs in the eyes of root.
    fn is_busy(&self, node: NodeId) -> bool {
        self.mission.tree.topology.within(node, &self.granted).next().is_some()
    }

    fn release(&mut self, leaf: NodeId, end: End, consequences: &Consequences) {
        let grant = self.granted.remove(&leaf).expect("only what was granted ends");
        let keeps = |keep| !matches!(keep, Retention::Release);
        for binding in &grant.bindings {
            if end == End::Succeeded && keeps(binding.keep) {
                self.left.insert((leaf, binding.resource.0));
            } else {
                self.left.remove(&(leaf, binding.resource.0));
            }
        }
        assert_eq!(end == End::Succeeded, consequences.completed.is_some());
        self.complete(leaf, consequences);
        self.fail(consequences);
    }

    fn fail(&mut self, consequences: &Consequences) {
        if let Some(node) = consequences.cleaned {
            let cleanup = self.mission.tree.topology.children(node).last().expect("it has a cleanup");
            for below in self.mission.tree.topology.nodes_below(cleanup) {
                self.done.remove(&below);
                self.failed.remove(&below);
            }
        }
        self.failed.extend(consequences.failed);
        // It waits for what runs below it, and starts nothing more, unless it finishes what it can.
        let failing = consequences.failing.filter(|failing| !failing.finishes);
        self.failed.extend(failing.map(|failing| failing.node));
    }

    fn overtake(&mut self, skips: &[NodeRange], goal: NodeId, consequences: &Consequences) {
        let topology = &self.mission.tree.topology;
        let is_skipped = |node: &NodeId| skips.iter().any(|skip| skip.contains(*node));
        assert!(!self.granted.keys().any(is_skipped), "what runs is passed over");
        self.done.extend(topology.children(topology.parent(goal)).filter(is_skipped));
        self.complete(goal, consequences);
        self.fail(consequences);
    }

    fn complete(&mut self, from: NodeId, consequences: &Consequences) {
        let Some(completed) = consequences.completed else {
            return;
        };
        let topology = &self.mission.tree.topology;
        let mut node = from;
        self.done.insert(from);
        while node != completed.node {
            node = topology.parent(node);
            let done = || topology.children(node).filter(|child| self.done.contains(child)).count();
            match self.mission.tree.nodes[node.index()] {
                NodeKind::And | NodeKind::Tasks | NodeKind::Then => {
                    assert_eq!(done(), topology.children(node).count(), "{node:?} is complete too early");
                }
                NodeKind::Or | NodeKind::Cleanup => assert_eq!(done(), 1, "{node:?} has one child done"),
                NodeKind::Root | NodeKind::Behavior(_) => unreachable!("completes no child"),
            }
            self.done.insert(node);
        }
        if let Some(heir) = completed.heir {
            assert_eq!(self.mission.tree.nodes[heir.index()], NodeKind::Then, "only a THEN inherits");
        }
    }
}
