//! Records a run: a thread of its own writes the messages, so that no disk holds up whoever makes them.

use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError, SyncSender, TrySendError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use ambidex::model::{Record, Time};
use ambidex::record::History;
use ambidex::show::recording::{Message, Recording};

use super::error::RecordingError;
use super::file::RecordingFile;
use crate::terminal::Patience;

/// How long a message stays in a chunk that is not handed on: so much of a recording is lost at most with its process.
const FLUSH_WITHIN: Duration = Duration::from_secs(1);
/// How long the last messages of a run may take.
const FINISH_WITHIN: Duration = Duration::from_secs(5);
const FINISH_POLL: Duration = Duration::from_millis(5);

/// What may wait to be written; what comes beyond that is dropped, and counted.
#[derive(Debug, Clone, Copy)]
pub(super) struct Room {
    pub(super) messages: usize,
    pub(super) bytes: usize,
}

const ROOM: Room = Room { messages: 16_384, bytes: 32 << 20 };

/// What waits to be written.
#[derive(Debug, Default)]
struct Waiting {
    messages: AtomicUsize,
    bytes: AtomicUsize,
}

impl Waiting {
    fn add(&self, message: &Message) {
        self.messages.fetch_add(1, Ordering::Relaxed);
        self.bytes.fetch_add(message.body.len(), Ordering::Relaxed);
    }

    fn remove(&self, bytes: usize) {
        self.messages.fetch_sub(1, Ordering::Relaxed);
        self.bytes.fetch_sub(bytes, Ordering::Relaxed);
    }

    /// Whether there is still room for one more of so many bytes. One that is larger than all room is taken alone.
    fn has_room(&self, room: Room, bytes: usize) -> bool {
        let (waiting, before) = (self.messages.load(Ordering::Relaxed), self.bytes.load(Ordering::Relaxed));
        waiting == 0 || (waiting < room.messages && before + bytes <= room.bytes)
    }

    /// Whether half of it is free again.
    fn has_much_room(&self, room: Room) -> bool {
        self.messages.load(Ordering::Relaxed) <= room.messages / 2
            && self.bytes.load(Ordering::Relaxed) <= room.bytes / 2
    }
}

/// A recording under way.
#[derive(Debug)]
pub struct Recorder {
    path: PathBuf,
    recording: Recording,
    patience: Patience,
    room: Room,
    to: SyncSender<Message>,
    waiting: Arc<Waiting>,
    writer: JoinHandle<Result<(), RecordingError>>,
    /// Messages that are missing since the last one was handed on.
    pub(super) missing: u64,
    /// Messages that are missing so far.
    total: u64,
    now: Time,
}

impl Recorder {
    /// Records into a file.
    ///
    /// # Errors
    /// When the system gives no thread.
    pub fn start(file: RecordingFile<File>, recording: Recording, patience: Patience) -> Result<Self, RecordingError> {
        Self::with_room(file, recording, patience, ROOM)
    }

    pub(super) fn with_room<W: Write + Send + 'static>(
        file: RecordingFile<W>,
        recording: Recording,
        patience: Patience,
        room: Room,
    ) -> Result<Self, RecordingError> {
        let path = file.path().to_owned();
        let (to, from) = mpsc::sync_channel(room.messages);
        let waiting = Arc::<Waiting>::default();
        let write = {
            let waiting = Arc::clone(&waiting);
            move || write_all(file, &from, &waiting)
        };
        let writer = thread::Builder::new().name("recording".into()).spawn(write);
        let writer = writer.map_err(|source| RecordingError::Create { path: path.clone(), source })?;
        let now = Time::ZERO;
        Ok(Self { path, recording, patience, room, to, waiting, writer, missing: 0, total: 0, now })
    }

    /// Takes the next record, which the history has taken last. False once nothing is written any more; the end says why.
    pub fn take(&mut self, history: &History, record: &Record) -> bool {
        self.now = record.at();
        if self.missing > 0 && self.waiting.has_much_room(self.room) {
            self.tell_missing();
        }
        let messages = self.recording.take(history, record);
        messages.into_iter().all(|message| self.hand_on(message))
    }

    /// Writes the last messages and the end of the file; how many messages are missing in it.
    ///
    /// # Errors
    /// When the file did not take a message, or does not take the last ones in time.
    pub fn finish(mut self) -> Result<u64, RecordingError> {
        let by = Instant::now() + FINISH_WITHIN;
        let is_late = |patience| patience == Patience::Drops && Instant::now() >= by;
        while self.missing > 0 && !self.writer.is_finished() && !is_late(self.patience) {
            if self.waiting.has_much_room(self.room) {
                self.tell_missing();
            } else {
                thread::sleep(FINISH_POLL);
            }
        }
        let Self { path, patience, to, writer, total, .. } = self;
        drop(to);
        while !writer.is_finished() {
            if is_late(patience) {
                return Err(RecordingError::Stuck { path });
            }
            thread::sleep(FINISH_POLL);
        }
        // A writer that panicked has written no end either.
        writer.join().unwrap_or(Err(RecordingError::Stuck { path })).map(|()| total)
    }

    /// Where the recording lies.
    pub fn path(&self) -> &Path {
        &self.path
    }

    fn tell_missing(&mut self) {
        let missing = std::mem::take(&mut self.missing);
        let message = self.recording.dropped(self.now, missing, self.total);
        self.hand_on(message);
    }

    /// Hands a message to the thread that writes; false if that has ended.
    fn hand_on(&mut self, message: Message) -> bool {
        if self.patience == Patience::Waits {
            self.waiting.add(&message);
            return self.to.send(message).is_ok();
        }
        if self.missing == 0 && self.waiting.has_room(self.room, message.body.len()) {
            self.waiting.add(&message);
            match self.to.try_send(message) {
                Ok(()) => return true,
                Err(TrySendError::Full(message)) => self.waiting.remove(message.body.len()),
                Err(TrySendError::Disconnected(_)) => return false,
            }
        }
        self.missing += 1;
        self.total += 1;
        true
    }
}

/// The thread that writes: until nobody hands on messages any more, or the file takes none.
fn write_all<W: Write>(
    mut file: RecordingFile<W>,
    from: &Receiver<Message>,
    waiting: &Waiting,
) -> Result<(), RecordingError> {
    let mut due: Option<Instant> = None;
    loop {
        let received = match due {
            None => from.recv().map_err(|_| RecvTimeoutError::Disconnected),
            Some(due) => from.recv_timeout(due.saturating_duration_since(Instant::now())),
        };
        match received {
            Ok(message) => {
                file.write(&message)?;
                waiting.remove(message.body.len());
                due.get_or_insert_with(|| Instant::now() + FLUSH_WITHIN);
            }
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => return file.finish().map(drop),
        }
        if due.is_some_and(|due| due <= Instant::now()) {
            file.flush()?;
            due = None;
        }
    }
}
