//! A run as trace events: who held which resource, what controllers were told, when behaviors ran, what root decided, and
//! what went wrong.

use std::collections::BTreeMap;

use ambidex_model::{
    Change, ControllerMessage, End, FromController, Grant, Header, LeaseKind, Level, MissionEnd, NodeId, Record,
    ResourceId, Time,
};
use ambidex_record::{Held, History, Lane, format};
use serde_json::{Map, Value, json};

use super::attempts::{Attempt, Attempts, task_of};
use super::cells;
use super::commands::{CommandSpan, Commands, Step};
use super::events::{TraceEvent, args};
use super::tracks::{Row, Tracks};
use crate::live;

/// Makes the events of a run of its records. Its times are since the mission began; what was before is at 0.
#[derive(Debug)]
pub struct Trace {
    history: History,
    tracks: Tracks,
    attempts: Attempts,
    commands: Commands,
    lanes: Vec<Lane>,
    /// How many behaviors of each task run.
    running: BTreeMap<NodeId, usize>,
}

impl Trace {
    /// Nothing has happened yet.
    pub fn new(header: &Header) -> Self {
        let history = History::new(header);
        Self {
            tracks: Tracks::new(),
            lanes: vec![Lane::default(); header.names.resources.len()],
            history,
            attempts: Attempts::default(),
            commands: Commands::default(),
            running: BTreeMap::new(),
        }
    }

    /// The events that come of the next record.
    pub fn take(&mut self, record: &Record) -> Vec<TraceEvent> {
        let mut out = Vec::new();
        let attempts = self.attempts.take(&self.history, record);
        for attempt in attempts.ended {
            self.end_attempt(&attempt, &mut out);
        }
        for attempt in attempts.begun {
            self.begin_attempt(&attempt, &mut out);
        }
        for step in self.commands.take(&self.history, record) {
            match step {
                Step::Begun(span) => self.begin_command(&span, &mut out),
                Step::Joined(span, leaf) => self.point(leaf, &span, self.history.moment(record.at()), &mut out),
                Step::Ended(span) => self.end_command(&span, &mut out),
            }
        }
        if let Record::Resource { resource, state, at } = record {
            let now = self.history.moment(*at);
            if let Some(lane) = self.lanes.get_mut(resource.index()) {
                lane.change(now, state);
                let past = lane.take_past();
                self.draw_lane(*resource, &past, now, &mut out);
            }
        }
        self.history.apply(record);
        self.mark(record, &mut out);
        out
    }

    /// What goes on at the end of the log, up to its last moment.
    pub fn finish(mut self) -> Vec<TraceEvent> {
        let (mut out, now) = (Vec::new(), self.history.now());
        for span in std::mem::take(&mut self.commands).into_open() {
            self.end_command(&span, &mut out);
        }
        for attempt in std::mem::take(&mut self.attempts).into_open() {
            self.end_attempt(&attempt, &mut out);
        }
        for (index, lane) in std::mem::take(&mut self.lanes).iter().enumerate() {
            self.draw_lane(ResourceId::from(index), lane, now, &mut out);
        }
        out
    }

    fn begin_attempt(&mut self, attempt: &Attempt, out: &mut Vec<TraceEvent>) {
        let (grant, at_us) = (&attempt.grant, attempt.granted.0);
        let (leaf, task) = (grant.leaf(), task_of(&self.history, grant.leaf()));
        let names = self.history.names();
        let running = self.running.entry(task).or_default();
        *running += 1;
        if *running == 1 && task != leaf {
            let track = self.tracks.track(Row::Task(task), &self.history, out);
            out.push(TraceEvent::begin(at_us, track, "task", names.node(task).to_owned()));
        }
        let track = self.tracks.track(Row::Behavior(task, leaf), &self.history, out);
        let event = TraceEvent::begin(at_us, track, "behavior", names.node(leaf).to_owned());
        let waited_for = attempt.waited_for.as_ref().map(|reason| reason.sentence(names));
        out.push(event.with(args([
            ("kind", json!(self.history.header().nodes.get(leaf.index()).map(|node| node.kind.word()))),
            ("attempt", json!(attempt.number)),
            ("round", json!(attempt.round)),
            ("potential", json!(grant.request.potential)),
            ("waited for", json!(waited_for)),
            ("resources", json!(cells::resources(grant, names))),
            ("objects", json!(cells::objects(grant, names))),
            ("place", json!(cells::place(grant, names))),
        ])));
    }

