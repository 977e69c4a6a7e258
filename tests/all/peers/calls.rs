//! One who calls for ever is looked at as often as is useful, whatever carries the link.

use std::future::poll_fn;
use std::io::{ErrorKind, Read, Write};
use std::os::fd::{AsFd, BorrowedFd};
use std::os::unix::net::UnixStream;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use ambidex::link::{Heard, Link, LinkError};
use ambidex::model::{Labels, ToController};
use ambidex::runtime::{Port, Readable, Wake};

/// As `docs/wire.md` says it.
const CALLS_MAX: u32 = 64;
const WINDOW: Duration = Duration::from_millis(5);
const FOR: Duration = Duration::from_millis(200);

/// A link over which nothing comes but calls.
struct Bell(UnixStream);

impl Link for Bell {
    fn send(&mut self, _: &ToController) -> Result<(), LinkError> {
        Ok(())
    }

    fn drain(&mut self) -> Vec<Heard> {
        while self.0.read(&mut [0; 64]).is_ok() {}
        Vec::new()
    }

    fn beat(&mut self) {}

    fn epoch(&self) -> u64 {
        1
    }

    fn forget(&mut self) {}

    fn know(&mut self, _: &Arc<Labels>) {}
}

impl AsFd for Bell {
    fn as_fd(&self) -> BorrowedFd<'_> {
        self.0.as_fd()
    }
}

#[test]
fn calls_without_end_count_so_often() {
    let (heard, mut rung) = UnixStream::pair().expect("a pair");
    heard.set_nonblocking(true).expect("a socket");
    rung.set_nonblocking(true).expect("a socket");
    let is_over = Arc::new(AtomicBool::new(false));
    let ends = Arc::clone(&is_over);
    let ringer = thread::spawn(move || {
        while !ends.load(Ordering::Relaxed) {
            if rung.write(b"x").is_err_and(|error| error.kind() != ErrorKind::WouldBlock) {
                break;
            }
        }
    });
    let mut link = Readable::new(Bell(heard));
    let executor = tokio::runtime::Builder::new_current_thread().enable_all().build().expect("an executor");
    let (mut count, begun) = (0, Instant::now());
    executor.block_on(async {
        while begun.elapsed() < FOR {
            let wake = poll_fn(|cx| link.poll_wake(cx)).await.expect("a link");
            count += u32::from(wake == Wake::Heard);
            link.drain();
        }
    });
    let windows = u32::try_from(begun.elapsed().as_millis() / WINDOW.as_millis()).expect("a few") + 1;
    is_over.store(true, Ordering::Relaxed);
    ringer.join().expect("it rang");
    println!("{count} in {windows} windows");
    assert!(count > 0 && count <= windows * CALLS_MAX, "{count} in {windows} windows");
}
