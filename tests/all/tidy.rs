//! The rules of the house, read from the sources: who imports whom, what must not be where, how long things are.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use crate::fixtures::file;

/// A room, its step, and words that must not stand in it. It imports only from rooms of smaller steps.
type Room = (&'static str, u32, &'static [&'static str]);

const CLOCKS: &[&str] = &["Instant::now", "SystemTime", "std::fs", "tokio::", "async ", ".await", "iceoryx2", "rand"];
const NO_TOKIO: &[&str] = &["tokio::", ".await", "iceoryx2"];

const ROOMS: &[Room] = &[
    ("model", 0, CLOCKS),
    ("world", 1, CLOCKS),
    ("behavior", 2, CLOCKS),
    ("tree", 3, CLOCKS),
    ("motion", 3, CLOCKS),
    ("config", 3, NO_TOKIO),
    ("journal", 3, NO_TOKIO),
    ("dispatch", 4, CLOCKS),
    ("draw", 4, CLOCKS),
    ("ipc", 4, &["tokio::", ".await"]),
    ("controller", 5, NO_TOKIO),
    ("sim", 5, CLOCKS),
    ("runtime", 5, &["iceoryx2"]),
];

/// Crates that are spoken to in one place.
const ALONE: &[(&str, &str)] = &[
    ("parry3d", "src/world/paths.rs"),
    ("pathfinding", "src/world/paths.rs"),
    ("ZeroCopySend", "src/ipc/"),
    ("serde_saphyr", "src/config/document.rs"),
    ("indicatif", "bins/ambidex/terminal.rs"),
    ("svg::node", "src/show/svg/page.rs"),
];

const FILE_WALL: usize = 500;
const FUNCTION_WALL: usize = 70;

/// Everything of the project in Rust under a folder, with its text.
fn sources(folder: &str) -> Vec<(PathBuf, String)> {
    let mut found = Vec::new();
    let mut folders = vec![file(folder)];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(&folder).expect("a folder of the project") {
            let path = entry.expect("an entry").path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|extension| extension == "rs") {
                let text = std::fs::read_to_string(&path).expect("a source");
                found.push((path, text));
            }
        }
    }
    found.sort();
    found
}

fn is_test(path: &Path) -> bool {
    let path = path.to_string_lossy();
    path.contains("tests") || path.ends_with("sample.rs") || path.ends_with("samples.rs")
}

/// The lines of a file before its tests.
fn body(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let lines = text.lines().enumerate().map(|(index, line)| (index + 1, line));
    lines.take_while(|(_, line)| *line != "#[cfg(test)]").filter(|(_, line)| !line.trim_start().starts_with("//"))
}

#[test]
fn rooms_import_only_from_rooms_above() {
    let steps: BTreeMap<&str, u32> = ROOMS.iter().map(|(room, step, _)| (*room, *step)).collect();
    let mut faults = Vec::new();
    for (room, step, banned) in ROOMS {
        for (path, text) in sources(&format!("src/{room}")).iter().filter(|(path, _)| !is_test(path)) {
            for (number, line) in body(text) {
                let place = || format!("{}:{number}: {}", path.display(), line.trim());
                let uses = line.match_indices("crate::").map(|(at, found)| &line[at + found.len()..]);
                for other in uses.map(|rest| rest.split(|c: char| !c.is_alphanumeric()).next().unwrap_or("")) {
                    let is_above = steps.get(other).is_none_or(|&other| other < *step);
                    if other != *room && !is_above {
                        faults.push(place());
                    }
                }
                if banned.iter().any(|word| line.contains(word)) {
                    faults.push(place());
                }
            }
        }
    }
    assert!(faults.is_empty(), "out of place:\n{}", faults.join("\n"));
}

#[test]
fn every_room_is_in_the_table() {
    for entry in std::fs::read_dir(file("src")).expect("sources") {
        let path = entry.expect("an entry").path();
        let name = path.file_name().and_then(|name| name.to_str()).expect("a name");
        let is_known = name == "lib.rs" || ROOMS.iter().any(|(room, ..)| *room == name);
        assert!(is_known, "src/{name} is no room of the house");
    }
}

#[test]
fn edges_are_alone() {
    let all: Vec<_> = sources("src").into_iter().chain(sources("bins")).collect();
    for (word, home) in ALONE {
        let users = all.iter().filter(|(path, text)| !is_test(path) && body(text).any(|(_, line)| line.contains(word)));
        for (path, _) in users {
            let is_home = path.to_string_lossy().contains(home);
            assert!(is_home, "{word} belongs in {home}, not in {}", path.display());
        }
    }
}

#[test]
fn nothing_is_too_long_or_silenced() {
    let mut faults = Vec::new();
    for (path, text) in ["src", "bins", "tests", "benches"].iter().flat_map(|folder| sources(folder)) {
        let name = path.display();
        if text.lines().count() > FILE_WALL {
            faults.push(format!("{name}: longer than {FILE_WALL} lines"));
        }
        for (number, length) in functions(&text) {
            if length > FUNCTION_WALL {
                faults.push(format!("{name}:{number}: a function of {length} lines"));
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
        for (number, line) in text.lines().enumerate() {
            if silencers.iter().any(|word| line.contains(word)) {
                faults.push(format!("{name}:{}: {}", number + 1, line.trim()));
            }
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

/// First line and length of every function of formatted code.
fn functions(text: &str) -> Vec<(usize, usize)> {
    let lines: Vec<&str> = text.lines().collect();
    let indent = |line: &str| line.len() - line.trim_start().len();
    let starts = lines.iter().enumerate().filter(|(_, line)| {
        let words: Vec<&str> = line.split_whitespace().take(4).collect();
        let is_head = words.iter().position(|word| *word == "fn");
        is_head.is_some_and(|at| {
            words[..at].iter().all(|word| word.starts_with("pub") || *word == "async" || *word == "const")
        })
    });
    let measured = starts.filter_map(|(start, line)| {
        let close = format!("{}}}", " ".repeat(indent(line)));
        let end = lines[start..].iter().position(|line| *line == close)?;
        Some((start + 1, end + 1))
    });
    measured.collect()
}
