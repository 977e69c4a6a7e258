//! Random missions: robots, worlds, trees of fetching and of claiming at random.

use std::sync::Arc;
use std::time::Duration;

use ambidex::model::{
    Access, BehaviorSpec, ChannelId, Claim, CommandTerm, Condition, EffectTerm, FactId, HeldBy, Hold, Limits, Location,
    MissionSpec, NodeId, NodeKind, ObjectId, Obstacle, PlaceId, Potential, ResourceId, Retention, Selector, TypeId,
};
use ambidex::tree::{Allocator, Greedy, Serial};
use nalgebra::Point3;

use super::extras::{self, Extras};
use super::plan::Plan;
use crate::driver::Rng;
use crate::support::{self, BASE, Body, GRIPPER, HEAD, TOOL, Tree, WING};

const FACTS: usize = 4;
/// Most nodes between the root and a behavior.
pub const DEPTH: usize = 6;

/// A mission with all that will happen to it.
#[derive(Clone)]
pub struct Case {
    pub seed: u64,
    pub depth: usize,
    pub mission: Arc<MissionSpec>,
    pub clashing: Vec<(NodeId, NodeId)>,
    pub is_serial: bool,
    /// The reference model knows of no certificate.
    pub prevents_deadlock: bool,
    pub plan: Plan,
}

impl Case {
    pub fn new(seed: u64) -> Self {
        Self::of(seed, DEPTH)
    }

    /// The same from a tree of less depth.
    pub fn of(seed: u64, depth: usize) -> Self {
        let (mut rng, mut others) = (Rng::of(&[seed, 1]), Rng::of(&[seed, 15]));
        let extras = Extras::of(seed);
        let mut maker = Maker::new(&mut rng);
        let mut tree = maker.tree(depth);
        if extras.cleanups {
            tree = Maker { rng: &mut others, objects: maker.objects.clone(), idle: Vec::new(), ..maker }.clean(tree);
        }
        let Maker { is_wild, body, places, objects, blocked, .. } = maker;
        let facts = (0..FACTS).map(|_| rng.is(40)).collect();
        let mut mission = support::mission(body, places, objects, facts, &tree);
        mission.world.obstacles.extend(blocked.map(|place| {
            let stand = mission.world.places[place.index()].stand.at;
            let corner = |by: f64, z| Point3::new(stand.x + by, stand.y + by, z);
            Obstacle::between(corner(-0.4, 0.0), corner(0.4, 1.0))
        }));
        add_limits(seed, &mut mission);
        extras::add_shortcuts(seed, &mut mission);
        extras::add(seed, extras, &mut mission);
        add_hands(seed, body, &mut mission);
        // Rules speak of behaviors on resources: what claims none is in nobody's way.
        let claims = |leaf: &NodeId| !mission.tree.behavior(*leaf).expect("a leaf").claims.is_empty();
        let leaves: Vec<_> = mission.tree.leaves().filter(claims).collect();
        let pairs = if !leaves.is_empty() && rng.is(25) { 1 + rng.below(3) } else { 0 };
        let clashing = (0..pairs).map(|_| (rng.one(&leaves), rng.one(&leaves))).filter(|(a, b)| a != b).collect();
        Self {
            seed,
            depth,
            clashing,
            is_serial: rng.is(12),
            prevents_deadlock: false,
            plan: Plan::new(seed, is_wild, &mission, |place| Some(place) != blocked),
            mission: Arc::new(mission),
        }
    }

    /// The same with a certificate against deadlock.
    pub fn certified(&self) -> Self {
        Self { prevents_deadlock: true, ..self.clone() }
    }

    /// The same where nothing goes wrong and nobody interferes.
    pub fn undisturbed(&self) -> Self {
        let mut mission = MissionSpec::clone(&self.mission);
        mission.tree.limits.clear();
        // What nobody cancels has an end.
        mission.tree.repeats.values_mut().for_each(|repeat| repeat.times = repeat.times.or(Some(2)));
        let plan = Plan { seed: self.plan.seed, ..Plan::default() };
        Self { mission: Arc::new(mission), plan, ..self.clone() }
    }

