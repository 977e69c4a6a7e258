//! The actor of a task node (III-C): passes the view down, and answers once for everything below it. What it knows of
//! its children stands in the view; it keeps the open round, and what they said last.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use super::ordering::{Ordering, is_repeated};
use super::{Activation, Allocator, Answer, Down, Effect, News, Offers, Outbox, Scope, Settings, Up, Verdict};
use crate::world::View;
use ambidex_model::state::{Phase, Wait};
use ambidex_model::{Failing, MissionSpec, NodeId, NodeKind, NodeRange, Reason, Topology};

/// The machine of a task node.
#[derive(Debug)]
pub struct Composite {
    id: NodeId,
    ordering: Ordering,
    /// Whether what is below are tasks, each by itself.
    is_stem: bool,
    /// Of the topology that its children are known by.
    version: u64,
    allocator: Arc<dyn Allocator>,
    children: Vec<Child>,
    /// Of an AND: what the children ask for.
    offers: Offers,
    /// Of an AND: how many of those that it asks are not satisfied.
    unsatisfied: usize,
    /// Of OR and THEN: the children whose answers count, by index, in their order.
    order: Vec<usize>,
    said: Option<Arc<Answer>>,
    /// What it said last was why nothing below is asked, but for cleanups.
    was_silent: bool,
    /// Whether all of it was satisfied, though it is not: it is done once more, or is a cleanup.
    was_complete: bool,
    open: Option<Open>,
}

/// A child, and what it said in the last round; none where it was not asked.
#[derive(Debug)]
struct Child {
    id: NodeId,
    asked: Option<Asked>,
}

#[derive(Debug)]
struct Asked {
    /// What was skipped on the way to it.
    skips: Arc<Vec<NodeRange>>,
    /// None before its first answer.
    said: Option<Arc<Answer>>,
}

/// A round from activation to answer.
#[derive(Debug)]
struct Open {
    view: Arc<View>,
    /// What was skipped above.
    skips: Arc<Vec<NodeRange>>,
    scope: Scope,
    /// How many have not answered.
    waiting: usize,
    /// Whether anybody says something else than in the last round, or others are asked.
    is_different: bool,
    news: News,
}

impl Composite {
    pub(super) fn new(id: NodeId, ordering: Ordering, mission: &MissionSpec, settings: &Settings) -> Self {
        let topology = &mission.tree.topology;
        let children = topology.children(id).map(|id| Child { id, asked: None }).collect();
        Self {
            id,
            ordering,
            is_stem: mission.tree.nodes[id.index()] == NodeKind::Tasks,
            version: topology.version(),
            allocator: Arc::clone(&settings.allocator),
            children,
            offers: Offers::default(),
            unsatisfied: 0,
            order: Vec::new(),
            said: None,
            was_silent: false,
            was_complete: false,
            open: None,
        }
    }

    pub(super) fn on_down(&mut self, down: Down, out: &mut Outbox) {
        match down {
            Down::Activation(activation) => self.on_activation(activation, out),
            Down::Verdict(verdict) => self.on_verdict(&verdict, out),
        }
    }

    pub(super) fn on_answer(&mut self, child: NodeId, answer: Arc<Answer>, news: Option<Box<News>>, out: &mut Outbox) {
        let index = self.index_of(child);
        let open = self.open.as_mut().expect("answers come to an open round");
        let asked = self.children[index].asked.as_mut().expect("only those answer that were asked");
        open.waiting -= 1;
        if let Some(news) = news {
            open.news.absorb(*news);
        }
        let last = asked.said.replace(Arc::clone(&answer));
        if last.as_ref().is_none_or(|last| !Arc::ptr_eq(last, &answer)) {
            open.is_different = true;
            let was = last.as_deref().and_then(|last| last.reason.as_ref());
            if was != answer.reason.as_ref() {
                open.news.reasons.push((child, answer.reason.clone()));
            }
            let wished = last.as_deref().and_then(|last| last.wish.as_ref());
            if wished != answer.wish.as_ref() {
                open.news.wishes.push((child, answer.wish.clone()));
            }
            self.take_in(last.as_deref(), Some(&answer));
        }
        self.go_on(index, out);
        self.answer_if_complete(out);
    }

