//! A serial order in which everything that is left can be run: a good guess first, behind it a search.

use std::collections::BTreeSet;

use super::forecast::Forecast;
use super::needs::{Kind, Wanted};
use ambidex_model::NodeId;

/// What came of looking for an order.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Search {
    /// There is one.
    Found(Vec<NodeId>),
    /// There is none.
    Nowhere,
    /// None was found as long as was looked.
    CutOff,
}

/// What is left of an order, if all that is left to be done can be run in it.
pub(super) fn follow(ahead: &Forecast<'_>, order: &[NodeId]) -> Option<Vec<NodeId>> {
    let mut then = ahead.clone();
    let mut rest = Vec::with_capacity(order.len());
    for &leaf in order.iter().filter(|leaf| !ahead.is_over(**leaf)) {
        // What an OR or an AND above has made needless is passed over.
        if then.run(leaf) {
            rest.push(leaf);
        }
    }
    then.is_complete().then_some(rest)
}

/// Looks for an order; each moment that is looked at takes one from the budget.
pub(super) fn find(ahead: &Forecast<'_>, budget: &mut u32) -> Search {
    let guess = block(ahead, NodeId(1)).leaves;
    if let Some(order) = follow(ahead, &guess) {
        return Search::Found(order);
    }
    let slots = &ahead.needs().slots;
    let mut ranks = vec![u32::MAX; slots.count()];
    guess.iter().enumerate().for_each(|(rank, leaf)| ranks[slots.of(*leaf)] = rank as u32);
    let mut search = Exact { ranks, seen: BTreeSet::new(), order: Vec::new(), budget, is_cut_off: false };
    if search.finish(ahead) {
        return Search::Found(search.order);
    }
    if search.is_cut_off { Search::CutOff } else { Search::Nowhere }
}

/// Some behaviors in order, and what they take together.
#[derive(Debug, Default)]
struct Block {
    leaves: Vec<NodeId>,
    /// Most that it has at once, beyond what there is before.
    peak: i64,
    /// What it has in the end, beyond what there is before.
    end: i64,
    /// Of what it has in the end, what is still empty.
    spare: i64,
}

/// What is left of a node: of an AND first what gives back at least what it takes, then what takes most meanwhile.
fn block(ahead: &Forecast<'_>, node: NodeId) -> Block {
    if ahead.is_over(node) || !ahead.needs().concerns(node) {
        return Block::default();
    }
    let children = ahead.needs().children(node);
    let mut blocks: Vec<Block> = match ahead.needs().kind(node) {
        Kind::Leaf => return leaf_block(ahead, node),
        Kind::All | Kind::InOrder => children.iter().map(|child| block(ahead, *child)).collect(),
        Kind::One => {
            let is_open = |child: &&NodeId| ahead.way(node).is_none_or(|way| way == **child);
            let ways = children.iter().filter(is_open).filter(|way| !ahead.is_over(**way));
            let best = ways.map(|way| block(ahead, *way)).min_by_key(|way| (way.end, way.peak));
            return best.unwrap_or_default();
        }
    };
    if ahead.needs().kind(node) == Kind::All {
        blocks.sort_by_key(|block| match block.end {
            ..=0 => (0, block.peak),
            1.. => (1, block.end - block.peak),
        });
    }
    let is_spare = |holder, resource| holder == node && ahead.content(resource).is_none();
    let spare = ahead.leases().iter().filter(|lease| is_spare(lease.holder, lease.resource)).count();
    let mut whole = Block { spare: spare as i64, ..Block::default() };
    for mut next in blocks {
        let shared = whole.spare.min(next.peak);
        whole.peak = whole.peak.max(whole.end - shared + next.peak);
        // Of an AND, what a child keeps its siblings never get.
        let inherited = if ahead.needs().kind(node) == Kind::InOrder { whole.spare.min(next.end.max(0)) } else { 0 };
        whole.end += next.end - inherited;
        whole.spare += next.spare - inherited;
        whole.leaves.append(&mut next.leaves);
    }
    whole
}

fn leaf_block(ahead: &Forecast<'_>, leaf: NodeId) -> Block {
    let mut block = Block { leaves: vec![leaf], ..Block::default() };
    let Some(spec) = ahead.needs().leaf(leaf) else { return block };
    for (index, need) in spec.needs.iter().enumerate() {
        let is_filled = spec.takes.iter().any(|(_, by)| *by == index);
        match (&need.wanted, need.keep) {
            (Wanted::Holding { .. }, Some(_)) => {}
            (Wanted::Holding { .. }, None) => block.end -= 1,
            (Wanted::OneOf { .. }, None) => block.peak += 1,
            (Wanted::OneOf { .. }, Some(_)) => {
                (block.peak, block.end) = (block.peak + 1, block.end + 1);
                block.spare += i64::from(!is_filled);
            }
        }
    }
    block
}

/// A search through all orders that differ.
struct Exact<'a> {
    /// By node, its place in the guess, along which is looked first.
    ranks: Vec<u32>,
    /// Moments from which nothing came.
    seen: BTreeSet<Vec<u32>>,
    order: Vec<NodeId>,
    budget: &'a mut u32,
    is_cut_off: bool,
}

impl Exact<'_> {
    /// Whether an order leads from a moment to the end.
    fn finish(&mut self, now: &Forecast<'_>) -> bool {
        if now.is_complete() {
            return true;
        }
        if *self.budget == 0 {
            self.is_cut_off = true;
            return false;
        }
        *self.budget -= 1;
        if !self.seen.insert(now.key()) {
            return false;
        }
        let mut open = now.open();
        open.sort_by_key(|leaf| (self.ranks[now.needs().slots.of(*leaf)], *leaf));
        let mut ways = Vec::new();
        for leaf in open {
            let after = |served| {
                let mut then = now.clone();
                then.run_with(leaf, &served);
                then
            };
            let of_leaf: Vec<Forecast<'_>> = now.ways_to_serve(leaf, usize::MAX).into_iter().map(after).collect();
            // What leaves at least as much free as before can as well be run at once, in front of all else.
            let is_best = |then: &&Forecast<'_>| of_leaf.iter().chain([now]).all(|other| then.is_no_worse(other));
            if let Some(best) = of_leaf.iter().find(is_best).filter(|_| !now.commits(leaf)) {
                return self.go_on(leaf, best);
            }
            ways.extend(of_leaf.into_iter().map(|then| (leaf, then)));
        }
        ways.iter().any(|(leaf, then)| self.go_on(*leaf, then))
    }

    fn go_on(&mut self, leaf: NodeId, then: &Forecast<'_>) -> bool {
        self.order.push(leaf);
        let is_found = self.finish(then);
        if !is_found {
            self.order.pop();
        }
        is_found
    }
}
