//! Where daemon and controllers meet: whether it is there, is memory, has room and takes files.

use std::fs::{self, File};
use std::io::{self, Write};
use std::path::Path;

use ambidex::record::shown;
use ambidex::show::doctor::{Check, Topic};
use rustix::fs::{StatVfs, statfs, statvfs};

use super::bytes;

const TOPIC: Topic = Topic::SharedMemory;
/// What the file system of memory calls itself.
const TMPFS: rustix::fs::FsWord = 0x0102_1994;
/// A robot of ten controllers takes a few MiB; below that the first of them has no room.
const LEAST: u64 = 8 << 20;
/// Room for some robots.
const ENOUGH: u64 = 64 << 20;
/// Files that a controller has there, at least.
const LEAST_FILES: u64 = 256;

/// Looks at the folder of shared memory.
pub(super) fn checks(folder: &Path) -> Vec<Check> {
    let name = shown(folder);
    if !folder.is_dir() {
        let todo = format!("mount it: `mount -t tmpfs -o mode=1777 tmpfs {name}`; a container needs it from its host");
        return vec![TOPIC.error("mount", format!("there is no {name}"), todo)];
    }
    let about = match statvfs(folder) {
        Ok(about) => about,
        Err(error) => return vec![TOPIC.error("mount", format!("{name} cannot be looked at: {error}"), MOUNT)],
    };
    vec![mount(folder, &name), space(&about, &name), writable(try_writing(folder), &name)]
}

const MOUNT: &str = "see what is mounted there: `findmnt /dev/shm`; a tmpfs of mode 1777 is wanted";

fn mount(folder: &Path, name: &str) -> Check {
    match statfs(folder) {
        Ok(about) if about.f_type == TMPFS => TOPIC.ok("mount", format!("{name} is memory (tmpfs)")),
        Ok(_) => TOPIC.warn("mount", format!("{name} is no tmpfs: what lies there may be written to a disk"), MOUNT),
        Err(error) => TOPIC.error("mount", format!("{name} cannot be looked at: {error}"), MOUNT),
    }
}

fn space(about: &StatVfs, name: &str) -> Check {
    let free = about.f_bavail.saturating_mul(about.f_frsize);
    let of = about.f_blocks.saturating_mul(about.f_frsize);
    let found = format!("{} free of {}", bytes(free), bytes(of));
    let todo = format!(
        "see what fills it: `ls -lS {name}`; give it more: `mount -o remount,size=256m {name}`, for a container \
         `--shm-size=256m`"
    );
    // A file system that counts no files has no limit of them.
    let few_files = about.f_files > 0 && about.f_favail < LEAST_FILES;
    if few_files {
        return TOPIC.error("space", format!("{found}, and only {} more files fit", about.f_favail), todo);
    }
    match free {
        ..LEAST => TOPIC.error("space", found, todo),
        LEAST..ENOUGH => TOPIC.warn("space", found, todo),
        ENOUGH.. => TOPIC.ok("space", found),
    }
}

/// Makes a file of a page, and removes it.
fn try_writing(folder: &Path) -> io::Result<()> {
    let path = folder.join(format!(".ambidex-doctor-{}", std::process::id()));
    let written = File::create_new(&path).and_then(|mut file| file.write_all(&[1; 4096]));
    let removed = if path.exists() { fs::remove_file(&path) } else { Ok(()) };
    written.and(removed)
}

fn writable(tried: io::Result<()>, name: &str) -> Check {
    match tried {
        Ok(()) => TOPIC.ok("writable", "files can be made there"),
        Err(error) => {
            let todo = format!("`chmod 1777 {name}` as root; in a container do not mount it read-only");
            TOPIC.error("writable", format!("no file can be made in {name}: {error}"), todo)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ambidex::show::doctor::Verdict;

    #[test]
    fn room_is_judged_by_bytes_and_files() {
        let folder = tempfile::tempdir().expect("a folder");
        let mut about = statvfs(folder.path()).expect("a file system");
        let mut check = |free: u64, files: u64, expected: Verdict| {
            (about.f_frsize, about.f_bavail, about.f_files, about.f_favail) = (1, free, 1000, files);
            let check = space(&about, "/dev/shm");
            assert_eq!(check.verdict, expected, "{free} bytes, {files} files");
            assert_eq!(check.todo.is_none(), expected == Verdict::Ok);
        };
        check(1 << 30, 1000, Verdict::Ok);
        check(ENOUGH - 1, 1000, Verdict::Warn);
        check(LEAST - 1, 1000, Verdict::Error);
        check(1 << 30, 10, Verdict::Error);
    }

    #[test]
    fn what_is_not_there_or_takes_nothing_is_an_error() {
        let folder = tempfile::tempdir().expect("a folder");
        let verdicts = |folder: &Path| checks(folder).iter().map(|check| check.verdict).collect::<Vec<_>>();
        assert_eq!(verdicts(&folder.path().join("none")), [Verdict::Error]);
        assert_eq!(checks(folder.path())[2].verdict, Verdict::Ok);
        assert_eq!(fs::read_dir(folder.path()).expect("a folder").count(), 0, "it leaves nothing");
        assert_eq!(writable(Err(io::Error::from(io::ErrorKind::ReadOnlyFilesystem)), "x").verdict, Verdict::Error);
    }
}
