//! Tasks for a robot that works: what they become against the world as it is, and what is said of them.

mod hostile;
mod shipped;
mod worlds;

use std::sync::Arc;

use super::super::{
    Checked, Fault, FilesError, InMemory, LoadedTask, Setting, check, load_branch, load_mission, load_task,
    load_task_source, load_use, load_world, task_source,
};
use super::{GOOD, PATH, ROBOT, robot, written};
use ambidex_model::{
    BehaviorSpec, ChannelId, Condition, Location, MissionSpec, NodeId, NodeKind, ObjectId, PlaceId, ResourceId,
    SourceKind,
};

const TASK: &str = "tasks/task.yaml";
const WORLD: &str = "\
include: [library.yaml]
behaviors:
  wipe: {label: wipe $at, parameters: {at: place}, claims: {base: {type: base, shared: wiping}}, potential: 1}
subtrees:
  fetch:
    parameters: {object: object, to: {type: place, default: table}}
    task:
      then: [{move: $object}, {pick: $object}, {move: $to}, {place: $object}]
world:
  tolerance: 0.5 m
  robot: {at: [0, 0]}
  places:
    shelf: {stand: [1 m, 2 m]}
    table: {stand: [3, 2]}
  objects:
    cup: {at: shelf}
    pot: {at: table}
  facts: {tidy: false}
";
const LIBRARY: &str = "\
library: small
behaviors:
  tidy: {claims: all, potential: 1, goal: [{fact: tidy}], effects: [{set: tidy}]}
subtrees:
  clean: {parameters: {at: place}, task: {then: [{wipe: $at}, tidy]}}
";

fn files() -> InMemory {
    let mut files = InMemory::default();
    files.insert("robot.yaml", robot(2));
    files.insert("world.yaml", WORLD);
    files.insert("library.yaml", LIBRARY);
    files
}

fn world() -> Arc<MissionSpec> {
    load_world(&files(), "robot.yaml".as_ref(), "world.yaml".as_ref(), &[]).unwrap().mission
}

fn with(task: &str) -> InMemory {
    let mut files = files();
    files.insert(TASK, task);
    files
}

/// A task for the world as it is at the start.
fn load(task: &str, settings: &[&str]) -> Result<LoadedTask, FilesError> {
    let base = world();
    load_task(&with(task), TASK.as_ref(), &all(settings), &base, &base.start)
}

fn all(settings: &[&str]) -> Vec<Setting> {
    settings.iter().map(|setting| setting.parse().expect("a setting")).collect()
}

/// Each fault with its file and line, and what to do.
fn told(faults: &[Fault]) -> Vec<String> {
    let told = |fault: &Fault| {
        let line = fault.position().map_or(0, |(line, _)| line);
        format!("{}:{line}: {fault}; {}", fault.file(), fault.help().unwrap_or_default())
    };
    faults.iter().map(told).collect()
}

fn behavior(loaded: &LoadedTask, node: usize) -> &BehaviorSpec {
    match &loaded.fragment.nodes[node] {
        NodeKind::Behavior(behavior) => behavior,
        other => panic!("no behavior: {other:?}"),
    }
}

#[test]
fn a_task_is_counted_from_its_top() {
    let loaded = load(
        "task:\n  name: all\n  priority: 2\n  and:\n    - {use: {fetch: cup}, timeout: 1 min, repeat: 2}\n    - {wipe: table, \
         priority: 3}\n",
        &[],
    )
    .unwrap();
    let fragment = &loaded.fragment;
    let names =
        ["all", "fetch cup", "move to cup", "pick cup", "move to table", "place cup", "wipe table"].map(str::to_owned);
    assert_eq!((fragment.name.as_str(), fragment.names.as_slice()), ("task", &names[..]));
    assert_eq!(fragment.parents, [0, 0, 1, 1, 1, 1, 0].map(NodeId));
    assert!(matches!(fragment.nodes[..2], [NodeKind::And, NodeKind::Then]));
    assert_eq!(fragment.priorities.iter().map(|(node, told)| (node.0, *told)).collect::<Vec<_>>(), [(0, 2), (6, 3)]);
    assert_eq!(fragment.limits.keys().collect::<Vec<_>>(), [&NodeId(1)]);
    assert_eq!(fragment.repeats[&NodeId(1)].times, Some(2));
    assert_eq!(fragment.channels, ["wiping"], "those of places are there already");
    assert_eq!(behavior(&loaded, 6).claims[0].access.channel(), Some(ChannelId(2)));
    assert_eq!(loaded.source.kind, SourceKind::Task);
}

