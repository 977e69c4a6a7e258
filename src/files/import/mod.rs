//! Files of the dHTT software, the ROS task trees that came before the paper, to missions and robots.
//!
//! Only the form of those files is known here. What cannot be carried over is a warning at its place, and a comment in
//! what is made; and what is made is loaded once before anybody writes it.

mod entry;
mod form;
mod kinds;
mod mission;
mod notes;
mod older;
mod robot;
#[cfg(test)]
mod tests;
mod translate;
mod tree;
mod write;

use std::path::{Path, PathBuf};

use crate::describe::Described;
use crate::document::{MAX_BYTES, SourceSpan};
use crate::fault::{Fault, Faults, FilesError};
use crate::files::Files;
use crate::format::{Format, Mission};
use crate::reader::Item;
use crate::robot::RobotFile;
use crate::sources::Sources;
use crate::whole::{robot_of as robot_in, with_robot};
use ambidex_model::{MissionSpec, NAME_MAX, is_obeyed};
use form::Task;
use mission::Title;
use notes::Note;
use robot::RobotDraft;
use translate::Draft;
use tree::Tree;

/// What a file is called that was made and is not written yet.
const MADE: &str = "what was made of it";

/// What became of a file of the dHTT software.
#[derive(Debug, Clone)]
pub struct Imported {
    /// The mission, or the robot file, as text.
    pub text: String,
    /// A robot file that the mission names and that is not there yet.
    pub beside: Option<Beside>,
    /// Whether the text is a mission; else it is a robot file.
    pub is_mission: bool,
    /// What it is, in a few words.
    pub summary: String,
    /// What is not carried over.
    pub warnings: Vec<Fault>,
    /// How many further warnings there are, which only the comments in the text tell.
    pub unshown: usize,
}

/// A file that belongs beside another.
#[derive(Debug, Clone)]
pub struct Beside {
    /// Where it belongs, beside the mission.
    pub path: PathBuf,
    /// The YAML that is to be written there.
    pub text: String,
}

/// Why nothing was imported.
#[derive(Debug, thiserror::Error)]
pub enum ImportError {
    /// The files have mistakes.
    #[error(transparent)]
    Faulty(FilesError),
    /// The mission would be larger than a file may be.
    #[error("the mission would have {0} bytes, and more than {MAX_BYTES} are not read")]
    TooLarge(usize),
    /// The files are sound, and what was made of them is not.
    #[error("what was made of the file does not load")]
    Defect(#[source] FilesError),
}

/// What a file is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum What {
    Task,
    Robot,
    /// A file of Ambidex.
    Ours(Format),
}

/// A mission before it is text.
struct Made {
    draft: Draft,
    robot: Robot,
}

/// The robot of a mission.
enum Robot {
    /// A file that is there already, and its path.
    There(Box<RobotFile>, PathBuf),
    /// One to be written.
    New(RobotDraft),
}

/// Reads a task file or a robot file of the dHTT software.
///
/// `robot` is the robot for a task: a file of dHTT or of Ambidex; without one a robot is made up. `target` is where the
/// text will be written, from where paths lead; without one that is the current folder.
///
/// # Errors
/// Every mistake in the files.
pub fn import(
    sources: &dyn Sources,
    path: &Path,
    robot: Option<&Path>,
    target: Option<&Path>,
) -> Result<Imported, ImportError> {
    let mut faults = Faults::default();
    let files = Files::alone(sources, path, None, &mut faults);
    let name = file_name(path);
    match files.main().and_then(|main| Some((what(main, &mut faults)?, main))) {
        Some((What::Robot, main)) => {
            if robot.is_some() {
                faults.push((main.span, ""), "this is a robot file, and `--robot` is for task files");
            }
            let draft = RobotDraft::read(main, &name, &stem(path), &mut faults);
            robot_file(sources, draft, faults)
        }
        Some((What::Task, main)) => {
            let draft = task(main, &mut faults);
            let robot = robot_of(sources, robot, &mut faults);
            let made = draft.zip(robot).map(|(draft, robot)| Made { draft, robot });
            mission_file(sources, made, path, target, faults)
        }
        Some((What::Ours(format), main)) => {
            let what = match format {
                Format::Mission => "this is a mission of Ambidex already",
                Format::World => "this is a world of Ambidex already",
                Format::Task => "this is a task of Ambidex already",
                Format::Robot => "this is a robot file of Ambidex already",
                Format::Behaviors => "this is a library of Ambidex already",
                Format::Failures => "this is a failure file of Ambidex already",
            };
            faults.push((main.span, ""), what.to_owned());
            failed(faults)
        }
        None => failed(faults),
    }
}

