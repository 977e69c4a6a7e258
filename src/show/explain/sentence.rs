//! Sentences that both the story and an account tell.

use ambidex_model::{
    Blocked, Candidate, Cause, Change, Consequences, Distance, End, Grant, Loss, Measured, MissionEnd, Names, NodeId,
    Reason, Record, Reopened, StopCause, Time,
};
use ambidex_record::{History, LeafState};

use crate::text::phrase;

/// The distance that a potential comes of.
pub(super) fn measured(distance: Option<Measured>) -> String {
    let Some(Measured { meters, along }) = distance else { return String::new() };
    let along = match along {
        Distance::Straight => "straight",
        Distance::Path => "along the path",
    };
    format!(" ({meters:.2} m {along})")
}

/// The requests that lost to one, each with its potential, the best first.
pub(super) fn losers(winner: NodeId, refused: &[Blocked]) -> Vec<(NodeId, f64)> {
    let lost = refused.iter().filter_map(|one| {
        let Reason::Outbid { by, own, .. } = &one.reason else {
            return None;
        };
        (*by == winner).then_some((one.leaf, *own))
    });
    let mut lost: Vec<(NodeId, f64)> = lost.collect();
    lost.sort_by(|one, other| other.1.total_cmp(&one.1));
    lost
}

/// Why a request was chosen before others: "Its potential of 0.502 beats that of move 1-1 (0.490)."
///
/// Where several are spoken of, the request is named.
pub(super) fn beats(grant: &Grant, losers: &[(NodeId, f64)], is_named: bool, names: &Names) -> Option<String> {
    let (equal, less): (Vec<_>, Vec<_>) = losers.iter().partition(|(_, own)| *own == grant.request.potential);
    let less: Vec<String> = less.iter().map(|(leaf, own)| format!("{} ({own:.3})", names.node(*leaf))).collect();
    let whose = match is_named {
        true => format!("The potential of {}, {:.3},", names.node(grant.leaf()), grant.request.potential),
        false => format!("Its potential of {:.3}", grant.request.potential),
    };
    let ties = phrase::nodes(equal.iter().map(|(leaf, _)| *leaf), names);
    let come = if equal.len() == 1 { "comes" } else { "come" };
    match (less.as_slice(), ties.is_empty()) {
        ([], true) => None,
        ([], false) => Some(format!("{whose} equals that of {ties}, which {come} after it.")),
        (less, true) => Some(format!("{whose} beats {}.", phrase::listed(less))),
        (less, false) => {
            Some(format!("{whose} beats {} and equals that of {ties}, which {come} after it.", phrase::listed(less)))
        }
    }
}

/// What became of a behavior that ended, after its name or "it": "is done after 4.15 s."
pub(super) fn ended(history: &History, at: Time, leaf: NodeId, end: End, consequences: Consequences) -> Vec<String> {
    let names = history.names();
    let runs = history.leaf(leaf).filter(|leaf| leaf.state() == LeafState::Active);
    let after = runs.map(|runs| format!(" after {:.2} s", (at - runs.since()).as_secs_f64())).unwrap_or_default();
    let mut said = vec![match end {
        End::Succeeded => format!("is done{after}."),
        End::Canceled => format!("is canceled{after}."),
        End::Interrupted => format!("is interrupted{after}, since {}.", interruption(history, leaf)),
        End::Failed(fault) => format!("fails{after}: {}.", fault.sentence(names)),
    }];
    if let Some(done) = consequences.completed.filter(|done| done.node != leaf) {
        said.push(format!("With it {} is complete.", phrase::part(done.node, names)));
    }
    if let Some(failed) = consequences.failed.filter(|failed| *failed != leaf) {
        said.push(format!("With it {} fails.", phrase::part(failed, names)));
    }
    said.extend(phrase::failing(consequences, names).map(|failing| format!("{}.", capital(&failing, names))));
    said
}

/// What kept a behavior from going on that had not failed.
fn interruption(history: &History, leaf: NodeId) -> String {
    let state = history.state_of_run();
    match state.interrupted(leaf) {
        Some(StopCause::Preempted { by }) => return format!("{} is more urgent", history.names().node(*by)),
        Some(StopCause::Broken(reason)) => return reason.sentence(history.names()),
        Some(StopCause::Ends) | None => {}
    }
    let bindings = state.running().get(&leaf).into_iter().flat_map(|grant| &grant.bindings);
    let inhibited = bindings.into_iter().find_map(|binding| {
        let why = state.table().resource(binding.resource).service().outage()?;
        why.is_inhibition().then_some((binding.resource, why))
    });
    match inhibited {
        Some((resource, Loss::Inhibited(why))) => {
            format!("the controller of {} is inhibited: {why}", history.names().resource(resource))
        }
        Some(_) | None => "its runtime was gone".to_owned(),
    }
}

