//! Starts the tasks of a run, watches them, and ends it within a grace.

use std::collections::{BTreeSet, HashMap};
use std::sync::Arc;
use std::time::Duration;

use tokio::sync::mpsc;
use tokio::task::{AbortHandle, Id, JoinError, JoinSet};
use tokio::time::{Instant, sleep_until};

use super::clock::Clock;
use super::dispatch_task::DispatchTask;
use super::journal_task::{Journal, Sink};
use super::link_task::{LinkTask, Port};
use super::node_task::{Surroundings, ToNode, wire};
use crate::dispatch::{self, Dispatch, Limits};
use crate::model::{Change, ControllerId, Header, MissionEnd, MissionSpec, NodeId, Record, Situation};
use crate::tree::{self, Begin, Settings};

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
    pub journal: Option<Sink>,
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
#[derive(Debug, Clone, PartialEq)]
pub enum Control {
    /// End the mission: goals are canceled, then the run ends.
    Cancel,
    /// The world is different.
    World(Change),
    /// Abort the task of a node, as a defect would.
    Abort(NodeId),
}

/// What tasks tell the supervisor.
#[derive(Debug)]
pub(super) enum Signal {
    Attached(ControllerId),
    Ready(Situation),
    Finished(MissionEnd),
    Lost(ControllerId),
    Safe,
}

/// Runs a mission over the links of its controllers, by controller, and gives how it ended.
pub async fn run(
    mission: Arc<MissionSpec>,
    links: Vec<Box<dyn Port>>,
    options: Options,
    control: mpsc::UnboundedReceiver<Control>,
) -> Ended {
    let (journal, writer) = match options.journal {
        Some(sink) => {
            let (journal, writer) = Journal::new(sink);
            (Some(journal), Some(tokio::spawn(writer)))
        }
        None => (None, None),
    };
    if let Some(journal) = &journal {
        let header = Header::new(&mission, options.settings.allocator.name());
        journal.write(Record::Header(Box::new(header)));
    }
    let timing = Timing { clock: options.clock, grace: options.grace };
    let supervisor = Supervisor::start(&mission, links, &options.settings, timing, journal, control);
    let ended = supervisor.watch(options.attach_timeout).await;
    if let Some(writer) = writer {
        // All handles are gone with the supervisor, so the writer comes to its end.
        drop(writer.await);
    }
    ended
}

#[derive(Debug, Clone, Copy)]
struct Timing {
    clock: Clock,
    grace: Duration,
}

struct Supervisor {
    timing: Timing,
    /// Node tasks alone; the others end by their inboxes.
    tasks: JoinSet<()>,
    others: JoinSet<()>,
    ids: HashMap<Id, NodeId>,
    aborts: Vec<AbortHandle>,
    root: ToNode,
    dispatch: mpsc::UnboundedSender<dispatch::Input>,
    signals: mpsc::UnboundedReceiver<Signal>,
    control: mpsc::UnboundedReceiver<Control>,
    journal: Option<Journal>,
    missing: BTreeSet<ControllerId>,
    end: Option<MissionEnd>,
    is_canceled: bool,
    has_begun: bool,
}

impl Supervisor {
    fn start(
        mission: &MissionSpec,
        links: Vec<Box<dyn Port>>,
        settings: &Settings,
        timing: Timing,
        journal: Option<Journal>,
        control: mpsc::UnboundedReceiver<Control>,
    ) -> Self {
        let (to_supervisor, signals) = mpsc::unbounded_channel();
        let (to_dispatch, inbox) = mpsc::unbounded_channel();
        let around = Surroundings {
            topology: Arc::new(mission.tree.topology.clone()),
            clock: timing.clock,
            dispatch: to_dispatch.clone(),
            supervisor: to_supervisor.clone(),
            journal: journal.clone(),
        };
        let (nodes, ways) = wire(tree::build(mission, settings), &around);
        let root = ways[0].clone();
        let (mut tasks, mut others, mut ids) = (JoinSet::new(), JoinSet::new(), HashMap::new());
        let mut aborts = Vec::new();
        for node in nodes {
            let id = node.id();
            let handle = tasks.spawn(node.run());
            ids.insert(handle.id(), id);
            aborts.push(handle);
        }
        let (orders, inboxes): (Vec<_>, Vec<_>) = links.iter().map(|_| mpsc::unbounded_channel()).unzip();
        for (index, (link, orders)) in std::iter::zip(links, inboxes).enumerate() {
            let id = ControllerId::from(index);
            let task = LinkTask { id, link, orders, dispatch: to_dispatch.clone() };
            let to_dispatch = to_dispatch.clone();
            others.spawn(async move {
                if let Err(error) = task.run().await {
                    tracing::error!(target: "ambidex::controller", controller = id.0, %error, "the link broke");
                    drop(to_dispatch.send(dispatch::Input::Lost(id)));
                }
            });
        }
        let dispatch = DispatchTask {
            dispatch: Dispatch::new(mission, Limits::at_speed(timing.clock.speed())),
            inbox,
            links: orders,
            nodes: ways,
            supervisor: to_supervisor,
            journal: journal.clone(),
            clock: timing.clock,
        };
        others.spawn(dispatch.run());
        if mission.robot.controllers.is_empty() {
            root.begin(Begin { situation: mission.start.clone() });
        }
        Self {
            timing,
            tasks,
            others,
            ids,
            aborts,
            root,
            dispatch: to_dispatch,
            signals,
            control,
            journal,
            missing: (0..mission.robot.controllers.len()).map(ControllerId::from).collect(),
            end: None,
            is_canceled: false,
            has_begun: false,
        }
    }

