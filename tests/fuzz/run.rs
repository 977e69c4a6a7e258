//! One target: what is committed first, then what is made of it, for as long as is asked.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, Once, PoisonError};
use std::time::{Duration, Instant};
use std::{env, fs};

use crate::corpus;
use crate::limits::{BYTES, CPU};
use crate::meter::{Measured, measured};
use crate::mutate::{Form, Mutator};
use crate::rng::Rng;
use crate::shrink::shrunk;
use crate::targets::{Taken, hash};
use crate::watchdog::{Watched, folder};

/// Something that reads what others wrote.
pub struct Target {
    pub name: &'static str,
    pub form: Form,
    /// Inputs to begin with, beside those that are committed.
    pub seeds: fn() -> Vec<Vec<u8>>,
    pub run: fn(&[u8]) -> Taken,
}

/// Most inputs that are kept because they were new.
const POOL: usize = 2000;
/// Most different faults that one run looks for.
const FAULTS: usize = 8;

/// What was asked for.
struct Asked {
    time: Duration,
    seed: u64,
    /// Only this input.
    input: Option<PathBuf>,
}

impl Asked {
    fn here() -> Self {
        let number = |name: &str| env::var(name).ok().map(|value| value.parse::<u64>().expect("a whole number"));
        Self {
            time: number("AMBIDEX_FUZZ_SECONDS").map_or(Duration::from_millis(1200), Duration::from_secs),
            seed: number("AMBIDEX_FUZZ_SEED").unwrap_or(1),
            input: env::var_os("AMBIDEX_FUZZ_INPUT").map(PathBuf::from),
        }
    }
}

/// What a run came to.
#[derive(Default)]
struct Tally {
    count: u64,
    accepted: u64,
    slowest: Duration,
    largest: usize,
    kinds: BTreeSet<u64>,
    /// By what is wrong: one input for each.
    faults: BTreeMap<String, PathBuf>,
}

/// Nothing else runs in this process as long as it is held.
fn alone() -> MutexGuard<'static, ()> {
    static ALONE: Mutex<()> = Mutex::new(());
    ALONE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Runs given inputs, each with its name.
