//! Files of the transport that are truncated, deleted or overwritten under those who have mapped them.

use std::ffi::OsStr;
use std::fs::{self, File, OpenOptions};
use std::io::{Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use ambidex::link::Instance;
use rustix::process::Signal;

use super::peer::{Peer, folder};
use super::scene::{Cup, Scene};

type Damage = fn(&Path);
type Row = (&'static str, &'static [&'static str], Damage, &'static [&'static str]);

/// What is said of a link that lies in what was truncated.
const BROKEN: &str = "left_arm is unavailable: the link to it broke";

/// Which files, by the ends of their names, what is done to them, and what the daemon says.
const DAMAGES: &[Row] = &[
    ("payload truncated to nothing", &[".data"], |path| cut(path, 0), &[BROKEN]),
    ("connections truncated to nothing", &[".connection"], |path| cut(path, 0), &[BROKEN]),
    ("ports truncated to nothing", &[".dynamic"], |path| cut(path, 0), &[BROKEN]),
    ("events truncated to nothing", &[".event_mgmt"], |path| cut(path, 0), &[BROKEN]),
    ("the transport's own truncated to nothing", &[".global_mgmt"], |path| cut(path, 0), &[]),
    ("payload truncated by half", &[".data"], |path| cut(path, 2), &[]),
    ("all of them deleted", &[".data", ".connection", ".dynamic", ".event_mgmt", ".event"], delete, &[]),
    ("descriptions of services deleted", &[".service"], delete, &[]),
    (
        "descriptions of services replaced",
        &[".service"],
        |path| fs::write(path, [0xff; 512]).expect("it is written"),
        &[],
    ),
    ("payload overwritten", &[".data"], overwrite, &[]),
];

fn cut(path: &Path, part: u64) {
    let file = OpenOptions::new().write(true).open(path).expect("its own user's file");
    let length = file.metadata().expect("a length").len();
    file.set_len(length.checked_div(part).unwrap_or(0)).expect("it is cut");
}

fn delete(path: &Path) {
    let _ = fs::remove_file(path);
}

fn overwrite(path: &Path) {
    let mut file: File = OpenOptions::new().write(true).open(path).expect("its own user's file");
    let length = file.metadata().expect("a length").len() as usize;
    file.seek(SeekFrom::Start(0)).expect("a file");
    file.write_all(&vec![0xff; length]).expect("it is written");
}

/// The files that this process has mapped, and those of the folder of its instance.
fn files(instance: &Instance) -> Vec<PathBuf> {
    let maps = fs::read_to_string("/proc/self/maps").expect("its own maps");
    let mapped = maps.lines().filter_map(|line| line.split_whitespace().nth(5)).map(PathBuf::from);
    let folder = folder(instance);
    let in_folder = [folder.clone(), folder.join("services")].into_iter().flat_map(|folder| {
        let entries = fs::read_dir(folder).into_iter().flatten().flatten();
        entries.map(|entry| entry.path()).collect::<Vec<_>>()
    });
    let mut files: Vec<_> = mapped.filter(|path| path.starts_with("/dev/shm")).chain(in_folder).collect();
    files.sort();
    files.dedup();
    files
}

pub fn damage(mut peer: Peer, instance: &Instance, row: usize) {
    let goal = peer.goal();
    peer.accept(&goal);
    let (_, ends, damage, _) = DAMAGES[row];
    let meant = |path: &Path| ends.iter().any(|end| path.to_string_lossy().ends_with(end));
    let files = files(instance);
    let meant: Vec<_> = files.iter().filter(|path| meant(path)).collect();
    assert!(!meant.is_empty(), "{files:#?}");
    meant.iter().for_each(|path| damage(path));
    peer.finish(goal);
    peer.behave();
}

/// The daemon lives, and the other arm does the work.
#[test]
fn files_that_are_damaged_cost_their_link_and_nothing_else() {
    for (row, (what, _, _, said)) in DAMAGES.iter().enumerate() {
        println!("{what}");
        let ending = Scene::new(&format!("segments {row}"), Cup::OfBoth, &[]).ends_for_all(0);
        said.iter().for_each(|said| ending.says(said));
    }
}

/// What cannot be survived is as a kill: the robot stops by itself, and the mission goes on in its log.
#[test]
fn a_daemon_that_is_ended_by_a_bus_error_goes_on_in_its_log() {
    let Scene { home, mut daemon, hostile, honest } = Scene::beside("nobody", &[]);
    daemon.says("step 2");
    daemon.signal(Signal::BUS);
    assert_eq!(daemon.wait().code, None);
    let log = home.path("run.jsonl");
    let args = ["daemon", "--instance", home.instance(), "--speed", "20", "--json", "--resume"].map(OsStr::new);
    let daemon = home.start(args.into_iter().chain([log.as_os_str()]));
    Scene { home, daemon, hostile, honest }.ends(0);
}
