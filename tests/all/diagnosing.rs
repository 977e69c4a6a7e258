//! How well controllers are, as real ones are told by status, log and tracing events.

use std::time::Duration;

use rustix::process::Signal;
use serde_json::{Value, json};

use crate::fixtures::experiment_file;
use crate::home::{Home, within};

/// Within which something that happened must be seen.
const SOON: Duration = Duration::from_secs(20);

/// A controller as `status --json` tells it.
fn controller(home: &Home, name: &str) -> Value {
    let told = home.status(&["--json"]).ends(0).stdout;
    let told: Value = serde_json::from_str(&told).expect("an object");
    let rows = told["controllers"].as_array().expect("a list");
    rows.iter().find(|row| row["name"] == name).expect("a controller").clone()
}

/// Waits until its daemon says of a controller that it is at a level, and gives what was said.
fn at_level(home: &Home, name: &str, level: &str) -> Value {
    let mut told = Value::Null;
    within(SOON, &format!("{name} is {level}"), || {
        told = controller(home, name)["diagnostics"].clone();
        told["level"] == level && told["live"] == true
    });
    told
}

#[test]
fn a_controller_is_diagnosed_each_second_and_the_log_has_what_changes() {
    let home = Home::new();
    let args = ["daemon", "--instance", home.instance()].map(str::to_owned);
    let mission = experiment_file(1).to_str().expect("UTF-8").to_owned();
    let mut daemon = home.start_with(args.into_iter().chain([mission]), |command| {
        command.env("RUST_LOG", "ambidex::diagnostics=debug");
    });
    daemon.says("waiting for");
    let mut head = home.controller("head", &[]);
    let well = at_level(&home, "head", "OK");
    assert_eq!(well["message"], "it serves");
    let values = &well["values"];
    assert_eq!((&values["attachments"], &values["generation"]), (&json!(1), &json!(1)));
    assert_eq!((&values["refused"], &values["hung"], &values["inhibited"]), (&json!(0), &json!(false), &Value::Null));
    assert!(values["heartbeat_age_ms"].is_u64() && values["worst_gap_ms"].is_u64(), "{values}");
    let absent = at_level(&home, "base", "STALE");
    assert_eq!(absent["message"], "it never attached");
    assert_eq!(absent["values"]["heartbeat_age_ms"], Value::Null);
    let text = home.status(&[]).ends(0).stdout;
    assert!(text.contains("gap ms"), "{text}");

    head.signal(Signal::STOP);
    let silent = at_level(&home, "head", "STALE");
    assert_eq!(silent["message"], "it showed no life for 1 s");
    assert!(silent["values"]["heartbeat_age_ms"].as_u64() >= Some(1000), "{silent}");
    head.signal(Signal::CONT);
    let back = at_level(&home, "head", "OK");
    assert_eq!(
        (&back["values"]["attachments"], &back["values"]["last_fault"]),
        (&json!(2), &json!({"lost": "silent"}))
    );

    head.signal(Signal::KILL);
    let ended = at_level(&home, "head", "ERROR");
    assert_eq!(ended["message"], "its process ended");
    assert!(head.has_ended());
    daemon.says("heartbeat_age_ms");
    daemon.signal(Signal::TERM);
    let said = daemon.ends(130).stderr;
    assert!(said.contains("DEBUG ambidex::diagnostics") && said.contains("INFO ambidex::diagnostics"), "{said}");

    let log = home.log();
    let diagnosed = |name: &str| {
        let names: Value = serde_json::from_str(log.lines().next().expect("a header")).expect("JSON");
        let id = names["names"]["controllers"].as_array().expect("names").iter().position(|known| known == name);
        let records = log.lines().map(|line| serde_json::from_str::<Value>(line).expect("JSON"));
        let its =
            records.filter(|record| record["controller"] == json!(id) && record["message"]["kind"] == "diagnosed");
        its.map(|record| record["message"]["level"].as_str().expect("a level").to_owned()).collect::<Vec<_>>()
    };
    assert_eq!(diagnosed("base"), ["STALE"], "what stays as it is is told once");
    let of_head = diagnosed("head");
    let worst = of_head.iter().filter(|level| ["STALE", "ERROR"].contains(&level.as_str())).collect::<Vec<_>>();
    assert!(worst.ends_with(&[&"STALE".to_owned(), &"ERROR".to_owned()]), "{of_head:?}");
    // Without a daemon the log tells it.
    let of_log = controller(&home, "head")["diagnostics"].clone();
    assert_eq!((&of_log["level"], &of_log["live"]), (&json!("ERROR"), &json!(false)));
    let path = home.write("run.jsonl", &log);
    assert!(home.start(["verify".as_ref(), path.as_os_str()]).ends(0).stdout.starts_with("same: "));
    let shown = home.start(["trace", "--kind", "diagnosed", path.to_str().expect("UTF-8")]).ends(0).stdout;
    assert!(shown.contains("STALE: it showed no life for 1 s"), "{shown}");
    home.is_empty();
}