    pub fn allocator(&self) -> Arc<dyn Allocator> {
        if self.is_serial { Arc::new(Serial) } else { Arc::new(Greedy) }
    }

    /// All there is to know.
    pub fn drawing(&self) -> String {
        let start = &self.mission.start;
        let types: Vec<_> = self.mission.robot.resources.iter().map(|spec| spec.ty.0).collect();
        format!(
            "serial {}, types {types:?}, start {start:?}, clashing {:?}, plan {:?}, outside {:?}, limits {:?}, repeats {:?}, \
             tasks {:?}, bypass {}\n{}",
            self.is_serial,
            self.clashing,
            self.plan,
            self.mission.world.outside,
            self.mission.tree.limits,
            self.mission.tree.repeats,
            self.mission.tree.tasks,
            self.mission.tree.bypass,
            support::draw(&self.mission)
        )
    }
}

/// Task nodes that may be tried again, or take only so long, and facts that others may set.
fn add_limits(seed: u64, mission: &mut MissionSpec) {
    let mut rng = Rng::of(&[seed, 11]);
    let has_limits = rng.is(50);
    for index in 1..mission.tree.nodes.len() {
        if matches!(mission.tree.nodes[index], NodeKind::Behavior(_) | NodeKind::Cleanup) || !has_limits || !rng.is(30)
        {
            continue;
        }
        let timeout = rng.is(50).then(|| Duration::from_millis(2000 + rng.below(18_000) as u64));
        let backoff = Duration::from_millis(rng.one(&[0, 200, 500]));
        let limits = Limits { timeout, retries: rng.below(3) as u32, backoff };
        mission.tree.limits.insert(NodeId::from(index), limits);
    }
    if rng.is(40) {
        mission.world.outside = (0..1 + rng.below(FACTS)).map(|_| rng.is(50)).collect();
    }
}

/// In some missions things are taken with two hands, put down with two, and handed over.
fn add_hands(seed: u64, body: Body, mission: &mut MissionSpec) {
    let mut rng = Rng::of(&[seed, 17]);
    if body.grippers < 2 || !rng.is(20) {
        return;
    }
    let objects = mission.start.objects.len();
    for node in mission.tree.nodes.iter_mut() {
        let NodeKind::Behavior(spec) = node else { continue };
        let both = |object| Condition::Held(Hold { object, by: HeldBy::Any, hands: 2, alone: false });
        match (spec.kind.as_str(), spec.changes.first().copied()) {
            ("pick", Some(object)) if rng.is(60) => {
                spec.claims.push(spec.claims[2]);
                spec.effects.push(EffectTerm::Taken(object, 3));
                spec.commands.push(CommandTerm { claim: 3, ..spec.commands[2].clone() });
                spec.satisfied = if rng.is(80) { both(object) } else { Condition::Held(object.into()) };
            }
            ("place", Some(object)) if rng.is(60) => {
                spec.claims.push(spec.claims[2]);
                spec.commands.push(CommandTerm { claim: 3, ..spec.commands[2].clone() });
                if rng.is(60) {
                    let precondition = std::mem::replace(&mut spec.precondition, Condition::Never);
                    spec.precondition = Condition::All(vec![precondition, both(object)]);
                }
            }
            ("gadget", _) if objects > 0 && rng.is(30) => {
                let object = ObjectId::from(rng.below(objects));
                let kept = Retention::Physical(Access::Exclusive);
                let holder = Selector::Holding { object, of: GRIPPER, resource: None };
                let taker = Selector::AnyEmpty { of: GRIPPER, reaches: Some(object) };
                spec.claims = vec![support::claim(holder, Access::Exclusive, rng.one(&[kept, Retention::Release]))];
                spec.effects.retain(|effect| matches!(effect, EffectTerm::Fact(..)));
                if rng.is(70) {
                    spec.claims.push(support::claim(taker, Access::Exclusive, kept));
                    spec.effects.push(EffectTerm::Taken(object, 1));
                }
                if rng.is(70) {
                    spec.effects.push(EffectTerm::LetGo(object, 0));
                }
                spec.changes = vec![object];
            }
            (_, _) => {}
        }
    }
}

