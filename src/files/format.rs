//! The formats of files, and which of them a file is of.

use crate::describe::{At, Count, Custom, Described, Later, List, Map, PathTo, Word, described};
use crate::failures::{FAILURES, FailureFile};
use crate::fault::Faults;
use crate::kinds::behavior_shape;
use crate::parameter::{PARAMETERS, Parameter};
use crate::reader::{Item, Name, Written};
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

/// The key of the paths that a file includes.
pub(crate) const INCLUDE: &str = "include";
const TASK: &str = "task";
const WORLD: &str = "world";
const ROBOT: &str = "robot";

/// Most grants that a task may see go to later ones.
const MAX_BYPASS: u32 = 1_000_000;

const MISSION: &str = "mission";
const LIBRARY: &str = "library";

const INCLUDED: List<PathTo> = List("a list of paths", PathTo("the path of a file"));
const BEHAVIORS: Later = Later(|| Form::Each(Box::new(Form::Map(behavior_shape))));
const SUBTREES: Later = Later(|| Form::Each(Box::new(Form::Map(Subtree::shape))));

const NAMED: Word = Word("the name of the mission");
const NAMED_DOC: &str = "Its name; without one that of the file.";
const ROBOT_PATH: PathTo = PathTo("the path of a robot file");
const START_DOC: &str = "Where everything is at the start.";
const BYPASS_DOC: &str =
    "How many grants a task that waits may see go to tasks that came after it, before it is its turn; 8.";

described! {
    /// What a task can use beside what is always there, and what it is told; what needs the names of other files is read
    /// later.
    pub(crate) struct Declarations<'a>: "declarations", "What a task can use, and what it is told." {
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
    }
}

described! {
    /// A mission file.
    pub(crate) struct Mission<'a>: "a mission", "A task for a robot in a world." {
        mission: Option<Name> = wanted(MISSION, "Its name.", NAMED),
        robot: Option<Name> = wanted(ROBOT, "The path of a robot file, from this file.", ROBOT_PATH),
        declared: Declarations<'a> = all(Declarations),
        bypass: Option<u32> = maybe_or("bypass", BYPASS_DOC, Count(MAX_BYPASS), BYPASS),
        world: Option<World> = wanted(WORLD, START_DOC, Map::<World>::new()),
        task: Option<Item<'a>> = wanted(TASK, "What is to be done.", Later(node_form)),
    }
}

described! {
    /// A file with a world, of whose task nothing is read.
    pub(crate) struct WorldFile<'a>: "a world file",
    "A world in which tasks come and go, and the behaviors and subtrees that all of them can use. Any mission is one." {
        mission: Option<Name> = maybe(MISSION, NAMED_DOC, NAMED),
        robot: Option<Name> = maybe(ROBOT, "Not read: the robot is told beside the file.", ROBOT_PATH),
        declared: Declarations<'a> = all(Declarations),
        bypass: Option<u32> = maybe_or("bypass", BYPASS_DOC, Count(MAX_BYPASS), BYPASS),
        world: Option<World> = wanted(WORLD, START_DOC, Map::<World>::new()),
        _task: Option<()> = maybe(TASK, "Not done: tasks are submitted.", NOT_DONE),
    }
}

described! {
    /// A file with a task, of whose robot and world nothing is used.
    pub(crate) struct TaskFile<'a>: "a task file",
    "A task for a robot that works already, in the world as it is then. Any mission is one." {
        mission: Option<Name> = maybe(MISSION, NAMED_DOC, NAMED),
        _robot: Option<Name> = maybe(ROBOT, "Not read: the robot is the one that works.", ROBOT_PATH),
        declared: Declarations<'a> = all(Declarations),
        _bypass: Option<u32> =
            maybe("bypass", "Not used: that of the world counts.", Count(MAX_BYPASS)),
        world: Option<Written<()>> = maybe(WORLD, "Not used: the world is as it is.", At(NOT_USED)),
        task: Option<Item<'a>> = wanted(TASK, "What is to be done.", Later(node_form)),
    }
}

/// A world that nobody needs.
const NOT_USED: Custom<()> = Custom(|| Form::Map(World::shape), |item, reading| World::read(item, reading).map(|_| ()));

/// A task that nobody does.
const NOT_DONE: Custom<()> = Custom(node_form, |item, reading| {
    let is_node = item.is_scalar() || item.is_map();
    if !is_node {
        item.wrong("a node of the task", reading.faults);
    }
    is_node.then_some(())
});

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
        let is_whole = [WORLD, TASK, ROBOT].into_iter().filter(|key| has(key)).count() > 1;
        let signs = [
            (is_whole && (has(TASK) || has(WORLD)), Self::Mission),
            (has(TASK), Self::Task),
            (has(WORLD), Self::World),
            (has(MISSION), Self::Mission),
            (has(RESOURCES) || has(CONTROLLERS), Self::Robot),
            (has(LIBRARY), Self::Behaviors),
            (has(FAILURES), Self::Failures),
        ];
        signs.into_iter().find(|(has, _)| *has).map(|(_, format)| format)
    }

    /// Whether a file is of this format, as far as its keys tell; one of another is a fault.
    pub(crate) fn is_that_of(self, file: Item<'_>, faults: &mut Faults) -> bool {
        let Some(other) = Self::of(file).filter(|found| !self.can_be(*found)) else {
            return true;
        };
        faults.push((file.span, ""), format!("this is {}, not {}", other.shape().what, self.shape().what));
        false
    }

    /// Whether a file that looks like one of that format may be one of this, or lacks no more than some keys of it.
    fn can_be(self, found: Self) -> bool {
        match self {
            Self::Mission => matches!(found, Self::Mission | Self::World | Self::Task),
            Self::World => matches!(found, Self::Mission | Self::World),
            Self::Task => matches!(found, Self::Mission | Self::Task),
            Self::Robot | Self::Behaviors | Self::Failures => found == self,
        }
    }

    /// The description of its files.
    pub(crate) fn shape(self) -> &'static Shape {
        match self {
            Self::Mission => Mission::shape(),
            Self::World => WorldFile::shape(),
            Self::Task => TaskFile::shape(),
            Self::Robot => Robot::shape(),
            Self::Behaviors => Library::shape(),
            Self::Failures => FailureFile::shape(),
        }
    }
}
