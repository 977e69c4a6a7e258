//! A run once more from what its log says that root was told, with every decision compared: the same machines, one
//! message after the other, no controllers.

use std::collections::VecDeque;
use std::sync::Arc;

use crate::dispatch::{LastKnown, at_start};
use crate::tree::{BranchReader, Effect, Input, Machines, Outbox, Root, Settings};
use ambidex_model::state::{Saved, Stage};
use ambidex_model::{
    Change, ControllerId, ControllerMessage, Header, Location, MissionEnd, MissionSpec, NodeId, Record, Time,
    ToController, Told,
};

/// A log that is taken record by record, the header first.
pub struct Replay {
    header: Header,
    nodes: Machines,
    mission: Arc<MissionSpec>,
    settings: Settings,
    places: usize,
    reader: Option<BranchReader>,
    /// What root made and the log has not told yet.
    made: VecDeque<Record>,
    /// What the last turn came to, with messages; none where that is not asked for.
    turn: Option<Vec<Record>>,
    /// From whom messages are wanted, by node.
    wanted: Vec<bool>,
    inbox: VecDeque<(NodeId, Input)>,
    told_to_end: Vec<MissionEnd>,
    /// The end that the log tells and root did not.
    ended: Option<MissionEnd>,
    decisions: u64,
    /// What controllers said of themselves last, and how often they had attached.
    controllers: Vec<LastKnown>,
    at: Time,
}

/// A run as its log leaves it, to go on from there.
#[derive(Debug)]
pub struct Resumed {
    /// The machines; what runs in their eyes ends when the mission goes on.
    pub nodes: Machines,
    /// What controllers said of themselves last and how often they had attached, by controller.
    pub controllers: Vec<LastKnown>,
    /// The last moment of the log.
    pub at: Time,
    /// What follows from the log and is not in it: its writer was killed before it came to that; and that it goes on.
    pub missing: Vec<Record>,
    /// How it ended, if it has: then nothing goes on.
    pub end: Option<MissionEnd>,
}

/// What was saved of a run is not of its mission, or cannot be read any more.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Unrestored;

/// A record of the log that does not follow from those before it.
#[derive(Debug, Clone, PartialEq)]
pub struct Difference {
    /// What the log says; none where it goes on without what follows.
    pub found: Option<Box<Record>>,
    /// What follows; none where nothing does, or the log tells of what its mission does not have.
    pub expected: Option<Box<Record>>,
}

impl Resumed {
    /// A run that begins with nothing behind it.
    pub fn fresh(mission: &Arc<MissionSpec>, settings: &Settings) -> Self {
        Self {
            nodes: Machines::new(mission, settings),
            controllers: at_start(mission),
            at: Time::ZERO,
            missing: Vec::new(),
            end: None,
        }
    }
}

impl Replay {
    /// Before the first turn of a mission that was run as its log's header says.
    pub fn new(mission: &Arc<MissionSpec>, settings: &Settings) -> Self {
        Self {
            header: settings.header(mission),
            nodes: Machines::new(mission, settings),
            mission: Arc::clone(mission),
            settings: settings.clone(),
            places: mission.world.places.len(),
            reader: None,
            made: VecDeque::new(),
            turn: None,
            wanted: Vec::new(),
            inbox: VecDeque::new(),
            told_to_end: Vec::new(),
            ended: None,
            decisions: 0,
            controllers: at_start(mission),
            at: Time::ZERO,
        }
    }

    /// The same, which reads with this what was submitted.
    #[must_use]
    pub fn reading(self, reader: BranchReader) -> Self {
        Self { reader: Some(reader), ..self }
    }

    /// The same, which gives with every turn why all else does not run, and what the `wanted` nodes say.
    pub fn with_messages(mission: &Arc<MissionSpec>, settings: &Settings, wanted: Vec<bool>) -> Self {
        let telling = Settings { has_messages: true, ..settings.clone() };
        let header = settings.header(mission);
        Self { header, turn: Some(Vec::new()), wanted, ..Self::new(mission, &telling) }
    }

    /// Goes on from where a run was saved, before anything else than its header and what controllers said last.
    ///
    /// # Errors
    /// When what was saved is not of this mission, or cannot be read any more.
    pub fn restore(&mut self, saved: &Saved) -> Result<(), Unrestored> {
        let restored = Machines::restored(&self.mission, &self.settings, saved, self.reader.as_ref());
        self.nodes = restored.ok_or(Unrestored)?;
        Ok(())
    }

