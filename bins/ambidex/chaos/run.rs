//! One run under chaos, and what is looked at after it.

use std::collections::{BTreeMap, VecDeque};
use std::fs;
use std::io;
use std::path::Path;
use std::thread;
use std::time::{Duration, Instant};

use ambidex::files::failures_text;
use ambidex::http::{self, Request};
use ambidex::link;
use ambidex::model::{Change, Location, MissionEnd, MissionSpec, Obstacle, Record};
use ambidex::record::Reader;
use ambidex::runtime::control::WorldChange;
use ambidex::show::chaos::{ChaosRun, Outcome};
use rustix::process::Signal;

use super::plan::{Deed, Plan};
use super::processes::{Processes, Recipe};
use crate::audit;
use crate::verify::{self, Again};

/// How often processes are looked at.
const POLL: Duration = Duration::from_millis(10);
/// How long processes may take to be there, wall time.
const BEGIN_GRACE: Duration = Duration::from_secs(10);
/// How long a mission may take to end once it is told to, wall time.
const END_GRACE: Duration = Duration::from_secs(20);

/// What comes back or goes on, and when.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Later {
    Start(usize),
    Continue(usize),
    ReleaseStop(usize),
    Resume,
    ContinueDaemon,
}

/// One run that goes on.
struct Going<'a> {
    processes: Processes,
    mission: &'a MissionSpec,
    recipe: &'a Recipe,
    later: Vec<(Instant, Later)>,
    daemon_is_away: bool,
    done: BTreeMap<&'static str, u32>,
    findings: Vec<String>,
}

/// Does what is planned to a mission, and looks at what is left.
///
/// # Errors
/// When processes cannot be started, or files not be made.
pub fn run(recipe: &Recipe, mission: &MissionSpec, plan: &Plan, limit: Duration) -> io::Result<ChaosRun> {
    fs::create_dir_all(recipe.records())?;
    if let Some(text) = failures_text(&plan.failures, &mission.names) {
        fs::write(recipe.failures(), text)?;
    }
    let names = mission.robot.controllers.iter().map(|spec| spec.name.clone()).collect();
    let mut going = Going {
        processes: Processes::start(recipe.clone(), names)?,
        mission,
        recipe,
        later: Vec::new(),
        daemon_is_away: false,
        done: BTreeMap::new(),
        findings: Vec::new(),
    };
    let code = going.carry(plan, limit)?;
    let left = going.processes.end_controllers();
    going.findings.extend(left.iter().map(|name| format!("{name} does not end when it is told to")));
    let last_words = going.processes.last_words();
    let Going { mut findings, mut done, processes, .. } = going;
    drop(processes);
    let planned = [
        ("a behavior that does wrong", plan.failures.flaws.len()),
        ("a full or slow disk", plan.failures.mishaps.len()),
    ];
    done.extend(planned.into_iter().filter(|(_, times)| *times > 0).map(|(deed, times)| (deed, times as u32)));
    findings.extend(left_over(recipe));
    let mut run = ChaosRun { findings, done, outcome: Outcome::of(code), ..ChaosRun::default() };
    look(recipe, code, &last_words, &mut run);
    Ok(run)
}

