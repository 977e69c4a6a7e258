//! The story of a run: what happened step by step, and why.

use std::collections::{BTreeMap, VecDeque};
use std::fmt::Write;

use ambidex_model::state::Stage;
use ambidex_model::{Change, ControllerMessage, Header, MissionEnd, NodeId, Reason, Record, Time};
use ambidex_record::{History, LeafState, MissionOutcome};

use super::because::because;
use super::sentence;
use super::step::{Step, Told};
use crate::Palette;
use crate::text::{MIN_WIDTH, NOT_ENDED, columns, count, hang, mark, mission_ended, of_end, phrase};

/// Most steps that are told from the beginning, and from the end.
const MAX_STEPS: usize = 20;
/// Most reasons at the end of a stalled run.
const MAX_REASONS: usize = 20;

/// A running fold of records to a story.
#[derive(Debug, Clone)]
pub struct Story {
    history: History,
    step: Step,
    known: BTreeMap<NodeId, Reason>,
    first: Vec<(Time, Vec<Told>)>,
    last: VecDeque<(Time, Vec<Told>)>,
    left_out: usize,
}

impl Story {
    /// Nothing has happened yet.
    pub fn new(header: &Header) -> Self {
        Self {
            history: History::new(header),
            step: Step::default(),
            known: BTreeMap::new(),
            first: Vec::new(),
            last: VecDeque::new(),
            left_out: 0,
        }
    }

    /// Takes the next record.
    pub fn add(&mut self, record: &Record) {
        let names = self.history.names();
        let at = &self.history.moment(record.at());
        match record {
            Record::Decided { .. } => self.step.decide(record, &self.history),
            Record::Released { leaf, .. } => {
                self.known.remove(leaf);
                self.close();
                self.step.release(record, &self.history);
            }
            Record::World { change, origin, .. } if !matches!(change, Change::Base(_)) => {
                let said = format!("From outside: {}.", phrase::changed_by(change, *origin, names));
                self.happens(*at, LeafState::Waiting, said);
            }
            Record::Denied { change, origin, why, .. } => {
                let said = format!("From outside: {}.", phrase::denied(change, *origin, *why, names));
                self.happens(*at, LeafState::Failed, said);
            }
            // Of a mission that goes on root says what follows from it.
            Record::Controller { controller, message: ControllerMessage::Lost { why }, .. }
                if self.history.state_of_run().stage() != Stage::Running =>
            {
                let said = format!("The controller {} is lost: {why}.", names.controller(*controller));
                self.happens(*at, LeafState::Failed, said);
            }
            Record::Served { controller, service, .. } => {
                let state = if service.is_available() { LeafState::Waiting } else { LeafState::Failed };
                let said = format!("{}.", phrase::served(*controller, *service, names));
                self.happens(*at, state, said);
            }
            Record::Awaited { until, facts, places, .. } => {
                let said = format!("For now {}.", phrase::awaited(*until, facts, places, names));
                self.happens(*at, LeafState::Waiting, said);
            }
            Record::Infeasible { .. }
            | Record::TimedOut { .. }
            | Record::Reopened { .. }
            | Record::Stopped { .. }
            | Record::Ending { .. }
            | Record::Leaving { .. }
            | Record::Cleaning { .. }
            | Record::Cleaned { .. }
            | Record::Added { .. }
            | Record::Removed { .. }
            | Record::Granting { .. }
            | Record::Canceled { .. }
            | Record::TaskEnded { .. }
            | Record::Stalled { .. }
            | Record::ObjectAdded { .. }
            | Record::ObjectRemoved { .. }
            | Record::Declined { .. }
            | Record::Checkpoint { .. }
            | Record::Overtaken { .. } => {
                let state = sentence::turned(record);
                if let Some(said) = phrase::turned(record, &self.history) {
                    self.happens(*at, state, format!("{}.", sentence::capital(&said, names)));
                }
            }
            Record::Ended { end, .. } => self.ends(*at, *end),
            Record::Told { .. } | Record::Observed { .. } | Record::Turn { .. } | Record::Began { .. } => {}
            Record::Header(_)
            | Record::Woke { .. }
            | Record::Sent { .. }
            | Record::World { .. }
            | Record::Resource { .. }
            | Record::Controller { .. } => {}
        }
        self.history.apply(record);
    }

    fn ends(&mut self, at: Time, end: MissionEnd) {
        let names = self.history.names();
        let skipped = sentence::skipped(&self.history.met(), names).filter(|_| end == MissionEnd::Done);
        let said = format!("The mission is over: {}.", mission_ended(end, names));
        if let Some(skipped) = skipped {
            self.happens(at, LeafState::Skipped, skipped);
        }
        self.happens(at, of_end(MissionOutcome::from(end)), said);
    }

