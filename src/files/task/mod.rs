//! The task as read, to a tree in preorder: names looked up, nodes named, every behavior bound to robot and world.

mod flat;
mod labels;
mod node;
mod siblings;
mod subtrees;
mod told;

use std::collections::BTreeSet;
use std::time::Duration;

pub(crate) use flat::no_subtree;
pub(crate) use node::{AND, OR, THEN, node_form};
pub(crate) use subtrees::{Subtree, Subtrees};

use crate::describe::Described;
use crate::document::SourceSpan;
use crate::fault::Faults;
use crate::kinds::{Binder, Declared, Kinds, Site, Stop};
use crate::names::Register;
use crate::parameter::{Argument, Known};
use crate::reader::{Item, Name};
use crate::robot::RobotFile;
use crate::settings::Given;
use crate::shape::Shape;
use crate::world::Built;
use ambidex_model::{Fragment, NodeId, NodeKind, Topology, TypeId};
use flat::{Flat, check_subtrees};
pub(crate) use labels::ROOT;
use labels::label;
use node::{MAX_AT_ONCE, Node, REPEAT, TIMEOUT_KEY};
use siblings::{Afters, moves_before};
use told::Told;

/// Most nodes of the task of a mission.
pub(crate) const MAX_NODES: usize = 100_000;
/// Most nodes of a task that is submitted: nobody else's work may wait long for it to be read.
pub(crate) const MAX_SUBMITTED: usize = 10_000;

/// The description of a node.
pub(crate) fn node_shape() -> &'static Shape {
    Node::shape()
}

/// What a task is bound to; what could not be read is none.
pub(crate) struct Surroundings<'a> {
    pub(crate) kinds: &'a Kinds,
    pub(crate) known: Known<'a>,
    pub(crate) robot: Option<&'a RobotFile>,
    pub(crate) world: Option<&'a Built>,
    /// Channels that there are already.
    pub(crate) channels: &'a Register,
    /// Whether there may be kinds and subtrees that nobody knows here.
    pub(crate) is_open: bool,
    pub(crate) most_nodes: usize,
}

/// No channels.
static NO_CHANNELS: Register = Register::new("channel");

impl<'a> Surroundings<'a> {
    /// Those of what is checked by itself: of robot and world nothing is known.
    pub(crate) fn of_nowhere(kinds: &'a Kinds) -> Self {
        let known = Known { world: None, robot: None };
        Self { kinds, known, robot: None, world: None, channels: &NO_CHANNELS, is_open: false, most_nodes: MAX_NODES }
    }
}

/// What is to be done, and what it is called.
pub(crate) struct Written<'a> {
    pub(crate) name: String,
    pub(crate) task: Item<'a>,
    /// What its top is called where nothing is told, if it is a subtree that is used.
    pub(crate) label: Option<Name>,
}

/// A task that can be run, with the span of each node.
pub(crate) struct BuiltTask {
    pub(crate) fragment: Fragment,
    pub(crate) spans: Vec<SourceSpan>,
}

/// A node with its names looked up.
#[derive(Debug)]
struct Draft<'a> {
    span: SourceSpan,
    name: Option<Name>,
    /// Whether it stands in a subtree.
    is_used: bool,
    /// None when something in it is wrong; that has its fault.
    kind: Option<DraftKind<'a>>,
    told: Told,
}

/// What a node is.
#[derive(Debug)]
enum DraftKind<'a> {
    And,
    Or,
    Then,
    Cleanup,
    Behavior(Box<Call<'a>>),
}

/// A behavior with its arguments.
#[derive(Debug)]
struct Call<'a> {
    kind: &'a Declared,
    arguments: Vec<Option<Argument>>,
    /// Where it drives to.
    stop: Option<Stop>,
    /// Types of resources that it claims.
    types: Vec<TypeId>,
}

impl Draft<'_> {
    /// The behavior, if it is one.
    fn call(&self) -> Option<&Call<'_>> {
        match &self.kind {
            Some(DraftKind::Behavior(call)) => Some(call),
            Some(DraftKind::And | DraftKind::Or | DraftKind::Then | DraftKind::Cleanup) | None => None,
        }
    }

    /// A node may shorten the time of its kind, but not below what it takes.
    fn check_timeout(&self, takes: Duration, faults: &mut Faults) {
        if let Some(timeout_s) = self.told.timeout_s.filter(|timeout_s| *timeout_s <= takes.as_secs_f64()) {
            let message = format!("it takes {} s, and its timeout is {timeout_s} s", takes.as_secs_f64());
            faults.push_with((self.span, TIMEOUT_KEY), message, "give it a greater `timeout`");
        }
    }

    /// What a behavior is called after what it is.
    fn label(&self) -> String {
        match &self.kind {
            Some(DraftKind::Behavior(call)) => call.kind.label(&call.arguments),
            Some(DraftKind::And | DraftKind::Or | DraftKind::Then | DraftKind::Cleanup) | None => "node".to_owned(),
        }
    }
}

