//! What controllers may report, as far as a mission has it: what is misspelt, or could never be taken.

use crate::fault::Faults;
use crate::names::Register;
use crate::reader::Name;
use crate::world::WorldNames;
use ambidex_model::{FactId, WorldSpec};

/// Facts and objects that controllers may report, as they are written.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Reported {
    pub(crate) facts: Vec<Name>,
    pub(crate) objects: Vec<Name>,
}

/// Warns of names that are nearly those of the mission, and of facts that others may not change. Names that are quite
/// different are for other missions.
pub(crate) fn check(reported: &Reported, names: &WorldNames, world: &WorldSpec, faults: &mut Faults) {
    for name in &reported.facts {
        match names.facts.id(&name.value) {
            Some(fact) if !world.is_outside(FactId::from(fact)) => {
                let message = format!("`{}` is reported, and the mission does not declare it `outside`", name.value);
                let help = format!(
                    "write `facts: {{{}: {{outside: true}}}}` in the mission, or nobody hears of it",
                    name.value
                );
                faults.warn(name, message, Some(help));
            }
            Some(_) => {}
            None => suspect(name, &names.facts, faults),
        }
    }
    reported.objects.iter().for_each(|name| suspect(name, &names.objects, faults));
}

fn suspect(name: &Name, known: &Register, faults: &mut Faults) {
    if known.id(&name.value).is_none()
        && let Some(meant) = known.meant(&name.value)
    {
        faults.warn(name, known.lacks(&name.value), Some(meant));
    }
}
