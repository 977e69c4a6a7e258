//! What a daemon is, and how well its controllers are.

use serde::{Deserialize, Serialize};

use ambidex_link::WIRE_VERSION;
use ambidex_model::{Diagnostics, JOURNAL_VERSION, Names};

/// A daemon and its controllers.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema))]
pub struct About {
    /// Version of the program.
    pub version: String,
    /// Version of the wire that it speaks to controllers.
    pub wire_version: u32,
    /// Version of the log that it writes.
    pub log_version: u32,
    /// How well each controller was in the last second, in the order of the robot file; none in the first second.
    pub controllers: Vec<ControllerDiagnostics>,
}

/// How well a controller is.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema))]
pub struct ControllerDiagnostics {
    /// What the robot file calls it.
    pub name: String,
    /// What is said of it.
    #[serde(flatten)]
    #[cfg_attr(feature = "schema", schema(value_type = Object))]
    pub diagnostics: Diagnostics,
}

impl About {
    /// This program, with what was said last of its controllers.
    pub fn this(diagnostics: &[Diagnostics], names: &Names) -> Self {
        let named = |diagnostics: &Diagnostics| ControllerDiagnostics {
            name: names.controller(diagnostics.controller).to_owned(),
            diagnostics: *diagnostics,
        };
        Self {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            wire_version: WIRE_VERSION,
            log_version: JOURNAL_VERSION,
            controllers: diagnostics.iter().map(named).collect(),
        }
    }
}
