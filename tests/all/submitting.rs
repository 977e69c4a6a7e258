//! `ambidex submit` and `watch` against a daemon that takes work: one that says so, in this process, and tells of the
//! task what the records of a simulated run do.

use std::sync::{Arc, mpsc as blocking};
use std::time::Duration;

use ambidex::http::{Endpoint, Feed, Hub, Server};
use ambidex::link::{Instance, IpcNode};
use ambidex::model::{MissionEnd, Record};
use ambidex::record::History;
use ambidex::runtime::control::{Answer, NameOrId, Refusal, Submission, Work};
use ambidex::runtime::{Clock, Control};
use ambidex::tree::Settings;
use rustix::process::Signal;
use serde_json::Value;
use tokio::sync::{mpsc, watch};

use crate::fixtures::{file, load, simulate};
use crate::home::{Home, Process, within};

/// A daemon that has nothing but its interface.
struct Daemon {
    server: Option<Server>,
    feed: Feed,
    history: History,
    records: Vec<Record>,
    asked: blocking::Receiver<Work>,
}

impl Daemon {
    fn new(home: &Home) -> Self {
        let mission = load(&file("config/missions/experiment-1.yaml"));
        let (mut records, _) = simulate(&mission, &Settings::default(), Vec::new());
        records.reverse();
        let Some(Record::Header(header)) = records.pop() else { panic!("no header") };
        let history = History::new(&header);
        let instance = Instance::new(home.instance()).expect("a name");
        let lock = instance.lock_daemon().expect("the daemon's place");
        let node = IpcNode::open(lock).expect("a place in shared memory");
        let endpoint = Endpoint::open(&node, None).expect("a socket");
        let (run, control) = mpsc::unbounded_channel();
        let (to_test, asked) = blocking::channel();
        std::thread::spawn(move || decide(control, &to_test));
        let (feed, news) = Feed::new();
        let hub = Hub::new(history.clone(), Clock::start(1.0));
        let server =
            Server::start(endpoint, mission, run, hub, news, watch::channel(Arc::default()).1).expect("a thread");
        Self { server: Some(server), feed, history, records, asked }
    }

    fn tell(&mut self, record: &Record) {
        self.history.apply(record);
        self.feed.take(record, &self.history);
    }

    /// Goes on to a record that is meant, or to the end.
    fn go_on(&mut self, is_last: impl Fn(&Record) -> bool) {
        while let Some(record) = self.records.pop() {
            self.tell(&record);
            if is_last(&record) {
                break;
            }
        }
        while !self.feed.flush(&self.history) {
            std::thread::yield_now();
        }
    }

    fn cancel(&mut self) {
        let (at, end) = (self.history.now(), MissionEnd::Canceled);
        self.tell(&Record::Ending { at, end, until: at });
        self.tell(&Record::Ended { at: at + Duration::from_secs(1), end });
        self.go_on(|_| true);
    }

    fn next(&self) -> Work {
        self.asked.recv_timeout(Duration::from_secs(30)).expect("it is asked")
    }

    fn end(&mut self) {
        self.server = None;
    }
}

/// Takes a task, and lets it be told to end.
fn decide(mut control: mpsc::UnboundedReceiver<Control>, to_test: &blocking::Sender<Work>) {
    while let Some(told) = control.blocking_recv() {
        let Control::Work(work, answer) = told else { panic!("nobody says {told:?}") };
        let said = match &work {
            Work::Submit(submission) => {
                Answer::Submitted { task: 1, name: submission.name.clone().unwrap_or_else(|| "own".into()) }
            }
            Work::Cancel(_) => Answer::Changed { said: "it is told to end".into() },
            _ => Answer::Refused(Refusal::takes_no_work()),
        };
        drop(answer.send(said));
        drop(to_test.send(work));
    }
}

fn submit(home: &Home, more: &[&str]) -> Process {
    let mission = file("config/missions/patrol.yaml");
    let args = ["submit", mission.to_str().expect("a path in UTF-8"), "--instance", home.instance()];
    home.start(args.iter().chain(more))
}

fn is_grant(record: &Record) -> bool {
    matches!(record, Record::Decided { granted, .. } if !granted.is_empty())
}

