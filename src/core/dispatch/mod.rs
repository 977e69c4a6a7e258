//! From a leaf's goal to commands of controllers and back: sharing, identities, deadlines, attachment. Pure.

mod attachment;
mod command_queue;
mod drops;
mod goals;
mod reports;
mod script;

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;

use attachment::Attachment;
pub use attachment::{LastKnown, at_start};
use command_queue::CommandQueue;
use drops::Drops;
use goals::Running;
use reports::Reports;
pub use script::Script;

use ambidex_model::{
    Change, CommandId, ControllerId, ControllerMessage, ControllerState, End, Fault, Flaw, FromController, Goal,
    Inhibition, Labels, Loss, MissionSpec, NodeId, Outcome, Part, Record, Refusal, Rejection, Report, Time,
    ToController,
};

/// What reaches the dispatch.
#[derive(Debug, Clone, PartialEq)]
pub enum Input {
    /// A controller is there.
    Attached(ControllerId),
    /// A controller said something.
    Heard(ControllerId, FromController),
    /// A controller says what it sees of the world.
    Reported(ControllerId, Report),
    /// What a controller said could not be used.
    Refused(ControllerId, Refusal),
    /// A controller let go of a command without a result.
    Closed(ControllerId, CommandId),
    /// A controller is gone.
    Lost(ControllerId, Loss),
    /// A leaf was granted.
    Start(Goal),
    /// End the goal of this leaf.
    Stop(NodeId),
    /// The mission is another one from now on, as to its tree and its objects.
    Mission(Arc<MissionSpec>),
    /// The deadline came.
    Woke,
    /// End everything and say when all is safe.
    Shutdown,
}

/// What the dispatch wants done.
#[derive(Debug, Clone, PartialEq)]
pub enum Effect {
    /// Tell a controller.
    Tell(ControllerId, ToController),
    /// This controller is attached and configured.
    Configured(ControllerId),
    /// All of them are: what they say of the world.
    Ready(Vec<Change>),
    /// The goal of this leaf ended.
    Ended(NodeId, Outcome),
    /// Where the base is while it drives.
    Observed(Change),
    /// An object has left its gripper on purpose: where it is now.
    Dropped(Change),
    /// A controller says what it sees of the world, as its robot file lets it.
    Reported(ControllerId, Change),
    /// A controller is away: what it moves cannot be used.
    Lost(ControllerId, Loss),
    /// A controller that was away is attached and configured again: what it says of the world.
    Returned(ControllerId, Vec<Change>),
    /// A controller is gone before the mission began: it is awaited again.
    Missing(ControllerId),
    /// Whatever is known of this controller's attachment is void: it may attach anew.
    Reset(ControllerId),
    /// After a shutdown: nothing is under way any more.
    Safe,
    /// Write it down.
    Record(Record),
}

/// Time limits, robot time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// Robot seconds per wall second.
    pub speed: f64,
    /// Within which a controller takes a goal: 1 s of a wall clock.
    pub accept: Duration,
}

impl Limits {
    /// The limits at a speed.
    pub fn at_speed(speed: f64) -> Self {
        Self { speed, accept: Duration::from_secs_f64(speed) }
    }

    /// A span of the wall clock as robot time.
    pub fn robot(&self, wall: Duration) -> Duration {
        wall.mul_f64(self.speed)
    }
}

/// The machine between leaves and controllers.
#[derive(Debug)]
pub struct Dispatch {
    mission: Arc<MissionSpec>,
    /// What controllers are configured with: what they reported last.
    states: Vec<ControllerState>,
    limits: Limits,
    attachments: Vec<Attachment>,
    queues: Vec<CommandQueue>,
    goals: BTreeMap<NodeId, Running>,
    is_ready: bool,
    is_ending: bool,
    is_safe: bool,
    /// What goes wrong on purpose.
    script: Script,
    drops: Drops,
    reports: Reports,
    labels: Labels,
    effects: Vec<Effect>,
}

impl Dispatch {
    /// For a mission whose controllers are not there yet, and of which that much is known.
    pub fn new(mission: &Arc<MissionSpec>, known: Vec<LastKnown>, limits: Limits) -> Self {
        let count = mission.robot.controllers.len();
        Self {
            mission: Arc::clone(mission),
            limits,
            attachments: known.iter().map(|known| Attachment::after(known.generation)).collect(),
            states: known.into_iter().map(|known| known.state).collect(),
            queues: (0..count).map(|_| CommandQueue::default()).collect(),
            goals: BTreeMap::new(),
            is_ready: false,
            is_ending: false,
            is_safe: false,
            script: Script::default(),
            drops: Drops::default(),
            reports: Reports::default(),
            labels: Labels::new(&mission.names),
            effects: Vec::new(),
        }
    }