    fn on_activation(&mut self, Activation { view, skips, scope }: Activation, out: &mut Outbox) {
        assert!(self.open.is_none(), "one round at a time");
        let is_other = self.meet_children(view.state.topology());
        let is_silent = self.silence(&view).is_some();
        if scope == Scope::Anew || is_silent || self.was_silent {
            self.forget();
        }
        self.open = Some(Open {
            view: Arc::clone(&view),
            skips: Arc::clone(&skips),
            scope,
            waiting: 0,
            // What repeats says something else in its last iteration, whatever those below say.
            is_different: is_other || self.said.is_none() || view.mission.tree.repeats.contains_key(&self.id),
            news: self.news_of_silence(view.state.topology()),
        });
        self.order.clear();
        if is_silent {
            self.ask_cleanups(&view, &skips, out);
        } else {
            match self.ordering {
                Ordering::And => self.ask_all(&view, &skips, out),
                Ordering::Or | Ordering::Then | Ordering::Cleanup => {
                    for child in self.ordering.first(&view.state, self.id) {
                        self.ask_in_order(self.index_of(child), &skips, out);
                    }
                }
            }
        }
        self.answer_if_complete(out);
    }

    /// Children come and go: those that are gone have taken back what they said.
    fn meet_children(&mut self, topology: &Topology) -> bool {
        if std::mem::replace(&mut self.version, topology.version()) == topology.version()
            || !topology.is_edited(self.id)
        {
            return false;
        }
        let mut known: BTreeMap<NodeId, Child> = self.children.drain(..).map(|child| (child.id, child)).collect();
        let children = topology.children(self.id).map(|id| known.remove(&id).unwrap_or(Child { id, asked: None }));
        self.children = children.collect();
        for gone in known.into_values() {
            self.take_in(gone.asked.and_then(|asked| asked.said).as_deref(), None);
        }
        true
    }

    /// What was said of those below that are not asked does not hold any more.
    fn news_of_silence(&mut self, topology: &Topology) -> News {
        let mut news = News::default();
        if std::mem::take(&mut self.was_silent) {
            news.withdrawn.extend(topology.runs([self.id]));
        }
        news
    }

    /// While nothing else below is asked, cleanups are.
    fn ask_cleanups(&mut self, view: &Arc<View>, skips: &Arc<Vec<NodeRange>>, out: &mut Outbox) {
        let topology = view.state.topology();
        let is_cleaning = |child: NodeId| topology.of_set(child, view.state.cleaning()).next().is_some();
        for index in 0..self.children.len() {
            if is_cleaning(self.children[index].id) {
                self.order.push(index);
                self.ask(index, skips, out);
            }
        }
    }

    /// Nothing that was said before counts.
    fn forget(&mut self) {
        self.children.iter_mut().for_each(|child| child.asked = None);
        self.offers.clear();
        (self.unsatisfied, self.said, self.was_complete) = (0, None, false);
    }

    /// An AND asks those that are not done, and of these again those that might say something else.
    fn ask_all(&mut self, view: &Arc<View>, skips: &Arc<Vec<NodeRange>>, out: &mut Outbox) {
        let is_partial = self.said.is_some() && self.open.as_ref().is_some_and(|open| open.scope == Scope::Changed);
        let touched = view.touched.as_deref().filter(|_| is_partial);
        let Some(touched) = touched else {
            (0..self.children.len()).for_each(|index| self.ask_or_leave(index, skips, out));
            return;
        };
        let topology = view.state.topology();
        if topology.is_edited(self.id) {
            // Whoever is touched, all above are too.
            let id = self.id;
            for child in touched.iter().filter(|node| node.0 > 0 && topology.parent(**node) == id) {
                self.ask_or_leave(self.index_of(*child), skips, out);
            }
            return;
        }
        let mut next = touched.partition_point(|node| *node <= self.id);
        // Whoever is touched, all above are too: the first one behind a child's subtree is a child.
        while let Some(&child) = touched.get(next).filter(|child| topology.is_within(**child, self.id)) {
            self.ask_or_leave(self.index_of(child), skips, out);
            next += touched[next..].partition_point(|node| topology.is_within(*node, child));
        }
    }

    fn ask_or_leave(&mut self, index: usize, skips: &Arc<Vec<NodeRange>>, out: &mut Outbox) {
        let open = self.open.as_ref().expect("children are asked in an open round");
        let (state, child) = (&open.view.state, self.children[index].id);
        let is_paused = self.is_stem && state.is_paused(child);
        if is_paused || matches!(state.phase(child), Phase::Done | Phase::Failed) {
            self.leave(index);
        } else {
            self.ask(index, skips, out);
        }
    }

    fn ask_in_order(&mut self, index: usize, skips: &Arc<Vec<NodeRange>>, out: &mut Outbox) {
        self.order.push(index);
        if !self.ask(index, skips, out) {
            self.go_on(index, out);
        }
    }

