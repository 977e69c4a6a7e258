//! The link between runtime and one controller, whatever carries it.

use ambidex_model::{CommandId, ControllerState, FromController, Rejection, Time, ToController};

/// One controller as the runtime sees it. No call blocks.
pub trait Link {
    /// Sends a message to the controller.
    ///
    /// # Errors
    /// [`LinkError`]; the message is lost then, and may be sent again.
    fn send(&mut self, message: &ToController) -> Result<(), LinkError>;

    /// Takes everything that has come. Call it whenever the link is readable, and with every beat.
    fn drain(&mut self) -> Vec<Heard>;

    /// Tells the controller that the daemon lives.
    fn beat(&mut self);

    /// The process id of the controller, if it showed a sign of life within [`DEAD_MAN`](super::DEAD_MAN).
    fn is_attached(&self) -> Option<u32>;

    /// Gives the controller up: nothing of the present attachment will be heard any more.
    fn forget(&mut self);
}

/// What came from a controller.
#[derive(Debug, Clone, PartialEq)]
pub enum Heard {
    /// A message of the present attachment.
    Message(FromController),
    /// A sign of life and the newest state.
    State {
        /// When the state was so, robot time; zero while not attached.
        at: Time,
        /// The state.
        state: ControllerState,
        /// The controller's process.
        pid: u32,
        /// The attachment to this daemon, 0 if none.
        generation: u32,
    },
    /// Something that was not taken: by us, or by the controller when it is not about a command.
    Refused(Rejection),
    /// The controller closed a command without a result.
    Closed(CommandId),
}

/// Why a message could not be sent.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
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
    /// Only the generation of the last `Configure` can be spoken of.
    #[error("generation {0} is not the present one")]
    Generation(u32),
    /// The transport failed.
    #[error("the transport failed: {0}")]
    Transport(String),
}
