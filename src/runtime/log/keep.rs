//! How many logs are kept where logs lie by default: those of one instance, and those of all unnamed runs together.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::{SystemTime, UNIX_EPOCH};

use super::file::is_being_written;
use super::path::{default_folder, default_path};

/// What the log of a run is called once another has taken its place: with the second it was written last.
const OLD: &str = "journal-";

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
    let old = files(&folder)
        .into_iter()
        .filter(|path| path.file_name().is_some_and(|name| name.to_string_lossy().starts_with(OLD)));
    prune(old, others, |log| {
        let _ = fs::remove_file(log);
    });
}

/// Whether an instance got its name because it was given none: `run-PID-` and eight hexadecimal digits.
fn is_unnamed(instance: &str) -> bool {
    let parts: Vec<&str> = instance.split('-').collect();
    let is_number = |text: &str| !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit());
    let is_salt = |text: &str| text.len() == 8 && text.bytes().all(|byte| byte.is_ascii_hexdigit());
    matches!(parts.as_slice(), ["run", pid, salt] if is_number(pid) && is_salt(salt))
}

/// Gives a log that is not being written the name of an old one.
fn put_aside(log: &Path) {
    let Some(written) = written(log).filter(|_| is_being_written(log).is_ok_and(|is_written| !is_written)) else {
        return;
    };
    let second = written.duration_since(UNIX_EPOCH).map_or(0, |since| since.as_secs());
    let names = (0..).map(|number| match number {
        0 => format!("{OLD}{second}.jsonl"),
        _ => format!("{OLD}{second}-{number}.jsonl"),
    });
    if let Some(free) = names.map(|name| log.with_file_name(name)).find(|path| !path.exists()) {
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
