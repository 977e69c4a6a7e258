//! The task around the dispatch: inbox, deadline, ways to links and nodes.

use std::sync::Arc;

use tokio::sync::mpsc;

use super::clock::Clock;
use super::diagnostics::Monitors;
use super::journal_task::Journal;
use super::link_task::Order;
use super::node_task::{ToRoot, Ways};
use super::signal::Signal;
use ambidex_core::dispatch::{Dispatch, Effect, Input};
use ambidex_model::{Labels, MissionSpec, NodeId, Origin, Told};

/// The dispatch with its neighbors.
pub(super) struct DispatchTask {
    pub(super) dispatch: Dispatch,
    pub(super) inbox: mpsc::UnboundedReceiver<Input>,
    pub(super) links: Vec<mpsc::UnboundedSender<Order>>,
    pub(super) root: ToRoot,
    pub(super) nodes: Ways,
    pub(super) supervisor: mpsc::UnboundedSender<Signal>,
    pub(super) journal: Option<Journal>,
    pub(super) monitors: Monitors,
    pub(super) clock: Clock,
    /// How many objects the links have names for.
    pub(super) objects: usize,
}

impl DispatchTask {
    /// Lives until the run is over. The links were opened for the mission of the files: one that goes on may have more.
    pub(super) async fn run(mut self, mission: Arc<MissionSpec>) {
        self.rename(&mission);
        drop(mission);
        loop {
            let due = self.dispatch.deadline().map(|at| self.clock.instant(at));
            // What came in time is not late because it was not taken up yet.
            let input = tokio::select! {
                biased;
                input = self.inbox.recv() => match input {
                    Some(input) => input,
                    None => return,
                },
                () = async { tokio::time::sleep_until(due.expect("guarded")).await }, if due.is_some() => Input::Woke,
            };
            if let Input::Mission(mission) = &input {
                self.rename(mission);
            }
            for effect in self.dispatch.handle(self.clock.now(), input) {
                self.carry(effect);
            }
        }
    }

    /// Objects came into the room: the links say so what they are called.
    fn rename(&mut self, mission: &MissionSpec) {
        if mission.names.objects.len() != self.objects {
            self.objects = mission.names.objects.len();
            let labels = Arc::new(Labels::new(&mission.names));
            self.links.iter().for_each(|link| drop(link.send(Order::Know(Arc::clone(&labels)))));
        }
    }

    fn carry(&mut self, effect: Effect) {
        match effect {
            Effect::Tell(id, message) => drop(self.links[id.index()].send(Order::Tell(message))),
            Effect::Reset(id) => drop(self.links[id.index()].send(Order::Reset)),
            Effect::Ended(leaf, outcome) => {
                self.nodes.to(leaf).into_iter().for_each(|node| node.ended(outcome.clone()))
            }
            Effect::Observed(change) => self.nodes.to(NodeId(0)).into_iter().for_each(|root| root.observed(change)),
            Effect::Dropped(change) => self.root.tell(Told::World { change, origin: Origin::Dropped }),
            Effect::Reported(id, change) => {
                self.root.tell(Told::World { change, origin: Origin::Controller(id) });
            }
            Effect::Ready(said) => {
                self.root.tell(Told::Begin { changes: said });
                self.signal(Signal::Begun);
            }
            Effect::Configured(id) => self.signal(Signal::Attached(id)),
            Effect::Lost(controller, why) => {
                self.root.tell(Told::Service { controller, outage: Some(why), changes: Vec::new() });
            }
            Effect::Returned(controller, changes) => {
                self.root.tell(Told::Service { controller, outage: None, changes });
            }
            Effect::Missing(id) => self.signal(Signal::Missing(id)),
            Effect::Safe => self.signal(Signal::Safe),
            Effect::Record(record) => {
                self.monitors.note(&record);
                if let Some(journal) = &self.journal {
                    journal.write(record);
                }
            }
        }
    }

    fn signal(&self, signal: Signal) {
        drop(self.supervisor.send(signal));
    }
}
