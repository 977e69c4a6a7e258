//! All that the rules let happen next, whoever would have been chosen: for a search over schedules.
//!
//! It has no order of requests, no priorities, no time: what waits for a moment has waited, who is away is back.

use ambidex::model::{
    Binding, Condition, EffectTerm, End, FactId, Grant, LeaseKind, Location, MissionEnd, MissionSpec, NodeId, NodeKind,
    NodeRange, Outcome, Reason, ResourceId, Retention,
};

use super::world::singles;
use super::{Ask, Model, TOP};

/// A rule that can be lifted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Rule {
    /// Who lapsed does not ask before there is progress.
    LapsedWaits,
    /// A behavior is sent back once in a progress.
    RedoOnce,
    /// A way is left once in a progress.
    LeaveOnce,
    /// What was rejected for reach or kind is no candidate before there is progress.
    RejectedWaits,
    /// What would leave no serial order of what is kept physically is not granted.
    Certificate,
    /// A satisfied way of an OR is before all others.
    SatisfiedFirst,
    /// Siblings of an AND are never sent back, nor is what stands in other ways or later.
    OwnTaskOnly,
}

impl Rule {
    pub const ALL: [Self; 7] = [
        Self::LapsedWaits,
        Self::RedoOnce,
        Self::LeaveOnce,
        Self::RejectedWaits,
        Self::Certificate,
        Self::SatisfiedFirst,
        Self::OwnTaskOnly,
    ];
}

/// The rules that are lifted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Freedom(u8);

impl Freedom {
    pub const NONE: Self = Self(0);
    /// All but what concerns the work of others.
    pub const OWN: Self = Self((1 << Rule::OwnTaskOnly as u8) - 1);

    pub fn of(rules: &[Rule]) -> Self {
        Self(rules.iter().fold(0, |set, rule| set | 1 << *rule as u8))
    }

    pub fn lifts(self, rule: Rule) -> bool {
        self.0 & (1 << rule as u8) != 0
    }

    /// Whether it does not matter when something was last completed.
    fn is_timeless(self) -> bool {
        [Rule::LapsedWaits, Rule::RedoOnce, Rule::LeaveOnce, Rule::RejectedWaits].iter().all(|rule| self.lifts(*rule))
    }
}

/// Something that can happen next.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Next {
    Run(NodeId, Vec<Binding>),
    End(NodeId),
    Lapse(NodeId),
    Redo(NodeId),
    Overtake(NodeId),
    Leave(NodeId),
    Iterate(NodeId),
    Undo(NodeId, NodeId),
}

#[derive(Default)]
struct Walk {
    asks: Vec<Ask>,
    blocked: Vec<NodeId>,
    over: Vec<NodeId>,
}