/// Checks every subtree by itself, and that none uses itself.
pub(crate) fn check_all(subtrees: &mut Subtrees, around: &Surroundings<'_>, faults: &mut Faults) {
    let mut flat = Flat::new(subtrees, around);
    let uses = check_subtrees(&mut flat, faults);
    subtrees.refuse_cycles(&uses, faults);
}

/// Checks a task whose robot and world are not known.
pub(crate) fn check_alone(
    task: Item<'_>,
    subtrees: &Subtrees,
    around: &Surroundings<'_>,
    given: &Given,
    faults: &mut Faults,
) {
    Flat::new(subtrees, around).add_task(task, None, given, faults);
}

/// The nodes and what they are called; `None` when there are faults.
pub(crate) fn build(
    Written { name, task, label: used_as }: Written<'_>,
    subtrees: &Subtrees,
    around: &Surroundings<'_>,
    given: &Given,
    faults: &mut Faults,
) -> Option<BuiltTask> {
    let mut flat = Flat::new(subtrees, around);
    flat.add_task(task, used_as.as_ref(), given, faults);
    let Flat { drafts, parents, .. } = flat;
    if drafts.is_empty() || drafts.len() > around.most_nodes || !given.is_whole() {
        return None;
    }
    let topology = Topology::new(parents.clone());
    check_repeats(&drafts, &topology, faults);
    let names = label(&drafts, faults);
    let mut binder = Binder::new(around.robot?, around.world?, around.known, around.channels);
    let nodes = bind_all(&drafts, &topology, &mut binder, faults)?;
    let spans = drafts.iter().map(|draft| draft.span).collect();
    let tasks = drafts.iter().enumerate().filter(|(_, draft)| draft.call().is_none());
    let limits = tasks.filter_map(|(index, draft)| Some((NodeId::from(index), draft.told.limits()?))).collect();
    let told = || drafts.iter().enumerate().map(|(index, draft)| (NodeId::from(index), draft.told));
    let priorities = told().filter_map(|(node, told)| Some((node, told.priority?))).collect();
    let repeats = told().filter_map(|(node, told)| Some((node, told.repeat?))).collect();
    let channels = binder.into_channels();
    let fragment = Fragment { name, nodes, parents, limits, repeats, priorities, names, channels };
    Some(BuiltTask { fragment, spans })
}

/// What is done again at once may take no time at all: all its rounds are then at one moment, and so many are bounded.
fn check_repeats(drafts: &[Draft<'_>], topology: &Topology, faults: &mut Faults) {
    let at_once = |node: NodeId| drafts[node.index()].told.repeat.filter(|repeat| repeat.every.is_none());
    for (index, draft) in drafts.iter().enumerate() {
        let node = NodeId::from(index);
        if at_once(node).is_none() {
            continue;
        }
        // Above one with `every` time passes.
        let above = topology.path(node).take_while(|above| {
            let repeat = drafts[above.index()].told.repeat;
            repeat.is_none_or(|repeat| repeat.every.is_none())
        });
        let times =
            above.filter_map(|above| at_once(above)?.times).fold(1_u64, |all, own| all.saturating_mul(own.into()));
        if times > MAX_AT_ONCE {
            let help =
                format!("write `every: TIME` beside it, or repeat it {MAX_AT_ONCE} times at most with all above it");
            faults.push_with((draft.span, REPEAT), format!("repeated {times} times without a pause"), help);
            return;
        }
    }
}

fn bind_all(
    drafts: &[Draft<'_>],
    topology: &Topology,
    binder: &mut Binder<'_>,
    faults: &mut Faults,
) -> Option<Vec<NodeKind>> {
    let befores = moves_before(drafts, topology);
    let calls = drafts.iter().filter_map(Draft::call);
    let types: BTreeSet<TypeId> = calls.flat_map(|call| call.types.iter().copied()).collect();
    let afters = Afters::of(drafts, topology, types);
    let mut nodes = Vec::with_capacity(drafts.len());
    for (index, draft) in drafts.iter().enumerate() {
        let call = match &draft.kind {
            None => None,
            Some(DraftKind::And) => Some(NodeKind::And),
            Some(DraftKind::Or) => Some(NodeKind::Or),
            Some(DraftKind::Then) => Some(NodeKind::Then),
            Some(DraftKind::Cleanup) => Some(NodeKind::Cleanup),
            Some(DraftKind::Behavior(call)) => {
                let site = Site {
                    span: draft.span,
                    arguments: &call.arguments,
                    before: befores[index],
                    is_claimed_after: &|ty| afters.claims(index, ty),
                };
                binder.bind(call.kind, &site, faults).map(|mut behavior| {
                    draft.check_timeout(behavior.takes, faults);
                    draft.told.tell(&mut behavior);
                    NodeKind::Behavior(Box::new(behavior))
                })
            }
        };
        nodes.push(call);
    }
    nodes.into_iter().collect()
}
