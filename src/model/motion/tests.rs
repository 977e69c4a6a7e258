//! Arm, base and head against their limits at every sample, whatever they are told and whenever they are stopped.

use nalgebra::{Point3, Vector3};
use proptest::prelude::*;

use super::*;
use crate::{ArmSpec, BaseSpec, Call, HeadSpec, NO_ARGUMENTS, Pose};

const BASE: BaseSpec = BaseSpec { speed: 0.8, acceleration: 0.5, turn_speed: 1.0, turn_acceleration: 1.5 };
const ARM: ArmSpec = ArmSpec {
    shoulder: Point3::new(-0.05, 0.188, 0.79),
    tuck: Point3::new(0.25, 0.3, 0.9),
    reach_m: 0.9,
    speed: 0.5,
    acceleration: 1.0,
    grip_s: 1.0,
    lift_m: 0.1,
};
const HEAD: HeadSpec = HeadSpec { neck: Point3::new(-0.02, 0.0, 1.2), speed: 1.5, acceleration: 5.0 };
/// More steps than any goal of these tests takes.
const MAX_STEPS: usize = 100_000;

fn moving(state: &ControllerState) -> (Vec<f64>, f64, f64) {
    match state {
        ControllerState::Base { velocity, .. } => (velocity.as_slice().to_vec(), BASE.speed, BASE.acceleration),
        ControllerState::Arm { velocity, .. } => (velocity.as_slice().to_vec(), ARM.speed, ARM.acceleration),
        ControllerState::Head { velocity, .. } => (velocity.to_vec(), HEAD.speed, HEAD.acceleration),
        ControllerState::Device => unreachable!("a device does not move"),
    }
}

/// Each group of coordinates that has a limit of its own.
fn speeds(of: &[f64], state: &ControllerState) -> Vec<f64> {
    match state {
        ControllerState::Base { .. } => {
            vec![of[0].hypot(of[1]), of[2] * BASE.speed / BASE.turn_speed]
        }
        ControllerState::Arm { .. } => vec![Vector3::from_row_slice(of).norm()],
        ControllerState::Head { .. } | ControllerState::Device => of.to_vec(),
    }
}

fn assert_limits(before: &ControllerState, now: &ControllerState) {
    let (velocity, speed, acceleration) = moving(now);
    let change: Vec<f64> =
        velocity.iter().zip(moving(before).0).map(|(now, before)| (now - before) / STEP.as_secs_f64()).collect();
    for found in speeds(&velocity, now) {
        assert!(found.abs() <= speed, "{now:?} is faster than {speed}");
    }
    let turn_allowed = BASE.turn_acceleration * BASE.speed / BASE.turn_speed;
    for (group, found) in speeds(&change, now).into_iter().enumerate() {
        let is_turn = group == 1 && matches!(now, ControllerState::Base { .. });
        let allowed = if is_turn { turn_allowed } else { acceleration };
        assert!(found.abs() <= allowed, "{before:?} to {now:?} is more than {allowed}");
    }
}

/// Steps until the command ends or is maintained, told to stop after `cancel_at` steps; gives each state.
fn run(controller: &mut dyn Controller, cancel_at: Option<usize>) -> (Progress, Vec<ControllerState>) {
    let mut states = vec![controller.state()];
    let mut done = 0.0;
    for step in 0..MAX_STEPS {
        if cancel_at == Some(step) {
            controller.cancel();
        }
        let progress = controller.step();
        states.push(controller.state());
        assert_limits(&states[step], &states[step + 1]);
        match progress {
            Progress::Running(now) => {
                assert!((done..=1.0).contains(&now), "progress {done} then {now}");
                done = now;
                if now == 1.0 && cancel_at.is_none() {
                    return (progress, states);
                }
            }
            Progress::Idle | Progress::Ended(_) => return (progress, states),
        }
    }
    panic!("it does not end");
}

fn look(x: f64, y: f64, z: f64) -> Command {
    Command::Look { at: Point3::new(x, y, z), place: None }
}

fn object_named(number: u32) -> Name {
    Name::from(&format!("object {number}")).expect("it fits")
}

fn grasp(object: u32, x: f64, y: f64, z: f64) -> Command {
    Command::Grasp { object: object_named(object), at: Point3::new(x, y, z), place: None, holder: None }
}

