//! Experiment 1 as records written by hand, for the tests of this room: the times are invented, the course is the
//! paper's.

use ambidex_model::*;
use ambidex_record::History;

const ROBOT: [&str; 4] = ["base", "head", "left_gripper", "right_gripper"];

pub(super) fn seconds(at_s: f64) -> Time {
    Time((at_s * 1e6).round() as u64)
}

pub(super) fn named(name: &str) -> NodeId {
    let nodes = header().names.nodes;
    NodeId::from(nodes.iter().position(|node| node == name).expect("a node of experiment 1"))
}

pub(super) fn header() -> Header {
    let list = |names: &[&str]| names.iter().map(|&name| name.to_owned()).collect();
    let entry = |parent: u32, kind: &str| NodeEntry { parent: NodeId(parent), kind: EntryKind::from(kind.to_owned()) };
    let mut nodes = vec![entry(0, "root"), entry(0, "and")];
    let mut names: Vec<String> = list(&["root", "all objects"]);
    for object in 1..=4 {
        let then = u32::try_from(nodes.len()).expect("a small tree");
        nodes.push(entry(1, "then"));
        names.push(format!("object {object}"));
        let parts = ["move", "pick", "move", "place"];
        nodes.extend(parts.map(|kind| entry(then, kind)));
        names.extend([
            format!("move {object}-1"),
            format!("pick {object}"),
            format!("move {object}-2"),
            format!("place {object}"),
        ]);
    }
    Header {
        version: JOURNAL_VERSION,
        mission: "experiment 1".into(),
        robot: "pr2".into(),
        allocator: "greedy".into(),
        nodes: nodes.into(),
        resource_types: vec![TypeId(0), TypeId(1), TypeId(2), TypeId(2)],
        movers: (0..4).map(|controller| Some(ControllerId(controller))).collect(),
        start: Some(WorldState::new(
            Pose::new(0.0, 0.0, 0.0),
            (0..4).map(|place| Location::At(PlaceId(place))).collect(),
            Vec::new(),
        )),
        names: Names {
            nodes: names.into(),
            resources: list(&ROBOT),
            types: list(&["base", "head", "gripper"]),
            channels: list(&["at shelf", "at counter", "at sink", "at cart", "at table"]),
            objects: list(&["object 1", "object 2", "object 3", "object 4"]),
            places: list(&["shelf", "counter", "sink", "cart", "table"]),
            stands: Vec::new(),
            facts: Vec::new(),
            controllers: list(&["base", "head", "left_arm", "right_arm"]),
        },
        waits_when_stalled: false,
        reattach_us: 10_000_000,
        cleanup_grace_us: 10_000_000,
        has_messages: true,
        source: None,
    }
}

pub(super) fn grant(name: &str, shared: &[u32], alone: &[u32], skips: &[&str]) -> Grant {
    let bind = |resource: &u32, access| Binding { resource: ResourceId(*resource), access, keep: Retention::Release };
    let at = Access::Shared(ChannelId(0));
    let shared = shared.iter().map(|resource| bind(resource, at));
    let alone = alone.iter().map(|resource| bind(resource, Access::Exclusive));
    let request = Request {
        leaf: named(name),
        priority: 0,
        iterations: 0,
        potential: 1.0,
        heir: false,
        claims: Vec::new(),
        changes: Vec::new(),
        skips: skips.iter().map(|&skip| NodeRange { from: named(skip), to: NodeId(named(skip).0 + 1) }).collect(),
        place: None,
        stand: None,
        spots: Vec::new(),
        distance: None,
    };
    Grant { request: request.into(), bindings: shared.chain(alone).collect(), met: Vec::new(), way: Vec::new() }
}

pub(super) fn decided(at_s: f64, round: u32, granted: Vec<Grant>) -> Record {
    Record::Decided {
        at: seconds(at_s),
        round,
        granted,
        refused: Vec::new(),
        reopened: None,
        deadlines: Vec::new(),
        urged: None,
        overdue: None,
    }
}

pub(super) fn released(at_s: f64, name: &str, end: End) -> Record {
    Record::Released {
        at: seconds(at_s),
        leaf: named(name),
        end,
        consequences: Consequences::default(),
        changes: Vec::new(),
        waits_until: None,
        unfit: Vec::new(),
    }
}

/// Experiment 1 from header to end.
pub(super) fn experiment_1() -> Vec<Record> {
    let drive = |name| grant(name, &[], &[0], &[]);
    let left = |name, skips: &[&str]| grant(name, &[0, 1], &[2], skips);
    let right = |name, skips: &[&str]| grant(name, &[0, 1], &[3], skips);
    let steps: [(f64, Vec<(Grant, f64)>); 10] = [
        (0.0, vec![(drive("move 2-1"), 7.4)]),
        (7.4, vec![(left("pick 1", &["move 1-1"]), 6.1), (right("pick 2", &[]), 6.6)]),
        (14.0, vec![(drive("move 1-2"), 5.3)]),
        (19.3, vec![(left("place 1", &[]), 5.9)]),
        (25.2, vec![(drive("move 2-2"), 14.2)]),
        (39.4, vec![(right("place 2", &[]), 5.8), (left("pick 3", &["move 3-1"]), 6.2)]),
        (45.6, vec![(drive("move 4-1"), 6.0)]),
        (51.6, vec![(right("pick 4", &[]), 6.3)]),
        (57.9, vec![(drive("move 3-2"), 13.8)]),
        (71.7, vec![(left("place 3", &[]), 5.7), (right("place 4", &["move 4-2"]), 6.0)]),
    ];
    let mut records = vec![Record::Header(Box::new(header()))];
    for (round, (at_s, step)) in (1..).zip(steps) {
        let granted = step.iter().map(|(grant, _)| grant.clone()).collect();
        records.push(decided(at_s, round, granted));
        let mut ends: Vec<(f64, NodeId)> = step.iter().map(|(grant, takes)| (at_s + takes, grant.leaf())).collect();
        ends.sort_by(|one, other| one.0.total_cmp(&other.0));
        let names = header().names;
        records.extend(ends.iter().map(|&(at_s, leaf)| released(at_s, names.node(leaf), End::Succeeded)));
    }
    records.push(Record::Ended { at: seconds(77.7), end: MissionEnd::Done });
    records
}

pub(super) fn history(records: &[Record]) -> History {
    History::of(records).expect("a header comes first")
}
