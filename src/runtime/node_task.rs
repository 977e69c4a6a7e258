//! One task per node: inbox, machine, effects out. Handles are directed: to a child only `Down`, to the parent only `Up`.
//!
//! Where tasks come and go, root starts the tasks of new nodes, and gives their parent the way to them before it is told of
//! them. A node ends when its parent has dropped that way.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use tokio::sync::mpsc;

use super::clock::Clock;
use super::journal_task::Journal;
use super::signal::{Signal, Spawned};
use ambidex_core::dispatch;
use ambidex_core::tree::{Down, Effect, Input, Machines, NODES_MAX, Node, Outbox, Up, below_root};
use ambidex_core::world::View;
use ambidex_model::{Change, NodeId, Outcome, Time, Told};

/// What a parent can have on the way to a child: a verdict, one that only stops, and the next activation; twice that.
const FROM_PARENT: usize = 8;
/// What dispatch can have on the way to a node: one end per grant; to root where the base is.
const FROM_DISPATCH: usize = 64;

/// The way down to a child.
#[derive(Debug, Clone)]
struct ToChild(mpsc::Sender<Letter>);

impl ToChild {
    fn tell(&self, down: Down) {
        deliver(&self.0, Input::Down(down));
    }
}

/// The way up to the parent. It keeps nobody alive.
#[derive(Debug, Clone)]
struct ToParent(mpsc::WeakSender<Letter>);

impl ToParent {
    fn tell(&self, up: Up) {
        if let Some(parent) = self.0.upgrade() {
            deliver(&parent, Input::Up(up));
        }
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
pub(super) struct ToNode(mpsc::Sender<Letter>);

impl ToNode {
    pub(super) fn ended(&self, outcome: Outcome) {
        deliver(&self.0, Input::Ended(Box::new(outcome)));
    }

    /// Where the base is while it drives. The next such message says it better, so it only takes room that nobody needs.
    pub(super) fn observed(&self, change: Change) {
        if self.0.capacity() > self.0.max_capacity() / 2 {
            drop(self.0.try_send(Letter::Input(Input::Observed(change))));
        }
    }
}

/// What lies in an inbox.
#[derive(Debug)]
enum Letter {
    /// Something for the machine.
    Input(Input),
    /// A child came.
    Adopt(NodeId, ToChild),
    /// A child goes.
    Disown(NodeId),
}

/// Sends without waiting. A full inbox is a defect of the capacities; a closed one belongs to a run that is over.
fn deliver(to: &mpsc::Sender<Letter>, input: Input) {
    post(to, Letter::Input(input));
}

fn post(to: &mpsc::Sender<Letter>, letter: Letter) {
    if let Err(mpsc::error::TrySendError::Full(letter)) = to.try_send(letter) {
        panic!("an inbox of {} is full at {letter:?}", to.max_capacity());
    }
}

/// The ways to all nodes that are there.
#[derive(Debug, Clone, Default)]
pub(super) struct Ways(Arc<Mutex<BTreeMap<NodeId, ToNode>>>);

impl Ways {
    /// The way to a node, if it is there.
    pub(super) fn to(&self, node: NodeId) -> Option<ToNode> {
        self.lock().get(&node).cloned()
    }

    fn lock(&self) -> MutexGuard<'_, BTreeMap<NodeId, ToNode>> {
        lock(&self.0)
    }
}

/// What all node tasks share.
#[derive(Debug)]
pub(super) struct Surroundings {
    /// Whether tasks come and go.
    pub(super) is_standing: bool,
    pub(super) clock: Clock,
    pub(super) dispatch: mpsc::UnboundedSender<dispatch::Input>,
    pub(super) supervisor: mpsc::UnboundedSender<Signal>,
    pub(super) journal: Option<Journal>,
    /// Whether messages between nodes are told.
    pub(super) has_messages: bool,
    /// Filled and emptied by one node at a time, within one input: one for all, since a tree has thousands.
    pub(super) outbox: Mutex<Outbox>,
    pub(super) ways: Ways,
    /// Nodes that are gone: their tasks may end.
    pub(super) retired: Mutex<BTreeSet<NodeId>>,
    /// What the last round saw, for whoever has to look at the world without asking.
    pub(super) seen: Mutex<Option<Arc<View>>>,
}

/// An actor: a machine with its inbox and its neighbors.
#[derive(Debug)]
pub(super) struct NodeTask {
    id: NodeId,
    parent_id: NodeId,
    node: Node,
    inbox: mpsc::Receiver<Letter>,
    /// Only to root.
    outside: Option<mpsc::UnboundedReceiver<Input>>,
    parent: ToParent,
    /// In the order of their ids.
    children: Vec<(NodeId, ToChild)>,
    around: Arc<Surroundings>,
}

/// Wires the machines of a tree; gives the tasks, and the way to root.
pub(super) fn wire(machines: Machines, around: &Arc<Surroundings>) -> (Vec<NodeTask>, ToRoot) {
    let (to_root, outside) = mpsc::unbounded_channel();
    let mut nodes = machines.into_nodes().collect::<Vec<_>>();
    let mut tasks = join(&mut nodes, around);
    // Root is the first.
    tasks[0].outside = Some(outside);
    (tasks, ToRoot(to_root))
}

/// Tasks for nodes of which each stands behind its parent, joined to each other, and to parents that are there already.
fn join(nodes: &mut Vec<(NodeId, NodeId, Node)>, around: &Arc<Surroundings>) -> Vec<NodeTask> {
    let mut ways = around.ways.lock();
    let mut below: BTreeMap<NodeId, usize> = BTreeMap::new();
    for (id, parent, _) in nodes.iter().rev().filter(|(id, ..)| id.0 > 0) {
        let count = below.get(id).copied().unwrap_or_default() + 1;
        *below.entry(*parent).or_default() += count;
    }
    let mut tasks: Vec<NodeTask> = Vec::with_capacity(nodes.len());
    let mut places: BTreeMap<NodeId, usize> = BTreeMap::new();
    for (id, parent_id, node) in nodes.drain(..) {
        let room = below.get(&id).copied().unwrap_or_default();
        let (to, inbox) = mpsc::channel(capacity(id, if around.is_standing { NODES_MAX as usize } else { room }));
        let parent = match ways.get(&parent_id) {
            Some(parent) => ToParent(parent.0.downgrade()),
            // Root is its own.
            None => ToParent(to.downgrade()),
        };
        let child = ToChild(to.clone());
        ways.insert(id, ToNode(to));
        places.insert(id, tasks.len());
        match places.get(&parent_id).filter(|_| id != parent_id) {
            Some(place) => tasks[*place].children.push((id, child)),
            None if id == parent_id => {}
            None => post(&ways[&parent_id].0, Letter::Adopt(id, child)),
        }
        let (outside, children, around) = (None, Vec::new(), Arc::clone(around));
        tasks.push(NodeTask { id, parent_id, node, inbox, outside, parent, children, around });
    }
    tasks
}

/// Each child has at most one answer on its way, and each node below at most one end per round, over two rounds; a parent
/// of tasks that come and go is told of each that does.
fn capacity(id: NodeId, below: usize) -> usize {
    let fixed = if id == NodeId(0) || below == 0 { FROM_DISPATCH } else { 0 };
    fixed + FROM_PARENT + 5 * below
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
                while let Some(letter) = self.inbox.recv().await {
                    match letter {
                        Letter::Input(input) => self.handle(input),
                        Letter::Adopt(id, child) => self.adopt(id, child),
                        Letter::Disown(id) => self.children.retain(|(child, _)| *child != id),
                    }
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
                Some(letter) = self.inbox.recv() => match letter {
                    Letter::Input(input) => input,
                    // Root has one child for good.
                    Letter::Adopt(..) | Letter::Disown(_) => continue,
                },
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
            if let Some(journal) = self.around.journal.as_ref().filter(|journal| journal.is_full())
                && let Some(saved) = self.node.save()
            {
                journal.save(self.around.clock.now(), saved);
            }
        }
    }

