//! Work in many parts, none of which depends on another, on several threads.

use std::num::NonZero;
use std::sync::atomic::{AtomicU64, Ordering};
use std::thread;

use crate::terminal::Progress;

/// Does parts 0 to `count` - 1, so many at once as there are cores unless told, and gives what came of them in their
/// order. Once `is_stopped` no further part begins.
///
/// # Panics
/// When a part does.
pub fn parallel<T: Send>(
    count: u64,
    jobs: Option<NonZero<usize>>,
    progress: &Progress,
    is_stopped: impl Fn() -> bool + Sync,
    part: impl Fn(u64) -> T + Sync,
) -> Vec<T> {
    let next = AtomicU64::new(0);
    let work = || {
        let mut own = Vec::new();
        while let index = next.fetch_add(1, Ordering::Relaxed)
            && index < count
            && !is_stopped()
        {
            own.push((index, part(index)));
            progress.one_more();
        }
        own
    };
    let cores = || thread::available_parallelism().map_or(1, NonZero::get);
    let jobs = jobs.map_or_else(cores, NonZero::get);
    let mut done: Vec<(u64, T)> = thread::scope(|scope| {
        // A child of a part ends with the thread that made it, so each worker waits for its own.
        let workers: Vec<_> = (0..jobs).map(|_| scope.spawn(work)).collect();
        workers.into_iter().flat_map(|worker| worker.join().expect("a part does not panic")).collect()
    });
    progress.clear();
    done.sort_by_key(|(index, _)| *index);
    done.into_iter().map(|(_, part)| part).collect()
}
