//! A mission under a virtual clock: the same nodes, dispatch and controller motion, no processes, no threads.

use std::collections::VecDeque;

use crate::dispatch::{self, Dispatch, Limits};
use crate::tree::{self, Begin, Effect, Input, Node, Outbox, Settings};
use ambidex_model::motion::{self, Controller, Executor, STEP};
use ambidex_model::{
    Change, ControllerId, FromController, Header, MissionEnd, MissionSpec, NodeId, Record, Situation, Time,
    ToController,
};

/// A controller of the fake plant.
type Plant = Executor<Box<dyn Controller + Send>>;

/// Robot time between two feedbacks of a command, microseconds.
const FEEDBACK_EVERY_US: u64 = 100_000;

/// What happens besides the mission, at a moment of robot time.
#[derive(Debug, Clone, PartialEq)]
pub enum Event {
    /// A controller attaches; without any such event all do at the beginning, in the order of the robot file.
    Attach(ControllerId),
    /// A controller is gone.
    Lose(ControllerId),
    /// The world changes from outside.
    World(Change),
    /// The mission is told to end.
    Cancel,
}

/// A mission with everything that carries it.
pub struct Simulation<'a> {
    mission: &'a MissionSpec,
    nodes: Vec<Node>,
    dispatch: Dispatch,
    plants: Vec<Plant>,
    inbox: VecDeque<(NodeId, Input)>,
    events: VecDeque<(Time, Event)>,
    now: Time,
    end: Option<MissionEnd>,
    is_safe: bool,
    journal: &'a mut dyn FnMut(&Record),
}

/// Runs a mission to its end and writes every record to `journal`.
pub fn simulate(
    mission: &MissionSpec,
    settings: &Settings,
    events: Vec<(Time, Event)>,
    journal: &mut dyn FnMut(&Record),
) -> MissionEnd {
    Simulation::new(mission, settings, events, journal).run()
}

impl<'a> Simulation<'a> {
    fn new(
        mission: &'a MissionSpec,
        settings: &Settings,
        mut events: Vec<(Time, Event)>,
        journal: &'a mut dyn FnMut(&Record),
    ) -> Self {
        journal(&Record::Header(Box::new(Header::new(mission, settings.allocator.name()))));
        let controllers = &mission.robot.controllers;
        if !events.iter().any(|(_, event)| matches!(event, Event::Attach(_))) {
            let all = (0..controllers.len()).map(|index| (Time::ZERO, Event::Attach(ControllerId::from(index))));
            events.extend(all);
        }
        events.sort_by_key(|(at, _)| *at);
        Self {
            mission,
            nodes: tree::build(mission, settings),
            dispatch: Dispatch::new(mission, Limits::at_speed(1.0)),
            plants: controllers.iter().map(|spec| Executor::new(motion::simulated(&spec.kind))).collect(),
            inbox: VecDeque::new(),
            events: events.into(),
            now: Time::ZERO,
            end: None,
            is_safe: false,
            journal,
        }
    }

    fn run(mut self) -> MissionEnd {
        if self.plants.is_empty() {
            self.begin(self.mission.start.clone());
        }
        loop {
            self.come_to_rest();
            while self.events.front().is_some_and(|(at, _)| *at <= self.now) {
                if let Some((_, event)) = self.events.pop_front() {
                    self.happen(event);
                    self.come_to_rest();
                }
            }
            if self.is_safe {
                return self.end.expect("only an ended mission is made safe");
            }
            if !self.advance() {
                // Nothing moves, nothing is due: a mission that waits for a world in which nothing happens.
                return self.end.unwrap_or(MissionEnd::Stalled);
            }
        }
    }

    fn happen(&mut self, event: Event) {
        match event {
            Event::Attach(id) => self.dispatch(dispatch::Input::Attached(id)),
            Event::Lose(id) => self.dispatch(dispatch::Input::Lost(id)),
            Event::World(change) => self.inbox.push_back((NodeId(0), Input::World(change))),
            Event::Cancel => self.inbox.push_back((NodeId(0), Input::End(MissionEnd::Canceled))),
        }
    }

    /// Delivers messages until nobody has any left.
    fn come_to_rest(&mut self) {
        let mut out = Outbox::default();
        while let Some((node, input)) = self.inbox.pop_front() {
            self.nodes[node.index()].handle(self.now, input, &mut out);
            for effect in out.drain() {
                self.carry(node, effect);
            }
        }
    }

