//! `ambidex simulate --runs`: many runs of one mission in which something goes wrong by chance.

use std::sync::Arc;

use ambidex::model::{Failures, MissionEnd, MissionSpec, Record};
use ambidex::record::History;
use ambidex::show::trials::{Trial, Trials, text};
use ambidex::sim::{self, Chance};
use ambidex::tree::Settings;
use miette::Result;

use crate::args::MissionArgs;
use crate::exit::Exit;
use crate::page::Page;
use crate::parallel::parallel;
use crate::terminal::Progress;

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
    let trial = |index: u64| {
        let chance = Chance { seed: chance.seed.wrapping_add(index), ..chance };
        let mut drawn = Failures::default();
        let history = history(|journal| {
            drawn = sim::simulate_chance(mission, settings, failures, chance, journal).1;
        });
        Trial::of(chance.seed, &history?, &drawn)
    };
    let progress = Progress::new(runs, "runs", is_quiet);
    parallel(runs, None, &progress, || false, trial).into_iter().flatten().collect()
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