fn put(object: u32, x: f64, y: f64, z: f64) -> Command {
    Command::Put { object: object_named(object), at: Point3::new(x, y, z), place: None, holder: None }
}

fn drive(path: &[(f64, f64, f64)]) -> Command {
    Command::Drive { path: path.iter().map(|&(x, y, h)| Pose::new(x, y, h)).collect(), place: None }
}

fn all() -> [Box<dyn Controller + Send>; 3] {
    [ControllerKind::Arm(ARM), ControllerKind::Base(BASE), ControllerKind::Head(HEAD)].map(|kind| simulated(&kind))
}

/// A command and what arm, base and head say to it.
type Row = (Command, Mode, [Result<(), Rejection>; 3]);

fn arm_rows() -> Vec<Row> {
    use Mode::{Achieve, Maintain};
    use Rejection::{NotFinite, OutOfReach, Unsupported};
    let row = |command, mode, arm| (command, mode, [arm, Err(Unsupported), Err(Unsupported)]);
    let near = grasp(1, 0.5, 0.2, 0.75);
    vec![
        row(near.clone(), Achieve, Ok(())),
        row(near, Maintain, Err(Unsupported)),
        row(grasp(1, 1.5, 0.2, 0.75), Achieve, Err(OutOfReach)),
        row(grasp(1, 1e300, 0.2, 0.75), Achieve, Err(OutOfReach)),
        row(grasp(1, f64::NAN, 0.2, 0.75), Achieve, Err(NotFinite)),
        row(put(1, 0.5, 0.2, 0.75), Achieve, Err(Unsupported)),
    ]
}

fn base_rows() -> Vec<Row> {
    use Mode::{Achieve, Maintain};
    use Rejection::{Malformed, NotFinite, Unsupported};
    let row = |command, mode, base| (command, mode, [Err(Unsupported), base, Err(Unsupported)]);
    let ahead = drive(&[(1.0, 0.0, 0.0)]);
    let nowhere = drive(&[(0.0, f64::INFINITY, 0.0)]);
    vec![
        row(ahead.clone(), Achieve, Ok(())),
        row(ahead, Maintain, Err(Unsupported)),
        row(drive(&[]), Achieve, Err(Malformed)),
        row(nowhere, Achieve, Err(NotFinite)),
        row(drive(&[(0.0, 1e300, 0.0)]), Achieve, Err(Malformed)),
        (Command::Stand, Achieve, [Ok(()); 3]),
        (Command::Stand, Maintain, [Ok(()); 3]),
    ]
}

fn head_rows() -> Vec<Row> {
    use Mode::{Achieve, Maintain};
    use Rejection::{NotFinite, Unsupported};
    let row = |command, mode, head| (command, mode, [Err(Unsupported), Err(Unsupported), head]);
    vec![
        row(look(1.0, 1.0, 0.7), Achieve, Ok(())),
        row(look(1.0, 1.0, 0.7), Maintain, Ok(())),
        row(look(1.0, f64::NAN, 0.7), Maintain, Err(NotFinite)),
    ]
}

#[test]
fn each_takes_what_it_can_do_and_nothing_else() {
    let rows = [arm_rows(), base_rows(), head_rows()].concat();
    for (command, mode, expected) in rows {
        for (mut controller, expected) in all().into_iter().zip(expected) {
            let about = format!("{command:?} {mode:?} {:?}", controller.state());
            assert_eq!(controller.start(&command, mode), expected, "{about}");
            let again = controller.start(&command, mode);
            assert_eq!(again, expected.and(Err(Rejection::Busy)), "{about}");
        }
    }
}