    /// Lets goals go wrong on purpose from now on.
    pub fn follow(&mut self, script: Script) {
        self.script = script;
    }

    /// One thing more goes wrong on purpose from now on.
    pub fn mar(&mut self, flaw: Flaw) {
        self.script.add(flaw);
    }

    /// Takes an input at a moment of robot time.
    pub fn handle(&mut self, now: Time, input: Input) -> Vec<Effect> {
        match input {
            Input::Attached(id) => self.attached(now, id),
            Input::Heard(id, message) => self.heard(now, id, message),
            Input::Reported(id, report) => self.reported(now, id, report),
            Input::Refused(id, refusal) => self.refused(now, id, refusal),
            Input::Closed(id, command) => self.closed(now, id, command),
            Input::Lost(id, why) => self.lost(now, id, why),
            Input::Start(goal) => self.attempt(now, goal),
            Input::Stop(leaf) => {
                self.stop_waiting(|waiting| waiting == leaf);
                self.stop(now, leaf, End::Canceled);
            }
            Input::Mission(mission) => {
                if mission.names.objects.len() != self.mission.names.objects.len() {
                    self.labels = Labels::new(&mission.names);
                }
                self.mission = mission;
            }
            Input::Woke => self.woke(now),
            Input::Shutdown => {
                self.is_ending = true;
                self.stop_waiting(|_| true);
                for leaf in self.goals.keys().copied().collect::<Vec<_>>() {
                    self.stop(now, leaf, End::Canceled);
                }
            }
        }
        if self.is_ending && !self.is_safe && self.queues.iter().all(CommandQueue::is_idle) {
            self.is_safe = true;
            self.effects.push(Effect::Safe);
        }
        std::mem::take(&mut self.effects)
    }

    /// When [`Input::Woke`] is due.
    pub fn deadline(&self) -> Option<Time> {
        let queues = self.queues.iter().filter_map(CommandQueue::deadline);
        let goals = self.goals.values().filter_map(Running::deadline);
        let attachments = self.attachments.iter().filter_map(Attachment::deadline);
        queues.chain(goals).chain(attachments).chain(self.next_report()).min()
    }

    fn attached(&mut self, now: Time, id: ControllerId) {
        self.record(now, id, ControllerMessage::Attached);
        self.configure(now, id);
    }

    fn configure(&mut self, now: Time, id: ControllerId) {
        let Some(generation) = self.attachments[id.index()].attach(now + self.limits.accept) else {
            self.lost(now, id, Loss::Unanswered);
            self.effects.push(Effect::Reset(id));
            return;
        };
        let start = self.states[id.index()];
        let limits = self.mission.robot.controllers[id.index()].kind;
        let configure = ToController::Configure { generation, speed: self.limits.speed, limits, start };
        self.tell(now, id, None, configure);
    }

    fn heard(&mut self, now: Time, id: ControllerId, message: FromController) {
        let is_known = match &message {
            FromController::Configured { generation, .. } => self.attachments[id.index()].expects(*generation),
            FromController::Accepted { id: command, .. }
            | FromController::Rejected { id: command, .. }
            | FromController::Feedback { id: command, .. }
            | FromController::Result { id: command, .. } => self.queues[id.index()].knows(*command),
        };
        if !is_known {
            self.record(now, id, ControllerMessage::Refused { id: message.id(), why: Rejection::Stale });
            return;
        }
        if !self.is_credible(id, &message) {
            let (command, is_last) = (message.id(), message.is_last());
            self.refused(now, id, Refusal { id: command, why: Rejection::Malformed, is_last });
            return;
        }
        self.record(now, id, ControllerMessage::Heard { message: message.clone() });
        if let Some(state) = message.state() {
            self.states[id.index()] = state.at_rest();
        }
        match message {
            FromController::Configured { state, .. } => self.configured(now, id, state),
            FromController::Accepted { .. } => self.queues[id.index()].accepted(),
            FromController::Rejected { why, .. } => self.rejected(now, id, why),
            FromController::Feedback { state, .. } => self.observe(state),
            FromController::Result { end, state, .. } => self.part_ended(now, id, end, state),
        }
    }

