//! Why not: whoever answered in a round and is not granted is told with a reason, and a stall names what cannot run.

use std::collections::BTreeSet;

use ambidex_model::{Message, MissionEnd, NodeId, Record};

use super::run::Run;
use super::{Found, LookedAt, Rule};

/// Behaviors that wait for a verdict in the open round.
#[derive(Debug, Default)]
pub(super) struct Reasons {
    waiting: BTreeSet<NodeId>,
    last_had_any: bool,
}

impl Reasons {
    pub(super) fn take(&mut self, run: &Run, record: &Record, found: &mut Found, looked_at: &mut LookedAt) {
        if let Record::Sent { from, message: Message::Answer { running, satisfied, request, .. }, .. } = record {
            let is_leaf = run.kinds.get(from.index()).is_some_and(|kind| kind.is_behavior());
            let is_idle = !running && (!satisfied || request.is_some());
            if is_leaf && is_idle {
                self.waiting.insert(*from);
            } else {
                self.waiting.remove(from);
            }
        } else if let Record::Decided { granted, refused, round, .. } = record {
            self.last_had_any = !refused.is_empty();
            looked_at.refusals += refused.len() as u64;
            let refused = refused.iter().map(|blocked| blocked.leaf);
            let told: BTreeSet<NodeId> = refused.chain(granted.iter().map(|grant| grant.leaf())).collect();
            for leaf in std::mem::take(&mut self.waiting).difference(&told).filter(|_| run.has_messages) {
                let name = run.name(*leaf);
                found.push(Rule::Reasons, format!("{name} is refused in round {round} without a reason"));
            }
        } else if let Record::Ended { end: MissionEnd::Stalled, .. } = record
            && !self.last_had_any
        {
            found.push(Rule::Reasons, "the mission is stalled, and nobody is told why".to_owned());
        }
    }
}
