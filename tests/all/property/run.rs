//! Runs of one case: in virtual time, one event after the other, or all at once.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;

use ambidex::model::{
    Change, Clash, ControllerId, End, Fault, Loss, MissionEnd, NodeId, Origin, Outcome, Reason, Record, Time, Told,
};
use ambidex::replay::Replay;
use ambidex::tree::{Input, Settings, Topic};
use ambidex::world::{Compatible, Unconstrained, Use, View};

use super::counts::Counts;
use super::generator::Case;
use super::livelock::Livelock;
use crate::driver::{Driver, Lockstep, Outside, Rng};

const ROOT: NodeId = NodeId(0);

/// Pairs of behaviors that are in each other's way.
#[derive(Debug)]
struct Apart(Vec<(NodeId, NodeId)>);

impl Compatible for Apart {
    fn check(&self, _: &View, uses: &[Use<'_>]) -> Result<(), Reason> {
        let Some(last) = uses.last().map(|last| last.request.leaf) else {
            return Ok(());
        };
        let clash = uses
            .iter()
            .map(|used| used.request.leaf)
            .find(|&other| self.0.contains(&(other, last)) || self.0.contains(&(last, other)));
        clash.map_or(Ok(()), |with| Err(Reason::Clash { with, over: Clash::Rule }))
    }
}

fn settings(case: &Case) -> Settings {
    let rules: Arc<dyn Compatible> = match case.clashing.as_slice() {
        [] => Arc::new(Unconstrained),
        clashing => Arc::new(Apart(clashing.to_vec())),
    };
    let prevents_deadlock = case.prevents_deadlock;
    Settings { allocator: case.allocator(), rules, prevents_deadlock, ..Settings::default() }
}

fn driver(case: &Case, interleaving: u64) -> Driver {
    Driver::new(&case.mission, &settings(case), Rng::of(&[case.seed, 7, interleaving]))
}

/// What root was told, told once more in another order of messages, leads to the same decisions.
fn replay(case: &Case, records: &[Record]) {
    let mut replay = Replay::new(&case.mission, &settings(case));
    for record in records {
        replay.take(record).unwrap_or_else(|difference| panic!("{difference:#?}"));
    }
    assert_eq!(replay.finish().missing, [], "the log lacks what follows");
}

/// What comes from outside the tree.
#[derive(Debug, Clone)]
pub enum Event {
    Ended(NodeId, Outcome),
    World(Change, Origin),
    /// A controller goes, or comes back.
    Service(ControllerId, Option<Loss>),
    /// The mission is to end.
    Cancel,
    /// Root has waited for this moment.
    Woke,
    /// Nothing else can come any more, and the mission waits for the world.
    Nothing,
}

/// Events in order of time, then of leaves, then changes of the world.
#[derive(Default)]
struct Agenda {
    events: BTreeMap<(Time, u32), Event>,
    when: BTreeMap<NodeId, (Time, u32)>,
    attempts: BTreeMap<NodeId, u64>,
    /// Whether it was said that nothing else comes.
    is_over: bool,
}

impl Agenda {
    fn new(case: &Case) -> Self {
        let changes = case.plan.changes.iter().enumerate();
        let events =
            changes.map(|(index, &(at, change, origin))| ((at, 10_000 + index as u32), Event::World(change, origin)));
        let services = case.plan.services.iter().enumerate();
        let services = services.map(|(index, &(at, id, loss))| ((at, 20_000 + index as u32), Event::Service(id, loss)));
        let cancel = case.plan.cancel.map(|at| ((at, 30_000), Event::Cancel));
        Self { events: events.chain(services).chain(cancel).collect(), ..Self::default() }
    }

