//! What a leaf can read of the state, known when the tree is built, since kinds are closed terms; and which nodes a change
//! touches. What was not touched since it answered would say the same again, and is not asked.

use std::collections::BTreeSet;
use std::sync::Arc;

use ambidex_model::state::{Chunks, State};
use ambidex_model::{
    Cause, Change, Condition, LeaseKind, Location, MissionSpec, NodeId, ObjectId, Potential, Record, ResourceId,
    Selector, Task,
};

/// Leaves by what they read, each list in tree order; a leaf may stand in it several times.
#[derive(Debug, Default)]
struct Topics {
    /// Whether a resource is held, by whom and how, and whether something is in it.
    resource: Vec<Vec<NodeId>>,
    /// Where an object is, and whether somebody changes it.
    object: Vec<Vec<NodeId>>,
    /// Whether a fact holds.
    fact: Vec<Vec<NodeId>>,
    /// Where the base is.
    base: Vec<NodeId>,
    /// Who drives the base.
    driver: Vec<NodeId>,
}

/// When each node was touched last.
#[derive(Debug)]
pub(super) struct Touches {
    mission: Arc<MissionSpec>,
    topics: Topics,
    rounds: Rounds,
    /// Behaviors that do not ask before there is progress.
    barred: BTreeSet<NodeId>,
}

/// By node the first round that has to ask it again.
#[derive(Debug)]
struct Rounds {
    mission: Arc<MissionSpec>,
    by_node: Chunks<u32>,
    /// The round that is next.
    next: u32,
}

impl Rounds {
    /// Leaves, each with all that is above it.
    fn touch(&mut self, leaves: impl IntoIterator<Item = NodeId>) {
        for leaf in leaves {
            for node in self.mission.tree.topology.path(leaf) {
                if *self.by_node.get(node.index()) == self.next {
                    break;
                }
                *self.by_node.get_mut(node.index()) = self.next;
            }
        }
    }
}

impl Touches {
    pub(super) fn new(mission: &Arc<MissionSpec>) -> Self {
        let mut topics = Topics {
            resource: vec![Vec::new(); mission.robot.resources.len()],
            object: vec![Vec::new(); mission.start.objects.len()],
            fact: vec![Vec::new(); mission.start.facts.len()],
            ..Topics::default()
        };
        for leaf in mission.tree.leaves() {
            topics.add(mission, leaf);
        }
        let by_node = Chunks::new(mission.tree.nodes.len());
        let rounds = Rounds { mission: Arc::clone(mission), by_node, next: 0 };
        Self { mission: Arc::clone(mission), topics, rounds, barred: BTreeSet::new() }
    }

    /// By node the first round that has to ask it again.
    pub(super) fn rounds(&self) -> &Chunks<u32> {
        &self.rounds.by_node
    }

    /// Takes note of what a record has changed.
    pub(super) fn note(&mut self, before: &State, after: &State, record: &Record) {
        self.rounds.next = after.round() + 1;
        self.note_table(before, after);
        if before.world().base != after.world().base {
            self.rounds.touch(self.topics.base.iter().copied());
        }
        if before.progress() != after.progress() {
            self.rounds.touch(self.barred.iter().copied());
        }
        match record {
            Record::Began { .. } => self.rounds.touch(self.mission.tree.leaves()),
            Record::World { change, .. } | Record::Observed { change, .. } => self.note_change(before, *change),
            Record::Decided { granted, reopened, .. } => {
                for leaf in granted.iter().map(|grant| grant.leaf()) {
                    self.barred.remove(&leaf);
                    self.note_running(leaf);
                }
                if let Some(reopened) = reopened {
                    if let Cause::Lapse { .. } = reopened.cause {
                        self.barred.insert(reopened.node);
                    }
                    self.rounds.touch([reopened.node]);
                }
            }
            Record::Released { leaf, changes, .. } => {
                self.note_running(*leaf);
                changes.iter().for_each(|change| self.note_change(before, *change));
            }
            Record::Header(_) | Record::Told { .. } | Record::Turn { .. } | Record::Stopped { .. } => {}
            Record::Sent { .. } | Record::Resource { .. } | Record::Controller { .. } | Record::Ended { .. } => {}
        }
    }