fn failed(faults: Faults) -> Result<Imported, ImportError> {
    faults.into_result(None::<Imported>).map(|(imported, _)| imported).map_err(ImportError::Faulty)
}

fn what(file: Item<'_>, faults: &mut Faults) -> Option<What> {
    if form::is_task(file) {
        return Some(What::Task);
    }
    if robot::is_robot(file) {
        return Some(What::Robot);
    }
    let ours = Format::of(file).map(What::Ours);
    if ours.is_none() {
        let help = "a task file has `NodeList` and `Nodes`, a robot file has `robot_resources`".to_owned();
        faults.push_with((file.span, ""), "this is no file of the dHTT software", help);
    }
    ours
}

fn task(file: Item<'_>, faults: &mut Faults) -> Option<Draft> {
    let before = faults.errors();
    let task = Task::read(file, faults)?;
    let tree = Tree::of(&task.entries, faults)?;
    (faults.errors() == before).then(|| translate::translate(&task, &tree))
}

fn robot_of(sources: &dyn Sources, path: Option<&Path>, faults: &mut Faults) -> Option<Robot> {
    let Some(path) = path else {
        return Some(Robot::New(RobotDraft::usual()));
    };
    let files = Files::alone(sources, path, None, faults);
    let main = files.main()?;
    match what(main, faults)? {
        What::Robot => RobotDraft::read(main, &file_name(path), &stem(path), faults).map(Robot::New),
        What::Ours(Format::Robot) => robot_in(main, faults).map(|robot| Robot::There(Box::new(robot), path.to_owned())),
        What::Task
        | What::Ours(Format::Mission | Format::World | Format::Task | Format::Behaviors | Format::Failures) => {
            faults.push((main.span, ""), "this is no robot file");
            None
        }
    }
}

/// The warnings of an import that has no mistakes, and how many do not fit among them.
fn warnings(notes: &[Note], mut faults: Faults) -> Result<(Vec<Fault>, usize), ImportError> {
    for note in notes {
        faults.warn((note.span, &note.of), note.message.clone(), note.help.clone());
    }
    let ((), warnings) = faults.into_result(Some(())).map_err(ImportError::Faulty)?;
    let unshown = notes.len().saturating_sub(warnings.len());
    Ok((warnings, unshown))
}

fn robot_file(sources: &dyn Sources, draft: Option<RobotDraft>, faults: Faults) -> Result<Imported, ImportError> {
    let Some(draft) = draft.filter(|_| faults.errors() == 0) else {
        return failed(faults);
    };
    let (warnings, unshown) = warnings(&draft.notes, faults)?;
    let text = draft.text();
    load_robot(sources, &text).map_err(ImportError::Defect)?;
    let summary = format!("a robot of {}", counted(draft.count(), "resource"));
    Ok(Imported { text, beside: None, is_mission: false, summary, warnings, unshown })
}

