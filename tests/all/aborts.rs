//! A node whose task is gone ends the run, by name and without a hang; so does a cancel that nobody heeds.

use std::sync::Arc;
use std::time::{Duration, Instant};

use ambidex::model::{Blocked, ControllerKind, MissionEnd, Mode, NodeId, Record, Rejection, Request};
use ambidex::motion::{self, Command, Controller, ControllerState, Progress};
use ambidex::runtime::{Control, Ended};
use ambidex::tree::{Allocator, Chosen, Greedy, Offers, Settings};
use ambidex::world::View;
use tokio::sync::mpsc;

use crate::fixtures::{experiment_file, load};
use crate::live;

/// Algorithm 1, which in one round tells the run to abort a node while the AND that asked it has yet to answer.
#[derive(Debug)]
struct Tripwire {
    node: NodeId,
    in_round: u32,
    control: mpsc::UnboundedSender<Control>,
}

impl Allocator for Tripwire {
    fn name(&self) -> &'static str {
        "tripwire"
    }

    fn merge(&self, view: &View, offers: &mut Offers) -> Vec<Blocked> {
        if view.round == self.in_round {
            drop(self.control.send(Control::Abort(self.node)));
        }
        Greedy.merge(view, offers)
    }

    fn choose(&self, view: &View, requests: &[Arc<Request>], wishes: &[Arc<Request>]) -> Chosen {
        Greedy.choose(view, requests, wishes)
    }
}

/// Aborts a node in the middle of that round.
fn check(node: NodeId, in_round: u32) {
    let mission = load(&experiment_file(1));
    let body = |index: usize| motion::simulated(&mission.robot.controllers[index].kind);
    let settings =
        |control| Settings { allocator: Arc::new(Tripwire { node, in_round, control }), ..Settings::default() };
    let live = live::run_with(&mission, 100.0, body, settings, |_| None);
    let name = mission.names.node(node);
    assert_eq!(live.ended, Ended::Mission(MissionEnd::NodeLost(node)), "{name}");
    let is_later = |record: &&Record| matches!(record, Record::Decided { round, .. } if *round > in_round);
    assert_eq!(live.records.iter().find(is_later), None, "{name}: no round comes after it");
    let is_of_round = |record: &&Record| matches!(record, Record::Decided { round, .. } if *round == in_round);
    if node == NodeId(0) {
        assert_eq!(live.records.iter().find(is_of_round), None, "{name}: it was in mid-round");
    }
    let end = live.records.iter().find_map(|record| match record {
        Record::Ended { end, .. } => Some(*end),
        _ => None,
    });
    assert_eq!(end, Some(MissionEnd::NodeLost(node)), "{name}: the journal tells it");
}

#[test]
fn any_node_aborted_in_the_first_round_ends_the_run_with_its_name() {
    let nodes = load(&experiment_file(1)).names.nodes.len();
    for node in 0..nodes {
        check(NodeId::from(node), 1);
    }
}

/// The third round opens when the first behavior has ended; the second one finds nothing more to grant.
#[test]
fn a_node_aborted_later_on_ends_the_run_with_its_name() {
    for node in [0, 1, 7, 8, 9, 21] {
        check(NodeId::from(node), 3);
    }
}

/// A controller that never ends what it has begun.
struct Stubborn {
    state: ControllerState,
}

impl Controller for Stubborn {
    fn configure(&mut self, _: &ControllerKind, start: ControllerState) -> ControllerState {
        self.state = start;
        start
    }

    fn start(&mut self, _: &Command, _: Mode) -> Result<(), Rejection> {
        Ok(())
    }

    fn cancel(&mut self) {}

    fn step(&mut self) -> Progress {
        Progress::Running(0.5)
    }

    fn state(&self) -> ControllerState {
        self.state
    }
}

#[test]
fn a_cancel_that_no_controller_heeds_ends_the_run_within_its_grace() {
    let mission = load(&experiment_file(1));
    let state = ControllerState::Head { angles: [0.0; 2], velocity: [0.0; 2] };
    let mut canceled: Option<Instant> = None;
    let (told, when) = std::sync::mpsc::channel();
    let cancel = move |record: &Record| {
        let starts = matches!(record, Record::Decided { granted, .. } if !granted.is_empty());
        if !starts || canceled.replace(Instant::now()).is_some() {
            return None;
        }
        told.send(Instant::now()).expect("somebody waits");
        Some(Control::Cancel)
    };
    let live = live::run(&mission, 100.0, |_| Box::new(Stubborn { state }), cancel);
    let took = live.at.duration_since(when.recv().expect("it was canceled"));
    assert_eq!(live.ended, Ended::Mission(MissionEnd::Canceled));
    assert!(took < live::GRACE + Duration::from_secs(1), "{took:?}");
    let is_end = |record: &&Record| matches!(record, Record::Ended { end: MissionEnd::Canceled, .. });
    assert_eq!(live.records.iter().filter(is_end).count(), 1);
}
