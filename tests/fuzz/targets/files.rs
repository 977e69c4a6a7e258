//! Files of every format.

use std::path::Path;
use std::sync::{Arc, LazyLock};

use ambidex::files::{
    self, Checked, Fault, FilesError, InMemory, Loaded, check, load_failures, load_mission, load_robot,
};
use ambidex::model::MissionSpec;
use serde_json::Value;

use super::Taken;
use crate::corpus;
use crate::mutate::ordered;

/// Where the input stands among the files.
const MISSION: &str = "missions/input.yaml";
const ROBOT: &str = "robots/input.yaml";
const LIBRARY: &str = "behaviors/input.yaml";
const FAILURES: &str = "failures/input.yaml";

static BESIDE: LazyLock<InMemory> = LazyLock::new(corpus::beside);

/// A file with all that is shipped beside it.
pub fn with(path: &str, text: &[u8]) -> InMemory {
    let mut sources = BESIDE.clone();
    sources.insert(path, text.to_vec());
    sources
}

/// A mission file, with all that is shipped beside it.
pub fn mission(text: &[u8]) -> Taken {
    let sources = with(MISSION, text);
    let loaded = load_mission(&sources, MISSION.as_ref(), None, &[]);
    let mut taken = told(loaded.as_ref().map(|loaded| loaded.warnings.as_slice()));
    if let Ok(loaded) = loaded {
        // A log carries the files: whoever reads it has to come to the same.
        let source = loaded.mission.source.clone().expect("what was loaded has a source");
        drop(loaded);
        assert!(files::load_source(&source).is_ok(), "it does not load again from what a log keeps of it");
        taken.accepted = true;
    }
    taken
}

/// The same, loaded once.
pub fn mission_once(text: &[u8]) -> Taken {
    let loaded = load_mission(&with(MISSION, text), MISSION.as_ref(), None, &[]);
    told(loaded.as_ref().map(|loaded| loaded.warnings.as_slice()))
}

/// A robot file, alone and for a mission.
pub fn robot(text: &[u8]) -> Taken {
    let mut sources = with(ROBOT, text);
    let loaded = load_robot(&sources, ROBOT.as_ref());
    let mut taken = told(loaded.as_ref().map(|_| [].as_slice()));
    if loaded.is_ok() {
        sources.insert(MISSION, include_str!("../../../config/missions/experiment-2.yaml"));
        let mission = load_mission(&sources, MISSION.as_ref(), Some(ROBOT.as_ref()), &[]);
        let told = told(mission.as_ref().map(|loaded| loaded.warnings.as_slice()));
        taken.kinds.extend(told.kinds);
    }
    taken
}

/// A file of behaviors and subtrees, alone and included.
pub fn behaviors(text: &[u8]) -> Taken {
    let mut sources = with(LIBRARY, text);
    let checked = check(&sources, LIBRARY.as_ref(), &[]);
    let warnings = checked.as_ref().map(|checked| match checked {
        Checked::Mission(loaded) => loaded.warnings.as_slice(),
        Checked::World(_, warnings) | Checked::Task(_, warnings) => warnings,
        Checked::Robot(_, warnings) | Checked::Library(_, warnings) | Checked::Failures(_, warnings) => warnings,
    });
    let mut taken = told(warnings);
    if let Ok(Checked::Library(names, _)) = &checked {
        let task: String = names.iter().map(|name| format!("    - {}\n", Value::from(name.as_str()))).collect();
        let mission = include_str!("../../../config/missions/experiment-2.yaml");
        let head = &mission[..mission.find("task:").expect("a task")];
        let include = format!("include: [../{LIBRARY}]\n");
        sources.insert(MISSION, format!("{include}{head}task:\n  and:\n    - {{move: shelf}}\n{task}"));
        let mission = load_mission(&sources, MISSION.as_ref(), None, &[]);
        let told = told(mission.as_ref().map(|loaded| loaded.warnings.as_slice()));
        taken.kinds.extend(told.kinds);
    }
    taken
}

/// What goes wrong on purpose.
pub fn failures(text: &[u8]) -> Taken {
    static MISSIONS: LazyLock<[Arc<MissionSpec>; 2]> = LazyLock::new(|| {
        let missions = [
            include_str!("../../../config/missions/experiment-1.yaml"),
            include_str!("../../../config/missions/read-a-label.yaml"),
        ];
        missions.map(|text| loaded(text.as_bytes()).expect("a shipped mission loads").mission)
    });
    let sources = with(FAILURES, text);
    let mut taken = Taken::default();
    for mission in MISSIONS.iter() {
        let loaded = load_failures(&sources, FAILURES.as_ref(), mission);
        let told = told(loaded.as_ref().map(|_| [].as_slice()));
        taken.kinds.extend(told.kinds);
        taken.accepted |= told.accepted;
    }
    taken
}

/// A mission that loads.
pub fn loaded(text: &[u8]) -> Option<Loaded> {
    load_mission(&with(MISSION, text), MISSION.as_ref(), None, &[]).ok()
}

/// The mission of a run, for its own robot if it has one.
pub fn mission_of(run: &Value) -> Option<Arc<MissionSpec>> {
    let mut sources = with(MISSION, ordered::get(run, "mission").map(ordered::text).unwrap_or_default().as_bytes());
    let robot = ordered::get(run, "robot").map(|robot| {
        sources.insert(ROBOT, ordered::text(robot));
        Path::new(ROBOT)
    });
    load_mission(&sources, MISSION.as_ref(), robot, &[]).ok().map(|loaded| loaded.mission)
}

/// What goes wrong in a run, none where it is not to be understood.
pub fn failures_of(run: &Value, mission: &MissionSpec) -> ambidex::model::Failures {
    let failures = ordered::get(run, "failures").map(ordered::text).unwrap_or_default();
    let text = format!("{{\"failures\": {failures}}}");
    load_failures(&with(FAILURES, text.as_bytes()), FAILURES.as_ref(), mission).unwrap_or_default()
}

/// Everything that is said of a file, which has to make sense.
pub fn told(loaded: Result<&[Fault], &FilesError>) -> Taken {
    let mut taken = Taken { accepted: loaded.is_ok(), ..Taken::default() };
    let faults = loaded.unwrap_or_else(|error| {
        assert!(!error.faults().is_empty(), "it is refused and nobody says why: {error}");
        error.faults()
    });
    for fault in faults {
        taken.said(fault.message());
        assert!(fault.message() != "the YAML parser gave up on it", "the YAML parser gave up on it");
        let Some((line, column)) = fault.position() else { continue };
        // A mistake at the end of a file stands behind its last line.
        let letters = fault.text().split('\n').nth(line - 1).map(|line| line.chars().count());
        let letters = letters.expect("a mistake stands on a line of its file");
        assert!(column <= letters + 1, "column {column} of {letters}");
        let bytes = fault.bytes().expect("what has a line has bytes");
        assert!(fault.text().get(bytes).is_some(), "what a mistake is about is no text");
    }
    taken
}
