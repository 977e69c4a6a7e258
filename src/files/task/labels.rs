//! What nodes are called: as written, else after what they are; no name comes twice.

use std::collections::{BTreeMap, BTreeSet};

use super::node::{AND, CLEANUP, NAME, OR, THEN};
use super::{Draft, DraftKind};
use crate::fault::Faults;

/// What stands above every task.
pub(crate) const ROOT: &str = "root";

/// Gives every node a name of its own, in preorder.
pub(super) fn label(drafts: &[Draft], faults: &mut Faults) -> Vec<String> {
    let mut taken = BTreeSet::from([ROOT.to_owned()]);
    // What stands in a subtree is used as often as the subtree is, so its names are only wishes.
    for name in drafts.iter().filter(|draft| !draft.is_used).filter_map(|draft| draft.name.as_ref()) {
        if !taken.insert(name.value.clone()) {
            let message = match name.value.as_str() {
                ROOT => format!("`{ROOT}` is what stands above every task"),
                other => format!("another node is called `{other}`"),
            };
            faults.push_with((name.span, NAME), message, "choose another name");
        }
    }
    let mut words = BTreeMap::new();
    for draft in drafts {
        *words.entry(composite(draft)).or_insert(0) += 1;
    }
    let mut numbers = BTreeMap::new();
    // What has a cleanup is called after its body, which stands right behind it.
    let of_body = |index: usize| {
        let body = drafts.get(index + 1).filter(|_| matches!(drafts[index].kind, Some(DraftKind::Cleanup)));
        body.and_then(|body| body.name.as_ref()).map(|name| format!("{} with cleanup", name.value))
    };
    let name = |(index, draft): (usize, &Draft)| {
        let written = draft.name.as_ref().map(|name| &name.value);
        if let Some(name) = written.filter(|_| !draft.is_used) {
            return name.clone();
        }
        let own = written.cloned().or_else(|| of_body(index));
        let is_called = own.is_some();
        let plain = own.or_else(|| composite(draft).map(str::to_owned)).unwrap_or_else(|| draft.label());
        let is_numbered = !is_called && composite(draft).is_some() && words.get(&composite(draft)) > Some(&1);
        let number = numbers.entry(plain.clone()).or_insert(0);
        unused(&plain, is_numbered, number, &mut taken)
    };
    drafts.iter().enumerate().map(name).collect()
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
    match draft.kind.as_ref()? {
        DraftKind::And => Some(AND),
        DraftKind::Or => Some(OR),
        DraftKind::Then => Some(THEN),
        DraftKind::Cleanup => Some(CLEANUP),
        DraftKind::Behavior(_) => None,
    }
}
