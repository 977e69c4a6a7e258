//! A run as messages by topic, in the form that viewers of robots read: JSON with JSON Schema, and the schemas of Foxglove
//! where one fits. Whoever has a file writes them there.

mod clock;
mod foxglove;
mod message;
mod poses;
mod scene;
mod schema;
mod state;
mod talk;
#[cfg(test)]
mod tests;

use std::sync::Arc;

use ambidex_model::{MissionSpec, Record, Time};
use ambidex_record::History;
use serde_json::json;

pub use clock::WallClock;
pub use message::{Message, Topic};

use crate::conversation::with_names;
use message::Moment;
use poses::Poses;
use scene::Scene;
use state::Told;

/// Makes the messages of a run of its records.
#[derive(Debug)]
pub struct Recording {
    clock: WallClock,
    told: Told,
    poses: Poses,
    /// None where positions are not known.
    scene: Option<Scene>,
    /// Whether all is to be told, not only what is different.
    is_anew: bool,
}

impl Recording {
    /// Nothing was told yet. Where things lie only the mission says: without it nothing is told of objects.
    pub fn new(clock: WallClock, mission: Option<Arc<MissionSpec>>) -> Self {
        Self {
            clock,
            told: Told::default(),
            poses: Poses::new(mission.as_deref()),
            scene: mission.map(Scene::new),
            is_anew: true,
        }
    }

    /// The messages that come of a record, which the history has taken last. The first one tells how everything is.
    pub fn take(&mut self, history: &History, record: &Record) -> Vec<Message> {
        let mut moment = Moment::new(self.clock, record.at());
        if let Record::Sent { .. } = record {
            moment.say_json(Topic::NodeMessages, with_names(record, history.names()));
        }
        if let Record::Controller { .. } = record {
            moment.say_json(Topic::ControllerMessages, with_names(record, history.names()));
        }
        let is_anew = std::mem::take(&mut self.is_anew);
        self.told.tell(history, record, is_anew, &mut moment);
        self.poses.tell(history, record, is_anew, &mut moment);
        if let Some(scene) = &mut self.scene {
            scene.tell(history, &self.poses, is_anew, &mut moment);
        }
        talk::tell(history, record, &mut moment);
        moment.into_messages()
    }

    /// Messages got lost: the next record tells again how everything is. The message that says how many are missing.
    pub fn dropped(&mut self, at: Time, missing: u64, total: u64) -> Message {
        self.is_anew = true;
        let mut moment = Moment::new(self.clock, at);
        moment.say(Topic::Dropped, &json!({"missing": missing, "total": total}));
        moment.into_messages().pop().expect("one was said")
    }
}
