//! What a behavior takes, lets go and puts down: held by what can hold it, told to whom it concerns, and never by nobody.

use super::bind::Bound;
use super::hands::{Grasped, HeldTerm, ObjectBy, PutTerm, PutTo};
use super::terms::Effect;
use super::{Claims, NameOrParam};
use crate::reader::Written;
use ambidex_model::{
    BehaviorSpec, Claim, Condition, ControllerKind, EffectTerm, HOLDERS_MAX, HeldBy, Hold, ObjectId, Selector, Task,
};

impl Bound<'_, '_> {
    pub(super) fn hold(&mut self, term: &HeldTerm) -> Option<Hold> {
        let by = match (&term.of, &term.resource) {
            (Some(of), _) => HeldBy::Type(self.ty(of, false)?),
            (None, Some(resource)) => HeldBy::Resource(self.resource(resource, false)?),
            (None, None) => HeldBy::Any,
        };
        Some(Hold { object: self.object(&term.object)?, by, hands: term.hands, alone: term.alone })
    }

    /// What is taken, and from what: the claim there is for what holds it.
    pub(super) fn grasp(&mut self, term: &Written<Grasped>, own: usize, claims: &[Claim]) -> Option<Task> {
        let (object, from) = match &term.value {
            Grasped::Lying(object) => return self.object(object).map(Task::Grasp),
            Grasped::From(object, from) => (object, self.claims[*from]?),
        };
        let Selector::Holding { object: held, .. } = claims[from].selector else {
            let name = self.claim_name(from).to_owned();
            let help = format!("write `holds:` and the object in the claim `{name}`");
            self.faults.push_with(term, format!("`{name}` is no claim on what holds an object"), help);
            return None;
        };
        if let Some(object) = object
            && self.object(object)? != held
        {
            let name = self.claim_name(from).to_owned();
            self.faults.push(&object.written, format!("the claim `{name}` holds another object"));
            return None;
        }
        self.check_other(term, own, from, claims).then_some(Task::GraspFrom(held, from))
    }

    pub(super) fn put(&mut self, term: &Written<PutTerm>, own: usize, claims: &[Claim]) -> Option<Task> {
        let PutTerm { object, to } = &term.value;
        match to {
            PutTo::At(place) => Some(Task::Put(self.object(object)?, self.place(place)?)),
            PutTo::Into(claim) => {
                let (object, into) = (self.object(object)?, self.claims[*claim]?);
                self.check_other(term, own, into, claims).then_some(Task::PutInto(object, into))
            }
        }
    }

    /// Whether the resources of a claim are others than a hand's own, and have a place where something can be.
    fn check_other<T>(&mut self, at: &Written<T>, own: usize, other: usize, claims: &[Claim]) -> bool {
        let name = self.claim_name(other).to_owned();
        if own == other {
            self.faults.push(at, format!("`{name}` is the hand itself"));
            return false;
        }
        let robot = self.robot();
        let all = robot.could_serve(claims[other].selector);
        let Some(lost) = all.into_iter().find(|id| robot.carried_at(*id).is_none()) else { return true };
        let resource = self.resource_name(lost.index());
        let (message, help) = match robot.resources[lost.index()].controller {
            Some(_) => (format!("`{resource}` holds nothing, since no arm moves it"), "claim a gripper or a slot"),
            None => (
                format!("nothing tells where `{resource}` is"),
                "give it a position in the robot file: `at: [x, y, z]`, in the frame of the base",
            ),
        };
        self.faults.push_with(at, message, help);
        false
    }

    fn resource_name(&self, index: usize) -> String {
        self.binder.robot.names.resources.get(index).cloned().unwrap_or_default()
    }

    /// What is taken is held by what could take it, whoever holds it hears of it, and what is let go does not fall.
    pub(super) fn check_holders(&mut self, behavior: &BehaviorSpec) {
        let kind = self.kind;
        for term in &kind.effects {
            match term {
                Effect::Taken(taken) => {
                    self.check_can_hold(taken, behavior);
                    self.check_told(taken, behavior, false);
                }
                Effect::LetGo(let_go) => {
                    self.check_can_hold(let_go, behavior);
                    self.check_told(let_go, behavior, true);
                    self.check_last(let_go, behavior);
                }
                Effect::Lies(lies) => {
                    let Some(object) = self.object(&lies.value.object) else { continue };
                    let place = lies.value.place.written.value.clone();
                    for (index, claim) in behavior.claims.iter().enumerate() {
                        let held = matches!(claim.selector, Selector::Holding { object: held, .. } if held == object);
                        if held && self.is_untold(index, object, behavior, true) {
                            let put = format!("put: {{object: {}, at: {place}}}", lies.value.object.written.value);
                            self.tell_untold(lies, &lies.value.object, index, behavior, &put);
                        }
                    }
                }
                Effect::Set(_) | Effect::Clear(_) => {}
            }
        }
        self.check_count(behavior);
    }

