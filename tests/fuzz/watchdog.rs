//! What is running at this moment, so that it is known when it never ends or takes the whole process with it.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{LazyLock, Once};
use std::thread;
use std::time::{Duration, Instant};

use crate::limits::HANGS;

/// Milliseconds of [`START`] since which an input runs; 0 while none does.
static SINCE: AtomicU64 = AtomicU64::new(0);
static START: LazyLock<Instant> = LazyLock::new(Instant::now);

/// Where inputs are written that should be looked at.
pub fn folder(target: &str) -> PathBuf {
    Path::new(env!("CARGO_TARGET_TMPDIR")).join("fuzz").join(target)
}

/// An input is running until this is dropped.
pub struct Watched;

impl Watched {
    /// Writes the input down as the one that runs.
    pub fn new(target: &str, input: &[u8]) -> Self {
        watch();
        let folder = folder(target);
        let written = fs::create_dir_all(&folder).and_then(|()| fs::write(folder.join("running"), input));
        written.expect("the target folder can be written");
        SINCE.store(now_ms(), Ordering::SeqCst);
        Self
    }
}

impl Drop for Watched {
    fn drop(&mut self) {
        SINCE.store(0, Ordering::SeqCst);
    }
}

fn now_ms() -> u64 {
    START.elapsed().as_millis() as u64 + 1
}

/// Ends the process where an input does not: nothing else could.
fn watch() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        thread::spawn(|| {
            loop {
                thread::sleep(Duration::from_millis(500));
                let since = SINCE.load(Ordering::SeqCst);
                if since > 0 && u128::from(now_ms() - since) > HANGS.as_millis() {
                    eprintln!("an input does not end: it is `running` in a folder of {}", folder("").display());
                    std::process::exit(101);
                }
            }
        });
    });
}
