//! `ambidex doctor` and `ambidex man` as processes.

use std::fs;
use std::process::Command;
use std::time::Duration;

use ambidex::link::Instance;
use rustix::process::Signal;
use serde_json::Value;

use crate::fixtures::experiment_file;
use crate::home::{Home, within};

/// Within which something that happened must be seen.
const SOON: Duration = Duration::from_secs(20);

/// What the doctor says of this home's surroundings; its code is that of its verdict.
fn examined(home: &Home, more: &[&str]) -> Value {
    let args = ["doctor", "--json"];
    let finished = home.start(args.iter().chain(more)).wait();
    assert_eq!(finished.stdout.lines().count(), 1, "{finished:#?}");
    let told: Value = serde_json::from_str(&finished.stdout).expect("an object");
    let code = if told["verdict"] == "ERROR" { 1 } else { 0 };
    assert_eq!(finished.code, Some(code), "{finished:#?}");
    told
}

/// The checks with such a topic and name.
fn checks<'a>(told: &'a Value, topic: &str, what: &str) -> Vec<&'a Value> {
    let checks = told["checks"].as_array().expect("a list").iter();
    checks.filter(|check| check["topic"] == topic && check["what"] == what).collect()
}

#[test]
fn what_killed_processes_left_is_told_and_removed_when_asked() {
    let home = Home::new();
    let instance = Instance::new(home.instance()).expect("a name");
    let _place = instance.lock_controller("head").expect("a place");
    let folder = instance.control_socket().parent().expect("a folder").to_owned();
    let left = ["control.sock", "controller-base.lock", "daemon.lock"].map(|name| folder.join(name));
    left.iter().for_each(|path| fs::write(path, "1\n").expect("a file"));

    let told = examined(&home, &[]);
    let [check] = checks(&told, "leftovers", home.instance())[..] else { panic!("{told}") };
    assert_eq!(check["verdict"], "WARN");
    assert_eq!(check["found"], "of processes that are gone: controller-base.lock, daemon.lock, control.sock");
    assert!(check["todo"].as_str().is_some_and(|todo| todo.contains("--fix")), "{check}");
    assert!(left.iter().all(|path| path.exists()), "looking changes nothing");

    let mended = examined(&home, &["--fix"]);
    let removed = mended["removed"].as_array().expect("a list");
    assert!(left.iter().all(|path| removed.contains(&path.to_str().into()) && !path.exists()), "{mended}");
    assert!(checks(&mended, "leftovers", home.instance()).is_empty(), "{mended}");
    assert!(folder.join("controller-head.lock").exists(), "its process lives");
}

#[test]
fn every_topic_is_looked_at_and_a_living_daemon_asked() {
    let home = Home::new();
    let mut daemon = home.daemon(&experiment_file(1), &[]);
    daemon.says("waiting for");
    within(SOON, "its log is begun", || home.status(&[]).wait().code == Some(0));
    let told = examined(&home, &["--instance", home.instance()]);
    for (topic, what) in [
        ("shared_memory", "space"),
        ("permissions", "logs"),
        ("versions", "this program"),
        ("clock", "latency"),
        ("descriptors", "open files"),
        ("system", "kernel"),
    ] {
        assert_eq!(checks(&told, topic, what).len(), 1, "{topic}, {what}: {told}");
    }
    let [asked] = checks(&told, "versions", &format!("daemon {}", home.instance()))[..] else { panic!("{told}") };
    assert_eq!(asked["verdict"], "OK", "{asked}");
    let [files] = checks(&told, "descriptors", "open files")[..] else { panic!("{told}") };
    assert!(files["found"].as_str().is_some_and(|found| found.contains("of 4 controllers")), "{files}");

    daemon.signal(Signal::STOP);
    let told = examined(&home, &["--instance", home.instance()]);
    let [asked] = checks(&told, "versions", &format!("daemon {}", home.instance()))[..] else { panic!("{told}") };
    assert!(
        asked["verdict"] == "ERROR" && asked["todo"].as_str().is_some_and(|todo| todo.contains("hangs")),
        "{asked}"
    );
    daemon.signal(Signal::CONT);
    daemon.signal(Signal::TERM);
    daemon.ends(130);

    let text = home.start(["doctor"]).wait().stdout;
    for head in
        ["Shared memory\n", "Permissions\n", "Leftovers\n", "Versions\n", "Clock\n", "Descriptors\n", "System\n"]
    {
        assert!(text.contains(head), "{head}: {text}");
    }
    assert!(!text.contains('\u{1b}'), "{text}");
    home.is_empty();
}

/// Whatever reads manual pages here finds nothing to complain of.
#[test]
fn manual_pages_are_what_their_readers_want() {
    let home = Home::new();
    let folder = home.path("man/man1");
    let written = home.start(["man", "-o", folder.to_str().expect("UTF-8")]).ends(0);
    assert!(written.stdout.is_empty() && written.stderr.contains("pages in"), "{written:#?}");
    let pages: Vec<_> = fs::read_dir(&folder).expect("a folder").flatten().map(|entry| entry.path()).collect();
    assert!(pages.iter().any(|page| page.ends_with("ambidex-daemon.1")) && pages.len() > 15, "{pages:?}");
    let readers: [&[&str]; 3] = [
        &["man", "--warnings=all", "--encoding=UTF-8", "--local-file"],
        &["groff", "-man", "-ww", "-Tutf8"],
        &["mandoc", "-Tlint", "-Wwarning"],
    ];
    for reader in readers {
        for page in &pages {
            let Ok(read) = Command::new(reader[0]).args(&reader[1..]).arg(page).env("MANWIDTH", "100").output() else {
                break;
            };
            let said = String::from_utf8_lossy(&read.stderr);
            assert!(read.status.success() && said.is_empty(), "{reader:?} {}: {said}", page.display());
        }
    }
    let page = home.start(["man"]).ends(0).stdout;
    assert!(page.contains(".TH ambidex 1") && page.contains(".SH \"EXIT STATUS\""), "{page}");
    home.is_empty();
}