    fn check_can_hold(&mut self, term: &Written<ObjectBy>, behavior: &BehaviorSpec) {
        let Some(claim) = self.claims[term.value.claim] else { return };
        let (name, word) = match self.controller(&behavior.claims[claim]) {
            Some((name, ControllerKind::Base(_))) => (name, "a base"),
            Some((name, ControllerKind::Head(_))) => (name, "a head"),
            Some((name, ControllerKind::Device)) => (name, "a device"),
            Some((_, ControllerKind::Arm(_))) | None => return,
        };
        self.faults.push(term, format!("controller `{name}` moves {word}, which cannot hold what is taken"));
    }

    fn check_told(&mut self, term: &Written<ObjectBy>, behavior: &BehaviorSpec, is_let_go: bool) {
        let Some(claim) = self.claims[term.value.claim] else { return };
        let Some(object) = self.object(&term.value.object) else { return };
        if self.is_untold(claim, object, behavior, is_let_go) {
            let what = &term.value.object.written.value;
            let task = match is_let_go {
                true => format!("put: {{object: {what}, into: {}}}", self.other_claim(claim)),
                false => format!("grasp: {what}"),
            };
            self.tell_untold(term, &term.value.object, claim, behavior, &task);
        }
    }

    /// Whether an arm moves the resource of a claim and hears nothing of what it takes or lets go.
    fn is_untold(&self, claim: usize, object: ObjectId, behavior: &BehaviorSpec, is_let_go: bool) -> bool {
        let is_arm = matches!(self.controller(&behavior.claims[claim]), Some((_, ControllerKind::Arm(_))));
        let mut tasks = behavior.commands.iter().filter(|term| term.claim == claim).map(|term| &term.task);
        is_arm
            && !tasks.any(|task| {
                let handled = if is_let_go { task.put() } else { task.grasped() };
                handled == Some(object) || matches!(task, Task::Call(_))
            })
    }

    fn tell_untold<T>(
        &mut self,
        at: &Written<T>,
        object: &NameOrParam,
        claim: usize,
        behavior: &BehaviorSpec,
        task: &str,
    ) {
        let controller = self.controller(&behavior.claims[claim]).map(|(name, _)| name).unwrap_or_default();
        let (object, claim) = (&object.written.value, self.claim_name(claim).to_owned());
        let message = format!("controller `{controller}` of the claim `{claim}` hears nothing of `{object}`");
        self.faults.push_with(at, message, format!("add to `commands`: `{{claim: {claim}, achieve: {{{task}}}}}`"));
    }

    /// The name of another claim, as an example.
    fn other_claim(&self, claim: usize) -> String {
        let Claims::Some(terms) = &self.kind.claims else { return "CLAIM".into() };
        let own = self.claim_name(claim);
        let other = terms.iter().find(|(name, term)| name.value != own && term.holds.is_some());
        other.map_or("CLAIM".into(), |(name, _)| name.value.clone())
    }

    /// What is let go is held by something else then: by what another claim is on, or by as many as a precondition says.
    fn check_last(&mut self, term: &Written<ObjectBy>, behavior: &BehaviorSpec) {
        let Some(object) = self.object(&term.value.object) else { return };
        let lets_go = |claim: usize| behavior.effects.contains(&EffectTerm::LetGo(object, claim));
        let keeps = |(index, claim): (usize, &Claim)| {
            let holds = matches!(claim.selector, Selector::Holding { object: held, .. } if held == object);
            !lets_go(index) && (holds || behavior.effects.contains(&EffectTerm::Taken(object, index)))
        };
        let count = (0..behavior.claims.len()).filter(|claim| lets_go(*claim)).count();
        let is_put_down =
            behavior.effects.iter().any(|effect| matches!(effect, EffectTerm::Lies(put, _) if *put == object));
        let is_kept = behavior.claims.iter().enumerate().any(keeps) || hands(&behavior.precondition, object) > count;
        if !is_kept && !is_put_down {
            let name = &term.value.object.written.value;
            let help = format!(
                "claim what holds it too, write `held: {{object: {name}, hands: {}}}` as a precondition, or put it down \
                 with `lies`",
                count + 1
            );
            self.faults.push_with(term, format!("nothing need hold `{name}` then, so that it could fall"), help);
        }
    }

    fn check_count(&mut self, behavior: &BehaviorSpec) {
        for &object in &behavior.changes {
            let taken =
                behavior.effects.iter().filter(|effect| matches!(effect, EffectTerm::Taken(of, _) if *of == object));
            if taken.count() > HOLDERS_MAX {
                let message = format!("at most {HOLDERS_MAX} hold one object");
                self.faults.push((self.kind.name.span, &self.kind.name.value), message);
            }
        }
    }
}

/// How many hold an object at least, as a precondition says.
fn hands(condition: &Condition, object: ObjectId) -> usize {
    match condition {
        Condition::All(parts) => parts.iter().map(|part| hands(part, object)).max().unwrap_or(0),
        Condition::Held(hold) if hold.object == object => hold.hands as usize,
        Condition::Held(_) | Condition::Free(_) | Condition::Somewhere(_) | Condition::Lies(..) => 0,
        Condition::Never | Condition::At { .. } | Condition::Path { .. } | Condition::Fact(..) => 0,
    }
}
