//! The rules of the house that neither the compiler nor clippy can say, read from the sources: rooms within a crate,
//! circles of files, edges that stand alone, lengths. What a crate depends on stands in its `Cargo.toml`.

mod imports;

use std::collections::{BTreeMap, BTreeSet};
use std::process::Command;

use crate::fixtures::file;
use imports::{Source, of_crate, sources};

/// Rooms of a crate by step; a room imports only from rooms of smaller steps of its crate. Other crates are kept apart
/// by what they depend on.
const ROOMS: &[(&str, &[(&str, u32)])] = &[
    ("model", &[("words", 0), ("motion", 1), ("state", 1), ("session", 2)]),
    ("core", &[("world", 0), ("behavior", 1), ("tree", 2), ("dispatch", 2), ("replay", 3), ("sim", 4)]),
    (
        "link",
        &[
            ("clock", 0),
            ("error", 0),
            ("link", 0),
            ("watch", 1),
            ("wire", 1),
            ("instances", 1),
            ("damage", 2),
            ("janitor", 2),
            ("node", 3),
            ("ports", 4),
            ("serve", 5),
        ],
    ),
];

/// Crates that are spoken to in one place.
const ALONE: &[(&str, &str)] = &[
    ("parry3d", "src/core/world/"),
    ("elsa", "src/core/world/ways.rs"),
    ("rstar", "src/core/world/free_space.rs"),
    ("pathfinding::", "src/core/world/paths.rs"),
    ("serde_saphyr", "src/files/document.rs"),
    ("axum::", "src/http"),
    ("hyper::", "src/http"),
    ("indicatif", "bins/ambidex/terminal.rs"),
    ("svg::node", "src/show/svg/page.rs"),
    ("mcap::", "bins/ambidex/recording"),
    ("csv::", "bins/ambidex/export/form.rs"),
];

const FILE_WALL: usize = 500;
const FUNCTION_WALL: usize = 70;

/// Most packages that a controller in Rust pulls in, its own words and the link included.
const CONTROLLER_PACKAGES: usize = 75;

/// What the core and its words may depend on directly: mathematics and derives.
const CORE_NEEDS: &[&str] = &[
    "ambidex-core",
    "ambidex-model",
    "arrayvec",
    "elsa",
    "nalgebra",
    "parry3d",
    "pathfinding",
    "rand",
    "rstar",
    "serde",
    "strsim",
    "thiserror",
];

/// What does IO, or waits, or looks at a clock: nothing of the kind is below the core.
const IO: &[&str] =
    &["tokio", "mio", "rustix", "nix", "libc", "errno", "socket2", "iceoryx2", "signal-hook", "getrandom", "tempfile"];

const CRATES: &[&str] = &["core", "files", "http", "link", "model", "record", "runtime", "show"];

#[test]
fn rooms_import_only_from_rooms_above() {
    let mut faults = Vec::new();
    for (name, rooms) in ROOMS {
        let steps: BTreeMap<&str, u32> = rooms.iter().copied().collect();
        for source in of_crate(name) {
            let Some(room) = source.module.first() else { continue };
            let Some(step) = steps.get(room.as_str()) else {
                faults.push(format!("src/{name}: {room} is no room of the house"));
                continue;
            };
            for import in source.imports.iter().filter(|import| import.first() != Some(room)) {
                let other = import.first().and_then(|other| steps.get(other.as_str()));
                if other.is_none_or(|other| other >= step) {
                    faults.push(format!("{}: takes {}", source.name(), import.join("::")));
                }
            }
        }
    }
    assert!(faults.is_empty(), "out of place:\n{}", faults.join("\n"));
}

/// A file that needs another which needs it is one file in two parts.
#[test]
fn files_do_not_import_in_circles() {
    let mut faults = Vec::new();
    for name in CRATES {
        let sources: Vec<Source> = of_crate(name).collect();
        let modules: BTreeSet<&[String]> = sources.iter().map(|source| source.module.as_slice()).collect();
        let home = |import: &[String]| {
            (0..=import.len()).rev().map(|end| import[..end].to_vec()).find(|part| modules.contains(part.as_slice()))
        };
        let arrows: BTreeMap<Vec<String>, BTreeSet<Vec<String>>> = sources
            .iter()
            .map(|source| {
                let others =
                    source.imports.iter().filter_map(|import| home(import)).filter(|other| *other != source.module);
                (source.module.clone(), others.collect())
            })
            .collect();
        for source in &sources {
            if let Some(way) = way_back(&source.module, &arrows) {
                let way: Vec<_> = way.iter().map(|module| module.join("::")).collect();
                faults.push(format!("src/{name}: {}", way.join(" → ")));
            }
        }
    }
    assert!(faults.is_empty(), "circles:\n{}", faults.join("\n"));
}

