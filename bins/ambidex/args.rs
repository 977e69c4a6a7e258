//! What can be said on the command line.

use std::net::SocketAddr;
use std::num::NonZeroU64;
use std::path::PathBuf;
use std::sync::{Arc, OnceLock};
use std::time::Duration;

use ambidex::files::Setting;
use ambidex::link::{Instance, WIRE_VERSION};
use ambidex::model::MissionSpec;
use ambidex::tree::{Allocator, Greedy, Serial};
use clap::{Args, Parser, Subcommand, ValueEnum};
use clap_complete::Shell;

use crate::audit::AuditArgs;
use crate::chaos::ChaosArgs;
use crate::check::{CheckArgs, SchemaArgs};
use crate::doctor::DoctorArgs;
use crate::edit::EditArgs;
use crate::exit::{self, Exit};
use crate::explain::ExplainArgs;
use crate::export::ExportArgs;
use crate::import::ImportArgs;
use crate::man::ManArgs;
use crate::map::MapArgs;
use crate::pacing::{StopArgs, TaskArgs, TasksArgs};
use crate::status::StatusArgs;
use crate::submit::SubmitArgs;
use crate::tasks::{ListArgs, ShowArgs};
use crate::timeline::TimelineArgs;
use crate::trace::TraceArgs;
use crate::tree::TreeArgs;
use crate::values::{self, Fail, LogFormat};
use crate::verify::VerifyArgs;
use crate::watch::WatchArgs;
use crate::world::WorldArgs;

/// What `--help` says below everything, after the exit codes.
const NOTES: &str = "\
status ends with 0 whenever it could tell, however the mission ended.

Ctrl-C once cancels the mission: what was begun is cleaned up (--cleanup-grace), controllers come to rest within 3 s,
then the process ends.
Twice ends it at once.

stdout carries data (--json), stderr talks. NO_COLOR and RUST_LOG are respected.";

/// One robot, several tasks at once.
#[derive(Debug, Parser)]
#[command(name = "ambidex", version = version(), about, after_help = notes())]
pub struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub verb: Verb,
}

/// The verbs.
#[derive(Debug, Subcommand)]
pub enum Verb {
    /// Run a mission: starts the runtime and one process per controller.
    Run(RunArgs),
    /// Run a mission with controllers that others start.
    Daemon(DaemonArgs),
    /// Be one controller of the robot, simulated.
    ///
    /// SIGUSR1 presses its emergency stop, SIGUSR2 releases it.
    Controller(ControllerArgs),
    /// Run a mission under a virtual clock, without processes.
    Simulate(SimulateArgs),
    /// Say everything that is wrong with mission, robot and behavior files.
    Check(CheckArgs),
    /// Print the JSON Schema of a file format, for editors.
    Schema(SchemaArgs),
    /// Tell what the mission of an instance is at: tree, resources, controllers, world.
    Status(StatusArgs),
    /// Draw when each behavior of a run was active, and who held which resource.
    Timeline(TimelineArgs),
    /// Draw the task tree of a mission, or of a run with the states of its behaviors.
    Tree(TreeArgs),
    /// Draw the room of a mission from above: what stands and lies where, what the arms reach, and what a run drove.
    Map(MapArgs),
    /// Print the log of a run as a conversation: who said what to whom, line by line.
    Trace(TraceArgs),
    /// Say in sentences what happened in a run and why, or why one behavior ran or did not.
    Explain(ExplainArgs),
    /// Write a log for other programs: trace events for Perfetto, tables as CSV, an MCAP file for Foxglove.
    Export(ExportArgs),
    /// Compute every decision of a log again, and say whether it is the same.
    Verify(VerifyArgs),
    /// Do all that can go wrong to missions with real processes, and look whether what must hold does.
    Chaos(ChaosArgs),
    /// Look at a log for what must hold in every run, and say what does not.
    Audit(AuditArgs),
    /// Tell a running mission that the world is different: a fact that others set, an object that somebody moved.
    World(WorldArgs),
    /// Give a running robot one more task.
    Submit(SubmitArgs),
    /// List the tasks of a running robot.
    List(ListArgs),
    /// Show a task of a running robot with its tree.
    Show(ShowArgs),
    /// Tell what happens to the tasks of a running robot, a line each.
    Watch(WatchArgs),
    /// Tell a task to end: what was begun is cleaned up.
    Cancel(TaskArgs),
    /// Grant a task nothing more for now; what runs goes on to its end.
    Pause(TasksArgs),
    /// Let a paused task go on.
    Resume(TasksArgs),
    /// Grant a task one step, and pause it again.
    Step(TasksArgs),
    /// Change the tree of a task while it runs.
    Edit(EditArgs),
    /// Tell a running robot to end everything: what was begun is cleaned up, then its daemon ends.
    Stop(StopArgs),
    /// Turn a task file or a robot file of the dHTT software into one of Ambidex.
    Import(ImportArgs),
    /// Look whether this machine is fit for a robot, and say what to do where it is not.
    Doctor(DoctorArgs),
    /// Print the manual page of the program, or write those of all verbs.
    Man(ManArgs),
    /// Print a completion script for a shell.
    Completions {
        /// Which shell.
        shell: Shell,
    },
}

