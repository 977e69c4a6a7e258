//! The runtime over controllers that are threads of this process: real shared memory, and bodies that a test can watch.

use std::os::fd::{AsFd, BorrowedFd};
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::Instant;

use ambidex::dispatch::Script;
use ambidex::link::{DaemonPort, Heard, Instance, IpcNode, Link, LinkError, fresh_epoch};
use ambidex::link::{ServeOptions, Stop, serve};
use ambidex::model::session::{Pulse, StampedPulse};
use ambidex::model::{Labels, MissionSpec, Record, Time, ToController};
use ambidex::motion::{Controller, ControllerState};
use ambidex::runtime::{self, Clock, Control, Ended, Options, Port, Readable};
use ambidex::tree::Settings;
use std::time::Duration;
use tokio::sync::mpsc;

/// How long controllers may take to come to rest in the end.
pub const GRACE: Duration = Duration::from_secs(1);
const DEADLINE: Duration = Duration::from_secs(60);

/// A body of a controller.
pub type Body = Box<dyn Controller + Send>;

/// States that a controller published, with their moments.
pub type Published = Vec<(Time, ControllerState)>;

/// What came of a run.
pub struct Live {
    pub ended: Ended,
    /// When it had ended; then the controllers were stopped.
    pub at: Instant,
    pub records: Vec<Record>,
    /// By controller.
    pub published: Vec<Published>,
}

/// Runs a mission; `watch` looks at each record, and what it gives is told to the run.
pub fn run(
    mission: &MissionSpec,
    speed: f64,
    body: impl Fn(usize) -> Body,
    watch: impl FnMut(&Record) -> Option<Control> + Send + 'static,
) -> Live {
    run_with(mission, speed, body, |_| Settings::default(), watch)
}

/// The same with settings that may tell something to the run.
pub fn run_with(
    mission: &MissionSpec,
    speed: f64,
    body: impl Fn(usize) -> Body,
    settings: impl FnOnce(mpsc::UnboundedSender<Control>) -> Settings,
    mut watch: impl FnMut(&Record) -> Option<Control> + Send + 'static,
) -> Live {
    let instance = Instance::fresh();
    let names: Vec<_> = mission.robot.controllers.iter().map(|spec| spec.name.clone()).collect();
    let mut controllers = Vec::new();
    for (index, name) in names.iter().cloned().enumerate() {
        let (stop, stopper) = Stop::by_hand().expect("a pair");
        let (instance, body) = (instance.clone(), body(index));
        let options = ServeOptions { stop: Some(stop), ..ServeOptions::default() };
        let thread = thread::spawn(move || serve(&instance, &name, body, options));
        controllers.push((thread, stopper));
    }
    let labels = Arc::new(Labels::new(&mission.names));
    let clock_and_links = || {
        let clock = Clock::start(speed);
        let place = instance.lock_daemon().expect("the daemon's place");
        let node = IpcNode::open(place).expect("a place in shared memory");
        let epoch = fresh_epoch();
        let open = |name: &String| Overheard {
            port: DaemonPort::open(&node, name, &labels, epoch, clock.origin()).expect("a link"),
            published: Arc::default(),
        };
        (clock, names.iter().map(open).collect::<Vec<_>>())
    };
    let records = Arc::new(Mutex::new(Vec::new()));
    let executor = tokio::runtime::Builder::new_current_thread().enable_all().build().expect("an executor");
    let (ended, published) = executor.block_on(async {
        let (clock, links) = clock_and_links();
        let published: Vec<_> = links.iter().map(|link| Arc::clone(&link.published)).collect();
        let links = links.into_iter().map(|link| Box::new(Readable::new(link)) as Box<dyn Port>).collect();
        let (control, controlled) = mpsc::unbounded_channel();
        let (settings, to_records) = (settings(control.clone()), Arc::clone(&records));
        let journal = Box::new(move |record: &Record| {
            if let Some(order) = watch(record) {
                drop(control.send(order));
            }
            to_records.lock().expect("no poison").push(record.clone());
        });
        let options = Options {
            reader: None,
            settings,
            clock,
            attach_timeout: Some(DEADLINE),
            grace: GRACE,
            journal: Some(journal),
            resumed: None,
            script: Script::default(),
            diagnostics: Default::default(),
        };
        // A task like the others, so that it is woken in turn with them and not after many of their steps.
        let run = tokio::spawn(runtime::run(Arc::new(mission.clone()), links, options, controlled));
        (tokio::time::timeout(DEADLINE, run).await.expect("the run hangs").expect("it does not panic"), published)
    });
    let at = Instant::now();
    for (thread, stopper) in controllers {
        stopper.stop();
        thread.join().expect("a controller does not panic").expect("it serves");
    }
    assert!(!instance.has_left_anything());
    let taken = |published: &Arc<Mutex<Published>>| std::mem::take(&mut *published.lock().expect("no poison"));
    let records = std::mem::take(&mut *records.lock().expect("no poison"));
    assert!(records.is_sorted_by_key(Record::at), "the log's time goes back");
    Live { ended, at, records, published: published.iter().map(taken).collect() }
}

/// A link that keeps the states which came over it.
struct Overheard {
    port: DaemonPort,
    published: Arc<Mutex<Published>>,
}

impl Link for Overheard {
    fn send(&mut self, message: &ToController) -> Result<(), LinkError> {
        self.port.send(message)
    }

    fn drain(&mut self) -> Vec<Heard> {
        let heard = self.port.drain();
        let states = heard.iter().filter_map(|heard| match heard {
            Heard::Pulse(StampedPulse { pulse: Pulse { generation: 1.., at, state, .. }, .. }) => Some((*at, *state)),
            Heard::Pulse(_) | Heard::Message(_) | Heard::Refused(_) => None,
            Heard::Report(_) | Heard::PassedOver(_) | Heard::Closed(_) | Heard::Broken => None,
        });
        self.published.lock().expect("no poison").extend(states);
        heard
    }

    fn beat(&mut self) {
        self.port.beat();
    }

    fn epoch(&self) -> u64 {
        self.port.epoch()
    }

    fn forget(&mut self) {
        self.port.forget();
    }

    fn know(&mut self, labels: &Arc<Labels>) {
        self.port.know(labels);
    }
}

impl AsFd for Overheard {
    fn as_fd(&self) -> BorrowedFd<'_> {
        self.port.as_fd()
    }
}
