//! A round that touches one task of n beside the tick of the same tree in behavior tree libraries: bonsai-bt, in this
//! process, and `py_trees`, where `python3` has it (`pip install py_trees==2.6.0`).

#[path = "support/mission.rs"]
mod mission;
#[path = "support/rounds.rs"]
mod rounds;
#[path = "support/table.rs"]
mod table;

use std::process::Command;
use std::time::{Duration, Instant};

use bonsai_bt::{Action, ActionArgs, BT, Behavior, Event, RUNNING, Sequence, UpdateArgs, WhenAll};
use rounds::{Actors, Load};

const SIZES: [usize; 3] = [100, 500, 2500];
const SAMPLES: usize = 10;
/// Ticks or rounds in one sample.
const TIMES: u64 = 100;

fn main() {
    let titles = ["nodes".to_owned()].into_iter().chain(Load::ALL.map(|load| format!("{}, µs", load.name())));
    let peers = ["bonsai-bt, µs", "py_trees, µs", "bonsai-bt/touched", "py_trees/touched"];
    let mut rows = vec![titles.chain(peers.map(str::to_owned)).collect::<Vec<_>>()];
    for n in SIZES {
        let rounds = Load::ALL.map(|load| (load, ambidex(n, load)));
        let (bonsai, py_trees) = (bonsai(n), py_trees(n));
        let touching = rounds.iter().find(|(load, _)| *load == Load::Touching).map(|(_, time)| *time);
        let us = |time: Duration| time.as_secs_f64() * 1e6;
        let over = |time: Duration| touching.map_or("-".into(), |touching| format!("{:.0}", us(time) / us(touching)));
        let mut row = vec![(2 + 5 * n).to_string()];
        row.extend(rounds.map(|(_, time)| format!("{:.1}", us(time))));
        row.push(format!("{:.1}", us(bonsai)));
        row.push(py_trees.map_or("-".into(), |time| format!("{:.0}", us(time))));
        row.push(over(bonsai));
        row.push(py_trees.map_or("-".into(), over));
        rows.push(row);
    }
    table::print("One round, or one tick, of an AND of n THENs of four behaviors that do not end:", &rows);
    println!(
        "\nambidex without a log, from a change of the world to the decision; a tick asks every task, whatever has changed.\n\
         The fastest of {SAMPLES} samples. A dash: python3 has no py_trees."
    );
}

/// The fastest of some samples, each of some rounds.
fn fastest(mut sample: impl FnMut(u64) -> Duration) -> Duration {
    let samples = (0..SAMPLES).map(|_| sample(TIMES) / TIMES as u32);
    samples.min().expect("some samples")
}

fn ambidex(n: usize, load: Load) -> Duration {
    let mut actors = Actors::start(n, load, false);
    let time = fastest(|rounds| actors.rounds(rounds));
    actors.end();
    time
}

fn bonsai(n: usize) -> Duration {
    let tasks = (0..n).map(|task| Sequence((0..4).map(|step| Action((task, step))).collect::<Vec<Behavior<_>>>()));
    let mut tree = BT::new(WhenAll(tasks.collect()), ());
    let event: Event = UpdateArgs { dt: 0.01 }.into();
    fastest(|ticks| {
        let mut asked = 0;
        let begun = Instant::now();
        for _ in 0..ticks {
            tree.tick(&event, &mut |args: ActionArgs<Event, (usize, i32)>, _: &mut ()| {
                assert_eq!(args.action.1, 0, "the first step does not end");
                asked += 1;
                RUNNING
            });
        }
        let passed = begun.elapsed();
        assert_eq!(asked, ticks * n as u64, "every task was asked");
        passed
    })
}

/// None where it is not installed.
fn py_trees(n: usize) -> Option<Duration> {
    let program = include_str!("support/py_trees_tick.py");
    let output = Command::new("python3").args(["-c", program, &n.to_string(), &SAMPLES.to_string()]).output().ok()?;
    let said = String::from_utf8(output.stdout).expect("text");
    let seconds = said.trim().parse().ok()?;
    Some(Duration::from_secs_f64(seconds))
}
