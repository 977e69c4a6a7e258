//! The core beside the reference model, event by event.

use ambidex::model::{
    Blocked, Change, Consequences, Deadline, End, Grant, MissionEnd, NodeId, NodeRange, Objection, Origin, Reason,
    Record, Reopened, ResourceId, Urged,
};

use super::counts::{Counts, variant};
use super::generator::Case;
use super::reference::{Certified, Held, Model, Step};
use super::run::{Event, counts, in_order};
use crate::driver::Driver;
use crate::support::short;

/// The core and the reference model on the same events.
pub fn against_reference(case: &Case) -> Counts {
    following(case, |_, _| ())
}

/// The same; `moment` sees the model before every event and every round.
pub fn following<'a>(case: &'a Case, mut moment: impl FnMut(&Model<'a>, Option<&Event>)) -> Counts {
    let mut model = Model::new(&case.mission, case.is_serial, &case.clashing);
    let driver = in_order(case, 0, |driver, event, records| {
        model.now = driver.now;
        moment(&model, event);
        let mut goes_on = match event {
            Some(Event::Woke) => model.woke(),
            Some(Event::Service(controller, outage)) => model.service(*controller, *outage),
            None => true,
            Some(Event::World(change, origin)) => model.hear(*change, *origin),
            Some(Event::Ended(leaf, outcome)) => {
                model.ended(*leaf, outcome);
                true
            }
            Some(Event::Cancel) => model.tell_to_finish(MissionEnd::Canceled),
            Some(Event::Nothing) => {
                model.end_stalled(true);
                true
            }
        };
        if case.prevents_deadlock {
            model.certified = Certified::of_rounds(records).collect();
        }
        while model.goes_on_cleaning() && goes_on && model.end.is_none() {
            moment(&model, None);
            goes_on = model.round();
        }
        compare(case, driver, event, records, &mut model);
    });
    let mut counts = counts(case, &driver);
    counts.rechoices = u64::from(model.rechoices);
    counts
}

fn compare(case: &Case, driver: &Driver, event: Option<&Event>, records: &[Record], model: &mut Model<'_>) {
    let said: Vec<String> = records.iter().filter_map(|record| recorded(case, record)).collect();
    let steps = std::mem::take(&mut model.log);
    if std::env::var("AMBIDEX_SHOW").is_ok() {
        println!("== {event:?}\n{}", short(&said.join("\n")));
    }
    let mut expected: Vec<String> = steps.iter().map(|step| stepped(case, step)).collect();
    expected.extend(model.end.map(|end| format!("{end:?}")));
    let show =
        || format!("after {event:?}\nlast records {:?}", &driver.records[driver.records.len().saturating_sub(4)..]);
    assert!(
        said == expected,
        "{}\ncore\n{}\nreference\n{}",
        show(),
        short(&said.join("\n")),
        short(&expected.join("\n"))
    );
    assert!(driver.taken_up == model.taken_up, "{}\n{:?}\n{:?}", show(), driver.taken_up, model.taken_up);
    compare_state(driver, model, &show());
    let stopped = records.iter().flat_map(|record| match record {
        Record::Stopped { leaves, cause, .. } => leaves.iter().map(|leaf| (*leaf, cause.clone())).collect(),
        _ => Vec::new(),
    });
    let (mut stopped, stops): (Vec<_>, _) = (stopped.collect(), model.stops());
    stopped.sort_by_key(|(leaf, _)| *leaf);
    assert!(stopped == stops, "{}\ncore stops {stopped:?}, reference {stops:?}", show());
}

