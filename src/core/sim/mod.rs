//! A mission under a virtual clock: the same nodes, dispatch, sessions and controller motion, no processes, no threads.

mod chance;
mod plant;

use std::collections::VecDeque;
use std::sync::Arc;

use crate::dispatch::{self, Dispatch, Limits, Script};
use crate::replay::Resumed;
use crate::tree::{Effect, Input, Machines, Outbox, Settings};
use ambidex_model::motion::{self, STEP};
use ambidex_model::session::Attendance;
use ambidex_model::{
    Change, ControllerId, Failures, Goal, Inhibition, Labels, Loss, Mishap, MissionEnd, MissionSpec, NodeId, Origin,
    Record, Time, ToController, Told, Work,
};
pub use chance::Chance;
use chance::Draws;
pub use plant::Body;
use plant::Plant;

/// What happens besides the mission, at a moment of robot time.
#[derive(Debug, Clone, PartialEq)]
pub enum Event {
    /// A controller attaches; without any such event all do at the beginning, in the order of the robot file.
    Attach(ControllerId),
    /// The process of a controller ends.
    Lose(ControllerId),
    /// The process of a controller is there and does nothing any more.
    Hang(ControllerId),
    /// A controller comes to be inhibited.
    Inhibit(ControllerId, Inhibition),
    /// A lost controller is started again, one that hangs goes on, one that is inhibited may move again.
    Return(ControllerId),
    /// The world changes from outside.
    World(Change, Origin),
    /// Somebody asks for work.
    Work(Work),
    /// The mission is told to end.
    Cancel,
}

impl Event {
    /// What a mishap is here; none of one that is about the log.
    fn of(mishap: Mishap) -> Option<Self> {
        Some(match mishap {
            Mishap::Lose(id) => Self::Lose(id),
            Mishap::Hang(id) => Self::Hang(id),
            Mishap::Inhibit(id) => Self::Inhibit(id, Inhibition::EmergencyStop),
            Mishap::Return(id) => Self::Return(id),
            Mishap::World(change) => Self::World(change, Origin::Script),
            Mishap::Cancel => Self::Cancel,
            Mishap::Disk(_) => return None,
        })
    }
}

/// A message on its way. None is handled within another: what one causes waits behind those that came before.
#[derive(Debug)]
enum Delivery {
    Node(NodeId, Input),
    Dispatch(dispatch::Input),
    Controller(ControllerId, ToController),
}

/// A mission with everything that carries it.
struct Simulation<'a> {
    nodes: Machines,
    has_messages: bool,
    dispatch: Dispatch,
    plants: Vec<Plant>,
    deliveries: VecDeque<Delivery>,
    events: VecDeque<(Time, Event)>,
    now: Time,
    has_begun: bool,
    end: Option<MissionEnd>,
    /// Since nothing can happen any more.
    is_told_to_end: bool,
    is_safe: bool,
    /// What goes wrong by chance.
    draws: Option<Draws>,
    journal: &'a mut dyn FnMut(&Record),
}

/// Runs a mission to its end and writes every record to `journal`.
pub fn simulate(
    mission: &Arc<MissionSpec>,
    settings: &Settings,
    events: Vec<(Time, Event)>,
    journal: &mut dyn FnMut(&Record),
) -> MissionEnd {
    simulate_bodies(mission, settings, bodies(mission), events, journal)
}

/// The same with controllers of your own, by controller.
pub fn simulate_bodies(
    mission: &Arc<MissionSpec>,
    settings: &Settings,
    bodies: Vec<Body>,
    events: Vec<(Time, Event)>,
    journal: &mut dyn FnMut(&Record),
) -> MissionEnd {
    Simulation::fresh(mission, settings, bodies, events, journal).run().0
}

/// Runs a mission in which things go wrong on purpose.
pub fn simulate_failures(
    mission: &Arc<MissionSpec>,
    settings: &Settings,
    failures: &Failures,
    journal: &mut dyn FnMut(&Record),
) -> MissionEnd {
    disturbed(mission, settings, failures, journal).run().0
}

