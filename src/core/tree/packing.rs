//! A set of requests with a resource for every claim: what can go on at once, and the cheapest way to bind it.

use std::collections::{BTreeMap, BTreeSet};
use std::hash::{DefaultHasher, Hash, Hasher};
use std::sync::Arc;

use crate::behavior::too_few;
use crate::world::{Compatible, Use, View};

use ambidex_model::{
    Access, Binding, Candidate, ClaimOptions, Grant, NodeId, ObjectId, Reason, Request, ResourceId, match_claims,
};

/// Requests that can be granted together, each claim with a resource that serves it (`semantics` 5).
#[derive(Debug)]
pub(super) struct Packing<'a> {
    view: &'a View,
    /// What may go on at once beyond resources and objects, where that is asked here.
    rules: Option<&'a dyn Compatible>,
    accepted: Vec<Arc<Request>>,
    /// The choice per accepted request and claim.
    chosen: Vec<Vec<Candidate>>,
    /// How each resource is used by what is chosen, by resource; others of the same access may join.
    used: Vec<Option<Access>>,
    /// Accepted ones that are not granted: they only keep others from what they need.
    wishes: BTreeSet<NodeId>,
    /// What found nothing beside the accepted ones, by a hash of what it wants; nor does whoever wants the same.
    late: BTreeMap<u64, Vec<Late>>,
}

/// A request that came too late.
#[derive(Debug)]
struct Late {
    request: Arc<Request>,
    /// Whether nothing but wishes was in its way.
    is_reserved: bool,
}

/// Choices that one search tries at most. The robots of the paper claim a few dozen; a robot with many alike arms could
/// ask for factorially many, and the core must not keep it waiting. What was found by then holds.
const STEPS: u32 = 20_000;

/// Costs that differ by less count as equal, meters.
const SAME_COST_M: f64 = 1e-9;

impl<'a> Packing<'a> {
    /// For root, who asks all rules.
    pub(super) fn new(view: &'a View) -> Self {
        let used = vec![None; view.mission.robot.resources.len()];
        let rules = Some(&*view.rules);
        Self {
            view,
            rules,
            accepted: Vec::new(),
            chosen: Vec::new(),
            used,
            wishes: BTreeSet::new(),
            late: BTreeMap::new(),
        }
    }

    /// For an AND, who leaves to root what root alone is asked.
    pub(super) fn below_root(view: &'a View) -> Self {
        Self { rules: Some(&*view.rules).filter(|rules| !rules.is_for_root()), ..Self::new(view) }
    }

    /// Adds a request if *some* choice of resources serves it and all accepted ones.
    ///
    /// # Errors
    /// Why it cannot join.
    pub(super) fn add(&mut self, request: Arc<Request>) -> Result<(), Reason> {
        if let Some(reason) = self.shares_object(&request) {
            return Err(reason);
        }
        // Most requests of a large tree come too late for everything: that is seen without a search.
        let wanted = hash_of_wanted(&request);
        let mut late = self.late.get(&wanted).into_iter().flatten();
        if let Some(late) = late.find(|late| wants_the_same(&late.request, &request)) {
            return Err(self.late(&request, late.is_reserved));
        }
        let has_room = self.has_room(&request);
        let may_rearrange = || self.has_alternatives() && self.could_match(&request);
        if has_room || may_rearrange() {
            let mut search = Search::new(self, &self.accepted, &request);
            if (has_room && search.extend(&self.chosen)) || (may_rearrange() && search.any()) {
                self.chosen = search.chosen;
                self.accepted.push(request);
                self.note_uses();
                return Ok(());
            }
            if let Some(reason) = search.clash.take() {
                return Err(reason);
            }
        }
        let reason = self.late(&request, true);
        let is_reserved = matches!(reason, Reason::Reserved { .. });
        self.late.entry(wanted).or_default().push(Late { request, is_reserved });
        Err(reason)
    }

