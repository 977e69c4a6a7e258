//! What a leaf can read of the state, known when the tree is built, since kinds are closed terms; and which nodes a change
//! touches. What was not touched since it answered would say the same again, and is not asked.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use super::{TOP, ahead, fairness};
use crate::world::Bodies;
use ambidex_model::state::{Chunks, State};
use ambidex_model::{
    BehaviorSpec, Cause, Change, Condition, EffectTerm, FactId, LeaseKind, Location, MissionSpec, NodeId, NodeKind,
    ObjectId, PlaceId, Potential, Record, ResourceId, Selector, Task,
};

/// Something that a leaf can read.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Topic {
    /// Whether a resource is held, by whom and how, and whether something is in it.
    Resource(ResourceId),
    /// Where an object is, and whether somebody changes it.
    Object(ObjectId),
    /// What lies at a place, and what is being put there.
    Place(PlaceId),
    /// Whether a fact holds.
    Fact(FactId),
    /// Where the base is.
    Base,
    /// Who drives the base.
    Driver,
    /// Whose arms move, where these have bodies that are in each other's way, and who brings the base.
    Bodies,
    /// What is kept for a node, by all below it.
    Intention(NodeId),
    /// Whether there was progress, by those that do not ask before, or not for everything.
    Progress,
    /// What has come of the leaf itself.
    Own(NodeId),
}

/// Whom a round has to ask, of what was touched since the last one.
#[derive(Debug)]
pub(super) struct Touches {
    mission: Arc<MissionSpec>,
    /// Leaves by what they read, each list in tree order.
    topics: BTreeMap<Topic, Vec<NodeId>>,
    /// The same by leaf: the tree around it may be another one when it goes.
    read: BTreeMap<NodeId, Vec<Topic>>,
    /// Behaviors that do not ask before there is progress, or not for everything.
    barred: BTreeSet<NodeId>,
    /// Whether a node is in `touched`.
    is_touched: Chunks<bool>,
    touched: Vec<NodeId>,
    unheard: fn(Topic) -> bool,
}

impl Touches {
    pub(super) fn new(mission: &Arc<MissionSpec>, unheard: fn(Topic) -> bool) -> Self {
        let (topics, barred, is_touched) = (BTreeMap::new(), BTreeSet::new(), Chunks::default());
        let (mission, touched, read) = (Arc::clone(mission), Vec::new(), BTreeMap::new());
        let mut touches = Self { mission: Arc::clone(&mission), topics, read, barred, is_touched, touched, unheard };
        mission.tree.leaves().for_each(|leaf| touches.hear(leaf));
        touches
    }

    /// A leaf is asked again when what it reads has become different.
    fn hear(&mut self, leaf: NodeId) {
        let (topics, mut read) = (&mut self.topics, Vec::new());
        read_by(&self.mission, leaf, &mut |topic| {
            let readers = topics.entry(topic).or_default();
            if let Err(place) = readers.binary_search(&leaf) {
                readers.insert(place, leaf);
                read.push(topic);
            }
        });
        self.read.entry(leaf).or_default().extend(read);
    }

    /// A leaf is not asked any more.
    fn unhear(&mut self, leaf: NodeId) {
        for topic in self.read.remove(&leaf).unwrap_or_default() {
            let Some(readers) = self.topics.get_mut(&topic) else { continue };
            if let Ok(place) = readers.binary_search(&leaf) {
                readers.remove(place);
            }
            if readers.is_empty() {
                self.topics.remove(&topic);
            }
        }
    }

    /// The tree has a further part.
    pub(super) fn add(&mut self, mission: &Arc<MissionSpec>, top: NodeId) {
        self.know(mission);
        mission.tree.leaves_below(top).into_iter().for_each(|leaf| self.hear(leaf));
        self.touch(Topic::Own(top));
        if let Some(then) = self.touch_thens(top) {
            // Drives read what is asked behind them.
            mission.tree.leaves_below(then).into_iter().for_each(|leaf| self.hear(leaf));
        }
    }

