//! A controller that speaks the wire by itself, as `docs/wire.md` says and as it pleases. Nothing of the link's own code
//! but its structures and its lock.

use std::fmt::Debug;
use std::path::PathBuf;
use std::thread;
use std::time::{Duration, Instant};

use ambidex::link::wire::{
    WIRE_VERSION, WireId, WireName, WirePulse, WireReport, WireRequest, WireResponse, WireState, command, end,
    request_kind, response_kind, state_kind,
};
use ambidex::link::{Instance, Lock, monotonic_ns};
use iceoryx2::active_request::ActiveRequest;
use iceoryx2::port::BackpressureAction;
use iceoryx2::port::notifier::Notifier;
use iceoryx2::port::publisher::Publisher;
use iceoryx2::port::server::Server;
use iceoryx2::prelude::*;
use iceoryx2::service::port_factory::{event, publish_subscribe, request_response};

pub type Ipc = ipc_threadsafe::Service;
pub type Request = ActiveRequest<Ipc, WireRequest, (), WireResponse, ()>;

const PULSE_EVERY: Duration = Duration::from_millis(100);
const POLL: Duration = Duration::from_millis(1);

/// Its ports, and what it would say if it behaved.
pub struct Peer {
    pub server: Server<Ipc, WireRequest, (), WireResponse, ()>,
    pub pulses: Publisher<Ipc, WirePulse, ()>,
    pub reports: Publisher<Ipc, WireReport, ()>,
    pub notifier: Notifier<Ipc>,
    /// Its attachment, as the last configuration said it.
    pub id: WireId,
    pub state: WireState,
    pub origin_ns: u64,
    pub speed: f64,
    pulsed: Option<Instant>,
    /// Kept open as long as the peer lives.
    answered: Vec<Request>,
    _node: Node<Ipc>,
    _lock: Option<Lock>,
}

/// The text as a name on the wire.
pub fn name(text: &str) -> WireName {
    let mut wire = WireName { len: text.len() as u32, ..WireName::default() };
    wire.text[..text.len()].copy_from_slice(text.as_bytes());
    wire
}

/// A node of the instance, made as the contract says.
pub fn node(instance: &Instance) -> Node<Ipc> {
    let tag = tag(instance);
    let mut config = Config::default();
    config.global.prefix = FileName::new(format!("ambidex_{tag}_").as_bytes()).expect("a prefix");
    let root = folder(instance);
    config.global.set_root_path(&Path::new(root.as_os_str().as_encoded_bytes()).expect("a path"));
    config.global.node.cleanup_dead_nodes_on_creation = false;
    config.global.node.cleanup_dead_nodes_on_destruction = false;
    config.global.service.cleanup_dead_nodes_on_open = false;
    NodeBuilder::new()
        .config(&config)
        .signal_handling_mode(SignalHandlingMode::Disabled)
        .create::<Ipc>()
        .expect("a node")
}

/// What stands for an instance in paths: FNV-1a over "UID INSTANCE".
fn tag(instance: &Instance) -> String {
    let text = format!("{} {}", rustix::process::getuid().as_raw(), instance.name());
    let hash = text
        .bytes()
        .fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3));
    format!("{:010x}", hash & 0xff_ffff_ffff)
}

/// The folder of an instance.
pub fn folder(instance: &Instance) -> PathBuf {
    PathBuf::from(format!("/dev/shm/ambidex-{}/{}", rustix::process::getuid().as_raw(), tag(instance)))
}

pub fn service(controller: &str, what: &str) -> ServiceName {
    ServiceName::new(&format!("ambidex/v{WIRE_VERSION}/{controller}/{what}")).expect("a name")
}

pub fn goals<A, B>(
    node: &Node<Ipc>,
    controller: &str,
) -> Result<request_response::PortFactory<Ipc, A, (), B, ()>, impl Debug>
where
    A: Debug + ZeroCopySend + 'static,
    B: Debug + ZeroCopySend + 'static,
{
    node.service_builder(&service(controller, "goals"))
        .request_response::<A, B>()
        .enable_safe_overflow_for_requests(false)
        .enable_safe_overflow_for_responses(false)
        .enable_fire_and_forget_requests(false)
        .max_active_requests_per_client(16)
        .max_loaned_requests(2)
        .max_response_buffer_size(32)
        .max_borrowed_responses_per_pending_response(2)
        .max_servers(1)
        .max_clients(2)
        .max_nodes(12)
        .open_or_create()
}

