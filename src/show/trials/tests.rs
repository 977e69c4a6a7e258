//! The tables of a few runs.

use std::collections::BTreeMap;

use ambidex_record::MissionOutcome;

use super::{Cause, Trial, Trials, Wrong, bounds, text};
use crate::Palette;

fn trial(seed: u64, cause: Option<(&str, &str)>, makespan_s: f64, wrong: &[Wrong]) -> Trial {
    let outcome = if cause.is_some() { MissionOutcome::Failed } else { MissionOutcome::Done };
    let cause = cause.map(|(at, why)| Cause { at: Some(at.into()), why: why.into() });
    let wrong: BTreeMap<Wrong, u32> = wrong.iter().map(|kind| (*kind, 1)).collect();
    Trial { seed, outcome, cause, makespan_s, wrong }
}

#[test]
fn ends_times_causes_and_kinds_are_counted() {
    let lost = Some(("pick cup", "right_arm was lost"));
    let trials = vec![
        trial(1, None, 10.0, &[]),
        trial(2, lost, 4.0, &[Wrong::Lost]),
        trial(3, None, 12.0, &[Wrong::Lost]),
        trial(4, Some(("place cup", "it took too long")), 5.0, &[Wrong::Hangs, Wrong::Lost]),
        trial(5, lost, 3.0, &[Wrong::Lost]),
    ];
    let trials = Trials { mission: "tea".into(), probability: 0.05, undisturbed_s: Some(9.5), trials };
    let expected = "\
tea: 5 runs, 5 % of attempts go wrong

  ✓ done          2   40.0 %  ━━━━━━━━━───────────────  11.8 to 76.9 % with 95 % confidence
  ✗ failed        3   60.0 %  ━━━━━━━━━━━━━━──────────

  done in 10.0 to 12.0 s of robot time, half of them within 12.0 s, 9 of 10 within 12.0 s; 9.5 s where nothing
  goes wrong

why not
  ✗      2  pick cup   right_arm was lost (seed 2)
  ✗      1  place cup  it took too long (seed 4)

what went wrong, and was done all the same
  a behavior hangs                   0 of 1        0.0 %  ────────────────────────
  a controller is lost               1 of 4       25.0 %  ━━━━━━──────────────────
";
    assert_eq!(text(&trials, 112, &Palette::plain()), expected);
}

#[test]
fn bounds_of_a_share_hold_it() {
    // Wilson, E. B. (1927); 8 of 10 as in textbooks.
    let (least, most) = bounds(8, 10);
    assert!((least - 0.4902).abs() < 1e-3 && (most - 0.9433).abs() < 1e-3, "{least} {most}");
    assert_eq!(bounds(0, 5).0, 0.0);
    assert_eq!(bounds(5, 5).1, 1.0);
}
