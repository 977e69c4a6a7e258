//! What is different in the world, as rows.

use ambidex_model::{Change, Location, Names, NodeId, Origin, Record, WorldState};
use ambidex_record::History;

use super::cells;

/// Columns of a row.
pub(super) const COLUMNS: &[&str] =
    &["at_s", "what", "name", "is", "where", "x_m", "y_m", "heading_rad", "by", "who", "refused"];

/// Who says that something is so.
enum By {
    /// It was so when the mission began or went on.
    Start,
    /// What the base says while it drives.
    Base,
    Behavior(NodeId),
    Others(Origin),
}

/// The rows of a record, which the history has taken.
pub(super) fn rows(history: &History, record: &Record) -> Vec<Vec<String>> {
    let row = |change: &Change, by: &By, refused: String| row(history, change, by, refused);
    let so = |changes: &[Change], by: By| changes.iter().map(|change| row(change, &by, String::new())).collect();
    match record {
        Record::Began { world_state, .. } => so(&all(world_state), By::Start),
        Record::Observed { change, .. } => so(&[*change], By::Base),
        Record::Released { leaf, changes, .. } => so(changes, By::Behavior(*leaf)),
        Record::World { change, origin, .. } => so(&[*change], By::Others(*origin)),
        Record::Denied { change, origin, why, .. } => {
            vec![row(change, &By::Others(*origin), why.sentence(change, history.names()))]
        }
        Record::ObjectAdded { object, place, .. } => {
            so(&[Change::Object(*object, Location::At(*place))], By::Others(Origin::Operator))
        }
        Record::ObjectRemoved { object, .. } => {
            so(&[Change::Object(*object, Location::Unknown)], By::Others(Origin::Operator))
        }
        Record::Added { .. } | Record::Removed { .. } | Record::Granting { .. } => Vec::new(),
        Record::Canceled { .. } | Record::TaskEnded { .. } | Record::Stalled { .. } => Vec::new(),
        Record::Declined { .. } | Record::Checkpoint { .. } => Vec::new(),
        Record::Header(_) | Record::Told { .. } | Record::Turn { .. } | Record::Sent { .. } => Vec::new(),
        Record::Decided { .. } | Record::Infeasible { .. } | Record::TimedOut { .. } => Vec::new(),
        Record::Reopened { .. } | Record::Overtaken { .. } | Record::Stopped { .. } => Vec::new(),
        Record::Ending { .. } | Record::Leaving { .. } | Record::Cleaning { .. } => Vec::new(),
        Record::Cleaned { .. } | Record::Woke { .. } | Record::Served { .. } | Record::Awaited { .. } => Vec::new(),
        Record::Resource { .. } | Record::Controller { .. } | Record::Ended { .. } => Vec::new(),
    }
}

/// A state of the world as changes.
fn all(world: &WorldState) -> Vec<Change> {
    let objects = world.objects.iter().enumerate().map(|(object, at)| Change::Object(object.into(), *at));
    let facts = world.facts.iter().enumerate().map(|(fact, holds)| Change::Fact(fact.into(), *holds));
    [Change::Base(world.base)].into_iter().chain(objects).chain(facts).collect()
}

fn row(history: &History, change: &Change, by: &By, refused: String) -> Vec<String> {
    let names = history.names();
    let [what, name, is, place] = said(change, names);
    let pose = if let Change::Base(pose) = change {
        [pose.at.x, pose.at.y, pose.heading].map(|number| number.to_string())
    } else {
        Default::default()
    };
    let (by, who) = match by {
        By::Start => ("start", String::new()),
        By::Base => ("controller", String::new()),
        By::Behavior(leaf) => ("behavior", names.node(*leaf).to_owned()),
        By::Others(Origin::Controller(controller)) => ("controller", names.controller(*controller).to_owned()),
        By::Others(Origin::Operator) => ("operator", String::new()),
        By::Others(Origin::Script) => ("purpose", String::new()),
        By::Others(Origin::Dropped) => ("dropped", String::new()),
        By::Others(Origin::Resumed) => ("resumed", String::new()),
    };
    let head = [cells::seconds(history.now()), what, name, is, place];
    head.into_iter().chain(pose).chain([by.to_owned(), who, refused]).collect()
}

/// What is different: the kind of thing, its name, what it is, and where.
fn said(change: &Change, names: &Names) -> [String; 4] {
    let said = |what: &str, name: &str, is: &str, place: String| [what.into(), name.into(), is.into(), place];
    match change {
        Change::Base(_) => said("base", "", "at", String::new()),
        Change::Object(object, Location::At(place)) => {
            said("object", names.object(*object), "at", names.place(*place).to_owned())
        }
        Change::Laid(object, place, _) => said("object", names.object(*object), "at", names.place(*place).to_owned()),
        Change::Object(object, Location::In(holders)) => {
            let holders = holders.as_slice().iter().map(|holder| names.resource(*holder));
            said("object", names.object(*object), "in", cells::list(holders))
        }
        Change::Object(object, Location::Unknown) => said("object", names.object(*object), "unknown", String::new()),
        Change::Taken(object, by) => said("object", names.object(*object), "taken", names.resource(*by).to_owned()),
        Change::Blocked(obstacle) => {
            said("obstacle", "", "there", format!("{:.2} {:.2}", obstacle.middle.x, obstacle.middle.y))
        }
        Change::Cleared(around) => said("obstacle", "", "gone", format!("{:.2} {:.2}", around.at.x, around.at.y)),
        Change::Emptied(resource) => said("resource", names.resource(*resource), "empty", String::new()),
        Change::Fact(fact, holds) => said("fact", names.fact(*fact), &holds.to_string(), String::new()),
    }
}
