//! `ambidex chaos`: missions with real processes to which things are done, and an auditor who looks at what is left.

mod plan;
mod processes;
mod rooms;
mod run;

use std::fs;
use std::io;
use std::num::NonZero;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use ambidex::files::{self, Disk};
use ambidex::link::Instance;
use ambidex::model::{Failures, Mishap, MissionSpec, Record, Time};
use ambidex::show::chaos::{ChaosReport, ChaosRun, text};
use ambidex::sim;
use ambidex::tree::Settings;
use clap::Args;
use miette::{IntoDiagnostic, Result, WrapErr};

use crate::diagnostics::report_all;
use crate::exit::Exit;
use crate::page::Page;
use crate::parallel::parallel;
use crate::terminal::Progress;
use crate::values;
use plan::Plan;
use processes::Recipe;

/// What a mission without an end is given, robot time.
const ENDLESS: Duration = Duration::from_secs(120);

/// `ambidex chaos`.
#[derive(Debug, Args)]
#[command(after_help = "\
Each run has a daemon and its controllers as processes of their own. Drawn from its seed,
controllers are killed, stopped, hung up or their emergency stop is pressed; the daemon is killed
and goes on in its log, is stopped or hung up; behaviors fail, hang, are late or drop what is held;
an operator changes the world and puts things in the way; the disk of the log is full or slow. What was killed or stopped
mostly comes back. After each run `ambidex audit` and `ambidex verify` look at its log and at what
the controllers wrote down themselves, and it is looked for what is left among processes and in
shared memory.

Exit codes: 0 nothing was found, 1 something was, 2 a mission is faulty or processes cannot be
started, 130 Ctrl-C.")]
pub struct ChaosArgs {
    /// The missions, one after the other.
    #[arg(required_unless_present = "rooms")]
    pub missions: Vec<PathBuf>,
    /// So many generated missions besides, for the robot of --robot.
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub rooms: u64,
    /// How many runs.
    #[arg(long, value_name = "N", default_value = "20")]
    pub runs: NonZero<u64>,
    /// What is done follows from this number and the number of the run.
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
    /// Robot seconds per wall second.
    #[arg(long, default_value_t = 20.0, value_parser = values::speed)]
    pub speed: f64,
    /// The robot of generated missions.
    #[arg(long, value_name = "FILE", default_value = "config/robots/pr2.yaml")]
    pub robot: PathBuf,
    /// After how many seconds of the wall clock a mission that still waits is told to end.
    #[arg(long, value_name = "SECONDS", default_value = "40", value_parser = values::seconds)]
    pub limit: Duration,
    /// How many runs at once [default: as many as there are cores].
    #[arg(long, value_name = "N")]
    pub jobs: Option<NonZero<usize>>,
    /// Where logs, records and words of runs with findings are kept.
    #[arg(long, value_name = "FOLDER", default_value = "chaos")]
    pub keep: PathBuf,
    /// Print one object on stdout, and nothing else there.
    #[arg(long)]
    pub json: bool,
    /// Say nothing but errors.
    #[arg(long, short)]
    pub quiet: bool,
}

/// A mission to be disturbed.
struct Target {
    path: PathBuf,
    robot: PathBuf,
    mission: Arc<MissionSpec>,
    /// About how long it takes when nothing goes wrong, wall time.
    wall: Duration,
}

/// Runs missions under chaos, and prints what was found.
pub fn chaos(args: &ChaosArgs) -> Result<Exit> {
    let stop = Arc::new(AtomicBool::new(false));
    for signal in [signal_hook::consts::SIGINT, signal_hook::consts::SIGTERM] {
        signal_hook::flag::register(signal, Arc::clone(&stop)).into_diagnostic()?;
    }
    let folder = Folder::new()?;
    let targets = targets(args, &folder.0)?;
    let report = ChaosReport { seed: args.seed, runs: runs(args, &targets, &folder.0, &stop)? };
    Page::new().tell(args.json, &report, text)?;
    Ok(if stop.load(Ordering::Relaxed) {
        Exit::Canceled
    } else if report.runs.iter().any(|run| !run.findings.is_empty()) {
        Exit::Failed
    } else {
        Exit::Done
    })
}

/// A folder for all runs, gone with them.
struct Folder(PathBuf);

