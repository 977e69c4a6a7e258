//! Missions as large as a file may be, each of one thing.

use std::fmt::Write;

/// A part of a mission that is repeated.
struct Large {
    /// Most of them that are in one file.
    count: usize,
    world: &'static str,
    /// What stands beside world and task.
    more: &'static str,
    task: &'static str,
    /// Where it stands: `N` is a number.
    each: &'static str,
}

const LARGE: &[Large] = &[
    Large {
        count: 20_000,
        world: "places: {s: {stand: [2, 0]}, EACH}",
        more: "",
        task: "{move: s}",
        each: "pN: {stand: [2, 1]}",
    },
    Large {
        count: 40_000,
        world: "places: {s: {stand: [2, 0]}, EACH}",
        more: "",
        task: "{move: s}",
        each: "s: {stand: [2, 1]}",
    },
    Large {
        count: 40_000,
        world: "places: {s: {stand: [2, 0]}}, objects: {EACH}",
        more: "",
        task: "{move: s}",
        each: "oN: {at: s}",
    },
    Large {
        count: 60_000,
        world: "places: {s: {stand: [2, 0]}}, facts: {EACH}",
        more: "",
        task: "{move: s}",
        each: "fN: true",
    },
    Large {
        count: 20_000,
        world: "places: {s: {stand: [2, 0]}}, obstacles: [EACH]",
        more: "",
        task: "{move: s}",
        each: "{min: [5, 5], max: [6, 6]}",
    },
    Large {
        count: 20_000,
        world: "places: {s: {stand: [2, 0]}}",
        more: "behaviors: {EACH}\n",
        task: "b1",
        each: "bN: {potential: 1}",
    },
    Large {
        count: 20_000,
        world: "places: {s: {stand: [2, 0]}}",
        more: "subtrees: {EACH}\n",
        task: "{use: s1}",
        each: "sN: {task: {move: s}}",
    },
    Large { count: 30_000, world: "places: {s: {stand: [2, 0]}}", more: "", task: "{and: [EACH]}", each: "{move: s}" },
    Large {
        count: 30_000,
        world: "places: {shelf: {stand: [2, 0]}}",
        more: "",
        task: "{and: [EACH]}",
        each: "{move: shlef N}",
    },
    Large { count: 100_000, world: "places: {s: {stand: [2, 0]}}", more: "", task: "{and: [EACH]}", each: "1" },
    Large {
        count: 6_000,
        world: "places: {s: {stand: [2, 0]}}, objects: {o: {at: s}}",
        more: "",
        task: "{and: [EACH]}",
        each: "{then: [{move: s}, {pick: o}, {move: s}, {place: o}]}",
    },
    Large { count: 80_000, world: "places: {s: {stand: [2, 0]}}", more: "EACH, ", task: "{move: s}", each: "kN: 1" },
];

/// The missions, and of how many parts each is: a `part` of what fits into a file.
pub fn missions(part: usize) -> impl Iterator<Item = (String, String)> {
    LARGE.iter().map(move |large| {
        let count = large.count / part;
        let mut each = String::new();
        for number in 0..count {
            let separator = if number == 0 { "" } else { ", " };
            write!(each, "{separator}{}", large.each.replace('N', &number.to_string())).expect("a text takes all");
        }
        let put = |place: &str| place.replace("EACH", &each);
        let (world, more, task) = (put(large.world), put(large.more), put(large.task));
        let more = if large.more.is_empty() { String::new() } else { more.trim_end_matches([',', '\n', ' ']).to_owned() + ", " };
        let mission = format!(
            "{{mission: large, robot: ../robots/pr2.yaml, {more}world: {{robot: {{at: [0, 0]}}, {world}}}, task: {task}}}"
        );
        (format!("{count} times {}", large.each), mission)
    })
}
