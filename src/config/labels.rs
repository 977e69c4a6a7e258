//! What nodes are called: as written, else after what they are; no name comes twice.

use std::collections::{BTreeMap, BTreeSet};

use super::fault::Faults;
use super::kinds::Kind;
use super::names::Register;
use super::task::{Draft, DraftKind};

/// Gives every node a name of its own, in preorder.
pub(super) fn label(drafts: &[Draft], places: &Register, objects: &Register, faults: &mut Faults) -> Vec<String> {
    let mut taken = BTreeSet::from(["root".to_owned()]);
    for name in drafts.iter().filter_map(|draft| draft.name.as_ref()) {
        if !taken.insert(name.value.clone()) {
            let message = format!("another node is called `{}`", name.value);
            faults.push(name.spot, "name", message, None);
        }
    }
    let mut words = BTreeMap::new();
    for draft in drafts {
        *words.entry(composite(draft)).or_insert(0) += 1;
    }
    let mut numbers = BTreeMap::new();
    let name = |draft: &Draft| {
        if let Some(name) = &draft.name {
            return name.value.clone();
        }
        if let Some(DraftKind::Root) = draft.kind {
            return "root".to_owned();
        }
        let plain = composite(draft).map_or_else(|| behavior(draft, places, objects), str::to_owned);
        let is_numbered = composite(draft).is_some() && words.get(&composite(draft)) > Some(&1);
        let number = numbers.entry(plain.clone()).or_insert(0);
        unused(&plain, is_numbered, number, &mut taken)
    };
    drafts.iter().map(name).collect()
}

/// `then 1`, `then 2`, …; a behavior's second is `pick 1 #2`.
fn unused(plain: &str, is_numbered: bool, number: &mut u32, taken: &mut BTreeSet<String>) -> String {
    loop {
        *number += 1;
        let name = match (is_numbered, *number) {
            (true, number) => format!("{plain} {number}"),
            (false, 1) => plain.to_owned(),
            (false, number) => format!("{plain} #{number}"),
        };
        if taken.insert(name.clone()) {
            return name;
        }
    }
}

fn composite(draft: &Draft) -> Option<&'static str> {
    match draft.kind? {
        DraftKind::And => Some("and"),
        DraftKind::Or => Some("or"),
        DraftKind::Then => Some("then"),
        DraftKind::Root | DraftKind::Behavior(_) => None,
    }
}

fn behavior(draft: &Draft, places: &Register, objects: &Register) -> String {
    match draft.kind {
        Some(DraftKind::Behavior(Kind::Move { to, .. })) => {
            format!("move to {}", places.name(to.place.index()))
        }
        Some(DraftKind::Behavior(Kind::Pick { object, .. })) => {
            format!("pick {}", objects.name(object.index()))
        }
        Some(DraftKind::Behavior(Kind::Place { object, .. })) => {
            format!("place {}", objects.name(object.index()))
        }
        Some(DraftKind::Root | DraftKind::And | DraftKind::Or | DraftKind::Then) | None => "node".to_owned(),
    }
}
