//! The tables of a few runs.

use std::collections::BTreeMap;

use super::{ChaosReport, ChaosRun, Outcome, text};
use crate::Palette;

#[test]
fn ends_deeds_and_findings_are_told() {
    let run = |seed, mission: &str, code, findings: &[&str]| ChaosRun {
        seed,
        mission: mission.into(),
        outcome: Outcome::of(Some(code)),
        done: BTreeMap::from([("kill -9 of a controller", 2)]),
        findings: findings.iter().map(|finding| (*finding).to_owned()).collect(),
        records: 500,
        ..ChaosRun::default()
    };
    let mut report = ChaosReport { seed: 1, runs: vec![run(1, "tea", 0, &[]), run(2, "tray", 4, &[])] };
    let expected = "\
mission    runs  done  lost
tea           1     1     ·
tray          1     ·     1
all           2     1     1

what was done
  kill -9 of a controller       4 in 2 runs

looked at 1000 records, 0 grants, 0 refusals, 0 commands, 0 goals, 0 moves of objects, 0 lines of
          controllers
✓ nothing was found in 2 runs
";
    assert_eq!(text(&report, 100, &Palette::plain()), expected);
    report.runs[1].findings.push("owners: line 7: base has two owners".into());
    let said = text(&report, 100, &Palette::plain());
    assert!(said.ends_with("what was found\n  ✗ seed 2      tray: owners: line 7: base has two owners\n"), "{said}");
}