    /// What ran with a controller that is gone ends at once.
    fn lose(&mut self, case: &Case, driver: &Driver, event: &Event) {
        let Event::Service(controller, Some(_)) = *event else { return };
        let moved: Vec<_> = case.mission.robot.moved_by(controller).collect();
        for (&leaf, grant) in driver.root().state().running() {
            let claimed = &grant.bindings[..grant.request.claims.len()];
            let is_hit = claimed.iter().any(|binding| moved.contains(&binding.resource));
            if !is_hit || !driver.goals.contains_key(&leaf) {
                continue;
            }
            if let Some(when) = self.when.remove(&leaf) {
                self.events.remove(&when);
            }
            let outcome = Outcome { end: End::Failed(Fault::Lost(controller)), changes: Vec::new() };
            self.when.insert(leaf, (driver.now, leaf.0));
            self.events.insert((driver.now, leaf.0), Event::Ended(leaf, outcome));
        }
    }

    /// Takes up what the driver was told to start and to stop.
    fn take_up(&mut self, case: &Case, driver: &mut Driver) {
        for told in std::mem::take(&mut driver.outside) {
            let (Outside::Start(leaf) | Outside::Stop(leaf)) = told;
            if let Some(when) = self.when.remove(&leaf) {
                self.events.remove(&when);
            }
            // What ended in the meantime is gone already.
            let Some(grant) = driver.root().state().running().get(&leaf).filter(|_| driver.goals.contains_key(&leaf))
            else {
                continue;
            };
            let (lasts, outcome) = match told {
                Outside::Start(_) => {
                    let attempt = self.attempts.entry(leaf).or_default();
                    *attempt += 1;
                    case.plan.attempt(&case.mission, grant, *attempt)
                }
                Outside::Stop(_) => (Duration::from_millis(20), case.plan.stopped(&case.mission, grant)),
            };
            let when = (driver.now + lasts, leaf.0);
            self.when.insert(leaf, when);
            self.events.insert(when, Event::Ended(leaf, outcome));
        }
    }

