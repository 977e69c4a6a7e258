//! What a call costs, CPU time and bytes of all threads, and whether anything in it panicked.

use std::alloc::{GlobalAlloc, Layout, System};
use std::panic::{self, AssertUnwindSafe};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Mutex, Once, PoisonError};
use std::time::Duration;

use rustix::time::{ClockId, clock_gettime};

/// The system's allocator, with a count of the bytes in use and of the most there were.
pub struct Counting;

static IN_USE: AtomicUsize = AtomicUsize::new(0);
static MOST: AtomicUsize = AtomicUsize::new(0);

fn grow(bytes: usize) {
    let in_use = IN_USE.fetch_add(bytes, Ordering::Relaxed) + bytes;
    MOST.fetch_max(in_use, Ordering::Relaxed);
}

// SAFETY: everything is passed on to the system's allocator as it came.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        grow(layout.size());
        // SAFETY: the caller's promise is the same.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        IN_USE.fetch_sub(layout.size(), Ordering::Relaxed);
        // SAFETY: the caller's promise is the same.
        unsafe { System.dealloc(pointer, layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        match size.checked_sub(layout.size()) {
            Some(more) => grow(more),
            None => drop(IN_USE.fetch_sub(layout.size() - size, Ordering::Relaxed)),
        }
        // SAFETY: the caller's promise is the same.
        unsafe { System.realloc(pointer, layout, size) }
    }
}

/// What a call came to.
pub struct Measured<T> {
    /// None where it panicked itself.
    pub value: Option<T>,
    pub cpu: Duration,
    pub bytes: usize,
    /// The first panic of any thread, even of one whose caller makes good for it.
    pub panic: Option<String>,
}

static IS_MEASURING: AtomicBool = AtomicBool::new(false);
static FIRST_PANIC: Mutex<Option<String>> = Mutex::new(None);

fn first_panic() -> Option<String> {
    FIRST_PANIC.lock().unwrap_or_else(PoisonError::into_inner).take()
}

/// Calls and measures. Nothing else may run meanwhile.
pub fn measured<T>(call: impl FnOnce() -> T) -> Measured<T> {
    keep_panics();
    let (before, began) = (IN_USE.load(Ordering::Relaxed), cpu());
    MOST.store(before, Ordering::Relaxed);
    IS_MEASURING.store(true, Ordering::SeqCst);
    let value = panic::catch_unwind(AssertUnwindSafe(call)).ok();
    IS_MEASURING.store(false, Ordering::SeqCst);
    let bytes = MOST.load(Ordering::Relaxed).saturating_sub(before);
    Measured { value, cpu: cpu().saturating_sub(began), bytes, panic: first_panic() }
}

/// Keeps what would be printed, as long as something is measured.
fn keep_panics() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        let usual = panic::take_hook();
        panic::set_hook(Box::new(move |info| {
            if !IS_MEASURING.load(Ordering::SeqCst) {
                return usual(info);
            }
            let mut first = FIRST_PANIC.lock().unwrap_or_else(PoisonError::into_inner);
            first.get_or_insert_with(|| info.to_string());
        }));
    });
}

/// CPU time that this process has taken. The time of a thread would lack that of the YAML reader's.
fn cpu() -> Duration {
    let now = clock_gettime(ClockId::ProcessCPUTime);
    Duration::new(now.tv_sec.unsigned_abs(), u32::try_from(now.tv_nsec).unwrap_or(0))
}
