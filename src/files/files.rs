//! The files of a mission: each opened once, with everything that they include.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Arc, LazyLock};

use crate::document::{self, MAX_BYTES, Node, PAPER_FILE, SourceSpan};
use crate::fault::{Faults, Source};
use crate::format::INCLUDE;
use crate::reader::{Item, Name};
use crate::sources::Sources;

/// Most files that one mission includes.
const MAX_FILES: usize = 100;
/// The behaviors of the paper, which are always there.
const PAPER: &str = include_str!("../../config/behaviors/paper.yaml");
/// What they are called in messages.
const PAPER_NAME: &str = "the behaviors of the paper (built in)";

/// Files in the order of opening.
pub(crate) struct Files<'s> {
    sources: &'s dyn Sources,
    known: &'s KnownFiles,
    /// The behaviors of the paper, unless they are the file that was asked for, or known.
    paper: Option<Arc<Node>>,
    /// The file that was asked for, then what is included.
    list: Vec<(PathBuf, Option<Arc<Node>>)>,
}

/// Files that were read before: what has the text of one of them is that file, and is not read again.
#[derive(Debug, Default)]
pub(crate) struct KnownFiles {
    /// All that were opened, by number.
    pub(crate) opened: Vec<Arc<Source>>,
    nodes: BTreeMap<usize, Arc<Node>>,
}

/// Where nothing was read before.
pub(crate) static NONE_KNOWN: KnownFiles = KnownFiles { opened: Vec::new(), nodes: BTreeMap::new() };

impl KnownFiles {
    /// The file of a text.
    fn find(&self, text: &str) -> Option<&Arc<Node>> {
        self.nodes.iter().find(|(file, _)| self.opened[**file].text == text).map(|(_, node)| node)
    }

    /// Whether something stands in one of them.
    fn has(&self, span: SourceSpan) -> bool {
        self.nodes.contains_key(&span.file)
    }
}

impl<'s> Files<'s> {
    /// The behaviors of the paper, then a file and everything that it includes, each once.
    pub(crate) fn with_includes(sources: &'s dyn Sources, path: &Path, faults: &mut Faults) -> Self {
        let mut files = Self { sources, known: &NONE_KNOWN, paper: None, list: Vec::new() };
        let content = sources.read(path);
        // The file of the paper's behaviors may be checked itself.
        if content.as_ref().map(Vec::as_slice).ok() != Some(PAPER.as_bytes()) {
            files.paper = paper(faults);
        }
        files.begin(path, content, faults);
        files
    }

    /// A file and everything that it includes beside files that were read before.
    pub(crate) fn beside_known(
        known: &'s KnownFiles,
        sources: &'s dyn Sources,
        path: &Path,
        faults: &mut Faults,
    ) -> Self {
        let mut files = Self { sources, known, paper: None, list: Vec::new() };
        files.begin(path, sources.read(path), faults);
        files
    }

    /// The behaviors of the paper, then a text that is no file.
    pub(crate) fn of_text(sources: &'s dyn Sources, name: &str, text: String, faults: &mut Faults) -> Self {
        let (known, paper) = (&NONE_KNOWN, paper(faults));
        Self { sources, known, paper, list: vec![(PathBuf::from(name), parse(name, text, known, faults))] }
    }

    /// A file without what it includes and without the behaviors of the paper; `named` is where its path stands.
    pub(crate) fn alone(sources: &'s dyn Sources, path: &Path, named: Option<&Name>, faults: &mut Faults) -> Self {
        let mut files = Self { sources, known: &NONE_KNOWN, paper: None, list: Vec::new() };
        files.open(path, named, faults);
        files
    }

