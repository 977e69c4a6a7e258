//! From a grant to a goal, and from an outcome to what is different in the world.

use crate::world::View;
use ambidex_model::{
    BehaviorSpec, Change, Command, EffectTerm, End, Goal, Grant, Outcome, Part, Report, Task, Whereabouts,
};

/// The goal of a granted behavior, with positions as of the view it asked in.
pub fn goal(spec: &BehaviorSpec, grant: &Grant, view: &View) -> Goal {
    let parts = spec.commands.iter().map(|term| {
        let binding = grant.bindings[term.claim];
        Part { resource: binding.resource, access: binding.access, mode: term.mode, command: command(term.task, view) }
    });
    Goal { leaf: grant.leaf, parts: parts.collect(), takes: spec.takes, timeout: spec.timeout }
}

fn command(task: Task, view: &View) -> Command {
    let (geometry, situation) = (&view.geometry, &view.situation);
    match task {
        Task::DriveTo(stand) => {
            Command::Drive { path: geometry.path(situation.base, stand).unwrap_or_else(|| vec![stand]) }
        }
        Task::Stand => Command::Stand,
        Task::Grasp(object) => {
            let at = geometry.object(situation, object).expect("a granted grasp knows where its object is");
            Command::Grasp { object, at: situation.base.to_local(at) }
        }
        Task::Put(object, place) => Command::Put { object, at: situation.base.to_local(geometry.spot(object, place)) },
        Task::LookAt(place) => Command::Look { at: situation.base.to_local(geometry.surface(place)) },
    }
}

/// What is different after a behavior: its effects where it succeeded, then what its controllers report.
pub fn changes(spec: &BehaviorSpec, grant: &Grant, outcome: &Outcome) -> Vec<Change> {
    let effects: &[EffectTerm] = match outcome.end {
        End::Succeeded => &spec.effects,
        End::Failed(_) | End::Canceled => &[],
    };
    let effects = effects.iter().map(|effect| match *effect {
        EffectTerm::Lies(object, place) => Change::Object(object, Whereabouts::At(place)),
        EffectTerm::Taken(object, claim) => Change::Object(object, Whereabouts::In(grant.bindings[claim].resource)),
        EffectTerm::Stands(pose) => Change::Base(pose),
        EffectTerm::Fact(fact, holds) => Change::Fact(fact, holds),
    });
    let reports = outcome.reports.iter().map(|report| match *report {
        Report::BaseAt(pose) => Change::Base(pose),
        Report::Holds(resource, Some(object)) => Change::Object(object, Whereabouts::In(resource)),
        Report::Holds(resource, None) => Change::Emptied(resource),
    });
    effects.chain(reports).collect()
}
