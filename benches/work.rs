//! Work given to a busy robot: tasks submitted while others run, each read from its file, logged and answered. How long an
//! answer takes, what a round costs and what is kept, with 20 and 200 tasks alive, early and late in a long run. All of them
//! want the same three tools, so that each change is news to all; those that are paused want nothing and cost nothing.
//! Beside it what reading the file alone takes, and a bare round trip between two threads.

#[path = "support/counting.rs"]
mod counting;
#[path = "support/table.rs"]
mod table;

use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use ambidex::dispatch::Script;
use ambidex::files::{self, InMemory, TaskLoader};
use ambidex::model::{Fragment, MissionSpec, NodeId, Record, Source, SourceFile, SourceKind, WorldState};
use ambidex::runtime::control::{Answer, Submission, Work};
use ambidex::runtime::log::JournalFile;
use ambidex::runtime::{self, BranchReader, Clock, Control, Options, Sink};
use ambidex::tree::Settings;
use counting::IN_USE;
use hdrhistogram::Histogram;
use tokio::sync::{mpsc, oneshot};

/// Tasks of a run.
const TASKS: usize = 10_000;
/// Robot seconds per wall second: what a robot does in a working day is over in minutes.
const SPEED: f64 = 2_000.0;

const ROBOT: &str = "\
robot: bench
radius: 0.3 m
resources: {rail: {type: rail}, one: {type: tool}, two: {type: tool}}
controllers: {}
";

const WORLD: &str = "\
world:
  robot: {at: [0 m, 0 m]}
  places: {here: {stand: [0 m, 0 m]}}
behaviors:
  short: {label: $n, parameters: {n: text, of: {type: type, default: rail}}, claims: {it: {type: $of}}, potential: 1, takes: 2 s}
";

/// Eight nodes, five behaviors.
const TASK: &str = "\
task:
  then:
    - and: [{short: {n: a, of: tool}}, {short: {n: b, of: tool}}]
    - short: c
    - and: [{short: {n: d, of: tool}}, {short: {n: e, of: tool}}]
";

struct Reader(Mutex<TaskLoader>);

impl BranchReader for Reader {
    fn read(&self, source: &Source, mission: &MissionSpec, now: &WorldState) -> Result<Fragment, String> {
        let mut loader = self.0.lock().expect("nobody panics");
        let loaded = loader.load_source(source, mission, now).map_err(|error| error.to_string())?;
        Ok(loaded.fragment)
    }
}

/// Writes the log, and tells of tasks that are over.
struct Log {
    file: JournalFile,
    ended: mpsc::UnboundedSender<NodeId>,
    rounds: Arc<AtomicUsize>,
    bytes: Arc<AtomicUsize>,
}

impl Sink for Log {
    fn take(&mut self, record: &Record) {
        self.file.write(record).expect("the disk takes it");
        match record {
            Record::TaskEnded { task, .. } => drop(self.ended.send(*task)),
            Record::Decided { .. } => drop(self.rounds.fetch_add(1, Ordering::Relaxed)),
            _ => {}
        }
    }

    fn settle(&mut self) -> bool {
        let length = std::fs::metadata(self.file.path()).map_or(0, |about| about.len());
        self.bytes.store(length as usize, Ordering::Relaxed);
        self.file.flush().is_ok()
    }
}

fn world() -> Arc<MissionSpec> {
    let mut files = InMemory::default();
    files.insert("bench.yaml", ROBOT.to_owned());
    files.insert("world.yaml", WORLD.to_owned());
    let loaded = files::load_world(&files, Path::new("bench.yaml"), Path::new("world.yaml"), &[]);
    loaded.unwrap_or_else(|error| panic!("{error}: {:#?}", error.faults())).mission
}

fn source() -> Source {
    let file = SourceFile { path: "task.yaml".into(), same_as: None, text: TASK.into() };
    Source { kind: SourceKind::Task, mission: "task.yaml".into(), robot: None, settings: Vec::new(), files: vec![file] }
}

/// What a part of a run came to.
struct Part {
    /// Half of the answers, 99 % and all came within so many microseconds.
    answers: [u64; 3],
    took: Duration,
    rounds: usize,
    in_use: usize,
}