    /// Root as it is after what was taken.
    pub fn root(&self) -> &Root {
        self.nodes.root()
    }

    /// How many decisions were compared.
    pub fn decisions(&self) -> u64 {
        self.decisions
    }

    /// Takes the next record of the log.
    ///
    /// # Errors
    /// When it does not follow from those before it.
    pub fn take(&mut self, record: &Record) -> Result<(), Difference> {
        self.at = self.at.max(record.at());
        match record {
            Record::Header(header) if **header != self.header => {
                let expected = Record::Header(Box::new(self.header.clone()));
                Err(Difference { found: Some(Box::new(record.clone())), expected: Some(Box::new(expected)) })
            }
            Record::Header(_) | Record::Sent { .. } => Ok(()),
            // Whoever reads text as records reads this one too, and says what it holds.
            Record::Checkpoint { .. } => Ok(()),
            Record::Controller { controller, message, .. } => {
                self.hear(*controller, message);
                Ok(())
            }
            Record::Told { at, input } => self.told(*at, input, record),
            Record::Turn { at } => match self.made.pop_front() {
                Some(expected) => Err(Difference { found: None, expected: Some(Box::new(expected)) }),
                None => {
                    self.give(*at, NodeId(0), Input::Turn);
                    Ok(())
                }
            },
            // It comes before its turn, of which it is made.
            Record::Observed { change, .. } => {
                if !matches!(change, Change::Base(_)) {
                    return Err(Difference { found: Some(Box::new(record.clone())), expected: None });
                }
                let observed = Input::Observed(*change);
                self.nodes.handle(record.at(), NodeId(0), observed, &mut Outbox::default());
                Ok(())
            }
            // Not all ends are root's word: a defect ends a mission without it, and so does a grace that is over.
            Record::Ended { end, .. } if self.is_without_root(*end) => {
                self.ended = Some(*end);
                Ok(())
            }
            Record::Began { .. } | Record::Stopped { .. } => self.compare(record),
            Record::World { .. } | Record::Denied { .. } => self.compare(record),
            Record::Woke { .. } | Record::Served { .. } | Record::Awaited { .. } => self.compare(record),
            Record::Infeasible { .. } | Record::TimedOut { .. } => self.compare(record),
            Record::Ending { .. } | Record::Cleaning { .. } | Record::Cleaned { .. } | Record::Leaving { .. } => {
                self.compare(record)
            }
            Record::Reopened { .. } | Record::Overtaken { .. } => self.compare(record),
            Record::Decided { .. } | Record::Released { .. } | Record::Resource { .. } => self.compare(record),
            Record::Added { .. } | Record::Removed { .. } | Record::Granting { .. } => self.compare(record),
            Record::Canceled { .. } | Record::TaskEnded { .. } | Record::Stalled { .. } => self.compare(record),
            Record::ObjectAdded { .. } | Record::ObjectRemoved { .. } | Record::Declined { .. } => self.compare(record),
            Record::Ended { .. } => self.compare(record),
        }
    }

    fn told(&mut self, at: Time, input: &Told, record: &Record) -> Result<(), Difference> {
        let is_known = self.root().state().knows_of(input) && self.has_places_of(input);
        let Some(input) = is_known.then(|| self.read(input)).flatten() else {
            return Err(Difference { found: Some(Box::new(record.clone())), expected: None });
        };
        let input = &input;
        if let Told::End { end } = input {
            self.told_to_end.push(*end);
        }
        // With its message from the behavior up to root, where messages are wanted.
        match input {
            Told::Ended { leaf, outcome } if self.turn.is_some() => {
                self.give(at, *leaf, Input::Ended(Box::new(outcome.clone())));
            }
            other => self.give(at, NodeId(0), other.clone().into()),
        }
        Ok(())
    }

    /// What the last turn came to, with its messages; nothing where there was none since this was asked last.
    pub fn take_turn(&mut self) -> Vec<Record> {
        self.turn.as_mut().map(std::mem::take).unwrap_or_default()
    }

    /// The run as the log leaves it. Where it is not over, root is told that it goes on, which the log then lacks too.
    pub fn finish(mut self) -> Resumed {
        let end = match self.root().state().stage() {
            Stage::Over(end) => Some(end),
            Stage::Waiting | Stage::Running => self.ended,
        };
        let mut missing: Vec<Record> = self.made.drain(..).collect();
        // They stand behind what the log has, which may be of a later moment than their turn.
        for record in missing.iter_mut().filter(|record| record.at() < self.at) {
            record.set_at(self.at);
        }
        if end.is_none() {
            missing.push(Record::Told { at: self.at, input: Told::Resumed });
            self.give(self.at, NodeId(0), Told::Resumed.into());
        }
        Resumed { nodes: self.nodes, controllers: self.controllers, at: self.at, missing, end }
    }