    /// What is asked later in a THEN bears upon what its earlier children ask for; gives the outermost one.
    fn touch_thens(&mut self, changed: NodeId) -> Option<NodeId> {
        let tree = &self.mission.tree;
        let is_then = |node: &NodeId| matches!(tree.nodes[node.index()], NodeKind::Then);
        let outermost = tree.topology.path(changed).skip(1).filter(is_then).last();
        outermost.into_iter().for_each(|then| self.touch_all(then));
        outermost
    }

    /// A part of the tree, of which these are the nodes, is about to go; what stands above it is asked.
    pub(super) fn remove(&mut self, top: NodeId) {
        self.touch_thens(top);
        let mission = Arc::clone(&self.mission);
        let topology = &mission.tree.topology;
        mission.tree.leaves_below(top).into_iter().for_each(|leaf| self.unhear(leaf));
        self.touched.retain(|node| !topology.is_within(*node, top));
        for run in topology.below(top) {
            self.barred.retain(|node| !run.contains(node));
            self.is_touched.forget(run.start.index()..run.end.index());
        }
        self.touch(Topic::Own(topology.parent(top)));
    }

    /// Behaviors that do not ask before there is progress, or not for everything.
    pub(super) fn barred(&self) -> BTreeSet<NodeId> {
        self.barred.clone()
    }

    /// The first round asks everybody.
    pub(super) fn restore(&mut self, barred: BTreeSet<NodeId>) {
        self.barred = barred;
        self.touch_all(NodeId(0));
    }

    /// The mission is another one.
    pub(super) fn know(&mut self, mission: &Arc<MissionSpec>) {
        let least = self.mission.tree.least_priority();
        self.mission = Arc::clone(mission);
        // What went was touched once more as it did.
        for gone in self.touched.extract_if(.., |node| !mission.tree.topology.has(*node)) {
            self.is_touched.forget(gone.index()..gone.index() + 1);
        }
        // Only who is more urgent than somebody has a wish.
        if mission.tree.least_priority() != least {
            self.touch(Topic::Intention(NodeId(0)));
        }
    }

    /// What was touched since this was asked last, in tree order.
    pub(super) fn take(&mut self) -> Arc<[NodeId]> {
        self.touched.sort();
        for node in &self.touched {
            *self.is_touched.get_mut(node.index()) = false;
        }
        self.touched.drain(..).collect()
    }

    /// All that read a topic, each with all that is above it.
    fn touch(&mut self, topic: Topic) {
        if (self.unheard)(topic) {
            return;
        }
        let mut touch = |leaf: NodeId| {
            let from = self.touched.len();
            for node in self.mission.tree.topology.path(leaf) {
                if std::mem::replace(self.is_touched.get_mut(node.index()), true) {
                    break;
                }
                self.touched.push(node);
            }
            // In the order of ids, which sorting makes use of.
            self.touched[from..].reverse();
        };
        match topic {
            Topic::Own(leaf) => touch(leaf),
            Topic::Progress => self.barred.iter().copied().for_each(touch),
            Topic::Intention(holder) => {
                self.mission.tree.leaves_below(holder).into_iter().for_each(touch);
            }
            Topic::Resource(_)
            | Topic::Object(_)
            | Topic::Place(_)
            | Topic::Fact(_)
            | Topic::Base
            | Topic::Driver
            | Topic::Bodies => {
                self.topics.get(&topic).into_iter().flatten().copied().for_each(touch);
            }
        }
    }

    /// A leaf may ask again, or does not any more.
    pub(super) fn note_bar(&mut self, leaf: NodeId) {
        self.touch(Topic::Own(leaf));
    }

    /// A node and everything below it.
    fn touch_all(&mut self, node: NodeId) {
        let mission = Arc::clone(&self.mission);
        mission.tree.topology.nodes_below(node).for_each(|node| self.touch(Topic::Own(node)));
    }

