//! What a controller writes down of itself, for `ambidex audit --records`.

use std::fs::File;
use std::io::Write;
use std::path::Path;
use std::sync::mpsc::{self, Sender};
use std::thread::{self, JoinHandle};

use ambidex::link::{ServeEvent, monotonic_ns};
use ambidex::record::audit::{OwnEvent, OwnLine};
use ambidex::record::shown;
use miette::{IntoDiagnostic, Result, WrapErr};

/// A record that a thread of its own writes, so that no disk holds up the controller.
#[derive(Debug)]
pub struct OwnRecord {
    to: Option<Sender<OwnLine>>,
    writer: Option<JoinHandle<()>>,
}

impl OwnRecord {
    /// Opens the file behind its end, with every folder above it.
    ///
    /// # Errors
    /// When it cannot be opened.
    pub fn open(path: &Path) -> Result<Self> {
        let cannot = || format!("cannot write the record {}", shown(path));
        if let Some(folder) = path.parent() {
            std::fs::create_dir_all(folder).into_diagnostic().wrap_err_with(cannot)?;
        }
        let file = File::options().create(true).append(true).open(path).into_diagnostic().wrap_err_with(cannot)?;
        let (to, lines) = mpsc::channel::<OwnLine>();
        let write = move || {
            for line in lines {
                // Whole lines, each in one write: another life of the controller appends to the same file.
                let text = serde_json::to_string(&line).expect("a line is plain") + "\n";
                if let Err(error) = (&file).write_all(text.as_bytes()) {
                    tracing::error!(%error, "the record is incomplete from here on");
                    return;
                }
            }
        };
        let writer = thread::Builder::new().name("record".into()).spawn(write).into_diagnostic()?;
        Ok(Self { to: Some(to), writer: Some(writer) })
    }

    /// Takes an event.
    pub fn take(&self, event: ServeEvent<'_>) {
        let event = match event {
            ServeEvent::Ready => OwnEvent::Ready,
            ServeEvent::Attached => OwnEvent::Attached,
            ServeEvent::Left => OwnEvent::Left,
            ServeEvent::Told(message) => OwnEvent::Told(message.clone()),
            ServeEvent::Said(message) => OwnEvent::Said(message.clone()),
        };
        self.write(event);
    }

    fn write(&self, event: OwnEvent) {
        if let Some(to) = &self.to {
            // Nobody writes any more where the disk is full.
            let _ = to.send(OwnLine { at_ns: monotonic_ns(), pid: std::process::id(), event });
        }
    }
}

impl Drop for OwnRecord {
    /// Its last word says that nothing of it is lacking.
    fn drop(&mut self) {
        self.write(OwnEvent::Ended);
        drop(self.to.take());
        self.writer.take().map(JoinHandle::join);
    }
}
