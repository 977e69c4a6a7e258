//! What was done: nothing is done again while its goal has held all the time.

use std::collections::BTreeMap;

use ambidex_model::{
    Cause, Condition, End, Hold, Location, MissionSpec, NodeId, ObjectId, Record, Reopened, WorldState,
};

use super::run::Run;
use super::{Found, LookedAt, Rule};

/// Behaviors that were done and whose goal has held ever since.
#[derive(Debug, Default)]
pub(super) struct Twice {
    held: BTreeMap<NodeId, Condition>,
    /// Those that just ended, whose goals are looked at once the world is as they left it.
    fresh: Vec<(NodeId, Condition)>,
}

impl Twice {
    pub(super) fn take(&mut self, run: &Run, record: &Record, found: &mut Found, looked_at: &mut LookedAt) {
        if let Record::Decided { granted, reopened, .. } = record {
            for leaf in granted.iter().map(|grant| grant.leaf()) {
                if self.held.remove(&leaf).is_some() {
                    let name = run.name(leaf);
                    let said = format!("{name} is granted again, and its goal has held since it was done");
                    found.push(Rule::Twice, said);
                }
            }
            reopened.iter().for_each(|reopened| self.reopen(run, reopened));
        } else if let Record::Reopened { reopened, .. } = record {
            self.reopen(run, reopened);
        } else if let Record::Cleaning { node, .. } = record {
            // What is cleaned up is cleaned up once more when the node fails again.
            self.forget(run, *node);
        } else if let Record::Released { leaf, end: End::Succeeded, .. } = record {
            let spec = run.running.get(leaf).and_then(|grant| run.behavior(grant));
            if let Some(goal) = spec.map(|spec| &spec.satisfied).filter(|goal| can_be_looked_at(goal)) {
                looked_at.goals += 1;
                self.fresh.push((*leaf, goal.clone()));
            }
        }
    }

    /// The world is as the last record left it.
    pub(super) fn look(&mut self, run: &Run) {
        let Some(mission) = &run.mission else { return };
        self.held.extend(self.fresh.drain(..));
        self.held.retain(|_, goal| holds(goal, mission, &run.world));
    }

    fn reopen(&mut self, run: &Run, reopened: &Reopened) {
        match reopened.cause {
            // A new iteration does everything again; a later behavior needs more than the goal says.
            Cause::Repeat { .. } => self.forget(run, reopened.node),
            Cause::Redo { .. } => drop(self.held.remove(&reopened.node)),
            Cause::Lapse { .. } | Cause::Leave | Cause::Retry { .. } | Cause::Yield => {}
        }
    }

    fn forget(&mut self, run: &Run, top: NodeId) {
        if run.is_known(top) {
            self.held.retain(|leaf, _| !run.topology.is_within(*leaf, top));
        }
    }
}

/// Whether the world alone says whether it holds.
fn can_be_looked_at(goal: &Condition) -> bool {
    match goal {
        Condition::All(parts) => !parts.is_empty() && parts.iter().all(can_be_looked_at),
        Condition::Never | Condition::Path { .. } => false,
        Condition::At { .. } | Condition::Held(_) | Condition::Free(_) | Condition::Somewhere(_) => true,
        Condition::Lies(..) | Condition::Fact(..) => true,
    }
}

/// Whether a goal holds, whoever has what is held.
fn holds(goal: &Condition, mission: &MissionSpec, world: &WorldState) -> bool {
    let is_free = |object: &ObjectId| world.objects[object.index()].holders().is_empty();
    match goal {
        Condition::All(parts) => parts.iter().all(|part| holds(part, mission, world)),
        Condition::Never | Condition::Path { .. } => false,
        Condition::At { stands, tolerance_m, .. } => {
            stands.iter().any(|stand| world.base.distance_m(stand) <= *tolerance_m)
        }
        Condition::Held(hold) => is_held(*hold, mission, world),
        Condition::Free(object) => is_free(object),
        Condition::Somewhere(object) => matches!(world.objects[object.index()], Location::At(_)),
        Condition::Lies(object, place) => world.objects[object.index()] == Location::At(*place),
        Condition::Fact(fact, so) => world.facts.get(fact.index()) == Some(so),
    }
}

fn is_held(hold: Hold, mission: &MissionSpec, world: &WorldState) -> bool {
    let holders = world.objects[hold.object.index()].holders();
    let counted = holders.iter().filter(|holder| mission.robot.counts(hold.by, **holder)).count();
    counted >= hold.hands as usize && (!hold.alone || counted == holders.len())
}
