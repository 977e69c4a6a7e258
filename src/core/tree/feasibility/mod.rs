//! Which behaviors can never run any more, whatever the others do: what they lack is out of reach in a future in which
//! order does not matter and nothing is undone (`semantics` 6, "Infeasible").
//!
//! What was found possible is kept with its proof, and looked at again only where that breaks.

mod terms;

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;
use std::sync::Arc;

use super::ahead;
use super::goals::is_met;
use super::ordering::{Ordering, begins_again, is_repeated};
use super::overtaking::Overtaking;
use super::reaching::Reaching;
use crate::behavior;
use crate::world::{Bodies, FreeSpace, NoPath, View, Ways, find_path};
use ambidex_model::state::{Phase, State};
use ambidex_model::{
    Change, Condition, Hold, Location, MissionSpec, NodeId, NodeRange, Pose, Reason, Record, Reopened, RobotSpec, Time,
};
use terms::{About, Terms};

/// Steps of a proof that are looked at before everything is proved anew.
const LOOKS: usize = 256;

/// What can still become so, and by whom.
#[derive(Debug)]
pub(super) struct Feasibility {
    mission: Arc<MissionSpec>,
    free_space: Arc<FreeSpace>,
    terms: Terms,
    /// By term.
    proofs: Vec<Proof>,
    /// By term, of its makers and readers the one to be looked at next: those before it are mostly over.
    next: Vec<[usize; 2]>,
    open_stands: OpenStands,
    /// Behaviors that could run when everything was proved last.
    able: BTreeSet<NodeId>,
    /// What each behavior is the proof of.
    proves: BTreeMap<NodeId, BTreeSet<usize>>,
    /// Behaviors that claim what the robot does not have.
    lacking: BTreeMap<NodeId, Reason>,
    /// Behaviors that cannot run and have not failed for that, since their goal holds or others may reach it.
    spared: Vec<NodeId>,
    /// Behaviors that were not to be judged and are again, since they do not run any more or are not done.
    returned: Vec<NodeId>,
    /// Terms whose proof may have broken.
    suspects: BTreeSet<usize>,
    /// Everything is to be proved anew.
    is_stale: bool,
}

/// Whether paths lead to stands from where the base can come to, by where these are: each looked for once.
#[derive(Debug, Default)]
struct OpenStands(BTreeMap<[u64; 2], bool>);

impl OpenStands {
    fn leads_to(&mut self, free_space: &FreeSpace, base: Pose, stand: Pose) -> bool {
        let key = [stand.at.x, stand.at.y].map(f64::to_bits);
        *self.0.entry(key).or_insert_with(|| find_path(free_space, base, stand).path != Err(NoPath::Closed))
    }
}

/// Why a term can become so.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Proof {
    Nothing,
    /// It is so, or others may make it so at any time.
    Now,
    By(NodeId),
}

impl Feasibility {
    /// The same of a tree that has become another one. What came to stand in the room may go again: it is left out.
    pub(super) fn anew(&self, mission: &Arc<MissionSpec>) -> Self {
        Self::new(mission, &self.free_space)
    }

    pub(super) fn new(mission: &Arc<MissionSpec>, free_space: &Arc<FreeSpace>) -> Self {
        let terms = Terms::of(mission);
        let count = terms.all.len();
        Self {
            mission: Arc::clone(mission),
            free_space: Arc::clone(free_space),
            terms,
            proofs: vec![Proof::Nothing; count],
            next: vec![[0, 0]; count],
            open_stands: OpenStands::default(),
            able: BTreeSet::new(),
            proves: BTreeMap::new(),
            lacking: BTreeMap::new(),
            spared: Vec::new(),
            returned: Vec::new(),
            suspects: BTreeSet::new(),
            is_stale: true,
        }
    }

