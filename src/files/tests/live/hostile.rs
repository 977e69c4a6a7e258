//! Tasks that nobody would write: what is too much is refused, whoever sends it.

use super::super::super::{TaskLoader, load_task_source};
use super::{LIBRARY, WORLD, load, told, world};
use ambidex_model::{Source, SourceFile, SourceKind};

fn source(files: Vec<(String, Option<String>, String)>) -> Source {
    let file = |(path, same_as, text)| SourceFile { path, same_as, text };
    let files = files.into_iter().map(file).collect();
    Source { kind: SourceKind::Task, mission: "task.yaml".into(), robot: None, settings: Vec::new(), files }
}

/// What is said of a task that came as texts.
fn said(files: Vec<(String, Option<String>, String)>) -> String {
    let base = world();
    let error = load_task_source(&source(files), &base, &base.start).unwrap_err();
    told(error.faults()).join("\n")
}

fn named(name: &str, text: &str) -> (String, Option<String>, String) {
    (name.to_owned(), None, text.to_owned())
}

#[test]
fn what_is_too_much_of_a_task_is_refused() {
    let doubled: String =
        (0..17).map(|n| format!("  s{n}: {{task: {{and: [{{use: s{0}}}, {{use: s{0}}}]}}}}\n", n + 1)).collect();
    let many = format!("subtrees:\n{doubled}  s17: {{task: tidy}}\ntask: {{use: s0}}\n");
    let first = |task: &str| told(load(task, &[]).unwrap_err().faults())[0].clone();
    assert!(first(&many).contains("more than 10000 nodes"), "{}", first(&many));
    let deep = format!("task: {}tidy{}\n", "{and: [".repeat(70), "]}".repeat(70));
    assert!(first(&deep).contains("nested more than"), "{}", first(&deep));
    let large = format!("task: tidy\n#{}", " ".repeat(1 << 20));
    assert!(first(&large).contains("larger than"), "{}", first(&large));
}

#[test]
fn a_source_is_no_more_than_its_files() {
    assert!(said(Vec::new()).contains("cannot read task.yaml"));
    let chain = |n: usize| named(&format!("{n}.yaml"), &format!("library: l{n}\ninclude: [{}.yaml]\n", n + 1));
    let task = named("task.yaml", "include: [0.yaml]\ntask: tidy\n");
    assert!(said([task].into_iter().chain((0..200).map(chain)).collect()).contains("more than 100 files"));
    // A file that is said to be another is that one, even if that is again said to be another, or is not there.
    let task = named("task.yaml", "include: [a.yaml]\ntask: {use: again}\n");
    let again = ("a.yaml".to_owned(), Some("b.yaml".to_owned()), String::new());
    let library = named("b.yaml", "library: l\nsubtrees: {again: {task: tidy}}\n");
    let base = world();
    let read = source(vec![task.clone(), again.clone(), library]);
    assert_eq!(load_task_source(&read, &base, &base.start).unwrap().fragment.nodes.len(), 1);
    assert!(said(vec![task, again]).contains("found nothing instead of a library"));
    // Neither the robot nor the files of the daemon's world can be read by what is sent.
    let outside = named("task.yaml", "include: [robot.yaml, /etc/hostname]\ntask: tidy\n");
    assert!(said(vec![outside]).contains("cannot read robot.yaml"));
}

#[test]
fn a_task_that_was_refused_leaves_nothing_behind() {
    let base = world();
    let mut loader = TaskLoader::new(&base).unwrap();
    let good = source(vec![named("task.yaml", "task: {use: {clean: shelf}}\n")]);
    let before = loader.load_source(&good, &base, &base.start).unwrap();
    let bad =
        "behaviors: {dust: {potential: 1}, wipe: {potential: 2}}\nsubtrees: {clean: {task: dust}}\ntask: {use: fech}\n";
    for text in [bad, "task: [", LIBRARY, WORLD, ""] {
        assert!(loader.load_source(&source(vec![named("task.yaml", text)]), &base, &base.start).is_err(), "{text}");
    }
    let after = loader.load_source(&good, &base, &base.start).unwrap();
    assert_eq!((before.fragment, told(&before.warnings)), (after.fragment, told(&after.warnings)));
}