#[test]
fn a_task_is_submitted_with_all_that_it_includes() {
    let home = Home::new();
    let daemon = Daemon::new(&home);
    let args = ["--name", "rounds", "--priority", "-2", "--set", "a=b", "--pause"];
    assert_eq!(submit(&home, &args).ends(0).stdout, "task 1: rounds\n");
    let Work::Submit(Submission { name, priority, pause, source }) = daemon.next() else { panic!("it submits") };
    assert_eq!((name.as_deref(), priority, pause), (Some("rounds"), Some(-2), true));
    assert_eq!((source.mission.as_str(), source.settings), ("patrol.yaml", vec![("a".into(), "b".into())]));
    let paths: Vec<&str> = source.files.iter().map(|file| file.path.as_str()).collect();
    assert_eq!(paths.len(), 2, "{paths:?}");
    assert!(paths[1].ends_with("household.yaml") && source.files[1].text.contains("behaviors:"), "{paths:?}");
    let said = submit(&home, &["--json"]).ends(0).stdout;
    assert_eq!(serde_json::from_str::<Value>(&said).expect("an object"), serde_json::json!({"task": 1, "name": "own"}));
    drop(daemon);
    home.is_empty();
}

#[test]
fn a_task_is_waited_for_until_it_is_done() {
    let home = Home::new();
    let mut daemon = Daemon::new(&home);
    let mut waiting = submit(&home, &["--wait"]);
    let asked = submit(&home, &["--wait", "--json"]);
    waiting.says("waiting, 0 of 16 done");
    daemon.go_on(is_grant);
    waiting.says("running, 0 of 16 done");
    daemon.go_on(|_| false);
    let finished = waiting.ends(0);
    assert_eq!(finished.stdout, "task 1: own\n");
    assert!(finished.stderr.ends_with("1 experiment-1  done, 16 of 16 done\n"), "{finished:#?}");
    let said: Value = serde_json::from_str(&asked.ends(0).stdout).expect("an object");
    assert_eq!((&said["state"], &said["done"]), (&"done".into(), &16.into()));
    // What has ended before it is waited for has ended.
    submit(&home, &["--wait"]).ends(0);
    daemon.end();
    submit(&home, &["--wait"]).ends(4);
    home.is_empty();
}

#[test]
fn ctrl_c_cancels_the_task_and_another_leaves_it_to_itself() {
    let home = Home::new();
    let mut daemon = Daemon::new(&home);
    let mut waits = submit(&home, &["--wait"]);
    let mut leaves = submit(&home, &["--wait"]);
    daemon.go_on(is_grant);
    for waiting in [&mut waits, &mut leaves] {
        waiting.says("running, 0 of 16 done");
        waiting.signal(Signal::INT);
        waiting.says("task 1 is told to end; Ctrl-C once more leaves it to itself");
    }
    leaves.signal(Signal::INT);
    let finished = leaves.ends(130);
    assert!(finished.stderr.ends_with("task 1 is left to itself\n"), "{finished:#?}");
    let canceled = std::iter::repeat_with(|| daemon.next()).filter(|work| *work == Work::Cancel(NameOrId::Id(1)));
    assert_eq!(canceled.take(2).count(), 2);
    assert!(!waits.has_ended());
    daemon.cancel();
    let finished = waits.ends(130);
    assert!(finished.stderr.ends_with("canceled, 0 of 16 done: it was told to end\n"), "{finished:#?}");
    daemon.end();
    home.is_empty();
}

#[test]
fn a_daemon_that_is_gone_is_told_of() {
    let home = Home::new();
    let mut daemon = Daemon::new(&home);
    let mut waiting = submit(&home, &["--wait"]);
    let watching = home.start(["watch", "--instance", home.instance()]);
    waiting.says("waiting, 0 of 16 done");
    within(Duration::from_secs(20), "it is told", || watching.stdout().contains("waiting, 0 of 16"));
    daemon.end();
    let finished = waiting.ends(4);
    assert!(finished.stderr.ends_with("× the daemon ended before task 1 did\n"), "{finished:#?}");
    let finished = watching.ends(4);
    assert!(finished.words().contains("not every task had ended"), "{finished:#?}");
    home.is_empty();
}