/// What is different in the world, but for where the base is, which moves all the time.
pub(super) fn changes(changes: &[Change], names: &Names) -> Option<String> {
    let told = changes.iter().filter(|change| !matches!(change, Change::Base(_)));
    let mut said = phrase::changes(told, names);
    // Whoever hears where the object is now need not hear that the gripper is empty.
    if said.len() > 1 {
        let empty = phrase::changes(changes.iter().filter(|change| matches!(change, Change::Emptied(_))), names);
        said.retain(|change| !empty.contains(change));
    }
    (!said.is_empty()).then(|| format!("{}.", capital(&said.join(", "), names)))
}

/// What runs already when something starts; none where nothing does.
pub(super) fn beside(running: impl Iterator<Item = NodeId>, names: &Names) -> Option<String> {
    let running: Vec<NodeId> = running.collect();
    let verb = if running.len() == 1 { "still runs" } else { "still run" };
    (!running.is_empty()).then(|| format!("{} {verb}.", phrase::nodes(running, names)))
}

/// What is done without running; none where nothing is.
pub(super) fn skipped(leaves: &[NodeId], names: &Names) -> Option<String> {
    let verb = if leaves.len() == 1 { "is skipped: its goal is" } else { "are skipped: their goals are" };
    (!leaves.is_empty()).then(|| format!("{} {verb} met already.", phrase::nodes(leaves.iter().copied(), names)))
}

/// What is done no more, after its name or "it", and why.
pub(super) fn reopened(reopened: &Reopened, names: &Names) -> String {
    let why = match &reopened.cause {
        Cause::Lapse { resource, heir } => format!(
            ": {} was kept for {}, which cannot come now, since {}",
            names.resource(*resource),
            names.node(heir.leaf),
            heir.reason.sentence(names)
        ),
        Cause::Redo { leaf } => format!(": {} needs it again", names.node(*leaf)),
        Cause::Retry { fault, .. } => {
            format!(": {} failed and is tried again: {}", phrase::part(reopened.node, names), fault.sentence(names))
        }
        Cause::Leave => format!(": {} leaves its way", phrase::part(reopened.up_to, names)),
        Cause::Repeat { .. } => format!(": {} is done once more", phrase::part(reopened.node, names)),
        Cause::Yield => format!(": {} comes first", names.node(reopened.node)),
    };
    format!("counts as done no more{why}.")
}

/// What those are that something happened to beside the rounds.
pub(super) fn turned(record: &Record) -> LeafState {
    match record {
        Record::Infeasible { .. } | Record::TimedOut { .. } => LeafState::Failed,
        Record::Overtaken { .. } => LeafState::Skipped,
        Record::Reopened { .. } => LeafState::Waiting,
        Record::Cleaned { is_done, .. } => {
            if *is_done {
                LeafState::Skipped
            } else {
                LeafState::Failed
            }
        }
        Record::Ending { .. } | Record::Leaving { .. } => LeafState::Canceled,
        Record::Cleaning { .. } => LeafState::Active,
        Record::Stopped { .. } => LeafState::Canceled,
        Record::TaskEnded { end: MissionEnd::Done, .. } => LeafState::Done,
        Record::TaskEnded { end: MissionEnd::Canceled, .. } | Record::Canceled { .. } => LeafState::Canceled,
        Record::TaskEnded { .. } | Record::Stalled { .. } | Record::Declined { .. } => LeafState::Failed,
        Record::Added { .. } | Record::Removed { .. } | Record::Granting { .. } => LeafState::Waiting,
        Record::ObjectAdded { .. } | Record::ObjectRemoved { .. } | Record::Checkpoint { .. } => LeafState::Waiting,
        Record::Header(_) | Record::Told { .. } | Record::Turn { .. } | Record::Began { .. } => LeafState::Waiting,
        Record::Observed { .. } => LeafState::Waiting,
        Record::World { .. } | Record::Denied { .. } => LeafState::Waiting,
        Record::Woke { .. } | Record::Served { .. } | Record::Awaited { .. } => LeafState::Waiting,
        Record::Decided { .. } | Record::Released { .. } | Record::Resource { .. } => LeafState::Waiting,
        Record::Sent { .. } | Record::Controller { .. } | Record::Ended { .. } => LeafState::Waiting,
    }
}

