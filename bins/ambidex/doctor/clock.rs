//! Time: what the clocks resolve, whether the wall clock jumps, how late a process gets the processor.

use std::fs;
use std::path::Path;
use std::thread;
use std::time::{Duration, Instant, SystemTime};

use ambidex::model::session::BEAT_EVERY;
use ambidex::motion::STEP;
use ambidex::record::shown;
use ambidex::show::doctor::{Check, Topic};
use rustix::time::{ClockId, clock_getres};

use super::{Subject, first_line};

const TOPIC: Topic = Topic::Clock;
/// Coarser than that, moments of a robot fall together.
const FINE: Duration = Duration::from_micros(1);
/// Clocks that are read without the help of a device.
const FAST: [&str; 7] =
    ["tsc", "kvm-clock", "arch_sys_counter", "hyperv_clocksource_tsc_page", "xen", "riscv_clocksource", "timebase"];
/// How often, and how long, the process sleeps to see when it wakes.
const SLEEPS: usize = 200;
const SLEEP: Duration = Duration::from_millis(1);
/// More than that the wall clock does not drift from the other meanwhile.
const STEPPED: Duration = Duration::from_millis(50);
/// So far in the future a file may seem to be written.
const AHEAD: Duration = Duration::from_secs(2);

/// What was seen while the process slept again and again.
struct Sleeping {
    /// How late it woke, the shortest first.
    late: Vec<Duration>,
    /// By how much the wall clock went another way than the monotonic one.
    stepped: Duration,
}

/// Looks at the clocks, for a fraction of a second.
pub(super) fn checks(subject: &Subject) -> Vec<Check> {
    let source = first_line("/sys/devices/system/clocksource/clocksource0/current_clocksource");
    let sleeping = sleep();
    let mut checks = vec![resolution()];
    checks.extend(source.map(|source| clock_source(&source)));
    checks.push(wall_clock(sleeping.stepped, subject.log.as_deref(), SystemTime::now()));
    checks.push(latency(&sleeping.late));
    checks.push(cores(thread::available_parallelism().map_or(1, |cores| cores.get())));
    checks.extend(governor(&governors()));
    checks
}

fn resolution() -> Check {
    let of = |clock| Duration::try_from(clock_getres(clock)).unwrap_or(Duration::MAX);
    let (monotonic, wall) = (of(ClockId::Monotonic), of(ClockId::Realtime));
    let found = format!("monotonic {monotonic:?}, wall {wall:?}");
    if monotonic <= FINE {
        TOPIC.ok("resolution", found)
    } else {
        TOPIC.warn("resolution", found, "use a kernel with high-resolution timers (CONFIG_HIGH_RES_TIMERS)")
    }
}

fn clock_source(source: &str) -> Check {
    if FAST.contains(&source) {
        return TOPIC.ok("clock source", source);
    }
    let todo = "see with `dmesg | grep -i tsc` why the kernel does not trust a faster one";
    TOPIC.warn("clock source", format!("{source}, which is slow to read"), todo)
}

fn sleep() -> Sleeping {
    let (wall, monotonic) = (SystemTime::now(), Instant::now());
    let late = |_| {
        let asleep = Instant::now();
        thread::sleep(SLEEP);
        asleep.elapsed().saturating_sub(SLEEP)
    };
    let mut late: Vec<Duration> = (0..SLEEPS).map(late).collect();
    late.sort();
    let passed = monotonic.elapsed();
    // A wall clock that went back has not passed at all.
    let stepped = SystemTime::now().duration_since(wall).unwrap_or_default().abs_diff(passed);
    Sleeping { late, stepped }
}

/// Robots live by the monotonic clock; who compares logs and files lives by the other.
fn wall_clock(stepped: Duration, log: Option<&Path>, now: SystemTime) -> Check {
    let todo = "robots do not mind, but `status` and the order of logs do: see `timedatectl`, let time be slewed";
    if stepped > STEPPED {
        return TOPIC.warn("wall clock", format!("it was set by {stepped:.1?} just now"), todo);
    }
    let ahead = |log: &Path| {
        let written = fs::metadata(log).and_then(|about| about.modified()).ok()?;
        written.duration_since(now).ok().filter(|ahead| *ahead > AHEAD)
    };
    match log.and_then(|log| Some((log, ahead(log)?))) {
        Some((log, ahead)) => {
            let found = format!("it was set back: {} was written {ahead:.0?} from now", shown(log));
            TOPIC.warn("wall clock", found, todo)
        }
        None => TOPIC.ok("wall clock", "it goes as the monotonic one does"),
    }
}