/// Runs a mission in which something goes wrong by chance: in each attempt of a behavior with this probability.
///
/// What went wrong is in the result. With that, [`simulate_failures`] writes the same records; `failures` go wrong
/// besides, and stand in it too.
pub fn simulate_chance(
    mission: &Arc<MissionSpec>,
    settings: &Settings,
    failures: &Failures,
    chance: Chance,
    journal: &mut dyn FnMut(&Record),
) -> (MissionEnd, Failures) {
    let mut simulation = disturbed(mission, settings, failures, journal);
    simulation.draws = Some(Draws::new(mission, chance, failures.clone()));
    let (end, draws) = simulation.run();
    (end, draws.map(Draws::into_failures).unwrap_or_default())
}

fn disturbed<'a>(
    mission: &Arc<MissionSpec>,
    settings: &Settings,
    failures: &Failures,
    journal: &'a mut dyn FnMut(&Record),
) -> Simulation<'a> {
    // Attached first, also where something goes wrong at once.
    let mishaps = failures.mishaps.iter().filter_map(|(at, mishap)| Some((*at, Event::of(*mishap)?)));
    let events = all_attach(Time::ZERO, mission.robot.controllers.len()).chain(mishaps).collect();
    let mut simulation = Simulation::fresh(mission, settings, bodies(mission), events, journal);
    simulation.dispatch.follow(Script::new(failures.flaws.clone()));
    simulation
}

/// Goes on with a mission as a log leaves it; what is written to `journal` belongs behind that log.
pub fn resume(mission: &Arc<MissionSpec>, mut resumed: Resumed, journal: &mut dyn FnMut(&Record)) -> MissionEnd {
    std::mem::take(&mut resumed.missing).iter().for_each(&mut *journal);
    if let Some(end) = resumed.end {
        return end;
    }
    Simulation::new(resumed, bodies(mission), Vec::new(), journal).run().0
}

fn bodies(mission: &MissionSpec) -> Vec<Body> {
    mission.robot.controllers.iter().map(|spec| motion::simulated(&spec.kind)).collect()
}

fn all_attach(at: Time, controllers: usize) -> impl Iterator<Item = (Time, Event)> {
    (0..controllers).map(move |index| (at, Event::Attach(ControllerId::from(index))))
}

impl<'a> Simulation<'a> {
    fn fresh(
        mission: &Arc<MissionSpec>,
        settings: &Settings,
        bodies: Vec<Body>,
        events: Vec<(Time, Event)>,
        journal: &'a mut dyn FnMut(&Record),
    ) -> Self {
        journal(&Record::Header(Box::new(settings.header(mission))));
        Self::new(Resumed::fresh(mission, settings), bodies, events, journal)
    }

    fn new(
        begun: Resumed,
        bodies: Vec<Body>,
        mut events: Vec<(Time, Event)>,
        journal: &'a mut dyn FnMut(&Record),
    ) -> Self {
        if !events.iter().any(|(_, event)| matches!(event, Event::Attach(_))) {
            events.extend(all_attach(begun.at, bodies.len()));
        }
        events.sort_by_key(|(at, _)| *at);
        let mission = Arc::clone(begun.nodes.root().mission());
        let labels = Arc::new(Labels::new(&mission.names));
        Self {
            has_messages: begun.nodes.root().has_messages(),
            nodes: begun.nodes,
            dispatch: Dispatch::new(&mission, begun.controllers, Limits::at_speed(1.0)),
            plants: bodies.into_iter().map(|body| Plant::new(body, &labels)).collect(),
            deliveries: VecDeque::new(),
            events: events.into(),
            now: begun.at,
            has_begun: false,
            end: None,
            is_told_to_end: false,
            is_safe: false,
            draws: None,
            journal,
        }
    }

    /// How it ended, and what went wrong by chance.
    fn run(mut self) -> (MissionEnd, Option<Draws>) {
        let end = self.go_on();
        (end, self.draws)
    }

