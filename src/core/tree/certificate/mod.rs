//! No deadlock: root carries one serial order in which all that is left can be run, and grants only what leaves it one
//! (`semantics` 4, "No deadlock").

mod blame;
mod forecast;
mod needs;
mod order;
#[cfg(test)]
mod tests;

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use super::allocator::{Allocator, Chosen};
use crate::world::View;
use ambidex_model::state::{SavedRoot, State};
use ambidex_model::{
    Blocked, Candidate, ClaimOptions, Deadlock, End, Grant, MissionSpec, NodeId, Reason, Record, Request, ResourceId,
    Time,
};
use forecast::Forecast;
use needs::Needs;
use order::{Search, find, follow};

/// Moments that the searches of one round look at, at most: some milliseconds.
const EXPANSIONS: u32 = 2_000;

/// The same for a check before the mission, which may take longer.
const EXPANSIONS_BEFORE: u32 = 20_000;

/// Other ways to serve a request that are tried when the cheapest would lead to a deadlock.
const OTHER_WAYS: usize = 64;

/// What root carries to come to no deadlock.
#[derive(Debug)]
pub(super) struct Certificate {
    is_wanted: bool,
    /// The tasks that are looked at, of a run that takes work.
    scope: Option<BTreeSet<NodeId>>,
    /// None where there is nothing to be looked at: no deadlock is possible, or none is to be prevented.
    needs: Option<Arc<Needs>>,
    /// Behaviors that need what can be kept, in an order in which all can be run; none where none is known.
    order: Option<Vec<NodeId>>,
    /// How many behaviors were left when there was no order to be found.
    lost: Option<usize>,
    /// Whom a round has refused for that and granted nothing: they do not ask before something has become different, so
    /// that what they hide is seen.
    barred: Arc<BTreeMap<NodeId, Reason>>,
}

/// What root grants, and whether others are to be asked now.
#[derive(Debug)]
pub(super) struct Safe {
    pub(super) chosen: Chosen,
    /// Those that would lead to a deadlock.
    pub(super) refused: Vec<Blocked>,
}

/// Why nothing can be granted as it was chosen.
struct Refusal {
    grant: Grant,
    deadlock: Deadlock,
    /// Served so it would do.
    instead: Option<Arc<Request>>,
}

impl Certificate {
    pub(super) fn new(mission: &MissionSpec, is_wanted: bool) -> Self {
        let mut certificate =
            Self { is_wanted, scope: None, needs: None, order: None, lost: None, barred: Arc::default() };
        certificate.know(mission);
        certificate
    }

    /// The tree is another one. Whoever was barred may ask again.
    pub(super) fn know(&mut self, mission: &MissionSpec) {
        self.scope = None;
        let is_whole = self.is_wanted && !mission.tree.is_standing();
        self.needs = if is_whole { Needs::of(mission, None) } else { None };
        (self.order, self.lost) = (None, None);
    }

    /// What is kept of it with a run.
    pub(super) fn save(&self) -> SavedRoot {
        let (barred, order, scope) = ((*self.barred).clone(), self.order.clone(), self.scope.clone());
        SavedRoot { barred, order, lost: self.lost.map(|lost| lost as u64), scope, ..SavedRoot::default() }
    }

    pub(super) fn restore(&mut self, mission: &MissionSpec, saved: &SavedRoot) {
        self.know(mission);
        self.scope.clone_from(&saved.scope);
        self.needs = self.scope.as_ref().filter(|_| self.is_wanted).and_then(|scope| Needs::of(mission, Some(scope)));
        self.order.clone_from(&saved.order);
        self.lost = saved.lost.map(|lost| lost as usize);
        self.barred = Arc::new(saved.barred.clone());
    }

    /// Of tasks that come and go those are looked at that hold something, run, or would be granted something now: all
    /// others can still be done when these are over.
    fn look_at(&mut self, view: &View, granted: &[Grant]) {
        if !self.is_wanted || !view.mission.tree.is_standing() {
            return;
        }
        let state = &view.state;
        let holding = state.table().leases().map(|(_, lease)| lease.holder);
        let busy = state.running().keys().copied().chain(granted.iter().map(Grant::leaf));
        let scope: BTreeSet<NodeId> = holding.chain(busy).filter_map(|node| state.task_of(node)).collect();
        if self.scope.as_ref() != Some(&scope) {
            self.needs = Needs::of(&view.mission, Some(&scope));
            (self.order, self.lost, self.scope) = (None, None, Some(scope));
        }
    }

    /// Who does not ask, and why.
    pub(super) fn barred(&self) -> &Arc<BTreeMap<NodeId, Reason>> {
        &self.barred
    }

    /// Bars those that were refused.
    pub(super) fn bar(&mut self, refused: &[Blocked]) {
        let barred = Arc::make_mut(&mut self.barred);
        barred.extend(refused.iter().map(|blocked| (blocked.leaf, blocked.reason.clone())));
    }