#[test]
fn an_arm_takes_and_gives_back() {
    let mut arm = Arm::new(ARM);
    arm.start(&grasp(3, 0.6, 0.1, 0.75), Mode::Achieve).unwrap();
    let (end, states) = run(&mut arm, None);
    assert_eq!(end, Progress::Ended(PartEnd::Succeeded));
    let held = |state: &ControllerState| match state {
        ControllerState::Arm { holds, gripper, .. } => (*holds, *gripper),
        ControllerState::Base { .. } | ControllerState::Head { .. } | ControllerState::Device => panic!("not an arm"),
    };
    let taken = states.iter().find(|state| held(state).0.is_some()).unwrap();
    assert_eq!(held(taken), (Some(object_named(3)), Point3::new(0.6, 0.1, 0.75)));
    assert_eq!(held(&arm.state()), (Some(object_named(3)), ARM.tuck));

    let other = arm.start(&put(4, 0.6, 0.1, 0.75), Mode::Achieve);
    assert_eq!(other, Err(Rejection::Unsupported));
    let second = arm.start(&grasp(4, 0.6, 0.1, 0.75), Mode::Achieve);
    assert_eq!(second, Err(Rejection::Busy));

    arm.start(&put(3, 0.5, 0.4, 0.75), Mode::Achieve).unwrap();
    assert_eq!(run(&mut arm, None).0, Progress::Ended(PartEnd::Succeeded));
    assert_eq!(held(&arm.state()), (None, ARM.tuck));
}

#[test]
fn maintained_commands_last_until_they_are_canceled() {
    let still = [0, 1, 2].map(|index| (Command::Stand, index));
    let commands = [still.to_vec(), vec![(look(1.0, -1.0, 0.7), 2)]].concat();
    for (command, index) in commands {
        let [arm, base, head] = all();
        let mut controller = [arm, base, head].into_iter().nth(index).unwrap();
        controller.start(&command, Mode::Maintain).unwrap();
        assert_eq!(run(controller.as_mut(), None).0, Progress::Running(1.0));
        assert_eq!(controller.step(), Progress::Running(1.0));
        assert_eq!(controller.start(&command, Mode::Maintain), Err(Rejection::Busy));
        controller.cancel();
        assert_eq!(controller.step(), Progress::Ended(PartEnd::Canceled));
        assert_eq!(controller.step(), Progress::Idle);
        controller.start(&command, Mode::Achieve).unwrap();
        assert_eq!(run(controller.as_mut(), None).0, Progress::Ended(PartEnd::Succeeded));
    }
}

#[test]
fn a_head_looks_left_and_down() {
    let mut head = Head::new(HEAD);
    head.start(&look(0.98, 1.0, 1.2), Mode::Achieve).unwrap();
    run(&mut head, None);
    let ControllerState::Head { angles, .. } = head.state() else { panic!("not a head") };
    assert!((angles[0] - std::f64::consts::FRAC_PI_4).abs() < 1e-12 && angles[1].abs() < 1e-12);
    head.start(&look(0.98, 0.0, 0.2), Mode::Achieve).unwrap();
    run(&mut head, None);
    let ControllerState::Head { angles, .. } = head.state() else { panic!("not a head") };
    assert!(angles[0].abs() < 1e-12 && (angles[1] - std::f64::consts::FRAC_PI_4).abs() < 1e-12);
}

#[test]
fn a_start_state_is_taken_only_by_its_own_kind() {
    let states = [
        ControllerState::Arm {
            gripper: Point3::new(0.3, 0.3, 0.9),
            velocity: Vector3::zeros(),
            holds: Some(object_named(2)),
        },
        ControllerState::Base { pose: Pose::new(1.0, 2.0, 3.0), velocity: Vector3::zeros() },
        ControllerState::Head { angles: [0.1, 0.2], velocity: [0.0; 2] },
    ];
    let limits = [ControllerKind::Arm(ARM), ControllerKind::Base(BASE), ControllerKind::Head(HEAD)];
    for (kind, mut controller) in all().into_iter().enumerate() {
        for (index, &state) in states.iter().enumerate() {
            let before = controller.state();
            let expected = if index == kind { state } else { before };
            assert_eq!(controller.configure(&limits[kind], state), expected);
            assert_eq!(controller.state(), expected);
        }
    }
}

#[test]
fn a_turn_takes_the_shorter_way() {
    let mut base = Base::new(BASE);
    base.start(&drive(&[(0.0, 0.0, 3.0), (0.0, 0.0, -3.0)]), Mode::Achieve).unwrap();
    let (_, states) = run(&mut base, None);
    assert!(states.len() < 500, "{} steps", states.len());
    let ControllerState::Base { pose, .. } = base.state() else { panic!("not a base") };
    assert_eq!(pose, Pose::new(0.0, 0.0, -3.0));
}