    /// Takes note of what a record may have made impossible.
    pub(super) fn note(&mut self, record: &Record) {
        match record {
            Record::World { change, .. } => match change {
                // It may have been carried where no path leads back from.
                Change::Base(_) => {
                    self.open_stands = OpenStands::default();
                    self.is_stale = true;
                    self.suspects.extend(self.terms.about(About::Path));
                    self.suspect_change(*change);
                }
                // What came to stand somewhere may go again: nothing can never run because of it.
                Change::Blocked(_) | Change::Cleared(_) => {}
                // It may lie where other hands reach it, or none.
                Change::Object(..) | Change::Laid(..) | Change::Taken(..) | Change::Emptied(_) => self.is_stale = true,
                Change::Fact(..) => self.suspect_change(*change),
            },
            Record::Began { .. } | Record::Served { .. } | Record::Infeasible { .. } => self.is_stale = true,
            Record::TimedOut { .. } | Record::Reopened { .. } | Record::Overtaken { .. } => self.is_stale = true,
            Record::Ending { .. } | Record::Cleaning { .. } | Record::Cleaned { .. } | Record::Leaving { .. } => {
                self.is_stale = true
            }
            Record::Observed { change, .. } => self.suspect_change(*change),
            Record::Decided { granted, reopened, .. } => {
                // What was done, and ways that were chosen, counted towards what others may do.
                let is_less = |reopened: &Reopened| reopened.lapsed().is_none() || !reopened.undecided.is_empty();
                let counts = |reopened| is_less(reopened) || !self.spared.is_empty();
                self.is_stale |= reopened.as_ref().is_some_and(counts);
                if let Some(Reopened { node, up_to, .. }) = reopened {
                    let topology = &self.mission.tree.topology;
                    // Other ways of an OR that is not done any more count again.
                    let open = topology.within(*up_to, &self.terms.promises);
                    self.returned.extend(open.map(|(leaf, _)| leaf));
                    // What was done proved something as long as it might be sent back.
                    self.suspect_node(*node);
                }
                // What nobody had a lease of was everybody's own.
                self.is_stale |= !granted.is_empty() && self.spared.iter().any(|leaf| self.is_to_hold(*leaf));
                for skip in granted.iter().flat_map(|grant| &grant.request.skips) {
                    self.suspect_below(skip.from..skip.to);
                }
            }
            Record::Released { leaf, consequences, changes, .. } => {
                self.returned.push(*leaf);
                changes.iter().for_each(|change| self.suspect_change(*change));
                let completed = consequences.completed.map(|completed| completed.node);
                let failing = consequences.failing.map(|failing| failing.node);
                for node in [Some(*leaf), completed, consequences.failed, failing].into_iter().flatten() {
                    self.suspect_node(node);
                }
            }
            Record::Header(_) | Record::Told { .. } | Record::Turn { .. } | Record::Sent { .. } => {}
            Record::Stopped { .. } | Record::Woke { .. } | Record::Awaited { .. } | Record::Denied { .. } => {}
            Record::Resource { .. } | Record::Controller { .. } | Record::Ended { .. } => {}
            Record::Canceled { .. } => self.is_stale = true,
            // Root makes it anew for another tree.
            Record::Added { .. } | Record::Removed { .. } | Record::TaskEnded { .. } => {}
            Record::ObjectAdded { .. } | Record::ObjectRemoved { .. } => self.is_stale = true,
            Record::Granting { .. } | Record::Stalled { .. } | Record::Declined { .. } => {}
            Record::Checkpoint { .. } => {}
        }
    }

    fn suspect_change(&mut self, change: Change) {
        let about = match change {
            Change::Base(_) => About::Base,
            Change::Fact(fact, _) => About::Fact(fact),
            Change::Object(object, _) | Change::Laid(object, ..) | Change::Taken(object, _) => About::Object(object),
            // Of what was in it.
            Change::Emptied(_) | Change::Blocked(_) | Change::Cleared(_) => {
                self.is_stale = true;
                return;
            }
        };
        let is_shown = |term: &&usize| self.proofs[**term] == Proof::Now;
        self.suspects.extend(self.terms.about(about).iter().filter(is_shown));
    }

    /// Whatever a node and those below it prove, if they are over.
    fn suspect_node(&mut self, node: NodeId) {
        let proved = self.mission.tree.topology.within(node, &self.proves).flat_map(|(_, proved)| proved);
        self.suspects.extend(proved);
    }

    /// Whatever these nodes prove, if they are over.
    fn suspect_below(&mut self, nodes: Range<NodeId>) {
        self.suspects.extend(self.proves.range(nodes).flat_map(|(_, proved)| proved));
    }

