//! Interned names: every thing of a mission is a small number, given when the tree is built.

use serde::{Deserialize, Serialize};

// Not `transparent`: in JSON they are bare numbers all the same, and a serializer is told what they are ids of.
macro_rules! ids {
    ($($(#[$doc:meta])* $name:ident),+ $(,)?) => {$(
        $(#[$doc])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
        pub struct $name(pub u32);

        impl $name {
            /// Position in the table that the id indexes.
            pub fn index(self) -> usize {
                self.0 as usize
            }
        }

        impl From<usize> for $name {
            fn from(index: usize) -> Self {
                Self(u32::try_from(index).expect("fewer than 2^32 things in a mission"))
            }
        }
    )+};
}

ids! {
    /// A node of the tree in preorder; 0 is the root, 1 the top of the task.
    NodeId,
    /// A resource of the robot (III-B), in the order of the robot file: *resource order*.
    ResourceId,
    /// A type of resource: `gripper`, `head`, `base`, or any other word.
    TypeId,
    /// The intention with which a shared resource is used (III-B).
    ChannelId,
    /// An object of the world.
    ObjectId,
    /// A place of the world.
    PlaceId,
    /// A stand of a place, in their order.
    StandId,
    /// A spot on the surface of a place, in their order.
    SpotId,
    /// A fact that behaviors set and clear.
    FactId,
    /// A controller process.
    ControllerId,
}

/// Identity of a command: which attachment of the controller, and a number that never comes twice in it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct CommandId {
    /// How often the controller had attached, counted by the daemon.
    pub generation: u32,
    /// Grows with every command of an attachment.
    pub number: u32,
}
