//! One round against the number of nodes: an AND of n THENs of four behaviors.
//!
//! A fact is toggled, or the base moved to and fro, which opens a round in which nothing is granted; so it can be
//! repeated for ever.
//! Beside the actors of `runtime` stand the same machines without tokio, and tokio's tasks without the machines.

#[path = "support/floor.rs"]
mod floor;
#[path = "support/mission.rs"]
mod mission;
#[path = "support/table.rs"]
mod table;

use std::collections::VecDeque;
use std::fs;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use ambidex::model::state::State;
use ambidex::model::{
    Access, Blocked, Change, Claim, Condition, FactId, MissionEnd, MissionSpec, NodeId, NodeKind, NodeRange, Pose,
    Potential, Reason, Request, ResourceSpec, Retention, Selector, Time, Told, Topology, TypeId,
};
use ambidex::runtime::log::{JournalFile, emit};
use ambidex::runtime::{self, Clock, Control, Ended, Options, Sink};
use ambidex::tree::{
    self, Activation, Allocator, Answer, Chosen, Down, Effect, Greedy, Input, Node, Offers, Outbox, Scope, Settings, Up,
};
use ambidex::world::{FreeSpace, Unconstrained, View};
use criterion::{BenchmarkId, Criterion, SamplingMode};
use floor::Floor;
use tokio::sync::mpsc;
use tokio::task::JoinHandle;

/// THENs below the AND.
const SIZES: [usize; 6] = [1, 5, 25, 125, 500, 2500];
const GRIPPER: TypeId = TypeId(0);
const TOGGLED: FactId = FactId(0);
const NEVER_TRUE: FactId = FactId(1);

/// What the behaviors that are asked say.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Load {
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
    const ALL: [Self; 4] = [Self::Blocked, Self::Asking, Self::Touching, Self::Winning];

    fn touches_all(self) -> bool {
        match self {
            Self::Blocked | Self::Asking => true,
            Self::Touching | Self::Winning => false,
        }
    }

    fn name(self) -> &'static str {
        match self {
            Self::Blocked => "blocked",
            Self::Asking => "asking",
            Self::Touching => "asking, one of them touched",
            Self::Winning => "asking, the best of them touched",
        }
    }
}

fn main() {
    if let Some(load) = std::env::args().skip_while(|arg| arg != "profile").nth(1) {
        return profile(&load);
    }
    let folder = tempfile::tempdir().expect("a folder for results");
    let mut criterion = Criterion::default()
        .output_directory(folder.path())
        .without_plots()
        .sample_size(10)
        .warm_up_time(Duration::from_millis(200))
        .measurement_time(Duration::from_millis(700))
        .configure_from_args();
    let mut group = criterion.benchmark_group("round");
    group.sampling_mode(SamplingMode::Flat);
    for n in SIZES {
        let id = |name: String| BenchmarkId::new(name, n);
        let mut floor = Floor::start(n);
        group.bench_function(id("floor".into()), |bench| {
            bench.iter_custom(|rounds| floor.rounds(rounds));
        });
        floor.end();
        for load in Load::ALL {
            let mut machines = Machines::start(n, load);
            group.bench_function(id(format!("machines {}", load.name())), |bench| {
                bench.iter_custom(|rounds| machines.rounds(rounds));
            });
            for has_journal in [false, true] {
                let name = if has_journal { "journal" } else { "actors" };
                let mut actors = Actors::start(n, load, has_journal);
                group.bench_function(id(format!("{name} {}", load.name())), |bench| {
                    bench.iter_custom(|rounds| actors.rounds(rounds));
                });
                actors.end();
            }
        }
    }
    group.finish();
    tell(folder.path());
}

/// Rounds of the machines alone, for a profiler: `round profile asking`.
fn profile(load: &str) {
    let load = Load::ALL.into_iter().find(|known| known.name() == load);
    let load = load.unwrap_or_else(|| panic!("a load is one of {:?}", Load::ALL.map(Load::name)));
    let passed = Machines::start(500, load).rounds(300);
    println!("300 rounds, {} messages in {passed:?}", 300 * messages(500, load));
}

