//! Algorithm 1 in root against the number of requests: those of a robot with eight grippers, a base and a head.

#[path = "support/mission.rs"]
mod mission;
#[path = "support/table.rs"]
mod table;

use std::hint::black_box;
use std::sync::Arc;
use std::time::{Duration, Instant};

use ambidex::model::state::State;
use ambidex::model::{
    Access, Candidate, ChannelId, ClaimOptions, NodeId, NodeKind, Potential, Request, ResourceId, ResourceSpec,
    Retention, Time, TypeId,
};
use ambidex::tree::{Allocator, Greedy};
use ambidex::world::{FreeSpace, Unconstrained, View};

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
            let chosen = Greedy.choose(&view, &requests);
            assert_eq!(chosen.granted.len() + chosen.refused.len(), n, "each has its answer");
            chosen.granted.len()
        });
        let (sorted, _) = fastest(|| {
            let mut requests = requests.clone();
            requests.sort_by(|a, b| b.potential.total_cmp(&a.potential));
            black_box(&requests).len()
        });
        let (serial, one) = fastest(|| ambidex::tree::Serial.choose(&view, &requests).granted.len());
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
    let claim = |access, candidates| ClaimOptions { access, keep: Retention::Release, candidates };
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
            leaf: NodeId(index as u32 + 1),
            potential,
            heir: false,
            claims,
            changes: Vec::new(),
            skips: Vec::new(),
        })
    };
    (0..n).map(request).collect()
}

fn view() -> View {
    let resources = vec![ResourceSpec { ty: TypeId(0), controller: None }; GRIPPERS as usize + 2];
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
        state: State::new(Arc::new(mission.tree.topology.clone()), GRIPPERS as usize + 2, mission.start.clone()),
        free_space: Arc::new(FreeSpace::new(&mission.world.obstacles, mission.robot.radius_m)),
        mission,
        rules: Arc::new(Unconstrained),
    }
}
