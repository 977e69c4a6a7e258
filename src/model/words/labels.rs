//! Objects, places and resources between daemon and controllers: ids on the one side, names on the other. The one place where either
//! becomes the other.

use std::collections::BTreeMap;

use arrayvec::ArrayString;

use super::{Command, ControllerState, FromController, Names, ObjectId, PlaceId, Rejection, ResourceId, ToController};

/// Longest name of an object, a place or a resource, bytes: files know none that is longer.
pub const NAME_MAX: usize = 64;

/// Name of an object, a place or a resource as a controller knows it.
pub type Name = ArrayString<NAME_MAX>;

/// What the objects and places of a mission and the resources of its robot are called.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Labels {
    objects: Vec<Name>,
    places: Vec<Name>,
    resources: Vec<Name>,
    by_name: BTreeMap<Name, ObjectId>,
}

impl Labels {
    /// Those of a mission. Of a name that is longer than [`NAME_MAX`] only the beginning is told.
    pub fn new(names: &Names) -> Self {
        let labels = |names: &[String]| names.iter().map(|name| shortened(name)).collect::<Vec<_>>();
        let objects = labels(&names.objects);
        let by_name = objects.iter().enumerate().map(|(index, name)| (*name, ObjectId::from(index))).collect();
        Self { objects, places: labels(&names.places), resources: labels(&names.resources), by_name }
    }

    /// A message as the controller is to read it.
    pub fn told(&self, message: &ToController) -> ToController<Name, Name, Name> {
        match *message {
            ToController::Configure { generation, speed, limits, start } => {
                let start = self.named(start);
                ToController::Configure { generation, speed, limits, start }
            }
            ToController::Goal { id, mode, ref command } => {
                ToController::Goal { id, mode, command: self.command(command) }
            }
            ToController::Cancel { id } => ToController::Cancel { id },
        }
    }

    /// What a controller said.
    ///
    /// # Errors
    /// [`Rejection::NoSuchName`] where it says to hold an object that the mission does not have.
    pub fn heard(&self, message: FromController<Name>) -> Result<FromController, Rejection> {
        Ok(match message {
            FromController::Configured { generation, state } => {
                FromController::Configured { generation, state: self.identified(state)? }
            }
            FromController::Accepted { id, at } => FromController::Accepted { id, at },
            FromController::Rejected { id, why } => FromController::Rejected { id, why },
            FromController::Feedback { id, progress, state } => {
                FromController::Feedback { id, progress, state: self.identified(state)? }
            }
            FromController::Result { id, end, began, ended, state } => {
                FromController::Result { id, end, began, ended, state: self.identified(state)? }
            }
        })
    }

    /// The name of an object; empty for one that is not of this mission.
    pub fn object(&self, id: ObjectId) -> Name {
        self.objects.get(id.index()).copied().unwrap_or_default()
    }

    /// The name of a place; empty for one that is not of this mission.
    pub fn place(&self, id: PlaceId) -> Name {
        self.places.get(id.index()).copied().unwrap_or_default()
    }

    /// The name of a resource; empty for one that is not of this robot.
    pub fn resource(&self, id: ResourceId) -> Name {
        self.resources.get(id.index()).copied().unwrap_or_default()
    }

    fn command(&self, command: &Command) -> Command<Name, Name, Name> {
        let place = |place: Option<PlaceId>| place.map(|place| self.place(place));
        let holder = |holder: Option<ResourceId>| holder.map(|holder| self.resource(holder));
        match *command {
            Command::Drive { ref path, place: to } => Command::Drive { path: path.clone(), place: place(to) },
            Command::Stand => Command::Stand,
            Command::Grasp { object, at, place: from, holder: by } => {
                Command::Grasp { object: self.object(object), at, place: place(from), holder: holder(by) }
            }
            Command::Put { object, at, place: to, holder: into } => {
                Command::Put { object: self.object(object), at, place: place(to), holder: holder(into) }
            }
            Command::Look { at, place: to } => Command::Look { at, place: place(to) },
            Command::Call(ref call) => Command::Call(call.clone()),
        }
    }

    /// A state with the name of what is held.
    pub fn named(&self, state: ControllerState) -> ControllerState<Name> {
        with_held(state, |object| Ok(self.object(object))).unwrap_or(ControllerState::Device)
    }

    fn identified(&self, state: ControllerState<Name>) -> Result<ControllerState, Rejection> {
        with_held(state, |name| self.by_name.get(&name).copied().ok_or(Rejection::NoSuchName))
    }
}

/// The same state with another word for what is held.
fn with_held<A, B>(
    state: ControllerState<A>,
    other: impl FnOnce(A) -> Result<B, Rejection>,
) -> Result<ControllerState<B>, Rejection> {
    Ok(match state {
        ControllerState::Base { pose, velocity } => ControllerState::Base { pose, velocity },
        ControllerState::Arm { gripper, velocity, holds } => {
            ControllerState::Arm { gripper, velocity, holds: holds.map(other).transpose()? }
        }
        ControllerState::Head { angles, velocity } => ControllerState::Head { angles, velocity },
        ControllerState::Device => ControllerState::Device,
    })
}

fn shortened(name: &str) -> Name {
    let mut short = Name::new();
    for letter in name.chars() {
        if short.try_push(letter).is_err() {
            break;
        }
    }
    short
}

#[cfg(test)]
mod tests {
    use nalgebra::{Point3, Vector3};

    use super::*;

    fn arm<O>(holds: Option<O>) -> ControllerState<O> {
        ControllerState::Arm { gripper: Point3::origin(), velocity: Vector3::zeros(), holds }
    }

    fn configured<O>(state: ControllerState<O>) -> FromController<O> {
        FromController::Configured { generation: 1, state }
    }

    #[test]
    fn what_is_held_has_a_name_and_an_id() {
        let names = Names { objects: vec!["cup".into(), "é".repeat(40)], ..Names::default() };
        let labels = Labels::new(&names);
        let cup = labels.named(arm(Some(ObjectId(0))));
        assert_eq!(cup.holds().as_deref(), Some("cup"));
        assert_eq!(labels.heard(configured(cup)), Ok(configured(arm(Some(ObjectId(0))))));
        assert_eq!(labels.heard(configured(arm(None))), Ok(configured(arm(None))));
        let strange = Name::from("key").expect("it fits");
        assert_eq!(labels.heard(configured(arm(Some(strange)))), Err(Rejection::NoSuchName));
        assert_eq!(labels.object(ObjectId(1)).len(), NAME_MAX, "what does not fit is cut between letters");
    }
}
