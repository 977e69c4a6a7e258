//! The processes of one run: a daemon and its controllers, each of this very program, in a folder of their own.

use std::fs::File;
use std::io;
use std::path::PathBuf;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use ambidex::link::Instance;
use rustix::process::{Pid, Signal, kill_process};

/// How often the end of a process is looked for.
const POLL: Duration = Duration::from_millis(10);
/// How long controllers may take to end in order.
const GRACE: Duration = Duration::from_secs(4);

/// What every process of a run is started with.
#[derive(Debug, Clone)]
pub struct Recipe {
    pub program: PathBuf,
    pub folder: PathBuf,
    pub instance: Instance,
    pub mission: PathBuf,
    pub robot: PathBuf,
    pub speed: f64,
}

/// The processes; whatever is left is killed in the end.
#[derive(Debug)]
pub struct Processes {
    recipe: Recipe,
    names: Vec<String>,
    daemon: Child,
    controllers: Vec<Option<Child>>,
    started: u32,
}

impl Recipe {
    pub fn log(&self) -> PathBuf {
        self.folder.join("log.jsonl")
    }

    pub fn failures(&self) -> PathBuf {
        self.folder.join("failures.yaml")
    }

    pub fn records(&self) -> PathBuf {
        self.folder.join("records")
    }

    fn start(&self, name: &str, args: impl FnOnce(&mut Command)) -> io::Result<Child> {
        let mut command = Command::new(&self.program);
        args(&mut command);
        command
            .args(["--instance", self.instance.name()])
            .env("XDG_STATE_HOME", &self.folder)
            .env_remove("RUST_LOG")
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(File::create(self.folder.join(format!("{name}.err")))?);
        command.spawn()
    }

    fn daemon(&self, number: u32, args: impl FnOnce(&mut Command)) -> io::Result<Child> {
        self.start(&format!("daemon-{number}"), |command| {
            command.arg("daemon").args(["--speed", &self.speed.to_string(), "--attach-timeout", "20"]);
            args(command);
        })
    }

    fn controller(&self, name: &str, number: u32) -> io::Result<Child> {
        self.start(&format!("{name}-{number}"), |command| {
            let record = self.records().join(format!("{name}.jsonl"));
            command.args(["controller", name, "--robot"]).arg(&self.robot).arg("--record").arg(record);
            command.args(["--parent", &std::process::id().to_string()]);
        })
    }
}

impl Processes {
    /// Starts a daemon with the failures of the recipe's folder, if it has any, and all controllers.
    pub fn start(recipe: Recipe, names: Vec<String>) -> io::Result<Self> {
        let daemon = recipe.daemon(0, |command| {
            command.arg(&recipe.mission).arg("--robot").arg(&recipe.robot).arg("--log").arg(recipe.log());
            command.args(["--reattach-timeout", "3", "--cleanup-grace", "5"]);
            if recipe.failures().exists() {
                command.arg("--fail").arg(recipe.failures());
            }
        })?;
        let controllers = names.iter().map(|_| None).collect();
        let mut processes = Self { recipe, names, daemon, controllers, started: 0 };
        for index in 0..processes.names.len() {
            processes.start_controller(index)?;
        }
        Ok(processes)
    }

    pub fn start_controller(&mut self, index: usize) -> io::Result<()> {
        self.kill_controller(index);
        self.started += 1;
        self.controllers[index] = Some(self.recipe.controller(&self.names[index], self.started)?);
        Ok(())
    }

    pub fn kill_controller(&mut self, index: usize) {
        if let Some(mut child) = self.controllers[index].take() {
            end(&mut child);
        }
    }

    /// Sends a signal to a controller, if it is there.
    pub fn signal_controller(&mut self, index: usize, with: Signal) {
        if let Some(child) = &mut self.controllers[index] {
            signal(child, with);
        }
    }

    pub fn signal_daemon(&mut self, with: Signal) {
        signal(&mut self.daemon, with);
    }

    /// Kills the daemon.
    pub fn kill_daemon(&mut self) {
        end(&mut self.daemon);
    }

    /// Another daemon goes on in the log.
    pub fn resume(&mut self) -> io::Result<()> {
        self.started += 1;
        let log = self.recipe.log();
        self.daemon = self.recipe.daemon(self.started, |command| {
            command.arg("--resume").arg(log);
        })?;
        Ok(())
    }

    /// How the daemon has ended, if it has.
    pub fn ended(&mut self) -> Option<ExitStatus> {
        self.daemon.try_wait().ok().flatten()
    }

    /// Tells controllers to end; names of those that do not.
    pub fn end_controllers(&mut self) -> Vec<String> {
        for index in 0..self.names.len() {
            self.signal_controller(index, Signal::TERM);
            self.signal_controller(index, Signal::CONT);
        }
        let by = Instant::now() + GRACE;
        let mut left = Vec::new();
        for (index, slot) in self.controllers.iter_mut().enumerate() {
            let Some(child) = slot else { continue };
            while matches!(child.try_wait(), Ok(None)) && Instant::now() < by {
                thread::sleep(POLL);
            }
            if matches!(child.try_wait(), Ok(None)) {
                left.push(self.names[index].clone());
                end(child);
            }
            *slot = None;
        }
        left
    }

    /// What the last daemon said, its end only.
    pub fn last_words(&self) -> String {
        let number = (0..=self.started).rev().map(|number| self.recipe.folder.join(format!("daemon-{number}.err")));
        let said = number.into_iter().find_map(|path| std::fs::read_to_string(path).ok()).unwrap_or_default();
        let lines: Vec<&str> = said.lines().rev().take(4).collect();
        lines.into_iter().rev().collect::<Vec<_>>().join(" / ")
    }
}

impl Drop for Processes {
    fn drop(&mut self) {
        end(&mut self.daemon);
        self.controllers.iter_mut().flatten().for_each(end);
    }
}

fn signal(child: &mut Child, with: Signal) {
    if matches!(child.try_wait(), Ok(None)) {
        // It may end at this moment.
        let _ = kill_process(Pid::from_child(child), with);
    }
}

/// Kills it, if it has not ended by itself.
fn end(child: &mut Child) {
    drop(child.kill());
    drop(child.wait());
}