struct Maker<'a> {
    rng: &'a mut Rng,
    body: Body,
    places: usize,
    blocked: Option<PlaceId>,
    objects: Vec<Location>,
    /// Objects that nobody fetches yet.
    idle: Vec<ObjectId>,
    leaves: usize,
    /// Claims and conditions that may never be met.
    is_wild: bool,
}

impl<'a> Maker<'a> {
    fn new(rng: &'a mut Rng) -> Self {
        let is_wild = rng.is(25);
        let body = Body {
            grippers: rng.one(&[0, 1, 1, 2, 2, 2, 2, 3, 4]),
            heads: usize::from(!is_wild || rng.is(90)),
            bases: usize::from(!is_wild || rng.is(90)),
            tools: rng.below(4),
            reach_m: if is_wild { rng.one(&[1.2, 0.62]) } else { 1.2 },
        };
        let places = 3 + rng.below(4);
        let blocked = (is_wild && rng.is(40)).then(|| PlaceId::from(rng.below(places)));
        let count = if body.grippers == 0 { rng.below(2) } else { 1 + rng.below(4) };
        let mut is_full = body.grippers == 0;
        let objects = (0..count).map(|_| match rng.below(20) {
            0 if is_wild => Location::Unknown,
            1 if is_wild && !std::mem::replace(&mut is_full, true) => Location::held(ResourceId(0)),
            _ => Location::At(rng.below(places).into()),
        });
        let objects: Vec<_> = objects.collect();
        let idle = (0..count).map(ObjectId::from).collect();
        Self { rng, body, places, blocked, objects, idle, leaves: 0, is_wild }
    }

    fn tree(&mut self, depth: usize) -> Tree {
        let wide = depth == DEPTH;
        if depth == 1 || self.leaves > 12 || (!wide && self.rng.is(30)) {
            return self.work();
        }
        let count = 2 + self.rng.below(if wide { 3 } else { 2 });
        let children = |maker: &mut Self| (0..count).map(|_| maker.tree(depth - 1)).collect();
        match self.rng.below(10) {
            0..5 => Tree::And(children(self)),
            5..7 => Tree::Or(children(self)),
            _ => Tree::Then(children(self)),
        }
    }

    /// Here and there a cleanup behind a node: mostly one that puts down what the node took.
    fn clean(&mut self, tree: Tree) -> Tree {
        let taken = extras::taken(&tree);
        let tree = match tree {
            Tree::And(children) => Tree::And(self.clean_all(children)),
            Tree::Or(children) => Tree::Or(self.clean_all(children)),
            Tree::Then(children) => Tree::Then(self.clean_all(children)),
            Tree::Cleanup(children) => Tree::Cleanup(children),
            leaf @ Tree::Leaf(..) => leaf,
        };
        if !self.rng.is(12) {
            return tree;
        }
        let place = self.place();
        let mut steps = vec![self.gadget(None)];
        if let Some(object) = taken.filter(|_| self.rng.is(70)) {
            steps = vec![self.go(place)];
            steps.push(self.leaf("place", support::put(self.body, object, place, self.places)));
        }
        if self.rng.is(30) {
            let more = self.gadget(None);
            steps.push(more);
        }
        let cleanup = match steps.len() {
            1 => steps.remove(0),
            _ if self.rng.is(20) => Tree::And(steps),
            _ => Tree::Then(steps),
        };
        Tree::Cleanup(Box::new([tree, cleanup]))
    }

    fn clean_all(&mut self, trees: Vec<Tree>) -> Vec<Tree> {
        trees.into_iter().map(|tree| self.clean(tree)).collect()
    }

    /// Something that makes sense: fetching, going somewhere to do something, or a lonely behavior.
    fn work(&mut self) -> Tree {
        match self.rng.below(10) {
            0..4 if !self.idle.is_empty() && (self.body.grippers > 0 || (self.is_wild && self.rng.is(20))) => {
                self.fetch()
            }
            4..6 => self.errand(),
            6 => {
                let count = 2 + self.rng.below(2);
                let children = (0..count).map(|_| self.gadget(None)).collect();
                Tree::Then(children)
            }
            _ => self.gadget(None),
        }
    }

