//! How requests are chosen: in AND on the way up, in root at the end. Nodes do not know which allocator they use.

use std::fmt::Debug;
use std::sync::Arc;

use super::packing::Packing;
use crate::world::View;
use ambidex_model::{Access, Binding, Blocked, Grant, Reason, Request, Retention};

/// Chooses among requests.
pub trait Allocator: Debug + Send + Sync {
    /// Its name on the command line and in the journal.
    fn name(&self) -> &'static str;

    /// Whether what it passes up depends on the requests alone, and on nothing else that the view tells.
    fn is_local(&self) -> bool {
        false
    }

    /// In AND: what is passed up, and why the rest is not. Bindings are provisional.
    fn merge(&self, view: &View, requests: Vec<Arc<Request>>) -> Merged;

    /// In root: what is granted, with resources bound, and why the rest is not.
    fn choose(&self, view: &View, requests: Vec<Arc<Request>>) -> Chosen;
}

/// What an AND passes up.
#[derive(Debug, Default)]
pub struct Merged {
    /// Passed up, best first.
    pub kept: Vec<Arc<Request>>,
    /// Not passed up.
    pub refused: Vec<Blocked>,
}

/// What root grants.
#[derive(Debug, Default)]
pub struct Chosen {
    /// Granted, best first.
    pub granted: Vec<Grant>,
    /// Not granted.
    pub refused: Vec<Blocked>,
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

    fn merge(&self, view: &View, requests: Vec<Arc<Request>>) -> Merged {
        let (packing, refused) = find_compatible(view, requests);
        Merged { kept: packing.into_accepted(), refused }
    }

    fn choose(&self, view: &View, requests: Vec<Arc<Request>>) -> Chosen {
        let (packing, refused) = find_compatible(view, requests);
        Chosen { granted: packing.bind(), refused }
    }
}

/// The task tree that the paper starts from (III-A): the best behavior gets the whole robot while it runs.
#[derive(Debug, Clone, Copy, Default)]
pub struct Serial;

impl Allocator for Serial {
    fn name(&self) -> &'static str {
        "serial"
    }

    fn merge(&self, view: &View, requests: Vec<Arc<Request>>) -> Merged {
        let (packing, refused) = find_best(view, requests);
        Merged { kept: packing.into_accepted(), refused }
    }

    fn choose(&self, view: &View, requests: Vec<Arc<Request>>) -> Chosen {
        let (packing, refused) = find_best(view, requests);
        let mut granted = packing.bind();
        for grant in &mut granted {
            let free = view.state.table().iter().filter(|(_, resource)| !resource.is_locked()).map(|(id, _)| id);
            let unclaimed: Vec<_> =
                free.filter(|id| grant.bindings.iter().all(|binding| binding.resource != *id)).collect();
            let whole = |resource| Binding { resource, access: Access::Exclusive, keep: Retention::Release };
            grant.bindings.extend(unclaimed.into_iter().map(whole));
        }
        Chosen { granted, refused }
    }
}

/// Greatest potential first; among equals the heir of an intention, then tree order (`semantics` 5).
fn sort(requests: &mut [Arc<Request>]) {
    requests.sort_by(|a, b| {
        let by_potential = b.potential.total_cmp(&a.potential);
        by_potential.then(b.heir.cmp(&a.heir)).then(a.leaf.cmp(&b.leaf))
    });
}

fn find_compatible(view: &View, mut requests: Vec<Arc<Request>>) -> (Packing<'_>, Vec<Blocked>) {
    sort(&mut requests);
    let mut packing = Packing::new(view);
    let mut refused = Vec::new();
    for request in requests {
        let leaf = request.leaf;
        if let Err(reason) = packing.add(request) {
            refused.push(Blocked { leaf, reason });
        }
    }
    (packing, refused)
}

fn find_best(view: &View, mut requests: Vec<Arc<Request>>) -> (Packing<'_>, Vec<Blocked>) {
    sort(&mut requests);
    let mut owner = view.state.running().keys().next().copied();
    let mut packing = Packing::new(view);
    let mut refused = Vec::new();
    for request in requests {
        let leaf = request.leaf;
        match owner {
            Some(by) => refused.push(Blocked { leaf, reason: Reason::WholeRobot { by } }),
            None => match packing.add(request) {
                Ok(()) => owner = Some(leaf),
                Err(reason) => refused.push(Blocked { leaf, reason }),
            },
        }
    }
    (packing, refused)
}
