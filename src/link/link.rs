//! The link between runtime and one controller, whatever carries it.

use std::sync::Arc;

use ambidex_model::session::StampedPulse;
use ambidex_model::{CommandId, FromController, Labels, Refusal, Report, ToController};

/// One controller as the runtime sees it, by ids: what a link carries names for, it turns into ids and back by
/// [`Labels`](ambidex_model::Labels). No call blocks.
pub trait Link {
    /// Sends a message to the controller.
    ///
    /// # Errors
    /// [`LinkError`]; the message is lost then, and may be sent again.
    fn send(&mut self, message: &ToController) -> Result<(), LinkError>;

    /// Takes everything that has come. Call it whenever the link is readable, and with every beat.
    fn drain(&mut self) -> Vec<Heard>;

    /// This life of the daemon; never 0.
    fn epoch(&self) -> u64;

    /// Tells the controller that the daemon lives.
    fn beat(&mut self);

    /// Gives the controller up: nothing of the present attachment will be heard any more.
    fn forget(&mut self);

    /// Things are called so from now on: objects came into the room.
    fn know(&mut self, labels: &Arc<Labels>);
}

/// What came from a controller.
#[derive(Debug, Clone, PartialEq)]
pub enum Heard {
    /// A message of the present attachment.
    Message(FromController),
    /// A sign of life with the newest state; [`Presence`](ambidex_model::session::Presence) says what it is worth.
    Pulse(StampedPulse),
    /// What the controller sees of the world beyond what it moves.
    Report(Report),
    /// Something that was not taken: by us, or by the controller when it is not about a command.
    Refused(Refusal),
    /// So much more was not taken, and is not told of one by one.
    PassedOver(u64),
    /// The controller closed a command without a result.
    Closed(CommandId),
    /// What carries the link is damaged: nothing comes any more, and nothing can be sent.
    Broken,
}

/// Why a message could not be sent.
#[derive(Debug, thiserror::Error)]
pub enum LinkError {
    /// No controller has its port open.
    #[error("no controller is there")]
    Absent,
    /// It did not take earlier ones yet.
    #[error("the controller does not take its messages")]
    Full,
    /// The path is empty or longer than the wire carries.
    #[error("a path of {0} way points; the wire carries 1 to 64")]
    PathLength(usize),
    /// A call whose name or arguments are longer than the wire carries.
    #[error("a call of {name} bytes with {with} bytes of arguments; the wire carries 64 and 1024")]
    CallLength {
        /// Bytes of its name.
        name: usize,
        /// Bytes of its arguments.
        with: usize,
    },
    /// Only the generation of the last `Configure` can be spoken of.
    #[error("generation {0} is not the present one")]
    Generation(u32),
    /// The transport failed.
    #[error("the transport failed")]
    Transport(#[source] Box<dyn std::error::Error + Send + Sync>),
}
