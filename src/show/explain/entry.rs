//! What is told of one leaf: what happened to it, and what was so for several rounds in one entry.

use std::collections::VecDeque;
use std::fmt::Write;

use ambidex_model::{Reason, Time};
use ambidex_record::LeafState;

use super::because::Because;
use crate::Palette;
use crate::text::{columns, hang, mark};

/// Most entries that are kept of one leaf; of more, the latest.
const MAX_ENTRIES: usize = 1000;

/// Fewest columns for what is said behind rounds and time; where there are fewer, it stands below them.
const MIN_SAID: usize = 24;

/// What is told of a leaf.
#[derive(Debug, Clone, Default)]
pub(super) struct Leaf {
    entries: VecDeque<Entry>,
    left_out: usize,
    pub(super) then: Option<LeafState>,
}

/// Something that was so for a round or several, or that happened.
#[derive(Debug, Clone)]
pub(super) struct Entry {
    pub(super) rounds: Option<(u32, u32)>,
    pub(super) from: Time,
    pub(super) state: LeafState,
    pub(super) said: String,
    pub(super) waits: Option<Wait>,
}

/// What can be so for several rounds.
#[derive(Debug, Clone)]
pub(super) struct Wait {
    pub(super) reason: Option<Reason>,
    pub(super) because: Because,
    pub(super) is_first_only: bool,
}

impl Leaf {
    pub(super) fn tell(&mut self, entry: Entry) {
        if let Some(last) = self.entries.back_mut()
            && last.goes_on_with(&entry)
        {
            return;
        }
        self.entries.push_back(entry);
        if self.entries.len() > MAX_ENTRIES {
            self.entries.pop_front();
            self.left_out += 1;
        }
    }

    /// What the last entry says that it is.
    pub(super) fn state(&self) -> Option<LeafState> {
        self.entries.back().map(|entry| entry.state)
    }

    /// The entries as rows, all or those of one round.
    pub(super) fn text(&self, round: Option<u32>, width: usize, palette: &Palette) -> String {
        let is_wanted = |entry: &&Entry| match round {
            Some(round) => entry.rounds.is_some_and(|(from, to)| (from..=to).contains(&round)),
            None => true,
        };
        let wanted: Vec<&Entry> = self.entries.iter().filter(is_wanted).collect();
        let mut text = String::new();
        if self.left_out > 0 && round.is_none() {
            let _ = writeln!(text, "  … {} earlier entries left out; --round tells of one round", self.left_out);
        }
        if let (Some(round), Some(then), []) = (round, self.then, wanted.as_slice()) {
            let mark = Palette::paint(palette.of(then), mark(then));
            let _ = writeln!(text, "  {mark} round {round}: nothing was decided about it; it was {}.", then.word());
        }
        let heads: Vec<[String; 2]> = wanted.iter().map(|entry| entry.head()).collect();
        let longest = |column: usize| heads.iter().map(|head| columns(&head[column])).max().unwrap_or_default();
        let widths = [longest(0), longest(1)];
        for (entry, [rounds, time]) in wanted.iter().zip(&heads) {
            let mark = Palette::paint(palette.of(entry.state), mark(entry.state));
            let head = format!("{rounds:<0$}  {time:>1$}", widths[0], widths[1]);
            let indent = widths[0] + widths[1] + 8;
            let head = format!("  {mark} {}", Palette::paint(palette.faint, head));
            let said = entry.said();
            if width < indent + MIN_SAID {
                let _ = writeln!(text, "{head}");
                text.push_str(&hang("    ", 4, &said, width));
                continue;
            }
            text.push_str(&hang(&(head + "  "), indent, &said, width));
        }
        text
    }
}

impl Entry {
    pub(super) fn moment(at: Time, round: Option<u32>, state: LeafState, said: String) -> Self {
        Self { rounds: round.map(|round| (round, round)), from: at, state, said, waits: None }
    }

    /// Takes in an entry that says the same of the next round; false if it does not.
    fn goes_on_with(&mut self, next: &Self) -> bool {
        let (Some(wait), Some(again)) = (&mut self.waits, &next.waits) else {
            return false;
        };
        let (Some((_, last)), Some((from, to))) = (&mut self.rounds, next.rounds) else {
            return false;
        };
        let is_same = wait.reason == again.reason && wait.because.sentence == again.because.sentence;
        if !is_same || last.checked_add(1) != Some(from) {
            return false;
        }
        wait.is_first_only |= wait.because.detail != again.because.detail;
        *last = to;
        true
    }

    fn head(&self) -> [String; 2] {
        let rounds = match self.rounds {
            None => String::new(),
            Some((from, to)) if from == to => format!("round {from}"),
            Some((from, to)) => format!("rounds {from} to {to}"),
        };
        [rounds, format!("{:.2} s", self.from.seconds())]
    }

    fn said(&self) -> String {
        let Some(Wait { reason, because, is_first_only }) = &self.waits else {
            return self.said.clone();
        };
        if *reason == Some(Reason::Satisfied) {
            return "Its goal is met already.".into();
        }
        let Because { sentence, detail } = because;
        let said = match detail {
            None => sentence.clone(),
            Some(detail) if *is_first_only => format!("{sentence} (at first {detail})"),
            Some(detail) => format!("{sentence} ({detail})"),
        };
        match (reason, said.strip_prefix("it is not asked")) {
            (_, Some(rest)) => format!("It is not asked{rest}."),
            (Some(Reason::Ending { .. }), None) => format!("It is not to run any more: {said}."),
            (_, None) => format!("It waits: {said}."),
        }
    }
}