/// What every way to run a mission takes.
#[derive(Debug, Args)]
pub struct MissionArgs {
    /// Use this robot file instead of the one that the mission names.
    #[arg(long, value_name = "FILE")]
    pub robot: Option<PathBuf>,
    /// Tell the mission a value for one of its parameters; can be given for each.
    #[arg(long, value_name = "NAME=VALUE")]
    pub set: Vec<Setting>,
    /// How requests are chosen.
    #[arg(long, value_enum, default_value_t = AllocatorName::Greedy)]
    pub allocator: AllocatorName,
    /// Print one report object on stdout, and nothing else there.
    #[arg(long)]
    pub json: bool,
    /// Say nothing but errors.
    #[arg(long, short)]
    pub quiet: bool,
    /// Where the log goes [default: $XDG_STATE_HOME/ambidex/INSTANCE/journal.jsonl].
    #[arg(long, value_name = "FILE")]
    pub log: Option<PathBuf>,
    /// Record the run as an MCAP file too, for Foxglove and other viewers: the tree and what its nodes are, resources,
    /// messages, where things are, and what is said. Readable also when the process is killed, but for the last second.
    #[arg(long, value_name = "FILE")]
    pub record: Option<PathBuf>,
    /// How many logs of an instance are kept where logs lie by default; unnamed runs count as one instance.
    #[arg(long, value_name = "N", default_value_t = 10, value_parser = clap::value_parser!(u32).range(1..))]
    pub keep_logs: u32,
    /// How long the log of a run that takes tasks may be before it begins anew with what the run is, MiB; the one so far
    /// is put aside and counts as one of --keep-logs.
    #[arg(long, value_name = "MIB", default_value = "64", value_parser = values::mebibytes)]
    pub log_size: u64,
    /// Whether the log tells every message between nodes, and with every decision why all else does not run
    /// [default: up to 200 nodes, none with --world]. Both can be computed again, which `trace LOG` and `explain LOG NODE` do.
    #[arg(long, value_enum)]
    pub messages: Option<Messages>,
    /// How long a controller that is gone is awaited when nothing can go on without it, seconds.
    #[arg(long, value_name = "SECONDS", default_value = "10", value_parser = values::seconds, allow_negative_numbers = true)]
    pub reattach_timeout: Duration,
    /// How long all cleanups together may take once the mission is told to end, seconds.
    #[arg(long, value_name = "SECONDS", default_value = "10", value_parser = values::seconds, allow_negative_numbers = true)]
    pub cleanup_grace: Duration,
    /// Form of log lines on the terminal; RUST_LOG says which are shown. The log file is always JSON Lines.
    #[arg(long, value_enum, default_value_t = LogFormat::Text)]
    pub log_format: LogFormat,
}