fn pose() -> impl Strategy<Value = (f64, f64, f64)> {
    (-10.0..10.0f64, -10.0..10.0f64, -7.0..7.0f64)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]

    #[test]
    fn a_base_keeps_its_limits_and_arrives(path in prop::collection::vec(pose(), 1..4), cancel in 0..4000usize) {
        let goal = *path.last().unwrap();
        let mut base = Base::new(BASE);
        let mut twin = Base::new(BASE);
        base.start(&drive(&path), Mode::Achieve).unwrap();
        twin.start(&drive(&path), Mode::Achieve).unwrap();
        let (end, states) = run(&mut base, None);
        prop_assert_eq!(end, Progress::Ended(PartEnd::Succeeded));
        prop_assert_eq!(&states, &run(&mut twin, None).1);
        let there = ControllerState::Base { pose: Pose::new(goal.0, goal.1, goal.2), velocity: Vector3::zeros() };
        prop_assert_eq!(base.state(), there);

        let mut stopped = Base::new(BASE);
        stopped.start(&drive(&path), Mode::Achieve).unwrap();
        let (end, short) = run(&mut stopped, Some(cancel));
        let expected = if cancel + 1 < states.len() { PartEnd::Canceled } else { PartEnd::Succeeded };
        prop_assert_eq!(end, Progress::Ended(expected));
        let same = (cancel + 1).min(states.len());
        prop_assert_eq!(&short[..same], &states[..same]);
        prop_assert_eq!(moving(&stopped.state()).0, vec![0.0; 3]);
        stopped.start(&drive(&path), Mode::Achieve).unwrap();
        run(&mut stopped, None);
        prop_assert_eq!(stopped.state(), there);
    }

    #[test]
    fn an_arm_keeps_its_limits(x in 0.2..0.6f64, y in -0.2..0.5f64, z in 0.5..1.1f64, cancel in 0..800usize) {
        let mut arm = Arm::new(ARM);
        arm.start(&grasp(1, x, y, z), Mode::Achieve).unwrap();
        let (end, _) = run(&mut arm, Some(cancel));
        prop_assert!(matches!(end, Progress::Ended(PartEnd::Canceled | PartEnd::Succeeded)));
        let ControllerState::Arm { holds, gripper, .. } = arm.state() else { panic!("not an arm") };
        prop_assert!((gripper - ARM.shoulder).norm() <= ARM.reach_m + 1e-9);
        let next = if holds.is_some() { put(1, y, 0.1, z) } else { grasp(1, 0.4, y, z) };
        arm.start(&next, Mode::Achieve).unwrap();
        prop_assert_eq!(run(&mut arm, None).0, Progress::Ended(PartEnd::Succeeded));
    }

    #[test]
    fn a_head_keeps_its_limits(points in prop::collection::vec(pose(), 1..4), cancel in 0..300usize) {
        let mut head = Head::new(HEAD);
        for (x, y, z) in points {
            head.start(&look(x, y, z), Mode::Maintain).unwrap();
            let (end, _) = run(&mut head, Some(cancel));
            prop_assert_eq!(end, Progress::Ended(PartEnd::Canceled));
        }
    }
}

#[test]
fn a_call_takes_its_time_whoever_does_it() {
    let call = Call { name: "scan".into(), with: NO_ARGUMENTS.into(), takes: STEP * 3 };
    let command = Command::Call(call);
    let kinds =
        [ControllerKind::Arm(ARM), ControllerKind::Base(BASE), ControllerKind::Head(HEAD), ControllerKind::Device];
    for kind in kinds {
        let mut controller = simulated(&kind);
        assert_eq!(controller.start(&command, Mode::Achieve), Ok(()));
        assert_eq!(controller.start(&command, Mode::Achieve), Err(Rejection::Busy));
        let steps: Vec<_> = (0..3).map(|_| controller.step()).collect();
        assert!(matches!(steps[..], [Progress::Running(_), Progress::Running(_), Progress::Ended(PartEnd::Succeeded)]));
        assert_eq!(controller.start(&command, Mode::Maintain), Ok(()));
        for _ in 0..100 {
            assert_eq!(controller.step(), Progress::Running(1.0));
        }
        controller.cancel();
        assert_eq!(controller.step(), Progress::Ended(PartEnd::Canceled));
    }
    let mut device = simulated(&ControllerKind::Device);
    assert_eq!(device.start(&Command::Stand, Mode::Achieve), Err(Rejection::Unsupported));
}
