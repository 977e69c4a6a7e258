//! Work for a run that works already: what is asked for, whether it can be, and what it makes of the tree (`semantics` 6,
//! "Tasks that come and go").

use std::sync::Arc;

use super::ordering::Ordering;
use super::topics::readers_of;
use super::{Effect, Outbox, Root};
use ambidex_model::state::Phase;
use ambidex_model::{
    Branch, EntryKind, Fragment, Granting, Hindrance, Location, NodeEntry, NodeId, NodeKind, ObjectId, ObjectSpec,
    PlaceId, Record, Source, Submission, TaskEntry, Time, Work, Worked,
};

/// Most nodes of a run that takes work.
pub const NODES_MAX: u32 = 100_000;

impl Root {
    /// How often work was asked for.
    pub fn asked_for(&self) -> u64 {
        self.asked_for
    }

    /// Takes up what is asked for, and tells what came of it.
    pub(super) fn work(&mut self, now: Time, work: Work, out: &mut Outbox) {
        self.asked_for += 1;
        let number = self.asked_for;
        let worked = self.try_work(now, work, out);
        match worked {
            Ok(_) => self.is_wanted = true,
            Err(why) => self.edit(Record::Declined { at: now, number, why }, out),
        }
        out.push(Effect::Worked(number, worked));
    }

    /// The run is over: nothing is taken any more.
    pub(super) fn decline(&mut self, out: &mut Outbox) {
        self.asked_for += 1;
        out.push(Effect::Worked(self.asked_for, Err(Hindrance::Over)));
    }

    fn try_work(&mut self, now: Time, work: Work, out: &mut Outbox) -> Worked {
        if !self.mission.tree.is_standing() {
            return Err(Hindrance::HasMission);
        }
        if self.ending.is_some() {
            return Err(Hindrance::Over);
        }
        match work {
            Work::Submit(submission) => self.submit(now, *submission, out).map(Some),
            Work::Cancel { task } => self.cancel(now, task, out).map(|()| None),
            Work::Grant { task, granting } => self.set_granting(now, task, granting, out).map(|()| None),
            Work::Add { under, behind, branch } => self.add_branch(now, under, behind, branch, out).map(Some),
            Work::Remove { node } => {
                self.can_be_removed(node, false)?;
                self.remove(now, node, out);
                Ok(None)
            }
            Work::Replace { node, branch } => self.replace(now, node, branch, out).map(Some),
            Work::AddObject { name, place } => self.add_object(now, name, place, out).map(|()| None),
            Work::RemoveObject { object } => self.remove_object(now, object, out).map(|()| None),
        }
    }

    fn submit(&mut self, now: Time, submission: Submission, out: &mut Outbox) -> Result<NodeId, Hindrance> {
        let Submission { name, priority, granting, branch } = submission;
        let mut fragment = Fragment::clone(&*self.read(&branch)?);
        let top = NodeId(0);
        fragment.priorities.extend(priority.map(|priority| (top, priority)));
        let name = self.free_name(if name.is_empty() { &fragment.name } else { &name });
        fragment.names[0].clone_from(&name);
        let stem = self.state.stem();
        let behind = self.state.topology().children(stem).count();
        let priority = fragment.priorities.get(&top).copied().unwrap_or_default();
        let task = TaskEntry { name, priority, granting };
        Ok(self.add(now, (stem, behind), (&fragment, branch.source), Some(task), out))
    }

    /// A name that no task has.
    fn free_name(&self, wanted: &str) -> String {
        let is_free = |name: &str| !self.state.tasks().values().any(|task| task.name == name);
        if is_free(wanted) {
            return wanted.to_owned();
        }
        let numbered = (2u32..).map(|number| format!("{wanted} {number}"));
        numbered.into_iter().find(|name| is_free(name)).expect("there are more numbers than tasks")
    }

    /// What a part of a tree was read as, if there is room for it.
    fn read(&self, branch: &Branch) -> Result<Arc<Fragment>, Hindrance> {
        let fragment =
            branch.fragment.clone().filter(|fragment| !fragment.nodes.is_empty()).ok_or(Hindrance::Unread)?;
        match self.mission.tree.nodes.count() + fragment.nodes.len() <= NODES_MAX as usize {
            true => Ok(fragment),
            false => Err(Hindrance::Full { most: NODES_MAX }),
        }
    }

