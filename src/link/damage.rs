//! Files of the transport that others truncate or overwrite while they are mapped. Whoever touches what is gone is killed
//! by SIGBUS, and any process of the same user can truncate. Here such a touch finds zeros instead, and is counted:
//! whoever reads a port asks before and after, and uses it no more. What the transport panics over is contained.

use std::any::Any;
use std::cell::Cell;
use std::io;
use std::os::fd::AsFd;
use std::panic::AssertUnwindSafe;
use std::sync::atomic::{AtomicU64, Ordering};
use std::{mem, panic, ptr};

use libc::{SIGBUS, c_int, c_void, siginfo_t};
use rustix::fs::{Mode, OFlags, open};
use rustix::mm::{MapFlags, ProtFlags, mmap_anonymous};
use signal_hook::low_level::emulate_default_handler;

use crate::instances::{PREFIX, shared_memory};

/// Touches of what was truncated, in this process.
static DAMAGES: AtomicU64 = AtomicU64::new(0);

thread_local! {
    /// Whether who works on this thread hears of a panic by [`contained`].
    static IS_CONTAINED: Cell<bool> = const { Cell::new(false) };
}

/// Longest line of a process's maps that is looked at; longer ones are of other files.
const LINE_MAX: usize = 512;
const READ_MAX: usize = 2048;

/// From now on this process survives that a file of the transport is truncated under it; any other SIGBUS ends it as ever.
/// What the transport panics over since others wrote it is told by whoever gives the link up. A daemon that does without is killed, and its mission goes on with `--resume`.
///
/// # Errors
/// When the handler cannot be set.
pub fn survive_truncation() -> io::Result<()> {
    // signal-hook would call the handler of std first, which takes the next SIGBUS as fatal.
    // SAFETY: the handler makes system calls on its own stack and changes one atomic; it neither allocates nor locks.
    let is_set = unsafe {
        let mut action: libc::sigaction = mem::zeroed();
        action.sa_sigaction = on_fault as *const () as libc::sighandler_t;
        action.sa_flags = libc::SA_SIGINFO;
        libc::sigaction(SIGBUS, &action, ptr::null_mut()) == 0
    };
    if !is_set {
        return Err(io::Error::last_os_error());
    }
    let tell = panic::take_hook();
    panic::set_hook(Box::new(move |about| {
        if !IS_CONTAINED.get() {
            tell(about);
        }
    }));
    Ok(())
}

/// How often this process has touched what was truncated.
pub(crate) fn count() -> u64 {
    DAMAGES.load(Ordering::Relaxed)
}

/// What the work gives, or what it panicked over: the transport does so over what it did not write.
///
/// # Errors
/// The message of the panic.
pub(crate) fn contained<T>(work: impl FnOnce() -> T) -> Result<T, String> {
    let was_contained = IS_CONTAINED.replace(true);
    let done = panic::catch_unwind(AssertUnwindSafe(work));
    IS_CONTAINED.set(was_contained);
    done.map_err(|panic| message(&*panic).to_owned())
}

fn message(panic: &(dyn Any + Send)) -> &str {
    let owned = panic.downcast_ref::<String>().map(String::as_str);
    owned.or_else(|| panic.downcast_ref::<&str>().copied()).unwrap_or("no message")
}

extern "C" fn on_fault(_signal: c_int, info: *mut siginfo_t, _context: *mut c_void) {
    // SAFETY: the kernel hands in what it is about; one that somebody sent has no address, and any number in its place.
    let address = unsafe { (*info).si_addr() } as usize;
    if patch(address).is_some() {
        DAMAGES.fetch_add(1, Ordering::Relaxed);
    } else {
        // It cannot fail for this signal; if it did, the touch would be repeated for ever.
        let _ = emulate_default_handler(SIGBUS);
    }
}