    /// What root was told, with the parts of trees that come with it read once more; none where they cannot be.
    fn read(&self, told: &Told) -> Option<Told> {
        let mut told = told.clone();
        if let Told::Work { work } = &mut told
            && let Some(branch) = work.branch_mut()
            && branch.fragment.is_none()
        {
            let (reader, root) = (self.reader.as_ref()?, self.nodes.root());
            branch.fragment = Some(Arc::new(reader(&branch.source, root.mission(), root.state().world())?));
        }
        Some(told)
    }

    fn has_places_of(&self, told: &Told) -> bool {
        let changes = match told {
            Told::Begin { changes } => changes.as_slice(),
            Told::World { change, .. } => std::slice::from_ref(change),
            Told::Ended { outcome, .. } => &outcome.changes,
            Told::Service { changes, .. } => changes,
            Told::Resumed | Told::Woke | Told::Work { .. } | Told::End { .. } => &[],
        };
        let is_nowhere = |change: &Change| match change.moved() {
            Some((_, Some(Location::At(at)))) => at.index() >= self.places,
            Some(_) | None => false,
        };
        !changes.iter().any(is_nowhere)
    }

    fn is_without_root(&self, end: MissionEnd) -> bool {
        matches!(end, MissionEnd::NodeLost(_) | MissionEnd::TaskLost)
            || self.made.is_empty() && self.told_to_end.contains(&end)
    }

    fn hear(&mut self, controller: ControllerId, message: &ControllerMessage) {
        let Some(known) = self.controllers.get_mut(controller.index()) else { return };
        match message {
            ControllerMessage::Heard { message } => {
                known.state = message.state().map_or(known.state, |said| said.at_rest())
            }
            ControllerMessage::Told { message: ToController::Configure { generation, .. }, .. } => {
                known.generation = known.generation.max(*generation);
            }
            ControllerMessage::Attached | ControllerMessage::Told { .. } | ControllerMessage::Joined { .. } => {}
            ControllerMessage::Refused { .. } | ControllerMessage::Misreported { .. } => {}
            ControllerMessage::Lost { .. } | ControllerMessage::Diagnosed { .. } => {}
        }
    }

    fn compare(&mut self, found: &Record) -> Result<(), Difference> {
        let Some(mut expected) = self.made.pop_front() else {
            return Err(Difference { found: Some(Box::new(found.clone())), expected: None });
        };
        // When an answer came up is no part of what follows, and why all else does not run the log may have left out.
        expected.set_at(found.at());
        if self.turn.is_some() && found.refusals().is_empty() {
            expected.forget_refusals();
        }
        if expected != *found {
            return Err(Difference { found: Some(Box::new(found.clone())), expected: Some(Box::new(expected)) });
        }
        self.decisions += u64::from(matches!(found, Record::Decided { .. }));
        Ok(())
    }

    fn give(&mut self, at: Time, to: NodeId, input: Input) {
        let mut out = Outbox::default();
        self.inbox.push_back((to, input));
        while let Some((node, input)) = self.inbox.pop_front() {
            self.nodes.handle(at, node, input, &mut out);
            let parent = self.nodes.parent(node);
            for effect in out.drain().filter_map(|effect| self.nodes.change(effect)).collect::<Vec<_>>() {
                if let Some(turn) = &mut self.turn
                    && self.wanted.get(node.index()).copied().unwrap_or(true)
                    && let Some(message) = effect.message(at, node, parent)
                {
                    turn.push(message);
                }
                match effect {
                    Effect::Down(to, down) => self.inbox.push_back((to, Input::Down(down))),
                    Effect::Up(up) => self.inbox.push_back((parent, Input::Up(up))),
                    Effect::Record(record) => self.make(*record),
                    Effect::Start(_) | Effect::Stop(_) | Effect::TakenUp(..) | Effect::Finished(_) => {}
                    Effect::Worked(..) | Effect::Mission(_) => {}
                    Effect::Spawn { .. } | Effect::Retire { .. } => unreachable!("nodes came and went"),
                }
            }
        }
    }

    fn make(&mut self, record: Record) {
        if record.follows() {
            if let Some(turn) = &mut self.turn {
                turn.push(record.clone());
            }
            self.made.push_back(record);
        }
    }
}
