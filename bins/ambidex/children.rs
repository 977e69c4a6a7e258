//! Controller processes as children of `run`: started with it, gone with it.

use std::io::{BufRead, BufReader};
use std::os::unix::process::CommandExt;
use std::path::Path;
use std::process::{Child, ChildStderr, Command, Stdio};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use ambidex::link::Instance;
use ambidex::model::RobotSpec;
use ambidex::runtime::{Control, process_end};
use clap::ValueEnum;
use miette::{IntoDiagnostic, Result};
use rustix::process::{Pid, Signal, kill_process};
use tokio::sync::mpsc;

use crate::terminal::Terminal;
use crate::values::LogFormat;

/// How often the end of a child is looked for.
const POLL: Duration = Duration::from_millis(5);

/// One child per controller; dropping kills what is left.
#[derive(Debug)]
pub struct Children {
    children: Vec<Child>,
    names: Vec<String>,
    voices: Vec<JoinHandle<()>>,
}

impl Children {
    /// Starts every controller of a robot as a process of this very program. What it says comes above the display.
    pub fn start(
        robot: &RobotSpec,
        file: &Path,
        instance: &Instance,
        format: LogFormat,
        terminal: &Terminal,
    ) -> Result<Self> {
        let program = std::env::current_exe().into_diagnostic()?;
        let format = format.to_possible_value().expect("no form is hidden");
        let mut children = Self { children: Vec::new(), names: Vec::new(), voices: Vec::new() };
        for controller in &robot.controllers {
            let mut command = Command::new(&program);
            command
                .args(["controller", &controller.name, "--once", "--instance", instance.name()])
                .arg("--robot")
                .arg(file)
                .args(["--log-format", format.get_name()])
                .args(["--parent", &std::process::id().to_string()])
                .stdin(Stdio::null())
                .stdout(Stdio::null())
                .stderr(Stdio::piped())
                // A group of its own: Ctrl-C reaches this process alone, which then ends the children in order.
                .process_group(0);
            if terminal.has_color() {
                command.env("CLICOLOR_FORCE", "1");
            }
            let mut child = command.spawn().into_diagnostic()?;
            let voice = child.stderr.take().map(|stderr| voice(stderr, terminal.clone()));
            children.voices.extend(voice);
            children.children.push(child);
            children.names.push(controller.name.clone());
        }
        Ok(children)
    }

    /// A child that ends before the mission begins will not attach: says so, and that nobody need wait for it.
    pub fn watch(&self, terminal: &Terminal, run: &mpsc::UnboundedSender<Control>) {
        for (child, name) in std::iter::zip(&self.children, &self.names) {
            let (pid, terminal, run, name) = (child.id(), terminal.clone(), run.clone(), name.clone());
            tokio::spawn(async move {
                if process_end(pid).await.is_ok() && run.send(Control::GiveUp).is_ok() {
                    terminal.say(&format!("the process of {name} has ended"));
                }
            });
        }
    }

    /// Tells all to end and waits for it; kills those that have not when the time is over.
    pub fn end(mut self, timeout: Duration) {
        // They would see by themselves that the daemon is silent, but only after the dead-man's time.
        for child in &self.children {
            let _ = kill_process(Pid::from_child(child), Signal::TERM);
        }
        let by = Instant::now() + timeout;
        while Instant::now() < by {
            self.children.retain_mut(|child| matches!(child.try_wait(), Ok(None)));
            if self.children.is_empty() {
                return;
            }
            thread::sleep(POLL);
        }
    }
}

impl Drop for Children {
    fn drop(&mut self) {
        for child in &mut self.children {
            drop(child.kill());
            drop(child.wait());
        }
        for voice in self.voices.drain(..) {
            drop(voice.join());
        }
    }
}

/// Says what a child says, line by line, until it ends.
fn voice(stderr: ChildStderr, terminal: Terminal) -> JoinHandle<()> {
    thread::spawn(move || {
        for line in BufReader::new(stderr).lines().map_while(std::io::Result::ok) {
            terminal.say(&line);
        }
    })
}
