//! What the controllers of a robot do for a behavior.

use super::bind::Bound;
use super::terms::{Action, Command, Doing, TaskTerm};
use ambidex_model::{BehaviorSpec, Claim, CommandTerm, ControllerKind, EffectTerm, Mode, Task};

impl Bound<'_, '_> {
    /// What controllers do; where nobody moves the base it stands where it was to drive.
    pub(super) fn commands(&mut self, behavior: &mut BehaviorSpec) {
        let kind = self.kind;
        for term in &kind.commands {
            let Some(claim) = self.claims.get(term.claim).copied().flatten() else { continue };
            let Some(task) = self.task(&term.order.task().value, claim, &behavior.claims) else { continue };
            match (self.controller(&behavior.claims[claim]), task) {
                (Some((name, controller)), task) => {
                    self.check_task(term, &task, &name, controller);
                    self.check_time(term, &task);
                    behavior.commands.push(CommandTerm { claim, mode: term.order.mode(), task });
                }
                (None, Task::DriveTo(_, stand)) => behavior.effects.push(EffectTerm::Stands(stand)),
                (None, Task::Stand | Task::LookAt(_) | Task::Call(_)) => {}
                (None, Task::Grasp(_) | Task::GraspFrom(..) | Task::Put(..) | Task::PutInto(..)) => {}
            }
        }
    }

    fn task(&mut self, term: &TaskTerm, own: usize, claims: &[Claim]) -> Option<Task> {
        let Some(Doing { action, with }) = term else { return Some(Task::Stand) };
        Some(match action {
            Action::DriveTo(stand) => {
                let (place, stands) = self.stop(stand)?;
                Task::DriveTo(place, stands[0])
            }
            Action::Grasp(grasped) => self.grasp(grasped, own, claims)?,
            Action::Put(put) => self.put(put, own, claims)?,
            Action::LookAt(place) => Task::LookAt(self.place(place)?),
            Action::Call(name) => Task::Call(self.call(name, with, &claims[own])?),
        })
    }

    /// Who moves the resource of a claim; of a type all are moved, or none is.
    pub(super) fn controller(&self, claim: &Claim) -> Option<(String, ControllerKind)> {
        let robot = self.robot();
        let resource = robot.could_serve(claim.selector).into_iter().next()?;
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
        let is_hands = task.grasped().is_some() || task.put().is_some();
        let is_still = *task == Task::Stand;
        let can = match (controller, task) {
            (_, Task::Call(_)) => return,
            (ControllerKind::Arm(_), _) if is_hands || is_still => return,
            (ControllerKind::Base(_), Task::DriveTo(..) | Task::Stand) => return,
            (ControllerKind::Head(_), Task::LookAt(_) | Task::Stand) => return,
            (ControllerKind::Device, _) => "a device, which can call",
            (ControllerKind::Arm(_), _) => "an arm, which can grasp, put, stand",
            (ControllerKind::Base(_), _) => "a base, which can drive_to, stand",
            (ControllerKind::Head(_), _) => "a head, which can look_at, stand",
        };
        let message = format!("controller `{name}` moves {can}");
        let stays = "what is claimed alone and told nothing stays as it is: leave the command out".to_owned();
        self.faults.push_or_with(term.order.task(), message, is_still.then_some(stays));
    }
}
