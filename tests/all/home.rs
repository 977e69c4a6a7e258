//! The program as processes in surroundings of their own, of which nothing may be left in the end.

use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicU32, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use ambidex::link::{self, Instance};
use rustix::process::{Pid, Signal, kill_process};
use tempfile::TempDir;

use crate::fixtures::file;

/// What takes longer hangs.
const DEADLINE: Duration = Duration::from_secs(60);
const POLL: Duration = Duration::from_millis(5);

/// A folder and an instance that no other test has. Dropped, it ends every process that was started in it.
pub struct Home {
    dir: TempDir,
    instance: Instance,
    started: AtomicU32,
}

/// A process of the program.
pub struct Process {
    child: Child,
    says: String,
    out: PathBuf,
    err: PathBuf,
}

/// How a process ended.
#[derive(Debug)]
pub struct Finished {
    /// None when a signal ended it.
    pub code: Option<i32>,
    pub stdout: String,
    pub stderr: String,
}

impl Home {
    pub fn new() -> Self {
        Self { dir: tempfile::tempdir().expect("a folder"), instance: Instance::fresh(), started: AtomicU32::new(0) }
    }

    /// The name of this home's instance.
    pub fn instance(&self) -> &str {
        self.instance.name()
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.dir.path().join(name)
    }

    pub fn write(&self, name: &str, text: &str) -> PathBuf {
        let path = self.path(name);
        fs::write(&path, text).expect("a file");
        path
    }

    /// Starts the program.
    pub fn start<S: AsRef<OsStr>>(&self, args: impl IntoIterator<Item = S>) -> Process {
        self.start_with(args, |_| {})
    }

    /// Starts the program with something else about it: folder, environment.
    pub fn start_with<S: AsRef<OsStr>>(
        &self,
        args: impl IntoIterator<Item = S>,
        adapt: impl FnOnce(&mut Command),
    ) -> Process {
        self.start_program(env!("CARGO_BIN_EXE_ambidex").as_ref(), args, adapt)
    }

    /// Starts any program as one of this home.
    pub fn start_program<S: AsRef<OsStr>>(
        &self,
        program: &Path,
        args: impl IntoIterator<Item = S>,
        adapt: impl FnOnce(&mut Command),
    ) -> Process {
        let number = self.started.fetch_add(1, Ordering::Relaxed);
        let (out, err) = (self.path(&format!("{number}.out")), self.path(&format!("{number}.err")));
        let mut command = Command::new(program);
        command
            .args(args)
            .current_dir(file(""))
            .env("XDG_STATE_HOME", self.dir.path())
            .env_remove("RUST_LOG")
            .env_remove("NO_COLOR")
            .stdin(Stdio::null())
            .stdout(fs::File::create(&out).expect("a file"))
            .stderr(fs::File::create(&err).expect("a file"));
        adapt(&mut command);
        let says = format!("{command:?}");
        let child = command.spawn().expect("the program starts");
        Process { child, says, out, err }
    }

    /// Starts a daemon of this home's instance.
    pub fn daemon(&self, mission: &Path, more: &[&str]) -> Process {
        self.carry("daemon", mission, more)
    }

    /// Starts `run` or `daemon` in the instance.
    pub fn carry(&self, verb: &str, mission: &Path, more: &[&str]) -> Process {
        let args = [verb, "--instance", self.instance.name()].map(OsStr::new);
        let more = more.iter().map(OsStr::new);
        self.start(args.into_iter().chain([mission.as_os_str()]).chain(more))
    }

    /// Starts a controller of this home's instance.
    pub fn controller(&self, name: &str, more: &[&str]) -> Process {
        let args = ["controller", name, "--instance", self.instance.name()];
        self.start(args.iter().chain(more))
    }

    /// Asks what the mission of this home's instance is at.
    pub fn status(&self, more: &[&str]) -> Process {
        let args = ["status", "--instance", self.instance.name()];
        self.start(args.iter().chain(more))
    }

    /// The processes that were started in this home and live, be they of this test or their children.
    pub fn processes(&self) -> Vec<(u32, String)> {
        let mark = format!("XDG_STATE_HOME={}", self.dir.path().display());
        let pids = fs::read_dir("/proc").expect("a list of processes");
        let pids = pids.flatten().filter_map(|entry| entry.file_name().to_str()?.parse().ok());
        pids.filter_map(|pid: u32| {
            let environment = fs::read(format!("/proc/{pid}/environ")).ok()?;
            let is_ours = environment.split(|byte| *byte == 0).any(|one| one == mark.as_bytes());
            let command = fs::read_to_string(format!("/proc/{pid}/cmdline")).ok()?;
            is_ours.then(|| (pid, command.replace('\0', " ")))
        })
        .collect()
    }