/// Puts zeros where a file of the transport has nothing any more; none if the address is of anything else.
fn patch(address: usize) -> Option<()> {
    let end = mapping_end(address)?;
    let page = address & !(rustix::param::page_size() - 1);
    let (protection, flags) = (ProtFlags::READ | ProtFlags::WRITE, MapFlags::PRIVATE | MapFlags::FIXED);
    // SAFETY: all from this page on is beyond the end of the file, so that nobody can use it as it is, and it belongs to a
    // mapping of the transport, which unmaps it by its address and length.
    unsafe { mmap_anonymous(page as *mut _, end - page, protection, flags) }.ok()?;
    Some(())
}

/// Where the mapping of a file of the transport ends that has the address.
fn mapping_end(address: usize) -> Option<usize> {
    let maps = open(c"/proc/self/maps", OFlags::RDONLY | OFlags::CLOEXEC, Mode::empty()).ok()?;
    let (mut line, mut used) = ([0; LINE_MAX], 0);
    let mut buffer = [0; READ_MAX];
    loop {
        let count = rustix::io::read(maps.as_fd(), &mut buffer).ok().filter(|count| *count > 0)?;
        for &byte in &buffer[..count] {
            if byte == b'\n' {
                if let Some(end) = end_if_meant(line.get(..used).unwrap_or_default(), address) {
                    return Some(end);
                }
                used = 0;
            } else {
                if let Some(place) = line.get_mut(used) {
                    *place = byte;
                }
                used += 1;
            }
        }
    }
}

/// Where the mapping of this line ends, if it has the address and is of the transport.
fn end_if_meant(line: &[u8], address: usize) -> Option<usize> {
    let text = str::from_utf8(line).ok()?;
    let (range, rest) = text.split_once(' ')?;
    let (from, to) = range.split_once('-')?;
    let (from, to) = (usize::from_str_radix(from, 16).ok()?, usize::from_str_radix(to, 16).ok()?);
    let path = rest.get(rest.find('/')?..)?;
    let name = path.strip_prefix(shared_memory().to_str()?)?.strip_prefix('/')?;
    ((from..to).contains(&address) && name.starts_with(PREFIX)).then_some(to)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_mappings_of_the_transport_are_meant() {
        let ours = "7f0000001000-7f0000003000 rw-s 00000000 00:1a 5 /dev/shm/ambidex_0123456789_1.data";
        let other = "7f0000001000-7f0000003000 rw-s 00000000 00:1a 5 /dev/shm/other_1.data";
        let library = "7f0000001000-7f0000003000 r-xp 00000000 08:01 5 /usr/lib/ambidex_1.so";
        let rows = [
            (ours, 0x7f00_0000_1000, Some(0x7f00_0000_3000)),
            (ours, 0x7f00_0000_2fff, Some(0x7f00_0000_3000)),
            (ours, 0x7f00_0000_3000, None),
            (ours, 0x7f00_0000_0fff, None),
            (other, 0x7f00_0000_1000, None),
            (library, 0x7f00_0000_1000, None),
            ("7f0000001000-7f0000003000 rw-p 00000000 00:00 0", 0x7f00_0000_1000, None),
            ("", 0, None),
        ];
        for (line, address, expected) in rows {
            assert_eq!(end_if_meant(line.as_bytes(), address), expected, "{line} {address:x}");
        }
        assert_eq!(mapping_end(&raw const DAMAGES as usize), None, "its own memory");
    }

    #[test]
    fn who_contains_a_panic_hears_why() {
        assert_eq!(contained(|| 1), Ok(1));
        assert_eq!(contained(|| panic!("on purpose")), Err::<(), _>("on purpose".to_owned()));
        assert_eq!(contained(|| panic!("{}", 2)), Err::<(), _>("2".to_owned()));
        let inner = contained(|| {
            assert!(contained(|| panic!("within")).is_err());
            IS_CONTAINED.get()
        });
        assert_eq!((inner, IS_CONTAINED.get()), (Ok(true), false));
    }
}
