//! Starts the tasks of a run, watches them, and ends it within a grace.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use tokio::sync::{mpsc, oneshot, watch};
use tokio::task::{AbortHandle, Id, JoinError, JoinSet};
use tokio::time::{Instant, sleep_until};

use super::clock::Clock;
use super::control::{self, Answer, Work, WorldChange};
use super::desk::{BranchReader, Desk};
use super::diagnostics::{DiagnosticsTask, Monitors};
use super::dispatch_task::DispatchTask;
use super::journal_task::{Journal, Sink};
use super::link_task::{FOREIGN_EVERY, LinkTask, Order};
use super::node_task::{Surroundings, ToRoot, Ways, lock, wire};
use super::port::Port;
use super::signal::Signal;
use ambidex_core::dispatch::{self, Dispatch, Limits, Script};
use ambidex_core::replay::Resumed;
use ambidex_core::tree::{Machines, Settings};
use ambidex_model::session::Pace;
use ambidex_model::{Change, ControllerId, Diagnostics, Loss, MissionEnd, MissionSpec, NodeId, Origin, Record, Told};

/// How long the log may take in the end to write what waits, wall time.
const WRITER_GRACE: Duration = Duration::from_secs(5);

/// How a run is carried.
pub struct Options {
    /// Allocator, rules, patience.
    pub settings: Settings,
    /// The robot clock, as the controllers know it too.
    pub clock: Clock,
    /// How long to wait for controllers, wall time; none waits for ever.
    pub attach_timeout: Option<Duration>,
    /// How long controllers may take to be safe in the end, wall time.
    pub grace: Duration,
    /// Where records go; none writes no journal.
    pub journal: Option<Box<dyn Sink>>,
    /// A run that goes on, as its log leaves it; none begins a new one.
    pub resumed: Option<Resumed>,
    /// What behaviors do wrong on purpose.
    pub script: Script,
    /// Who reads what is submitted; none where nothing is.
    pub reader: Option<Arc<dyn BranchReader>>,
    /// Where it is said each second how well controllers are.
    pub diagnostics: watch::Sender<Arc<[Diagnostics]>>,
}

/// How a run ended.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Ended {
    /// The mission came to its end.
    Mission(MissionEnd),
    /// These controllers did not attach in time.
    NotAttached(Vec<ControllerId>),
}

/// What can be told to a run from outside.
#[derive(Debug)]
pub enum Control {
    /// End the mission: goals are canceled, then the run ends.
    Cancel,
    /// The world is different, as a file of what goes wrong on purpose has it.
    World(Change),
    /// An operator says that the world is different, and is told what comes of it; nothing where the run ends first.
    Ask(WorldChange, oneshot::Sender<Answer>),
    /// Somebody asks about the work of the run, and is told what comes of it; nothing where the run ends first.
    Work(Work, oneshot::Sender<Answer>),
    /// A controller that is awaited will not come: do not wait for it before the mission begins.
    GiveUp,
    /// Abort the task of a node, as a defect would.
    Abort(NodeId),
}

/// Runs a mission over the links of its controllers, by controller, and gives how it ended.
pub async fn run(
    mission: Arc<MissionSpec>,
    links: Vec<Box<dyn Port>>,
    options: Options,
    control: mpsc::UnboundedReceiver<Control>,
) -> Ended {
    let mut resumed = options.resumed;
    let (journal, writer) = match options.journal {
        Some(sink) => {
            let (journal, writer) = Journal::new(sink);
            (Some(journal), Some(writer))
        }
        None => (None, None),
    };
    if let Some(journal) = &journal {
        match &mut resumed {
            Some(resumed) => std::mem::take(&mut resumed.missing).into_iter().for_each(|record| journal.write(record)),
            None => journal.write(Record::Header(Box::new(options.settings.header(&mission)))),
        }
    }
    let begun = resumed.unwrap_or_else(|| Resumed::fresh(&mission, &options.settings));
    // One that goes on may have more than the files: what came into the room, what was submitted.
    let mission = Arc::clone(begun.nodes.root().mission());
    let mut dispatch = Dispatch::new(&mission, begun.controllers, Limits::at_speed(options.clock.speed()));
    dispatch.follow(options.script);
    let has_cleanups = mission.tree.is_standing() || !mission.tree.topology.cleanups().is_empty();
    let cleanups = options.settings.cleanup_grace.div_f64(options.clock.speed());
    let cleanups = if has_cleanups { cleanups } else { Duration::ZERO };
    let timing = Timing { clock: options.clock, grace: options.grace, cleanups };
    let monitors = Monitors::new(mission.robot.controllers.len(), options.clock.now_ns());
    let diagnosing = DiagnosticsTask {
        mission: Arc::clone(&mission),
        monitors,
        clock: options.clock,
        journal,
        feed: options.diagnostics,
    };
    let mut supervisor = Supervisor::start(begun.nodes, options.reader, links, dispatch, timing, diagnosing, control);
    supervisor.writer = writer;
    supervisor.watch(options.attach_timeout).await
}

