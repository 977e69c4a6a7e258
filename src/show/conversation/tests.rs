//! Every kind of record as a line, filters one by one, and JSON with names.

use nalgebra::Point3;
use serde_json::Value;
use strum::VariantArray;

use super::*;
use crate::sample::{decided, experiment_1, grant, header, named, released, seconds};
use ambidex_model::*;

fn sent(from: &str, to: &str, message: Message) -> Record {
    Record::Sent { at: seconds(7.4), round: 2, from: named(from), to: named(to), message }
}

fn controller(controller: u32, message: ControllerMessage) -> Record {
    Record::Controller { at: seconds(9.0), controller: ControllerId(controller), message }
}

fn id() -> CommandId {
    CommandId { generation: 1, number: 7 }
}

fn goal(to: u32, leaf: &str, mode: Mode, command: Command) -> Record {
    let message = ToController::Goal { id: id(), mode, command };
    controller(to, ControllerMessage::Told { leaf: Some(named(leaf)), message })
}

fn stop(leaves: &[&str]) -> Message {
    let stopped = leaves.iter().map(|leaf| named(leaf)).collect();
    Message::Verdict { granted: Vec::new(), stopped }
}

fn heard(from: u32, message: FromController) -> Record {
    controller(from, ControllerMessage::Heard { message })
}

fn state() -> ControllerState {
    ControllerState::Head { angles: [0.0; 2], velocity: [0.0; 2] }
}

fn answer(leaf: &str, request: Option<Request>, reason: Option<Reason>) -> Message {
    Message::Answer {
        running: false,
        satisfied: false,
        potential: request.as_ref().map(|request| request.potential),
        asking: request.iter().map(|request| request.leaf).collect(),
        request: request.map(Into::into),
        blocked: reason.map(|reason| Blocked { leaf: named(leaf), reason }).into_iter().collect(),
    }
}

fn request() -> Request {
    let need = |access, candidates: &[u32]| ClaimOptions {
        access,
        keep: Retention::Release,
        candidates: candidates
            .iter()
            .map(|&id| Candidate { cost_m: 0.5, ..Candidate::at_hand(ResourceId(id)) })
            .collect(),
        beyond: Vec::new(),
    };
    let at = named("move 1-1");
    Request {
        leaf: named("pick 1"),
        priority: 0,
        iterations: 0,
        potential: 9.0,
        heir: true,
        claims: vec![need(Access::Shared(ChannelId(0)), &[0]), need(Access::Exclusive, &[2, 3])],
        changes: vec![ObjectId(0)],
        skips: vec![NodeRange { from: at, to: NodeId(at.0 + 1) }],
        place: None,
        stand: None,
        spots: Vec::new(),
        distance: None,
    }
}

/// A round in which pick 1 is granted, with what controllers make of it.
fn records() -> Vec<Record> {
    let outbid = Reason::Outbid { by: named("move 2-1"), resource: ResourceId(0), own: 0.25, theirs: 0.5 };
    let at = Point3::new(0.5, 0.25, 0.75);
    let mut decision = decided(7.4, 2, vec![grant("pick 1", &[0, 1], &[2], &["move 1-1"])]);
    if let Record::Decided { refused, .. } = &mut decision {
        refused.push(Blocked { leaf: named("move 3-1"), reason: outbid.clone() });
    }
    vec![
        Record::Header(Box::new(header())),
        controller(2, ControllerMessage::Attached),
        sent("all objects", "object 1", Message::Activation),
        sent("pick 1", "object 1", answer("pick 1", Some(request()), None)),
        sent("move 3-1", "object 3", answer("move 3-1", None, Some(Reason::NotAt { place: PlaceId(0) }))),
        decision,
        sent("object 1", "pick 1", Message::Verdict { granted: vec![named("pick 1")], stopped: Vec::new() }),
        goal(2, "pick 1", Mode::Achieve, Command::Grasp { object: ObjectId(0), at, place: None, holder: None }),
        goal(1, "pick 1", Mode::Maintain, Command::Look { at, place: None }),
        controller(1, ControllerMessage::Joined { leaf: named("pick 2"), id: id() }),
        heard(2, FromController::Accepted { id: id(), at: seconds(9.0) }),
        heard(1, FromController::Feedback { id: id(), progress: 0.25, state: state() }),
        heard(
            2,
            FromController::Result {
                id: id(),
                end: PartEnd::Succeeded,
                began: seconds(7.4),
                ended: seconds(9.0),
                state: state(),
            },
        ),
        sent("pick 1", "object 1", Message::Release { leaf: named("pick 1"), end: End::Succeeded }),
        released(9.0, "pick 2", End::Failed(Fault::Aborted(ControllerId(3)))),
        Record::World {
            at: seconds(9.5),
            change: Change::Object(ObjectId(2), Location::At(PlaceId(1))),
            origin: Origin::Script,
        },
        sent("object 1", "move 1-2", stop(&["move 1-2"])),
        sent("all objects", "object 1", stop(&["move 1-2"])),
        Record::Stopped { at: seconds(9.5), leaves: vec![named("move 1-2")], cause: StopCause::Ends },
        Record::Turn { at: seconds(9.5) },
        Record::Told { at: seconds(9.5), input: Told::End { end: MissionEnd::Canceled } },
        Record::Ended { at: seconds(10.0), end: MissionEnd::Failed(named("pick 2")) },
    ]
}

