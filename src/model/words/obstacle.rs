//! Boxes that stand in a room.

use nalgebra::{Point2, Point3, Vector3};
use serde::{Deserialize, Serialize};

use super::Pose;

/// A height that nothing of a robot reaches over: that of walls and of what is told from above alone, meters.
pub const TALL_M: f64 = 2.0;

/// A box that stands upright, turned about z; map frame, meters.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Obstacle {
    /// Its middle.
    pub middle: Point3<f64>,
    /// Its sides along its own x, y and z.
    pub size: Vector3<f64>,
    /// The direction of its own x, radians, counterclockwise from x of the map.
    pub heading: f64,
}

impl Obstacle {
    /// The box along the axes of the map between two corners.
    pub fn between(min: Point3<f64>, max: Point3<f64>) -> Self {
        Self { middle: nalgebra::center(&min, &max), size: max - min, heading: 0.0 }
    }

    /// One that stands on the floor around a point of it.
    pub fn on_floor(at: Point2<f64>, size: Vector3<f64>, heading: f64) -> Self {
        Self { middle: Point3::new(at.x, at.y, size.z / 2.0), size, heading }
    }

    /// Where it stands and faces.
    pub fn pose(&self) -> Pose {
        Pose { at: self.middle.xy(), heading: self.heading }
    }

    /// Its corners from above, counterclockwise; the first is the one of positive x and y of its own.
    pub fn corners(&self) -> [Point2<f64>; 4] {
        let (x, y) = (self.size.x / 2.0, self.size.y / 2.0);
        [(x, y), (-x, y), (-x, -y), (x, -y)].map(|(x, y)| self.pose().to_map(Point3::new(x, y, 0.0)).xy())
    }

    /// How far a point is from the nearest of its edges, from above, meters; below 0 beyond one.
    pub fn left_m(&self, at: Point2<f64>) -> f64 {
        let own = self.pose().to_local(Point3::new(at.x, at.y, 0.0));
        (self.size.xy() / 2.0 - own.coords.xy().abs()).min()
    }

    /// Whether a point is within it, from above.
    pub fn is_around(&self, at: Point2<f64>) -> bool {
        self.left_m(at) >= 0.0
    }

    /// Height of its upper side.
    pub fn top_m(&self) -> f64 {
        self.middle.z + self.size.z / 2.0
    }
}
