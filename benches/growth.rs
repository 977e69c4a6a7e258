//! How a log grows with the number of behaviors, and how long `explain` takes with it: an AND of n behaviors that drive,
//! pick and place, and one of n of a constant potential, simulated. Whole commands, as a user waits for them.
//!
//! `AMBIDEX_SIZES=500,5000` sets the sizes.

#[path = "support/table.rs"]
mod table;

use std::fmt::Write;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Instant;

const SIZES: [usize; 3] = [500, 2_000, 5_000];
const PLACES: usize = 10;

fn main() {
    let sizes = std::env::var("AMBIDEX_SIZES").ok();
    let sizes: Vec<usize> = match &sizes {
        Some(sizes) => sizes.split(',').map(|size| size.parse().expect("a number")).collect(),
        None => SIZES.to_vec(),
    };
    let folder = tempfile::tempdir().expect("a folder");
    tell("AND of n / 4 THENs of move, pick, move, place", &sizes, folder.path(), driving, "pick o5");
    tell(
        "AND of n behaviors of one gripper and a constant potential, 1 s each",
        &sizes,
        folder.path(),
        constant,
        "work #5",
    );
    println!("\nexponent: growth of the log from the row above. explain NODE computes all rounds again.");
}

fn tell(title: &str, sizes: &[usize], folder: &Path, mission: impl Fn(usize) -> String, node: &str) {
    let titles = "behaviors|log MB|exponent|simulate s|explain s|explain NODE s|verify s";
    let mut rows = vec![titles.split('|').map(str::to_owned).collect::<Vec<_>>()];
    let mut above: Option<(usize, u64)> = None;
    for &n in sizes {
        let (path, log) = (folder.join("mission.yaml"), folder.join("run.jsonl"));
        std::fs::write(&path, mission(n)).expect("a mission");
        let (path, log) = (path.to_str().expect("a path"), log.to_str().expect("a path"));
        let (simulate_s, report) = timed(&["simulate", "--quiet", "--json", path, "--log", log]);
        let done = report.matches("\"outcome\":\"done\"").count();
        assert_eq!(done, 1, "{report}");
        let bytes = std::fs::metadata(log).expect("a log").len();
        let (explain_s, story) = timed(&["explain", log]);
        assert!(story.contains("done"), "{story}");
        let (node_s, account) = timed(&["explain", log, node]);
        assert!(account.contains("It is done after"), "{account}");
        let (verify_s, said) = timed(&["verify", log]);
        assert!(said.starts_with("same: "), "{said}");
        let exponent = above.map(|(m, less)| (bytes as f64 / less as f64).ln() / (n as f64 / m as f64).ln());
        above = Some((n, bytes));
        rows.push(vec![
            n.to_string(),
            format!("{:.1}", bytes as f64 / 1e6),
            exponent.map_or("-".into(), |exponent| format!("{exponent:.2}")),
            format!("{simulate_s:.2}"),
            format!("{explain_s:.2}"),
            format!("{node_s:.2}"),
            format!("{verify_s:.2}"),
        ]);
    }
    table::print(title, &rows);
}

/// Runs the program; seconds, and what it printed.
fn timed(args: &[&str]) -> (f64, String) {
    let begun = Instant::now();
    let output = Command::new(env!("CARGO_BIN_EXE_ambidex")).args(args).stderr(Stdio::inherit()).output();
    let output = output.expect("the program runs");
    let seconds = begun.elapsed().as_secs_f64();
    assert!(output.status.success(), "{args:?} ends with {}", output.status);
    (seconds, String::from_utf8(output.stdout).expect("text"))
}

fn head(name: &str) -> String {
    let robot = Path::new(env!("CARGO_MANIFEST_DIR")).join("config/robots/pr2.yaml");
    let mut text = format!("mission: {name}\nrobot: {}\nworld:\n  robot: {{at: [0, 0]}}\n  places:\n", robot.display());
    for place in 0..PLACES {
        let (x, y) = (1.5 * place as f64, (place * 7 % 5) as f64);
        writeln!(text, "    p{place}: {{stand: [{x}, {y}]}}").expect("a string takes all");
    }
    text
}

/// Objects are carried from place to place: four behaviors each.
fn driving(n: usize) -> String {
    let mut text = head("driving") + "  objects:\n";
    for object in 0..n / 4 {
        writeln!(text, "    o{object}: {{at: p{}}}", object % PLACES).expect("a string takes all");
    }
    text += "task:\n  and:\n";
    for object in 0..n / 4 {
        let (from, to) = (object % PLACES, (object + 3) % PLACES);
        let then = format!("[{{move: p{from}}}, {{pick: o{object}}}, {{move: p{to}}}, {{place: o{object}}}]");
        writeln!(text, "    - then: {then}").expect("a string takes all");
    }
    text
}

/// Nothing tells the behaviors apart but their order.
fn constant(n: usize) -> String {
    let kind = "behaviors:\n  work:\n    potential: 1\n    claims: {hand: {type: gripper}}\n    takes: 1 s\n";
    head("constant") + kind + "task:\n  and:\n" + &"    - work:\n".repeat(n)
}
