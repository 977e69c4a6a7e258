//! Recordings read back by a public reader of their format: whole, cut off, and of a run that was killed.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fs;
use std::path::PathBuf;
use std::time::Duration;

use ambidex::record::{History, Reader};
use ambidex::show::recording::{Recording, Topic, WallClock};
use mcap::read::{ChunkReader, LinearReader, Options};
use mcap::records::{ChunkHeader, Record as McapRecord};
use mcap::{MessageStream, Summary};
use rustix::process::Signal;
use serde_json::Value;
use strum::VariantArray;

use crate::fixtures::{experiment_file, load};
use crate::home::{Home, within};

/// A message of a recording.
#[derive(Debug, Clone, PartialEq)]
struct Read {
    topic: String,
    schema: String,
    log_time_ns: u64,
    publish_time_ns: u64,
    body: Value,
}

/// The messages that are there, up to where the file was cut off.
fn read(bytes: &[u8]) -> Vec<Read> {
    let Ok(stream) = MessageStream::new_with_options(bytes, Options::IgnoreEndMagic.into()) else { return Vec::new() };
    let messages = stream.map_while(Result::ok).map(|message| Read {
        topic: message.channel.topic.clone(),
        schema: message.channel.schema.as_ref().expect("a schema").name.clone(),
        log_time_ns: message.log_time,
        publish_time_ns: message.publish_time,
        body: serde_json::from_slice(&message.data).expect("JSON"),
    });
    messages.collect()
}

/// Simulates an experiment with a recording; its log and the recording.
fn simulated(home: &Home, number: u32) -> (PathBuf, PathBuf) {
    let (log, recording) = (home.path("log.jsonl"), home.path("run.mcap"));
    let options = ["--log".as_ref(), log.as_os_str(), "--record".as_ref(), recording.as_os_str()];
    let args = ["simulate", "--quiet"].map(AsRef::as_ref).into_iter().chain(options);
    let finished = home.start(args.chain([experiment_file(number).as_os_str()])).ends(0);
    assert_eq!((finished.stdout, finished.stderr), (String::new(), String::new()));
    (log, recording)
}

fn counts(messages: &[Read]) -> BTreeMap<&str, usize> {
    let mut counts = BTreeMap::new();
    messages.iter().for_each(|message| *counts.entry(message.topic.as_str()).or_default() += 1);
    counts
}

#[test]
fn a_recording_has_every_message_of_the_run() {
    let home = Home::new();
    let (log, recording) = simulated(&home, 1);
    let bytes = fs::read(&recording).expect("a recording");
    let told = read(&bytes);
    let reader = Reader::open(&log).expect("a log");
    let mission = load(&experiment_file(1));
    let (mut history, mut made) = (History::new(reader.header()), Recording::new(WallClock::NONE, Some(mission)));
    let expected = reader.flat_map(|record| {
        let record = record.expect("a record");
        history.apply(&record);
        made.take(&history, &record)
    });
    let expected = expected.map(|message| Read {
        topic: message.topic.name().to_owned(),
        schema: message.topic.schema_name().to_owned(),
        log_time_ns: message.log_time_ns,
        publish_time_ns: message.publish_time_ns,
        body: serde_json::from_str(&message.body).expect("JSON"),
    });
    let expected: Vec<Read> = expected.collect();
    assert_eq!(told.len(), expected.len());
    assert_eq!(told, expected);
    assert!(told.is_sorted_by_key(|message| message.log_time_ns), "a run goes forward");
    let summary = Summary::read(&bytes).expect("a summary").expect("a whole file has one");
    let stats = summary.stats.as_ref().expect("statistics");
    assert_eq!(stats.message_count, told.len() as u64);
    assert!(summary.chunk_indexes.iter().all(|chunk| chunk.message_end_time > 0), "no chunk is empty");
    let topics: Vec<_> = summary.channels.values().map(|channel| channel.topic.as_str()).collect();
    assert!(Topic::VARIANTS.iter().all(|topic| topics.contains(&topic.name())), "{topics:?}");
}

