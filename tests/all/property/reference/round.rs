//! One round: a recursive walk down, Algorithm 1 on the way up (`semantics` 4 and 5).

use std::cmp::Ordering;

use ambidex::model::{
    Access, Binding, Clash, Deadline, Grant, NodeId, NodeKind, NodeRange, Reason, ResourceId, Retention,
};

use super::{Ask, Decision, Model, Refusal, Step};

#[derive(Default)]
struct Answer {
    is_satisfied: bool,
    asks: Vec<Ask>,
    wishes: Vec<Ask>,
    /// Repeating nodes of which all is satisfied.
    over: Vec<NodeId>,
    /// Nodes that clean up and of which the cleanup is satisfied.
    clean: Vec<NodeId>,
    refused: Vec<(NodeId, Refusal)>,
}

impl Model<'_> {
    /// Gives up what can never run, and begins cleanups; false if no round follows.
    fn prepare(&mut self) -> bool {
        if self.ending.is_none() {
            self.give_up();
            if self.end.is_none() {
                self.begin_cleanups();
            }
        }
        self.end.is_none() && self.goes_on_cleaning()
    }

    /// Gives up what can never run, asks, grants, goes on, lapses; true if another round follows at once.
    pub fn round(&mut self) -> bool {
        if !self.prepare() {
            return false;
        }
        let answer = self.ask(NodeId(1), &[]);
        let mut decision = Decision { refused: answer.refused.into_iter().collect(), ..Decision::default() };
        let wishes = self.counting(answer.wishes, &answer.asks);
        let mut asks = [answer.asks, wishes].concat();
        decision.refused.extend(self.drop_what_would_deadlock(&mut asks));
        let (accepted, refused) = self.merge(asks);
        decision.refused.extend(refused);
        let (grants, taken) = self.bind(&accepted);
        for grant in grants {
            decision.granted.insert(grant.leaf(), grant);
        }
        let (rows, was_idle) = (self.rows.clone(), self.running.is_empty());
        self.grant(&mut decision);
        if !decision.granted.is_empty() {
            self.hidden.clear();
        }
        let place = self.log.len();
        let mut is_overtaken = false;
        let is_hiding = decision.granted.is_empty() && self.hide(&decision);
        if !answer.is_satisfied && !is_hiding {
            (is_overtaken, decision.reopened) = self.help_blocked(&decision);
            if !is_overtaken && decision.reopened.is_none() {
                decision.reopened = self.lapse(&decision);
            }
        }
        if self.end.is_none() && !answer.is_satisfied {
            self.tell_what_ends();
            self.tell_what_is_broken();
            self.preempt(&taken);
        }
        let yields = if self.end.is_none() { self.give_way(&taken) } else { Vec::new() };
        if self.end.is_none() {
            decision.urged = self.urge(&decision, &rows);
            decision.overdue = self.note_fairness(&decision, was_idle);
        }
        self.log.insert(place, Step::Decided(decision.clone()));
        let has_yielded = !yields.is_empty();
        self.log.extend(yields.into_iter().map(Step::Reopened));
        let counts = self.end.is_none() && !is_overtaken && decision.reopened.is_none();
        let over =
            answer.over.iter().min().copied().filter(|node| counts && !self.runs_below(*node) && !self.is_over(*node));
        if let Some(node) = over {
            self.end_iteration(node);
        }
        let clean = answer.clean.iter().min().copied().filter(|_| over.is_none() && counts);
        if let Some(node) = clean {
            self.end_cleanup_alone(node, true);
        }
        let is_order = decision.urged.is_some() || decision.overdue.is_some();
        if is_order || decision.reopened.is_some() || is_overtaken || has_yielded {
            self.hidden.clear();
        }
        let goes_on = decision.overdue.is_some()
            || !decision.granted.is_empty()
            || decision.reopened.is_some()
            || is_overtaken
            || decision.urged.is_some()
            || over.is_some()
            || clean.is_some()
            || has_yielded
            || is_hiding;
        self.awaited = self.awaited.filter(|_| decision.granted.is_empty());
        self.end.is_none() && self.end_of_round(answer.is_satisfied, goes_on, &decision)
    }

    fn grant(&mut self, decision: &mut Decision) {
        for grant in decision.granted.values().cloned().collect::<Vec<_>>() {
            self.take(&grant);
            self.settle_grant(&grant);
            decision.deadlines.extend(self.begin_times(grant.leaf()));
            self.begin_first_time(grant.leaf());
            self.running.insert(grant.leaf(), grant);
        }
        decision.deadlines.sort_by_key(|deadline| deadline.node);
    }

    /// The time of every node above runs from the first grant.
    fn begin_times(&mut self, leaf: NodeId) -> Vec<Deadline> {
        let mut begun = Vec::new();
        for node in self.within(leaf) {
            let timeout = self.mission.tree.limits(node).timeout;
            if let Some(timeout) = timeout.filter(|_| !self.deadlines.contains_key(&node)) {
                let until = self.now + timeout;
                self.deadlines.insert(node, until);
                begun.push(Deadline { node, until });
            }
        }
        begun
    }

    fn ask(&self, node: NodeId, skips: &[NodeRange]) -> Answer {
        if self.cleaning.contains(&node) {
            let mut answer = self.ask(self.children(node)[1], skips);
            if std::mem::take(&mut answer.is_satisfied) {
                answer.clean.push(node);
            }
            return answer;
        }
        if let Some(refusal) = self.silence(node) {
            return self.same_answer(node, &refusal, skips);
        }
        let mut answer = match self.kind(node) {
            NodeKind::Cleanup => self.ask(self.body(node), skips),
            NodeKind::Root => unreachable!("root is asked by nobody"),
            NodeKind::Behavior(_) => self.ask_leaf(node, skips),
            NodeKind::And | NodeKind::Tasks => self.ask_and(node, skips),
            NodeKind::Or => self.ask_or(node, skips),
            NodeKind::Then => self.ask_then(node, skips),
        };
        answer.is_satisfied &= !self.runs_below(node);
        if answer.is_satisfied && self.is_not_the_last(node) {
            answer.over.push(node);
            answer.is_satisfied = false;
        }
        answer
    }

    fn ask_leaf(&self, leaf: NodeId, skips: &[NodeRange]) -> Answer {
        let refused = |refusal| Answer { refused: vec![(leaf, refusal)], ..Answer::default() };
        if self.running.contains_key(&leaf) {
            return Answer::default();
        }
        let by = self.redone.get(&leaf).and_then(|(_, by)| *by);
        let is_satisfied = match by {
            Some(by) => self.done.contains(&by) || !self.lacks_what(by, leaf),
            None => self.is_satisfied(leaf, skips),
        };
        if is_satisfied {
            return Answer { is_satisfied: true, ..refused(Reason::Satisfied.into()) };
        }
        if let Some(&(_, wait_ms, fault)) = self.waits.get(&leaf) {
            return refused(Refusal { waits: true, ..Reason::BackingOff { wait_ms, fault }.into() });
        }
        if let Some((progress, heir, lacks)) = self.silent.get(&leaf)
            && *progress == self.progress
        {
            let (heir, lacks) = (*heir, Box::new(lacks.clone()));
            return refused(Reason::AlreadyDone { heir, lacks }.into());
        }
        if let Some(refusal) = self.hidden.get(&leaf).filter(|_| self.request(leaf, skips, false).is_ok()) {
            return refused(refusal.clone());
        }
        if let Some(refusal) = self.too_early(leaf).filter(|_| self.request(leaf, skips, false).is_ok()) {
            return refused(refusal);
        }
        match self.request(leaf, skips, false) {
            Ok(ask) => Answer { asks: vec![ask], ..Answer::default() },
            Err(refusal) => {
                Answer { wishes: self.wish(leaf, skips, &refusal).into_iter().collect(), ..refused(refusal) }
            }
        }
    }

    fn ask_and(&self, node: NodeId, skips: &[NodeRange]) -> Answer {
        let mut whole = Answer { is_satisfied: !self.failing.contains_key(&node), ..Answer::default() };
        for child in self.not_done(node).into_iter().filter(|child| !self.failed.contains(child)) {
            let answer = self.ask(child, skips);
            whole.is_satisfied &= answer.is_satisfied;
            whole.asks.extend(answer.asks);
            whole.wishes.extend(answer.wishes);
            whole.over.extend(answer.over);
            whole.clean.extend(answer.clean);
            whole.refused.extend(answer.refused);
        }
        let (accepted, refused) = self.merge(std::mem::take(&mut whole.asks));
        whole.asks = accepted;
        whole.refused.extend(refused);
        whole
    }

    fn ask_or(&self, node: NodeId, skips: &[NodeRange]) -> Answer {
        let options = match self.committed.get(&node) {
            Some(&child) => vec![child],
            None => self.children(node).into_iter().filter(|child| !self.failed.contains(child)).collect(),
        };
        let mut answers: Vec<_> = options.into_iter().map(|child| (child, self.ask(child, skips))).collect();
        let best_of = |answer: &Answer| answer.asks.iter().map(|ask| ask.grant.request.potential).fold(0.0, f64::max);
        let mut chosen = answers.iter().position(|(_, answer)| answer.is_satisfied);
        let is_satisfied = chosen.is_some();
        let mut best = 0.0;
        for (index, (_, answer)) in answers.iter().enumerate() {
            if !is_satisfied && best_of(answer) > best {
                (chosen, best) = (Some(index), best_of(answer));
            }
        }
        let mut whole = Answer { is_satisfied, ..Answer::default() };
        let winner = chosen.map(|index| answers[index].0);
        for (child, answer) in &mut answers {
            whole.refused.append(&mut answer.refused);
            whole.wishes.append(&mut answer.wishes);
            whole.over.append(&mut answer.over);
            whole.clean.append(&mut answer.clean);
            for ask in answer.asks.drain(..) {
                match winner {
                    Some(chosen) if chosen != *child => {
                        let reason = Reason::Alternative { chosen };
                        whole.refused.push((ask.grant.leaf(), reason.into()));
                    }
                    Some(_) | None => whole.asks.push(ask),
                }
            }
        }
        whole
    }

    fn ask_then(&self, node: NodeId, skips: &[NodeRange]) -> Answer {
        let mut whole = Answer::default();
        let remaining = self.not_done(node);
        for (index, &child) in remaining.iter().enumerate() {
            // What has failed cannot be gone on with.
            if self.failed.contains(&child) {
                whole.is_satisfied = false;
                break;
            }
            let mut skips = skips.to_vec();
            if index > 0 {
                skips.push(NodeRange { from: remaining[0], to: child });
            }
            let answer = self.ask(child, &skips);
            whole.refused.extend(answer.refused);
            whole.asks = answer.asks;
            whole.wishes.extend(answer.wishes);
            whole.over.extend(answer.over);
            whole.clean.extend(answer.clean);
            whole.is_satisfied = answer.is_satisfied;
            if !answer.is_satisfied {
                break;
            }
        }
        whole
    }

    /// Every leaf below that does not run says the same, but for cleanups that go on.
    fn same_answer(&self, node: NodeId, refusal: &Refusal, skips: &[NodeRange]) -> Answer {
        let mut whole = Answer::default();
        if matches!(self.kind(node), NodeKind::Behavior(_)) {
            let idle = (!self.running.contains_key(&node)).then(|| (node, refusal.clone()));
            return Answer { refused: idle.into_iter().collect(), ..whole };
        }
        for child in self.children(node) {
            let below = self.below(child);
            if self.cleaning.iter().any(|cleaning| below.contains(*cleaning)) {
                let answer = self.ask(child, skips);
                whole.asks.extend(answer.asks);
                whole.wishes.extend(answer.wishes);
                whole.over.extend(answer.over);
                whole.clean.extend(answer.clean);
                whole.refused.extend(answer.refused);
                continue;
            }
            let leaves = self.mission.tree.leaves().filter(|leaf| below.contains(*leaf));
            let idle = leaves.filter(|leaf| !self.running.contains_key(leaf));
            whole.refused.extend(idle.map(|leaf| (leaf, refusal.clone())));
        }
        whole
    }

    pub(super) fn not_done(&self, node: NodeId) -> Vec<NodeId> {
        let mut children = self.children(node);
        children.retain(|child| !self.done.contains(child));
        children
    }

    /// Algorithm 1; serially, the best that is possible while nothing runs. Wishes take part behind the requests that
    /// are as urgent, and one that does not fit takes nothing.
    pub(super) fn merge(&self, mut asks: Vec<Ask>) -> (Vec<Ask>, Vec<(NodeId, Refusal)>) {
        asks.sort_by(order);
        let (mut accepted, mut refused): (Vec<Ask>, _) = (Vec::new(), Vec::new());
        for ask in asks {
            let first = accepted.first().map(|other| other.grant.leaf());
            let owner = first.or(self.running.keys().next().copied()).filter(|_| self.is_serial);
            let leaf = ask.grant.leaf();
            let refusal = match owner {
                Some(by) => Some(on(Reason::WholeRobot { by }, by)),
                None => self.incompatible(&accepted, &ask),
            };
            match refusal {
                None if ask.wish.is_some() => {
                    accepted.push(ask);
                    self.keep_cheapest(&mut accepted);
                }
                None => accepted.push(ask),
                Some(refusal) if ask.wish.is_none() => refused.push((leaf, refusal)),
                Some(_) => {}
            }
        }
        (accepted, refused)
    }

    /// The last one takes what is cheapest now, whatever comes behind it.
    fn keep_cheapest(&self, accepted: &mut [Ask]) {
        let chosen = self.cheapest(accepted);
        let last = accepted.last_mut().expect("one that was accepted");
        let own = chosen[chosen.len() - last.serving.len()..].iter();
        for (serving, id) in std::iter::zip(&mut last.serving, own) {
            serving.retain(|(other, _)| other == id);
        }
    }

    fn incompatible(&self, accepted: &[Ask], ask: &Ask) -> Option<Refusal> {
        for &object in &ask.grant.request.changes {
            let mut others = accepted.iter();
            if let Some(other) = others.find(|other| other.grant.request.changes.contains(&object)) {
                let with = other.grant.leaf();
                if other.wish.is_some() {
                    return Some(Reason::Reserved { resource: None, by: with }.into());
                }
                return Some(on(Reason::SameObject { object, with }, with));
            }
        }
        let all = [accepted, std::slice::from_ref(ask)].concat();
        let mut fits = false;
        self.for_each_choice(&all, &mut |_| fits = true);
        if !fits {
            let requests: Vec<Ask> = all.iter().filter(|other| other.wish.is_none()).cloned().collect();
            let (by, resource) = (NodeId(0), ResourceId(0));
            let mut fits_beside_requests = false;
            self.for_each_choice(&requests, &mut |_| fits_beside_requests = true);
            let (own, theirs) = (ask.grant.request.potential, 0.0);
            let wanted = ask.serving.iter().flatten().map(|(id, _)| *id);
            let reason = match fits_beside_requests {
                true => Reason::Reserved { resource: Some(resource), by },
                false => Reason::Outbid { by, resource, own, theirs },
            };
            // Who is in its way alone, if anybody is, and with what.
            let clashes = |other: &&Ask| {
                let mut is_beside = false;
                self.for_each_choice(&[(*other).clone(), ask.clone()], &mut |_| is_beside = true);
                !is_beside
            };
            let blockers: Vec<&Ask> = accepted.iter().filter(clashes).collect();
            let claims_of = |ask: &Ask| -> Vec<(ResourceId, Access)> {
                let claims = std::iter::zip(&self.behavior(ask.grant.leaf()).claims, &ask.serving);
                claims.flat_map(|(claim, serving)| serving.iter().map(|(id, _)| (*id, claim.access))).collect()
            };
            let theirs: Vec<_> = blockers.iter().flat_map(|other| claims_of(other)).collect();
            let is_contested = |(id, access): &(ResourceId, Access)| {
                theirs.iter().any(|(other, used)| other == id && (used != access || *used == Access::Exclusive))
            };
            let contested: Vec<_> = claims_of(ask).into_iter().filter(is_contested).map(|(id, _)| id).collect();
            let behaviors = blockers.iter().map(|other| other.grant.leaf()).collect();
            let resources = if blockers.is_empty() { wanted.collect() } else { contested };
            return Some(Refusal { resources, behaviors, ..reason.into() });
        }
        let others = self.running.keys().copied().chain(accepted.iter().map(|other| other.grant.leaf()));
        let clash = others.into_iter().find(|&other| self.clashes(other, ask.grant.leaf()))?;
        Some(on(Reason::Clash { with: clash, over: Clash::Rule }, clash))
    }

    fn clashes(&self, a: NodeId, b: NodeId) -> bool {
        self.clashing.contains(&(a, b)) || self.clashing.contains(&(b, a))
    }

    /// Every way to give each claim a resource so that nothing serves two, except on one channel.
    pub(super) fn for_each_choice(&self, asks: &[Ask], found: &mut impl FnMut(&[(ResourceId, f64)])) {
        let claims: Vec<Claimed<'_>> = asks
            .iter()
            .flat_map(|ask| {
                let claims = &self.behavior(ask.grant.leaf()).claims;
                let serving = std::iter::zip(claims, &ask.serving);
                serving.map(|(claim, serving)| (ask.grant.leaf(), claim.access, serving.as_slice()))
            })
            .collect();
        choose(&claims, &mut Vec::new(), found);
    }

    /// The cheapest way for the whole set, the first in resource order among equals.
    fn cheapest(&self, accepted: &[Ask]) -> Vec<ResourceId> {
        let per_claim = accepted.iter().flat_map(|ask| ask.serving.iter().map(|_| ask.wish.as_ref()));
        let per_claim: Vec<_> = per_claim.collect();
        let mut best: Option<(u32, f64, Vec<ResourceId>)> = None;
        self.for_each_choice(accepted, &mut |choice| {
            let cost: f64 = choice.iter().map(|(_, cost)| cost).sum();
            let ranks = std::iter::zip(choice, &per_claim).filter_map(|((id, _), wish)| wish.map(|wish| wish[id]));
            let rank: u32 = ranks.sum();
            let is_better =
                |(other, least, _): &(u32, f64, _)| rank < *other || (rank == *other && cost < least - 1e-9);
            if best.as_ref().is_none_or(is_better) {
                best = Some((rank, cost, choice.iter().map(|(id, _)| *id).collect()));
            }
        });
        best.map(|(.., chosen)| chosen).unwrap_or_default()
    }

    /// Grants, and what wishes take.
    pub(super) fn bind(&self, accepted: &[Ask]) -> (Vec<Grant>, Vec<Grant>) {
        let mut chosen = self.cheapest(accepted).into_iter();
        let (mut grants, mut taken) = (Vec::new(), Vec::new());
        for ask in accepted {
            let mut grant = ask.grant.clone();
            for claim in &self.behavior(grant.leaf()).claims {
                let resource = chosen.next().expect("a resource for every claim");
                grant.bindings.push(Binding { resource, access: claim.access, keep: claim.keep });
            }
            if ask.wish.is_some() {
                taken.push(grant);
                continue;
            }
            if self.is_serial {
                self.add_the_rest(&mut grant);
            }
            grants.push(grant);
        }
        (grants, taken)
    }

    fn add_the_rest(&self, grant: &mut Grant) {
        for (index, row) in self.rows.iter().enumerate() {
            let resource = ResourceId::from(index);
            let is_claimed = grant.bindings.iter().any(|binding| binding.resource == resource);
            if row.leases.is_empty() && !is_claimed && self.outage(resource).is_none() {
                grant.bindings.push(Binding { resource, access: Access::Exclusive, keep: Retention::Release });
            }
        }
    }
}