    fn fetch(&mut self) -> Tree {
        let index = self.rng.below(self.idle.len());
        let object = if !self.is_wild || self.rng.is(80) { self.idle.swap_remove(index) } else { self.idle[index] };
        let from = match self.objects[object.index()] {
            Location::At(place) => place,
            Location::In(_) | Location::Unknown => self.place(),
        };
        let to = self.place();
        let (body, places) = (self.body, self.places);
        let mut steps = vec![self.go(from)];
        let mut pick = support::pick(body, object, from, places);
        if self.is_wild && self.rng.is(20) {
            let lies = Condition::Lies(object, self.place_but(from));
            pick.precondition = Condition::All(vec![pick.precondition, lies]);
        }
        steps.push(self.leaf("pick", pick));
        if self.rng.is(20) {
            steps.push(self.gadget(None));
        }
        if !self.is_wild || self.rng.is(80) {
            steps.push(self.go(to));
            steps.push(self.leaf("place", support::put(body, object, to, places)));
        }
        if self.rng.is(25) && steps.len() >= 4 {
            let rest = steps.split_off(2);
            return Tree::Then(vec![Tree::Then(steps), Tree::Then(rest)]);
        }
        Tree::Then(steps)
    }

    /// A move and something done there, or several things.
    fn errand(&mut self) -> Tree {
        let to = self.place();
        let mut steps = vec![self.go(to)];
        if self.rng.is(10) {
            let other = self.place();
            steps = vec![Tree::Or(vec![self.go(to), self.go(other)])];
        }
        let there = if self.rng.is(40) {
            let count = 2;
            let children = (0..count).map(|_| self.gadget(Some(to))).collect();
            if self.rng.is(70) { Tree::And(children) } else { Tree::Or(children) }
        } else {
            self.gadget(Some(to))
        };
        steps.push(there);
        Tree::Then(steps)
    }

    fn go(&mut self, to: PlaceId) -> Tree {
        let mut spec = support::move_to(self.body, to, self.places);
        if let Potential::Nearness { scale_by, .. } = &mut spec.potential {
            *scale_by = self.rng.one(&[None, Some(GRIPPER), Some(GRIPPER), Some(TOOL), Some(WING)]);
            if self.body.grippers == 0 && *scale_by == Some(GRIPPER) {
                *scale_by = None;
            }
        }
        if self.rng.is(15) {
            spec.potential = Potential::Constant(1.0);
        }
        self.leaf("move", spec)
    }

    /// A behavior that claims at random, there if a place is given.
    fn gadget(&mut self, there: Option<PlaceId>) -> Tree {
        let mut spec = support::blank("gadget");
        for _ in 0..self.rng.below(3) {
            let claim = self.claim(there);
            let is_new = spec.claims.iter().all(|other| self.types(other) != self.types(&claim));
            if self.is_wild || is_new {
                spec.claims.push(claim);
            }
        }
        let value = self.rng.one(&[1.0, 1.0, 1.0, 2.0, 9.0]);
        spec.potential = match self.rng.below(20) {
            0 if self.is_wild => Potential::Constant(0.0),
            1..4 => Potential::Scaled { value, by: self.ty() },
            _ => Potential::Constant(value),
        };
        let mut needs = Vec::new();
        if let Some(place) = there {
            let stand = support::place(place.index(), self.places).stand;
            needs.push(Condition::At { place, stands: vec![stand], tolerance_m: support::TOLERANCE_M });
            if self.body.bases > 0 && self.rng.is(70) {
                let wanted = Selector::Named(self.body.first(BASE).expect("a base"));
                let access = Access::Shared(support::at_channel(place));
                spec.claims.retain(|claim| self.types(claim) != Some(BASE));
                spec.claims.push(support::claim(wanted, access, Retention::Release));
            }
        }
        if self.is_wild && self.rng.is(25) {
            needs.push(Condition::Fact(self.fact(), self.rng.is(60)));
        }
        spec.precondition = Condition::All(needs);
        for _ in 0..self.rng.below(2) {
            let effect = EffectTerm::Fact(self.fact(), self.rng.is(75));
            spec.effects.push(effect);
        }
        if let Some(EffectTerm::Fact(fact, holds)) = spec.effects.first().copied()
            && self.rng.is(60)
        {
            spec.satisfied = Condition::Fact(fact, holds);
        }
        if !self.objects.is_empty() && self.rng.is(12) {
            spec.changes.push(self.rng.below(self.objects.len()).into());
        }
        self.leaf("gadget", spec)
    }

