//! Exit codes.

use std::process::ExitCode;

use ambidex::model::MissionEnd;
use ambidex::runtime::Ended;

/// What each code means, for `--help` and manual pages.
pub const MEANINGS: [(Exit, &str); 7] = [
    (Exit::Done, "the mission is done; of doctor: nothing is wrong"),
    (Exit::Failed, "the mission failed; of world: the change was refused; of doctor: something is wrong"),
    (
        Exit::Usage,
        "wrong usage, a faulty file, a name that the mission does not have, or a place that is taken already",
    ),
    (Exit::Stalled, "stalled: nothing runs and nothing can, with the reason of every leaf"),
    (
        Exit::Controller,
        "a controller was lost, or did not attach in time; of status: the daemon is gone, its mission did not end;\n\
         of world: no daemon of that instance runs, or it ended before it answered",
    ),
    (Exit::Log, "the mission is done, but its log or its recording is incomplete (a full disk)"),
    (Exit::Canceled, "canceled by Ctrl-C, SIGTERM or SIGHUP"),
];

/// How the process ends; [`MEANINGS`] tells it to people.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Exit {
    /// The mission is done; of `doctor`: nothing is wrong.
    Done = 0,
    /// It failed; of what asks a daemon: it was refused; of `doctor`: something is wrong.
    Failed = 1,
    /// Wrong usage, a faulty file, or a name that the mission does not have.
    Usage = 2,
    /// Nothing runs and nothing can.
    Stalled = 3,
    /// A controller was lost or not attached in time; a daemon is gone whose mission did not end, or none is there to be
    /// asked.
    Controller = 4,
    /// The mission is done, and its log or its recording is incomplete: the disk is full, or a file could not be written.
    Log = 5,
    /// Ctrl-C, SIGTERM or SIGHUP.
    Canceled = 130,
}

impl Exit {
    /// The same end where the log could not be written to its end; what went wrong with the mission itself comes first.
    pub fn with_incomplete_log(self) -> Self {
        if self == Self::Done { Self::Log } else { self }
    }
}

impl From<Exit> for ExitCode {
    fn from(exit: Exit) -> Self {
        Self::from(exit as u8)
    }
}

impl From<&Ended> for Exit {
    fn from(ended: &Ended) -> Self {
        match ended {
            Ended::Mission(end) => Self::from(*end),
            Ended::NotAttached(_) => Self::Controller,
        }
    }
}

impl From<MissionEnd> for Exit {
    fn from(end: MissionEnd) -> Self {
        match end {
            MissionEnd::Done => Self::Done,
            MissionEnd::Failed(_) | MissionEnd::NodeLost(_) | MissionEnd::TaskLost => Self::Failed,
            MissionEnd::Stalled => Self::Stalled,
            MissionEnd::Canceled => Self::Canceled,
            MissionEnd::ControllerLost(_) | MissionEnd::NotAttached => Self::Controller,
        }
    }
}
