//! The kinds of behavior as data: `move`, `pick` and `place` of the paper, with every parameter filled in.

use std::time::Duration;

use crate::model::{
    Access, BehaviorSpec, ChannelId, Claim, CommandTerm, Condition, EffectTerm, Keep, Mode, ObjectId, PlaceId, Pose,
    Potential, ResourceId, RobotSpec, Task, TypeId, Wanted,
};

/// Type of what holds objects.
pub(super) const GRIPPER: &str = "gripper";
/// Type of what looks.
pub(super) const HEAD: &str = "head";
/// Type of what drives.
pub(super) const BASE: &str = "base";

const MOVE_TIMEOUT: Duration = Duration::from_secs(600);
const HANDLE_TIMEOUT: Duration = Duration::from_secs(120);
const RETRIES: u32 = 2;

/// A behavior of the task with its names looked up.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Kind {
    /// Drive to a stand of a place.
    Move {
        to: Stop,
        /// Type whose available resources make the drive worth more.
        scale_by: Option<TypeId>,
    },
    /// Take an object, at a place if it is told.
    Pick { object: ObjectId, at: Option<PlaceId> },
    /// Set an object down, at a place if it is told.
    Place { object: ObjectId, at: Option<PlaceId> },
}

/// A stand of a place, map frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Stop {
    pub(super) place: PlaceId,
    pub(super) stand: Pose,
}

/// What a kind needs to know of robot, world and task.
#[derive(Debug, Clone, Copy)]
pub(super) struct Context<'a> {
    pub(super) robot: &'a RobotSpec,
    pub(super) types: Types,
    /// The stand of each place.
    pub(super) stands: &'a [Pose],
    /// Where each object is at the start.
    pub(super) starts: &'a [PlaceId],
    pub(super) tolerance_m: f64,
    /// Where the nearest `move` before it in its THEN goes.
    pub(super) before: Option<Stop>,
}

/// The types that the kinds use, as far as the robot has them.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct Types {
    pub(super) gripper: Option<TypeId>,
    pub(super) head: Option<TypeId>,
    pub(super) base: Option<TypeId>,
}

/// What keeps a behavior from being bound.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Lack {
    /// The robot has no resource of a type.
    Resource(&'static str),
    /// It is not told where to.
    Destination,
}

/// A resource and whether a controller moves it.
#[derive(Debug, Clone, Copy)]
struct Mover {
    resource: ResourceId,
    is_driven: bool,
}

impl Kind {
    /// The name of the kind.
    pub(super) fn word(&self) -> &'static str {
        match self {
            Self::Move { .. } => "move",
            Self::Pick { .. } => "pick",
            Self::Place { .. } => "place",
        }
    }

    /// Whether it takes or sets down: claims gripper and head, not only the base.
    pub(super) fn is_handling(&self) -> bool {
        match self {
            Self::Move { .. } => false,
            Self::Pick { .. } | Self::Place { .. } => true,
        }
    }

    /// The behavior with its terms filled in.
    ///
    /// # Errors
    /// What the robot or the task lacks for it.
    pub(super) fn bind(&self, context: &Context<'_>) -> Result<BehaviorSpec, Lack> {
        match *self {
            Self::Move { to, scale_by } => context.bind_move(to, scale_by),
            Self::Pick { object, at } => context.bind_pick(object, at),
            Self::Place { object, at } => context.bind_place(object, at),
        }
    }
}

