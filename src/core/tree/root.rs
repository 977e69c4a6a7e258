//! Root: keeps the state, takes up in turns what it is told, opens rounds, grants, and moves leases. Only it decides.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;

use super::allocator::Chosen;
use super::certificate::{Certificate, Safe};
use super::fairness::Fairness;
use super::feasibility::Feasibility;
use super::reopening::{Found, RoundEnd};
use super::topics::{Topic, Touches};
use super::winners::{winner, with_winner};
use super::{Activation, Allocator, Answer, Down, Effect, Greedy, News, Outbox, Scope, TOP, Verdict};
use crate::world::{Compatible, FreeSpace, Unconstrained, View};
use ambidex_model::state::{Stage, State};
use ambidex_model::{
    Blocked, Change, Grant, Header, MissionEnd, MissionSpec, NodeId, Objection, Origin, Reason, Record, Request,
    ResourceTable, Time, Told,
};

/// How long a controller is awaited by default, robot time.
pub const REATTACH: Duration = Duration::from_secs(10);

/// How long cleanups may take by default once a mission is told to end, robot time.
pub const CLEANUP_GRACE: Duration = Duration::from_secs(10);

/// How a mission is to be run.
#[derive(Debug, Clone)]
pub struct Settings {
    /// How requests are chosen.
    pub allocator: Arc<dyn Allocator>,
    /// What may go on at once beyond resources and objects.
    pub rules: Arc<dyn Compatible>,
    /// Whether a request is refused after whose grant something could never be finished.
    pub prevents_deadlock: bool,
    /// Whether a stall waits for the world instead of ending the mission.
    pub waits_when_stalled: bool,
    /// Whether records tell every message between nodes, and with every decision why all else does not run. All that
    /// can be computed again; it grows with nodes times rounds.
    pub has_messages: bool,
    /// How long a controller is awaited without which nothing can go on, robot time.
    pub reattach: Duration,
    /// How long cleanups may take all together once the mission is told to end, robot time.
    pub cleanup_grace: Duration,
    /// Topics whose readers are not asked again, so that rounds go wrong: by this a test shows that it would notice.
    pub unheard: fn(Topic) -> bool,
}

impl Settings {
    /// Whether an answer depends on nothing but what its leaves can read.
    fn is_local(&self) -> bool {
        self.allocator.is_local() && self.rules.is_unconstrained()
    }

    /// How the run of a log was run, by its first record and the allocator that this one names.
    pub fn of(header: &Header, allocator: Arc<dyn Allocator>) -> Self {
        Self {
            allocator,
            waits_when_stalled: header.waits_when_stalled,
            has_messages: header.has_messages,
            reattach: Duration::from_micros(header.reattach_us),
            cleanup_grace: Duration::from_micros(header.cleanup_grace_us),
            ..Self::default()
        }
    }

    /// The first record of a run of a mission.
    pub fn header(&self, mission: &MissionSpec) -> Header {
        Header {
            has_messages: self.has_messages,
            reattach_us: u64::try_from(self.reattach.as_micros()).unwrap_or(u64::MAX),
            cleanup_grace_us: u64::try_from(self.cleanup_grace.as_micros()).unwrap_or(u64::MAX),
            ..Header::new(mission, self.allocator.name(), self.waits_when_stalled)
        }
    }
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            allocator: Arc::new(Greedy),
            rules: Arc::new(Unconstrained),
            prevents_deadlock: true,
            waits_when_stalled: false,
            has_messages: true,
            reattach: REATTACH,
            cleanup_grace: CLEANUP_GRACE,
            unheard: |_| false,
        }
    }
}

