//! Calls: what they become, and what is said of the mistakes in them.

use std::sync::Arc;
use std::time::Duration;

use super::super::FilesError;
use super::load;
use ambidex_model::{ARGUMENTS_MAX, Call, MissionSpec, Mode, NO_ARGUMENTS, NodeId, Task};

const ROBOT: &str = "\
robot: reader
radius: 0.3 m
resources:
  left: {type: gripper, controller: left_arm}
  right: {type: gripper, controller: right_arm}
  reader: {type: reader, controller: reader}
  bell: {type: bell}
controllers:
  left_arm:
    arm: {shoulder: [0, 0, 0.8], tuck: [0.3, 0, 0.9], reach: 0.9, speed: 0.5, acceleration: 1, grip: 1 s, lift: 10 cm, calls: {wave: {takes: 1 s}, point: {takes: 1 s}}}
  right_arm:
    arm: {shoulder: [0, 0, 0.8], tuck: [0.3, 0, 0.9], reach: 0.9, speed: 0.5, acceleration: 1, grip: 1 s, lift: 10 cm, calls: {wave: {takes: 1 s}, point: {takes: 2 s}}}
  reader:
    device:
      calls:
        read: {parameters: {what: object, times: {type: number, default: 2}, note: {type: text, default: none}}, takes: 2500 ms}
        beep: {takes: 0 s}
";

fn mission(call: &str) -> String {
    format!(
        "\
mission: reading
robot: robot.yaml
behaviors:
  study:
    parameters: {{what: object, effort: number}}
    claims: {{it: {{type: reader}}, hand: {{type: gripper}}, sound: {{type: bell}}}}
    potential: $effort
    commands:
      - {{claim: {call}}}
    timeout: 3 s
world:
  robot: {{at: [0, 0]}}
  places: {{desk: {{stand: [0, 0]}}}}
  objects: {{book: {{at: desk}}}}
task: {{study: {{what: book, effort: 3}}}}
"
    )
}

fn loaded(call: &str) -> Result<Arc<MissionSpec>, FilesError> {
    load(&mission(call), ROBOT)
}