/// `pulse` and `beat`.
pub fn samples<T: Debug + ZeroCopySend + 'static>(
    node: &Node<Ipc>,
    controller: &str,
    what: &str,
) -> Result<publish_subscribe::PortFactory<Ipc, T, ()>, impl Debug> {
    node.service_builder(&service(controller, what))
        .publish_subscribe::<T>()
        .enable_safe_overflow(true)
        .subscriber_max_buffer_size(1)
        .history_size(1)
        .subscriber_max_borrowed_samples(2)
        .max_publishers(2)
        .max_subscribers(6)
        .max_nodes(12)
        .open_or_create()
}

pub fn reports<T: Debug + ZeroCopySend + 'static>(
    node: &Node<Ipc>,
    controller: &str,
) -> Result<publish_subscribe::PortFactory<Ipc, T, ()>, impl Debug> {
    node.service_builder(&service(controller, "reports"))
        .publish_subscribe::<T>()
        .enable_safe_overflow(false)
        .subscriber_max_buffer_size(64)
        .history_size(0)
        .subscriber_max_borrowed_samples(2)
        .max_publishers(2)
        .max_subscribers(2)
        .max_nodes(12)
        .open_or_create()
}

pub fn wake(
    node: &Node<Ipc>,
    controller: &str,
    what: &str,
    listeners: usize,
) -> Result<event::PortFactory<Ipc>, impl Debug> {
    node.service_builder(&service(controller, what))
        .event()
        .max_listeners(listeners)
        .max_notifiers(2)
        .max_nodes(12)
        .event_id_max_value(15)
        .open_or_create()
}

impl Peer {
    /// Takes its place, as an arm that holds nothing.
    pub fn enter(instance: &Instance, controller: &str) -> Self {
        let lock = instance.lock_controller(controller).expect("the place is free");
        Self::open(instance, controller, Some(lock))
    }

    /// Opens the ports, whoever has the place.
    pub fn open(instance: &Instance, controller: &str, lock: Option<Lock>) -> Self {
        let node = node(instance);
        let fail = |_: &_| BackpressureAction::DiscardDataAndFail;
        let notifier = wake(&node, controller, "wake-daemon", 6).expect("a service");
        let pulses = samples(&node, controller, "pulse").expect("a service");
        let reports = reports(&node, controller).expect("a service");
        let goals = goals(&node, controller).expect("a service");
        Self {
            notifier: notifier.notifier_builder().create().expect("a port"),
            pulses: pulses.publisher_builder().set_backpressure_handler(fail).create().expect("a port"),
            reports: reports.publisher_builder().set_backpressure_handler(fail).create().expect("a port"),
            server: goals.server_builder().set_backpressure_handler(fail).create().expect("a port"),
            id: WireId::default(),
            state: WireState { kind: state_kind::ARM, position: [0.35, 0.25, 0.9], ..WireState::default() },
            origin_ns: 0,
            speed: 1.0,
            pulsed: None,
            answered: Vec::new(),
            _node: node,
            _lock: lock,
        }
    }

    pub fn ring(&self) {
        let _ = self.notifier.notify();
    }

    /// Robot time now, in whole steps.
    pub fn now_us(&self) -> u64 {
        let passed_ns = monotonic_ns().saturating_sub(self.origin_ns);
        (passed_ns as f64 * self.speed / 1e3) as u64 / 10_000 * 10_000
    }

    /// A pulse as it should be.
    pub fn pulse(&self) -> WirePulse {
        WirePulse {
            version: WIRE_VERSION,
            pid: std::process::id(),
            epoch: self.id.epoch,
            generation: self.id.generation,
            inhibited: 0,
            sent_ns: monotonic_ns(),
            at_us: if self.id.generation == 0 { 0 } else { self.now_us() },
            state: self.state,
        }
    }

