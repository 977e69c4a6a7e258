//! Behaviors can be run in some order to the end, whatever each keeps.

use ambidex_core::tree::{Unfinishable, can_finish};

use super::{Seen, TOP};
use crate::fault::Faults;

pub(super) fn check(seen: &Seen<'_>, faults: &mut Faults) {
    let Err(Unfinishable { waiting, needs, kept }) = can_finish(seen.mission) else { return };
    let names = &seen.mission.names;
    let kept: Vec<String> = kept
        .iter()
        .map(|(resource, keeper)| format!("{} is kept by `{}`", names.resource(*resource), names.node(*keeper)))
        .collect();
    let message = format!(
        "it can be finished in no order: `{}` needs {needs} at once, and in the end {}",
        names.node(waiting),
        kept.join(", ")
    );
    seen.warn(TOP, message, "give some back in between, as `place` does", faults);
}
