//! A link in memory: a session of a controller in the place of another process, stepped by tokio's clock.

use std::collections::VecDeque;
use std::io;
use std::pin::Pin;
use std::sync::Arc;
use std::task::{Context, Poll, Waker};
use std::time::Duration;

use ambidex::link::{Heard, Link, LinkError};
use ambidex::model::session::{Beat, Received, Session, StampedPulse};
use ambidex::model::{Inhibition, Labels, Names, Refusal, ToController};
use ambidex::motion::STEP;
use ambidex::runtime::{Clock, Port, Wake};
use ambidex::sim::Body;
use tokio::time::{Instant, Sleep, sleep_until};

const EPOCH: u64 = 1;
const PID: u32 = 1;

pub struct Memory {
    session: Session<Body>,
    labels: Arc<Labels>,
    clock: Clock,
    start: Instant,
    orders: VecDeque<ToController>,
    heard: Vec<Heard>,
    next: Pin<Box<Sleep>>,
    waker: Option<Waker>,
    /// When it comes to be inhibited, and when it may move again.
    stops: VecDeque<(Instant, Option<Inhibition>)>,
}

/// When something inhibits a controller or does so no more, from the start on.
pub type Stop = (Duration, Option<Inhibition>);

impl Memory {
    pub fn new(body: Body, names: &Names, stops: &[Stop], clock: Clock) -> Self {
        let start = Instant::now();
        let (session, next) = (Session::new(body), Box::pin(sleep_until(start)));
        let labels = Arc::new(Labels::new(names));
        let stops = stops.iter().map(|(at, why)| (start + *at, *why)).collect();
        Self { session, labels, clock, start, orders: VecDeque::new(), heard: Vec::new(), next, waker: None, stops }
    }

    /// What the loop of a controller's process does when it wakes.
    fn turn(&mut self) {
        let now_ns = self.clock.now_ns();
        while let Some((_, why)) = self.stops.pop_front_if(|(at, _)| *at <= Instant::now()) {
            self.session.inhibit(why);
        }
        self.session.hear_beat(Beat { pid: PID, epoch: EPOCH, sent_ns: now_ns });
        for message in std::mem::take(&mut self.orders) {
            let message = self.labels.told(&message);
            self.session.take(Received { message, epoch: EPOCH, origin: self.clock.origin() }, now_ns);
        }
        self.session.tick(now_ns);
        self.heard.extend(self.session.replies().into_iter().map(|reply| {
            let (id, is_last) = (reply.message.id(), reply.message.is_last());
            match self.labels.heard(reply.message) {
                Ok(message) => Heard::Message(message),
                Err(why) => Heard::Refused(Refusal { id, why, is_last }),
            }
        }));
        self.heard.push(Heard::Pulse(StampedPulse { pid: PID, sent_ns: now_ns, pulse: self.session.pulse() }));
    }
}

impl Link for Memory {
    fn send(&mut self, message: &ToController) -> Result<(), LinkError> {
        self.orders.push_back(message.clone());
        if let Some(waker) = self.waker.take() {
            waker.wake();
        }
        Ok(())
    }

    fn drain(&mut self) -> Vec<Heard> {
        std::mem::take(&mut self.heard)
    }

    fn epoch(&self) -> u64 {
        EPOCH
    }

    fn beat(&mut self) {}

    fn forget(&mut self) {}

    fn know(&mut self, labels: &Arc<Labels>) {
        self.labels = Arc::clone(labels);
    }
}

impl Port for Memory {
    fn poll_wake(&mut self, cx: &mut Context<'_>) -> Poll<io::Result<Wake>> {
        let is_due = self.next.as_mut().poll(cx).is_ready();
        if !is_due && self.orders.is_empty() {
            self.waker = Some(cx.waker().clone());
            return Poll::Pending;
        }
        self.turn();
        // At the next step of the grid while it moves, and once in a while to show that it lives.
        let passed = Instant::now() - self.start;
        let steps = passed.as_nanos() / STEP.as_nanos() + 1;
        let step = STEP * u32::try_from(steps).expect("no mission lasts for a year");
        let rest = if self.session.is_at_rest() { passed + Duration::from_millis(100) } else { step };
        let next = self.start + rest;
        self.next.as_mut().reset(self.stops.front().map_or(next, |(at, _)| next.min(*at)));
        Poll::Ready(Ok(Wake::Heard))
    }

    fn watch(&mut self, _pid: u32) {}

    fn unwatch(&mut self) {}
}