impl Folder {
    fn new() -> Result<Self> {
        let path = std::env::temp_dir().join(format!("ambidex-chaos-{}", std::process::id()));
        fs::create_dir_all(&path).into_diagnostic()?;
        Ok(Self(path))
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        drop(fs::remove_dir_all(&self.0));
    }
}

fn targets(args: &ChaosArgs, folder: &Path) -> Result<Vec<Target>> {
    let mut paths = args.missions.clone();
    for number in 0..args.rooms {
        let robot =
            fs::canonicalize(&args.robot).into_diagnostic().wrap_err_with(|| args.robot.display().to_string())?;
        let path = folder.join(format!("room-{number}.yaml"));
        let text = rooms::mission(args.seed.wrapping_add(number), &robot.to_string_lossy());
        fs::write(&path, text).into_diagnostic()?;
        paths.push(path);
    }
    paths.into_iter().map(|path| target(path, args.speed)).collect()
}

fn target(path: PathBuf, speed: f64) -> Result<Target> {
    let loaded = files::load_mission(&Disk, &path, None, &[]).map_err(|error| report_all(&error))?;
    let mut last = Time::ZERO;
    let end = (Time::ZERO + ENDLESS, Mishap::Cancel);
    let failures = Failures { mishaps: vec![end], flaws: Vec::new() };
    let mut take = |record: &Record| last = last.max(record.at());
    sim::simulate_failures(&loaded.mission, &Settings::default(), &failures, &mut take);
    let wall = (last - Time::ZERO).div_f64(speed);
    Ok(Target { path, robot: loaded.robot_path, mission: loaded.mission, wall })
}

/// All runs, several at once.
fn runs(args: &ChaosArgs, targets: &[Target], folder: &Path, stop: &AtomicBool) -> Result<Vec<ChaosRun>> {
    let program = std::env::current_exe().into_diagnostic()?;
    let progress = Progress::new(args.runs.get(), "runs", args.quiet);
    let has_failed = AtomicBool::new(false);
    let run = |index: u64| {
        let target = &targets[(index % targets.len() as u64) as usize];
        let run = one(args, target, args.seed.wrapping_add(index), &program, &folder.join(index.to_string()));
        has_failed.fetch_or(run.is_err(), Ordering::Relaxed);
        let run = run?;
        for finding in &run.findings {
            progress.say(&format!("seed {}, {}: {finding}", run.seed, run.mission));
        }
        Ok(run)
    };
    let is_stopped = || stop.load(Ordering::Relaxed) || has_failed.load(Ordering::Relaxed);
    let runs: io::Result<_> = parallel(args.runs.get(), args.jobs, &progress, is_stopped, run).into_iter().collect();
    runs.into_diagnostic()
}

fn one(args: &ChaosArgs, target: &Target, seed: u64, program: &Path, folder: &Path) -> io::Result<ChaosRun> {
    let instance = Instance::fresh();
    let recipe = Recipe {
        program: program.to_owned(),
        folder: folder.to_owned(),
        instance,
        mission: target.path.clone(),
        robot: target.robot.clone(),
        speed: args.speed,
    };
    let plan = Plan::draw(seed, &target.mission, target.wall, args.speed);
    let begun = Instant::now();
    let mut run = run::run(&recipe, &target.mission, &plan, args.limit)?;
    run.seed = seed;
    run.mission.clone_from(&target.mission.name);
    run.wall_s = begun.elapsed().as_secs_f64();
    if !run.findings.is_empty() {
        let kept = args.keep.join(seed.to_string());
        copy(folder, &kept)?;
        fs::copy(&target.path, kept.join("mission.yaml"))?;
    }
    fs::remove_dir_all(folder)?;
    Ok(run)
}

/// Copies a folder with all files and folders in it.
fn copy(from: &Path, to: &Path) -> io::Result<()> {
    fs::create_dir_all(to)?;
    for entry in fs::read_dir(from)? {
        let entry = entry?;
        let to = to.join(entry.file_name());
        if entry.file_type()?.is_dir() {
            copy(&entry.path(), &to)?;
        } else if entry.file_type()?.is_file() {
            fs::copy(entry.path(), to)?;
        }
    }
    Ok(())
}
