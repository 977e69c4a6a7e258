//! The actor of a low-level behavior: asks, starts its goal, and passes on how it ended (III-B).

use std::sync::Arc;

use super::ordering::is_repeated;
use super::{Activation, Answer, Down, Effect, Outbox, Release, Requests, Up, Verdict, fairness};
use crate::behavior;
use crate::world::{KnownPaths, View};
use ambidex_model::{BehaviorSpec, Lineage, MissionSpec, NodeId, NodeRange, Outcome, Reason, Request};

/// The machine of a leaf. Of the run it knows what the view says; it keeps what it said last and the paths that it asked
/// for.
#[derive(Debug)]
pub struct Leaf {
    id: NodeId,
    mission: Arc<MissionSpec>,
    round: u32,
    said: Arc<Answer>,
    known_paths: KnownPaths,
}

impl Leaf {
    pub(super) fn new(id: NodeId, mission: &Arc<MissionSpec>) -> Self {
        let mission = Arc::clone(mission);
        Self { id, mission, round: 0, said: Arc::default(), known_paths: KnownPaths::default() }
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
                    let is_satisfied = !is_repeated(&self.mission.tree, &view.state, self.id);
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
        let (tree, priority) = (&self.mission.tree, view.priority(self.id));
        if !reason.is_of_resources() || tree.least_priority() >= priority {
            return None;
        }
        let line = Lineage { topology: &tree.topology, node: self.id, skips };
        let own = spec(&self.mission, self.id);
        let (spec, place) = (own.as_in(view.state.world()), own.place_in(view.state.world()));
        let wish = behavior::wish(spec, view, &line, &mut self.known_paths, priority)?;
        let wish = self.ranked(view, Request { place, ..wish });
        let said = self.said.wish.as_ref().filter(|said| ***said == wish);
        Some(said.cloned().unwrap_or_else(|| Arc::new(wish)))
    }

    /// With what it is ordered by beside its potential.
    fn ranked(&self, view: &View, request: Request) -> Request {
        Request { priority: view.priority(self.id), iterations: self.iterations(view), ..request }
    }

    /// How often the outermost node at or above it that repeats has been done.
    fn iterations(&self, view: &View) -> u32 {
        let tree = &self.mission.tree;
        if tree.repeats.is_empty() {
            return 0;
        }
        let outermost = tree.topology.path(self.id).filter(|above| tree.repeats.contains_key(above)).last();
        outermost.map_or(0, |node| view.state.iterations(node))
    }

    /// Why it is not its turn, though it could run: a task that came before has waited for longer.
    fn is_too_early(&self, view: &View) -> Option<Reason> {
        let task = fairness::barred_by(&self.mission.tree, &view.state, self.id)?;
        Some(Reason::TooEarly { task })
    }

    fn answer(&mut self, view: &View, skips: &[NodeRange]) -> behavior::Answer {
        if let Some(pause) = view.state.pauses().get(&self.id) {
            return behavior::Answer::Blocked(pause.reason(self.id));
        }
        let tree = &self.mission.tree;
        let line = Lineage { topology: &tree.topology, node: self.id, skips };
        let own = spec(&self.mission, self.id);
        let (spec, place) = (own.as_in(view.state.world()), own.place_in(view.state.world()));
        let bar = view.state.status(self.id).bar.as_ref().filter(|bar| bar.progress == view.state.progress());
        let answer = match view.state.redone().get(&self.id).and_then(|redone| redone.leaf) {
            Some(by) => behavior::answer_again(spec, view, &line, &mut self.known_paths, by),
            None => behavior::answer(spec, view, &line, &mut self.known_paths),
        };
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
                    None => behavior::Answer::Request(self.ranked(view, Request { place, ..request })),
                },
            },
            (answer @ behavior::Answer::Blocked(_), None) => answer,
        }
    }

    fn on_verdict(&mut self, verdict: &Verdict, out: &mut Outbox) {
        if let (Some(grant), Some(view)) = (verdict.granted.get(&self.id), &verdict.view) {
            let spec = spec(&self.mission, self.id).at(grant.request.place);
            out.push(Effect::Start(behavior::goal(spec, grant, view, &mut self.known_paths)));
        }
        if verdict.stopped.contains(&self.id) {
            out.push(Effect::Stop(self.id));
        }
    }
}

fn spec(mission: &MissionSpec, leaf: NodeId) -> &BehaviorSpec {
    mission.tree.behavior(leaf).expect("a leaf has a behavior")
}
