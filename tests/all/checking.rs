//! `ambidex check`, and that every verb says the same of the same files.

use std::path::Path;

use serde_json::Value;

use crate::fixtures::{HANDS_FULL, experiment_file, file, mission};
use crate::home::Home;

/// A mission with four mistakes and, once they are mended, a warning.
fn wrong(home: &Home) -> std::path::PathBuf {
    let task = "\
objects: {1: {at: shlf}, 2: {at: shelf}}
task:
  and:
    - mve: shelf
    - then: []
    - {move: shelf, timeout: 3 m}
";
    home.write("wrong.yaml", &mission(task))
}

fn lines(stderr: &str, path: &Path) -> Vec<String> {
    let mark = format!("[{}:", path.display());
    let places = stderr.lines().filter_map(|line| line.split_once(&mark));
    places.map(|(_, rest)| rest.trim_end_matches(']').to_owned()).collect()
}

#[test]
fn every_mistake_is_told_at_once_by_every_verb() {
    let home = Home::new();
    let path = wrong(&home);
    let arg = path.to_str().expect("a path in UTF-8");
    let mut said = Vec::new();
    for verb in ["check", "run", "daemon", "simulate"] {
        let finished = home.start([verb, arg]).ends(2);
        assert_eq!(finished.stdout, "", "{verb}");
        assert!(finished.stderr.contains("did you mean `shelf`?"), "{}", finished.stderr);
        assert_eq!(lines(&finished.stderr, &path), ["6:21", "9:7", "10:7", "11:30"], "{}", finished.stderr);
        said.push(finished.stderr);
    }
    assert!(said.iter().all(|other| *other == said[0]));
    home.is_empty();
}

#[test]
fn what_is_surely_not_meant_is_a_warning_to_every_verb() {
    let home = Home::new();
    let path = home.write("full.yaml", &mission(HANDS_FULL));
    let arg = path.to_str().expect("a path in UTF-8");
    let says = |stderr: &str| stderr.contains("must run out") && lines(stderr, &path) == ["8:3"];
    let finished = home.start(["check", arg]).ends(0);
    assert!(says(&finished.stderr), "{}", finished.stderr);
    assert!(finished.stdout.contains("mission small, 11 nodes (6 behaviors) for robot pr2"), "{}", finished.stdout);
    assert!(says(&home.start(["check", "--strict", arg]).ends(2).stderr));
    assert!(says(&home.start(["simulate", arg]).ends(3).stderr));
    assert!(!says(&home.start(["simulate", "--quiet", arg]).ends(3).stderr));
    home.is_empty();
}

#[test]
fn a_list_of_faults_is_for_programs() {
    let home = Home::new();
    let path = wrong(&home);
    let full = home.write("full.yaml", &mission(HANDS_FULL));
    let args = ["check", "--json", path.to_str().expect("UTF-8"), full.to_str().expect("UTF-8")];
    let finished = home.start(args).ends(2);
    assert_eq!(finished.stderr, "");
    let list: Vec<Value> = serde_json::from_str(&finished.stdout).expect("a list");
    let places: Vec<_> = list.iter().map(|fault| (fault["line"].as_u64(), fault["severity"].as_str())).collect();
    let error = |line| (Some(line), Some("error"));
    assert_eq!(places, [error(6), error(9), error(10), error(11), (Some(8), Some("warning"))]);
    assert_eq!(list[1]["key"], "mve");
    assert_eq!(list[1]["message"], "there is no kind of node `mve`");
    assert!(list[1]["help"].as_str().is_some_and(|help| help.starts_with("did you mean `move`?")));
}

#[test]
fn all_shipped_files_are_sound() {
    let home = Home::new();
    let mut files = vec![experiment_file(1)];
    for folder in ["missions", "worlds", "tasks", "robots", "behaviors"] {
        let entries = std::fs::read_dir(file("config").join(folder)).expect("a folder");
        files.extend(entries.map(|entry| entry.expect("an entry").path()));
    }
    let args =
        ["check", "--strict"].map(std::ffi::OsStr::new).into_iter().chain(files.iter().map(|path| path.as_os_str()));
    let finished = home.start(args).ends(0);
    assert_eq!(finished.stderr, "");
    assert_eq!(finished.stdout.lines().count(), files.len());
}

