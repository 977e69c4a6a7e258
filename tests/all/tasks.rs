//! Work for a robot that works already (`semantics` 6, "Tasks that come and go"): what is told of runs, line by line.

use std::collections::BTreeMap;
use std::sync::Arc;

use ambidex::model::{
    Branch, Fragment, Granting, MissionSpec, NodeId, NodeKind, Record, Source, SourceKind, Submission, Time, Topology,
    TreeSpec, Work,
};
use ambidex::replay::Replay;
use ambidex::sim::{self, Event};
use ambidex::tree::Settings;

use crate::lines::{bench, lines};

/// A run of the bench that takes work.
pub fn standing(mission: MissionSpec) -> MissionSpec {
    let mut mission = mission;
    mission.tree = TreeSpec::new(vec![NodeKind::Root, NodeKind::Tasks], Topology::new(vec![NodeId(0); 2]));
    mission.names.nodes = vec!["root".to_owned(), "tasks".to_owned()].into();
    mission
}

/// The task of a mission as a part of another tree.
pub fn fragment(mission: &MissionSpec) -> Fragment {
    let (tree, top) = (&mission.tree, NodeId(1));
    let moved = |node: &NodeId| NodeId(node.0 - 1);
    let nodes: Vec<NodeId> = tree.topology.nodes_below(top).collect();
    let parent = |node: &NodeId| if *node == top { NodeId(0) } else { moved(&tree.topology.parent(*node)) };
    Fragment {
        name: mission.names.node(top).to_owned(),
        nodes: nodes.iter().map(|node| tree.nodes[node.index()].clone()).collect(),
        parents: nodes.iter().map(parent).collect(),
        limits: tree.limits.iter().map(|(node, limits)| (moved(node), *limits)).collect(),
        repeats: tree.repeats.iter().map(|(node, repeat)| (moved(node), *repeat)).collect(),
        priorities: nodes.iter().map(|node| (moved(node), tree.priority(*node))).collect(),
        names: nodes.iter().map(|node| mission.names.node(*node).to_owned()).collect(),
        channels: Vec::new(),
    }
}

/// A part of a tree of the bench, told by its text.
pub fn branch(task: &str) -> Branch {
    told(task, fragment(&bench(task)))
}

/// A part of a tree with the text that it was read from.
pub fn told(task: &str, fragment: Fragment) -> Branch {
    let source = Source {
        kind: SourceKind::Task,
        mission: task.to_owned(),
        robot: None,
        settings: Vec::new(),
        files: Vec::new(),
    };
    Branch { source, fragment: Some(Arc::new(fragment)) }
}

/// Lines of a script: a second, a verb, a name, and behind a colon what comes with it.
struct Script {
    events: Vec<(Time, Event)>,
    /// The top of each part by its name.
    tops: BTreeMap<String, NodeId>,
    next: u32,
}

impl Script {
    fn read(text: &str) -> Self {
        let mut script = Self { events: Vec::new(), tops: BTreeMap::new(), next: 2 };
        text.trim().lines().map(str::trim).for_each(|line| script.take(line));
        script
    }

    fn take(&mut self, line: &str) {
        let (said, with) = line.split_once(": ").unwrap_or((line, ""));
        let mut words = said.split_whitespace();
        let at: f64 = words.next().expect("a second").parse().expect("a number");
        let (verb, name) = (words.next().expect("a verb"), words.next());
        let place = words.next().map(|place| place.parse().expect("a place"));
        let node = |name: Option<&str>| self.tops[name.expect("a name")];
        let task = name.map(|name| self.tops.get(name).copied().unwrap_or(NodeId(999)));
        let work = match verb {
            "submit" | "urgent" | "held" => {
                let priority = (verb == "urgent").then_some(1);
                let granting = if verb == "held" { Granting::Paused } else { Granting::Freely };
                let name = name.expect("a name").to_owned();
                Work::Submit(Box::new(Submission { name, priority, granting, branch: branch(with) }))
            }
            "cancel" => Work::Cancel { task: task.expect("a name") },
            "pause" => Work::Grant { task, granting: Granting::Paused },
            "resume" => Work::Grant { task, granting: Granting::Freely },
            "step" => Work::Grant { task, granting: Granting::Step },
            "add" => {
                let (name, with) = with.split_once(" = ").expect("a name");
                let work = Work::Add { under: task.expect("a name"), behind: place, branch: branch(with) };
                self.name(name, &work);
                work
            }
            "remove" => Work::Remove { node: node(name) },
            "replace" => {
                let (other, with) = with.split_once(" = ").expect("a name");
                let work = Work::Replace { node: node(name), branch: branch(with) };
                self.name(other, &work);
                work
            }
            "stop" => {
                self.events.push((Time((at * 1e6) as u64), Event::Cancel));
                return;
            }
            other => panic!("{other}?"),
        };
        if let Work::Submit(_) = work {
            self.name(name.expect("a name"), &work);
        }
        self.events.push((Time((at * 1e6) as u64), Event::Work(work)));
    }

