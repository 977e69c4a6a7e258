//! Who stands in whose way when no order is left, for people.

use super::forecast::{Forecast, Kept};
use ambidex_model::{Deadlock, NodeId, Standstill};

/// Where everything comes to a stop behind a moment of which no order leads to the end; `leaf` has brought it there.
pub(super) fn deadlock(ahead: &Forecast<'_>, leaf: NodeId) -> Deadlock {
    let (stop, waiting) = stop(ahead);
    let of_leaf = stop.leases().iter().find(|lease| lease.behavior == leaf);
    let heir = of_leaf.and_then(|lease| waiting.iter().copied().find(|other| stop.is_in_line(*other, lease.holder)));
    let own = Standstill {
        node: heir.unwrap_or(leaf),
        holds: of_leaf.map(|lease| lease.resource),
        needs: heir.map_or(0, |heir| wanted(&stop, heir)),
    };
    let others: Vec<&Kept> = stop.leases().iter().filter(|lease| lease.behavior != leaf).collect();
    let has = |waiting: NodeId| others.iter().find(|lease| stop.is_in_line(waiting, lease.holder));
    let mut strangers = waiting.iter().copied().filter(|other| *other != own.node);
    // One that holds something tells more than one that only waits.
    let stranger = strangers.clone().find(|other| has(*other).is_some()).or_else(|| strangers.next());
    let other = match (stranger, others.first()) {
        (Some(node), _) => {
            Standstill { node, holds: has(node).map(|lease| lease.resource), needs: wanted(&stop, node) }
        }
        (None, Some(lease)) => Standstill { node: lease.behavior, holds: Some(lease.resource), needs: 0 },
        (None, None) => Standstill { node: own.node, holds: None, needs: own.needs },
    };
    Deadlock { other, own }
}

/// Runs what can be run, first what leaves as much free; gives who cannot be run any more.
pub(super) fn stop<'a>(ahead: &Forecast<'a>) -> (Forecast<'a>, Vec<NodeId>) {
    let mut now = ahead.clone();
    loop {
        let open = now.open();
        let mut ran = open.iter().filter_map(|leaf| {
            let mut then = now.clone();
            then.run(*leaf).then_some(then)
        });
        let first = ran.next();
        let is_harmless = |then: &Forecast<'_>| then.is_no_worse(&now);
        let next = match first {
            None => return (now, open),
            Some(first) if is_harmless(&first) => first,
            Some(first) => ran.find(is_harmless).unwrap_or(first),
        };
        now = next;
    }
}

/// How many of what can be kept a behavior needs.
pub(super) fn wanted(stop: &Forecast<'_>, leaf: NodeId) -> u32 {
    stop.needs().leaf(leaf).map_or(0, |spec| spec.needs.len() as u32)
}
