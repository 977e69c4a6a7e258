//! Which event comes of which record, as a subscriber sees it.

use std::fmt::Debug;
use std::sync::{Arc, Mutex};

use tracing::field::{Field, Visit};
use tracing::{Event, Subscriber};
use tracing_subscriber::layer::{Context, Layer, SubscriberExt};

use super::{diagnosed, emit};
use ambidex_model::*;
use ambidex_record::samples;

/// Keeps every event as one line: level, target, message, fields.
#[derive(Clone, Default)]
struct Capture(Arc<Mutex<Vec<String>>>);

#[derive(Default)]
struct Fields {
    message: String,
    others: String,
}

impl Visit for Fields {
    fn record_str(&mut self, field: &Field, value: &str) {
        self.record_debug(field, &format_args!("{value}"));
    }

    fn record_debug(&mut self, field: &Field, value: &dyn Debug) {
        match field.name() {
            "message" => self.message = format!("{value:?}"),
            name => self.others += &format!(" {name}=[{value:?}]"),
        }
    }
}

impl<S: Subscriber> Layer<S> for Capture {
    fn on_event(&self, event: &Event<'_>, _: Context<'_, S>) {
        let mut fields = Fields::default();
        event.record(&mut fields);
        let (level, target) = (event.metadata().level(), event.metadata().target());
        let line = format!("{level} {target} {}{}", fields.message, fields.others);
        self.0.lock().unwrap().push(line);
    }
}

fn events(records: &[Record]) -> Vec<String> {
    let names = samples::names();
    events_of(|| records.iter().for_each(|record| emit(record, &names)))
}

fn events_of(work: impl FnOnce()) -> Vec<String> {
    let capture = Capture::default();
    let subscriber = tracing_subscriber::registry().with(capture.clone());
    tracing::subscriber::with_default(subscriber, work);
    std::mem::take(&mut *capture.0.lock().unwrap())
}

fn check(record: Record, expected: &[&str]) {
    assert_eq!(events(&[record]), expected);
}

#[test]
fn messages_between_nodes_name_who_tells_whom() {
    let from_leaf = |message| Record::Sent { at: Time(1_500_000), round: 3, from: NodeId(2), to: NodeId(1), message };
    check(samples::activation(), &["TRACE ambidex::tree activation round=[3] from=[root] to=[both] at_s=[1.5]"]);
    check(
        from_leaf(samples::answer(Some(samples::request()), Vec::new())),
        &["DEBUG ambidex::tree answer round=[3] from=[pick 1] to=[both] at_s=[1.5] \
           feasible=[true] potential=[8.5] running=[false] satisfied=[false] asking=[pick 1] \
           claims=[base for \"at shelf\", left_gripper or right_gripper alone] skips=[pick 1]"],
    );
    let reason = Reason::NotAt { place: PlaceId(0) };
    let blocked = |leaf| Blocked { leaf, reason: reason.clone() };
    let says_no = |leaf| samples::answer(None, vec![blocked(leaf)]);
    let expected = |level| {
        format!(
            "{level} ambidex::tree answer round=[3] from=[pick 1] to=[both] at_s=[1.5] \
             feasible=[false] running=[false] satisfied=[false] asking=[] \
             reason=[the base does not stand at shelf]"
        )
    };
    check(from_leaf(says_no(NodeId(2))), &[&expected("DEBUG")]);
    check(from_leaf(says_no(NodeId(3))), &[&expected("TRACE")]);
    check(
        samples::sent(Message::Verdict { granted: vec![NodeId(2), NodeId(3)], stopped: Vec::new() }),
        &["TRACE ambidex::tree verdict round=[3] from=[root] to=[both] at_s=[1.5] \
           granted=[pick 1, pick 2]"],
    );
}

#[test]
fn a_release_says_how_and_what_follows() {
    check(
        samples::sent(Message::Release { leaf: NodeId(2), end: End::Succeeded }),
        &["TRACE ambidex::tree release round=[3] from=[root] to=[both] at_s=[1.5] \
           leaf=[pick 1] end=[succeeded]"],
    );
    check(
        Record::Released {
            at: Time(2_000_000),
            leaf: NodeId(2),
            end: End::Failed(Fault::Aborted(ControllerId(1))),
            consequences: Consequences { completed: None, failed: Some(NodeId(1)), failing: None, cleaned: None },
            changes: vec![Change::Object(ObjectId(0), Location::Unknown)],
            waits_until: None,
            unfit: Vec::new(),
        },
        &["WARN ambidex::mission goal ended leaf=[pick 1] end=[failed: aborted] \
           controller=[left_arm] fails=[both] changes=[cup nobody knows where] at_s=[2.0]"],
    );
}

