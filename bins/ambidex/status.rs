//! `ambidex status`: what a mission is at, from its journal alone, once or until it ends.

use std::io::{self, IsTerminal, Write};
use std::path::PathBuf;
use std::time::{Duration, Instant};

use ambidex::link::Instance;
use ambidex::link::Stop;
use ambidex::record::MissionOutcome;
use ambidex::show::MIN_WIDTH;
use ambidex::show::status::{Daemon, Phase, Snapshot};
use clap::Args;
use miette::{IntoDiagnostic, Result};

use crate::exit::Exit;
use crate::following::{Following, Source};
use crate::page::is_read;
use crate::terminal::{self, Display, WIDTH};
use crate::values;
use crate::waiting::is_stopped;

/// How often news are looked for and drawn at most.
const TICK: Duration = Duration::from_millis(100);
/// How long a daemon is waited for that ended its mission and makes its controllers safe.
const LEAVE_WITHIN: Duration = Duration::from_secs(5);

/// Lines of a text that is not drawn again.
const HEIGHT: usize = 500;

const HELP: &str = "\
It tells of one instance, since it also asks whether that one's daemon lives; where nothing is named, of `default`.
The other verbs that read a log take it as LOG: a file or an instance, and the newest where nothing is named.";

/// `ambidex status`.
#[derive(Debug, Args)]
#[command(after_help = HELP)]
pub struct StatusArgs {
    /// Name of the robot's runtime [default: default].
    #[arg(long, value_parser = values::instance)]
    pub instance: Option<Instance>,
    /// Follow the mission until it ends: in place on a terminal, else a text per change, at most ten in a second.
    #[arg(long, short)]
    pub watch: bool,
    /// Print one object on stdout; with --watch one in a line per change.
    #[arg(long)]
    pub json: bool,
    /// Read this log instead of the one of the instance; without --instance nobody knows whether its daemon lives.
    #[arg(long, value_name = "FILE")]
    pub log: Option<PathBuf>,
}

/// Tells what a mission is at.
pub fn status(args: &StatusArgs) -> Result<Exit> {
    let mut following = Source::new(args.instance.clone(), args.log.clone()).follow()?;
    let told = if args.watch { watch(&mut following, args.json)? } else { once(&following, args.json)? };
    match told {
        Told::Ended(outcome) => {
            if args.watch && !args.json {
                say(&format!("the mission ended: {}", outcome.word()));
            }
            Ok(Exit::Done)
        }
        Told::Gone => {
            say("error: the daemon is gone (crashed or killed) and its mission did not end");
            Ok(Exit::Controller)
        }
        Told::SoFar => Ok(Exit::Done),
        Told::Interrupted => Ok(Exit::Canceled),
    }
}

/// What the last thing told was.
enum Told {
    Ended(MissionOutcome),
    Gone,
    SoFar,
    Interrupted,
}

fn once(following: &Following, is_json: bool) -> Result<Told> {
    let Some(snapshot) = following.snapshot() else {
        return Ok(Told::SoFar);
    };
    print(&if is_json { json(&snapshot)? } else { text(&snapshot) })?;
    Ok(told(&snapshot))
}

/// Tells every change until the mission ended, its daemon is gone, or nobody listens.
fn watch(following: &mut Following, is_json: bool) -> Result<Told> {
    let stop = Stop::on_signals().into_diagnostic()?;
    let is_drawn = !is_json && io::stdout().is_terminal();
    let mut size = terminal::size(io::stdout());
    let display = is_drawn.then(Display::stdout);
    let mut last = None;
    let mut ended: Option<Instant> = None;
    loop {
        let is_behind = following.catch_up()?;
        if !is_behind && following.is_abandoned() {
            return Ok(Told::Gone);
        }
        let news = following.snapshot().filter(|_| !is_behind);
        if let Some(snapshot) = news {
            let goes_on = match &display {
                Some(display) => {
                    let now = terminal::size(io::stdout());
                    if std::mem::replace(&mut size, now) != now {
                        display.start_over();
                    }
                    display.show(lines(&snapshot));
                    true
                }
                None if last.as_ref() == Some(&snapshot) => true,
                None if is_json => print(&json(&snapshot)?)?,
                None => print(&(text(&snapshot) + "\n"))?,
            };
            let told = told(&snapshot);
            let is_over = match told {
                Told::Ended(_) => has_left(&snapshot, *ended.get_or_insert_with(Instant::now)),
                Told::Gone => true,
                Told::SoFar | Told::Interrupted => false,
            };
            if is_over || !goes_on {
                if let Some(display) = &display {
                    display.leave(lines(&snapshot));
                }
                return Ok(told);
            }
            last = Some(snapshot);
        }
        if is_stopped(&stop, if is_behind { Duration::ZERO } else { TICK })? {
            return Ok(Told::Interrupted);
        }
    }
}

/// Whether nothing more is to come of a mission that ended.
fn has_left(snapshot: &Snapshot, ended: Instant) -> bool {
    !matches!(snapshot.daemon, Daemon::Running { .. }) || ended.elapsed() > LEAVE_WITHIN
}

fn told(snapshot: &Snapshot) -> Told {
    match snapshot.phase {
        Phase::Gone => Told::Gone,
        Phase::Ended | Phase::Waiting | Phase::Running => snapshot.outcome.map_or(Told::SoFar, Told::Ended),
    }
}

/// What a terminal has room for, without two lines: where the cursor rests, and where the end is told.
fn lines(snapshot: &Snapshot) -> Vec<String> {
    let (width, height) = terminal::size(io::stdout()).unwrap_or((WIDTH, HEIGHT));
    match width < MIN_WIDTH {
        true => vec!["…".to_owned()],
        false => snapshot.lines(width, height.saturating_sub(2), &terminal::palette(&io::stdout())),
    }
}

fn text(snapshot: &Snapshot) -> String {
    let width = terminal::size(io::stdout()).map_or(WIDTH, |(columns, _)| columns);
    snapshot.lines(width, HEIGHT, &terminal::palette(&io::stdout())).join("\n")
}

fn json(snapshot: &Snapshot) -> Result<String> {
    serde_json::to_string(snapshot).into_diagnostic()
}

/// Prints a text; false if nobody listens any more.
fn print(text: &str) -> Result<bool> {
    let mut stdout = io::stdout().lock();
    is_read(writeln!(stdout, "{text}").and_then(|()| stdout.flush()))
}

fn say(text: &str) {
    drop(writeln!(io::stderr(), "{text}"));
}