#[derive(Debug, Clone, Copy)]
struct Timing {
    clock: Clock,
    grace: Duration,
    /// How long cleanups may take before that, wall time.
    cleanups: Duration,
}

struct Supervisor {
    timing: Timing,
    /// Node tasks alone; the others end by their inboxes.
    tasks: JoinSet<()>,
    others: JoinSet<()>,
    ids: HashMap<Id, NodeId>,
    aborts: BTreeMap<NodeId, AbortHandle>,
    around: Arc<Surroundings>,
    desk: Desk,
    root: ToRoot,
    dispatch: mpsc::UnboundedSender<dispatch::Input>,
    signals: mpsc::UnboundedReceiver<Signal>,
    control: mpsc::UnboundedReceiver<Control>,
    journal: Option<Journal>,
    missing: BTreeSet<ControllerId>,
    end: Option<MissionEnd>,
    /// Root is being told to end for this.
    ending: Option<MissionEnd>,
    has_begun: bool,
    /// What root was asked and has not decided, in its order.
    asked: Vec<(Change, oneshot::Sender<Answer>)>,
    writer: Option<oneshot::Receiver<()>>,
}

impl Supervisor {
    fn start(
        machines: Machines,
        reader: Option<Arc<dyn BranchReader>>,
        links: Vec<Box<dyn Port>>,
        dispatch: Dispatch,
        timing: Timing,
        diagnosing: DiagnosticsTask,
        control: mpsc::UnboundedReceiver<Control>,
    ) -> Self {
        let mission = Arc::clone(machines.root().mission());
        let (journal, monitors) = (diagnosing.journal.clone(), diagnosing.monitors.clone());
        let (to_supervisor, signals) = mpsc::unbounded_channel();
        let (to_dispatch, inbox) = mpsc::unbounded_channel();
        let around = Arc::new(Surroundings {
            is_standing: mission.tree.is_standing(),
            clock: timing.clock,
            dispatch: to_dispatch.clone(),
            supervisor: to_supervisor.clone(),
            journal: journal.clone(),
            has_messages: machines.root().has_messages(),
            outbox: Mutex::default(),
            ways: Ways::default(),
            retired: Mutex::default(),
            seen: Mutex::default(),
        });
        let desk = Desk::new(&mission, machines.root().asked_for(), reader, &around, to_supervisor.clone());
        let (nodes, root) = wire(machines, &around);
        let mut others = JoinSet::new();
        let orders = spawn_links(links, timing.clock, &monitors, &to_dispatch, &mut others);
        let task = DispatchTask {
            dispatch,
            inbox,
            links: orders,
            root: root.clone(),
            nodes: around.ways.clone(),
            supervisor: to_supervisor,
            journal: journal.clone(),
            monitors,
            clock: timing.clock,
            objects: 0,
        };
        others.spawn(task.run(Arc::clone(&mission)));
        others.spawn(diagnosing.run());
        if mission.robot.controllers.is_empty() {
            root.tell(Told::Begin { changes: Vec::new() });
        }
        let mut supervisor = Self {
            timing,
            tasks: JoinSet::new(),
            others,
            ids: HashMap::new(),
            aborts: BTreeMap::new(),
            around,
            desk,
            root,
            dispatch: to_dispatch,
            signals,
            control,
            journal,
            missing: (0..mission.robot.controllers.len()).map(ControllerId::from).collect(),
            end: None,
            ending: None,
            has_begun: mission.robot.controllers.is_empty(),
            asked: Vec::new(),
            writer: None,
        };
        nodes.into_iter().for_each(|node| supervisor.spawn(node.id(), node.run()));
        supervisor
    }

