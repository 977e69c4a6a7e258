//! Files that stand for themselves: missions, and worlds in which tasks come and go. Each with its libraries and its robot.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::describe::Described;
use crate::fault::{Fault, Faults, FilesError};
use crate::files::{Files, beside};
use crate::format::{Format, Mission, WorldFile};
use crate::lint::{self, Part};
use crate::parameter::refuse_open_defaults;
use crate::reader::{Item, Name};
use crate::reports;
use crate::robot::{self, RobotFile};
use crate::scene::Scene;
use crate::settings::{Given, Setting, warn_of_settings};
use crate::task::{self, ROOT, Written};
use ambidex_model::{MissionSpec, NAME_MAX, Names, NodeId, NodeKind, Source, Topology, TreeSpec, make_legible};

/// The node below which tasks come and go.
const TASKS: &str = "tasks";

/// A mission with the file of its robot.
#[derive(Debug, Clone)]
pub struct Loaded {
    /// Everything that a run needs to know, shared by all who run it.
    pub mission: Arc<MissionSpec>,
    /// Where its robot stands, for the controllers to read it too.
    pub robot_path: PathBuf,
    /// What is legal in the files but surely not meant.
    pub warnings: Vec<Fault>,
}

impl Loaded {
    /// What was read, unless something in the files is wrong.
    pub(crate) fn of(read: Option<(MissionSpec, PathBuf)>, faults: Faults) -> Result<Self, FilesError> {
        let ((mission, robot_path), warnings) = faults.into_result(read)?;
        Ok(Self { mission: Arc::new(mission), robot_path, warnings })
    }

    /// The same with the files that it was made of.
    pub(crate) fn made_of(mut self, source: Source) -> Self {
        if let Some(mission) = Arc::get_mut(&mut self.mission) {
            mission.source = Some(source);
        }
        self
    }
}

/// What is told from outside of the files.
pub(crate) struct Overrides<'a> {
    pub(crate) robot: Option<&'a Path>,
    pub(crate) settings: &'a [Setting],
}

/// A world as its files say it, before any task.
pub(crate) struct ReadWorld {
    pub(crate) name: String,
    pub(crate) scene: Scene,
    bypass: Option<u32>,
}

/// A file that must be a robot.
pub(crate) fn robot_of(file: Item<'_>, faults: &mut Faults) -> Option<RobotFile> {
    if Format::Robot.is_that_of(file, faults) { robot::read(file, faults) } else { None }
}

/// A mission file with its libraries and its robot.
pub(crate) fn mission(
    path: &Path,
    files: &Files<'_>,
    overrides: &Overrides<'_>,
    faults: &mut Faults,
) -> Option<(MissionSpec, PathBuf)> {
    let main = files.main().filter(|main| Format::Mission.is_that_of(*main, faults))?;
    let file = Mission::take(main, faults)?;
    let (robot_path, robot) = robot_beside(path, files, overrides.robot, file.robot.as_ref(), faults);
    let mission = with_robot(files, file, robot, overrides.settings, faults);
    Some((mission?, robot_path?))
}

/// The robot that was told, or that a file names; and where it stands.
fn robot_beside(
    path: &Path,
    files: &Files<'_>,
    told: Option<&Path>,
    named: Option<&Name>,
    faults: &mut Faults,
) -> (Option<PathBuf>, Option<RobotFile>) {
    let robot_path = told.map(Path::to_owned).or_else(|| named.map(|name| beside(path, &name.value)));
    let named = named.filter(|_| told.is_none());
    let node = robot_path.as_ref().and_then(|path| files.beside(path, named, faults));
    let robot = node.as_ref().and_then(|node| robot_of(Item::root(node), faults));
    (robot_path, robot)
}

