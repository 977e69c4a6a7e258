//! What the children of an AND ask for, in the order of requests, and what of it the AND passed up last.

use std::cmp::Reverse;
use std::sync::Arc;

use ambidex_model::{Blocked, NodeId, Request};

type Ranked = Vec<(Rank, Arc<Request>)>;

/// Requests in their order (`semantics` 5), with what became different since they were merged last.
#[derive(Debug, Default)]
pub struct Offers {
    /// In order, but for what is `new`.
    ranked: Ranked,
    kept: Vec<Arc<Request>>,
    gone: Ranked,
    new: Ranked,
}

/// The order of requests: the more urgent first, then what has been done fewer times, then the greatest potential; among
/// equals the heir of an intention, then tree order (`semantics` 5).
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Rank {
    priority: Reverse<i32>,
    iterations: u32,
    /// The bits of a positive number are in its order.
    potential: Reverse<u64>,
    heir: Reverse<bool>,
    leaf: NodeId,
}

impl Rank {
    pub(super) fn of(request: &Request) -> Self {
        Self {
            priority: Reverse(request.priority),
            iterations: request.iterations,
            potential: Reverse(request.potential.to_bits()),
            heir: Reverse(request.heir),
            leaf: request.leaf,
        }
    }
}

/// What becomes of one request in a merge.
#[derive(Debug)]
pub enum Judged {
    /// It goes up.
    Kept,
    /// It does not.
    Refused(Blocked),
}

impl Offers {
    /// What goes up, best first.
    pub fn kept(&self) -> &[Arc<Request>] {
        &self.kept
    }

    pub(super) fn clear(&mut self) {
        *self = Self::default();
    }

    pub(super) fn offer(&mut self, request: &Arc<Request>) {
        self.new.push((Rank::of(request), Arc::clone(request)));
    }

    pub(super) fn withdraw(&mut self, request: &Arc<Request>) {
        self.gone.push((Rank::of(request), Arc::clone(request)));
    }

    /// Whether anything is different since the last merge.
    pub(super) fn are_different(&self) -> bool {
        !self.gone.is_empty() || !self.new.is_empty()
    }

    /// Judges all anew: `judge` is told each in order.
    pub fn merge_all(&mut self, mut judge: impl FnMut(&Arc<Request>) -> Judged) -> Vec<Blocked> {
        if self.gone.len() == self.ranked.len() {
            self.gone.clear();
            self.ranked.clear();
            std::mem::swap(&mut self.ranked, &mut self.new);
            self.ranked.sort_unstable_by_key(|(rank, _)| *rank);
        } else {
            self.take_up();
        }
        self.kept.clear();
        let mut refused = Vec::new();
        for (_, request) in &self.ranked {
            judge_one(request, &mut judge, &mut self.kept, &mut refused);
        }
        refused
    }

    /// The same where what becomes of a request depends on those alone that were kept before it: as long as these are
    /// what they were, the rest is what it was, and not told again.
    pub fn merge_changed(&mut self, mut judge: impl FnMut(&Arc<Request>) -> Judged) -> Vec<Blocked> {
        if self.gone.len() == self.ranked.len() {
            return self.merge_all(judge);
        }
        let (gone, new) = self.take_up();
        let mut refused = Vec::new();
        let was_kept = std::mem::take(&mut self.kept);
        let mut gone = gone.iter().map(|(rank, _)| *rank).peekable();
        let mut new = new.iter().peekable();
        let mut old = was_kept.iter().map(|request| (Rank::of(request), request)).peekable();
        loop {
            // Where a request comes back with the rank that it had, its old form comes first.
            let next_old = old.peek().map(|(rank, _)| *rank);
            let next = [next_old, gone.peek().copied(), new.peek().map(|(rank, _)| *rank)];
            let Some(rank) = next.into_iter().flatten().min() else { break };
            let is_gone = std::iter::from_fn(|| gone.next_if_eq(&rank)).last().is_some();
            let was_kept = old.next_if(|(other, _)| *other == rank);
            let arrived = new.next_if(|(other, _)| *other == rank);
            match (was_kept, is_gone, arrived) {
                (Some((_, request)), false, _) => {
                    judge_one(request, &mut judge, &mut self.kept, &mut refused);
                }
                (None, _, Some((_, request))) => {
                    if judge_one(request, &mut judge, &mut self.kept, &mut refused) {
                        self.judge_behind(rank, &mut judge, &mut refused);
                        break;
                    }
                }
                (None, _, None) => {}
                (Some(_), true, arrived) => {
                    if let Some((_, request)) = arrived {
                        judge_one(request, &mut judge, &mut self.kept, &mut refused);
                    }
                    self.judge_behind(rank, &mut judge, &mut refused);
                    break;
                }
            }
        }
        refused
    }

    /// Everything behind a rank.
    fn judge_behind(
        &mut self,
        rank: Rank,
        judge: &mut impl FnMut(&Arc<Request>) -> Judged,
        refused: &mut Vec<Blocked>,
    ) {
        let from = self.ranked.partition_point(|(other, _)| *other <= rank);
        for (_, request) in &self.ranked[from..] {
            judge_one(request, judge, &mut self.kept, refused);
        }
    }

    /// Brings everything in order; gives what is gone and what is new, each in order.
    fn take_up(&mut self) -> (Ranked, Ranked) {
        let (mut gone, mut new) = (std::mem::take(&mut self.gone), std::mem::take(&mut self.new));
        new.sort_unstable_by_key(|(rank, _)| *rank);
        gone.sort_unstable_by_key(|(rank, _)| *rank);
        if gone.len() + new.len() <= FEW {
            for (rank, _) in &gone {
                let at = self.ranked.binary_search_by_key(rank, |(rank, _)| *rank);
                self.ranked.remove(at.expect("only what was offered is withdrawn"));
            }
            for (rank, request) in &new {
                let at = self.ranked.partition_point(|(other, _)| other < rank);
                self.ranked.insert(at, (*rank, Arc::clone(request)));
            }
        } else {
            let mut leaving = gone.iter().map(|(rank, _)| *rank).peekable();
            self.ranked.retain(|(rank, _)| leaving.next_if_eq(rank).is_none());
            self.ranked.extend(new.iter().cloned());
            // Two sorted runs.
            self.ranked.sort_by_key(|(rank, _)| *rank);
        }
        (gone, new)
    }
}

/// So many are put in their places one by one.
const FEW: usize = 16;

/// True if it is kept.
fn judge_one(
    request: &Arc<Request>,
    judge: &mut impl FnMut(&Arc<Request>) -> Judged,
    kept: &mut Vec<Arc<Request>>,
    refused: &mut Vec<Blocked>,
) -> bool {
    match judge(request) {
        Judged::Kept => {
            kept.push(Arc::clone(request));
            true
        }
        Judged::Refused(blocked) => {
            refused.push(blocked);
            false
        }
    }
}
