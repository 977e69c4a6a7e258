//! Random trees: the core against a reference model, and what must always hold.
//!
//! `AMBIDEX_TREES=100000` sets how many, `AMBIDEX_SEED=17` runs one alone and shows what it is.

mod counts;
mod generator;
mod plan;
mod reference;
mod run;

use std::cell::{Cell, RefCell};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Once;

use crate::driver::Driver;
use ambidex::model::{MissionSpec, Record};
use counts::Counts;
use generator::Case;

const TREES: u64 = 3000;

fn seeds() -> std::ops::Range<u64> {
    let number = |name| std::env::var(name).ok()?.parse::<u64>().ok();
    match number("AMBIDEX_SEED") {
        Some(seed) => seed..seed + 1,
        None => 0..number("AMBIDEX_TREES").unwrap_or(TREES),
    }
}

/// Runs `test` on every `share`th seed in two threads; panics with the smallest tree that fails.
fn for_all(title: &str, share: u64, test: impl Fn(&Case) -> Counts + Sync) -> Counts {
    let (seeds, test) = (seeds(), &test);
    let is_alone = seeds.end - seeds.start == 1;
    let run = |half: u64| {
        let mut sum = Counts::default();
        let mut failures = Vec::new();
        for seed in seeds.clone() {
            if is_alone || (seed % share == 0 && seed / share % 2 == half) {
                let case = Case::new(seed);
                match quietly(|| test(&case)) {
                    Ok(counts) => sum = sum.plus(counts),
                    Err(message) => failures.push((case.mission.tree.nodes.len(), seed, message)),
                }
            }
        }
        (sum, failures)
    };
    let halves = if is_alone { 0..1 } else { 0..2 };
    let (counts, failures) = std::thread::scope(|scope| {
        let threads: Vec<_> = halves
            .map(|half| {
                scope.spawn({
                    let run = &run;
                    move || run(half)
                })
            })
            .collect();
        let mut all = (Counts::default(), Vec::new());
        for thread in threads {
            let (counts, failures) = thread.join().expect("what fails is caught");
            all = (all.0.plus(counts), [all.1, failures].concat());
        }
        all
    });
    println!("{title}: {counts}");
    if let Some((_, seed, message)) = failures.iter().min() {
        let drawing = Case::new(*seed).drawing();
        let count = failures.len();
        panic!("{title}: {count} fail, the smallest with AMBIDEX_SEED={seed}\n{drawing}\n{message}");
    }
    counts
}

/// What a test comes to, or with what words it panics, without printing them.
fn quietly(test: impl FnOnce() -> Counts) -> Result<Counts, String> {
    static HOOK: Once = Once::new();
    HOOK.call_once(|| {
        let loud = std::panic::take_hook();
        std::panic::set_hook(Box::new(move |info| {
            if IS_QUIET.get() {
                let place = info.location().map(ToString::to_string).unwrap_or_default();
                PLACE.set(place);
            } else {
                loud(info);
            }
        }));
    });
    IS_QUIET.set(true);
    let result = catch_unwind(AssertUnwindSafe(test));
    IS_QUIET.set(false);
    result.map_err(|panic| {
        let owned = panic.downcast_ref::<String>().cloned();
        let text = owned.or_else(|| panic.downcast_ref::<&str>().map(ToString::to_string));
        format!("{}: {}", PLACE.take(), text.unwrap_or_default())
    })
}

thread_local! {
    static IS_QUIET: Cell<bool> = const { Cell::new(false) };
    static PLACE: RefCell<String> = const { RefCell::new(String::new()) };
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
    let counts = for_all("against the reference", 1, run::against_reference);
    if seeds().end - seeds().start >= 1000 {
        counts.check_spread();
    }
}

/// Ends and changes of the world at any moment, also in the middle of a round.
#[test]
fn invariants_hold_whenever_things_end() {
    for_all("chaos", 1, run::chaos);
}

/// The same with a cancel at any moment.
#[test]
fn cancelled_missions_end() {
    for_all("cancelled", 3, run::cancelled);
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