    fn spawn(&mut self, node: NodeId, life: impl Future<Output = ()> + Send + 'static) {
        let handle = self.tasks.spawn(life);
        self.ids.insert(handle.id(), node);
        self.aborts.insert(node, handle);
    }

    /// Waits for the end; then for the controllers to be safe, as long as the grace allows. It counts from the moment
    /// at which the mission is told to end.
    async fn watch(mut self, attach_timeout: Option<Duration>) -> Ended {
        let attach_by = attach_timeout.map(|timeout| Instant::now() + timeout);
        let (mut safe_by, mut is_shut_down) = (None, false);
        loop {
            let attach_due = attach_by.filter(|_| !self.has_begun && self.ending.is_none());
            let is_going = self.end.is_none();
            tokio::select! {
                Some(ended) = self.tasks.join_next_with_id(), if is_going => self.task_ended(ended),
                Some(_) = self.others.join_next(), if is_going => self.finish(MissionEnd::TaskLost),
                () = ended(&mut self.writer), if is_going => self.finish(MissionEnd::TaskLost),
                Some(signal) = self.signals.recv() => {
                    if self.signaled(signal) {
                        break;
                    }
                }
                Some(control) = self.control.recv() => self.controlled(control),
                () = at(attach_due), if attach_due.is_some() => self.tell_root(MissionEnd::NotAttached),
                () = at(safe_by), if safe_by.is_some() => {
                    let cause = self.ending.unwrap_or(MissionEnd::Canceled);
                    self.finish(cause);
                    break;
                },
            }
            if self.end.is_some() || self.ending.is_some() {
                safe_by.get_or_insert_with(|| Instant::now() + self.timing.cleanups + self.timing.grace);
            }
            if self.end.is_some() && !std::mem::replace(&mut is_shut_down, true) {
                if !self.timing.cleanups.is_zero() {
                    safe_by = Some(Instant::now() + self.timing.grace);
                }
                drop(self.dispatch.send(dispatch::Input::Shutdown));
            }
        }
        self.close().await
    }

    /// Ends all tasks, the journal's last: it writes what has come until its handles are gone.
    async fn close(mut self) -> Ended {
        self.tasks.shutdown().await;
        self.others.shutdown().await;
        // With the last handle the log is told to end.
        drop((self.journal, self.around, self.desk));
        if self.writer.is_some() {
            tokio::select! {
                () = ended(&mut self.writer) => {}
                () = pause(WRITER_GRACE) => tracing::error!("the log is not written out: what it goes to takes nothing"),
            }
        }
        match self.end.expect("the watch ends with the mission") {
            MissionEnd::NotAttached => Ended::NotAttached(self.missing.into_iter().collect()),
            end => Ended::Mission(end),
        }
    }

    /// True when everything is safe.
    fn signaled(&mut self, signal: Signal) -> bool {
        match signal {
            Signal::Attached(id) => {
                self.missing.remove(&id);
            }
            Signal::Begun => self.has_begun = true,
            Signal::Finished(end) => {
                self.end.get_or_insert(end);
            }
            Signal::Missing(id) => {
                self.missing.insert(id);
            }
            Signal::TakenUp(change, uptake) => {
                // One of an earlier life of this run is asked for by nobody any more.
                if let Some(index) = self.asked.iter().position(|(asked, _)| *asked == change) {
                    let (_, answer) = self.asked.remove(index);
                    // Who asked may have gone.
                    let _ = answer.send(control::answer(&change, uptake, &self.desk.mission));
                }
            }
            Signal::Read(read) => self.desk.was_read(read, &self.root),
            Signal::Worked(number, worked) => {
                self.desk.worked(number, worked, self.journal.as_ref(), &self.root);
            }
            Signal::Mission(mission) => self.desk.mission = mission,
            Signal::Spawned(tasks) => tasks.into_iter().for_each(|task| self.spawn(task.node, task.life)),
            Signal::Safe => return true,
        }
        false
    }

