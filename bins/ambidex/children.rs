//! Controller processes as children of `run`: started with it, gone with it.

use std::io::{self, BufRead, BufReader};
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStderr, Command, Stdio};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use ambidex::link::Instance;
use ambidex::model::RobotSpec;
use clap::ValueEnum;
use miette::{IntoDiagnostic, Result};
use rustix::process::{Pid, Signal, kill_process};

use crate::terminal::Terminal;
use crate::values::LogFormat;

/// How often the end of a child is looked for.
const POLL: Duration = Duration::from_millis(5);

/// One child per controller; dropping kills what is left.
#[derive(Debug)]
pub struct Children {
    recipe: Recipe,
    children: Vec<Child>,
    names: Vec<String>,
    /// Those that were ended on purpose.
    meant: Vec<bool>,
    voices: Vec<JoinHandle<()>>,
}

/// How a child is started.
#[derive(Debug)]
struct Recipe {
    program: PathBuf,
    file: PathBuf,
    instance: Instance,
    format: LogFormat,
    terminal: Terminal,
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
        let recipe = Recipe {
            program: std::env::current_exe().into_diagnostic()?,
            file: file.to_owned(),
            instance: instance.clone(),
            format,
            terminal: terminal.clone(),
        };
        let mut children =
            Self { recipe, children: Vec::new(), names: Vec::new(), meant: Vec::new(), voices: Vec::new() };
        for controller in &robot.controllers {
            let (child, voice) = children.recipe.start(&controller.name).into_diagnostic()?;
            children.voices.extend(voice);
            children.children.push(child);
            children.names.push(controller.name.clone());
            children.meant.push(false);
        }
        Ok(children)
    }

    /// The processes, by controller.
    pub fn pids(&self) -> Vec<u32> {
        self.children.iter().map(Child::id).collect()
    }

    /// What a child is called.
    pub fn name(&self, index: usize) -> &str {
        &self.names[index]
    }

    /// Whether a process that ended is still the child, and was not ended on purpose.
    pub fn is_missed(&self, index: usize, pid: u32) -> bool {
        !self.meant[index] && self.children.get(index).is_some_and(|child| child.id() == pid)
    }

    /// Ends a child at once.
    pub fn kill(&mut self, index: usize) {
        self.meant[index] = true;
        let child = &mut self.children[index];
        // One that has ended by itself is as dead.
        drop(child.kill());
        drop(child.wait());
    }

    /// Holds a child, which is there and does nothing any more.
    pub fn hold(&self, index: usize) {
        let _ = kill_process(Pid::from_child(&self.children[index]), Signal::STOP);
    }

    /// Lets a child that is held go on.
    pub fn release(&self, index: usize) {
        let _ = kill_process(Pid::from_child(&self.children[index]), Signal::CONT);
    }

    /// Presses the emergency stop of a child.
    pub fn press_stop(&self, index: usize) {
        let _ = kill_process(Pid::from_child(&self.children[index]), Signal::USR1);
    }

    /// Releases the emergency stop of a child.
    pub fn release_stop(&self, index: usize) {
        let _ = kill_process(Pid::from_child(&self.children[index]), Signal::USR2);
    }

    /// Starts a child that has ended once more; gives its process.
    ///
    /// # Errors
    /// When it cannot be started.
    pub fn restart(&mut self, index: usize) -> io::Result<u32> {
        // What is left of the one before it; never two at once.
        drop(self.children[index].kill());
        drop(self.children[index].wait());
        let (child, voice) = self.recipe.start(&self.names[index])?;
        (self.children[index], self.meant[index]) = (child, false);
        self.voices.extend(voice);
        Ok(self.children[index].id())
    }

    /// Tells all to end and waits for it; kills those that have not when the time is over.
    pub fn end(&mut self, timeout: Duration) {
        // They would see by themselves that the daemon is silent, but only after the dead-man's time.
        for child in &self.children {
            let _ = kill_process(Pid::from_child(child), Signal::TERM);
            // One that is held would hear it too late.
            let _ = kill_process(Pid::from_child(child), Signal::CONT);
        }
        let by = Instant::now() + timeout;
        while Instant::now() < by {
            self.children.retain_mut(|child| matches!(child.try_wait(), Ok(None)));
            if self.children.is_empty() {
                break;
            }
            thread::sleep(POLL);
        }
        self.reap();
    }

    fn reap(&mut self) {
        for child in &mut self.children {
            drop(child.kill());
            drop(child.wait());
        }
        for voice in self.voices.drain(..) {
            drop(voice.join());
        }
    }
}

impl Drop for Children {
    fn drop(&mut self) {
        self.reap();
    }
}

impl Recipe {
    fn start(&self, name: &str) -> io::Result<(Child, Option<JoinHandle<()>>)> {
        let format = self.format.to_possible_value().expect("no form is hidden");
        let mut command = Command::new(&self.program);
        command
            .args(["controller", name, "--once", "--instance", self.instance.name()])
            .arg("--robot")
            .arg(&self.file)
            .args(["--log-format", format.get_name()])
            .args(["--parent", &std::process::id().to_string()])
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            // A group of its own: Ctrl-C reaches this process alone, which then ends the children in order.
            .process_group(0);
        if self.terminal.has_color() {
            command.env("CLICOLOR_FORCE", "1");
        }
        let mut child = command.spawn()?;
        let voice = child.stderr.take().map(|stderr| voice(stderr, self.terminal.clone()));
        Ok((child, voice))
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
