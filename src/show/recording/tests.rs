//! What a run comes to as messages: each as its schema says, and no more of them than something is different.

use std::collections::BTreeMap;

use ambidex_model::*;
use ambidex_record::{History, samples};
use jsonschema::Validator;
use nalgebra::{Point3, Vector3};
use serde_json::Value;
use strum::VariantArray;

use super::{Message, Recording, Topic, WallClock};
use crate::sample;

fn schemas() -> BTreeMap<Topic, Validator> {
    let schema = |topic: &Topic| jsonschema::validator_for(&topic.schema()).expect("a schema");
    Topic::VARIANTS.iter().map(|topic| (*topic, schema(topic))).collect()
}

fn messages(records: &[Record]) -> Vec<Message> {
    let Some(Record::Header(header)) = records.first() else { panic!("a header comes first") };
    let (mut history, mut recording) = (History::new(header), Recording::new(WallClock::NONE, None));
    let mut take = |record: &Record| {
        history.apply(record);
        recording.take(&history, record)
    };
    records.iter().flat_map(&mut take).collect()
}

fn of(topic: Topic, messages: &[Message]) -> Vec<Value> {
    let bodies = messages.iter().filter(|message| message.topic == topic);
    bodies.map(|message| serde_json::from_str(&message.body).expect("JSON")).collect()
}

#[test]
fn every_message_is_as_its_schema_says() {
    let schemas = schemas();
    for records in [samples::records(), sample::experiment_1()] {
        for message in messages(&records) {
            let body = serde_json::from_str(&message.body).expect("JSON");
            if let Err(error) = schemas[&message.topic].validate(&body) {
                panic!("{:?}: {error}: {body:#}", message.topic);
            }
            assert_eq!(message.log_time_ns, message.publish_time_ns, "a simulation has robot time alone");
        }
    }
    let names: std::collections::BTreeSet<_> = Topic::VARIANTS.iter().map(|topic| topic.name()).collect();
    assert_eq!(names.len(), Topic::VARIANTS.len());
}

/// What some nodes are at the end of each message.
fn phases(messages: &[Message], name: &str) -> Vec<String> {
    let told = of(Topic::State, messages);
    let nodes = told.iter().flat_map(|state| state["nodes"].as_array().expect("a list"));
    let mut phases: Vec<_> =
        nodes.filter(|node| node["name"] == name).map(|node| node["phase"].as_str().expect("a word").into()).collect();
    phases.dedup();
    phases
}

#[test]
fn nodes_are_told_when_they_change() {
    let told = messages(&sample::experiment_1());
    let check = |name: &str, expected: &[&str]| assert_eq!(phases(&told, name), expected, "{name}");
    check("pick 2", &["waiting", "active", "done"]);
    check("move 1-1", &["waiting", "skipped"]);
    check("object 2", &["waiting", "active", "waiting", "active", "waiting", "active", "waiting", "active", "done"]);
    let states = of(Topic::State, &told);
    assert!(states.iter().all(|state| state["whole"] == true && state["nodes"].as_array().map(Vec::len) == Some(22)));
    assert!(states.windows(2).all(|pair| pair[0]["nodes"] != pair[1]["nodes"]), "what is the same is not told again");
    assert_eq!(of(Topic::Tree, &told).len(), 1);
    let talk = of(Topic::Log, &told);
    assert_eq!(talk.last().expect("a line")["message"], "done in 10 steps");
}

#[test]
fn a_failure_is_told_with_its_reason() {
    let mut records = sample::experiment_1();
    let failed = End::Failed(Fault::Aborted(ControllerId(2)));
    records.truncate(4);
    records.push(sample::released(9.0, "pick 1", failed));
    let told = messages(&records);
    let last = of(Topic::State, &told).pop().expect("a state");
    let pick = last["nodes"].as_array().expect("a list").iter().find(|node| node["name"] == "pick 1");
    let reason = pick.expect("a node")["reason"].as_str().expect("a reason");
    assert!(reason.contains("left_arm"), "{reason}");
    let said = of(Topic::Log, &told).pop().expect("a line");
    assert_eq!((&said["level"], said["message"].as_str()), (&4.into(), Some(&*format!("failed pick 1: {reason}"))));
}

fn controller(of: u32, message: ControllerMessage) -> Record {
    Record::Controller { at: sample::seconds(1.0), controller: ControllerId(of), message }
}

fn heard(of: u32, state: ControllerState) -> Record {
    let message = FromController::Configured { generation: 1, state };
    controller(of, ControllerMessage::Heard { message })
}

fn configure(of: u32, limits: ControllerKind) -> Record {
    let message = ToController::Configure { generation: 1, speed: 1.0, limits, start: ControllerState::Device };
    controller(of, ControllerMessage::Told { leaf: None, message })
}

#[test]
fn frames_are_where_controllers_say() {
    let head = HeadSpec { neck: Point3::new(0.1, 0.0, 1.2), speed: 1.0, acceleration: 1.0 };
    let records = [
        Record::Header(Box::new(sample::header())),
        configure(1, ControllerKind::Head(head)),
        heard(0, ControllerState::Base { pose: Pose::new(1.0, 2.0, std::f64::consts::PI), velocity: Vector3::zeros() }),
        heard(2, ControllerState::Arm { gripper: Point3::new(0.5, 0.2, 0.9), velocity: Vector3::zeros(), holds: None }),
        heard(1, ControllerState::Head { angles: [0.0, 0.5], velocity: [0.0; 2] }),
    ];
    let told = messages(&records);
    let transforms: Vec<Value> =
        of(Topic::Transforms, &told).into_iter().map(|one| one["transforms"][0].clone()).collect();
    let ways: Vec<_> =
        transforms.iter().map(|one| format!("{}→{}", one["parent_frame_id"], one["child_frame_id"])).collect();
    let expected = ["\"map\"→\"base\"", "\"map\"→\"base\"", "\"base\"→\"left_gripper\"", "\"base\"→\"head\""];
    assert_eq!(ways, expected);
    assert_eq!(transforms[2]["translation"], serde_json::json!({"x": 0.5, "y": 0.2, "z": 0.9}));
    assert_eq!(transforms[3]["translation"]["z"], 1.2);
    let poses = of(Topic::Pose, &told);
    assert_eq!((&poses[1]["frame_id"], &poses[1]["pose"]["position"]["y"]), (&"map".into(), &2.0.into()));
    assert_eq!(poses[1]["pose"]["orientation"]["z"], 1.0);
}

#[test]
fn what_got_lost_is_told_again() {
    let records = sample::experiment_1();
    let Record::Header(header) = &records[0] else { panic!("a header") };
    let (mut history, mut recording) = (History::new(header), Recording::new(WallClock::NONE, None));
    let mut topics = |record: &Record, recording: &mut Recording| -> Vec<Topic> {
        history.apply(record);
        recording.take(&history, record).iter().map(|message| message.topic).collect()
    };
    let all = [Topic::Tree, Topic::State, Topic::Resources, Topic::Pose, Topic::Transforms, Topic::Log];
    assert_eq!(topics(&records[0], &mut recording), all);
    assert_eq!(topics(&records[1], &mut recording), [Topic::State, Topic::Log]);
    let told = recording.dropped(Time(5), 3, 7);
    assert_eq!((told.topic, told.body.as_str()), (Topic::Dropped, r#"{"missing":3,"total":7}"#));
    assert_eq!(topics(&records[2], &mut recording), all);
}
