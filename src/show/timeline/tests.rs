//! Folding of odd courses, and what a picture of them shows.

use crate::sample::{self, decided, grant, history, named, released, seconds};
use ambidex_model::*;

use ambidex_record::{History, Phase};

use super::{compare, picture, rows};
use crate::svg::fit::{self, CHANNEL};
use crate::svg::page::{MARGIN, PAGE_WIDTH};
use crate::tree;

fn header() -> Record {
    Record::Header(Box::new(sample::header()))
}

fn phases(history: &History, name: &str) -> Vec<(f64, Phase)> {
    rows::stretches(history, named(name)).map(|stretch| (stretch.from.seconds(), stretch.phase)).collect()
}

fn failed_for_good(at_s: f64, name: &str, top: &str) -> Record {
    let (end, consequences) = (
        End::Failed(Fault::TimedOut),
        Consequences { completed: None, failed: Some(named(top)), failing: None, cleaned: None },
    );
    Record::Released {
        at: seconds(at_s),
        leaf: named(name),
        end,
        consequences,
        changes: Vec::new(),
        waits_until: None,
        unfit: Vec::new(),
    }
}

fn lease(holder: &str, hold: &str) -> serde_json::Value {
    let holder = named(holder);
    serde_json::json!({"holder": holder, "behavior": holder, "kind": hold, "from": null})
}

/// The state of a resource as a journal has it, shared on channel 0.
fn shared(at_s: f64, leases: &[serde_json::Value]) -> Record {
    let access = if leases.is_empty() { serde_json::Value::Null } else { serde_json::json!({"shared": 0}) };
    let state = serde_json::from_value(serde_json::json!({"access": access, "leases": leases})).unwrap();
    Record::Resource { at: seconds(at_s), resource: ResourceId(0), state }
}

#[test]
fn a_plain_course_is_waiting_active_done() {
    let history = history(&sample::experiment_1());
    assert_eq!(phases(&history, "pick 1"), [(0.0, Phase::Waiting), (7.4, Phase::Active), (13.5, Phase::Done)]);
    assert_eq!(phases(&history, "move 1-1"), [(0.0, Phase::Waiting), (7.4, Phase::Skipped)]);
    assert_eq!(history.last_moment(), seconds(77.7));
    assert_eq!(history.steps().len(), 10);
}

#[test]
fn what_fails_waits_again_until_it_fails_for_good() {
    let again = Fault::Aborted(ControllerId(2));
    let history = history(&[
        header(),
        decided(1.0, 1, vec![grant("move 1-1", &[], &[0], &[])]),
        released(2.0, "move 1-1", End::Failed(again)),
        decided(2.0, 2, vec![grant("move 1-1", &[], &[0], &[])]),
        failed_for_good(4.0, "move 1-1", "object 1"),
    ]);
    let retry = Phase::Failed { fault: again, is_final: false };
    let end = Phase::Failed { fault: Fault::TimedOut, is_final: true };
    let course = [(0.0, Phase::Waiting), (0.0, Phase::Active), (1.0, retry), (1.0, Phase::Active), (3.0, end)];
    assert_eq!(phases(&history, "move 1-1"), course);
    assert_eq!(phases(&history, "place 1"), [(0.0, Phase::Waiting), (3.0, Phase::NotAsked)]);
    assert_eq!(phases(&history, "place 2"), [(0.0, Phase::Waiting)], "another line waits on");
}

#[test]
fn what_is_reopened_is_not_done_any_more() {
    let (node, up_to) = (named("move 1-1"), named("object 1"));
    let reopened = Reopened::new(node, up_to, Cause::Redo { leaf: node });
    let back = Record::Decided {
        at: seconds(5.0),
        round: 2,
        granted: vec![],
        refused: vec![],
        reopened: Some(reopened),
        deadlines: Vec::new(),
        urged: None,
        overdue: None,
    };
    let history = history(&[
        header(),
        decided(0.0, 1, vec![grant("move 1-1", &[], &[0], &[])]),
        released(3.0, "move 1-1", End::Succeeded),
        back,
        decided(6.0, 3, vec![grant("move 1-1", &[], &[0], &[])]),
        released(8.0, "move 1-1", End::Canceled),
    ]);
    let course = [
        (0.0, Phase::Waiting),
        (0.0, Phase::Active),
        (3.0, Phase::Done),
        (5.0, Phase::Reopened),
        (6.0, Phase::Active),
        (8.0, Phase::Canceled),
    ];
    assert_eq!(phases(&history, "move 1-1"), course);
    let drawn = picture(&history);
    assert!(drawn.contains("not done any more") && drawn.contains("canceled"), "{drawn}");
}

