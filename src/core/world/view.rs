//! The immutable snapshot that an activation carries down.

use std::collections::BTreeMap;
use std::fmt::Debug;
use std::sync::Arc;

use nalgebra::Point3;

use super::{Geometry, Ways};
use ambidex_model::state::State;
use ambidex_model::{
    BehaviorSpec, LeaseKind, Lineage, MissionSpec, NodeId, ObjectId, PlaceId, Reason, Request, ResourceId, Task, Time,
    TreeSpec,
};

/// The state of the run at the opening of a round.
#[derive(Debug, Clone)]
pub struct View {
    /// Counted from 1: the round that is open.
    pub round: u32,
    /// When it opened.
    pub now: Time,
    /// Tree, table, world, and what runs.
    pub state: State,
    /// In tree order what has become different since the last round: these nodes might say something else than they said.
    /// None where every round asks all.
    pub touched: Option<Arc<[NodeId]>>,
    /// Leaves that do not ask, since they would lead to a deadlock as things are.
    pub barred: Arc<BTreeMap<NodeId, Reason>>,
    /// Robot, tree and the fixed part of the world.
    pub mission: Arc<MissionSpec>,
    /// Where the base can drive from where it is.
    pub ways: Arc<Ways>,
    /// What may go on at once beyond resources and objects.
    pub rules: Arc<dyn Compatible>,
}

impl View {
    /// Whether a node that was asked in the last round would say again what it said.
    pub fn is_fresh(&self, node: NodeId) -> bool {
        self.touched.as_ref().is_some_and(|touched| touched.binary_search(&node).is_err())
    }

    /// The robot in the fixed part of the world.
    pub fn geometry(&self) -> Geometry<'_> {
        Geometry::of(&self.mission)
    }

    /// How urgent a node is: as it is told, or as who waits for what it or one above it holds.
    pub fn priority(&self, node: NodeId) -> i32 {
        priority(&self.mission.tree, self.state.urged(), node)
    }

    /// The behavior of a leaf as the world is.
    pub fn behavior(&self, leaf: NodeId) -> Option<&BehaviorSpec> {
        self.mission.tree.behavior_in(leaf, self.state.world())
    }

    /// What a behavior puts down, as it asked: where, and in which point of the map.
    pub fn puts(&self, request: &Request) -> Vec<(ObjectId, PlaceId, Point3<f64>)> {
        let spec = self.mission.tree.behavior(request.leaf).map(|spec| spec.asked(request));
        let puts = spec.into_iter().flat_map(|spec| &spec.commands).filter_map(|term| {
            let (object, place) = term.task.put().zip(term.task.put_at())?;
            Some((object, place, self.mission.world.spot(object, place, request.spot(object))))
        });
        puts.collect()
    }

    /// What runs, on all that it has.
    pub fn uses(&self) -> impl Iterator<Item = Use<'_>> {
        self.state.running().values().flat_map(|grant| {
            let claims = grant.request.claims.len();
            grant.bindings.iter().enumerate().map(move |(index, binding)| Use {
                request: &grant.request,
                claim: Some(index).filter(|index| *index < claims),
                resource: binding.resource,
                is_running: true,
            })
        })
    }

    /// The running behavior that moves the base, if any does.
    pub fn driver(&self) -> Option<NodeId> {
        self.state.running().keys().copied().find(|&leaf| {
            let behavior = self.mission.tree.behavior(leaf).expect("only leaves run");
            behavior.commands.iter().any(|term| matches!(term.task, Task::DriveTo(..)))
        })
    }

    /// Whether an intention lease is kept for a node of this line.
    pub fn is_heir(&self, line: &Lineage<'_>) -> bool {
        let mut leases = self.state.table().leases();
        leases.any(|(_, lease)| lease.kind == LeaseKind::Intention && line.contains(lease.holder))
    }
}

/// How urgent a node is where some are as urgent as others.
pub(crate) fn priority(tree: &TreeSpec, urged: &BTreeMap<NodeId, i32>, node: NodeId) -> i32 {
    let own = tree.priority(node);
    if urged.is_empty() {
        return own;
    }
    let above = tree.topology.path(node).filter_map(|above| urged.get(&above));
    above.copied().fold(own, i32::max)
}

/// A behavior on a resource.
#[derive(Debug, Clone, Copy)]
pub struct Use<'a> {
    /// The behavior that uses it or would use it, as it asked.
    pub request: &'a Request,
    /// For which of its claims; none where an allocator added it.
    pub claim: Option<usize>,
    /// The resource that it has or would get.
    pub resource: ResourceId,
    /// Whether it runs.
    pub is_running: bool,
}

/// Says whether behaviors can go on at once on the resources they would get.
pub trait Compatible: Debug + Send + Sync {
    /// Judges a set of uses, running ones included; the last behavior is the one to be added.
    ///
    /// # Errors
    /// Why the last one cannot join.
    fn check(&self, view: &View, uses: &[Use<'_>]) -> Result<(), Reason>;

    /// Whether root alone asks it, who sees all of a round: what an AND passes up depends on the requests then, and on
    /// nothing else.
    fn is_for_root(&self) -> bool {
        false
    }
}

/// Everything that resources allow can go on at once.
#[derive(Debug, Clone, Copy, Default)]
pub struct Unconstrained;

impl Compatible for Unconstrained {
    fn check(&self, _: &View, _: &[Use<'_>]) -> Result<(), Reason> {
        Ok(())
    }

    fn is_for_root(&self) -> bool {
        true
    }
}
