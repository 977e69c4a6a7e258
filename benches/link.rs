//! From a controller's result to the next goal seen in another process: port, wake, dispatch, round, and back.
//!
//! Beside it, in the same run, two processes exchange the same two messages over bare iceoryx2 through a third.

#[path = "support/mission.rs"]
mod mission;
#[path = "support/table.rs"]
mod table;

use std::io::{BufRead, BufReader, Read};
use std::path::Path;
use std::process::{Child, ChildStdout, Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use ambidex::dispatch::Script;
use ambidex::link::wire::{WireRequest, WireResponse};
use ambidex::link::{DaemonPort, Instance, IpcNode, fresh_epoch, monotonic_ns, sweep};
use ambidex::link::{ServeOptions, serve};
use ambidex::model::{
    self, Access, Claim, CommandTerm, Condition, ControllerId, ControllerKind, ControllerSpec, HeadSpec, Labels,
    MissionEnd, MissionSpec, Mode, NodeId, NodeKind, PartEnd, Potential, Rejection, ResourceId, ResourceSpec,
    Retention, Selector, Task, TypeId,
};
use ambidex::motion::{self, Controller, ControllerState, Progress};
use ambidex::runtime::log::{JournalFile, emit};
use ambidex::runtime::{self, Clock, Ended, Options, Port, Readable, Sink};
use ambidex::tree::Settings;
use hdrhistogram::Histogram;
use iceoryx2::active_request::ActiveRequest;
use iceoryx2::pending_response::PendingResponse;
use iceoryx2::port::{client::Client, listener::Listener, notifier::Notifier, server::Server};
use iceoryx2::prelude::{
    Config, FileDescriptorBased, FileName, Node, NodeBuilder, Path as TransportPath, SemanticString, ServiceName,
    SignalHandlingMode, ipc_threadsafe,
};
use rustix::event::{PollFd, PollFlags, poll};
use rustix::process::{Signal, set_parent_process_death_signal};
use tokio::io::Interest;
use tokio::io::unix::AsyncFd;

/// Goals of one mission, each on the other controller than the one before.
const GOALS: usize = 400;
/// How often each way is measured; they take turns.
const TURNS: usize = 3;
/// How long a controller works on a goal: at this speed its step takes as long.
const WORK: Duration = Duration::from_millis(1);
const SPEED: f64 = 10.0;
const NAMES: [&str; 2] = ["one", "other"];
const SHARED_MEMORY: &str = "/dev/shm";
/// Nothing takes that long.
const BOUND_NS: u64 = 10_000_000_000;

type Transport = ipc_threadsafe::Service;

fn main() {
    let args: Vec<String> = std::env::args().collect();
    match args.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        [_, "as-controller", instance, name] => return be_controller(instance, name),
        [_, "as-bare", folder, name] => return be_bare(Path::new(folder), name),
        _ => {}
    }
    let (mut bare, mut plain, mut logged) = (histogram(), histogram(), histogram());
    for _ in 0..TURNS {
        measure_bare(&mut bare);
        measure_runtime(&mut plain, false);
        measure_runtime(&mut logged, true);
    }
    for histogram in [&bare, &plain, &logged] {
        assert_eq!(histogram.len(), (TURNS * (GOALS - 1)) as u64);
    }
    tell(&[("bare iceoryx2", &bare), ("ambidex", &plain), ("ambidex, journal on disk", &logged)]);
}

fn histogram() -> Histogram<u64> {
    Histogram::new_with_bounds(1, BOUND_NS, 3).expect("sound bounds")
}

fn tell(measured: &[(&str, &Histogram<u64>)]) {
    let titles = "way|exchanges|p50 µs|p95 µs|p99 µs|p50/bare|p95/bare|p99/bare";
    let mut rows = vec![titles.split('|').map(str::to_owned).collect::<Vec<_>>()];
    let quantiles = [0.5, 0.95, 0.99];
    for (name, histogram) in measured {
        let us = |q| histogram.value_at_quantile(q) as f64 / 1e3;
        let bare = |q| measured[0].1.value_at_quantile(q) as f64 / 1e3;
        let mut row = vec![(*name).to_owned(), histogram.len().to_string()];
        row.extend(quantiles.map(|q| format!("{:.0}", us(q))));
        row.extend(quantiles.map(|q| format!("{:.2}", us(q) / bare(q))));
        rows.push(row);
    }
    table::print("From a result to the next goal in another process:", &rows);
    println!(
        "\nbare: result to a third process, which wakes on its descriptor in tokio and sends the next goal to the other;\n\
         ambidex: the same way with dispatch, journal, a release, a round and a grant in the third process."
    );
}

/// When goals were seen, and when they were ended, one of each per goal, nanoseconds of the system's clock.
#[derive(Debug, Default)]
struct Moments {
    seen_ns: Vec<u64>,
    ended_ns: Vec<u64>,
}

