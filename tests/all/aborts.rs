//! A node whose task is gone ends the run, by name and without a hang.

use ambidex::model::{Message, MissionEnd, NodeId, Record};
use ambidex::motion;
use ambidex::runtime::Ended;

use crate::fixtures::{experiment_file, load};
use crate::live;

/// Aborts a node when that round has just been opened.
fn check(node: NodeId, in_round: u32) {
    let mission = load(&experiment_file(1));
    let body = |index: usize| motion::simulated(&mission.robot.controllers[index].kind);
    let mut has_opened = false;
    let abort = move |record: &Record| {
        let opens = matches!(record, Record::Sent { round, message: Message::Activation, .. } if *round == in_round);
        (opens && !std::mem::replace(&mut has_opened, opens)).then_some(node)
    };
    let live = live::run(&mission, 100.0, body, abort);
    let name = mission.names.node(node);
    assert_eq!(live.ended, Ended::Mission(MissionEnd::NodeLost(node)), "{name}");
    let is_of_round = |record: &&Record| matches!(record, Record::Decided { round, .. } if *round == in_round);
    assert_eq!(live.records.iter().find(is_of_round), None, "{name}: it was in mid-round");
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
