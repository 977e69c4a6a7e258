//! What one behavior sees: conditions, potential, reach, and the resources that would serve it.

use std::sync::Arc;

use ambidex::model::{
    ArmSpec, BehaviorSpec, Claim, Condition, ControllerKind, Grant, HeldBy, LeaseKind, Location, Loss, Misheld, NodeId,
    NodeRange, ObjectId, PlaceId, Pose, Potential, Reason, Request, ResourceId, Selector, Task, TypeId,
};

use super::holding::too_few_holders;
use super::{Ask, Model, Refusal};

type Serving = Vec<(ResourceId, f64)>;

impl Model<'_> {
    pub(super) fn behavior(&self, leaf: NodeId) -> &BehaviorSpec {
        self.mission.tree.behavior(leaf).expect("a leaf")
    }

    pub(super) fn held_object(&self, gripper: ResourceId) -> Option<ObjectId> {
        let objects = &self.world_state.objects;
        let index = objects.iter().position(|at| at.holders().contains(&gripper))?;
        Some(ObjectId::from(index))
    }

    pub(super) fn is_satisfied(&self, leaf: NodeId, skips: &[NodeRange]) -> bool {
        self.unmet(&self.behavior(leaf).satisfied, leaf, skips).is_none()
    }

    /// The request of a leaf whose goal is not met, or the first thing that is wrong.
    /// A wish is what it would ask for without what runs and without idle leases for intentions of who is less urgent.
    pub(super) fn request(&self, leaf: NodeId, skips: &[NodeRange], is_wish: bool) -> Result<Ask, Refusal> {
        let spec = self.behavior(leaf);
        if let Some(refusal) = self.unmet(&spec.precondition, leaf, skips) {
            return Err(refusal);
        }
        let potential = self.potential(&spec.potential, leaf, skips)?;
        for &object in &spec.changes {
            let mut others = self.running.values().filter(|_| !is_wish);
            if let Some(other) = others.find(|other| other.request.changes.contains(&object)) {
                let with = other.leaf();
                return Err(on(Reason::SameObject { object, with }, with));
            }
        }
        for term in &spec.commands {
            if let Task::Grasp(object) = term.task
                && !matches!(self.world_state.objects[object.index()], Location::At(_))
            {
                return Err(Reason::OutOfReach { object }.into());
            }
        }
        self.let_go(spec, leaf, skips)?;
        let mut serving: Vec<Serving> = Vec::new();
        for claim in &spec.claims {
            let mut found = self.serving(claim, leaf, skips, is_wish)?;
            // Worse than anything that is only far away.
            found.iter_mut().filter(|(id, _)| self.bad.contains(&(leaf, *id))).for_each(|(_, cost)| *cost += 1e6);
            serving.push(found);
        }
        if let Some(short) = first_short(spec.claims.len(), &serving)
            && let Some(reason) = too_few_holders(&spec.claims, &serving, short - 1)
        {
            return Err(reason.into());
        }
        self.all_at_once(&spec.claims, &serving)?;
        let is_heir = self
            .rows
            .iter()
            .flat_map(|row| &row.leases)
            .any(|held| held.kind == LeaseKind::Intention && self.is_own(leaf, skips, held.holder));
        Ok(Ask {
            grant: Grant {
                request: Arc::new(Request {
                    leaf,
                    priority: self.priority(leaf),
                    iterations: self.iterations(leaf),
                    potential,
                    heir: is_heir,
                    claims: Vec::new(),
                    changes: spec.changes.clone(),
                    skips: skips.to_vec(),
                    place: None,
                    stand: None,
                    spots: Vec::new(),
                    distance: None,
                }),
                bindings: Vec::new(),
                met: Vec::new(),
                way: Vec::new(),
            },
            is_heir,
            is_overdue: self.is_overdue(leaf),
            wish: is_wish.then(|| self.preferences(leaf, skips, &serving)),
            serving,
        })
    }

    /// What is not so of a condition.
    pub(super) fn unmet(&self, condition: &Condition, leaf: NodeId, skips: &[NodeRange]) -> Option<Refusal> {
        let whereabouts = |object: &ObjectId| self.world_state.objects[object.index()];
        let (is_met, reason) = match condition {
            Condition::All(parts) => {
                return parts.iter().find_map(|part| self.unmet(part, leaf, skips));
            }
            Condition::Never => (false, Reason::NotItsTurn { after: leaf }),
            Condition::At { place, stands, tolerance_m } => {
                if let Some(by) = self.driver() {
                    return Some(on(Reason::Driving { by }, by));
                }
                let is_near = stands.iter().any(|stand| distance_m(self.world_state.base, *stand) <= *tolerance_m);
                (is_near, Reason::NotAt { place: *place })
            }
            Condition::Path { place, stands } => {
                (stands.iter().any(|stand| self.is_clear(*stand)), Reason::NoPath { place: *place })
            }
            Condition::Held(hold) => {
                let is_own = |gripper: &ResourceId| {
                    let leases = &self.rows[gripper.index()].leases;
                    leases.is_empty() || leases.iter().any(|held| self.is_own(leaf, skips, held.holder))
                };
                let is_alone = !hold.alone || self.holding(hold).len() == whereabouts(&hold.object).holders().len();
                let found = self.holding(hold).into_iter().filter(is_own).count() as u32;
                let is_plain = hold.by == HeldBy::Any && hold.hands == 1 && !hold.alone;
                let reason = if is_plain {
                    Reason::NotHeld { object: hold.object }
                } else {
                    Reason::Misheld(Misheld::NotSo { hold: *hold, found })
                };
                (found >= hold.hands && is_alone, reason)
            }
            Condition::Free(object) => match whereabouts(object).holders().first() {
                Some(&by) => (false, Reason::Taken { object: *object, by }),
                None => return None,
            },
            Condition::Somewhere(object) => match whereabouts(object) {
                Location::At(_) => return None,
                Location::In(by) => (false, Reason::Taken { object: *object, by: by.as_slice()[0] }),
                Location::Unknown => (false, Reason::Nowhere { object: *object }),
            },
            Condition::Lies(object, place) => {
                let is_there = whereabouts(object) == Location::At(*place);
                (is_there, Reason::Elsewhere { object: *object, place: *place })
            }
            Condition::Fact(fact, holds) => {
                let is_so = self.world_state.facts[fact.index()] == *holds;
                (is_so, Reason::Fact { fact: *fact, holds: *holds })
            }
        };
        (!is_met).then(|| reason.into())
    }

    /// The first single condition of a leaf's precondition that is not met, with the reason.
    pub(super) fn lacking(&self, leaf: NodeId) -> Option<(Condition, Reason)> {
        let parts = singles(&self.behavior(leaf).precondition);
        parts.into_iter().find_map(|part| Some((part.clone(), self.unmet(part, leaf, &[])?.reason)))
    }

    /// Whether a leaf still lacks something that a behavior makes so.
    pub(super) fn lacks_what(&self, leaf: NodeId, maker: NodeId) -> bool {
        let parts = singles(&self.behavior(leaf).precondition);
        let mut unmet = parts.into_iter().filter(|part| self.unmet(part, leaf, &[]).is_some());
        unmet.any(|part| self.promises(maker, part))
    }

    fn driver(&self) -> Option<NodeId> {
        let mut running = self.running.keys().copied();
        running.find(|&leaf| {
            let commands = &self.behavior(leaf).commands;
            commands.iter().any(|term| matches!(term.task, Task::DriveTo(..)))
        })
    }

    /// The boxes of the generated worlds stand around stands only, and no two stands have a third between them.
    pub(super) fn is_clear(&self, stand: Pose) -> bool {
        self.mission.world.obstacles.iter().all(|solid| {
            let inside = |axis: usize| (stand.at[axis] - solid.middle[axis]).abs() <= solid.size[axis] / 2.0;
            !(inside(0) && inside(1))
        })
    }

    fn potential(&self, potential: &Potential, leaf: NodeId, skips: &[NodeRange]) -> Result<f64, Refusal> {
        let (each, over, scale_by) = match *potential {
            Potential::Constant(0.0) => return Err(Reason::Unwanted.into()),
            Potential::Constant(value) => (value, 1.0, None),
            Potential::Scaled { value, by } => (value, 1.0, Some(by)),
            Potential::Nearness { to, floor_m, scale_by } => {
                (1.0, distance_m(self.world_state.base, to).max(floor_m), scale_by)
            }
        };
        let mut count = 1;
        if let Some(of) = scale_by
            && !self.of_type(of).is_empty()
        {
            let usable = self.of_type(of).into_iter().filter(|id| {
                let leases = &self.rows[id.index()].leases;
                self.outage(*id).is_none()
                    && (leases.is_empty() || leases.iter().any(|held| self.is_own(leaf, skips, held.holder)))
            });
            count = usable.count();
            if count == 0 {
                return Err(Refusal { resources: self.of_type(of), ..Reason::NothingAvailable { of }.into() });
            }
        }
        Ok(count as f64 * each / over)
    }

    /// Why the controller of a resource is away.
    pub(super) fn outage(&self, resource: ResourceId) -> Option<Loss> {
        let controller = self.mission.robot.resources[resource.index()].controller?;
        self.away.get(&controller).map(|(why, _)| *why)
    }

    /// None of a type would do; if all of them are away or unfit, that is why.
    fn none_free(&self, of: TypeId, leaf: NodeId) -> Refusal {
        let all = self.of_type(of);
        let outages: Vec<_> = all.iter().filter_map(|&id| Some((id, self.outage(id)?))).collect();
        let unfit = all.iter().copied().find(|id| self.is_unfit(leaf, *id));
        match (outages.first(), unfit) {
            (Some(&(resource, why)), _) if outages.len() == all.len() => Reason::Unavailable { resource, why }.into(),
            (_, Some(resource)) if all.iter().all(|id| self.outage(*id).is_some() || self.is_unfit(leaf, *id)) => {
                Reason::Unfit { resource }.into()
            }
            _ => Refusal { resources: all, ..Reason::NoneFree { of }.into() },
        }
    }

    pub(super) fn of_type(&self, of: TypeId) -> Vec<ResourceId> {
        let all = self.mission.robot.resources.iter().enumerate();
        all.filter(|(_, spec)| spec.ty == of).map(|(index, _)| ResourceId::from(index)).collect()
    }

    /// The resources that would serve a claim now.
    fn serving(&self, claim: &Claim, leaf: NodeId, skips: &[NodeRange], is_wish: bool) -> Result<Serving, Refusal> {
        let fits = |id: &ResourceId| {
            let is_held = self.hinders(leaf, skips, *id, claim.access, is_wish).is_some();
            self.outage(*id).is_none() && !self.is_unfit(leaf, *id) && !is_held
        };
        let held = |resource: ResourceId| {
            if let Some(why) = self.outage(resource) {
                return Some(Refusal::from(Reason::Unavailable { resource, why }));
            }
            if self.is_unfit(leaf, resource) {
                return Some(Refusal::from(Reason::Unfit { resource }));
            }
            let by = self.hinders(leaf, skips, resource, claim.access, is_wish)?;
            let channel = self.rows[resource.index()].access.and_then(|access| access.channel());
            Some(Refusal { resources: vec![resource], ..Reason::Held { resource, by, channel }.into() })
        };
        let (of, must_be_empty, reaches) = match claim.selector {
            Selector::Named(resource) => {
                return held(resource).map_or(Ok(vec![(resource, 0.0)]), Err);
            }
            Selector::Holding { .. } => {
                let holders = self.holders_for(claim.selector);
                let usable: Serving = holders.iter().copied().filter(fits).map(|id| (id, 0.0)).collect();
                return match holders.first() {
                    Some(_) if !usable.is_empty() => Ok(usable),
                    Some(first) => Err(held(*first).expect("it does not fit")),
                    None => Err(self.no_holder(claim.selector).into()),
                };
            }
            Selector::Any(of) => (of, false, None),
            Selector::AnyEmpty { of, reaches } => (of, true, reaches),
            Selector::Empty { resource, reaches } => {
                return held(resource).map_or_else(|| self.if_empty(resource, reaches, leaf), Err);
            }
        };
        let all = self.of_type(of);
        if all.is_empty() {
            return Err(Reason::Missing { of }.into());
        }
        let is_usable = |id: &ResourceId| fits(id) && !(must_be_empty && self.held_object(*id).is_some());
        let usable: Vec<_> = all.iter().copied().filter(is_usable).collect();
        if usable.is_empty() {
            return Err(self.none_free(of, leaf));
        }
        let reach = |id: ResourceId| match reaches {
            Some(object) => self.reach_m(id, object),
            None => Some(0.0),
        };
        let reaching: Serving = usable.iter().filter_map(|&id| Some((id, reach(id)?))).collect();
        match reaches {
            Some(object) if reaching.is_empty() => {
                let mut would: Vec<_> = all.into_iter().filter(|&id| reach(id).is_some()).collect();
                would.retain(|id| !fits(id));
                would.sort_by_key(|&id| !self.is_run(id));
                let reason = match would.iter().find_map(|&id| held(id)) {
                    Some(refusal) => refusal.reason,
                    None => Reason::OutOfReach { object },
                };
                Err(Refusal { resources: would, ..reason.into() })
            }
            Some(_) | None => Ok(reaching),
        }
    }

    /// One resource, if it holds nothing and reaches what it must.
    fn if_empty(&self, resource: ResourceId, reaches: Option<ObjectId>, leaf: NodeId) -> Result<Serving, Refusal> {
        if self.held_object(resource).is_some() {
            return Err(self.none_free(self.mission.robot.resources[resource.index()].ty, leaf));
        }
        let reach = reaches.map_or(Some(0.0), |object| self.reach_m(resource, object));
        match (reach, reaches) {
            (Some(cost_m), _) => Ok(vec![(resource, cost_m)]),
            (None, Some(object)) => Err(Reason::OutOfReach { object }.into()),
            (None, None) => unreachable!("nothing is to be reached"),
        }
    }

    /// Two claims of one behavior never get the same resource.
    pub(super) fn all_at_once(&self, claims: &[Claim], serving: &[Serving]) -> Result<(), Refusal> {
        let Some(short) = first_short(claims.len(), serving) else {
            return Ok(());
        };
        let of = self.mission.robot.resources[serving[short - 1][0].0.index()].ty;
        let all = self.of_type(of);
        let wanted = serving.iter().filter(|serving| serving.iter().any(|(id, _)| all.contains(id))).count() as u32;
        let free = all.iter().filter(|id| serving.iter().flatten().any(|(other, _)| other == *id)).count() as u32;
        Err(Refusal { resources: all, ..Reason::TooFew { of, wanted, free }.into() })
    }

    fn reach_m(&self, resource: ResourceId, object: ObjectId) -> Option<f64> {
        let spots: Vec<[f64; 3]> = match self.world_state.objects[object.index()] {
            Location::At(place) => vec![self.spot(object, place)],
            // What is held is where an arm carries it; none of these robots has slots.
            Location::In(holders) => {
                let others = holders.as_slice().iter().filter(|holder| **holder != resource);
                others
                    .filter_map(|holder| self.arm_of(*holder))
                    .map(|arm| on_map(self.world_state.base, arm.tuck))
                    .collect()
            }
            Location::Unknown => Vec::new(),
        };
        let Some(arm) = self.arm_of(resource) else {
            return spots.first().map(|_| 0.0);
        };
        let shoulder = on_map(self.world_state.base, arm.shoulder);
        let distance_m = |spot: &[f64; 3]| {
            let away = [spot[0] - shoulder[0], spot[1] - shoulder[1], spot[2] - shoulder[2]];
            away.iter().map(|part| part * part).sum::<f64>().sqrt()
        };
        let reached = spots.iter().map(distance_m).filter(|distance_m| *distance_m <= arm.reach_m);
        reached.min_by(f64::total_cmp)
    }

    pub(super) fn arm_of(&self, resource: ResourceId) -> Option<ArmSpec> {
        let controller = self.mission.robot.resources[resource.index()].controller?;
        match self.mission.robot.controllers[controller.index()].kind {
            ControllerKind::Arm(arm) => Some(arm),
            _ => None,
        }
    }

    pub(super) fn spot(&self, object: ObjectId, place: PlaceId) -> [f64; 3] {
        let place = &self.mission.world.places[place.index()];
        let local = place.surface + self.mission.world.objects[object.index()].offset;
        let (sin, cos) = place.stand.heading.sin_cos();
        [place.stand.at.x + cos * local.x - sin * local.y, place.stand.at.y + sin * local.x + cos * local.y, local.z]
    }
}

