//! Failures as the file that says them.

use std::fmt::Write;

use ambidex_model::{Change, Disk, Failures, Flaw, FlawKind, Location, Mishap, Names, Obstacle, Time};

use super::{ALL, FAILURES};

/// The text of a failure file that comes to these failures of a mission with these names, where one can say them: it
/// cannot put objects into grippers, nor move the base. None where nothing goes wrong, which no file says.
pub fn failures_text(failures: &Failures, names: &Names) -> Option<String> {
    let entries = failures.mishaps.iter().filter_map(|(at, mishap)| of_mishap(*at, *mishap, names));
    let entries = entries.chain(failures.flaws.iter().map(|flaw| of_flaw(flaw, names)));
    let mut text = String::new();
    for entry in entries {
        let _ = writeln!(text, "  - {{{entry}}}");
    }
    (!text.is_empty()).then(|| format!("{FAILURES}:\n{text}"))
}

fn of_mishap(at: Time, mishap: Mishap, names: &Names) -> Option<String> {
    let controller = |key: &str, id| format!("{key}: {}", quoted(names.controller(id)));
    let event = match mishap {
        Mishap::Lose(id) => controller("lose", id),
        Mishap::Hang(id) => controller("hang", id),
        Mishap::Inhibit(id) => controller("inhibit", id),
        Mishap::Return(id) => controller("return", id),
        Mishap::World(Change::Fact(fact, true)) => format!("set: {}", quoted(names.fact(fact))),
        Mishap::World(Change::Fact(fact, false)) => format!("clear: {}", quoted(names.fact(fact))),
        Mishap::World(Change::Object(object, Location::At(place)) | Change::Laid(object, place, _)) => {
            format!("lies: {{object: {}, at: {}}}", quoted(names.object(object)), quoted(names.place(place)))
        }
        Mishap::World(Change::Blocked(Obstacle { middle, size, heading })) => {
            let (at, size) = (format!("[{}, {}]", middle.x, middle.y), format!("[{}, {}]", size.x, size.y));
            format!("block: {{at: {at}, size: {size}, heading: {heading}}}")
        }
        Mishap::World(Change::Cleared(around)) => format!("unblock: [{}, {}]", around.at.x, around.at.y),
        Mishap::World(
            Change::Object(_, Location::In(_) | Location::Unknown)
            | Change::Taken(..)
            | Change::Emptied(_)
            | Change::Base(_),
        ) => return None,
        Mishap::Disk(disk) => format!("disk: {}", word(disk)),
        Mishap::Cancel => "cancel: true".to_owned(),
    };
    Some(format!("at: {}, {event}", seconds(at.seconds())))
}

fn of_flaw(flaw: &Flaw, names: &Names) -> String {
    let attempt = flaw.attempt.map_or_else(|| "every".to_owned(), |attempt| attempt.to_string());
    let wrong = match flaw.kind {
        FlawKind::Fails => "fails: aborted".to_owned(),
        FlawKind::Hangs => "hangs: true".to_owned(),
        FlawKind::Late(by) => format!("late: {}", seconds(by.as_secs_f64())),
        FlawKind::Drops(None) => format!("drops: {ALL}"),
        FlawKind::Drops(Some(object)) => format!("drops: {}", quoted(names.object(object))),
    };
    format!("behavior: {}, attempt: {attempt}, {wrong}", quoted(names.node(flaw.leaf)))
}

pub(super) fn word(disk: Disk) -> &'static str {
    match disk {
        Disk::Full => "full",
        Disk::Slow => "slow",
        Disk::Well => "well",
    }
}

fn seconds(seconds: f64) -> String {
    format!("{seconds} s")
}

/// A name as YAML reads it, whatever letters it has.
fn quoted(name: &str) -> String {
    serde_json::Value::from(name).to_string()
}