    /// Behaviors that can never run any more, in tree order, each with what it lacks.
    pub(super) fn infeasible(&mut self, view: &View) -> Vec<(NodeId, Reason)> {
        let state = &view.state;
        let (suspects, returned) = (std::mem::take(&mut self.suspects), std::mem::take(&mut self.returned));
        self.is_stale |= returned.into_iter().any(|leaf| self.is_out_of_reach(leaf));
        self.is_stale |= !self.spared.is_empty() && !suspects.is_empty();
        self.is_stale |= !suspects.into_iter().all(|term| self.is_mended(state, term));
        if !std::mem::take(&mut self.is_stale) {
            return Vec::new();
        }
        self.prove_all(state);
        let is_left = |leaf: &NodeId| !state.is_over(*leaf) && !state.running().contains_key(leaf);
        let leaves: Vec<NodeId> = self.terms.promises.keys().copied().filter(is_left).collect();
        let mut found = Vec::new();
        let mut spared = Vec::new();
        for leaf in leaves.into_iter().filter(|leaf| self.is_out_of_reach(*leaf)) {
            match self.lacks(view, leaf) {
                Some(reason) => found.push((leaf, reason)),
                None => spared.push(leaf),
            }
        }
        self.spared = spared;
        found
    }

    /// Whether a behavior lacks what it claims, or something of its precondition that nothing makes so.
    fn is_out_of_reach(&self, leaf: NodeId) -> bool {
        // A cleanup's is not judged.
        let Some(promise) = self.terms.promises.get(&leaf) else { return false };
        let is_lost = promise.precondition.iter().any(|term| self.proofs[*term] == Proof::Nothing);
        self.lacking.contains_key(&leaf) || is_lost
    }

    /// Whether the goal of a behavior is to hold something.
    fn is_to_hold(&self, leaf: NodeId) -> bool {
        let mut goal = self.terms.promises[&leaf].goal.iter().flatten();
        goal.any(|term| matches!(self.terms.all[*term].condition, Condition::Held(_)))
    }

    /// What a behavior lacks that can never run.
    fn lacks(&self, view: &View, leaf: NodeId) -> Option<Reason> {
        // What is so already needs no robot.
        if let Some(reason) = self.lacking.get(&leaf).filter(|_| !is_met(view, leaf)) {
            return Some(reason.clone());
        }
        let promise = &self.terms.promises[&leaf];
        let is_out = |term: &&usize| self.proofs[**term] == Proof::Nothing;
        let first = *promise.precondition.iter().find(is_out)?;
        let is_reachable = promise.goal.as_ref().is_some_and(|goal| !goal.iter().any(|term| is_out(&term)));
        let is_spared = is_reachable || self.can_be_overtaken(&view.state, leaf);
        (!is_spared).then(|| reason(&self.terms.all[first].condition, &view.state, &self.mission.robot))
    }

    /// Whether others may do what a leaf is to do, so that the THEN goes on behind that.
    fn can_be_overtaken(&self, state: &State, leaf: NodeId) -> bool {
        let holds = &|leaf: NodeId, passed: &[NodeRange]| {
            let goal = self.terms.promises.get(&leaf).and_then(|promise| promise.goal.as_ref());
            goal.is_some_and(|goal| goal.iter().all(|term| self.comes_from_others(*term, passed)))
        };
        Overtaking { tree: &self.mission.tree, state, holds, can_go_on: &|_| true }.by(leaf).is_some()
    }

    /// Whether a term is so, or something makes it so that is not passed over.
    fn comes_from_others(&self, term: usize, passed: &[NodeRange]) -> bool {
        let is_passed = |maker: NodeId| passed.iter().any(|run| run.contains(maker));
        let is_other = |maker: &NodeId| !is_passed(*maker) && self.able.contains(maker);
        self.proofs[term] == Proof::Now || self.terms.all[term].makers.iter().any(is_other)
    }

