//! What everything is called, for people.

use std::borrow::Cow;

use serde::{Deserialize, Serialize};

use super::{ChannelId, ControllerId, FactId, NodeId, ObjectId, PlaceId, ResourceId, Runs, TypeId};

/// The names behind the ids of a mission, each list by id.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Names {
    /// Nodes of the tree.
    pub nodes: Runs<String>,
    /// Resources of the robot.
    pub resources: Vec<String>,
    /// Types of resources.
    pub types: Vec<String>,
    /// Channels, as they are made from texts like `at $place`.
    pub channels: Vec<String>,
    /// Objects of the world; empty for one that is gone.
    pub objects: Vec<String>,
    /// Places of the world.
    pub places: Vec<String>,
    /// What the stands of a place are called, by place; empty for one that has only one.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub stands: Vec<Vec<String>>,
    /// Facts of the world.
    pub facts: Vec<String>,
    /// Controllers of the robot, which are also names of processes.
    pub controllers: Vec<String>,
}

macro_rules! named {
    ($($name:ident, $list:ident, $id:ty;)+) => {
        impl Names {$(
            #[doc = concat!("The name behind one id of `", stringify!($list), "`; `?` for one that is not of this mission, or no more.")]
            pub fn $name(&self, id: $id) -> &str {
                self.$list.get(id.index()).filter(|name| !name.is_empty()).map_or("?", String::as_str)
            }
        )+}
    };
}

named! {
    node, nodes, NodeId;
    resource, resources, ResourceId;
    ty, types, TypeId;
    channel, channels, ChannelId;
    object, objects, ObjectId;
    place, places, PlaceId;
    fact, facts, FactId;
    controller, controllers, ControllerId;
}

impl Names {
    /// The same names without what a terminal obeys instead of showing it.
    #[must_use]
    pub fn legible(mut self) -> Self {
        let Self { nodes, resources, types, channels, objects, places, stands, facts, controllers } = &mut self;
        nodes.iter_mut().for_each(make_legible);
        stands.iter_mut().flatten().for_each(make_legible);
        for names in [resources, types, channels, objects, places, facts, controllers] {
            names.iter_mut().for_each(make_legible);
        }
        self
    }

    /// An object within a sentence: its name, with its noun before it where the name alone is but a number.
    pub fn thing(&self, id: ObjectId) -> Cow<'_, str> {
        let name = self.object(id);
        match name.starts_with(|first: char| first.is_ascii_digit()) {
            true => format!("object {name}").into(),
            false => name.into(),
        }
    }
}

/// Replaces what a terminal obeys instead of showing it: control characters and what turns the direction of a line.
pub fn make_legible(text: &mut String) {
    if text.contains(is_obeyed) {
        *text = text.replace(is_obeyed, "\u{fffd}");
    }
}

/// Whether a terminal obeys a letter instead of showing it, or turns what is seen around.
pub fn is_obeyed(letter: char) -> bool {
    let turns =
        matches!(letter, '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    letter.is_control() || turns || matches!(letter, '\u{2028}' | '\u{2029}')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_cannot_speak_to_the_terminal() {
        let check = |name: &str, expected: &str| {
            let names = Names { nodes: vec![name.into()].into(), ..Names::default() }.legible();
            assert_eq!(names.nodes[0], expected);
        };
        check("pick \"2\" * [é 物]", "pick \"2\" * [é 物]");
        check("\u{1b}[2Jpick\n\0", "\u{fffd}[2Jpick\u{fffd}\u{fffd}");
        check("a\u{9b}31m\u{202e}b\u{2028}", "a\u{fffd}31m\u{fffd}b\u{fffd}");
    }
}
