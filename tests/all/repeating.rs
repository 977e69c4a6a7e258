//! Work that repeats (`semantics` 6): what is told of small missions, line by line.

use crate::lines::check;

#[test]
fn it_is_done_as_often_as_it_says() {
    check(
        "then: [{short: a}, {short: b}], repeat: 2",
        "",
        "
        0.00 step 1: a (rail)
        2.00 step 2: b (rail)
        4.00 the task is done and begins again
        4.00 step 3: a (rail)
        6.00 step 4: b (rail)
        8.00 done in 4 steps",
    );
    check(
        "short: a, repeat: 3",
        "",
        "
        0.00 step 1: a (rail)
        2.00 the task is done and begins again
        2.00 step 2: a (rail)
        4.00 the task is done and begins again
        4.00 step 3: a (rail)
        6.00 done in 3 steps",
    );
    // Counts of what is below begin anew.
    check(
        "then: [{short: a, repeat: 2}, {short: b}], repeat: 2, name: outer",
        "",
        "
        0.00 step 1: a (rail)
        2.00 a is done and begins again
        2.00 step 2: a (rail)
        4.00 step 3: b (rail)
        6.00 the task is done and begins again
        6.00 step 4: a (rail)
        8.00 a is done and begins again
        8.00 step 5: a (rail)
        10.00 step 6: b (rail)
        12.00 done in 6 steps",
    );
}

#[test]
fn what_was_done_fewer_times_comes_first() {
    check(
        "and: [{long: a, repeat: 2}, {short: b}, {short: c, repeat: 2}]",
        "",
        "
        0.00 step 1: a (rail)
        10.00 a is done and begins again
        10.00 step 2: b (rail)
        12.00 step 3: c (rail)
        14.00 c is done and begins again
        14.00 step 4: a (rail)
        24.00 step 5: c (rail)
        26.00 done in 5 steps",
    );
}

#[test]
fn the_next_time_begins_when_it_is_due() {
    check(
        "short: a, repeat: forever, every: 5 s",
        "\n  - {at: 12 s, cancel: true}",
        "
        0.00 step 1: a (rail)
        2.00 the task is done and begins again at 5.00 s
        5.00 a begins again
        5.00 step 2: a (rail)
        7.00 the task is done and begins again at 10.00 s
        10.00 a begins again
        10.00 step 3: a (rail)
        12.00 the task is done and begins again at 15.00 s
        12.00 canceled",
    );
    // Too late is at once, and what was missed is left out.
    check(
        "long: a, repeat: 3, every: 4 s",
        "",
        "
        0.00 step 1: a (rail)
        10.00 the task is done and begins again
        10.00 step 2: a (rail)
        20.00 the task is done and begins again
        20.00 step 3: a (rail)
        30.00 done in 3 steps",
    );
    // Who waits so holds nobody up.
    check(
        "and: [{short: a, repeat: 2, every: 9 s}, {then: [{long: b}, {short: c}]}]",
        "",
        "
        0.00 step 1: b (rail)
        10.00 step 2: a (rail)
        12.00 a is done and begins again at 19.00 s
        12.00 step 3: c (rail)
        19.00 a begins again
        19.00 step 4: a (rail)
        21.00 done in 4 steps",
    );
}

#[test]
fn a_time_in_which_all_is_satisfied_counts() {
    check(
        "then: [{set: a}, {then: [{set: b}], repeat: 3, name: again}, {short: c}]",
        "",
        "
        0.00 step 1: a
        1.00 again is done and begins again
        1.00 again is done and begins again
        1.00 step 2: c (rail); skipped b
        3.00 done in 2 steps",
    );
    check(
        "then: [{set: a}, {set: b, repeat: 3}, {short: c}]",
        "",
        "
        0.00 step 1: a
        1.00 b is done and begins again
        1.00 b is done and begins again
        1.00 step 2: c (rail); skipped b
        3.00 done in 2 steps",
    );
}

#[test]
fn attempts_and_failed_ways_begin_anew() {
    let failures = "\n  - {behavior: a, attempt: every, hangs: true}";
    check(
        "or: [{once: a}, {short: b}], repeat: 2, name: R",
        failures,
        "
        0.00 step 1: a (rail)
        4.00 failed a: it took too long
        4.00 step 2: b (rail)
        6.00 the task is done and begins again
        6.00 step 3: a (rail)
        10.00 failed a: it took too long
        10.00 step 4: b (rail)
        12.00 done in 4 steps",
    );
    // One that fails for good is not done again.
    check(
        "then: [{short: b}, {once: a}], repeat: 2, name: R",
        failures,
        "
        0.00 step 1: b (rail)
        2.00 step 2: a (rail)
        6.00 failed a: it took too long
        6.00 failed at a",
    );
}
