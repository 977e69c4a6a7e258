//! Between work as it is asked for, by names, and as root takes it, by ids.

use super::Desk;
use crate::control::{Answer, Edit, NameOrId, Refusal, Why, Work as Asked};
use ambidex_model::{Branch, Granting, Hindrance, Names, NodeId, Source, Submission, Work};

/// What is said when it is done.
#[derive(Debug)]
pub(super) enum Said {
    /// There is one more task.
    Submitted,
    /// Something was added to a tree.
    Added,
    /// This, as a sentence without its end.
    Plainly(String),
}

impl Desk {
    /// Work by ids, and what is said when it is done.
    pub(super) fn by_ids(&self, asked: Asked) -> Result<(Work, Said), Refusal> {
        if !self.mission.tree.is_standing() {
            return Err(Refusal::takes_no_work());
        }
        let branch = |source: Source| Branch { source, fragment: None };
        Ok(match asked {
            Asked::Submit(submission) => {
                let granting = if submission.pause { Granting::Paused } else { Granting::Freely };
                let name = submission.name.unwrap_or_default();
                let (priority, branch) = (submission.priority, branch(submission.source));
                (Work::Submit(Box::new(Submission { name, priority, granting, branch })), Said::Submitted)
            }
            Asked::Cancel(task) => {
                let task = self.task(&task)?;
                (Work::Cancel { task }, Said::Plainly(format!("{} is told to end", self.called(task))))
            }
            Asked::Pause(task) => self.grant(task, Granting::Paused, "is paused")?,
            Asked::Resume(task) => self.grant(task, Granting::Freely, "goes on")?,
            Asked::Step(task) => self.grant(task, Granting::Step, "takes a step")?,
            Asked::Edit(task, edit) => {
                let task = self.task(&task)?;
                match edit {
                    Edit::Add { under, source, at } => {
                        let under = self.node(task, &under)?;
                        (Work::Add { under, behind: at, branch: branch(source) }, Said::Added)
                    }
                    Edit::Remove { node } => {
                        let node = self.node(task, &node)?;
                        (Work::Remove { node }, Said::Plainly(format!("{} is taken out", self.called(node))))
                    }
                    Edit::Replace { node, source } => {
                        let node = self.node(task, &node)?;
                        (Work::Replace { node, branch: branch(source) }, Said::Added)
                    }
                }
            }
            Asked::AddObject { object, place } => {
                if let Some(misnamed) = self.mission.misnamed(&object) {
                    return Err(Refusal::new(Why::NotNow, format!("no further object can be called so: {misnamed}")));
                }
                let names = &self.mission.names;
                let found = names.places.iter().position(|known| *known == place);
                let found =
                    found.ok_or_else(|| Refusal::no_such("place", &place, names.places.iter().map(String::as_str)))?;
                let said = Said::Plainly(format!("{object} is at {place} now"));
                (Work::AddObject { name: object, place: found.into() }, said)
            }
            Asked::RemoveObject { object } => {
                let names = self.mission.names.objects.iter().map(String::as_str).filter(|name| !name.is_empty());
                let found = self.mission.object(&object).ok_or_else(|| Refusal::no_such("object", &object, names))?;
                (Work::RemoveObject { object: found }, Said::Plainly(format!("{object} is not in the room any more")))
            }
            Asked::Stop => return Err(Refusal::over()),
        })
    }

    fn grant(&self, task: Option<NameOrId>, granting: Granting, said: &str) -> Result<(Work, Said), Refusal> {
        let task = task.map(|task| self.task(&task)).transpose()?;
        let who = task.map_or("everything", |task| self.called(task));
        Ok((Work::Grant { task, granting }, Said::Plainly(format!("{who} {said}"))))
    }

    fn called(&self, node: NodeId) -> &str {
        self.mission.names.node(node)
    }

    fn task(&self, wanted: &NameOrId) -> Result<NodeId, Refusal> {
        let tasks = self.mission.tree.tasks.iter().copied();
        let found = tasks.clone().find(|task| wanted.is(task.0, self.called(*task)));
        found.ok_or_else(|| wanted.is_no_task(tasks.map(|task| self.called(task))))
    }

    /// The one node of a task that is meant.
    fn node(&self, task: NodeId, wanted: &NameOrId) -> Result<NodeId, Refusal> {
        let nodes = self.mission.tree.topology.nodes_below(task);
        let found: Vec<NodeId> = nodes.clone().filter(|node| wanted.is(node.0, self.called(*node))).collect();
        match found.as_slice() {
            [node] => Ok(*node),
            [] => Err(Refusal::no_such("node", &wanted.to_string(), nodes.map(|node| self.called(node)))),
            several => {
                let numbers: Vec<String> = several.iter().map(|node| node.0.to_string()).collect();
                let said = format!("{} nodes of {} are called so", several.len(), self.called(task));
                Err(Refusal::new(Why::NoSuchName, said).with_help(format!("their numbers: {}", numbers.join(", "))))
            }
        }
    }

    /// What is said of what was done.
    pub(super) fn done(&self, said: Said, added: Option<NodeId>) -> Answer {
        match (said, added) {
            (Said::Submitted, Some(task)) => Answer::Submitted { task: task.0, name: self.called(task).to_owned() },
            (Said::Added, Some(node)) => {
                Answer::Changed { said: format!("{} is added as node {}", self.called(node), node.0) }
            }
            (Said::Submitted | Said::Added, None) => Answer::Changed { said: "it is done".into() },
            (Said::Plainly(said), _) => Answer::Changed { said },
        }
    }
}

/// Why root does not take something.
pub(super) fn refusal(why: Hindrance, names: &Names) -> Refusal {
    let for_programs = match why {
        Hindrance::HasMission => return Refusal::takes_no_work(),
        Hindrance::NotBegun => Why::NotBegun,
        Hindrance::Over => Why::Over,
        Hindrance::Unread => Why::Faulty,
        Hindrance::NoTask | Hindrance::NoNode | Hindrance::NoPlace | Hindrance::NoObject => Why::NoSuchName,
        Hindrance::ObjectHeld => Why::Held,
        Hindrance::Full { .. } | Hindrance::GivenUp | Hindrance::IsTask | Hindrance::Runs { .. } => Why::NotNow,
        Hindrance::Holds { .. } | Hindrance::IsDone | Hindrance::IsOver | Hindrance::HasNoChildren => Why::NotNow,
        Hindrance::IsLast | Hindrance::IsPassed | Hindrance::NameTaken { .. } | Hindrance::Misnamed => Why::NotNow,
        Hindrance::ObjectNeeded { .. } => Why::NotNow,
    };
    Refusal::new(for_programs, why.sentence(names))
}

/// It is done, and the log takes nothing.
pub(super) fn not_logged() -> Refusal {
    Refusal::new(Why::NotNow, "the log takes nothing: what was asked for is done, and would be lost with this daemon")
        .with_help("make room on the disk of the log")
}
