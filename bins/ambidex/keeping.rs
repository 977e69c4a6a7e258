//! Children of `run` that end by themselves are started again.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use ambidex::model::Time;
use ambidex::runtime::{Control, process_end};
use tokio::sync::{mpsc, watch};
use tokio::time::{Instant, sleep};

use crate::children::Children;
use crate::terminal::Terminal;

/// So often a child is started again within [`SPAN`]; then it is left alone.
const RESTARTS: usize = 5;
const SPAN: Duration = Duration::from_secs(60);
/// How long the first restart waits; each further one twice as long.
const BACKOFF: Duration = Duration::from_millis(250);

/// Keeps children alive.
#[derive(Clone)]
pub struct Keeper {
    /// The children of the run.
    pub children: Arc<Mutex<Children>>,
    /// Tells when the mission has begun.
    pub begun: watch::Receiver<Option<Time>>,
    /// To the run.
    pub run: mpsc::UnboundedSender<Control>,
    /// For what is said of it.
    pub terminal: Terminal,
}

impl Keeper {
    /// Keeps every child.
    pub fn keep_all(&self) {
        let pids = self.children().pids();
        pids.into_iter().enumerate().for_each(|(index, pid)| self.keep(index, pid));
    }

    /// Keeps one that was just started.
    pub fn keep(&self, index: usize, pid: u32) {
        tokio::spawn(self.clone().kept(index, pid));
    }

    /// A child that ends before the mission begins will not attach, and nobody need wait for it; later it is started
    /// again.
    async fn kept(self, index: usize, mut pid: u32) {
        let mut restarts = VecDeque::new();
        while process_end(pid).await.is_ok() && self.children().is_missed(index, pid) {
            let name = self.children().name(index).to_owned();
            if self.begun.borrow().is_none() && self.run.send(Control::GiveUp).is_ok() {
                self.terminal.say(&format!("the process of {name} has ended"));
            }
            // Where all had attached before, the mission begins all the same.
            if self.begun.clone().wait_for(Option::is_some).await.is_err() {
                return;
            }
            let now = Instant::now();
            restarts.retain(|at: &Instant| now.duration_since(*at) < SPAN);
            if restarts.len() == RESTARTS {
                self.terminal.say(&format!("the process of {name} ended {RESTARTS} times, and is left alone"));
                return;
            }
            sleep(BACKOFF * (1 << restarts.len())).await;
            restarts.push_back(now);
            let restarted = {
                let mut children = self.children();
                // It may have been ended on purpose meanwhile, or started again.
                children.is_missed(index, pid).then(|| children.restart(index))
            };
            match restarted {
                None => return,
                Some(Ok(next)) => pid = next,
                Some(Err(error)) => {
                    self.terminal.say(&format!("error: {name} is not started: {error}"));
                    return;
                }
            }
            self.terminal.say(&format!("the process of {name} has ended and is started again"));
        }
    }

    /// The children, for as long as nobody else is to see them.
    pub fn children(&self) -> MutexGuard<'_, Children> {
        self.children.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
