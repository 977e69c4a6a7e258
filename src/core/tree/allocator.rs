//! How requests are chosen: in AND on the way up, in root at the end. Nodes do not know which allocator they use.

use std::fmt::Debug;
use std::sync::Arc;

use super::offers::{Judged, Offers, Rank};
use super::packing::Packing;
use crate::world::View;
use ambidex_model::{Access, Binding, Blocked, Grant, NodeId, Reason, Request, Retention};

/// Chooses among requests.
pub trait Allocator: Debug + Send + Sync {
    /// Its name on the command line and in the journal.
    fn name(&self) -> &'static str;

    /// Whether what it passes up depends on the requests alone, and on nothing else that the view tells.
    fn is_local(&self) -> bool {
        false
    }

    /// In AND: brings up to date what is passed up, and says of what is different why it is not. Bindings are
    /// provisional.
    fn merge(&self, view: &View, offers: &mut Offers) -> Vec<Blocked>;

    /// In root: what is granted, with resources bound, and why the rest is not. Wishes take part behind the requests that
    /// are as urgent, and are not granted: so nobody takes what a more urgent behavior waits for.
    fn choose(&self, view: &View, requests: &[Arc<Request>], wishes: &[Arc<Request>]) -> Chosen;
}

/// What root grants.
#[derive(Debug, Default)]
pub struct Chosen {
    /// Granted, best first.
    pub granted: Vec<Grant>,
    /// Not granted.
    pub refused: Vec<Blocked>,
    /// Wishes that found a place beside what is granted, best first, with what they would get.
    pub wished: Vec<Grant>,
}

/// Algorithm 1: the best request, then every later one that is compatible with those before it.
#[derive(Debug, Clone, Copy, Default)]
pub struct Greedy;

impl Allocator for Greedy {
    fn name(&self) -> &'static str {
        "greedy"
    }

    fn is_local(&self) -> bool {
        true
    }

    fn merge(&self, view: &View, offers: &mut Offers) -> Vec<Blocked> {
        let mut packing = Packing::below_root(view);
        offers.merge_changed(|request| judge(&mut packing, request))
    }

    fn choose(&self, view: &View, requests: &[Arc<Request>], wishes: &[Arc<Request>]) -> Chosen {
        let mut packing = Packing::new(view);
        let mut wishes: Vec<_> = wishes.iter().map(|wish| (Rank::of(wish), wish)).collect();
        wishes.sort_unstable_by_key(|(rank, _)| *rank);
        let mut wishes = wishes.into_iter().map(|(_, wish)| wish).peekable();
        let refused = judge_all(requests, |request| {
            while let Some(wish) = wishes.next_if(|wish| wish.priority > request.priority) {
                packing.wish(Arc::clone(wish));
            }
            judge(&mut packing, request)
        });
        wishes.for_each(|wish| packing.wish(Arc::clone(wish)));
        let (granted, wished) = packing.bind();
        Chosen { granted, refused, wished }
    }
}

/// The task tree that the paper starts from (III-A): the best behavior gets the whole robot while it runs.
#[derive(Debug, Clone, Copy, Default)]
pub struct Serial;

impl Allocator for Serial {
    fn name(&self) -> &'static str {
        "serial"
    }

    fn merge(&self, view: &View, offers: &mut Offers) -> Vec<Blocked> {
        let mut whole = Whole::new(view);
        offers.merge_all(|request| whole.judge(request))
    }

    fn choose(&self, view: &View, requests: &[Arc<Request>], _: &[Arc<Request>]) -> Chosen {
        let mut whole = Whole::new(view);
        let refused = judge_all(requests, |request| whole.judge(request));
        let (mut granted, wished) = whole.packing.bind();
        for grant in &mut granted {
            let free = view.state.table().iter().filter(|(_, resource)| resource.is_free()).map(|(id, _)| id);
            let unclaimed: Vec<_> =
                free.filter(|id| grant.bindings.iter().all(|binding| binding.resource != *id)).collect();
            let whole = |resource| Binding { resource, access: Access::Exclusive, keep: Retention::Release };
            grant.bindings.extend(unclaimed.into_iter().map(whole));
        }
        Chosen { granted, refused, wished }
    }
}

/// Judges requests in their order; gives why some do not join.
fn judge_all(requests: &[Arc<Request>], mut judge: impl FnMut(&Arc<Request>) -> Judged) -> Vec<Blocked> {
    let mut ranked: Vec<_> = requests.iter().map(|request| (Rank::of(request), request)).collect();
    ranked.sort_unstable_by_key(|(rank, _)| *rank);
    let judged = ranked.into_iter().map(|(_, request)| judge(request));
    let refused = judged.filter_map(|judged| match judged {
        Judged::Kept => None,
        Judged::Refused(blocked) => Some(blocked),
    });
    refused.collect()
}

fn judge(packing: &mut Packing<'_>, request: &Arc<Request>) -> Judged {
    match packing.add(Arc::clone(request)) {
        Ok(()) => Judged::Kept,
        Err(reason) => Judged::Refused(Blocked { leaf: request.leaf, reason }),
    }
}

/// Gives the whole robot to one.
struct Whole<'a> {
    packing: Packing<'a>,
    owner: Option<NodeId>,
}

impl<'a> Whole<'a> {
    fn new(view: &'a View) -> Self {
        Self { packing: Packing::new(view), owner: view.state.running().keys().next().copied() }
    }

    fn judge(&mut self, request: &Arc<Request>) -> Judged {
        if let Some(by) = self.owner {
            return Judged::Refused(Blocked { leaf: request.leaf, reason: Reason::WholeRobot { by } });
        }
        let judged = judge(&mut self.packing, request);
        if let Judged::Kept = judged {
            self.owner = Some(request.leaf);
        }
        judged
    }
}
