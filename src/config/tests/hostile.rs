//! Files that nobody would write: too deep, too large, cut up at random.

use proptest::prelude::*;

use super::{GOOD, ROBOT, load};

#[test]
fn what_is_too_much_is_refused() {
    let head = &GOOD[..GOOD.find("task:").unwrap()];
    let deep = |levels| {
        let open = "{and: [".repeat(levels);
        let close = "]}".repeat(levels);
        format!("{head}task: {open}{{move: shelf}}{close}\n")
    };
    assert!(load(&deep(63), ROBOT).is_ok());
    for (mission, words) in [
        (deep(66), "nested more than"),
        (deep(5000), ""),
        (format!("{GOOD}#{}", " ".repeat(1 << 20)), "larger than"),
        (format!("{head}task: {{and: [{}]}}", "{},".repeat(90_000)), "does not say what it is"),
        (format!("{head}task: {{and: [{}]}}", "1,".repeat(300_000)), ""),
    ] {
        let error = load(&mission, ROBOT).unwrap_err();
        let found = error.faults()[0].message();
        assert!(found.contains(words), "{found}");
        assert!(error.faults().len() <= 100);
    }
}

#[test]
fn aliases_stay_within_bounds() {
    let mut bomb = "a0: &a0 [1, 1, 1, 1, 1, 1, 1, 1, 1]\n".to_owned();
    for level in 1..12 {
        let items = format!("*a{}, ", level - 1).repeat(9);
        bomb += &format!("a{level}: &a{level} [{items}]\n");
    }
    assert!(load(&bomb, ROBOT).is_err());
    let anchored = GOOD.replace("pick: cup", "&it pick: cup").replace("    - place:", "    - *nothing\n    - place:");
    assert!(load(&anchored, ROBOT).is_err());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn no_text_makes_it_panic(
        cuts in prop::collection::vec((0..1000usize, 0..6usize, "[-a-z0-9 :\\[\\]{},&*!|>'\"#~%@.\n]{0,4}"), 1..6),
        is_robot in any::<bool>(),
    ) {
        let mut text = if is_robot { ROBOT } else { GOOD }.to_owned();
        for (at, length, by) in cuts {
            let from = at.min(text.len());
            let to = (from + length).min(text.len());
            text.replace_range(from..to, &by);
        }
        let loaded = if is_robot { load(GOOD, &text) } else { load(&text, ROBOT) };
        if let Err(error) = loaded {
            prop_assert!(!error.faults().is_empty());
            for fault in error.faults() {
                prop_assert!(fault.position().is_none_or(|at| at.0 <= text.lines().count() + GOOD.len()));
            }
            let report = format!("{:?}", miette::Report::new(error));
            prop_assert!(!report.is_empty());
        }
    }

    #[test]
    fn no_bytes_make_it_panic(text in "\\PC{0,200}") {
        prop_assert!(load(&text, ROBOT).is_err());
    }
}
