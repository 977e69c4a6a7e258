//! What the auditor knows of a run: names, tree, world, what runs and what is away.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use ambidex_model::state::Saved;
use ambidex_model::{
    BehaviorSpec, Change, ControllerId, EffectTerm, EntryKind, Grant, Header, Location, MissionSpec, Names, NodeId,
    ObjectId, Pose, Record, ResourceId, Runs, Service, Topology, WorldState,
};

/// The auditor's own fold.
#[derive(Debug)]
pub(super) struct Run {
    pub(super) names: Names,
    pub(super) topology: Topology,
    pub(super) kinds: Runs<EntryKind>,
    pub(super) has_messages: bool,
    /// Only one that has the header's nodes and objects.
    pub(super) mission: Option<Arc<MissionSpec>>,
    pub(super) world: WorldState,
    pub(super) running: BTreeMap<NodeId, Grant>,
    pub(super) services: BTreeMap<ResourceId, Service>,
    /// Objects that two hands have held at once.
    pub(super) shared: BTreeSet<ObjectId>,
}

impl Run {
    /// Whether it takes tasks while it works.
    pub(super) fn is_standing(&self) -> bool {
        self.kinds.get(1) == Some(&EntryKind::Tasks)
    }

    pub(super) fn new(header: &Header, mission: Option<Arc<MissionSpec>>) -> Self {
        let names = header.names.clone();
        let unknown = WorldState::new(Pose::new(0.0, 0.0, 0.0), Vec::new(), Vec::new());
        let mut world = header.start.clone().unwrap_or(unknown);
        world.objects.resize(names.objects.len(), Location::Unknown);
        world.facts.resize(names.facts.len(), false);
        let fits = |mission: &Arc<MissionSpec>| {
            mission.tree.nodes.len() == header.nodes.len() && mission.names.objects.len() == names.objects.len()
        };
        Self {
            topology: header.topology(),
            kinds: header.nodes.iter().map(|node| node.kind.clone()).collect(),
            has_messages: header.has_messages,
            mission: mission.filter(fits),
            world,
            running: BTreeMap::new(),
            services: BTreeMap::new(),
            shared: BTreeSet::new(),
            names,
        }
    }

    pub(super) fn name(&self, node: NodeId) -> &str {
        self.names.node(node)
    }

    /// The controller of that name.
    pub(super) fn controller(&self, name: &str) -> Option<ControllerId> {
        self.names.controllers.iter().position(|other| other == name).map(ControllerId::from)
    }

    /// Whether the tree has this node.
    pub(super) fn is_known(&self, node: NodeId) -> bool {
        self.topology.has(node)
    }

    /// A behavior as it was granted.
    pub(super) fn behavior(&self, grant: &Grant) -> Option<&BehaviorSpec> {
        let mission = self.mission.as_ref()?;
        Some(mission.tree.behavior(grant.leaf()).filter(|_| self.is_known(grant.leaf()))?.asked(&grant.request))
    }

    /// Whether an object may be in two hands at once: the log has had it so, or a behavior takes it with two hands or from
    /// one into the other, however that ends.
    pub(super) fn is_shared(&self, object: ObjectId) -> bool {
        let is_of = |effect: &&EffectTerm| matches!(effect, EffectTerm::Taken(of, _) | EffectTerm::LetGo(of, _) if *of == object);
        let hands = |spec: &BehaviorSpec| spec.effects.iter().filter(is_of).count();
        let mission = self.mission.iter();
        let mut leaves =
            mission.flat_map(|mission| mission.tree.leaves().filter_map(|leaf| mission.tree.behavior(leaf)));
        self.shared.contains(&object) || leaves.any(|spec| hands(spec) > 1)
    }

