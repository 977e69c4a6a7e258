//! Who must stand somewhere claims what could drive the base away, and stands where it reaches.

use std::collections::BTreeSet;

use ambidex_core::behavior::stands;
use ambidex_core::tree::split_stands;

use super::Seen;
use crate::fault::Faults;
use ambidex_model::{EffectTerm, NodeId, ResourceId, Task};

pub(super) fn check(seen: &Seen<'_>, faults: &mut Faults) {
    for (drive, leaf) in split_stands(seen.mission) {
        let drive = seen.mission.names.node(drive);
        let message = format!("no stand to which {drive} goes reaches both this and all else that comes behind it");
        seen.warn(leaf, message, "give it a `move` of its own", faults);
    }
    let driven = driven(seen);
    for leaf in seen.mission.tree.leaves() {
        check_leaf(seen, leaf, &driven, faults);
    }
}

/// Who must stand somewhere to begin and does not claim what drives may be driven away.
fn check_leaf(seen: &Seen<'_>, leaf: NodeId, driven: &BTreeSet<ResourceId>, faults: &mut Faults) {
    let behavior = seen.behavior(leaf);
    let claims_it = behavior.claims.iter().any(|claim| seen.resource(claim).is_some_and(|id| driven.contains(&id)));
    if driven.is_empty() || claims_it || stands(&behavior.precondition).is_none() {
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