    /// Takes note of what a record has changed.
    pub(super) fn note(&mut self, before: &State, after: &State, record: &Record) {
        if !Arc::ptr_eq(before.table(), after.table()) {
            self.note_table(before, after);
            self.note_tasks(before, after);
        }
        if before.world().base != after.world().base {
            self.touch(Topic::Base);
        }
        if before.progress() != after.progress() {
            self.touch(Topic::Progress);
        }
        match record {
            // The first round asks everybody.
            Record::Began { .. } => {}
            Record::World { change, .. } | Record::Observed { change, .. } => self.note_change(before, *change),
            Record::Decided { .. } => self.note_decision(after, record),
            Record::Released { leaf, changes, unfit, consequences, .. } => {
                self.note_running(*leaf);
                consequences.cleaned.into_iter().for_each(|node| self.touch_all(node));
                if !unfit.is_empty() {
                    self.barred.insert(*leaf);
                }
                changes.iter().for_each(|change| self.note_change(before, *change));
            }
            Record::Woke { leaves, .. } => leaves.iter().for_each(|leaf| self.touch(Topic::Own(*leaf))),
            Record::Infeasible { leaf, .. } => self.touch(Topic::Own(*leaf)),
            Record::TimedOut { node, consequences, .. } => {
                self.touch(Topic::Own(*node));
                consequences.cleaned.into_iter().for_each(|node| self.touch_all(node));
            }
            Record::Reopened { reopened, .. } => {
                self.touch(Topic::Own(reopened.up_to));
                reopened.reset.iter().for_each(|node| self.touch(Topic::Own(*node)));
            }
            Record::Overtaken { goal, consequences, .. } => {
                self.touch(Topic::Own(*goal));
                consequences.cleaned.into_iter().for_each(|node| self.touch_all(node));
            }
            Record::Ending { .. } => self.touch(Topic::Own(TOP)),
            Record::Canceled { task, .. } => self.touch(Topic::Own(*task)),
            Record::Granting { task: Some(task), .. } => self.touch(Topic::Own(*task)),
            Record::Granting { task: None, .. } => {
                after.tasks().keys().for_each(|task| self.touch(Topic::Own(*task)));
            }
            Record::ObjectAdded { object, place, .. } => {
                self.touch(Topic::Object(*object));
                self.touch(Topic::Place(*place));
            }
            Record::ObjectRemoved { object, .. } => {
                self.note_change(before, Change::Object(*object, Location::Unknown))
            }
            // Root says what is added and removed beforehand or afterwards.
            Record::Added { .. } | Record::Removed { .. } | Record::TaskEnded { .. } => {}
            Record::Stalled { .. } | Record::Declined { .. } | Record::Checkpoint { .. } => {}
            Record::Leaving { way, .. } => self.touch(Topic::Own(*way)),
            Record::Cleaning { node, .. } | Record::Cleaned { node, .. } => self.touch_all(*node),
            // Of what is different in the table.
            Record::Served { .. } | Record::Awaited { .. } | Record::Denied { .. } => {}
            Record::Header(_) | Record::Told { .. } | Record::Turn { .. } | Record::Stopped { .. } => {}
            Record::Sent { .. } | Record::Resource { .. } | Record::Controller { .. } | Record::Ended { .. } => {}
        }
    }

    fn note_decision(&mut self, after: &State, record: &Record) {
        let Record::Decided { granted, reopened, urged, overdue, .. } = record else { return };
        // Who is how urgent matters to all that wait.
        if urged.is_some() || overdue.is_some() {
            self.touch(Topic::Intention(NodeId(0)));
        }
        for leaf in granted.iter().map(|grant| grant.leaf()) {
            // What would not do it is asked for again once there is progress.
            if after.unfit(leaf).is_empty() {
                self.barred.remove(&leaf);
            }
            self.note_running(leaf);
        }
        if let Some(reopened) = reopened {
            if let Cause::Lapse { .. } = reopened.cause {
                self.barred.insert(reopened.node);
            }
            self.touch(Topic::Own(reopened.node));
        }
    }

