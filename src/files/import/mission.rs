//! The text of an imported mission.

use super::form::POTENTIAL_KEY;
use super::kinds::KindDraft;
use super::translate::{Draft, Is, NodeDraft};
use super::write::{Lines, flow};
use crate::text::scalar;

/// How long a behavior takes that nothing tells of.
const TAKES: &str = "1 s";

/// What a mission is called.
#[derive(Debug)]
pub(super) struct Title<'a> {
    /// The file that it comes from, without its folder.
    pub(super) file: &'a str,
    pub(super) mission: &'a str,
    /// The path of its robot file from where it will stand.
    pub(super) robot: &'a str,
}

/// The YAML of a mission, with a comment wherever something is not carried over.
pub(super) fn text(title: &Title<'_>, draft: &Draft) -> String {
    let mut lines = Lines::default();
    lines.comment(0, &format!("Imported from {}, a task file of the dHTT software.", title.file));
    lines.comment(
        0,
        "Every behavior claims the whole robot, so that one runs at a time and the potentials alone say which.",
    );
    for comment in &draft.comments {
        lines.comment(0, comment);
    }
    lines.line(0, &format!("mission: {}", scalar(title.mission)));
    lines.line(0, &format!("robot: {}", scalar(title.robot)));
    lines.gap();
    world(draft, &mut lines);
    lines.gap();
    lines.comment(
        0,
        &format!("How long a behavior takes is not in a dHTT file: {TAKES} is there to be seen in diagrams."),
    );
    lines.line(0, "behaviors:");
    for kind in &draft.kinds {
        behavior(kind, &mut lines);
    }
    lines.gap();
    lines.line(0, "task:");
    node(&draft.top, 1, "", &mut lines);
    lines.into_text()
}

fn world(draft: &Draft, lines: &mut Lines) {
    lines.line(0, "world:");
    lines.comment(1, "A dHTT file has no coordinates. Places and objects can be added for `move`, `pick` and `place`.");
    for (parameter, values) in &draft.named {
        lines.comment(1, &format!("Named as `{parameter}` in the task: {}.", values.join(", ")));
    }
    lines.line(1, "robot: {at: [0 m, 0 m]}");
    lines.line(1, "places: {}");
}

fn behavior(kind: &KindDraft, lines: &mut Lines) {
    let mut about = format!("The plugin {}.", super::notes::line(&kind.plugin));
    if !kind.is_told {
        about += " How it computes its potential is not in a dHTT file: 1, unless a node tells another.";
    }
    if !kind.texts.is_empty() {
        about += " Nothing acts by its texts.";
    }
    lines.comment(1, &about);
    lines.line(1, &format!("{}:", scalar(&kind.name)));
    if !kind.texts.is_empty() {
        lines.line(2, &format!("label: {}", scalar(&kind.label)));
    }
    lines.line(2, "parameters:");
    let number = if kind.is_told { "number" } else { "{type: number, default: 1}" };
    lines.line(3, &format!("{POTENTIAL_KEY}: {number}"));
    for text in &kind.texts {
        let ty = if text.is_told { "text" } else { "{type: text, default: '-'}" };
        lines.line(3, &format!("{}: {ty}", scalar(&text.name)));
    }
    lines.line(2, "claims: all");
    lines.line(2, &format!("potential: ${POTENTIAL_KEY}"));
    lines.line(2, &format!("takes: {TAKES}"));
}

/// A node, and all below it; `dash` begins an item of a list.
fn node(of: &NodeDraft, depth: usize, dash: &str, lines: &mut Lines) {
    let within = depth + dash.len() / 2;
    for comment in &of.comments {
        lines.comment(depth, comment);
    }
    let name = format!("name: {}", scalar(&of.name));
    match &of.is {
        Is::Composite(word, children) => {
            lines.line(depth, &format!("{dash}{name}"));
            lines.line(within, &format!("{word}:"));
            for child in children {
                node(child, within + 1, "- ", lines);
            }
        }
        Is::Behavior(kind, arguments) => {
            let written = arguments.iter().map(|(key, value)| {
                // A potential is a number, whatever it looks like to YAML.
                let value = if key == POTENTIAL_KEY { value.clone() } else { scalar(value) };
                (key.as_str(), value)
            });
            lines.line(depth, &format!("{dash}{}: {}", scalar(kind), flow(written)));
            lines.line(within, &name);
        }
    }
}
