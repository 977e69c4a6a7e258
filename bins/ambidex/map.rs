//! `ambidex map`.

use std::path::PathBuf;

use ambidex::files::{self, Disk, Setting};
use ambidex::record::Reader;
use ambidex::show::map::{Moment, Scene, picture};
use clap::Args;
use miette::{IntoDiagnostic, Result, miette};

use crate::diagnostics::report_all;
use crate::exit::Exit;
use crate::{log, out};

/// `ambidex map`.
#[derive(Debug, Args)]
pub struct MapArgs {
    /// A mission file.
    #[arg(value_name = "MISSION")]
    pub mission: PathBuf,
    /// The log of a run of it, a file or an instance: with what it drove, and where everything is then.
    #[arg(long, value_name = "LOG")]
    pub log: Option<String>,
    /// Not the end of the log but as a step of the run begins (`3`, counted from 1), or some time of it (`12.5s`).
    #[arg(long, value_name = "STEP|TIME", requires = "log")]
    pub at: Option<Moment>,
    /// The SVG picture; - is stdout.
    #[arg(long, short, value_name = "FILE")]
    pub output: PathBuf,
    /// Use this robot file instead of the one that the mission names.
    #[arg(long, value_name = "FILE")]
    pub robot: Option<PathBuf>,
    /// Tell the mission a value for one of its parameters; can be given for each.
    #[arg(long, value_name = "NAME=VALUE")]
    pub set: Vec<Setting>,
}

/// Draws the room from above.
pub fn map(args: &MapArgs) -> Result<Exit> {
    out::spare(&args.mission, Some(&args.output))?;
    let robot = args.robot.as_deref();
    let loaded = files::load_mission(&Disk, &args.mission, robot, &args.set).map_err(|error| report_all(&error))?;
    let mut scene = Scene::new(&loaded.mission);
    if let Some(log) = &args.log {
        let path = log::find(Some(log))?;
        out::spare(&path, Some(&args.output))?;
        let reader = Reader::open(&path).into_diagnostic()?;
        let header = reader.header();
        if header.mission != loaded.mission.name || header.names.places != loaded.mission.names.places {
            return Err(miette!(
                help = "give the mission file that this run was of",
                "the log is of the mission {}, with other places than {}",
                header.mission,
                loaded.mission.name
            ));
        }
        let mut is_reached = false;
        log::read(reader, |record| {
            is_reached |= !scene.take(record, args.at);
            Ok(!is_reached)
        })?;
        if let (Some(Moment::Step(step)), false) = (args.at, is_reached) {
            return Err(miette!("there is no step {step}: the run had {}", scene.steps()));
        }
    }
    out::write(&args.output, &picture(&scene))?;
    Ok(Exit::Done)
}