/// The machine of root.
#[derive(Debug)]
pub struct Root {
    pub(super) mission: Arc<MissionSpec>,
    pub(super) free_space: Arc<FreeSpace>,
    pub(super) settings: Settings,
    pub(super) state: State,
    /// All ORs, in tree order.
    pub(super) ors: Vec<NodeId>,
    /// Whom a round has to ask; none where every round asks all.
    pub(super) touches: Option<Touches>,
    /// Why those that were asked do not run, as they and the nodes above them said it last.
    pub(super) reasons: BTreeMap<NodeId, Reason>,
    /// What behaviors would ask for that wait for others, by leaf.
    pub(super) wishes: BTreeMap<NodeId, Arc<Request>>,
    /// Whom behaviors with a wish have interrupted, with the progress at which they did.
    pub(super) preempted: BTreeMap<(NodeId, NodeId), u64>,
    /// When the present time of nodes began that are done more than once.
    pub(super) began: BTreeMap<NodeId, Time>,
    pub(super) fairness: Fairness,
    pub(super) certificate: Certificate,
    pub(super) feasibility: Feasibility,
    /// The table as the records tell it.
    last_recorded: Arc<ResourceTable>,
    /// What came since the last turn.
    pub(super) told: Vec<Told>,
    /// Where the base was seen last since then.
    observed: Option<Change>,
    /// What others said and was refused since the world is as it is.
    pub(super) denied: Vec<(Change, Origin, Objection)>,
    open: Option<Arc<View>>,
    /// When the last turn was. When an answer comes up is no part of what follows from the records, so that all moments
    /// are counted from there.
    pub(super) turned: Time,
    /// A round is to be opened.
    pub(super) is_wanted: bool,
    /// The last round came to nothing, and nothing runs.
    pub(super) is_quiet: bool,
    /// The last round granted nothing while nothing ran, so that its reasons are told.
    was_quiet: bool,
    /// It goes on after its runtime was gone, and has not been told to begin again.
    pub(super) is_suspended: bool,
    /// The mission is to end, once nothing runs any more.
    pub(super) ending: Option<MissionEnd>,
}

impl Root {
    pub(super) fn new(mission: &Arc<MissionSpec>, settings: &Settings) -> Self {
        let resources = mission.robot.resources.len();
        let free_space = Arc::new(FreeSpace::new(&mission.world.obstacles, mission.robot.radius_m));
        Self {
            feasibility: Feasibility::new(mission, &free_space),
            ors: mission.tree.ors().collect(),
            free_space,
            settings: settings.clone(),
            touches: settings.is_local().then(|| Touches::new(mission, settings.unheard)),
            state: State::new(Arc::new(mission.tree.topology.clone()), resources, mission.start.clone()),
            reasons: BTreeMap::new(),
            wishes: BTreeMap::new(),
            preempted: BTreeMap::new(),
            began: BTreeMap::new(),
            fairness: Fairness::default(),
            certificate: Certificate::new(mission, settings.prevents_deadlock),
            last_recorded: Arc::new(ResourceTable::new(resources)),
            told: Vec::new(),
            observed: None,
            denied: Vec::new(),
            open: None,
            turned: Time::ZERO,
            is_wanted: false,
            is_quiet: false,
            was_quiet: false,
            is_suspended: false,
            ending: None,
            mission: Arc::clone(mission),
        }
    }

    /// Whether messages are told.
    pub fn has_messages(&self) -> bool {
        self.settings.has_messages
    }

    /// What the run has come to.
    pub fn state(&self) -> &State {
        &self.state
    }

    /// Whether a turn is due as soon as nothing else is there for root.
    pub fn wants_turn(&self) -> bool {
        let goes_on = !self.is_suspended && (self.is_wanted || self.is_quiet);
        let has_cause = !self.told.is_empty() || goes_on;
        self.open.is_none() && has_cause && !self.is_over()
    }

    /// Takes note; what comes of it is decided in the next turn.
    pub(super) fn on_told(&mut self, now: Time, told: Told, out: &mut Outbox) {
        if self.is_over() {
            self.turn_away(&told, out);
            return;
        }
        if self.is_no_news(&told) {
            return;
        }
        out.push(Effect::Record(Box::new(Record::Told { at: now, input: told.clone() })));
        self.told.push(told);
    }

    /// The next such word says it better; the last one counts in the next turn.
    pub(super) fn on_observation(&mut self, change: Change) {
        self.observed = Some(change);
    }