#[test]
fn a_granted_round_is_told_with_its_bindings() {
    let events = events(&[samples::decided(vec![samples::grant()], None)]);
    assert_eq!(
        events,
        [
            "INFO ambidex::mission round granted round=[3] granted=[pick 1] refused=[47] at_s=[1.5]",
            "DEBUG ambidex::mission grant round=[3] leaf=[pick 1] potential=[8.5] \
             claims=[base for \"at shelf\", base for \"at shelf\", left_gripper alone] at_s=[1.5]",
        ]
    );
}

#[test]
fn messages_of_controllers_name_controller_and_goal() {
    let heard = |message| samples::told(ControllerMessage::Heard { message });
    let (object, at) = (ObjectId(0), nalgebra::Point3::origin());
    check(
        samples::told(samples::goal(Command::Grasp { object, at, place: None, holder: None })),
        &["TRACE ambidex::controller goal controller=[left_arm] goal=[1.7] leaf=[pick 1] \
           mode=[achieve] command=[grasp cup] at_s=[1.75]"],
    );
    check(
        heard(FromController::Rejected { id: samples::id(), why: Rejection::OutOfReach }),
        &["WARN ambidex::controller rejected controller=[left_arm] goal=[1.7] \
           reason=[the point is out of reach] at_s=[1.75]"],
    );
    let state = ControllerState::Head { angles: [0.0; 2], velocity: [0.0; 2] };
    check(
        heard(FromController::Feedback { id: samples::id(), progress: 0.5, state }),
        &["TRACE ambidex::controller feedback controller=[left_arm] goal=[1.7] progress=[0.5] at_s=[1.75]"],
    );
    check(
        samples::told(ControllerMessage::Lost { why: ambidex_model::Loss::Silent }),
        &["WARN ambidex::controller lost controller=[left_arm] at_s=[1.75] why=[it showed no life for 1 s]"],
    );
}

#[test]
fn a_diagnosis_is_news_when_the_level_is_another() {
    let message = Diagnosis::Lost(Loss::Silent);
    let values = Vitals {
        heartbeat_age_ms: Some(2100),
        attachments: 1,
        last_fault: Some(Trouble::Lost(Loss::Silent)),
        ..Vitals::default()
    };
    let diagnostics = Diagnostics { controller: ControllerId(1), level: message.level(), message, values };
    let fields = "ambidex::diagnostics it showed no life for 1 s controller=[left_arm] level=[STALE] \
                  heartbeat_age_ms=[2100] states_per_s=[0] attachments=[1] generation=[0] refused=[0] foreign=[0] \
                  queued=[0] last_fault=[it showed no life for 1 s] hung=[false] at_s=[3.5]";
    for (is_change, level) in [(true, "INFO"), (false, "DEBUG")] {
        let said = events_of(|| diagnosed(Time(3_500_000), &diagnostics, is_change, &samples::names()));
        assert_eq!(said, [format!("{level} {fields}")]);
    }
}

#[test]
fn every_record_has_its_event() {
    for record in samples::records() {
        let is_told_again = matches!(
            record,
            Record::Told { .. }
                | Record::Observed { .. }
                | Record::Turn { .. }
                | Record::Began { .. }
                | Record::Controller { message: ControllerMessage::Diagnosed { .. }, .. }
        );
        assert_eq!(is_told_again, events(std::slice::from_ref(&record)).is_empty(), "{record:?}");
    }
}

#[test]
fn the_end_of_a_mission_is_as_loud_as_it_is_bad() {
    let levels: Vec<String> = events(&samples::records())
        .into_iter()
        .filter(|line| line.contains("mission ended"))
        .map(|line| line.split(' ').next().unwrap_or_default().to_owned())
        .collect();
    assert_eq!(levels, ["INFO", "WARN", "WARN", "INFO", "ERROR", "ERROR", "ERROR", "ERROR"]);
}

#[test]
fn a_resource_has_the_five_properties_of_the_paper() {
    let [held, free] = samples::resources();
    check(
        held,
        &["DEBUG ambidex::mission resource resource=[base] owners=[1] channel=[at shelf] locked=[true] \
           holders=[pick 1] at_s=[1.5]"],
    );
    check(free, &["DEBUG ambidex::mission resource resource=[base] owners=[0] locked=[false] holders=[] at_s=[1.5]"]);
}
