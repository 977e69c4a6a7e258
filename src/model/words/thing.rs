//! Things that can be taken: where they lie on a surface, what body they have, and from where a hand may come to them.

use nalgebra::{Point3, Vector3};

use super::Pose;

/// The fixed part of an object.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ObjectSpec {
    /// Where it lies on any surface: from its middle, in the frame of the place's stand, meters.
    pub offset: Vector3<f64>,
    /// Whether somebody told where it lies, rather than that it was given a place beside the others.
    pub is_offset_told: bool,
    /// The direction of its own x in the frame of the place's stand, radians, counterclockwise.
    pub heading: f64,
    /// Its body; none for a point.
    pub shape: Option<Shape>,
    /// The sides from which a hand may come to it; from anywhere where none is told.
    pub grasps: Vec<Side>,
}

/// The body of an object that stands upright.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Shape {
    /// A box: its sides along its own x, y and z, meters.
    Box(Vector3<f64>),
    /// A cylinder, meters.
    Cylinder {
        /// Of its circle.
        radius_m: f64,
        /// From bottom to top.
        height_m: f64,
    },
}

/// A side of an object, as who stands in front of it and faces its x sees it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    /// From where a hand comes down.
    Above,
    /// Against its own x: the side that faces the stand where it has no heading.
    Front,
    /// Beyond it.
    Back,
    /// Along its own y.
    Left,
    /// Against its own y.
    Right,
}

/// From where a hand may come to something that is turned.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Approach<'a> {
    /// The sides; from anywhere where there are none.
    pub sides: &'a [Side],
    /// The direction of its own x, radians, counterclockwise; in the frame in which it is asked for.
    pub heading: f64,
}

impl Approach<'_> {
    /// From wherever a hand likes.
    pub const ANY: Approach<'static> = Approach { sides: &[], heading: 0.0 };

    /// From where a hand comes that has taken it and puts it down: it turns it as it likes, but what it holds from above it
    /// lets go from above.
    #[must_use]
    pub fn to_put(self) -> Self {
        let is_above = |side: &Side| *side == Side::Above;
        if self.sides.iter().all(is_above) { self } else { Self::ANY }
    }

    /// The same in the frame of a pose.
    #[must_use]
    pub fn in_frame_of(self, pose: &Pose) -> Self {
        Self { heading: self.heading - pose.heading, ..self }
    }

    /// Directions from it to where hands come from, of length 1.
    pub fn directions(&self) -> impl Iterator<Item = Vector3<f64>> + '_ {
        let (sin, cos) = self.heading.sin_cos();
        self.sides.iter().map(move |side| match side {
            Side::Above => Vector3::z(),
            Side::Front => Vector3::new(-cos, -sin, 0.0),
            Side::Back => Vector3::new(cos, sin, 0.0),
            Side::Left => Vector3::new(-sin, cos, 0.0),
            Side::Right => Vector3::new(sin, -cos, 0.0),
        })
    }
}

impl ObjectSpec {
    /// Without a body, where nobody told anything but where it lies.
    pub fn at(offset: Vector3<f64>) -> Self {
        Self { offset, is_offset_told: true, ..Self::default() }
    }

    /// Where it is taken hold of when it stands on a point: in its middle.
    pub fn middle(&self, on: Point3<f64>) -> Point3<f64> {
        on + Vector3::z() * self.shape.map_or(0.0, |shape| shape.height_m() / 2.0)
    }
}

impl Shape {
    /// From bottom to top, meters.
    pub fn height_m(&self) -> f64 {
        match *self {
            Self::Box(size) => size.z,
            Self::Cylinder { height_m, .. } => height_m,
        }
    }

    /// How far it extends sideways from its middle at most, meters.
    pub fn half_width_m(&self) -> f64 {
        match *self {
            Self::Box(size) => size.x.hypot(size.y) / 2.0,
            Self::Cylinder { radius_m, .. } => radius_m,
        }
    }
}
