//! Random missions for the shipped robot with the shipped kinds of behaviors.

use std::fmt::Write;

use crate::driver::Rng;
use crate::fixtures::file;

const PLACES: [&str; 5] = ["shelf", "table", "rack", "sink", "cart"];

/// A mission file.
pub fn text(seed: u64) -> String {
    let mut rng = Rng::of(&[seed, 21]);
    let objects = 2 + rng.below(4);
    let mut text = format!("mission: case-{seed}\nrobot: {}\n", file("config/robots/pr2.yaml").display());
    let mut line = |line: String| writeln!(text, "{line}").expect("a string takes all");
    line("world:\n  robot: {at: [0, 0]}\n  places:".into());
    for (index, place) in PLACES.iter().enumerate() {
        let (x, y) = (3.0 * index as f64 + 0.1 * rng.below(20) as f64, 0.1 * rng.below(60) as f64);
        // Some are farther ahead than any arm reaches: a pick there is not possible, a place is rejected.
        let ahead = if rng.is(20) { 1.6 } else { 0.5 };
        line(format!("    {place}: {{stand: [{x:.1}, {y:.1}], surface: [{ahead}, 0, 0.75]}}"));
    }
    line("  objects:".into());
    for object in 0..objects {
        line(format!("    o{object}: {{at: {}}}", rng.one(&PLACES)));
    }
    let mut maker = Maker { objects: (0..objects).collect(), rng };
    let children: Vec<String> = std::iter::from_fn(|| maker.part(2)).collect();
    line(format!("task:\n  and: [{}]", children.join(", ")));
    text
}

struct Maker {
    /// Objects that nobody fetches yet.
    objects: Vec<usize>,
    rng: Rng,
}

impl Maker {
    /// A part of the task; none when nothing is left to be fetched.
    fn part(&mut self, depth: u32) -> Option<String> {
        let object = self.objects.pop()?;
        let deliver = self.deliver(object);
        Some(match self.rng.below(if depth == 0 { 2 } else { 4 }) {
            0 => deliver,
            // The same object by one of two ways.
            1 => format!("{{or: [{deliver}, {}]}}", self.deliver(object)),
            2 => match self.part(depth - 1) {
                Some(other) => format!("{{and: [{deliver}, {other}]}}"),
                None => deliver,
            },
            _ => match self.part(depth - 1) {
                Some(other) => format!("{{then: [{deliver}, {other}]}}"),
                None => deliver,
            },
        })
    }

    fn deliver(&mut self, object: usize) -> String {
        let (from, to) = (self.rng.one(&PLACES), self.rng.one(&PLACES));
        format!("{{then: [{{move: {from}}}, {{pick: o{object}}}, {{move: {to}}}, {{place: o{object}}}]}}")
    }
}
