//! Others ask a daemon over HTTP: as bytes over its socket and over loopback, and by the verbs of the command line.

use std::fs;
use std::io::{Read, Write};
use std::net::TcpStream;
use std::os::unix::fs::MetadataExt;
use std::os::unix::net::UnixStream;
use std::path::PathBuf;
use std::time::Duration;

use ambidex::link::Instance;
use rustix::process::Signal;
use serde_json::Value;

use crate::fixtures::file;
use crate::home::{Finished, Home, Process, within};

const WAITS: &str = "nothing can go on before others change \"door open\"";
const FACT: &str = "/v1/world/facts/door%20open";

fn door() -> PathBuf {
    file("config/missions/door.yaml")
}

fn instance(home: &Home) -> Instance {
    Instance::new(home.instance()).expect("a name")
}

fn verb(home: &Home, args: &[&str]) -> Process {
    home.start(args.iter().chain(&["--instance", home.instance()]))
}

/// Both kinds of connection.
trait Stream: Read + Write {}
impl<T: Read + Write> Stream for T {}

fn local(home: &Home) -> UnixStream {
    let stream = UnixStream::connect(instance(home).control_socket()).expect("a daemon");
    stream.set_read_timeout(Some(Duration::from_secs(30))).expect("a socket");
    stream
}

/// Where the daemon says that it can be asked.
fn address(home: &Home) -> String {
    fs::read_to_string(instance(home).address_file()).expect("it is asked over TCP").trim().to_owned()
}

fn loopback(home: &Home) -> TcpStream {
    let stream = TcpStream::connect(address(home)).expect("a daemon");
    stream.set_read_timeout(Some(Duration::from_secs(30))).expect("a socket");
    stream
}

fn token(home: &Home) -> String {
    let token = fs::read_to_string(instance(home).token_file()).expect("a daemon");
    format!("authorization: Bearer {}\r\n", token.trim())
}

/// Says bytes, and gives status and body of what is answered.
fn say(mut stream: impl Stream, request: &[u8]) -> (u16, String) {
    stream.write_all(request).expect("it is taken");
    let mut answer = Vec::new();
    // Who is hung up on while it still talks may be told less gently.
    let _ = stream.read_to_end(&mut answer);
    let answer = String::from_utf8(answer).expect("text");
    let (head, body) = answer.split_once("\r\n\r\n").unwrap_or_else(|| panic!("no answer: {answer:?}"));
    (head.split(' ').nth(1).and_then(|status| status.parse().ok()).expect("a status"), body.to_owned())
}

fn request(method: &str, path: &str, headers: &str, body: &str) -> Vec<u8> {
    let length = body.len();
    let json = "content-type: application/json\r\n";
    format!("{method} {path} HTTP/1.1\r\nconnection: close\r\ncontent-length: {length}\r\n{json}{headers}\r\n{body}")
        .into_bytes()
}

