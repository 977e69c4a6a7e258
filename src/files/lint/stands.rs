//! Who must stand somewhere claims what could drive the base away.

use std::collections::BTreeSet;

use super::Seen;
use crate::fault::Faults;
use ambidex_model::{Condition, EffectTerm, NodeId, ResourceId, Task};

pub(super) fn check(seen: &Seen<'_>, faults: &mut Faults) {
    let driven = driven(seen);
    for leaf in seen.mission.tree.leaves() {
        check_leaf(seen, leaf, &driven, faults);
    }
}

/// Who must stand somewhere to begin and does not claim what drives may be driven away.
fn check_leaf(seen: &Seen<'_>, leaf: NodeId, driven: &BTreeSet<ResourceId>, faults: &mut Faults) {
    let behavior = seen.behavior(leaf);
    let claims_it = behavior.claims.iter().any(|claim| seen.resource(claim).is_some_and(|id| driven.contains(&id)));
    if driven.is_empty() || claims_it || !must_stand(&behavior.precondition) {
        return;
    }
    let message = "it must stand somewhere and does not claim the base, which may drive away meanwhile".to_owned();
    seen.warn(leaf, message, "claim `{type: base, shared: at $place}`", faults);
}

/// What behaviors claim that move the base.
fn driven(seen: &Seen<'_>) -> BTreeSet<ResourceId> {
    let drivers = seen.behaviors().filter(|behavior| {
        let drives = behavior.commands.iter().any(|term| matches!(term.task, Task::DriveTo(..)));
        drives || behavior.effects.iter().any(|effect| matches!(effect, EffectTerm::Stands(_)))
    });
    drivers.flat_map(|behavior| &behavior.claims).filter_map(|claim| seen.resource(claim)).collect()
}

/// Whether a condition says where the base stands.
fn must_stand(condition: &Condition) -> bool {
    match condition {
        Condition::All(parts) => parts.iter().any(must_stand),
        Condition::At { .. } => true,
        Condition::Never
        | Condition::Path { .. }
        | Condition::Held(_)
        | Condition::Free(_)
        | Condition::Somewhere(_) => false,
        Condition::Lies(..) | Condition::Fact(..) => false,
    }
}