    fn claim(&mut self, there: Option<PlaceId>) -> Claim {
        let access = if self.rng.is(60) { Access::Exclusive } else { Access::Shared(self.channel(there)) };
        let kept =
            if access == Access::Exclusive && self.rng.is(50) { Access::Shared(self.channel(there)) } else { access };
        let keep = match self.rng.below(100) {
            0..70 => Retention::Release,
            70..97 => Retention::Intention(kept),
            _ if !self.is_wild => Retention::Release,
            _ => Retention::Physical(kept),
        };
        let claim = support::claim(self.wanted(), access, keep);
        assert!(claim.is_sound(), "{claim:?}");
        claim
    }

    fn wanted(&mut self) -> Selector {
        let all = self.body.spec().resources.len();
        let of = self.ty();
        match self.rng.below(20) {
            0..5 if all > 0 && self.is_wild => Selector::Named(self.rng.below(all).into()),
            0..3 => self.body.first(of).map_or(Selector::Any(of), Selector::Named),
            3..5 => match self.body.first(of) {
                Some(resource) if self.is_wild && !self.objects.is_empty() && self.rng.is(50) => {
                    Selector::Empty { resource, reaches: Some(self.rng.below(self.objects.len()).into()) }
                }
                Some(resource) => Selector::Empty { resource, reaches: None },
                None => Selector::Any(of),
            },
            5..9 => Selector::AnyEmpty { of, reaches: None },
            9..11 if self.is_wild && !self.objects.is_empty() => {
                Selector::AnyEmpty { of: GRIPPER, reaches: Some(self.rng.below(self.objects.len()).into()) }
            }
            11 if self.is_wild && !self.objects.is_empty() => {
                let object = self.rng.below(self.objects.len()).into();
                Selector::Holding { object, of: GRIPPER, resource: None }
            }
            _ => Selector::Any(of),
        }
    }

    /// The types of which a claim may take one.
    fn types(&self, claim: &Claim) -> Option<TypeId> {
        match claim.selector {
            Selector::Named(resource) | Selector::Empty { resource, .. } => {
                Some(self.body.spec().resources[resource.index()].ty)
            }
            Selector::AnyEmpty { of, .. } | Selector::Any(of) => Some(of),
            Selector::Holding { .. } => None,
        }
    }

    /// Mostly a type that the robot has.
    fn ty(&mut self) -> TypeId {
        let mut all = if self.is_wild { vec![WING] } else { Vec::new() };
        let body = self.body;
        for (ty, count) in [
            (GRIPPER, if self.is_wild { body.grippers } else { 0 }),
            (HEAD, body.heads),
            (BASE, body.bases),
            (TOOL, body.tools),
        ] {
            all.extend(std::iter::repeat_n(ty, if count > 0 { 10 } else { 0 }));
        }
        self.rng.one(&all)
    }

    fn channel(&mut self, there: Option<PlaceId>) -> ChannelId {
        match there {
            Some(place) if self.rng.is(70) => support::at_channel(place),
            Some(_) | None => ChannelId(self.rng.below(3) as u32),
        }
    }

    fn place(&mut self) -> PlaceId {
        let place = PlaceId::from(self.rng.below(self.places));
        // A blocked place is worth a visit only now and then.
        if Some(place) == self.blocked && self.rng.is(70) { self.place_but(place) } else { place }
    }

    fn place_but(&mut self, other: PlaceId) -> PlaceId {
        PlaceId::from((other.index() + 1 + self.rng.below(self.places - 1)) % self.places)
    }

    fn fact(&mut self) -> FactId {
        self.rng.below(FACTS).into()
    }

    fn leaf(&mut self, word: &str, mut spec: BehaviorSpec) -> Tree {
        spec.retries = self.rng.below(3) as u32;
        spec.backoff = Duration::from_millis([0, 200, 500][self.leaves % 3]);
        self.leaves += 1;
        Tree::Leaf(format!("{word}{}", self.leaves), Box::new(spec))
    }
}