impl<'a> Model<'a> {
    /// The same where nothing waits for a moment, and with another copy of the mission.
    pub fn for_search<'b>(&self, mission: &'b MissionSpec, freedom: Freedom) -> Model<'b>
    where
        'a: 'b,
    {
        let mut model: Model<'b> = Model { mission, ..self.clone() };
        let is_refused = |reason: &Reason| matches!(reason, Reason::WouldDeadlock { .. });
        model.hidden.retain(|_, refusal| !freedom.lifts(Rule::Certificate) && is_refused(&refusal.reason));
        model.forget_time(freedom);
        // A round would begin with that.
        if model.end.is_none() && !model.is_cleaning_up() {
            model.give_up();
            model.forget_time(freedom);
        }
        model
    }

    pub fn is_cleaning_up(&self) -> bool {
        !self.cleaning.is_empty() || !self.leaving.is_empty() || self.ending.is_some()
    }

    /// How many iterations of a node have ended.
    pub fn iterations_ended(&self, node: NodeId) -> u32 {
        self.ended_times(node)
    }

    pub fn is_won(&self) -> bool {
        self.end == Some(MissionEnd::Done) || self.walk(TOP, &[], &mut Walk::default(), Freedom::NONE)
    }

    /// Everything that can happen next, and what comes of it.
    pub fn next(&self, freedom: Freedom) -> Vec<(Next, Model<'a>)> {
        if self.end.is_some() {
            return Vec::new();
        }
        let mut all = Vec::new();
        let ends = self.running.keys().map(|leaf| self.with(Next::End(*leaf), |model| model.succeed(*leaf)));
        all.extend(ends);
        let mut walk = Walk::default();
        self.walk(TOP, &[], &mut walk, freedom);
        // What nobody notices comes first.
        if let Some(harmless) = walk.asks.iter().find(|ask| self.is_harmless(ask)) {
            walk.asks = vec![harmless.clone()];
            all.clear();
        }
        let is_alone = walk.asks.len() == 1 && self.is_harmless(&walk.asks[0]);
        for ask in &walk.asks {
            for grant in self.grants(ask).into_iter().take(if is_alone { 1 } else { usize::MAX }) {
                let next = Next::Run(grant.leaf(), grant.bindings.clone());
                all.push(self.with(next, |model| {
                    model.start(&grant);
                    model.succeed(grant.leaf());
                }));
            }
        }
        if is_alone {
            walk.over.clear();
            walk.blocked.clear();
        }
        for node in walk.over.into_iter().filter(|node| !self.runs_below(*node) && !self.is_over(*node)) {
            all.push(self.with(Next::Iterate(node), |model| model.end_iteration(node)));
        }
        for &leaf in &walk.blocked {
            all.extend(self.helped(leaf, freedom));
        }
        if !is_alone {
            all.extend(self.lapses(freedom));
            all.extend(self.leaves(freedom));
        }
        for (_, model) in &mut all {
            model.hidden.clear();
            model.forget_time(freedom);
            // What can never run has failed; in another task it could be made so again.
            if !freedom.lifts(Rule::OwnTaskOnly) && model.end.is_none() {
                model.give_up();
                model.forget_time(freedom);
            }
        }
        all.retain(|(_, model)| !model.failing.contains_key(&TOP));
        all
    }

    /// Every way to serve a request, as a grant.
    pub fn grants(&self, ask: &Ask) -> Vec<Grant> {
        let mut grants = Vec::new();
        self.for_each_choice(std::slice::from_ref(ask), &mut |choice| {
            let mut grant = ask.grant.clone();
            let claims = &self.behavior(grant.leaf()).claims;
            let bound = std::iter::zip(claims, choice);
            let bound = bound.map(|(claim, (id, _))| Binding { resource: *id, access: claim.access, keep: claim.keep });
            grant.bindings = bound.collect();
            grants.push(grant);
        });
        grants
    }

    /// What asks now, each with all that would serve it.
    pub fn asking(&self, freedom: Freedom) -> Vec<Ask> {
        let mut walk = Walk::default();
        self.walk(TOP, &[], &mut walk, freedom);
        walk.asks
    }

    /// Whether a behavior takes nothing, gives back all that it uses, changes nothing that anybody looks at, and decides
    /// nothing: it may as well run at once.
    fn is_harmless(&self, ask: &Ask) -> bool {
        let leaf = ask.grant.leaf();
        let spec = self.behavior(leaf);
        let gives_back = spec.claims.iter().all(|claim| claim.keep == Retention::Release);
        let is_free = |id: &ResourceId| self.rows[id.index()].leases.is_empty();
        let takes_nothing = ask.serving.iter().flatten().all(|(id, _)| is_free(id));
        let is_noticed = |effect: &EffectTerm| match *effect {
            EffectTerm::Fact(fact, _) => self.looked_at(leaf).contains(&fact),
            EffectTerm::Lies(..) | EffectTerm::Taken(..) | EffectTerm::LetGo(..) | EffectTerm::Stands(_) => true,
        };
        let is_open = |node: &NodeId| self.kind(*node) == &NodeKind::Or && !self.committed.contains_key(node);
        let decides =
            self.upward(leaf).iter().any(|node| is_open(node) || self.mission.tree.repeats.contains_key(node));
        gives_back
            && takes_nothing
            && ask.grant.request.skips.is_empty()
            && !decides
            && !spec.effects.iter().any(is_noticed)
    }

    /// The facts that some other behavior asks for.
    fn looked_at(&self, but_for: NodeId) -> Vec<FactId> {
        let others = self.mission.tree.leaves().filter(|leaf| *leaf != but_for).map(|leaf| self.behavior(leaf));
        let parts = others.flat_map(|spec| [&spec.precondition, &spec.satisfied].map(singles)).flatten();
        parts.filter_map(|part| if let Condition::Fact(fact, _) = part { Some(*fact) } else { None }).collect()
    }

    /// The ORs that have not chosen and would choose with a behavior, with the way to it.
    pub fn would_choose(&self, leaf: NodeId) -> Vec<(NodeId, NodeId)> {
        let path = self.upward(leaf);
        let is_open = |or: NodeId| self.kind(or) == &NodeKind::Or && !self.committed.contains_key(&or);
        path.windows(2).filter(|pair| is_open(pair[1])).map(|pair| (pair[1], pair[0])).collect()
    }

    /// The same with a behavior granted, run and succeeded.
    pub fn after_run(&self, grant: &Grant) -> Self {
        let mut model = self.clone();
        model.start(grant);
        model.succeed(grant.leaf());
        model
    }

    /// The same where the world is, and who holds what, as it was before.
    pub fn restored(&self, before: &Self, world: bool, leases: bool) -> Self {
        let mut model = self.clone();
        if world {
            model.world_state = before.world_state.clone();
        }
        if leases {
            model.rows = before.rows.clone();
        }
        model
    }

    /// The same where what was skipped for a behavior is not done.
    pub fn without_skips(&self, grant: &Grant) -> Self {
        let mut model = self.clone();
        let is_skipped = |node: &NodeId| grant.request.skips.iter().any(|skip| skip.contains(*node));
        model.done.retain(|node| !is_skipped(node));
        model
    }

    pub fn choose_way(&mut self, or: NodeId, way: NodeId) {
        self.committed.insert(or, way);
    }

    pub fn start(&mut self, grant: &Grant) {
        self.take(grant);
        self.settle_grant(grant);
        self.begin_first_time(grant.leaf());
        self.running.insert(grant.leaf(), grant.clone());
    }

    fn succeed(&mut self, leaf: NodeId) {
        self.stopping.remove(&leaf);
        self.ended(leaf, &Outcome { end: End::Succeeded, changes: Vec::new() });
    }

    fn with(&self, next: Next, make: impl FnOnce(&mut Self)) -> (Next, Self) {
        let mut model = self.clone();
        make(&mut model);
        (next, model)
    }

    fn forget_time(&mut self, freedom: Freedom) {
        self.log.clear();
        self.waits.clear();
        self.resting.clear();
        self.began.clear();
        self.deadlines.clear();
        self.away.clear();
        self.awaited = None;
        self.urged.clear();
        self.told.clear();
        self.stopping.clear();
        self.preempted.clear();
        self.seen.clear();
        self.overdue.clear();
        self.bad.clear();
        self.denied.clear();
        self.begun.clear();
        if freedom.lifts(Rule::LapsedWaits) {
            self.silent.clear();
        }
        if freedom.lifts(Rule::RedoOnce) {
            self.redone.retain(|_, (_, by)| by.is_some());
            self.redone.values_mut().for_each(|(progress, _)| *progress = u64::MAX);
        }
        if freedom.lifts(Rule::LeaveOnce) {
            self.left.clear();
        }
        if freedom.lifts(Rule::RejectedWaits) {
            self.unfit.clear();
        }
    }

    /// All that is asked below a node; true if it is satisfied.
    fn walk(&self, node: NodeId, skips: &[NodeRange], walk: &mut Walk, freedom: Freedom) -> bool {
        if self.is_canceling(node) || self.is_given_up(node) || self.failed.contains(&node) {
            return false;
        }
        let mut is_satisfied = match self.kind(node) {
            NodeKind::Root => unreachable!("root is asked by nobody"),
            NodeKind::Cleanup => self.walk(self.body(node), skips, walk, freedom),
            NodeKind::Behavior(_) => self.walk_leaf(node, skips, walk),
            NodeKind::And | NodeKind::Tasks => {
                let mut all = !self.failing.contains_key(&node);
                for child in self.not_done(node) {
                    all &= self.walk(child, skips, walk, freedom);
                }
                all
            }
            NodeKind::Or => {
                let before = walk.asks.len();
                let ways = self.committed.get(&node).map_or_else(|| self.children(node), |way| vec![*way]);
                let mut any = false;
                for way in ways {
                    any |= self.walk(way, skips, walk, freedom);
                }
                if any && !freedom.lifts(Rule::SatisfiedFirst) {
                    let passed_over = walk.asks.split_off(before).into_iter();
                    walk.blocked.extend(passed_over.map(|ask| ask.grant.leaf()));
                }
                any
            }
            NodeKind::Then => self.walk_then(node, skips, walk, freedom),
        };
        is_satisfied &= !self.runs_below(node);
        if is_satisfied && self.is_not_the_last(node) {
            walk.over.push(node);
            return false;
        }
        is_satisfied
    }

    fn walk_then(&self, node: NodeId, skips: &[NodeRange], walk: &mut Walk, freedom: Freedom) -> bool {
        let remaining = self.not_done(node);
        for (index, &child) in remaining.iter().enumerate() {
            let mut skips = skips.to_vec();
            if index > 0 {
                skips.push(NodeRange { from: remaining[0], to: child });
            }
            if !self.walk(child, &skips, walk, freedom) {
                return false;
            }
        }
        true
    }

    fn walk_leaf(&self, leaf: NodeId, skips: &[NodeRange], walk: &mut Walk) -> bool {
        if self.running.contains_key(&leaf) {
            return false;
        }
        let is_satisfied = match self.redone.get(&leaf).and_then(|(_, by)| *by) {
            Some(by) => self.done.contains(&by) || !self.lacks_what(by, leaf),
            None => self.is_satisfied(leaf, skips),
        };
        if is_satisfied {
            return true;
        }
        let is_silent = self.silent.get(&leaf).is_some_and(|(progress, ..)| *progress == self.progress);
        match self.request(leaf, skips, false) {
            Ok(ask) if !is_silent && !self.hidden.contains_key(&leaf) => walk.asks.push(ask),
            Ok(_) | Err(_) => walk.blocked.push(leaf),
        }
        false
    }

    /// A blocked leaf is helped by what others did, or by sending somebody back.
    fn helped(&self, leaf: NodeId, freedom: Freedom) -> Vec<(Next, Model<'a>)> {
        let mut all = Vec::new();
        let Some((condition, reason)) = self.lacking(leaf) else { return all };
        if matches!(reason, Reason::Driving { .. }) {
            return all;
        }
        let mut model = self.clone();
        if model.overtake(leaf) {
            all.push((Next::Overtake(leaf), model));
        }
        let mut model = self.clone();
        if !matches!(reason, Reason::NoPath { .. }) && model.send_back(leaf, &condition).is_some() {
            all.push((Next::Redo(leaf), model));
        }
        if freedom.lifts(Rule::OwnTaskOnly) {
            let makers = self.mission.tree.leaves().filter(|maker| self.is_within_done(*maker));
            let makers = makers.filter(|maker| self.cleans(*maker).is_none() && self.promises(*maker, &condition));
            all.extend(makers.map(|maker| self.with(Next::Undo(maker, leaf), |model| model.undo_all(maker, leaf))));
        }
        all
    }

    fn is_within_done(&self, leaf: NodeId) -> bool {
        self.done.contains(&leaf) && !self.runs_below(leaf)
    }

    /// The behavior and all between it and what it has in common with a leaf are not done.
    fn undo_all(&mut self, maker: NodeId, leaf: NodeId) {
        let above = self.upward(leaf);
        let common = self.upward(maker).into_iter().find(|node| above.contains(node)).expect("root at least");
        self.undo(common, maker);
        self.redone.insert(maker, (u64::MAX, Some(leaf)));
    }

    fn lapses(&self, freedom: Freedom) -> Vec<(Next, Model<'a>)> {
        let mut all = Vec::new();
        for (index, row) in self.rows.iter().enumerate() {
            for held in row.leases.iter().filter(|held| held.kind == LeaseKind::Intention) {
                all.push(self.with(Next::Lapse(held.behavior), |model| {
                    model.end_intention(index.into(), held.holder);
                    model.undo(held.holder, held.behavior);
                    if !freedom.lifts(Rule::LapsedWaits) {
                        let lacks = Reason::Satisfied;
                        model.silent.insert(held.behavior, (model.progress, held.holder, lacks));
                    }
                    model.let_choose_again(held.behavior);
                }));
            }
        }
        all
    }

    fn leaves(&self, freedom: Freedom) -> Vec<(Next, Model<'a>)> {
        let mut all = Vec::new();
        for (&or, &way) in &self.committed {
            let has_other = self.children(or).into_iter().any(|other| other != way && !self.failed.contains(&other));
            let was_left = !freedom.lifts(Rule::LeaveOnce) && self.left.get(&way) == Some(&self.progress);
            if !self.is_over(or) && !self.done.contains(&way) && has_other && !was_left && !self.runs_below(way) {
                all.push(self.with(Next::Leave(way), |model| model.leave_at_last(or, way)));
            }
        }
        all
    }

    /// All that what can happen depends on.
    pub fn key(&self, freedom: Freedom) -> Vec<u32> {
        let mut key = Vec::with_capacity(96);
        let mut list = |items: &mut dyn Iterator<Item = u32>| {
            key.extend(items);
            key.push(u32::MAX);
        };
        list(&mut self.hidden.keys().map(|leaf| leaf.0));
        list(&mut self.done.iter().map(|node| node.0));
        list(&mut self.failed.iter().map(|node| node.0));
        list(&mut self.failing.keys().map(|node| node.0));
        list(&mut self.committed.iter().flat_map(|(or, way)| [or.0, way.0]));
        list(&mut self.iterated.iter().flat_map(|(node, count)| [node.0, *count]));
        list(&mut self.failures.iter().flat_map(|(node, count)| [node.0, *count]));
        list(&mut self.redone.iter().filter_map(|(leaf, (_, by))| Some([leaf.0, by.as_ref()?.0])).flatten());
        for row in &self.rows {
            let channel = row.access.map_or(0, |access| access.channel().map_or(1, |channel| channel.0 + 2));
            let leases = row.leases.iter().flat_map(|held| [held.holder.0, held.behavior.0, held.kind as u32]);
            list(&mut std::iter::once(channel).chain(leases));
        }
        list(&mut self.running.iter().flat_map(|(leaf, grant)| {
            std::iter::once(leaf.0).chain(grant.bindings.iter().map(|binding| 1000 + binding.resource.0))
        }));
        let base = self.world_state.base;
        let bits = [base.at.x, base.at.y, base.heading].map(f64::to_bits);
        list(&mut bits.iter().flat_map(|bits| [(bits >> 32) as u32, *bits as u32]));
        for at in &self.world_state.objects {
            list(
                &mut std::iter::once(match at {
                    Location::At(place) => place.0,
                    Location::In(_) => 1000,
                    Location::Unknown => 1001,
                })
                .chain(at.holders().iter().map(|holder| holder.0)),
            );
        }
        list(&mut self.world_state.facts.iter().map(|fact| u32::from(*fact)));
        if !freedom.is_timeless() {
            let now = self.progress;
            list(&mut self.silent.iter().filter(|(_, (at, ..))| *at == now).map(|(leaf, _)| leaf.0));
            list(&mut self.redone.iter().filter(|(_, (at, _))| *at == now).map(|(leaf, _)| leaf.0));
            list(&mut self.left.iter().filter(|(_, at)| **at == now).map(|(way, _)| way.0));
            list(&mut self.unfit.iter().filter(|(.., at)| *at == now).flat_map(|(leaf, id, _)| [leaf.0, id.0]));
            list(&mut self.ever_completed.iter().map(|leaf| leaf.0));
        }
        key
    }
}
