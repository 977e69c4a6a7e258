//! Disks that are slow, take nothing, or are full.

use std::collections::BTreeMap;
use std::io::{self, ErrorKind, Write};
use std::path::PathBuf;
use std::sync::{Arc, Condvar, Mutex};
use std::thread;

use ambidex::files::{self, Disk};
use ambidex::model::Record;
use ambidex::record::History;
use ambidex::show::recording::{Message, Recording, Topic, WallClock};
use ambidex::sim;
use ambidex::tree::Settings;
use mcap::MessageStream;

use super::error::RecordingError;
use super::file::RecordingFile;
use super::recorder::{Recorder, Room};
use crate::terminal::Patience;

/// A disk that takes nothing while it is shut, and which others may look at.
#[derive(Clone, Default)]
struct Gate(Arc<Shared>);

#[derive(Default)]
struct Shared {
    is_shut: Mutex<bool>,
    opened: Condvar,
    bytes: Mutex<Vec<u8>>,
}

impl Gate {
    fn set(&self, is_shut: bool) {
        *self.0.is_shut.lock().expect("no poison") = is_shut;
        self.0.opened.notify_all();
    }

    fn bytes(&self) -> Vec<u8> {
        self.0.bytes.lock().expect("no poison").clone()
    }
}

impl Write for Gate {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let is_shut = self.0.is_shut.lock().expect("no poison");
        drop(self.0.opened.wait_while(is_shut, |is_shut| *is_shut).expect("no poison"));
        self.0.bytes.lock().expect("no poison").write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// A disk with room for so many bytes.
struct Small(usize);

impl Write for Small {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0 = self.0.checked_sub(bytes.len()).ok_or(ErrorKind::StorageFull)?;
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

fn records() -> Vec<Record> {
    let mission = concat!(env!("CARGO_MANIFEST_DIR"), "/config/missions/experiment-1.yaml");
    let mission = files::load_mission(&Disk, mission.as_ref(), None, &[]).expect("a mission").mission;
    let mut records = Vec::new();
    sim::simulate(&mission, &Settings::default(), Vec::new(), &mut |record| records.push(record.clone()));
    records
}

fn history(records: &[Record]) -> History {
    let Record::Header(header) = &records[0] else { panic!("a header comes first") };
    History::new(header)
}

fn recording() -> Recording {
    Recording::new(WallClock::NONE, None)
}

fn recorder(disk: impl Write + Send + 'static, patience: Patience, room: Room) -> Recorder {
    let file = RecordingFile::begin(disk, PathBuf::from("run.mcap")).expect("a file");
    Recorder::with_room(file, recording(), patience, room).expect("a thread")
}

/// How often each topic comes, and the messages that say what is missing.
fn read(bytes: &[u8]) -> (BTreeMap<String, u64>, Vec<String>) {
    let (mut counts, mut dropped) = (BTreeMap::new(), Vec::new());
    for message in MessageStream::new(bytes).expect("a recording") {
        let message = message.expect("a message");
        *counts.entry(message.channel.topic.clone()).or_default() += 1;
        if message.channel.topic == Topic::Dropped.name() {
            dropped.push(String::from_utf8(message.data.to_vec()).expect("JSON"));
        }
    }
    (counts, dropped)
}

#[test]
fn what_a_slow_disk_does_not_take_is_counted_and_then_told_anew() {
    let (records, disk) = (records(), Gate::default());
    let mut recorder = recorder(disk.clone(), Patience::Drops, Room { messages: 8, bytes: 1 << 20 });
    let (mut history, mut same, mut made) = (history(&records), recording(), 0);
    let mut take = |recorder: &mut Recorder, record: &Record| {
        history.apply(record);
        made += same.take(&history, record).len() as u64;
        assert!(recorder.take(&history, record));
    };
    disk.set(true);
    let mut next = records.iter();
    while recorder.missing == 0 {
        take(&mut recorder, next.next().expect("a shut disk takes not all of a run"));
    }
    disk.set(false);
    let last = records.last().expect("an end");
    while recorder.missing > 0 {
        thread::yield_now();
        take(&mut recorder, last);
    }
    let missing = recorder.finish().expect("the disk takes the rest");
    let (counts, dropped) = read(&disk.bytes());
    let told = |told: &String| serde_json::from_str::<serde_json::Value>(told).expect("JSON")["missing"].as_u64();
    assert!(missing > 0);
    assert_eq!(dropped.iter().filter_map(told).sum::<u64>(), missing, "{dropped:?}");
    assert!(counts["/tree"] > 1, "what there is after a gap is told anew: {counts:?}");
    let written: u64 = counts.values().sum();
    assert!(written + missing > made, "{written} written and {missing} missing of {made} and what was told anew");
}

#[test]
fn a_simulation_waits_for_its_disk() {
    let (records, disk) = (records(), Gate::default());
    let mut recorder = recorder(disk.clone(), Patience::Waits, Room { messages: 2, bytes: 1 });
    let (mut history, mut same, mut made) = (history(&records), recording(), Vec::<Message>::new());
    for record in &records {
        history.apply(record);
        made.extend(same.take(&history, record));
        assert!(recorder.take(&history, record));
    }
    assert_eq!(recorder.finish().expect("all is written"), 0);
    let (counts, dropped) = read(&disk.bytes());
    assert_eq!((counts.values().sum::<u64>(), dropped.len()), (made.len() as u64, 0));
}

#[test]
fn a_full_disk_ends_a_recording_and_nothing_else() {
    let records = records();
    let mut recorder = recorder(Small(20_000), Patience::Waits, Room { messages: 2, bytes: 1 });
    let mut history = history(&records);
    let mut is_taken = |record: &Record| {
        history.apply(record);
        recorder.take(&history, record)
    };
    assert!(!records.iter().all(&mut is_taken), "a run does not fit on the disk");
    let error = recorder.finish().expect_err("the disk is full");
    assert!(matches!(error, RecordingError::Write { .. }), "{error}");
}
