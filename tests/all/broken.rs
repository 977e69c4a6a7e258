//! A defect outside the tree: a task of the runtime that panics ends the run loudly, it does not hang it.

use std::os::fd::{AsFd, BorrowedFd};
use std::os::unix::net::UnixStream;
use std::sync::Arc;
use std::time::Duration;

use ambidex::dispatch::Script;
use ambidex::link::{Heard, Link, LinkError};
use ambidex::model::{Labels, MissionEnd, ToController};
use ambidex::runtime::{self, Clock, Ended, Options, Port, Readable};
use ambidex::tree::Settings;
use tokio::sync::mpsc;

use crate::fixtures::{experiment_file, load};

const DEADLINE: Duration = Duration::from_secs(10);

/// A link that panics at its first sound.
struct Broken {
    listener: UnixStream,
}

impl Link for Broken {
    fn send(&mut self, _: &ToController) -> Result<(), LinkError> {
        Ok(())
    }

    fn drain(&mut self) -> Vec<Heard> {
        panic!("this link is broken on purpose")
    }

    fn beat(&mut self) {}

    fn epoch(&self) -> u64 {
        1
    }

    fn forget(&mut self) {}

    fn know(&mut self, _: &Arc<Labels>) {}
}

impl AsFd for Broken {
    fn as_fd(&self) -> BorrowedFd<'_> {
        self.listener.as_fd()
    }
}

#[test]
fn a_panic_in_a_link_ends_the_run() {
    let mission = load(&experiment_file(1));
    let (ears, _voices): (Vec<_>, Vec<_>) =
        mission.robot.controllers.iter().map(|_| UnixStream::pair().expect("a pair")).unzip();
    let links =
        ears.into_iter().map(|listener| Box::new(Readable::new(Broken { listener })) as Box<dyn Port>).collect();
    let executor = tokio::runtime::Builder::new_current_thread().enable_all().build().expect("an executor");
    executor.block_on(async {
        let (_control, controlled) = mpsc::unbounded_channel();
        let options = Options {
            reader: None,
            settings: Settings::default(),
            clock: Clock::start(1.0),
            attach_timeout: None,
            grace: Duration::ZERO,
            journal: None,
            resumed: None,
            script: Script::default(),
            diagnostics: Default::default(),
        };
        let run = tokio::spawn(runtime::run(mission, links, options, controlled));
        let ended = tokio::time::timeout(DEADLINE, run).await.expect("the run hangs");
        let ended = ended.expect("the run itself goes on to its end");
        assert_eq!(ended, Ended::Mission(MissionEnd::TaskLost));
    });
}
