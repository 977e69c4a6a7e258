//! Why a controller could not serve.

use std::io;

use crate::IpcError;

/// Why a controller could not serve.
#[derive(Debug, thiserror::Error)]
pub enum ServeError {
    /// Its place in the instance could not be had; most often because another has its name.
    #[error("the controller could not take its place")]
    Place(#[source] IpcError),
    /// Its ports could not be opened.
    #[error("the controller could not open its ports")]
    Ports(#[source] IpcError),
    /// The parent that it is to end with has ended already.
    #[error("the parent process {0} has ended already")]
    Orphan(u32),
    /// It could not be tied to its parent.
    #[error("the controller could not be tied to its parent process")]
    Parent(#[source] io::Error),
    /// It could not wait for what comes.
    #[error("the controller could not wait for messages")]
    Wait(#[source] io::Error),
}
