//! What the controllers of a robot do for a behavior.

use super::bind::Bound;
use super::terms::{Action, Command, ObjectAt, TAKEN, TaskTerm};
use ambidex_model::{BehaviorSpec, Claim, CommandTerm, ControllerKind, EffectTerm, Task};

impl Bound<'_, '_> {
    /// What controllers do; where nobody moves the base it stands where it was to drive.
    pub(super) fn commands(&mut self, behavior: &mut BehaviorSpec) {
        let kind = self.kind;
        for term in &kind.commands {
            let Some(claim) = self.claims.get(term.claim).copied().flatten() else { continue };
            let Some(task) = self.task(&term.order.task().value) else { continue };
            match (self.controller(&behavior.claims[claim]), task) {
                (Some((name, controller)), task) => {
                    self.check_task(term, task, &name, controller);
                    behavior.commands.push(CommandTerm { claim, mode: term.order.mode(), task });
                }
                (None, Task::DriveTo(stand)) => behavior.effects.push(EffectTerm::Stands(stand)),
                (None, Task::Stand | Task::Grasp(_) | Task::Put(..) | Task::LookAt(_)) => {}
            }
        }
    }

    /// What is taken is held by what could take it.
    pub(super) fn check_takers(&mut self, behavior: &BehaviorSpec) {
        for effect in &behavior.effects {
            let EffectTerm::Taken(_, claim) = effect else { continue };
            let (name, word) = match self.controller(&behavior.claims[*claim]) {
                Some((name, ControllerKind::Base(_))) => (name, "a base"),
                Some((name, ControllerKind::Head(_))) => (name, "a head"),
                Some((_, ControllerKind::Arm(_))) | None => continue,
            };
            let message = format!("controller `{name}` moves {word}, which cannot hold what is taken");
            self.faults.push((self.kind.name.span, TAKEN), message);
        }
    }

    pub(super) fn task(&mut self, term: &TaskTerm) -> Option<Task> {
        Some(match term {
            None => Task::Stand,
            Some(Action::DriveTo(stand)) => Task::DriveTo(self.stop(stand)?.stand),
            Some(Action::Grasp(object)) => Task::Grasp(self.object(object)?),
            Some(Action::Put(ObjectAt { object, place })) => Task::Put(self.object(object)?, self.place(place)?),
            Some(Action::LookAt(place)) => Task::LookAt(self.place(place)?),
        })
    }

    /// Who moves the resource of a claim; of a type all are moved, or none is.
    pub(super) fn controller(&self, claim: &Claim) -> Option<(String, ControllerKind)> {
        let robot = self.robot();
        let resource = robot.could_serve(claim.selector, &self.holders()).into_iter().next()?;
        let controller = &robot.controllers[robot.resources[resource.index()].controller?.index()];
        Some((controller.name.clone(), controller.kind))
    }

    pub(super) fn check_task(&mut self, term: &Command, task: Task, name: &str, controller: ControllerKind) {
        let can = match (controller, task) {
            (ControllerKind::Arm(_), Task::Grasp(_) | Task::Put(..))
            | (ControllerKind::Base(_), Task::DriveTo(_) | Task::Stand)
            | (ControllerKind::Head(_), Task::LookAt(_)) => return,
            (ControllerKind::Arm(_), Task::DriveTo(_) | Task::Stand | Task::LookAt(_)) => {
                "an arm, which can grasp, put"
            }
            (ControllerKind::Base(_), Task::Grasp(_) | Task::Put(..) | Task::LookAt(_)) => {
                "a base, which can drive_to, stand"
            }
            (ControllerKind::Head(_), Task::DriveTo(_) | Task::Stand | Task::Grasp(_) | Task::Put(..)) => {
                "a head, which can look_at"
            }
        };
        let message = format!("controller `{name}` moves {can}");
        let stays = "what is claimed alone and told nothing stays as it is: leave the command out".to_owned();
        self.faults.push_or_with(term.order.task(), message, (task == Task::Stand).then_some(stays));
    }
}
