//! Requests of the control interface as its server takes them, and its answers as the client does.

use std::sync::{Arc, LazyLock};

use ambidex::http::{Hub, Problem, Served, Token, Way, answer, answer_of};
use ambidex::model::{MissionSpec, Uptake};
use ambidex::record::History;
use ambidex::runtime::control::{self, Answer, Refusal};
use ambidex::runtime::{Clock, Control};
use ambidex::tree::Settings;
use serde_json::Value;
use tokio::io::{AsyncReadExt, AsyncWriteExt, duplex};
use tokio::sync::mpsc;

use super::Taken;
use super::files::loaded;

/// Longest problem: none repeats more than the beginning of what was said.
const PROBLEM: usize = 4096;
/// Room for every request on its way.
const ROOM: usize = 4 * 1024 * 1024;

/// A text of JSON as a request with `method`, `path`, `headers` and `body`; anything else as the bytes of one.
pub fn control(text: &[u8]) -> Taken {
    let token = Token::fresh().expect("chance");
    let request = serde_json::from_slice(text).map_or_else(|_| text.to_owned(), |value| request(&value, &token));
    // What is not said to its end is waited for; the clock goes on by itself then.
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().start_paused(true).build();
    let runtime = runtime.expect("a runtime");
    let said = runtime.block_on(asked(request, token));
    let mut taken = Taken::default();
    let Some((head, body)) = split(&said) else {
        assert!(said.is_empty(), "that is no answer: {}", String::from_utf8_lossy(&said));
        return taken;
    };
    let status: u16 = head.split(' ').nth(1).and_then(|status| status.parse().ok()).expect("a status");
    assert!(status < 500 || status == 503, "{head}");
    taken.said(&status.to_string());
    taken.accepted = status < 300;
    if head.contains("application/problem+json") {
        assert!(body.len() <= PROBLEM, "a problem is too long: {} bytes", body.len());
        let problem: Problem = serde_json::from_slice(body).expect("a problem");
        assert_eq!(problem.status, status);
        taken.said(&format!("{:?}", problem.why));
    }
    for status in [200_u16, 201, 409] {
        match answer_of(status.try_into().expect("a status"), text) {
            Ok(answer) => taken.said(&format!("{answer:?}")),
            Err(error) => taken.said(&error.to_string()),
        }
    }
    taken
}

/// What is answered to these bytes by a run that changes the world and has a mission of its own.
async fn asked(request: Vec<u8>, token: Token) -> Vec<u8> {
    static MISSION: LazyLock<Arc<MissionSpec>> = LazyLock::new(|| {
        let text = include_str!("../../../config/missions/door.yaml");
        loaded(text.as_bytes()).expect("a shipped mission loads").mission
    });
    let (run, mut control) = mpsc::unbounded_channel();
    tokio::spawn(async move {
        while let Some(told) = control.recv().await {
            match told {
                Control::Ask(change, answer) => {
                    let decided = change.with_ids(&MISSION.names);
                    let taken = |change| control::answer(&change, Uptake::Changed, &MISSION);
                    drop(answer.send(decided.map_or_else(Answer::Refused, taken)));
                }
                Control::Work(_, answer) => drop(answer.send(Answer::Refused(Refusal::takes_no_work()))),
                Control::Cancel | Control::World(_) | Control::GiveUp | Control::Abort(_) => {
                    unreachable!("nobody can say that")
                }
            }
        }
    });
    let hub = Hub::new(History::new(&Settings::default().header(&MISSION)), Clock::start(1.0));
    let served = Served::new(Arc::clone(&MISSION), run, hub, tokio::sync::watch::channel(Arc::default()).1, token);
    let (mut ours, theirs) = duplex(ROOM);
    let answering = tokio::spawn(answer(served, Way::Socket, theirs));
    ours.write_all(&request).await.expect("there is room");
    let mut said = Vec::new();
    let mut bytes = [0; 4096];
    while let Ok(count @ 1..) = ours.read(&mut bytes).await {
        said.extend_from_slice(&bytes[..count]);
        // A stream of events has no end.
        if said.windows(17).any(|words| words == b"text/event-stream") {
            break;
        }
    }
    answering.abort();
    said
}

/// The bytes of a request, which comes to its end and has the token.
fn request(value: &Value, token: &Token) -> Vec<u8> {
    let word = |key: &str| value[key].as_str().unwrap_or_default().to_owned();
    let body = match &value["body"] {
        Value::Null => String::new(),
        Value::String(text) => text.clone(),
        body => body.to_string(),
    };
    let headers = value["headers"].as_object().into_iter().flatten();
    let headers: String =
        headers.map(|(name, value)| format!("{name}: {}\r\n", value.as_str().unwrap_or("x"))).collect();
    format!(
        "{} {} HTTP/1.1\r\nconnection: close\r\ncontent-type: application/json\r\nauthorization: {}\r\n\
         content-length: {}\r\n{headers}\r\n{body}",
        word("method"),
        word("path"),
        token.header(),
        body.len()
    )
    .into_bytes()
}

/// An answer: its head, and as much of a body as that says. Behind it another may follow.
fn split(said: &[u8]) -> Option<(String, &[u8])> {
    let end = said.windows(4).position(|end| end == b"\r\n\r\n")?;
    let head = std::str::from_utf8(&said[..end]).ok()?.to_lowercase();
    let length = head.lines().find_map(|line| line.strip_prefix("content-length: ")?.parse().ok());
    let body = &said[end + 4..];
    Some((head, &body[..length.unwrap_or(body.len()).min(body.len())]))
}
