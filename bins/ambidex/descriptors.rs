//! File descriptors: whether there are enough, before the first one is missing somewhere deep within.

use miette::{Result, miette};
use rustix::process::{Resource, getrlimit, setrlimit};

/// What a process has open beside its links: standard streams, log, executor, watches, locks, the transport, the socket
/// and who asks over it; and some to spare.
const FIXED: u64 = 84;
/// What one link keeps open, and what opening it takes for a moment.
const PER_LINK: u64 = 40;

/// How many files a process has open that serves so many links.
pub fn needed(links: usize) -> u64 {
    FIXED + PER_LINK * links as u64
}

/// How many links a process can serve that may have so many files open.
pub fn links_within(files: u64) -> u64 {
    files.saturating_sub(FIXED) / PER_LINK
}

/// Sees to it that this process may open as many files as it needs for so many links.
///
/// # Errors
/// When it may not, with the number.
pub fn ensure(links: usize) -> Result<()> {
    let needed = needed(links);
    let mut limit = getrlimit(Resource::Nofile);
    let is_enough = |limit: Option<u64>| limit.is_none_or(|limit| limit >= needed);
    if is_enough(limit.current) {
        return Ok(());
    }
    if is_enough(limit.maximum) {
        limit.current = Some(needed);
        if setrlimit(Resource::Nofile, limit).is_ok() {
            return Ok(());
        }
    }
    let has = limit.current.unwrap_or_default();
    Err(miette!(
        help = format!("`ulimit -n {needed}` in this shell, or in the service's unit `LimitNOFILE={needed}`"),
        "{needed} file descriptors are needed for {links} controllers, and this process may open {has}"
    ))
}
