//! Requests as bytes, over streams in memory and a clock that stands still while nobody waits.

use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use serde_json::Value;
use tokio::io::{AsyncReadExt, AsyncWriteExt, DuplexStream, duplex};
use tokio::sync::mpsc;
use tokio::time::Instant;

use crate::limits::{BODY_MAX, BODY_WITHIN, FILES_MAX, HEAD_WITHIN, Rate, STREAMS_MAX, TAKEN_WITHIN};
use crate::{Hub, News, Served, Token, Way, answer, document};
use ambidex_files::{Disk, load_mission};
use ambidex_model::{MissionSpec, Uptake};
use ambidex_record::{History, samples};
use ambidex_runtime::control::{self, Answer, Refusal, WorldChange};
use ambidex_runtime::{Clock, Control};

/// Of the clock of the test, which stands still while anything goes on.
const HOUR: Duration = Duration::from_secs(3_600);
const LOOPBACK: &str = "127.0.0.1:8080";

/// What is asked, with somebody who decides in the place of a run.
struct Asked {
    served: Served,
    token: Token,
    hub: Hub,
}

/// What a run says that takes whatever has names.
fn decided(change: &WorldChange) -> Answer {
    let (mission, taken) = (mission(), Uptake::Changed);
    change.with_ids(&mission.names).map_or_else(Answer::Refused, |change| control::answer(&change, taken, &mission))
}

impl Asked {
    fn new() -> Self {
        let (run, mut control) = mpsc::unbounded_channel();
        tokio::spawn(async move {
            while let Some(told) = control.recv().await {
                match told {
                    Control::Ask(change, answer) => drop(answer.send(decided(&change))),
                    Control::Work(_, answer) => drop(answer.send(Answer::Refused(Refusal::takes_no_work()))),
                    other => panic!("nobody says {other:?}"),
                }
            }
        });
        Self::of(run)
    }

    fn of(run: mpsc::UnboundedSender<Control>) -> Self {
        let mission = mission();
        let header = ambidex_model::Header::new(&mission, "greedy", false);
        let hub = Hub::new(History::new(&header), Clock::start(1.0));
        let token = Token::fresh().expect("chance");
        let served =
            Served::new(mission, run, hub.clone(), tokio::sync::watch::channel(Arc::default()).1, token.clone());
        Self { served, token, hub }
    }

    /// Our end of a connection with so much room on its way.
    fn connect(&self, way: Way, room: usize) -> DuplexStream {
        let (ours, theirs) = duplex(room);
        tokio::spawn(answer(self.served.clone(), way, theirs));
        ours
    }

    /// The answer to a request with a body and the token, over the socket.
    async fn say(&self, method: &str, path: &str, body: &str) -> Said {
        self.say_with(Way::Socket, method, path, &[("content-type", "application/json"), self.auth()], body).await
    }

    /// A header that stands for the token.
    fn auth(&self) -> (&'static str, &'static str) {
        ("authorization", "token")
    }

    async fn say_with(&self, way: Way, method: &str, path: &str, headers: &[(&str, &str)], body: &str) -> Said {
        let header = |(name, value): &(&str, &str)| {
            let value = if *value == "token" { self.token.header() } else { (*value).to_owned() };
            format!("{name}: {value}\r\n")
        };
        let headers: String = headers.iter().map(header).collect();
        let length = body.len();
        let request =
            format!("{method} {path} HTTP/1.1\r\nconnection: close\r\ncontent-length: {length}\r\n{headers}\r\n{body}");
        let mut stream = self.connect(way, 2 * FILES_MAX);
        stream.write_all(request.as_bytes()).await.expect("it is taken");
        Said::read(&mut stream).await
    }
}

/// An answer.
#[derive(Debug)]
struct Said {
    status: u16,
    head: String,
    body: String,
}

impl Said {
    async fn read(stream: &mut DuplexStream) -> Self {
        let mut bytes = Vec::new();
        stream.read_to_end(&mut bytes).await.expect("an answer");
        let text = String::from_utf8(bytes).expect("text");
        let (head, body) = text.split_once("\r\n\r\n").unwrap_or_else(|| panic!("no answer: {text:?}"));
        let status = head.split(' ').nth(1).and_then(|status| status.parse().ok()).expect("a status");
        Self { status, head: head.to_lowercase(), body: body.to_owned() }
    }

