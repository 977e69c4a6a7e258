//! One task per node: inbox, machine, effects out. Handles are directed: to a child only `Down`, to the parent only `Up`.

use std::sync::{Arc, Mutex, PoisonError};

use tokio::sync::mpsc;

use super::clock::Clock;
use super::journal_task::Journal;
use super::signal::Signal;
use ambidex_core::dispatch;
use ambidex_core::tree::{Down, Effect, Input, Node, Outbox, Up};
use ambidex_model::{Change, MissionSpec, NodeId, Outcome, Time, Told, Topology};

/// What a parent can have on the way to a child: a verdict, one that only stops, and the next activation; twice that.
const FROM_PARENT: usize = 8;
/// What dispatch can have on the way to a node: one end per grant; to root where the base is.
const FROM_DISPATCH: usize = 64;

/// The way down to a child.
#[derive(Debug, Clone)]
struct ToChild(mpsc::Sender<Input>);

impl ToChild {
    fn tell(&self, down: Down) {
        deliver(&self.0, Input::Down(down));
    }
}

/// The way up to the parent.
#[derive(Debug, Clone)]
struct ToParent(mpsc::Sender<Input>);

impl ToParent {
    fn tell(&self, up: Up) {
        deliver(&self.0, Input::Up(up));
    }
}

/// The way on which root hears of the mission's begin, of changes from outside and of the end: one, so that none overtakes
/// another, and without a bound, since they come while root waits for the log.
#[derive(Debug, Clone)]
pub(super) struct ToRoot(mpsc::UnboundedSender<Input>);

impl ToRoot {
    /// A closed inbox belongs to a run that is over.
    pub(super) fn tell(&self, told: Told) {
        drop(self.0.send(told.into()));
    }
}

/// The way from dispatch to a node, for what comes of a goal.
#[derive(Debug, Clone)]
pub(super) struct ToNode(mpsc::Sender<Input>);

impl ToNode {
    pub(super) fn ended(&self, outcome: Outcome) {
        deliver(&self.0, Input::Ended(Box::new(outcome)));
    }

    /// Where the base is while it drives. The next such message says it better, so it only takes room that nobody needs.
    pub(super) fn observed(&self, change: Change) {
        if self.0.capacity() > self.0.max_capacity() / 2 {
            drop(self.0.try_send(Input::Observed(change)));
        }
    }
}

/// Sends without waiting. A full inbox is a defect of the capacities; a closed one belongs to a run that is over.
fn deliver(to: &mpsc::Sender<Input>, input: Input) {
    if let Err(mpsc::error::TrySendError::Full(input)) = to.try_send(input) {
        panic!("an inbox of {} is full at {input:?}", to.max_capacity());
    }
}

/// What all node tasks share.
#[derive(Debug)]
pub(super) struct Surroundings {
    pub(super) mission: Arc<MissionSpec>,
    pub(super) clock: Clock,
    pub(super) dispatch: mpsc::UnboundedSender<dispatch::Input>,
    pub(super) supervisor: mpsc::UnboundedSender<Signal>,
    pub(super) journal: Option<Journal>,
    /// Whether messages between nodes are told.
    pub(super) has_messages: bool,
    /// Filled and emptied by one node at a time, within one input: one for all, since a tree has thousands.
    pub(super) outbox: Mutex<Outbox>,
}

/// An actor: a machine with its inbox and its neighbors.
#[derive(Debug)]
pub(super) struct NodeTask {
    id: NodeId,
    node: Node,
    inbox: mpsc::Receiver<Input>,
    /// Only to root.
    outside: Option<mpsc::UnboundedReceiver<Input>>,
    parent: ToParent,
    children: Vec<(NodeId, ToChild)>,
    around: Arc<Surroundings>,
}

