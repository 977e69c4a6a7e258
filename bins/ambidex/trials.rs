//! `ambidex simulate --runs`: many runs of one mission in which something goes wrong by chance.

use std::num::NonZero;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::thread;
use std::time::Duration;

use ambidex::model::{Failures, MissionEnd, MissionSpec, Record};
use ambidex::record::History;
use ambidex::show::trials::{Trial, Trials, text};
use ambidex::sim::{self, Chance};
use ambidex::tree::Settings;
use miette::Result;

use crate::args::MissionArgs;
use crate::exit::Exit;
use crate::page::Page;
use crate::terminal::Progress;

/// How often it is looked how far it is.
const POLL: Duration = Duration::from_millis(5);

/// Runs with this seed and those after it, and prints what they came to.
pub fn run(
    args: &MissionArgs,
    mission: &Arc<MissionSpec>,
    settings: &Settings,
    failures: &Failures,
    chance: Chance,
    runs: u64,
) -> Result<Exit> {
    // Nobody reads a log of these.
    let settings = Settings { has_messages: false, ..settings.clone() };
    let undisturbed = history(|journal| {
        sim::simulate_failures(mission, &settings, failures, journal);
    });
    let undisturbed_s = undisturbed.filter(|history| history.end() == Some(MissionEnd::Done));
    let trials = Trials {
        mission: mission.name.clone(),
        probability: chance.probability,
        undisturbed_s: undisturbed_s.map(|history| history.makespan_s()),
        trials: trials(mission, &settings, failures, chance, runs, args.quiet),
    };
    Page::new().tell(args.json, &trials, text)?;
    Ok(Exit::Done)
}

/// The runs in the order of their seeds, on all cores.
fn trials(
    mission: &Arc<MissionSpec>,
    settings: &Settings,
    failures: &Failures,
    chance: Chance,
    runs: u64,
    is_quiet: bool,
) -> Vec<Trial> {
    let next = AtomicU64::new(0);
    let trial = |index: u64| {
        let chance = Chance { seed: chance.seed.wrapping_add(index), ..chance };
        let mut drawn = Failures::default();
        let history = history(|journal| {
            drawn = sim::simulate_chance(mission, settings, failures, chance, journal).1;
        });
        Trial::of(chance.seed, &history?, &drawn)
    };
    let work = || {
        let mut own = Vec::new();
        while let index = next.fetch_add(1, Ordering::Relaxed)
            && index < runs
        {
            own.push((index, trial(index)));
        }
        own
    };
    let progress = Progress::new(runs, "runs", is_quiet);
    let cores = thread::available_parallelism().map_or(1, NonZero::get);
    let mut done = thread::scope(|scope| {
        let workers: Vec<_> = (0..cores).map(|_| scope.spawn(work)).collect();
        while workers.iter().any(|worker| !worker.is_finished()) {
            progress.at(next.load(Ordering::Relaxed).min(runs));
            thread::sleep(POLL);
        }
        workers.into_iter().flat_map(|worker| worker.join().expect("a run does not panic")).collect::<Vec<_>>()
    });
    progress.clear();
    done.sort_by_key(|(index, _)| *index);
    done.into_iter().filter_map(|(_, trial)| trial).collect()
}

/// What the records come to that something writes.
fn history(run: impl FnOnce(&mut dyn FnMut(&Record))) -> Option<History> {
    let mut history: Option<History> = None;
    run(&mut |record| match (&mut history, record) {
        (Some(history), record) => history.apply(record),
        (history, Record::Header(header)) => *history = Some(History::new(header)),
        (None, _) => {}
    });
    history
}
