//! Missions that load, run under a virtual clock, with what goes wrong in them.

use std::sync::Arc;

use ambidex::model::{Mishap, Reason, Record, Time};
use ambidex::record::History;
use ambidex::replay::Replay;
use ambidex::show::conversation::Kind;
use ambidex::sim;
use ambidex::tree::{Allocator, Greedy, Serial, Settings};
use serde_json::Value;

use super::Taken;
use super::files::{failures_of, mission_of};
use crate::mutate::ordered;

/// Robot time after which every mission is canceled at the latest, seconds.
const LATEST_S: f64 = 60.0;

/// A map of a mission, what goes wrong in it, when it is canceled, and how it is run.
pub fn execution(text: &[u8]) -> Taken {
    let Some(run) = ordered::read(text) else { return Taken::default() };
    let Some(mission) = mission_of(&run) else { return Taken::default() };
    let mut taken = Taken { accepted: true, ..Taken::default() };
    let is = |key: &str| ordered::get(&run, key).and_then(Value::as_bool).unwrap_or_default();
    let allocator: Arc<dyn Allocator> = if is("serial") { Arc::new(Serial) } else { Arc::new(Greedy) };
    let settings = Settings {
        allocator,
        has_messages: is("messages"),
        waits_when_stalled: is("waits"),
        prevents_deadlock: is("certified"),
        ..Settings::default()
    };
    let mut failures = failures_of(&run, &mission);
    let cancel_s = ordered::get(&run, "cancel_s").and_then(Value::as_f64).unwrap_or(LATEST_S).clamp(0.0, LATEST_S);
    failures.mishaps.push((Time((cancel_s * 1e6) as u64), Mishap::Cancel));
    let mut history = History::new(&settings.header(&mission));
    let mut replay = Replay::new(&mission, &settings);
    let end = sim::simulate_failures(&mission, &settings, &failures, &mut |record: &Record| {
        taken.said(Kind::of(record).word());
        record.refusals().iter().for_each(|blocked| taken.said(kind_of(&blocked.reason).as_str()));
        history.apply(record);
        let same = replay.take(record);
        assert!(same.is_ok(), "computed again it differs\n{same:?}");
        // Once is enough.
        taken.kinds.sort_unstable();
        taken.kinds.dedup();
    });
    assert_eq!(history.end(), Some(end), "the log ends otherwise");
    taken.said(&format!("{end:?}"));
    taken
}

/// A reason without what it is about.
fn kind_of(reason: &Reason) -> String {
    format!("{reason:?}").chars().take_while(|letter| letter.is_alphanumeric()).collect()
}