    /// Takes over what a record changes.
    pub(super) fn apply(&mut self, record: &Record) {
        match record {
            Record::Began { world_state, .. } => {
                let (objects, facts) = (self.world.objects.len(), self.world.facts.len());
                self.world = (**world_state).clone();
                self.world.objects.resize(objects, Location::Unknown);
                self.world.facts.resize(facts, false);
            }
            Record::Decided { granted, .. } => {
                let known = granted.iter().filter(|grant| self.topology.has(grant.leaf()));
                self.running.extend(known.map(|grant| (grant.leaf(), grant.clone())));
            }
            Record::Released { leaf, changes, .. } => {
                self.running.remove(leaf);
                changes.iter().for_each(|change| self.change(*change));
            }
            Record::World { change, .. } | Record::Observed { change, .. } => self.change(*change),
            Record::Served { resources, service, .. } => {
                self.services.extend(resources.iter().map(|resource| (*resource, *service)));
            }
            Record::Added { top, under, behind, nodes, names, .. } => {
                if *top == self.topology.next() && self.topology.has(*under) {
                    let parents: Vec<NodeId> = nodes.iter().map(|node| node.parent).collect();
                    let has_cleanup = |node: NodeId| nodes[(node.0 - top.0) as usize].kind == EntryKind::Cleanup;
                    self.topology.graft(*under, *behind as usize, &parents, has_cleanup);
                    self.kinds.add(top.index(), nodes.iter().map(|node| node.kind.clone()).collect());
                    self.names.nodes.add(top.index(), names.clone());
                }
            }
            Record::Removed { node, .. } | Record::TaskEnded { task: node, .. } => {
                if node.0 > 0 && self.topology.has(*node) {
                    self.topology.remove(*node);
                }
            }
            Record::ObjectAdded { object, name, place, .. } => {
                if object.index() == self.world.objects.len() {
                    self.world.objects.push(Location::At(*place));
                    self.names.objects.push(name.clone());
                }
            }
            // What came before is told nowhere else.
            Record::Checkpoint { saved, .. } => {
                if let Ok(saved) = serde_json::from_str::<Saved>(saved) {
                    self.topology = Topology::clone(saved.state.topology());
                    self.kinds = saved.nodes.map(|node| node.kind.clone());
                    self.names = saved.names.legible();
                    self.world = saved.state.world().clone();
                    self.running = saved.state.running().clone();
                    let services = saved.state.table().iter().map(|(id, resource)| (id, resource.service()));
                    self.services = services.collect();
                }
            }
            Record::ObjectRemoved { object, .. } => self.change(Change::Object(*object, Location::Unknown)),
            Record::Granting { .. } | Record::Canceled { .. } | Record::Stalled { .. } | Record::Declined { .. } => {}
            Record::Header(_) | Record::Told { .. } | Record::Turn { .. } | Record::Sent { .. } => {}
            Record::Infeasible { .. } | Record::TimedOut { .. } | Record::Reopened { .. } => {}
            Record::Overtaken { .. } | Record::Stopped { .. } | Record::Ending { .. } | Record::Leaving { .. } => {}
            Record::Cleaning { .. } | Record::Cleaned { .. } | Record::Woke { .. } | Record::Awaited { .. } => {}
            Record::Denied { .. } | Record::Resource { .. } | Record::Controller { .. } | Record::Ended { .. } => {}
        }
    }

    fn change(&mut self, change: Change) {
        let (objects, facts) = (self.world.objects.len(), self.world.facts.len());
        let is_known = match change {
            Change::Object(object, _) | Change::Laid(object, ..) | Change::Taken(object, _) => object.index() < objects,
            Change::Fact(fact, _) => fact.index() < facts,
            Change::Base(_) | Change::Emptied(_) | Change::Blocked(_) | Change::Cleared(_) => true,
        };
        if !is_known {
            return;
        }
        self.world.apply(change);
        if let Some((object, _)) = change.moved()
            && self.world.objects[object.index()].holders().len() > 1
        {
            self.shared.insert(object);
        }
    }

    /// Whether the world may be another one after a record.
    pub(super) fn is_about_world(record: &Record) -> bool {
        matches!(
            record,
            Record::Began { .. } | Record::Released { .. } | Record::World { .. } | Record::Observed { .. }
        )
    }

    /// Who changes the world by a record, and how.
    pub(super) fn changes(record: &Record) -> &[Change] {
        if let Record::Released { changes, .. } = record {
            changes
        } else if let Record::World { change, .. } | Record::Observed { change, .. } = record {
            std::slice::from_ref(change)
        } else {
            &[]
        }
    }
}
