//! Objects, places, facts and resources between daemon and controllers: ids on the one side, names on the other. The one
//! place where either becomes the other.

use std::collections::BTreeMap;

use super::name::shortened;
use super::{
    Change, Command, ControllerState, FactId, FromController, Location, Misreport, Name, Names, ObjectId, PlaceId,
    Rejection, Report, ResourceId, ToController,
};

/// What the objects, places and facts of a mission and the resources of its robot are called.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Labels {
    objects: Vec<Name>,
    places: Vec<Name>,
    resources: Vec<Name>,
    by_name: BTreeMap<Name, ObjectId>,
    places_by_name: BTreeMap<Name, PlaceId>,
    facts_by_name: BTreeMap<Name, FactId>,
}

impl Labels {
    /// Those of a mission. Of a name that is longer than [`NAME_MAX`](crate::NAME_MAX) only the beginning is told.
    pub fn new(names: &Names) -> Self {
        let labels = |names: &[String]| names.iter().map(|name| shortened(name)).collect::<Vec<_>>();
        let (objects, places) = (labels(&names.objects), labels(&names.places));
        Self {
            by_name: ids(&objects),
            places_by_name: ids(&places),
            facts_by_name: ids(&labels(&names.facts)),
            resources: labels(&names.resources),
            objects,
            places,
        }
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

    /// What a controller reports.
    ///
    /// # Errors
    /// [`Misreport`] where the mission has no such thing.
    pub fn reported(&self, report: &Report) -> Result<Change, Misreport> {
        Ok(match report {
            Report::Fact { fact, holds } => {
                Change::Fact(*self.facts_by_name.get(fact).ok_or(Misreport::NoSuchFact)?, *holds)
            }
            Report::Object { object, at } => {
                let object = *self.by_name.get(object).ok_or(Misreport::NoSuchObject)?;
                let place = |place| self.places_by_name.get(&place).copied().ok_or(Misreport::NoSuchPlace);
                Change::Object(object, at.map(place).transpose()?.map_or(Location::Unknown, Location::At))
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

/// What is gone has no name.
fn ids<I: From<usize>>(names: &[Name]) -> BTreeMap<Name, I> {
    let named = names.iter().enumerate().filter(|(_, name)| !name.is_empty());
    named.map(|(index, name)| (*name, I::from(index))).collect()
}

#[cfg(test)]
mod tests {
    use nalgebra::{Point3, Vector3};

    use super::*;
    use crate::NAME_MAX;

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

    #[test]
    fn reports_are_of_what_the_mission_has() {
        let list = |name: &str| vec![name.to_owned()];
        let names = Names { objects: list("cup"), places: list("table"), facts: list("open"), ..Names::default() };
        let labels = Labels::new(&names);
        let check = |report: Report, expected| assert_eq!(labels.reported(&report), expected, "{report}");
        check(Report::fact("open", true), Ok(Change::Fact(FactId(0), true)));
        check(Report::fact("cup", true), Err(Misreport::NoSuchFact));
        check(Report::object("cup", Some("table")), Ok(Change::Object(ObjectId(0), Location::At(PlaceId(0)))));
        check(Report::object("cup", None), Ok(Change::Object(ObjectId(0), Location::Unknown)));
        check(Report::object("cup", Some("open")), Err(Misreport::NoSuchPlace));
        check(Report::object("table", None), Err(Misreport::NoSuchObject));
    }
}
