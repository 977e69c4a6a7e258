//! What AND, OR and THEN have in common: one answer per activation, one verdict, ends held while a round is open.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::branch::{Branch, Open};
use super::ordering::Ordering;
use super::{Activation, Answer, Down, Effect, Outbox, Release, Settings, Up, Verdict};
use ambidex_model::{Blocked, MissionSpec, NodeId, NodeRange, Reason};

/// The machine of a task node (III-C).
#[derive(Debug)]
pub struct Composite {
    branch: Branch,
    ordering: Ordering,
    round: u32,
    /// Ends that came during a round.
    deferred: Vec<(NodeId, Release)>,
    /// The child whose failure this node is waiting to pass on, and the leaf that it began with.
    ending: Option<(NodeId, NodeId)>,
}

impl Composite {
    pub(super) fn new(id: NodeId, ordering: Ordering, mission: &Arc<MissionSpec>, settings: &Settings) -> Self {
        let branch = Branch::new(id, mission, &settings.allocator);
        Self { branch, ordering, round: 0, deferred: Vec::new(), ending: None }
    }

    pub(super) fn on_down(&mut self, down: Down, out: &mut Outbox) {
        self.round = down.round();
        match down {
            Down::Activation(activation) => self.on_activation(activation, out),
            Down::Verdict(verdict) => self.on_verdict(&verdict, out),
            Down::Reopen(verdict) => self.reopen(&verdict, out),
            Down::Cancel(_) => self.cancel_running(None, out),
        }
    }

    pub(super) fn on_answer(&mut self, child: NodeId, answer: Answer, out: &mut Outbox) {
        let index = self.branch.index_of(child);
        let open = self.branch.open.as_mut().expect("answers come to an open round");
        let slot = open.asked.get_mut(&index).expect("only those answer that were asked");
        assert!(slot.replace(answer).is_none(), "{child:?} answered twice");
        open.waiting -= 1;
        match self.ordering.next(&self.branch, index) {
            Some((next, skips)) => self.ask(next, skips, out),
            None => self.answer_if_complete(out),
        }
    }

    pub(super) fn on_release(&mut self, child: NodeId, release: Release, out: &mut Outbox) {
        if self.branch.open.is_some() {
            self.deferred.push((child, release));
        } else {
            self.apply(child, release, out);
        }
    }

    fn on_activation(&mut self, activation: Activation, out: &mut Outbox) {
        assert!(self.branch.open.is_none(), "one round at a time");
        let skips = Arc::clone(&activation.skips);
        self.branch.open = Some(Open { activation, asked: BTreeMap::new(), waiting: 0 });
        let first = if self.ending.is_some() { Vec::new() } else { self.ordering.first(&mut self.branch) };
        self.branch.has_lapsed = false;
        for child in first {
            self.ask(child, Arc::clone(&skips), out);
        }
        self.answer_if_complete(out);
    }

    fn ask(&mut self, child: usize, skips: Arc<[NodeRange]>, out: &mut Outbox) {
        let open = self.branch.open.as_mut().expect("children are asked in an open round");
        open.asked.insert(child, None);
        open.waiting += 1;
        let view = Arc::clone(&open.activation.view);
        out.push(Effect::Down(self.branch.children[child].id, Down::Activation(Activation { view, skips })));
    }

    fn answer_if_complete(&mut self, out: &mut Outbox) {
        let open = self.branch.open.as_mut().expect("only an open round is answered");
        if open.waiting > 0 {
            return;
        }
        let answers: Vec<(usize, Answer)> = open
            .asked
            .iter_mut()
            .map(|(&child, answer)| (child, std::mem::take(answer.as_mut().expect("all have answered"))))
            .collect();
        let view = Arc::clone(&open.activation.view);
        let mut answer = match self.ending {
            Some((failed, _)) => self.ending_answer(failed),
            // All children are done, and the word of it has not reached root yet.
            None if answers.is_empty() => Answer { is_running: true, ..Answer::default() },
            None => self.ordering.answer(&self.branch, &view, answers),
        };
        answer.round = view.round;
        out.push(Effect::Up(Up::Answer(Box::new(answer))));
    }