    fn go_on(&mut self) -> MissionEnd {
        if self.plants.is_empty() {
            self.begin(Vec::new());
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
                if let Some(end) = self.end {
                    return end;
                }
                // Nothing moves, nothing is due: whoever waits for the world waits for one in which nothing happens.
                let end = if self.has_begun { MissionEnd::Stalled } else { MissionEnd::NotAttached };
                if std::mem::replace(&mut self.is_told_to_end, true) {
                    return end;
                }
                self.tell_root(Told::End { end });
            }
        }
    }

    fn happen(&mut self, event: Event) {
        match event {
            Event::Attach(id) | Event::Return(id) => {
                self.plants[id.index()].start();
                self.exchange(id, None);
            }
            Event::Lose(id) => {
                self.plants[id.index()].end();
                self.exchange(id, None);
            }
            Event::Hang(id) => self.plants[id.index()].hang(),
            Event::Inhibit(id, why) => {
                self.plants[id.index()].inhibit(why);
                self.exchange(id, None);
            }
            Event::World(change, origin) => self.tell_root(Told::World { change, origin }),
            Event::Work(work) => self.tell_root(Told::Work { work }),
            Event::Cancel => self.tell_root(Told::End { end: MissionEnd::Canceled }),
        }
    }

    /// Delivers messages until nobody has any left.
    fn come_to_rest(&mut self) {
        while let Some(delivery) = self.deliveries.pop_front() {
            match delivery {
                Delivery::Node(node, input) => {
                    self.handle(node, input);
                    // Whatever came before it is part of the turn.
                    while self.nodes.root().wants_turn() && !self.has_any_for_root() {
                        self.handle(NodeId(0), Input::Turn);
                    }
                }
                Delivery::Dispatch(input) => {
                    for effect in self.dispatch.handle(self.now, input) {
                        self.carry_dispatch(effect);
                    }
                }
                Delivery::Controller(id, message) => self.exchange(id, Some(message)),
            }
        }
    }

    fn handle(&mut self, node: NodeId, input: Input) {
        let mut out = Outbox::default();
        self.nodes.handle(self.now, node, input, &mut out);
        for effect in out.drain() {
            if let Some(effect) = self.nodes.change(effect) {
                self.carry(node, effect);
            }
        }
    }

    fn has_any_for_root(&self) -> bool {
        self.deliveries.iter().any(|delivery| matches!(delivery, Delivery::Node(NodeId(0), _)))
    }

    fn carry(&mut self, from: NodeId, effect: Effect) {
        let parent = self.nodes.parent(from);
        if self.has_messages
            && let Some(record) = effect.message(self.now, from, parent)
        {
            (self.journal)(&record);
        }
        match effect {
            Effect::Down(to, down) => self.deliveries.push_back(Delivery::Node(to, Input::Down(down))),
            Effect::Up(up) => {
                self.deliveries.push_back(Delivery::Node(parent, Input::Up(up)));
            }
            Effect::Start(goal) => {
                self.draw(&goal);
                self.tell_dispatch(dispatch::Input::Start(goal));
            }
            Effect::Stop(leaf) => self.tell_dispatch(dispatch::Input::Stop(leaf)),
            // Nobody waits for it here; the log has it.
            Effect::TakenUp(..) | Effect::Worked(..) => {}
            Effect::Mission(mission) => self.tell_dispatch(dispatch::Input::Mission(mission)),
            Effect::Spawn { .. } | Effect::Retire { .. } => unreachable!("nodes came and went"),
            Effect::Record(record) => (self.journal)(&record),
            Effect::Finished(end) => {
                if self.end.is_none() {
                    self.end = Some(end);
                    self.tell_dispatch(dispatch::Input::Shutdown);
                }
            }
        }
    }

    /// What goes wrong by chance in the attempt that begins.
    fn draw(&mut self, goal: &Goal) {
        let Some(draws) = &mut self.draws else { return };
        let drawn = draws.draw(self.now, goal, self.nodes.root().state().world());
        drawn.flaw.into_iter().for_each(|flaw| self.dispatch.mar(flaw));
        for (at, mishap) in drawn.mishaps {
            let behind = self.events.partition_point(|(other, _)| *other <= at);
            if let Some(event) = Event::of(mishap) {
                self.events.insert(behind, (at, event));
            }
        }
    }

    fn carry_dispatch(&mut self, effect: dispatch::Effect) {
        match effect {
            dispatch::Effect::Tell(id, message) => self.deliveries.push_back(Delivery::Controller(id, message)),
            dispatch::Effect::Ready(said) => self.begin(said),
            dispatch::Effect::Ended(leaf, outcome) => {
                self.deliveries.push_back(Delivery::Node(leaf, Input::Ended(Box::new(outcome))));
            }
            dispatch::Effect::Dropped(change) => {
                self.tell_root(Told::World { change, origin: Origin::Dropped });
            }
            dispatch::Effect::Reported(id, change) => {
                self.tell_root(Told::World { change, origin: Origin::Controller(id) });
            }
            dispatch::Effect::Observed(change) => {
                self.deliveries.push_back(Delivery::Node(NodeId(0), Input::Observed(change)));
            }
            dispatch::Effect::Lost(controller, why) => {
                self.tell_root(Told::Service { controller, outage: Some(why), changes: Vec::new() });
            }
            dispatch::Effect::Returned(controller, changes) => {
                self.tell_root(Told::Service { controller, outage: None, changes });
            }
            dispatch::Effect::Configured(_) | dispatch::Effect::Missing(_) => {}
            dispatch::Effect::Reset(id) => {
                self.plants[id.index()].reset();
                self.exchange(id, None);
            }
            dispatch::Effect::Safe => self.is_safe = true,
            dispatch::Effect::Record(record) => (self.journal)(&record),
        }
    }

    fn begin(&mut self, said: Vec<Change>) {
        self.has_begun = true;
        self.tell_root(Told::Begin { changes: said });
    }

    fn tell_root(&mut self, told: Told) {
        self.deliveries.push_back(Delivery::Node(NodeId(0), told.into()));
    }

    fn tell_dispatch(&mut self, input: dispatch::Input) {
        self.deliveries.push_back(Delivery::Dispatch(input));
    }

    /// Brings a controller to this moment; what comes of it is delivered in turn.
    fn exchange(&mut self, id: ControllerId, message: Option<ToController>) {
        let exchanged = self.plants[id.index()].exchange(self.now, message);
        for heard in exchanged.heard {
            self.tell_dispatch(match heard {
                Ok(message) => dispatch::Input::Heard(id, message),
                Err(refusal) => dispatch::Input::Refused(id, refusal),
            });
        }
        for report in exchanged.reports {
            self.tell_dispatch(dispatch::Input::Reported(id, report));
        }
        match exchanged.attendance {
            Some(Attendance::Attached { .. }) => self.tell_dispatch(dispatch::Input::Attached(id)),
            Some(Attendance::Inhibited { why, .. }) => {
                self.tell_dispatch(dispatch::Input::Lost(id, Loss::Inhibited(why)));
            }
            Some(Attendance::Lost(why)) => self.tell_dispatch(dispatch::Input::Lost(id, why)),
            None => {}
        }
    }

    /// Moves the clock to the next moment at which something can happen; false if there is none.
    fn advance(&mut self) -> bool {
        let is_moving = self.plants.iter().any(Plant::is_moving);
        let step = is_moving.then(|| next_step(self.now));
        let event = self.events.front().map(|(at, _)| *at);
        let silence = self.plants.iter().filter_map(Plant::silent_at).min();
        let waits = self.nodes.root().deadline();
        let Some(next) = [step, self.dispatch.deadline(), event, silence, waits].into_iter().flatten().min() else {
            return false;
        };
        self.now = next.max(self.now);
        for index in 0..self.plants.len() {
            let plant = &self.plants[index];
            let is_due =
                plant.is_moving() && step == Some(self.now) || plant.silent_at().is_some_and(|at| at <= self.now);
            if is_due {
                self.exchange(ControllerId::from(index), None);
                self.come_to_rest();
            }
        }
        if self.dispatch.deadline().is_some_and(|due| due <= self.now) {
            self.tell_dispatch(dispatch::Input::Woke);
        }
        if self.nodes.root().deadline().is_some_and(|due| due <= self.now) {
            self.tell_root(Told::Woke);
        }
        true
    }
}

/// The next moment of the grid on which all controllers move.
fn next_step(now: Time) -> Time {
    let step_us = STEP.as_micros() as u64;
    Time((now.0 / step_us + 1) * step_us)
}
