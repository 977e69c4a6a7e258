//! The actor of a low-level behavior: asks, starts its goal, and passes on how it ended (III-B).

use std::sync::Arc;

use super::ahead;
use super::ordering::is_repeated;
use super::{Activation, Answer, Down, Effect, Outbox, Release, Requests, Up, Verdict, fairness};
use crate::behavior::{self, Asking};
use crate::world::{View, beside_running};
use ambidex_model::{
    BehaviorSpec, Lineage, MissionSpec, NodeId, NodeRange, Outcome, PlaceId, Reason, Request, StandId,
};

/// The machine of a leaf. Of the run it knows what the view says; it keeps what it said last.
#[derive(Debug)]
pub struct Leaf {
    id: NodeId,
    round: u32,
    said: Arc<Answer>,
}

impl Leaf {
    pub(super) fn new(id: NodeId) -> Self {
        Self { id, round: 0, said: Arc::default() }
    }

    pub(super) fn on_down(&mut self, down: Down, out: &mut Outbox) {
        self.round = down.round();
        match down {
            Down::Activation(activation) => self.on_activation(activation, out),
            Down::Verdict(verdict) => self.on_verdict(&verdict, out),
        }
    }

    /// Its controllers are finished with its goal.
    pub(super) fn on_end(&self, outcome: Outcome, out: &mut Outbox) {
        let release = Release { round: self.round, leaf: self.id, outcome };
        out.push(Effect::Up(Up::Release(Box::new(release))));
    }

    fn on_activation(&mut self, Activation { view, skips, .. }: Activation, out: &mut Outbox) {
        let answer = if view.state.running().contains_key(&self.id) {
            Answer { is_running: true, ..Answer::default() }
        } else {
            match self.answer(&view, &skips) {
                behavior::Answer::Request(request) => Answer { requests: self.again(request), ..Answer::default() },
                behavior::Answer::Satisfied => {
                    // What is done more than once is satisfied the last time only.
                    let is_satisfied = !is_repeated(&view.mission.tree, &view.state, self.id);
                    Answer { is_satisfied, reason: Some(Reason::Satisfied), ..Answer::default() }
                }
                behavior::Answer::Blocked(reason) => {
                    let wish = self.wish(&view, &skips, &reason);
                    Answer { reason: Some(reason), wish, ..Answer::default() }
                }
            }
        };
        if answer != *self.said {
            self.said = Arc::new(answer);
        }
        let (from, answer) = (self.id, Arc::clone(&self.said));
        out.push(Effect::Up(Up::Answer { from, round: view.round, answer, news: None }));
    }

    /// The request that was made last, if this one is the same.
    fn again(&self, request: Request) -> Requests {
        match self.said.requests.first() {
            Some(last) if **last == request => self.said.requests.clone(),
            Some(_) | None => Requests::One(Arc::new(request)),
        }
    }

    /// What it would ask for if nothing ran, and less urgent holders kept nothing for their intentions.
    fn wish(&mut self, view: &View, skips: &[NodeRange], reason: &Reason) -> Option<Arc<Request>> {
        let (tree, priority) = (&view.mission.tree, view.priority(self.id));
        if !reason.is_of_resources() || tree.least_priority() >= priority {
            return None;
        }
        let line = Lineage { topology: &tree.topology, node: self.id, skips };
        let ahead = |hand, object| ahead::out_of_reach(&view.mission, line.node, hand, object);
        let asking = Asking { view, line: &line, ahead: &ahead };
        let wishes = self.ways(view).into_iter().filter_map(|way| {
            let wish = behavior::wish(way.spec, &asking, priority)?;
            Some(way.asked(wish))
        });
        let wish = best(wishes.collect())?;
        let wish = self.ranked(view, wish);
        let said = self.said.wish.as_ref().filter(|said| ***said == wish);
        Some(said.cloned().unwrap_or_else(|| Arc::new(wish)))
    }