#[test]
fn the_same_task_alone_is_the_same_mission() {
    let mut files = written(GOOD, ROBOT);
    files.insert("world.yaml", &GOOD[GOOD.find("world:").unwrap()..GOOD.find("task:").unwrap()]);
    let mission = load_mission(&files, PATH.as_ref(), None, &[]).unwrap().mission;
    let base = load_world(&files, "robot.yaml".as_ref(), "world.yaml".as_ref(), &[]).unwrap().mission;
    let loaded = load_task(&files, PATH.as_ref(), &[], &base, &base.start).unwrap();
    assert_eq!(loaded.fragment.name, "good");
    assert_eq!(loaded.fragment.into_tree(), mission.tree);
    assert_eq!(told(&loaded.warnings), [] as [&str; 0]);
}

#[test]
fn a_subtree_of_the_world_needs_no_file() {
    let base = world();
    let settings = all(&["to=shelf", "object=pot"]);
    let loaded = load_use("fetch", &settings, &base, &base.start).unwrap();
    assert_eq!((loaded.fragment.name.as_str(), loaded.fragment.names[0].as_str()), ("fetch pot", "fetch pot"));
    let by_file = load("task: {use: {fetch: {object: pot, to: shelf}}}", &[]).unwrap();
    assert_eq!(by_file.fragment.nodes, loaded.fragment.nodes);
    assert_eq!(load_task_source(&loaded.source, &base, &base.start).unwrap().fragment, loaded.fragment);
    let said = |name: &str, settings: &[&str]| {
        told(load_use(name, &all(settings), &base, &base.start).unwrap_err().faults()).join("\n")
    };
    assert_eq!(
        said("fech", &[]),
        "use: fech:0: use: fech: there is no subtree `fech`; did you mean `fetch`? Allowed: `clean`, `fetch`"
    );
    assert!(said("fetch", &[]).starts_with("world.yaml:6: object: nothing tells an object: `object`; tell it with"));
    assert!(said("fetch", &["object=cub"]).contains("there is no object `cub`; did you mean `cup`?"));
    assert!(said("fetch", &["object=cup", "from=shelf"]).contains("`fetch` has no parameter `from`"));
}

#[test]
fn what_is_wrong_is_told_with_its_place() {
    let said = |task: &str| told(load(task, &[]).unwrap_err().faults()).join("\n");
    let check = |task: &str, expected: &str| assert_eq!(said(task), format!("{TASK}:{expected}"), "{task}");
    check(
        "task:\n  mvoe: shelf\n",
        "2: mvoe: there is no kind of node `mvoe`; did you mean `move`? Allowed: `and`, `or`, `then`, `use`, `move`, `pick`, `place`, `tidy`, `wipe`",
    );
    check(
        "task: {use: {fetch: cub}}\n",
        "1: fetch: there is no object `cub`; did you mean `cup`? Allowed: `cup`, `pot`",
    );
    check(
        "task:\n  use: fech\n",
        "2: use: there is no subtree `fech`; did you mean `fetch`? Allowed: `clean`, `fetch`",
    );
    check(
        "tsak: tidy\n",
        "1: tsak: a task file has no key `tsak`; did you mean `task`? Allowed: `mission`, `robot`, `include`, `parameters`, `behaviors`, `subtrees`, `bypass`, `world`, `task`\ntasks/task.yaml:1: a task file lacks the key `task`; What is to be done.",
    );
    check("library: x\n", "1: this is a library, not a task file; ");
    check("world: {robot: {at: [0, 0]}, places: {a: {stand: [0, 0]}}}\n", "1: this is a world file, not a task file; ");
    let declared = "behaviors: {dust: {potential: 1, precondition: [{fact: dusty}]}}\ntask: dust\n";
    assert!(said(declared).contains("1: fact: there is no fact `dusty`; add `dusty: false` under `facts:`"));
}

#[test]
fn a_world_that_a_task_tells_is_not_used() {
    let own =
        "robot: none.yaml\nworld:\n  robot: {at: [9, 9]}\n  places: {shelf: {stand: [9, 9]}, desk: {stand: [8, 8]}}\n";
    let loaded = load(&format!("{own}task: {{then: [{{move: shelf}}, tidy]}}\n"), &[]).unwrap();
    let Condition::Path { ref stands, .. } = behavior(&loaded, 1).precondition else { panic!("it drives") };
    let stand = stands[0];
    assert_eq!((stand.at.x, stand.at.y), (1.0, 2.0));
    let error = load(&format!("{own}task: {{move: desk}}\n"), &[]).unwrap_err();
    let said = told(error.faults());
    assert!(said[0].starts_with("tasks/task.yaml:2: world: a task is for the world as it is: this one is not used"));
    assert!(said[1].contains("there is no place `desk`"), "{said:?}");
}

