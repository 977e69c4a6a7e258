//! The story of a run: what happened step by step, and why.

use std::collections::{BTreeMap, VecDeque};
use std::fmt::Write;

use crate::text::{MIN_WIDTH, columns, count, flow, hang};
use crate::{LeafState, Palette, last_reasons, phrase};
use ambidex_model::{Change, ControllerMessage, Header, MissionEnd, NodeId, Reason, Record, Tally, Time};

use super::holdings::Holdings;
use super::moment::{Moment, Told};
use super::sentence;
use super::standing::Standing;

/// Most moments that are told from the beginning, and from the end.
const MAX_MOMENTS: usize = 20;
/// Most reasons at the end of a stalled run.
const MAX_REASONS: usize = 20;

/// A running fold of records to a story.
#[derive(Debug, Clone)]
pub struct Story {
    standing: Standing,
    holdings: Holdings,
    tally: Tally,
    moment: Moment,
    known: BTreeMap<NodeId, Reason>,
    first: Vec<(Time, Vec<Told>)>,
    last: VecDeque<(Time, Vec<Told>)>,
    left_out: usize,
}

impl Story {
    /// Nothing has happened yet.
    pub fn new(header: &Header) -> Self {
        Self {
            standing: Standing::new(header),
            holdings: Holdings::new(header),
            tally: Tally::default(),
            moment: Moment::default(),
            known: BTreeMap::new(),
            first: Vec::new(),
            last: VecDeque::new(),
            left_out: 0,
        }
    }

    /// Takes the next record.
    pub fn add(&mut self, record: &Record) {
        let names = &self.standing.header().names;
        match record {
            Record::Decided { .. } => self.moment.decide(record, &self.standing, &self.holdings),
            Record::Released { leaf, .. } => {
                self.known.remove(leaf);
                self.close();
                self.moment.release(record, &self.standing);
            }
            Record::World { at, change } if !matches!(change, Change::Base(_)) => {
                let said = format!("From outside: {}.", phrase::changed(change, names));
                self.happens(*at, LeafState::Waiting, said);
            }
            Record::Controller { at, controller, message: ControllerMessage::Lost { .. } } => {
                let said = format!("The controller {} is lost.", names.controller(*controller));
                self.happens(*at, LeafState::Failed, said);
            }
            Record::Ended { at, end } => {
                let met: Vec<NodeId> = self.standing.met().collect();
                let skipped = sentence::skipped(&met, names).filter(|_| *end == MissionEnd::Done);
                let said = format!("The mission is over: {}.", phrase::mission_ended(*end, names));
                if let Some(skipped) = skipped {
                    self.happens(*at, LeafState::Skipped, skipped);
                }
                self.happens(*at, ended(*end), said);
            }
            Record::Header(_)
            | Record::Sent { .. }
            | Record::World { .. }
            | Record::Resource { .. }
            | Record::Controller { .. } => {}
        }
        self.tally.add(record);
        self.holdings.add(record);
        self.standing.add(record);
    }

    /// The story as far as it was heard.
    pub fn text(&self, width: usize, palette: &Palette) -> String {
        let width = width.max(MIN_WIDTH);
        let mut heard = self.clone();
        heard.close();
        let mut text = heard.head(width, palette);
        let latest = heard.first.iter().chain(&heard.last).map(|(at, _)| clock(*at));
        let clock_columns = latest.map(|clock| columns(&clock)).max().unwrap_or_default();
        let rows = |moments: &mut dyn Iterator<Item = &(Time, Vec<Told>)>| {
            moments.map(|moment| told(moment, clock_columns, width, palette)).collect::<String>()
        };
        text.push_str(&rows(&mut heard.first.iter()));
        if heard.left_out > 0 {
            let _ = writeln!(text, "{:>clock_columns$}  … {} left out", "", count(heard.left_out, "further moment"));
        }
        text.push_str(&rows(&mut heard.last.iter()));
        text + &heard.tail(width, palette)
    }

    fn happens(&mut self, at: Time, state: LeafState, said: String) {
        self.close();
        self.moment.happens(at, state, said);
    }

