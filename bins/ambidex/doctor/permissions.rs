//! Who may write where: the folders of instances are for their user alone, that of logs is the user's own.

use std::fs;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};

use ambidex::record::shown;
use ambidex::runtime::log::default_folder;
use ambidex::show::doctor::{Check, Topic};
use rustix::fs::{Access, access};

use super::Subject;

const TOPIC: Topic = Topic::Permissions;
/// What group and others may do.
const OTHERS: u32 = 0o077;

/// Looks at folders, sockets and segments.
pub(super) fn checks(subject: &Subject) -> Vec<Check> {
    let user = rustix::process::getuid().as_raw();
    let survey = &subject.survey;
    // What lies in these folders nobody else gets at; segments lie where all can see them.
    let below = survey.instances.iter().flat_map(|instance| [vec![instance.folder.clone()], instance.segments.clone()]);
    let private: Vec<PathBuf> = [survey.folder.clone()].into_iter().chain(below.flatten()).collect();
    let runtime = std::env::var_os("XDG_RUNTIME_DIR").filter(|folder| !folder.is_empty()).map(PathBuf::from);
    let mut checks = vec![instances(&survey.folder, &private, user), logs(&default_folder("any"), user)];
    checks.extend(runtime.map(|folder| runtime_folder(&folder, user)));
    checks
}

fn contents(folder: &Path) -> impl Iterator<Item = PathBuf> + use<> {
    fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path())
}

/// What is for this user alone.
fn instances(folder: &Path, private: &[PathBuf], user: u32) -> Check {
    let Ok(about) = fs::symlink_metadata(folder) else {
        return TOPIC.ok("instances", format!("{} is made by the first that runs", shown(folder)));
    };
    if about.uid() != user || !about.is_dir() {
        let found = format!("{} belongs to user {}, and no instance can begin", shown(folder), about.uid());
        return TOPIC.error("instances", found, "remove it as that user or as root, if nobody knows what it is for");
    }
    let is_wide = |path: &&PathBuf| {
        fs::symlink_metadata(path).is_ok_and(|about| !about.is_symlink() && about.mode() & OTHERS != 0)
    };
    let wide: Vec<&PathBuf> = private.iter().filter(is_wide).collect();
    match wide.as_slice() {
        [] => TOPIC.ok("instances", format!("{} and all below it is for this user alone", shown(folder))),
        [first, more @ ..] => {
            let more = if more.is_empty() { String::new() } else { format!(" and {} more", more.len()) };
            let found = format!("others may get at {}{more}", shown(first));
            TOPIC.warn("instances", found, format!("`chmod -R go= {} /dev/shm/ambidex_*`", shown(folder)))
        }
    }
}

/// Whether logs can be written by this user.
fn logs(instance: &Path, user: u32) -> Check {
    let folder = instance.parent().unwrap_or(instance);
    let there = folder.ancestors().find(|folder| folder.exists()).unwrap_or(folder);
    if !there.is_dir() || access(there, Access::WRITE_OK | Access::EXEC_OK).is_err() {
        let found = format!("no log can be written in {}: {} is not this user's to write", shown(folder), shown(there));
        let todo = "give it to the user that runs the robot with `chown`, or set XDG_STATE_HOME or --log";
        return TOPIC.error("logs", found, todo);
    }
    let below = contents(folder).chain(contents(folder).flat_map(|instance| contents(&instance)));
    let foreign = |path: &PathBuf| fs::symlink_metadata(path).is_ok_and(|about| about.uid() != user);
    match below.filter(foreign).collect::<Vec<_>>().as_slice() {
        [] => TOPIC.ok("logs", format!("they can be written in {}", shown(folder))),
        [first, ..] => {
            let found = format!("{} belongs to another user, as after `sudo ambidex`", shown(first));
            TOPIC.warn("logs", found, format!("`chown -R {user} {}` as root", shown(folder)))
        }
    }
}

/// What a user's service manager needs.
fn runtime_folder(folder: &Path, user: u32) -> Check {
    let what = "XDG_RUNTIME_DIR";
    let todo = "log in as this user, not by `su` or `sudo`; for a user that never does: `loginctl enable-linger`";
    match fs::metadata(folder) {
        Err(error) => TOPIC.warn(what, format!("{}: {error}; no user unit can be started", shown(folder)), todo),
        Ok(about) if about.uid() != user => {
            TOPIC.warn(what, format!("{} belongs to user {}", shown(folder), about.uid()), todo)
        }
        Ok(about) if about.mode() & OTHERS != 0 => {
            let found = format!("others may get at {}", shown(folder));
            TOPIC.warn(what, found, format!("`chmod 700 {}`", shown(folder)))
        }
        Ok(_) => TOPIC.ok(what, format!("{} is this user's", shown(folder))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ambidex::show::doctor::Verdict;
    use std::fs::Permissions;
    use std::os::unix::fs::PermissionsExt;

    fn mode(path: &Path, mode: u32) {
        fs::set_permissions(path, Permissions::from_mode(mode)).expect("a mode");
    }

    #[test]
    fn what_others_can_get_at_is_named() {
        let home = tempfile::tempdir().expect("a folder");
        let user = rustix::process::getuid().as_raw();
        let (folder, socket) = (home.path().join("all"), home.path().join("all/control.sock"));
        let judged = |user| instances(&folder, &[folder.clone(), socket.clone()], user);
        assert_eq!(judged(user).verdict, Verdict::Ok, "it is not there yet");
        fs::create_dir(&folder).expect("a folder");
        fs::write(&socket, "").expect("a file");
        mode(&folder, 0o700);
        mode(&socket, 0o600);
        assert_eq!(judged(user).verdict, Verdict::Ok);
        mode(&socket, 0o660);
        let wide = judged(user);
        assert!(wide.verdict == Verdict::Warn && wide.found.contains("control.sock"), "{wide:?}");
        assert_eq!(judged(user + 1).verdict, Verdict::Error, "another user made it");
    }

    #[test]
    fn logs_of_another_user_are_named() {
        let home = tempfile::tempdir().expect("a folder");
        let user = rustix::process::getuid().as_raw();
        let instance = home.path().join("state/ambidex/lab");
        assert_eq!(logs(&instance, user).verdict, Verdict::Ok, "it can be made");
        fs::create_dir_all(&instance).expect("a folder");
        assert_eq!(logs(&instance, user).verdict, Verdict::Ok);
        let foreign = logs(&instance, user + 1);
        assert!(foreign.verdict == Verdict::Warn && foreign.found.contains("lab"), "{foreign:?}");
        fs::write(home.path().join("file"), "x").expect("a file");
        assert_eq!(logs(&home.path().join("file/ambidex/lab"), user).verdict, Verdict::Error);
    }

    #[test]
    fn the_runtime_folder_is_of_its_user_alone() {
        let home = tempfile::tempdir().expect("a folder");
        let user = rustix::process::getuid().as_raw();
        for (bits, expected) in [(0o700, Verdict::Ok), (0o755, Verdict::Warn)] {
            mode(home.path(), bits);
            assert_eq!(runtime_folder(home.path(), user).verdict, expected);
        }
        assert_eq!(runtime_folder(home.path(), user + 1).verdict, Verdict::Warn);
        assert_eq!(runtime_folder(&home.path().join("none"), user).verdict, Verdict::Warn);
    }
}