    /// The story as far as it was self.
    pub fn text(mut self, width: usize, palette: &Palette) -> String {
        let width = width.max(MIN_WIDTH);
        self.close();
        let mut text = self.head(width, palette);
        let latest = self.first.iter().chain(&self.last).map(|(at, _)| clock(*at));
        let clock_columns = latest.map(|clock| columns(&clock)).max().unwrap_or_default();
        let rows = |steps: &mut dyn Iterator<Item = &(Time, Vec<Told>)>| {
            steps.map(|step| told(step, clock_columns, width, palette)).collect::<String>()
        };
        text.push_str(&rows(&mut self.first.iter()));
        if self.left_out > 0 {
            let _ = writeln!(text, "{:>clock_columns$}  … {} left out", "", count(self.left_out, "further step"));
        }
        text.push_str(&rows(&mut self.last.iter()));
        if !self.history.header().has_messages {
            let note =
                "Why the others waited is not written in the log of so large a tree: explain LOG NODE computes it.";
            text.push_str(&hang("  ", 2, note, width));
        }
        text + &self.tail(width, palette)
    }

    fn happens(&mut self, at: Time, state: LeafState, said: String) {
        self.close();
        self.step.happens(at, state, said);
    }

    /// Ends the step if anything was decided in it, or if it is the last one.
    fn close(&mut self) {
        if !self.step.is_decided && self.history.end().is_none() {
            return;
        }
        let waits = self.step.waiting(&mut self.known, self.history.names());
        let Step { at, mut happened, .. } = std::mem::take(&mut self.step);
        happened.extend(waits);
        if happened.is_empty() {
            return;
        }
        if self.first.len() < MAX_STEPS {
            self.first.push((at, happened));
            return;
        }
        self.last.push_back((at, happened));
        if self.last.len() > MAX_STEPS {
            self.last.pop_front();
            self.left_out += 1;
        }
    }

    fn head(&self, width: usize, palette: &Palette) -> String {
        let Header { mission, robot, allocator, names, .. } = self.history.header();
        let history = &self.history;
        let outcome = history.end().map_or(NOT_ENDED.into(), |end| mission_ended(end, names));
        let figures = format!(
            "{} in {:.2} s of robot time, {}, {} skipped",
            count(history.step_count(), "step"),
            history.makespan_s(),
            count(history.rounds(), "round"),
            count(history.skipped().len() as u64, "behavior")
        );
        let state = history.end().map_or(LeafState::Active, |end| of_end(end.into()));
        let (title, outcome) = (Palette::paint(palette.strong, mission), Palette::paint(palette.of(state), outcome));
        let figures = hang("  ", 2, &figures, width);
        format!("{title} on {robot}, {allocator}: {outcome}\n{figures}\n")
    }

    /// What stands open in the end: what runs where the records stop, and in a stall why nothing can.
    fn tail(&self, width: usize, palette: &Palette) -> String {
        let names = self.history.names();
        let running = phrase::nodes(self.history.running().keys().copied(), names);
        let mut told: Vec<String> = Vec::new();
        if self.history.end().is_none() && !running.is_empty() {
            told.push(format!("Still under way: {running}."));
        }
        if self.history.end() == Some(MissionEnd::Stalled) {
            let mut causes = self.history.causes();
            let all = causes.len();
            causes.truncate(MAX_REASONS);
            told.extend(causes.iter().map(|(leaf, reason)| {
                format!("{} cannot run: {}.", names.node(*leaf), because(reason, &self.history).whole())
            }));
            if all > causes.len() {
                told.push(format!("{} more cannot run.", count(all - causes.len(), "behavior")));
            }
        }
        if told.is_empty() {
            return String::new();
        }
        let mark = Palette::paint(palette.waiting, mark(LeafState::Waiting));
        let rows = told.iter().map(|said| hang(&format!("  {mark} "), 4, said, width));
        format!("\n{}", rows.collect::<String>())
    }
}

fn clock(at: Time) -> String {
    format!("{:>6.2} s", at.seconds())
}

/// A step: its time once, then line by line what happened.
fn told((at, happened): &(Time, Vec<Told>), clock_columns: usize, width: usize, palette: &Palette) -> String {
    let indent = clock_columns + 4;
    let rows = happened.iter().enumerate().map(|(index, (state, said))| {
        let clock = if index == 0 { clock(*at) } else { String::new() };
        let mark = Palette::paint(palette.of(*state), mark(*state));
        let head = format!("{}  {mark} ", Palette::paint(palette.faint, format!("{clock:>clock_columns$}")));
        hang(&head, indent, said, width)
    });
    rows.collect()
}