impl Moments {
    /// What a child tells in the end.
    fn print(&self) {
        for (seen, ended) in std::iter::zip(&self.seen_ns, &self.ended_ns) {
            println!("{seen} {ended}");
        }
    }

    /// What a child told.
    fn read(text: &str) -> Self {
        let mut moments = Self::default();
        for line in text.lines() {
            let (seen, ended) = line.split_once(' ').expect("two moments");
            moments.seen_ns.push(seen.parse().expect("a number"));
            moments.ended_ns.push(ended.parse().expect("a number"));
        }
        assert_eq!(moments.seen_ns.len(), GOALS / 2, "every goal was seen");
        moments
    }
}

/// Goals went to the two by turns: each result of one is followed by the next goal of the other.
fn take_up(histogram: &mut Histogram<u64>, [one, other]: &[Moments; 2]) {
    for turn in 0..GOALS / 2 {
        let mut pairs = vec![(one.ended_ns[turn], other.seen_ns[turn])];
        if turn + 1 < GOALS / 2 {
            pairs.push((other.ended_ns[turn], one.seen_ns[turn + 1]));
        }
        for (ended, seen) in pairs {
            assert!(ended < seen, "a goal came before the result that it follows");
            histogram.record(seen - ended).expect("within bounds");
        }
    }
}

fn child(args: [&str; 3]) -> Child {
    let program = std::env::current_exe().expect("this program");
    let mut command = Command::new(program);
    command.args(args).stdin(Stdio::null()).stdout(Stdio::piped());
    command.spawn().expect("a child")
}

fn outcome_of(mut child: Child, mut stdout: impl Read) -> Moments {
    let mut text = String::new();
    stdout.read_to_string(&mut text).expect("what it tells");
    assert!(child.wait().expect("it ends").success());
    Moments::read(&text)
}

// The runtime's way.

/// Ends every goal in its first step.
struct Player<'a> {
    moments: &'a mut Moments,
    is_busy: bool,
}

impl Controller for Player<'_> {
    fn configure(&mut self, _: &ControllerKind, start: ControllerState) -> ControllerState {
        start
    }

    fn start(&mut self, _: &motion::Command, _: Mode) -> Result<(), Rejection> {
        self.moments.seen_ns.push(monotonic_ns());
        self.is_busy = true;
        Ok(())
    }

    fn cancel(&mut self) {}

    fn step(&mut self) -> Progress {
        if !std::mem::take(&mut self.is_busy) {
            return Progress::Idle;
        }
        self.moments.ended_ns.push(monotonic_ns());
        Progress::Ended(PartEnd::Succeeded)
    }

    fn state(&self) -> ControllerState {
        ControllerState::Head { angles: [0.0; 2], velocity: [0.0; 2] }
    }
}

fn be_controller(instance: &str, name: &str) {
    let instance = Instance::new(instance).expect("a name");
    let mut moments = Moments::default();
    let player = Player { moments: &mut moments, is_busy: false };
    let options =
        ServeOptions { once: true, parent: std::os::unix::process::parent_id().into(), ..ServeOptions::default() };
    serve(&instance, name, player, options).expect("it serves");
    moments.print();
}

fn measure_runtime(histogram: &mut Histogram<u64>, has_journal: bool) {
    sweep().expect("shared memory");
    let instance = Instance::fresh();
    let mission = Arc::new(goals_by_turns());
    let folder = tempfile::tempdir().expect("a folder for the journal");
    let written = Arc::new(AtomicU64::new(0));
    let journal = has_journal.then(|| sink(&mission, folder.path(), &written));
    let mut children = NAMES.map(|name| child(["as-controller", instance.name(), name]));
    let tokio = current_thread();
    let ended = tokio.block_on(async {
        let clock = Clock::start(SPEED);
        let lock = instance.lock_daemon().expect("a fresh instance");
        let node = IpcNode::open(lock).expect("shared memory");
        let epoch = fresh_epoch();
        let labels = Arc::new(Labels::new(&mission.names));
        let links = NAMES.map(|name| {
            let port = DaemonPort::open(&node, name, &labels, epoch, clock.origin());
            Box::new(Readable::new(port.expect("a port"))) as Box<dyn Port>
        });
        let options = Options {
            reader: None,
            settings: Settings::default(),
            clock,
            attach_timeout: Some(Duration::from_secs(10)),
            grace: Duration::from_secs(1),
            journal,
            resumed: None,
            script: Script::default(),
            diagnostics: Default::default(),
        };
        let (_control, controlled) = tokio::sync::mpsc::unbounded_channel();
        runtime::run(mission, links.into(), options, controlled).await
    });
    assert_eq!(ended, Ended::Mission(MissionEnd::Done));
    let stdouts = children.each_mut().map(stdout_of);
    let both: Vec<_> = std::iter::zip(children, stdouts).map(|(child, stdout)| outcome_of(child, stdout)).collect();
    take_up(histogram, &both.try_into().expect("two controllers"));
    let records = written.load(Ordering::Relaxed);
    assert!(!has_journal || records > 10 * GOALS as u64, "{records} records");
    sweep().expect("shared memory");
    assert!(!instance.has_left_anything(), "nothing is left behind");
}