    /// A node that waits for its running children to end asks for nothing more.
    fn ending_answer(&self, failed: NodeId) -> Answer {
        let leaves = (self.branch.id.0..self.branch.mission.tree.topology.end(self.branch.id).0).map(NodeId);
        let idle = leaves
            .filter(|&leaf| self.branch.mission.tree.behavior(leaf).is_some() && !self.branch.running.contains(&leaf));
        let blocked = idle.map(|leaf| Blocked { leaf, reason: Reason::Ending { failed } }).collect();
        Answer { is_running: true, blocked, ..Answer::default() }
    }

    fn on_verdict(&mut self, verdict: &Arc<Verdict>, out: &mut Outbox) {
        let open = self.branch.open.take().expect("a verdict ends an open round");
        for &child in open.asked.keys() {
            out.push(Effect::Down(self.branch.children[child].id, Down::Verdict(Arc::clone(verdict))));
        }
        let below = self.branch.below();
        for (&leaf, grant) in verdict.granted.range(below.from..below.to) {
            self.branch.running.insert(leaf);
            let topology = &self.branch.mission.tree.topology;
            let skipped = grant.request.skips.iter().flat_map(|skip| {
                let children = topology.children(topology.parent(skip.from));
                children.filter(|child| skip.contains(*child))
            });
            self.branch.done_below.extend(skipped.filter(|&node| below.contains(node)));
            let child = self.branch.children.iter().position(|child| child.below.contains(leaf));
            let child = child.expect("what was granted below lies below a child");
            self.ordering.commit(&mut self.branch, child, &open);
        }
        if let Some(reopened) = &verdict.reopened
            && reopened.holder == self.branch.id
        {
            self.reopen(verdict, out);
        }
        self.forget(verdict);
        for (child, release) in std::mem::take(&mut self.deferred) {
            self.apply(child, release, out);
        }
    }

    /// The behavior named in the verdict is not done any more, nor is the child it lies below.
    fn reopen(&mut self, verdict: &Arc<Verdict>, out: &mut Outbox) {
        let leaf = verdict.reopened.as_ref().expect("a reopening says what it reopens").leaf;
        let child = self.branch.children.iter_mut().find(|child| child.below.contains(leaf));
        let child = child.expect("what is reopened lies below a child");
        child.is_done = false;
        out.push(Effect::Down(child.id, Down::Reopen(Arc::clone(verdict))));
        self.forget(verdict);
    }

    /// Takes note that a behavior below is not done any more.
    fn forget(&mut self, verdict: &Verdict) {
        if let Some(reopened) = &verdict.reopened
            && self.branch.below().contains(reopened.leaf)
        {
            let mut node = reopened.leaf;
            while node != reopened.holder {
                self.branch.done_below.remove(&node);
                node = self.branch.mission.tree.topology.parent(node);
            }
            self.branch.has_lapsed |= reopened.lapsed.is_some();
        }
    }

    fn apply(&mut self, child: NodeId, mut release: Release, out: &mut Outbox) {
        let index = self.branch.index_of(child);
        self.branch.running.remove(&release.leaf);
        let consequences = &mut release.consequences;
        if consequences.completed.is_some() {
            self.branch.done_below.insert(release.leaf);
        }
        if consequences.failed == Some(child) {
            self.branch.children[index].has_failed = true;
            let fails = self.ordering.fails(&mut self.branch);
            if fails && self.ending.is_none() {
                self.ending = Some((child, release.cause));
                self.cancel_running(Some(child), out);
            }
        }
        if let Some(completed) = &mut consequences.completed
            && completed.node == child
        {
            self.branch.children[index].is_done = true;
            if self.ending.is_none() {
                *completed = self.ordering.complete(&self.branch, *completed);
            }
        }
        if let Some((_, cause)) = self.ending
            && self.branch.running.is_empty()
        {
            consequences.failed = Some(self.branch.id);
            release.cause = cause;
        }
        out.push(Effect::Up(Up::Release(Box::new(release))));
    }

    fn cancel_running(&self, except: Option<NodeId>, out: &mut Outbox) {
        for child in &self.branch.children {
            let is_running = self.branch.running.range(child.below.from..child.below.to).next().is_some();
            if is_running && Some(child.id) != except {
                out.push(Effect::Down(child.id, Down::Cancel(self.round)));
            }
        }
    }
}
