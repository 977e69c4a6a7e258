//! How it ends: with an end, or with something that it names and waits for.

use ambidex_model::{NodeId, Record, Told};

use super::run::Run;
use super::{Found, Rule};

/// What the run waits for at each moment.
#[derive(Debug, Default)]
pub(super) struct Ending {
    has_begun: bool,
    has_ended: bool,
    /// What was told to wait for, since the last decision that granted something.
    awaited: Option<String>,
    /// Who waits out a back-off or for the next iteration, each once, the latest last.
    waits: Vec<NodeId>,
}

impl Ending {
    pub(super) fn take(&mut self, run: &Run, record: &Record, found: &mut Found) {
        match record {
            Record::Began { .. } => self.has_begun = true,
            Record::Ended { .. } => self.has_ended = true,
            Record::Told { input: Told::Resumed, .. } => self.has_ended = false,
            Record::Awaited { until, facts, places, .. } => {
                let facts = facts.iter().map(|fact| format!("\"{}\"", run.names.fact(*fact)));
                let ways = places.iter().map(|place| format!("a free way to {}", run.names.place(*place)));
                let until = until.map_or(String::new(), |until| format!(" until {until}"));
                let what: Vec<_> = facts.chain(ways).collect();
                let what = if what.is_empty() { "a controller".to_owned() } else { what.join(" and ") };
                self.awaited = Some(format!("it waits for {what}{until}"));
            }
            Record::Decided { granted, .. } if !granted.is_empty() => {
                self.awaited = None;
                if self.has_ended {
                    found.push(Rule::End, "something is granted after the end".to_owned());
                }
            }
            Record::Released { leaf, waits_until: Some(_), .. } => self.wait(*leaf),
            Record::Woke { leaves, .. } => self.waits.retain(|leaf| !leaves.contains(leaf)),
            Record::Reopened { reopened, .. } => self.wait(reopened.node),
            Record::Decided { .. } | Record::Released { .. } | Record::Told { .. } | Record::Header(_) => {}
            Record::Observed { .. } | Record::Turn { .. } | Record::Sent { .. } | Record::Infeasible { .. } => {}
            Record::TimedOut { .. } | Record::Overtaken { .. } | Record::Stopped { .. } | Record::Ending { .. } => {}
            Record::Leaving { .. } | Record::Cleaning { .. } | Record::Cleaned { .. } | Record::Served { .. } => {}
            Record::Stalled { tasks, .. } => {
                let named: Vec<&str> = tasks.iter().map(|task| run.name(*task)).collect();
                self.awaited = (!tasks.is_empty()).then(|| format!("{} stalled", named.join(" and ")));
            }
            Record::Added { .. } | Record::Removed { .. } | Record::TaskEnded { .. } | Record::Canceled { .. } => {}
            Record::Granting { .. } | Record::Declined { .. } => {}
            Record::Checkpoint { .. } => self.has_begun = true,
            Record::ObjectAdded { .. } | Record::ObjectRemoved { .. } => {}
            Record::World { .. } | Record::Denied { .. } | Record::Resource { .. } | Record::Controller { .. } => {}
        }
    }

    fn wait(&mut self, node: NodeId) {
        self.waits.retain(|other| *other != node);
        self.waits.push(node);
    }

    /// What a log without an end ends at; a finding where that is nothing.
    pub(super) fn finish(&self, run: &Run, is_whole: bool, found: &mut Found) -> Option<String> {
        if self.has_ended {
            return None;
        }
        let runs: Vec<_> = run.running.keys().map(|leaf| run.name(*leaf)).collect();
        let open = if !self.has_begun {
            "it has not begun".to_owned()
        } else if !runs.is_empty() {
            format!("{} runs", runs.join(" and "))
        } else if let Some(awaited) = &self.awaited {
            awaited.clone()
        } else if let Some(leaf) = self.waits.last() {
            format!("{} waits to ask again", run.name(*leaf))
        } else {
            // One that takes tasks rests between them, and its log goes on in another file.
            if is_whole && !run.is_standing() {
                found.push(Rule::End, "nothing runs, nothing is awaited, and there is no end".to_owned());
            }
            "nothing runs".to_owned()
        };
        Some(open)
    }
}
