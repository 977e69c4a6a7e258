//! The forms in which a log is exported, and how each is written record by record.

use std::io::{self, Write};
use std::path::Path;

use ambidex::model::{Header, Record};
use ambidex::record::History;
use ambidex::show::export::{Row, Rows, Table, Trace, TraceEvent};
use ambidex::show::recording::{Recording, WallClock};
use miette::{IntoDiagnostic, Result};

use crate::log;
use crate::out::Output;
use crate::page::is_read;
use crate::recording::{RecordingError, RecordingFile};
use crate::verify::rerun;

/// What a log becomes.
pub enum Form {
    /// A list of events within an object of JSON.
    Trace { trace: Box<Trace>, out: Output, is_first: bool },
    /// Rows below a head.
    Table { rows: Box<Rows>, out: Box<csv::Writer<Output>> },
    /// An MCAP file.
    Recording { recording: Box<Recording>, history: Box<History>, file: Box<RecordingFile<Output>> },
}

impl Form {
    /// Trace events.
    ///
    /// # Errors
    /// When the output takes nothing.
    pub fn trace(header: &Header, mut out: Output) -> Result<Self> {
        let begun = out.write_all(b"{\"displayTimeUnit\":\"ms\",\"traceEvents\":[");
        is_read(begun)?;
        Ok(Self::Trace { trace: Box::new(Trace::new(header)), out, is_first: true })
    }

    /// A table.
    ///
    /// # Errors
    /// When the output takes nothing.
    pub fn table(table: Table, header: &Header, out: Output) -> Result<Self> {
        let mut out = Box::new(csv::Writer::from_writer(out));
        is_read(out.write_record(table.columns()).map_err(io::Error::from))?;
        Ok(Self::Table { rows: Box::new(Rows::new(table, header)), out })
    }

    /// An MCAP file. Where things lie is told where the log carries the files of its mission.
    ///
    /// # Errors
    /// When the output takes nothing.
    pub fn recording(header: &Header, path: &Path, out: Output) -> Result<Self> {
        let mission = match rerun(header, path) {
            Ok(rerun) => Some(rerun.mission),
            Err(error) => {
                log::say(&format!("warning: where things lie is not told: {error}"));
                None
            }
        };
        let recording = Box::new(Recording::new(WallClock::NONE, mission));
        let file = Box::new(RecordingFile::begin(out, path.with_extension("mcap"))?);
        Ok(Self::Recording { recording, history: Box::new(History::new(header)), file })
    }

    /// Writes what the next record comes to.
    ///
    /// # Errors
    /// When the output does not take it.
    pub fn take(&mut self, record: &Record) -> io::Result<()> {
        match self {
            Self::Trace { trace, out, is_first } => write_events(trace.take(record), out, is_first),
            Self::Table { rows, out } => write_rows(rows.take(record), out),
            Self::Recording { recording, history, file } => {
                history.apply(record);
                let messages = recording.take(history, record);
                messages.iter().try_for_each(|message| file.write(message)).map_err(RecordingError::into_io)
            }
        }
    }

    /// Writes what goes on at the end of the log, and the end.
    ///
    /// # Errors
    /// When the output does not take it.
    pub fn finish(self) -> Result<()> {
        let (written, out) = match self {
            Self::Trace { trace, mut out, mut is_first } => {
                let events = write_events(trace.finish(), &mut out, &mut is_first);
                (events.and_then(|()| out.write_all(b"\n]}\n")), out)
            }
            Self::Table { rows, mut out } => {
                let written = write_rows(rows.finish(), &mut out);
                (written, out.into_inner().map_err(|error| error.into_error()).into_diagnostic()?)
            }
            Self::Recording { file, .. } => (Ok(()), file.finish()?),
        };
        if is_read(written)? { out.commit() } else { Ok(()) }
    }
}

fn write_events(events: Vec<TraceEvent>, out: &mut Output, is_first: &mut bool) -> io::Result<()> {
    for event in events {
        out.write_all(if std::mem::take(is_first) { b"\n" } else { b",\n" })?;
        serde_json::to_writer(&mut *out, &event)?;
    }
    Ok(())
}

fn write_rows(rows: Vec<Row>, out: &mut csv::Writer<Output>) -> io::Result<()> {
    rows.iter().try_for_each(|row| out.write_record(row)).map_err(io::Error::from)
}