    /// Whoever reads a resource, or is to inherit it.
    fn note_table(&mut self, before: &State, after: &State) {
        for ((id, old), (_, new)) in std::iter::zip(before.table().iter(), after.table().iter()) {
            if old == new {
                continue;
            }
            self.touch_resource(id);
            for object in [before, after].into_iter().filter_map(|state| state.world().held_by(id)) {
                self.touch_object(object);
            }
            let leases = old.leases().iter().chain(new.leases());
            for lease in leases.filter(|lease| lease.kind == LeaseKind::Intention) {
                let below = (lease.holder.0..after.topology().end(lease.holder).0).map(NodeId);
                self.rounds.touch(below.filter(|node| self.mission.tree.behavior(*node).is_some()));
            }
        }
    }

    fn note_change(&mut self, before: &State, change: Change) {
        match change {
            Change::Base(_) => {}
            Change::Fact(fact, _) => self.rounds.touch(self.topics.fact[fact.index()].iter().copied()),
            Change::Emptied(gripper) => self.touch_contents(before, gripper),
            Change::Object(object, to) => {
                for at in [before.world().objects[object.index()], to] {
                    if let Location::In(gripper) = at {
                        self.touch_contents(before, gripper);
                    }
                }
                self.touch_object(object);
            }
        }
    }

    fn touch_contents(&mut self, before: &State, gripper: ResourceId) {
        self.touch_resource(gripper);
        if let Some(held) = before.world().held_by(gripper) {
            self.touch_object(held);
        }
    }

    /// A behavior runs now, or does no more.
    fn note_running(&mut self, leaf: NodeId) {
        self.rounds.touch([leaf]);
        let Some(spec) = self.mission.tree.behavior(leaf) else { return };
        for object in &spec.changes {
            self.rounds.touch(self.topics.object[object.index()].iter().copied());
        }
        if spec.commands.iter().any(|term| matches!(term.task, Task::DriveTo(_))) {
            self.rounds.touch(self.topics.driver.iter().copied());
        }
    }

    fn touch_resource(&mut self, resource: ResourceId) {
        self.rounds.touch(self.topics.resource[resource.index()].iter().copied());
    }

    fn touch_object(&mut self, object: ObjectId) {
        self.rounds.touch(self.topics.object[object.index()].iter().copied());
    }
}

impl Topics {
    fn add(&mut self, mission: &MissionSpec, leaf: NodeId) {
        let Some(spec) = mission.tree.behavior(leaf) else { return };
        for claim in &spec.claims {
            for resource in mission.robot.could_serve(claim.selector, &[]) {
                self.resource[resource.index()].push(leaf);
            }
            match claim.selector {
                Selector::Holding(object) => self.read_object(leaf, object),
                Selector::AnyEmpty { reaches: Some(object), .. } | Selector::Empty { reaches: Some(object), .. } => {
                    self.read_object(leaf, object);
                    self.base.push(leaf);
                }
                Selector::AnyEmpty { reaches: None, .. } | Selector::Empty { reaches: None, .. } => {}
                Selector::Named(_) | Selector::Any(_) => {}
            }
        }
        let scale_by = match spec.potential {
            Potential::Constant(_) => None,
            Potential::Scaled { by, .. } => Some(by),
            Potential::Nearness { scale_by, .. } => {
                self.base.push(leaf);
                scale_by
            }
        };
        for resource in scale_by.into_iter().flat_map(|of| mission.robot.of_type(of)) {
            self.resource[resource.index()].push(leaf);
        }
        self.read_condition(leaf, &spec.satisfied);
        self.read_condition(leaf, &spec.precondition);
        spec.changes.iter().for_each(|object| self.read_object(leaf, *object));
        for term in &spec.commands {
            match term.task {
                Task::Grasp(object) | Task::Put(object, _) => self.read_object(leaf, object),
                Task::DriveTo(_) | Task::Stand | Task::LookAt(_) => {}
            }
        }
    }

    fn read_object(&mut self, leaf: NodeId, object: ObjectId) {
        self.object[object.index()].push(leaf);
    }

    fn read_condition(&mut self, leaf: NodeId, condition: &Condition) {
        match condition {
            Condition::All(parts) => parts.iter().for_each(|part| self.read_condition(leaf, part)),
            Condition::Never => {}
            Condition::At { .. } => {
                self.base.push(leaf);
                self.driver.push(leaf);
            }
            Condition::Path { .. } => self.base.push(leaf),
            Condition::Held(object) | Condition::Free(object) | Condition::Lies(object, _) => {
                self.read_object(leaf, *object);
            }
            Condition::Fact(fact, _) => self.fact[fact.index()].push(leaf),
        }
    }
}
