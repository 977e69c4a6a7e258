//! Cleanups (`semantics` 6): what is told of small missions, line by line.

use std::time::Duration;

use ambidex::tree::Settings;

use crate::lines::{bench, check, check_mission};

/// The behavior `f` never ends by itself.
const HANGS: &str = "\n  - {behavior: f, attempt: every, hangs: true}";

fn canceled_at(second: u32) -> String {
    format!("\n  - {{at: {second} s, cancel: true}}")
}

#[test]
fn a_cleanup_comes_when_its_body_has_failed_for_good() {
    check(
        "then: [{short: a}, {once: f}], cleanup: {short: t}",
        HANGS,
        "
        0.00 step 1: a (rail)
        2.00 step 2: f (rail)
        6.00 failed f: it took too long
        6.00 cleaning up behind \"then\"
        6.00 step 3: t (rail)
        8.00 failed at f",
    );
    // Behind all retries, of the behavior and of the node.
    check(
        "then: [{short: a}, {once: f, retries: 1}], retries: 1, cleanup: {short: t}",
        HANGS,
        "
        0.00 step 1: a (rail)
        2.00 step 2: f (rail)
        6.00 failed f: it took too long
        6.50 f asks again
        6.50 step 3: f (rail)
        10.50 failed f: it took too long
        10.50 \"then\" is tried again at 11.00 s, since it failed: it took too long
        11.00 then asks again
        11.00 step 4: a (rail)
        13.00 step 5: f (rail)
        17.00 failed f: it took too long
        17.50 f asks again
        17.50 step 6: f (rail)
        21.50 failed f: it took too long
        21.50 cleaning up behind \"then\"
        21.50 step 7: t (rail)
        23.50 failed at f",
    );
    // Not where nothing was begun, and not where all went well.
    check(
        "then: [{never: n}, {short: a}], cleanup: {short: t}",
        "",
        "
        0.00 n can never run: \"lacking\" does not hold; with it the task fails
        0.00 failed at n",
    );
    check(
        "then: [{short: a}], cleanup: {short: t}",
        "",
        "
        0.00 step 1: a (rail)
        2.00 done in 1 step",
    );
}

#[test]
fn inner_ones_come_first() {
    let task = "then: [{short: a, cleanup: {short: done}}, {then: [{short: b}, {once: f}], cleanup: {short: inner}}], cleanup: {short: outer}";
    check(
        task,
        HANGS,
        "
        0.00 step 1: a (rail)
        2.00 step 2: b (rail)
        4.00 step 3: f (rail)
        8.00 failed f: it took too long
        8.00 cleaning up behind then 2
        8.00 step 4: inner (rail)
        10.00 done inner
        10.00 cleaning up behind then 1
        10.00 step 5: outer (rail)
        12.00 failed at f",
    );
}

#[test]
fn a_canceled_sibling_cleans_up_before_the_next_way() {
    let task =
        "or: [{and: [{once: f}, {then: [{long: {n: l, of: tool}}, {short: s}], cleanup: {short: t}}]}, {short: other}]";
    check(
        task,
        HANGS,
        "
        0.00 step 1: f (rail), l (one)
        4.00 failed f: it took too long
        4.00 canceled l
        4.00 cleaning up behind \"then\"
        4.00 step 2: t (rail)
        6.00 step 3: other (rail)
        8.00 done in 3 steps",
    );
}

#[test]
fn a_way_that_is_left_is_cleaned_up() {
    let task = "or: [{then: [{short: a}, {answer: n}], cleanup: {short: t}, name: way}, {short: other}]";
    check(
        task,
        "",
        "
        0.00 step 1: a (rail)
        2.00 way with cleanup is to be left, and what was begun is cleaned up first
        2.00 cleaning up behind way
        2.00 step 2: t (rail)
        4.00 the task leaves way with cleanup, in which nothing can go on
        4.00 step 3: other (rail)
        6.00 done in 3 steps",
    );
}

#[test]
fn what_takes_too_long_is_cleaned_up() {
    check(
        "then: [{short: a}, {long: b}], timeout: 5 s, cleanup: {short: t}",
        "",
        "
        0.00 step 1: a (rail)
        2.00 step 2: b (rail)
        5.00 \"then\" took too long; what runs of \"then\" is canceled
        5.00 canceled b
        5.00 cleaning up behind \"then\"
        5.00 step 3: t (rail)
        7.00 failed at then",
    );
}

