//! Inputs to begin with: what is committed, what is shipped, and logs and runs of that.

use std::fs;
use std::path::{Path, PathBuf};

use ambidex::files::InMemory;
use ambidex::model::Record;
use ambidex::sim;
use ambidex::tree::Settings;
use serde_json::{Value, json};

use crate::mutate::ordered;
use crate::rng::Rng;
use crate::targets::files::{loaded, mission_of};
use crate::targets::generate;

/// How many missions are generated.
const GENERATED: u64 = 40;
/// Bytes of a log that are enough.
const LOG: usize = 60_000;

/// What is committed for a target, in the order of the names.
pub fn committed(target: &str) -> Vec<Vec<u8>> {
    contents(&Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fuzz/corpus").join(target))
}

/// The files of a folder of `config`, in the order of their names.
fn shipped(folder: &str) -> Vec<Vec<u8>> {
    contents(&Path::new(env!("CARGO_MANIFEST_DIR")).join("config").join(folder))
}

fn contents(folder: &Path) -> Vec<Vec<u8>> {
    let read = |path: &PathBuf| fs::read(path).expect("a file");
    files(folder).iter().map(read).collect()
}

fn files(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).unwrap_or_else(|error| panic!("{}: {error}", folder.display()));
    let mut paths: Vec<PathBuf> = entries.map(|entry| entry.expect("an entry").path()).collect();
    paths.sort();
    paths
}

/// Robots and libraries by the paths that missions call them by.
pub fn beside() -> InMemory {
    let config = Path::new(env!("CARGO_MANIFEST_DIR")).join("config");
    let mut memory = InMemory::default();
    for folder in ["robots", "behaviors"] {
        for path in files(&config.join(folder)) {
            let name = Path::new(folder).join(path.file_name().expect("a name"));
            memory.insert(&name, fs::read(&path).expect("a file"));
        }
    }
    memory
}

pub fn missions() -> Vec<Vec<u8>> {
    let generated = (0..GENERATED).map(|seed| generate::mission(&mut Rng::of(&[seed])).to_string().into_bytes());
    shipped("missions").into_iter().chain(generated).collect()
}

pub fn worlds() -> Vec<Vec<u8>> {
    shipped("worlds").into_iter().chain(shipped("missions")).collect()
}

pub fn tasks() -> Vec<Vec<u8>> {
    shipped("tasks").into_iter().chain(shipped("missions")).collect()
}

pub fn robots() -> Vec<Vec<u8>> {
    shipped("robots")
}

pub fn libraries() -> Vec<Vec<u8>> {
    shipped("behaviors")
}

pub fn failures() -> Vec<Vec<u8>> {
    shipped("failures")
}

/// Files of the software that came before the paper.
pub fn of_dhtt() -> Vec<Vec<u8>> {
    vec![include_bytes!("../data/dhtt-breakfast.yaml").to_vec()]
}

pub fn requests() -> Vec<Vec<u8>> {
    let source = json!({"mission": "m.yaml", "files": [{"path": "m.yaml", "text": "task: {move: hall}"}]});
    let post = |path: &str, body: Value| json!({"method": "POST", "path": path, "body": body});
    let requests = [
        post("/v1/world/facts/door%20open", json!({"holds": true})),
        post("/v1/world/objects/parcel/place", json!({"place": "hall"})),
        post("/v1/world/objects", json!({"object": "cup", "place": "hall"})),
        post("/v1/tasks", json!({"name": "fetch", "priority": -3, "pause": true, "source": source})),
        post("/v1/tasks/door/edit", json!({"add": {"under": 3, "source": source, "at": 0}})),
        post("/v1/tasks/1/edit", json!({"remove": {"node": "pick parcel"}})),
        post("/v1/tasks/1/edit", json!({"replace": {"node": 2, "source": source}})),
        json!({"method": "POST", "path": "/v1/tasks/1/pause"}),
        json!({"method": "DELETE", "path": "/v1/tasks/door"}),
        json!({"method": "GET", "path": "/v1/tasks/1", "headers": {"host": "localhost", "accept": "*/*"}}),
        json!({"method": "GET", "path": "/v1/status", "headers": {"origin": "http://evil.example"}}),
        json!({"method": "GET", "path": "/v1/events"}),
        json!({"result": "changed", "said": "so"}),
        json!({"status": 409, "title": "Conflict", "detail": "so", "why": "held", "help": "wait"}),
    ];
    requests.iter().map(|request| format!("{request}\n").into_bytes()).collect()
}

/// Beginnings of logs of what is shipped.
pub fn logs() -> Vec<Vec<u8>> {
    let missions = shipped("missions");
    let log = |(index, text): (usize, &Vec<u8>)| log_of(text, index % 3 == 0);
    missions.iter().enumerate().filter_map(log).collect()
}

fn log_of(text: &[u8], has_messages: bool) -> Option<Vec<u8>> {
    let mission = loaded(text)?.mission;
    let settings = Settings { has_messages, ..Settings::default() };
    let mut log: Vec<Vec<u8>> = Vec::new();
    sim::simulate(&mission, &settings, Vec::new(), &mut |record: &Record| {
        let line = serde_json::to_string(record).expect("a record is plain");
        log.push((line + "\n").into_bytes());
    });
    let last = log.pop()?;
    let mut bytes = 0;
    let beginning = log.iter().take_while(|line| {
        bytes += line.len();
        bytes < LOG
    });
    Some(beginning.chain([&last]).flatten().copied().collect())
}

/// Missions with what goes wrong in them.
pub fn runs() -> Vec<Vec<u8>> {
    let failures: Vec<Value> = failures().iter().filter_map(|text| ordered::read(text)).collect();
    let robots: Vec<Value> = robots().iter().filter_map(|text| ordered::read(text)).collect();
    let missions = missions();
    let run = |(index, text): (usize, &Vec<u8>)| {
        let mut run = json!({"mission": ordered::read(text)?, "cancel_s": 20 + index % 40, "serial": index % 7 == 0});
        let own = mission_of(&run).map(|mission| generate::failures(&mission, &mut Rng::of(&[index as u64, 2])));
        run["failures"] = own.unwrap_or_else(|| {
            ordered::get(&failures[index % failures.len()], "failures").cloned().unwrap_or_default()
        });
        if index % 5 == 0 {
            run["robot"] = robots[index / 5 % robots.len()].clone();
        }
        Some(ordered::text(&run).into_bytes())
    };
    missions.iter().enumerate().filter_map(run).collect()
}
