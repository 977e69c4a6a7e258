//! Random trees: the core against a reference model, and what must always hold.
//!
//! What failed once stands in `tests/regressions/trees.txt` and is tried first. `AMBIDEX_TREES=100000` sets how many are
//! tried behind it, `AMBIDEX_SEED=17` with `AMBIDEX_DEPTH=4` runs one alone and shows what it is.

mod compare;
mod counts;
mod extras;
mod generator;
mod livelock;
mod plan;
mod reference;
mod run;
mod stalls;

use std::cell::Cell;

use crate::driver::Driver;
use crate::support;
use ambidex::model::{MissionSpec, Record};
use ambidex::tree::Topic;
use proptest::prelude::{Strategy, any};
use proptest::sample::select;
use proptest::test_runner::{Config, FileFailurePersistence, RngSeed, TestError, TestRunner};

use counts::Counts;
use generator::{Case, DEPTH};

const TREES: u32 = 3000;
const REGRESSIONS: &str = "tests/regressions/trees.txt";
/// Most smaller trees that are tried of one that fails.
const SMALLER: u32 = 1000;

fn number<T: std::str::FromStr>(name: &str) -> Option<T> {
    std::env::var(name).ok()?.parse().ok()
}

fn trees() -> u32 {
    number("AMBIDEX_TREES").unwrap_or(TREES)
}

/// Runs `test` on one of `share` trees in two threads; panics with the shallowest tree that fails.
fn for_all(title: &str, share: u32, test: impl Fn(&Case) -> Counts + Sync) -> Counts {
    if let Some(seed) = number("AMBIDEX_SEED") {
        let case = Case::of(seed, number("AMBIDEX_DEPTH").unwrap_or(DEPTH));
        println!("{title}: {}", case.drawing());
        return test(&case);
    }
    let half = |half: u64| {
        let sum = Cell::new(Counts::default());
        let mut runner = TestRunner::new(Config {
            cases: trees() / share / 2,
            rng_seed: RngSeed::Fixed(half),
            failure_persistence: Some(Box::new(FileFailurePersistence::Direct(REGRESSIONS))),
            max_shrink_iters: SMALLER,
            ..Config::default()
        });
        // Mostly deep ones; what fails is tried with less depth.
        let depths = select([(1..DEPTH).collect(), vec![DEPTH; 4 * DEPTH]].concat());
        let ended = runner.run(&(any::<u64>().no_shrink(), depths), |(seed, depth)| {
            let counts = test(&Case::of(seed, depth));
            sum.set(sum.take().plus(counts));
            Ok(())
        });
        match ended {
            Ok(()) => sum.take(),
            Err(TestError::Fail(why, (seed, depth))) => {
                let drawing = Case::of(seed, depth).drawing();
                panic!("{title}: AMBIDEX_SEED={seed} AMBIDEX_DEPTH={depth} fails\n{drawing}\n{why}")
            }
            Err(error @ TestError::Abort(_)) => panic!("{title}: {error}"),
        }
    };
    let counts = std::thread::scope(|scope| {
        let threads = [0, 1].map(|index| scope.spawn(move || half(index)));
        let join = |thread: std::thread::ScopedJoinHandle<'_, Counts>| match thread.join() {
            Ok(counts) => counts,
            Err(panic) => std::panic::resume_unwind(panic),
        };
        threads.into_iter().map(join).reduce(Counts::plus).expect("two threads")
    });
    println!("{title}: {counts}");
    counts
}

/// The mission and the records of one generated case.
pub fn decided(seed: u64) -> (std::sync::Arc<MissionSpec>, Vec<Record>) {
    let case = Case::new(seed);
    let records = run::records(&case, 0).0;
    (case.mission, records)
}

