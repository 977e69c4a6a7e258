//! Objects in several hands (`semantics` 2, "Objects in several hands").

use std::collections::BTreeSet;

use ambidex::model::{
    BehaviorSpec, Claim, EffectTerm, HeldBy, Hold, Misheld, NodeId, NodeRange, Reason, ResourceId, Selector, Task,
};

use super::{Model, Refusal};

impl Model<'_> {
    /// All that count for a condition and hold its object.
    pub(super) fn holding(&self, hold: &Hold) -> Vec<ResourceId> {
        let all = self.world_state.objects[hold.object.index()].holders().iter().copied();
        let counts = |id: &ResourceId| match hold.by {
            HeldBy::Any => true,
            HeldBy::Type(of) => self.of_type(of).contains(id),
            HeldBy::Resource(only) => *id == only,
        };
        all.filter(counts).collect()
    }

    /// What holds what a claim wants held and would do for it.
    pub(super) fn holders_for(&self, selector: Selector) -> Vec<ResourceId> {
        let Selector::Holding { object, of, resource } = selector else { return Vec::new() };
        let by = resource.map_or(HeldBy::Type(of), HeldBy::Resource);
        self.holding(&Hold { object, by, hands: 1, alone: false })
    }

    /// Why nothing serves a claim on what holds an object.
    pub(super) fn no_holder(&self, selector: Selector) -> Reason {
        let Selector::Holding { object, of, resource } = selector else { unreachable!("it wants a holder") };
        if self.world_state.objects[object.index()].holders().is_empty() {
            return Reason::NotHeld { object };
        }
        let by = resource.map_or(HeldBy::Type(of), HeldBy::Resource);
        Reason::Misheld(Misheld::NotSo { hold: Hold { object, by, hands: 1, alone: false }, found: 0 })
    }

    /// What is put down is let go by all that hold it, and what is let go is held by others still.
    pub(super) fn let_go(&self, spec: &BehaviorSpec, leaf: NodeId, skips: &[NodeRange]) -> Result<(), Refusal> {
        for &object in &spec.changes {
            let holders = self.world_state.objects[object.index()].holders().to_vec();
            if holders.is_empty() {
                continue;
            }
            let is_for = |claim: &Claim| matches!(claim.selector, Selector::Holding { object: of, .. } if of == object);
            if spec.effects.iter().any(|effect| matches!(effect, EffectTerm::Lies(put, _) if *put == object)) {
                let mut left: Vec<_> = holders.iter().copied().filter(|id| !self.is_put_by_name(spec, *id)).collect();
                let spare = spec.claims.iter().filter(|claim| is_for(claim)).count();
                if left.len() > spare {
                    let is_strange = |id: &ResourceId| {
                        let leases = &self.rows[id.index()].leases;
                        !leases.is_empty() && !leases.iter().any(|held| self.is_own(leaf, skips, held.holder))
                    };
                    let last = left.pop().expect("one is left");
                    let by = left.into_iter().chain([last]).find(is_strange).unwrap_or(last);
                    return Err(Reason::Misheld(Misheld::Too { object, by }).into());
                }
                continue;
            }
            let is_holder = |claim: usize| {
                let named = |id: &ResourceId| spec.claims[claim].selector == Selector::Named(*id);
                is_for(&spec.claims[claim]) || holders.iter().any(named)
            };
            let claims = 0..spec.claims.len();
            let more = claims
                .clone()
                .filter(|claim| !is_holder(*claim) && spec.effects.contains(&EffectTerm::Taken(object, *claim)));
            let fewer =
                claims.filter(|claim| is_holder(*claim) && spec.effects.contains(&EffectTerm::LetGo(object, *claim)));
            let (more, fewer) = (more.count(), fewer.count());
            if holders.len() + more <= fewer {
                return Err(Reason::Misheld(Misheld::Last { object }).into());
            }
            if more > 0 && holders.len() + more - fewer > 4 {
                return Err(Reason::Misheld(Misheld::Full { object }).into());
            }
        }
        Ok(())
    }

    /// Whether a behavior claims a resource by its name, and tells it to let go if an arm moves it.
    fn is_put_by_name(&self, spec: &BehaviorSpec, id: ResourceId) -> bool {
        let mut claims = (0..spec.claims.len()).filter(|claim| spec.claims[*claim].selector == Selector::Named(id));
        let tells = |claim: usize| {
            let mut tasks = spec.commands.iter().filter(|term| term.claim == claim).map(|term| &term.task);
            tasks.any(|task| matches!(task, Task::Put(..) | Task::PutInto(..) | Task::Call(_)))
        };
        claims.any(|claim| self.mission.robot.arm(id).is_none() || tells(claim))
    }
}

/// Fewer hold an object than claims want one that does.
pub(super) fn too_few_holders(claims: &[Claim], serving: &[Vec<(ResourceId, f64)>], short: usize) -> Option<Reason> {
    let Selector::Holding { object, of, .. } = claims[short].selector else { return None };
    let is_for = |claim: &Claim| matches!(claim.selector, Selector::Holding { object: other, .. } if other == object);
    let wanting: Vec<_> = (0..claims.len()).filter(|index| is_for(&claims[*index])).collect();
    let holders: BTreeSet<_> = wanting.iter().flat_map(|index| &serving[*index]).map(|(id, _)| *id).collect();
    let (hands, found) = (wanting.len() as u32, holders.len() as u32);
    (found < hands).then_some(Reason::Misheld(Misheld::NotSo {
        hold: Hold { object, by: HeldBy::Type(of), hands, alone: false },
        found,
    }))
}
