//! `ambidex trace`.

use std::io;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};
use std::time::Duration;

use ambidex::link::Stop;
use ambidex::model::{Header, Record, Time};
use ambidex::record::{JournalError, Reader, shown};
use ambidex::runtime::log::{Follower, News};
use ambidex::show::conversation::{Conversation, Filters, Kind, Selection};
use clap::Args;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use miette::{IntoDiagnostic, Result, miette};
use strum::VariantArray;

use crate::exit::Exit;
use crate::log;
use crate::page::Page;
use crate::telling::Telling;
use crate::waiting::is_stopped;

/// How often a live log is looked at.
const POLL: Duration = Duration::from_millis(50);
/// How many looks without news make a log quiet that tells of the end of its mission.
const QUIET: u32 = 10;
/// How many records may come between two looks for Ctrl-C.
const AT_ONCE: u64 = 256;

/// `ambidex trace`.
#[derive(Debug, Args)]
#[command(after_help = log::HELP)]
pub struct TraceArgs {
    /// The log: a file or an instance.
    pub log: Option<String>,
    /// Only what is from, to or about nodes with such a name; * ? and [...] match as in a shell.
    #[arg(long, value_name = "GLOB")]
    pub node: Option<String>,
    /// Only these rounds: N, A..B with both, A.. or ..B. What has none belongs to the one decided last.
    #[arg(long, value_name = "ROUNDS", value_parser = rounds)]
    pub round: Option<RangeInclusive<u32>>,
    /// Only this kind of record; may be given several times. Without it all kinds but feedback, diagnosed, told, observed,
    /// turn and began.
    #[arg(long, value_name = "KIND", value_parser = kinds())]
    pub kind: Vec<Kind>,
    /// Besides, how far controllers say that they are, ten times in a second, and what root takes up in its turns.
    #[arg(long)]
    pub feedback: bool,
    /// Only what is about this resource.
    #[arg(long, value_name = "NAME")]
    pub resource: Option<String>,
    /// Only what this controller says or is told.
    #[arg(long, value_name = "NAME")]
    pub controller: Option<String>,
    /// Nothing before this moment, seconds of robot time since the mission began.
    #[arg(long, value_name = "SECONDS", value_parser = moment)]
    pub from: Option<Time>,
    /// Nothing after this moment, seconds of robot time since the mission began.
    #[arg(long, value_name = "SECONDS", value_parser = moment)]
    pub to: Option<Time>,
    /// Go on reading while the log is written, until its mission is over or Ctrl-C.
    #[arg(long, short)]
    pub follow: bool,
    /// Print JSON Lines: the records of the log, with its own times, and names instead of ids.
    #[arg(long)]
    pub json: bool,
}

impl TraceArgs {
    fn conversation(&self, header: &Header) -> Result<Conversation> {
        let filters = Filters {
            node: self.node.clone(),
            resource: self.resource.clone(),
            controller: self.controller.clone(),
            kinds: self.kind.clone(),
            with_minor: self.feedback,
            rounds: self.round.clone(),
            from: self.from,
            to: self.to,
        };
        let selection = Selection::new(&filters, header).map_err(|error| log::unknown(&error))?;
        Ok(Conversation::new(header, selection))
    }
}

/// Prints a log as a conversation.
pub fn trace(args: &TraceArgs) -> Result<Exit> {
    if let (Some(from), Some(to)) = (args.from, args.to)
        && from > to
    {
        return Err(miette!("nothing lies between --from {from} and --to {to}: the first is later"));
    }
    let mut page = Page::new();
    if args.follow {
        follow(args, &log::place(args.log.as_deref())?, &mut page)?;
        return Ok(Exit::Done);
    }
    let path = log::find(args.log.as_deref())?;
    let reader = Reader::open(&path).into_diagnostic()?;
    let mut telling = Telling::new(reader.header(), &path, |_| true)?;
    let mut conversation = args.conversation(reader.header())?;
    let mut told = 0_u64;
    log::read(reader, |record| {
        telling.tell(record, |record| {
            let is_wanted = conversation.take(record);
            told += u64::from(is_wanted);
            Ok(!is_wanted || tell(args, &conversation, record, &mut page)?)
        })
    })?;
    page.flush()?;
    if told == 0 {
        log::say("the log has no record that is asked for");
    }
    Ok(Exit::Done)
}

