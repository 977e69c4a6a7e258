//! One task per controller link: what came, the daemon's heartbeat, and whether the controller is there.

use std::collections::VecDeque;
use std::error::Error;
use std::future::poll_fn;
use std::sync::Arc;
use std::time::Duration;

use tokio::sync::mpsc;
use tokio::time::sleep_until;

use super::clock::Clock;
use super::diagnostics::Monitors;
use super::port::{Port, Wake};
use ambidex_core::dispatch::Input;
use ambidex_link::{Heard, LinkError};
use ambidex_model::session::{Attendance, BEAT_EVERY, Hearing, Pace, Presence};
use ambidex_model::{ControllerId, FromController, Labels, Loss, Refusal, Rejection, ToController};

/// A daemon that runs takes a turn more often than that, wall time: longer ago, its process was stopped.
const AWAY: Duration = BEAT_EVERY.saturating_mul(2);

/// How often is told of a process that pulses under a name which another has, wall time.
pub(super) const FOREIGN_EVERY: Duration = Duration::from_secs(1);

/// What a link is told to do.
#[derive(Debug)]
pub(super) enum Order {
    /// Tell the controller.
    Tell(ToController),
    /// Forget the attachment, so that the controller may attach anew.
    Reset,
    /// Things are called so from now on.
    Know(Arc<Labels>),
}

/// A link with its neighbors.
pub(super) struct LinkTask {
    pub(super) id: ControllerId,
    pub(super) link: Box<dyn Port>,
    pub(super) orders: mpsc::UnboundedReceiver<Order>,
    pub(super) dispatch: mpsc::UnboundedSender<Input>,
    pub(super) clock: Clock,
    /// How often is told of others under its name.
    pub(super) foreign: Pace,
    pub(super) monitors: Monitors,
}

impl LinkTask {
    /// Lives until the run is over.
    ///
    /// # Errors
    /// When a descriptor cannot be watched, or the link is damaged.
    pub(super) async fn run(mut self) -> std::io::Result<()> {
        self.link.beat();
        let mut presence = Presence::new(self.link.epoch());
        // What was meant for an attachment that is over is not sent to the next.
        let (mut waiting, mut is_void) = (VecDeque::new(), false);
        let mut ran_ns = self.clock.now_ns();
        loop {
            let mut has_ended = false;
            let silent_at = presence.silent_at_ns().map(|at_ns| self.clock.instant_of_ns(at_ns));
            tokio::select! {
                wake = poll_fn(|cx| self.link.poll_wake(cx)) => match wake? {
                    Wake::Heard => {}
                    Wake::Beat => {
                        self.link.beat();
                        self.monitors.beat(self.clock.now_ns());
                    }
                    Wake::Ended => has_ended = true,
                },
                order = self.orders.recv() => match order {
                    Some(Order::Tell(message)) => {
                        is_void &= !matches!(message, ToController::Configure { .. });
                        waiting.extend((!is_void).then_some(message));
                    }
                    Some(Order::Reset) => {
                        presence = Presence::new(self.link.epoch());
                        waiting.clear();
                        is_void = true;
                    }
                    Some(Order::Know(labels)) => self.link.know(&labels),
                    None => return Ok(()),
                },
                () = async { sleep_until(silent_at.expect("guarded")).await }, if silent_at.is_some() => {}
            }
            let now_ns = self.clock.now_ns();
            let away = Duration::from_nanos(now_ns.saturating_sub(ran_ns));
            ran_ns = now_ns;
            if away > AWAY {
                tracing::warn!(target: "ambidex::controller", controller = self.id.0, ?away, "this daemon did not run");
                presence.was_away(now_ns, away);
            }
            self.hear(&mut presence, now_ns)?;
            match presence.attend(now_ns, has_ended) {
                Some(Attendance::Attached { pid }) => {
                    self.link.watch(pid);
                    self.tell(Input::Attached(self.id));
                }
                Some(Attendance::Inhibited { pid, why }) => {
                    self.link.watch(pid);
                    self.link.forget();
                    waiting.clear();
                    is_void = true;
                    self.tell(Input::Lost(self.id, Loss::Inhibited(why)));
                }
                Some(Attendance::Lost(why)) => {
                    self.link.unwatch();
                    self.link.forget();
                    waiting.clear();
                    is_void = true;
                    self.tell(Input::Lost(self.id, why));
                }
                None => {}
            }
            self.send(&mut waiting);
            self.monitors.of(self.id).queued(waiting.len());
        }
    }

    /// Takes all that came; a wake-up is only a hint.
    ///
    /// # Errors
    /// When the link is damaged.
    fn hear(&mut self, presence: &mut Presence, now_ns: u64) -> std::io::Result<()> {
        for heard in self.link.drain() {
            match heard {
                Heard::Message(message) => self.tell(Input::Heard(self.id, message)),
                Heard::Report(report) => self.tell(Input::Reported(self.id, report)),
                Heard::Refused(refusal) => self.tell(Input::Refused(self.id, refusal)),
                Heard::Closed(command) => self.tell(Input::Closed(self.id, command)),
                Heard::PassedOver(count) => self.monitors.of(self.id).passed_over(count),
                Heard::Pulse(pulse) => {
                    let hearing = presence.hear(&pulse, now_ns);
                    self.monitors.of(self.id).pulsed(&pulse, hearing);
                    match hearing {
                        Hearing::Taken | Hearing::Old => {}
                        Hearing::Foreign { pid: owner } => self.refuse_foreign(pulse.pid, owner, now_ns),
                    }
                }
                Heard::Broken => return Err(std::io::Error::other("a file of the link is damaged")),
            }
        }
        Ok(())
    }

    /// Who has come first keeps the name as long as it lives.
    fn refuse_foreign(&mut self, pid: u32, owner: u32, now_ns: u64) {
        if self.foreign.takes(now_ns) {
            tracing::warn!(
                target: "ambidex::controller", controller = self.id.0, pid, owner, "another process has this name"
            );
            self.tell(Input::Refused(self.id, Refusal { id: None, why: Rejection::Stale, is_last: false }));
        }
    }

    /// Sends in order; what the controller cannot take yet is tried again at the next wake-up.
    fn send(&mut self, waiting: &mut VecDeque<ToController>) {
        while let Some(message) = waiting.front() {
            match self.link.send(message) {
                Ok(()) => {}
                Err(LinkError::Absent | LinkError::Full) => return,
                Err(
                    error @ (LinkError::PathLength(_)
                    | LinkError::CallLength { .. }
                    | LinkError::Generation(_)
                    | LinkError::Transport(_)),
                ) => {
                    let error: &(dyn Error + 'static) = &error;
                    tracing::warn!(target: "ambidex::controller", controller = self.id.0, error, "not sent");
                    if let ToController::Goal { id, .. } = message {
                        let rejected = FromController::Rejected { id: *id, why: Rejection::Malformed };
                        self.tell(Input::Heard(self.id, rejected));
                    }
                }
            }
            waiting.pop_front();
        }
    }

    fn tell(&self, input: Input) {
        drop(self.dispatch.send(input));
    }
}
