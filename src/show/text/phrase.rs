//! Parts of sentences that several texts are made of: lists, uses of resources, changes of the world, ends.

pub(crate) use super::brief::listed;
use std::borrow::Cow;

use ambidex_model::{
    Access, Binding, Cause, Change, Consequences, ControllerId, End, FactId, Location, Loss, Names, NodeId, Objection,
    Origin, PlaceId, Record, Reopened, Service, StopCause, Time,
};
use ambidex_record::History;

use super::work;

/// The top of the task.
const TOP: NodeId = NodeId(1);

/// Names of nodes as a list.
pub(crate) fn nodes(nodes: impl IntoIterator<Item = NodeId>, names: &Names) -> String {
    let nodes: Vec<&str> = nodes.into_iter().map(|node| names.node(node)).collect();
    listed(&nodes)
}

/// A node as a part of the task: its top need not have a name, and a name that is a mere word is set off.
pub(crate) fn part(node: NodeId, names: &Names) -> Cow<'_, str> {
    const TOP: NodeId = NodeId(1);
    let name = names.node(node);
    match node == TOP {
        true => "the task".into(),
        false if ["and", "or", "then"].contains(&name) => format!("\"{name}\"").into(),
        false => name.into(),
    }
}

/// Why a way is not needed: which child of the OR did it.
pub(crate) fn did_it(way: NodeId, names: &Names) -> String {
    format!("{} did it", part(way, names))
}

/// How a resource is used: `alone`, `for "at shelf"`.
pub(crate) fn access(access: Access, names: &Names) -> String {
    match access {
        Access::Exclusive => "alone".into(),
        Access::Shared(channel) => format!("for \"{}\"", names.channel(channel)),
    }
}

/// What a grant has: `right_gripper alone, base and head for "at shelf"`.
pub(crate) fn bindings(bindings: &[Binding], names: &Names) -> String {
    let mut uses: Vec<(Access, Vec<&str>)> = Vec::new();
    let alone_first = [true, false]
        .into_iter()
        .flat_map(|alone| bindings.iter().filter(move |binding| (binding.access == Access::Exclusive) == alone));
    for binding in alone_first {
        let resource = names.resource(binding.resource);
        match uses.iter_mut().find(|(access, _)| *access == binding.access) {
            Some((_, resources)) if resources.contains(&resource) => {}
            Some((_, resources)) => resources.push(resource),
            None => uses.push((binding.access, vec![resource])),
        }
    }
    let uses: Vec<String> =
        uses.iter().map(|(used, resources)| format!("{} {}", listed(resources), access(*used, names))).collect();
    uses.join(", ")
}

/// A change of the world as a sentence.
pub(crate) fn changed(change: &Change, names: &Names) -> String {
    match change {
        Change::Base(pose) => format!("the base is at ({:.2}, {:.2}) now", pose.at.x, pose.at.y),
        Change::Object(object, at) => {
            let object = names.thing(*object);
            match at {
                Location::At(place) => format!("{object} is at {} now", names.place(*place)),
                Location::In(by) => {
                    let holders: Vec<_> = by.as_slice().iter().map(|by| names.resource(*by)).collect();
                    format!("{object} is in {} now", listed(&holders))
                }
                Location::Unknown => format!("nobody knows where {object} is"),
            }
        }
        Change::Laid(object, place, _) => format!("{} is at {} now", names.thing(*object), names.place(*place)),
        Change::Taken(object, by) => format!("{} is in {} now", names.thing(*object), names.resource(*by)),
        Change::Blocked(obstacle) => {
            let (at, size) = (obstacle.middle, obstacle.size);
            format!("something stands at ({:.2}, {:.2}) now, {:.2} m by {:.2} m", at.x, at.y, size.x, size.y)
        }
        Change::Cleared(around) => format!("nothing stands at ({:.2}, {:.2}) any more", around.at.x, around.at.y),
        Change::Emptied(resource) => format!("{} is empty now", names.resource(*resource)),
        Change::Fact(fact, true) => format!("\"{}\" holds now", names.fact(*fact)),
        Change::Fact(fact, false) => format!("\"{}\" holds no more", names.fact(*fact)),
    }
}

/// A change of the world that somebody outside made, with how it came about.
pub(crate) fn changed_by(change: &Change, origin: Origin, names: &Names) -> String {
    format!("{}: {}", changed(change, names), origin.phrase(change, names))
}

/// What somebody outside said of the world, and why it is not taken.
pub(crate) fn denied(change: &Change, origin: Origin, why: Objection, names: &Names) -> String {
    let by = match origin {
        Origin::Operator => "an operator".into(),
        Origin::Controller(id) => Cow::Borrowed(names.controller(id)),
        Origin::Script => "what goes wrong on purpose".into(),
        Origin::Dropped | Origin::Resumed => "the runtime".into(),
    };
    format!("{by} says that {}, which is refused: {}", changed(change, names), why.sentence(change, names))
}

