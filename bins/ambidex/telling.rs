//! What a log tells with all messages between nodes and all refusals. That of a large tree leaves them out: then they
//! are computed again, turn by turn, from what it does tell.

use std::path::Path;

use ambidex::model::{Header, NodeId, Record};
use ambidex::replay::Replay;
use miette::Result;

use crate::verify::{Rerun, differs, rerun};

/// Makes of each record of a log those that are to be told.
pub struct Telling {
    replay: Option<Replay>,
    line: u64,
}

impl Telling {
    /// Of messages only those that the `wanted` nodes send are computed.
    ///
    /// # Errors
    /// When the log tells no messages, and carries no files to compute them from.
    pub fn new(header: &Header, path: &Path, wanted: impl Fn(NodeId) -> bool) -> Result<Self> {
        if header.has_messages {
            return Ok(Self { replay: None, line: 0 });
        }
        let Rerun { mission, settings, .. } = rerun(header, path)?;
        let wanted = (0..mission.tree.nodes.len()).map(|node| wanted(NodeId::from(node))).collect();
        Ok(Self { replay: Some(Replay::with_messages(&mission, &settings, wanted)), line: 0 })
    }

    /// Hands on what the next record of the log comes to.
    ///
    /// # Errors
    /// When it does not follow from those before it, or `take` fails. False when that wants no more.
    pub fn tell(&mut self, record: &Record, mut take: impl FnMut(&Record) -> Result<bool>) -> Result<bool> {
        self.line += 1;
        let Some(replay) = &mut self.replay else { return take(record) };
        replay.take(record).map_err(|difference| differs(&difference, self.line))?;
        let is_made_in_a_turn = match record {
            Record::Header(_) | Record::Told { .. } | Record::Observed { .. } | Record::Turn { .. } => false,
            Record::Sent { .. } | Record::Controller { .. } => false,
            Record::Began { .. } | Record::Stopped { .. } | Record::World { .. } => true,
            Record::Decided { .. } | Record::Released { .. } | Record::Resource { .. } => true,
            // It may be that of a defect, which no turn makes.
            Record::Ended { .. } => false,
        };
        if !is_made_in_a_turn && !take(record)? {
            return Ok(false);
        }
        let made = replay.take_turn();
        for made in made.iter().filter(|made| !matches!(made, Record::Ended { .. })) {
            if !take(made)? {
                return Ok(false);
            }
        }
        Ok(true)
    }
}
