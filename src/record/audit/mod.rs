//! An auditor of logs: what must hold in every run (`semantics` 7), looked at by other means than those that decided.
//!
//! It folds the records by itself and asks neither the state nor the history of a run. What it finds is a defect, or a log
//! that was tampered with; what a mission came to is none of its business.

mod commands;
mod end;
mod leases;
mod objects;
mod own;
mod reasons;
mod run;
mod twice;

use std::fmt::{self, Display, Formatter};
use std::iter::Sum;
use std::sync::Arc;

use ambidex_model::{Header, MissionSpec, Record, Time};
use serde::Serialize;

use commands::Commands;
use end::Ending;
use leases::Leases;
pub use own::{OwnEvent, OwnLine, OwnRecords};
use reasons::Reasons;
use run::Run;
use twice::Twice;

/// What must hold.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, strum::IntoStaticStr, strum::VariantArray)]
#[serde(rename_all = "snake_case")]
#[strum(serialize_all = "snake_case")]
pub enum Rule {
    /// No resource serves two behaviors unless both share it on one channel, and no two children of a THEN run.
    Owners,
    /// What is away, or still stops, is granted to nobody.
    Available,
    /// Nothing is done twice while its goal holds.
    Twice,
    /// No object is lost or in two places.
    Objects,
    /// Every refusal has a reason.
    Reasons,
    /// Time never goes backwards.
    Time,
    /// Every command is told once, for a behavior that runs, and ends once.
    Commands,
    /// A run ends, or names what it waits for; a complete task leaves no lease.
    End,
    /// Controllers' own records and the log say the same.
    Records,
}

impl Rule {
    /// What it is called on a command line.
    pub fn word(self) -> &'static str {
        self.into()
    }

    /// What must hold, as a sentence without its end.
    pub fn sentence(self) -> &'static str {
        match self {
            Self::Owners => "no resource serves two behaviors, no two steps of a THEN run at once",
            Self::Available => "nothing is granted that is away",
            Self::Twice => "nothing is done twice while its goal holds",
            Self::Objects => "no object is lost or in two places",
            Self::Reasons => "every refusal has a reason",
            Self::Time => "time never goes backwards",
            Self::Commands => "every command is told once, for what runs, and ends once",
            Self::End => "the run ends or names what it waits for, and leaves no lease",
            Self::Records => "the controllers' own records say the same",
        }
    }
}

/// Something that does not hold.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Finding {
    /// What should have.
    pub rule: Rule,
    /// The line of the log, from 1; none of a controller's own record.
    pub line: Option<u64>,
    /// Robot time.
    pub at: Option<Time>,
    /// What is the matter.
    pub said: String,
}

impl Display for Finding {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let Self { rule, line, at, said } = self;
        write!(f, "{}: ", rule.word())?;
        if let Some(line) = line {
            write!(f, "line {line}")?;
        }
        match at {
            Some(at) => write!(f, ", {at}: {said}"),
            None => f.write_str(said),
        }
    }
}

/// Where findings gather, and of which line they are.
#[derive(Debug, Default)]
struct Found {
    line: u64,
    at: Time,
    findings: Vec<Finding>,
}

/// Most findings that are kept; a log that is broken from one line on has one for each that follows.
const MOST_FINDINGS: usize = 1000;

impl Found {
    fn push(&mut self, rule: Rule, said: String) {
        if self.findings.len() < MOST_FINDINGS {
            self.findings.push(Finding { rule, line: Some(self.line), at: Some(self.at), said });
        }
    }
}

/// What an audit came to.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct AuditReport {
    /// What does not hold, in the order in which it was seen.
    pub findings: Vec<Finding>,
    /// Records that were looked at, the header included.
    pub records: u64,
    /// Decisions, grants, commands and moved objects among them: what there was to be looked at.
    pub looked_at: LookedAt,
    /// Where the log has no end, what it ends at.
    pub open: Option<String>,
}

/// How much there was to be looked at.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct LookedAt {
    /// Behaviors that were granted.
    pub grants: u64,
    /// Requests and answers whose refusal needs a reason.
    pub refusals: u64,
    /// Commands to controllers.
    pub commands: u64,
    /// Changes of where an object is.
    pub moves: u64,
    /// Behaviors that were done and had a goal that could be looked at.
    pub goals: u64,
    /// Lines of controllers' own records.
    pub own: u64,
}

impl Sum for LookedAt {
    fn sum<I: Iterator<Item = Self>>(all: I) -> Self {
        all.fold(Self::default(), |one, other| Self {
            grants: one.grants + other.grants,
            refusals: one.refusals + other.refusals,
            commands: one.commands + other.commands,
            moves: one.moves + other.moves,
            goals: one.goals + other.goals,
            own: one.own + other.own,
        })
    }
}

/// An audit that goes on.
#[derive(Debug)]
pub struct Audit {
    run: Run,
    leases: Leases,
    twice: Twice,
    reasons: Reasons,
    commands: Commands,
    ending: Ending,
    found: Found,
    looked_at: LookedAt,
}

impl Audit {
    /// Of a log with this header; without its mission nothing can be said of goals.
    ///
    /// # Panics
    /// When the nodes of the header are no tree in preorder, as those of a header that was read always are.
    pub fn new(header: &Header, mission: Option<Arc<MissionSpec>>) -> Self {
        let run = Run::new(header, mission);
        Self {
            leases: Leases::default(),
            twice: Twice::default(),
            reasons: Reasons::default(),
            commands: Commands::default(),
            ending: Ending::default(),
            // The header is its first line.
            found: Found { line: 1, ..Found::default() },
            looked_at: LookedAt::default(),
            run,
        }
    }

    /// Takes the next record; that of the header may be left out.
    pub fn take(&mut self, record: &Record) {
        if matches!(record, Record::Header(_)) {
            return;
        }
        let Self { run, found, looked_at, .. } = self;
        found.line += 1;
        if record.at() < found.at {
            let said = format!("it stands behind a line of {}", found.at);
            found.at = record.at();
            found.push(Rule::Time, said);
        }
        found.at = record.at();
        self.leases.take(run, record, found, looked_at);
        self.twice.take(run, record, found, looked_at);
        objects::take(run, record, found, looked_at);
        self.reasons.take(run, record, found, looked_at);
        self.commands.take(run, record, found, looked_at);
        self.ending.take(run, record, found);
        run.apply(record);
        if Run::is_about_world(record) {
            self.twice.look(run);
        }
    }

    /// What it came to. `own` are the controllers' own records, where there are any; `is_whole` says that nothing of the
    /// log is lacking.
    pub fn finish(mut self, own: Option<&OwnRecords>, is_whole: bool) -> AuditReport {
        let open = self.ending.finish(&self.run, is_whole, &mut self.found);
        if open.is_none() && is_whole {
            self.commands.finish(&self.run, &mut self.found);
            self.leases.finish(&self.run, &mut self.found);
        }
        let mut findings = self.found.findings;
        if let Some(own) = own {
            self.looked_at.own = own.lines();
            findings.extend(own.compare(&self.run, &self.commands, is_whole && open.is_none()));
        }
        AuditReport { findings, records: self.found.line, looked_at: self.looked_at, open }
    }
}
