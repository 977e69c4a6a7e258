//! The actor of a low-level behavior: asks, starts its goal, and passes on how it ended (III-B).

use std::sync::Arc;

use super::{Activation, Answer, Down, Effect, Outbox, Release, Requests, Up, Verdict};
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
                    Answer { is_satisfied: true, reason: Some(Reason::Satisfied), ..Answer::default() }
                }
                behavior::Answer::Blocked(reason) => Answer { reason: Some(reason), ..Answer::default() },
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

    fn answer(&mut self, view: &View, skips: &[NodeRange]) -> behavior::Answer {
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
                None => behavior::Answer::Request(Request { place, ..request }),
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