#[test]
fn leases_at_one_time_never_share_a_track() {
    let (one, other) = (lease("pick 1", "running"), lease("pick 2", "running"));
    let kept = lease("pick 2", "physical");
    let history = history(&[
        header(),
        decided(0.0, 1, vec![grant("pick 1", &[0], &[], &[])]),
        shared(0.0, &[lease("move 1-1", "intention")]),
        shared(0.0, std::slice::from_ref(&one)),
        shared(1.0, &[one, other.clone()]),
        shared(2.0, std::slice::from_ref(&other)),
        shared(3.0, std::slice::from_ref(&kept)),
        shared(4.0, &[kept, lease("pick 3", "running")]),
        shared(5.0, &[]),
    ]);
    let lane = &history.lanes()[0];
    let mut leases: Vec<_> = lane
        .leases()
        .map(|held| (held.track, held.from.seconds(), held.to.map(Time::seconds), held.lease.behavior))
        .collect();
    leases.sort_by(|one, other| (one.0, one.1).partial_cmp(&(other.0, other.1)).unwrap());
    let expected = [
        (0, 0.0, Some(2.0), named("pick 1")),
        (0, 3.0, Some(5.0), named("pick 2")),
        (1, 1.0, Some(3.0), named("pick 2")),
        (1, 4.0, Some(5.0), named("pick 3")),
    ];
    assert_eq!(leases, expected, "what came and went at one moment is not among them");
    assert_eq!(lane.channels(), [(ChannelId(0), seconds(0.0), Some(seconds(5.0)))], "one channel throughout");
}

#[test]
fn records_of_things_that_no_header_names_do_no_harm() {
    let mut strange = grant("pick 1", &[0], &[], &[]);
    std::sync::Arc::make_mut(&mut strange.request).leaf = NodeId(999);
    let records = [
        header(),
        shared(0.0, &[]),
        decided(0.0, 1, vec![strange]),
        Record::Resource { at: seconds(1.0), resource: ResourceId(77), state: Resource::default() },
        decided(1.0, 2, vec![grant("pick 1", &[0], &[], &[])]),
    ];
    for count in 1..=records.len() {
        let history = history(&records[..count]);
        for drawn in [picture(&history), compare(&history, &history)] {
            roxmltree::Document::parse(&drawn).unwrap();
        }
    }
}

#[test]
fn a_run_that_goes_on_says_so() {
    let history = history(&sample::experiment_1()[..5]);
    let drawn = picture(&history);
    assert!(drawn.contains("the log ends before the mission did, at"), "{drawn}");
    assert!(drawn.contains("still when the log ends"), "{drawn}");
}

#[test]
fn a_tree_shows_the_states_of_its_leaves() {
    let records = sample::experiment_1();
    let drawn = tree::picture(&sample::header(), Some(&history(&records)));
    assert_eq!(drawn.matches(">move 1-1 (move): skipped<").count(), 1);
    assert_eq!(drawn.matches(": done<").count(), 13);
    assert_eq!(drawn.matches(": all children, in order; done<").count(), 4, "a THEN has a state as well");
    assert!(!tree::picture(&sample::header(), None).contains(">skipped<"));
}

/// Texts of a class with their places.
fn texts(drawn: &str, class: &str) -> Vec<(f64, String)> {
    let document = roxmltree::Document::parse(drawn).unwrap();
    let is_wanted = |node: &roxmltree::Node| {
        node.has_tag_name("text")
            && node.attribute("class").is_some_and(|classes| classes.split(' ').any(|one| one == class))
    };
    let place =
        |node: roxmltree::Node| (node.attribute("x").unwrap().parse().unwrap(), node.text().unwrap().to_owned());
    document.descendants().filter(is_wanted).map(place).collect()
}

#[test]
fn names_of_channels_stay_within_their_lane_and_short_leases_have_short_labels() {
    let mut records = sample::experiment_1();
    records.truncate(records.len() - 1);
    records.push(shared(76.0, &[lease("place 4", "running")]));
    records.push(shared(77.6, &[]));
    records.extend([decided(77.7, 11, vec![grant("pick 1", &[], &[], &[])]), released(80.0, "pick 1", End::Succeeded)]);
    let drawn = picture(&history(&records));
    let names = texts(&drawn, "channel-name");
    let [(x, name)] = names.as_slice() else { panic!("one channel: {names:?}") };
    let right = PAGE_WIDTH - MARGIN - 8.0;
    assert!(name == "at shelf" && x + fit::width(name, CHANNEL) <= right + 0.01, "{names:?}");
    let labels: Vec<String> = texts(&drawn, "inner-active").into_iter().map(|(_, label)| label).collect();
    assert_eq!(labels, ["p4"], "place 4 has no room");
}

#[test]
fn a_legend_explains_what_can_be_seen() {
    let legend = |records: &[Record]| {
        let drawn = picture(&history(records));
        let legend = drawn.split("class=\"legend\"").nth(1).unwrap().to_owned();
        let explained =
            |words: &&str| legend.contains(&format!("\n{words}\n")) || legend.contains(&format!(">{words}<"));
        ["inactive", "active, uses the resource", "done", "skipped", "step begins", "round"]
            .into_iter()
            .filter(explained)
            .collect::<Vec<_>>()
    };
    assert_eq!(legend(&[header()]), Vec::<&str>::new());
    let begun = [header(), decided(0.0, 1, vec![grant("pick 1", &[], &[], &[])]), decided(2.0, 2, vec![])];
    assert_eq!(legend(&begun), ["inactive", "active, uses the resource", "step begins", "round"]);
}