    /// Why a request comes too late: only wishes are in its way, if that may be, or others came first.
    fn late(&self, request: &Arc<Request>, may_be_reserved: bool) -> Reason {
        if may_be_reserved && !self.wishes.is_empty() && self.fits_without_wishes(request) {
            let of_wishes = |leaf| self.wishes.contains(&leaf);
            let (by, resource) = match self.in_the_way(request, of_wishes) {
                Some((wish, resource)) => (wish.leaf, Some(resource)),
                None => (*self.wishes.first().expect("there are wishes"), None),
            };
            return Reason::Reserved { resource, by };
        }
        let of_requests = |leaf| !self.wishes.contains(&leaf);
        match self.in_the_way(request, of_requests).or_else(|| self.in_the_way(request, |_| true)) {
            Some((other, resource)) => Reason::outbid(request, resource, other),
            // Only its own claims are in each other's way.
            None => {
                let options: Vec<_> = request.claims.iter().map(ClaimOptions::resources).collect();
                too_few(&options, options[0][0], &self.view.mission.robot)
            }
        }
    }

    fn fits_without_wishes(&self, request: &Arc<Request>) -> bool {
        let is_granted = |accepted: &&Arc<Request>| !self.wishes.contains(&accepted.leaf);
        let granted: Vec<_> = self.accepted.iter().filter(is_granted).cloned().collect();
        Search::new(self, &granted, request).any()
    }

    /// Adds what is wished for, if it finds a place; else it takes nothing. It keeps the cheapest that it finds then,
    /// whatever comes behind it.
    pub(super) fn wish(&mut self, wish: Arc<Request>) {
        let leaf = wish.leaf;
        if self.add(wish).is_err() {
            return;
        }
        self.wishes.insert(leaf);
        if let Some(best) = self.cheapest() {
            self.chosen = best;
            self.note_uses();
        }
        if let (Some(wish), Some(chosen)) = (self.accepted.last_mut(), self.chosen.last()) {
            let claims = std::iter::zip(&wish.claims, chosen);
            let claims = claims.map(|(claim, only)| ClaimOptions { candidates: vec![*only], ..claim.clone() });
            *wish = Arc::new(Request { claims: claims.collect(), ..Request::clone(wish) });
        }
    }

    /// The choice for all that costs least.
    fn cheapest(&self) -> Option<Vec<Vec<Candidate>>> {
        let (last, before) = self.accepted.split_last()?;
        let mut search = Search::new(self, before, last);
        search.cheapest();
        search.best.map(|(_, chosen)| chosen)
    }

    /// Binds the whole set: least sum of reach distances, then the order of resources; what is granted, and what is only
    /// wished for.
    pub(super) fn bind(self) -> (Vec<Grant>, Vec<Grant>) {
        let best = self.cheapest().unwrap_or(self.chosen);
        let grant = |(request, chosen): (Arc<Request>, Vec<Candidate>)| Grant {
            bindings: std::iter::zip(&request.claims, chosen)
                .map(|(claim, choice)| Binding { resource: choice.resource, access: claim.access, keep: claim.keep })
                .collect(),
            request,
            met: Vec::new(),
            way: Vec::new(),
        };
        std::iter::zip(self.accepted, best).map(grant).partition(|grant| !self.wishes.contains(&grant.leaf()))
    }

    fn shares_object(&self, request: &Request) -> Option<Reason> {
        let changed = |object: &ObjectId| {
            let with = self.accepted.iter().find(|other| other.changes.contains(object))?.leaf;
            Some(match self.wishes.contains(&with) {
                true => Reason::Reserved { resource: None, by: with },
                false => Reason::SameObject { object: *object, with },
            })
        };
        request.changes.iter().find_map(changed)
    }

    /// Whether each claim alone finds something beside what is chosen.
    fn has_room(&self, request: &Request) -> bool {
        let fits = |claim: &ClaimOptions, candidate: &Candidate| {
            self.used[candidate.resource.index()].is_none_or(|used| used.joins(claim.access))
        };
        request.claims.iter().all(|claim| claim.candidates.iter().any(|candidate| fits(claim, candidate)))
    }

