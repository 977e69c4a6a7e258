//! What the hostile process does, by name. Each act stands beside its test.

use ambidex::link::Instance;

use super::peer::Peer;
use super::scene::HOSTILE;
use super::{floods, lies, order, segments, silence, strangers};

/// Which act is played; none in a test run.
pub const ACT: &str = "AMBIDEX_TEST_ACT";
/// The instance that it is played in.
pub const INSTANCE: &str = "AMBIDEX_TEST_INSTANCE";

/// The other side of the tests beside this file; without an act it has nothing to do.
#[test]
fn hostile() {
    let Ok(act) = std::env::var(ACT) else {
        return;
    };
    let instance = std::env::var(INSTANCE).expect("an instance");
    play(&act, &Instance::new(&instance).expect("a name"));
}

fn play(act: &str, instance: &Instance) {
    let enter = || Peer::enter(instance, HOSTILE);
    let (act, row) = act.split_once(' ').unwrap_or((act, "0"));
    let row: usize = row.parse().expect("a row");
    match act {
        "good" => enter().behave(),
        "results" => lies::results(enter()),
        "feedback" => lies::feedback(enter()),
        "pulses" => lies::pulses(enter()),
        "wrong-pulses" => lies::wrong_pulses(enter()),
        "future" => lies::future(enter()),
        "configured" => lies::configured(enter(), row),
        "after-the-end" => order::after_the_end(enter()),
        "foreign" => order::foreign(enter()),
        "holds-nothing-known" => order::holds_nothing_known(enter()),
        "holds-another" => order::holds_another(enter()),
        "holds-what-the-other-holds" => order::holds_what_the_other_holds(enter()),
        "flood" => floods::flood(enter(), row),
        "flood-stream" => floods::flood_stream(enter(), row),
        "segments" => segments::damage(enter(), instance, row),
        "silence" => silence::be_silent(enter(), row),
        "usurper" => strangers::usurp(instance),
        "nobody" => Peer::enter(instance, "third_arm").behave(),
        "late" => strangers::come_late(instance),
        "settings" => strangers::occupy(instance, row),
        other => panic!("{other} is no act"),
    }
}