    fn controlled(&mut self, control: Control) {
        match control {
            Control::Cancel => self.tell_root(MissionEnd::Canceled),
            Control::World(change) => self.root.tell(Told::World { change, origin: Origin::Script }),
            Control::Ask(asked, answer) => match asked.with_ids(&self.desk.mission.names) {
                Ok(change) => {
                    self.asked.push((change, answer));
                    self.root.tell(Told::World { change, origin: Origin::Operator });
                }
                // Who asked may have gone.
                Err(refusal) => drop(answer.send(Answer::Refused(refusal))),
            },
            Control::Work(Work::Stop, answer) => {
                self.tell_root(MissionEnd::Canceled);
                // Who asked may have gone.
                let _ = answer.send(Answer::Changed { said: "the run is told to end".into() });
            }
            Control::Work(work, answer) => self.desk.take(work, answer, &self.root),
            Control::GiveUp if !self.has_begun => self.tell_root(MissionEnd::NotAttached),
            Control::GiveUp => {}
            Control::Abort(node) => self.aborts.get(&node).into_iter().for_each(AbortHandle::abort),
        }
    }

    fn tell_root(&mut self, end: MissionEnd) {
        self.ending.get_or_insert(end);
        self.root.tell(Told::End { end });
    }

    fn task_ended(&mut self, ended: Result<(Id, ()), JoinError>) {
        let id = match &ended {
            Ok((id, ())) => *id,
            Err(error) => error.id(),
        };
        let Some(node) = self.ids.remove(&id) else { return };
        self.aborts.remove(&node);
        // One that is gone from the tree has ended in order.
        if !lock(&self.around.retired).remove(&node) {
            self.finish(MissionEnd::NodeLost(node));
        }
    }

    /// Ends the mission without root, which cannot any more: nobody decides after that.
    fn finish(&mut self, end: MissionEnd) {
        if self.end.is_none() {
            self.end = Some(end);
            self.tasks.abort_all();
            if let Some(journal) = &self.journal {
                journal.write(Record::Ended { at: self.timing.clock.now(), end });
            }
        }
    }
}

/// Starts a task per link; gives the way to each.
fn spawn_links(
    links: Vec<Box<dyn Port>>,
    clock: Clock,
    monitors: &Monitors,
    dispatch: &mpsc::UnboundedSender<dispatch::Input>,
    tasks: &mut JoinSet<()>,
) -> Vec<mpsc::UnboundedSender<Order>> {
    let spawn = |(index, link)| {
        let id = ControllerId::from(index);
        let (way, orders) = mpsc::unbounded_channel();
        let dispatch = dispatch.clone();
        let task = LinkTask {
            id,
            link,
            orders,
            dispatch: dispatch.clone(),
            clock,
            foreign: Pace::new(1, FOREIGN_EVERY),
            monitors: monitors.clone(),
        };
        tasks.spawn(async move {
            if let Err(error) = task.run().await {
                tracing::error!(target: "ambidex::controller", controller = id.0, %error, "the link broke");
                drop(dispatch.send(dispatch::Input::Lost(id, Loss::Broken)));
                // What follows from it is the mission's end; the task itself is no news.
                std::future::pending::<()>().await;
            }
        });
        way
    };
    links.into_iter().enumerate().map(spawn).collect()
}

/// Comes back when the log's thread has ended; never without one.
async fn ended(writer: &mut Option<oneshot::Receiver<()>>) {
    match writer {
        Some(ended) => {
            // Ended or panicked: in both cases it writes no more.
            let _ = ended.await;
            *writer = None;
        }
        None => std::future::pending().await,
    }
}

/// A pause of the wall clock, on which the log's thread lives too, whatever becomes of tokio's.
async fn pause(length: Duration) {
    let (over, is_over) = oneshot::channel();
    std::thread::spawn(move || {
        std::thread::sleep(length);
        // Whoever waited may have gone on.
        let _ = over.send(());
    });
    let _ = is_over.await;
}

async fn at(moment: Option<Instant>) {
    match moment {
        Some(moment) => sleep_until(moment).await,
        None => std::future::pending().await,
    }
}
