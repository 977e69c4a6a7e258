//! One round against the number of nodes: an AND of n THENs of four behaviors.
//!
//! A fact is toggled, or the base moved to and fro, which opens a round in which nothing is granted; so it can be
//! repeated for ever.
//! Beside the actors of `runtime` stand the same machines without tokio, and tokio's tasks without the machines.

#[path = "support/floor.rs"]
mod floor;
#[path = "support/mission.rs"]
mod mission;
#[path = "support/rounds.rs"]
mod rounds;
#[path = "support/table.rs"]
mod table;

use std::collections::VecDeque;
use std::fs;
use std::path::Path;
use std::time::{Duration, Instant};

use ambidex::model::{NodeId, Origin, Time, Told, Topology};
use ambidex::tree::{self, Effect, Input, Node, Outbox};
use criterion::{BenchmarkId, Criterion, SamplingMode};
use floor::Floor;
use rounds::{Actors, Load, change, messages, settings, tree_of};
use tokio::sync::mpsc;

/// THENs below the AND.
const SIZES: [usize; 6] = [1, 5, 25, 125, 500, 2500];

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
            self.come_to_rest(Told::World { change: change(self.load, self.is_on), origin: Origin::Script }.into());
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
                    Effect::Up(up) => (self.topology.parent(node), Input::Up(up)),
                    Effect::Record(_) => continue,
                    Effect::Worked(..) | Effect::Mission(_) | Effect::Spawn { .. } | Effect::Retire { .. } => {
                        unreachable!("a mission's tree stays as it is")
                    }
                    other @ (Effect::Start(_) | Effect::Stop(_) | Effect::TakenUp(..) | Effect::Finished(_)) => {
                        panic!("nothing starts and nothing ends: {other:?}")
                    }
                };
                self.messages += 1;
                self.inbox.push_back(next);
            }
        }
    }
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