/// Prints a record; false where nobody reads any more.
fn tell(args: &TraceArgs, conversation: &Conversation, record: &Record, page: &mut Page) -> Result<bool> {
    match args.json {
        true => page.line(&conversation.json(record).into_diagnostic()?),
        false => page.line(&conversation.line(record, &page.palette())),
    }
}

fn follow(args: &TraceArgs, path: &Path, page: &mut Page) -> Result<()> {
    let stop = Stop::on_signals().into_diagnostic()?;
    while let Some(follower) = open(path, &stop)? {
        if !follow_run(args, follower, &stop, page)? {
            break;
        }
        log::say(&format!("a new run began in {}", shown(path)));
    }
    Ok(())
}

/// Waits for the log to be begun; none if it was told to stop before.
fn open(path: &Path, stop: &Stop) -> Result<Option<Follower>> {
    let mut has_said = false;
    loop {
        match Follower::open(PathBuf::from(path)) {
            Err(JournalError::Open { source, .. }) if source.kind() == io::ErrorKind::NotFound => {}
            opened => return opened.map(Some).into_diagnostic(),
        }
        if !std::mem::replace(&mut has_said, true) {
            log::say(&format!("waiting for {}", shown(path)));
        }
        if is_stopped(stop, POLL)? {
            return Ok(None);
        }
    }
}

/// Follows one run; true if another has taken its place.
fn follow_run(args: &TraceArgs, mut follower: Follower, stop: &Stop, page: &mut Page) -> Result<bool> {
    let mut conversation: Option<(Conversation, Telling)> = None;
    let (mut is_over, mut quiet, mut count) = (false, 0, 0_u64);
    loop {
        match follower.look().into_diagnostic()? {
            News::Record(record) => {
                if let Record::Header(header) = record.as_ref() {
                    let telling = Telling::new(header, follower.path(), |_| true)?;
                    conversation = Some((args.conversation(header)?, telling));
                }
                let (conversation, telling) = conversation.as_mut().expect("the header comes first");
                is_over |= matches!(record.as_ref(), Record::Ended { .. });
                quiet = 0;
                count += 1;
                let is_read = telling.tell(&record, |record| {
                    Ok(!conversation.take(record) || tell(args, conversation, record, page)?)
                })?;
                if !is_read || (count.is_multiple_of(AT_ONCE) && is_stopped(stop, Duration::ZERO)?) {
                    break;
                }
            }
            News::Quiet => {
                quiet += 1;
                if !page.flush()? || (is_over && quiet > QUIET) || is_stopped(stop, POLL)? {
                    break;
                }
            }
            News::Replaced => return Ok(true),
        }
    }
    if is_over && follower.is_within_a_line() {
        log::say(&format!("the log was cut off in its last line; {count} records read"));
    }
    page.flush()?;
    Ok(false)
}

fn kinds() -> impl TypedValueParser<Value = Kind> {
    let words = Kind::VARIANTS.iter().map(|kind| kind.word());
    PossibleValuesParser::new(words).map(|word| word.parse().expect("one of the words"))
}

fn rounds(text: &str) -> Result<RangeInclusive<u32>, String> {
    let number = |text: &str, open: u32| match text.trim() {
        "" => Some(open),
        number => number.parse().ok(),
    };
    let ends = match text.split_once("..") {
        Some((from, to)) => number(from, 0).zip(number(to.trim_start_matches('='), u32::MAX)),
        None => text.trim().parse().ok().map(|only| (only, only)),
    };
    match ends {
        Some((from, to)) if from <= to => Ok(from..=to),
        Some(_) | None => Err("a round N, or rounds A..B, A.. or ..B".into()),
    }
}

fn moment(text: &str) -> Result<Time, String> {
    match text.parse::<f64>() {
        Ok(seconds) if (0.0..1e12).contains(&seconds) => Ok(Time((seconds * 1e6).round() as u64)),
        Ok(_) | Err(_) => Err("seconds of robot time, from 0".into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rounds_are_one_or_several() {
        let check =
            |text: &str, expected: Option<RangeInclusive<u32>>| assert_eq!(rounds(text).ok(), expected, "{text}");
        check("3", Some(3..=3));
        check("3..5", Some(3..=5));
        check("3..=5", Some(3..=5));
        check("3..", Some(3..=u32::MAX));
        check("..5", Some(0..=5));
        check("5..3", None);
        check("three", None);
        check("-1", None);
    }

    #[test]
    fn moments_are_seconds() {
        assert_eq!(moment("6.58"), Ok(Time(6_580_000)));
        assert!(moment("-1").is_err() && moment("soon").is_err() && moment("NaN").is_err());
    }
}