/// A record of the core as one line, if the model says such a thing.
fn recorded(case: &Case, record: &Record) -> Option<String> {
    Some(match record {
        Record::Released { leaf, end, consequences, unfit, .. } => released(*leaf, *end, consequences, unfit),
        Record::Decided { granted, refused, reopened, deadlines, urged, overdue, .. } => {
            let refused = refused.iter().map(|Blocked { leaf, reason }| (*leaf, reason));
            decided(case, granted.iter(), refused, reopened.as_ref(), deadlines)
                + &changed(urged.as_ref(), overdue.as_ref())
        }
        Record::Infeasible { leaf, reason, consequences, .. } => infeasible(*leaf, reason, consequences),
        Record::TimedOut { node, consequences, .. } => timed_out(*node, consequences),
        Record::Reopened { reopened, .. } => tried_again(reopened),
        Record::Overtaken { leaf, skips, goal, consequences, .. } => overtaken(*leaf, skips[0], *goal, consequences),
        Record::Ended { end, .. } => format!("{end:?}"),
        Record::Added { .. } | Record::Removed { .. } | Record::Granting { .. } => return None,
        Record::Canceled { .. } | Record::TaskEnded { .. } | Record::Stalled { .. } => return None,
        Record::ObjectAdded { .. }
        | Record::ObjectRemoved { .. }
        | Record::Declined { .. }
        | Record::Checkpoint { .. } => return None,
        Record::Told { .. } | Record::Observed { .. } | Record::Turn { .. } | Record::Began { .. } => return None,
        Record::Header(_) | Record::Stopped { .. } | Record::Sent { .. } | Record::World { .. } => return None,
        Record::Resource { .. } | Record::Woke { .. } | Record::Served { .. } => return None,
        Record::Awaited { .. } | Record::Controller { .. } => return None,
        Record::Denied { change, origin, why, .. } => denied(*change, *origin, *why),
        Record::Ending { end, until, .. } => format!("ending {end:?} {until:?}"),
        Record::Leaving { way, .. } => format!("leaving {way:?}"),
        Record::Cleaning { node, .. } => format!("cleaning {node:?}"),
        Record::Cleaned { node, is_done, consequences, .. } => cleaned(*node, *is_done, consequences),
    })
}

/// The same of what the model says.
fn stepped(case: &Case, step: &Step) -> String {
    match step {
        Step::Released { leaf, end, consequences, unfit } => released(*leaf, *end, consequences, unfit),
        Step::Decided(decision) => {
            let refused = decision.refused.iter().map(|(&leaf, refusal)| (leaf, &refusal.reason));
            let reopened = decision.reopened.as_ref();
            decided(case, decision.granted.values(), refused, reopened, &decision.deadlines)
                + &changed(decision.urged.as_ref(), decision.overdue.as_ref())
        }
        Step::Infeasible { leaf, reason, consequences } => infeasible(*leaf, reason, consequences),
        Step::TimedOut { node, consequences } => timed_out(*node, consequences),
        Step::Reopened(reopened) => tried_again(reopened),
        Step::Denied { change, origin, why } => denied(*change, *origin, *why),
        Step::Ending { end, until } => format!("ending {end:?} {until:?}"),
        Step::Leaving { way } => format!("leaving {way:?}"),
        Step::Cleaning { node } => format!("cleaning {node:?}"),
        Step::Cleaned { node, is_done, consequences } => cleaned(*node, *is_done, consequences),
        Step::Overtaken { leaf, skip, goal, consequences } => overtaken(*leaf, *skip, *goal, consequences),
    }
}

fn changed(urged: Option<&Vec<Urged>>, overdue: Option<&Vec<NodeId>>) -> String {
    let overdue = overdue.map_or_else(String::new, |overdue| format!(" overdue {overdue:?}"));
    urged.map_or_else(String::new, |urged| format!(" urged {urged:?}")) + &overdue
}

fn released(leaf: NodeId, end: End, consequences: &Consequences, unfit: &[ResourceId]) -> String {
    format!("{leaf:?} {end:?} {consequences:?} unfit {unfit:?}")
}

fn cleaned(node: NodeId, is_done: bool, consequences: &Consequences) -> String {
    format!("cleaned {node:?} {is_done} {consequences:?}")
}

