//! Rounds of the actors: an AND of n THENs of four behaviors, in which nothing is ever granted.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use ambidex::dispatch::Script;
use ambidex::model::{
    Access, Blocked, Change, Claim, Condition, FactId, MissionEnd, MissionSpec, NodeId, NodeKind, Pose, Potential,
    Reason, Request, ResourceSpec, Retention, Selector, TypeId,
};
use ambidex::runtime::log::{JournalFile, emit};
use ambidex::runtime::{self, Clock, Control, Ended, Options, Sink};
use ambidex::tree::{Allocator, Chosen, Greedy, Offers, Settings};
use ambidex::world::View;
use tokio::sync::mpsc;
use tokio::task::JoinHandle;

use crate::mission;

const GRIPPER: TypeId = TypeId(0);
const TOGGLED: FactId = FactId(0);
const NEVER_TRUE: FactId = FactId(1);

/// What the behaviors that are asked say.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Load {
    /// All are asked, and blocked by a precondition as they were.
    Blocked,
    /// All ask for one of two grippers, each with another potential than in the last round; Algorithm 1 keeps two
    /// requests, and root's allocator grants none.
    Asking,
    /// The same, but the potential of one of the n tasks alone is another, and it is outbid as it was.
    Touching,
    /// The same, but that one outbids all others.
    Winning,
}

impl Load {
    pub const ALL: [Self; 4] = [Self::Blocked, Self::Asking, Self::Touching, Self::Winning];

    pub fn touches_all(self) -> bool {
        match self {
            Self::Blocked | Self::Asking => true,
            Self::Touching | Self::Winning => false,
        }
    }

    pub fn name(self) -> &'static str {
        match self {
            Self::Blocked => "blocked",
            Self::Asking => "asking",
            Self::Touching => "asking, one of them touched",
            Self::Winning => "asking, the best of them touched",
        }
    }
}

/// Messages between nodes in a round: activation and answer on every edge to a node that is asked.
pub fn messages(n: usize, load: Load) -> u64 {
    let tasks = if load.touches_all() { n } else { 1 };
    2 * (1 + 2 * tasks as u64)
}

/// What opens a round.
pub fn change(load: Load, is_on: bool) -> Change {
    match load {
        Load::Blocked => Change::Fact(TOGGLED, is_on),
        Load::Asking | Load::Touching | Load::Winning => {
            Change::Base(Pose::new(0.0, if is_on { 1.0 } else { 0.0 }, 0.0))
        }
    }
}

/// Those that are written: of a large tree none, as `run` has it.
pub fn told_messages(n: usize, load: Load) -> u64 {
    if has_messages(n) { messages(n, load) } else { 0 }
}

pub fn has_messages(n: usize) -> bool {
    2 + 5 * n <= 200
}

pub fn tree_of(n: usize, load: Load) -> Arc<MissionSpec> {
    let claim = Claim { selector: Selector::Any(GRIPPER), access: Access::Exclusive, keep: Retention::Release };
    let precondition = match load {
        Load::Blocked => Condition::Fact(NEVER_TRUE, true),
        Load::Asking | Load::Touching | Load::Winning => Condition::All(Vec::new()),
    };
    let mut nodes = vec![(NodeId(0), NodeKind::Root), (NodeId(0), NodeKind::And)];
    for branch in 0..n {
        let then = NodeId::from(nodes.len());
        nodes.push((NodeId(1), NodeKind::Then));
        // Never met, but it reads the fact that is toggled.
        let satisfied = Condition::All(vec![Condition::Never, Condition::Fact(TOGGLED, true)]);
        // The best requests are spread over the tree.
        let far = Pose::new(2.0 + (branch * 7919 % 1009) as f64, 0.0, 0.0);
        let touched = if load == Load::Winning { 0 } else { n - 1 };
        let potential = match load.touches_all() || branch == touched {
            true => Potential::Nearness { to: far, floor_m: 0.25, scale_by: None },
            false => Potential::Constant(1.0 / far.at.x),
        };
        let leaf = || mission::behavior(vec![claim], Vec::new(), satisfied.clone(), precondition.clone(), potential);
        nodes.extend((0..4).map(|_| (then, leaf())));
    }
    let gripper = ResourceSpec { ty: GRIPPER, controller: None, at: None };
    Arc::new(mission::build(vec![gripper; 2], Vec::new(), nodes, 2))
}

/// The greedy allocator in every AND; in root it grants nothing, and says that a round has come so far.
#[derive(Debug)]
struct Withholding {
    requests: usize,
    rounds: mpsc::UnboundedSender<u32>,
}