#[test]
fn a_canceled_mission_cleans_up() {
    let task = "then: [{short: a}, {long: b}], cleanup: {then: [{short: t}, {short: u}]}";
    check(
        task,
        &canceled_at(5),
        "
        0.00 step 1: a (rail)
        2.00 step 2: b (rail)
        5.00 the mission is to end, and what it has begun is cleaned up first
        5.00 canceled b
        5.00 cleaning up behind then 1
        5.00 step 3: t (rail)
        7.00 step 4: u (rail)
        9.00 canceled",
    );
    // All together have a grace, and what runs then is stopped.
    let settings = Settings { cleanup_grace: Duration::from_secs(3), ..Settings::default() };
    check_mission(
        bench(task),
        &settings,
        &canceled_at(5),
        "
        0.00 step 1: a (rail)
        2.00 step 2: b (rail)
        5.00 the mission is to end, and what it has begun is cleaned up first
        5.00 canceled b
        5.00 cleaning up behind then 1
        5.00 step 3: t (rail)
        7.00 step 4: u (rail)
        8.00 canceled u
        8.00 canceled",
    );
}

#[test]
fn what_cannot_be_granted_is_over() {
    check(
        "then: [{short: a}, {long: b}], cleanup: {then: [{short: t}, {never: n}]}",
        &canceled_at(5),
        "
        0.00 step 1: a (rail)
        2.00 step 2: b (rail)
        5.00 the mission is to end, and what it has begun is cleaned up first
        5.00 canceled b
        5.00 cleaning up behind then 1
        5.00 step 3: t (rail)
        7.00 cannot clean up behind then 1
        7.00 canceled",
    );
    // Nor is it done where all of it is satisfied.
    check(
        "then: [{set: a}, {long: b}], cleanup: {set: t}",
        &canceled_at(5),
        "
        0.00 step 1: a
        1.00 step 2: b (rail)
        5.00 the mission is to end, and what it has begun is cleaned up first
        5.00 canceled b
        5.00 cleaning up behind \"then\"
        5.00 there is nothing to clean up behind \"then\"
        5.00 canceled",
    );
}

#[test]
fn nothing_else_begins_meanwhile() {
    let task = "and: [{then: [{short: a}, {long: b}], cleanup: {long: t}}, {then: [{long: {n: c, of: tool}}, {short: {n: d, of: tool}}]}]";
    check(
        task,
        &canceled_at(5),
        "
        0.00 step 1: a (rail), c (one)
        2.00 step 2: b (rail)
        5.00 the mission is to end, and what it has begun is cleaned up first
        5.00 canceled c
        5.00 canceled b
        5.00 cleaning up behind then 1
        5.00 step 3: t (rail)
        15.00 canceled",
    );
}

#[test]
fn a_failing_cleanup_changes_nothing() {
    check(
        "then: [{short: a}, {long: b}], cleanup: {once: f}",
        &format!("{}{HANGS}", canceled_at(5)),
        "
        0.00 step 1: a (rail)
        2.00 step 2: b (rail)
        5.00 the mission is to end, and what it has begun is cleaned up first
        5.00 canceled b
        5.00 cleaning up behind \"then\"
        5.00 step 3: f (rail)
        9.00 failed f: it took too long
        9.00 canceled",
    );
}

#[test]
fn a_cleanup_has_its_own_time_whatever_is_canceled() {
    check(
        "and: [{then: [{short: a}, {once: f}], cleanup: {then: [{long: t}], timeout: 3 s}}, {short: {n: b, of: tool}}]",
        &format!("{HANGS}{}", canceled_at(7)),
        "
        0.00 step 1: a (rail), b (one)
        2.00 step 2: f (rail)
        6.00 failed f: it took too long
        6.00 cleaning up behind then 1
        6.00 step 3: t (rail)
        7.00 the mission is to end, and what it has begun is cleaned up first
        9.00 then 2 took too long; what runs of then 2 is canceled
        9.00 canceled t
        9.00 canceled",
    );
}