fn denied(change: Change, origin: Origin, why: Objection) -> String {
    format!("{origin:?} denied {change:?} {why:?}")
}

fn infeasible(leaf: NodeId, reason: &Reason, consequences: &Consequences) -> String {
    format!("{leaf:?} infeasible {reason:?} {consequences:?}")
}

fn timed_out(node: NodeId, consequences: &Consequences) -> String {
    format!("{node:?} timed out {consequences:?}")
}

fn tried_again(Reopened { node, up_to, cause, reset, ended, .. }: &Reopened) -> String {
    format!("{node:?} reopened up to {up_to:?} {cause:?} reset {reset:?} ended {ended:?}")
}

fn overtaken(leaf: NodeId, skip: NodeRange, goal: NodeId, consequences: &Consequences) -> String {
    format!("{leaf:?} overtaken {skip:?} {goal:?} {consequences:?}")
}

/// Leases, world, and what runs.
fn compare_state(driver: &Driver, model: &Model<'_>, seen: &str) {
    for (id, resource) in driver.root().state().table().iter() {
        let leases = resource.leases().iter().map(|lease| Held {
            holder: lease.holder,
            behavior: lease.behavior,
            kind: lease.kind,
            from: lease.from,
        });
        let (row, core) = (&model.rows[id.index()], (resource.access(), leases.collect()));
        assert!((row.access, row.leases.clone()) == core, "{}\n{id:?}: core {core:?}, reference {row:?}", seen);
    }
    let world = driver.root().state().world();
    assert!(*world == model.world_state, "{seen}\ncore {world:?}\nreference {:?}", model.world_state);
    assert!(driver.root().state().running().keys().eq(model.running.keys()), "{seen}");
}

/// The kind of a reason.
fn kind(reason: &Reason) -> String {
    lost(reason).unwrap_or_else(|| variant(reason))
}

/// The model names whoever was preferred below root; whether that one won in the end, the driver's watch asks.
fn lost(reason: &Reason) -> Option<String> {
    let is_lost = matches!(
        reason,
        Reason::Outbid { .. }
            | Reason::LessUrgent { .. }
            | Reason::DoneOftener { .. }
            | Reason::WholeRobot { .. }
            | Reason::Outdone { .. }
    );
    is_lost.then(|| "lost to another".to_owned())
}

/// A decision as one line; where several reasons are as true, only the kind of reason counts.
fn decided<'a>(
    case: &Case,
    granted: impl Iterator<Item = &'a Grant>,
    refused: impl Iterator<Item = (NodeId, &'a Reason)>,
    reopened: Option<&Reopened>,
    deadlines: &[Deadline],
) -> String {
    let name = |leaf: NodeId| case.mission.names.node(leaf).to_owned();
    let granted: Vec<_> = granted
        .map(|Grant { request, bindings, .. }| {
            let (changes, skips) = (&request.changes, &request.skips);
            let order = (request.priority, request.iterations, request.potential);
            format!("{} {order:?} {bindings:?} {changes:?} {skips:?}", name(request.leaf))
        })
        .collect();
    let refused = refused.map(|(leaf, reason)| {
        let is_one_of_several =
            matches!(reason, Reason::Clash { .. } | Reason::AlreadyDone { .. } | Reason::Reserved { .. });
        let told = if is_one_of_several { kind(reason) } else { lost(reason).unwrap_or_else(|| format!("{reason:?}")) };
        format!("{} {told}", name(leaf))
    });
    let refused: Vec<_> = refused.collect();
    let reopened = reopened.map(|reopened| {
        let lacks = reopened.lacks().map(|lacks| (lacks.leaf, kind(&lacks.reason)));
        format!("{:?} {:?} {:?} lacks {lacks:?}", reopened.up_to, reopened.node, reopened.lapsed())
    });
    format!("granted {granted:?} refused {refused:?} reopened {reopened:?} deadlines {deadlines:?}")
}
