//! The thread that answers: it takes connections and follows the run, and ends with it.

use std::io;
use std::sync::Arc;
use std::thread::{self, JoinHandle};
use std::time::Duration;

use axum::Router;
use hyper_util::server::graceful::GracefulShutdown;
use tokio::io::{AsyncRead, AsyncWrite};
use tokio::net::{TcpListener, TcpStream, UnixListener, UnixStream};
use tokio::sync::{Semaphore, mpsc, oneshot};
use tokio::time::{sleep, timeout};

use crate::connection::answering;
use crate::endpoint::Endpoint;
use crate::gate::Way;
use crate::hub::{Hub, News};
use crate::limits::{CONNECTIONS_MAX, LAST_WORDS};
use crate::routes::Served;
use ambidex_model::MissionSpec;
use ambidex_runtime::{Control, Feed as Diagnoses};

/// How long nobody is taken when one could not be, as when there are no descriptors.
const PAUSE: Duration = Duration::from_millis(100);

/// What one connection too many is told.
const BUSY: &str = "HTTP/1.1 503 Service Unavailable\r\ncontent-type: application/problem+json\r\nretry-after: 1\r\n\
                    connection: close\r\ncontent-length: 117\r\n\r\n\
                    {\"status\":503,\"title\":\"Service Unavailable\",\"detail\":\"32 others are connected\",\
                    \"why\":\"busy\",\"help\":\"try again later\"}";

/// Who answers, in a thread of its own. When it is dropped whoever waits is told that the run is over, and streams get
/// their last events, which takes half a second at most.
#[derive(Debug)]
pub struct Server {
    over: Option<oneshot::Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

impl Server {
    /// Begins to answer for a run of the mission, from what the hub is told of it.
    ///
    /// # Errors
    /// When the system gives no thread, or no way to wait for connections.
    pub fn start(
        endpoint: Endpoint,
        mission: Arc<MissionSpec>,
        run: mpsc::UnboundedSender<Control>,
        hub: Hub,
        news: mpsc::Receiver<News>,
        diagnostics: Diagnoses,
    ) -> io::Result<Self> {
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
        let (over, is_over) = oneshot::channel();
        let served = Served::new(mission, run, hub.clone(), diagnostics, endpoint.token.clone());
        let serve = move || runtime.block_on(serve(endpoint, served, hub, news, is_over));
        let thread = thread::Builder::new().name("http".into()).spawn(move || {
            if let Err(error) = serve() {
                tracing::error!(%error, "nobody can be heard any more");
            }
        })?;
        Ok(Self { over: Some(over), thread: Some(thread) })
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        self.over = None;
        // It has said why, if it ended otherwise.
        let _ = self.thread.take().map(JoinHandle::join);
    }
}

async fn serve(
    mut endpoint: Endpoint,
    served: Served,
    hub: Hub,
    news: mpsc::Receiver<News>,
    mut over: oneshot::Receiver<()>,
) -> io::Result<()> {
    let loopback = endpoint.loopback.take();
    let loopback = loopback.map(|(listener, at)| Ok::<_, io::Error>((TcpListener::from_std(listener)?, at)));
    let loopback = loopback.transpose()?.map(|(listener, at)| (listener, served.clone().router(Way::Loopback(at))));
    let socket = UnixListener::from_std(endpoint.listener.try_clone()?)?;
    let socket_router = served.router(Way::Socket);
    let (end_following, following_ends) = oneshot::channel();
    let following = tokio::spawn(hub.follow(news, following_ends));
    let clients = Clients::new();
    loop {
        let taken = tokio::select! {
            _ = &mut over => break,
            accepted = socket.accept() => accepted.map(|(stream, _)| clients.take_local(stream, &socket_router)),
            accepted = accept(loopback.as_ref()) => {
                accepted.map(|(stream, router)| clients.take(stream, router, TcpStream::try_write))
            }
        };
        if let Err(error) = taken {
            tracing::warn!(%error, "nobody can be heard for now");
            sleep(PAUSE).await;
        }
    }
    drop((end_following, socket, loopback));
    let last_words = async {
        // It ends by itself; a panic in it is told by whoever sees it.
        let _ = following.await;
        clients.graceful.shutdown().await;
    };
    // Who does not listen is not waited for.
    let _ = timeout(LAST_WORDS, last_words).await;
    Ok(())
}

/// The next one over loopback; never where it is not served.
async fn accept(loopback: Option<&(TcpListener, Router)>) -> io::Result<(TcpStream, &Router)> {
    match loopback {
        Some((listener, router)) => listener.accept().await.map(|(stream, _)| (stream, router)),
        None => std::future::pending().await,
    }
}

/// Who is connected.
struct Clients {
    room: Arc<Semaphore>,
    graceful: GracefulShutdown,
}

impl Clients {
    fn new() -> Self {
        Self { room: Arc::new(Semaphore::new(CONNECTIONS_MAX)), graceful: GracefulShutdown::new() }
    }

    /// Answers one of the same user. The folder keeps others out; whoever came by another way is no user of this robot
    /// either.
    fn take_local(&self, stream: UnixStream, router: &Router) {
        let own = rustix::process::getuid().as_raw();
        if stream.peer_cred().is_ok_and(|peer| peer.uid() == own) {
            self.take(stream, router, UnixStream::try_write);
        }
    }

    /// Answers one more, or tells it that it is too many, as far as that can be told at once.
    fn take<I>(&self, stream: I, router: &Router, try_write: impl Fn(&I, &[u8]) -> io::Result<usize>)
    where
        I: AsyncRead + AsyncWrite + Send + 'static,
    {
        let Ok(place) = Arc::clone(&self.room).try_acquire_owned() else {
            // What does not fit is not awaited.
            let _ = try_write(&stream, BUSY.as_bytes());
            return;
        };
        let answering = self.graceful.watch(answering(router.clone(), stream));
        tokio::spawn(async move {
            // How it ended is for whoever asked.
            let _ = answering.await;
            drop(place);
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_one_too_many_is_told_is_an_answer() {
        let (head, body) = BUSY.split_once("\r\n\r\n").expect("a head and a body");
        assert!(
            head.contains(&format!("content-length: {}\r\n", body.len())) || head.ends_with(&body.len().to_string())
        );
        let problem: crate::Problem = serde_json::from_str(body).expect("a problem");
        assert_eq!(problem.why, ambidex_runtime::control::Why::Busy);
        assert!(problem.detail.starts_with(&CONNECTIONS_MAX.to_string()));
    }
}