    /// Takes up what came, in its order; then ends the mission if it is over, else opens a round if one is wanted.
    pub(super) fn turn(&mut self, now: Time, out: &mut Outbox) {
        assert!(self.open.is_none(), "a turn begins between rounds");
        self.turned = now;
        if let Some(change) = self.observed.take() {
            self.edit(Record::Observed { at: now, change }, out);
        }
        out.push(Effect::Record(Box::new(Record::Turn { at: now })));
        for told in std::mem::take(&mut self.told) {
            if self.is_over() {
                self.turn_away(&told, out);
            } else {
                self.take_up(now, told, out);
            }
        }
        if self.is_suspended && self.ending.is_some() {
            self.interrupt(now, out);
        }
        if !self.is_over() && !self.is_suspended && self.ending.is_none() && self.state.stage() == Stage::Running {
            self.give_up(now, out);
        }
        if !self.is_over() && !self.is_suspended {
            self.go_on(now, out);
        }
    }

    /// What a turn comes to once all is taken up.
    fn go_on(&mut self, now: Time, out: &mut Outbox) {
        if self.state.stage() != Stage::Running {
            if let Some(end) = self.ending {
                self.finish(now, end, out);
            }
            return;
        }
        self.begin_cleanups(now, out);
        let is_wanted = std::mem::take(&mut self.is_wanted);
        let is_quiet = std::mem::take(&mut self.is_quiet);
        if let Some(end) = self.ending {
            if self.state.running().is_empty() && !self.owes_cleanup() {
                return self.finish(now, end, out);
            }
            self.stop_all(now, out);
            if self.state.cleaning().is_empty() || self.is_grace_over() {
                return;
            }
        }
        if is_wanted {
            self.open_round(now, out);
        } else if is_quiet {
            self.stall(now, out);
        }
    }

    pub(super) fn on_answer(
        &mut self,
        now: Time,
        top: NodeId,
        answer: &Answer,
        news: Option<Box<News>>,
        out: &mut Outbox,
    ) {
        let view = self.open.take().expect("an answer ends an open round");
        if let Some(news) = news {
            self.take_in(*news);
        }
        // A task node has told its own word, if it has one, among the news.
        if self.mission.tree.behavior(top).is_some() {
            self.take_word(top, answer.reason.clone());
            self.take_wish(top, answer.wish.clone());
        }
        let (mut verdict, wished) = self.decide(now, &view, answer, out);
        verdict.stopped = self.stop_what_ends(now, out);
        verdict.stopped.extend(self.stop_broken(now, out));
        verdict.stopped.extend(self.preempt(now, &view, &wished, out));
        if !verdict.granted.is_empty() || !verdict.stopped.is_empty() {
            out.push(Effect::Down(TOP, Down::Verdict(Arc::new(verdict))));
        }
        if answer.is_satisfied {
            self.finish(now, MissionEnd::Done, out);
        }
    }

    fn take_in(&mut self, news: News) {
        for range in news.withdrawn {
            let gone: Vec<NodeId> = self.reasons.range(range.from..range.to).map(|(&leaf, _)| leaf).collect();
            gone.iter().for_each(|leaf| drop(self.reasons.remove(leaf)));
            let gone: Vec<NodeId> = self.wishes.range(range.from..range.to).map(|(&leaf, _)| leaf).collect();
            gone.iter().for_each(|leaf| drop(self.wishes.remove(leaf)));
        }
        for (leaf, reason) in news.reasons {
            self.take_word(leaf, reason);
        }
        for (leaf, wish) in news.wishes {
            self.take_wish(leaf, wish);
        }
    }

    fn take_word(&mut self, node: NodeId, reason: Option<Reason>) {
        match reason {
            Some(reason) => drop(self.reasons.insert(node, reason)),
            None => drop(self.reasons.remove(&node)),
        }
    }

    fn take_wish(&mut self, leaf: NodeId, wish: Option<Arc<Request>>) {
        match wish {
            Some(wish) => drop(self.wishes.insert(leaf, wish)),
            None => drop(self.wishes.remove(&leaf)),
        }
    }