/// Runs a generated case in which anything may happen at any moment, and shows it after every input to a node.
pub fn watched(seed: u64, is_canceled: bool, mut watch: impl FnMut(&MissionSpec, &Driver)) {
    let case = Case::new(seed);
    let cancel_after = if is_canceled { case.plan.cancel_after() } else { usize::MAX };
    run::all_at_once(&case, cancel_after, |driver| watch(&case.mission, driver));
}

/// Every decision, lease, change of the world and end is that of the reference model.
#[test]
fn decisions_are_those_of_the_reference_model() {
    let counts = for_all("against the reference", 1, compare::against_reference);
    if number::<u64>("AMBIDEX_SEED").is_none() && trees() >= 1000 {
        counts.check_spread();
    }
}

/// A round that asks only what has changed comes to what a round comes to that asks everybody, at every node.
#[test]
fn rounds_are_those_of_plain_recursion() {
    for_all("in lockstep", 1, |case| {
        let (difference, counts) = run::in_lockstep(case, |_| false);
        assert_eq!(difference, None);
        counts
    });
}

/// No topic is there for nothing: without it some node says what is no longer so.
#[test]
fn a_topic_left_out_is_noticed() {
    type IsLeftOut = fn(Topic) -> bool;
    let left_out: [(&str, IsLeftOut); 8] = [
        ("resource", |topic| matches!(topic, Topic::Resource(_))),
        ("object", |topic| matches!(topic, Topic::Object(_))),
        ("fact", |topic| matches!(topic, Topic::Fact(_))),
        ("base", |topic| matches!(topic, Topic::Base)),
        ("driver", |topic| matches!(topic, Topic::Driver)),
        ("intention", |topic| matches!(topic, Topic::Intention(_))),
        ("progress", |topic| matches!(topic, Topic::Progress)),
        ("own", |topic| matches!(topic, Topic::Own(_))),
    ];
    for (name, unheard) in left_out {
        let noticed = (0..u64::from(trees())).find_map(|seed| {
            let difference = run::in_lockstep(&Case::new(seed), unheard).0?;
            Some((seed, difference))
        });
        let (seed, difference) = noticed.unwrap_or_else(|| panic!("nobody misses the topic {name}"));
        println!("without {name}: tree {seed}, {}", support::short(&difference));
    }
}

/// Ends and changes of the world at any moment, also in the middle of a round.
#[test]
fn invariants_hold_whenever_things_end() {
    for_all("chaos", 1, run::chaos);
}

/// The same with a cancel at any moment.
#[test]
fn canceled_missions_end() {
    for_all("canceled", 3, run::canceled);
}

/// A certificate refuses what would leave no order, and where nothing goes wrong hardly a tree stalls for it that would not.
#[test]
fn a_certificate_costs_hardly_a_stall() {
    let undisturbed = |case: &Case| run::records(&case.undisturbed(), 0).1;
    let plain = for_all("without a certificate", 1, undisturbed);
    let certified = for_all("with a certificate", 1, |case| undisturbed(&case.certified()));
    if number::<u64>("AMBIDEX_SEED").is_none() && trees() >= 1000 {
        assert!(certified.told("WouldDeadlock") > 0 && certified.stalled() * 50 <= plain.stalled() * 51);
    }
}

/// Invariants, replay and the answers of every round are as good with a certificate.
#[test]
fn a_certificate_keeps_every_invariant() {
    for_all("chaos with a certificate", 2, |case| run::chaos(&case.certified()));
    for_all("canceled with a certificate", 3, |case| run::canceled(&case.certified()));
    for_all("in lockstep with a certificate", 2, |case| {
        let (difference, counts) = run::in_lockstep(&case.certified(), |_| false);
        assert_eq!(difference, None);
        counts
    });
}

/// The order between edges changes no record.
#[test]
fn records_do_not_depend_on_interleaving() {
    for_all("interleavings", 5, |case| {
        let (first, counts) = run::lines(case, 0);
        for interleaving in 1..4 {
            assert!(run::lines(case, interleaving).0 == first, "interleaving {interleaving}");
        }
        counts
    });
}
