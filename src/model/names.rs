//! What everything is called, for people.

use std::borrow::Cow;

use serde::{Deserialize, Serialize};

use super::{ChannelId, ControllerId, FactId, NodeId, ObjectId, PlaceId, ResourceId, TypeId};

/// The names behind the ids of a mission, each list by id.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Names {
    /// Nodes of the tree.
    pub nodes: Vec<String>,
    /// Resources.
    pub resources: Vec<String>,
    /// Types of resources.
    pub types: Vec<String>,
    /// Channels.
    pub channels: Vec<String>,
    /// Objects.
    pub objects: Vec<String>,
    /// Places.
    pub places: Vec<String>,
    /// Facts.
    pub facts: Vec<String>,
    /// Controllers.
    pub controllers: Vec<String>,
}

macro_rules! named {
    ($($name:ident, $list:ident, $id:ty;)+) => {
        impl Names {$(
            #[doc = concat!("The name behind one id of `", stringify!($list), "`; `?` for one that is not of this mission.")]
            pub fn $name(&self, id: $id) -> &str {
                self.$list.get(id.index()).map_or("?", String::as_str)
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
    /// An object within a sentence: its name, with its noun before it where the name alone is but a number.
    pub fn thing(&self, id: ObjectId) -> Cow<'_, str> {
        let name = self.object(id);
        match name.starts_with(|first: char| first.is_ascii_digit()) {
            true => format!("object {name}").into(),
            false => name.into(),
        }
    }
}