#[test]
fn what_is_called_with_what() {
    let check = |call: &str, mode: Mode, expected: Call| {
        let mission = loaded(call).unwrap_or_else(|error| panic!("{call}: {:#?}", error.faults()));
        let command = &mission.tree.behavior(NodeId(1)).unwrap().commands[0];
        assert_eq!((command.mode, &command.task), (mode, &Task::Call(expected)), "{call}");
    };
    let read = |with: &str| Call { name: "read".into(), with: with.into(), takes: Duration::from_millis(2500) };
    let of_book = read(r#"{"note":"none","times":2.0,"what":"book"}"#);
    check("it, achieve: {call: read, with: {what: book}}", Mode::Achieve, of_book.clone());
    check("it, achieve: {call: read, with: {what: $what}}", Mode::Achieve, of_book);
    let told = read(r#"{"note":"a \"book\" of 3","times":3.0,"what":"book"}"#);
    check(
        "it, achieve: {call: read, with: {what: '${what}', times: $effort, note: 'a \"$what\" of $effort'}}",
        Mode::Achieve,
        told,
    );
    let beep = Call { name: "beep".into(), with: NO_ARGUMENTS.into(), takes: Duration::ZERO };
    check("it, maintain: {call: beep}", Mode::Maintain, beep);
    let wave = Call { name: "wave".into(), with: NO_ARGUMENTS.into(), takes: Duration::from_secs(1) };
    check("hand, achieve: {call: wave}", Mode::Achieve, wave);
}

#[test]
fn mistakes_say_what_is_allowed() {
    let rows = [
        (
            "it, achieve: {call: raed}",
            "controller `reader` offers no call `raed` did you mean `read`? Allowed: `read`, `beep`",
        ),
        ("hand, achieve: {call: read}", "controller `left_arm` offers no call `read`"),
        ("hand, achieve: {call: point}", "`left_arm` and `right_arm` offer `point` with other parameters or times"),
        ("sound, achieve: {call: read}", "no controller moves what is claimed, so that nobody can be called"),
        (
            "it, achieve: {call: read}",
            "`read` lacks its parameter `what`, an object write `with: {what: OBJECT}` beside it",
        ),
        (
            "it, achieve: {call: read, with: {what: book, tims: 3}}",
            "`read` has no parameter `tims` did you mean `times`?",
        ),
        ("it, achieve: {call: beep, with: {loud: 3}}", "`beep` has no parameter `loud` there is no parameter at all"),
        ("it, achieve: {call: read, with: {what: bok}}", "there is no object `bok` did you mean `book`?"),
        ("it, achieve: {call: read, with: {what: $effort}}", "`$effort` is a number, not an object"),
        ("it, achieve: {call: read, with: {what: book, times: 'x$what'}}", "a text is not a number"),
        ("it, achieve: {call: read, with: {what: book, times: often}}", "found `often` instead of a number"),
        ("it, achieve: {call: read, with: {what: $waht}}", "there is no parameter `waht` did you mean `what`?"),
        ("it, achieve: {put: {object: book, at: desk}, with: {what: book}}", "arguments are for a `call`"),
        ("it, achieve: {grasp: book}", "controller `reader` moves a device, which can call"),
        ("it, achieve: {call: read, with: book}", "found `book` instead of a map of arguments"),
    ];
    for (call, words) in rows {
        let error = loaded(call).expect_err(call);
        let said = |fault: &crate::Fault| format!("{fault} {}", fault.help().unwrap_or_default());
        let found: Vec<_> =
            error.faults().iter().map(|fault| (fault.position().map_or(0, |at| at.0), said(fault))).collect();
        assert!(found.iter().any(|(line, said)| *line == 9 && said.contains(words)), "{call}: {words}: {found:#?}");
    }
    // One byte for one, however it is written.
    let long = "x".repeat(ARGUMENTS_MAX);
    let parameters = "commands:\n      - {claim: it, achieve: {call: read, with: {what: book, note: $note}}}";
    let text = mission("it, achieve: {call: beep}")
        .replace("effort: number}", "effort: number, note: text}")
        .replace("commands:\n      - {claim: it, achieve: {call: beep}}", parameters);
    assert!(load(&text.replace("effort: 3}", "effort: 3, note: short}"), ROBOT).is_ok());
    assert!(load(&text.replace("effort: 3}", &format!("effort: 3, note: {long}}}")), ROBOT).is_err());
    let slow = ROBOT.replace("takes: 2500 ms", "takes: 3 s");
    let error = load(&mission("it, achieve: {call: read, with: {what: book}}"), &slow).expect_err("it cannot end");
    let said = "`read` takes 3 s, and the timeout of the behavior is 3 s";
    assert!(error.faults().iter().any(|fault| fault.to_string().contains(said)), "{:#?}", error.faults());
}

#[test]
fn a_device_is_neither_arm_nor_base_nor_head() {
    let gripper = ROBOT.replace("reader: {type: reader,", "reader: {type: gripper,");
    let error = load(&mission("it, achieve: {call: beep}"), &gripper).expect_err("it cannot grip");
    assert!(error.faults().iter().any(|fault| fault.to_string().contains("moves a device, not a gripper")));
    let names = ROBOT.replace("beep:", &format!("{}:", "b".repeat(65)));
    assert!(load(&mission("it, maintain: {call: read, with: {what: book}}"), &names).is_err(), "a name is short");
}

#[test]
fn a_name_that_would_not_fit_is_told() {
    let named = |name: &str| mission("it, achieve: {call: beep}").replace("book", name);
    assert!(load(&named(&"é".repeat(32)), ROBOT).is_ok());
    let error = load(&named(&"é".repeat(33)), ROBOT).expect_err("66 bytes");
    assert!(error.faults().iter().any(|fault| fault.to_string().contains("a name has at most 64 bytes")));
}
