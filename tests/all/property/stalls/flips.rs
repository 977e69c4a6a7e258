//! The moment from which on no schedule was left, and what happened then.

use ambidex::model::{End, Grant, MissionSpec};

use super::search::{Found, Search};
use super::{BEFORE, Moment, Verdict};
use crate::property::reference::{Freedom, Model, Next};
use crate::property::run::Event;

/// What happened in the moment from which on no schedule was left.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Cause {
    /// Something failed or was interrupted.
    Failed,
    /// A behavior ended otherwise than its kind promises.
    Otherwise,
    /// Others changed the world.
    Outside,
    /// A controller went.
    Away,
    /// A node took too long.
    TimeOver,
    /// Of those that ran the wrong one ended first.
    EndedFirst,
    /// A behavior was granted resources with which it leads nowhere; with others there was a schedule.
    Resource,
    /// A behavior was granted in a way of an OR that leads nowhere.
    Way,
    /// What was passed over as satisfied would have had to run.
    Skipped,
    /// A behavior that came too early changed what others need.
    World,
    /// A behavior that came too early took, kept or gave back what others need.
    Leases,
    /// Both together.
    WorldAndLeases,
    /// A behavior came too early otherwise: every schedule that was left runs it later.
    Early,
    /// A behavior ran that in the schedule which was left need not run.
    Needless,
    /// What a round did beside grants: what lapsed, was sent back, left, passed over, given up or begun anew.
    Beside,
}

/// The last of all moments after which no schedule was left.
pub fn last(mission: &MissionSpec, moments: &[Moment<'_>]) -> Verdict {
    let mut search = Search::new(mission, Freedom::OWN);
    for (index, moment) in moments.iter().enumerate().rev().skip(1) {
        match search.from(&moment.before) {
            Found::Nothing => {}
            Found::CutOff => return Verdict::CutOff(BEFORE),
            Found::Schedule(_) => return cause(mission, &mut search, moment, &moments[index + 1].before),
        }
    }
    Verdict::Unsolvable
}

fn cause<'m>(mission: &'m MissionSpec, search: &mut Search<'m>, moment: &Moment<'m>, after: &Model<'m>) -> Verdict {
    Verdict::Lost(match &moment.event {
        Some(Event::World(..)) => Cause::Outside,
        Some(Event::Service(..)) => Cause::Away,
        Some(Event::Woke) => Cause::TimeOver,
        Some(Event::Cancel | Event::Nothing) => return Verdict::Unexplained("told to end".into()),
        Some(Event::Ended(_, outcome)) if outcome.end != End::Succeeded => Cause::Failed,
        Some(Event::Ended(_, outcome)) if !outcome.changes.is_empty() => Cause::Otherwise,
        Some(Event::Ended(..)) => Cause::EndedFirst,
        None => return of_round(mission, search, &moment.before, after),
    })
}

/// Which of the grants of a round it was, or what came of it beside.
fn of_round<'m>(mission: &'m MissionSpec, search: &mut Search<'m>, before: &Model<'m>, after: &Model<'m>) -> Verdict {
    let granted: Vec<&Grant> =
        after.running.iter().filter(|(leaf, _)| !before.running.contains_key(leaf)).map(|(_, grant)| grant).collect();
    let mut model = before.clone();
    for grant in granted {
        let mut with = model.clone();
        with.start(grant);
        match search.from(&with) {
            Found::CutOff => return Verdict::CutOff(BEFORE),
            Found::Schedule(_) => model = with,
            Found::Nothing => {
                let cause = of_grant(mission, search, &model, grant);
                let unknown = || Verdict::Unexplained(format!("after the grant of {:?}", grant.leaf()));
                return cause.map_or_else(unknown, Verdict::Lost);
            }
        }
    }
    Verdict::Lost(Cause::Beside)
}

fn of_grant<'m>(mission: &'m MissionSpec, search: &mut Search<'m>, before: &Model<'m>, grant: &Grant) -> Option<Cause> {
    let leaf = grant.leaf();
    let mut is_solvable = |model: &Model<'m>| matches!(search.from(model), Found::Schedule(_));
    let asks = before.for_search(mission, Freedom::OWN).asking(Freedom::OWN);
    let others = asks.iter().filter(|ask| ask.grant.leaf() == leaf).flat_map(|ask| before.grants(ask));
    for other in others {
        let mut with = before.clone();
        with.start(&other);
        if is_solvable(&with) {
            return Some(Cause::Resource);
        }
    }
    let mut chosen = before.clone();
    before.would_choose(leaf).into_iter().for_each(|(or, way)| chosen.choose_way(or, way));
    if !is_solvable(&chosen) {
        return Some(Cause::Way);
    }
    let after = before.after_run(grant);
    let otherwise = [
        (Cause::Skipped, after.without_skips(grant)),
        (Cause::World, after.restored(before, true, false)),
        (Cause::Leases, after.restored(before, false, true)),
        (Cause::WorldAndLeases, after.restored(before, true, true)),
    ];
    if let Some((cause, _)) = otherwise.into_iter().find(|(_, model)| is_solvable(model)) {
        return Some(cause);
    }
    let Found::Schedule(schedule) = search.from(before) else { return None };
    let runs_it = schedule.iter().any(|next| matches!(next, Next::Run(other, _) if *other == leaf));
    Some(if runs_it { Cause::Early } else { Cause::Needless })
}
