//! A daemon, three honest controllers, and a hostile one in the place of the left arm, without which the mission can
//! be done as well.

use std::ffi::OsStr;
use std::fs;
use std::path::PathBuf;

use ambidex::link;
use ambidex::model::{CommandId, ControllerId, ControllerMessage, Loss, Record, Rejection};
use ambidex::record::Reader;
use rustix::process::Signal;

use super::acts::{ACT, INSTANCE};
use crate::fixtures::file;
use crate::home::{Finished, Home, Process};

/// Whose place the hostile process takes; the first of the robot file.
pub const HOSTILE: &str = "left_arm";
const HONEST: [&str; 3] = ["right_arm", "head", "base"];

/// Everything that runs.
pub struct Scene {
    pub home: Home,
    pub daemon: Process,
    pub hostile: Process,
    pub honest: Vec<Process>,
}

/// What is left of it: what the daemon said, and its log.
pub struct Ending {
    pub finished: Finished,
    pub records: Vec<Record>,
    /// What the hostile process said on stderr.
    hostile: String,
}

/// Who can fetch the cup.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Cup {
    /// Both arms, the left one with a shorter way.
    OfBoth,
    /// The left arm alone; it may fail as often as that.
    OfTheHostile { retries: usize },
}

/// One object from the shelf to the table.
pub fn mission(home: &Home, cup: Cup) -> PathBuf {
    let arm = "    arm:\n      shoulder: [-0.05 m, 0.188 m";
    let seeing = arm.replace("arm:\n", "arm:\n      reports: {facts: [lamp on]}\n");
    let pr2 = fs::read_to_string(file("config/robots/pr2.yaml")).expect("a robot");
    assert!(pr2.contains(arm));
    home.write("robot.yaml", &pr2.replace(arm, &seeing));
    let (offset, retries) = match cup {
        Cup::OfBoth => ("0.2 m", 2),
        Cup::OfTheHostile { retries } => ("0.6 m", retries),
    };
    let text = format!(
        "mission: fetch\nrobot: robot.yaml\nworld:\n  robot: {{at: [0 m, 0 m]}}\n  places:\n    shelf: {{stand: [1 m, 0 m]}}\n    \
         table: {{stand: [2 m, 0 m]}}\n  objects:\n    cup: {{at: shelf, offset: [0 m, {offset}]}}\n    mug: {{at: table}}\n  facts:\n    lamp on: {{holds: false, outside: true}}\ntask:\n  then:\n    - \
         move: shelf\n    - {{pick: cup, retries: {retries}, backoff: 0 s}}\n    - move: table\n    - place: cup\n"
    );
    home.write("fetch.yaml", &text)
}

/// The hostile process.
pub fn hostile(home: &Home, act: &str) -> Process {
    let own = std::env::current_exe().expect("this program");
    let args = ["--exact", "peers::acts::hostile", "--nocapture", "--quiet"];
    home.start_program(&own, args, |command| {
        command.env(ACT, act).env(INSTANCE, home.instance());
    })
}

impl Scene {
    /// The hostile process is the left arm.
    pub fn new(act: &str, cup: Cup, more: &[&str]) -> Self {
        Self::with(act, &HONEST, cup, "20", more)
    }

    /// The left arm is honest, and the hostile process is one more, which the mission leaves time for.
    pub fn beside(act: &str, more: &[&str]) -> Self {
        Self::with(act, &[&HONEST[..], &[HOSTILE]].concat(), Cup::OfBoth, "4", more)
    }

    fn with(act: &str, honest: &[&str], cup: Cup, speed: &str, more: &[&str]) -> Self {
        let home = Home::new();
        let mission = mission(&home, cup);
        let log = home.path("run.jsonl");
        let honest = honest.iter().map(|name| home.controller(name, &[])).collect();
        let hostile = hostile(&home, act);
        let log = ["--log", log.to_str().expect("a path in UTF-8")];
        let common = ["--json", "--speed", speed];
        let more: Vec<_> = common.iter().chain(&log).chain(more).copied().collect();
        let daemon = home.daemon(&mission, &more);
        Self { home, daemon, hostile, honest }
    }

    /// Waits for the daemon's end, ends the others, and looks whether something is left.
    pub fn ends(self, code: i32) -> Ending {
        let ending = self.ends_for_all(code);
        assert!(!ending.hostile.contains("panicked"), "the hostile one: {}", ending.hostile);
        ending
    }

    /// The same where the hostile process may have come to harm by what it did.
    pub fn ends_for_all(self, code: i32) -> Ending {
        let Self { home, daemon, hostile, honest } = self;
        let finished = daemon.ends(code);
        assert!(!finished.stderr.contains("panicked"), "{}", finished.stderr);
        hostile.signal(Signal::KILL);
        let said = hostile.stderr();
        hostile.wait();
        for process in honest {
            process.signal(Signal::TERM);
            process.ends(0);
        }
        link::sweep().expect("it is swept");
        home.is_empty();
        let log = home.path("run.jsonl");
        let verified = home.start(["verify".as_ref(), log.as_os_str()] as [&OsStr; 2]).ends(0);
        assert!(verified.stdout.starts_with("same: "), "{}", verified.stdout);
        let records = Reader::open(&log).expect("a log").map(|record| record.expect("a record")).collect();
        Ending { finished, records, hostile: said }
    }
}

impl Ending {
    /// What was recorded of the hostile controller.
    pub fn heard(&self) -> impl Iterator<Item = &ControllerMessage> {
        self.records.iter().filter_map(|record| match record {
            Record::Controller { controller: ControllerId(0), message, .. } => Some(message),
            _ => None,
        })
    }

    /// What of it was refused, and why.
    pub fn refused(&self) -> impl Iterator<Item = (Option<CommandId>, Rejection)> {
        self.heard().filter_map(|message| match message {
            ControllerMessage::Refused { id, why } => Some((*id, *why)),
            _ => None,
        })
    }

    /// How it was lost, each time.
    pub fn losses(&self) -> Vec<Loss> {
        let lost = self.heard().filter_map(|message| match message {
            ControllerMessage::Lost { why } => Some(*why),
            _ => None,
        });
        lost.collect()
    }

    pub fn says(&self, words: &str) {
        assert!(self.finished.words().contains(words), "\"{words}\" is not in\n{}", self.finished.stderr);
    }
}