#[test]
fn objects_are_seen_where_they_are() {
    let home = Home::new();
    let told = read(&fs::read(simulated(&home, 1).1).expect("a recording"));
    let scenes: Vec<&Value> =
        told.iter().filter(|message| message.topic == "/scene").map(|scene| &scene.body).collect();
    let seen = |id: &str| -> Vec<String> {
        let entities = scenes.iter().flat_map(|scene| scene["entities"].as_array().expect("a list"));
        let of = entities.filter(|entity| entity["id"] == id);
        of.map(|entity| entity["frame_id"].as_str().expect("a frame").to_owned()).collect()
    };
    assert_eq!(seen("object 2"), ["map", "left_gripper", "map"]);
    assert_eq!((seen("robot"), seen("place shelf")), (vec!["base".to_owned()], vec!["map".to_owned()]));
    let frames: Vec<&Value> = told
        .iter()
        .filter(|message| message.topic == "/tf")
        .flat_map(|message| message.body["transforms"].as_array().expect("a list"))
        .map(|transform| &transform["child_frame_id"])
        .collect();
    for frame in ["base", "left_gripper", "right_gripper", "head"] {
        assert!(frames.iter().any(|other| **other == frame), "{frame}");
    }
}

/// How many messages are in chunks that are there to their end.
fn in_whole_chunks(bytes: &[u8]) -> usize {
    let records = LinearReader::new_with_options(bytes, Options::IgnoreEndMagic.into());
    let chunks = records.into_iter().flatten().map_while(Result::ok).filter_map(|record| match record {
        McapRecord::Chunk { header, data } => Some((header, data)),
        _ => None,
    });
    let messages = |(header, data): (ChunkHeader, Cow<'_, [u8]>)| {
        let records = ChunkReader::new(header, &data).expect("a chunk").map(|record| record.expect("a record"));
        records.filter(|record| matches!(record, McapRecord::Message { .. })).count()
    };
    chunks.map(messages).sum()
}

#[test]
fn a_recording_that_was_cut_off_reads_to_its_last_chunk() {
    let home = Home::new();
    let bytes = fs::read(simulated(&home, 1).1).expect("a recording");
    let whole = read(&bytes);
    let mut found = Vec::new();
    for length in (0..bytes.len()).step_by(bytes.len() / 23) {
        let told = read(&bytes[..length]);
        assert_eq!(told, whole[..told.len()], "a prefix at {length} bytes");
        found.push(told.len());
        let safe = in_whole_chunks(&bytes[..length]);
        assert!(told.len() >= safe, "{} of {safe} messages at {length} bytes", told.len());
    }
    assert!(found.is_sorted() && found.last() == Some(&whole.len()), "{found:?}");
    found.dedup();
    assert!(found.len() > 3, "chunk by chunk: {found:?}");
}

#[test]
fn a_log_exports_as_what_was_recorded() {
    let home = Home::new();
    let (log, recording) = simulated(&home, 2);
    let exported = home.path("exported.mcap");
    let args = ["export".as_ref(), log.as_os_str(), "--mcap".as_ref(), "-o".as_ref(), exported.as_os_str()];
    home.start(args).ends(0);
    let [exported, recorded] = [exported, recording].map(|path| read(&fs::read(path).expect("a recording")));
    assert_eq!(exported, recorded);
}

