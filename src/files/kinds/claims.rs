//! The claims of a behavior on the resources of a robot, and whether the robot can ever serve them together.

use super::bind::Bound;
use super::terms::{ClaimTarget, ClaimTerm, Filter, KeepTerm};
use super::{Claims, NameOrParam};
use crate::types::Type;
use ambidex_model::{Access, Claim, ControllerKind, ResourceId, Retention, Selector, TypeId, match_claims, suggestion};

impl Bound<'_, '_> {
    pub(super) fn claims(&mut self) -> Option<Vec<Claim>> {
        let kind = self.kind;
        let terms = match &kind.claims {
            Claims::All => {
                let whole = |resource| Claim {
                    selector: Selector::Named(resource),
                    access: Access::Exclusive,
                    keep: Retention::Release,
                };
                return Some((0..self.robot().resources.len()).map(|index| whole(index.into())).collect());
            }
            Claims::Some(terms) => terms,
        };
        let mut claims = Vec::new();
        for (_, term) in terms {
            let claim = self.claim(term);
            self.claims.push(claim.is_some().then_some(claims.len()));
            claims.extend(claim);
        }
        Some(claims)
    }

    /// A claim on the robot; none where the robot has no such resource, which is a fault unless it is optional.
    pub(super) fn claim(&mut self, term: &ClaimTerm) -> Option<Claim> {
        let selector = self.selector(term)?;
        let access = match &term.shared {
            Some(text) => Access::Shared(self.channel(text)),
            None => Access::Exclusive,
        };
        let keep = match &term.keep {
            KeepTerm::Release => Retention::Release,
            KeepTerm::Physical => Retention::Physical(access),
            KeepTerm::For(text) => Retention::Intention(Access::Shared(self.channel(text))),
        };
        Some(Claim { selector, access, keep })
    }

    pub(super) fn selector(&mut self, term: &ClaimTerm) -> Option<Selector> {
        let (of, named) = match &term.target {
            ClaimTarget::Type(name) => {
                let of = self.ty(name, term.is_optional)?;
                let mut all = self.robot().of_type(of);
                (of, all.next().filter(|_| all.next().is_none()))
            }
            ClaimTarget::Resource(name) => {
                let resource = self.resource(name, term.is_optional)?;
                (self.robot().resources[resource.index()].ty, Some(resource))
            }
        };
        let is_named = matches!(term.target, ClaimTarget::Resource(_));
        let reaches = match term.filter() {
            Filter::Holds(name) => {
                let resource = named.filter(|_| is_named);
                return self.object(name).map(|object| Selector::Holding { object, of, resource });
            }
            // The only one of a type is as good as its name, and tells who holds it.
            Filter::Any => return Some(named.map_or(Selector::Any(of), Selector::Named)),
            Filter::Empty => None,
            Filter::Reaches(name) => Some(self.object(name)?),
        };
        Some(match named.filter(|_| is_named) {
            Some(resource) => Selector::Empty { resource, reaches },
            None => Selector::AnyEmpty { of, reaches },
        })
    }

    pub(super) fn ty(&mut self, name: &NameOrParam, is_optional: bool) -> Option<TypeId> {
        let names = &self.binder.known.robot?.types;
        let found = self.found_type(name);
        if found.is_none() && !is_optional {
            let message = format!("the robot has no resource of type `{}`", name.written.value);
            let help = || suggestion(&name.written.value, "type", names.names().iter().map(String::as_str));
            self.faults.push_with((self.site.span, &self.kind.name.value), message, help);
        }
        found
    }

    /// The type that a name names, if the robot has it.
    fn found_type(&self, name: &NameOrParam) -> Option<TypeId> {
        match name.parameter {
            None => self.binder.known.robot?.types.id(&name.written.value).map(TypeId::from),
            Some(index) => self.arguments[index].as_ref()?.value.ty(),
        }
    }

    pub(super) fn resource(&mut self, name: &NameOrParam, is_optional: bool) -> Option<ResourceId> {
        let names = &self.binder.known.robot?.resources;
        let is_lacking = name.parameter.is_none() && names.id(&name.written.value).is_none();
        if is_lacking && is_optional {
            return None;
        }
        self.meaning(name, Type::Resource)?.resource()
    }

    /// Whether a claim may be served by the gripper of an arm.
    pub(super) fn is_hand(&self, claim: &Claim) -> bool {
        let robot = self.robot();
        let mover = |id: ResourceId| robot.resources[id.index()].controller;
        let kind = |id: ResourceId| mover(id).map(|controller| robot.controllers[controller.index()].kind);
        robot.could_serve(claim.selector).into_iter().any(|id| matches!(kind(id), Some(ControllerKind::Arm(_))))
    }

    pub(super) fn claim_name(&self, claim: usize) -> &str {
        let Claims::Some(terms) = &self.kind.claims else {
            return "all";
        };
        let declared = self.claims.iter().position(|at| *at == Some(claim));
        declared.map_or("?", |declared| terms[declared].0.value.as_str())
    }

    /// Claims that this robot can never serve together.
    pub(super) fn check_claims(&mut self, claims: &[Claim]) {
        let robot = self.robot();
        let possible: Vec<_> = claims.iter().map(|claim| robot.could_serve(claim.selector)).collect();
        let Err(lacking) = match_claims(&possible) else { return };
        let types = &self.binder.known.robot.map(|names| names.types.names()).unwrap_or_default();
        let mut counts = vec![0_usize; types.len()];
        for first in possible.iter().filter_map(|possible| possible.first()) {
            counts[robot.resources[first.index()].ty.index()] += 1;
        }
        let has = |ty: usize| robot.of_type(ty.into()).count();
        let short = (0..types.len()).find(|&ty| counts[ty] > has(ty));
        let message = match short {
            Some(ty) => format!("it claims {} of type `{}`; the robot has {}", counts[ty], types[ty], has(ty)),
            None => format!("its claim `{}` can only get what another one claims too", self.claim_name(lacking)),
        };
        self.faults.push((self.kind.name.span, &self.kind.name.value), message);
    }
}