#[test]
fn tasks_are_checked_in_their_world() {
    let home = Home::new();
    let [world, robot] = ["worlds/kitchen.yaml", "robots/pr2.yaml"].map(|name| file("config").join(name));
    let tasks = ["set-the-table", "fetch", "patrol"].map(|name| file("config/tasks").join(format!("{name}.yaml")));
    let base = ["check".as_ref(), "--robot".as_ref(), robot.as_os_str(), "--world".as_ref(), world.as_os_str()];
    let args = [&base[..], &["--strict".as_ref()], &tasks.each_ref().map(|path| path.as_os_str())].concat();
    let finished = home.start(args).ends(0);
    let said: Vec<&str> =
        finished.stdout.lines().filter_map(|line| line.split_once(".yaml: ")).map(|(_, it)| it).collect();
    let expected = [
        "world kitchen, 5 places, 6 objects, for robot pr2",
        "task set the table, 22 nodes (16 behaviors) in world kitchen",
        "task fetch, 5 nodes (4 behaviors) in world kitchen",
        "task patrol, 3 nodes (2 behaviors) in world kitchen",
    ];
    assert_eq!((said.as_slice(), finished.stderr.as_str()), (&expected[..], ""));
    let wrong = home.write("wrong.yaml", "task: {use: {fetch: {object: mgu}}}\n");
    let args = [&base[..], &[wrong.as_os_str()]].concat();
    let words = home.start(&args).ends(2).words();
    assert!(words.contains("there is no object `mgu`") && words.contains("help: did you mean `mug`?"), "{words}");
    // Alone it is a task for a world that nobody knows.
    let finished = home.start(["check".as_ref(), wrong.as_os_str()]).ends(0);
    assert!(finished.stdout.contains("task wrong; what it names is looked up in a world"), "{}", finished.stdout);
    let finished = home.start(["check".as_ref(), "--world".as_ref(), world.as_os_str()]).ends(2);
    assert!(finished.stderr.contains("--robot"), "{}", finished.stderr);
    // A world with mistakes takes no tasks.
    let broken = home
        .write("broken.yaml", "world: {robot: {at: [0, 0]}, places: {a: {stand: [0, 0]}}, objects: {b: {at: c}}}\n");
    let args = ["check".as_ref(), "--robot".as_ref(), robot.as_os_str(), "--world".as_ref(), broken.as_os_str()];
    let finished = home.start([&args[..], &[wrong.as_os_str()]].concat()).ends(2);
    assert!(
        finished.words().contains("there is no place `c`") && !finished.stderr.contains("mgu"),
        "{}",
        finished.stderr
    );
}

#[test]
fn what_is_no_file_is_said_to_be_none() {
    let home = Home::new();
    let nothing = home.write("nothing.yaml", "");
    let finished = home.start(["check", nothing.to_str().expect("UTF-8"), "no/such.yaml", "config"]).ends(2);
    for words in ["found nothing instead of a mission", "cannot read no/such.yaml", "cannot read config"] {
        assert!(finished.stderr.contains(words), "{words}: {}", finished.stderr);
    }
}

#[test]
fn a_file_of_another_format_is_said_to_be_one() {
    let home = Home::new();
    let robot = file("config/robots/pr2.yaml");
    let finished = home.start(["simulate".as_ref(), robot.as_os_str()]).ends(2);
    assert!(finished.stderr.contains("this is a robot, not a mission"), "{}", finished.stderr);
    let mission = experiment_file(1);
    let args = ["controller".as_ref(), "base".as_ref(), "--robot".as_ref(), mission.as_os_str()];
    let finished = home.start(args).ends(2);
    assert!(finished.stderr.contains("this is a mission, not a robot"), "{}", finished.stderr);
    let library = file("config/behaviors/household.yaml");
    let finished = home.start(["simulate".as_ref(), library.as_os_str()]).ends(2);
    assert!(finished.stderr.contains("this is a library, not a mission"), "{}", finished.stderr);
}

#[test]
fn names_do_not_speak_to_the_terminal() {
    let home = Home::new();
    let text = mission("objects: {cup: {at: shelf}}\ntask:\n  move: shelf\n");
    let odd = ["\\e[31m", "\\a", "\\n", "\\x9b", "\\u202e", "\\u2028", "\\u061c"];
    let raw = |text: &str| {
        text.chars().filter(|letter| *letter != '\n' && ambidex::model::is_obeyed(*letter)).collect::<String>()
    };
    for letters in odd {
        for (from, to) in [
            ("mission: small", format!("mission: \"a{letters}b\"")),
            ("mission: small", format!("mission: small\n\"a{letters}b\": 1")),
            ("pr2.yaml", format!("\"a{letters}b.yaml\"")),
            ("shelf: {stand", format!("\"a{letters}b\": {{stand: [1 m, 1 m]}}, shelf: {{stand")),
            ("  places:", format!("  facts: {{\"a{letters}b\": maybe}}\n  places:")),
            ("task:", format!("behaviors: {{\"a{letters}b\": {{potential: 1}}}}\ntask:")),
            ("task:", format!("subtrees: {{\"a{letters}b\": {{task: {{move: \"${{{letters}}}\"}}}}}}\ntask:")),
            ("task:", format!("task: {{\"a{letters}b\": 1}}\n\"task{letters}\":")),
        ] {
            assert!(text.contains(from), "{from} in {text}");
            let path = home.write("odd.yaml", &text.replacen(from, &to, 1));
            let path = path.to_str().expect("UTF-8");
            for args in [vec!["check", path], vec!["check", "--json", path], vec!["simulate", path]] {
                let finished = home.start(&args).ends(2);
                assert_eq!(raw(&finished.stdout) + &raw(&finished.stderr), "", "{to}: {args:?}\n{}", finished.stderr);
            }
        }
    }
    let strange = home.write("a\u{1b}[31m\u{7}b.yaml", &text);
    let finished = home.start(["check", strange.to_str().expect("UTF-8")]).ends(0);
    assert_eq!(raw(&finished.stdout) + &raw(&finished.stderr), "", "{}", finished.stderr);
}