    fn end_attempt(&mut self, attempt: &Attempt, out: &mut Vec<TraceEvent>) {
        let (leaf, task) = (attempt.grant.leaf(), task_of(&self.history, attempt.grant.leaf()));
        let names = self.history.names();
        let at_us = attempt.ended.map_or(self.history.now(), |(at, _)| at).0;
        let (end, fault) =
            attempt.ended.map_or(("", String::new()), |(_, end)| (cells::end(end), cells::fault(end, names)));
        let track = self.tracks.track(Row::Behavior(task, leaf), &self.history, out);
        let event = TraceEvent::end(at_us, track, "behavior", names.node(leaf).to_owned());
        out.push(event.with(args([("end", json!(end)), ("fault", json!(fault))])));
        let running = self.running.entry(task).or_default();
        *running = running.saturating_sub(1);
        if *running == 0 && task != leaf {
            let track = self.tracks.track(Row::Task(task), &self.history, out);
            out.push(TraceEvent::end(at_us, track, "task", names.node(task).to_owned()));
        }
    }

    fn begin_command(&mut self, span: &CommandSpan, out: &mut Vec<TraceEvent>) {
        let names = self.history.names();
        let track = self.tracks.track(Row::Controller(span.controller, span.track), &self.history, out);
        let does = format::command(&span.command, names).to_string();
        let event = TraceEvent::begin(span.told.0, track, "command", does);
        out.push(event.with(args([
            ("command", json!(format::goal(span.id).to_string())),
            ("for", json!(cells::nodes(&span.leaves, names))),
            ("mode", json!(cells::mode(span.mode))),
        ])));
        for leaf in span.leaves.clone() {
            self.point(leaf, span, span.told, out);
        }
    }

    fn end_command(&mut self, span: &CommandSpan, out: &mut Vec<TraceEvent>) {
        let names = self.history.names();
        let track = self.tracks.track(Row::Controller(span.controller, span.track), &self.history, out);
        let at_us = span.ended.map_or(self.history.now(), |(at, _)| at).0;
        let (end, why) = span.ended.map_or(("", String::new()), |(_, end)| (end.word(), end.to_string()));
        let does = format::command(&span.command, names).to_string();
        out.push(TraceEvent::end(at_us, track, "command", does).with(args([
            ("end", json!(end)),
            ("why", json!(why)),
            ("accepted_s", json!(span.accepted.map(Time::seconds))),
            ("told to stop_s", json!(span.canceled.map(Time::seconds))),
            ("took_s", json!(span.took_s)),
            ("for all of", json!(cells::nodes(&span.leaves, names))),
        ])));
    }

    /// An arrow from a behavior that runs to the command that it is granted with.
    fn point(&mut self, leaf: NodeId, to: &CommandSpan, at: Time, out: &mut Vec<TraceEvent>) {
        if !self.attempts.is_open(leaf) {
            return;
        }
        let from = self.tracks.track(Row::Behavior(task_of(&self.history, leaf), leaf), &self.history, out);
        let track = self.tracks.track(Row::Controller(to.controller, to.track), &self.history, out);
        let id = format!("{}/{}/{}", self.history.names().controller(to.controller), format::goal(to.id), leaf.0);
        out.extend(TraceEvent::arrow(at.0, from, track, "command", id));
    }

    /// What is over of a resource; what is not, up to now.
    fn draw_lane(&mut self, resource: ResourceId, lane: &Lane, now: Time, out: &mut Vec<TraceEvent>) {
        let names = self.history.names();
        for Held { lease, from, to, track } in lane.leases() {
            let track = self.tracks.track(Row::Resource(resource, *track), &self.history, out);
            let name = match lease.kind {
                LeaseKind::Running => names.node(lease.behavior).to_owned(),
                LeaseKind::Intention | LeaseKind::Physical => format!("kept for {}", names.node(lease.holder)),
            };
            let event = TraceEvent::whole(from.0, to.unwrap_or(now).0, track, cells::lease(lease.kind), name);
            out.push(event.with(args([
                ("hold", json!(cells::lease(lease.kind))),
                ("holder", json!(names.node(lease.holder))),
                ("behavior", json!(names.node(lease.behavior))),
                ("inherited from", json!(lease.from.map(|from| names.node(from)))),
            ])));
        }
        for (why, from, to) in lane.outages() {
            let track = self.tracks.track(Row::Outage(resource), &self.history, out);
            out.push(TraceEvent::whole(from.0, to.unwrap_or(now).0, track, "outage", why.to_string()));
        }
    }

