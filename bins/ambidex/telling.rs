//! What a log tells with all messages between nodes and all refusals. That of a large tree leaves them out: then they
//! are computed again, turn by turn, from what it does tell.

use std::path::Path;

use ambidex::model::{Header, NodeId, Record};
use ambidex::replay::Replay;
use miette::Result;

use crate::verify::{Rerun, differs, follow, reading, rerun};

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
        let replay = reading(Replay::with_messages(&mission, &settings, wanted), &mission)?;
        Ok(Self { replay: Some(replay), line: 0 })
    }

    /// Hands on what the next record of the log comes to.
    ///
    /// # Errors
    /// When it does not follow from those before it, or `take` fails. False when that wants no more.
    pub fn tell(&mut self, record: &Record, mut take: impl FnMut(&Record) -> Result<bool>) -> Result<bool> {
        self.line += 1;
        let Some(replay) = &mut self.replay else { return take(record) };
        follow(replay, record).map_err(|difference| differs(&difference, self.line))?;
        // The end may be that of a defect, which no turn makes: it is told where the log has it.
        let is_end = |record: &Record| matches!(record, Record::Ended { .. });
        if (!record.follows() || is_end(record)) && !take(record)? {
            return Ok(false);
        }
        let made = replay.take_turn();
        for made in made.iter().filter(|made| !is_end(made)) {
            if !take(made)? {
                return Ok(false);
            }
        }
        Ok(true)
    }
}
