//! The rows of a trace, in groups: each is named when something is first drawn there.

use std::collections::BTreeMap;

use ambidex_model::{ControllerId, NodeId, ResourceId};
use ambidex_record::History;

use super::events::{Named, TraceEvent, Track};

/// What a row is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Row {
    /// What root decides.
    Decisions,
    /// What goes wrong.
    Failures,
    /// What is different in the world.
    World,
    /// Who holds a resource; leases at the same time have rows of their own.
    Resource(ResourceId, usize),
    /// When a resource was unavailable.
    Outage(ResourceId),
    /// What a controller was told; commands at the same time have rows of their own.
    Controller(ControllerId, usize),
    /// When anything of a task runs.
    Task(NodeId),
    /// When a behavior of a task runs.
    Behavior(NodeId, NodeId),
}

/// Groups that every mission has; those of tasks stand behind them.
const ROOT: u32 = 1;
const RESOURCES: u32 = 2;
const CONTROLLERS: u32 = 3;
const TASKS: u32 = 4;

/// What rows are called by from here on: no task has so great an id.
const ROWS: u32 = 1 << 30;

/// The rows that there are.
#[derive(Debug)]
pub(super) struct Tracks {
    rows: BTreeMap<Row, Track>,
    groups: Vec<u32>,
    /// What the next row is called by. Some viewers want no two rows to have the same number, nor one that of a group.
    next: u32,
}

impl Tracks {
    /// None yet.
    pub(super) fn new() -> Self {
        Self { rows: BTreeMap::new(), groups: Vec::new(), next: ROWS }
    }

    /// Where a row is drawn; `out` gets what names it where it is new.
    pub(super) fn track(&mut self, row: Row, history: &History, out: &mut Vec<TraceEvent>) -> Track {
        if let Some(track) = self.rows.get(&row) {
            return *track;
        }
        let (pid, group) = group(row, history);
        let track = Track { pid, tid: self.next };
        self.next += 1;
        if !self.groups.contains(&pid) {
            self.groups.push(pid);
            out.extend(TraceEvent::names(Named::Group, track, &group, pid as usize));
        }
        let (name, place) = name(row, history);
        out.extend(TraceEvent::names(Named::Row, track, &name, place));
        self.rows.insert(row, track);
        track
    }
}

fn group(row: Row, history: &History) -> (u32, String) {
    match row {
        Row::Decisions | Row::Failures | Row::World => (ROOT, history.header().mission.clone()),
        Row::Resource(..) | Row::Outage(_) => (RESOURCES, "resources".into()),
        Row::Controller(..) => (CONTROLLERS, "controllers".into()),
        Row::Task(task) | Row::Behavior(task, _) => {
            (TASKS.saturating_add(task.0), history.names().node(task).to_owned())
        }
    }
}

/// What a row is called, and where it stands in its group.
fn name(row: Row, history: &History) -> (String, usize) {
    let names = history.names();
    let of = |name: &str, index: usize, track: usize| match track {
        0 => (name.to_owned(), index << 8),
        _ => (format!("{name}, also"), (index << 8) + track),
    };
    match row {
        Row::Decisions => ("decisions".into(), 0),
        Row::Failures => ("failures".into(), 1),
        Row::World => ("world".into(), 2),
        Row::Resource(resource, track) => of(names.resource(resource), resource.index(), track),
        Row::Outage(resource) => (format!("{}, away", names.resource(resource)), (resource.index() << 8) + 0xff),
        Row::Controller(controller, track) => of(names.controller(controller), controller.index(), track),
        Row::Task(_) => ("the task".into(), 0),
        Row::Behavior(_, leaf) => (names.node(leaf).to_owned(), leaf.index()),
    }
}
