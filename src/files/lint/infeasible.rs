//! Every behavior can run at some time, as far as that can be seen before the mission begins.

use super::{Part, Seen};
use crate::fault::Faults;
use ambidex_core::tree::infeasible_at_start;
use ambidex_model::Reason;

pub(super) fn check(seen: &Seen<'_>, faults: &mut Faults) {
    let names = &seen.mission.names;
    let (by_nobody, nothing) = match seen.part {
        Part::Mission | Part::Branch => ("", "nothing in the task makes it so: it fails as the mission begins"),
        Part::Task => (" here", "nothing in the task makes it so: unless another task does, it fails as it begins"),
    };
    for (leaf, reason) in infeasible_at_start(seen.mission) {
        let (message, help) = match reason {
            Reason::Fact { fact, holds } => {
                let verb = if holds { "sets" } else { "clears" };
                let message =
                    format!("it can never run: no behavior{by_nobody} that can run {verb} \"{}\"", names.fact(fact));
                (
                    message,
                    "see `facts` of the world (`outside: true` where others set it) and `effects` of the behaviors",
                )
            }
            Reason::Unreachable { is_shut: false, .. } => {
                let message = format!("it can never run: {}", reason.sentence(names));
                (message, "see `stand` and `surface` of the place, and `reach` and `shoulder` of the arms")
            }
            // Of these others tell more.
            Reason::Missing { .. } | Reason::TooFew { .. } => continue,
            other => {
                let message = format!("it can never run: {}", other.sentence(names));
                (message, nothing)
            }
        };
        seen.warn(leaf, message, help, faults);
    }
}