/// Changes as sentences, none twice.
pub(crate) fn changes<'a>(changes: impl IntoIterator<Item = &'a Change>, names: &Names) -> Vec<String> {
    let mut said: Vec<String> = Vec::new();
    for change in changes {
        let change = changed(change, names);
        if !said.contains(&change) {
            said.push(change);
        }
    }
    said
}

/// What became of a controller's service.
pub(crate) fn served(controller: ControllerId, service: Service, names: &Names) -> String {
    let controller = names.controller(controller);
    match service {
        Service::Available => format!("{controller} is back"),
        Service::Unavailable { why: Loss::Inhibited(why), .. } => format!("{controller} is inhibited: {why}"),
        Service::Unavailable { why, .. } => format!("{controller} is unavailable: {why}"),
        Service::Gone { why, .. } => format!("{controller} is awaited no more: {why}"),
    }
}

/// What a mission waits for: for controllers, until when.
pub(crate) fn awaited(until: Option<Time>, facts: &[FactId], places: &[PlaceId], names: &Names) -> String {
    let facts: Vec<String> = facts.iter().map(|fact| format!("\"{}\"", names.fact(*fact))).collect();
    let places: Vec<String> = places.iter().map(|place| names.place(*place).to_owned()).collect();
    let change = (!facts.is_empty()).then(|| format!("others change {}", listed(&facts)));
    let clear = (!places.is_empty()).then(|| format!("the way to {} is free again", listed(&places)));
    let before: Vec<String> = change.into_iter().chain(clear).collect();
    if !before.is_empty() {
        return format!("nothing can go on before {}", before.join(" or "));
    }
    let how_long = match until {
        Some(until) => format!("which is awaited until {:.2} s", until.seconds()),
        None => "which is awaited for as long as it is inhibited".to_owned(),
    };
    format!("nothing can go on without what is unavailable, {how_long}")
}

/// What root says beside its rounds of what fails, is tried again or otherwise, or need not be done; none of anything else.
pub(crate) fn turned(record: &Record, history: &History) -> Option<String> {
    let names = history.names();
    match record {
        Record::Infeasible { leaf, reason, consequences, .. } => {
            let never = format!("{} can never run: {}", names.node(*leaf), reason.sentence(names));
            Some(with_consequences(never, *leaf, *consequences, names))
        }
        Record::TimedOut { node, consequences, .. } => {
            Some(with_consequences(format!("{} took too long", part(*node, names)), *node, *consequences, names))
        }
        Record::Reopened { reopened, .. } => Some(reopened_to(reopened, names)),
        Record::Overtaken { skips, goal, consequences, .. } => {
            let is_open = |leaf: &NodeId| history.leaf(*leaf).is_some_and(|leaf| leaf.state().is_open());
            let skipped = skips.iter().flat_map(|skip| skip.nodes(names.nodes.len()));
            let passed = nodes(skipped.filter(is_open), names);
            let done = format!("done by others: {passed} ({} holds already)", part(*goal, names));
            Some(with_consequences(done, *goal, *consequences, names))
        }
        Record::Stopped { leaves, cause, .. } => stopped(leaves, cause, names),
        Record::Ending { .. } => {
            let cleanup = history.state_of_run().owed_cleanup(TOP, None);
            cleanup.map(|_| "the mission is to end, and what it has begun is cleaned up first".into())
        }
        Record::Leaving { way, .. } => {
            Some(format!("{} is to be left, and what was begun is cleaned up first", part(*way, names)))
        }
        Record::Cleaning { node, .. } => Some(format!("cleaning up behind {}", body(*node, names))),
        Record::Cleaned { node, is_done, consequences, .. } => {
            let node_name = body(*node, names);
            let said = match is_done {
                true => format!("there is nothing to clean up behind {node_name}"),
                false => format!("cannot clean up behind {node_name}"),
            };
            Some(with_consequences(said, *node, *consequences, names))
        }
        Record::Added { .. } | Record::Removed { .. } | Record::Granting { .. } => work::worked(record, history),
        Record::Canceled { .. } | Record::TaskEnded { .. } | Record::Stalled { .. } => work::worked(record, history),
        Record::ObjectAdded { .. } | Record::ObjectRemoved { .. } => work::worked(record, history),
        Record::Declined { .. } | Record::Checkpoint { .. } => work::worked(record, history),
        Record::Header(_) | Record::Told { .. } | Record::Turn { .. } | Record::Began { .. } => None,
        Record::Observed { .. } | Record::Sent { .. } => None,
        Record::World { .. } | Record::Denied { .. } => None,
        Record::Woke { .. } | Record::Served { .. } | Record::Awaited { .. } | Record::Decided { .. } => None,
        Record::Released { .. } | Record::Resource { .. } | Record::Controller { .. } | Record::Ended { .. } => None,
    }
}