    /// While a task is overdue, it matters to the others whether they hold anything.
    fn note_tasks(&mut self, before: &State, after: &State) {
        if after.overdue().is_empty() {
            return;
        }
        let tree = &self.mission.tree;
        let (held, holding) = (fairness::holding(tree, before), fairness::holding(tree, after));
        for task in held.symmetric_difference(&holding) {
            self.touch(Topic::Intention(*task));
        }
    }

    /// Whoever reads a resource, or is to inherit it.
    fn note_table(&mut self, before: &State, after: &State) {
        for ((id, old), (_, new)) in std::iter::zip(before.table().iter(), after.table().iter()) {
            if old == new {
                continue;
            }
            self.touch(Topic::Resource(id));
            for object in [before, after].into_iter().filter_map(|state| state.world().held_by(id)) {
                self.touch(Topic::Object(object));
            }
            let leases = old.leases().iter().chain(new.leases());
            for lease in leases.filter(|lease| lease.kind == LeaseKind::Intention) {
                self.touch(Topic::Intention(lease.holder));
            }
        }
    }

    fn note_change(&mut self, before: &State, change: Change) {
        if let Some((object, to)) = change.moved() {
            let from = before.world().objects.get(object.index()).copied();
            for place in [from, to].into_iter().flatten().filter_map(|at| at.place()) {
                self.touch(Topic::Place(place));
            }
        }
        match change {
            Change::Base(_) => {}
            Change::Laid(object, place, _) => self.note_change(before, Change::Object(object, Location::At(place))),
            Change::Fact(fact, _) => self.touch(Topic::Fact(fact)),
            // Who reads where it can drive reads where it is.
            Change::Blocked(_) | Change::Cleared(_) => self.touch(Topic::Base),
            Change::Emptied(gripper) => self.touch_contents(before, gripper),
            Change::Object(object, to) => {
                for gripper in before.world().objects[object.index()].holders().iter().chain(to.holders()) {
                    self.touch_contents(before, *gripper);
                }
                self.touch(Topic::Object(object));
            }
            Change::Taken(object, gripper) => {
                self.touch_contents(before, gripper);
                self.touch(Topic::Object(object));
            }
        }
    }

    fn touch_contents(&mut self, before: &State, gripper: ResourceId) {
        self.touch(Topic::Resource(gripper));
        if let Some(held) = before.world().held_by(gripper) {
            self.touch(Topic::Object(held));
        }
    }

    /// A behavior runs now, or does no more.
    fn note_running(&mut self, leaf: NodeId) {
        self.touch(Topic::Own(leaf));
        let mission = Arc::clone(&self.mission);
        let Some(spec) = mission.tree.behavior(leaf) else { return };
        spec.changes.iter().for_each(|object| self.touch(Topic::Object(*object)));
        puts_anywhere(spec).for_each(|place| self.touch(Topic::Place(place)));
        if spec.commands.iter().any(|term| matches!(term.task, Task::DriveTo(..))) {
            self.touch(Topic::Driver);
        }
        let brings = spec.effects.iter().any(|effect| matches!(effect, EffectTerm::Stands(_)));
        if brings || Bodies::matter_to(&mission, spec) {
            self.touch(Topic::Bodies);
        }
    }
}

/// The leaves that read of an object.
pub(super) fn readers_of(mission: &MissionSpec, object: ObjectId) -> Vec<NodeId> {
    let reads = |leaf: &NodeId| {
        let mut is_read = false;
        read_by(mission, *leaf, &mut |topic| is_read |= topic == Topic::Object(object));
        is_read
    };
    mission.tree.leaves().filter(reads).collect()
}