/// So many tasks are alive at once; so many more are paused from the start.
fn run(alive: usize, paused: usize) -> (Vec<Part>, usize) {
    let mission = world();
    let reader = Reader(Mutex::new(TaskLoader::new(&mission).expect("it was loaded")));
    let folder = tempfile::tempdir().expect("a folder");
    let (to_us, mut ended) = mpsc::unbounded_channel();
    let (rounds, bytes) = (Arc::new(AtomicUsize::new(0)), Arc::new(AtomicUsize::new(0)));
    let file = JournalFile::create(folder.path().join("journal.jsonl")).expect("a log");
    let log = Log { file, ended: to_us, rounds: Arc::clone(&rounds), bytes: Arc::clone(&bytes) };
    let options = Options {
        settings: Settings { has_messages: false, ..Settings::default() },
        clock: Clock::start(SPEED),
        attach_timeout: None,
        grace: Duration::from_secs(1),
        journal: Some(Box::new(log)),
        resumed: None,
        script: Script::default(),
        reader: Some(Arc::new(reader)),
        diagnostics: Default::default(),
    };
    let tokio = tokio::runtime::Builder::new_current_thread().enable_all().build().expect("a runtime");
    let (control, controlled) = mpsc::unbounded_channel();
    let running = tokio.spawn(runtime::run(Arc::clone(&mission), Vec::new(), options, controlled));
    // Whoever submits is another process; here it is another thread, so that it waits for its turn as such a one would.
    let submitting = std::thread::spawn(move || {
        let mut parts = Vec::new();
        let mut there = 0;
        let submit = |pause| {
            let submission = Submission { name: None, priority: None, pause, source: source() };
            let (answer, answered) = oneshot::channel();
            control.send(Control::Work(Work::Submit(submission), answer)).expect("it runs");
            let done = answered.blocking_recv().expect("it answers");
            assert!(matches!(done, Answer::Submitted { .. }), "{done:?}");
        };
        (0..paused).for_each(|_| submit(true));
        for _ in 0..10 {
            let mut answers = Histogram::<u64>::new(3).expect("three digits");
            let (begun, before) = (Instant::now(), rounds.load(Ordering::Relaxed));
            for _ in 0..TASKS / 10 {
                while there >= alive {
                    ended.blocking_recv().expect("tasks end");
                    there -= 1;
                }
                while ended.try_recv().is_ok() {
                    there -= 1;
                }
                let asked = Instant::now();
                submit(false);
                answers.record(asked.elapsed().as_micros() as u64).expect("it fits");
                there += 1;
            }
            let rounds = rounds.load(Ordering::Relaxed) - before;
            let answers = [answers.value_at_quantile(0.5), answers.value_at_quantile(0.99), answers.max()];
            let part = Part { answers, took: begun.elapsed(), rounds, in_use: IN_USE.load(Ordering::Relaxed) };
            eprintln!(
                "{alive} alive, {paused} paused: {} of {TASKS} tasks, {:.1} s",
                (parts.len() + 1) * TASKS / 10,
                part.took.as_secs_f64()
            );
            parts.push(part);
        }
        control.send(Control::Cancel).expect("it runs");
        parts
    });
    tokio.block_on(running).expect("it ran");
    (submitting.join().expect("it submitted"), bytes.load(Ordering::Relaxed))
}

/// Reading the file of a task alone, and what a message to another thread and back takes.
fn floors() -> (Duration, Duration) {
    let mission = world();
    let mut loader = TaskLoader::new(&mission).expect("it was loaded");
    let source = source();
    let begun = Instant::now();
    for _ in 0..1000 {
        loader.load_source(&source, &mission, &mission.start).expect("it reads");
    }
    let reading = begun.elapsed() / 1000;
    let (there, mut heard) = mpsc::unbounded_channel::<oneshot::Sender<()>>();
    let tokio = tokio::runtime::Builder::new_current_thread().enable_all().build().expect("a runtime");
    let answering = std::thread::spawn(move || {
        tokio.block_on(async {
            while let Some(answer) = heard.recv().await.map(|answer| answer.send(())) {
                let _ = answer;
            }
        });
    });
    let begun = Instant::now();
    for _ in 0..1000 {
        let (answer, answered) = oneshot::channel();
        there.send(answer).expect("it hears");
        answered.blocking_recv().expect("it answers");
    }
    let trip = begun.elapsed() / 1000;
    drop(there);
    answering.join().expect("it heard");
    (reading, trip)
}

fn main() {
    let (reading, trip) = floors();
    let titles = "alive|paused|tasks|answer p50 µs|p99 µs|most µs|rounds|round µs|KiB in use";
    let mut rows = vec![titles.split('|').map(str::to_owned).collect::<Vec<_>>()];
    for (alive, paused) in [(20, 0), (20, 180), (200, 0)] {
        let before = IN_USE.load(Ordering::Relaxed);
        let (parts, log) = run(alive, paused);
        for (index, part) in parts.iter().enumerate().filter(|(index, _)| matches!(index, 0 | 1 | 4 | 9)) {
            rows.push(vec![
                alive.to_string(),
                paused.to_string(),
                format!("{}", (index + 1) * TASKS / 10),
                part.answers[0].to_string(),
                part.answers[1].to_string(),
                part.answers[2].to_string(),
                part.rounds.to_string(),
                format!("{:.0}", part.took.as_secs_f64() * 1e6 / part.rounds.max(1) as f64),
                format!("{}", part.in_use.saturating_sub(before) / 1024),
            ]);
        }
        println!("{alive} alive, {paused} paused: a log of {} KiB for {TASKS} tasks", log / 1024);
    }
    table::print(&format!("{TASKS} tasks of five behaviors, submitted one by one:"), &rows);
    println!(
        "\nreading a task's file alone: {} µs; a message to another thread and back: {} µs.\n\
         round: wall time of the part, submissions included, by its rounds.",
        reading.as_micros(),
        trip.as_micros()
    );
}
