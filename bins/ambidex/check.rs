//! `ambidex check` and `ambidex schema`.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use ambidex::files::{self, Checked, Disk, Fault, FilesError, Format, Setting, TaskLoader};
use ambidex::model::{Fragment, MissionSpec, NodeKind};
use ambidex::show::count;
use clap::{Args, ValueEnum};
use miette::{IntoDiagnostic, Result};
use serde_json::{Value, json};

use crate::diagnostics::{legible, report_all, say, say_all};
use crate::exit::Exit;
use crate::page::Page;

/// `ambidex check`.
#[derive(Debug, Args)]
pub struct CheckArgs {
    /// Mission, world, task, robot, behavior and failure files; what each is is seen from its keys.
    #[arg(required_unless_present = "world", value_name = "FILE")]
    files: Vec<PathBuf>,
    /// Tell the missions or tasks a value for one of their parameters; can be given for each.
    #[arg(long, value_name = "NAME=VALUE")]
    set: Vec<Setting>,
    /// Check this world, and each FILE as a task that is submitted to a robot in it.
    #[arg(long, value_name = "FILE", requires = "robot")]
    world: Option<PathBuf>,
    /// The robot that is in the world.
    #[arg(long, value_name = "FILE", requires = "world")]
    robot: Option<PathBuf>,
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
    /// A world in which tasks come and go.
    World,
    /// A task for a robot that works already.
    Task,
    /// A robot and its controllers.
    Robot,
    /// Behaviors and subtrees for missions.
    Behaviors,
    /// What goes wrong on purpose.
    Failures,
}

/// A file in a line, and what is surely not meant in it.
type Told = (String, Vec<Fault>);

/// What was found so far.
struct Findings {
    page: Page,
    faults: Vec<Value>,
    is_json: bool,
    is_strict: bool,
    is_sound: bool,
}

/// Says everything that is wrong with some files.
pub fn check(args: &CheckArgs) -> Result<Exit> {
    let (is_json, is_strict) = (args.json, args.strict);
    let mut found = Findings { page: Page::new(), faults: Vec::new(), is_json, is_strict, is_sound: true };
    match args.world.as_ref().zip(args.robot.as_ref()) {
        Some((world, robot)) => check_in(world, robot, args, &mut found)?,
        None => {
            for file in &args.files {
                found.tell(file, files::check(&Disk, file, &args.set).map(told))?;
            }
        }
    }
    if args.json {
        found.page.line(&Value::from(found.faults).to_string())?;
        found.page.flush()?;
    }
    Ok(if found.is_sound { Exit::Done } else { Exit::Usage })
}

/// Tasks are checked only where the world in which they are done is sound.
fn check_in(path: &Path, robot: &Path, args: &CheckArgs, found: &mut Findings) -> Result<()> {
    let loaded = files::load_world(&Disk, robot, path, &[]);
    let world = loaded.as_ref().ok().map(|loaded| Arc::clone(&loaded.mission));
    found.tell(path, loaded.map(|loaded| (in_world(&loaded.mission), loaded.warnings)))?;
    let Some(world) = world else { return Ok(()) };
    let mut loader = TaskLoader::new(&world).map_err(|error| report_all(&error))?;
    for file in &args.files {
        let loaded = loader.load_task(&Disk, file, &args.set, &world, &world.start);
        found.tell(file, loaded.map(|loaded| (task(&loaded.fragment, &world), loaded.warnings)))?;
    }
    Ok(())
}

impl Findings {
    fn tell(&mut self, file: &Path, checked: Result<Told, FilesError>) -> Result<()> {
        let faults = match checked {
            Ok((summary, warnings)) => {
                if !self.is_json {
                    self.page.line(&legible(&format!("{}: {summary}", file.display())))?;
                    self.page.flush()?;
                    say_all(&warnings);
                }
                self.is_sound &= warnings.is_empty() || !self.is_strict;
                warnings
            }
            Err(error) => {
                self.is_sound = false;
                if !self.is_json {
                    say(&report_all(&error));
                }
                error.faults().to_vec()
            }
        };
        self.faults.extend(faults.iter().map(as_json));
        Ok(())
    }
}

/// Prints the JSON Schema of a format.
pub fn schema(args: &SchemaArgs) -> Result<Exit> {
    let format = match args.format {
        FormatName::Mission => Format::Mission,
        FormatName::World => Format::World,
        FormatName::Task => Format::Task,
        FormatName::Robot => Format::Robot,
        FormatName::Behaviors => Format::Behaviors,
        FormatName::Failures => Format::Failures,
    };
    let text = serde_json::to_string_pretty(&files::schema(format)).into_diagnostic()?;
    Page::new().text(&format!("{text}\n"))?;
    Ok(Exit::Done)
}

/// What a file is, in a line, and what is surely not meant in it.
fn told(checked: Checked) -> Told {
    match checked {
        Checked::Mission(loaded) => (mission(&loaded.mission), loaded.warnings),
        Checked::World(world, warnings) => {
            let (places, objects) = (count(world.places, "place"), count(world.objects, "object"));
            let declared = match world.declared.as_slice() {
                [] => String::new(),
                names => format!("; library of {}", names.join(", ")),
            };
            (format!("world {}, {places}, {objects}{declared}", world.name), warnings)
        }
        Checked::Task(name, warnings) => {
            (format!("task {name}; what it names is looked up in a world with `--world`"), warnings)
        }
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

fn in_world(world: &MissionSpec) -> String {
    let (places, objects) = (count(world.names.places.len(), "place"), count(world.names.objects.len(), "object"));
    format!("world {}, {places}, {objects}, for robot {}", world.name, world.robot.name)
}

fn task(task: &Fragment, world: &MissionSpec) -> String {
    let leaves = task.nodes.iter().filter(|node| matches!(node, NodeKind::Behavior(_))).count();
    let (nodes, leaves) = (count(task.nodes.len(), "node"), count(leaves, "behavior"));
    format!("task {}, {nodes} ({leaves}) in world {}", task.name, world.name)
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