    /// A part of the tree is there from now on.
    fn add(
        &mut self,
        now: Time,
        (under, behind): (NodeId, usize),
        (fragment, source): (&Fragment, Source),
        task: Option<TaskEntry>,
        out: &mut Outbox,
    ) -> NodeId {
        let top = self.state.topology().next();
        let entry = |(parent, kind): (&NodeId, &NodeKind)| NodeEntry { parent: *parent, kind: EntryKind::from(kind) };
        let record = Record::Added {
            at: now,
            top,
            under,
            behind: u32::try_from(behind).expect("fewer children than ids"),
            nodes: std::iter::zip(&fragment.parents, &fragment.nodes).map(entry).collect(),
            names: fragment.names.clone(),
            channels: fragment.channels.clone(),
            task,
        };
        self.edit(record, out);
        let added = Arc::make_mut(&mut self.mission).graft(under, behind, fragment);
        debug_assert_eq!(added, top, "state and mission have the same tree");
        self.touches.iter_mut().for_each(|touches| touches.add(&self.mission, top));
        let topology = &self.mission.tree.topology;
        let nodes = topology.nodes_below(top).map(|node| (node, topology.parent(node))).collect();
        let (mission, settings) = (Arc::clone(&self.mission), Box::new(self.settings.clone()));
        out.push(Effect::Spawn { under, nodes, mission, settings });
        self.tree_changed(out);
        self.parts.insert(top, Arc::new(source));
        top
    }

    /// A part of the tree is gone from now on.
    fn remove(&mut self, now: Time, node: NodeId, out: &mut Outbox) {
        self.forget_nodes(node);
        self.edit(Record::Removed { at: now, node }, out);
        self.retire(node, out);
    }

    /// Whatever is kept beside the state of nodes that are about to go.
    pub(super) fn forget_nodes(&mut self, top: NodeId) {
        self.touches.iter_mut().for_each(|touches| touches.remove(top));
        let topology = &self.mission.tree.topology;
        let is_gone = |node: NodeId| topology.is_within(node, top);
        topology.below(top).for_each(|run| self.reasons.withdraw(&self.mission.tree, run));
        self.wishes.retain(|leaf, _| !is_gone(*leaf));
        self.preempted.retain(|(victim, by), _| !is_gone(*victim) && !is_gone(*by));
        self.began.retain(|node, _| !is_gone(*node));
        self.met.retain(|node| !is_gone(*node));
        self.idle.retain(|node| !is_gone(*node));
        self.parts.retain(|node, _| !is_gone(*node));
        self.fairness.forget(top);
    }

    /// The machines of nodes that are gone from the state end.
    pub(super) fn retire(&mut self, top: NodeId, out: &mut Outbox) {
        let topology = &self.mission.tree.topology;
        let (under, nodes) = (topology.parent(top), topology.nodes_below(top).collect());
        Arc::make_mut(&mut self.mission).remove(top);
        self.touches.iter_mut().for_each(|touches| touches.know(&self.mission));
        out.push(Effect::Retire { under, nodes });
        self.tree_changed(out);
    }

    fn tree_changed(&mut self, out: &mut Outbox) {
        self.is_tree_new = true;
        out.push(Effect::Mission(Arc::clone(&self.mission)));
    }

    fn add_branch(
        &mut self,
        now: Time,
        under: NodeId,
        behind: Option<u32>,
        branch: Branch,
        out: &mut Outbox,
    ) -> Result<NodeId, Hindrance> {
        let fragment = self.read(&branch)?;
        if !self.state.topology().has(under) || under.0 == 0 {
            return Err(Hindrance::NoNode);
        }
        if under == self.state.stem() {
            return Err(Hindrance::IsTask);
        }
        self.has_children_that_come(under)?;
        let children = self.state.topology().children(under).count();
        let behind = behind.map_or(children, |behind| behind as usize).min(children);
        self.is_place(under, behind)?;
        Ok(self.add(now, (under, behind), (&fragment, branch.source), None, out))
    }

    /// Whether children of a node may come and go: it is an AND, an OR or a THEN that is not over.
    fn has_children_that_come(&self, node: NodeId) -> Result<(), Hindrance> {
        match &self.mission.tree.nodes[node.index()] {
            NodeKind::And | NodeKind::Or | NodeKind::Then => {}
            NodeKind::Root | NodeKind::Tasks | NodeKind::Cleanup | NodeKind::Behavior(_) => {
                return Err(Hindrance::HasNoChildren);
            }
        }
        let is_open = self.state.phase(node) == Phase::Pending && !self.state.is_over(node);
        if is_open { Ok(()) } else { Err(Hindrance::IsOver) }
    }

    /// A THEN takes nothing before its present child.
    fn is_place(&self, under: NodeId, behind: usize) -> Result<(), Hindrance> {
        if Ordering::of(&self.mission.tree.nodes[under.index()]) != Some(Ordering::Then) {
            return Ok(());
        }
        let present = self.state.topology().children(under).position(|child| !self.state.is_done(child));
        match present {
            Some(present) if behind <= present => Err(Hindrance::IsPassed),
            Some(_) | None => Ok(()),
        }
    }

