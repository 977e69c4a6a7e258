//! The moment from which on no schedule was left, and what happened then.

use ambidex::model::{End, Grant, MissionSpec, NodeId};

use super::search::{Found, Search};
use super::{Moment, Verdict};
use crate::property::reference::{Freedom, Model, Step};
use crate::property::run::Event;

/// What happened in the moment from which on no schedule was left.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub enum Cause {
    /// Something failed, was lost, took too long, or was changed from outside.
    Failure,
    Outside,
    Away,
    TimeOver,
    /// A behavior ended otherwise than its kind promises.
    Otherwise,
    /// Of two that ran the wrong one ended first.
    EndedFirst,
    /// Granted with resources with which it leads nowhere; with others there was a schedule.
    Resource,
    /// Granted in a way of an OR that leads nowhere.
    Way,
    /// Granted too early.
    Order(String),
    /// A decision beside grants.
    Beside(String),
}

/// The last of all moments after which no schedule was left.
pub fn last(mission: &MissionSpec, moments: &[Moment<'_>]) -> Verdict {
    let mut search = Search::new(mission, Freedom::OWN);
    for (index, moment) in moments.iter().enumerate().rev().skip(1) {
        match search.from(&moment.before) {
            Found::Nothing => {}
            Found::CutOff => return Verdict::CutOff,
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
        Some(Event::Cancel | Event::Nothing) => Cause::Beside(format!("{:?}", moment.event)),
        Some(Event::Ended(_, outcome)) if outcome.end != End::Succeeded => Cause::Failure,
        Some(Event::Ended(_, outcome)) if !outcome.changes.is_empty() => Cause::Otherwise,
        Some(Event::Ended(..)) => Cause::EndedFirst,
        None => return of_round(mission, search, &moment.before, after),
    })
}

/// Which of the grants of a round it was, or what came of it beside.
fn of_round<'m>(
    mission: &'m MissionSpec,
    search: &mut Search<'m>,
    before: &Model<'m>,
    after: &Model<'m>,
) -> Verdict {
    let granted: Vec<&Grant> =
        after.running.iter().filter(|(leaf, _)| !before.running.contains_key(leaf)).map(|(_, grant)| grant).collect();
    let mut model = before.clone();
    for grant in granted {
        let mut with = model.clone();
        with.start(grant);
        match search.from(&with) {
            Found::CutOff => return Verdict::CutOff,
            Found::Schedule(_) => model = with,
            Found::Nothing => return Verdict::Lost(of_grant(mission, search, &model, grant)),
        }
    }
    let steps = after.log.iter().map(|step| match step {
        Step::Decided(decision) => format!("decided {:?}", decision.reopened.as_ref().map(|reopened| &reopened.cause)),
        other => format!("{other:?}"),
    });
    Verdict::Lost(Cause::Beside(steps.collect::<Vec<_>>().join("; ")))
}

fn of_grant<'m>(mission: &'m MissionSpec, search: &mut Search<'m>, before: &Model<'m>, grant: &Grant) -> Cause {
    let leaf = grant.leaf();
    let asks = before.for_search(mission, Freedom::OWN).asking(Freedom::OWN);
    for ask in asks.iter().filter(|ask| ask.grant.leaf() == leaf) {
        for other in before.grants(ask) {
            let mut with = before.clone();
            with.start(&other);
            if let Found::Schedule(_) = search.from(&with) {
                return Cause::Resource;
            }
        }
    }
    for (or, way) in before.would_choose(leaf) {
        let mut with = before.clone();
        with.choose_way(or, way);
        if search.from(&with) == Found::Nothing {
            return Cause::Way;
        }
    }
    Cause::Order(kind(mission, leaf))
}

fn kind(mission: &MissionSpec, leaf: NodeId) -> String {
    let spec = mission.tree.behavior(leaf).expect("a leaf");
    let keeps = spec.claims.iter().any(|claim| matches!(claim.keep, ambidex::model::Retention::Physical(_)));
    format!("{} keeps {keeps} effects {:?}", spec.kind, spec.effects)
}
