//! Files that nobody would write: too deep, too large, cut up at random.

use std::fs;
use std::process::Command;
use std::time::{Duration, Instant};

use proptest::prelude::*;
use tempfile::TempDir;

use super::super::{Disk, load_mission};
use super::{GOOD, PATH, ROBOT, load, written};

#[test]
fn what_is_too_much_is_refused() {
    let head = &GOOD[..GOOD.find("task:").unwrap()];
    let deep = |levels| {
        let open = "{and: [".repeat(levels);
        let close = "]}".repeat(levels);
        format!("{head}task: {open}{{move: shelf}}{close}\n")
    };
    assert!(load(&deep(63), ROBOT).is_ok());
    for (mission, words) in [
        (deep(66), "nested more than"),
        (deep(5000), "nested more than"),
        (format!("{GOOD}#{}", " ".repeat(1 << 20)), "larger than"),
        (format!("{head}task: {{and: [{}]}}", "{},".repeat(90_000)), "does not say what it is"),
        (format!("{head}task: {{and: [{}]}}", "1,".repeat(300_000)), "more than 250000 keys and values"),
    ] {
        let error = load(&mission, ROBOT).unwrap_err();
        let found = error.faults()[0].message();
        assert!(found.contains(words), "{found}");
        assert!(error.faults().len() <= 100);
    }
}

#[test]
fn comments_may_be_as_long_as_they_need() {
    let words = "  # one more line of what there is to say\n".repeat(2000);
    let mission = GOOD.replace("task:\n", &format!("task:\n{words}"));
    assert!(mission.contains(&words), "there is a task");
    assert_eq!(load(&mission, ROBOT).err().map(|error| error.faults()[0].message().to_owned()), None);
}

#[test]
fn aliases_stay_within_bounds() {
    let mut bomb = "a0: &a0 [1, 1, 1, 1, 1, 1, 1, 1, 1]\n".to_owned();
    for level in 1..12 {
        let items = format!("*a{}, ", level - 1).repeat(9);
        bomb += &format!("a{level}: &a{level} [{items}]\n");
    }
    assert!(load(&bomb, ROBOT).is_err());
    let anchored = GOOD.replace("pick: cup", "&it pick: cup").replace("    - place:", "    - *nothing\n    - place:");
    assert!(load(&anchored, ROBOT).is_err());
}

#[test]
fn what_is_no_file_is_not_waited_for() {
    let folder = TempDir::new().unwrap();
    let pipe = folder.path().join("pipe.yaml");
    assert!(Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    let path = folder.path().join("mission.yaml");
    for (include, words) in [("pipe.yaml", "no regular file"), ("/dev/zero", "no regular file"), (".", "directory")] {
        fs::write(folder.path().join("robot.yaml"), ROBOT).unwrap();
        fs::write(&path, GOOD.replace("world:", &format!("include: [{include}]\nworld:"))).unwrap();
        let error = load_mission(&Disk, &path, None, &[]).unwrap_err();
        assert!(error.faults()[0].message().contains(words), "{include}: {error:?}");
    }
}

#[test]
fn what_is_not_utf8_is_told_with_its_place() {
    let at = GOOD.find("cup").unwrap();
    let files = written([&GOOD.as_bytes()[..at], b"\xe9", &GOOD.as_bytes()[at..]].concat(), ROBOT);
    let error = load_mission(&files, PATH.as_ref(), None, &[]).unwrap_err();
    let fault = &error.faults()[0];
    assert_eq!((fault.position(), fault.message()), (Some((9, 5)), "this is not UTF-8"));
    // What is pointed at is what stands there instead.
    assert_eq!(fault.bytes().and_then(|bytes| fault.text().get(bytes)), Some("\u{fffd}"));
}

#[test]
fn a_place_is_on_a_line_of_the_text_that_is_shown() {
    let robot = ROBOT.replace('\n', "\r") + "zz: 1\r";
    let error = load(GOOD, &robot).unwrap_err();
    let fault = &error.faults()[0];
    let (line, _) = fault.position().unwrap();
    assert_eq!(fault.text().lines().nth(line - 1), Some("zz: 1"));
    assert!(load(&GOOD.replace('\n', "\r"), &ROBOT.replace('\n', "\r\n")).is_ok());
}

#[test]
fn many_subtrees_take_no_time() {
    let head = &GOOD[..GOOD.find("task:").unwrap()];
    let chain = |last: &str| {
        let entry = |n: usize| format!("  s{n}: {{task: {{and: [{{use: s{0}}}, {{use: s{0}}}]}}}}\n", n + 1);
        let entries: String = (0..1000).map(entry).collect();
        format!("{head}subtrees:\n{entries}  s1000: {{task: {last}}}\ntask: {{use: s999}}\n")
    };
    let start = Instant::now();
    assert!(load(&chain("{move: shelf}"), ROBOT).is_ok());
    let error = load(&chain("{use: s0}"), ROBOT).unwrap_err();
    assert_eq!(error.faults().len(), 1);
    assert!(start.elapsed() < Duration::from_secs(20), "{:?}", start.elapsed());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn no_text_makes_it_panic(
        cuts in prop::collection::vec((0..1000usize, 0..6usize, "[-a-z0-9 :\\[\\]{},&*!|>'\"#~%@.\n]{0,4}"), 1..6),
        is_robot in any::<bool>(),
    ) {
        let mut text = if is_robot { ROBOT } else { GOOD }.to_owned();
        for (at, length, by) in cuts {
            let from = at.min(text.len());
            let to = (from + length).min(text.len());
            text.replace_range(from..to, &by);
        }
        let loaded = if is_robot { load(GOOD, &text) } else { load(&text, ROBOT) };
        if let Err(error) = loaded {
            prop_assert!(!error.faults().is_empty());
            for fault in error.faults() {
                let Some((line, column)) = fault.position() else { continue };
                // A mistake at the end of a file stands behind its last line.
                let lines: Vec<&str> = fault.text().split('\n').collect();
                prop_assert!(line <= lines.len(), "line {line} of {}", lines.len());
                prop_assert!(column <= lines[line - 1].chars().count() + 1, "column {column} of {:?}", lines[line - 1]);
                let bytes = fault.bytes().expect("what has a line has bytes");
                prop_assert!(fault.text().get(bytes.clone()).is_some(), "{bytes:?} are no text");
            }
        }
    }

    #[test]
    fn no_bytes_make_it_panic(text in "\\PC{0,200}") {
        prop_assert!(load(&text, ROBOT).is_err());
    }
}
