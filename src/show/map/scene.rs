//! What a map shows: the world of a mission at some moment, and the drives that led there.

use std::str::FromStr;
use std::sync::Arc;

use ambidex_model::{
    Command, ControllerMessage, MissionSpec, Names, NodeId, Pose, Record, Time, ToController, WorldState,
};
use ambidex_record::History;

/// When a map is drawn of.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Moment {
    /// As a step of the run begins, counted from 1.
    Step(usize),
    /// Robot time.
    At(Time),
}

/// One drive of a run.
#[derive(Debug, Clone, PartialEq)]
pub struct Drive {
    /// In which step of the run it began, counted from 1.
    pub step: usize,
    /// The behavior that it was for.
    pub leaf: NodeId,
    /// Where it begins, and its way points; map frame.
    pub way: Vec<Pose>,
}

/// The world of a mission at a moment.
#[derive(Debug)]
pub struct Scene {
    /// Robot, places and obstacles.
    pub mission: Arc<MissionSpec>,
    /// The drives before that moment, in their order.
    pub drives: Vec<Drive>,
    history: Option<History>,
}

impl FromStr for Moment {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let seconds = text.strip_suffix('s').map(str::trim_end);
        let is_moment = |seconds: &f64| (0.0..=1e12).contains(seconds);
        let moment = match seconds {
            Some(seconds) => {
                let seconds = seconds.parse().ok().filter(is_moment);
                seconds.map(|seconds: f64| Self::At(Time((seconds * 1e6) as u64)))
            }
            None => text.parse().ok().filter(|step| *step > 0).map(Self::Step),
        };
        moment.ok_or_else(|| "a step, as `3`, counted from 1, or a time, as `12.5s`".to_owned())
    }
}

impl Scene {
    /// The world as a mission begins.
    pub fn new(mission: &Arc<MissionSpec>) -> Self {
        Self { mission: Arc::clone(mission), drives: Vec::new(), history: None }
    }

    /// What everything is called.
    pub fn names(&self) -> &Names {
        self.history.as_ref().map_or(&self.mission.names, History::names)
    }

    /// Where objects are.
    pub fn world(&self) -> &WorldState {
        self.history.as_ref().map_or(&self.mission.start, History::world)
    }

    /// Where the base is.
    pub fn base(&self) -> Pose {
        self.history.as_ref().map_or(self.mission.start.base, base)
    }

    /// When it is; none before a run.
    pub fn now(&self) -> Option<Time> {
        self.history.as_ref().map(History::now)
    }

    /// Takes the next record of a run of it; false once the moment has come.
    pub fn take(&mut self, record: &Record, until: Option<Moment>) -> bool {
        let Some(history) = &mut self.history else {
            if let Record::Header(header) = record {
                self.history = Some(History::new(header));
            }
            return true;
        };
        let begins_step = matches!(record, Record::Decided { granted, .. } if !granted.is_empty());
        let is_behind = match until {
            None => false,
            Some(Moment::Step(step)) => begins_step && history.step_count() + 1 >= step,
            Some(Moment::At(time)) => record.at() > time,
        };
        // A step has begun once it is decided; what comes after a time is not so yet.
        if is_behind && matches!(until, Some(Moment::At(_))) {
            return false;
        }
        history.apply(record);
        if let Record::Controller { message, .. } = record {
            self.drives.extend(drive(message, history));
        }
        !is_behind
    }

    /// How many steps the run has had so far.
    pub fn steps(&self) -> usize {
        self.history.as_ref().map_or(0, History::step_count)
    }
}

/// Where the base is by what its controller said last, else as the world has it.
fn base(history: &History) -> Pose {
    history.base().unwrap_or(history.world().base)
}

/// The drive that a message to a controller is about.
fn drive(message: &ControllerMessage, history: &History) -> Option<Drive> {
    let ControllerMessage::Told { leaf: Some(leaf), message: ToController::Goal { command, .. } } = message else {
        return None;
    };
    let Command::Drive { path, .. } = command else { return None };
    let way = std::iter::once(base(history)).chain(path.iter().copied()).collect();
    Some(Drive { step: history.step_count(), leaf: *leaf, way })
}
