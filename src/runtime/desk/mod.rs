//! Where work for a run is handed in: one after the other is read, told to root, and answered once it is in the log.

mod words;

use std::collections::VecDeque;
use std::fmt;
use std::sync::Arc;

use tokio::sync::{mpsc, oneshot};

use super::control::{Answer, Refusal, Why, Work as Asked};
use super::journal_task::Journal;
use super::node_task::{Surroundings, ToRoot, lock};
use super::signal::Signal;
use ambidex_model::{Fragment, MissionSpec, Source, Told, Work, Worked, WorldState};
use words::{Said, not_logged, refusal};

/// Reads parts of trees for a mission as it is, on a thread where it may take its time.
pub trait BranchReader: Send + Sync {
    /// The part of a tree that files tell.
    ///
    /// # Errors
    /// Why it cannot be, for people.
    fn read(&self, source: &Source, mission: &MissionSpec, world_state: &WorldState) -> Result<Fragment, String>;
}

/// The desk.
pub(super) struct Desk {
    pub(super) mission: Arc<MissionSpec>,
    reader: Option<Arc<dyn BranchReader>>,
    around: Arc<Surroundings>,
    signals: mpsc::UnboundedSender<Signal>,
    /// How much was told to root.
    told: u64,
    waiting: VecDeque<(Asked, oneshot::Sender<Answer>)>,
    /// What is read, or with root.
    present: Option<(Said, oneshot::Sender<Answer>)>,
}

impl fmt::Debug for Desk {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Desk").field("told", &self.told).field("waiting", &self.waiting.len()).finish_non_exhaustive()
    }
}

impl Desk {
    pub(super) fn new(
        mission: &Arc<MissionSpec>,
        told: u64,
        reader: Option<Arc<dyn BranchReader>>,
        around: &Arc<Surroundings>,
        signals: mpsc::UnboundedSender<Signal>,
    ) -> Self {
        let (mission, around) = (Arc::clone(mission), Arc::clone(around));
        Self { mission, reader, around, signals, told, waiting: VecDeque::new(), present: None }
    }

    /// Takes work; it is answered in its turn.
    pub(super) fn take(&mut self, work: Asked, answer: oneshot::Sender<Answer>, root: &ToRoot) {
        self.waiting.push_back((work, answer));
        self.go_on(root);
    }

    /// The next one, when none is read or with root.
    fn go_on(&mut self, root: &ToRoot) {
        while self.present.is_none() {
            let Some((work, answer)) = self.waiting.pop_front() else { return };
            // Whoever asked has left before it was begun.
            if answer.is_closed() {
                continue;
            }
            let (work, said) = match self.by_ids(work) {
                Ok(understood) => understood,
                Err(refusal) => {
                    // Whoever asked may have gone.
                    let _ = answer.send(Answer::Refused(refusal));
                    continue;
                }
            };
            self.present = Some((said, answer));
            match self.reader.clone().filter(|_| work.branch().is_some()) {
                Some(reader) => self.read(work, reader),
                None => self.tell(work, root),
            }
        }
    }

    fn read(&self, mut work: Work, reader: Arc<dyn BranchReader>) {
        let (mission, signals) = (Arc::clone(&self.mission), self.signals.clone());
        let seen = lock(&self.around.seen).clone();
        tokio::task::spawn_blocking(move || {
            let world_state = seen.as_ref().map_or(&mission.start, |view| view.state.world());
            let read = work.branch_mut().map_or(Ok(()), |branch| {
                branch.fragment = Some(Arc::new(reader.read(&branch.source, &mission, world_state)?));
                Ok(())
            });
            drop(signals.send(Signal::Read(read.map(|()| Box::new(work)))));
        });
    }

    /// What came with the present work was read.
    pub(super) fn was_read(&mut self, read: Result<Box<Work>, String>, root: &ToRoot) {
        match read {
            Ok(work) => self.tell(*work, root),
            Err(why) => {
                self.answer(Answer::Refused(Refusal::new(Why::Faulty, why)));
                self.go_on(root);
            }
        }
    }

    fn tell(&mut self, work: Work, root: &ToRoot) {
        self.told += 1;
        root.tell(Told::Work { work });
    }

    /// Root has decided. What was told in an earlier life of this run nobody asks for any more.
    pub(super) fn worked(&mut self, number: u64, worked: Worked, journal: Option<&Journal>, root: &ToRoot) {
        if number != self.told {
            return;
        }
        let Some((said, answer)) = self.present.take() else { return };
        let done = match worked {
            Ok(added) => self.done(said, added),
            Err(why) => Answer::Refused(refusal(why, &self.mission.names)),
        };
        match journal {
            Some(journal) => {
                let settled = journal.settled();
                tokio::spawn(async move {
                    let is_settled = settled.await.unwrap_or(false);
                    // Whoever asked may have gone.
                    let _ = answer.send(if is_settled { done } else { Answer::Refused(not_logged()) });
                });
            }
            None => {
                let _ = answer.send(done);
            }
        }
        self.go_on(root);
    }

    fn answer(&mut self, done: Answer) {
        if let Some((_, answer)) = self.present.take() {
            // Whoever asked may have gone.
            let _ = answer.send(done);
        }
    }
}