    /// Takes note of a record; gives those that may ask again.
    pub(super) fn note(&mut self, record: &Record) -> Vec<NodeId> {
        let (is_news, is_disturbed) = match record {
            Record::Released { end, .. } => (true, *end != End::Succeeded),
            Record::Decided { granted, reopened, urged, overdue, .. } => {
                let is_order = urged.is_some() || overdue.is_some();
                (!granted.is_empty() || reopened.is_some() || is_order, reopened.is_some())
            }
            Record::World { .. } | Record::Began { .. } | Record::Served { .. } => (true, true),
            Record::Infeasible { .. } | Record::TimedOut { .. } | Record::Reopened { .. } => (true, true),
            Record::Overtaken { .. } => (true, true),
            Record::Ending { .. } | Record::Cleaning { .. } | Record::Cleaned { .. } | Record::Leaving { .. } => {
                (true, true)
            }
            Record::Added { .. } | Record::Removed { .. } | Record::Canceled { .. } => (true, true),
            Record::TaskEnded { .. } | Record::Granting { .. } => (true, true),
            Record::ObjectAdded { .. } | Record::ObjectRemoved { .. } => (true, true),
            Record::Stalled { .. } | Record::Declined { .. } | Record::Checkpoint { .. } => (false, false),
            Record::Woke { .. } | Record::Awaited { .. } | Record::Denied { .. } => (false, false),
            Record::Header(_) | Record::Told { .. } | Record::Turn { .. } | Record::Observed { .. } => (false, false),
            Record::Sent { .. } | Record::Stopped { .. } | Record::Resource { .. } => (false, false),
            Record::Controller { .. } | Record::Ended { .. } => (false, false),
        };
        if is_disturbed {
            self.lost = None;
        }
        if !is_news || self.barred.is_empty() {
            return Vec::new();
        }
        std::mem::take(&mut self.barred).keys().copied().collect()
    }

    /// Chooses, the best first, what leaves an order; what would not is dropped, and others get what it would have had.
    pub(super) fn choose(
        &mut self,
        allocator: &dyn Allocator,
        view: &View,
        requests: &[Arc<Request>],
        wishes: &[Arc<Request>],
    ) -> Safe {
        let mut chosen = allocator.choose(view, requests, wishes);
        let mut refused = Vec::new();
        self.look_at(view, &chosen.granted);
        let mut budget = EXPANSIONS;
        let mut offered: Option<Vec<Arc<Request>>> = None;
        let mut served: BTreeMap<NodeId, Arc<Request>> = BTreeMap::new();
        while let Some(needs) = self.needs.clone() {
            // Most rounds grant nothing that matters, and an order is long.
            let is_tried = chosen.granted.iter().any(|grant| matters(&needs, grant));
            let carried = is_tried.then(|| self.order.clone());
            let Err(refusal) = self.judge(&needs, &view.state, &chosen.granted, &mut budget) else { break };
            let leaf = refusal.grant.leaf();
            // What was tried led on from there.
            if let Some(carried) = carried {
                self.order = carried;
            }
            let offered = offered.get_or_insert_with(|| requests.to_vec());
            let is_first = !served.contains_key(&leaf);
            match refusal.instead.filter(|_| is_first) {
                Some(instead) => {
                    let asked = offered.iter_mut().find(|request| request.leaf == leaf);
                    let asked = asked.expect("what is granted was asked for");
                    served.insert(leaf, std::mem::replace(asked, instead));
                }
                None => {
                    offered.retain(|request| request.leaf != leaf);
                    let reason = Reason::WouldDeadlock { deadlock: Box::new(refusal.deadlock) };
                    refused.push(Blocked { leaf, reason });
                }
            }
            chosen = allocator.choose(view, offered, wishes);
            self.look_at(view, &chosen.granted);
        }
        for grant in &mut chosen.granted {
            if let Some(request) = served.remove(&grant.leaf()) {
                grant.request = request;
            }
        }
        Safe { chosen, refused }
    }

    fn judge(&mut self, needs: &Needs, state: &State, granted: &[Grant], budget: &mut u32) -> Result<(), Box<Refusal>> {
        if !granted.iter().any(|grant| matters(needs, grant)) {
            return Ok(());
        }
        let mut before = state.clone();
        for grant in granted {
            let after = with(&before, grant);
            if matters(needs, grant) && !self.admits(needs, &before, &after, budget) {
                let deadlock = blame::deadlock(&Forecast::new(needs, &after), grant.leaf());
                let instead = self.instead(needs, &before, grant, budget);
                return Err(Box::new(Refusal { grant: grant.clone(), deadlock, instead }));
            }
            before = after;
        }
        Ok(())
    }

