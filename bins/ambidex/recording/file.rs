//! A recording as an MCAP file, which the public readers of that format read however it was cut off.

use std::collections::BTreeMap;
use std::fs::{self, File, TryLockError};
use std::io::{self, BufWriter, Read, Write};
use std::os::unix::fs::OpenOptionsExt;
use std::path::{Path, PathBuf};

use ambidex::show::recording::{Message, Topic};
use mcap::records::MessageHeader;
use mcap::write::NoSeek;
use mcap::{Compression, MAGIC, McapError, WriteOptions, Writer};
use strum::VariantArray;

use super::error::RecordingError;

/// A chunk is closed when so many bytes are in it, before it is compressed.
const CHUNK_BYTES: u64 = 256 << 10;

/// Messages as a stream of chunks: what was handed on is a whole one, so that a reader never finds the half of one but at
/// the end of what is there.
pub struct RecordingFile<W: Write> {
    path: PathBuf,
    writer: Option<Writer<NoSeek<BufWriter<W>>>>,
    channels: BTreeMap<Topic, u16>,
    /// Messages of each topic so far.
    counts: BTreeMap<Topic, u32>,
}

impl RecordingFile<File> {
    /// Creates the file with every folder above it, in the place of a recording that is there; locked as long as it is
    /// written.
    ///
    /// # Errors
    /// When it cannot be made, when something else is there, when another process writes it.
    pub fn create(path: &Path) -> Result<Self, RecordingError> {
        let path = path.to_owned();
        let cannot = |source| RecordingError::Create { path: path.clone(), source };
        if let Some(folder) = path.parent() {
            fs::create_dir_all(folder).map_err(cannot)?;
        }
        let mut options = File::options();
        let opened = options.read(true).write(true).create(true).truncate(false).mode(0o600).open(&path);
        let mut file = opened.map_err(cannot)?;
        if !can_be_written_over(&mut file).map_err(cannot)? {
            return Err(RecordingError::Other { path });
        }
        match file.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => return Err(RecordingError::Busy { path }),
            Err(TryLockError::Error(source)) => return Err(RecordingError::Create { path, source }),
        }
        file.set_len(0).and_then(|()| io::Seek::rewind(&mut file)).map_err(cannot)?;
        Self::begin(file, path)
    }
}

impl<W: Write> RecordingFile<W> {
    /// Begins a recording on anything that takes bytes; `path` is what errors call it.
    ///
    /// # Errors
    /// When the bytes are not taken.
    pub fn begin(out: W, path: PathBuf) -> Result<Self, RecordingError> {
        let options = WriteOptions::new()
            .compression(Some(Compression::Zstd))
            // A thread of its own writes already.
            .compression_threads(0)
            .chunk_size(Some(CHUNK_BYTES))
            // A chunk goes out when it is whole. Written into the file at once, one of which the writer was killed would
            // say that it has no end.
            .disable_seeking(true)
            .library(concat!("ambidex ", env!("CARGO_PKG_VERSION")));
        let writer = options.create(NoSeek::new(BufWriter::new(out)));
        let mut file = match writer {
            Ok(writer) => Self { path, writer: Some(writer), channels: BTreeMap::new(), counts: BTreeMap::new() },
            Err(error) => return Err(RecordingError::of_writer(path, error)),
        };
        file.with(|writer, channels| {
            for topic in Topic::VARIANTS {
                let schema = serde_json::to_vec(&topic.schema()).expect("a schema is plain");
                let schema = writer.add_schema(topic.schema_name(), "jsonschema", &schema)?;
                let channel = writer.add_channel(schema, topic.name(), "json", &BTreeMap::new())?;
                channels.insert(*topic, channel);
            }
            Ok(())
        })?;
        Ok(file)
    }

    /// Adds a message.
    ///
    /// # Errors
    /// When the file does not take it, as on a full disk; nothing is written from then on.
    pub fn write(&mut self, message: &Message) -> Result<(), RecordingError> {
        let count = self.counts.entry(message.topic).or_default();
        let sequence = *count;
        *count = count.wrapping_add(1);
        self.with(|writer, channels| {
            let header = MessageHeader {
                channel_id: channels[&message.topic],
                sequence,
                log_time: message.log_time_ns,
                publish_time: message.publish_time_ns,
            };
            writer.write_to_known_channel(&header, message.body.as_bytes())
        })
    }

    /// Closes the chunk, which needs a message in it, and hands all to the operating system: until here it is safe if the process is killed.
    ///
    /// # Errors
    /// When the file does not take it, as on a full disk; nothing is written from then on.
    pub fn flush(&mut self) -> Result<(), RecordingError> {
        self.with(|writer, _| writer.flush())
    }

    /// Adds what tells readers where everything stands, and hands all to the operating system.
    ///
    /// # Errors
    /// When the file does not take it, as on a full disk.
    pub fn finish(mut self) -> Result<W, RecordingError> {
        self.with(|writer, _| writer.finish().map(drop))?;
        let writer = self.writer.take().expect("what did not fail is there").into_inner();
        let written = writer.into_inner().into_inner();
        written.map_err(|error| RecordingError::Write { path: self.path.clone(), source: error.into_error() })
    }

    /// Where it lies.
    pub fn path(&self) -> &Path {
        &self.path
    }

    fn with(
        &mut self,
        act: impl FnOnce(&mut Writer<NoSeek<BufWriter<W>>>, &mut BTreeMap<Topic, u16>) -> Result<(), McapError>,
    ) -> Result<(), RecordingError> {
        let Some(writer) = &mut self.writer else { return Ok(()) };
        act(writer, &mut self.channels).map_err(|error| {
            // Nor does it try to end the file.
            self.writer.take().map(Writer::into_inner);
            RecordingError::of_writer(self.path.clone(), error)
        })
    }
}

/// Whether a file is empty or a recording, at least its beginning.
fn can_be_written_over(file: &mut File) -> io::Result<bool> {
    if !file.metadata()?.is_file() {
        return Ok(false);
    }
    let mut start = Vec::new();
    file.take(MAGIC.len() as u64).read_to_end(&mut start)?;
    Ok(MAGIC.starts_with(&start))
}
