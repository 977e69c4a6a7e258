//! Processor time of a daemon and its four controllers: waiting for a goal, and running at speed 1.

#[path = "support/table.rs"]
mod table;

use std::fs;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, ChildStderr, Command, Stdio};
use std::time::{Duration, Instant};

use ambidex::link::{Instance, sweep};
use rustix::process::{Pid, Signal, kill_process};

const CONTROLLERS: [&str; 4] = ["left_arm", "right_arm", "base", "head"];
const ROBOT: &str = "config/robots/pr2.yaml";
/// How long each state is watched, wall time.
const WATCHED: Duration = Duration::from_secs(8);
/// After what has to have happened, so that its own cost is not counted.
const SETTLED: Duration = Duration::from_millis(500);
/// Pulses of a controller wake it ten times a second; half of that proves that it lives.
const WAKES_PER_S: f64 = 2.0;

/// A pick out of reach: it stalls at once.
const STALLING: &str = "
mission: idle
robot: ROBOT
world:
  robot: {at: [4 m, 4 m], heading: 0 deg}
  places:
    shelf: {stand: [1 m, 1 m]}
  objects:
    cup: {at: shelf}
task:
  pick: {object: cup}
";

fn main() {
    let folder = tempfile::tempdir().expect("a folder");
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let stalling = folder.path().join("stalling.yaml");
    let robot = root.join(ROBOT);
    fs::write(&stalling, STALLING.replace("ROBOT", robot.to_str().expect("plain letters"))).expect("a mission");
    let moving = root.join("config/missions/experiment-1.yaml");
    let rows = ["daemon"].into_iter().chain(CONTROLLERS);
    let waiting = Robot::start(&stalling, folder.path()).watch("attached", CONTROLLERS.len());
    let running = Robot::start(&moving, folder.path()).watch("step 1", 1);
    let titles = "process|waiting ms/s|wakes/s|running ms/s|wakes/s";
    let mut table = vec![titles.split('|').map(str::to_owned).collect::<Vec<_>>()];
    for (index, name) in rows.enumerate() {
        table.push(row(name, waiting[index], running[index]));
    }
    let sum = |used: &[Used]| Used {
        ms_per_s: used.iter().map(|used| used.ms_per_s).sum(),
        wakes_per_s: used.iter().map(|used| used.wakes_per_s).sum(),
    };
    table.push(row("all", sum(&waiting), sum(&running)));
    table::print("Processor time per second of wall time:", &table);
    println!(
        "\nwaiting: all are attached and the mission has stalled (--on-stall wait); running: the first\n\
         seconds of experiment 1 at speed 1, a drive and the beginning of two picks. {} s each; 10 ms/s is 1 % of a core;\n\
         wakes are voluntary context switches.",
        WATCHED.as_secs()
    );
}

fn row(name: &str, waiting: Used, running: Used) -> Vec<String> {
    let cells = [waiting, running]
        .into_iter()
        .flat_map(|used| [format!("{:.2}", used.ms_per_s), format!("{:.1}", used.wakes_per_s)]);
    [name.to_owned()].into_iter().chain(cells).collect()
}

/// What a process used, per second of wall time.
#[derive(Debug, Clone, Copy)]
struct Used {
    ms_per_s: f64,
    wakes_per_s: f64,
}

/// A daemon with its controllers; dropping kills what is left.
struct Robot {
    instance: Instance,
    said: BufReader<ChildStderr>,
    /// The daemon, then the controllers.
    processes: Vec<Child>,
}