    /// Names the nodes of a part, as the run will count them.
    fn name(&mut self, name: &str, work: &Work) {
        let fragment = work.branch().and_then(|branch| branch.fragment.clone()).expect("something comes with it");
        self.tops.insert(name.to_owned(), NodeId(self.next));
        for (index, inner) in fragment.names.iter().enumerate().skip(1) {
            self.tops.entry(inner.clone()).or_insert(NodeId(self.next + index as u32));
        }
        self.next += fragment.nodes.len() as u32;
    }
}

/// Runs a script; every decision follows from its log.
#[track_caller]
fn run(mission: MissionSpec, script: &str) -> Vec<Record> {
    let mission = Arc::new(standing(mission));
    let settings = Settings::default();
    let mut records = Vec::new();
    let mut script = Script::read(script).events;
    let last = script.iter().map(|(at, _)| *at).max().unwrap_or_default();
    if !script.iter().any(|(_, event)| *event == Event::Cancel) {
        script.push((last + std::time::Duration::from_secs(100), Event::Cancel));
    }
    sim::simulate(&mission, &settings, script, &mut |record| records.push(record.clone()));
    follows(&mission, &settings, &records);
    records
}

/// Every decision follows from what was told, as the log has it.
#[track_caller]
pub fn follows(mission: &Arc<MissionSpec>, settings: &Settings, records: &[Record]) {
    follows_as_read(mission, settings, records, |task| fragment(&bench(task)));
}

/// The same where tasks are read otherwise than those of the bench.
pub fn follows_as_read(
    mission: &Arc<MissionSpec>,
    settings: &Settings,
    records: &[Record],
    read: impl Fn(&str) -> Fragment + Send + Sync + 'static,
) {
    let mut replay = Replay::new(mission, settings)
        .reading(Arc::new(move |source: &Source, _: &_, _: &_| Some(read(&source.mission))));
    for record in records {
        let line = serde_json::to_string(record).expect("it is plain");
        let read: Record = serde_json::from_str(&line).expect("it reads back");
        replay.take(&read).unwrap_or_else(|difference| panic!("{difference:#?}"));
    }
}

#[track_caller]
fn check(script: &str, expected: &str) {
    let told = lines(&run(bench("set: x"), script));
    let expected: Vec<&str> = expected.trim().lines().map(str::trim).collect();
    assert_eq!(told, expected, "\n{}", told.join("\n"));
}

#[test]
fn tasks_share_the_robot() {
    check(
        "
        0 submit rail: then: [{short: a}, {short: b}]
        0 submit tools: and: [{short: {n: c, of: tool}}, {short: d}]
        9 stop
        ",
        "
        0.00 task rail is submitted: 2 behaviors
        0.00 step 1: a (rail)
        0.00 task tools is submitted: 2 behaviors
        0.00 step 1: c (one)
        2.00 step 2: b (rail)
        4.00 task rail is over: done
        4.00 step 3: d (rail)
        6.00 task tools is over: done
        9.00 canceled",
    );
}

