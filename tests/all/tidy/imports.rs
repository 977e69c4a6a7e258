//! What each source file imports of its own crate, and its functions, from its syntax. Tests within it do not count.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use proc_macro2::{TokenStream, TokenTree};
use syn::spanned::Spanned;
use syn::visit::{self, Visit};
use syn::{Attribute, ImplItemFn, ItemFn, ItemMod, ItemUse, TraitItemFn, UseTree, Visibility};

use crate::fixtures::file;

/// A source file of the project.
pub struct Source {
    /// Below the project's folder.
    path: PathBuf,
    pub text: String,
    /// The module that the file is, below its crate.
    pub module: Vec<String>,
    /// Modules and names of the same crate that it takes, as far as they are written.
    pub imports: Vec<Vec<String>>,
    /// First line, name and length of every function, those of tests included.
    pub functions: Vec<(usize, String, usize)>,
    /// Lines that belong to tests, from 1.
    test_lines: Vec<(usize, usize)>,
    /// What a module hands on under its own name: name to the module that has it.
    reexports: BTreeMap<String, Vec<String>>,
}

impl Source {
    pub fn name(&self) -> String {
        self.path.to_string_lossy().into_owned()
    }

    /// Lines with their numbers, without comments and tests.
    pub fn code(&self) -> impl Iterator<Item = (usize, &str)> {
        let lines = self.text.lines().enumerate().map(|(index, line)| (index + 1, line));
        let is_test = |number: usize| self.test_lines.iter().any(|(from, to)| (*from..=*to).contains(&number));
        lines.filter(move |(number, line)| !line.trim_start().starts_with("//") && !is_test(*number))
    }
}

/// The files of a crate that are no tests, what they import resolved to where it is.
pub fn of_crate(name: &str) -> impl Iterator<Item = Source> {
    let mut all = sources(&format!("src/{name}"));
    all.retain(|source| {
        !source.path.components().any(|part| part.as_os_str() == "examples") && !is_test_file(&source.path)
    });
    let known: BTreeMap<Vec<String>, BTreeMap<String, Vec<String>>> =
        all.iter().map(|source| (source.module.clone(), source.reexports.clone())).collect();
    let resolve = |import: &Vec<String>| {
        let mut import = import.clone();
        // Names are handed on from module to module; more often than there are modules would be a circle.
        for _ in 0..8 {
            let Some(end) = (0..import.len()).rev().find(|&end| known.contains_key(&import[..end])) else { break };
            if known.contains_key(&import) {
                break;
            }
            let handed_on = &known[&import[..end]];
            match handed_on.get(&import[end]).or_else(|| handed_on.get("*")) {
                Some(home) => import = [home.clone(), import[end..].to_vec()].concat(),
                None => break,
            }
        }
        import
    };
    let resolved: Vec<_> = all.iter().map(|source| source.imports.iter().map(resolve).collect::<Vec<_>>()).collect();
    std::iter::zip(all, resolved).map(|(source, imports)| Source { imports, ..source })
}

/// Everything of the project in Rust below one of its folders.
pub fn sources(folder: &str) -> Vec<Source> {
    let mut found = Vec::new();
    let mut folders = vec![PathBuf::from(folder)];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(file(folder.to_str().expect("UTF-8"))).expect("a folder of the project") {
            let path = folder.join(entry.expect("an entry").file_name());
            if file(path.to_str().expect("UTF-8")).is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|extension| extension == "rs") {
                found.push(path);
            }
        }
    }
    found.sort();
    found.into_iter().map(read).collect()
}

fn read(path: PathBuf) -> Source {
    let text = std::fs::read_to_string(file(path.to_str().expect("UTF-8"))).expect("a source");
    let syntax = syn::parse_file(&text).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let mut reader = Reader { module: module_of(&path), ..Reader::default() };
    reader.visit_file(&syntax);
    let Reader { module, imports, functions, test_lines, reexports, .. } = reader;
    Source { path, text, module, imports, functions, test_lines, reexports }
}

/// Files that hold nothing but tests, below the project's folder.
fn is_test_file(path: &Path) -> bool {
    let stem = path.file_stem().and_then(|stem| stem.to_str()).unwrap_or_default();
    let is_in_tests = path.components().any(|part| part.as_os_str() == "tests");
    is_in_tests || stem == "tests" || stem.ends_with("_tests") || stem == "sample" || stem == "samples"
}

fn module_of(path: &Path) -> Vec<String> {
    // src/CRATE/module/file.rs
    let parts: Vec<String> = path.with_extension("").iter().map(|part| part.to_string_lossy().into_owned()).collect();
    let module = parts.get(2..).unwrap_or_default();
    module.iter().filter(|part| !["mod", "lib", "main"].contains(&part.as_str())).cloned().collect()
}

#[derive(Default)]
struct Reader {
    module: Vec<String>,
    /// Inline modules around what is read.
    inner: Vec<String>,
    imports: Vec<Vec<String>>,
    functions: Vec<(usize, String, usize)>,
    test_lines: Vec<(usize, usize)>,
    reexports: BTreeMap<String, Vec<String>>,
    tests: usize,
}

impl Reader {
    fn function(&mut self, name: &syn::Ident, span: proc_macro2::Span) {
        let (from, to) = (span.start().line, span.end().line);
        self.functions.push((from, name.to_string(), to + 1 - from));
    }

