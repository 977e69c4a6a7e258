//! What a task is done in, and what it can use: robot and world, kinds of behavior and subtrees.

use crate::describe::Described;
use crate::fault::Faults;
use crate::files::Files;
use crate::format::{Declarations, Library};
use crate::kinds::Kinds;
use crate::names::Register;
use crate::parameter::{Known, RobotNames};
use crate::reader::Item;
use crate::robot::RobotFile;
use crate::task::{self, MAX_NODES, Subtrees, Surroundings};
use crate::world::{self, Built, World, WorldNames};

/// All that a task refers to; what could not be read is none.
pub(crate) struct Scene {
    pub(crate) kinds: Kinds,
    pub(crate) subtrees: Subtrees,
    pub(crate) robot: Option<RobotFile>,
    pub(crate) robot_names: Option<RobotNames>,
    pub(crate) world: Option<Built>,
    pub(crate) names: Option<WorldNames>,
    /// Channels that there are before any task: those of being at a place, in the order of the places.
    pub(crate) channels: Register,
}

impl Scene {
    /// What a file and those that it includes say, for a robot; subtrees are checked, used or not.
    pub(crate) fn read(
        files: &Files<'_>,
        declarations: &Declarations<'_>,
        world: Option<World>,
        robot: Option<RobotFile>,
        faults: &mut Faults,
    ) -> Self {
        let (kinds, mut subtrees) = declared(files, declarations.behaviors, declarations.subtrees, faults);
        let names = world.as_ref().map(WorldNames::of);
        let world = world.zip(names.as_ref()).and_then(|(raw, names)| {
            let robot = robot.as_ref().map(|file| (&file.robot, &file.names));
            world::build(raw, names, robot, faults)
        });
        let channels = names.as_ref().map(at_places).unwrap_or_default();
        let robot_names = robot.as_ref().map(|robot| RobotNames::of(&robot.names));
        let mut scene = Self { kinds, subtrees: Subtrees::default(), robot, robot_names, world, names, channels };
        task::check_all(&mut subtrees, &scene.around(), faults);
        scene.subtrees = subtrees;
        scene.kinds.check_tables(&scene.known(), files.main_file(), faults);
        scene.subtrees.check_defaults(&scene.known(), files.main_file(), faults);
        scene
    }

    /// What names stand for.
    pub(crate) fn known(&self) -> Known<'_> {
        Known { world: self.names.as_ref(), robot: self.robot_names.as_ref() }
    }

    /// The same as a task sees it.
    pub(crate) fn around(&self) -> Surroundings<'_> {
        Surroundings {
            kinds: &self.kinds,
            known: self.known(),
            robot: self.robot.as_ref(),
            world: self.world.as_ref(),
            channels: &self.channels,
            is_open: false,
            most_nodes: MAX_NODES,
        }
    }
}

fn at_places(names: &WorldNames) -> Register {
    let channels: Vec<String> = names.places.names().iter().map(|place| format!("at {place}")).collect();
    Register::of("channel", channels.iter().map(String::as_str))
}

/// Behaviors and subtrees of a file and of all that it includes.
pub(crate) fn declared(
    files: &Files<'_>,
    behaviors: Option<Item<'_>>,
    subtrees: Option<Item<'_>>,
    faults: &mut Faults,
) -> (Kinds, Subtrees) {
    let (mut kinds, mut parts) = (Kinds::new(task::node_shape().keys()), Subtrees::default());
    declare(files, (behaviors, subtrees), (&mut kinds, &mut parts), faults);
    (kinds, parts)
}

/// Adds what files declare to what there is; those that were read before declare nothing new.
pub(crate) fn declare(
    files: &Files<'_>,
    (behaviors, subtrees): (Option<Item<'_>>, Option<Item<'_>>),
    (kinds, parts): (&mut Kinds, &mut Subtrees),
    faults: &mut Faults,
) {
    for file in files.libraries() {
        let Some(library) = Library::take(file, faults) else { continue };
        kinds.declare(library.behaviors, faults);
        parts.declare(library.subtrees, faults);
    }
    if !files.is_main_known() {
        kinds.declare(behaviors, faults);
        parts.declare(subtrees, faults);
    }
}
