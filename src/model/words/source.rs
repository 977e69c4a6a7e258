//! The files that a mission was made of, as they were when it was.

use serde::{Deserialize, Serialize};

/// All that is needed to make a mission again.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Source {
    /// The path of the mission among the files.
    pub mission: String,
    /// The path of the robot, where another than the mission's was told.
    #[serde(default)]
    pub robot: Option<String>,
    /// Values that were told for parameters, name and value.
    #[serde(default)]
    pub settings: Vec<(String, String)>,
    /// Every file that was read, in the order of reading.
    pub files: Vec<SourceFile>,
}

/// One file.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct SourceFile {
    /// Its path as seen from the folder of the mission.
    pub path: String,
    /// Another of the paths that leads to the same file and has its text.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub same_as: Option<String>,
    /// What it held.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub text: String,
}