    /// Activates a child; false if it would say again what it said.
    fn ask(&mut self, index: usize, skips: &Arc<Vec<NodeRange>>, out: &mut Outbox) -> bool {
        let open = self.open.as_mut().expect("children are asked in an open round");
        let child = &self.children[index];
        // What was kept for the nodes skipped here may have changed, and is in the line of everything below.
        let is_behind_skip = skips.len() > open.skips.len();
        let scope = match &child.asked {
            Some(asked) if asked.skips != *skips => Scope::Anew,
            None => Scope::Anew,
            Some(_) if is_behind_skip || open.scope != Scope::Changed => Scope::All,
            Some(_) if open.view.is_fresh(child.id) => return false,
            Some(_) => Scope::Changed,
        };
        open.waiting += 1;
        let id = child.id;
        let (view, skips) = (Arc::clone(&open.view), Arc::clone(skips));
        if scope == Scope::Anew {
            self.leave(index);
            self.children[index].asked = Some(Asked { skips: Arc::clone(&skips), said: None });
        }
        out.push(Effect::Down(id, Down::Activation(Activation { view, skips, scope })));
        true
    }

    /// A child that was asked is asked no more.
    fn leave(&mut self, index: usize) {
        let child = &mut self.children[index];
        let Some(asked) = child.asked.take() else { return };
        let open = self.open.as_mut().expect("children are left in an open round");
        open.is_different = true;
        open.news.withdrawn.extend(open.view.state.topology().runs([child.id]));
        self.take_in(asked.said.as_deref(), None);
    }

    /// What an AND keeps of its children's answers.
    fn take_in(&mut self, before: Option<&Answer>, now: Option<&Answer>) {
        if self.ordering != Ordering::And {
            return;
        }
        let is_unsatisfied = |said: Option<&Answer>| usize::from(said.is_some_and(|said| !said.is_satisfied));
        self.unsatisfied = self.unsatisfied + is_unsatisfied(now) - is_unsatisfied(before);
        let requests = |said: Option<&Answer>| said.map(|said| said.requests.clone()).unwrap_or_default();
        let (old, new) = (requests(before), requests(now));
        if !old.is_same(&new) {
            old.iter().for_each(|request| self.offers.withdraw(request));
            new.iter().for_each(|request| self.offers.offer(request));
        }
    }

    /// A THEN goes on behind a child that is satisfied.
    fn go_on(&mut self, index: usize, out: &mut Outbox) {
        let open = self.open.as_ref().expect("children answer in an open round");
        let child = &self.children[index];
        let is_satisfied = self.answer_of(index).is_satisfied;
        let next = if is_satisfied { self.ordering.behind(&open.view.state, self.id, child.id) } else { None };
        if let Some(next) = next {
            let (first, next) = (self.order[0], self.index_of(next));
            let skipped = self.children[first..next].iter().map(|child| child.id);
            let skipped = open.view.state.topology().runs(skipped);
            let skips = Arc::new(open.skips.iter().copied().chain(skipped).collect());
            self.ask_in_order(next, &skips, out);
        }
    }

    fn answer_if_complete(&mut self, out: &mut Outbox) {
        if self.open.as_ref().is_none_or(|open| open.waiting > 0) {
            return;
        }
        if self.ordering != Ordering::And {
            self.leave_others();
        }
        let Open { view, is_different, mut news, .. } = self.open.take().expect("it is open");
        news.passed_on = news.reasons.len();
        let said = match (self.silence(&view), self.said.take()) {
            // What runs of a task that is paused says nothing.
            (None, Some(said)) if !is_different && said.is_running == view.state.is_busy(self.id) => said,
            (None, said) => {
                let answer = self.answer(&view, said.as_deref(), &mut news);
                said.filter(|said| **said == answer).unwrap_or_else(|| Arc::new(answer))
            }
            (Some(reason), _) => Arc::new(self.silent_answer(&view, &reason, &mut news)),
        };
        // What is said in silence is no answer to build on.
        self.was_silent = self.silence(&view).is_some();
        self.said = (!self.was_silent).then(|| Arc::clone(&said));
        let news = (!news.is_empty()).then(|| Box::new(news));
        out.push(Effect::Up(Up::Answer { from: self.id, round: view.round, answer: said, news }));
    }

