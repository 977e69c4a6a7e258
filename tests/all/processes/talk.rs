//! Nobody reads what is said, the disk is full, descriptors are few, a log is somebody else's: the robot goes on, or
//! the program says at once what is wrong.

use std::fs;
use std::io::{ErrorKind, PipeReader, Write, pipe};
use std::process::Stdio;
use std::time::{Duration, Instant};

use ambidex::link::Instance;
use rustix::process::Signal;

use super::report;
use crate::fixtures::experiment_file;
use crate::home::{Home, signal, within};

/// A pipe that takes nothing any more, and whose reader reads nothing.
fn full_pipe() -> (PipeReader, Stdio) {
    let (reader, mut writer) = pipe().expect("a pipe");
    rustix::io::ioctl_fionbio(&writer, true).expect("a pipe that does not block");
    loop {
        match writer.write(&[b'x'; 4096]) {
            Ok(_) => {}
            Err(error) if error.kind() == ErrorKind::WouldBlock => break,
            Err(error) => panic!("{error}"),
        }
    }
    rustix::io::ioctl_fionbio(&writer, false).expect("a pipe that blocks");
    (reader, writer.into())
}

/// The mission goes on and ends, though nobody reads a word of it.
#[test]
fn a_full_pipe_does_not_stop_the_robot() {
    let home = Home::new();
    let (_reader, pipe) = full_pipe();
    let mission = experiment_file(1);
    let args = ["run", "--speed", "100", "--json", mission.to_str().expect("a path in UTF-8")];
    let run = home.start_with(args, |command| {
        command.env("RUST_LOG", "ambidex=trace").stderr(pipe);
    });
    assert_eq!(report(&run.ends(0))["outcome"], "done");
    home.is_empty();
}

/// The first signal cancels, the second ends, whatever is written where.
#[test]
fn signals_reach_a_run_that_nobody_reads() {
    for (signals, code) in [(&[Signal::TERM][..], 130), (&[Signal::HUP, Signal::TERM], 130)] {
        let home = Home::new();
        let (_reader, pipe) = full_pipe();
        let mission = experiment_file(1);
        let log = home.path("run.jsonl");
        let [mission, to] = [&mission, &log].map(|path| path.to_str().expect("a path in UTF-8"));
        let run = home.start_with(["run", mission, "--log", to], |command| {
            command.env("RUST_LOG", "ambidex=trace").stderr(pipe);
        });
        let has_begun = || fs::read_to_string(&log).is_ok_and(|text| text.contains("\"decided\""));
        within(Duration::from_secs(10), "the mission begins", has_begun);
        let begun = Instant::now();
        signals.iter().for_each(|signal| run.signal(*signal));
        run.ends(code);
        assert!(begun.elapsed() < Duration::from_secs(8), "{signals:?}: {:?}", begun.elapsed());
    }
}

#[test]
fn a_controller_that_nobody_reads_ends_when_it_is_told_to() {
    let home = Home::new();
    let (_reader, pipe) = full_pipe();
    let instance = Instance::fresh();
    let args = ["controller", "head", "--instance", instance.name()];
    let head = home.start_with(args, |command| {
        command.env("RUST_LOG", "trace").stderr(pipe);
    });
    std::thread::sleep(Duration::from_millis(300));
    head.signal(Signal::HUP);
    head.ends(0);
    home.is_empty();
}

#[test]
fn a_log_is_a_file_of_its_own() {
    let home = Home::new();
    let mission = experiment_file(1);
    let mission = mission.to_str().expect("a path in UTF-8");
    let fifo = home.path("fifo");
    rustix::fs::mknodat(rustix::fs::CWD, &fifo, rustix::fs::FileType::Fifo, rustix::fs::Mode::RUSR, 0).expect("a FIFO");
    for no_file in [fifo.to_str().expect("a path in UTF-8"), "/dev/null", "/dev/full"] {
        for verb in ["run", "simulate"] {
            let refused = home.start([verb, mission, "--quiet", "--log", no_file]).ends(2);
            assert!(refused.words().contains("is no file"), "{}", refused.stderr);
        }
    }
    home.is_empty();
}

#[test]
fn two_writers_of_one_log_do_not_lose_the_first() {
    let home = Home::new();
    let log = home.path("one.jsonl");
    let log = log.to_str().expect("a path in UTF-8");
    let first = home.carry("run", &experiment_file(1), &["--speed", "5", "--json", "--quiet", "--log", log]);
    let is_begun = || fs::metadata(log).is_ok_and(|about| about.len() > 0);
    within(Duration::from_secs(10), "the first log is begun", is_begun);
    let mission = experiment_file(2);
    let second = home.start(["simulate", mission.to_str().expect("UTF-8"), "--quiet", "--log", log]).ends(2);
    assert!(second.words().contains("another run writes"), "{}", second.stderr);
    assert_eq!(report(&first.ends(0))["outcome"], "done");
    let text = fs::read_to_string(log).expect("the first log");
    assert!(text.lines().next().is_some_and(|header| header.contains("experiment-1")));
    assert!(text.lines().last().is_some_and(|end| end.contains("\"ended\"")));
    home.is_empty();
}

#[test]
fn too_few_descriptors_are_told_with_their_number() {
    let home = Home::new();
    let mission = experiment_file(1);
    for limit in [8, 16, 32, 64, 128] {
        let program = format!("ulimit -n {limit}; exec \"$0\" run \"$1\" --quiet");
        let args = ["-c", &program, env!("CARGO_BIN_EXE_ambidex"), mission.to_str().expect("UTF-8")];
        let output = std::process::Command::new("sh").args(args).output().expect("a shell");
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{limit}: {said}");
        assert!(said.contains("file descriptors are needed") && said.contains("ulimit -n"), "{limit}: {said}");
    }
    home.is_empty();
}

/// Whoever waits for a child that has ended waits for nothing.
#[test]
fn a_child_that_dies_before_it_attached_is_not_awaited() {
    let home = Home::new();
    let run = home.carry("run", &experiment_file(1), &["--quiet"]);
    let begun = Instant::now();
    let child = loop {
        if let Some((pid, _)) = home.processes().into_iter().find(|(_, words)| words.contains("controller base")) {
            break pid;
        }
        assert!(begun.elapsed() < Duration::from_secs(10), "no child came");
    };
    signal(child, Signal::KILL);
    let ended = run.ends(4);
    assert!(begun.elapsed() < Duration::from_secs(6), "{:?}", begun.elapsed());
    assert!(ended.stderr.contains("base"), "{}", ended.stderr);
    home.is_empty();
}
