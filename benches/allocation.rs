//! Algorithm 1 in root against the number of requests: those of a robot with eight grippers, a base and a head. Behind it
//! whole missions with and without the certificate against deadlock.

#[path = "support/mission.rs"]
mod mission;
#[path = "support/table.rs"]
mod table;

use std::collections::{BTreeSet, VecDeque};
use std::hint::black_box;
use std::sync::Arc;
use std::time::{Duration, Instant};

use ambidex::model::state::State;
use ambidex::model::{
    Access, Candidate, ChannelId, Claim, ClaimOptions, Condition, EffectTerm, End, Location, MissionEnd, MissionSpec,
    NodeId, NodeKind, ObjectId, Outcome, PlaceId, Potential, Record, Request, ResourceId, ResourceSpec, Retention,
    Selector, Time, Told, TypeId,
};
use ambidex::tree::{Allocator, Effect, Greedy, Input, Node, Outbox, Settings, build};
use ambidex::world::{FreeSpace, Unconstrained, View, Ways};

const SIZES: [usize; 4] = [100, 1_000, 10_000, 100_000];
const SAMPLES: usize = 10;
const GRIPPERS: u32 = 8;
const BASE: ResourceId = ResourceId(GRIPPERS);
const HEAD: ResourceId = ResourceId(GRIPPERS + 1);

fn main() {
    let titles = "requests|granted|Algorithm 1, ms|exponent|sorted alone, ms|Algorithm 1/sorted|serial, ms";
    let mut rows = vec![titles.split('|').map(str::to_owned).collect::<Vec<_>>()];
    let mut above: Option<(usize, f64)> = None;
    for n in SIZES {
        let (view, requests) = (view(), requests(n));
        let (time, granted) = fastest(|| {
            let chosen = Greedy.choose(&view, &requests, &[]);
            assert_eq!(chosen.granted.len() + chosen.refused.len(), n, "each has its answer");
            chosen.granted.len()
        });
        let (sorted, _) = fastest(|| {
            let mut requests = requests.clone();
            requests.sort_by(|a, b| b.potential.total_cmp(&a.potential));
            black_box(&requests).len()
        });
        let (serial, one) = fastest(|| ambidex::tree::Serial.choose(&view, &requests, &[]).granted.len());
        assert_eq!(one, 1, "one behavior at a time");
        let ms = |time: Duration| time.as_secs_f64() * 1e3;
        let exponent = above.map(|(m, less)| (ms(time) / less).ln() / (n as f64 / m as f64).ln());
        above = Some((n, ms(time)));
        rows.push(vec![
            n.to_string(),
            granted.to_string(),
            format!("{:.3}", ms(time)),
            exponent.map_or("-".into(), |exponent| format!("{exponent:.2}")),
            format!("{:.3}", ms(sorted)),
            format!("{:.1}", ms(time) / ms(sorted)),
            format!("{:.3}", ms(serial)),
        ]);
    }
    table::print("Requests judged by Algorithm 1:", &rows);
    println!(
        "\nA third asks for one gripper of eight, a third for two and the head, a third for the base or a place beside it."
    );
    certificates();
}

/// All of a mission, which is a round with a grant and one without for each behavior.
fn certificates() {
    let titles = "tasks|rounds|plain, us a round|with a certificate|ratio";
    let mut rows = vec![titles.split('|').map(str::to_owned).collect::<Vec<_>>()];
    for n in [10, 100, 400] {
        let mission = tasks(n);
        let [(plain, rounds), (certified, same)] = [false, true].map(|prevents_deadlock| {
            let settings = Settings { prevents_deadlock, has_messages: false, ..Settings::default() };
            fastest(|| whole(&mission, &settings))
        });
        assert_eq!(rounds, same, "the same is decided");
        let us = |time: Duration| time.as_secs_f64() * 1e6 / rounds as f64;
        rows.push(vec![
            n.to_string(),
            rounds.to_string(),
            format!("{:.1}", us(plain)),
            format!("{:.1}", us(certified)),
            format!("{:.2}", us(certified) / us(plain)),
        ]);
    }
    table::print("An AND of tasks, each to take an object with one of two grippers and to put it down:", &rows);
}

/// An AND of n THENs of a behavior that takes and one that puts down.
fn tasks(n: usize) -> Arc<MissionSpec> {
    let leaf = |selector, keep, effects, potential| {
        let claims = vec![Claim { selector, access: Access::Exclusive, keep }];
        let always = Condition::All(Vec::new());
        let mut leaf = mission::behavior(claims, Vec::new(), Condition::Never, always, Potential::Constant(potential));
        if let NodeKind::Behavior(spec) = &mut leaf {
            spec.effects = effects;
        }
        leaf
    };
    let mut nodes = vec![(NodeId(0), NodeKind::Root), (NodeId(0), NodeKind::And)];
    for index in 0..n {
        let (then, object) = (NodeId::from(nodes.len()), ObjectId::from(index));
        nodes.push((NodeId(1), NodeKind::Then));
        let empty = Selector::AnyEmpty { of: TypeId(0), reaches: None };
        let kept = Retention::Physical(Access::Exclusive);
        // The best are spread over the tree.
        let potential = 1.0 + (index * 7919 % 1009) as f64;
        nodes.push((then, leaf(empty, kept, vec![EffectTerm::Taken(object, 0)], potential)));
        let put = vec![EffectTerm::Lies(object, PlaceId(0))];
        nodes.push((
            then,
            leaf(Selector::Holding { object, of: TypeId(0), resource: None }, Retention::Release, put, potential),
        ));
    }
    let gripper = ResourceSpec { ty: TypeId(0), controller: None, at: None };
    let mut mission = mission::build(vec![gripper; 2], Vec::new(), nodes, 0);
    mission.start.objects = vec![Location::At(PlaceId(0)); n];
    Arc::new(mission)
}

