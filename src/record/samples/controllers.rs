//! One message of every kind between runtime and controllers.

use std::time::Duration;

use nalgebra::{Point3, Vector3};

use ambidex_model::*;

use super::{goal, id};

/// One message of every kind.
pub(super) fn messages() -> Vec<ControllerMessage> {
    let at = Point3::new(0.5, 0.25, 1.0);
    let (object, place) = (ObjectId(0), PlaceId(0));
    let path = vec![Pose::new(1.0, 2.0, 0.5)];
    let commands = [
        Command::Drive { path, place: Some(place) },
        Command::Stand,
        Command::Grasp { object, at, place: None, holder: None },
        Command::Grasp { object, at, place: None, holder: Some(ResourceId(1)) },
        Command::Put { object, at, place: Some(place), holder: None },
        Command::Look { at, place: Some(place) },
        Command::Call(Call { name: "scan".into(), with: NO_ARGUMENTS.into(), takes: Duration::from_secs(2) }),
    ];
    let leaf = NodeId(2);
    let mut messages = vec![
        ControllerMessage::Attached,
        ControllerMessage::Joined { leaf, id: id() },
        ControllerMessage::Lost { why: Loss::Ended },
        ControllerMessage::Lost { why: Loss::Silent },
        ControllerMessage::Lost { why: Loss::Left { away_ms: 1200 } },
        ControllerMessage::Lost { why: Loss::Unanswered },
        ControllerMessage::Lost { why: Loss::Broken },
        ControllerMessage::Lost { why: Loss::Inhibited(Inhibition::ByHand) },
        ControllerMessage::Lost { why: Loss::HoldsUnknown },
    ];
    messages.extend(states().map(|start| ControllerMessage::Told {
        leaf: None,
        message: ToController::Configure {
            generation: 1,
            speed: 20.0,
            limits: ControllerKind::Base(BaseSpec {
                speed: 1.0,
                acceleration: 0.5,
                turn_speed: 1.0,
                turn_acceleration: 1.0,
            }),
            start,
        },
    }));
    messages.extend(commands.map(goal));
    messages.push(ControllerMessage::Told { leaf: Some(leaf), message: ToController::Cancel { id: id() } });
    messages.extend(heard().into_iter().map(|message| ControllerMessage::Heard { message }));
    let reports = [
        (Report::fact("door open", true), Misreport::NotAllowed),
        (Report::fact("door open", false), Misreport::NoSuchFact),
        (Report::object("cup", Some("moon")), Misreport::NoSuchPlace),
        (Report::object("cup", None), Misreport::NoSuchObject),
    ];
    messages.extend(reports.map(|(report, why)| ControllerMessage::Misreported { report, why }));
    messages.extend(diagnoses());
    messages.extend(REJECTIONS.map(|why| ControllerMessage::Refused { id: Some(id()), why }));
    messages
}

fn diagnoses() -> impl Iterator<Item = ControllerMessage> {
    let values = Vitals {
        heartbeat_age_ms: Some(120),
        worst_gap_ms: Some(410),
        states_per_s: 12,
        attachments: 2,
        generation: 3,
        refused: 4,
        foreign: 5,
        queued: 6,
        last_fault: Some(Trouble::Lost(Loss::Hung)),
        inhibited: Some(Inhibition::Fault),
        hung: true,
    };
    let troubles = [
        Trouble::Rejected(Rejection::Busy),
        Trouble::Aborted,
        Trouble::Refused(Rejection::Stale),
        Trouble::Misreported(Misreport::NotAllowed),
        Trouble::Lost(Loss::Ended),
    ];
    let others = [
        Diagnosis::Serves,
        Diagnosis::Unconfigured,
        Diagnosis::Late,
        Diagnosis::Doubled,
        Diagnosis::Backlog,
        Diagnosis::Lost(Loss::Silent),
        Diagnosis::Unheard(Rejection::Version),
        Diagnosis::Absent,
    ];
    let all = others
        .into_iter()
        .chain(troubles.map(Diagnosis::Troubled))
        .zip([values, Vitals::default()].into_iter().cycle());
    all.map(|(message, values)| ControllerMessage::Diagnosed {
        level: message.level(),
        message,
        values: Box::new(values),
    })
}

const REJECTIONS: [Rejection; 9] = [
    Rejection::Version,
    Rejection::Stale,
    Rejection::Unknown,
    Rejection::Malformed,
    Rejection::NotFinite,
    Rejection::NotConfigured,
    Rejection::Unsupported,
    Rejection::OutOfReach,
    Rejection::Busy,
];

fn heard() -> Vec<FromController> {
    let id = id();
    let [state, ..] = states();
    let mut heard = vec![
        FromController::Configured { generation: 1, state },
        FromController::Accepted { id, at: Time(17) },
        FromController::Rejected { id, why: Rejection::OutOfReach },
        FromController::Feedback { id, progress: 0.5, state },
    ];
    let ends = [PartEnd::Succeeded, PartEnd::Aborted, PartEnd::Canceled];
    heard.extend(ends.map(|end| FromController::Result { id, end, began: Time(20), ended: Time(40), state }));
    heard
}

fn states() -> [ControllerState; 4] {
    let (at, velocity) = (Point3::new(0.5, 0.25, 1.0), Vector3::zeros());
    [
        ControllerState::Base { pose: Pose::new(7.0, 3.5, 0.0), velocity },
        ControllerState::Arm { gripper: at, velocity, holds: Some(ObjectId(0)) },
        ControllerState::Head { angles: [0.5, -0.25], velocity: [0.0, 0.0] },
        ControllerState::Device,
    ]
}
