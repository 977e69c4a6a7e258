//! The six services between daemon and one controller: names and settings, the same for whoever comes first.

use std::fmt::Display;

use iceoryx2::port::BackpressureAction;
use iceoryx2::port::client::Client;
use iceoryx2::port::publisher::Publisher;
use iceoryx2::port::server::Server;
use iceoryx2::port::subscriber::Subscriber;
use iceoryx2::prelude::{ServiceName, ZeroCopySend};
use iceoryx2::service::port_factory::{event, publish_subscribe, request_response};

use crate::error::IpcError;
use crate::instances::Transport;
use crate::node::IpcNode;
use crate::wire::{WIRE_VERSION, WireBeat, WirePulse, WireReport, WireRequest, WireResponse};

/// Requests under way at once: a goal, its cancel and a configuration, and as many of an attachment that is given up.
pub(super) const REQUESTS_MAX: usize = 16;
/// Responses that wait in one stream: three seconds of feedback.
pub(super) const RESPONSES_MAX: usize = 32;
/// One controller of a name, see `instances`.
const SERVERS_MAX: usize = 1;
/// One daemon, and one that died and is not cleaned up yet.
const CLIENTS_MAX: usize = 2;
/// As above.
pub(super) const WRITERS_MAX: usize = 2;
/// The other side, one that died, and people who look on.
const READERS_MAX: usize = 6;
const NODES_MAX: usize = 12;
/// Reports that wait for the daemon. None makes room for the next: whoever cannot send one says it again.
pub(super) const REPORTS_MAX: usize = 64;

pub(super) type Goals = Client<Transport, WireRequest, (), WireResponse, ()>;
pub(super) type GoalServer = Server<Transport, WireRequest, (), WireResponse, ()>;
pub(super) type Pulses = Subscriber<Transport, WirePulse, ()>;
pub(super) type PulsePublisher = Publisher<Transport, WirePulse, ()>;
pub(super) type Beats = Subscriber<Transport, WireBeat, ()>;
pub(super) type BeatPublisher = Publisher<Transport, WireBeat, ()>;
pub(super) type Reports = Subscriber<Transport, WireReport, ()>;
pub(super) type ReportPublisher = Publisher<Transport, WireReport, ()>;
pub(super) type Listener = iceoryx2::port::listener::Listener<Transport>;
pub(super) type Notifier = iceoryx2::port::notifier::Notifier<Transport>;

type GoalService = request_response::PortFactory<Transport, WireRequest, (), WireResponse, ()>;

/// The services of one controller.
pub(super) struct Services<'a> {
    node: &'a IpcNode,
    controller: &'a str,
}

impl<'a> Services<'a> {
    pub(super) fn new(node: &'a IpcNode, controller: &'a str) -> Self {
        Self { node, controller }
    }

    /// The daemon's side of `goals`.
    pub(super) fn client(&self) -> Result<Goals, IpcError> {
        let name = self.name("goals");
        self.goals(&name)?
            .client_builder()
            .set_backpressure_handler(|_| BackpressureAction::DiscardDataAndFail)
            .create()
            .map_err(IpcError::service(&name))
    }

    /// The controller's side of `goals`.
    pub(super) fn server(&self) -> Result<GoalServer, IpcError> {
        let name = self.name("goals");
        self.goals(&name)?
            .server_builder()
            .set_backpressure_handler(|_| BackpressureAction::DiscardDataAndFail)
            .create()
            .map_err(IpcError::service(&name))
    }

    pub(super) fn pulses(&self) -> Result<Pulses, IpcError> {
        self.subscriber("pulse")
    }

    pub(super) fn pulse_publisher(&self) -> Result<PulsePublisher, IpcError> {
        self.publisher("pulse")
    }

    pub(super) fn beats(&self) -> Result<Beats, IpcError> {
        self.subscriber("beat")
    }

    pub(super) fn beat_publisher(&self) -> Result<BeatPublisher, IpcError> {
        self.publisher("beat")
    }

    pub(super) fn reports(&self) -> Result<Reports, IpcError> {
        let name = self.name("reports");
        self.queue(&name)?.subscriber_builder().create().map_err(IpcError::service(&name))
    }

    pub(super) fn report_publisher(&self) -> Result<ReportPublisher, IpcError> {
        let name = self.name("reports");
        self.queue(&name)?
            .publisher_builder()
            .set_backpressure_handler(|_| BackpressureAction::DiscardDataAndFail)
            .create()
            .map_err(IpcError::service(&name))
    }

    /// What wakes the daemon.
    pub(super) fn daemon_listener(&self) -> Result<Listener, IpcError> {
        self.listener("wake-daemon")
    }

