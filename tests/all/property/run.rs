//! Runs of one case: in virtual time, one event after the other, or all at once.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;

use ambidex::model::{
    Change, Consequences, ControllerId, End, Fault, Grant, Loss, MissionEnd, NodeId, Outcome, Reason, Record, Time,
    Told, WorldState,
};
use ambidex::replay::Replay;
use ambidex::tree::{Input, Settings, Topic};
use ambidex::world::{Compatible, Unconstrained, Use};

use super::counts::{Counts, variant};
use super::generator::Case;
use super::reference::{Decision, Held, Model};
use crate::driver::{Driver, Lockstep, Outside, Rng};
use crate::support::short;

/// More rounds than this in one tree are a livelock; the most seen in 100,000 trees are 109.
const MOST_ROUNDS: usize = 600;

const ROOT: NodeId = NodeId(0);

/// Pairs of behaviors that are in each other's way.
#[derive(Debug)]
struct Apart(Vec<(NodeId, NodeId)>);

impl Compatible for Apart {
    fn check(&self, _: &WorldState, uses: &[Use]) -> Result<(), Reason> {
        let Some(last) = uses.last().map(|last| last.leaf) else {
            return Ok(());
        };
        let clash = uses
            .iter()
            .map(|used| used.leaf)
            .find(|&other| self.0.contains(&(other, last)) || self.0.contains(&(last, other)));
        clash.map_or(Ok(()), |with| Err(Reason::Clash { with }))
    }
}

fn settings(case: &Case) -> Settings {
    let rules: Arc<dyn Compatible> = match case.clashing.as_slice() {
        [] => Arc::new(Unconstrained),
        clashing => Arc::new(Apart(clashing.to_vec())),
    };
    Settings { allocator: case.allocator(), rules, ..Settings::default() }
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

#[derive(Debug, Clone)]
enum Event {
    Ended(NodeId, Outcome),
    World(Change),
    /// A controller goes, or comes back.
    Service(ControllerId, Option<Loss>),
    /// Root has waited for this moment.
    Woke,
}

/// Events in order of time, then of leaves, then changes of the world.
#[derive(Default)]
struct Agenda {
    events: BTreeMap<(Time, u32), Event>,
    when: BTreeMap<NodeId, (Time, u32)>,
    attempts: BTreeMap<NodeId, u64>,
}

impl Agenda {
    fn new(case: &Case) -> Self {
        let changes = case.plan.changes.iter().enumerate();
        let events = changes.map(|(index, &(at, change))| ((at, 10_000 + index as u32), Event::World(change)));
        let services = case.plan.services.iter().enumerate();
        let services = services.map(|(index, &(at, id, loss))| ((at, 20_000 + index as u32), Event::Service(id, loss)));
        Self { events: events.chain(services).collect(), ..Self::default() }
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
        Event::World(change) => driver.give(ROOT, Told::World { change: *change }.into()),
        Event::Service(controller, outage) => {
            let told = Told::Service { controller: *controller, outage: *outage, changes: Vec::new() };
            driver.give(ROOT, told.into());
        }
        Event::Woke => driver.give(ROOT, Told::Woke.into()),
    }
}

fn begin(driver: &mut Driver) {
    driver.give(ROOT, Told::Begin { changes: Vec::new() }.into());
}

fn rounds(driver: &Driver) -> usize {
    let decided = |record: &&Record| matches!(record, Record::Decided { .. });
    driver.records.iter().filter(decided).count()
}

fn counts(driver: &Driver) -> Counts {
    Counts::of(&driver.records, driver.finished)
}

/// One event at a time, each after what came of the one before; `after` sees every event and what it recorded.
fn in_order(case: &Case, interleaving: u64, mut after: impl FnMut(&Driver, Option<&Event>, &[Record])) -> Driver {
    let mut driver = driver(case, interleaving);
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
        driver.rest();
        agenda.take_up(case, &mut driver);
        agenda.lose(case, &driver, &event);
        after(&driver, Some(&event), &driver.records[seen..]);
        assert!(rounds(&driver) <= MOST_ROUNDS, "a livelock");
    }
    assert!(driver.goals.is_empty(), "still runs: {:?}", driver.goals);
    driver
}

/// The records of a run.
pub fn records(case: &Case, interleaving: u64) -> (Vec<Record>, Counts) {
    let driver = in_order(case, interleaving, |_, _, _| ());
    let counts = counts(&driver);
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
    let mut driver = driver(case, 9);
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
        assert!(rounds(&driver) <= MOST_ROUNDS, "a livelock");
    }
    driver.rest();
    assert!(driver.goals.is_empty(), "still runs: {:?}", driver.goals);
    replay(case, &driver.records);
    if is_canceled {
        // What came before the cancel may have ended it.
        let end = driver.finished;
        let ends = matches!(end, Some(MissionEnd::Canceled | MissionEnd::Done | MissionEnd::Failed(_)));
        assert!(ends, "{end:?}");
    }
    counts(&driver)
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
    (driver.difference().map(str::to_owned), counts(&driver))
}

