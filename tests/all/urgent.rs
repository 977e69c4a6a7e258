//! Urgent work, what must last, and fairness (`semantics` 6): what is told of small missions, line by line.

use ambidex::model::{NodeId, Record, StopCause};
use ambidex::tree::Settings;

use crate::fixtures::{load, mission, simulate};
use crate::home::Home;
use crate::lines::{bench, check, check_mission, lines};

#[test]
fn the_more_urgent_comes_first() {
    check(
        "and: [{long: a}, {short: b, priority: 1}]",
        "",
        "
        0.00 step 1: b (rail)
        2.00 step 2: a (rail)
        12.00 done in 2 steps",
    );
    // What is told of a node holds for all below it that are told nothing.
    check(
        "and: [{long: a}, {then: [{short: b}, {short: c, priority: -1}], priority: 1}]",
        "",
        "
        0.00 step 1: b (rail)
        2.00 step 2: a (rail)
        12.00 step 3: c (rail)
        14.00 done in 3 steps",
    );
}

#[test]
fn the_more_urgent_interrupts() {
    check(
        "and: [ring, {long: a}, {answer: b, priority: 1}]",
        "",
        "
        0.00 step 1: ring, a (rail)
        3.00 interrupting a for b
        3.00 interrupted a
        3.00 step 2: b (rail)
        5.00 step 3: a (rail)
        15.00 done in 3 steps",
    );
    // As urgent is not more urgent.
    check(
        "and: [ring, {long: a, priority: 1}, {answer: b, priority: 1}]",
        "",
        "
        0.00 step 1: ring, a (rail)
        10.00 step 2: b (rail)
        12.00 done in 2 steps",
    );
}

#[test]
fn nobody_takes_what_it_waits_for() {
    // What may not be interrupted ends first; nobody comes between.
    check(
        "and: [ring, {firm: a}, {short: c}, {answer: b, priority: 1}]",
        "",
        "
        0.00 step 1: ring, a (rail)
        10.00 step 2: b (rail)
        12.00 step 3: c (rail)
        14.00 done in 3 steps",
    );
    // It needs the rail and a tool: one tool is given up for it, and kept for it until the rail is free.
    let both = "and: [ring, {firm: a}, {long: {n: t1, of: tool}}, {then: [{short: {n: t2, of: tool}}, {short: {n: t3, of: tool}}]}, {answer_both: b, priority: 1}]";
    check(
        both,
        "",
        "
        0.00 step 1: ring, a (rail), t1 (one), t2 (two)
        2.00 step 2: t3 (two)
        3.00 interrupting t1 for b
        3.00 interrupted t1
        4.00 step 3: t1 (two)
        10.00 step 4: b (rail, one)
        14.00 done in 4 steps",
    );
}

#[test]
fn a_way_that_can_be_gone_interrupts_nobody() {
    let ways = |rest: &str| {
        format!(
            "and: [ring, {{long: a}}{rest}, {{or: [{{answer: w1}}, {{answer: {{n: w2, of: tool}}}}], priority: 1}}]"
        )
    };
    check(
        &ways(""),
        "",
        "
        0.00 step 1: ring, a (rail)
        3.00 step 2: w2 (one)
        10.00 done in 2 steps",
    );
    // One of several wishes of an OR.
    check(
        &ways(", {long: {n: t1, of: tool}}, {long: {n: t2, of: tool}}"),
        "",
        "
        0.00 step 1: ring, a (rail), t1 (one), t2 (two)
        3.00 interrupting a for w1
        3.00 interrupted a
        3.00 step 2: w1 (rail)
        5.00 step 3: a (rail)
        15.00 done in 3 steps",
    );
}

#[test]
fn what_must_last_interrupts_when_it_does_not() {
    check(
        "and: [{then: [ring, {short: {n: c, of: tool}}]}, {quiet: a}]",
        "\n  - {at: 6 s, clear: rang}",
        "
        0.00 step 1: ring, a (rail)
        3.00 step 2: c (one)
        3.00 interrupting a: \"rang\" holds
        3.00 interrupted a
        5.00 nothing can go on before others change \"rang\"
        6.00 \"rang\" holds no more: done on purpose
        6.00 step 3: a (rail)
        16.00 done in 3 steps",
    );
    // It is a precondition too.
    check(
        "then: [ring, {or: [{quiet: a}, {short: b}]}]",
        "",
        "
        0.00 step 1: ring
        3.00 step 2: b (rail)
        5.00 done in 2 steps",
    );
}

#[test]
fn no_thrashing() {
    // Four urgent calls one after the other: each interrupts once.
    let urgent = "{then: [{answer: b1}, {answer: b2}, {answer: b3}, {answer: b4}], priority: 1}";
    let mission = std::sync::Arc::new(bench(&format!("and: [ring, {{long: a}}, {{long: c}}, {urgent}]")));
    let (records, _) = simulate(&mission, &Settings::default(), Vec::new());
    let interrupted = records.iter().filter_map(|record| match record {
        Record::Stopped { leaves, cause: StopCause::Preempted { .. }, .. } => Some(leaves.len()),
        _ => None,
    });
    assert_eq!(interrupted.sum::<usize>(), 1, "{:#?}", lines(&records));
}

/// Two deliveries to the side, both grippers full when somebody urgently wants one.
const DELIVERIES: &str = "\
objects: {a: {at: shelf}, b: {at: shelf}}
  facts: {rang: false}