    /// What happened at one moment.
    fn mark(&mut self, record: &Record, out: &mut Vec<TraceEvent>) {
        let Some((row, category)) = row_of(record) else { return };
        let args =
            if let Record::Decided { granted, .. } = record { self.decision(granted, record) } else { Map::new() };
        let name = if let Record::Decided { round, .. } = record {
            Some(format!("round {round}"))
        } else {
            live::said(&self.history, record)
        };
        let Some(name) = name else { return };
        let track = self.tracks.track(row, &self.history, out);
        out.push(TraceEvent::instant(self.history.now().0, track, category, name).with(args));
    }

    fn decision(&self, granted: &[Grant], record: &Record) -> Map<String, Value> {
        let names = self.history.names();
        let leaves: Vec<NodeId> = granted.iter().map(Grant::leaf).collect();
        let refused = record.refusals().iter();
        let refused: Map<String, Value> = refused
            .map(|blocked| (names.node(blocked.leaf).to_owned(), blocked.reason.sentence(names).into()))
            .collect();
        args([
            ("granted", json!(cells::nodes(&leaves, names))),
            ("said", json!(live::said(&self.history, record))),
            ("refused", if refused.is_empty() { Value::Null } else { refused.into() }),
        ])
    }
}

/// Where what happened at one moment is drawn, and as what; none of what is no event of its own.
fn row_of(record: &Record) -> Option<(Row, &'static str)> {
    match record {
        Record::Decided { .. } => Some((Row::Decisions, "decision")),
        Record::Reopened { .. } | Record::Overtaken { .. } | Record::Stopped { .. } => Some((Row::Decisions, "root")),
        Record::Ending { .. } | Record::Leaving { .. } | Record::Cleaning { .. } => Some((Row::Decisions, "root")),
        Record::Woke { .. } | Record::Cleaned { is_done: true, .. } => Some((Row::Decisions, "root")),
        Record::Ended { end: MissionEnd::Done, .. } => Some((Row::Decisions, "end")),
        Record::Ended { .. } => Some((Row::Failures, "end")),
        Record::Released { end: End::Failed(_), .. } => Some((Row::Failures, "failure")),
        Record::Released { end: End::Succeeded | End::Canceled | End::Interrupted, .. } => None,
        Record::Infeasible { .. } | Record::TimedOut { .. } => Some((Row::Failures, "failure")),
        Record::Cleaned { is_done: false, .. } => Some((Row::Failures, "failure")),
        Record::Served { .. } | Record::Awaited { .. } => Some((Row::Failures, "controller")),
        Record::Controller { message, .. } => of_controller(message).then_some((Row::Failures, "controller")),
        Record::World { change, .. } if !matches!(change, Change::Base(_)) => Some((Row::World, "world")),
        Record::World { .. } => None,
        Record::Denied { .. } => Some((Row::World, "denied")),
        Record::TaskEnded { end: MissionEnd::Done | MissionEnd::Canceled, .. } => Some((Row::Decisions, "task")),
        Record::TaskEnded { .. } | Record::Stalled { .. } => Some((Row::Failures, "task")),
        Record::Added { .. } | Record::Removed { .. } | Record::Granting { .. } => Some((Row::Decisions, "task")),
        Record::Canceled { .. } | Record::Declined { .. } => Some((Row::Decisions, "task")),
        Record::ObjectAdded { .. } | Record::ObjectRemoved { .. } => Some((Row::World, "world")),
        Record::Checkpoint { .. } => None,
        Record::Header(_) | Record::Told { .. } | Record::Observed { .. } | Record::Turn { .. } => None,
        Record::Began { .. } | Record::Sent { .. } | Record::Resource { .. } => None,
    }
}

/// Whether what a controller says goes wrong.
fn of_controller(message: &ControllerMessage) -> bool {
    match message {
        ControllerMessage::Lost { .. } | ControllerMessage::Refused { .. } => true,
        ControllerMessage::Misreported { .. } => true,
        ControllerMessage::Diagnosed { level, .. } => *level != Level::Ok,
        ControllerMessage::Heard { message: FromController::Rejected { .. } } => true,
        ControllerMessage::Heard { .. } | ControllerMessage::Attached => false,
        ControllerMessage::Told { .. } | ControllerMessage::Joined { .. } => false,
    }
}
