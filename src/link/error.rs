//! What can go wrong at the edge to shared memory.

use std::io;
use std::path::PathBuf;

type Source = Box<dyn std::error::Error + Send + Sync>;

/// Why an instance, a lock or a port could not be had.
#[derive(Debug, thiserror::Error)]
pub enum IpcError {
    /// The name of an instance has other characters, or too many or none.
    #[error("`{0}` is no name of an instance: 1 to 32 of a-z, 0-9 and -")]
    InstanceName(String),
    /// The name of a controller has other characters, or too many or none.
    #[error("`{0}` is no name of a controller: 1 to 32 of a-z, 0-9, _ and -")]
    ControllerName(String),
    /// The daemon's lock is held.
    #[error("a daemon of instance `{instance}` runs already (pid {pid})")]
    DaemonRuns {
        /// The instance that has a daemon.
        instance: String,
        /// Who holds it, 0 if unknown.
        pid: u32,
    },
    /// The controller's lock is held.
    #[error("a controller `{name}` of instance `{instance}` runs already (pid {pid})")]
    ControllerRuns {
        /// The instance that has such a controller.
        instance: String,
        /// The name that is taken.
        name: String,
        /// Who holds it, 0 if unknown.
        pid: u32,
    },
    /// Another process holds the lock over all instances for too long.
    #[error("another process has held {0} for seconds; is it stopped?")]
    GlobalLockHeld(PathBuf),
    /// A folder of ours is somebody else's, or no folder.
    #[error(
        "{} is in the way: it belongs to user {uid}, and what lies there must be a folder of your own; have it removed",
        path.display()
    )]
    Foreign {
        /// What lies where the folder should.
        path: PathBuf,
        /// User id of its owner.
        uid: u32,
    },
    /// A file or folder under the root could not be made or read.
    #[error("cannot use {path}")]
    File {
        /// What could not be made or read.
        path: PathBuf,
        /// What the operating system says.
        source: io::Error,
    },
    /// The path of the instance does not fit the transport.
    #[error("{0} does not fit as a path of the transport")]
    Path(PathBuf),
    /// The transport did not start.
    #[error("cannot create a node of shared memory for instance `{instance}`")]
    Node {
        /// The instance that was to be entered.
        instance: String,
        /// What the transport says.
        source: Source,
    },
    /// A service or one of its ports could not be opened; most often the other side has another version.
    #[error("cannot open the service `{service}`")]
    Service {
        /// The service that could not be opened.
        service: String,
        /// What the transport says.
        source: Source,
    },
    /// A process could not be watched.
    #[error("cannot watch process {pid}")]
    Watch {
        /// The process that was to be watched.
        pid: u32,
        /// What the operating system says.
        source: io::Error,
    },
}

impl IpcError {
    /// Whether a process could not be watched because there is none.
    pub fn is_gone(&self) -> bool {
        let gone = rustix::io::Errno::SRCH.raw_os_error();
        matches!(self, Self::Watch { source, .. } if source.raw_os_error() == Some(gone))
    }

    pub(super) fn file(path: impl Into<PathBuf>) -> impl FnOnce(io::Error) -> Self {
        let path = path.into();
        move |source| Self::File { path, source }
    }

    pub(super) fn service<E>(service: &str) -> impl FnOnce(E) -> Self
    where
        E: std::error::Error + Send + Sync + 'static,
    {
        let service = service.to_owned();
        move |source| Self::Service { service, source: Box::new(source) }
    }
}
