//! What nodes tell each other and what root decides, in words.

use ambidex_model::{
    Blocked, Change, Consequences, End, Grant, Granting, LeaseKind, Message, Names, NodeId, Reason, Reopened, Request,
    Resource, Told, Work,
};
use ambidex_record::format;

use anstyle::Style;

use crate::Palette;
use crate::text::{mission_ended, phrase};

pub(super) fn said(from: NodeId, to: NodeId, message: &Message, names: &Names) -> String {
    match message {
        Message::Activation => "activation".into(),
        Message::Answer { .. } => answer(from, message, names),
        Message::Verdict { stopped, .. } if stopped == &[to] => "is to end".into(),
        Message::Verdict { granted, stopped, .. } if !stopped.is_empty() => {
            let granted =
                (!granted.is_empty()).then(|| format!("granted: {}", phrase::nodes(granted.iter().copied(), names)));
            parts([granted, Some(stopping(stopped, names))])
        }
        Message::Verdict { granted, .. } if granted == &[to] => "granted".into(),
        Message::Verdict { granted, .. } => {
            format!("granted: {}", phrase::nodes(granted.iter().copied(), names))
        }
        Message::Release { leaf, end } => format!("{} {}", names.node(*leaf), phrase::ended(*end, names)),
    }
}

/// Who is to end.
pub(super) fn stopping(leaves: &[NodeId], names: &Names) -> String {
    let verb = if leaves.len() == 1 { "is" } else { "are" };
    format!("{} {verb} to end", phrase::nodes(leaves.iter().copied(), names))
}

/// What root is told.
pub(super) fn told(told: &Told, names: &Names) -> String {
    match told {
        Told::Begin { .. } => "begin".into(),
        Told::Resumed => "the runtime was gone; another goes on".into(),
        Told::World { change, origin } => phrase::changed_by(change, *origin, names),
        Told::Service { controller, outage, changes } => {
            let controller = names.controller(*controller);
            let went = outage.map_or(format!("{controller} is back"), |why| format!("{controller} is away: {why}"));
            parts([Some(went)].into_iter().chain(phrase::changes(changes, names).into_iter().map(Some)))
        }
        Told::Woke => "a moment came for which it waited".into(),
        Told::Work { work } => asked_for(work, names),
        Told::Ended { leaf, outcome } => {
            let ended = format!("{} {}", names.node(*leaf), phrase::ended(outcome.end, names));
            parts([Some(ended)].into_iter().chain(phrase::changes(&outcome.changes, names).into_iter().map(Some)))
        }
        Told::End { end } => format!("end: {}", mission_ended(*end, names)),
    }
}

/// Work that is asked for.
fn asked_for(work: &Work, names: &Names) -> String {
    match work {
        Work::Submit(submission) => format!("do the task {}", submission.name),
        Work::Cancel { task } => format!("cancel {}", names.node(*task)),
        Work::Grant { task, granting } => {
            let what = task.map_or("everything", |task| names.node(task));
            match granting {
                Granting::Freely => format!("go on with {what}"),
                Granting::Paused => format!("pause {what}"),
                Granting::Step => format!("one step of {what}"),
            }
        }
        Work::Add { under, .. } => format!("add something below {}", names.node(*under)),
        Work::Remove { node } => format!("take out {}", names.node(*node)),
        Work::Replace { node, .. } => format!("put something in the place of {}", names.node(*node)),
        Work::AddObject { name, place } => format!("{name} came into the room, to {}", names.place(*place)),
        Work::RemoveObject { object } => format!("{} left the room", names.thing(*object)),
    }
}

pub(super) fn style(message: &Message, palette: &Palette, of_end: impl Fn(End) -> Style) -> Style {
    match message {
        Message::Activation => palette.faint,
        Message::Answer { asking, .. } if asking.is_empty() => palette.faint,
        Message::Answer { .. } => Style::new(),
        Message::Verdict { stopped, .. } if !stopped.is_empty() => palette.canceled,
        Message::Verdict { .. } => palette.active,
        Message::Release { end, .. } => of_end(*end),
    }
}

fn answer(from: NodeId, message: &Message, names: &Names) -> String {
    let Message::Answer { running, satisfied, potential, asking, request, blocked } = message else {
        return String::new();
    };
    let asks = match (request.as_deref(), potential) {
        (Some(request), _) => Some(asked(request, names)),
        (None, Some(potential)) => {
            let best = if asking.len() == 1 { "potential" } else { "best potential" };
            Some(format!("asks for {}, {best} {potential:.3}", phrase::nodes(asking.iter().copied(), names)))
        }
        (None, None) => None,
    };
    let is_met = |one: &Blocked| one.leaf == from && one.reason == Reason::Satisfied;
    let no: Vec<String> = blocked.iter().filter(|one| !is_met(one)).map(|one| refusal(from, one, names)).collect();
    let said = parts([
        running.then(|| "is running".into()),
        satisfied.then(|| "its goal is met".into()),
        asks,
        (!no.is_empty()).then(|| no.join("; ")),
    ]);
    if said.is_empty() { "asks for nothing".into() } else { said }
}