    /// Whether a step keeps an order; true also where there is none to be lost.
    fn admits(&mut self, needs: &Needs, before: &State, after: &State, budget: &mut u32) -> bool {
        let ahead = Forecast::new(needs, after);
        if let Some(rest) = self.order.as_ref().and_then(|order| follow(&ahead, order)) {
            self.order = Some(rest);
            return true;
        }
        let left = ahead.left_to_do();
        if self.order.is_none() && self.lost.is_some_and(|lost| left > lost / 2) {
            return true;
        }
        if let Search::Found(order) = find(&ahead, budget) {
            (self.order, self.lost) = (Some(order), None);
            return true;
        }
        // Only an order that is there without the step is a reason to refuse it.
        let now = Forecast::new(needs, before);
        let carried = self.order.as_ref().and_then(|order| follow(&now, order));
        self.order = carried.or_else(|| match find(&now, budget) {
            Search::Found(order) => Some(order),
            Search::Nowhere | Search::CutOff => None,
        });
        self.lost = if self.order.is_some() { None } else { Some(left) };
        self.order.is_none()
    }

    /// The request cut down to the first other way to serve it that keeps an order.
    fn instead(&self, needs: &Needs, before: &State, grant: &Grant, budget: &mut u32) -> Option<Arc<Request>> {
        let order = self.order.as_ref()?;
        let mut ways = vec![Vec::new()];
        for claim in &grant.request.claims {
            let longer = |way: &Vec<Candidate>| {
                let free = claim.candidates.iter().filter(|new| way.iter().all(|old| old.resource != new.resource));
                free.map(|new| [way.as_slice(), &[*new]].concat()).collect::<Vec<_>>()
            };
            ways = ways.iter().flat_map(longer).take(OTHER_WAYS).collect();
        }
        let cut_down = |way: &Vec<Candidate>| {
            let claims = std::iter::zip(&grant.request.claims, way);
            let claims = claims.map(|(claim, only)| ClaimOptions { candidates: vec![*only], ..claim.clone() });
            let mut other = grant.clone();
            std::iter::zip(&mut other.bindings, way).for_each(|(binding, only)| binding.resource = only.resource);
            (claims.collect::<Vec<_>>(), other)
        };
        ways.iter().map(cut_down).find_map(|(claims, other)| {
            let after = with(before, &other);
            let ahead = Forecast::new(needs, &after);
            let goes_on = follow(&ahead, order).is_some() || matches!(find(&ahead, budget), Search::Found(_));
            goes_on.then(|| Arc::new(Request { claims, ..Request::clone(&grant.request) }))
        })
    }
}

/// Where a mission comes to a stop in every order.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Unfinishable {
    /// A behavior that cannot be run any more.
    pub waiting: NodeId,
    /// How many resources it needs that can be kept.
    pub needs: u32,
    /// What is kept from it then, and by which behaviors.
    pub kept: Vec<(ResourceId, NodeId)>,
}

/// Whether a mission can be run to its end at all, as far as that depends on what is kept physically (`semantics` 4).
///
/// # Errors
/// Where everything comes to a stop, if all orders were tried and none leads to the end.
pub fn can_finish(mission: &MissionSpec) -> Result<(), Unfinishable> {
    let Some(needs) = Needs::of(mission, None) else { return Ok(()) };
    let topology = Arc::new(mission.tree.topology.clone());
    let state = State::new(topology, mission.robot.resources.len(), mission.start.clone());
    let ahead = Forecast::new(&needs, &state);
    match find(&ahead, &mut { EXPANSIONS_BEFORE }) {
        Search::Found(_) | Search::CutOff => Ok(()),
        Search::Nowhere => {
            let (stop, waiting) = blame::stop(&ahead);
            let Some(&waiting) = waiting.first() else { return Ok(()) };
            let strange = stop.leases().iter().filter(|lease| !stop.is_in_line(waiting, lease.holder));
            let kept = strange.map(|lease| (lease.resource, lease.behavior)).collect();
            Err(Unfinishable { waiting, needs: blame::wanted(&stop, waiting), kept })
        }
    }
}

/// Whether a grant makes a difference to what is left: it needs what can be kept, skips such, or chooses between such.
fn matters(needs: &Needs, grant: &Grant) -> bool {
    let leaf = grant.leaf();
    if needs.topology.is_in_cleanup(leaf) {
        return false;
    }
    needs.leaf(leaf).is_some()
        || grant.request.skips.iter().any(|skip| needs.has_within(*skip))
        || needs.topology.path(leaf).any(|node| needs.is_choice(node))
}

/// The state with a further grant.
fn with(state: &State, grant: &Grant) -> State {
    let mut after = state.clone();
    after.apply(&Record::Decided {
        at: Time::ZERO,
        round: state.round(),
        granted: vec![grant.clone()],
        refused: Vec::new(),
        reopened: None,
        deadlines: Vec::new(),
        urged: None,
        overdue: None,
    });
    after
}
