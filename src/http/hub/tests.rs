//! Readers of the stream of events, in memory and without a clock.

use ambidex_model::{Header, MissionEnd, Record, Time};
use ambidex_record::{History, samples};
use ambidex_runtime::Clock;
use futures_util::FutureExt;
use serde_json::Value;

use super::*;
use crate::limits::QUEUE_MAX;

fn header() -> Header {
    match samples::records().swap_remove(0) {
        Record::Header(header) => *header,
        other => panic!("{other:?} is no header"),
    }
}

fn hub() -> Hub {
    Hub::new(History::new(&header()), Clock::start(1.0))
}

fn record(record: &Record) -> News {
    News::Records(vec![record.clone()])
}

/// What waits for a reader, word by word with its number; of what was dropped with how many.
fn read(subscription: &mut Subscription) -> Vec<(String, u64)> {
    let mut all = Vec::new();
    while let Some(Some(event)) = subscription.next().now_or_never() {
        let data: Value = serde_json::from_str(&event.data).expect("a line of JSON");
        let more = data["records"].as_u64().map_or(String::new(), |records| format!(" {records}"));
        all.push((format!("{}{more}", event.kind.word()), event.seq));
    }
    all
}

fn row(word: &str, seq: u64) -> (String, u64) {
    (word.to_owned(), seq)
}

#[test]
fn a_snapshot_comes_first_then_all_that_happens() {
    let hub = hub();
    hub.take([record(&samples::activation())]);
    let mut early = hub.subscribe();
    assert_eq!(read(&mut early), [row("snapshot", 1)]);
    let ended = Record::Ended { at: Time::ZERO, end: MissionEnd::Done };
    hub.take([record(&samples::activation()), record(&ended)]);
    let mut late = hub.subscribe();
    assert_eq!(read(&mut early), [row("record", 2), row("record", 3), row("task", 3)]);
    assert_eq!(read(&mut late), [row("snapshot", 3)]);
    hub.take([record(&samples::activation())]);
    for reader in [&mut early, &mut late] {
        assert_eq!(read(reader), [row("record", 4)]);
    }
    assert!(early.next().now_or_never().is_none(), "it goes on");
    hub.close();
    assert_eq!(early.next().now_or_never(), Some(None));
}

#[test]
fn who_stops_reading_is_told_so_and_goes_on_from_a_snapshot() {
    let hub = hub();
    let (mut stopped, mut reads) = (hub.subscribe(), hub.subscribe());
    assert_eq!(read(&mut stopped), [row("snapshot", 0)]);
    read(&mut reads);
    let length = ambidex_show::conversation::json(&samples::activation(), &samples::names()).expect("it is one").len();
    let many = 2 * (QUEUE_MAX / length) as u64;
    for seq in 1..=many {
        hub.take([record(&samples::activation())]);
        assert_eq!(read(&mut reads), [row("record", seq)]);
        let waits = hub.inner().readers.values().map(|reader| reader.queue.bytes()).max();
        assert!(waits <= Some(QUEUE_MAX), "{waits:?}");
    }
    assert_eq!(read(&mut stopped), [row(&format!("dropped {many}"), many), row("snapshot", many)]);
    hub.take([record(&samples::activation())]);
    for reader in [&mut stopped, &mut reads] {
        assert_eq!(read(reader), [row("record", many + 1)]);
    }
    drop(stopped);
    assert_eq!(hub.inner().readers.len(), 1);
}

#[test]
fn who_is_told_of_the_snapshot_misses_nothing_behind_it() {
    let hub = hub();
    let mut reader = hub.subscribe();
    read(&mut reader);
    hub.take([News::Missed { records: 7, history: Box::new(History::new(&header())) }]);
    let dropped = reader.next().now_or_never().flatten().expect("it was told");
    assert_eq!((dropped.kind, &*dropped.data), (EventKind::Dropped, "{\"records\":7}"));
    hub.take([record(&samples::activation())]);
    assert_eq!(read(&mut reader), [row("snapshot", 7), row("record", 8)]);
}

#[test]
fn a_hub_that_does_not_keep_up_is_given_the_whole_and_nobody_waits_for_it() {
    let (mut feed, mut news) = Feed::new();
    let mut history = History::new(&header());
    let written = 200 * news.max_capacity() as u64;
    for _ in 0..written {
        history.apply(&samples::activation());
        feed.take(&samples::activation(), &history);
    }
    assert!(!feed.flush(&history), "there is no room");
    let hub = hub();
    let mut reader = hub.subscribe();
    assert_eq!(read(&mut reader), [row("snapshot", 0)]);
    let mut taken = 0;
    while let Ok(one) = news.try_recv() {
        hub.take([one]);
        taken += 1;
    }
    assert_eq!(taken, news.max_capacity());
    assert!(feed.flush(&history) && feed.flush(&history));
    while let Ok(one) = news.try_recv() {
        hub.take([one]);
    }
    assert_eq!(hub.snapshot().messages, history.messages());
    let told = read(&mut reader);
    assert_eq!(told.last(), Some(&row("snapshot", written)), "{told:?}");
    assert_eq!(told[told.len() - 2], row(&format!("dropped {written}"), written));
    drop(news);
    feed.take(&samples::activation(), &history);
    assert!(feed.flush(&history), "nobody is there to be told");
}

#[test]
fn a_run_that_begins_is_told_from_its_beginning() {
    let hub = hub();
    let mut reader = hub.subscribe();
    read(&mut reader);
    let named = Header { mission: "another".into(), ..header() };
    hub.take([record(&Record::Header(Box::new(named)))]);
    let event = reader.next().now_or_never().flatten().expect("it was told");
    let data: Value = serde_json::from_str(&event.data).expect("a snapshot");
    assert_eq!((event.kind, data["mission"].as_str()), (EventKind::Snapshot, Some("another")));
}