#[test]
fn a_task_that_comes_while_others_run_begins_at_once_where_it_can() {
    check(
        "
        0 submit long: long: a
        1 submit tool: long: {n: b, of: tool}
        3 submit rail: short: c
        20 stop
        ",
        "
        0.00 task long is submitted: 1 behavior
        0.00 step 1: long (rail)
        1.00 task tool is submitted: 1 behavior
        1.00 step 1: tool (one)
        3.00 task rail is submitted: 1 behavior
        10.00 task long is over: done
        10.00 step 2: rail (rail)
        11.00 task tool is over: done
        12.00 task rail is over: done
        20.00 canceled",
    );
}

#[test]
fn what_runs_of_a_canceled_task_is_stopped_and_cleaned_up() {
    check(
        "
        0 submit a: long: a, cleanup: {short: wipe}
        1 submit b: short: b
        2 cancel a
        8 stop
        ",
        "
        0.00 task a is submitted: 2 behaviors
        0.00 step 1: a (rail)
        1.00 task b is submitted: 1 behavior
        2.00 task a is canceled
        2.00 canceled a
        2.00 cleaning up behind a
        2.00 step 2: wipe (rail)
        4.00 task a is over: canceled
        4.00 step 3: b (rail)
        6.00 task b is over: done
        8.00 canceled",
    );
}

#[test]
fn a_paused_task_is_granted_nothing_and_keeps_what_it_has() {
    check(
        "
        0 submit a: then: [{short: a1}, {short: a2}, {short: a3}]
        1 pause a
        5 submit b: short: b
        9 step a
        15 resume a
        20 stop
        ",
        "
        0.00 task a is submitted: 3 behaviors
        0.00 step 1: a1 (rail)
        1.00 task a is paused
        5.00 task b is submitted: 1 behavior
        5.00 step 2: b (rail)
        7.00 task b is over: done
        9.00 task a takes a step
        9.00 step 3: a2 (rail)
        9.00 task a is paused
        15.00 task a goes on
        15.00 step 4: a3 (rail)
        17.00 task a is over: done
        20.00 canceled",
    );
}

#[test]
fn all_tasks_are_held_back_together() {
    check(
        "
        0 pause
        1 submit a: short: a
        1 submit b: short: {n: b, of: tool}
        3 step
        6 submit c: short: c
        9 resume
        20 stop
        ",
        "
        0.00 everything is paused
        1.00 task a is submitted: 1 behavior
        1.00 task b is submitted: 1 behavior
        3.00 everything takes a step
        3.00 step 1: a (rail), b (one)
        3.00 everything is paused
        5.00 task a is over: done
        5.00 task b is over: done
        6.00 task c is submitted: 1 behavior
        9.00 everything goes on
        9.00 step 2: c (rail)
        11.00 task c is over: done
        20.00 canceled",
    );
}

#[test]
fn a_task_that_stalls_waits_beside_a_patrol_that_goes_on() {
    check(
        "
        0 held maker: set: m
        0 submit stuck: never: a
        0 submit patrol: short: p, repeat: forever, every: 5 s
        6 resume maker
        11 stop
        ",
        "
        0.00 task maker is submitted: 1 behavior, paused
        0.00 task stuck is submitted: 1 behavior
        0.00 nothing of stuck can go on: stuck: \"lacking\" does not hold
        0.00 task patrol is submitted: 1 behavior
        0.00 step 1: patrol (rail)
        2.00 patrol is done and begins again at 5.00 s
        5.00 patrol begins again
        5.00 step 2: patrol (rail)
        6.00 task maker goes on
        6.00 step 2: maker
        7.00 patrol is done and begins again at 10.00 s
        7.00 task maker is over: done
        7.00 step 3: stuck
        8.00 task stuck is over: done
        10.00 patrol begins again
        10.00 step 4: patrol (rail)
        11.00 canceled patrol
        11.00 task patrol is over: canceled
        11.00 canceled",
    );
}

