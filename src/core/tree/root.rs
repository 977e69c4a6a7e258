//! Root: keeps the state, takes up in turns what it is told, opens rounds, grants, and moves leases. Only it decides.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use super::allocator::Chosen;
use super::certificate::{Certificate, Safe};
use super::fairness::Fairness;
use super::feasibility::Feasibility;
use super::reasons::Reasons;
use super::reopening::{Found, RoundEnd};
use super::topics::Touches;
use super::winners::{winner, with_winner};
use super::{Activation, Answer, Down, Effect, News, Outbox, Scope, Settings, TOP, Verdict};
use crate::behavior;
use crate::world::{FreeSpace, View, Ways};
use ambidex_model::state::{Stage, State};
use ambidex_model::{
    Blocked, Change, Grant, MissionEnd, MissionSpec, NodeId, Objection, Origin, Reason, Record, Request, ResourceTable,
    Source, Time, Told,
};

/// The machine of root.
#[derive(Debug)]
pub struct Root {
    pub(super) mission: Arc<MissionSpec>,
    pub(super) free_space: Arc<FreeSpace>,
    /// What has come to stand in the room.
    pub(super) came: FreeSpace,
    /// What was found in the last round.
    pub(super) ways: Option<Arc<Ways>>,
    pub(super) settings: Settings,
    pub(super) state: State,
    /// All ORs, in tree order.
    pub(super) ors: Vec<NodeId>,
    /// Whom a round has to ask; none where every round asks all.
    pub(super) touches: Option<Touches>,
    /// Why those that were asked do not run, as they and the nodes above them said it last.
    pub(super) reasons: Reasons,
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
    pub(super) was_quiet: bool,
    /// It goes on after its runtime was gone, and has not been told to begin again.
    pub(super) is_suspended: bool,
    /// The mission is to end, once nothing runs any more.
    pub(super) ending: Option<MissionEnd>,
    /// How often work was asked for.
    pub(super) asked_for: u64,
    /// Nodes came or went since proofs and certificate were made.
    pub(super) is_tree_new: bool,
    /// Tasks that are over and not gone, and how they ended.
    pub(super) ended: BTreeMap<NodeId, MissionEnd>,
    /// Tasks that said that they are satisfied.
    pub(super) met: BTreeSet<NodeId>,
    /// Tasks of which nothing went on in the last round.
    pub(super) idle: BTreeSet<NodeId>,
    /// What parts of the tree were read from, each by its top.
    pub(super) parts: BTreeMap<NodeId, Arc<Source>>,
}

impl Root {
    pub(super) fn new(mission: &Arc<MissionSpec>, settings: &Settings) -> Self {
        let resources = mission.robot.resources.len();
        let free_space = Arc::new(FreeSpace::of(mission));
        Self {
            feasibility: Feasibility::new(mission, &free_space),
            ors: mission.tree.ors().collect(),
            free_space,
            came: FreeSpace::new(&[], mission.robot.radius_m),
            ways: None,
            settings: settings.clone(),
            touches: settings.is_local().then(|| Touches::new(mission, settings.unheard)),
            state: State::new(Arc::new(mission.tree.topology.clone()), resources, mission.start.clone()),
            reasons: Reasons::default(),
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
            asked_for: 0,
            is_tree_new: false,
            ended: BTreeMap::new(),
            met: BTreeSet::new(),
            idle: BTreeSet::new(),
            parts: BTreeMap::new(),
            mission: Arc::clone(mission),
        }
    }

    /// Whether messages are told.
    pub fn has_messages(&self) -> bool {
        self.settings.has_messages
    }

    /// The mission as it is now: its tree may live.
    pub fn mission(&self) -> &Arc<MissionSpec> {
        &self.mission
    }

    /// What the run has come to.
    pub fn state(&self) -> &State {
        &self.state
    }

    /// Whether a turn is due as soon as nothing else is there for root.
    pub fn wants_turn(&self) -> bool {
        // What is wanted before the mission begins waits for that.
        let may_go_on = !self.is_suspended && self.state.stage() == Stage::Running;
        let goes_on = may_go_on && (self.is_wanted || self.is_quiet || !self.idle.is_empty());
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
        self.know_tree();
        if !self.is_over() && !self.is_suspended && self.ending.is_none() && self.state.stage() == Stage::Running {
            self.give_up(now, out);
        }
        if !self.is_over() && !self.is_suspended {
            self.go_on(now, out);
        }
    }

