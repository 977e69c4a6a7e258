//! The files that a mission, a world or a task was made of, as they were when it was.

use serde::{Deserialize, Serialize};

/// All that is needed to make a mission, a world or a task again.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema))]
pub struct Source {
    /// What is made of it.
    #[serde(default, skip_serializing_if = "SourceKind::is_mission")]
    pub kind: SourceKind,
    /// The path of the mission, the world or the task among the files; of a use the name of the subtree.
    pub mission: String,
    /// The path of the robot, where another than the file's was told.
    #[serde(default)]
    pub robot: Option<String>,
    /// Values that were told for parameters, name and value.
    #[serde(default)]
    #[cfg_attr(feature = "schema", schema(schema_with = settings))]
    pub settings: Vec<(String, String)>,
    /// Every file that was read, in the order of reading.
    pub files: Vec<SourceFile>,
}

/// What files are read as.
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema))]
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SourceKind {
    /// A task for a robot in a world.
    #[default]
    Mission,
    /// A world in which tasks come and go.
    World,
    /// A task for a world that is there.
    Task,
    /// A part of a task to be added to one that is there.
    Branch,
    /// A subtree of the world, by its name: a task without a file.
    Use,
}

impl SourceKind {
    /// As all were before there were others.
    fn is_mission(&self) -> bool {
        *self == Self::Mission
    }
}

/// One file.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema))]
pub struct SourceFile {
    /// Its path as seen from the folder of the mission, the world or the task.
    pub path: String,
    /// Another of the paths that leads to the same file and has its text.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub same_as: Option<String>,
    /// What it held.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub text: String,
}

/// The schema of lists of a name and a value.
#[cfg(feature = "schema")]
fn settings() -> utoipa::openapi::schema::Array {
    use utoipa::openapi::schema::{ArrayBuilder, ObjectBuilder, Type};
    let text = ObjectBuilder::new().schema_type(Type::String);
    let pair = ArrayBuilder::new().items(text).min_items(Some(2)).max_items(Some(2));
    ArrayBuilder::new().items(pair).description(Some("Values that were told for parameters, name and value.")).build()
}
