//! Daemon and controller as real processes, killed and stopped. A child is this test binary in another role.

use std::io::{BufRead, BufReader};
use std::process::{Child, Command as Process, Stdio};

use rustix::process::{Pid, kill_process};

use super::tests::{Cart, Daemon, leaves_nothing};
use super::*;
use crate::{Heard, Link, Swept};
use ambidex_model::session::DEAD_MAN;
use ambidex_model::{Command, Mode, PartEnd};

const ROLE: &str = "AMBIDEX_TEST_ROLE";
const INSTANCE: &str = "AMBIDEX_TEST_INSTANCE";
const PARENT: &str = "AMBIDEX_TEST_PARENT";

/// Kills its process when dropped, as a failing test must not leave it.
struct Role(Child);

impl Role {
    fn start(role: &str, instance: &Instance) -> Self {
        let own = std::env::current_exe().unwrap();
        let child = Process::new(own)
            .args(["--exact", "serve::server::process_tests::child"])
            .args(["--nocapture", "--quiet"])
            .env(ROLE, role)
            .env(INSTANCE, instance.name())
            .env(PARENT, std::process::id().to_string())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        Self(child)
    }

    fn pid(&self) -> Pid {
        Pid::from_child(&self.0)
    }

    fn kill(&mut self) {
        self.0.kill().unwrap();
        self.0.wait().unwrap();
    }

    /// Waits until the child says the word; what follows it.
    fn says(&mut self, word: &str) -> String {
        let out = BufReader::new(self.0.stdout.as_mut().unwrap());
        out.lines().map_while(Result::ok).find_map(|line| line.strip_prefix(word).map(str::to_owned)).unwrap()
    }
}

impl Drop for Role {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
        let _ = sweep();
    }
}

/// The other side of the tests below; without a role it has nothing to do.
#[test]
fn child() {
    let Ok(role) = std::env::var(ROLE) else {
        return;
    };
    let instance = Instance::new(&std::env::var(INSTANCE).unwrap()).unwrap();
    match role.as_str() {
        "controller" => {
            let options = ServeOptions { stop: Some(Stop::on_signals().unwrap()), ..ServeOptions::default() };
            assert_eq!(serve(&instance, "cart", Cart::new(), options).unwrap(), Exit::Stopped);
        }
        "tied" => {
            // The parent may be dead already, which is the harder half of the matter.
            let parent = std::env::var(PARENT).unwrap().parse().unwrap();
            let options = ServeOptions { parent: Some(parent), ..ServeOptions::default() };
            let ended = serve(&instance, "cart", Cart::new(), options);
            assert!(matches!(ended, Err(ServeError::Orphan(_))));
        }
        "parent" => {
            let tied = Role::start("tied", &instance);
            println!("\ntied {}", tied.0.id());
            thread::sleep(Duration::from_secs(60));
        }
        "daemon" => {
            let mut daemon = Daemon::new(&instance, 1);
            daemon.attach();
            daemon.goal(1, Mode::Maintain, Command::Stand);
            daemon.until("feedback", |heard| matches!(heard, Heard::Message(_)));
            println!("\nunder way");
            daemon.until("nothing, for ever", |_| false);
        }
        other => unreachable!("{other}"),
    }
}

#[test]
fn a_killed_controller_is_seen_and_its_successor_attaches() {
    let instance = Instance::fresh();
    let mut daemon = Daemon::new(&instance, 1);
    for _ in 0..3 {
        let mut controller = Role::start("controller", &instance);
        daemon.attach();
        assert_eq!(daemon.pid(), Some(controller.0.id()));
        let watch = Pidfd::open(controller.0.id()).unwrap();
        daemon.goal(1, Mode::Maintain, Command::Stand);
        controller.kill();
        assert!(watch.has_ended());
        daemon.port.forget();
        // What the dead one published last counts for a while: a successor is told by its process id.
        thread::sleep(DEAD_MAN);
        assert_eq!(daemon.pid(), None);
    }
    let mut controller = Role::start("controller", &instance);
    daemon.attach();
    let id = daemon.goal(1, Mode::Achieve, super::tests::drive());
    assert_eq!(daemon.result(id).0, PartEnd::Succeeded);
    kill_process(controller.pid(), Signal::TERM).unwrap();
    assert!(controller.0.wait().unwrap().success());
    drop(daemon);
    leaves_nothing(&instance);
}

#[test]
fn a_stopped_controller_is_seen_and_gives_up_its_command_when_it_goes_on() {
    let instance = Instance::fresh();
    let mut daemon = Daemon::new(&instance, 1);
    let controller = Role::start("controller", &instance);
    daemon.attach();
    let id = daemon.goal(1, Mode::Maintain, Command::Stand);
    daemon.until("accepted", |heard| matches!(heard, Heard::Message(_)));
    kill_process(controller.pid(), Signal::STOP).unwrap();
    let begun = Instant::now();
    while daemon.pid().is_some() {
        daemon.hear();
        assert!(begun.elapsed() < DEAD_MAN + Duration::from_millis(500));
        thread::sleep(Duration::from_millis(10));
    }
    thread::sleep(Duration::from_millis(300));
    kill_process(controller.pid(), Signal::CONT).unwrap();
    assert_eq!(daemon.result(id).0, PartEnd::Canceled);
}

#[test]
fn a_controller_outlives_killed_daemons() {
    let instance = Instance::fresh();
    let controller = Role::start("controller", &instance);
    let mut first = Role::start("daemon", &instance);
    first.says("under way");
    assert!(instance.lock_daemon().is_err());
    first.kill();
    let mut daemon = Daemon::new(&instance, 2);
    daemon.attach();
    assert_eq!(daemon.pid(), Some(controller.0.id()));
    let id = daemon.goal(1, Mode::Achieve, super::tests::drive());
    assert_eq!(daemon.result(id).0, PartEnd::Succeeded);
}

#[test]
fn what_all_the_dead_left_is_swept() {
    let instance = Instance::fresh();
    let mut controller = Role::start("controller", &instance);
    let mut daemon = Role::start("daemon", &instance);
    daemon.says("under way");
    controller.kill();
    daemon.kill();
    let swept = sweep().unwrap();
    let is_ours = |swept: &&Swept| matches!(swept, Swept::Instance { name, .. } if name == instance.name());
    // Another test may have swept it first; then there is nothing for us.
    for swept in swept.iter().filter(is_ours) {
        assert!(matches!(swept, Swept::Instance { segments, .. } if *segments > 0));
    }
    assert!(!instance.has_left_anything());
}

#[test]
fn a_controller_ends_with_its_parent() {
    let instance = Instance::fresh();
    let mut parent = Role::start("parent", &instance);
    let tied: u32 = parent.says("tied ").parse().unwrap();
    let watch = Pidfd::open(tied).unwrap();
    parent.kill();
    let begun = Instant::now();
    while !watch.has_ended() {
        assert!(begun.elapsed() < Duration::from_secs(2));
        thread::sleep(Duration::from_millis(10));
    }
}