/// The mission of a run with processes, and what it takes besides.
#[derive(Debug, Clone, Args)]
pub struct LiveArgs {
    /// The mission file. With --resume it may be left out; if it is there, it must be that of the log.
    #[arg(required_unless_present_any = ["resume", "world"])]
    pub mission: Option<PathBuf>,
    /// Begin with nothing to do, in the world of this file, and take tasks: see `submit`.
    #[arg(long, value_name = "FILE", requires = "robot", conflicts_with = "mission")]
    pub world: Option<PathBuf>,
    /// Go on in this log, a file or an instance, as if its runtime had never been gone.
    #[arg(long, value_name = "LOG", conflicts_with_all = ["log", "allocator", "messages", "on_stall", "keep_logs", "reattach_timeout", "cleanup_grace"])]
    pub resume: Option<String>,
    /// Robot seconds per wall second, for simulated controllers.
    #[arg(long, default_value_t = 1.0, value_parser = values::speed)]
    pub speed: f64,
    /// Also be asked over HTTP at this address of loopback, such as 127.0.0.1:8080; port 0 is any that is free.
    #[arg(long, value_name = "ADDRESS", value_parser = values::loopback)]
    pub http: Option<SocketAddr>,
    /// What to do in a stall.
    #[arg(long, hide = true, value_enum, default_value_t = OnStall::End)]
    pub on_stall: OnStall,
}

/// `ambidex run`.
#[derive(Debug, Args)]
pub struct RunArgs {
    #[command(flatten)]
    pub live: LiveArgs,
    #[command(flatten)]
    pub common: MissionArgs,
    /// Name of this robot's runtime [default: a fresh one].
    #[arg(long, value_parser = values::instance)]
    pub instance: Option<Instance>,
    /// Let things go wrong on purpose, as this file says.
    #[arg(long, value_name = "FILE", conflicts_with = "resume")]
    pub fail: Option<PathBuf>,
    /// How long to wait for the controllers, seconds.
    #[arg(long, value_name = "SECONDS", default_value = "10", value_parser = values::seconds, allow_negative_numbers = true)]
    pub attach_timeout: Duration,
}

/// `ambidex daemon`.
#[derive(Debug, Args)]
pub struct DaemonArgs {
    #[command(flatten)]
    pub live: LiveArgs,
    #[command(flatten)]
    pub common: MissionArgs,
    /// Name of this robot's runtime.
    #[arg(long, default_value = "default", value_parser = values::instance)]
    pub instance: Instance,
    /// Let things go wrong on purpose, as this file says; what is to happen to a controller is for whoever started it.
    #[arg(long, value_name = "FILE", conflicts_with = "resume")]
    pub fail: Option<PathBuf>,
    /// Go on in the log of this instance's last run, or that of --log, if its runtime was gone before the mission had
    /// ended; else begin the mission. For a service that is started again after it was killed. What goes on keeps its
    /// settings.
    #[arg(long, conflicts_with_all = ["resume", "fail"])]
    pub or_resume: bool,
    /// How long to wait for the controllers, seconds [default: for ever].
    #[arg(long, value_name = "SECONDS", value_parser = values::seconds, allow_negative_numbers = true)]
    pub attach_timeout: Option<Duration>,
}

/// `ambidex controller`.
#[derive(Debug, Args)]
pub struct ControllerArgs {
    /// Its name in the robot file.
    pub name: String,
    /// The robot file.
    #[arg(long, value_name = "FILE", default_value = "config/robots/pr2.yaml")]
    pub robot: PathBuf,
    /// Name of the robot's runtime.
    #[arg(long, default_value = "default", value_parser = values::instance)]
    pub instance: Instance,
    /// Form of log lines; RUST_LOG says which are shown.
    #[arg(long, value_enum, default_value_t = LogFormat::Text)]
    pub log_format: LogFormat,
    /// Write down what it is told and says, behind what stands there already; for `ambidex audit --records`.
    #[arg(long, value_name = "FILE")]
    pub record: Option<PathBuf>,
    /// End with the first daemon instead of waiting for the next.
    #[arg(long)]
    pub once: bool,
    /// End when this process does.
    #[arg(long, hide = true, value_name = "PID")]
    pub parent: Option<u32>,
}