    /// The one process of this home whose command line has these words.
    pub fn process(&self, words: &str) -> u32 {
        let found: Vec<_> = self.processes().into_iter().filter(|(_, command)| command.contains(words)).collect();
        let [(pid, _)] = found.as_slice() else {
            panic!("one process with \"{words}\" is wanted, there is {found:?}");
        };
        *pid
    }

    /// The instance of this home and those that its runs have chosen, which are told by the folders of their logs.
    pub fn instances(&self) -> Vec<Instance> {
        let logs = fs::read_dir(self.path("ambidex")).into_iter().flatten().flatten();
        let names = logs.filter_map(|entry| entry.file_name().into_string().ok());
        let fresh = names.filter_map(|name| Instance::new(&name).ok());
        fresh.chain([self.instance.clone()]).collect()
    }

    /// The log of the only instance that has one.
    pub fn log(&self) -> String {
        let logs: Vec<_> = self
            .instances()
            .iter()
            .map(|instance| self.path("ambidex").join(instance.name()).join("journal.jsonl"))
            .filter(|path| path.exists())
            .collect();
        fs::read_to_string(logs.first().expect("a log")).expect("a log that can be read")
    }

    /// Asserts that no process and no file in shared memory is left.
    pub fn is_empty(&self) {
        assert_eq!(self.processes(), [], "processes are left");
        for instance in self.instances() {
            assert!(!instance.has_left_anything(), "{} is left in shared memory", instance.name());
        }
    }
}

impl Drop for Home {
    fn drop(&mut self) {
        for (pid, _) in self.processes() {
            signal(pid, Signal::KILL);
        }
        drop(link::sweep());
    }
}

impl Finished {
    /// What it said on stderr, however the lines were broken.
    pub fn words(&self) -> String {
        flat(&self.stderr)
    }
}

impl Process {
    pub fn pid(&self) -> u32 {
        self.child.id()
    }

    pub fn signal(&self, with: Signal) {
        signal(self.pid(), with);
    }

    pub fn stderr(&self) -> String {
        fs::read_to_string(&self.err).expect("what it said")
    }

    pub fn stdout(&self) -> String {
        fs::read_to_string(&self.out).expect("what it said")
    }

    /// Waits until it has said these words on stderr.
    pub fn says(&mut self, words: &str) {
        let by = Instant::now() + DEADLINE;
        while !self.stderr().contains(words) {
            let has_ended = self.child.try_wait().expect("a child").is_some();
            if (has_ended && !self.stderr().contains(words)) || Instant::now() > by {
                panic!("{} never said \"{words}\":\n{}", self.says, self.stderr());
            }
            thread::sleep(POLL);
        }
    }

    pub fn has_ended(&mut self) -> bool {
        self.child.try_wait().expect("a child").is_some()
    }

    /// Waits for its end; one that hangs fails the test with what it said.
    pub fn wait(mut self) -> Finished {
        let by = Instant::now() + DEADLINE;
        while !self.has_ended() {
            assert!(Instant::now() < by, "{} hangs:\n{}", self.says, self.stderr());
            thread::sleep(POLL);
        }
        Finished { code: self.child.wait().expect("a child").code(), stdout: self.stdout(), stderr: self.stderr() }
    }

    /// Waits for its end, which must have this code.
    pub fn ends(self, code: i32) -> Finished {
        let says = self.says.clone();
        let finished = self.wait();
        assert_eq!(finished.code, Some(code), "{says}\n{finished:#?}");
        finished
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        if matches!(self.child.try_wait(), Ok(None)) {
            drop(self.child.kill());
            drop(self.child.wait());
        }
    }
}

/// A text without its line breaks and what stands before broken lines.
pub fn flat(text: &str) -> String {
    text.split_whitespace().filter(|word| *word != "│").collect::<Vec<_>>().join(" ")
}

/// Sends a signal to a process that may have ended.
pub fn signal(pid: u32, with: Signal) {
    let pid = i32::try_from(pid).ok().and_then(Pid::from_raw).expect("a process id");
    let _ = kill_process(pid, with);
}

/// Waits until something is so, which must be within the time.
pub fn within(time: Duration, what: &str, mut is_so: impl FnMut() -> bool) {
    let by = Instant::now() + time;
    while !is_so() {
        assert!(Instant::now() < by, "{what}: not within {time:?}");
        thread::sleep(POLL);
    }
}