type Claimed<'a> = (NodeId, Access, &'a [(ResourceId, f64)]);

fn choose(claims: &[Claimed<'_>], chosen: &mut Vec<(ResourceId, f64)>, found: &mut impl FnMut(&[(ResourceId, f64)])) {
    let Some(&(leaf, access, serving)) = claims.get(chosen.len()) else {
        return found(chosen);
    };
    for &(resource, cost_m) in serving {
        let mut before = std::iter::zip(claims, chosen.iter());
        let is_free = before.all(|(&(other, used, _), &(taken, _))| {
            taken != resource || (other != leaf && used == access && used != Access::Exclusive)
        });
        if is_free {
            chosen.push((resource, cost_m));
            choose(claims, chosen, found);
            chosen.pop();
        }
    }
}

fn on(reason: Reason, behavior: NodeId) -> Refusal {
    Refusal { behaviors: vec![behavior], ..reason.into() }
}

/// The order of requests, and of wishes behind the requests that are as urgent.
pub(super) fn order(a: &Ask, b: &Ask) -> Ordering {
    let (one, other) = (&a.grant.request, &b.grant.request);
    let by_turn = a.wish.is_some().cmp(&b.wish.is_some()).then(b.is_overdue.cmp(&a.is_overdue));
    let by_urgency = other.priority.cmp(&one.priority).then(by_turn);
    let by_potential = one.iterations.cmp(&other.iterations).then(other.potential.total_cmp(&one.potential));
    by_urgency.then(by_potential).then(b.is_heir.cmp(&a.is_heir)).then(one.leaf.cmp(&other.leaf))
}
