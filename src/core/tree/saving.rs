//! A run that is saved, and one that goes on from there (`semantics` 6, "Tasks that come and go").

use std::collections::BTreeMap;
use std::sync::Arc;

use super::topics::Touches;
use super::{Machines, Root, Settings};
use ambidex_model::state::{Saved, SavedRoot, Stage};
use ambidex_model::{
    EntryKind, Fragment, MissionSpec, NodeEntry, NodeId, NodeKind, ObjectSpec, Runs, Source, TreeSpec, WorldState,
};

/// Reads a part of a tree once more for a mission as it is; none where that cannot be.
pub type BranchReader = Arc<dyn Fn(&Source, &MissionSpec, &WorldState) -> Option<Fragment> + Send + Sync>;

impl Root {
    /// All that the run is; none while a round is open, something is to be taken up, or where it takes no work.
    pub fn save(&self) -> Option<Saved> {
        // What is still to be judged is judged by what the last round said, which is not saved.
        let is_judged = self.idle.is_empty() && !self.is_quiet && self.met.is_empty();
        let is_at_rest = self.is_between_rounds() && self.told.is_empty() && self.ended.is_empty() && is_judged;
        let is_going = self.state.stage() == Stage::Running && self.ending.is_none() && !self.is_suspended;
        if !is_at_rest || !is_going || !self.mission.tree.is_standing() {
            return None;
        }
        let preempted = self.preempted.iter().map(|((leaf, by), progress)| (*leaf, *by, *progress));
        let root = SavedRoot {
            turned: self.turned,
            is_wanted: self.is_wanted,
            was_quiet: self.was_quiet,
            asked_for: self.asked_for,
            preempted: preempted.collect(),
            began: self.began.clone(),
            denied: self.denied.clone(),
            unheard: self.touches.as_ref().map(Touches::barred).unwrap_or_default(),
            seen: self.fairness.seen().clone(),
            ..self.certificate.save()
        };
        let tree = &self.mission.tree;
        Some(Saved {
            state: self.state.clone(),
            nodes: entries(tree),
            names: self.mission.names.clone(),
            parts: self.parts.iter().map(|(top, source)| (*top, Source::clone(source))).collect(),
            root,
        })
    }

    fn restore(&mut self, saved: &Saved) {
        let root = &saved.root;
        self.state = saved.state.clone();
        self.look_around();
        self.parts = saved.parts.iter().map(|(top, source)| (*top, Arc::new(source.clone()))).collect();
        (self.turned, self.asked_for) = (root.turned, root.asked_for);
        (self.is_wanted, self.was_quiet) = (root.is_wanted, root.was_quiet);
        self.preempted = root.preempted.iter().map(|(leaf, by, progress)| ((*leaf, *by), *progress)).collect();
        self.began.clone_from(&root.began);
        self.denied.clone_from(&root.denied);
        self.fairness.restore(root.seen.clone());
        self.certificate.restore(&self.mission, root);
        self.touches.iter_mut().for_each(|touches| touches.restore(root.unheard.clone()));
        self.is_table_told();
    }
}

impl Machines {
    /// Those of a run that goes on from where it was saved; `mission` is what it began with. None where what was saved is
    /// not of that mission, or cannot be read any more.
    pub fn restored(
        mission: &MissionSpec,
        settings: &Settings,
        saved: &Saved,
        reader: Option<&BranchReader>,
    ) -> Option<Self> {
        let mission = Arc::new(restored(mission, saved, reader)?);
        let mut machines = Self::new(&mission, settings);
        machines.root_mut().restore(saved);
        Some(machines)
    }
}

/// What each node is, by id.
fn entries(tree: &TreeSpec) -> Runs<NodeEntry> {
    let mut entries = Runs::default();
    for run in tree.nodes.ranges() {
        let entry = |index: usize| {
            let node = NodeId::from(index);
            // What is gone from within a run has no parent any more.
            let parent = if tree.topology.has(node) { tree.topology.parent(node) } else { NodeId(0) };
            NodeEntry { parent, kind: EntryKind::from(&tree.nodes[index]) }
        };
        entries.add(run.start, run.map(entry).collect());
    }
    entries
}

fn restored(mission: &MissionSpec, saved: &Saved, reader: Option<&BranchReader>) -> Option<MissionSpec> {
    let mut mission = mission.clone();
    let (state, names) = (&saved.state, &saved.names);
    let is_of_it = mission.tree.is_standing()
        && std::iter::zip(&names.objects, &mission.names.objects).all(|(now, then)| now.is_empty() || now == then)
        && names.objects.len() >= mission.names.objects.len()
        && names.channels.starts_with(&mission.names.channels)
        && names.objects.len() == state.world().objects.len()
        && state.world().facts.len() == mission.names.facts.len()
        && state.table().count() == mission.robot.resources.len();
    if !is_of_it {
        return None;
    }
    mission.names = names.clone();
    mission.world.objects.resize_with(names.objects.len(), ObjectSpec::default);
    mission.start.objects = state.world().objects.clone();
    let mut fragments: BTreeMap<NodeId, Fragment> = BTreeMap::new();
    for (&top, source) in &saved.parts {
        let fragment = reader?(source, &mission, state.world())?;
        let is_alike = |(index, kind): (usize, &NodeKind)| {
            saved.nodes.get(top.index() + index).is_some_and(|entry| entry.kind == EntryKind::from(kind))
        };
        if !fragment.channels.is_empty() || !fragment.nodes.iter().enumerate().all(is_alike) {
            return None;
        }
        fragments.insert(top, fragment);
    }
    for (&task, known) in state.tasks() {
        fragments.get_mut(&task)?.priorities.insert(NodeId(0), known.priority);
    }
    mission.tree = mission.tree.restored(state.topology(), fragments);
    Some(mission)
}