#[test]
fn whatever_is_said_to_the_socket_is_answered() {
    let home = Home::new();
    let mut daemon = home.daemon(&door(), &[]);
    daemon.says("waiting for");
    let about = fs::metadata(instance(&home).token_file()).expect("a file");
    assert_eq!(about.mode() & 0o777, 0o600);
    assert!(!instance(&home).address_file().exists());
    let token = token(&home);
    let rows: [(&str, &str, &str, &str, u16); 8] = [
        ("GET", "/v1/tasks", "", "", 200),
        ("GET", "/v1/openapi.json", "", "", 200),
        ("GET", "/", "", "", 404),
        ("POST", FACT, "", r#"{"holds":true}"#, 401),
        ("POST", FACT, &token, r#"{"holds":true}"#, 409),
        ("POST", FACT, &token, r#"{"holds":"yes"}"#, 422),
        ("POST", FACT, &token, &" ".repeat(20_000), 413),
        ("GET", "/v1/status", "origin: http://evil.example\r\n", "", 403),
    ];
    for (method, path, headers, body, expected) in rows {
        let (status, said) = say(local(&home), &request(method, path, headers, body));
        assert_eq!(status, expected, "{method} {path}: {said}");
        let said: Value = serde_json::from_str(&said).expect("JSON");
        assert_eq!(said["why"].is_null(), expected == 200, "{said}");
    }
    for strange in [&b"\n\n\xff\xfe{\r\n\r\n"[..], b"{\"version\":1}\n\r\n\r\n"] {
        let mut stream = local(&home);
        stream.write_all(strange).expect("it is taken");
        let mut answer = String::new();
        stream.read_to_string(&mut answer).expect("an answer");
        assert!(answer.starts_with("HTTP/1.1 400 "), "{answer}");
    }
    daemon.signal(Signal::INT);
    daemon.ends(130);
    home.is_empty();
}

#[test]
fn one_too_many_is_told_so_and_a_slow_one_is_hung_up_on() {
    let home = Home::new();
    let mut daemon = home.daemon(&door(), &[]);
    daemon.says("waiting for");
    let mut slow: Vec<_> = (0..32).map(|_| local(&home)).collect();
    slow.iter_mut().for_each(|stream| stream.write_all(b"GET /v1/ta").expect("it is taken"));
    let is_full = || {
        let mut answer = String::new();
        let _ = local(&home).read_to_string(&mut answer);
        answer.starts_with("HTTP/1.1 503 ") && answer.contains("\"why\":\"busy\"")
    };
    within(Duration::from_secs(5), "all are taken", is_full);
    for mut stream in slow {
        let mut rest = Vec::new();
        stream.read_to_end(&mut rest).expect("it is hung up on");
    }
    let (status, _) = say(local(&home), &request("GET", "/v1/tasks", "", ""));
    assert_eq!(status, 200);
    daemon.signal(Signal::INT);
    daemon.ends(130);
    home.is_empty();
}

#[test]
fn over_loopback_only_who_means_it_is_heard() {
    let home = Home::new();
    for address in ["0.0.0.0:0", "192.168.0.1:80", "localhost", "127.0.0.1"] {
        let finished = home.daemon(&door(), &["--http", address]).ends(2);
        assert!(finished.words().contains("loopback"), "{finished:#?}");
    }
    let mut daemon = home.daemon(&door(), &["--http", "127.0.0.1:0"]);
    daemon.says("waiting for");
    let host = format!("host: {}\r\n", address(&home));
    daemon.says(&format!("asked at http://{}/v1/", address(&home)));
    let rebound = "host: rebound.example\r\n";
    let origin = format!("{host}origin: http://evil.example\r\n");
    let own = format!("{host}origin: http://{}\r\n{}", address(&home), token(&home));
    let foreign = format!("{origin}{}", token(&home));
    let body = r#"{"holds":true}"#;
    let rows: [(&str, &str, &str, u16); 6] = [
        ("GET", "/v1/status", &host, 200),
        ("GET", "/v1/status", rebound, 403),
        ("GET", "/v1/status", &origin, 403),
        ("POST", FACT, &foreign, 403),
        ("POST", FACT, &host, 401),
        ("POST", FACT, &own, 409),
    ];
    for (method, path, headers, expected) in rows {
        let body = if method == "POST" { body } else { "" };
        let (status, said) = say(loopback(&home), &request(method, path, headers, body));
        assert_eq!(status, expected, "{method} {path} {headers}: {said}");
    }
    let taken = address(&home);
    let (second, mission) = (Instance::fresh(), door());
    let mission = mission.to_str().expect("a path in UTF-8");
    let other = home.start(["daemon", "--instance", second.name(), "--http", &taken, mission]);
    let finished = other.ends(2);
    assert!(finished.words().contains(&format!("cannot be asked at {taken}")), "{finished:#?}");
    assert!(!second.has_left_anything());
    daemon.signal(Signal::INT);
    daemon.ends(130);
    home.is_empty();
}

/// One who follows a run.
struct Follower {
    stream: UnixStream,
    heard: String,
}

impl Follower {
    /// What it hears before these words.
    fn until(&mut self, words: &str) -> String {
        loop {
            if let Some((before, behind)) = self.heard.split_once(words) {
                let (before, behind) = (before.to_owned(), behind.to_owned());
                self.heard = behind;
                return before;
            }
            let mut bytes = [0; 4096];
            let count = self.stream.read(&mut bytes).expect("more");
            assert!(count > 0, "it ends without {words:?}: {}", self.heard);
            self.heard.push_str(&String::from_utf8_lossy(&bytes[..count]));
        }
    }
}

#[test]
fn a_reader_that_stops_reading_holds_up_no_mission_and_goes_on_from_a_snapshot() {
    let home = Home::new();
    let text = fs::read_to_string(file("config/missions/patrol.yaml")).expect("a mission");
    let config = file("config");
    let text = text.replace("repeat: 2", "repeat: 1000").replace("../", &format!("{}/", config.display()));
    let mission = home.write("patrol.yaml", &text);
    let mut run = home.carry("run", &mission, &["--speed", "500", "--messages", "all"]);
    run.says("step 1");
    let mut follower = Follower { stream: local(&home), heard: String::new() };
    follower.stream.write_all(b"GET /v1/events HTTP/1.1\r\nhost: localhost\r\n\r\n").expect("it is taken");
    follower.until("event: snapshot");
    let lines = || home.log().lines().count();
    let before = lines();
    within(Duration::from_secs(50), "the mission goes on", || lines() > before + 6_000);
    follower.until("event: dropped\n");
    let told = follower.until("event: snapshot");
    assert!(told.contains("data: {\"records\":"), "{told}");
    run.signal(Signal::INT);
    // What was last is told before it is over.
    follower.until("\"record\":\"ended\"");
    let mut rest = Vec::new();
    follower.stream.read_to_end(&mut rest).expect("its end");
    run.ends(130);
    home.start(["verify", home.instance()]).ends(0);
    home.is_empty();
}

fn refused(finished: &Finished, words: &[&str]) {
    assert_eq!(finished.stdout, "", "{finished:#?}");
    words.iter().for_each(|word| assert!(finished.words().contains(word), "{word}: {finished:#?}"));
}

#[test]
fn tasks_are_listed_shown_and_watched_and_the_run_is_stopped() {
    let home = Home::new();
    let takes_none = ["takes no further tasks", "ambidex daemon --robot R --world W"];
    refused(&verb(&home, &["list"]).ends(4), &["no daemon of instance"]);
    let mut run = home.carry("run", &door(), &["--speed", "20"]);
    run.says(WAITS);
    let waits = "waiting, 2 of 4 done: pass to office: \"door open\" does not hold";
    let listed = verb(&home, &["list"]).ends(0).stdout;
    assert!(listed.contains("door  waiting") && listed.contains("2 of 4"), "{listed}");
    let shown = verb(&home, &["show", "door"]).ends(0).stdout;
    assert!(shown.starts_with(&format!("1 door  {waits}\n")) && shown.contains("✓ pick parcel"), "{shown}");
    let shown = verb(&home, &["show", "1", "--json"]).ends(0).stdout;
    let shown: Value = serde_json::from_str(&shown).expect("an object");
    assert_eq!((&shown["state"], &shown["nodes"][0]["kind"]), (&"waiting".into(), &"then".into()));
    refused(&verb(&home, &["show", "dor"]).ends(2), &["there is no task `dor`", "did you mean `door`?"]);
    refused(&verb(&home, &["watch", "2"]).ends(2), &["there is no task `2`"]);
    let door = door();
    let door = door.to_str().expect("a path in UTF-8");
    for args in [
        &["submit", door, "--wait"][..],
        &["cancel", "1"],
        &["pause"],
        &["resume", "door"],
        &["step"],
        &["edit", "1", "add", "door", door],
        &["edit", "1", "remove", "pick parcel"],
        &["world", "add", "cup", "hall"],
        &["world", "remove", "parcel"],
    ] {
        refused(&verb(&home, args).ends(1), &takes_none);
    }
    let missing = home.path("missing.yaml");
    let missing = verb(&home, &["submit", missing.to_str().expect("a path in UTF-8")]).ends(2);
    refused(&missing, &["cannot read", "missing.yaml"]);
    let watching = verb(&home, &["watch", "door"]);
    within(Duration::from_secs(20), "it is told", || watching.stdout().contains(waits));
    assert_eq!(verb(&home, &["stop"]).ends(0).stdout, "the run is told to end\n");
    let watched = watching.ends(0).stdout;
    assert!(watched.ends_with("1 door  canceled, 2 of 4 done: it was told to end\n"), "{watched}");
    run.ends(130);
    home.is_empty();
}