    /// Waits for the end; then for the controllers to be safe, as long as the grace allows. It counts from the cancel.
    async fn watch(mut self, attach_timeout: Option<Duration>) -> Ended {
        let attach_by = attach_timeout.map(|timeout| Instant::now() + timeout);
        let (mut safe_by, mut is_shut_down) = (None, false);
        loop {
            let attach_due = attach_by.filter(|_| !self.has_begun && self.end.is_none());
            tokio::select! {
                Some(ended) = self.tasks.join_next_with_id(), if self.end.is_none() => self.task_ended(ended),
                Some(ended) = self.others.join_next() => carry_on(ended),
                Some(signal) = self.signals.recv() => {
                    if self.signaled(signal) {
                        break;
                    }
                }
                Some(control) = self.control.recv() => self.controlled(control),
                () = at(attach_due), if attach_due.is_some() => {
                    return Ended::NotAttached(self.missing.into_iter().collect());
                },
                () = at(safe_by), if safe_by.is_some() => {
                    self.finish(MissionEnd::Canceled);
                    break;
                },
            }
            if self.end.is_some() || self.is_canceled {
                safe_by.get_or_insert_with(|| Instant::now() + self.timing.grace);
            }
            if self.end.is_some() && !std::mem::replace(&mut is_shut_down, true) {
                drop(self.dispatch.send(dispatch::Input::Shutdown));
            }
        }
        self.tasks.shutdown().await;
        self.others.shutdown().await;
        Ended::Mission(self.end.expect("the loop ends with the mission"))
    }

    /// True when everything is safe.
    fn signaled(&mut self, signal: Signal) -> bool {
        match signal {
            Signal::Attached(id) => {
                self.missing.remove(&id);
            }
            Signal::Ready(situation) => {
                self.has_begun = true;
                self.root.begin(Begin { situation });
            }
            Signal::Finished(end) => {
                self.end.get_or_insert(end);
            }
            Signal::Lost(id) => self.finish(MissionEnd::ControllerLost(id)),
            Signal::Safe => return true,
        }
        false
    }

    fn controlled(&mut self, control: Control) {
        match control {
            Control::Cancel => {
                self.is_canceled = true;
                self.root.cancel();
            }
            Control::World(change) => self.root.world(change),
            Control::Abort(node) => self.aborts[node.index()].abort(),
        }
    }

    fn task_ended(&mut self, ended: Result<(Id, ()), JoinError>) {
        let id = match &ended {
            Ok((id, ())) => *id,
            Err(error) => error.id(),
        };
        if let Some(&node) = self.ids.get(&id) {
            self.finish(MissionEnd::NodeLost(node));
        }
    }

    /// Ends the mission for a cause outside the tree.
    fn finish(&mut self, end: MissionEnd) {
        if self.end.is_none() {
            self.end = Some(end);
            self.root.cancel();
            if let Some(journal) = &self.journal {
                journal.write(Record::Ended { at: self.timing.clock.now(), end });
            }
        }
    }
}

/// Without dispatch or a link the run would wait for ever: their panic is its own.
fn carry_on(ended: Result<(), JoinError>) {
    if let Err(error) = ended
        && error.is_panic()
    {
        std::panic::resume_unwind(error.into_panic());
    }
}

async fn at(moment: Option<Instant>) {
    match moment {
        Some(moment) => sleep_until(moment).await,
        None => std::future::pending().await,
    }
}
