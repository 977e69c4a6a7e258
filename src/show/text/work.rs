//! Tasks that come and go, in words.

use ambidex_model::{Blocked, Granting, MissionEnd, NodeEntry, NodeId, Record};
use ambidex_record::History;

use super::brief::listed;
use super::{count, mission_ended};

/// What a record says of tasks, of the tree and of the objects in the room; none of a record of anything else.
pub(crate) fn worked(record: &Record, history: &History) -> Option<String> {
    let names = history.names();
    Some(match record {
        Record::Added { task: Some(task), nodes, .. } => {
            let urgent = if task.priority == 0 { String::new() } else { format!(", priority {}", task.priority) };
            let held = if task.granting == Granting::Paused { ", paused" } else { "" };
            let behaviors = count(behaviors(nodes), "behavior");
            format!("task {} is submitted: {behaviors}{urgent}{held}", task.name)
        }
        Record::Added { under, nodes, names: added, .. } => {
            let top = added.first().map_or("?", String::as_str);
            format!("{top} is added below {}: {}", names.node(*under), count(behaviors(nodes), "behavior"))
        }
        Record::Removed { node, .. } => format!("{} is taken out of the tree", names.node(*node)),
        Record::Granting { task, granting, .. } => {
            let who = task.map_or_else(|| "everything".to_owned(), |task| format!("task {}", name(task, history)));
            match granting {
                Granting::Freely => format!("{who} goes on"),
                Granting::Paused => format!("{who} is paused"),
                Granting::Step => format!("{who} takes a step"),
            }
        }
        Record::Canceled { task, .. } => format!("task {} is canceled", name(*task, history)),
        Record::TaskEnded { task, end, .. } => {
            let ended = history.ended_tasks().back().filter(|ended| ended.task == *task);
            let how = match (end, ended.and_then(|ended| ended.said.as_ref())) {
                (MissionEnd::Done, _) => "done".to_owned(),
                // What it was called is gone with it.
                (MissionEnd::Failed(_), Some(said)) => format!("failed, {said}"),
                (end, _) => mission_ended(*end, names),
            };
            format!("task {} is over: {how}", name(*task, history))
        }
        Record::Stalled { tasks, .. } if tasks.is_empty() => "no task is stalled any more".into(),
        Record::Stalled { tasks, blocked, .. } => {
            let tasks: Vec<String> = tasks.iter().map(|task| name(*task, history)).collect();
            let why = |blocked: &Blocked| format!(": {}: {}", names.node(blocked.leaf), blocked.reason.sentence(names));
            let why = blocked.iter().find(|blocked| blocked.reason.is_telling()).map_or(String::new(), why);
            format!("nothing of {} can go on{why}", listed(&tasks))
        }
        Record::ObjectAdded { name, place, .. } => format!("{name} came into the room, to {}", names.place(*place)),
        Record::ObjectRemoved { object, .. } => format!("{} left the room", names.thing(*object)),
        Record::Checkpoint { .. } => "the log goes on where another was put aside".into(),
        Record::Declined { why, .. } => format!("refused: {}", why.sentence(names)),
        Record::Header(_) | Record::Told { .. } | Record::Observed { .. } | Record::Turn { .. } => return None,
        Record::Began { .. } | Record::Sent { .. } | Record::Decided { .. } | Record::Infeasible { .. } => return None,
        Record::TimedOut { .. } | Record::Reopened { .. } | Record::Overtaken { .. } => return None,
        Record::Stopped { .. } | Record::Ending { .. } | Record::Leaving { .. } => return None,
        Record::Cleaning { .. } | Record::Cleaned { .. } | Record::Released { .. } => return None,
        Record::Woke { .. } | Record::Served { .. } | Record::Awaited { .. } | Record::World { .. } => return None,
        Record::Denied { .. } | Record::Resource { .. } | Record::Controller { .. } => return None,
        Record::Ended { .. } => return None,
    })
}

fn behaviors(nodes: &[NodeEntry]) -> usize {
    nodes.iter().filter(|node| node.kind.is_behavior()).count()
}

/// What a task is called, also when it is gone.
pub(crate) fn name(task: NodeId, history: &History) -> String {
    let there = history.state_of_run().tasks().get(&task).map(|task| task.name.clone());
    let gone =
        || history.ended_tasks().iter().rev().find(|ended| ended.task == task).map(|gone| gone.known.name.clone());
    there.or_else(gone).unwrap_or_else(|| history.names().node(task).to_owned())
}