impl Going<'_> {
    /// Does one thing after the other until the daemon has ended; its exit code.
    fn carry(&mut self, plan: &Plan, limit: Duration) -> io::Result<Option<i32>> {
        let begun = self.begun();
        let mut deeds: VecDeque<_> = plan.deeds.clone().into();
        let mut told_to_end: Option<Instant> = None;
        loop {
            thread::sleep(POLL);
            let now = Instant::now();
            for later in self.due(now) {
                self.come_back(later)?;
            }
            if let Some((_, deed)) = deeds.pop_front_if(|(at, _)| begun + *at <= now) {
                self.deed(deed, now);
            }
            if !self.daemon_is_away
                && let Some(status) = self.processes.ended()
            {
                return Ok(status.code());
            }
            match told_to_end {
                None if now > begun + limit && !self.daemon_is_away => {
                    self.processes.signal_daemon(Signal::TERM);
                    *self.done.entry("SIGTERM, since it waited").or_default() += 1;
                    told_to_end = Some(now);
                }
                Some(told) if now > told + END_GRACE => {
                    self.findings.push(format!("it does not end within {} s of SIGTERM", END_GRACE.as_secs()));
                    self.processes.kill_daemon();
                    return Ok(None);
                }
                None | Some(_) => {}
            }
        }
    }

    /// When the mission has begun, as its log tells; else when that has been waited for long enough.
    fn begun(&mut self) -> Instant {
        let by = Instant::now() + BEGIN_GRACE;
        let is_begun = |record| matches!(record, Ok(Record::Began { .. }));
        while Instant::now() < by && self.processes.ended().is_none() {
            if Reader::open(self.recipe.log()).is_ok_and(|mut log| log.any(is_begun)) {
                break;
            }
            thread::sleep(POLL);
        }
        Instant::now()
    }

    fn due(&mut self, now: Instant) -> Vec<Later> {
        let (due, later) = std::mem::take(&mut self.later).into_iter().partition(|(at, _)| *at <= now);
        self.later = later;
        let due: Vec<(Instant, Later)> = due;
        due.into_iter().map(|(_, later)| later).collect()
    }

    fn come_back(&mut self, later: Later) -> io::Result<()> {
        match later {
            Later::Start(index) => self.processes.start_controller(index)?,
            Later::Continue(index) => self.processes.signal_controller(index, Signal::CONT),
            Later::ReleaseStop(index) => self.processes.signal_controller(index, Signal::USR2),
            Later::Resume => {
                self.processes.resume()?;
                self.daemon_is_away = false;
            }
            Later::ContinueDaemon => self.processes.signal_daemon(Signal::CONT),
        }
        Ok(())
    }

    fn deed(&mut self, deed: Deed, now: Instant) {
        // A daemon that has ended, or is away, is not struck again.
        let is_of_daemon = matches!(deed, Deed::KillDaemon(_) | Deed::StopDaemon(_) | Deed::HangUpDaemon);
        if is_of_daemon && (self.daemon_is_away || self.processes.ended().is_some()) {
            return;
        }
        *self.done.entry(deed.word()).or_default() += 1;
        let processes = &mut self.processes;
        match deed {
            Deed::Kill(index, back) => {
                processes.kill_controller(index);
                self.later.extend(back.map(|back| (now + back, Later::Start(index))));
            }
            Deed::Stop(index, back) => {
                processes.signal_controller(index, Signal::STOP);
                self.later.extend(back.map(|back| (now + back, Later::Continue(index))));
            }
            Deed::HangUp(index, back) => {
                processes.signal_controller(index, Signal::HUP);
                self.later.push((now + back.max(Duration::from_secs(1)), Later::Start(index)));
            }
            Deed::PressStop(index, back) => {
                processes.signal_controller(index, Signal::USR1);
                self.later.push((now + back, Later::ReleaseStop(index)));
            }
            Deed::KillDaemon(back) => {
                processes.kill_daemon();
                // One that was killed before it had a log to go on in is not to be resumed.
                if has_header(&self.recipe.log()) {
                    self.daemon_is_away = true;
                    self.later.push((now + back, Later::Resume));
                }
            }
            Deed::StopDaemon(back) => {
                processes.signal_daemon(Signal::STOP);
                self.later.push((now + back, Later::ContinueDaemon));
            }
            Deed::HangUpDaemon => processes.signal_daemon(Signal::HUP),
            Deed::Change(change) => self.say(change),
        }
    }

    /// An operator says it; whether it is taken is the daemon's business.
    fn say(&self, change: Change) {
        let names = &self.mission.names;
        let change = match change {
            Change::Fact(fact, holds) => WorldChange::Fact { fact: names.fact(fact).to_owned(), holds },
            Change::Object(object, Location::At(place)) | Change::Laid(object, place, _) => {
                WorldChange::Place { object: names.object(object).to_owned(), place: names.place(place).to_owned() }
            }
            Change::Blocked(Obstacle { middle, size, heading }) => {
                WorldChange::Block { at: middle.xy().into(), size: size.xy().into(), heading }
            }
            Change::Cleared(around) => WorldChange::Unblock { at: around.at.into() },
            Change::Object(..) | Change::Taken(..) | Change::Emptied(_) | Change::Base(_) => return,
        };
        let instance = self.recipe.instance.clone();
        // It may wait for its answer; the run goes on.
        thread::spawn(move || http::ask(&instance, &Request::World(change)));
    }
}

/// Whether there is a log that a daemon could go on in.
fn has_header(log: &Path) -> bool {
    Reader::open(log).is_ok()
}

/// What is left in shared memory once the next process has swept it.
fn left_over(recipe: &Recipe) -> Option<String> {
    if let Err(error) = link::sweep() {
        return Some(format!("shared memory cannot be swept: {error}"));
    }
    let name = recipe.instance.name();
    recipe.instance.has_left_anything().then(|| format!("the instance {name} is left in shared memory"))
}

/// Audits the log, decides it again, and looks whether the exit code tells what the log does.
fn look(recipe: &Recipe, code: Option<i32>, last_words: &str, run: &mut ChaosRun) {
    let log = recipe.log();
    if !has_header(&log) {
        run.outcome = Outcome::NotBegun;
        if code.is_some() {
            run.findings.push(format!("it ends with {code:?} and has no log: {last_words}"));
        }
        return;
    }
    let is_incomplete = code == Some(5) || has_said(recipe, "the log is incomplete");
    match audit::look(&log, Some(&recipe.records()), !is_incomplete) {
        Ok(report) => {
            run.findings.extend(report.findings.iter().map(ToString::to_string));
            if report.open.is_some() && !is_incomplete && code.is_some() {
                run.findings.push(format!("it ends with {code:?} and its log does not end: {last_words}"));
            }
            run.records = report.records;
            run.looked_at = report.looked_at;
        }
        Err(error) => run.findings.push(format!("its log cannot be audited: {error:?}")),
    }
    match verify::again(&log) {
        Ok(Again::Same { .. }) => {}
        Ok(Again::Different { line, .. }) => {
            run.findings.push(format!("line {line} of its log is decided otherwise"));
        }
        Err(error) => run.findings.push(format!("its log cannot be decided again: {error:?}")),
    }
    if let (Some(expected), false) = (last_end(&log).map(expected_code), is_incomplete)
        && code.is_some_and(|code| code != expected)
    {
        run.findings
            .push(format!("its log ends as for exit code {expected}, and it ended with {code:?}: {last_words}"));
    }
}

/// Whether any daemon of the run has said something.
fn has_said(recipe: &Recipe, words: &str) -> bool {
    let entries = fs::read_dir(&recipe.folder).into_iter().flatten().flatten();
    let said = entries.filter(|entry| entry.file_name().to_string_lossy().starts_with("daemon-"));
    said.filter_map(|entry| fs::read_to_string(entry.path()).ok()).any(|said| said.contains(words))
}

fn last_end(log: &Path) -> Option<MissionEnd> {
    let mut end = None;
    for record in Reader::open(log).ok()? {
        match record {
            Ok(Record::Ended { end: told, .. }) if end.is_none() => end = Some(told),
            Ok(_) | Err(_) => {}
        }
    }
    end
}

fn expected_code(end: MissionEnd) -> i32 {
    crate::exit::Exit::from(end) as i32
}