/// A THEN of goals by turns.
fn goals_by_turns() -> MissionSpec {
    let kind = ControllerKind::Head(HeadSpec { neck: [0.0; 3].into(), speed: 1.0, acceleration: 1.0 });
    let controllers = NAMES.map(|name| ControllerSpec {
        name: name.into(),
        kind,
        cancel_grace: Duration::from_secs(5),
        radius_m: None,
        hand_m: 0.0,
        reports: Default::default(),
    });
    let resource =
        |index: usize| ResourceSpec { ty: TypeId::from(index), controller: Some(ControllerId::from(index)), at: None };
    let goal = |index: usize| {
        let claim = Claim {
            selector: Selector::Named(ResourceId::from(index % 2)),
            access: Access::Exclusive,
            keep: Retention::Release,
        };
        let command = CommandTerm { claim: 0, mode: Mode::Achieve, task: Task::Stand };
        let always = Condition::All(Vec::new());
        (NodeId(1), mission::behavior(vec![claim], vec![command], Condition::Never, always, Potential::Constant(1.0)))
    };
    let mut nodes = vec![(NodeId(0), NodeKind::Root), (NodeId(0), NodeKind::Then)];
    nodes.extend((0..GOALS).map(goal));
    mission::build([0, 1].map(resource).into(), controllers.into(), nodes, 0)
}

/// What `ambidex run` does with a record, but for the terminal.
fn sink(mission: &MissionSpec, folder: &Path, written: &Arc<AtomicU64>) -> Box<dyn Sink> {
    let mut file = JournalFile::create(folder.join("journal.jsonl")).expect("a journal");
    let (names, written) = (mission.names.clone(), Arc::clone(written));
    Box::new(move |record: &model::Record| {
        file.write(record).expect("the disk takes it");
        emit(record, &names);
        written.fetch_add(1, Ordering::Relaxed);
    })
}

// The bare way.

/// What both ends of a bare exchange have.
struct Place {
    node: Node<Transport>,
    name: String,
}

impl Place {
    fn new(folder: &Path, name: &str) -> Self {
        let mut config = Config::default();
        let prefix = prefix_of(folder);
        config.global.prefix = FileName::new(prefix.as_bytes()).expect("a prefix");
        let root = TransportPath::new(folder.as_os_str().as_encoded_bytes()).expect("a path");
        config.global.set_root_path(&root);
        let node = NodeBuilder::new()
            .config(&config)
            .signal_handling_mode(SignalHandlingMode::Disabled)
            .create()
            .expect("a node");
        let name = name.to_owned();
        Self { node, name }
    }

    fn service(&self, what: &str) -> ServiceName {
        ServiceName::new(&format!("{}/{what}", self.name)).expect("a name")
    }

    fn goals(
        &self,
    ) -> iceoryx2::service::port_factory::request_response::PortFactory<Transport, WireRequest, (), WireResponse, ()>
    {
        let service = self.node.service_builder(&self.service("goals"));
        let goals = service.request_response::<WireRequest, WireResponse>();
        goals.open_or_create().expect("a service")
    }

    fn listener(&self, what: &str) -> Listener<Transport> {
        let service = self.node.service_builder(&self.service(what)).event();
        let service = service.open_or_create().expect("a service");
        service.listener_builder().create().expect("a listener")
    }

    fn notifier(&self, what: &str) -> Notifier<Transport> {
        let service = self.node.service_builder(&self.service(what)).event();
        let service = service.open_or_create().expect("a service");
        service.notifier_builder().create().expect("a notifier")
    }
}

fn prefix_of(folder: &Path) -> String {
    let name = folder.file_name().expect("a name").to_string_lossy();
    format!("{}_", name.trim_start_matches('.'))
}