/// A way that is left, or a node that is tried or done again.
fn reopened_to(reopened: &Reopened, names: &Names) -> String {
    let node = part(reopened.node, names);
    match &reopened.cause {
        Cause::Leave => format!("{} leaves {node}, in which nothing can go on", part(reopened.up_to, names)),
        Cause::Retry { fault, until, .. } => {
            format!("{node} is tried again at {:.2} s, since it failed: {}", until.seconds(), fault.sentence(names))
        }
        Cause::Lapse { .. } | Cause::Redo { .. } => format!("{node} is done no more"),
        Cause::Repeat { until: None, .. } => format!("{node} is done and begins again"),
        Cause::Repeat { until: Some(until), .. } => {
            format!("{node} is done and begins again at {:.2} s", until.seconds())
        }
        Cause::Yield => {
            let mut given_up: Vec<&str> = reopened.ended.iter().map(|kept| names.resource(kept.resource)).collect();
            given_up.dedup();
            let holders = nodes(reopened.ended.iter().map(|kept| kept.holder), names);
            format!("{holders} gives up {} for {node}, which is more urgent", listed(&given_up))
        }
    }
}

/// The node of which a cleanup is that of another.
fn body(node: NodeId, names: &Names) -> Cow<'_, str> {
    part(NodeId(node.0 + 1), names)
}

/// What is interrupted, and why; none of what is canceled with a node above.
fn stopped(leaves: &[NodeId], cause: &StopCause, names: &Names) -> Option<String> {
    let interrupted = nodes(leaves.iter().copied(), names);
    match cause {
        StopCause::Ends => None,
        StopCause::Broken(reason) => Some(format!("interrupting {interrupted}: {}", reason.sentence(names))),
        StopCause::Preempted { by } => Some(format!("interrupting {interrupted} for {}", names.node(*by))),
    }
}

fn with_consequences(said: String, from: NodeId, consequences: Consequences, names: &Names) -> String {
    let completed = consequences.completed.filter(|done| done.node != from);
    let completed = completed.map(|done| format!("with it {} is complete", part(done.node, names)));
    let failed = consequences.failed.filter(|failed| *failed != from);
    let failed = failed.map(|failed| format!("with it {} fails", part(failed, names)));
    [Some(said), completed, failed, failing(consequences, names)].into_iter().flatten().collect::<Vec<_>>().join("; ")
}

/// What becomes of a node that cannot be complete any more and is not over yet.
pub(crate) fn failing(consequences: Consequences, names: &Names) -> Option<String> {
    let failing = consequences.failing?;
    let node = part(failing.node, names);
    Some(match failing.finishes {
        true => format!("the rest of {node} is finished as far as it can be"),
        false => format!("what runs of {node} is canceled"),
    })
}

/// Who asks again after having waited, or begins its next time.
pub(crate) fn asking_again(woken: &[NodeId], history: &History) -> String {
    let (names, state) = (history.names(), history.state_of_run());
    let is_next = |node: &&NodeId| state.iterations(**node) > 0 && state.status(**node).failures == 0;
    let (next, waiting): (Vec<&NodeId>, Vec<&NodeId>) = woken.iter().partition(is_next);
    let said = |woken: Vec<&NodeId>, one: &str, several: &str| {
        let verb = if woken.len() == 1 { one } else { several };
        (!woken.is_empty()).then(|| format!("{} {verb} again", nodes(woken.into_iter().copied(), names)))
    };
    let said = [said(next, "begins", "begin"), said(waiting, "asks", "ask")];
    said.into_iter().flatten().collect::<Vec<_>>().join(", ")
}

/// How a behavior ended.
pub(crate) fn ended(end: End, names: &Names) -> String {
    match end {
        End::Succeeded => "succeeded".into(),
        End::Canceled => "was canceled".into(),
        End::Interrupted => "was interrupted by no fault of its own".into(),
        End::Failed(fault) => format!("failed: {}", fault.sentence(names)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_read_as_people_write_them() {
        let check = |items: &[&str], expected: &str| assert_eq!(listed(items), expected);
        check(&[], "");
        check(&["a"], "a");
        check(&["a", "b"], "a and b");
        check(&["a", "b", "c"], "a, b and c");
        check(&["a", "b", "c", "d", "e", "f", "g"], "a, b, c, d, e, f and g");
        check(&["a", "b", "c", "d", "e", "f", "g", "h"], "a, b, c, d, e, f and 2 more");
    }
}
