//! Who got what a request lost: a request that beat another below root may have lost there, and a reason names only who
//! has what it is about.

use std::collections::BTreeMap;

use super::Verdict;
use ambidex_model::{Cause, Grant, NodeId, Reason, Reopened};

/// A lapse whose heir lost something, with whoever has it.
pub(super) fn with_winner(running: &BTreeMap<NodeId, Grant>, verdict: &Verdict, mut reopened: Reopened) -> Reopened {
    if let Cause::Lapse { heir, .. } = &mut reopened.cause
        && let Some(reason) = winner(running, verdict, &heir.reason)
    {
        heir.reason = reason;
    }
    reopened
}

/// The true reason where one names a behavior that did not get what it is about.
pub(super) fn winner(running: &BTreeMap<NodeId, Grant>, verdict: &Verdict, reason: &Reason) -> Option<Reason> {
    let (by, contested, own) = if let Reason::Outbid { by, resource, own, .. } = *reason {
        (by, Some(resource), own)
    } else if let Reason::LessUrgent { by, .. } | Reason::DoneOftener { by, .. } = *reason {
        (by, None, 0.0)
    } else if let Reason::WholeRobot { by } = *reason {
        (by, None, 0.0)
    } else {
        return None;
    };
    if running.contains_key(&by) || verdict.granted.contains_key(&by) {
        return None;
    }
    let has = |grant: &&Grant| grant.bindings.iter().any(|binding| Some(binding.resource) == contested);
    let winner = verdict.granted.values().find(has).zip(contested);
    Some(match winner {
        Some((grant, resource)) => Reason::Outbid { by: grant.leaf(), resource, own, theirs: grant.request.potential },
        None => Reason::Outdone { by },
    })
}
