//! `ambidex explain`: what it says of experiment 1 is what the records say.

use ambidex::model::Record;

use super::{printed, refused, simulated};
use crate::fixtures::history;
use crate::home::flat;

#[test]
fn behaviors_of_experiment_1_are_explained() {
    let (home, log) = simulated(1);
    let log = log.to_str().expect("a path");
    let explained = |more: &[&str]| flat(&printed(&home, "explain", log, more));
    let pick = explained(&["pick 3"]);
    for true_thing in [
        "pick 3 (pick in object 3)",
        "rounds 1 to 11 0.00 s It is not asked: its turn comes after move 3-1.",
        "It starts with potential 9.000 and has right_gripper alone, base and head for \"at sink\".",
        "place 2 starts with it.",
        "It is done after 4.12 s. object 3 is in right_gripper now.",
    ] {
        assert!(pick.contains(true_thing), "{true_thing}: {pick}");
    }
    let skipped = explained(&["move 1-1"]);
    for true_thing in [
        "It waits: outbid by move 2-1 for base (0.502 against 0.490).",
        "round 2 0.00 s It waits: base is in use by move 2-1.",
        "It is skipped: its goal is met already, and pick 1 goes on from there.",
    ] {
        assert!(skipped.contains(true_thing), "{true_thing}: {skipped}");
    }
    let kept = explained(&["move 3-1", "--round", "3"]);
    let why = "It waits: base is kept for \"at shelf\" by object 2, for what comes after move 2-1.";
    assert!(kept.contains(why) && !kept.contains("round 4"), "{kept}");
    let part = explained(&["object 4"]);
    assert!(part.contains("object 4 (then in the task) It asked for resources in"), "{part}");
    assert!(["move 4-1", "pick 4", "move 4-2", "place 4"].iter().all(|leaf| part.contains(leaf)), "{part}");
}

#[test]
fn the_story_of_a_run_has_its_steps_and_skips_on_a_page() {
    for number in 1..=4 {
        let (home, log) = simulated(number);
        let text = printed(&home, "explain", log.to_str().expect("a path"), &[]);
        let records = ambidex::record::Reader::open(&log).expect("a log");
        let records: Vec<Record> = records.map(|record| record.expect("a record")).collect();
        let history = history(&records);
        let names = history.names();
        let story = flat(&text);
        for step in history.steps() {
            let mut leaves: Vec<&str> = step.leaves.iter().map(|leaf| names.node(*leaf)).collect();
            let last = leaves.pop().expect("no step is empty");
            let starts = match leaves.as_slice() {
                [] => format!("● {last} starts with"),
                others => format!("● {} and {last} start together.", others.join(", ")),
            };
            assert!(story.contains(&starts), "{starts}\n{text}");
        }
        for (leaf, _) in history.skipped() {
            let skipped = format!("◇ {} is skipped: its goal is met already.", names.node(leaf));
            assert!(story.contains(&skipped), "{skipped}\n{text}");
        }
        assert!(story.ends_with("The mission is over: done."), "{text}");
        assert!(text.lines().count() <= 60, "{text}");
    }
}

#[test]
fn a_pattern_explains_every_behavior_that_it_matches() {
    let (home, log) = simulated(1);
    let log = log.to_str().expect("a path");
    let each = |name: &str| printed(&home, "explain", log, &[name]);
    assert_eq!(each("pick [12]"), format!("{}\n{}", each("pick 1"), each("pick 2")));
    assert_eq!(each("object ?").matches(" (then in the task)").count(), 4);
}

#[test]
fn unknown_names_and_rounds_are_told_with_what_there_is() {
    let (home, log) = simulated(1);
    let log = log.to_str().expect("a path");
    let said = refused(&home, "explain", log, &["pik 2"]);
    assert!(said.contains("there is no node `pik 2`") && said.contains("did you mean `pick 2`?"), "{said}");
    let said = refused(&home, "explain", "pick 2", &[]);
    assert!(said.contains("there is no log `pick 2`") && said.contains("name the log first"), "{said}");
    let said = refused(&home, "explain", log, &["pik*"]);
    assert!(said.contains("there is no node `pik*`") && said.contains("allowed: `root`"), "{said}");
    let said = refused(&home, "explain", log, &["pick 2", "--round", "99"]);
    assert!(said.contains("there is no round 99") && said.contains("the log has rounds 1 to 23"), "{said}");
}