    /// Ends the moment if anything was decided in it, or if it is the last one.
    fn close(&mut self) {
        let moment = &self.moment;
        if !moment.is_decided && self.tally.end.is_none() {
            return;
        }
        let waits = moment.waiting(&mut self.known, &self.standing.header().names);
        let Moment { at, mut happened, .. } = std::mem::take(&mut self.moment);
        happened.extend(waits);
        if happened.is_empty() {
            return;
        }
        if self.first.len() < MAX_MOMENTS {
            self.first.push((at, happened));
            return;
        }
        self.last.push_back((at, happened));
        if self.last.len() > MAX_MOMENTS {
            self.last.pop_front();
            self.left_out += 1;
        }
    }

    fn head(&self, width: usize, palette: &Palette) -> String {
        let Header { mission, robot, allocator, names, .. } = self.standing.header();
        let outcome = match self.tally.end {
            Some(end) => phrase::mission_ended(end, names),
            None => "not over where its records stop".into(),
        };
        let figures = format!(
            "{} in {:.2} s of robot time, {}, {} skipped",
            count(self.tally.steps.len(), "step"),
            self.tally.makespan_s(),
            count(self.tally.rounds as usize, "round"),
            count(self.tally.skipped.len(), "behavior")
        );
        let state = self.tally.end.map_or(LeafState::Active, ended);
        let (title, outcome) = (Palette::paint(palette.strong, mission), Palette::paint(palette.of(state), outcome));
        let figures = hang("  ", 2, &flow(figures.split(' '), width - 2));
        format!("{title} on {robot}, {allocator}: {outcome}\n{figures}\n")
    }

    /// What stands open in the end: what runs where the records stop, and in a stall why nothing can.
    fn tail(&self, width: usize, palette: &Palette) -> String {
        let names = &self.standing.header().names;
        let running = phrase::nodes(self.standing.running(), names);
        let mut told: Vec<String> = Vec::new();
        if self.tally.end.is_none() && !running.is_empty() {
            told.push(format!("Still under way: {running}."));
        }
        if self.tally.end == Some(MissionEnd::Stalled) {
            let mut open = last_reasons(&self.tally);
            open.retain(|(_, reason)| *reason != Some(Reason::Satisfied));
            let all = open.len();
            open.truncate(MAX_REASONS);
            told.extend(open.iter().map(|(leaf, reason)| {
                let why = reason.as_ref().map(|reason| self.holdings.because(reason, names).whole());
                format!("{} cannot run: {}.", names.node(*leaf), why.unwrap_or_else(|| "it was not asked".into()))
            }));
            if all > open.len() {
                told.push(format!("{} more cannot run.", count(all - open.len(), "behavior")));
            }
        }
        if told.is_empty() {
            return String::new();
        }
        let mark = Palette::paint(palette.waiting, LeafState::Waiting.mark());
        let rows = told.iter().map(|said| hang(&format!("  {mark} "), 4, &flow(said.split(' '), width - 4)));
        format!("\n{}", rows.collect::<String>())
    }
}

fn ended(end: MissionEnd) -> LeafState {
    match end {
        MissionEnd::Done => LeafState::Done,
        MissionEnd::Canceled => LeafState::Canceled,
        MissionEnd::Failed(_)
        | MissionEnd::Stalled
        | MissionEnd::ControllerLost(_)
        | MissionEnd::NotAttached
        | MissionEnd::NodeLost(_)
        | MissionEnd::TaskLost => LeafState::Failed,
    }
}

fn clock(at: Time) -> String {
    format!("{:>6.2} s", at.seconds())
}

/// A moment: its time once, then line by line what happened.
fn told((at, happened): &(Time, Vec<Told>), clock_columns: usize, width: usize, palette: &Palette) -> String {
    let indent = clock_columns + 4;
    let rows = happened.iter().enumerate().map(|(index, (state, said))| {
        let clock = if index == 0 { clock(*at) } else { String::new() };
        let mark = Palette::paint(palette.of(*state), state.mark());
        let head = format!("{}  {mark} ", Palette::paint(palette.faint, format!("{clock:>clock_columns$}")));
        hang(&head, indent, &flow(said.split(' '), width - indent))
    });
    rows.collect()
}