    pub(super) fn is_between_rounds(&self) -> bool {
        self.open.is_none()
    }

    pub(super) fn is_over(&self) -> bool {
        matches!(self.state.stage(), Stage::Over(_))
    }

    /// The one way on which anything of the state changes: as a record.
    pub(super) fn edit(&mut self, record: Record, out: &mut Outbox) {
        let at = record.at();
        let before = self.touches.is_some().then(|| self.state.clone());
        assert!(self.state.apply(&record), "root contradicts itself: {record:?}");
        if let (Some(touches), Some(before)) = (&mut self.touches, before) {
            touches.note(&before, &self.state, &record);
        }
        self.forget_cleaned(&record);
        self.feasibility.note(&record);
        for leaf in self.certificate.note(&record) {
            self.touches.iter_mut().for_each(|touches| touches.note_bar(leaf));
        }
        self.state.table().assert_sound();
        out.push(Effect::Record(Box::new(record)));
        self.tell_table(at, out);
    }

    fn take_up(&mut self, now: Time, told: Told, out: &mut Outbox) {
        match told {
            Told::Begin { changes } => self.begin(now, changes, out),
            Told::Resumed => self.is_suspended = true,
            Told::World { change, origin } => self.hear(now, change, origin, out),
            Told::Ended { leaf, outcome } => self.release(now, leaf, outcome, out),
            Told::Service { controller, outage, changes } => {
                self.serve(now, controller, outage, out);
                self.find_out(now, changes, Origin::Controller(controller), out);
            }
            Told::Woke => self.wake(now, out),
            Told::End { end } => {
                let end = if end == MissionEnd::Stalled { self.stalled() } else { end };
                self.end(now, end, out);
            }
        }
    }

    fn open_round(&mut self, now: Time, out: &mut Outbox) {
        let touched = self.touches.as_mut().map(Touches::take);
        let view = Arc::new(View { touched, ..self.view(now) });
        self.open = Some(Arc::clone(&view));
        let scope = if view.touched.is_none() { Scope::Anew } else { Scope::Changed };
        if scope == Scope::Anew {
            self.reasons.clear();
            self.wishes.clear();
        }
        let activation = Activation { view, skips: Arc::default(), scope };
        out.push(Effect::Down(TOP, Down::Activation(activation)));
    }

    /// Chooses, moves the leases, and finds what lapses or is done again; gives also the wishes that found a place.
    fn decide(&mut self, now: Time, view: &Arc<View>, answer: &Answer, out: &mut Outbox) -> (Verdict, Vec<Grant>) {
        let wishes = self.wishes_of(view, &answer.requests);
        let allocator = self.settings.allocator.as_ref();
        let Safe { chosen, refused } = self.certificate.choose(allocator, view, &answer.requests, &wishes);
        let Chosen { granted, refused: outbid, wished } = chosen;
        // Whom a refused request hides is asked before anything lapses.
        let reserved = outbid.iter().filter(|blocked| matches!(blocked.reason, Reason::Reserved { .. })).cloned();
        let hiding: Vec<Blocked> = refused.iter().cloned().chain(reserved).collect();
        let is_hiding = granted.is_empty() && !hiding.is_empty();
        self.bar(is_hiding, &hiding);
        self.reasons.extend(outbid.into_iter().chain(refused).map(|blocked| (blocked.leaf, blocked.reason)));
        let mut verdict = Verdict { round: view.round, view: Some(Arc::clone(view)), ..Verdict::default() };
        for mut grant in granted {
            self.reasons.remove(&grant.leaf());
            grant.met = met(&grant, &self.reasons);
            verdict.granted.insert(grant.leaf(), grant);
        }
        self.note_grants(&verdict);
        let mut decided = Record::Decided {
            at: now,
            round: view.round,
            granted: verdict.granted.values().cloned().collect(),
            refused: Vec::new(),
            reopened: None,
            deadlines: self.deadlines(verdict.granted.values()),
            urged: self.urge(),
            overdue: self.fairness.overdue(&self.mission.tree, &self.state, &self.reasons, &verdict),
        };
        let goes_on = !answer.is_satisfied && !is_hiding;
        let (found, overtaken) = match goes_on.then(|| self.find(view, &decided)).flatten() {
            Some(Found::Reopened(found)) => (Some(with_winner(self.state.running(), &verdict, found)), None),
            Some(Found::Overtaken(overtaken)) => (None, Some(overtaken)),
            None => (None, None),
        };
        // What was satisfied in this round may not be so any more.
        let begins_anew = found.is_some() || overtaken.is_some();
        let is_nothing = verdict.granted.is_empty() && !begins_anew && !is_hiding;
        self.tell_why(&mut decided, &verdict, is_nothing);
        if let Record::Decided { reopened, urged, overdue, .. } = &mut decided {
            self.is_wanted |= urged.is_some() || overdue.is_some();
            *reopened = found;
        }
        self.edit(decided, out);
        self.is_wanted |= !is_nothing;
        if let Some(overtaken) = overtaken {
            self.overtake(now, overtaken, out);
        }
        self.give_way(now, view, &wished, out);
        if !begins_anew {
            self.end_satisfied(now, out);
        }
        let is_idle = self.state.running().is_empty() && self.state.waits().is_empty();
        self.is_quiet = is_nothing && is_idle && !self.is_wanted;
        (verdict, wished)
    }