/// Messages between nodes in a round: activation and answer on every edge to a node that is asked.
fn messages(n: usize, load: Load) -> u64 {
    let tasks = if load.touches_all() { n } else { 1 };
    2 * (1 + 2 * tasks as u64)
}

/// What opens a round.
fn change(load: Load, is_on: bool) -> Change {
    match load {
        Load::Blocked => Change::Fact(TOGGLED, is_on),
        Load::Asking | Load::Touching | Load::Winning => {
            Change::Base(Pose::new(0.0, if is_on { 1.0 } else { 0.0 }, 0.0))
        }
    }
}

/// Those that are written: of a large tree none, as `run` has it.
fn told_messages(n: usize, load: Load) -> u64 {
    if has_messages(n) { messages(n, load) } else { 0 }
}

fn has_messages(n: usize) -> bool {
    2 + 5 * n <= 200
}

fn tree_of(n: usize, load: Load) -> Arc<MissionSpec> {
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
    let gripper = ResourceSpec { ty: GRIPPER, controller: None };
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

    fn choose(&self, view: &View, requests: &[Arc<Request>]) -> Chosen {
        assert_eq!(requests.len(), self.requests, "as many as there are grippers came up");
        self.rounds.send(view.round).expect("the bench counts rounds");
        let refuse = |request: &Arc<Request>| Blocked { leaf: request.leaf, reason: Reason::NoneFree { of: GRIPPER } };
        Chosen { granted: Vec::new(), refused: requests.iter().map(refuse).collect() }
    }
}