    /// Everything that can become so, from what is.
    fn prove_all(&mut self, state: &State) {
        self.proves.clear();
        self.able.clear();
        self.proofs.fill(Proof::Nothing);
        self.find_lacking(state);
        let mut left: BTreeMap<NodeId, usize> = BTreeMap::new();
        let mut proved: Vec<usize> = Vec::new();
        for term in 0..self.terms.all.len() {
            if self.is_so(state, term) {
                self.prove(term, Proof::Now);
                proved.push(term);
            }
        }
        for leaf in self.terms.promises.keys().copied().collect::<Vec<_>>() {
            let is_running = state.running().contains_key(&leaf);
            if is_running || self.counts(state, leaf) {
                let needs = self.terms.promises[&leaf].precondition.len();
                let unmet = if is_running { 0 } else { needs };
                left.insert(leaf, unmet);
                if unmet == 0 {
                    self.prove_by(leaf, &mut proved);
                }
            }
        }
        while let Some(term) = proved.pop() {
            for index in 0..self.terms.all[term].needed_by.len() {
                let leaf = self.terms.all[term].needed_by[index];
                let Some(unmet) = left.get_mut(&leaf).filter(|unmet| **unmet > 0) else { continue };
                // A condition may be written twice.
                let times = self.terms.promises[&leaf].precondition.iter().filter(|needed| **needed == term).count();
                *unmet = unmet.saturating_sub(times);
                if *unmet == 0 {
                    self.prove_by(leaf, &mut proved);
                }
            }
        }
    }

    fn prove_by(&mut self, leaf: NodeId, proved: &mut Vec<usize>) {
        self.able.insert(leaf);
        for term in self.terms.promises[&leaf].makes.clone() {
            if self.proofs[term] == Proof::Nothing {
                self.prove(term, Proof::By(leaf));
                proved.push(term);
            }
        }
    }

    fn prove(&mut self, term: usize, proof: Proof) {
        if let Proof::By(before) = std::mem::replace(&mut self.proofs[term], proof)
            && let Some(proved) = self.proves.get_mut(&before)
        {
            proved.remove(&term);
        }
        if let Proof::By(leaf) = proof {
            self.proves.entry(leaf).or_default().insert(term);
        }
    }

    /// Whether a term has a proof still or again, or nobody asks for one.
    fn is_mended(&mut self, state: &State, term: usize) -> bool {
        let is_sound = match self.proofs[term] {
            Proof::Nothing => true,
            Proof::Now => self.is_so(state, term),
            Proof::By(leaf) => self.is_proof(state, leaf, term),
        };
        if is_sound {
            return true;
        }
        if self.is_so(state, term) {
            self.prove(term, Proof::Now);
            return true;
        }
        let [from, _] = self.next[term];
        let makers = &self.terms.all[term].makers;
        let mut others = (0..makers.len()).map(|step| (from + step) % makers.len());
        if let Some(index) = others.find(|index| self.is_proof(state, makers[*index], term)) {
            let maker = makers[index];
            self.next[term][0] = index;
            self.prove(term, Proof::By(maker));
            return true;
        }
        let [_, from] = self.next[term];
        let readers = &self.terms.all[term].readers;
        let mut others = (0..readers.len()).map(|step| (from + step) % readers.len());
        match others.find(|index| self.counts(state, readers[*index])) {
            Some(index) => {
                self.next[term][1] = index;
                false
            }
            None => {
                self.prove(term, Proof::Nothing);
                true
            }
        }
    }

    /// Whether a behavior can make a term so, by proofs that do not need it.
    fn is_proof(&self, state: &State, leaf: NodeId, of: usize) -> bool {
        let mut leaves = vec![leaf];
        let mut looked_at = BTreeSet::new();
        while let Some(leaf) = leaves.pop() {
            if state.running().contains_key(&leaf) {
                continue;
            }
            if !self.counts(state, leaf) || looked_at.len() > LOOKS {
                return false;
            }
            for &term in &self.terms.promises[&leaf].precondition {
                match self.proofs[term] {
                    _ if term == of => return false,
                    Proof::Nothing => return false,
                    Proof::Now => {}
                    Proof::By(other) => {
                        if looked_at.insert(other) {
                            leaves.push(other);
                        }
                    }
                }
            }
        }
        true
    }

    /// Whether something may yet come of a behavior: it is left, or is done below a THEN that may send it back.
    fn counts(&self, state: &State, leaf: NodeId) -> bool {
        let is_left = |node: NodeId| match state.phase(node) {
            Phase::Pending => true,
            Phase::Done | Phase::Failed | Phase::Ending | Phase::Cleaning(_) => false,
            Phase::Failing(failing) => failing.finishes || begins_again(&self.mission.tree, state, failing),
        };
        let tree = &self.mission.tree;
        // Whether all from here up is left, and whether a THEN is among that, or what is done once more.
        let (mut has_then, mut is_again, mut is_own_left) = (false, false, true);
        for node in tree.topology.path(leaf) {
            if !is_left(node) {
                (has_then, is_again, is_own_left) = (false, false, false);
            } else {
                has_then |= Ordering::of(&tree.nodes[node.index()]) == Some(Ordering::Then);
                is_again |= is_repeated(tree, state, node);
            }
        }
        is_own_left || is_again || has_then && state.is_done(leaf)
    }