impl Allocator for Withholding {
    fn name(&self) -> &'static str {
        "withholding"
    }

    fn is_local(&self) -> bool {
        true
    }

    fn merge(&self, view: &View, offers: &mut Offers) -> Vec<Blocked> {
        Greedy.merge(view, offers)
    }

    fn choose(&self, view: &View, requests: &[Arc<Request>], _: &[Arc<Request>]) -> Chosen {
        assert_eq!(requests.len(), self.requests, "as many as there are grippers came up");
        self.rounds.send(view.round).expect("the bench counts rounds");
        let refuse = |request: &Arc<Request>| Blocked { leaf: request.leaf, reason: Reason::NoneFree { of: GRIPPER } };
        Chosen { refused: requests.iter().map(refuse).collect(), ..Chosen::default() }
    }
}

pub fn settings(n: usize, load: Load) -> (Settings, mpsc::UnboundedReceiver<u32>) {
    let (rounds, counted) = mpsc::unbounded_channel();
    let requests = match load {
        Load::Blocked => 0,
        Load::Asking | Load::Touching | Load::Winning => n.min(2),
    };
    let settings = Settings {
        allocator: Arc::new(Withholding { requests, rounds }),
        waits_when_stalled: true,
        has_messages: has_messages(n),
        ..Settings::default()
    };
    (settings, counted)
}

/// The actors as in production, without controllers.
pub struct Actors {
    tokio: tokio::runtime::Runtime,
    run: JoinHandle<Ended>,
    control: mpsc::UnboundedSender<Control>,
    counted: mpsc::UnboundedReceiver<u32>,
    round: u32,
    /// Records written; none without a journal.
    written: Option<Arc<AtomicU64>>,
    records: u64,
    records_per_round: u64,
    load: Load,
    is_on: bool,
    _folder: tempfile::TempDir,
}

impl Actors {
    pub fn start(n: usize, load: Load, has_journal: bool) -> Self {
        let mission = tree_of(n, load);
        let (settings, mut counted) = settings(n, load);
        // The first round asks everybody.
        let first = if load.touches_all() { load } else { Load::Asking };
        let tokio = current_thread();
        let folder = tempfile::tempdir().expect("a folder for the journal");
        let written = has_journal.then(|| Arc::new(AtomicU64::new(0)));
        let journal = written.as_ref().map(|written| sink(&mission, &folder.path().join("journal.jsonl"), written));
        let options = Options {
            reader: None,
            settings,
            clock: Clock::start(1.0),
            attach_timeout: None,
            grace: Duration::from_secs(1),
            journal,
            resumed: None,
            script: Script::default(),
            diagnostics: Default::default(),
        };
        let (control, controlled) = mpsc::unbounded_channel();
        let run = tokio.spawn(runtime::run(mission, Vec::new(), options, controlled));
        let round = tokio.block_on(counted.recv()).expect("the first round");
        Self {
            tokio,
            run,
            control,
            counted,
            round,
            written,
            // The header; then what root is told, its turn, what is different, all messages, the decision, the turn in
            // which nothing can go on; of blocked ones at first also what they wait for.
            records: 1 + told_messages(n, first) + if let Load::Blocked = load { 6 } else { 5 },
            records_per_round: told_messages(n, load) + 5,
            load,
            is_on: false,
            _folder: folder,
        }
    }

    /// A round counts from its change to its decision.
    pub fn rounds(&mut self, rounds: u64) -> Duration {
        let begun = Instant::now();
        self.tokio.block_on(async {
            for _ in 0..rounds {
                self.is_on = !self.is_on;
                self.control.send(Control::World(change(self.load, self.is_on))).expect("it runs");
                let round = self.counted.recv().await.expect("it runs");
                assert_eq!(round, self.round + 1, "rounds come one by one");
                self.round = round;
            }
            self.records += rounds * self.records_per_round;
            if let Some(written) = &self.written {
                while written.load(Ordering::Relaxed) < self.records {
                    tokio::task::yield_now().await;
                }
            }
        });
        let passed = begun.elapsed();
        if let Some(written) = &self.written {
            assert_eq!(written.load(Ordering::Relaxed), self.records, "all written");
        }
        passed
    }

    pub fn end(self) {
        self.control.send(Control::Cancel).expect("it runs");
        let ended = self.tokio.block_on(self.run).expect("it ran");
        assert_eq!(ended, Ended::Mission(MissionEnd::Canceled));
    }
}

/// What `ambidex run` does with a record, but for the terminal.
fn sink(mission: &MissionSpec, path: &Path, written: &Arc<AtomicU64>) -> Box<dyn Sink> {
    let mut file = JournalFile::create(path).expect("a journal");
    let (names, written) = (mission.names.clone(), Arc::clone(written));
    Box::new(move |record: &ambidex::model::Record| {
        file.write(record).expect("the disk takes it");
        emit(record, &names);
        written.fetch_add(1, Ordering::Relaxed);
    })
}

pub fn current_thread() -> tokio::runtime::Runtime {
    let mut builder = tokio::runtime::Builder::new_current_thread();
    builder.enable_all().build().expect("a runtime")
}