#[test]
fn what_the_world_has_may_be_declared_again_if_it_is_the_same() {
    let same = "include: [../library.yaml]\nbehaviors:\n  wipe: {label: wipe $at, parameters: {at: place}, claims: {base: {type: base, shared: \
                wiping}}, potential: 1}\ntask: {use: {clean: shelf}}\n";
    assert_eq!(load(same, &[]).unwrap().fragment.names, ["clean shelf", "wipe shelf", "tidy"]);
    let other = told(load(&same.replace("potential: 1", "potential: 2"), &[]).unwrap_err().faults());
    let help = "the files of the world declare another one: choose another name, or write it as they do";
    assert_eq!(other, [format!("{TASK}:3: wipe: there is a behavior `wipe` already; {help}")]);
    let subtree = "subtrees: {clean: {task: tidy}}\ntask: {use: clean}\n";
    let other = told(load(subtree, &[]).unwrap_err().faults());
    assert!(other[0].contains(&format!("there is a subtree `clean` already; {help}")), "{other:?}");
    // Another text of the same name is another file, and what that declares is compared.
    let mut files = with("include: [library.yaml]\ntask: tidy\n");
    files.insert("tasks/library.yaml", LIBRARY.replace("potential: 1", "potential: 3"));
    let base = world();
    let error = load_task(&files, TASK.as_ref(), &[], &base, &base.start).unwrap_err();
    assert_eq!(error.faults()[0].file(), "tasks/library.yaml");
    assert!(error.faults()[0].message().contains("there is a behavior `tidy` already"));
}

#[test]
fn a_task_brings_what_the_world_does_not_know() {
    let task = "include: [more.yaml]\nsubtrees: {both: {task: {then: [{use: {clean: shelf}}, {use: again}]}}}\ntask: {use: both}\n";
    let mut files = with(task);
    files.insert("tasks/more.yaml", "library: more\nsubtrees: {again: {task: {then: [tidy, tidy]}}}\n");
    let base = world();
    let loaded = load_task(&files, TASK.as_ref(), &[], &base, &base.start).unwrap();
    assert_eq!(loaded.fragment.nodes.len(), 7);
    let kept = load_task_source(&loaded.source, &base, &base.start).unwrap();
    assert_eq!((kept.fragment, kept.source), (loaded.fragment, loaded.source.clone()));
    assert_eq!(task_source(&files, TASK.as_ref(), &[]).unwrap(), loaded.source);
    let cycle = "subtrees: {a: {task: {use: b}}, b: {task: {use: a}}}\ntask: tidy\n";
    assert!(told(load(cycle, &[]).unwrap_err().faults())[0].contains("`a` uses itself: a → b → a"));
}

#[test]
fn parameters_of_a_task_are_told_with_it() {
    let task = "parameters: {what: object}\ntask: {use: {fetch: $what}}\n";
    assert_eq!(load(task, &["what=pot"]).unwrap().fragment.names[0], "fetch pot");
    let said = |settings: &[&str]| told(load(task, settings).unwrap_err().faults()).join("\n");
    assert!(said(&[]).contains("nothing tells an object: `what`"));
    assert!(said(&["what=cup", "wht=cup"]).contains("the task has no parameter `wht`; did you mean `what`?"));
}

