//! The file of a log on a disk that can be full or slow on purpose.

use std::fs::File;
use std::io::{self, ErrorKind, Write};
use std::thread;
use std::time::Duration;

use ambidex_model::Disk;

/// How long a slow disk takes for each write, wall time.
const SLOW: Duration = Duration::from_millis(500);

/// A file and how its disk takes what is written to it.
#[derive(Debug)]
pub(super) struct DiskFile {
    pub(super) file: File,
    pub(super) disk: Disk,
}

impl From<File> for DiskFile {
    fn from(file: File) -> Self {
        Self { file, disk: Disk::default() }
    }
}

impl Write for DiskFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match self.disk {
            Disk::Well => {}
            Disk::Full => return Err(ErrorKind::StorageFull.into()),
            Disk::Slow => thread::sleep(SLOW),
        }
        self.file.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}
