//! Between a change of the world as it is asked for, by names, and as root decides it, by ids.

use std::f64::consts::TAU;
use std::ops::RangeInclusive;

use ambidex_model::{Change, Location, MissionSpec, Names, Objection, Obstacle, Pose, TALL_M, Uptake, suggestion};

use super::answer::{Answer, Refusal, Why, beginning};

/// What something that came to stand in the room can be like, and where: meters, radians.
const MAP_M: RangeInclusive<f64> = -10_000.0..=10_000.0;
const EXTENT_M: RangeInclusive<f64> = 0.01..=100.0;
const TURN: RangeInclusive<f64> = -TAU..=TAU;

/// How the world is to be different, by names of the mission.
#[derive(Debug, Clone, PartialEq)]
pub enum WorldChange {
    /// A fact holds, or does not.
    Fact {
        /// The fact.
        fact: String,
        /// Whether it holds.
        holds: bool,
    },
    /// An object lies at a place.
    Place {
        /// The object.
        object: String,
        /// The place.
        place: String,
    },
    /// Something stands in the room that was not there before.
    Block {
        /// Its middle on the map, meters.
        at: [f64; 2],
        /// Along its x and its y, meters.
        size: [f64; 2],
        /// Where its x points, radians, counterclockwise from x of the map.
        heading: f64,
    },
    /// What came to stand around a point is gone.
    Unblock {
        /// The point on the map, meters.
        at: [f64; 2],
    },
}

impl WorldChange {
    /// The same by ids.
    ///
    /// # Errors
    /// When there is no such fact, object or place, and when a number is none of a room.
    pub fn with_ids(&self, names: &Names) -> Result<Change, Refusal> {
        Ok(match self {
            Self::Fact { fact, holds } => Change::Fact(find("fact", fact, &names.facts)?.into(), *holds),
            Self::Place { object, place } => {
                let object = find("object", object, &names.objects)?;
                Change::Object(object.into(), Location::At(find("place", place, &names.places)?.into()))
            }
            Self::Block { at, size, heading } => {
                let side = |index: usize| within("size", size[index], EXTENT_M, "m");
                let (size, heading) = ([side(0)?, side(1)?, TALL_M], within("heading", *heading, TURN, "rad")?);
                Change::Blocked(Obstacle::on_floor(on_the_map(*at)?.into(), size.into(), heading))
            }
            Self::Unblock { at } => {
                let [x, y] = on_the_map(*at)?;
                Change::Cleared(Pose::new(x, y, 0.0))
            }
        })
    }
}

/// What root made of a change, in words.
pub fn answer(change: &Change, uptake: Uptake, mission: &MissionSpec) -> Answer {
    let names = &mission.names;
    match uptake {
        Uptake::Changed => Answer::Changed { said: state(change, "now", names) },
        Uptake::Same => Answer::Same { said: state(change, "already", names) },
        Uptake::Refused(objection) => Answer::Refused(Refusal {
            why: why(objection),
            said: objection.sentence(change, names),
            help: help(change, objection, mission),
        }),
    }
}

fn on_the_map(at: [f64; 2]) -> Result<[f64; 2], Refusal> {
    Ok([within("position", at[0], MAP_M, "m")?, within("position", at[1], MAP_M, "m")?])
}

fn within(what: &str, number: f64, range: RangeInclusive<f64>, unit: &str) -> Result<f64, Refusal> {
    if range.contains(&number) {
        return Ok(number);
    }
    let said = format!("the {what}, {number} {unit}, is not from {} to {} {unit}", range.start(), range.end());
    Err(Refusal::new(Why::Malformed, said))
}

fn find(what: &str, name: &str, names: &[String]) -> Result<usize, Refusal> {
    names.iter().position(|known| known == name).ok_or_else(|| {
        let name = beginning(name);
        Refusal::new(Why::NoSuchName, format!("the mission has no {what} `{name}`")).with_help(suggestion(
            name,
            what,
            names.iter().map(String::as_str),
        ))
    })
}

fn state(change: &Change, when: &str, names: &Names) -> String {
    match *change {
        Change::Fact(fact, true) => format!("\"{}\" holds {when}", names.fact(fact)),
        Change::Fact(fact, false) if when == "now" => format!("\"{}\" holds no more", names.fact(fact)),
        Change::Fact(fact, false) => format!("\"{}\" does not hold {when}", names.fact(fact)),
        Change::Object(object, Location::At(place)) | Change::Laid(object, place, _) => {
            format!("{} is at {} {when}", names.thing(object), names.place(place))
        }
        Change::Object(object, Location::In(_) | Location::Unknown) => {
            format!("nobody knows where {} is {when}", names.thing(object))
        }
        Change::Blocked(Obstacle { middle, .. }) => {
            format!("something stands at ({:.2}, {:.2}) {when}", middle.x, middle.y)
        }
        Change::Cleared(Pose { at, .. }) if when == "now" => {
            format!("what came to stand at ({:.2}, {:.2}) is gone", at.x, at.y)
        }
        Change::Cleared(Pose { at, .. }) => format!("nothing has come to stand at ({:.2}, {:.2})", at.x, at.y),
        Change::Base(_) | Change::Taken(..) | Change::Emptied(_) => format!("it is so {when}"),
    }
}

fn why(objection: Objection) -> Why {
    match objection {
        Objection::NotOutside => Why::NotOutside,
        Objection::Held { .. } => Why::Held,
        Objection::NotTheirs => Why::NotTheirs,
        Objection::NotBegun => Why::NotBegun,
        Objection::Over => Why::Over,
        Objection::Full => Why::NotNow,
    }
}

fn help(change: &Change, objection: Objection, mission: &MissionSpec) -> Option<String> {
    match (objection, change) {
        (Objection::NotOutside, Change::Fact(fact, _)) => {
            let holds = mission.start.facts.get(fact.index()).copied().unwrap_or_default();
            let name = mission.names.fact(*fact);
            Some(format!("declare it in the mission: `facts: {{{name}: {{holds: {holds}, outside: true}}}}`"))
        }
        (Objection::Held { .. }, _) => Some("what is in a gripper moves only by the word of its controller".into()),
        (Objection::Full, _) => Some("say first what is gone".into()),
        (Objection::NotOutside | Objection::NotTheirs | Objection::NotBegun | Objection::Over, _) => None,
    }
}