/// The shortest way along the arrows that leads back to where it begins.
fn way_back(start: &[String], arrows: &BTreeMap<Vec<String>, BTreeSet<Vec<String>>>) -> Option<Vec<Vec<String>>> {
    let mut ways = std::collections::VecDeque::from([vec![start.to_vec()]]);
    let mut seen = BTreeSet::new();
    while let Some(way) = ways.pop_front() {
        for next in arrows.get(way.last()?).into_iter().flatten() {
            if next == start {
                return Some([way, vec![next.clone()]].concat());
            }
            if seen.insert(next.clone()) {
                ways.push_back([way.clone(), vec![next.clone()]].concat());
            }
        }
    }
    None
}

#[test]
fn edges_are_alone() {
    for (word, home) in ALONE {
        for source in sources("src").into_iter().chain(sources("bins")) {
            let is_home = source.name().starts_with(home);
            let uses = source.code().any(|(_, line)| line.contains(word));
            assert!(is_home || !uses, "{word} belongs in {home}, not in {}", source.name());
        }
    }
}

#[test]
fn nothing_is_too_long_or_silenced() {
    let mut faults = Vec::new();
    for source in ["src", "bins", "tests", "benches"].into_iter().flat_map(sources) {
        let name = source.name();
        let length = source.text.lines().count();
        if length > FILE_WALL {
            faults.push(format!("{name}: {length} lines"));
        }
        for (line, function, length) in &source.functions {
            if *length > FUNCTION_WALL {
                faults.push(format!("{name}:{line}: {function} has {length} lines"));
            }
        }
        // Written apart, so that this file does not find itself.
        let silencers = [
            concat!("allow", "("),
            concat!("TO", "DO"),
            concat!("FIX", "ME"),
            concat!("#[ig", "nore"),
            concat!("un", "implemented!"),
        ];
        for (number, line) in source.text.lines().enumerate() {
            if silencers.iter().any(|word| line.contains(word)) {
                faults.push(format!("{name}:{}: {}", number + 1, line.trim()));
            }
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

/// Names of the packages below one, itself included.
fn packages(of: &str, depth: Option<u32>) -> BTreeSet<String> {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let mut command = Command::new(cargo);
    command.current_dir(file("."));
    command.args(["tree", "--locked", "--offline", "--edges", "normal", "--prefix", "none", "--package", of]);
    command.args(["--target", "x86_64-unknown-linux-gnu"]);
    if let Some(depth) = depth {
        command.args(["--depth", &depth.to_string()]);
    }
    let output = command.output().expect("cargo runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = String::from_utf8(output.stdout).expect("names");
    text.lines()
        .filter_map(|line| {
            line.split_whitespace().take(2).map(str::to_owned).reduce(|name, version| name + " " + &version)
        })
        .collect()
}

fn name(package: &str) -> &str {
    package.split(' ').next().unwrap_or(package)
}

#[test]
fn a_controller_needs_few_packages() {
    let packages = packages("ambidex-link", None);
    assert!(packages.len() > 10, "{packages:?}");
    assert!(packages.len() <= CONTROLLER_PACKAGES, "{} packages: {packages:?}", packages.len());
}

#[test]
fn the_core_does_no_io() {
    let direct: BTreeSet<String> =
        ["ambidex-core", "ambidex-model"].iter().flat_map(|of| packages(of, Some(1))).collect();
    let strange: Vec<_> = direct.iter().filter(|package| !CORE_NEEDS.contains(&name(package))).collect();
    assert!(strange.is_empty(), "the core came to depend on {strange:?}");
    let all = packages("ambidex-core", None);
    let doing_io: Vec<_> = all.iter().filter(|package| IO.contains(&name(package))).collect();
    assert!(all.len() > direct.len() && doing_io.is_empty(), "below the core: {doing_io:?}");
}
