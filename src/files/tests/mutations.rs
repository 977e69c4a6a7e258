//! Every key and every value of every shipped file made wrong, one at a time: each is found, on its line.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::super::document::{Node, SourceSpan, Value, parse};
use super::super::{Fault, InMemory, TaskLoader, check, load_world};
use ambidex_model::MissionSpec;

const ROBOT: &str = "robots/pr2.yaml";

/// Keys below which the writer chooses the names: another name is only missed where the old one is used.
const NAMING: [&str; 12] = [
    "places",
    "stands",
    "objects",
    "facts",
    "resources",
    "controllers",
    "behaviors",
    "subtrees",
    "parameters",
    "claims",
    "values",
    "calls",
];
/// Keys of which any word is a good value.
const FREE: [&str; 8] = ["mission", "robot", "library", "label", "name", "type", "shared", "for"];
/// Keys of texts that are looked up only with a world, which a library has none of.
const OF_A_WORLD: [&str; 14] = [
    "fact", "not_fact", "set", "clear", "default", "object", "at", "to", "from", "reaches", "holds", "held", "free",
    "resource",
];

/// One place to make wrong.
#[derive(Debug)]
struct Target {
    span: SourceSpan,
    /// The key above it, and the one above that.
    keys: [String; 2],
    is_key: bool,
}

fn targets(node: &Node, keys: &[String; 2], found: &mut Vec<Target>) {
    match &node.value {
        Value::Null => {}
        Value::Scalar { .. } => found.push(Target { span: node.span, keys: keys.clone(), is_key: false }),
        Value::List(list) => list.iter().for_each(|item| targets(item, keys, found)),
        Value::Map(entries) => {
            for (key, value) in entries {
                found.push(Target { span: key.span, keys: keys.clone(), is_key: true });
                targets(value, &[key.value.clone(), keys[0].clone()], found);
            }
        }
    }
}

/// The shipped files by their paths; those of the paper under other names, since they are always there.
fn shipped() -> BTreeMap<PathBuf, String> {
    let config = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../config");
    let mut files = BTreeMap::new();
    for part in ["missions", "worlds", "tasks", "robots", "behaviors"] {
        for entry in fs::read_dir(config.join(part)).unwrap() {
            let path = entry.unwrap().path();
            let mut text = fs::read_to_string(&path).unwrap();
            if path.ends_with("paper.yaml") {
                for (kind, twin) in
                    [("  move:\n", "  drive:\n"), ("  pick:\n", "  take:\n"), ("  place:\n", "  put:\n")]
                {
                    text = text.replacen(kind, twin, 1);
                }
            }
            files.insert(Path::new(part).join(path.file_name().unwrap()), text);
        }
    }
    files
}

/// Everything that is said of a file: of a world for a robot, of a task in that world.
fn said(files: &InMemory, path: &Path, loader: &mut (Arc<MissionSpec>, TaskLoader)) -> (bool, Vec<Fault>) {
    let (base, loader) = loader;
    let error = match path.parent().and_then(Path::to_str) {
        Some("worlds") => load_world(files, ROBOT.as_ref(), path, &[]).err(),
        Some("tasks") => loader.load_task(files, path, &[], base, &base.start).err(),
        _ => check(files, path, &[]).err(),
    };
    error.map_or((true, Vec::new()), |error| (false, error.faults().to_vec()))
}

fn is_on(faults: &[Fault], file: &Path, line: usize) -> bool {
    let is_here = |fault: &Fault| fault.file() == file.display().to_string();
    faults.iter().any(|fault| is_here(fault) && fault.position().is_some_and(|at| at.0 == line))
}

/// What a target becomes, and whether it may pass unseen.
fn mutants(target: &Target, old: &str, file: &Path) -> Vec<(String, bool)> {
    let [key, above] = target.keys.each_ref().map(String::as_str);
    let is_library = file.parent().is_some_and(|folder| folder.ends_with("behaviors"));
    let misspelt = format!("{}zz", old.trim_end_matches(['"', '\'']));
    if target.is_key {
        return vec![(misspelt, NAMING.contains(&key))];
    }
    let in_world = is_library && (OF_A_WORLD.contains(&key) || old.contains('$'));
    // What uses a subtree may tell another value.
    let is_default = key == "default" && file.starts_with("worlds");
    let is_free = FREE.contains(&key) || in_world || is_default || ["values", "reports"].contains(&above);
    // Each of the others at every fourth value.
    let others = ["[[1]]", "{zz: {zz: 1}}", "[.nan, .inf]", "1e999"];
    let other = others[(target.span.line + target.span.column) % others.len()];
    vec![(misspelt, is_free), (other.into(), false)]
}

#[test]
fn every_mistake_is_found_on_its_line() {
    let shipped = shipped();
    let mut files = InMemory::default();
    shipped.iter().for_each(|(path, text)| files.insert(path, text.as_str()));
    let base = load_world(&files, ROBOT.as_ref(), "worlds/kitchen.yaml".as_ref(), &[]).unwrap().mission;
    let mut loader = (Arc::clone(&base), TaskLoader::new(&base).unwrap());
    let mut missed = Vec::new();
    let mut count = 0;
    for (file, text) in &shipped {
        let (is_sound, faults) = said(&files, file, &mut loader);
        assert!(is_sound, "{}: {faults:?}", file.display());
        let mut found = Vec::new();
        targets(&parse(0, text).unwrap(), &Default::default(), &mut found);
        for target in found {
            let (from, to) = (target.span.offset, target.span.offset + target.span.length);
            let old = &text[from..to];
            for (new, may_pass) in mutants(&target, old, file) {
                count += 1;
                files.insert(file, format!("{}{new}{}", &text[..from], &text[to..]));
                let (is_sound, faults) = said(&files, file, &mut loader);
                let is_seen = is_on(&faults, file, target.span.line);
                let is_named = faults.iter().any(|fault| fault.message().contains(old.trim_start_matches('$')));
                let is_fine = if may_pass { is_sound || is_seen || is_named } else { is_seen };
                if !is_fine {
                    let said: Vec<_> = faults.iter().map(|fault| format!("{:?} {fault}", fault.position())).collect();
                    missed.push(format!("{}:{}: `{old}` -> `{new}`: {said:?}", file.display(), target.span.line));
                }
            }
        }
        files.insert(file, text.as_str());
    }
    assert!(count > 1500, "{count}");
    assert!(missed.is_empty(), "{} of {count}:\n{}", missed.len(), missed.join("\n"));
}
