//! The formats of files, and which of them a file is of.

use crate::describe::{Count, Described, Later, List, Map, PathTo, Word, described};
use crate::failures::{FAILURES, FailureFile};
use crate::fault::Faults;
use crate::kinds::behavior_shape;
use crate::parameter::{PARAMETERS, Parameter};
use crate::reader::{Item, Name};
use crate::robot::{CONTROLLERS, RESOURCES, Robot};
use crate::shape::{Form, Shape};
use crate::task::{Subtree, node_form};
use crate::world::World;
use ambidex_model::BYPASS;

/// A format of files.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// A task for a robot in a world.
    Mission,
    /// A robot and its controllers.
    Robot,
    /// Behaviors and subtrees for missions.
    Behaviors,
    /// What goes wrong on purpose.
    Failures,
}

/// The key of the paths that a file includes.
pub(crate) const INCLUDE: &str = "include";
/// The key of the task of a mission.
pub(crate) const TASK: &str = "task";

/// Most grants that a task may see go to later ones.
const MAX_BYPASS: u32 = 1_000_000;

const MISSION: &str = "mission";
const LIBRARY: &str = "library";

const INCLUDED: List<PathTo> = List("a list of paths", PathTo("the path of a file"));
const BEHAVIORS: Later = Later(|| Form::Each(Box::new(Form::Map(behavior_shape))));
const SUBTREES: Later = Later(|| Form::Each(Box::new(Form::Map(Subtree::shape))));

described! {
    /// A mission file; what needs the names of other files is read later.
    pub(crate) struct Mission<'a>: "a mission", "A task for a robot in a world." {
        mission: Option<Name> = wanted(MISSION, "Its name.", Word("the name of the mission")),
        robot: Option<Name> =
            wanted("robot", "The path of a robot file, from this file.", PathTo("the path of a robot file")),
        /// Followed while files are opened.
        _include: Vec<Name> =
            maybe_all(INCLUDE, "Paths of files with behaviors and subtrees, from this file.", INCLUDED),
        parameters: Vec<Parameter> = maybe_all(
            "parameters",
            "What `--set NAME=VALUE` tells when it is started; `$name` stands for it in the task.",
            PARAMETERS
        ),
        behaviors: Option<Item<'a>> =
            maybe("behaviors", "Kinds of behavior beside `move`, `pick` and `place`.", BEHAVIORS),
        subtrees: Option<Item<'a>> = maybe("subtrees", "Parts of the task to be used with arguments.", SUBTREES),
        bypass: Option<u32> = maybe_or(
            "bypass",
            "How many grants a task that waits may see go to tasks that came after it, before it is its turn; 8.",
            Count(MAX_BYPASS),
            BYPASS
        ),
        world: Option<World> = wanted("world", "Where everything is at the start.", Map::<World>::new()),
        task: Option<Item<'a>> = wanted(TASK, "What is to be done.", Later(node_form)),
    }
}

described! {
    /// A file of behaviors and subtrees.
    pub(crate) struct Library<'a>: "a library", "Behaviors and subtrees for any mission that includes them." {
        library: Option<Name> = wanted(LIBRARY, "Its name.", Word("the name of the library")),
        /// Followed while files are opened.
        _include: Vec<Name> = maybe_all(INCLUDE, "Paths of further such files, from this file.", INCLUDED),
        behaviors: Option<Item<'a>> = maybe("behaviors", "Kinds of behavior.", BEHAVIORS),
        subtrees: Option<Item<'a>> = maybe("subtrees", "Parts of a task to be used with arguments.", SUBTREES),
    }
}

impl Format {
    /// What a file is, from its first keys; none where that is not clear.
    pub(crate) fn of(file: Item<'_>) -> Option<Self> {
        let has = |key| file.value_of(key).is_some();
        let signs = [
            (has(MISSION) || has(TASK), Self::Mission),
            (has(RESOURCES) || has(CONTROLLERS), Self::Robot),
            (has(LIBRARY), Self::Behaviors),
            (has(FAILURES), Self::Failures),
        ];
        signs.into_iter().find(|(has, _)| *has).map(|(_, format)| format)
    }

    /// Whether a file is of this format, as far as its keys tell; one of another is a fault.
    pub(crate) fn is_that_of(self, file: Item<'_>, faults: &mut Faults) -> bool {
        let Some(other) = Self::of(file).filter(|found| *found != self) else {
            return true;
        };
        faults.push((file.span, ""), format!("this is {}, not {}", other.shape().what, self.shape().what));
        false
    }

    /// The description of its files.
    pub(crate) fn shape(self) -> &'static Shape {
        match self {
            Self::Mission => Mission::shape(),
            Self::Robot => Robot::shape(),
            Self::Behaviors => Library::shape(),
            Self::Failures => FailureFile::shape(),
        }
    }
}
