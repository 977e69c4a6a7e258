//! Events of the Trace Event format, which Perfetto and chrome://tracing open.

use serde::Serialize;
use serde_json::{Map, Value, json};

/// One event; several are written as a list of JSON objects, in any order of their times.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TraceEvent {
    name: String,
    #[serde(rename = "cat", skip_serializing_if = "Option::is_none")]
    category: Option<&'static str>,
    #[serde(rename = "ph")]
    phase: &'static str,
    /// Microseconds.
    #[serde(rename = "ts")]
    at_us: u64,
    #[serde(rename = "dur", skip_serializing_if = "Option::is_none")]
    duration_us: Option<u64>,
    #[serde(flatten)]
    track: Track,
    /// Of a flow.
    #[serde(skip_serializing_if = "Option::is_none")]
    id: Option<String>,
    /// Of the end of a flow: that it ends in what is under way, not in what comes next.
    #[serde(rename = "bp", skip_serializing_if = "Option::is_none")]
    binding: Option<&'static str>,
    /// Of an instant: how far it is drawn.
    #[serde(rename = "s", skip_serializing_if = "Option::is_none")]
    scope: Option<&'static str>,
    #[serde(skip_serializing_if = "Map::is_empty")]
    args: Map<String, Value>,
}

/// Where events are drawn: a row of a group.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub(super) struct Track {
    /// The group, a process to viewers.
    pub(super) pid: u32,
    /// The row, a thread to viewers.
    pub(super) tid: u32,
}

/// Arguments of an event: those that are empty say nothing.
pub(super) fn args<const N: usize>(args: [(&str, Value); N]) -> Map<String, Value> {
    let is_said = |value: &Value| !value.is_null() && value.as_str() != Some("");
    args.into_iter().filter(|(_, value)| is_said(value)).map(|(name, value)| (name.to_owned(), value)).collect()
}

impl TraceEvent {
    fn new(phase: &'static str, at_us: u64, track: Track, name: String) -> Self {
        Self {
            name,
            category: None,
            phase,
            at_us,
            duration_us: None,
            track,
            id: None,
            binding: None,
            scope: None,
            args: Map::new(),
        }
    }

    /// Something begins, which the next end on its track ends.
    pub(super) fn begin(at_us: u64, track: Track, category: &'static str, name: String) -> Self {
        Self { category: Some(category), ..Self::new("B", at_us, track, name) }
    }

    /// What began last on the track ends.
    pub(super) fn end(at_us: u64, track: Track, category: &'static str, name: String) -> Self {
        Self { category: Some(category), ..Self::new("E", at_us, track, name) }
    }

    /// Something from its beginning to its end.
    pub(super) fn whole(from_us: u64, to_us: u64, track: Track, category: &'static str, name: String) -> Self {
        let duration_us = Some(to_us.saturating_sub(from_us));
        Self { category: Some(category), duration_us, ..Self::new("X", from_us, track, name) }
    }

    /// Something at a moment.
    pub(super) fn instant(at_us: u64, track: Track, category: &'static str, name: String) -> Self {
        Self { category: Some(category), scope: Some("t"), ..Self::new("i", at_us, track, name) }
    }

    /// An arrow from what is under way on one track to what is on another.
    pub(super) fn arrow(at_us: u64, from: Track, to: Track, name: &str, id: String) -> [Self; 2] {
        let event = |phase, track, binding| Self {
            category: Some("grant"),
            id: Some(id.clone()),
            binding,
            ..Self::new(phase, at_us, track, name.to_owned())
        };
        [event("s", from, None), event("f", to, Some("e"))]
    }

    /// What a group or a row is called, and where it stands among the others.
    pub(super) fn names(what: Named, track: Track, name: &str, place: usize) -> [Self; 2] {
        let (called, sorted) = match what {
            Named::Group => ("process_name", "process_sort_index"),
            Named::Row => ("thread_name", "thread_sort_index"),
        };
        let event = |kind: &str, args| Self { args, ..Self::new("M", 0, track, kind.to_owned()) };
        [event(called, args([("name", json!(name))])), event(sorted, args([("sort_index", json!(place))]))]
    }

    /// The same with arguments.
    #[must_use]
    pub(super) fn with(self, args: Map<String, Value>) -> Self {
        Self { args, ..self }
    }
}

/// What has a name.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Named {
    /// A group of rows.
    Group,
    /// A row.
    Row,
}
