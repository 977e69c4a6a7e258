//! The files of a mission: read once each, with everything that they include.

use std::fs::File;
use std::io::{self, ErrorKind, Read};
use std::path::{Path, PathBuf};

use super::document::{self, MAX_BYTES, Node, Spot};
use super::fault::Faults;
use super::kinds::BEHAVIOR;
use super::reader::{Item, Name};
use super::shape::{Form, Shape, optional, required};
use super::task::{NODE, SUBTREE};

/// Most files that one mission includes.
const MAX_FILES: usize = 100;
/// The behaviors of the paper, which are always there.
const PAPER: &str = include_str!("../../config/behaviors/paper.yaml");
/// What they are called in messages.
const PAPER_NAME: &str = "the behaviors of the paper (built in)";

const INCLUDE: Form = Form::List(&Form::Word);
const BEHAVIORS: Form = Form::Each(&Form::Map(&BEHAVIOR));
const SUBTREES: Form = Form::Each(&Form::Map(&SUBTREE));

/// A mission file.
pub(super) static MISSION: Shape = Shape::new(
    "a mission",
    "A task for a robot in a world.",
    &[
        required("mission", "Its name.", Form::Word),
        required("robot", "The path of a robot file, from this file.", Form::Word),
        optional("include", "Paths of files with behaviors and subtrees, from this file.", INCLUDE),
        optional("behaviors", "Kinds of behavior beside `move`, `pick` and `place`.", BEHAVIORS),
        optional("subtrees", "Parts of the task to be used with arguments.", SUBTREES),
        required("world", "Where everything is at the start.", Form::Map(&super::raw::WORLD)),
        required("task", "What is to be done.", Form::Map(&NODE)),
    ],
);

/// A file of behaviors and subtrees.
pub(super) static LIBRARY: Shape = Shape::new(
    "a library",
    "Behaviors and subtrees for any mission that includes them.",
    &[
        required("library", "Its name.", Form::Word),
        optional("include", "Paths of further such files, from this file.", INCLUDE),
        optional("behaviors", "Kinds of behavior.", BEHAVIORS),
        optional("subtrees", "Parts of a task to be used with arguments.", SUBTREES),
    ],
);

/// Files in the order of opening.
#[derive(Debug, Default)]
pub(super) struct Files {
    list: Vec<(PathBuf, Option<Node>)>,
}

impl Files {
    /// The behaviors of the paper, then a file and everything that it includes, each once.
    pub(super) fn with_includes(path: &Path, faults: &mut Faults) -> Self {
        // The file of the paper's behaviors may be checked itself.
        let mut files = match bytes(path) {
            Ok(bytes) if bytes == PAPER.as_bytes() => Self::default(),
            Ok(_) | Err(_) => Self::of_paper(faults),
        };
        files.open(path, None, faults);
        let mut next = files.list.len() - 1;
        while next < files.list.len() {
            let (including, node) = &files.list[next];
            let wanted: Vec<_> =
                includes(node.as_ref()).into_iter().map(|name| (beside(including, &name.value), name)).collect();
            for (path, name) in wanted {
                if files.list.len() > MAX_FILES {
                    faults.push(name.spot, &name.key, format!("more than {MAX_FILES} files"), None);
                    return files;
                }
                let is_known = files.list.iter().any(|(known, _)| is_same(known, &path));
                if !is_known {
                    files.open(&path, Some(&name), faults);
                }
            }
            next += 1;
        }
        files
    }

    /// The behaviors of the paper, then a text that is no file.
    pub(super) fn of_text(name: &str, text: String, faults: &mut Faults) -> Self {
        let mut files = Self::of_paper(faults);
        let node = parse(name, text, faults);
        files.list.push((PathBuf::from(name), node));
        files
    }

    /// A file alone.
    pub(super) fn alone(path: &Path, named: Option<&Name>, faults: &mut Faults) -> Self {
        let mut files = Self::default();
        files.open(path, named, faults);
        files
    }

    fn of_paper(faults: &mut Faults) -> Self {
        let paper = parse(PAPER_NAME, PAPER.to_owned(), faults);
        Self { list: vec![(PathBuf::new(), paper)] }
    }

    fn open(&mut self, path: &Path, named: Option<&Name>, faults: &mut Faults) {
        let node = match bytes(path) {
            Ok(bytes) => parse_bytes(&path.display().to_string(), bytes, faults),
            Err(error) => {
                let message = format!("cannot read {}: {error}", path.display());
                match named {
                    Some(name) => faults.push(name.spot, &name.key, message, None),
                    None => {
                        let file = faults.open(&path.display().to_string(), String::new());
                        faults.push(Spot { file, ..Spot::default() }, "", message, None);
                    }
                }
                None
            }
        };
        self.list.push((path.to_owned(), node));
    }

    /// The file that was asked for: behind the behaviors of the paper, if they are there.
    pub(super) fn main(&self) -> Option<Item<'_>> {
        let (_, node) = self.list.iter().find(|(path, _)| !path.as_os_str().is_empty())?;
        node.as_ref().map(Item::root)
    }

    /// All other files that could be read.
    pub(super) fn libraries(&self) -> impl Iterator<Item = Item<'_>> {
        let main = self.list.iter().position(|(path, _)| !path.as_os_str().is_empty());
        let others = self.list.iter().enumerate().filter(move |(index, _)| Some(*index) != main);
        others.filter_map(|(_, (_, node))| node.as_ref().map(Item::root))
    }
}

/// Where a path in a file leads.
pub(super) fn beside(file: &Path, name: &str) -> PathBuf {
    file.parent().unwrap_or(Path::new("")).join(name)
}

/// What stands under `include`, as far as it is paths; the rest is a fault when the file is read.
fn includes(node: Option<&Node>) -> Vec<Name> {
    let include = node.map(Item::root).and_then(|file| file.value_of("include"));
    let paths = include.iter().flat_map(Item::each);
    let name = |item: Item<'_>| Some(Name { value: item.text()?.to_owned(), key: "include".into(), spot: item.spot });
    paths.filter_map(name).collect()
}

fn is_same(one: &Path, other: &Path) -> bool {
    one == other || one.canonicalize().ok().is_some_and(|one| other.canonicalize().is_ok_and(|other| one == other))
}

fn parse_bytes(name: &str, bytes: Vec<u8>, faults: &mut Faults) -> Option<Node> {
    match String::from_utf8(bytes) {
        Ok(text) => parse(name, text, faults),
        Err(error) => {
            let file = faults.open(name, String::from_utf8_lossy(error.as_bytes()).into_owned());
            let fault = document::not_text(file, error.as_bytes(), error.utf8_error());
            faults.push(fault.spot, "", fault.message, None);
            None
        }
    }
}

fn parse(name: &str, text: String, faults: &mut Faults) -> Option<Node> {
    let file = faults.open(name, text.clone());
    match document::parse(file, &text) {
        Ok(node) => Some(node),
        Err(fault) => {
            faults.push(fault.spot, "", fault.message, None);
            None
        }
    }
}

fn bytes(path: &Path) -> io::Result<Vec<u8>> {
    // To open a pipe is to wait for somebody who writes to it.
    let metadata = path.metadata()?;
    if !metadata.is_file() && !metadata.is_dir() {
        return Err(io::Error::new(ErrorKind::InvalidInput, "it is no regular file"));
    }
    let mut bytes = Vec::new();
    File::open(path)?.take(MAX_BYTES + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > MAX_BYTES {
        return Err(io::Error::new(ErrorKind::FileTooLarge, format!("it is larger than {MAX_BYTES} bytes")));
    }
    Ok(bytes)
}
