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
    topics: Arc<Topics>,
    /// By node the first round that has to ask it again.
    rounds: Chunks<u32>,
    /// Behaviors that do not ask before there is progress.
    barred: BTreeSet<NodeId>,
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
        let rounds = Chunks::new(mission.tree.nodes.len());
        Self { mission: Arc::clone(mission), topics: Arc::new(topics), rounds, barred: BTreeSet::new() }
    }

    /// By node the first round that has to ask it again.
    pub(super) fn rounds(&self) -> &Chunks<u32> {
        &self.rounds
    }

    /// Takes note of what a record has changed.
    pub(super) fn note(&mut self, before: &State, after: &State, record: &Record) {
        let round = after.round() + 1;
        let topics = Arc::clone(&self.topics);
        self.note_table(round, before, after);
        if before.world().base != after.world().base {
            self.touch_all(round, topics.base.iter().copied());
        }
        if before.progress() != after.progress() {
            let barred = std::mem::take(&mut self.barred);
            self.touch_all(round, barred.iter().copied());
            self.barred = barred;
        }
        match record {
            Record::Began { .. } => {
                let mission = Arc::clone(&self.mission);
                self.touch_all(round, mission.tree.leaves());
            }
            Record::World { change, .. } | Record::Observed { change, .. } => self.note_change(round, before, *change),
            Record::Decided { granted, reopened, .. } => {
                for leaf in granted.iter().map(|grant| grant.leaf()) {
                    self.barred.remove(&leaf);
                    self.note_running(round, leaf);
                }
                if let Some(reopened) = reopened {
                    if let Cause::Lapse { .. } = reopened.cause {
                        self.barred.insert(reopened.node);
                    }
                    self.touch(round, reopened.node);
                }
            }
            Record::Released { leaf, changes, .. } => {
                self.note_running(round, *leaf);
                changes.iter().for_each(|change| self.note_change(round, before, *change));
            }
            Record::Header(_) | Record::Told { .. } | Record::Turn { .. } | Record::Stopped { .. } => {}
            Record::Sent { .. } | Record::Resource { .. } | Record::Controller { .. } | Record::Ended { .. } => {}
        }
    }

    /// Whoever reads a resource, or is to inherit it.
    fn note_table(&mut self, round: u32, before: &State, after: &State) {
        for ((id, old), (_, new)) in std::iter::zip(before.table().iter(), after.table().iter()) {
            if old == new {
                continue;
            }
            self.touch_resource(round, id);
            for object in [before, after].into_iter().filter_map(|state| state.world().held_by(id)) {
                self.touch_object(round, object);
            }
            let intentions = old.leases().iter().chain(new.leases()).filter(|lease| lease.kind == LeaseKind::Intention);
            for holder in intentions.map(|lease| lease.holder).collect::<Vec<_>>() {
                for node in (holder.0..after.topology().end(holder).0).map(NodeId) {
                    if self.mission.tree.behavior(node).is_some() {
                        self.touch(round, node);
                    }
                }
            }
        }
    }

    fn note_change(&mut self, round: u32, before: &State, change: Change) {
        let world = before.world();
        match change {
            Change::Base(_) => {}
            Change::Fact(fact, _) => {
                let topics = Arc::clone(&self.topics);
                self.touch_all(round, topics.fact[fact.index()].iter().copied());
            }
            Change::Emptied(gripper) => self.touch_contents(round, before, gripper),
            Change::Object(object, to) => {
                for at in [world.objects[object.index()], to] {
                    if let Location::In(gripper) = at {
                        self.touch_contents(round, before, gripper);
                    }
                }
                self.touch_object(round, object);
            }
        }
    }

    fn touch_contents(&mut self, round: u32, before: &State, gripper: ResourceId) {
        self.touch_resource(round, gripper);
        if let Some(held) = before.world().held_by(gripper) {
            self.touch_object(round, held);
        }
    }

    /// A behavior runs now, or does no more.
    fn note_running(&mut self, round: u32, leaf: NodeId) {
        self.touch(round, leaf);
        let mission = Arc::clone(&self.mission);
        let Some(spec) = mission.tree.behavior(leaf) else { return };
        spec.changes.iter().for_each(|object| self.touch_object(round, *object));
        if spec.commands.iter().any(|term| matches!(term.task, Task::DriveTo(_))) {
            let topics = Arc::clone(&self.topics);
            self.touch_all(round, topics.driver.iter().copied());
        }
    }

    fn touch_resource(&mut self, round: u32, resource: ResourceId) {
        let topics = Arc::clone(&self.topics);
        self.touch_all(round, topics.resource[resource.index()].iter().copied());
    }

    fn touch_object(&mut self, round: u32, object: ObjectId) {
        let topics = Arc::clone(&self.topics);
        self.touch_all(round, topics.object[object.index()].iter().copied());
    }

    /// Leaves, each with all that is above it.
    fn touch_all(&mut self, round: u32, leaves: impl IntoIterator<Item = NodeId>) {
        for leaf in leaves {
            for node in self.mission.tree.topology.path(leaf) {
                if *self.rounds.get(node.index()) == round {
                    break;
                }
                *self.rounds.get_mut(node.index()) = round;
            }
        }
    }

    fn touch(&mut self, round: u32, leaf: NodeId) {
        self.touch_all(round, [leaf]);
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