fn mission_file(
    sources: &dyn Sources,
    made: Option<Made>,
    path: &Path,
    target: Option<&Path>,
    faults: Faults,
) -> Result<Imported, ImportError> {
    let Some(Made { draft, robot }) = made.filter(|_| faults.errors() == 0) else {
        return failed(faults);
    };
    let mut notes = draft.notes.clone();
    let (robot, named, beside) = match robot {
        Robot::There(robot, at) => (*robot, relative(sources, &at, target), None),
        Robot::New(new) => {
            notes.extend(new.notes.iter().cloned());
            let text = new.text();
            let robot = load_robot(sources, &text).map_err(ImportError::Defect)?;
            let name = format!("{}.robot.yaml", whole_stem(target.unwrap_or(path)));
            let at = target.map_or_else(|| PathBuf::from(&name), |target| target.with_file_name(&name));
            (robot, name, Some(Beside { path: at, text }))
        }
    };
    let (warnings, unshown) = warnings(&notes, faults)?;
    let title = Title { file: &file_name(path), mission: &stem(path), robot: &named };
    let text = mission::text(&title, &draft);
    if text.len() as u64 > MAX_BYTES {
        return Err(ImportError::TooLarge(text.len()));
    }
    let mission = load(sources, &text, robot, &draft).map_err(ImportError::Defect)?;
    let behaviors = counted(mission.tree.leaves().count(), "behavior");
    let kinds = counted(draft.kinds.len(), "kind");
    let nodes = counted(mission.tree.nodes.len() - 1, "node");
    let summary = format!("a mission of {nodes}: {behaviors} of {kinds}");
    Ok(Imported { text, beside, is_mission: true, summary, warnings, unshown })
}

fn load_robot(sources: &dyn Sources, text: &str) -> Result<RobotFile, FilesError> {
    let mut faults = Faults::default();
    let files = Files::of_text(sources, MADE, text.to_owned(), &mut faults);
    let robot = files.main().and_then(|main| robot_in(main, &mut faults));
    faults.into_result(robot).map(|(robot, _)| robot)
}

/// Loads a mission that was made, which must be that of the draft.
fn load(sources: &dyn Sources, text: &str, robot: RobotFile, draft: &Draft) -> Result<MissionSpec, FilesError> {
    let mut faults = Faults::default();
    let files = Files::of_text(sources, MADE, text.to_owned(), &mut faults);
    let main = files.main();
    let file = main.and_then(|main| Mission::take(main, &mut faults));
    let mission = file.and_then(|file| with_robot(&files, file, Some(robot), &[], &mut faults));
    let span = main.map_or_else(SourceSpan::default, |main| main.span);
    if let Some(mission) = &mission
        && mission.names.nodes.iter().skip(1).ne(draft.top.names())
    {
        faults.push((span, ""), "its nodes are called otherwise");
    }
    faults.into_result(mission).map(|(mission, _)| mission)
}

/// The name of a file without its folder.
fn file_name(path: &Path) -> String {
    notes::line(&path.file_name().unwrap_or_default().to_string_lossy())
}

/// The same without its ending, and whole: two missions have two robot files.
fn whole_stem(path: &Path) -> String {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    stem.chars().map(|letter| if is_obeyed(letter) { '_' } else { letter }).collect()
}

/// The same without its ending, as a name.
fn stem(path: &Path) -> String {
    let stem = notes::line(&path.file_stem().unwrap_or_default().to_string_lossy());
    let mut end = stem.len().min(NAME_MAX);
    while !stem.is_char_boundary(end) {
        end -= 1;
    }
    match stem[..end].trim() {
        "" => "imported".to_owned(),
        name => name.to_owned(),
    }
}

/// The path of a file from the folder of another, or from the current one.
fn relative(sources: &dyn Sources, file: &Path, from: Option<&Path>) -> String {
    let folder = from.and_then(Path::parent).filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let (Some(file_at), Some(folder)) = (sources.identity(file), sources.identity(folder)) else {
        return file.display().to_string();
    };
    let shared = file_at.iter().zip(folder.iter()).take_while(|(one, other)| one == other).count();
    let up = folder.iter().skip(shared).map(|_| Path::new("..").as_os_str());
    let path: PathBuf = up.chain(file_at.iter().skip(shared)).collect();
    path.display().to_string()
}

fn counted(count: usize, what: &str) -> String {
    if count == 1 { format!("1 {what}") } else { format!("{count} {what}s") }
}