    pub fn publish(&mut self, pulse: WirePulse) {
        let is_first = self.pulsed.is_none();
        self.pulsed = Some(Instant::now());
        let _ = self.pulses.send_copy(pulse);
        if is_first {
            self.ring();
        }
    }

    /// A pulse that wakes nobody.
    pub fn throw(&self, pulse: WirePulse) {
        let _ = self.pulses.send_copy(pulse);
    }

    /// Pulses when it is time to.
    pub fn live(&mut self) {
        if self.pulsed.is_none_or(|at| at.elapsed() >= PULSE_EVERY) {
            self.publish(self.pulse());
        }
    }

    /// The next request, while it pulses.
    pub fn request(&mut self) -> Request {
        loop {
            self.live();
            if let Some(request) = self.server.receive().expect("a port") {
                return request;
            }
            thread::sleep(POLL);
        }
    }

    /// Answers the first `CONFIGURE`.
    pub fn attach(&mut self) {
        let request = self.configuration();
        self.configure(&request);
    }

    /// The next `CONFIGURE`, which is not answered.
    pub fn configuration(&mut self) -> Request {
        loop {
            let request = self.request();
            if request.kind == request_kind::CONFIGURE {
                (self.origin_ns, self.speed) = (request.origin_ns, request.speed);
                return request;
            }
        }
    }

    /// Answers a `CONFIGURE` as it should be.
    pub fn configure(&mut self, request: &Request) {
        (self.id, self.origin_ns, self.speed) = (request.id, request.origin_ns, request.speed);
        self.send(request, self.word(request, response_kind::CONFIGURED));
        self.publish(self.pulse());
    }

    /// The next goal; configurations on the way are answered, cancels are not.
    pub fn goal(&mut self) -> Request {
        loop {
            let request = self.request();
            match request.kind {
                request_kind::CONFIGURE => {
                    self.configure(&request);
                }
                request_kind::GOAL => return request,
                _ => {}
            }
        }
    }

    /// A response as it should be.
    pub fn word(&self, request: &WireRequest, kind: u32) -> WireResponse {
        let now_us = self.now_us();
        WireResponse {
            version: WIRE_VERSION,
            kind,
            id: request.id,
            end: end::SUCCEEDED,
            progress: 0.5,
            began_us: now_us,
            ended_us: now_us,
            state: self.state,
            ..WireResponse::default()
        }
    }

    /// Sends a response, whether or not there is room for it.
    pub fn send(&self, request: &Request, response: WireResponse) -> bool {
        let sent = request.send_copy(response).is_ok();
        self.ring();
        sent
    }

    pub fn accept(&self, goal: &Request) {
        self.send(goal, self.word(goal, response_kind::ACCEPTED));
    }

    /// Does a goal at once, and ends its stream.
    pub fn obey(&mut self, goal: Request) {
        self.accept(&goal);
        self.finish(goal);
    }

    /// Does a goal that it has accepted.
    pub fn finish(&mut self, goal: Request) {
        self.hold(&goal);
        self.send(&goal, self.word(&goal, response_kind::RESULT));
    }

    /// Does whatever was asked for, at once.
    pub fn do_at_once(&mut self, request: Request) {
        match request.kind {
            request_kind::CONFIGURE => self.configure(&request),
            request_kind::GOAL => self.obey(request),
            _ => {}
        }
    }

    /// What is in the gripper after a goal.
    pub fn hold(&mut self, goal: &WireRequest) {
        match goal.command {
            command::GRASP => self.state.holds = goal.object,
            command::PUT => self.state.holds = WireName::default(),
            _ => {}
        }
    }

    /// Keeps a stream open, and lets go of the oldest where they become too many for the transport.
    pub fn keep(&mut self, request: Request) {
        self.answered.push(request);
        if self.answered.len() > 8 {
            self.answered.remove(0);
        }
    }

    /// A good controller from now on.
    pub fn behave(&mut self) -> ! {
        loop {
            let goal = self.goal();
            self.obey(goal);
        }
    }

    /// Lives, and answers nothing.
    pub fn idle(&mut self, length: Duration) {
        let begun = Instant::now();
        while begun.elapsed() < length {
            self.live();
            thread::sleep(POLL);
        }
    }
}