    /// The file that was asked for.
    pub(crate) fn main(&self) -> Option<Item<'_>> {
        self.list.first()?.1.as_deref().map(Item::root)
    }

    /// Its number among the files.
    pub(crate) fn main_file(&self) -> usize {
        self.main().map_or(PAPER_FILE, |main| main.span.file)
    }

    /// Whether the file that was asked for was read before.
    pub(crate) fn is_main_known(&self) -> bool {
        self.main().is_some_and(|main| self.known.has(main.span))
    }

    /// All other files that could be read and were not before.
    pub(crate) fn libraries(&self) -> impl Iterator<Item = Item<'_>> {
        let included = self.list.iter().skip(1).filter_map(|(_, node)| node.as_ref());
        let all = self.paper.iter().chain(included).map(|node| Item::root(node));
        all.filter(|file| !self.known.has(file.span))
    }

    /// All of them, to be known where further ones are read.
    pub(crate) fn into_known(self, faults: &Faults) -> KnownFiles {
        let read = self.paper.into_iter().chain(self.list.into_iter().filter_map(|(_, node)| node));
        KnownFiles { nodes: read.map(|node| (node.span.file, node)).collect(), opened: faults.opened().to_vec() }
    }

    /// Whether a file is open already, under this path or another.
    fn find(&self, path: &Path) -> Option<&Option<Arc<Node>>> {
        let identity = self.sources.identity(path);
        let is_same = |known: &Path| known == path || (identity.is_some() && self.sources.identity(known) == identity);
        self.list.iter().find(|(known, _)| is_same(known)).map(|(_, node)| node)
    }

    /// A further file, which may be open already if somebody includes it by mistake.
    pub(crate) fn beside(&self, path: &Path, named: Option<&Name>, faults: &mut Faults) -> Option<Arc<Node>> {
        match self.find(path) {
            Some(open) => open.clone(),
            None => content_of(path, self.sources.read(path), named, self.known, faults),
        }
    }

    fn begin(&mut self, path: &Path, content: std::io::Result<Vec<u8>>, faults: &mut Faults) {
        let main = content_of(path, content, None, self.known, faults);
        self.list.push((path.to_owned(), main));
        self.follow_includes(faults);
    }

    fn open(&mut self, path: &Path, named: Option<&Name>, faults: &mut Faults) {
        let node = content_of(path, self.sources.read(path), named, self.known, faults);
        self.list.push((path.to_owned(), node));
    }

    fn follow_includes(&mut self, faults: &mut Faults) {
        let mut next = 0;
        while let Some((including, node)) = self.list.get(next) {
            let wanted: Vec<_> =
                includes(node.as_deref()).into_iter().map(|name| (beside(including, &name.value), name)).collect();
            for (path, name) in wanted {
                if self.list.len() >= MAX_FILES + usize::from(self.paper.is_none()) {
                    return faults.push(&name, format!("more than {MAX_FILES} files"));
                }
                if self.find(&path).is_none() {
                    self.open(&path, Some(&name), faults);
                }
            }
            next += 1;
        }
    }
}

/// The behaviors of the paper, which are parsed once and stand first among the files.
fn paper(faults: &mut Faults) -> Option<Arc<Node>> {
    static PAPER_NODE: LazyLock<Option<Arc<Node>>> =
        LazyLock::new(|| document::parse(PAPER_FILE, PAPER).ok().map(Arc::new));
    let file = faults.open(PAPER_NAME, PAPER.to_owned());
    assert_eq!(file, PAPER_FILE, "nothing is opened before the behaviors of the paper");
    PAPER_NODE.clone()
}

/// Where a path in a file leads.
pub(crate) fn beside(file: &Path, name: &str) -> PathBuf {
    file.parent().unwrap_or(Path::new("")).join(name)
}

/// What stands under `include`, as far as it is paths; the rest is a fault when the file is read.
fn includes(node: Option<&Node>) -> Vec<Name> {
    let include = node.map(Item::root).and_then(|file| file.value_of(INCLUDE));
    let items = include.iter().flat_map(Item::each);
    let name = |item: Item<'_>| Some(Name { value: item.text()?.to_owned(), key: INCLUDE.into(), span: item.span });
    items.filter_map(name).collect()
}

/// What a file holds; if it cannot be read, that is a fault where it is `named`.
fn content_of(
    path: &Path,
    content: std::io::Result<Vec<u8>>,
    named: Option<&Name>,
    known: &KnownFiles,
    faults: &mut Faults,
) -> Option<Arc<Node>> {
    let shown = path.display();
    let too_large = |bytes: &Vec<u8>| bytes.len() as u64 > MAX_BYTES;
    let message = match content {
        Ok(bytes) if too_large(&bytes) => format!("cannot read {shown}: it is larger than {MAX_BYTES} bytes"),
        Ok(bytes) => return parse_bytes(&shown.to_string(), bytes, known, faults),
        Err(error) => format!("cannot read {shown}: {error}"),
    };
    match named {
        Some(name) => faults.push(name, message),
        None => {
            let file = faults.open(&shown.to_string(), String::new());
            faults.push((SourceSpan { file, ..SourceSpan::default() }, ""), message);
        }
    }
    None
}

fn parse_bytes(name: &str, bytes: Vec<u8>, known: &KnownFiles, faults: &mut Faults) -> Option<Arc<Node>> {
    match String::from_utf8(bytes) {
        Ok(text) => parse(name, text, known, faults),
        Err(error) => {
            let file = faults.open(name, String::from_utf8_lossy(error.as_bytes()).into_owned());
            let fault = document::not_text(file, error.as_bytes(), error.utf8_error());
            faults.push((fault.span, ""), fault.message);
            None
        }
    }
}

fn parse(name: &str, text: String, known: &KnownFiles, faults: &mut Faults) -> Option<Arc<Node>> {
    let text = in_lines(text);
    if let Some(node) = known.find(&text) {
        return Some(Arc::clone(node));
    }
    let file = faults.open(name, text.clone());
    match document::parse(file, &text) {
        Ok(node) => Some(Arc::new(node)),
        Err(fault) => {
            faults.push((fault.span, ""), fault.message);
            None
        }
    }
}

/// YAML takes a carriage return alone for the end of a line too; whoever shows a place in a file counts other ends.
fn in_lines(text: String) -> String {
    if !text.contains('\r') {
        return text;
    }
    let mut rest = text.chars().peekable();
    let mut next = || match rest.next()? {
        '\r' if rest.peek() != Some(&'\n') => Some('\n'),
        letter => Some(letter),
    };
    std::iter::from_fn(&mut next).collect()
}