/// A point of the base frame on the map.
pub(super) fn on_map(base: Pose, point: nalgebra::Point3<f64>) -> [f64; 3] {
    let (sin, cos) = base.heading.sin_cos();
    [base.at.x + cos * point.x - sin * point.y, base.at.y + sin * point.x + cos * point.y, point.z]
}

/// How many of the claims cannot be served together with those before them.
fn first_short(count: usize, serving: &[Serving]) -> Option<usize> {
    fn can(serving: &[Serving], taken: &[ResourceId]) -> bool {
        let Some((first, rest)) = serving.split_first() else {
            return true;
        };
        let mut free = first.iter().filter(|(id, _)| !taken.contains(id));
        free.any(|(id, _)| can(rest, &[taken, &[*id]].concat()))
    }
    (1..=count).find(|&upto| !can(&serving[..upto], &[]))
}

pub(super) fn singles(condition: &Condition) -> Vec<&Condition> {
    if let Condition::All(parts) = condition { parts.iter().flat_map(singles).collect() } else { vec![condition] }
}

fn on(reason: Reason, behavior: NodeId) -> Refusal {
    Refusal { behaviors: vec![behavior], ..reason.into() }
}

pub(super) fn distance_m(a: Pose, b: Pose) -> f64 {
    ((a.at.x - b.at.x).powi(2) + (a.at.y - b.at.y).powi(2)).sqrt()
}