    /// Where nothing goes on any more, the reasons are the news.
    fn tell_why(&mut self, decided: &mut Record, verdict: &Verdict, is_nothing: bool) {
        let is_idle = self.state.running().is_empty() && self.state.waits().is_empty();
        let is_quiet = is_nothing && is_idle;
        let is_news = is_quiet && !self.was_quiet;
        self.was_quiet = is_quiet;
        if let Record::Decided { refused, .. } = decided
            && (is_news || self.settings.has_messages)
        {
            let tree = &self.mission.tree;
            let leaves = self.reasons.iter().filter(|(node, _)| tree.behavior(**node).is_some());
            refused.extend(leaves.map(|(&leaf, reason)| {
                let winner = winner(self.state.running(), verdict, reason);
                Blocked { leaf, reason: winner.unwrap_or_else(|| reason.clone()) }
            }));
        }
    }

    /// What is done again, or need not be done, once the grants of a decision are made.
    fn find(&self, view: &View, decided: &Record) -> Option<Found> {
        let mut view = View { state: self.state.clone(), ..View::clone(view) };
        view.state.apply(decided);
        RoundEnd { view: &view, refused: &self.reasons }.find()
    }

    fn bar(&mut self, is_hiding: bool, refused: &[Blocked]) {
        if is_hiding {
            self.certificate.bar(refused);
            let touches = self.touches.iter_mut();
            touches.for_each(|touches| refused.iter().for_each(|blocked| touches.note_bar(blocked.leaf)));
        }
    }

    /// Records every resource that is not as it was last told.
    fn tell_table(&mut self, now: Time, out: &mut Outbox) {
        let table = self.state.table();
        if Arc::ptr_eq(table, &self.last_recorded) {
            return;
        }
        for (id, resource) in table.iter().filter(|(id, resource)| self.last_recorded.resource(*id) != *resource) {
            let state = resource.clone();
            out.push(Effect::Record(Box::new(Record::Resource { at: now, resource: id, state })));
        }
        self.last_recorded = Arc::clone(table);
    }

    pub(super) fn finish(&mut self, now: Time, end: MissionEnd, out: &mut Outbox) {
        self.edit(Record::Ended { at: now, end }, out);
        out.push(Effect::Finished(end));
    }
}

/// Leaves that a grant skips since their goal is met.
fn met(grant: &Grant, refused: &BTreeMap<NodeId, Reason>) -> Vec<NodeId> {
    let skips = grant.request.skips.iter();
    let skipped = skips.flat_map(|skip| refused.range(skip.from..skip.to));
    skipped.filter(|(_, reason)| **reason == Reason::Satisfied).map(|(&leaf, _)| leaf).collect()
}