#[test]
fn the_more_urgent_task_comes_first_and_takes_what_it_needs() {
    check(
        "
        0 submit low: long: l
        1 urgent high: short: h
        30 stop
        ",
        "
        0.00 task low is submitted: 1 behavior
        0.00 step 1: low (rail)
        1.00 task high is submitted: 1 behavior, priority 1
        1.00 interrupting low for high
        1.00 interrupted low
        1.00 step 2: high (rail)
        3.00 task high is over: done
        3.00 step 3: low (rail)
        13.00 task low is over: done
        30.00 canceled",
    );
}

#[test]
fn live_trees_are_edited() {
    check(
        "
        0 submit a: then: [{short: a1}, {short: a2}, {short: a3}]
        1 add a 2: x = short: x
        1 remove a3
        1 add a 0: y = short: y
        1 remove a1
        3 replace a2: z = short: z
        30 stop
        ",
        "
        0.00 task a is submitted: 3 behaviors
        0.00 step 1: a1 (rail)
        1.00 x is added below a: 1 behavior
        1.00 a3 is taken out of the tree
        1.00 refused: the THEN is beyond that place already
        1.00 refused: a1 runs
        2.00 step 2: a2 (rail)
        3.00 refused: a2 runs
        4.00 step 3: x (rail)
        6.00 task a is over: done
        30.00 canceled",
    );
}

#[test]
fn a_long_waiting_task_comes_before_those_that_came_after_it() {
    // One that needs both tools, while others come all the time that need one.
    let mut script = "0 submit both: pair: both\n".to_owned();
    script = format!("0 submit first: short: {{n: f, of: tool}}\n{script}");
    for second in 0..30 {
        script += &format!("{second} submit t{second}: short: {{n: n{second}, of: tool}}\n");
    }
    let records = run(bench("set: x"), &script);
    let told = lines(&records);
    let place = |what: &str| told.iter().position(|line| line.contains(what)).expect(what);
    let before = told[..place("both (")].iter().filter(|line| line.contains("step")).count();
    assert!(before <= 10, "it waits for 8 grants to later tasks at most:\n{}", told.join("\n"));
}

/// A run that is saved at every moment at which it can be, and gone on with from there, decides the same.
#[test]
fn a_saved_run_goes_on_as_it_was() {
    let mission = Arc::new(standing(bench("set: x")));
    let settings = Settings::default();
    let script = Script::read(
        "
        0 submit a: then: [{short: a1}, {long: a2}, {short: a3}]
        0 submit b: and: [{long: {n: b1, of: tool}}, {pair: b2}], cleanup: {short: wipe}
        1 urgent c: short: c
        2 pause a
        3 held d: set: d
        3 submit e: never: e
        4 add b 0: x = short: {n: x, of: tool}
        6 resume a
        7 submit f: short: f, repeat: 3, every: 4 s
        9 cancel b
        30 resume d
        ",
    );
    let mut records = Vec::new();
    let events = script.events.into_iter().chain([(Time(60_000_000), Event::Cancel)]).collect();
    sim::simulate(&mission, &settings, events, &mut |record| records.push(record.clone()));
    let reader: ambidex::tree::BranchReader =
        Arc::new(|source: &Source, _: &MissionSpec, _: &_| Some(fragment(&bench(&source.mission))));
    let mut replay = Replay::new(&mission, &settings).reading(Arc::clone(&reader));
    let mut saves = 0;
    for (index, record) in records.iter().enumerate() {
        replay.take(record).unwrap_or_else(|difference| panic!("{difference:#?}"));
        let is_turn = matches!(records.get(index + 1), Some(Record::Told { .. } | Record::Turn { .. }));
        let Some(saved) = replay.root().save().filter(|_| is_turn) else { continue };
        let text = serde_json::to_string(&saved).expect("it is plain");
        let read = serde_json::from_str(&text).expect("it reads back");
        assert!(saved == read, "what is saved reads back: {text}");
        let mut other = Replay::new(&mission, &settings).reading(Arc::clone(&reader));
        other.restore(&read).expect("it is of this mission");
        for (at, record) in records.iter().enumerate().skip(index + 1) {
            other.take(record).unwrap_or_else(|difference| panic!("saved at {index}, line {at}: {difference:#?}"));
        }
        saves += 1;
    }
    assert!(saves > 20, "it was saved {saves} times");
}
