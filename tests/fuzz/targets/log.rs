//! Logs that others wrote: read, folded, computed again, shown and exported in every way there is.

use ambidex::files;
use ambidex::model::{Header, Record};
use ambidex::record::audit::{Audit, OwnRecords};
use ambidex::record::{History, Reader};
use ambidex::replay::Replay;
use ambidex::show::conversation::{Conversation, Filters, Kind, Selection};
use ambidex::show::explain::{Account, Story};
use ambidex::show::export::{Rows, Table, Trace};
use ambidex::show::recording::{Recording, WallClock};
use ambidex::show::status::{Daemon, Snapshot};
use ambidex::show::{self, MIN_WIDTH, Palette, live, timeline, tree};
use ambidex::tree::Settings;

use strum::VariantArray;

use super::Taken;

/// A log, as `status`, `explain`, `trace`, `timeline`, `tree`, `verify` and the terminal of a run see it.
pub fn log(bytes: &[u8]) -> Taken {
    let mut taken = Taken::default();
    let reader = match Reader::new(bytes, "log.jsonl") {
        Ok(reader) => reader,
        Err(error) => {
            taken.said(&error.to_string());
            return taken;
        }
    };
    let header = reader.header().clone();
    let mut records = Vec::new();
    for record in reader {
        match record {
            Ok(record) => records.push(record),
            Err(error) => {
                taken.said(&error.to_string());
                break;
            }
        }
    }
    taken.accepted = records.len() > 1;
    records.iter().for_each(|record| taken.said(Kind::of(record).word()));
    taken.kinds.sort_unstable();
    taken.kinds.dedup();
    show(&header, &records);
    follow(&header, &records);
    export(&header, &records);
    audited(&header, &records, bytes);
    taken.said(&format!("{:?}", verify(&header, &records)));
    taken
}

/// What is shown of a whole log.
fn show(header: &Header, records: &[Record]) {
    let (plain, colored) = (Palette::plain(), Palette::ansi());
    let mut history = History::with_past(header);
    let mut story = Story::new(header);
    let mut account = Account::new(header, "*", None).ok();
    for record in records {
        history.apply(record);
        story.add(record);
        if let Some(account) = &mut account {
            account.add(record);
        }
    }
    drop(story.text(80, &colored));
    drop(account.map(|account| account.text(MIN_WIDTH, &plain)));
    drop((timeline::text(&history, 80, &colored), timeline::text(&history, MIN_WIDTH, &plain)));
    drop((timeline::picture(&history), timeline::compare(&history, &history)));
    drop((tree::text(header, Some(&history), 80, &plain), tree::picture(header, Some(&history))));
    drop(live::summary(&history, 80, &plain));
    drop(history.report());
    let snapshot = Snapshot::new(&history, Daemon::Gone, history.now());
    drop((snapshot.lines(80, 24, &colored), snapshot.lines(MIN_WIDTH, 500, &plain)));
    serde_json::to_string(&snapshot).expect("a status is plain");
}

/// What is shown of a log while it is read.
fn follow(header: &Header, records: &[Record]) {
    let plain = Palette::plain();
    let mut history = History::new(header);
    let filters = Filters { with_minor: true, ..Filters::default() };
    let selection = Selection::new(&filters, header).expect("it names nothing");
    let mut conversation = Conversation::new(header, selection);
    for (number, record) in records.iter().enumerate() {
        history.apply(record);
        drop(live::line(&history, record));
        if conversation.take(record) {
            drop(conversation.line(record, &plain));
            drop(conversation.json(record));
        }
        // As often as a screen is drawn.
        if number % 32 == 0 {
            drop(live::rows(&history, 80, &plain));
            drop(Snapshot::new(&history, Daemon::Running { pid: None }, history.now()).lines(80, 24, &plain));
        }
    }
}

/// What other programs read of it.
fn export(header: &Header, records: &[Record]) {
    let mission = header.source.as_ref().and_then(|source| files::load_source(source).ok());
    let mut history = History::new(header);
    let mut recording = Recording::new(WallClock::NONE, mission.map(|loaded| loaded.mission));
    let mut trace = Trace::new(header);
    let mut tables: Vec<Rows> = Table::VARIANTS.iter().map(|table| Rows::new(*table, header)).collect();
    for record in records {
        history.apply(record);
        drop(recording.take(&history, record));
        drop(trace.take(record));
        tables.iter_mut().for_each(|rows| drop(rows.take(record)));
    }
    drop(trace.finish());
    tables.into_iter().for_each(|rows| drop(rows.finish()));
}

/// What an auditor says to it, beside what calls itself the records of controllers.
fn audited(header: &Header, records: &[Record], own: &[u8]) {
    let mission = header.source.as_ref().and_then(|source| files::load_source(source).ok());
    let mut audit = Audit::new(header, mission.map(|loaded| loaded.mission));
    records.iter().for_each(|record| audit.take(record));
    let mut own_records = OwnRecords::default();
    // None of it need be one.
    drop(own_records.read("base", own));
    let report = audit.finish(Some(&own_records), true);
    drop(show::audit::text(&report, true, 80, &Palette::ansi()));
}

/// Whether everything in it follows; none where that cannot be computed.
fn verify(header: &Header, records: &[Record]) -> Option<bool> {
    let loaded = files::load_source(header.source.as_ref()?).ok()?;
    let settings = Settings::of(header, Settings::default().allocator);
    let mut replay = Replay::new(&loaded.mission, &settings);
    let is_same = records.iter().all(|record| replay.take(record).is_ok());
    if is_same {
        drop(replay.finish());
    }
    Some(is_same)
}
