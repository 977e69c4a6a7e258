//! Inputs that nobody would write, for everything that reads what others wrote: files, logs, messages, requests; and
//! missions that nobody would write, run. None of it may panic, take more than 100 MB, or more than a second.
//!
//! `AMBIDEX_FUZZ_SECONDS=60 AMBIDEX_FUZZ_SEED=7 cargo test --release --test fuzz -- --nocapture` is the long form; what
//! it finds lies in `target/tmp/fuzz`, and `AMBIDEX_FUZZ_INPUT=FILE cargo test --test fuzz TARGET` runs that alone. Once
//! mended it belongs into `tests/fuzz/corpus/TARGET`, which is run before all else.

mod corpus;
mod limits;
mod meter;
mod mutate;
#[path = "../all/driver/rng.rs"]
mod rng;
mod run;
mod shrink;
mod targets;
mod watchdog;

use meter::Counting;
use mutate::Form;
use run::{Target, fuzz};

#[global_allocator]
static ALLOCATOR: Counting = Counting;

#[test]
fn mission() {
    fuzz(&Target { name: "mission", form: Form::Yaml, seeds: corpus::missions, run: targets::files::mission });
}

#[test]
fn world() {
    fuzz(&Target { name: "world", form: Form::Yaml, seeds: corpus::worlds, run: targets::live::world });
}

#[test]
fn task() {
    fuzz(&Target { name: "task", form: Form::Yaml, seeds: corpus::tasks, run: targets::live::task });
}

#[test]
fn robot() {
    fuzz(&Target { name: "robot", form: Form::Yaml, seeds: corpus::robots, run: targets::files::robot });
}

#[test]
fn behaviors() {
    fuzz(&Target { name: "behaviors", form: Form::Yaml, seeds: corpus::libraries, run: targets::files::behaviors });
}

#[test]
fn failures() {
    fuzz(&Target { name: "failures", form: Form::Yaml, seeds: corpus::failures, run: targets::files::failures });
}

#[test]
fn import() {
    fuzz(&Target { name: "import", form: Form::Yaml, seeds: corpus::of_dhtt, run: targets::import::import });
}

#[test]
fn log() {
    fuzz(&Target { name: "log", form: Form::JsonLines, seeds: corpus::logs, run: targets::log::log });
}

#[test]
fn wire() {
    fuzz(&Target { name: "wire", form: Form::Bytes, seeds: targets::wire::seeds, run: targets::wire::wire });
}

#[test]
fn control() {
    fuzz(&Target { name: "control", form: Form::JsonLines, seeds: corpus::requests, run: targets::control::control });
}

#[test]
fn execution() {
    fuzz(&Target { name: "execution", form: Form::Yaml, seeds: corpus::runs, run: targets::execution::execution });
}

/// Not the largest that are read: 45,000 moves are within a file and take 127 MB. Without optimization a twentieth.
#[test]
fn tens_of_thousands_of_one_thing() {
    let part = if cfg!(debug_assertions) { 20 } else { 1 };
    run::each("large", targets::large::missions(part), targets::files::mission_once);
}
