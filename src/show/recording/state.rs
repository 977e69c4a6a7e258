//! The tree, what its nodes are, and who holds the resources.

use std::collections::BTreeMap;

use std::time::Duration;

use ambidex_model::{Change, End, LeaseKind, NodeId, Reason, Record, Time};
use ambidex_record::{History, LeafState};
use serde::Serialize;

use super::message::{Moment, Topic};
use crate::status::{ResourceRow, node_reason, resource_rows};

/// A tree of so many nodes is told whole whenever something of it changes, so that who looks at any moment sees all.
const SMALL: usize = 200;
/// How often at most a larger one is told whole; between, what changed. Robot time.
const WHOLE_EVERY: Duration = Duration::from_secs(10);

#[derive(Serialize)]
struct Tree<'a> {
    mission: &'a str,
    robot: &'a str,
    allocator: &'a str,
    nodes: Vec<TreeNode<'a>>,
}

#[derive(Serialize)]
struct TreeNode<'a> {
    id: u32,
    name: &'a str,
    kind: &'a str,
    #[serde(skip_serializing_if = "Option::is_none")]
    parent: Option<u32>,
}

#[derive(Serialize)]
struct State<'a> {
    round: u32,
    whole: bool,
    nodes: Vec<NodeState<'a>>,
}

#[derive(Serialize)]
struct NodeState<'a> {
    id: u32,
    name: &'a str,
    kind: &'a str,
    phase: LeafState,
    #[serde(skip_serializing_if = "Option::is_none")]
    reason: Option<String>,
}

#[derive(Serialize)]
struct Resources<'a> {
    resources: Vec<ResourceState<'a>>,
}

#[derive(Serialize)]
struct ResourceState<'a> {
    id: usize,
    name: &'a str,
    #[serde(rename = "type")]
    ty: &'a str,
    #[serde(skip_serializing_if = "Option::is_none")]
    controller: Option<&'a str>,
    access: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    channel: Option<&'a str>,
    holders: Vec<Holder<'a>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    holds: Option<&'a str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    unavailable: Option<&'a str>,
}

#[derive(Serialize)]
struct Holder<'a> {
    node: &'a str,
    behavior: &'a str,
    kind: LeaseKind,
}

/// What was told of nodes and resources.
#[derive(Debug, Default)]
pub(super) struct Told {
    nodes: BTreeMap<NodeId, Seen>,
    /// Of the tree that was told last.
    version: u64,
    whole_at: Time,
    resources: Vec<ResourceRow>,
}

/// What was told of a node.
#[derive(Debug)]
struct Seen {
    state: LeafState,
    reason: Option<Reason>,
    end: Option<End>,
}

impl Seen {
    fn new(history: &History, node: NodeId) -> Self {
        let leaf = history.leaf(node);
        Self {
            state: history.state(node),
            reason: leaf.and_then(|leaf| leaf.reason()).cloned(),
            end: leaf.and_then(|leaf| leaf.last_end()),
        }
    }

    /// Whether a node is still so; nothing is copied to know it.
    fn is_still(&self, history: &History, node: NodeId) -> bool {
        let leaf = history.leaf(node);
        self.state == history.state(node)
            && self.reason.as_ref() == leaf.and_then(|leaf| leaf.reason())
            && self.end == leaf.and_then(|leaf| leaf.last_end())
    }
}

impl Told {
    /// Tells what is different after a record, or all anew. A tree that has other nodes than before is told anew too.
    pub(super) fn tell(&mut self, history: &History, record: &Record, is_anew: bool, moment: &mut Moment) {
        let version = history.state_of_run().topology().version();
        let is_anew = std::mem::replace(&mut self.version, version) != version || is_anew;
        if is_anew {
            tell_tree(history, moment);
        }
        if is_anew || changes_nodes(record) {
            self.tell_nodes(history, is_anew, moment);
        }
        if is_anew || changes_resources(record) {
            self.tell_resources(history, is_anew, moment);
        }
    }

    fn tell_nodes(&mut self, history: &History, is_anew: bool, moment: &mut Moment) {
        let header = history.header();
        let ids = || header.nodes.entries().map(|(index, _)| NodeId::from(index));
        if is_anew {
            self.nodes.retain(|node, _| header.nodes.get(node.index()).is_some());
        }
        let is_known = |node: &NodeId| self.nodes.get(node).is_some_and(|seen| seen.is_still(history, *node));
        let changed: Vec<NodeId> = ids().filter(|node| !is_known(node)).collect();
        self.nodes.extend(changed.iter().map(|node| (*node, Seen::new(history, *node))));
        if changed.is_empty() && !is_anew {
            return;
        }
        let is_due = history.now().since(self.whole_at) >= WHOLE_EVERY;
        let is_whole = is_anew || is_due || self.nodes.len() <= SMALL;
        let told = if is_whole { ids().collect() } else { changed };
        if is_whole {
            self.whole_at = history.now();
        }
        let node = |node: NodeId| {
            let state = self.nodes[&node].state;
            NodeState {
                id: node.0,
                name: history.names().node(node),
                kind: header.nodes[node.index()].kind.word(),
                phase: state,
                reason: node_reason(history, node, state),
            }
        };
        let nodes = told.into_iter().map(node).collect();
        moment.say(Topic::State, &State { round: history.rounds(), whole: is_whole, nodes });
    }