    /// A quick no: shared claims that only one resource serves do not join, or the exclusive ones find no resource each
    /// beside these.
    fn could_match(&self, request: &Request) -> bool {
        let claims = || self.accepted.iter().map(|accepted| &**accepted).chain([request]).flat_map(|one| &one.claims);
        let mut fixed: Vec<Option<Access>> = vec![None; self.used.len()];
        for claim in claims().filter(|claim| claim.access != Access::Exclusive) {
            if let [only] = claim.candidates.as_slice() {
                let access = fixed[only.resource.index()].get_or_insert(claim.access);
                if !access.joins(claim.access) {
                    return false;
                }
            }
        }
        let others = |claim: &ClaimOptions| -> Vec<ResourceId> {
            let resources = claim.candidates.iter().map(|candidate| candidate.resource);
            resources.filter(|resource| fixed[resource.index()].is_none()).collect()
        };
        let exclusive = claims().filter(|claim| claim.access == Access::Exclusive);
        match_claims(&exclusive.map(others).collect::<Vec<_>>()).is_ok()
    }

    fn note_uses(&mut self) {
        self.used.fill(None);
        for (request, chosen) in std::iter::zip(&self.accepted, &self.chosen) {
            for (claim, choice) in std::iter::zip(&request.claims, chosen) {
                self.used[choice.resource.index()] = Some(claim.access);
            }
        }
    }

    fn has_alternatives(&self) -> bool {
        self.accepted.iter().flat_map(|request| &request.claims).any(|claim| claim.candidates.len() > 1)
    }

    /// Who uses what the first such claim of a request could have, and what; only of those that count.
    fn in_the_way(&self, request: &Request, counts: impl Fn(NodeId) -> bool) -> Option<(&Request, ResourceId)> {
        let users = || std::iter::zip(&self.accepted, &self.chosen).filter(|(other, _)| counts(other.leaf));
        request.claims.iter().find_map(|claim| {
            let users = users().flat_map(|(other, chosen)| {
                std::iter::zip(&other.claims, chosen)
                    .map(move |(used, choice)| (&**other, used.access, choice.resource))
            });
            let mut in_the_way = users.filter(|(_, access, _)| !access.joins(claim.access));
            let found = in_the_way.find(|(_, _, used)| claim.candidates.iter().any(|one| one.resource == *used));
            found.map(|(other, _, resource)| (other, resource))
        })
    }
}

/// A search over the choices for a list of requests.
struct Search<'a> {
    view: &'a View,
    rules: Option<&'a dyn Compatible>,
    requests: Vec<&'a Request>,
    /// The choice so far, per request and claim.
    chosen: Vec<Vec<Candidate>>,
    users: Vec<Vec<(NodeId, Access)>>,
    clash: Option<Reason>,
    /// Choices that may still be tried.
    steps: u32,
    best: Option<(f64, Vec<Vec<Candidate>>)>,
}

impl<'a> Search<'a> {
    fn new(packing: &Packing<'a>, accepted: &'a [Arc<Request>], new: &'a Arc<Request>) -> Self {
        let view = packing.view;
        Self {
            view,
            rules: packing.rules,
            requests: accepted.iter().chain([new]).map(|request| &**request).collect(),
            chosen: Vec::new(),
            users: vec![Vec::new(); view.mission.robot.resources.len()],
            clash: None,
            steps: STEPS,
            best: None,
        }
    }

    /// Keeps the choices for all but the last request; true if the last one finds its own beside them.
    fn extend(&mut self, chosen: &[Vec<Candidate>]) -> bool {
        for (request, choices) in std::iter::zip(&self.requests, chosen) {
            for (claim, choice) in std::iter::zip(&request.claims, choices) {
                self.users[choice.resource.index()].push((request.leaf, claim.access));
            }
        }
        self.chosen = chosen.to_vec();
        self.chosen.push(Vec::new());
        let found = self.first_from(chosen.len());
        if !found {
            self.users.iter_mut().for_each(Vec::clear);
            self.chosen.clear();
        }
        found
    }

    /// True if there is a choice for all.
    fn any(&mut self) -> bool {
        self.chosen = vec![Vec::new()];
        self.first_from(0)
    }

    /// Finds the cheapest choice for all, the first in resource order among equals.
    fn cheapest(&mut self) {
        self.chosen = vec![Vec::new()];
        self.walk(0, 0.0, &mut |search, cost_m| {
            if search.best.as_ref().is_none_or(|(best, _)| cost_m < best - SAME_COST_M) {
                search.best = Some((cost_m, search.chosen.clone()));
            }
            false
        });
    }