/// Potential, claims and skips of a request.
fn asked(request: &Request, names: &Names) -> String {
    let mut said = format!("asks with potential {:.3} for {}", request.potential, format::claims(request, names));
    if !request.skips.is_empty() {
        said += &format!("; skips {}", format::skips(request, names));
    }
    if request.heir {
        said += "; an intention is kept for it";
    }
    said
}

/// A node speaks of itself without its name.
fn refusal(from: NodeId, blocked: &Blocked, names: &Names) -> String {
    let sentence = blocked.reason.sentence(names);
    match blocked.leaf == from {
        true => format!("cannot: {sentence}"),
        false => format!("not {}: {sentence}", names.node(blocked.leaf)),
    }
}

pub(super) fn decided(granted: &[Grant], refused: &[Blocked], reopened: Option<&Reopened>, names: &Names) -> String {
    let grants = granted.iter().map(|grant| {
        let mut said = format!("grants {} {}", names.node(grant.leaf()), phrase::bindings(&grant.bindings, names));
        let skipped = grant.skipped(names.nodes.len());
        if !grant.request.skips.is_empty() {
            said += &format!(" (skipping {})", phrase::nodes(skipped, names));
        }
        Some(said)
    });
    let refusals =
        refused.iter().map(|one| Some(format!("not {}: {}", names.node(one.leaf), one.reason.sentence(names))));
    let reopened = reopened.map(|reopened| reopening(reopened, names));
    let said = parts(grants.chain([reopened]).chain(refusals));
    match (granted.is_empty(), said.is_empty()) {
        (true, true) => "grants nothing".into(),
        (true, false) => format!("grants nothing; {said}"),
        (false, _) => said,
    }
}

/// What is done no more, and why.
fn reopening(reopened: &Reopened, names: &Names) -> String {
    let mut said = format!("{} is done no more", names.node(reopened.node));
    if let Some(resource) = reopened.lapsed() {
        said += &format!(", its lease of {} lapses", names.resource(resource));
    }
    if let Some(lacks) = reopened.lacks() {
        said += &format!(", since {} lacks: {}", names.node(lacks.leaf), lacks.reason.sentence(names));
    }
    said
}

pub(super) fn released(
    leaf: NodeId,
    end: End,
    consequences: Consequences,
    changes: &[Change],
    names: &Names,
) -> String {
    let ended = format!("{} {}", names.node(leaf), phrase::ended(end, names));
    let changes = phrase::changes(changes, names).into_iter().map(Some);
    parts([Some(ended), follows(leaf, consequences, names)].into_iter().chain(changes))
}

/// What the end of a behavior means for the nodes above.
fn follows(leaf: NodeId, consequences: Consequences, names: &Names) -> Option<String> {
    let completed = consequences.completed.map(|done| {
        let completes = (done.node != leaf).then(|| format!("{} is complete", phrase::part(done.node, names)));
        parts([completes, done.heir.map(|heir| format!("{} goes on", names.node(heir)))])
    });
    let failed = consequences.failed.filter(|&failed| failed != leaf);
    let said = parts([completed, failed.map(|failed| format!("{} fails", phrase::part(failed, names)))]);
    (!said.is_empty()).then_some(said)
}

/// Who holds a resource, how and why.
pub(super) fn used(resource: &Resource, names: &Names) -> String {
    let Some(access) = resource.access() else {
        return "is free".into();
    };
    let holding = |kind: LeaseKind, verb: &str| {
        let holders = resource.leases().iter().filter(|lease| lease.kind == kind).map(|lease| lease.holder);
        let holders = phrase::nodes(holders, names);
        (!holders.is_empty()).then(|| format!("{verb} {holders}"))
    };
    let uses = [
        holding(LeaseKind::Running, "is in use by"),
        holding(LeaseKind::Intention, "is kept for what comes next in"),
        holding(LeaseKind::Physical, "holds something for"),
    ];
    let uses: Vec<String> = uses.into_iter().flatten().collect();
    format!("{}, {}", uses.join(", "), phrase::access(access, names))
}

/// What is there, with semicolons between.
fn parts(parts: impl IntoIterator<Item = Option<String>>) -> String {
    let parts: Vec<String> = parts.into_iter().flatten().filter(|part| !part.is_empty()).collect();
    parts.join("; ")
}
