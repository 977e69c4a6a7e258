//! The form of a dHTT robot file, and what becomes of it: resources that nothing moves.

use std::collections::BTreeSet;

use super::notes::{self, Note, line};
use super::write::Lines;
use crate::describe::{At, Count, Described, Later, Word, described};
use crate::fault::Faults;
use crate::reader::{Fields, Item, Name, Written};
use crate::scope::Reading;
use crate::shape::Form;
use crate::text::scalar;

/// Half the width of a robot that nobody has measured, meters.
const RADIUS: &str = "0.5 m";
/// Keys of resources begin so; a number follows.
const RESOURCE_KEY: &str = "resource_";
const MAX_RESOURCES: u32 = 1000;

const STILL: &str = "How its parts move is not known: they count as resources, and nothing moves them. For a robot \
                     that moves, name the `controller` of each, and describe it under `controllers`.";

const ROBOT_RESOURCES: &str = "robot_resources";
const ANYTHING: Later = Later(|| Form::Arguments);

described! {
    /// A robot file as written.
    struct RobotFile<'a>: "a dHTT robot", "A robot as a set of resources.", others ANYTHING, known [] {
        name: Option<Name> = maybe("robot_name", "Its name.", Word("the name of the robot")),
        resources: Option<Item<'a>> = wanted(
            ROBOT_RESOURCES,
            "Its resources: resource_0, resource_1 …",
            Later(|| Form::Map(Resources::shape))
        ),
    }
}

described! {
    /// `robot_resources`.
    struct Resources: "the resources", "Resources by number.",
    others Later(|| Form::Map(Resource::shape)), known [] {
        count: Option<Written<u32>> =
            maybe("number_of_resources", "How many there are.", At(Count(MAX_RESOURCES))),
    }
}

described! {
    /// An entry of `robot_resources`.
    struct Resource<'a>: "a dHTT resource", "A resource.", others ANYTHING, known [] {
        ty: Option<Item<'a>> = wanted("type", "1 (a gripper), 2 (a head) or 3 (a base).", Later(|| Form::Count(3))),
        name: Option<Name> = wanted("name", "What it is called.", Word("the name of a resource")),
    }
}

/// Whether a file is a robot file, as far as its keys tell.
pub(super) fn is_robot(file: Item<'_>) -> bool {
    file.value_of(ROBOT_RESOURCES).is_some()
}

/// A robot before it is written.
#[derive(Debug)]
pub(super) struct RobotDraft {
    name: String,
    /// Name and type of each.
    resources: Vec<(String, &'static str)>,
    /// Where it comes from.
    origin: String,
    /// What is not carried over.
    pub(super) notes: Vec<Note>,
}

impl RobotDraft {
    /// The robot for a task that comes without one.
    pub(super) fn usual() -> Self {
        let resources = [("left_gripper", "gripper"), ("right_gripper", "gripper"), ("head", "head"), ("base", "base")];
        Self {
            name: "imported".to_owned(),
            resources: resources.map(|(name, ty)| (name.to_owned(), ty)).to_vec(),
            origin: "The import was given no robot: here is one with two grippers, a head and a base.".to_owned(),
            notes: Vec::new(),
        }
    }

    /// Reads a robot file; `name` is for one that has none.
    pub(super) fn read(file: Item<'_>, file_name: &str, name: &str, faults: &mut Faults) -> Option<Self> {
        let before = faults.errors();
        let fields = file.fields(RobotFile::shape(), faults)?;
        let robot = RobotFile::from_map(&fields, &mut Reading::new(faults))?;
        let of = robot.resources?.fields(Resources::shape(), faults)?;
        let told = Resources::from_map(&of, &mut Reading::new(faults))?.count;
        let mut notes = notes::unknown("", &fields, faults);
        let mut entries = entries(&of, &mut notes);
        entries.sort_by_key(|(number, ..)| *number);
        check_count(&of, told, entries.len(), faults);
        let mut seen = BTreeSet::new();
        let mut resources = Vec::new();
        for (_, key, item) in entries {
            let Some((name, ty)) = resource(&key, item, &mut notes, faults) else { continue };
            if !seen.insert(name.value.clone()) {
                faults.push((name.span, &key), format!("another resource is called `{}`", name.value));
            }
            resources.push((name.value, ty));
        }
        let name = robot.name.map_or_else(|| name.to_owned(), |name| name.value);
        let origin = format!("Imported from {}, a robot file of the dHTT software.", line(file_name));
        (faults.errors() == before).then_some(Self { name, resources, origin, notes })
    }

    /// How many resources there are.
    pub(super) fn count(&self) -> usize {
        self.resources.len()
    }

    /// The file of Ambidex that is made of it.
    pub(super) fn text(&self) -> String {
        let mut lines = Lines::default();
        lines.comment(0, &self.origin);
        for note in &self.notes {
            let of = if note.of.is_empty() { String::new() } else { format!(" {}:", note.of) };
            lines.comment(0, &format!("dHTT:{of} {}", note.message));
        }
        lines.comment(0, STILL);
        lines.line(0, &format!("robot: {}", scalar(&self.name)));
        lines.line(0, &format!("radius: {RADIUS}    # a guess: only driving around obstacles needs it"));
        lines.line(0, "resources:");
        for (name, ty) in &self.resources {
            lines.line(1, &format!("{}: {{type: {ty}}}", scalar(name)));
        }
        lines.into_text()
    }
}

/// The resources with their numbers; any other key is noted.
fn entries<'a>(of: &Fields<'a>, notes: &mut Vec<Note>) -> Vec<(u32, String, Item<'a>)> {
    let number = |key: &str| key.strip_prefix(RESOURCE_KEY).and_then(|number| number.parse().ok());
    let mut entries = Vec::new();
    for (key, item) in of.others() {
        match number(&key.value) {
            Some(number) => entries.push((number, key.value.clone(), item)),
            None => {
                let message =
                    format!("`{}` is left out: resources are called resource_0, resource_1 …", line(&key.value));
                notes.push(Note::new("", key.span, message, None));
            }
        }
    }
    entries
}

fn check_count(of: &Fields<'_>, told: Option<Written<u32>>, found: usize, faults: &mut Faults) {
    const HELP: &str = "they are called resource_0, resource_1 …";
    if let Some(Written { value: told, key, span }) = told.filter(|told| told.value as usize != found) {
        let message = format!("{told} resources are announced, and there are {found}");
        faults.push_with((span, &key), message, HELP.to_owned());
    }
    if found == 0 {
        faults.push_with((of.span(), ROBOT_RESOURCES), "a robot without resources".to_owned(), HELP.to_owned());
    }
}

fn resource(key: &str, item: Item<'_>, notes: &mut Vec<Note>, faults: &mut Faults) -> Option<(Name, &'static str)> {
    let fields = item.fields(Resource::shape(), faults)?;
    let Resource { ty, name } = Resource::from_map(&fields, &mut Reading::new(faults))?;
    let ty = ty.and_then(|item| match item.text() {
        Some("1") => Some("gripper"),
        Some("2") => Some("head"),
        Some("3") => Some("base"),
        Some(_) | None => {
            item.wrong("1 (a gripper), 2 (a head) or 3 (a base)", faults);
            None
        }
    });
    notes.extend(notes::unknown(key, &fields, faults));
    Some((name?, ty?))
}