    /// A path as written, from the crate's root; none for one that leads out of the crate.
    fn absolute(&self, path: &[String], children_count: bool) -> Option<Vec<String>> {
        let here = [self.module.as_slice(), self.inner.as_slice()].concat();
        let supers = path.iter().take_while(|part| *part == "super").count();
        match path.first().map(String::as_str) {
            Some("crate") => Some(path[1..].to_vec()),
            Some("self") => Some([here.as_slice(), &path[1..]].concat()),
            Some("super") => Some([&here[..here.len().checked_sub(supers)?], &path[supers..]].concat()),
            Some(_) if children_count => Some([here.as_slice(), path].concat()),
            _ => None,
        }
    }

    fn take(&mut self, path: &[String]) {
        if self.tests == 0
            && let Some(import) = self.absolute(path, false)
        {
            self.imports.push(import);
        }
    }

    /// Paths within macros are but tokens.
    fn take_tokens(&mut self, tokens: TokenStream) {
        let mut path: Vec<String> = Vec::new();
        let mut colons = 0;
        for token in tokens {
            match token {
                TokenTree::Ident(ident) if path.is_empty() || colons == 2 => path.push(ident.to_string()),
                TokenTree::Punct(punct) if punct.as_char() == ':' && !path.is_empty() && colons < 2 => {
                    colons += 1;
                    continue;
                }
                TokenTree::Group(group) => {
                    self.take(&std::mem::take(&mut path));
                    self.take_tokens(group.stream());
                }
                TokenTree::Ident(ident) => {
                    self.take(&std::mem::take(&mut path));
                    path.push(ident.to_string());
                }
                TokenTree::Punct(_) | TokenTree::Literal(_) => self.take(&std::mem::take(&mut path)),
            }
            colons = 0;
        }
        self.take(&path);
    }
}

impl<'ast> Visit<'ast> for Reader {
    fn visit_item_mod(&mut self, item: &'ast ItemMod) {
        let is_test = is_test(&item.attrs);
        if is_test {
            self.test_lines.push((item.span().start().line, item.span().end().line));
        }
        self.tests += usize::from(is_test);
        self.inner.push(item.ident.to_string());
        visit::visit_item_mod(self, item);
        self.inner.pop();
        self.tests -= usize::from(is_test);
    }

    fn visit_item_use(&mut self, item: &'ast ItemUse) {
        let mut paths = Vec::new();
        flatten(&item.tree, &mut Vec::new(), &mut paths);
        let is_handed_on = !matches!(item.vis, Visibility::Inherited) && self.inner.is_empty();
        for (path, name) in paths {
            match self.absolute(&path, is_handed_on) {
                // What is handed on is imported by whoever takes it.
                Some(whole) if is_handed_on => {
                    let home = whole[..whole.len().saturating_sub(1)].to_vec();
                    self.reexports.insert(name, home);
                }
                _ => self.take(&path),
            }
        }
    }

    // `pub(crate)` takes nothing.
    fn visit_visibility(&mut self, _: &'ast Visibility) {}

    fn visit_path(&mut self, path: &'ast syn::Path) {
        let parts: Vec<String> = path.segments.iter().map(|part| part.ident.to_string()).collect();
        self.take(&parts);
        visit::visit_path(self, path);
    }

    fn visit_macro(&mut self, item: &'ast syn::Macro) {
        self.take_tokens(item.tokens.clone());
        visit::visit_macro(self, item);
    }

    fn visit_item_fn(&mut self, item: &'ast ItemFn) {
        self.function(&item.sig.ident, item.span());
        let is_test = is_test(&item.attrs);
        self.tests += usize::from(is_test);
        visit::visit_item_fn(self, item);
        self.tests -= usize::from(is_test);
    }

    fn visit_impl_item_fn(&mut self, item: &'ast ImplItemFn) {
        self.function(&item.sig.ident, item.span());
        visit::visit_impl_item_fn(self, item);
    }

    fn visit_trait_item_fn(&mut self, item: &'ast TraitItemFn) {
        self.function(&item.sig.ident, item.span());
        visit::visit_trait_item_fn(self, item);
    }
}

fn is_test(attributes: &[Attribute]) -> bool {
    attributes.iter().any(|attribute| {
        let text = attribute.meta.path().get_ident().map(ToString::to_string).unwrap_or_default();
        let tokens = attribute.meta.require_list().map(|list| list.tokens.to_string()).unwrap_or_default();
        text == "test" || text == "cfg" && tokens.split(|c: char| !c.is_alphanumeric()).any(|word| word == "test")
    })
}

/// Every path of a `use`, each with the name under which it is taken.
fn flatten(tree: &UseTree, above: &mut Vec<String>, paths: &mut Vec<(Vec<String>, String)>) {
    match tree {
        UseTree::Path(path) => {
            above.push(path.ident.to_string());
            flatten(&path.tree, above, paths);
            above.pop();
        }
        UseTree::Name(name) => {
            let name = name.ident.to_string();
            let path =
                if name == "self" { above.clone() } else { [above.as_slice(), std::slice::from_ref(&name)].concat() };
            paths.push((path, name));
        }
        UseTree::Rename(rename) => {
            let path = [above.as_slice(), &[rename.ident.to_string()]].concat();
            paths.push((path, rename.rename.to_string()));
        }
        UseTree::Glob(_) => paths.push(([above.as_slice(), &["*".to_owned()]].concat(), "*".to_owned())),
        UseTree::Group(group) => group.items.iter().for_each(|tree| flatten(tree, above, paths)),
    }
}