    /// Whether a term holds as things are, or others may make it so at any time.
    fn is_so(&mut self, state: &State, term: usize) -> bool {
        let world = state.world();
        match self.terms.all[term].condition {
            Condition::All(_) | Condition::Never => false,
            Condition::At { ref stands, tolerance_m, .. } => behavior::is_at(world.base, stands, tolerance_m),
            Condition::Path { ref stands, .. } => {
                stands.iter().any(|stand| self.open_stands.leads_to(&self.free_space, world.base, *stand))
            }
            Condition::Held(hold) => {
                let robot = &self.mission.robot;
                holders(hold, state, robot) >= hold.hands && (!hold.alone || robot.is_held_alone(hold, world))
            }
            Condition::Free(object) => world.objects[object.index()].holders().is_empty(),
            Condition::Somewhere(object) => matches!(world.objects[object.index()], Location::At(_)),
            Condition::Lies(object, place) => world.objects[object.index()] == Location::At(place),
            Condition::Fact(fact, holds) => world.facts[fact.index()] == holds || self.mission.world.is_outside(fact),
        }
    }

    fn find_lacking(&mut self, state: &State) {
        let (mission, free_space) = (Arc::clone(&self.mission), Arc::clone(&self.free_space));
        let leaves: Vec<NodeId> = self.terms.promises.keys().copied().collect();
        let acting =
            leaves.iter().copied().filter(|leaf| state.running().contains_key(leaf) || self.counts(state, *leaf));
        let reaching = Reaching::new(&mission, state, acting);
        let open_stands = &mut self.open_stands;
        let mut is_open = |stand: &Pose| open_stands.leads_to(&free_space, state.world().base, *stand);
        let lacking = leaves.into_iter().filter_map(|leaf| {
            let spec = mission.tree.behavior(leaf)?;
            let lack = behavior::lacks_for_good(spec, state, &mission.robot);
            let lack = lack.or_else(|| reaching.lacks(leaf, &mut is_open));
            Some((leaf, lack.or_else(|| ahead::lacks_for_good(&mission, leaf))?))
        });
        self.lacking = lacking.collect();
    }
}

/// Behaviors that can never run as a mission begins, in tree order, each with what it lacks.
pub fn infeasible_at_start(mission: &MissionSpec) -> Vec<(NodeId, Reason)> {
    let topology = Arc::new(mission.tree.topology.clone());
    let state = State::new(topology, mission.robot.resources.len(), mission.start.clone());
    let free_space = Arc::new(FreeSpace::of(mission));
    let mission = Arc::new(mission.clone());
    let view = View {
        round: 1,
        now: Time::ZERO,
        state,
        touched: None,
        barred: Arc::default(),
        mission: Arc::clone(&mission),
        ways: Arc::new(Ways::new(&free_space, mission.start.base)),
        rules: Arc::new(Bodies),
    };
    Feasibility::new(&mission, &free_space).infeasible(&view)
}

/// How many that count hold an object, whoever has them.
fn holders(hold: Hold, state: &State, robot: &RobotSpec) -> u32 {
    let holders = state.world().objects[hold.object.index()].holders().iter();
    holders.filter(|holder| robot.counts(hold.by, **holder)).count() as u32
}

/// Why a single condition is not so, which is not.
fn reason(single: &Condition, state: &State, robot: &RobotSpec) -> Reason {
    match *single {
        Condition::At { place, .. } => Reason::NotAt { place },
        Condition::Path { place, .. } => Reason::NoPath { place },
        Condition::Held(hold) => hold.reason(holders(hold, state, robot)),
        Condition::Lies(object, place) => Reason::Elsewhere { object, place },
        Condition::Fact(fact, holds) => Reason::Fact { fact, holds },
        Condition::Free(object) | Condition::Somewhere(object) => {
            match state.world().objects[object.index()].holders().first() {
                Some(&by) => Reason::Taken { object, by },
                None => Reason::Nowhere { object },
            }
        }
        Condition::All(_) | Condition::Never => Reason::Unwanted,
    }
}