    fn answer(&mut self, view: &View, said: Option<&Answer>, news: &mut News) -> Answer {
        let is_running = view.state.is_busy(self.id);
        let answers = self.order.iter().map(|&index| (self.children[index].id, self.answer_of(index)));
        let (is_satisfied, requests) = match self.ordering {
            Ordering::Or | Ordering::Then | Ordering::Cleanup => {
                let is_satisfied = self.ordering.is_satisfied(&view.state, self.id, answers.clone());
                (is_satisfied, self.ordering.pass_on(answers, news))
            }
            Ordering::And => {
                let requests = if self.offers.are_different() {
                    let refused = self.allocator.merge(view, &mut self.offers);
                    news.reasons.extend(refused.into_iter().map(|blocked| (blocked.leaf, Some(blocked.reason))));
                    self.offers.kept().iter().cloned().collect()
                } else {
                    said.map(|said| said.requests.clone()).unwrap_or_default()
                };
                (self.unsatisfied == 0 && !self.is_stem, requests)
            }
        };
        let is_complete = is_satisfied && view.state.phase(self.id) == Phase::Pending && !is_running;
        let tree = &view.mission.tree;
        let is_again = is_repeated(tree, &view.state, self.id);
        let is_task = self.id.0 > 0 && tree.is_standing() && tree.topology.parent(self.id) == tree.topology.stem();
        let is_news = (is_again || is_task || tree.topology.is_cleanup(self.id)) && is_complete;
        if std::mem::replace(&mut self.was_complete, is_news) != is_news {
            news.reasons.push((self.id, is_news.then_some(Reason::Satisfied)));
        }
        Answer { is_running, is_satisfied: is_complete && !is_again, requests, reason: None, wish: None }
    }

    /// An OR or a THEN has asked others than in the last round.
    fn leave_others(&mut self) {
        for index in 0..self.children.len() {
            if self.children[index].asked.is_some() && self.order.binary_search(&index).is_err() {
                self.leave(index);
            }
        }
    }

    fn answer_of(&self, index: usize) -> &Answer {
        let said = self.children[index].asked.as_ref().and_then(|asked| asked.said.as_deref());
        said.expect("who is asked answers before it counts")
    }

    fn index_of(&self, child: NodeId) -> usize {
        let found = self.children.binary_search_by_key(&child, |child| child.id).ok();
        // Those that were added later may stand before others.
        let found = found.or_else(|| self.children.iter().position(|known| known.id == child));
        found.expect("children speak to their parent")
    }

    /// Why nothing below is asked but cleanups: it waits for what runs there to end, after a failure, or for its next
    /// time; or one above is given up.
    fn silence(&self, view: &View) -> Option<Reason> {
        let status = view.state.status(self.id);
        match status.phase {
            Phase::Failing(Failing { finishes: true, .. }) | Phase::Pending | Phase::Done | Phase::Failed => {
                let pause = view.state.pauses().get(&self.id).map(|pause| pause.reason(self.id));
                let given_up = || {
                    let is_cleaning = !view.state.cleaning().is_empty();
                    (is_cleaning && view.state.is_over(self.id)).then_some(Reason::GivenUp { node: self.id })
                };
                status.wait.as_deref().map(Wait::reason).or(pause).or_else(given_up)
            }
            Phase::Ending => Some(Reason::GivenUp { node: self.id }),
            // Its cleanup alone is asked.
            Phase::Cleaning(_) => None,
            Phase::Failing(Failing { child, .. }) if child == self.id => Some(Reason::OutOfTime { node: child }),
            Phase::Failing(Failing { child, .. }) => Some(Reason::Ending { failed: child }),
        }
    }

    /// A node below which nothing is asked but cleanups asks for nothing else.
    fn silent_answer(&mut self, view: &View, reason: &Reason, news: &mut News) -> Answer {
        let tree = &view.mission.tree;
        let asked =
            |leaf: &NodeId| self.order.iter().any(|&index| tree.topology.is_within(*leaf, self.children[index].id));
        let leaves = tree.leaves_below(self.id).into_iter();
        let idle = leaves.filter(|leaf| !view.state.running().contains_key(leaf));
        let reasons = idle.filter(|leaf| !asked(leaf)).map(|leaf| (leaf, Some(reason.clone()))).collect::<Vec<_>>();
        // What was said before does not hold; what cleanups say comes behind that.
        news.withdrawn.splice(..0, tree.topology.runs([self.id]));
        news.reasons.extend(reasons);
        let requests = self.order.iter().flat_map(|&index| self.answer_of(index).requests.iter().cloned()).collect();
        Answer { is_running: view.state.is_busy(self.id), requests, ..Answer::default() }
    }

    /// Goes to where something starts or is to end.
    fn on_verdict(&mut self, verdict: &Arc<Verdict>, out: &mut Outbox) {
        let topology = &verdict.topology;
        let is_edited = topology.is_edited(self.id);
        let child_above = |leaf: NodeId| match is_edited {
            true => topology.path(leaf).find(|node| topology.parent(*node) == self.id),
            false => {
                self.children[..self.children.partition_point(|child| child.id <= leaf)].last().map(|child| child.id)
            }
        };
        let told: BTreeSet<NodeId> = verdict.about(self.id).filter_map(child_above).collect();
        for child in told {
            out.push(Effect::Down(child, Down::Verdict(Arc::clone(verdict))));
        }
    }
}
