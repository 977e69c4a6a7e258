//! The loop of a controller's process: ports and clock around a session. It blocks; there is no tokio in it.

use std::fmt;
use std::io;
use std::os::fd::AsFd;
use std::thread;
use std::time::{Duration, Instant};

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::process::{Signal, getppid, set_parent_process_death_signal};

use super::error::ServeError;
use super::stop::Stop;
use crate::watch::Pidfd;
use crate::{ControllerPort, Instance, IpcNode, monotonic_ns, sweep, tidy};
use ambidex_model::Inhibition;
use ambidex_model::motion::{Controller, FromController, ToController};
use ambidex_model::session::{PULSE_EVERY, Session};

/// How long the ports of a dead predecessor may stand in the way.
const OPEN_WAIT: Duration = Duration::from_secs(2);
const OPEN_POLL: Duration = Duration::from_millis(20);
/// How long motion may brake once the controller is told to stop, wall time.
const STOP_GRACE: Duration = Duration::from_secs(2);

/// What happens while a controller serves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ServeEvent<'a> {
    /// It has its place, and waits for a daemon.
    Ready,
    /// A daemon has configured it.
    Attached,
    /// Its daemon is gone.
    Left,
    /// A daemon told it something.
    Told(&'a ToController),
    /// It answers.
    Said(&'a FromController),
}

/// Somebody who is told what happens; it must not block.
pub struct Watcher(Box<dyn FnMut(ServeEvent<'_>) + Send>);

impl Watcher {
    /// Tells it to a closure.
    pub fn new(watch: impl FnMut(ServeEvent<'_>) + Send + 'static) -> Self {
        Self(Box::new(watch))
    }
}

impl fmt::Debug for Watcher {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Watcher")
    }
}

/// How a controller serves.
#[derive(Debug, Default)]
pub struct ServeOptions {
    /// Ends when the first daemon has left, instead of waiting for the next.
    pub once: bool,
    /// Ends by SIGKILL when this parent does. Its thread that made the process counts, so make it in one that stays.
    pub parent: Option<u32>,
    /// Stops motion and ends when it becomes readable.
    pub stop: Option<Stop>,
    /// Is told what happens.
    pub watcher: Option<Watcher>,
}

/// Why a controller ended, all being well.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Exit {
    /// It was told to.
    Stopped,
    /// Its daemon left, and it was to serve [`once`](ServeOptions::once).
    DaemonLeft,
}

/// Serves as the controller of that name until it is told to stop, for one daemon after the other.
///
/// # Errors
/// [`ServeError`] when the name is taken, when the ports cannot be opened or waited for, when the parent is gone.
pub fn serve<C: Controller>(
    instance: &Instance,
    name: &str,
    controller: C,
    options: ServeOptions,
) -> Result<Exit, ServeError> {
    if let Some(parent) = options.parent {
        end_with(parent)?;
    }
    if let Err(error) = sweep() {
        tracing::warn!(%error, "cannot sweep what dead instances left");
    }
    let lock = instance.lock_controller(name).map_err(ServeError::Place)?;
    let node = IpcNode::open(lock).map_err(ServeError::Place)?;
    let mut server = Server {
        port: open_port(&node, name)?,
        session: Session::new(controller),
        daemon: None,
        pulsed: None,
        was_attached: false,
        was_inhibited: None,
        was_rung: false,
        stop_by: None,
        options,
    };
    server.tell(ServeEvent::Ready);
    server.run()
}

struct Server<C> {
    port: ControllerPort,
    session: Session<C>,
    daemon: Option<Pidfd>,
    pulsed: Option<Instant>,
    was_attached: bool,
    was_inhibited: Option<Inhibition>,
    /// The daemon has rung since the last turn.
    was_rung: bool,
    stop_by: Option<Instant>,
    options: ServeOptions,
}

impl<C: Controller> Server<C> {
    fn run(mut self) -> Result<Exit, ServeError> {
        loop {
            self.hear();
            let has_moved = self.session.tick(monotonic_ns());
            let has_replied = self.speak();
            let has_left = self.was_attached && !self.session.is_attached();
            let has_joined = !self.was_attached && self.session.is_attached();
            if has_left {
                tracing::info!("the daemon is gone");
                self.tell(ServeEvent::Left);
                self.port.detach();
            }
            if has_joined {
                tracing::info!("attached");
                self.tell(ServeEvent::Attached);
            }
            self.was_attached = self.session.is_attached();
            let has_turned = self.hear_inhibition();
            // A daemon that has just come rings, and is to see at once that somebody is there.
            let is_called = std::mem::take(&mut self.was_rung) && !self.session.is_attached();
            self.publish(has_moved, has_replied || has_left || has_joined || is_called || has_turned);
            self.report();
            if has_left && self.options.once {
                return Ok(Exit::DaemonLeft);
            }
            if self.may_stop() {
                return Ok(Exit::Stopped);
            }
            self.wait()?;
        }
    }

    fn tell(&mut self, event: ServeEvent<'_>) {
        if let Some(Watcher(watch)) = &mut self.options.watcher {
            watch(event);
        }
    }

    fn hear(&mut self) {
        // A request may stand on a beat sent before it, so requests are taken first and beats are heard first.
        let received = self.port.receive();
        if let Some(beat) = self.port.beat() {
            self.session.hear_beat(beat);
            self.watch(beat.pid);
        }
        let now_ns = monotonic_ns();
        for request in received {
            self.tell(ServeEvent::Told(&request.message));
            self.session.take(request, now_ns);
        }
    }

    fn watch(&mut self, pid: u32) {
        if self.daemon.as_ref().is_some_and(|daemon| daemon.pid() == pid) {
            return;
        }
        match Pidfd::open(pid) {
            Ok(daemon) => self.daemon = Some(daemon),
            Err(error) if error.is_gone() => {
                tracing::warn!(%error, "the daemon has ended");
                self.session.hear_end();
            }
            // Its end will be known by its silence.
            Err(error) => tracing::debug!(%error, "the daemon cannot be watched"),
        }
    }

    /// Whether it came to be inhibited, or to be so no more.
    fn hear_inhibition(&mut self) -> bool {
        let inhibited = self.session.inhibited();
        let has_changed = std::mem::replace(&mut self.was_inhibited, inhibited) != inhibited;
        match inhibited.filter(|_| has_changed) {
            Some(why) => tracing::warn!(%why, "inhibited"),
            None if has_changed => tracing::info!("inhibited no more"),
            None => {}
        }
        has_changed
    }

    fn speak(&mut self) -> bool {
        let replies = self.session.replies();
        for reply in &replies {
            if let FromController::Rejected { id, why } = &reply.message {
                tracing::warn!(?id, %why, "a command was rejected");
            }
            self.tell(ServeEvent::Said(&reply.message));
            self.port.reply(reply.epoch, &reply.message);
        }
        self.port.flush();
        !replies.is_empty()
    }

    /// Tells what is seen of the world; what cannot be sent now is told by and by.
    fn report(&mut self) {
        for said in self.session.reports(monotonic_ns()) {
            if !self.port.report(&said) {
                self.session.untold(&said.report);
            }
        }
    }

    fn publish(&mut self, has_moved: bool, has_news: bool) {
        let is_first = self.pulsed.is_none();
        let is_due = self.pulsed.is_none_or(|at| at.elapsed() >= PULSE_EVERY);
        if is_due || has_news || has_moved {
            self.pulsed = Some(Instant::now());
            // That it lives the daemon sees when it looks; what is new is worth a wake-up.
            self.port.publish(&self.session.pulse(), is_first || has_news);
        }
    }

    fn may_stop(&mut self) -> bool {
        let is_told = self.options.stop.as_ref().is_some_and(is_readable);
        if is_told && self.stop_by.is_none() {
            tracing::info!("stopping");
            self.session.stop();
            self.stop_by = Some(Instant::now() + STOP_GRACE);
        }
        self.stop_by.is_some_and(|by| self.session.is_at_rest() || Instant::now() > by)
    }

    fn wait(&mut self) -> Result<(), ServeError> {
        let mut fds = vec![PollFd::new(&self.port, PollFlags::IN)];
        // Once told, the stop stays readable; it must not keep the loop spinning while motion brakes.
        if let Some(stop) = self.options.stop.as_ref().filter(|_| self.stop_by.is_none()) {
            fds.push(PollFd::new(stop, PollFlags::IN));
        }
        if let Some(daemon) = &self.daemon {
            fds.push(PollFd::new(daemon, PollFlags::IN));
        }
        let rest = Timespec::try_from(self.session.rest(monotonic_ns())).unwrap_or_default();
        match poll(&mut fds, Some(&rest)) {
            Ok(_) | Err(rustix::io::Errno::INTR) => {}
            Err(error) => return Err(ServeError::Wait(error.into())),
        }
        self.was_rung = !fds[0].revents().is_empty();
        if self.daemon.as_ref().is_some_and(Pidfd::has_ended) {
            self.daemon = None;
            self.session.hear_end();
        }
        Ok(())
    }
}

/// A predecessor that was killed may still have its port until its node is cleaned up, here or by the daemon.
fn open_port(node: &IpcNode, name: &str) -> Result<ControllerPort, ServeError> {
    let begun = Instant::now();
    loop {
        match ControllerPort::open(node, name) {
            Ok(port) => return Ok(port),
            Err(error) if begun.elapsed() > OPEN_WAIT => return Err(ServeError::Ports(error)),
            Err(error) => tracing::debug!(%error, "the ports are not free yet"),
        }
        thread::sleep(OPEN_POLL);
        tidy(node.instance());
    }
}

fn end_with(parent: u32) -> Result<(), ServeError> {
    set_parent_process_death_signal(Some(Signal::KILL)).map_err(|error| ServeError::Parent(io::Error::from(error)))?;
    // It may have ended before the call above.
    let is_there = getppid().is_some_and(|pid| pid.as_raw_pid().cast_unsigned() == parent);
    if is_there { Ok(()) } else { Err(ServeError::Orphan(parent)) }
}

fn is_readable(stop: &Stop) -> bool {
    let mut fds = [PollFd::from_borrowed_fd(stop.as_fd(), PollFlags::IN)];
    poll(&mut fds, Some(&Timespec::default())).is_ok_and(|ready| ready > 0)
}

#[cfg(test)]
#[path = "tests.rs"]
mod tests;

#[cfg(test)]
#[path = "process_tests.rs"]
mod process_tests;
