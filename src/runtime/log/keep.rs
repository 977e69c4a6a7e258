//! How many logs are kept where logs lie by default: those of one instance, and those of all unnamed runs together.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::time::{SystemTime, UNIX_EPOCH};

use super::held::is_being_written;
use super::path::{default_folder, default_path};

/// Makes room for a new log of the instance, so that with it no more than `keep` are left; what is being written is
/// spared. Logs that cannot be removed stay.
pub fn make_room(instance: &str, keep: usize) {
    let others = keep.saturating_sub(1);
    let folder = default_folder(instance);
    if is_unnamed(instance) {
        let all = folder.parent().map(folders).unwrap_or_default();
        let unnamed =
            all.into_iter().filter(|folder| folder.file_name().is_some_and(|name| is_unnamed(&name.to_string_lossy())));
        prune(unnamed.map(|folder| folder.join("journal.jsonl")), others, |log| {
            let _ = log.parent().map(fs::remove_dir_all);
        });
        return;
    }
    put_aside(&default_path(instance));
    make_room_for_old(&default_path(instance), others);
}

/// Removes all but the newest `keep` of the logs that once stood at the path of this one.
pub(super) fn make_room_for_old(log: &Path, keep: usize) {
    let folder = log.parent().map(Path::to_owned).unwrap_or_default();
    let old = files(&folder).into_iter().filter(|path| is_old(path, log));
    prune(old, keep, |log| {
        let _ = fs::remove_file(log);
    });
}

/// Whether a file has the name that a log gets once another has taken its place: with a second, and perhaps a number.
fn is_old(path: &Path, log: &Path) -> bool {
    let stem = |path: &Path| path.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
    let behind = |stem_of_old: &str| {
        let behind = stem_of_old.strip_prefix(stem(log).as_str())?.strip_prefix('-')?;
        Some(behind.split('-').all(is_number))
    };
    path.extension() == log.extension() && behind(&stem(path)) == Some(true)
}

/// A free name for a log that was written last at that moment.
fn name_of_old(log: &Path, written: SystemTime) -> Option<PathBuf> {
    let second = written.duration_since(UNIX_EPOCH).map_or(0, |since| since.as_secs());
    let stem = log.file_stem()?.to_string_lossy().into_owned();
    let end = log.extension().map_or(String::new(), |end| format!(".{}", end.to_string_lossy()));
    let names = (0..).map(|number| match number {
        0 => format!("{stem}-{second}{end}"),
        _ => format!("{stem}-{second}-{number}{end}"),
    });
    names.map(|name| log.with_file_name(name)).find(|path| !path.exists())
}

/// Gives a log the name of an old one besides its own, so that another can take its place at once.
///
/// # Errors
/// When there is no room or no right for that.
pub(super) fn put_behind(log: &Path) -> io::Result<()> {
    let old = name_of_old(log, SystemTime::now()).ok_or(io::ErrorKind::AlreadyExists)?;
    match fs::hard_link(log, &old) {
        // Some file systems have one name for a file alone: then there is a moment without a log.
        Err(error) if matches!(error.kind(), io::ErrorKind::Unsupported | io::ErrorKind::PermissionDenied) => {
            fs::rename(log, old)
        }
        linked => linked,
    }
}

/// Whether an instance got its name because it was given none: `run-PID-` and eight hexadecimal digits.
fn is_unnamed(instance: &str) -> bool {
    let parts: Vec<&str> = instance.split('-').collect();
    let is_salt = |text: &str| text.len() == 8 && text.bytes().all(|byte| byte.is_ascii_hexdigit());
    matches!(parts.as_slice(), ["run", pid, salt] if is_number(pid) && is_salt(salt))
}

fn is_number(text: &str) -> bool {
    !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit())
}

/// Gives a log that is not being written the name of an old one.
fn put_aside(log: &Path) {
    let Some(written) = written(log).filter(|_| is_being_written(log).is_ok_and(|is_written| !is_written)) else {
        return;
    };
    if let Some(free) = name_of_old(log, written) {
        let _ = fs::rename(log, free);
    }
}

/// Removes all but the newest `keep` of these logs, and none that is being written.
fn prune(logs: impl Iterator<Item = PathBuf>, keep: usize, remove: impl Fn(&Path)) {
    let mut dated: Vec<_> = logs.filter_map(|log| Some((written(&log)?, log))).collect();
    dated.sort_by(|one, other| other.cmp(one));
    for (_, log) in dated.into_iter().skip(keep) {
        if is_being_written(&log).is_ok_and(|is_written| !is_written) {
            remove(&log);
        }
    }
}

fn written(log: &Path) -> Option<SystemTime> {
    fs::metadata(log).and_then(|about| about.modified()).ok()
}

fn files(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    entries.map(|entry| entry.path()).filter(|path| path.is_file()).collect()
}

fn folders(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    entries.map(|entry| entry.path()).filter(|path| path.is_dir()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unnamed_runs_are_known_by_their_names() {
        let check = |name: &str, expected| assert_eq!(is_unnamed(name), expected, "{name}");
        check("run-123-00ffab12", true);
        check("run-1", false);
        check("run-x-00ffab12", false);
        check("run-1-00ffab123", false);
        check("simulate", false);
    }

    #[test]
    fn the_newest_are_kept_and_what_is_written_is_spared() {
        let folder = tempfile::tempdir().unwrap();
        let log = |second: u64| {
            let path = folder.path().join(format!("{second}.jsonl"));
            let file = fs::File::create(&path).unwrap();
            file.set_modified(UNIX_EPOCH + std::time::Duration::from_secs(second)).unwrap();
            (path, file)
        };
        let logs: Vec<_> = (1..=5).map(log).collect();
        logs[1].1.lock().unwrap();
        prune(logs.iter().map(|(path, _)| path.clone()), 2, |log| fs::remove_file(log).unwrap());
        let left: Vec<bool> = logs.iter().map(|(path, _)| path.exists()).collect();
        assert_eq!(left, [false, true, false, true, true]);
    }

    #[test]
    fn what_is_put_aside_has_a_name_of_its_own() {
        let folder = tempfile::tempdir().unwrap();
        let log = folder.path().join("journal.jsonl");
        for _ in 0..3 {
            let file = fs::File::create(&log).unwrap();
            file.set_modified(UNIX_EPOCH + std::time::Duration::from_secs(7)).unwrap();
            drop(file);
            put_aside(&log);
        }
        let mut left: Vec<_> = files(folder.path()).iter().map(|path| path.file_name().unwrap().to_owned()).collect();
        left.sort();
        assert_eq!(left, ["journal-7-1.jsonl", "journal-7-2.jsonl", "journal-7.jsonl"]);
    }
}