/// A mission file with its libraries, for a robot.
pub(crate) fn with_robot(
    files: &Files<'_>,
    file: Mission<'_>,
    robot: Option<RobotFile>,
    settings: &[Setting],
    faults: &mut Faults,
) -> Option<MissionSpec> {
    let scene = Scene::read(files, &file.declared, file.world, robot, faults);
    let parameters = file.declared.parameters;
    refuse_open_defaults("a mission", parameters.iter(), faults);
    let given = Given::of("the mission", parameters, settings, &scene.known(), faults);
    let name = file.mission.as_ref().map(|name| name.value.clone()).unwrap_or_default();
    let task = file.task.map(|task| Written { name, task, label: None });
    let built = task.and_then(|task| task::build(task, &scene.subtrees, &scene.around(), &given, faults))?;
    let fragment = built.fragment;
    let (name, channels) = (fragment.name.clone(), fragment.channels.clone());
    let names = [ROOT.to_owned()].into_iter().chain(fragment.names.clone()).collect();
    let mut tree = fragment.into_tree();
    tree.bypass = file.bypass?;
    file.mission?;
    let mission = spec(scene, name, tree, (names, channels), faults)?;
    lint::check(&mission, &built.spans, Part::Mission, faults);
    Some(mission)
}

/// A world file with its libraries, for a robot.
pub(crate) fn world(
    path: &Path,
    files: &Files<'_>,
    overrides: &Overrides<'_>,
    faults: &mut Faults,
) -> Option<(MissionSpec, PathBuf)> {
    let (read, robot_path) = read_world(path, files, overrides, faults)?;
    let nodes = vec![NodeKind::Root, NodeKind::Tasks];
    let mut tree = TreeSpec::new(nodes, Topology::new(vec![NodeId(0), NodeId(0)]));
    tree.bypass = read.bypass?;
    let names = vec![ROOT.to_owned(), TASKS.to_owned()];
    Some((spec(read.scene, read.name, tree, (names, Vec::new()), faults)?, robot_path?))
}

/// A world file with its libraries and the robot that was told, or that it names if it is a mission.
pub(crate) fn read_world(
    path: &Path,
    files: &Files<'_>,
    overrides: &Overrides<'_>,
    faults: &mut Faults,
) -> Option<(ReadWorld, Option<PathBuf>)> {
    let main = files.main().filter(|main| Format::World.is_that_of(*main, faults))?;
    let file = WorldFile::take(main, faults)?;
    let (robot_path, robot) = robot_beside(path, files, overrides.robot, file.robot.as_ref(), faults);
    if robot_path.is_none() {
        faults.push((main.span, ""), "nothing tells the robot that is in this world");
    }
    warn_of_settings(&file.declared.parameters, overrides.settings, faults);
    let scene = Scene::read(files, &file.declared, file.world, robot, faults);
    let name = name_or_that_of(file.mission, path);
    Some((ReadWorld { name, scene, bypass: file.bypass }, robot_path))
}

/// A name that a file tells, or that of the file.
pub(crate) fn name_or_that_of(told: Option<Name>, path: &Path) -> String {
    told.map(|name| name.value).unwrap_or_else(|| {
        let mut name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        make_legible(&mut name);
        name.truncate(name.floor_char_boundary(NAME_MAX));
        name
    })
}

/// All that a run needs to know, where nothing of it is wrong.
fn spec(
    scene: Scene,
    name: String,
    tree: TreeSpec,
    (nodes, channels): (Vec<String>, Vec<String>),
    faults: &mut Faults,
) -> Option<MissionSpec> {
    let (world, robot, names) = (scene.world?, scene.robot?, scene.names?);
    reports::check(&robot.reported, &names, &world.spec, faults);
    Some(MissionSpec {
        name,
        robot: robot.robot,
        world: world.spec,
        start: world.start,
        tree,
        names: Names {
            nodes: nodes.into(),
            channels: [scene.channels.into_names(), channels].concat(),
            places: names.places.into_names(),
            stands: names.stands,
            objects: names.objects.into_names(),
            facts: names.facts.into_names(),
            ..robot.names
        },
        source: None,
    })
}
