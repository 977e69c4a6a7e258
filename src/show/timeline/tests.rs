//! Folding of odd courses, and what a picture of them shows.

use crate::sample::{self, decided, grant, history, named, released, seconds};
use ambidex_model::*;

use ambidex_record::{History, Phase};

use super::{compare, picture, rows};
use crate::tree;

fn header() -> Record {
    Record::Header(Box::new(sample::header()))
}

fn phases(history: &History, name: &str) -> Vec<(f64, Phase)> {
    rows::stretches(history, named(name)).map(|stretch| (stretch.from.seconds(), stretch.phase)).collect()
}

fn failed_for_good(at_s: f64, name: &str, top: &str) -> Record {
    let (end, consequences) =
        (End::Failed(Fault::TimedOut), Consequences { completed: None, failed: Some(named(top)) });
    Record::Released { at: seconds(at_s), leaf: named(name), end, consequences, changes: Vec::new() }
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
    let reopened = Reopened { holder: named("object 1"), leaf: named("move 1-1"), lapsed: None, lacks: None };
    let back =
        Record::Decided { at: seconds(5.0), round: 2, granted: vec![], refused: vec![], reopened: Some(reopened) };
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
    assert!(!tree::picture(&sample::header(), None).contains(">skipped<"));
}