    fn tell_resources(&mut self, history: &History, is_anew: bool, moment: &mut Moment) {
        let rows = resource_rows(history);
        if rows != self.resources || is_anew {
            let resources = rows.iter().enumerate().map(|(id, row)| resource_state(id, row)).collect();
            moment.say(Topic::Resources, &Resources { resources });
            self.resources = rows;
        }
    }
}

fn tell_tree(history: &History, moment: &mut Moment) {
    let header = history.header();
    let nodes = header.nodes.entries().map(|(index, entry)| TreeNode {
        id: NodeId::from(index).0,
        name: header.names.node(NodeId::from(index)),
        kind: entry.kind.word(),
        parent: (index > 0).then_some(entry.parent.0),
    });
    let (mission, robot, allocator) = (&header.mission, &header.robot, &header.allocator);
    moment.say(Topic::Tree, &Tree { mission, robot, allocator, nodes: nodes.collect() });
}

fn resource_state(id: usize, row: &ResourceRow) -> ResourceState<'_> {
    let holders = row.holders.iter();
    ResourceState {
        id,
        name: &row.name,
        ty: &row.ty,
        controller: row.controller.as_deref(),
        access: match (row.locked, &row.channel) {
            (false, _) => "free",
            (true, None) => "exclusive",
            (true, Some(_)) => "shared",
        },
        channel: row.channel.as_deref(),
        holders: holders
            .map(|holder| Holder { node: &holder.node, behavior: &holder.behavior, kind: holder.kind })
            .collect(),
        holds: row.holds.as_deref(),
        unavailable: row.unavailable.as_ref().map(|outage| outage.why.as_str()),
    }
}

/// Whether a node may be something else after a record.
fn changes_nodes(record: &Record) -> bool {
    match record {
        Record::Header(_) | Record::Began { .. } | Record::Decided { .. } | Record::Released { .. } => true,
        Record::Infeasible { .. } | Record::TimedOut { .. } | Record::Reopened { .. } => true,
        Record::Overtaken { .. } | Record::Cleaning { .. } | Record::Cleaned { .. } | Record::Ended { .. } => true,
        Record::Added { .. } | Record::Removed { .. } | Record::TaskEnded { .. } => true,
        Record::Canceled { .. } | Record::Checkpoint { .. } => true,
        Record::Granting { .. } | Record::Stalled { .. } | Record::Declined { .. } => false,
        Record::ObjectAdded { .. } | Record::ObjectRemoved { .. } => false,
        Record::Told { .. } | Record::Observed { .. } | Record::Turn { .. } | Record::Sent { .. } => false,
        Record::Stopped { .. } | Record::Ending { .. } | Record::Leaving { .. } | Record::Woke { .. } => false,
        Record::Served { .. } | Record::Awaited { .. } | Record::World { .. } | Record::Denied { .. } => false,
        Record::Resource { .. } | Record::Controller { .. } => false,
    }
}

/// Whether a resource may be held by somebody else, or hold something else, after a record.
fn changes_resources(record: &Record) -> bool {
    let is_of_objects = |change: &Change| match change {
        Change::Object(..) | Change::Laid(..) | Change::Taken(..) | Change::Emptied(_) => true,
        Change::Base(_) | Change::Fact(..) | Change::Blocked(_) | Change::Cleared(_) => false,
    };
    match record {
        Record::Header(_) | Record::Began { .. } | Record::Resource { .. } | Record::Checkpoint { .. } => true,
        Record::TaskEnded { .. } => true,
        Record::Added { .. } | Record::Removed { .. } | Record::Canceled { .. } => false,
        Record::Granting { .. } | Record::Stalled { .. } | Record::Declined { .. } => false,
        Record::ObjectAdded { .. } | Record::ObjectRemoved { .. } => false,
        Record::Released { changes, .. } => changes.iter().any(is_of_objects),
        Record::World { change, .. } | Record::Observed { change, .. } => is_of_objects(change),
        Record::Told { .. } | Record::Turn { .. } | Record::Sent { .. } | Record::Decided { .. } => false,
        Record::Infeasible { .. } | Record::TimedOut { .. } | Record::Reopened { .. } => false,
        Record::Overtaken { .. } | Record::Stopped { .. } | Record::Ending { .. } => false,
        Record::Leaving { .. } | Record::Cleaning { .. } | Record::Cleaned { .. } | Record::Woke { .. } => false,
        Record::Served { .. } | Record::Awaited { .. } | Record::Denied { .. } => false,
        Record::Controller { .. } | Record::Ended { .. } => false,
    }
}