fn settings(n: usize, load: Load) -> (Settings, mpsc::UnboundedReceiver<u32>) {
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

/// The machines, their messages delivered by a queue, as in `sim`.
struct Machines {
    nodes: Vec<Node>,
    topology: Topology,
    inbox: VecDeque<(NodeId, Input)>,
    messages: u64,
    expected: u64,
    load: Load,
    is_on: bool,
    counted: mpsc::UnboundedReceiver<u32>,
}

impl Machines {
    fn start(n: usize, load: Load) -> Self {
        let mission = tree_of(n, load);
        let (settings, counted) = settings(n, load);
        let mut machines = Self {
            nodes: tree::build(&mission, &settings),
            topology: mission.tree.topology.clone(),
            inbox: VecDeque::new(),
            messages: 0,
            expected: messages(n, load),
            load,
            is_on: false,
            counted,
        };
        machines.come_to_rest(Told::Begin { changes: Vec::new() }.into());
        machines
    }

    fn rounds(&mut self, rounds: u64) -> Duration {
        while self.counted.try_recv().is_ok() {}
        self.messages = 0;
        let begun = Instant::now();
        for _ in 0..rounds {
            self.is_on = !self.is_on;
            self.come_to_rest(Told::World { change: change(self.load, self.is_on) }.into());
        }
        let passed = begun.elapsed();
        assert_eq!(self.messages, rounds * self.expected, "all messages came");
        assert_eq!(self.counted.len() as u64, rounds, "all rounds ended");
        passed
    }

    fn come_to_rest(&mut self, input: Input) {
        let mut out = Outbox::default();
        self.inbox.push_back((NodeId(0), input));
        loop {
            let next =
                self.inbox.pop_front().or_else(|| self.nodes[0].wants_turn().then_some((NodeId(0), Input::Turn)));
            let Some((node, input)) = next else { return };
            self.nodes[node.index()].handle(Time::ZERO, input, &mut out);
            for effect in out.drain() {
                let next = match effect {
                    Effect::Down(to, down) => (to, Input::Down(down)),
                    Effect::Up(up) => (self.topology.parent(node), Input::Up(node, up)),
                    Effect::Record(_) => continue,
                    other @ (Effect::Start(_) | Effect::Stop(_) | Effect::Finished(_)) => {
                        panic!("nothing starts and nothing ends: {other:?}")
                    }
                };
                self.messages += 1;
                self.inbox.push_back(next);
            }
        }
    }
}

/// The actors as in production, without controllers.
struct Actors {
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
    fn start(n: usize, load: Load, has_journal: bool) -> Self {
        let mission = tree_of(n, load);
        let (settings, mut counted) = settings(n, load);
        // The first round asks everybody.
        let first = if load.touches_all() { load } else { Load::Asking };
        let tokio = current_thread();
        let folder = tempfile::tempdir().expect("a folder for the journal");
        let written = has_journal.then(|| Arc::new(AtomicU64::new(0)));
        let journal = written.as_ref().map(|written| sink(&mission, &folder.path().join("journal.jsonl"), written));
        let options = Options {
            settings,
            clock: Clock::start(1.0),
            attach_timeout: None,
            grace: Duration::from_secs(1),
            journal,
            resumed: None,
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
            // The header; then what root is told, its turn, what is different, all messages, the decision.
            records: 1 + told_messages(n, first) + 4,
            records_per_round: told_messages(n, load) + 4,
            load,
            is_on: false,
            _folder: folder,
        }
    }

    /// A round counts from its change to its decision.
    fn rounds(&mut self, rounds: u64) -> Duration {
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

    fn end(self) {
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

fn view_of(mission: &Arc<MissionSpec>) -> View {
    View {
        round: 1,
        now: Time::ZERO,
        touched: None,
        state: State::new(
            Arc::new(mission.tree.topology.clone()),
            mission.robot.resources.len(),
            mission.start.clone(),
        ),
        mission: Arc::clone(mission),
        free_space: Arc::new(FreeSpace::new(&mission.world.obstacles, mission.robot.radius_m)),
        rules: Arc::new(Unconstrained),
    }
}

fn current_thread() -> tokio::runtime::Runtime {
    let mut builder = tokio::runtime::Builder::new_current_thread();
    builder.enable_all().build().expect("a runtime")
}

/// One of criterion's results, by its own names.
#[derive(serde::Deserialize)]
struct Samples {
    iters: Vec<f64>,
    times: Vec<f64>,
}

/// The fastest sample per round: whatever else runs on the machine only adds to it.
fn fastest_us(results: &Path, name: &str, n: usize) -> Option<f64> {
    let file = results.join(format!("round/{name}/{n}/new/sample.json"));
    let samples: Samples = serde_json::from_str(&fs::read_to_string(file).ok()?).ok()?;
    let per_round = std::iter::zip(samples.times, samples.iters).map(|(ns, rounds)| ns / rounds);
    per_round.min_by(f64::total_cmp).map(|ns| ns / 1e3)
}

/// The table, from what criterion found.
fn tell(results: &Path) {
    let number = |value: Option<f64>, digits: usize| value.map_or("-".into(), |value| format!("{value:.digits$}"));
    let over = |a: Option<f64>, b: Option<f64>| Some(a? / b?);
    for load in Load::ALL {
        let titles = "nodes|messages|floor µs|machines µs|actors µs|journal µs|actors/floor|\
                      journal/actors|actors ns/node|actors ns/message";
        let mut rows = vec![titles.split('|').map(str::to_owned).collect::<Vec<_>>()];
        for n in SIZES {
            let of = |name: &str| fastest_us(results, &format!("{name} {}", load.name()), n);
            let (floor, actors, journal) = (fastest_us(results, "floor", n), of("actors"), of("journal"));
            let per = |count: f64| actors.map(|us| us * 1e3 / count);
            rows.push(vec![
                (2 + 5 * n).to_string(),
                messages(n, load).to_string(),
                number(floor, 1),
                number(of("machines"), 1),
                number(actors, 1),
                number(journal, 1),
                number(over(actors, floor), 2),
                number(over(journal, actors), 2),
                number(per((2 + 5 * n) as f64), 0),
                number(per(messages(n, load) as f64), 0),
            ]);
        }
        table::print(&format!("One round, behaviors {}:", load.name()), &rows);
    }
    println!(
        "\nfloor: tokio tasks and messages alone; machines: the nodes without tokio; actors: runtime without journal;\n\
         journal: with the log file. The fastest of ten samples, per round; one THEN child in four is asked, the other nodes stay silent."
    );
}