    fn handle(&mut self, input: Input) {
        // One moment for all that comes of one input, so that no record is older than the one before it. Where nothing is
        // recorded it is asked by nobody.
        let is_recorded = self.id == NodeId(0) || self.around.has_messages;
        let now = if is_recorded { self.around.clock.now() } else { Time::ZERO };
        let around = Arc::clone(&self.around);
        let mut out = lock(&around.outbox);
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
            && let Some(record) = effect.message(now, self.id, self.parent_id)
        {
            journal.write(record);
        }
        match effect {
            Effect::Down(to, down) => {
                if let (NodeId(0), Down::Activation(activation)) = (self.id, &down) {
                    *lock(&self.around.seen) = Some(Arc::clone(&activation.view));
                }
                self.child(to).tell(down);
            }
            Effect::Up(up) => self.parent.tell(up),
            Effect::Start(goal) => self.dispatch(dispatch::Input::Start(goal)),
            Effect::Stop(leaf) => self.dispatch(dispatch::Input::Stop(leaf)),
            Effect::Record(record) => {
                if let Some(journal) = &self.around.journal {
                    journal.write(*record);
                }
            }
            Effect::TakenUp(change, uptake) => {
                self.signal(Signal::TakenUp(change, uptake));
            }
            Effect::Worked(number, worked) => self.signal(Signal::Worked(number, worked)),
            Effect::Mission(mission) => {
                self.dispatch(dispatch::Input::Mission(Arc::clone(&mission)));
                self.signal(Signal::Mission(mission));
            }
            Effect::Spawn { nodes, mission, settings, .. } => {
                let machine = |(id, parent)| (id, parent, below_root(id, &mission, &settings));
                let mut nodes = nodes.into_iter().map(machine).collect();
                let tasks = join(&mut nodes, &self.around).into_iter();
                let spawned = tasks.map(|task| Spawned { node: task.id(), life: Box::pin(task.run()) });
                self.signal(Signal::Spawned(spawned.collect()));
            }
            Effect::Retire { under, nodes } => {
                lock(&self.around.retired).extend(&nodes);
                let mut ways = self.around.ways.lock();
                if let (Some(parent), Some(first)) = (ways.get(&under), nodes.first()) {
                    post(&parent.0, Letter::Disown(*first));
                }
                nodes.iter().for_each(|node| drop(ways.remove(node)));
            }
            Effect::Finished(end) => self.signal(Signal::Finished(end)),
        }
    }

    fn adopt(&mut self, id: NodeId, child: ToChild) {
        let place = self.children.partition_point(|(other, _)| *other < id);
        self.children.insert(place, (id, child));
    }

    fn signal(&self, signal: Signal) {
        drop(self.around.supervisor.send(signal));
    }

    fn child(&self, id: NodeId) -> &ToChild {
        let index = self.children.binary_search_by_key(&id, |(child, _)| *child);
        &self.children[index.expect("a node tells only its children")].1
    }

    fn dispatch(&self, input: dispatch::Input) {
        drop(self.around.dispatch.send(input));
    }
}

/// What a task that panicked has left is as it was.
pub(super) fn lock<T>(shared: &Mutex<T>) -> MutexGuard<'_, T> {
    shared.lock().unwrap_or_else(PoisonError::into_inner)
}