pub fn each(name: &'static str, inputs: impl Iterator<Item = (String, String)>, run: fn(&[u8]) -> Taken) {
    let _alone = alone();
    let target = Target { name, form: Form::Bytes, seeds: Vec::new, run };
    let mut faults = Vec::new();
    for (what, input) in inputs {
        let measured = once(&target, input.as_bytes());
        println!(
            "{what}: {} bytes, {:?} of CPU time, {:.1} MB",
            input.len(),
            measured.cpu,
            measured.bytes as f64 / 1e6
        );
        faults.extend(fault(&measured).map(|fault| format!("{what}: {fault}")));
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

/// Runs a target, alone in this process.
pub fn fuzz(target: &Target) {
    let _alone = alone();
    let asked = Asked::here();
    let mut tally = Tally::default();
    match &asked.input {
        Some(input) => {
            let bytes = fs::read(input).expect("the input can be read");
            let Measured { value, cpu, bytes: used, .. } = tally.take(target, &bytes);
            let accepted = value.is_some_and(|taken| taken.accepted);
            println!("{}: accepted {accepted}, {cpu:?} of CPU time, {used} bytes", input.display());
        }
        None => tally.run(target, &asked),
    }
    tally.print(target);
    let faults: Vec<String> = tally
        .faults
        .iter()
        .map(|(what, at)| {
            let (name, at) = (target.name, at.display());
            format!("{what}\n  AMBIDEX_FUZZ_INPUT={at} cargo test --test fuzz {name} -- --nocapture")
        })
        .collect();
    assert!(faults.is_empty(), "{}, seed {}:\n{}", target.name, asked.seed, faults.join("\n"));
}

impl Tally {
    fn run(&mut self, target: &Target, asked: &Asked) {
        let began = Instant::now();
        let mut pool = corpus::committed(target.name);
        pool.extend((target.seeds)());
        let mut sound = Vec::new();
        for (index, input) in pool.iter().enumerate() {
            let is_sound = self.take(target, input).value.is_some_and(|taken| taken.accepted);
            sound.extend(is_sound.then_some(index));
        }
        let mut rng = Rng::of(&[asked.seed, hash(target.name)]);
        let mut mutator = Mutator::new(target.form, &pool);
        while began.elapsed() < asked.time && self.faults.len() < FAULTS {
            let input = mutator.mutant(&pool, &sound, &mut rng);
            let known = self.kinds.len();
            let taken = self.take(target, &input).value;
            if self.kinds.len() > known && pool.len() < POOL {
                sound.extend(taken.is_some_and(|taken| taken.accepted).then_some(pool.len()));
                pool.push(input);
            }
        }
    }

    /// Runs an input; what is wrong with it is kept.
    fn take(&mut self, target: &Target, input: &[u8]) -> Measured<Taken> {
        let measured = once(target, input);
        self.count += 1;
        self.slowest = self.slowest.max(measured.cpu);
        self.largest = self.largest.max(measured.bytes);
        if let Some(taken) = &measured.value {
            self.accepted += u64::from(taken.accepted);
            // What takes twice as much is as new as another answer.
            self.kinds.insert(u64::from(measured.bytes.ilog2_or_zero()));
            self.kinds.extend(&taken.kinds);
        }
        if let Some(what) = fault(&measured)
            && !self.faults.contains_key(&what)
        {
            let small = shrunk(target.form, input, |smaller| fault(&once(target, smaller)).as_ref() == Some(&what));
            self.faults.insert(what, written(target.name, &small));
        }
        measured
    }

    fn print(&self, target: &Target) {
        static HEAD: Once = Once::new();
        let row = |cells: [&str; 6]| {
            println!(
                "{:<10} {:>10} {:>9} {:>7} {:>11} {:>10}",
                cells[0], cells[1], cells[2], cells[3], cells[4], cells[5]
            );
        };
        HEAD.call_once(|| row(["target", "executions", "accepted", "kinds", "slowest ms", "largest MB"]));
        let slowest = format!("{:.1}", self.slowest.as_secs_f64() * 1e3);
        let largest = format!("{:.1}", self.largest as f64 / 1e6);
        let (count, accepted) = (self.count.to_string(), self.accepted.to_string());
        row([target.name, &count, &accepted, &self.kinds.len().to_string(), &slowest, &largest]);
    }
}

fn once(target: &Target, input: &[u8]) -> Measured<Taken> {
    let _watched = Watched::new(target.name, input);
    measured(|| (target.run)(input))
}

/// What is wrong, in words that are the same for the same fault.
fn fault(measured: &Measured<Taken>) -> Option<String> {
    match &measured.panic {
        Some(panic) => Some(panic.lines().next().unwrap_or("a panic").to_owned() + &first_words(panic)),
        None if measured.bytes > BYTES => Some(format!("more than {BYTES} bytes in use")),
        None if measured.cpu > CPU => Some(format!("more than {CPU:?} of CPU time")),
        None => None,
    }
}

/// What a panic says behind its place, as far as it does not quote the input.
fn first_words(panic: &str) -> String {
    let said = panic.lines().nth(1).unwrap_or_default();
    let end = said.find(|letter: char| letter.is_numeric() || matches!(letter, '"' | '`' | '{')).unwrap_or(said.len());
    format!(" {}", &said[..end])
}

fn written(target: &str, input: &[u8]) -> PathBuf {
    let path = folder(target).join(format!("fault-{:016x}", hash(&String::from_utf8_lossy(input))));
    fs::write(&path, input).expect("the target folder can be written");
    shown(&path)
}

/// As it can be named from the folder of the project, where tests run.
fn shown(path: &Path) -> PathBuf {
    path.strip_prefix(env!("CARGO_MANIFEST_DIR")).unwrap_or(path).to_owned()
}

trait Magnitude {
    fn ilog2_or_zero(self) -> u32;
}

impl Magnitude for usize {
    fn ilog2_or_zero(self) -> u32 {
        self.checked_ilog2().unwrap_or(0)
    }
}
