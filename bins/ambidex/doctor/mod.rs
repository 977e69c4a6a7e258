//! `ambidex doctor`: whether this machine is fit for a robot, and what to do where it is not.

mod clock;
mod files;
mod leftovers;
mod permissions;
mod shared_memory;
mod system;
mod versions;

use std::path::{Path, PathBuf};

use ambidex::link::{self, Instance, Survey, Swept};
use ambidex::record::shown;
use ambidex::runtime::log;
use ambidex::show::doctor::{Examination, Topic, Verdict};
use clap::Args;
use miette::{IntoDiagnostic, Result};

use crate::diagnostics::legible;
use crate::exit::Exit;
use crate::page::Page;
use crate::values;

const HELP: &str = "\
OK: as a robot needs it. WARN: a robot runs, perhaps not as well as it could. ERROR: a robot does not run so.
It takes about a second, changes nothing without --fix, and disturbs no robot that runs.

Exit codes: 0 nothing is wrong (there may be warnings), 1 something is (ERROR).";

/// `ambidex doctor`.
#[derive(Debug, Args)]
#[command(after_help = HELP)]
pub struct DoctorArgs {
    /// Whose daemon, log and number of controllers are looked at [default: all living daemons, and the newest log].
    #[arg(long, value_parser = values::instance)]
    pub instance: Option<Instance>,
    /// Remove first what surely belongs to no process any more: instances, locks, sockets and shared memory of the dead.
    #[arg(long)]
    pub fix: bool,
    /// Print one object on stdout, and nothing else there.
    #[arg(long)]
    pub json: bool,
}

/// What the checks are about.
struct Subject {
    instance: Option<Instance>,
    survey: Survey,
    log: Option<PathBuf>,
}

/// Looks at the machine and tells what it found.
pub fn doctor(args: &DoctorArgs) -> Result<Exit> {
    let removed = if args.fix { link::sweep_all().into_diagnostic()?.iter().map(told).collect() } else { Vec::new() };
    let examination = Examination::new(checks(args), removed);
    Page::new().tell(args.json, &examination, Examination::text)?;
    Ok(match examination.verdict {
        Verdict::Ok | Verdict::Warn => Exit::Done,
        Verdict::Error => Exit::Failed,
    })
}

fn checks(args: &DoctorArgs) -> Vec<ambidex::show::doctor::Check> {
    let mut checks = shared_memory::checks(link::shared_memory());
    let survey = link::survey().unwrap_or_else(|error| {
        let todo = "see which process holds it with `lsof`, and end it if it hangs";
        checks.push(Topic::Leftovers.error("instances", format!("they cannot be looked at: {error}"), todo));
        Survey::default()
    });
    let subject = Subject { instance: args.instance.clone(), survey, log: newest_log(args.instance.as_ref()) };
    checks.extend(permissions::checks(&subject));
    checks.extend(leftovers::checks(&subject.survey));
    checks.extend(versions::checks(&subject));
    checks.extend(clock::checks(&subject));
    checks.extend(files::checks(&subject));
    checks.extend(system::checks());
    checks
}

/// The log of an instance, or the newest of all.
fn newest_log(instance: Option<&Instance>) -> Option<PathBuf> {
    let name = instance.map(|instance| instance.name().to_owned()).or_else(|| log::instances().into_iter().next())?;
    Some(log::default_path(&name)).filter(|path| path.exists())
}

fn told(swept: &Swept) -> String {
    match swept {
        Swept::Instance { name, segments } => {
            format!("instance {} and {segments} segments of shared memory", legible(name))
        }
        Swept::Node { id } => format!("node {id} of a process that is gone"),
        Swept::File(path) | Swept::Segment(path) => shown(path),
    }
}

/// Bytes as people read them: `1.5 MiB`.
fn bytes(bytes: u64) -> String {
    let scales = [(1 << 30, "GiB"), (1 << 20, "MiB"), (1 << 10, "KiB")];
    match scales.into_iter().find(|(scale, _)| bytes >= *scale) {
        Some((scale, unit)) => format!("{:.1} {unit}", bytes as f64 / scale as f64),
        None => format!("{bytes} bytes"),
    }
}

/// The first line of a file that the system shows, without its end; none where there is no such file.
fn first_line(path: impl AsRef<Path>) -> Option<String> {
    let text = std::fs::read_to_string(path).ok()?;
    text.lines().next().map(legible)
}