    /// Asserts that it is a problem with this status and word.
    fn is(&self, status: u16, why: &str) {
        assert_eq!(self.status, status, "{self:?}");
        assert!(self.head.contains("content-type: application/problem+json"), "{self:?}");
        let body: Value = serde_json::from_str(&self.body).expect("a problem");
        assert_eq!((body["status"].as_u64(), body["why"].as_str()), (Some(status.into()), Some(why)), "{self:?}");
        assert!(body["detail"].as_str().is_some_and(|said| !said.is_empty()), "{self:?}");
    }
}

fn mission() -> Arc<MissionSpec> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../config/missions/door.yaml");
    load_mission(&Disk, &path, None, &[]).expect("a shipped mission loads").mission
}

#[tokio::test(start_paused = true)]
async fn what_is_asked_is_answered() {
    let asked = Asked::new();
    let said = asked.say("POST", "/v1/world/facts/door%20open", r#"{"holds":true}"#).await;
    assert_eq!((said.status, said.body.as_str()), (200, r#"{"result":"changed","said":"\"door open\" holds now"}"#));
    let said = asked.say("POST", "/v1/world/objects/parcel/place", r#"{"place":"hall"}"#).await;
    assert_eq!((said.status, said.body.contains("parcel is at hall now")), (200, true), "{said:?}");
    let status = asked.say_with(Way::Socket, "GET", "/v1/status", &[], "").await;
    let status: Value = serde_json::from_str(&status.body).expect("a snapshot");
    assert_eq!((status["mission"].as_str(), status["tasks"][0]["name"].as_str()), (Some("door"), Some("door")));
    for task in ["1", "door"] {
        let said = asked.say_with(Way::Socket, "GET", &format!("/v1/tasks/{task}"), &[], "").await;
        let said: Value = serde_json::from_str(&said.body).expect("a task");
        assert_eq!(said["nodes"].as_array().map(Vec::len), Some(5), "{said}");
    }
    asked.say("GET", "/v1/tasks/dor", "").await.is(404, "no_such_name");
    let source = r#"{"mission":"m.yaml","files":[{"path":"m.yaml","text":"task: {}"}]}"#;
    let submission = format!(r#"{{"source":{source},"priority":3}}"#);
    asked.say("POST", "/v1/tasks", &submission).await.is(409, "takes_no_work");
    let edit = format!(r#"{{"add":{{"under":"door","source":{source}}}}}"#);
    asked.say("POST", "/v1/tasks/1/edit", &edit).await.is(409, "takes_no_work");
    asked.say("POST", "/v1/tasks/1/edit", r#"{"remove":{"node":3}}"#).await.is(409, "takes_no_work");
    asked.say("DELETE", "/v1/tasks/1", "").await.is(409, "takes_no_work");
    for path in ["/v1/tasks/1/pause", "/v1/tasks/door/step", "/v1/pause", "/v1/resume", "/v1/step", "/v1/stop"] {
        asked.say("POST", path, "").await.is(409, "takes_no_work");
    }
}

#[tokio::test(start_paused = true)]
async fn what_is_no_request_is_refused_with_what_is_wrong() {
    let asked = Asked::new();
    let fact = "/v1/world/facts/door%20open";
    asked.say("POST", fact, "{").await.is(400, "malformed");
    asked.say("POST", fact, r#"{"holds":1}"#).await.is(422, "malformed");
    asked.say("POST", fact, r#"{"holds":true,"more":1}"#).await.is(422, "malformed");
    asked.say_with(Way::Socket, "POST", fact, &[asked.auth()], "{}").await.is(415, "malformed");
    asked.say("POST", "/v1/world/facts/dor%20open", r#"{"holds":true}"#).await.is(404, "no_such_name");
    asked.say("POST", "/v1/world/facts/%ff", r#"{"holds":true}"#).await.is(400, "malformed");
    asked.say("POST", "/v1/tasks", r#"{"name":"17","source":{"mission":"","files":[]}}"#).await.is(422, "malformed");
    asked.say("GET", "/v2/status", "").await.is(404, "no_such_path");
    asked.say("DELETE", "/v1/status", "").await.is(405, "no_such_path");
    let (run, control) = mpsc::unbounded_channel();
    drop(control);
    let over = Asked::of(run);
    over.say("POST", fact, r#"{"holds":true}"#).await.is(503, "over");
}

#[tokio::test(start_paused = true)]
async fn strangers_are_refused() {
    let asked = Asked::new();
    let way = Way::Loopback(LOOPBACK.parse().expect("an address"));
    let host = ("host", LOOPBACK);
    let said = asked.say_with(way, "GET", "/v1/status", &[host], "").await;
    assert_eq!(said.status, 200, "{said:?}");
    asked.say_with(way, "GET", "/v1/status", &[("host", "rebound.example:8080")], "").await.is(403, "foreign");
    let foreign = [host, ("origin", "http://evil.example"), asked.auth()];
    asked.say_with(way, "POST", "/v1/stop", &foreign, "").await.is(403, "foreign");
    let said = asked.say_with(way, "POST", "/v1/stop", &[host], "").await;
    said.is(401, "token");
    assert!(said.head.contains("www-authenticate: bearer"), "{said:?}");
    asked.say_with(way, "POST", "/v1/stop", &[host, asked.auth()], "").await.is(409, "takes_no_work");
    // Nobody learns without the token what there is.
    asked.say_with(Way::Socket, "POST", "/v1/nothing", &[], "").await.is(401, "token");
}

#[tokio::test(start_paused = true)]
async fn what_is_too_much_is_refused() {
    let asked = Asked::new();
    let fact = |length: usize| format!(r#"{{"holds":true{}}}"#, " ".repeat(length - r#"{"holds":true}"#.len()));
    let path = "/v1/world/facts/door%20open";
    assert_eq!(asked.say("POST", path, &fact(BODY_MAX)).await.status, 200);
    asked.say("POST", path, &fact(BODY_MAX + 1)).await.is(413, "too_large");
    asked.say("POST", "/v1/tasks", &fact(FILES_MAX)).await.is(422, "malformed");
    asked.say("POST", "/v1/tasks", &fact(FILES_MAX + 1)).await.is(413, "too_large");
    let asked = Asked { served: asked.served.clone().with_rate(Rate::of_one()), ..asked };
    asked.say("POST", "/v1/stop", "").await.is(409, "takes_no_work");
    let said = asked.say("POST", "/v1/stop", "").await;
    said.is(429, "too_often");
    assert!(said.head.contains("retry-after: 3600"), "{said:?}");
    assert_eq!(asked.say("GET", "/v1/tasks", "").await.status, 200, "to read is free");
}

#[tokio::test(start_paused = true)]
async fn who_is_slow_is_hung_up_on() {
    let asked = Asked::new();
    let began = Instant::now();
    let mut stream = asked.connect(Way::Socket, 1024);
    stream.write_all(b"GET /v1/status HT").await.expect("it is taken");
    let mut rest = Vec::new();
    stream.read_to_end(&mut rest).await.expect("its end");
    assert!(began.elapsed() >= HEAD_WITHIN && began.elapsed() < 2 * HEAD_WITHIN, "{:?}", began.elapsed());
    let began = Instant::now();
    let mut stream = asked.connect(Way::Socket, 1024);
    let token = asked.token.header();
    let head = format!(
        "POST /v1/world/facts/x HTTP/1.1\r\nconnection: close\r\nauthorization: {token}\r\n\
         content-type: application/json\r\ncontent-length: 100\r\n\r\n{{"
    );
    stream.write_all(head.as_bytes()).await.expect("it is taken");
    Said::read(&mut stream).await.is(408, "too_slow");
    assert!(began.elapsed() >= BODY_WITHIN && began.elapsed() < 2 * BODY_WITHIN, "{:?}", began.elapsed());
}

/// One who follows a run.
struct Follower {
    stream: DuplexStream,
    heard: String,
}

impl Follower {
    async fn new(asked: &Asked) -> Self {
        let mut stream = asked.connect(Way::Socket, 1024);
        stream.write_all(b"GET /v1/events HTTP/1.1\r\n\r\n").await.expect("it is taken");
        Self { stream, heard: String::new() }
    }

    /// What it hears before these words.
    async fn until(&mut self, words: &str) -> String {
        let began = Instant::now();
        loop {
            assert!(began.elapsed() < HOUR, "never {words:?}");
            if let Some((before, behind)) = self.heard.split_once(words) {
                let (before, behind) = (before.to_owned(), behind.to_owned());
                self.heard = behind;
                return before;
            }
            let mut bytes = [0; 512];
            let count = self.stream.read(&mut bytes).await.expect("more");
            assert!(count > 0, "it ends without {words:?}: {}", self.heard);
            self.heard.push_str(&String::from_utf8_lossy(&bytes[..count]));
        }
    }
}

#[tokio::test(start_paused = true)]
async fn a_reader_that_stops_reading_holds_up_nobody_and_goes_on_from_a_snapshot() {
    let asked = Asked::new();
    let mut follower = Follower::new(&asked).await;
    let head = follower.until("event: snapshot").await;
    assert!(head.contains("content-type: text/event-stream"), "{head}");
    for _ in 0..50 {
        asked.hub.take([News::Records(vec![samples::activation(); 100])]);
        tokio::task::yield_now().await;
    }
    let heard = follower.until("event: dropped").await.matches("event: record").count();
    assert!(heard < 1_000, "{heard}");
    let told = follower.until("event: snapshot").await;
    assert!(told.contains(&format!("data: {{\"records\":{}}}", 5_000 - heard)) && told.contains("id: 5000"), "{told}");
    // Nothing happens: it is heard that somebody is there.
    follower.until("\n:\n\n").await;
}

#[tokio::test(start_paused = true)]
async fn a_reader_that_never_reads_again_is_hung_up_on() {
    let asked = Asked::new();
    let (ours, theirs) = duplex(64);
    let answering = tokio::spawn(answer(asked.served.clone(), Way::Socket, theirs));
    let mut ours = ours;
    ours.write_all(b"GET /v1/events HTTP/1.1\r\n\r\n").await.expect("it is taken");
    let began = Instant::now();
    tokio::time::timeout(HOUR, answering).await.expect("it ends").expect("it does not panic");
    assert!(began.elapsed() >= TAKEN_WITHIN, "{:?}", began.elapsed());
    assert!(began.elapsed() < TAKEN_WITHIN + Duration::from_secs(5), "{:?}", began.elapsed());
}

#[tokio::test(start_paused = true)]
async fn so_many_follow_a_run_and_no_more() {
    let asked = Asked::new();
    let mut streams = Vec::new();
    for _ in 0..STREAMS_MAX {
        let mut follower = Follower::new(&asked).await;
        follower.until("event: snapshot").await;
        streams.push(follower);
    }
    asked.say_with(Way::Socket, "GET", "/v1/events", &[], "").await.is(503, "busy");
    drop(streams.pop());
    // Whoever left is missed when somebody speaks to it.
    tokio::time::sleep(Duration::from_secs(30)).await;
    Follower::new(&asked).await.until("event: snapshot").await;
}

#[tokio::test(start_paused = true)]
async fn the_document_says_what_there_is() {
    let asked = Asked::new();
    let said = asked.say_with(Way::Socket, "GET", "/v1/openapi.json", &[], "").await;
    assert_eq!((said.status, said.body.as_str()), (200, document()));
    let document: Value = serde_json::from_str(document()).expect("JSON");
    assert_eq!(document["openapi"].as_str().map(|version| &version[..3]), Some("3.1"));
    let paths = document["paths"].as_object().expect("paths");
    assert_eq!(document["components"]["schemas"]["Edit"]["oneOf"][1]["additionalProperties"], false);
    assert_eq!(paths.len(), 20, "{:?}", paths.keys());
    for (path, operations) in paths {
        for (method, operation) in operations.as_object().expect("operations") {
            let about = format!("{method} {path}");
            let responses = operation["responses"].as_object().expect("responses");
            let is_reading = method == "get";
            assert_eq!(operation["security"].is_null(), is_reading, "{about}");
            assert_eq!(responses.contains_key("401"), !is_reading, "{about}");
            assert!(responses.contains_key("403") && responses.contains_key("503"), "{about}");
            assert_eq!(responses.contains_key("413"), !operation["requestBody"].is_null(), "{about}");
            assert!(operation["summary"].as_str().is_some_and(|said| !said.is_empty()), "{about}");
            let path = path.replace(['{', '}'], "");
            if path.ends_with("/events") {
                continue;
            }
            let said = asked.say(&method.to_uppercase(), &path, "{}").await;
            let documented = responses.contains_key(&said.status.to_string());
            assert!(documented, "{about} answers {}: {}", said.status, said.body);
        }
    }
}