/// What a leaf reads.
fn read_by(mission: &MissionSpec, leaf: NodeId, read: &mut impl FnMut(Topic)) {
    let Some(spec) = mission.tree.behavior(leaf) else { return };
    for claim in &spec.claims {
        if let Selector::Holding { object, .. } = claim.selector {
            // What holds it is read with it.
            read(Topic::Object(object));
            continue;
        }
        for resource in mission.robot.could_serve(claim.selector) {
            read(Topic::Resource(resource));
        }
        match claim.selector {
            Selector::AnyEmpty { reaches: Some(object), .. } | Selector::Empty { reaches: Some(object), .. } => {
                read(Topic::Object(object));
                read(Topic::Base);
            }
            Selector::AnyEmpty { reaches: None, .. } | Selector::Empty { reaches: None, .. } => {}
            Selector::Named(_) | Selector::Any(_) | Selector::Holding { .. } => {}
        }
    }
    if Bodies::matter_to(mission, spec) {
        read(Topic::Bodies);
        read(Topic::Base);
    }
    if spec.anywhere().any(|one| one.stands.is_some()) {
        // Where it is best to stand.
        ahead::objects_behind(mission, leaf).into_iter().for_each(|object| read(Topic::Object(object)));
    }
    let scale_by = match spec.potential {
        Potential::Constant(_) => None,
        Potential::Scaled { by, .. } => Some(by),
        Potential::Nearness { scale_by, .. } => {
            read(Topic::Base);
            scale_by
        }
    };
    for resource in scale_by.into_iter().flat_map(|of| mission.robot.of_type(of)) {
        read(Topic::Resource(resource));
    }
    // Sent back, it is done again until what it makes so is so.
    for effect in &spec.effects {
        match *effect {
            EffectTerm::Stands(_) => {
                read(Topic::Base);
                read(Topic::Driver);
            }
            EffectTerm::Lies(object, _) | EffectTerm::Taken(object, _) | EffectTerm::LetGo(object, _) => {
                read(Topic::Object(object));
            }
            EffectTerm::Fact(fact, _) => read(Topic::Fact(fact)),
        }
    }
    read_condition(&spec.satisfied, read);
    read_condition(&spec.precondition, read);
    spec.changes.iter().for_each(|object| read(Topic::Object(*object)));
    for place in puts_anywhere(spec) {
        read(Topic::Base);
        read(Topic::Place(place));
    }
    read_commands(spec, read);
}

fn read_commands(spec: &BehaviorSpec, read: &mut impl FnMut(Topic)) {
    for term in &spec.commands {
        match term.task {
            Task::Grasp(object) | Task::GraspFrom(object, _) | Task::Put(object, _) | Task::PutInto(object, _) => {
                read(Topic::Object(object))
            }
            Task::DriveTo(..) => {
                read(Topic::Base);
                read(Topic::Driver);
            }
            Task::Stand | Task::LookAt(_) | Task::Call(_) => {}
        }
    }
}

/// Where it puts something down, wherever an object lies that it follows.
fn puts_anywhere(spec: &BehaviorSpec) -> impl Iterator<Item = PlaceId> + '_ {
    spec.anywhere().flat_map(|one| &one.commands).filter_map(|term| term.task.put_at())
}

fn read_condition(condition: &Condition, read: &mut impl FnMut(Topic)) {
    match condition {
        Condition::All(parts) => parts.iter().for_each(|part| read_condition(part, read)),
        Condition::Never => {}
        Condition::At { .. } => {
            read(Topic::Base);
            read(Topic::Driver);
        }
        Condition::Path { .. } => read(Topic::Base),
        Condition::Held(hold) => read(Topic::Object(hold.object)),
        Condition::Free(object) | Condition::Somewhere(object) | Condition::Lies(object, _) => {
            read(Topic::Object(*object))
        }
        Condition::Fact(fact, _) => read(Topic::Fact(*fact)),
    }
}
