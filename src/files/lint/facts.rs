//! Every fact that a behavior needs is so at the start, or some behavior makes it so.

use std::collections::BTreeSet;

use super::Seen;
use crate::fault::Faults;
use ambidex_model::{Condition, EffectTerm, FactId, NodeId};

pub(super) fn check(seen: &Seen<'_>, faults: &mut Faults) {
    let brought = brought(seen);
    for leaf in seen.mission.tree.leaves() {
        check_leaf(seen, leaf, &brought, faults);
    }
}

fn check_leaf(seen: &Seen<'_>, leaf: NodeId, brought: &BTreeSet<(FactId, bool)>, faults: &mut Faults) {
    let mut needed = Vec::new();
    needs(&seen.behavior(leaf).precondition, &mut needed);
    for (fact, holds) in needed {
        let is_so = seen.mission.start.facts[fact.index()] == holds;
        if is_so || brought.contains(&(fact, holds)) {
            continue;
        }
        let (fact, verb) = (seen.mission.names.fact(fact), if holds { "sets" } else { "clears" });
        let message = format!("it can never run: no behavior {verb} \"{fact}\"");
        seen.warn(leaf, message, "see `facts` of the world and `effects` of the behaviors", faults);
    }
}

/// Every fact as some behavior makes it.
fn brought(seen: &Seen<'_>) -> BTreeSet<(FactId, bool)> {
    let effects = seen.behaviors().flat_map(|behavior| &behavior.effects);
    let facts = effects.filter_map(|effect| match effect {
        EffectTerm::Fact(fact, holds) => Some((*fact, *holds)),
        EffectTerm::Lies(..) | EffectTerm::Taken(..) | EffectTerm::Stands(_) => None,
    });
    facts.collect()
}

/// Every fact that a condition needs, and how.
fn needs(condition: &Condition, needed: &mut Vec<(FactId, bool)>) {
    match condition {
        Condition::All(parts) => parts.iter().for_each(|part| needs(part, needed)),
        Condition::Fact(fact, holds) => needed.push((*fact, *holds)),
        Condition::Never | Condition::At { .. } | Condition::Path { .. } => {}
        Condition::Held(_) | Condition::Free(_) | Condition::Lies(..) => {}
    }
}