    /// Proofs and certificate are about the tree as it is.
    fn know_tree(&mut self) {
        if std::mem::take(&mut self.is_tree_new) {
            self.feasibility = self.feasibility.anew(&self.mission);
            self.certificate.know(&self.mission);
            self.ors = self.mission.tree.ors().collect();
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
        self.stop_late_cleanups(now, out);
        self.end_tasks(now, out);
        self.know_tree();
        let is_wanted = std::mem::take(&mut self.is_wanted);
        let is_quiet = std::mem::take(&mut self.is_quiet);
        if let Some(end) = self.ending {
            if self.state.running().is_empty() && !self.owes_cleanup() {
                return self.finish(now, end, out);
            }
            self.stop_all(now, out);
            if self.state.cleaning().is_empty() || self.is_grace_over() {
                // Nothing is granted any more, so nothing is judged.
                self.idle.clear();
                return;
            }
        }
        if is_wanted {
            self.open_round(now, out);
        } else if self.mission.tree.is_standing() {
            let idle = std::mem::take(&mut self.idle);
            self.stall_tasks(now, &idle, out);
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
        let granted = verdict.granted.keys().filter_map(|leaf| self.state.task_of(*leaf)).collect();
        if !verdict.granted.is_empty() || !verdict.stopped.is_empty() {
            out.push(Effect::Down(TOP, Down::Verdict(Arc::new(verdict))));
        }
        if self.mission.tree.is_standing() {
            self.end_round(now, &view, granted, out);
        } else if answer.is_satisfied {
            self.finish(now, MissionEnd::Done, out);
        }
    }

    /// Tasks that took a step are paused, and those that did nothing are judged when nothing else is to be done.
    fn end_round(&mut self, now: Time, view: &View, granted: BTreeSet<NodeId>, out: &mut Outbox) {
        self.end_steps(now, &granted, out);
        self.is_wanted |= !self.met.is_empty();
        let idle = match self.is_quiet {
            true => self.idle_tasks(None),
            false => self.idle_tasks(view.touched.as_deref()),
        };
        self.idle.retain(|task| !granted.contains(task));
        self.idle.extend(idle.into_iter().filter(|task| !granted.contains(task)));
    }

    fn take_in(&mut self, news: News) {
        for range in news.withdrawn {
            self.reasons.withdraw(&self.mission.tree, range.from..range.to);
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
        if reason == Some(Reason::Satisfied) && self.mission.tree.is_standing() && self.is_task(node) {
            self.met.insert(node);
        }
        self.reasons.take(&self.mission.tree, node, reason);
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
        for leaf in self.certificate.note(&record).into_iter().filter(|leaf| self.state.topology().has(*leaf)) {
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
            Told::Work { work } => self.work(now, work, out),
            Told::End { end } => {
                let end = if end == MissionEnd::Stalled { self.stalled() } else { end };
                self.end(now, end, out);
            }
        }
    }

    fn open_round(&mut self, now: Time, out: &mut Outbox) {
        let touched = self.touches.as_mut().map(Touches::take);
        self.ways = Some(self.ways());
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
        for Blocked { leaf, reason } in outbid.into_iter().chain(refused) {
            self.reasons.take(&self.mission.tree, leaf, Some(reason));
        }
        let (topology, stopped) = (Arc::clone(view.state.topology()), BTreeSet::new());
        let mut verdict =
            Verdict { round: view.round, granted: BTreeMap::new(), stopped, view: Some(Arc::clone(view)), topology };
        for mut grant in granted {
            self.reasons.take(&self.mission.tree, grant.leaf(), None);
            grant.met = met(&grant, &self.reasons);
            grant.way = behavior::way(&grant.request, view);
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

    /// The table is told as it is.
    pub(super) fn is_table_told(&mut self) {
        self.last_recorded = Arc::clone(self.state.table());
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
        self.give_up_tasks(now, out);
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