    fn first_from(&mut self, request: usize) -> bool {
        self.walk(request, 0.0, &mut |_, _| true)
    }

    /// Tries every choice from the claim after the last chosen one on, until `found` says that it is enough or the
    /// steps are used up.
    fn walk(&mut self, request: usize, cost_m: f64, found: &mut impl FnMut(&mut Self, f64) -> bool) -> bool {
        let index = self.chosen[request].len();
        let Some(claim) = self.requests[request].claims.get(index) else {
            return self.next_request(request, cost_m, found);
        };
        let leaf = self.requests[request].leaf;
        let rest_m = self.least_behind(request, index);
        for &candidate in &claim.candidates {
            let cost_m = cost_m + candidate.weight_m();
            let is_hopeless = self.best.as_ref().is_some_and(|(best, _)| cost_m + rest_m >= best - SAME_COST_M);
            if self.steps == 0 || is_hopeless || !self.is_free(candidate.resource, leaf, claim.access) {
                continue;
            }
            self.steps -= 1;
            self.users[candidate.resource.index()].push((leaf, claim.access));
            self.chosen[request].push(candidate);
            if self.walk(request, cost_m, found) {
                return true;
            }
            self.chosen[request].pop();
            self.users[candidate.resource.index()].pop();
        }
        false
    }

    fn next_request(&mut self, request: usize, cost_m: f64, found: &mut impl FnMut(&mut Self, f64) -> bool) -> bool {
        if request + 1 == self.requests.len() {
            return self.is_allowed() && found(self, cost_m);
        }
        self.chosen.push(Vec::new());
        let enough = self.walk(request + 1, cost_m, found);
        if !enough {
            self.chosen.pop();
        }
        enough
    }

    /// What the claims behind this one cost at least, meters.
    fn least_behind(&self, request: usize, claim: usize) -> f64 {
        let behind = self.requests[request].claims[claim + 1..].iter();
        let others = self.requests[request + 1..].iter().flat_map(|request| &request.claims);
        let least = |claim: &ClaimOptions| claim.candidates.iter().map(Candidate::weight_m).min_by(f64::total_cmp);
        behind.chain(others).filter_map(least).sum()
    }

    /// Candidates fit the table; here they must fit each other.
    fn is_free(&self, resource: ResourceId, leaf: NodeId, access: Access) -> bool {
        let mut users = self.users[resource.index()].iter();
        users.all(|&(user, used)| user != leaf && used.joins(access))
    }

    fn is_allowed(&mut self) -> bool {
        let Some(rules) = self.rules else { return true };
        let asked = std::iter::zip(&self.requests, &self.chosen).flat_map(|(request, chosen)| {
            let chosen = chosen.iter().enumerate();
            chosen.map(|(claim, choice)| Use {
                request,
                claim: Some(claim),
                resource: choice.resource,
                is_running: false,
            })
        });
        let uses: Vec<Use<'_>> = self.view.uses().chain(asked).collect();
        match rules.check(self.view, &uses) {
            Ok(()) => true,
            Err(reason) => {
                self.clash.get_or_insert(reason);
                false
            }
        }
    }
}

/// The same for all that could be served by the same resources in the same ways, on every machine.
fn hash_of_wanted(request: &Request) -> u64 {
    let mut hasher = DefaultHasher::new();
    for claim in &request.claims {
        claim.access.hash(&mut hasher);
        claim.candidates.iter().for_each(|candidate| candidate.resource.hash(&mut hasher));
    }
    hasher.finish()
}

/// Whether two requests could be served by the same resources in the same ways.
fn wants_the_same(one: &Request, other: &Request) -> bool {
    let is_same = |(one, other): (&ClaimOptions, &ClaimOptions)| {
        one.access == other.access
            && one.candidates.len() == other.candidates.len()
            && std::iter::zip(&one.candidates, &other.candidates).all(|(one, other)| one.resource == other.resource)
    };
    one.claims.len() == other.claims.len() && std::iter::zip(&one.claims, &other.claims).all(is_same)
}