    pub(super) fn daemon_notifier(&self) -> Result<Notifier, IpcError> {
        self.notifier("wake-daemon")
    }

    /// What wakes the controller.
    pub(super) fn controller_listener(&self) -> Result<Listener, IpcError> {
        self.listener("wake-controller")
    }

    pub(super) fn controller_notifier(&self) -> Result<Notifier, IpcError> {
        self.notifier("wake-controller")
    }

    fn goals(&self, name: &str) -> Result<GoalService, IpcError> {
        self.node
            .node()
            .service_builder(&service_name(name)?)
            .request_response::<WireRequest, WireResponse>()
            .enable_safe_overflow_for_requests(false)
            .enable_safe_overflow_for_responses(false)
            .enable_fire_and_forget_requests(false)
            .max_active_requests_per_client(REQUESTS_MAX)
            .max_loaned_requests(2)
            .max_response_buffer_size(RESPONSES_MAX)
            .max_borrowed_responses_per_pending_response(2)
            .max_servers(SERVERS_MAX)
            .max_clients(CLIENTS_MAX)
            .max_nodes(NODES_MAX)
            .open_or_create()
            .map_err(IpcError::service(name))
    }

    /// What is read one by one, unlike samples, of which the last counts.
    fn queue(&self, name: &str) -> Result<publish_subscribe::PortFactory<Transport, WireReport, ()>, IpcError> {
        self.node
            .node()
            .service_builder(&service_name(name)?)
            .publish_subscribe::<WireReport>()
            .enable_safe_overflow(false)
            .subscriber_max_buffer_size(REPORTS_MAX)
            .history_size(0)
            .subscriber_max_borrowed_samples(2)
            .max_publishers(WRITERS_MAX)
            .max_subscribers(CLIENTS_MAX)
            .max_nodes(NODES_MAX)
            .open_or_create()
            .map_err(IpcError::service(name))
    }

    fn samples<T>(&self, name: &str) -> Result<publish_subscribe::PortFactory<Transport, T, ()>, IpcError>
    where
        T: std::fmt::Debug + ZeroCopySend + 'static,
    {
        self.node
            .node()
            .service_builder(&service_name(name)?)
            .publish_subscribe::<T>()
            .enable_safe_overflow(true)
            .subscriber_max_buffer_size(1)
            .history_size(1)
            .subscriber_max_borrowed_samples(2)
            .max_publishers(WRITERS_MAX)
            .max_subscribers(READERS_MAX)
            .max_nodes(NODES_MAX)
            .open_or_create()
            .map_err(IpcError::service(name))
    }

    fn subscriber<T>(&self, what: &str) -> Result<Subscriber<Transport, T, ()>, IpcError>
    where
        T: std::fmt::Debug + ZeroCopySend + 'static,
    {
        let name = self.name(what);
        self.samples(&name)?.subscriber_builder().create().map_err(IpcError::service(&name))
    }

    fn publisher<T>(&self, what: &str) -> Result<Publisher<Transport, T, ()>, IpcError>
    where
        T: std::fmt::Debug + ZeroCopySend + 'static,
    {
        let name = self.name(what);
        self.samples(&name)?
            .publisher_builder()
            .set_backpressure_handler(|_| BackpressureAction::DiscardDataAndFail)
            .create()
            .map_err(IpcError::service(&name))
    }

    fn wake(&self, name: &str) -> Result<event::PortFactory<Transport>, IpcError> {
        self.node
            .node()
            .service_builder(&service_name(name)?)
            .event()
            .max_listeners(READERS_MAX)
            .max_notifiers(WRITERS_MAX)
            .max_nodes(NODES_MAX)
            .event_id_max_value(15)
            .open_or_create()
            .map_err(IpcError::service(name))
    }

    fn listener(&self, what: &str) -> Result<Listener, IpcError> {
        let name = self.name(what);
        let service = self.wake(&name)?;
        service.listener_builder().create().map_err(IpcError::service(&name))
    }

    fn notifier(&self, what: &str) -> Result<Notifier, IpcError> {
        let name = self.name(what);
        let service = self.wake(&name)?;
        service.notifier_builder().create().map_err(IpcError::service(&name))
    }

    fn name(&self, what: impl Display) -> String {
        format!("ambidex/v{WIRE_VERSION}/{}/{what}", self.controller)
    }
}

/// Rings at whoever listens. Nobody there, or one who is asleep for long, is no fault: wake-ups are hints.
pub(super) fn ring(notifier: &Notifier) {
    if let Err(error) = notifier.notify() {
        tracing::trace!(%error, "nobody could be woken");
    }
}

fn service_name(name: &str) -> Result<ServiceName, IpcError> {
    ServiceName::new(name).map_err(IpcError::service(name))
}
