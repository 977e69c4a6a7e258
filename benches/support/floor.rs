//! The bare floor: tokio's tasks and messages without the machines.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use ambidex::model::state::State;
use ambidex::model::{Change, FactId, MissionSpec, NodeId, NodeKind, NodeRange, Origin, Time, Told};
use ambidex::tree::{Activation, Answer, Down, Input, Scope, Up};
use ambidex::world::{FreeSpace, Unconstrained, View, Ways};
use tokio::sync::mpsc;
use tokio::task::JoinHandle;

use crate::rounds::{Load, current_thread, messages, tree_of};

/// Tasks, inboxes and messages as in `runtime`, with a count of answers in place of a machine.
pub struct Floor {
    tokio: tokio::runtime::Runtime,
    tasks: Vec<JoinHandle<()>>,
    root: mpsc::Sender<Input>,
    ended: mpsc::UnboundedReceiver<()>,
    delivered: Arc<AtomicU64>,
    expected: u64,
}

struct FloorTask {
    id: NodeId,
    inbox: mpsc::Receiver<Input>,
    parent: mpsc::Sender<Input>,
    asked: Vec<mpsc::Sender<Input>>,
    waiting: usize,
    view: Arc<View>,
    skips: Arc<Vec<NodeRange>>,
    said: Arc<Answer>,
    ended: mpsc::UnboundedSender<()>,
    delivered: Arc<AtomicU64>,
}

impl Floor {
    pub fn start(n: usize) -> Self {
        let mission = tree_of(n, Load::Blocked);
        let view = Arc::new(view_of(&mission));
        let topology = &mission.tree.topology;
        let tokio = current_thread();
        let (to_bench, ended) = mpsc::unbounded_channel();
        let delivered = Arc::new(AtomicU64::new(0));
        let ids = || (0..mission.tree.nodes.len()).map(NodeId::from);
        let below = |id: NodeId| topology.nodes_below(id).count() - 1;
        let (ways, inboxes): (Vec<_>, Vec<_>) = ids().map(|id| mpsc::channel(72 + 3 * below(id))).unzip();
        let task = |(id, inbox)| {
            let asked = match mission.tree.nodes[NodeId::index(id)] {
                NodeKind::Then => 1,
                NodeKind::Root
                | NodeKind::And
                | NodeKind::Tasks
                | NodeKind::Or
                | NodeKind::Cleanup
                | NodeKind::Behavior(_) => n,
            };
            let children = topology.children(id).take(asked);
            FloorTask {
                id,
                inbox,
                parent: ways[topology.parent(id).index()].clone(),
                asked: children.map(|child| ways[child.index()].clone()).collect(),
                waiting: 0,
                view: Arc::clone(&view),
                skips: Arc::default(),
                said: Arc::default(),
                ended: to_bench.clone(),
                delivered: Arc::clone(&delivered),
            }
        };
        let tasks = std::iter::zip(ids(), inboxes).map(task);
        let tasks = tasks.map(|task| tokio.spawn(task.run())).collect();
        Self { tasks, tokio, root: ways[0].clone(), ended, delivered, expected: messages(n, Load::Blocked) }
    }

    pub fn rounds(&mut self, rounds: u64) -> Duration {
        let before = self.delivered.load(Ordering::Relaxed);
        let begun = Instant::now();
        self.tokio.block_on(async {
            for _ in 0..rounds {
                let change = Told::World { change: Change::Fact(FactId(0), true), origin: Origin::Script };
                let change = Input::from(change);
                self.root.try_send(change).expect("there is room");
                self.ended.recv().await.expect("it runs");
            }
        });
        let passed = begun.elapsed();
        let delivered = self.delivered.load(Ordering::Relaxed) - before;
        assert_eq!(delivered, rounds * self.expected, "all messages came");
        passed
    }

    pub fn end(self) {
        self.tasks.iter().for_each(JoinHandle::abort);
    }
}

impl FloorTask {
    async fn run(mut self) {
        while let Some(input) = self.inbox.recv().await {
            if !matches!(input, Input::Told(_)) {
                self.delivered.fetch_add(1, Ordering::Relaxed);
            }
            match input {
                Input::Down(down @ Down::Activation(_)) => self.activate(&down),
                Input::Down(down) => self.tell(&down),
                Input::Up(up) => self.answered(up),
                Input::Told(_) => self.activate(&Down::Activation(Activation {
                    view: Arc::clone(&self.view),
                    skips: Arc::clone(&self.skips),
                    scope: Scope::Changed,
                })),
                Input::Ended(_) | Input::Observed(_) | Input::Turn => {
                    panic!("nothing runs")
                }
            }
        }
    }

    fn activate(&mut self, down: &Down) {
        self.waiting = self.asked.len();
        self.tell(down);
        if self.waiting == 0 {
            self.answer();
        }
    }

    fn answered(&mut self, up: Up) {
        assert!(matches!(up, Up::Answer { .. }), "nothing runs");
        self.waiting -= 1;
        if self.waiting == 0 {
            self.answer();
        }
    }

    fn answer(&self) {
        if self.id == NodeId(0) {
            self.ended.send(()).expect("the bench counts rounds");
        } else {
            let up = Input::Up(Up::Answer { from: self.id, round: 0, answer: Arc::clone(&self.said), news: None });
            self.parent.try_send(up).expect("there is room");
        }
    }

    fn tell(&self, down: &Down) {
        for child in &self.asked {
            let input = Input::Down(down.clone());
            child.try_send(input).expect("there is room");
        }
    }
}

fn view_of(mission: &Arc<MissionSpec>) -> View {
    View {
        round: 1,
        now: Time::ZERO,
        touched: None,
        barred: Arc::default(),
        state: State::new(
            Arc::new(mission.tree.topology.clone()),
            mission.robot.resources.len(),
            mission.start.clone(),
        ),
        mission: Arc::clone(mission),
        ways: Arc::new(Ways::new(&Arc::new(FreeSpace::of(mission)), mission.start.base)),
        rules: Arc::new(Unconstrained),
    }
}