/// Wires the machines of a tree; gives the tasks and the ways to them, both by node, and that to root.
pub(super) fn wire(nodes: Vec<Node>, around: &Arc<Surroundings>) -> (Vec<NodeTask>, Vec<ToNode>, ToRoot) {
    let (to_root, outside) = mpsc::unbounded_channel();
    let mut outside = Some(outside);
    let topology = &around.mission.tree.topology;
    let (ways, inboxes): (Vec<_>, Vec<_>) =
        (0..nodes.len()).map(|index| mpsc::channel(capacity(topology, NodeId::from(index)))).unzip();
    let tasks = std::iter::zip(nodes, inboxes).enumerate().map(|(index, (node, inbox))| {
        let id = NodeId::from(index);
        let child = |child: NodeId| (child, ToChild(ways[child.index()].clone()));
        NodeTask {
            id,
            node,
            inbox,
            // Root is the first.
            outside: outside.take(),
            parent: ToParent(ways[topology.parent(id).index()].clone()),
            children: topology.children(id).map(child).collect(),
            around: Arc::clone(around),
        }
    });
    (tasks.collect(), ways.iter().cloned().map(ToNode).collect(), ToRoot(to_root))
}

/// Each child has at most one answer on its way, and each node below at most one end per round, over two rounds.
fn capacity(topology: &Topology, id: NodeId) -> usize {
    let below = topology.end(id).index() - id.index() - 1;
    let fixed = if id == NodeId(0) || below == 0 { FROM_DISPATCH } else { 0 };
    fixed + FROM_PARENT + 3 * below
}

impl NodeTask {
    pub(super) fn id(&self) -> NodeId {
        self.id
    }

    /// Lives until the run is over. Whatever is in here, every node has.
    pub(super) async fn run(mut self) {
        match self.outside.take() {
            Some(outside) => Box::pin(self.run_root(outside)).await,
            None => {
                while let Some(input) = self.inbox.recv().await {
                    self.handle(input);
                }
            }
        }
    }

    /// Root hears of the world outside first, waits for the log, and takes its turns.
    async fn run_root(mut self, mut outside: mpsc::UnboundedReceiver<Input>) {
        loop {
            let due = self.node.deadline().map(|at| self.around.clock.instant(at));
            let input = tokio::select! {
                biased;
                Some(input) = outside.recv() => input,
                Some(input) = self.inbox.recv() => input,
                () = async { tokio::time::sleep_until(due.expect("guarded")).await }, if due.is_some() => Told::Woke.into(),
                else => return,
            };
            if let Some(journal) = &self.around.journal {
                journal.ready().await;
            }
            self.handle(input);
            // Whatever came before it is part of the turn.
            while self.node.wants_turn() && self.inbox.is_empty() && outside.is_empty() {
                self.handle(Input::Turn);
            }
        }
    }

    fn handle(&mut self, input: Input) {
        // One moment for all that comes of one input, so that no record is older than the one before it. Where nothing is
        // recorded it is asked by nobody.
        let is_recorded = self.id == NodeId(0) || self.around.has_messages;
        let now = if is_recorded { self.around.clock.now() } else { Time::ZERO };
        let around = Arc::clone(&self.around);
        let mut out = around.outbox.lock().unwrap_or_else(PoisonError::into_inner);
        // What a node left that panicked is nobody's.
        drop(out.drain());
        self.node.handle(now, input, &mut out);
        for effect in out.drain() {
            self.carry(now, effect);
        }
    }

    fn carry(&self, now: Time, effect: Effect) {
        if self.around.has_messages
            && let Some(journal) = &self.around.journal
            && let Some(record) = effect.message(now, self.id, &self.around.mission.tree.topology)
        {
            journal.write(record);
        }
        match effect {
            Effect::Down(to, down) => self.child(to).tell(down),
            Effect::Up(up) => self.parent.tell(up),
            Effect::Start(goal) => self.dispatch(dispatch::Input::Start(goal)),
            Effect::Stop(leaf) => self.dispatch(dispatch::Input::Stop(leaf)),
            Effect::Record(record) => {
                if let Some(journal) = &self.around.journal {
                    journal.write(*record);
                }
            }
            Effect::TakenUp(change, uptake) => {
                drop(self.around.supervisor.send(Signal::TakenUp(change, uptake)));
            }
            Effect::Finished(end) => drop(self.around.supervisor.send(Signal::Finished(end))),
        }
    }

    fn child(&self, id: NodeId) -> &ToChild {
        let index = self.children.binary_search_by_key(&id, |(child, _)| *child);
        &self.children[index.expect("a node tells only its children")].1
    }

    fn dispatch(&self, input: dispatch::Input) {
        drop(self.around.dispatch.send(input));
    }
}
