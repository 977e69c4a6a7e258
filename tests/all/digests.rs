//! The decisions of every shipped mission, of the forty rooms and of generated trees: one digest each of what was
//! granted, done again and ended, and one of the reasons for everything else.
//!
//! A change that is to leave decisions alone leaves `tests/data/digests.txt` alone. One that means to change them
//! writes it anew with `AMBIDEX_BLESS=1` and says why each line differs.

use std::fmt::Write;
use std::sync::Arc;

use ambidex::model::{Grant, MissionSpec, Names, Record, Reopened};
use ambidex::tree::{Serial, Settings};

use crate::fixtures::{file, load, rooms, simulate};
use crate::property;

/// How many generated trees are kept.
const TREES: u64 = 400;

#[test]
fn decisions_are_those_that_were_kept() {
    let mut lines = shipped();
    lines.extend(forty_rooms());
    lines.extend((0..TREES).map(|seed| {
        let (mission, records) = property::decided(seed);
        line(&format!("tree-{seed}"), &mission.names, &records)
    }));
    let said = lines.join("\n") + "\n";
    let path = file("tests/data/digests.txt");
    if std::env::var_os("AMBIDEX_BLESS").is_some() {
        std::fs::write(&path, &said).expect("the digests are written");
    }
    let kept = std::fs::read_to_string(&path).expect("the digests are there");
    let differs = |(said, kept): &(&str, &str)| said != kept;
    let different: Vec<_> = std::iter::zip(said.lines(), kept.lines()).filter(differs).collect();
    assert!(different.is_empty(), "{} decide otherwise (now, kept): {different:#?}", different.len());
    assert_eq!(said.lines().count(), kept.lines().count());
}

fn shipped() -> Vec<String> {
    let folder = std::fs::read_dir(file("config/missions")).expect("the shipped missions");
    let mut paths: Vec<_> = folder.map(|entry| entry.expect("an entry").path()).collect();
    paths.sort();
    let serial = Settings { allocator: Arc::new(Serial), ..Settings::default() };
    let mut lines = Vec::new();
    for path in paths {
        let name = path.file_stem().and_then(|name| name.to_str()).expect("a name");
        let mission = load(&path);
        lines.push(simulated(name, &mission, &Settings::default()));
        lines.push(simulated(&format!("{name}-serial"), &mission, &serial));
    }
    lines
}

fn forty_rooms() -> Vec<String> {
    let folder = tempfile::tempdir().expect("a folder");
    let room = |(number, room): (u32, crate::fixtures::Room)| {
        let path = folder.path().join(format!("room-{number}.yaml"));
        std::fs::write(&path, room.mission(number)).expect("a file");
        simulated(&format!("room-{number}"), &load(&path), &Settings::default())
    };
    rooms().into_iter().map(room).collect()
}

fn simulated(name: &str, mission: &Arc<MissionSpec>, settings: &Settings) -> String {
    line(name, &mission.names, &simulate(mission, settings, Vec::new()).0)
}

fn line(name: &str, names: &Names, records: &[Record]) -> String {
    let (decisions, reasons) = (decisions(names, records), reasons(records));
    format!("{name} {:016x} {:016x} {}", fnv(&decisions), fnv(&reasons), decisions.lines().count())
}

/// Every decision and every end in order, in words that do not depend on how records are written; not when: that is
/// the business of the controllers.
pub fn decisions(names: &Names, records: &[Record]) -> String {
    let mut text = String::new();
    for record in records {
        match record {
            Record::Decided { round, granted, reopened, .. } => {
                write!(text, "round {round}").expect("a string takes all");
                granted.iter().for_each(|grant| tell(&mut text, names, grant));
                if let Some(reopened) = reopened {
                    let lapsed = reopened.lapsed().map(|resource| resource.0);
                    let (leaf, holder) = (reopened.node.0, reopened.up_to.0);
                    write!(text, "; {leaf} again for {holder}, {lapsed:?}").expect("a string takes all");
                }
            }
            Record::Released { leaf, end, consequences, .. } => {
                let completed =
                    consequences.completed.map(|completed| (completed.node.0, completed.heir.map(|node| node.0)));
                let failed = consequences.failed.map(|node| node.0);
                write!(text, "{} {end:?} {completed:?} {failed:?}", leaf.0).expect("a string takes all");
            }
            Record::Ended { end, .. } => write!(text, "{end:?}").expect("a string takes all"),
            Record::Infeasible { leaf, .. } => write!(text, "{} never", leaf.0).expect("a string takes all"),
            Record::TimedOut { node, .. } => write!(text, "{} too long", node.0).expect("a string takes all"),
            Record::Reopened { reopened, .. } => {
                let Reopened { node, up_to, reset, .. } = reopened;
                write!(text, "{} of {} again, {reset:?}", node.0, up_to.0).expect("a string takes all");
            }
            Record::Overtaken { skips, .. } => write!(text, "{:?} by others", skips[0]).expect("a string takes all"),
            Record::Added { .. } | Record::Removed { .. } | Record::Granting { .. } => continue,
            Record::Canceled { .. } | Record::TaskEnded { .. } | Record::Stalled { .. } => continue,
            Record::ObjectAdded { .. }
            | Record::ObjectRemoved { .. }
            | Record::Declined { .. }
            | Record::Checkpoint { .. } => continue,
            Record::Told { .. } | Record::Observed { .. } | Record::Turn { .. } | Record::Began { .. } => continue,
            Record::Header(_)
            | Record::Stopped { .. }
            | Record::Sent { .. }
            | Record::World { .. }
            | Record::Denied { .. } => continue,
            Record::Leaving { way, .. } => write!(text, "{} to be left", way.0).expect("a string takes all"),
            Record::Cleaning { node, .. } => write!(text, "{} cleans up", node.0).expect("a string takes all"),
            Record::Cleaned { node, is_done, .. } => {
                write!(text, "{} is clean: {is_done}", node.0).expect("a string takes all");
            }
            Record::Resource { .. }
            | Record::Ending { .. }
            | Record::Woke { .. }
            | Record::Served { .. }
            | Record::Awaited { .. }
            | Record::Controller { .. } => continue,
        }
        text.push('\n');
    }
    text
}

/// Why each behavior that was asked did not run, round by round.
fn reasons(records: &[Record]) -> String {
    let mut text = String::new();
    for record in records {
        if let Record::Decided { round, refused, .. } = record {
            for blocked in refused {
                writeln!(text, "{round} {} {:?}", blocked.leaf.0, blocked.reason).expect("a string takes all");
            }
        }
    }
    text
}

fn tell(text: &mut String, names: &Names, grant: &Grant) {
    write!(text, "; {} {:?}", names.node(grant.leaf()), grant.request.potential).expect("a string takes all");
    for binding in &grant.bindings {
        let name = names.resource(binding.resource);
        write!(text, " {name} {:?} {:?}", binding.access, binding.keep).expect("a string takes all");
    }
    for skip in &grant.request.skips {
        write!(text, " skips {}..{}", skip.from.0, skip.to.0).expect("a string takes all");
    }
}

/// FNV-1a of 64 bits: the same in every version of everything.
fn fnv(text: &str) -> u64 {
    text.bytes().fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3))
}