    fn carry(&mut self, from: NodeId, effect: Effect) {
        let topology = &self.mission.tree.topology;
        if let Some(record) = effect.message(self.now, from, topology) {
            (self.journal)(&record);
        }
        match effect {
            Effect::Down(to, down) => self.inbox.push_back((to, Input::Down(down))),
            Effect::Up(up) => self.inbox.push_back((topology.parent(from), Input::Up(from, up))),
            Effect::Start(goal) => self.dispatch(dispatch::Input::Start(goal)),
            Effect::Stop(leaf) => self.dispatch(dispatch::Input::Stop(leaf)),
            Effect::Record(record) => (self.journal)(&record),
            Effect::Finished(end) => self.finish(end),
        }
    }

    fn begin(&mut self, situation: Situation) {
        let begin = Box::new(Begin { situation });
        self.inbox.push_back((NodeId(0), Input::Begin(begin)));
    }

    fn finish(&mut self, end: MissionEnd) {
        if self.end.is_none() {
            self.end = Some(end);
            self.dispatch(dispatch::Input::Shutdown);
        }
    }

    fn dispatch(&mut self, input: dispatch::Input) {
        for effect in self.dispatch.handle(self.now, input) {
            match effect {
                dispatch::Effect::Tell(id, message) => self.tell(id, &message),
                dispatch::Effect::Ready(situation) => self.begin(situation),
                dispatch::Effect::Ended(leaf, outcome) => {
                    self.inbox.push_back((leaf, Input::Ended(Box::new(outcome))));
                }
                dispatch::Effect::Observed(change) => self.inbox.push_back((NodeId(0), Input::Observed(change))),
                // Before the ends that follow from it: root grants nothing for them.
                dispatch::Effect::Lost(id) => {
                    self.inbox.push_back((NodeId(0), Input::End(MissionEnd::ControllerLost(id))));
                }
                dispatch::Effect::Configured(_) => {}
                dispatch::Effect::Safe => self.is_safe = true,
                dispatch::Effect::Record(record) => (self.journal)(&record),
            }
        }
    }

    fn tell(&mut self, id: ControllerId, message: &ToController) {
        let plant = &mut self.plants[id.index()];
        let reply = match message {
            ToController::Configure { generation, limits, start, .. } => {
                let state = plant.configure(limits, *start);
                FromController::Configured { generation: *generation, state }
            }
            ToController::Goal { id, mode, command } => match plant.begin(*id, *mode, command, self.now) {
                Ok(()) => FromController::Accepted { id: *id, at: self.now },
                Err(why) => FromController::Rejected { id: *id, why },
            },
            ToController::Cancel { id } => {
                if plant.is_doing(*id) {
                    plant.cancel();
                }
                return;
            }
        };
        self.hear(id, reply);
    }

    fn hear(&mut self, id: ControllerId, message: FromController) {
        self.dispatch(dispatch::Input::Heard(id, message));
    }

    /// Moves the clock to the next moment at which something can happen; false if there is none.
    fn advance(&mut self) -> bool {
        let is_moving = self.plants.iter().any(Executor::is_busy);
        let step = is_moving.then(|| self.now + STEP);
        let event = self.events.front().map(|(at, _)| *at);
        let Some(next) = [step, self.dispatch.deadline(), event].into_iter().flatten().min() else {
            return false;
        };
        self.now = next.max(self.now);
        if step == Some(self.now) {
            self.step();
        }
        if self.dispatch.deadline().is_some_and(|due| due <= self.now) {
            self.dispatch(dispatch::Input::Woke);
        }
        true
    }

    fn step(&mut self) {
        let is_feedback_due = self.now.0.is_multiple_of(FEEDBACK_EVERY_US);
        for index in 0..self.plants.len() {
            let id = ControllerId::from(index);
            if !self.plants[index].is_busy() {
                continue;
            }
            let result = self.plants[index].step(self.now);
            let feedback = is_feedback_due.then(|| self.plants[index].feedback()).flatten();
            for message in feedback.into_iter().chain(result) {
                self.hear(id, message);
                self.come_to_rest();
            }
        }
    }
}