fn selected(filters: &Filters, records: &[Record]) -> Vec<String> {
    let selection = Selection::new(filters, &header()).unwrap();
    let mut conversation = Conversation::new(&header(), selection);
    let mut lines = Vec::new();
    for record in records {
        if conversation.take(record) {
            lines.push(conversation.line(record, &Palette::plain()));
        }
    }
    lines
}

const ALL: &str = "\
experiment 1 on pr2, greedy: 22 nodes with 16 behaviors
    0.000 s             left_arm → dispatch       attached
    0.000 s    r2    all objects → object 1       activation
    0.000 s    r2         pick 1 → object 1       asks with potential 9.000 for base for \"at shelf\", left_gripper or right_gripper alone; skips move 1-1; an intention is kept for it
    0.000 s    r2       move 3-1 → object 3       cannot: the base does not stand at shelf
    0.000 s    r2           root                  grants pick 1 left_gripper alone, base and head for \"at shelf\" (skipping move 1-1); not move 3-1: outbid by move 2-1 for base (0.500 against 0.250)
    0.000 s    r2       object 1 → pick 1         granted
    1.600 s               pick 1 → left_arm       goal 1.7: grasp object 1
    1.600 s               pick 1 → head           goal 1.7: look at (0.50, 0.25, 0.75), until told to stop
    1.600 s               pick 2 → head           shares goal 1.7
    1.600 s             left_arm → pick 1         accepted goal 1.7
    1.600 s                 head → pick 1 + pick 2  goal 1.7 is at 25 %
    1.600 s             left_arm → pick 1         goal 1.7 succeeded after 1.60 s
    0.000 s    r2         pick 1 → object 1       pick 1 succeeded
    1.600 s                 root                  pick 2 failed: right_arm gave up
    2.100 s                world                  object 3 is at counter now: done on purpose
    0.000 s    r2       object 1 → move 1-2       is to end
    0.000 s    r2    all objects → object 1       move 1-2 is to end
    2.100 s                 root                  move 1-2 is to end
    2.100 s                 root                  takes up what it was told
    2.100 s                world → root           end: canceled
    2.600 s                 root                  the mission is over: failed at pick 2
";

#[test]
fn every_record_is_a_line() {
    let text = selected(&everything(), &records()).into_iter().map(|line| format!("{}\n", line.trim_end()));
    let text: String = text.collect();
    assert_eq!(text, ALL, "\n{text}");
}

fn everything() -> Filters {
    Filters { with_minor: true, ..Filters::default() }
}

/// Which lines of all a filter leaves.
fn check(adapt: impl Fn(&mut Filters), expected: &[usize]) {
    let mut filters = everything();
    adapt(&mut filters);
    let found = selected(&filters, &records());
    let all = selected(&everything(), &records());
    let found: Vec<_> = found.iter().map(|line| all.iter().position(|other| other == line)).collect();
    let expected: Vec<_> = expected.iter().map(|line| Some(*line)).collect();
    assert_eq!(found, expected, "{filters:?}");
}