behaviors:
  ring: {potential: 1, effects: [{set: rang}], takes: 6 s}
  hands: {claims: {it: {type: gripper}}, potential: 1, precondition: [{fact: rang}], takes: 2 s}
  drive: {label: $n, parameters: {n: text}, claims: {it: {type: base}}, potential: 9, precondition: [{fact: rang}], takes: 20 s}
  eyes: {claims: {it: {type: head}}, potential: 1, takes: 10 s, interruptible: false}
  wait: {claims: {it: {type: head}}, potential: 1, takes: 1 s}
task:
";

fn robot(task: &str) -> Vec<String> {
    let home = Home::new();
    let mission = load(&home.write("mission.yaml", &mission(&format!("{DELIVERIES}{task}"))));
    let (records, _) = simulate(&mission, &Settings::default(), Vec::new());
    lines(&records)
}

#[test]
fn who_holds_what_is_wanted_is_as_urgent() {
    let deliver = |object: &str| {
        format!(
            "{{then: [{{move: shelf}}, {{pick: {object}}}, {{move: {{to: table}}, name: bring {object}}}, {{place: {object}}}]}}"
        )
    };
    let task =
        |urgent: &str| format!("  and: [{}, {}, ring, {{drive: elsewhere}}{urgent}]", deliver("a"), deliver("b"));
    let steps = |lines: Vec<String>| -> String {
        let steps = lines.iter().filter_map(|line| line.split_once("step ")).map(|(_, step)| step.to_owned());
        steps.collect::<Vec<_>>().join("\n")
    };
    // The drive has the greater potential.
    assert_eq!(
        steps(robot(&task(""))),
        "1: move to shelf (base), ring\n\
            2: pick a (right_gripper, head, base), pick b (left_gripper, head, base); skipped move to shelf #2\n\
            3: elsewhere (base)\n\
            4: bring a (base)\n\
            5: place a (right_gripper, head, base), place b (left_gripper, head, base); skipped bring b"
    );
    // Somebody who waits for a gripper lends his urgency to those that hold them; none of them interrupts the other.
    assert_eq!(
        steps(robot(&task(", {hands: , priority: 2}"))),
        "1: move to shelf (base), ring\n\
         2: pick a (right_gripper, head, base), pick b (left_gripper, head, base); skipped move to shelf #2\n\
         3: bring b (base)\n\
         4: place a (right_gripper, head, base), place b (left_gripper, head, base); skipped bring a\n\
         5: hands (left_gripper)\n\
         6: elsewhere (base)"
    );
}

#[test]
fn an_idle_intention_gives_way() {
    let task =
        "  and: [{then: [{move: shelf}, {wait: }, {pick: a}]}, {eyes: }, {then: [ring, {drive: urgent}], priority: 1}]";
    assert_eq!(
        robot(task).join("\n"),
        "0.00 attached left_arm\n\
            0.00 attached right_arm\n\
            0.00 attached head\n\
            0.00 attached base\n\
            0.00 step 1: move to shelf (base), eyes (head), ring\n\
            6.00 then 1 gives up base for urgent, which is more urgent\n\
            6.00 step 2: urgent (base)\n\
            10.00 step 3: wait (head)\n\
            26.00 step 4: pick a (right_gripper, head, base)\n\
            29.40 done in 4 steps"
    );
}

/// A mission whose top has tasks for children, the first first.
fn tasks(task: &str, bypass: u32) -> ambidex::model::MissionSpec {
    let mut mission = bench(task);
    mission.tree.tasks = mission.tree.topology.children(NodeId(1)).collect();
    mission.tree.bypass = bypass;
    mission
}

#[test]
fn a_task_that_waits_for_long_has_its_turn() {
    // The first task needs both tools at once, and of the others always one has one.
    let stream = |kind: &str, name: &str| {
        let each = |index: u32| format!("{{{kind}: {{n: {name}{index}, of: tool}}}}");
        format!("{{then: [{}]}}", (1..=5).map(each).collect::<Vec<_>>().join(", "))
    };
    let task = format!(
        "and: [{{then: [{{short: first}}, {{pair: old}}]}}, {}, {}]",
        stream("short", "x"),
        stream("three", "y")
    );
    check_mission(
        tasks(&task, 100),
        &Settings::default(),
        "",
        "
        0.00 step 1: first (rail), x1 (one), y1 (two)
        2.00 step 2: x2 (one)
        3.00 step 3: y2 (two)
        4.00 step 4: x3 (one)
        6.00 step 5: old (one, two)
        8.00 step 6: x4 (one), y3 (two)
        10.00 step 7: x5 (one)
        11.00 step 8: y4 (two)
        14.00 step 9: y5 (one)
        17.00 done in 9 steps",
    );
    check_mission(
        tasks(&task, 2),
        &Settings::default(),
        "",
        "
        0.00 step 1: first (rail), x1 (one), y1 (two)
        2.00 step 2: x2 (one)
        3.00 step 3: y2 (two)
        6.00 step 4: old (one, two)
        8.00 step 5: x3 (one), y3 (two)
        10.00 step 6: x4 (one)
        11.00 step 7: y4 (two)
        12.00 step 8: x5 (one)
        14.00 step 9: y5 (one)
        17.00 done in 9 steps",
    );
}
