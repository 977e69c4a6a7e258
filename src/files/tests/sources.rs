//! Where files come from: each is read once, whatever leads to it.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::io;
use std::path::{Path, PathBuf};

use super::super::{InMemory, Sources, check, import, load_mission, load_robot};
use super::{GOOD, PATH, ROBOT, written};

/// Files that count how often each is read.
struct Counting {
    files: InMemory,
    reads: RefCell<BTreeMap<PathBuf, usize>>,
}

impl Sources for Counting {
    fn read(&self, path: &Path) -> io::Result<Vec<u8>> {
        let name = self.identity(path).unwrap_or_else(|| path.to_owned());
        *self.reads.borrow_mut().entry(name).or_default() += 1;
        self.files.read(path)
    }

    fn identity(&self, path: &Path) -> Option<PathBuf> {
        self.files.identity(path)
    }
}

/// What is read, each once, when something is done with a mission that includes these.
fn reads(include: &str, act: impl Fn(&Counting)) -> Vec<String> {
    let mission = GOOD.replace("world:", &format!("include: [{include}]\nworld:"));
    let mut files = written(mission, ROBOT);
    files.insert("one.yaml", "library: one\ninclude: [two.yaml, ./one.yaml]\n");
    files.insert("two.yaml", "library: two\ninclude: [sub/../one.yaml]\n");
    let counting = Counting { files, reads: RefCell::default() };
    act(&counting);
    let reads = counting.reads.into_inner();
    assert!(reads.values().all(|count| *count == 1), "{reads:?}");
    reads.into_keys().map(|path| path.display().to_string()).collect()
}

#[test]
fn each_file_is_read_once() {
    let all = ["mission.yaml", "one.yaml", "robot.yaml", "two.yaml"];
    let path = Path::new(PATH);
    assert_eq!(reads("one.yaml, two.yaml", |files| drop(load_mission(files, path, None, &[]).unwrap())), all);
    assert_eq!(reads("one.yaml", |files| drop(check(files, path, &[]).unwrap())), all);
    assert_eq!(reads("one.yaml, ./one.yaml", |files| drop(check(files, path, &[]).unwrap())), all);
    assert_eq!(
        reads("robot.yaml, none.yaml", |files| drop(check(files, path, &[]).unwrap_err())),
        ["mission.yaml", "none.yaml", "robot.yaml"]
    );
    let robot = Path::new("robot.yaml");
    assert_eq!(reads("", |files| drop(load_robot(files, robot).unwrap())), ["robot.yaml"]);
    assert_eq!(reads("", |files| drop(import(files, path, Some(robot), None).unwrap_err())), ["mission.yaml"]);
}

#[test]
fn paths_of_one_file_are_one() {
    let mut files = InMemory::default();
    files.insert("a/./b/../c.yaml", "c");
    for (path, is_there) in [("a/c.yaml", true), ("./a/c.yaml", true), ("a/b/../c.yaml", true), ("c.yaml", false)] {
        assert_eq!(files.read(path.as_ref()).is_ok(), is_there, "{path}");
        assert_eq!(files.identity(path.as_ref()).is_some(), is_there, "{path}");
    }
    files.insert("../d.yaml", "d");
    assert_eq!(files.read("../d.yaml".as_ref()).unwrap(), b"d");
}