/// Runs a mission in which everything succeeds, the first of what runs first; gives its rounds.
fn whole(mission: &Arc<MissionSpec>, settings: &Settings) -> usize {
    let mut nodes = build(mission, settings);
    let topology = &mission.tree.topology;
    let mut inbox = VecDeque::from([(NodeId(0), Input::from(Told::Begin { changes: Vec::new() }))]);
    let (mut running, mut rounds) = (BTreeSet::new(), 0);
    let mut out = Outbox::default();
    loop {
        while let Some((node, input)) = inbox.pop_front() {
            nodes[node.index()].handle(Time::ZERO, input, &mut out);
            for effect in out.drain() {
                match effect {
                    Effect::Down(to, down) => inbox.push_back((to, Input::Down(down))),
                    Effect::Up(up) => inbox.push_back((topology.parent(node), Input::Up(up))),
                    Effect::Start(goal) => drop(running.insert(goal.leaf)),
                    Effect::Record(record) => rounds += usize::from(matches!(*record, Record::Decided { .. })),
                    Effect::Finished(end) => {
                        assert_eq!(end, MissionEnd::Done);
                        return rounds;
                    }
                    Effect::Stop(_) | Effect::TakenUp(..) => {}
                    Effect::Worked(..) | Effect::Mission(_) | Effect::Spawn { .. } | Effect::Retire { .. } => {
                        unreachable!("a mission's tree stays as it is")
                    }
                }
            }
        }
        let Node::Root(root) = &nodes[0] else { unreachable!("node 0 is root") };
        if root.wants_turn() {
            inbox.push_back((NodeId(0), Input::Turn));
        } else {
            let leaf = running.pop_first().expect("something runs");
            inbox.push_back((leaf, Input::Ended(Box::new(Outcome { end: End::Succeeded, changes: Vec::new() }))));
        }
    }
}

fn fastest<T>(mut run: impl FnMut() -> T) -> (Duration, T) {
    let mut timed = || {
        let begun = Instant::now();
        let came = run();
        (begun.elapsed(), came)
    };
    (0..SAMPLES).map(|_| timed()).min_by_key(|(time, _)| *time).expect("some samples")
}

fn requests(n: usize) -> Vec<Arc<Request>> {
    let grippers = |first: u32| {
        let all = (0..GRIPPERS).map(|index| (first + index) % GRIPPERS);
        all.map(|index| Candidate { cost_m: f64::from(index) / 10.0, ..Candidate::at_hand(ResourceId(index)) })
            .collect()
    };
    let claim = |access, candidates| ClaimOptions { access, keep: Retention::Release, candidates, beyond: Vec::new() };
    let one = |resource| vec![Candidate::at_hand(resource)];
    let request = |index: usize| {
        let first = index as u32 % GRIPPERS;
        let claims = match index % 3 {
            0 => vec![claim(Access::Exclusive, grippers(first))],
            1 => vec![
                claim(Access::Exclusive, grippers(0)),
                claim(Access::Exclusive, grippers(first)),
                claim(Access::Shared(ChannelId(index as u32 % 5)), one(HEAD)),
            ],
            _ if index.is_multiple_of(2) => vec![claim(Access::Exclusive, one(BASE))],
            _ => vec![claim(Access::Shared(ChannelId(first)), one(BASE)), claim(Access::Exclusive, grippers(first))],
        };
        // Spread, without two alike.
        let potential = 1.0 + (index * 7919 % 104_729) as f64;
        Arc::new(Request {
            priority: 0,
            iterations: 0,
            leaf: NodeId(index as u32 + 1),
            potential,
            heir: false,
            claims,
            changes: Vec::new(),
            skips: Vec::new(),
            place: None,
            stand: None,
            spots: Vec::new(),
            distance: None,
        })
    };
    (0..n).map(request).collect()
}

fn view() -> View {
    let resources = vec![ResourceSpec { ty: TypeId(0), controller: None, at: None }; GRIPPERS as usize + 2];
    let idle = mission::behavior(
        Vec::new(),
        Vec::new(),
        ambidex::model::Condition::Never,
        ambidex::model::Condition::All(Vec::new()),
        Potential::Constant(1.0),
    );
    let nodes = vec![(NodeId(0), NodeKind::Root), (NodeId(0), idle)];
    let mission = Arc::new(mission::build(resources, Vec::new(), nodes, 0));
    View {
        round: 1,
        now: Time::ZERO,
        touched: None,
        barred: Arc::default(),
        state: State::new(Arc::new(mission.tree.topology.clone()), GRIPPERS as usize + 2, mission.start.clone()),
        ways: Arc::new(Ways::new(&Arc::new(FreeSpace::of(&mission)), mission.start.base)),
        mission,
        rules: Arc::new(Unconstrained),
    }
}