/// The core and the reference model on the same events.
pub fn against_reference(case: &Case) -> Counts {
    let mut model = Model::new(&case.mission, case.is_serial, &case.clashing);
    let driver = in_order(case, 0, |driver, event, records| {
        model.now = driver.now;
        let (consequences, mut goes_on) = match event {
            Some(Event::Woke) => (None, model.woke()),
            Some(Event::Service(controller, outage)) => (None, model.service(*controller, *outage)),
            None => (None, true),
            Some(Event::World(change)) => (None, model.world(*change)),
            Some(Event::Ended(leaf, outcome)) => {
                let end = model.judged(*leaf, outcome);
                (Some((*leaf, end, model.ended(*leaf, outcome))), true)
            }
        };
        let mut decisions = Vec::new();
        while goes_on && model.end.is_none() {
            let (decision, again) = model.round();
            decisions.push(decision);
            goes_on = again;
        }
        compare(case, driver, event, records, &model, consequences, &decisions);
    });
    let mut counts = counts(&driver);
    counts.rechoices = u64::from(model.rechoices);
    counts
}

fn compare(
    case: &Case,
    driver: &Driver,
    event: Option<&Event>,
    records: &[Record],
    model: &Model<'_>,
    consequences: Option<(NodeId, End, Consequences)>,
    decisions: &[Decision],
) {
    let said = records.iter().filter_map(|record| match record {
        Record::Released { leaf, end, consequences, .. } => {
            Some((*leaf, *end, Consequences { failing: None, ..*consequences }))
                .map(|(leaf, end, consequences)| format!("{leaf:?} {end:?} {consequences:?}"))
        }
        Record::Decided { granted, refused, reopened, .. } => Some(decided(
            case,
            granted.iter(),
            refused.iter().map(|blocked| (blocked.leaf, &blocked.reason)),
            reopened.as_ref(),
        )),
        Record::Ended { end, .. } => Some(format!("{end:?}")),
        Record::Told { .. } | Record::Observed { .. } | Record::Turn { .. } | Record::Began { .. } => None,
        Record::Header(_) | Record::Stopped { .. } | Record::Sent { .. } | Record::World { .. } => None,
        Record::Resource { .. }
        | Record::Woke { .. }
        | Record::Served { .. }
        | Record::Awaited { .. }
        | Record::Controller { .. } => None,
    });
    let said: Vec<String> = said.collect();
    let mut expected: Vec<String> = consequences
        .map(|(leaf, end, consequences)| format!("{leaf:?} {end:?} {consequences:?}"))
        .into_iter()
        .collect();
    expected.extend(decisions.iter().map(|decision| {
        let refused = decision.refused.iter().map(|(&leaf, refusal)| (leaf, &refusal.reason));
        decided(case, decision.granted.values(), refused, decision.reopened.as_ref())
    }));
    expected.extend(model.end.map(|end| format!("{end:?}")));
    let show =
        || format!("after {event:?}\nlast records {:?}", &driver.records[driver.records.len().saturating_sub(4)..]);
    assert!(
        said == expected,
        "{}\ncore\n{}\nreference\n{}",
        show(),
        short(&said.join("\n")),
        short(&expected.join("\n"))
    );
    compare_state(driver, model, &show());
}

/// Leases, world, and what runs.
fn compare_state(driver: &Driver, model: &Model<'_>, seen: &str) {
    for (id, resource) in driver.root().state().table().iter() {
        let leases = resource.leases().iter().map(|lease| Held {
            holder: lease.holder,
            behavior: lease.behavior,
            kind: lease.kind,
            from: lease.from,
        });
        let (row, core) = (&model.rows[id.index()], (resource.access(), leases.collect()));
        assert!((row.access, row.leases.clone()) == core, "{}\n{id:?}: core {core:?}, reference {row:?}", seen);
    }
    assert!(*driver.root().state().world() == model.world_state, "{}\nreference {:?}", seen, model.world_state);
    assert!(driver.root().state().running().keys().eq(model.running.keys()), "{seen}");
}

/// The kind of a reason.
fn kind(reason: &Reason) -> String {
    lost(reason).unwrap_or_else(|| variant(reason))
}

/// The model names whoever was preferred below root; whether that one won in the end, the driver's watch asks.
fn lost(reason: &Reason) -> Option<String> {
    let is_lost = matches!(reason, Reason::Outbid { .. } | Reason::WholeRobot { .. } | Reason::Outdone { .. });
    is_lost.then(|| "lost to another".to_owned())
}

/// A decision as one line; where several reasons are as true, only the kind of reason counts.
fn decided<'a>(
    case: &Case,
    granted: impl Iterator<Item = &'a Grant>,
    refused: impl Iterator<Item = (NodeId, &'a Reason)>,
    reopened: Option<&ambidex::model::Reopened>,
) -> String {
    let name = |leaf: NodeId| case.mission.names.node(leaf).to_owned();
    let granted: Vec<_> = granted
        .map(|Grant { request, bindings, .. }| {
            let (changes, skips) = (&request.changes, &request.skips);
            format!("{} {} {bindings:?} {changes:?} {skips:?}", name(request.leaf), request.potential)
        })
        .collect();
    let refused = refused.map(|(leaf, reason)| {
        let is_one_of_several = matches!(reason, Reason::Clash { .. } | Reason::AlreadyDone { .. });
        let told = if is_one_of_several { kind(reason) } else { lost(reason).unwrap_or_else(|| format!("{reason:?}")) };
        format!("{} {told}", name(leaf))
    });
    let refused: Vec<_> = refused.collect();
    let reopened = reopened.map(|reopened| {
        let lacks = reopened.lacks().map(|lacks| (lacks.leaf, kind(&lacks.reason)));
        format!("{:?} {:?} {:?} lacks {lacks:?}", reopened.up_to, reopened.node, reopened.lapsed())
    });
    format!("granted {granted:?} refused {refused:?} reopened {reopened:?}")
}