impl Context<'_> {
    fn bind_move(&self, to: Stop, scale_by: Option<TypeId>) -> Result<BehaviorSpec, Lack> {
        let base = self.first(self.types.base).ok_or(Lack::Resource(BASE))?;
        let mut behavior = BehaviorSpec {
            kind: "move".to_owned(),
            claims: vec![Claim {
                wanted: Wanted::Named(base.resource),
                access: Access::Exclusive,
                keep: Keep::Intention(at_channel(to.place)),
            }],
            potential: Potential::Nearness { to: to.stand, floor_m: self.tolerance_m, scale_by },
            satisfied: self.at(to),
            precondition: Condition::Path { place: to.place, stand: to.stand },
            effects: Vec::new(),
            commands: Vec::new(),
            changes: Vec::new(),
            timeout: MOVE_TIMEOUT,
            retries: RETRIES,
        };
        if base.is_driven {
            behavior.commands.push(command(0, Mode::Achieve, Task::DriveTo(to.stand)));
        } else {
            behavior.effects.push(EffectTerm::Stands(to.stand));
        }
        Ok(behavior)
    }

    fn bind_pick(&self, object: ObjectId, at: Option<PlaceId>) -> Result<BehaviorSpec, Lack> {
        let gripper = self.types.gripper.ok_or(Lack::Resource(GRIPPER))?;
        let place = at.or(self.before.map(|stop| stop.place)).unwrap_or(self.starts[object.index()]);
        let stop = self.stop_at(place);
        let hand = Claim {
            wanted: Wanted::AnyEmpty { of: gripper, reaches: Some(object) },
            access: Access::Exclusive,
            keep: Keep::Physical(Access::Exclusive),
        };
        let mut behavior = self.handle("pick", object, stop, hand, Task::Grasp(object))?;
        let gripper_claim = behavior.claims.len() - 1;
        behavior.satisfied = Condition::Held(object);
        behavior.precondition = Condition::All(vec![self.at(stop), Condition::Free(object)]);
        behavior.effects = vec![EffectTerm::Taken(object, gripper_claim)];
        Ok(behavior)
    }

    fn bind_place(&self, object: ObjectId, at: Option<PlaceId>) -> Result<BehaviorSpec, Lack> {
        let place = at.or(self.before.map(|stop| stop.place)).ok_or(Lack::Destination)?;
        let stop = self.stop_at(place);
        let hand = Claim { wanted: Wanted::Holding(object), access: Access::Exclusive, keep: Keep::Release };
        let mut behavior = self.handle("place", object, stop, hand, Task::Put(object, place))?;
        behavior.satisfied = Condition::Lies(object, place);
        behavior.precondition = Condition::All(vec![self.at(stop), Condition::Held(object)]);
        behavior.effects = vec![EffectTerm::Lies(object, place)];
        Ok(behavior)
    }

    /// What `pick` and `place` have in common; conditions and effects are theirs.
    fn handle(&self, kind: &str, object: ObjectId, stop: Stop, hand: Claim, task: Task) -> Result<BehaviorSpec, Lack> {
        let base = self.first(self.types.base).ok_or(Lack::Resource(BASE))?;
        let gripper = self.first(self.types.gripper).ok_or(Lack::Resource(GRIPPER))?;
        let shared = |mover: Mover| Claim {
            wanted: Wanted::Named(mover.resource),
            access: at_channel(stop.place),
            keep: Keep::Release,
        };
        let head = self.first(self.types.head);
        let mut claims = vec![shared(base)];
        claims.extend(head.map(shared));
        claims.push(hand);

        let arm = (gripper, claims.len() - 1, Mode::Achieve, task);
        let head = head.map(|head| (head, 1, Mode::Maintain, Task::LookAt(stop.place)));
        let base = (base, 0, Mode::Maintain, Task::Stand);
        let commands = [Some(arm), head, Some(base)].into_iter().flatten();
        Ok(BehaviorSpec {
            kind: kind.to_owned(),
            claims,
            potential: Potential::Constant(self.above_any_move()),
            satisfied: Condition::Never,
            precondition: Condition::All(Vec::new()),
            effects: Vec::new(),
            commands: commands
                .filter(|(mover, ..)| mover.is_driven)
                .map(|(_, claim, mode, task)| command(claim, mode, task))
                .collect(),
            changes: vec![object],
            timeout: HANDLE_TIMEOUT,
            retries: RETRIES,
        })
    }

    /// A potential that no `move` reaches, whatever type it is scaled by.
    fn above_any_move(&self) -> f64 {
        let types = self.robot.resources.iter().map(|resource| resource.ty);
        let most = types.map(|ty| self.robot.of_type(ty).count()).max().unwrap_or(1);
        1.0 + most as f64 / self.tolerance_m
    }

    /// The stand at a place: where the `move` before goes, if it goes there.
    fn stop_at(&self, place: PlaceId) -> Stop {
        match self.before {
            Some(stop) if stop.place == place => stop,
            Some(_) | None => Stop { place, stand: self.stands[place.index()] },
        }
    }

    fn at(&self, stop: Stop) -> Condition {
        Condition::At { place: stop.place, stand: stop.stand, tolerance_m: self.tolerance_m }
    }

    fn first(&self, ty: Option<TypeId>) -> Option<Mover> {
        let resource = self.robot.of_type(ty?).next()?;
        let is_driven = self.robot.resources[resource.index()].controller.is_some();
        Some(Mover { resource, is_driven })
    }
}

/// The intention of being at a place; channels are in the order of the places.
fn at_channel(place: PlaceId) -> Access {
    Access::Shared(ChannelId(place.0))
}

fn command(claim: usize, mode: Mode, task: Task) -> CommandTerm {
    CommandTerm { claim, mode, task }
}
