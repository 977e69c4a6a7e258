//! Whoever is asked: the socket, its clients, and the way to the supervisor and back.

use std::fs::{self, Permissions};
use std::io;
use std::os::unix::fs::PermissionsExt;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use tokio::io::{AsyncBufReadExt, AsyncReadExt, AsyncWriteExt, BufReader};
use tokio::net::{UnixListener, UnixStream};
use tokio::sync::{mpsc, oneshot};
use tokio::task::JoinSet;
use tokio::time::{sleep, timeout};

use super::protocol::{Answer, LINE_MAX, Why, answer_line};
use super::words;
use crate::supervisor::Control;
use ambidex_link::IpcNode;
use ambidex_model::MissionSpec;

/// Who may be connected at once; one more is told that it is too many.
const CLIENTS_MAX: usize = 8;
/// How long a client may take for a line, be it to write or to read one.
const LINE_WITHIN: Duration = Duration::from_secs(10);
/// How long no client is taken when one could not be, as when there are no descriptors.
const PAUSE: Duration = Duration::from_millis(100);
/// How long those that wait for an answer are told that the run is over.
const LAST_WORDS: Duration = Duration::from_millis(100);

/// Why the socket could not be had.
#[derive(Debug, thiserror::Error)]
#[error("cannot make the socket {path}")]
pub struct ControlError {
    path: PathBuf,
    source: io::Error,
}

/// The socket of a daemon, there until this is dropped.
#[derive(Debug)]
pub struct ControlSocket {
    listener: UnixListener,
    path: PathBuf,
    /// As long as it is held no other daemon takes the place, whose socket would be removed.
    _node: IpcNode,
}

impl ControlSocket {
    /// Makes the socket of the instance in which the node is the daemon's, within a runtime of tokio. One that a killed
    /// daemon left gives way.
    ///
    /// # Errors
    /// [`ControlError`] when it cannot be made.
    pub fn open(node: &IpcNode) -> Result<Self, ControlError> {
        let path = node.instance().control_socket();
        let made = path.with_extension("new");
        // It gets its name once nobody else can open it.
        let bind = || {
            match fs::remove_file(&made) {
                Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error),
                Ok(()) | Err(_) => {}
            }
            let listener = UnixListener::bind(&made)?;
            fs::set_permissions(&made, Permissions::from_mode(0o600))?;
            fs::rename(&made, &path)?;
            Ok(listener)
        };
        match bind() {
            Ok(listener) => Ok(Self { listener, path, _node: node.clone() }),
            Err(source) => Err(ControlError { path, source }),
        }
    }

    /// Takes clients and their requests for a run of the mission, until the other end of `over` is dropped; then those
    /// that wait are told so.
    pub async fn serve(
        self,
        mission: Arc<MissionSpec>,
        run: mpsc::UnboundedSender<Control>,
        mut over: oneshot::Receiver<()>,
    ) {
        let mut clients = JoinSet::new();
        loop {
            let stream = tokio::select! {
                _ = &mut over => break,
                accepted = self.listener.accept() => match accepted {
                    Ok((stream, _)) => stream,
                    Err(error) => {
                        tracing::warn!(%error, "nobody can be heard over the socket for now");
                        sleep(PAUSE).await;
                        continue;
                    }
                },
                Some(_) = clients.join_next() => continue,
            };
            // The folder keeps others out; whoever came by another way is no user of this robot either.
            let own = rustix::process::getuid().as_raw();
            if stream.peer_cred().is_ok_and(|peer| peer.uid() == own) {
                let client = Client { mission: Arc::clone(&mission), run: run.clone() };
                if clients.len() < CLIENTS_MAX {
                    clients.spawn(client.serve(stream));
                } else {
                    turn_away(&stream);
                }
            }
        }
        drop(run);
        let told = async { while clients.join_next().await.is_some() {} };
        // Who is connected and asks nothing is not waited for.
        let _ = timeout(LAST_WORDS, told).await;
    }
}

impl Drop for ControlSocket {
    fn drop(&mut self) {
        // A folder that was removed has taken it along.
        let _ = fs::remove_file(&self.path);
    }
}

/// Tells one client too many so, as far as it can be told at once.
fn turn_away(stream: &UnixStream) {
    let said = format!("{CLIENTS_MAX} others are asking");
    let busy = Answer::Refused { why: Why::Busy, said, help: Some("try again".into()) };
    // What does not fit is not awaited.
    let _ = stream.try_write(answer_line(&busy).as_bytes());
}

/// One who asks.
struct Client {
    mission: Arc<MissionSpec>,
    run: mpsc::UnboundedSender<Control>,
}

impl Client {
    /// Answers line by line, until the client leaves, says nothing for too long, or says what is no line.
    async fn serve(self, mut stream: UnixStream) {
        let (from, mut to) = stream.split();
        let mut from = BufReader::with_capacity(LINE_MAX, from);
        let mut line = Vec::new();
        loop {
            line.clear();
            let mut bounded = (&mut from).take(LINE_MAX as u64);
            let Ok(Ok(_)) = timeout(LINE_WITHIN, bounded.read_until(b'\n', &mut line)).await else { return };
            if line.is_empty() {
                return;
            }
            let is_whole = line.ends_with(b"\n");
            let answer = if is_whole { self.answer(&line).await } else { too_long() };
            let written = answer_line(&answer);
            let Ok(Ok(())) = timeout(LINE_WITHIN, to.write_all(written.as_bytes())).await else { return };
            if !is_whole {
                return;
            }
        }
    }

    async fn answer(&self, line: &[u8]) -> Answer {
        let change = match words::asked(line, &self.mission.names) {
            Ok(change) => change,
            Err(answer) => return answer,
        };
        let (to_client, answer) = oneshot::channel();
        if self.run.send(Control::Ask(change, to_client)).is_err() {
            return words::over();
        }
        answer.await.map_or_else(|_| words::over(), |uptake| words::answer(&change, uptake, &self.mission))
    }
}

fn too_long() -> Answer {
    let said = format!("that is no request: a line ends after {LINE_MAX} bytes at most");
    Answer::Refused { why: Why::Malformed, said, help: None }
}