#[test]
fn filters_select_and_combine() {
    let some = |name: &str| Some(name.to_owned());
    check(|filters| filters.node = some("pick 1"), &[3, 5, 6, 7, 8, 9, 10, 11, 12, 13]);
    check(|filters| filters.node = some("pick 2"), &[9, 11, 14, 21]);
    check(|filters| filters.node = some("move 3*"), &[4, 5]);
    check(|filters| filters.node = some("*"), &[2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 16, 17, 18, 21]);
    let goals = |filters: &mut Filters| (filters.kinds, filters.with_minor) = (vec![Kind::Goal], false);
    check(goals, &[7, 8]);
    check(|filters| filters.kinds = vec![Kind::Goal], &[7, 8, 11, 19, 20]);
    check(|filters| filters.kinds = vec![Kind::Feedback], &[11, 19, 20]);
    let quiet = |filters: &mut Filters| (filters.controller, filters.with_minor) = (some("head"), false);
    check(quiet, &[8, 9]);
    check(|filters| filters.kinds = vec![Kind::Goal, Kind::Feedback], &[7, 8, 11, 19, 20]);
    check(|filters| filters.resource = some("left_gripper"), &[3, 5]);
    check(|filters| filters.resource = some("base"), &[3, 5]);
    check(|filters| filters.controller = some("left_arm"), &[1, 7, 10, 12]);
    check(|filters| filters.controller = some("right_arm"), &[14]);
    check(|filters| filters.rounds = Some(0..=1), &[0, 1]);
    check(
        |filters| filters.rounds = Some(2..=2),
        &[2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18, 19, 20, 21],
    );
    check(|filters| filters.from = Some(seconds(1.8)), &[15, 18, 19, 20, 21]);
    check(|filters| filters.to = Some(seconds(0.0)), &[0, 1, 2, 3, 4, 5, 6, 13, 16, 17]);
    let both = |filters: &mut Filters| {
        filters.node = some("pick 1");
        filters.controller = some("head");
    };
    check(both, &[8, 9, 11]);
}

#[test]
fn unknown_names_are_told_with_what_there_is() {
    let check = |filters: Filters, said: &str, help: &str| {
        let error = Selection::new(&filters, &header()).unwrap_err();
        assert_eq!(error.to_string(), said);
        assert!(error.help().starts_with(help), "{}", error.help());
    };
    let some = |name: &str| Some(name.to_owned());
    let node = |name| Filters { node: some(name), ..Filters::default() };
    check(node("pik 3"), "there is no node `pik 3`", "did you mean `pick 3`? Allowed: `root`");
    check(node("push*"), "there is no node `push*`", "allowed: `root`");
    check(node("[pick"), "there is no node `[pick`", "allowed: ");
    let filters = Filters { resource: some("bass"), ..Filters::default() };
    check(filters, "there is no resource `bass`", "did you mean `base`? Allowed: `base`, `head`");
    let filters = Filters { controller: some("arm"), ..Filters::default() };
    check(filters, "there is no controller `arm`", "did you mean `left_arm` or `right_arm`? Allowed: `base`");
}

#[test]
fn json_has_names_where_the_journal_has_ids() {
    let selection = Selection::new(&Filters::default(), &header()).unwrap();
    let conversation = Conversation::new(&header(), selection);
    let json = |record: &Record| conversation.json(record).unwrap();
    let back = |record: &Record| -> Value { serde_json::from_str(&json(record)).unwrap() };
    assert_eq!(
        json(&records()[2]),
        "{\"record\":\"sent\",\"at\":7400000,\"round\":2,\"from\":\"all objects\",\"to\":\"object 1\",\
         \"message\":{\"kind\":\"activation\"}}"
    );
    let decision = back(&records()[5]);
    assert_eq!(decision["granted"][0]["leaf"], "pick 1");
    assert_eq!(decision["granted"][0]["bindings"][0]["resource"], "base");
    assert_eq!(decision["granted"][0]["bindings"][0]["access"]["shared"], "at shelf");
    assert_eq!(decision["granted"][0]["skips"], serde_json::json!([["move 1-1"]]));
    assert_eq!(decision["refused"][0]["reason"]["outbid"]["theirs"], 0.5);
    let world = back(&records()[15]);
    assert_eq!(world["change"]["object"], serde_json::json!(["object 3", {"at": "counter"}]));
    assert_eq!(back(&records()[14])["end"]["failed"]["aborted"], "right_arm");
    assert_eq!(back(&records()[0])["nodes"][3]["parent"], "object 1");
    for record in records().iter().chain(&experiment_1()) {
        // What is no id is as it was.
        let plain: Value = serde_json::to_value(record).unwrap();
        assert_eq!(back(record)["at"], plain["at"]);
        assert_eq!(back(record)["record"], plain["record"]);
    }
}

#[test]
fn every_kind_has_a_word_that_means_it() {
    let check = |kind: Kind, word: &str| assert_eq!((kind.word(), word.parse()), (word, Ok(kind)));
    check(Kind::Header, "header");
    check(Kind::Stop, "stop");
    assert!(Kind::VARIANTS.iter().all(|kind| kind.word().parse() == Ok(*kind)));
}