/// Whether it happened to a leaf.
pub(super) fn is_turned(record: &Record, leaf: NodeId, history: &History) -> bool {
    let state = history.state(leaf);
    let is_below = |node: NodeId| history.is_within(leaf, node);
    match record {
        Record::Infeasible { leaf: other, consequences, .. } => {
            *other == leaf || consequences.failed.is_some_and(is_below) && state == LeafState::Waiting
        }
        Record::TimedOut { node, .. } => is_below(*node) && state.is_open() | (state == LeafState::Active),
        Record::Overtaken { skips, .. } => skips.iter().any(|skip| skip.contains(leaf)) && state.is_open(),
        Record::Reopened { reopened, .. } => match reopened.cause {
            Cause::Leave => is_below(reopened.node) && state == LeafState::Waiting,
            Cause::Repeat { .. } => is_below(reopened.node) && state != LeafState::NotNeeded,
            Cause::Yield => reopened.ended.iter().any(|kept| kept.behavior == leaf),
            Cause::Retry { .. } | Cause::Lapse { .. } | Cause::Redo { .. } => reopened.reset.contains(&leaf),
        },
        Record::Header(_) | Record::Told { .. } | Record::Turn { .. } | Record::Began { .. } => false,
        Record::Stopped { leaves, .. } => leaves.contains(&leaf),
        Record::Removed { node, .. } | Record::TaskEnded { task: node, .. } => is_below(*node),
        Record::Canceled { task, .. } | Record::Granting { task: Some(task), .. } => is_below(*task),
        Record::Added { .. } | Record::Granting { task: None, .. } | Record::Stalled { .. } => false,
        Record::ObjectAdded { .. } | Record::ObjectRemoved { .. } | Record::Declined { .. } => false,
        Record::Checkpoint { .. } => false,
        Record::Leaving { way: node, .. } => is_below(*node) && state == LeafState::Waiting,
        Record::Cleaning { node, .. } | Record::Cleaned { node, .. } => is_below(*node) && history.is_in_cleanup(leaf),
        Record::Observed { .. }
        | Record::World { .. }
        | Record::Denied { .. }
        | Record::Sent { .. }
        | Record::Ending { .. } => false,
        Record::Woke { .. } | Record::Served { .. } | Record::Awaited { .. } | Record::Decided { .. } => false,
        Record::Released { .. } | Record::Resource { .. } | Record::Controller { .. } | Record::Ended { .. } => false,
    }
}

/// A sentence begins with a capital unless it begins with a name.
pub(super) fn capital(said: &str, names: &Names) -> String {
    let named = names.resources.iter().chain(&names.objects).chain(names.nodes.iter());
    let is_name = named.into_iter().any(|name| said.starts_with(name.as_str()));
    let mut letters = said.chars();
    match letters.next() {
        Some(first) if !is_name && !said.starts_with("object ") => first.to_uppercase().chain(letters).collect(),
        Some(_) | None => said.to_owned(),
    }
}

/// Why it is this hand and not another one: those that do not reach, and those that are nearer and are for others.
pub(super) fn hands(grant: &Grant, granted: &[Grant], names: &Names) -> Option<String> {
    let mut said: Vec<String> = Vec::new();
    for (claim, binding) in std::iter::zip(&grant.request.claims, &grant.bindings) {
        said.extend(claim.beyond.iter().map(|beyond| {
            let hand = names.resource(beyond.resource);
            match beyond.by {
                Some(by) => format!("{hand} would not reach what {} asks later", names.node(by)),
                None => format!("{hand} does not reach it"),
            }
        }));
        let own = claim.candidates.iter().find(|candidate| candidate.resource == binding.resource);
        let is_nearer = |other: &&Candidate| own.is_some_and(|own| other.weight_m() < own.weight_m());
        for nearer in claim.candidates.iter().filter(is_nearer) {
            let has_it = |other: &&Grant| other.bindings.iter().any(|binding| binding.resource == nearer.resource);
            let other = granted.iter().filter(|other| other.leaf() != grant.leaf()).find(has_it);
            let hand = names.resource(nearer.resource);
            said.extend(other.map(|other| format!("{hand}, which is nearer, is for {}", names.node(other.leaf()))));
        }
    }
    (!said.is_empty()).then(|| format!("{}.", said.join("; ")))
}
