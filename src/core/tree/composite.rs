//! The actor of a task node (III-C): passes the view down, and answers once for everything below it. What it knows of
//! its children stands in the view; it keeps nothing but the open round.

use std::sync::Arc;

use super::ordering::Ordering;
use super::{Activation, Allocator, Answer, Down, Effect, Outbox, Settings, Up, Verdict};
use crate::world::View;
use ambidex_model::state::Phase;
use ambidex_model::{Blocked, MissionSpec, NodeId, NodeRange, Reason};

/// The machine of a task node.
#[derive(Debug)]
pub struct Composite {
    id: NodeId,
    ordering: Ordering,
    mission: Arc<MissionSpec>,
    allocator: Arc<dyn Allocator>,
    open: Option<Open>,
}

/// A round from activation to verdict.
#[derive(Debug)]
struct Open {
    view: Arc<View>,
    /// What was skipped above.
    skips: Arc<[NodeRange]>,
    /// Children asked in their order, each with its answer.
    asked: Vec<(NodeId, Option<Answer>)>,
    /// How many of them have not answered.
    waiting: usize,
}

impl Composite {
    pub(super) fn new(id: NodeId, ordering: Ordering, mission: &Arc<MissionSpec>, settings: &Settings) -> Self {
        let (mission, allocator) = (Arc::clone(mission), Arc::clone(&settings.allocator));
        Self { id, ordering, mission, allocator, open: None }
    }

    pub(super) fn on_down(&mut self, down: Down, out: &mut Outbox) {
        match down {
            Down::Activation(activation) => self.on_activation(activation, out),
            Down::Verdict(verdict) => self.on_verdict(&verdict, out),
        }
    }

    pub(super) fn on_answer(&mut self, child: NodeId, answer: Answer, out: &mut Outbox) {
        let open = self.open.as_mut().expect("answers come to an open round");
        let is_satisfied = answer.is_satisfied;
        let index = open.asked.binary_search_by_key(&child, |(asked, _)| *asked);
        let slot = &mut open.asked[index.expect("only those answer that were asked")].1;
        assert!(slot.replace(answer).is_none(), "{child:?} answered twice");
        open.waiting -= 1;
        let next = if is_satisfied { self.ordering.behind(&open.view.state, self.id, child) } else { None };
        match next {
            Some(next) => {
                let (first, _) = *open.asked.first().expect("somebody was asked");
                let skip = NodeRange { from: first, to: next };
                let skips = open.skips.iter().copied().chain([skip]).collect();
                self.ask(next, skips, out);
            }
            None => self.answer_if_complete(out),
        }
    }

    fn on_activation(&mut self, Activation { view, skips }: Activation, out: &mut Outbox) {
        assert!(self.open.is_none(), "one round at a time");
        let first = match view.state.phase(self.id) {
            Phase::Failing(_) => Vec::new(),
            Phase::Pending | Phase::Done | Phase::Failed => self.ordering.first(&view.state, self.id),
        };
        self.open = Some(Open { view, skips: Arc::clone(&skips), asked: Vec::with_capacity(first.len()), waiting: 0 });
        for child in first {
            self.ask(child, Arc::clone(&skips), out);
        }
        self.answer_if_complete(out);
    }

    fn ask(&mut self, child: NodeId, skips: Arc<[NodeRange]>, out: &mut Outbox) {
        let open = self.open.as_mut().expect("children are asked in an open round");
        open.asked.push((child, None));
        open.waiting += 1;
        let view = Arc::clone(&open.view);
        out.push(Effect::Down(child, Down::Activation(Activation { view, skips })));
    }

    fn answer_if_complete(&mut self, out: &mut Outbox) {
        let open = self.open.as_mut().expect("only an open round is answered");
        if open.waiting > 0 {
            return;
        }
        let take = |(child, answer): &mut (NodeId, Option<Answer>)| {
            (*child, std::mem::take(answer.as_mut().expect("all have answered")))
        };
        let answers: Vec<(NodeId, Answer)> = open.asked.iter_mut().map(take).collect();
        let view = Arc::clone(&open.view);
        let mut answer = match view.state.phase(self.id) {
            Phase::Failing(failing) => self.failing_answer(&view, failing.child),
            Phase::Pending | Phase::Done | Phase::Failed => {
                self.ordering.answer(self.id, &view, &*self.allocator, answers)
            }
        };
        answer.round = view.round();
        out.push(Effect::Up(Up::Answer(Box::new(answer))));
    }

    /// A node that waits for its running children to end asks for nothing more.
    fn failing_answer(&self, view: &View, failed: NodeId) -> Answer {
        let tree = &self.mission.tree;
        let leaves = (self.id.0..tree.topology.end(self.id).0).map(NodeId);
        let idle = leaves.filter(|leaf| tree.behavior(*leaf).is_some() && !view.state.running().contains_key(leaf));
        let blocked = idle.map(|leaf| Blocked { leaf, reason: Reason::Ending { failed } }).collect();
        Answer { is_running: true, blocked, ..Answer::default() }
    }

    /// Goes to whoever was asked, and to whoever is told to end.
    fn on_verdict(&mut self, verdict: &Arc<Verdict>, out: &mut Outbox) {
        let asked = self.open.take().map(|open| open.asked).unwrap_or_default();
        for (child, _) in &asked {
            out.push(Effect::Down(*child, Down::Verdict(Arc::clone(verdict))));
        }
        if !verdict.stopped.is_empty() {
            let topology = &self.mission.tree.topology;
            let is_asked = |child: &NodeId| asked.binary_search_by_key(child, |(asked, _)| *asked).is_ok();
            let others = topology.children(self.id).filter(|child| !is_asked(child));
            for child in others.filter(|child| verdict.stops_below(topology, *child)) {
                out.push(Effect::Down(child, Down::Verdict(Arc::clone(verdict))));
            }
        }
    }
}
