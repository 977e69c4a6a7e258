//! `ambidex check` and `ambidex schema`.

use std::path::PathBuf;

use ambidex::files::{self, Checked, Disk, Fault, Format, Setting};
use ambidex::model::MissionSpec;
use clap::{Args, ValueEnum};
use miette::{IntoDiagnostic, Result};
use serde_json::{Value, json};

use crate::diagnostics::{legible, report_all, say, say_all};
use crate::exit::Exit;
use crate::page::Page;

/// `ambidex check`.
#[derive(Debug, Args)]
pub struct CheckArgs {
    /// Mission, robot, behavior and failure files; what each is is seen from its keys.
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
    /// Tell the mission a value for one of its parameters; can be given for each.
    #[arg(long, value_name = "NAME=VALUE")]
    set: Vec<Setting>,
    /// Print one list of all faults on stdout, and nothing else there.
    #[arg(long)]
    json: bool,
    /// Treat warnings like mistakes.
    #[arg(long)]
    strict: bool,
}

/// `ambidex schema`.
#[derive(Debug, Args)]
pub struct SchemaArgs {
    /// Which format.
    format: FormatName,
}

/// Names of file formats.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum FormatName {
    /// A task for a robot in a world.
    Mission,
    /// A robot and its controllers.
    Robot,
    /// Behaviors and subtrees for missions.
    Behaviors,
    /// What goes wrong on purpose.
    Failures,
}

/// Says everything that is wrong with some files.
pub fn check(args: &CheckArgs) -> Result<Exit> {
    let mut page = Page::new();
    let mut list = Vec::new();
    let mut is_sound = true;
    for file in &args.files {
        let faults = match files::check(&Disk, file, &args.set) {
            Ok(checked) => {
                let (summary, warnings) = told(checked);
                if !args.json {
                    page.line(&legible(&format!("{}: {summary}", file.display())))?;
                    page.flush()?;
                    say_all(&warnings);
                }
                is_sound &= warnings.is_empty() || !args.strict;
                warnings
            }
            Err(error) => {
                is_sound = false;
                let faults = error.faults().to_vec();
                if !args.json {
                    say(&report_all(&error));
                }
                faults
            }
        };
        list.extend(faults.iter().map(as_json));
    }
    if args.json {
        page.line(&Value::from(list).to_string())?;
        page.flush()?;
    }
    Ok(if is_sound { Exit::Done } else { Exit::Usage })
}

/// Prints the JSON Schema of a format.
pub fn schema(args: &SchemaArgs) -> Result<Exit> {
    let format = match args.format {
        FormatName::Mission => Format::Mission,
        FormatName::Robot => Format::Robot,
        FormatName::Behaviors => Format::Behaviors,
        FormatName::Failures => Format::Failures,
    };
    let text = serde_json::to_string_pretty(&files::schema(format)).into_diagnostic()?;
    Page::new().text(&format!("{text}\n"))?;
    Ok(Exit::Done)
}

/// What a file is, in a line, and what is surely not meant in it.
fn told(checked: Checked) -> (String, Vec<Fault>) {
    match checked {
        Checked::Mission(loaded) => (mission(&loaded.mission), loaded.warnings),
        Checked::Robot(robot, warnings) => {
            let (resources, controllers) = (robot.robot.resources.len(), robot.robot.controllers.len());
            (format!("robot {}, {resources} resources, {controllers} controllers", robot.robot.name), warnings)
        }
        Checked::Failures(count, warnings) => {
            let failures = if count == 1 { "failure" } else { "failures" };
            (format!("{count} {failures}; what they name is looked up in a mission with `--fail`"), warnings)
        }
        Checked::Library(names, warnings) => (format!("library of {}", names.join(", ")), warnings),
    }
}

fn mission(mission: &MissionSpec) -> String {
    let (nodes, leaves) = (mission.tree.nodes.len(), mission.tree.leaves().count());
    format!("mission {}, {nodes} nodes ({leaves} behaviors) for robot {}", mission.name, mission.robot.name)
}

fn as_json(fault: &Fault) -> Value {
    let position = fault.position();
    json!({
        "file": fault.file(),
        "line": position.map(|(line, _)| line),
        "column": position.map(|(_, column)| column),
        "severity": if fault.is_warning() { "warning" } else { "error" },
        "key": fault.key(),
        "message": fault.message(),
        "help": fault.help(),
    })
}
