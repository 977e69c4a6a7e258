//! Where journals lie unless told otherwise.

use std::env;
use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};

/// `$XDG_STATE_HOME/ambidex/<instance>`, else below `$HOME/.local/state`, else below the folder for temporary files.
pub fn default_folder(instance: &str) -> PathBuf {
    let state = env::var_os("XDG_STATE_HOME");
    state_home(state, env::var_os("HOME"), &env::temp_dir()).join("ambidex").join(instance)
}

/// The journal of an instance unless it was told to lie elsewhere.
pub fn default_path(instance: &str) -> PathBuf {
    default_folder(instance).join("journal.jsonl")
}

/// The instances that have a journal where it lies by default, the one that was written last first.
pub fn instances() -> Vec<String> {
    let any = default_folder("x");
    let folders = any.parent().and_then(|all| fs::read_dir(all).ok()).into_iter().flatten().flatten();
    let names = folders.filter_map(|entry| entry.file_name().into_string().ok());
    let written = |name: &String| fs::metadata(default_path(name)).and_then(|about| about.modified()).ok();
    let mut found: Vec<_> = names.filter_map(|name| Some((written(&name)?, name))).collect();
    found.sort_by(|one, other| other.cmp(one));
    found.into_iter().map(|(_, name)| name).collect()
}

/// The XDG specification tells to ignore a path that is not absolute.
fn state_home(state: Option<OsString>, home: Option<OsString>, temp: &Path) -> PathBuf {
    let absolute = |var: Option<OsString>| var.map(PathBuf::from).filter(|path| path.is_absolute());
    absolute(state).or_else(|| absolute(home).map(|home| home.join(".local/state"))).unwrap_or_else(|| temp.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(state: Option<&str>, home: Option<&str>, expected: &str) {
        let found = state_home(state.map(OsString::from), home.map(OsString::from), Path::new("/t"));
        assert_eq!(found, Path::new(expected), "{state:?} {home:?}");
    }

    #[test]
    fn state_home_falls_back_step_by_step() {
        check(Some("/s"), Some("/h"), "/s");
        check(Some("relative"), Some("/h"), "/h/.local/state");
        check(Some(""), Some("/h"), "/h/.local/state");
        check(None, Some("/h"), "/h/.local/state");
        check(None, None, "/t");
        check(None, Some(""), "/t");
    }

    #[test]
    fn the_folder_ends_with_the_instance() {
        assert!(default_folder("lab").ends_with("ambidex/lab"));
    }
}