#[test]
fn a_task_is_for_the_world_as_it_is_now() {
    let base = world();
    let said = |task: &str, now: &dyn Fn(&mut Vec<Location>)| {
        let mut start = base.start.clone();
        now(&mut start.objects);
        told(&load_task(&with(task), TASK.as_ref(), &[], &base, &start).unwrap().warnings).join("\n")
    };
    let place = "task: {then: [{move: table}, {place: {object: cup, at: table}}]}";
    let at_start: &dyn Fn(&mut Vec<Location>) = &|_| {};
    assert!(said(place, at_start).contains(
        "place cup: it can never run: cup is not held by this branch of the task; nothing in the task makes it so: unless \
         another task does, it fails as it begins"
    ));
    assert_eq!(said(place, &|objects| objects[0] = Location::held(ResourceId(0))), "");
    let fetch = "task: {use: {fetch: cup}}";
    assert_eq!(said(fetch, at_start), "");
    assert!(said(fetch, &|objects| objects[0] = Location::Unknown).contains("pick cup: it can never run"));
    let both = |objects: &mut Vec<Location>| {
        objects[0] = Location::held(ResourceId(0));
        objects[1] = Location::held(ResourceId(1));
    };
    let three = "task: {then: [{move: shelf}, {pick: pot}]}";
    assert!(!said(three, &|objects| objects[0] = Location::held(ResourceId(0))).contains("gripper"));
    let other = "task: {then: [{move: table}, {pick: {object: cup, at: table}}]}";
    assert!(said(other, &both).contains(
        "pick cup: it waits for `gripper`: 2 of 2 hold something now that nothing in the task puts down; it goes on once \
         another task puts that down"
    ));
    let first = "task: {then: [{move: table}, {place: {object: pot, at: table}}, {pick: {object: cup, at: table}}]}";
    assert!(!said(first, &both).contains("gripper"), "{}", said(first, &both));
}

#[test]
fn where_an_object_starts_is_where_it_is_now() {
    let base = world();
    let mut now = base.start.clone();
    now.objects[0] = Location::At(PlaceId(1));
    let files = with("task: {then: [tidy, {pick: cup}]}");
    let loaded = load_task(&files, TASK.as_ref(), &[], &base, &now).unwrap();
    let parts = match &behavior(&loaded, 2).precondition {
        Condition::All(parts) => parts.clone(),
        other => panic!("one condition: {other:?}"),
    };
    assert!(parts.contains(&Condition::Lies(ObjectId(0), PlaceId(1))), "{parts:?}");
}

#[test]
fn of_a_part_nothing_is_said_of_what_stands_around_it() {
    let base = world();
    for task in ["task: {pick: {object: cup, at: shelf}}", "task: {place: {object: cup, at: table}}"] {
        let loaded = load(task, &[]).unwrap();
        let branch = load_branch(&with(task), TASK.as_ref(), &[], &base, &base.start).unwrap();
        assert!(!loaded.warnings.is_empty());
        assert_eq!(told(&branch.warnings), [] as [&str; 0]);
        assert_eq!((&branch.fragment, branch.source.kind), (&loaded.fragment, SourceKind::Branch));
        assert_eq!(load_task_source(&branch.source, &base, &base.start).unwrap().warnings.len(), 0);
    }
    let loose = "task: {and: [{move: shelf}, tidy]}";
    let branch = load_branch(&with(loose), TASK.as_ref(), &[], &base, &base.start).unwrap();
    assert!(told(&branch.warnings)[0].contains("nobody inherits what it keeps"));
}

#[test]
fn alone_a_task_may_use_what_nobody_knows() {
    let said = |task: &str| match check(&with(task), TASK.as_ref(), &[]) {
        Ok(Checked::Task(name, warnings)) => {
            assert_eq!(name, "task");
            told(&warnings).join("\n")
        }
        Ok(other) => panic!("no task: {other:?}"),
        Err(error) => told(error.faults()).join("\n"),
    };
    let parameters = "parameters: {what: {type: object, default: mug}, to: {type: place, default: den}}\n";
    let using = "task: {then: [{use: {bring: {it: $what}}}, {scan: {by: [1, $to]}}, dance, {move: den}]}\n";
    assert_eq!(said(&format!("{parameters}{using}")), "");
    let check = |task: &str, expected: &str| {
        let said = said(task);
        assert!(said.starts_with(&format!("{TASK}:1: {expected}")), "{task}: {said}");
    };
    check("task: {use: {bring: {it: $whta}}}", "it: there is no parameter `whta` here");
    check("task: {scan: $whta}", "scan: there is no parameter `whta` here");
    check("task: {mvoe: den}", "mvoe: there is no kind of node `mvoe`; did you mean `move`?");
    check("task: {and: [pik]}", "and: there is no kind of node `pik`; did you mean `pick`?");
    assert_eq!(
        said("subtrees: {bring: {task: {move: den}}}\ntask: {use: brnig}"),
        format!("{TASK}:2: use: there is no subtree `brnig`; did you mean `bring`?")
    );
    check("task: {then: []}", "then: an empty list");
    check("task: {move: den, then: [{move: den}]}", "task: a node of the task that is 2 things instead of one");
}
