//! A daemon under a service manager, of which a datagram socket stands for what it listens on; the unit that is shipped;
//! and what goes on after it was killed.

use std::io::ErrorKind;
use std::os::unix::net::UnixDatagram;
use std::process::Command;
use std::time::{Duration, Instant};

use rustix::process::Signal;

use crate::fixtures::{experiment_file, file};
use crate::home::{Home, Process};

use super::{CONTROLLERS, report};

/// What takes longer hangs.
const DEADLINE: Duration = Duration::from_secs(30);
/// What the manager is patient for.
const WATCHDOG: Duration = Duration::from_millis(400);

/// The manager's end.
struct Manager {
    socket: UnixDatagram,
}

impl Manager {
    fn new(home: &Home) -> Self {
        let socket = UnixDatagram::bind(home.path("notify")).expect("a socket");
        Self { socket }
    }

    fn daemon(&self, home: &Home, more: &[&str]) -> Process {
        let mission = experiment_file(1);
        let args = ["daemon", "--instance", home.instance(), mission.to_str().expect("UTF-8")];
        home.start_with(args.iter().chain(more), |command| {
            command.env("NOTIFY_SOCKET", home.path("notify")).env("WATCHDOG_USEC", WATCHDOG.as_micros().to_string());
        })
    }

    /// The next word; none if none comes within the time.
    fn hears(&self, within: Duration) -> Option<String> {
        let mut word = [0; 1024];
        self.socket.set_read_timeout(Some(within)).expect("a time");
        match self.socket.recv(&mut word) {
            Ok(length) => Some(String::from_utf8_lossy(&word[..length]).trim_end().to_owned()),
            Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => None,
            Err(error) => panic!("{error}"),
        }
    }

    /// Waits for a word that begins so, and gives all words up to it.
    fn waits_for(&self, beginning: &str) -> Vec<String> {
        let (by, mut heard) = (Instant::now() + DEADLINE, Vec::new());
        while Instant::now() < by {
            heard.extend(self.hears(DEADLINE));
            if heard.last().is_some_and(|word| word.starts_with(beginning)) {
                return heard;
            }
        }
        panic!("never heard {beginning}: {heard:?}");
    }
}

#[test]
fn a_daemon_tells_its_manager_that_it_is_ready_lives_and_ends() {
    let home = Home::new();
    let manager = Manager::new(&home);
    let mut daemon = manager.daemon(&home, &[]);
    let before = manager.waits_for("READY=1");
    assert!(!before.contains(&"STOPPING=1".to_owned()), "{before:?}");
    // Ready is who can be asked.
    assert!(home.start(["world", "set", "x", "--instance", home.instance()]).wait().words().contains("no fact"));
    let waiting = "STATUS=experiment-1: waiting for left_arm, right_arm, head, base";
    if !before.contains(&waiting.to_owned()) {
        manager.waits_for(waiting);
    }
    let head = home.controller("head", &["--once"]);
    manager.waits_for("STATUS=experiment-1: waiting for left_arm, right_arm, base");
    manager.waits_for("WATCHDOG=1");
    manager.waits_for("WATCHDOG=1");

    // Who does not run does not say that it lives.
    daemon.signal(Signal::STOP);
    // What was sent before waits still.
    assert!((0..50).any(|_| manager.hears(WATCHDOG * 5).is_none()), "it goes on");
    daemon.signal(Signal::CONT);
    manager.waits_for("WATCHDOG=1");

    daemon.signal(Signal::TERM);
    manager.waits_for("STOPPING=1");
    manager.waits_for("STATUS=experiment-1: canceled");
    assert!(!daemon.stderr().contains("service manager"), "{}", daemon.stderr());
    daemon.says("log:");
    daemon.ends(130);
    head.ends(0);
    home.is_empty();
}

/// A manager that is gone, or was never there, changes nothing.
#[test]
fn nobody_needs_to_listen() {
    let home = Home::new();
    let manager = Manager::new(&home);
    drop(manager.socket);
    let mission = experiment_file(1);
    let args = ["run", "--speed", "100", "--json", mission.to_str().expect("UTF-8")];
    let run = home.start_with(args, |command| {
        command.env("NOTIFY_SOCKET", home.path("notify")).env("WATCHDOG_USEC", "1");
    });
    assert_eq!(report(&run.ends(0))["outcome"], "done");
    home.is_empty();
}

#[test]
fn a_daemon_that_was_killed_goes_on_and_one_that_ended_begins_anew() {
    let home = Home::new();
    let controllers: Vec<_> = CONTROLLERS.iter().map(|name| home.controller(name, &[])).collect();
    let start = || home.daemon(&experiment_file(1), &["--or-resume", "--json", "--speed", "20"]);
    let mut first = start();
    first.says("step 2");
    first.signal(Signal::KILL);
    assert_eq!(first.wait().code, None);
    let second = start().ends(0);
    assert!(second.words().contains("the last run did not end; it goes on in"), "{}", second.stderr);
    assert_eq!(report(&second)["outcome"], "done");
    let goes_on = home.log();
    assert_eq!(goes_on.matches("\"record\":\"header\"").count(), 1);
    assert!(goes_on.contains("\"resumed\""), "in the same log");
    let third = start().ends(0);
    assert!(!third.words().contains("goes on in"), "{}", third.stderr);
    assert!(!home.log().contains("\"resumed\""), "in a log of its own");
    drop(controllers);
}

/// Where systemd is installed it finds nothing to complain of.
#[test]
fn the_unit_is_one() {
    let home = Home::new();
    let check = |unit: &str| {
        let mut command = Command::new("systemd-analyze");
        command.args(["--user", "verify", "--man=no", unit]).env("XDG_RUNTIME_DIR", home.path(""));
        command.output()
    };
    let unit = file("config/systemd/ambidex@.service");
    let Ok(verified) = check(unit.to_str().expect("UTF-8")) else { return };
    let said = String::from_utf8_lossy(&verified.stderr).into_owned();
    assert!(verified.status.success() && said.is_empty(), "{said}");
    let text = std::fs::read_to_string(&unit).expect("the unit").replace("WatchdogSec=10", "WatchdogSec=soon");
    let broken = home.write("broken@.service", &text);
    let verified = check(broken.to_str().expect("UTF-8")).expect("it ran before");
    assert!(String::from_utf8_lossy(&verified.stderr).contains("soon"), "it would say so");
}