    fn is_credible(&self, id: ControllerId, message: &FromController) -> bool {
        message.state().is_none_or(|state| attachment::is_credible(&self.mission, id, &state))
    }

    /// What was said cannot be used. If it was the last word on a command, the goal fails at once.
    fn refused(&mut self, now: Time, id: ControllerId, refusal: Refusal) {
        self.record(now, id, ControllerMessage::Refused { id: refusal.id, why: refusal.why });
        let is_over = refusal.is_last && refusal.id.is_some_and(|command| self.queues[id.index()].knows(command));
        if is_over && refusal.why == Rejection::NoSuchName {
            // It holds something, whatever the goal came to: it is not to be used before it holds what is known.
            self.gone(now, id, Loss::HoldsUnknown, End::Failed(Fault::Refused(id, refusal.why)));
            self.effects.push(Effect::Reset(id));
        } else if is_over {
            self.drop_current(now, id, End::Failed(Fault::Refused(id, refusal.why)));
        }
    }

    fn observe(&mut self, state: ControllerState) {
        self.effects.extend(state.changes([]).into_iter().map(Effect::Observed));
    }

    fn configured(&mut self, now: Time, id: ControllerId, state: ControllerState) {
        self.attachments[id.index()].configured(state);
        self.effects.push(Effect::Configured(id));
        if self.drops.is_letting_go(id) {
            self.let_go(now, id, Some(state));
        } else if self.is_ready {
            let changes = state.changes(self.mission.robot.moved_by(id));
            self.effects.push(Effect::Returned(id, changes));
        } else {
            self.check_ready();
            self.pass_on(now);
        }
    }

    fn check_ready(&mut self) {
        if self.is_ready || !self.attachments.iter().all(Attachment::is_ready) {
            return;
        }
        self.is_ready = true;
        let robot = &self.mission.robot;
        let said = self.attachments.iter().enumerate().filter_map(|(index, attachment)| {
            let moved = robot.moved_by(ControllerId::from(index));
            attachment.state().map(|state| state.changes(moved))
        });
        let said = said.flatten().collect();
        self.effects.push(Effect::Ready(said));
    }

    fn lost(&mut self, now: Time, id: ControllerId, why: Loss) {
        // That it is inhibited it says in its results and in each of its pulses.
        if !(why.is_inhibition() && self.attachments[id.index()].loss() == Some(why)) {
            self.gone(now, id, why, loses(id, why));
        }
    }

    /// It says that it may not move, as the end of its command or instead of beginning it.
    fn inhibited(&mut self, now: Time, id: ControllerId, why: Inhibition) {
        self.gone(now, id, Loss::Inhibited(why), End::Interrupted);
        self.effects.push(Effect::Reset(id));
    }

    /// A controller is away; what it was doing ends so.
    fn gone(&mut self, now: Time, id: ControllerId, why: Loss, end: End) {
        self.attachments[id.index()].lose(why);
        self.record(now, id, ControllerMessage::Lost { why });
        // Before the ends that follow from it, so that nothing is granted what is away.
        self.effects.push(if self.is_ready { Effect::Lost(id, why) } else { Effect::Missing(id) });
        self.queue_lost(now, id, loses(id, why), end);
        self.forget_reports(id);
        self.let_go(now, id, None);
    }

    /// It does what nobody wants of it any more, so that it is not to be used before it is configured anew.
    fn hang(&mut self, now: Time, id: ControllerId, end: End) {
        self.gone(now, id, Loss::Hung, end);
        self.effects.push(Effect::Reset(id));
    }

    fn tell(&mut self, now: Time, id: ControllerId, leaf: Option<NodeId>, message: ToController) {
        self.record(now, id, ControllerMessage::Told { leaf, message: message.clone() });
        self.effects.push(Effect::Tell(id, message));
    }

    /// Sends a command with a new identity.
    fn send(&mut self, now: Time, id: ControllerId, leaf: NodeId, part: &Part) -> CommandId {
        let command = self.attachments[id.index()].next_command();
        let message = ToController::Goal { id: command, mode: part.mode, command: part.command.clone() };
        self.tell(now, id, Some(leaf), message);
        command
    }

    fn record(&mut self, at: Time, controller: ControllerId, message: ControllerMessage) {
        self.effects.push(Effect::Record(Record::Controller { at, controller, message }));
    }
}

/// How what needs a controller ends that is away: to be inhibited is no failure.
fn loses(id: ControllerId, why: Loss) -> End {
    if why.is_inhibition() { End::Interrupted } else { End::Failed(Fault::Lost(id)) }
}