impl Robot {
    fn start(mission: &Path, folder: &Path) -> Self {
        let instance = Instance::fresh();
        let log = folder.join(format!("{}.jsonl", instance.name()));
        let mut daemon = ambidex()
            .arg("daemon")
            .arg(mission)
            .arg("--log")
            .arg(log)
            .args(["--on-stall", "wait", "--attach-timeout", "10"])
            .args(["--instance", instance.name()])
            .stderr(Stdio::piped())
            .spawn()
            .expect("a daemon");
        let said = BufReader::new(daemon.stderr.take().expect("piped"));
        let mut processes = vec![daemon];
        for name in CONTROLLERS {
            let controller = ambidex()
                .args(["controller", name, "--once", "--robot", ROBOT])
                .args(["--instance", instance.name()])
                .args(["--parent", &std::process::id().to_string()])
                .spawn();
            processes.push(controller.expect("a controller"));
        }
        Self { instance, said, processes }
    }

    /// Waits until the daemon has said a word so often, then sees what each process uses, and ends all.
    fn watch(mut self, word: &str, times: usize) -> Vec<Used> {
        self.hear(word, times);
        std::thread::sleep(SETTLED);
        let (begun, before) = (Instant::now(), self.spent());
        std::thread::sleep(WATCHED);
        let (passed_s, after) = (begun.elapsed().as_secs_f64(), self.spent());
        let used: Vec<_> = std::iter::zip(before, after)
            .map(|(before, after)| Used {
                ms_per_s: (after.cpu_ns - before.cpu_ns) as f64 / 1e6 / passed_s,
                wakes_per_s: (after.wakes - before.wakes) as f64 / passed_s,
            })
            .collect();
        for used in &used {
            let is_alive = used.wakes_per_s > WAKES_PER_S && used.ms_per_s > 0.0;
            assert!(is_alive, "a process did nothing: {used:?}");
        }
        self.end();
        used
    }

    fn hear(&mut self, word: &str, times: usize) {
        let mut count = 0;
        let mut line = String::new();
        while count < times {
            line.clear();
            let length = self.said.read_line(&mut line).expect("it speaks");
            assert!(length > 0, "the daemon ended before it said {word:?}");
            count += usize::from(line.contains(word));
        }
    }

    fn spent(&self) -> Vec<Spent> {
        self.processes.iter().map(|child| Spent::by(child.id())).collect()
    }

    /// As by Ctrl-C: canceled, and the controllers leave with their daemon.
    fn end(mut self) {
        let daemon = Pid::from_child(&self.processes[0]);
        kill_process(daemon, Signal::TERM).expect("it is there");
        let mut rest = String::new();
        while self.said.read_line(&mut rest).is_ok_and(|length| length > 0) {}
        for (index, mut child) in self.processes.drain(..).enumerate() {
            let code = child.wait().expect("it ends").code();
            assert_eq!(code, Some(if index == 0 { 130 } else { 0 }));
        }
        sweep().expect("shared memory");
        assert!(!self.instance.has_left_anything(), "nothing is left behind");
    }
}

impl Drop for Robot {
    fn drop(&mut self) {
        for child in &mut self.processes {
            drop(child.kill());
            drop(child.wait());
        }
    }
}

fn ambidex() -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_ambidex"));
    command.current_dir(env!("CARGO_MANIFEST_DIR")).env_remove("RUST_LOG").stdin(Stdio::null()).stdout(Stdio::null());
    command
}

/// What all threads of a process have used since it began.
#[derive(Debug, Default, Clone, Copy)]
struct Spent {
    cpu_ns: u64,
    wakes: u64,
}

impl Spent {
    fn by(pid: u32) -> Self {
        let tasks = fs::read_dir(format!("/proc/{pid}/task")).expect("it lives");
        let mut spent = Self::default();
        for task in tasks.flatten() {
            let read = |name: &str| fs::read_to_string(task.path().join(name)).expect("it lives");
            // Nanoseconds on a core; `stat` counts only in ticks of 10 ms.
            let cpu_ns = read("schedstat").split(' ').next().map(str::parse::<u64>);
            spent.cpu_ns += cpu_ns.expect("a field").expect("a number");
            let status = read("status");
            let wakes = status.lines().find_map(|line| line.strip_prefix("voluntary_ctxt_switches:"));
            spent.wakes += wakes.expect("a field").trim().parse::<u64>().expect("a number");
        }
        spent
    }
}