#[test]
fn a_killed_run_leaves_a_recording() {
    let home = Home::new();
    let recording = home.path("run.mcap");
    let path = recording.to_str().expect("UTF-8");
    let mission = experiment_file(1);
    let log = home.path("log.jsonl");
    let log = log.to_str().expect("UTF-8");
    let mut run = home.carry("run", &mission, &["--speed", "4", "--log", log, "--record", path]);
    run.says("done move 2-1");
    let is_there = || fs::read(&recording).is_ok_and(|bytes| counts(&read(&bytes)).contains_key("/state"));
    within(Duration::from_secs(20), "a chunk is written", is_there);
    // What is said may be so a moment before it is safe.
    let is_safe = || fs::read_to_string(log).is_ok_and(|text| text.contains("\"released\""));
    within(Duration::from_secs(20), "the log has it", is_safe);
    run.signal(Signal::KILL);
    drop(run.wait());
    let told = read(&fs::read(&recording).expect("a recording"));
    for topic in ["/tree", "/state", "/resources", "/messages/nodes", "/messages/controllers", "/pose", "/tf", "/log"] {
        assert!(counts(&told).contains_key(topic), "{topic}: {:?}", counts(&told));
    }
    // Robot time passes four times as fast as the wall clock, by which viewers go.
    let first = told.first().expect("a message");
    assert!(first.log_time_ns > 1_700_000_000_000_000_000, "{first:?}");
    for message in &told {
        let wall_ns = message.log_time_ns - first.log_time_ns;
        assert!(wall_ns.abs_diff(message.publish_time_ns / 4) < 2_000, "{message:?}");
    }
    within(Duration::from_secs(20), "controllers end with their run", || home.processes().is_empty());
    let last_ns = told.last().expect("a message").publish_time_ns;
    home.start(["run", "--quiet", "--speed", "100", "--resume", log, "--record", path]).ends(0);
    let told = read(&fs::read(&recording).expect("a recording"));
    let first = told.iter().find(|message| message.topic == "/state").expect("a state");
    let is_done = |node: &Value| node["name"] == "move 2-1" && node["phase"] == "done";
    assert!(first.body["nodes"].as_array().expect("a list").iter().any(is_done), "it goes on from there: {first:?}");
    assert!(told[0].publish_time_ns >= last_ns && told[0].topic == "/tree", "{:?}", told[0]);
}

#[test]
fn a_run_tells_where_its_recording_lies() {
    let home = Home::new();
    let recording = home.path("deep/run.mcap");
    let path = recording.to_str().expect("UTF-8");
    let said = home.carry("run", &experiment_file(1), &["--speed", "100", "--record", path]).ends(0).stderr;
    assert!(said.contains(&format!("recording: {path}\n")), "{said}");
    let told = read(&fs::read(&recording).expect("a recording"));
    assert!(told.last().is_some_and(|message| message.topic != "/dropped"));
    let last = told.iter().rfind(|message| message.topic == "/state").expect("a state");
    assert!(last.body["nodes"].as_array().expect("a list").iter().skip(1).all(|node| node["phase"] != "waiting"));
    home.is_empty();
}

#[test]
fn what_is_no_recording_is_not_written_over() {
    let home = Home::new();
    let (log, mission) = (home.path("log.jsonl"), experiment_file(1));
    let (log, mission) = (log.to_str().expect("UTF-8"), mission.to_str().expect("UTF-8"));
    let simulate = |record: &str, code| {
        let args = ["simulate", "--quiet", "--log", log, "--record", record, mission];
        home.start(args).ends(code).words()
    };
    let letter = home.write("letter.txt", "Dear Sir");
    let said = simulate(letter.to_str().expect("UTF-8"), 2);
    assert!(said.contains("letter.txt is there already and is no recording"), "{said}");
    assert_eq!(fs::read_to_string(&letter).expect("a letter"), "Dear Sir");
    let said = simulate(log, 2);
    assert!(said.contains("--log and --record name the same file"), "{said}");
    let recording = home.path("run.mcap");
    for _ in 0..2 {
        assert_eq!(simulate(recording.to_str().expect("UTF-8"), 0), "");
    }
    let held = fs::File::options().write(true).open(&recording).expect("a recording");
    held.lock().expect("nobody else has it");
    let said = simulate(recording.to_str().expect("UTF-8"), 2);
    assert!(said.contains("another run writes"), "{said}");
    assert!(!read(&fs::read(&recording).expect("a recording")).is_empty(), "it stays as it was");
}