/// `ambidex simulate`.
#[derive(Debug, Args)]
pub struct SimulateArgs {
    /// The mission file.
    pub mission: PathBuf,
    /// Let things go wrong on purpose: as this file says, or by chance, in each attempt of a behavior with this
    /// probability: it gives up, hangs, is late or drops what is held, a controller is lost, hangs or is stopped, the
    /// world changes.
    #[arg(long, value_name = "FILE|PROBABILITY", value_parser = values::fail)]
    pub fail: Option<Fail>,
    /// What goes wrong by chance follows from this number [default: 1].
    #[arg(long, value_name = "N")]
    pub seed: Option<u64>,
    /// Run so often, with this seed and those after it, and print how often it was done, how long it took, and why not.
    #[arg(long, value_name = "N", conflicts_with_all = ["log", "record", "save_failures"])]
    pub runs: Option<NonZeroU64>,
    /// Write what went wrong by chance as a file for `--fail`, of `run` too.
    #[arg(long, value_name = "FILE")]
    pub save_failures: Option<PathBuf>,
    /// Tell the mission to end at that moment of robot time, seconds; for one that never ends by itself.
    #[arg(long, value_name = "SECONDS", value_parser = values::seconds, allow_negative_numbers = true)]
    pub until: Option<Duration>,
    #[command(flatten)]
    pub common: MissionArgs,
}

impl SimulateArgs {
    /// What was told that is only about chance.
    pub fn chance_option(&self) -> Option<&'static str> {
        let save = self.save_failures.as_ref().map(|_| "--save-failures");
        self.runs.map(|_| "--runs").or(self.seed.map(|_| "--seed")).or(save)
    }
}

/// Names of allocators.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum AllocatorName {
    /// The paper's: the best request and all that are compatible with it.
    Greedy,
    /// One behavior at a time has the whole robot.
    Serial,
}

impl AllocatorName {
    /// The allocator behind the name.
    pub fn allocator(self) -> Arc<dyn Allocator> {
        match self {
            Self::Greedy => Arc::new(Greedy),
            Self::Serial => Arc::new(Serial),
        }
    }
}

/// What of the talk of nodes a log tells.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Messages {
    /// Every message and every refusal.
    All,
    /// Neither.
    None,
}

impl Messages {
    /// Trees of so many nodes are small.
    const SMALL: usize = 200;

    /// Whether messages are told of a mission.
    pub fn are_told(told: Option<Self>, mission: &MissionSpec) -> bool {
        match told {
            Some(Self::All) => true,
            Some(Self::None) => false,
            // The log of tasks that come and go grows as long as they do.
            None => !mission.tree.is_standing() && mission.tree.nodes.len() <= Self::SMALL,
        }
    }
}

/// What to do in a stall.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum OnStall {
    /// End the mission and say why.
    End,
    /// Wait for the world to change.
    Wait,
}

fn notes() -> String {
    let code = |(exit, meaning): &(Exit, &str)| format!("{:>5}  {}\n", *exit as u8, meaning.replace('\n', "\n       "));
    let codes: String = exit::MEANINGS.iter().map(code).collect();
    format!("Exit codes:\n{codes}\n{NOTES}")
}

fn version() -> &'static str {
    static VERSION: OnceLock<String> = OnceLock::new();
    VERSION.get_or_init(|| format!("{} (wire version {WIRE_VERSION})", env!("CARGO_PKG_VERSION")))
}