    /// The behavior as the world is, at each stand that is as good as any: for a drive those from which most of what comes
    /// next can be reached. The nearest comes first, which is the one where the base stands if it stands at one.
    fn ways<'a>(&self, view: &'a View) -> Vec<Way<'a>> {
        let own = spec(&view.mission, self.id);
        let (spec, place) = (own.as_in(view.state.world()), own.place_in(view.state.world()));
        let Some(stands) = &spec.stands else { return vec![Way { spec, place, stand: None }] };
        let base = view.state.world().base;
        let worth = |spec: &BehaviorSpec| match behavior::driven_to(spec) {
            Some(stand) => ahead::reached_from(&view.mission, &view.state, self.id, stand),
            None => 0,
        };
        let ways = stands.iter().enumerate().map(|(stand, spec)| {
            let far_m = behavior::stand(spec).map_or(f64::INFINITY, |at| base.distance_m(&at));
            (worth(spec), far_m, Way { spec, place, stand: Some(StandId::from(stand)) })
        });
        let mut ways: Vec<_> = ways.collect();
        let most = ways.iter().map(|(worth, ..)| *worth).max().unwrap_or_default();
        ways.retain(|(worth, ..)| *worth == most);
        ways.sort_by(|(_, one, _), (_, other, _)| one.total_cmp(other));
        ways.into_iter().map(|(_, _, way)| way).collect()
    }

    /// With what it is ordered by beside its potential.
    fn ranked(&self, view: &View, request: Request) -> Request {
        Request { priority: view.priority(self.id), iterations: self.iterations(view), ..request }
    }

    /// How often the outermost node at or above it that repeats has been done.
    fn iterations(&self, view: &View) -> u32 {
        let tree = &view.mission.tree;
        if tree.repeats.is_empty() {
            return 0;
        }
        let outermost = tree.topology.path(self.id).filter(|above| tree.repeats.contains_key(above)).last();
        outermost.map_or(0, |node| view.state.iterations(node))
    }

    /// Why it is not its turn, though it could run: a task that came before has waited for longer.
    fn is_too_early(&self, view: &View) -> Option<Reason> {
        let task = fairness::barred_by(&view.mission.tree, &view.state, self.id)?;
        Some(Reason::TooEarly { task })
    }

    fn answer(&mut self, view: &View, skips: &[NodeRange]) -> behavior::Answer {
        if let Some(pause) = view.state.pauses().get(&self.id) {
            return behavior::Answer::Blocked(pause.reason(self.id));
        }
        let tree = &view.mission.tree;
        let line = Lineage { topology: &tree.topology, node: self.id, skips };
        let bar = view.state.status(self.id).bar.as_ref().filter(|bar| bar.progress == view.state.progress());
        let ahead = |hand, object| ahead::out_of_reach(&view.mission, line.node, hand, object);
        let asking = Asking { view, line: &line, ahead: &ahead };
        let sent_by = view.state.redone().get(&self.id).and_then(|redone| redone.leaf);
        let answer = first_or_best(self.ways(view).into_iter().map(|way| {
            let answer = match sent_by {
                Some(by) => behavior::answer_again(way.spec, &asking, by),
                None => behavior::answer(way.spec, &asking),
            };
            match answer {
                behavior::Answer::Request(request) => match beside_running(view, way.asked(request)) {
                    Ok(request) => behavior::Answer::Request(request),
                    Err(reason) => behavior::Answer::Blocked(reason),
                },
                behavior::Answer::Satisfied | behavior::Answer::Blocked(_) => answer,
            }
        }));
        if let (Some(wait), false) = (&view.state.status(self.id).wait, answer == behavior::Answer::Satisfied) {
            return behavior::Answer::Blocked(wait.reason());
        }
        match (answer, bar) {
            (behavior::Answer::Satisfied, _) => behavior::Answer::Satisfied,
            (_, Some(bar)) => behavior::Answer::Blocked(Reason::AlreadyDone {
                heir: bar.heir.leaf,
                lacks: Box::new(bar.heir.reason.root_cause().clone()),
            }),
            (behavior::Answer::Request(request), None) => match view.barred.get(&self.id) {
                Some(reason) => behavior::Answer::Blocked(reason.clone()),
                None => match self.is_too_early(view) {
                    Some(reason) => behavior::Answer::Blocked(reason),
                    None => behavior::Answer::Request(self.ranked(view, request)),
                },
            },
            (answer @ behavior::Answer::Blocked(_), None) => answer,
        }
    }

    fn on_verdict(&mut self, verdict: &Verdict, out: &mut Outbox) {
        if let (Some(grant), Some(view)) = (verdict.granted.get(&self.id), &verdict.view) {
            let spec = spec(&view.mission, self.id).asked(&grant.request);
            out.push(Effect::Start(behavior::goal(spec, grant, view)));
        }
        if verdict.stopped.contains(&self.id) {
            out.push(Effect::Stop(self.id));
        }
    }
}

/// A behavior as it could be asked for.
#[derive(Clone, Copy)]
struct Way<'a> {
    spec: &'a BehaviorSpec,
    place: Option<PlaceId>,
    stand: Option<StandId>,
}

impl Way<'_> {
    fn asked(&self, request: Request) -> Request {
        Request { place: self.place, stand: self.stand, ..request }
    }
}

/// The request of the highest potential, of these in which it is equal the first.
fn best(requests: Vec<Request>) -> Option<Request> {
    requests.into_iter().reduce(|best, next| if next.potential > best.potential { next } else { best })
}

/// What a behavior says of which each way says something: satisfied where one is, else what it asks for by the best way, else
/// why the first is blocked.
fn first_or_best(answers: impl Iterator<Item = behavior::Answer>) -> behavior::Answer {
    let (mut requests, mut blocked) = (Vec::new(), None);
    for answer in answers {
        match answer {
            behavior::Answer::Satisfied => return answer,
            behavior::Answer::Request(request) => requests.push(request),
            behavior::Answer::Blocked(reason) => blocked = blocked.or(Some(reason)),
        }
    }
    match (best(requests), blocked) {
        (Some(request), _) => behavior::Answer::Request(request),
        (None, Some(reason)) => behavior::Answer::Blocked(reason),
        (None, None) => behavior::Answer::Blocked(Reason::Unwanted),
    }
}

fn spec(mission: &MissionSpec, leaf: NodeId) -> &BehaviorSpec {
    mission.tree.behavior(leaf).expect("a leaf has a behavior")
}
