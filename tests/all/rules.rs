//! The rules as tables: small trees, what happens, and what must come of it.
//!
//! A row is a tree, its events, and the steps: what is granted, by name, in order of the rounds that grant anything.

mod choosing;
mod ending;
mod failing;
mod leases;
mod reasons;
mod words;

use ambidex::model::{
    BehaviorSpec, Cause, Change, ControllerId, End, Fault, MissionEnd, MissionSpec, NodeId, Origin, Outcome, Reason,
    Record, Rejection, Retention, Time, Told,
};
use ambidex::tree::{Input, Settings};

use crate::driver::{Driver, Rng};
use crate::support::{Body, GRIPPER, Tree};

/// What happens next.
#[derive(Debug, Clone, Copy)]
pub enum Event {
    /// The behavior succeeds.
    Ok(&'static str),
    /// It fails.
    Fails(&'static str),
    /// It fails, and its controller says where the base or what the gripper holds.
    FailsWith(&'static str, Change),
    /// It succeeds, and its controller says where the base is or what the gripper holds.
    OkWith(&'static str, Change),
    /// Its controllers will not take it: it is out of reach.
    Rejects(&'static str),
    /// It ends since it was told to.
    Ends(&'static str),
    /// So many seconds pass.
    Wait(u64),
    /// The world changes from outside.
    World(Change),
}

/// A run that is over or waits for the next event.
pub struct Run {
    driver: Driver,
    mission: MissionSpec,
}

impl Run {
    pub fn new(mission: MissionSpec, settings: Settings, events: &[Event]) -> Self {
        let driver = Driver::new(&std::sync::Arc::new(mission.clone()), &settings, Rng::of(&[1]));
        let mut run = Self { driver, mission };
        run.give(NodeId(0), Told::Begin { changes: Vec::new() }.into());
        for event in events {
            run.driver.now = Time(run.driver.now.0 + 1_000_000);
            let outcome = |end, changes| Input::Ended(Box::new(Outcome { end, changes }));
            match *event {
                Event::Ok(name) => run.give(run.node(name), outcome(End::Succeeded, Vec::new())),
                Event::Fails(name) => {
                    let failed = End::Failed(Fault::TimedOut);
                    run.give(run.node(name), outcome(failed, Vec::new()));
                }
                Event::FailsWith(name, change) => {
                    let failed = End::Failed(Fault::TimedOut);
                    run.give(run.node(name), outcome(failed, vec![change]));
                }
                Event::OkWith(name, change) => run.give(run.node(name), outcome(End::Succeeded, vec![change])),
                Event::Rejects(name) => {
                    let node = run.node(name);
                    let failed = End::Failed(Fault::Rejected(run.mover(node), Rejection::OutOfReach));
                    run.give(node, outcome(failed, Vec::new()));
                }
                Event::Ends(name) => run.give(run.node(name), outcome(End::Canceled, Vec::new())),
                Event::Wait(seconds) => {
                    run.driver.now = Time(run.driver.now.0 + seconds * 1_000_000);
                    if run.driver.root().deadline().is_some_and(|due| due <= run.driver.now) {
                        run.give(NodeId(0), Told::Woke.into());
                    }
                }
                Event::World(change) => run.give(NodeId(0), Told::World { change, origin: Origin::Script }.into()),
            }
        }
        run
    }

    fn give(&mut self, node: NodeId, input: Input) {
        self.driver.give(node, input);
        self.driver.rest();
        // Who waits after a failure asks again before anything else happens.
        while !self.driver.root().state().waits().is_empty() {
            self.driver.now = self.driver.root().deadline().map_or(self.driver.now, |due| due.max(self.driver.now));
            self.driver.give(NodeId(0), Told::Woke.into());
            self.driver.rest();
        }
    }

    /// Who moves the gripper of a running behavior.
    fn mover(&self, leaf: NodeId) -> ControllerId {
        let grant = &self.driver.root().state().running()[&leaf];
        let mut bindings = grant.bindings.iter();
        let mover = bindings.find_map(|binding| {
            let spec = self.mission.robot.resources[binding.resource.index()];
            spec.controller.filter(|_| spec.ty == GRIPPER)
        });
        mover.expect("a gripper is moved by somebody")
    }

    fn node(&self, name: &str) -> NodeId {
        let names = &self.mission.names.nodes;
        let index = names.iter().position(|other| other == name);
        NodeId::from(index.unwrap_or_else(|| panic!("no {name} in {names:?}")))
    }

    /// What was granted, one list a round, with `skip`ped nodes and `back` for what was reopened.
    pub fn steps(&self) -> String {
        let name = |node: NodeId| self.mission.names.node(node);
        let mut steps: Vec<String> = Vec::new();
        for record in &self.driver.records {
            steps.extend(self.turn(record));
            let Record::Decided { granted, reopened, .. } = record else {
                continue;
            };
            if !granted.is_empty() {
                let names: Vec<_> = granted.iter().map(|grant| name(grant.leaf())).collect();
                steps.push(names.join(" + "));
            }
            if let Some(reopened) = reopened {
                let how = if reopened.lapsed().is_some() { "lapses" } else { "back" };
                steps.push(format!("{how} {}", name(reopened.node)));
            }
        }
        match self.driver.finished {
            Some(MissionEnd::Done) => steps.push("done".into()),
            Some(MissionEnd::Failed(leaf)) => steps.push(format!("failed at {}", name(leaf))),
            Some(end) => steps.push(format!("{end:?}").to_lowercase()),
            None if self.driver.root().state().running().is_empty() => steps.push("waits".into()),
            None => {}
        }
        steps.join(", ")
    }

    /// What happened beside the rounds.
    fn turn(&self, record: &Record) -> Option<String> {
        let name = |node: NodeId| self.mission.names.node(node);
        match record {
            Record::Infeasible { leaf, .. } => Some(format!("never {}", name(*leaf))),
            Record::TimedOut { node, .. } => Some(format!("late {}", name(*node))),
            Record::Overtaken { goal, .. } => Some(format!("others {}", name(*goal))),
            Record::Reopened { reopened, .. } => {
                let how = if reopened.cause == Cause::Leave { "leaves" } else { "again" };
                Some(format!("{how} {}", name(reopened.node)))
            }
            _ => None,
        }
    }

    /// The last reason of a leaf.
    pub fn reason(&self, name: &str) -> Option<Reason> {
        let leaf = self.node(name);
        self.driver.records.iter().rev().find_map(|record| match record {
            Record::Infeasible { leaf: never, reason, .. } if *never == leaf => Some(reason.clone()),
            _ => record.refusals().iter().rfind(|blocked| blocked.leaf == leaf).map(|blocked| blocked.reason.clone()),
        })
    }

    /// Rounds of which it is recorded why something does not run.
    pub fn told_rounds(&self) -> Vec<u32> {
        let told = self.driver.records.iter().filter_map(|record| {
            let Record::Decided { round, refused, .. } = record else { return None };
            (!refused.is_empty()).then_some(*round)
        });
        told.collect()
    }

    /// Where things are.
    pub fn world_state(&self) -> &ambidex::model::WorldState {
        self.driver.root().state().world()
    }

    /// Who holds what: `resource: holder` in resource order.
    pub fn table(&self) -> String {
        let table = self.driver.root().state().table();
        let leases = table.leases().map(|(id, lease)| {
            let (resource, holder) = (self.mission.names.resource(id), lease.holder);
            format!("{resource}: {}", self.mission.names.node(holder))
        });
        leases.collect::<Vec<_>>().join(", ")
    }
}

pub fn and<const N: usize>(children: [Tree; N]) -> Tree {
    Tree::And(children.into())
}

pub fn or<const N: usize>(children: [Tree; N]) -> Tree {
    Tree::Or(children.into())
}

pub fn then<const N: usize>(children: [Tree; N]) -> Tree {
    Tree::Then(children.into())
}

pub fn leaf(name: &str, spec: BehaviorSpec) -> Tree {
    Tree::Leaf(name.into(), Box::new(spec))
}

/// A robot of so many grippers and tools, with a head and a base.
pub fn robot(grippers: usize, tools: usize) -> Body {
    Body { grippers, heads: 1, bases: 1, tools, reach_m: 1.2 }
}

/// The keep of most claims.
pub const FREE: Retention = Retention::Release;
