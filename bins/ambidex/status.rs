//! `ambidex status`: what a mission is at, from its journal alone, once or until it ends.

mod screen;
mod vitals;

use std::io::{self, Write};
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
use crate::following::Source;
use crate::log::say;
use crate::page::is_read;
use crate::terminal::{self, WIDTH};
use crate::values;
use crate::waiting::is_stopped;
use screen::{Screen, Wish};
use vitals::Vitals;

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
    /// Follow the mission until it ends, and wait for it if nothing is there yet: on a terminal a page until `q`, else a
    /// text per change, at most ten in a second.
    #[arg(long, short)]
    pub watch: bool,
    /// Print one object on stdout; with --watch one in a line per change.
    #[arg(long)]
    pub json: bool,
    /// Read this log instead of the one of the instance; without --instance its daemon lives while it holds the file.
    #[arg(long, value_name = "FILE")]
    pub log: Option<PathBuf>,
}

/// Tells what a mission is at.
pub fn status(args: &StatusArgs) -> Result<Exit> {
    let source = Source::new(args.instance.clone(), args.log.clone());
    match if args.watch { watch(&source, args.json)? } else { once(&source, args.json)? } {
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

fn once(source: &Source, is_json: bool) -> Result<Told> {
    let Some(snapshot) = source.follow()?.snapshot() else {
        return Ok(Told::SoFar);
    };
    let mut vitals = Vitals::of(source.instance());
    let snapshot = with_vitals(snapshot, &mut vitals);
    print(&if is_json { json(&snapshot)? } else { text(&snapshot) })?;
    Ok(told(&snapshot))
}

/// Tells every change until the mission ended, its daemon is gone, or nobody wants to see more.
fn watch(source: &Source, is_json: bool) -> Result<Told> {
    let stop = Stop::on_signals().into_diagnostic()?;
    let mut view = View::new(is_json, Vitals::of(source.instance()))?;
    let mut following = loop {
        if let Some(following) = source.look()? {
            break following;
        }
        view.wait_for(&source.awaited())?;
        if let Some(told) = view.wish(&stop, TICK)? {
            return Ok(told);
        }
    };
    let mut ended: Option<Instant> = None;
    loop {
        let is_behind = following.catch_up()?;
        if !is_behind && following.is_abandoned() {
            return Ok(Told::Gone);
        }
        if let Some(snapshot) = following.snapshot().filter(|_| !is_behind) {
            let goes_on = view.show(&snapshot)?;
            let told = told(&snapshot);
            let is_over = match told {
                Told::Ended(_) => has_left(&snapshot, *ended.get_or_insert_with(Instant::now)),
                Told::Gone => true,
                Told::SoFar | Told::Interrupted => false,
            };
            if is_over || !goes_on {
                view.leave(&snapshot)?;
                return Ok(told);
            }
        }
        if let Some(told) = view.wish(&stop, if is_behind { Duration::ZERO } else { TICK })? {
            return Ok(told);
        }
    }
}

/// Where changes are told: on a screen, or one after the other.
struct View {
    screen: Option<Screen>,
    is_json: bool,
    last: Option<Snapshot>,
    is_waiting: bool,
    vitals: Vitals,
}

impl View {
    fn new(is_json: bool, vitals: Vitals) -> Result<Self> {
        let screen = if is_json { None } else { Screen::take().into_diagnostic()? };
        Ok(Self { screen, is_json, last: None, is_waiting: false, vitals })
    }

    fn wait_for(&mut self, what: &str) -> Result<()> {
        let said = format!("waiting for {what}");
        match &mut self.screen {
            Some(screen) => screen.show(vec![said, "q leaves".into()]).into_diagnostic()?,
            None if self.is_waiting => {}
            None => say(&said),
        }
        self.is_waiting = true;
        Ok(())
    }

    /// Tells what is different; false if nobody listens any more. Other numbers alone are no change but on a screen.
    fn show(&mut self, snapshot: &Snapshot) -> Result<bool> {
        let vitals = &mut self.vitals;
        let mut told = || with_vitals(snapshot.clone(), vitals);
        let goes_on = match &mut self.screen {
            Some(screen) => is_read(screen.show(lines(&told())))?,
            None if self.last.as_ref() == Some(snapshot) => true,
            None if self.is_json => print(&json(&told())?)?,
            None => print(&(text(&told()) + "\n"))?,
        };
        self.last = Some(snapshot.clone());
        Ok(goes_on)
    }

    /// What somebody wishes who looks at it; none to see more.
    fn wish(&mut self, stop: &Stop, within: Duration) -> Result<Option<Told>> {
        let wish = match &mut self.screen {
            Some(screen) => screen.wish(stop, within).into_diagnostic()?,
            None if is_stopped(stop, within)? => Wish::Stop,
            None => Wish::Stay,
        };
        Ok(match wish {
            Wish::Stay => None,
            Wish::Leave => Some(Told::SoFar),
            Wish::Stop => Some(Told::Interrupted),
        })
    }

    /// Gives the terminal back with the last page on it.
    fn leave(self, snapshot: &Snapshot) -> Result<()> {
        if self.screen.is_some() {
            drop(self.screen);
            print(&text(snapshot))?;
        }
        Ok(())
    }
}

/// With what the daemon says of the last second.
fn with_vitals(snapshot: Snapshot, vitals: &mut Vitals) -> Snapshot {
    let told = vitals.told(snapshot.daemon);
    snapshot.with_diagnostics(told)
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

/// What a terminal has room for, without the line in which the cursor rests.
fn lines(snapshot: &Snapshot) -> Vec<String> {
    let (width, height) = terminal::size(io::stdout()).unwrap_or((WIDTH, HEIGHT));
    match width < MIN_WIDTH {
        true => vec!["…".to_owned()],
        false => snapshot.lines(width, height.saturating_sub(1), &terminal::palette(&io::stdout())),
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