    /// Whether a part of the tree may go: it neither runs nor holds nor is done, and something is left beside it, unless
    /// something else comes in its place.
    fn can_be_removed(&self, node: NodeId, is_replaced: bool) -> Result<(), Hindrance> {
        let (state, topology) = (&self.state, self.state.topology());
        if node <= state.stem() || !topology.has(node) {
            return Err(Hindrance::NoNode);
        }
        let parent = topology.parent(node);
        if parent == state.stem() {
            return Err(Hindrance::IsTask);
        }
        self.has_children_that_come(parent)?;
        if state.is_done(node) {
            return Err(Hindrance::IsDone);
        }
        let waits =
            state.waits().iter().map(|(_, waiting)| *waiting).find(|waiting| topology.is_within(*waiting, node));
        if let Some(leaf) = state.running_below(node).map(|(leaf, _)| leaf).next().or(waits) {
            return Err(Hindrance::Runs { leaf });
        }
        let mut leases = state.table().leases();
        if let Some((resource, _)) = leases.find(|(_, lease)| topology.is_within(lease.holder, node)) {
            return Err(Hindrance::Holds { resource });
        }
        let mut others = topology.children(parent).filter(|child| *child != node);
        let is_left = match Ordering::of(&self.mission.tree.nodes[parent.index()]) {
            Some(Ordering::Or) => others.any(|other| state.phase(other) != Phase::Failed),
            Some(Ordering::And | Ordering::Then | Ordering::Cleanup) | None => others.next().is_some(),
        };
        if is_left || is_replaced { Ok(()) } else { Err(Hindrance::IsLast) }
    }

    fn replace(&mut self, now: Time, node: NodeId, branch: Branch, out: &mut Outbox) -> Result<NodeId, Hindrance> {
        let fragment = self.read(&branch)?;
        self.can_be_removed(node, true)?;
        let under = self.state.topology().parent(node);
        let place = self.state.topology().children(under).position(|child| child == node);
        self.remove(now, node, out);
        Ok(self.add(now, (under, place.unwrap_or_default()), (&fragment, branch.source), None, out))
    }

    fn cancel(&mut self, now: Time, task: NodeId, out: &mut Outbox) -> Result<(), Hindrance> {
        let known = self.state.tasks().get(&task).ok_or(Hindrance::NoTask)?;
        if known.canceled.is_some() {
            return Err(Hindrance::GivenUp);
        }
        let until = self.turned + self.settings.cleanup_grace;
        self.edit(Record::Canceled { at: now, task, until }, out);
        Ok(())
    }

    fn set_granting(
        &mut self,
        now: Time,
        task: Option<NodeId>,
        granting: Granting,
        out: &mut Outbox,
    ) -> Result<(), Hindrance> {
        let present = match task {
            None => Some(self.state.granting()),
            Some(task) => self.state.tasks().get(&task).map(|task| task.granting),
        };
        if present.ok_or(Hindrance::NoTask)? != granting {
            self.edit(Record::Granting { at: now, task, granting }, out);
        }
        Ok(())
    }

    fn add_object(&mut self, now: Time, name: String, place: PlaceId, out: &mut Outbox) -> Result<(), Hindrance> {
        if let Some(object) = self.mission.object(&name) {
            return Err(Hindrance::NameTaken { object });
        }
        if self.mission.misnamed(&name).is_some() {
            return Err(Hindrance::Misnamed);
        }
        if place.index() >= self.mission.world.places.len() {
            return Err(Hindrance::NoPlace);
        }
        let object = ObjectId::from(self.state.world().objects.len());
        self.edit(Record::ObjectAdded { at: now, object, name: name.clone(), place }, out);
        let added = Arc::make_mut(&mut self.mission).add_object(&name, ObjectSpec::default(), Location::At(place));
        debug_assert_eq!(added, Ok(object), "state and mission have the same objects");
        self.world_changed(out);
        Ok(())
    }

    fn remove_object(&mut self, now: Time, object: ObjectId, out: &mut Outbox) -> Result<(), Hindrance> {
        if !self.mission.has_object(object) {
            return Err(Hindrance::NoObject);
        }
        if !self.state.world().objects[object.index()].holders().is_empty() {
            return Err(Hindrance::ObjectHeld);
        }
        let mut readers = readers_of(&self.mission, object).into_iter();
        if let Some(by) = readers.find(|leaf| !self.state.is_over(*leaf)) {
            return Err(Hindrance::ObjectNeeded { by });
        }
        self.edit(Record::ObjectRemoved { at: now, object }, out);
        Arc::make_mut(&mut self.mission).remove_object(object);
        self.world_changed(out);
        Ok(())
    }

    fn world_changed(&mut self, out: &mut Outbox) {
        self.touches.iter_mut().for_each(|touches| touches.know(&self.mission));
        self.tree_changed(out);
    }
}
