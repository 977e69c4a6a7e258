//! Large missions, each of one thing, so that what grows faster than it does is seen.

/// A part of a mission that is repeated.
struct Large {
    /// How many.
    count: usize,
    world: &'static str,
    /// What stands beside world and task.
    more: &'static str,
    task: &'static str,
    /// What stands at `EACH`: `N` is a number.
    each: &'static str,
    /// What stands as often at `ALSO`.
    also: &'static str,
}

const LARGE: &[Large] = &[
    Large {
        count: 20_000,
        world: "places: {s: {stand: [2, 0]}, EACH}",
        more: "",
        task: "{move: s}",
        each: "pN: {stand: [2, 1]}",
        also: "",
    },
    Large {
        count: 40_000,
        world: "places: {s: {stand: [2, 0]}, EACH}",
        more: "",
        task: "{move: s}",
        each: "s: {stand: [2, 1]}",
        also: "",
    },
    Large {
        count: 40_000,
        world: "places: {s: {stand: [2, 0]}}, objects: {EACH}",
        more: "",
        task: "{move: s}",
        each: "oN: {at: s}",
        also: "",
    },
    Large {
        count: 60_000,
        world: "places: {s: {stand: [2, 0]}}, facts: {EACH}",
        more: "",
        task: "{move: s}",
        each: "fN: true",
        also: "",
    },
    Large {
        count: 20_000,
        world: "places: {s: {stand: [2, 0]}}, obstacles: [EACH]",
        more: "",
        task: "{move: s}",
        each: "{min: [5, 5], max: [6, 6]}",
        also: "",
    },
    Large {
        count: 20_000,
        world: "places: {s: {stand: [2, 0]}}",
        more: "behaviors: {EACH}\n",
        task: "b1",
        each: "bN: {potential: 1}",
        also: "",
    },
    Large {
        count: 20_000,
        world: "places: {s: {stand: [2, 0]}}",
        more: "subtrees: {EACH}\n",
        task: "{use: s1}",
        each: "sN: {task: {move: s}}",
        also: "",
    },
    Large {
        count: 30_000,
        world: "places: {s: {stand: [2, 0]}}",
        more: "",
        task: "{and: [EACH]}",
        each: "{move: s}",
        also: "",
    },
    Large {
        count: 30_000,
        world: "places: {shelf: {stand: [2, 0]}}",
        more: "",
        task: "{and: [EACH]}",
        each: "{move: shlef N}",
        also: "",
    },
    Large {
        count: 100_000,
        world: "places: {s: {stand: [2, 0]}}",
        more: "",
        task: "{and: [EACH]}",
        each: "1",
        also: "",
    },
    Large {
        count: 6_000,
        world: "places: {s: {stand: [2, 0]}}, objects: {o: {at: s}}",
        more: "",
        task: "{and: [EACH]}",
        each: "{then: [{move: s}, {pick: o}, {move: s}, {place: o}]}",
        also: "",
    },
    Large {
        count: 80_000,
        world: "places: {s: {stand: [2, 0]}}",
        more: "EACH, ",
        task: "{move: s}",
        each: "kN: 1",
        also: "",
    },
    Large {
        count: 12_000,
        world: "places: {s: {stand: [2, 0]}, EACH}",
        more: "",
        task: "{and: [ALSO]}",
        each: "place number N: {stand: [2, 1]}",
        also: "{move: plcae number N}",
    },
    Large {
        count: 6_000,
        world: "places: {s: {stand: [2, 0]}, t: {stand: [5, 0]}}, objects: {EACH}",
        more: "",
        task: "{and: [ALSO]}",
        each: "oN: {at: s}",
        also: "{then: [{move: s}, {pick: oN}, {move: t}, {place: oN}]}",
    },
    Large {
        count: 20_000,
        world: "places: {s: {stand: [2, 0]}}",
        more: "behaviors: {EACH}",
        task: "{and: [ALSO]}",
        each: "bN: {potential: 1}",
        also: "bN",
    },
];

/// The missions, and of how many parts each is: a `part` of what fits into a file.
pub fn missions(part: usize) -> impl Iterator<Item = (String, String)> {
    LARGE.iter().map(move |large| {
        let count = large.count / part;
        let all = |what: &str| (0..count).map(|number| what.replace('N', &number.to_string())).collect::<Vec<_>>().join(", ");
        let (each, also) = (all(large.each), all(large.also));
        let put = |place: &str| place.replace("EACH", &each).replace("ALSO", &also);
        let (world, more, task) = (put(large.world), put(large.more), put(large.task));
        let more = if large.more.is_empty() { String::new() } else { more.trim_end_matches([',', '\n', ' ']).to_owned() + ", " };
        let mission = format!(
            "{{mission: large, robot: ../robots/pr2.yaml, {more}world: {{robot: {{at: [0, 0]}}, {world}}}, task: {task}}}"
        );
        (format!("{count} times {} {}", large.each, large.also), mission)
    })
}
