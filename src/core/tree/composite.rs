//! The actor of a task node (III-C): passes the view down, and answers once for everything below it. What it knows of
//! its children stands in the view; it keeps the open round, and what they said last.

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
    children: Vec<Child>,
    open: Option<Open>,
}

/// A child and what it said last.
#[derive(Debug)]
struct Child {
    id: NodeId,
    said: Option<Said>,
}

/// An answer, with what it depends on beside the state.
#[derive(Debug)]
struct Said {
    round: u32,
    skips: Arc<[NodeRange]>,
    answer: Option<Answer>,
}

/// A round from activation to verdict.
#[derive(Debug)]
struct Open {
    view: Arc<View>,
    /// What was skipped above.
    skips: Arc<[NodeRange]>,
    /// Children whose answers count, by index, in their order.
    asked: Vec<usize>,
    /// Those of them that were activated: the others would say again what they said.
    activated: Vec<usize>,
    /// How many of these have not answered.
    waiting: usize,
}

impl Composite {
    pub(super) fn new(id: NodeId, ordering: Ordering, mission: &Arc<MissionSpec>, settings: &Settings) -> Self {
        let children = mission.tree.topology.children(id).map(|id| Child { id, said: None }).collect();
        let (mission, allocator) = (Arc::clone(mission), Arc::clone(&settings.allocator));
        Self { id, ordering, mission, allocator, children, open: None }
    }

    pub(super) fn on_down(&mut self, down: Down, out: &mut Outbox) {
        match down {
            Down::Activation(activation) => self.on_activation(activation, out),
            Down::Verdict(verdict) => self.on_verdict(&verdict, out),
        }
    }

    pub(super) fn on_answer(&mut self, child: NodeId, answer: Answer, out: &mut Outbox) {
        let index = self.index_of(child);
        let said = self.children[index].said.as_mut().expect("only those answer that were asked");
        assert!(said.answer.replace(answer).is_none(), "{child:?} answered twice");
        self.open.as_mut().expect("answers come to an open round").waiting -= 1;
        self.go_on(index, out);
        self.answer_if_complete(out);
    }

    fn on_activation(&mut self, Activation { view, skips }: Activation, out: &mut Outbox) {
        assert!(self.open.is_none(), "one round at a time");
        let first = match view.state.phase(self.id) {
            Phase::Failing(_) => Vec::new(),
            Phase::Pending | Phase::Done | Phase::Failed => self.ordering.first(&view.state, self.id),
        };
        let asked = Vec::with_capacity(first.len());
        self.open = Some(Open { view, skips: Arc::clone(&skips), asked, activated: Vec::new(), waiting: 0 });
        // Both are in tree order.
        let mut index = 0;
        for child in first {
            while self.children[index].id < child {
                index += 1;
            }
            self.ask(index, &skips, out);
        }
        self.answer_if_complete(out);
    }

    /// Activates a child, unless it would say again what it said.
    fn ask(&mut self, index: usize, skips: &Arc<[NodeRange]>, out: &mut Outbox) {
        let child = &mut self.children[index];
        let open = self.open.as_mut().expect("children are asked in an open round");
        open.asked.push(index);
        let is_fresh = |said: &Said| open.view.is_fresh(child.id, said.round) && said.skips == *skips;
        if child.said.as_ref().is_some_and(is_fresh) {
            self.go_on(index, out);
            return;
        }
        child.said = Some(Said { round: open.view.round, skips: Arc::clone(skips), answer: None });
        open.activated.push(index);
        open.waiting += 1;
        let (view, skips) = (Arc::clone(&open.view), Arc::clone(skips));
        out.push(Effect::Down(child.id, Down::Activation(Activation { view, skips })));
    }

    /// A THEN goes on behind a child that is satisfied.
    fn go_on(&mut self, index: usize, out: &mut Outbox) {
        let open = self.open.as_ref().expect("children answer in an open round");
        let child = &self.children[index];
        let is_satisfied = self.answer_of(index).is_satisfied;
        let next = if is_satisfied { self.ordering.behind(&open.view.state, self.id, child.id) } else { None };
        if let Some(next) = next {
            let first = self.children[open.asked[0]].id;
            let skip = NodeRange { from: first, to: next };
            let skips: Arc<[NodeRange]> = open.skips.iter().copied().chain([skip]).collect();
            self.ask(self.index_of(next), &skips, out);
        }
    }

    fn answer_if_complete(&mut self, out: &mut Outbox) {
        let open = self.open.as_ref().expect("only an open round is answered");
        if open.waiting > 0 {
            return;
        }
        let answers: Vec<(NodeId, &Answer)> =
            open.asked.iter().map(|&index| (self.children[index].id, self.answer_of(index))).collect();
        let view = &open.view;
        let mut answer = match view.state.phase(self.id) {
            Phase::Failing(failing) => self.failing_answer(view, failing.child),
            Phase::Pending | Phase::Done | Phase::Failed => {
                self.ordering.answer(self.id, view, &*self.allocator, &answers)
            }
        };
        answer.round = view.round;
        out.push(Effect::Up(Up::Answer(Box::new(answer))));
    }

    fn answer_of(&self, index: usize) -> &Answer {
        let said = self.children[index].said.as_ref().and_then(|said| said.answer.as_ref());
        said.expect("who is asked answers before it counts")
    }

    fn index_of(&self, child: NodeId) -> usize {
        self.children.binary_search_by_key(&child, |child| child.id).expect("children speak to their parent")
    }

    /// A node that waits for its running children to end asks for nothing more.
    fn failing_answer(&self, view: &View, failed: NodeId) -> Answer {
        let tree = &self.mission.tree;
        let leaves = (self.id.0..tree.topology.end(self.id).0).map(NodeId);
        let idle = leaves.filter(|leaf| tree.behavior(*leaf).is_some() && !view.state.running().contains_key(leaf));
        let blocked = idle.map(|leaf| Blocked { leaf, reason: Reason::Ending { failed } }).collect();
        Answer { is_running: true, blocked, ..Answer::default() }
    }

    /// Goes to whoever was activated, and to where something starts or is to end.
    fn on_verdict(&mut self, verdict: &Arc<Verdict>, out: &mut Outbox) {
        let mut told = self.open.take().map(|open| open.activated).unwrap_or_default();
        let about = verdict.about(&self.mission.tree.topology, self.id);
        told.extend(about.map(|leaf| self.children.partition_point(|child| child.id <= leaf) - 1));
        told.sort_unstable();
        told.dedup();
        for index in told {
            out.push(Effect::Down(self.children[index].id, Down::Verdict(Arc::clone(verdict))));
        }
    }
}
