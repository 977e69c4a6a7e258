//! A low-level behavior: asks, runs, and hands over (III-B).

use std::sync::Arc;

use super::{Activation, Answer, Down, Effect, Outbox, Release, Up, Verdict};
use crate::behavior;
use crate::world::{KnownPaths, View};
use ambidex_model::{
    BehaviorSpec, Blocked, Completion, Consequences, End, Grant, Lineage, MissionSpec, NodeId, NodeRange, Outcome,
    Reason, Request,
};

/// The machine of a leaf.
#[derive(Debug)]
pub struct Leaf {
    id: NodeId,
    mission: Arc<MissionSpec>,
    round: u32,
    proposal: Option<Arc<View>>,
    grant: Option<Grant>,
    failures: u32,
    lapsed: Option<Lapsed>,
    known_paths: KnownPaths,
}

/// Why it does not ask although it is not done.
#[derive(Debug)]
struct Lapsed {
    progress: u64,
    for_whom: Blocked,
}

impl Leaf {
    pub(super) fn new(id: NodeId, mission: &Arc<MissionSpec>) -> Self {
        Self {
            id,
            mission: Arc::clone(mission),
            round: 0,
            proposal: None,
            grant: None,
            failures: 0,
            lapsed: None,
            known_paths: KnownPaths::default(),
        }
    }

    pub(super) fn on_down(&mut self, down: Down, out: &mut Outbox) {
        self.round = down.round();
        match down {
            Down::Activation(activation) => self.on_activation(activation, out),
            Down::Verdict(verdict) => self.on_verdict(&verdict, out),
            Down::Reopen(verdict) => self.reopened(&verdict),
            Down::Cancel(_) => {
                if self.grant.is_some() {
                    out.push(Effect::Stop(self.id));
                }
            }
        }
    }

    /// Its controllers are finished with its goal.
    pub(super) fn on_end(&mut self, mut outcome: Outcome, out: &mut Outbox) {
        let grant = self.grant.take().expect("only what was granted ends");
        outcome.end = behavior::believed(self.spec(), &grant, &outcome);
        let consequences = match outcome.end {
            End::Succeeded => Consequences { completed: Some(Completion { node: self.id, heir: None }), failed: None },
            End::Failed(_) => {
                self.failures += 1;
                let is_final = self.failures > self.spec().retries;
                Consequences { completed: None, failed: is_final.then_some(self.id) }
            }
            End::Canceled => Consequences::default(),
        };
        let changes = behavior::changes(self.spec(), &grant, &outcome);
        let release = Release { round: self.round, leaf: self.id, outcome, changes, consequences, cause: self.id };
        out.push(Effect::Up(Up::Release(Box::new(release))));
    }

    fn spec(&self) -> &BehaviorSpec {
        self.mission.tree.behavior(self.id).expect("a leaf has a behavior")
    }

    fn on_activation(&mut self, Activation { view, skips }: Activation, out: &mut Outbox) {
        let mut answer = Answer { round: view.round, ..Answer::default() };
        // What ended while this round was on its way still runs in the eyes of root.
        if view.running.contains_key(&self.id) {
            answer.is_running = true;
        } else {
            match self.proposal(&view, &skips) {
                behavior::Answer::Request(request) => answer.requests.push(Arc::new(request)),
                behavior::Answer::Satisfied => {
                    answer.is_satisfied = true;
                    answer.blocked.push(Blocked { leaf: self.id, reason: Reason::Satisfied });
                }
                behavior::Answer::Blocked(reason) => {
                    answer.blocked.push(Blocked { leaf: self.id, reason });
                }
            }
        }
        if !answer.requests.is_empty() {
            self.proposal = Some(view);
        }
        out.push(Effect::Up(Up::Answer(Box::new(answer))));
    }

    fn proposal(&mut self, view: &View, skips: &[NodeRange]) -> behavior::Answer {
        let tree = &self.mission.tree;
        let spec = tree.behavior(self.id).expect("a leaf has a behavior");
        let line = Lineage { topology: &tree.topology, node: self.id, skips };
        let lapsed = self.lapsed.as_ref().filter(|lapsed| lapsed.progress == view.progress);
        match (behavior::answer(spec, view, &line, &mut self.known_paths), lapsed) {
            (behavior::Answer::Satisfied, _) => behavior::Answer::Satisfied,
            (_, Some(Lapsed { for_whom, .. })) => behavior::Answer::Blocked(Reason::AlreadyDone {
                heir: for_whom.leaf,
                lacks: Box::new(for_whom.reason.root_cause().clone()),
            }),
            (answer @ (behavior::Answer::Request(Request { .. }) | behavior::Answer::Blocked(_)), None) => answer,
        }
    }

    fn on_verdict(&mut self, verdict: &Verdict, out: &mut Outbox) {
        let proposal = self.proposal.take();
        if let (Some(grant), Some(view)) = (verdict.granted.get(&self.id), proposal) {
            let spec = self.mission.tree.behavior(self.id).expect("a leaf has a behavior");
            out.push(Effect::Start(behavior::goal(spec, grant, &view, &mut self.known_paths)));
            self.grant = Some(grant.clone());
            self.lapsed = None;
        }
    }

    fn reopened(&mut self, verdict: &Verdict) {
        let lacks = verdict.reopened.as_ref().and_then(|reopened| reopened.lacks.clone());
        self.lapsed = lacks.map(|for_whom| Lapsed { progress: verdict.progress, for_whom: *for_whom });
    }
}