/// How late a process is that is to wake in a moment.
fn latency(late: &[Duration]) -> Check {
    let at = |part: usize| late.get((late.len() * part / 100).min(late.len() - 1)).copied().unwrap_or_default();
    let (median, worst) = (at(50), at(100));
    let found = format!("woke {median:.0?} late, {worst:.0?} at worst of {}", late.len());
    let todo = "see with `top` who takes the processor; give the robot a machine, or cores, of its own";
    if worst >= BEAT_EVERY {
        TOPIC.error("latency", format!("{found}: controllers would give a daemon up"), todo)
    } else if worst >= STEP {
        TOPIC.warn("latency", format!("{found}: motion has steps of {STEP:?}"), todo)
    } else {
        TOPIC.ok("latency", found)
    }
}

fn cores(cores: usize) -> Check {
    match cores {
        0 | 1 => TOPIC.warn("cores", "1: daemon and controllers take turns", "give the robot another core"),
        more => TOPIC.ok("cores", more.to_string()),
    }
}

/// How the speed of each core is governed, each word once; none where it is not told, as in virtual machines.
fn governors() -> Vec<String> {
    let cores = fs::read_dir("/sys/devices/system/cpu").into_iter().flatten().flatten();
    let mut words: Vec<String> =
        cores.filter_map(|core| first_line(core.path().join("cpufreq/scaling_governor"))).collect();
    words.sort();
    words.dedup();
    words
}

fn governor(words: &[String]) -> Option<Check> {
    let found = words.join(", ");
    let todo = "`cpupower frequency-set -g performance` as root, where late wake-ups matter";
    match words {
        [] => None,
        _ if words.iter().any(|word| word == "powersave") => Some(TOPIC.warn("governor", found, todo)),
        _ => Some(TOPIC.ok("governor", found)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ambidex::show::doctor::Verdict;

    #[test]
    fn lateness_is_judged_by_what_robots_need() {
        for (worst, expected) in [(2, Verdict::Ok), (10, Verdict::Warn), (299, Verdict::Warn), (300, Verdict::Error)] {
            let late = [vec![Duration::from_micros(60); SLEEPS - 1], vec![Duration::from_millis(worst)]].concat();
            assert_eq!(latency(&late).verdict, expected, "{worst} ms");
        }
    }

    #[test]
    fn a_wall_clock_that_jumps_is_told() {
        let home = tempfile::tempdir().expect("a folder");
        let log = home.path().join("journal.jsonl");
        fs::write(&log, "x").expect("a file");
        let now = SystemTime::now();
        let check = |stepped, now, expected| {
            assert_eq!(wall_clock(stepped, Some(&log), now).verdict, expected, "{stepped:?}");
        };
        check(Duration::ZERO, now, Verdict::Ok);
        check(STEPPED * 2, now, Verdict::Warn);
        check(Duration::ZERO, now - Duration::from_secs(3600), Verdict::Warn);
    }

    #[test]
    fn what_clocks_and_processors_are_is_judged() {
        let judged = |words: &[&str]| governor(&words.iter().map(|word| (*word).to_owned()).collect::<Vec<_>>());
        assert_eq!(judged(&[]), None);
        assert_eq!(judged(&["performance"]).map(|check| check.verdict), Some(Verdict::Ok));
        assert_eq!(judged(&["performance", "powersave"]).map(|check| check.verdict), Some(Verdict::Warn));
        assert_eq!((clock_source("tsc").verdict, clock_source("hpet").verdict), (Verdict::Ok, Verdict::Warn));
        assert_eq!((cores(1).verdict, cores(2).verdict), (Verdict::Warn, Verdict::Ok));
    }
}