    fn next(&mut self, driver: &Driver) -> Option<(Time, Event)> {
        let is_over = self.events.is_empty() && driver.goals.is_empty() && driver.root().deadline().is_none();
        let is_waiting = is_over && driver.is_at_rest();
        if is_waiting && !std::mem::replace(&mut self.is_over, true) {
            return Some((driver.now, Event::Nothing));
        }
        let first = self.events.first_key_value().map(|((at, _), _)| *at);
        if let Some(due) = driver.root().deadline().filter(|due| first.is_none_or(|at| *due <= at)) {
            return Some((due.max(driver.now), Event::Woke));
        }
        let ((at, _), event) = self.events.pop_first()?;
        if let Event::Ended(leaf, _) = event {
            self.when.remove(&leaf);
        }
        Some((at, event))
    }
}

fn give(driver: &mut Driver, event: &Event) {
    match event {
        Event::Ended(leaf, outcome) => driver.give(*leaf, Input::Ended(Box::new(outcome.clone()))),
        Event::World(change, origin) => {
            driver.give(ROOT, Told::World { change: *change, origin: *origin }.into());
        }
        Event::Service(controller, outage) => {
            let told = Told::Service { controller: *controller, outage: *outage, changes: Vec::new() };
            driver.give(ROOT, told.into());
        }
        Event::Cancel => driver.give(ROOT, Told::End { end: MissionEnd::Canceled }.into()),
        Event::Woke => driver.give(ROOT, Told::Woke.into()),
        Event::Nothing => driver.give(ROOT, Told::End { end: MissionEnd::Stalled }.into()),
    }
}

fn begin(driver: &mut Driver) {
    driver.give(ROOT, Told::Begin { changes: Vec::new() }.into());
}

pub fn counts(case: &Case, driver: &Driver) -> Counts {
    Counts::of(&case.mission, &driver.records, driver.finished)
}

/// One event at a time, each after what came of the one before; `after` sees every event and what it recorded.
pub fn in_order(case: &Case, interleaving: u64, mut after: impl FnMut(&Driver, Option<&Event>, &[Record])) -> Driver {
    let (mut driver, mut livelock) = (driver(case, interleaving), Livelock::new(case));
    let mut agenda = Agenda::new(case);
    begin(&mut driver);
    driver.rest();
    after(&driver, None, &driver.records);
    while driver.finished.is_none() {
        agenda.take_up(case, &mut driver);
        let (at, event) = agenda.next(&driver).expect("what runs ends");
        let seen = driver.records.len();
        driver.now = at;
        give(&mut driver, &event);
        driver.rest_watched(|records| livelock.check(records));
        agenda.take_up(case, &mut driver);
        agenda.lose(case, &driver, &event);
        after(&driver, Some(&event), &driver.records[seen..]);
        livelock.check(&driver.records);
    }
    assert!(driver.goals.is_empty(), "still runs: {:?}", driver.goals);
    driver
}

/// The records of a run.
pub fn records(case: &Case, interleaving: u64) -> (Vec<Record>, Counts) {
    let driver = in_order(case, interleaving, |_, _, _| ());
    let counts = counts(case, &driver);
    (driver.records, counts)
}

/// The same as they would stand in a journal.
pub fn lines(case: &Case, interleaving: u64) -> (String, Counts) {
    let (records, counts) = records(case, interleaving);
    let lines = records.iter().map(|record| serde_json::to_string(record).expect("records are plain"));
    (lines.collect::<Vec<_>>().join("\n"), counts)
}

pub fn chaos(case: &Case) -> Counts {
    all_at_once(case, usize::MAX, |_| ())
}

pub fn canceled(case: &Case) -> Counts {
    all_at_once(case, case.plan.cancel_after(), |_| ())
}

/// Messages, ends, changes of the world and a cancel in any order; `watch` sees what came of each.
pub fn all_at_once(case: &Case, cancel_after: usize, mut watch: impl FnMut(&Driver)) -> Counts {
    let mut rng = Rng::of(&[case.seed, 8]);
    let (mut driver, mut livelock) = (driver(case, 9), Livelock::new(case));
    let mut agenda = Agenda::new(case);
    let (mut steps, mut is_canceled) = (0, false);
    begin(&mut driver);
    while driver.finished.is_none() {
        steps += 1;
        agenda.take_up(case, &mut driver);
        if steps > cancel_after && !std::mem::replace(&mut is_canceled, true) {
            driver.give(ROOT, Told::End { end: MissionEnd::Canceled }.into());
        } else if rng.is(85) && driver.step() {
        } else if driver.is_turn_due() && rng.is(50) {
            driver.turn();
        } else if let Some((at, event)) = agenda.next(&driver) {
            driver.now = driver.now.max(at);
            give(&mut driver, &event);
            agenda.lose(case, &driver, &event);
        } else {
            let goes_on = driver.step() || driver.is_turn_due();
            assert!(goes_on, "nothing is left to happen, and the mission goes on");
            if driver.is_turn_due() {
                driver.turn();
            }
        }
        watch(&driver);
        livelock.check(&driver.records);
    }
    driver.rest();
    assert!(driver.goals.is_empty(), "still runs: {:?}", driver.goals);
    replay(case, &driver.records);
    if is_canceled {
        // What came before the cancel may have ended it.
        let end = driver.finished;
        let ends = matches!(end, Some(MissionEnd::Canceled | MissionEnd::Done | MissionEnd::Failed(_)));
        assert!(ends || agenda.is_over, "{end:?}");
    }
    counts(case, &driver)
}

/// Every answer of every round against plain recursion; gives the first difference, with which the run ends. `unheard`
/// are topics that the core is deaf to.
pub fn in_lockstep(case: &Case, unheard: fn(Topic) -> bool) -> (Option<String>, Counts) {
    let lockstep = Lockstep::new(&case.mission, &settings(case));
    let deaf = Settings { unheard, ..settings(case) };
    let mut driver = Driver::new(&case.mission, &deaf, Rng::of(&[case.seed, 7, 0])).in_lockstep(lockstep);
    let mut agenda = Agenda::new(case);
    begin(&mut driver);
    while driver.finished.is_none() && driver.difference().is_none() {
        if driver.step() {
        } else if driver.is_turn_due() {
            driver.turn();
        } else {
            agenda.take_up(case, &mut driver);
            let (at, event) = agenda.next(&driver).expect("what runs ends");
            driver.now = at;
            give(&mut driver, &event);
            agenda.lose(case, &driver, &event);
        }
    }
    (driver.difference().map(str::to_owned), counts(case, &driver))
}
