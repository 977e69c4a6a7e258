//! Kernel, memory and service manager: what of them a robot meets.

use std::fs;
use std::path::Path;

use ambidex::link::watch::Pidfd;
use ambidex::show::doctor::{Check, Topic};

use super::{bytes, first_line};

const TOPIC: Topic = Topic::System;
/// Less than that, and the system begins to end processes.
const MEMORY: u64 = 256 << 20;
/// Users below that are of the system: their shared memory is left alone.
const FIRST_PERSON: u32 = 1000;

/// Looks at the system.
pub(super) fn checks() -> Vec<Check> {
    let user = rustix::process::getuid().as_raw();
    let mut checks = vec![kernel(Pidfd::open(std::process::id()).map_err(|error| error.to_string()))];
    checks.extend(fs::read_to_string("/proc/meminfo").ok().and_then(|text| memory(&text)));
    let is_booted = Path::new("/run/systemd/system").is_dir();
    let settings = || logind_settings(Path::new("/etc/systemd"));
    let lingers = || name_of(user).is_some_and(|name| Path::new("/var/lib/systemd/linger").join(name).exists());
    checks.push(if is_booted { log_out(user, keeps(&settings()), lingers()) } else { no_manager() });
    checks
}

/// Whether the end of a process can be seen at once.
fn kernel(watched: Result<Pidfd, String>) -> Check {
    let release = first_line("/proc/sys/kernel/osrelease").unwrap_or_else(|| "of unknown version".to_owned());
    match watched {
        Ok(_) => TOPIC.ok("kernel", release),
        Err(error) => {
            let found = format!("{release}: {error}; the end of a controller is seen by its silence alone");
            TOPIC.warn("kernel", found, "use Linux 5.3 or later, and let a sandbox allow pidfd_open")
        }
    }
}

fn memory(meminfo: &str) -> Option<Check> {
    let line = meminfo.lines().find_map(|line| line.strip_prefix("MemAvailable:"))?;
    let available = line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()?.saturating_mul(1024);
    let found = format!("{} available", bytes(available));
    let todo = "end what takes it (`ps aux --sort -rss | head`): short of memory, the kernel ends processes";
    Some(if available < MEMORY { TOPIC.warn("memory", found, todo) } else { TOPIC.ok("memory", found) })
}

fn no_manager() -> Check {
    TOPIC.ok("systemd", "it does not run here; `ambidex daemon` needs no service manager")
}

/// When the last session of a person ends, systemd may remove the person's shared memory, robots and all.
fn log_out(user: u32, keeps_memory: bool, lingers: bool) -> Check {
    let found = match (user < FIRST_PERSON, keeps_memory, lingers) {
        (true, _, _) => "a user of the system, whose shared memory stays",
        (false, _, true) => "this user's services and shared memory stay when the user logs out",
        (false, true, false) => "this user's shared memory stays when the user logs out; user units end",
        (false, false, false) => {
            let found = "when this user logs out, services end and shared memory is removed under a running robot";
            return TOPIC.warn(
                "systemd",
                found,
                "`loginctl enable-linger`, or RemoveIPC=no in /etc/systemd/logind.conf",
            );
        }
    };
    TOPIC.ok("systemd", found)
}

/// What the manager of logins was told, in the order in which it reads it.
fn logind_settings(folder: &Path) -> String {
    let more = fs::read_dir(folder.join("logind.conf.d")).into_iter().flatten().flatten().map(|entry| entry.path());
    let mut more: Vec<_> = more.filter(|path| path.extension().is_some_and(|extension| extension == "conf")).collect();
    more.sort();
    let files = [folder.join("logind.conf")].into_iter().chain(more);
    files.filter_map(|path| fs::read_to_string(path).ok()).collect::<Vec<_>>().join("\n")
}

/// Whether shared memory is left alone; what is said last counts.
fn keeps(settings: &str) -> bool {
    let said = settings.lines().filter_map(|line| line.trim().strip_prefix("RemoveIPC=")).next_back();
    said.is_some_and(|said| ["no", "false", "off", "0"].contains(&said.trim().to_lowercase().as_str()))
}

/// The name of a user, as far as a file tells it.
fn name_of(user: u32) -> Option<String> {
    let users = fs::read_to_string("/etc/passwd").ok()?;
    let number = user.to_string();
    let is_meant = |line: &&str| line.split(':').nth(2) == Some(&number);
    users.lines().find(is_meant).and_then(|line| line.split(':').next()).map(str::to_owned)
}

#[cfg(test)]
mod tests {
    use super::*;
    use ambidex::show::doctor::Verdict;

    #[test]
    fn what_happens_at_a_log_out_is_told() {
        for (user, keeps, lingers, expected) in [
            (0, false, false, Verdict::Ok),
            (1000, false, false, Verdict::Warn),
            (1000, true, false, Verdict::Ok),
            (1000, false, true, Verdict::Ok),
        ] {
            assert_eq!(log_out(user, keeps, lingers).verdict, expected, "{user} {keeps} {lingers}");
        }
        for (settings, expected) in [
            ("", false),
            ("[Login]\n#RemoveIPC=no\n", false),
            ("RemoveIPC=no", true),
            ("RemoveIPC=no\n[Login]\nRemoveIPC=yes\n", false),
            ("RemoveIPC=yes\nRemoveIPC= False \n", true),
        ] {
            assert_eq!(keeps(settings), expected, "{settings}");
        }
    }

    #[test]
    fn settings_are_read_in_their_order() {
        let home = tempfile::tempdir().expect("a folder");
        fs::create_dir(home.path().join("logind.conf.d")).expect("a folder");
        for (file, text) in [
            ("logind.conf", "RemoveIPC=yes\n"),
            ("logind.conf.d/20-b.conf", "RemoveIPC=no\n"),
            ("logind.conf.d/10-a.conf", "RemoveIPC=yes\n"),
            ("logind.conf.d/30-c.txt", "RemoveIPC=yes\n"),
        ] {
            fs::write(home.path().join(file), text).expect("a file");
        }
        assert!(keeps(&logind_settings(home.path())));
    }

    #[test]
    fn kernel_and_memory_are_judged() {
        assert_eq!(kernel(Pidfd::open(std::process::id()).map_err(|error| error.to_string())).verdict, Verdict::Ok);
        assert_eq!(kernel(Err("not permitted".into())).verdict, Verdict::Warn);
        let judged = |text| memory(text).map(|check| check.verdict);
        assert_eq!(judged("MemTotal: 1 kB\nMemAvailable:    8000000 kB\n"), Some(Verdict::Ok));
        assert_eq!(judged("MemAvailable: 1000 kB\n"), Some(Verdict::Warn));
        assert_eq!(judged(""), None);
    }
}