fn be_bare(folder: &Path, name: &str) {
    set_parent_process_death_signal(Some(Signal::KILL)).expect("it ends with its parent");
    let place = Place::new(folder, name);
    let (listener, notifier) = (place.listener("down"), place.notifier("up"));
    let server: Server<Transport, WireRequest, (), WireResponse, ()> =
        place.goals().server_builder().create().expect("a server");
    println!("ready");
    let mut moments = Moments::default();
    while moments.ended_ns.len() < GOALS / 2 {
        let request: ActiveRequest<Transport, WireRequest, (), WireResponse, ()> = loop {
            listener.try_wait(|_| {}).expect("it hears");
            if let Some(request) = server.receive().expect("it receives") {
                break request;
            }
            // SAFETY: the descriptor is the listener's, which lives as long as this function.
            let fd = unsafe { listener.file_descriptor().native_handle() };
            let fd = unsafe { std::os::fd::BorrowedFd::borrow_raw(fd) };
            poll(&mut [PollFd::from_borrowed_fd(fd, PollFlags::IN)], None).expect("it waits");
        };
        assert_eq!(request.payload().path_len, 7, "the payload came");
        moments.seen_ns.push(monotonic_ns());
        std::thread::sleep(WORK);
        moments.ended_ns.push(monotonic_ns());
        request.send_copy(WireResponse::default()).expect("it sends");
        drop(request);
        notifier.notify().expect("it wakes");
    }
    moments.print();
}

/// The third process's side of a bare exchange.
struct Peer {
    client: Client<Transport, WireRequest, (), WireResponse, ()>,
    listener: Listener<Transport>,
    readable: AsyncFd<std::os::fd::OwnedFd>,
    notifier: Notifier<Transport>,
    _place: Place,
}

impl Peer {
    fn new(folder: &Path, name: &str) -> Self {
        let place = Place::new(folder, name);
        let listener = place.listener("up");
        // SAFETY: the descriptor is the listener's, which is alive, and is duplicated at once.
        let fd = unsafe { listener.file_descriptor().native_handle() };
        let fd = unsafe { std::os::fd::BorrowedFd::borrow_raw(fd) };
        let fd = fd.try_clone_to_owned().expect("a descriptor");
        // SAFETY: the `AsyncFd` is the only owner of the duplicate, and drops it last.
        let readable = unsafe { AsyncFd::register_with_interest(fd, Interest::READABLE) };
        Self {
            client: place.goals().client_builder().create().expect("a client"),
            readable: readable.map_err(std::io::Error::from).expect("watched"),
            notifier: place.notifier("down"),
            listener,
            _place: place,
        }
    }

    /// Sends a goal and waits for its result.
    async fn exchange(&self) {
        let goal = WireRequest { path_len: 7, ..WireRequest::default() };
        let pending: PendingResponse<Transport, WireRequest, (), WireResponse, ()> =
            self.client.send_copy(goal).expect("it sends");
        assert_eq!(pending.number_of_server_connections(), 1, "it is there");
        self.notifier.notify().expect("it wakes");
        loop {
            let mut ready = self.readable.readable().await.expect("it waits");
            ready.clear_ready();
            self.listener.try_wait(|_| {}).expect("it hears");
            if pending.receive().expect("it receives").is_some() {
                return;
            }
        }
    }
}

fn measure_bare(histogram: &mut Histogram<u64>) {
    let shared = Shared::new();
    let path = shared.folder.path().to_str().expect("plain letters");
    let mut children = NAMES.map(|name| child(["as-bare", path, name]));
    let mut stdouts = children.each_mut().map(stdout_of);
    for stdout in &mut stdouts {
        let mut line = String::new();
        stdout.read_line(&mut line).expect("it speaks");
        assert_eq!(line, "ready\n");
    }
    let tokio = current_thread();
    tokio.block_on(async {
        let peers = NAMES.map(|name| Peer::new(shared.folder.path(), name));
        for turn in 0..GOALS {
            peers[turn % 2].exchange().await;
        }
    });
    let both: Vec<_> = std::iter::zip(children, stdouts).map(|(child, stdout)| outcome_of(child, stdout)).collect();
    take_up(histogram, &both.try_into().expect("two peers"));
}

/// Where bare exchanges have their files; dropping removes them.
struct Shared {
    folder: tempfile::TempDir,
}

impl Shared {
    fn new() -> Self {
        let mut named = tempfile::Builder::new();
        let root = Path::new(SHARED_MEMORY);
        let folder = named.prefix("ambidexbench").tempdir_in(root);
        Self { folder: folder.expect("a folder in shared memory") }
    }
}

impl Drop for Shared {
    fn drop(&mut self) {
        // A transport leaves its management segment even when all its nodes have ended in order.
        let prefix = prefix_of(self.folder.path());
        let entries = std::fs::read_dir(SHARED_MEMORY).into_iter().flatten();
        for entry in entries.flatten() {
            if entry.file_name().to_string_lossy().starts_with(&prefix) {
                drop(std::fs::remove_file(entry.path()));
            }
        }
    }
}

fn stdout_of(child: &mut Child) -> BufReader<ChildStdout> {
    BufReader::new(child.stdout.take().expect("piped"))
}

fn current_thread() -> tokio::runtime::Runtime {
    let mut builder = tokio::runtime::Builder::new_current_thread();
    builder.enable_all().build().expect("a runtime")
}
