//! What the controllers of a robot do for a behavior.

use super::Stop;
use super::bind::Bound;
use super::terms::{Action, Command, Doing, ObjectAt, TAKEN, TaskTerm};
use ambidex_model::{BehaviorSpec, Claim, CommandTerm, ControllerKind, EffectTerm, Mode, Task};

impl Bound<'_, '_> {
    /// What controllers do; where nobody moves the base it stands where it was to drive.
    pub(super) fn commands(&mut self, behavior: &mut BehaviorSpec) {
        let kind = self.kind;
        for term in &kind.commands {
            let Some(claim) = self.claims.get(term.claim).copied().flatten() else { continue };
            let Some(task) = self.task(&term.order.task().value, &behavior.claims[claim]) else { continue };
            match (self.controller(&behavior.claims[claim]), task) {
                (Some((name, controller)), task) => {
                    self.check_task(term, &task, &name, controller);
                    self.check_time(term, &task);
                    behavior.commands.push(CommandTerm { claim, mode: term.order.mode(), task });
                }
                (None, Task::DriveTo(_, stand)) => behavior.effects.push(EffectTerm::Stands(stand)),
                (None, Task::Stand | Task::Grasp(_) | Task::Put(..) | Task::LookAt(_) | Task::Call(_)) => {}
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
                Some((name, ControllerKind::Device)) => (name, "a device"),
                Some((_, ControllerKind::Arm(_))) | None => continue,
            };
            let message = format!("controller `{name}` moves {word}, which cannot hold what is taken");
            self.faults.push((self.kind.name.span, TAKEN), message);
        }
    }

    fn task(&mut self, term: &TaskTerm, claim: &Claim) -> Option<Task> {
        let Some(Doing { action, with }) = term else { return Some(Task::Stand) };
        Some(match action {
            Action::DriveTo(stand) => {
                let Stop { place, stand, .. } = self.stop(stand)?;
                Task::DriveTo(place, stand)
            }
            Action::Grasp(object) => Task::Grasp(self.object(object)?),
            Action::Put(ObjectAt { object, place }) => Task::Put(self.object(object)?, self.place(place)?),
            Action::LookAt(place) => Task::LookAt(self.place(place)?),
            Action::Call(name) => Task::Call(self.call(name, with, claim)?),
        })
    }

    /// Who moves the resource of a claim; of a type all are moved, or none is.
    pub(super) fn controller(&self, claim: &Claim) -> Option<(String, ControllerKind)> {
        let robot = self.robot();
        let resource = robot.could_serve(claim.selector, &self.holders()).into_iter().next()?;
        let controller = &robot.controllers[robot.resources[resource.index()].controller?.index()];
        Some((controller.name.clone(), controller.kind))
    }

    /// A call that cannot end in time.
    fn check_time(&mut self, term: &Command, task: &Task) {
        let (Task::Call(call), Mode::Achieve) = (task, term.order.mode()) else { return };
        let timeout = self.kind.timeout;
        if call.takes >= timeout {
            let (takes_s, timeout_s) = (call.takes.as_secs_f64(), timeout.as_secs_f64());
            let message =
                format!("`{}` takes {takes_s} s, and the timeout of the behavior is {timeout_s} s", call.name);
            self.faults.push_with(term.order.task(), message, "give the behavior a greater `timeout`");
        }
    }

    fn check_task(&mut self, term: &Command, task: &Task, name: &str, controller: ControllerKind) {
        let can = match (controller, task) {
            (ControllerKind::Arm(_), Task::Grasp(_) | Task::Put(..))
            | (ControllerKind::Base(_), Task::DriveTo(..) | Task::Stand)
            | (ControllerKind::Head(_), Task::LookAt(_))
            | (_, Task::Call(_)) => return,
            (
                ControllerKind::Device,
                Task::DriveTo(..) | Task::Stand | Task::Grasp(_) | Task::Put(..) | Task::LookAt(_),
            ) => "a device, which can call",
            (ControllerKind::Arm(_), Task::DriveTo(..) | Task::Stand | Task::LookAt(_)) => {
                "an arm, which can grasp, put"
            }
            (ControllerKind::Base(_), Task::Grasp(_) | Task::Put(..) | Task::LookAt(_)) => {
                "a base, which can drive_to, stand"
            }
            (ControllerKind::Head(_), Task::DriveTo(..) | Task::Stand | Task::Grasp(_) | Task::Put(..)) => {
                "a head, which can look_at"
            }
        };
        let message = format!("controller `{name}` moves {can}");
        let stays = "what is claimed alone and told nothing stays as it is: leave the command out".to_owned();
        self.faults.push_or_with(term.order.task(), message, (*task == Task::Stand).then_some(stays));
    }
}
