//! Where things are: meters and radians in the map frame or the base frame (REP-103: x forward, y left, z up).

use nalgebra::{Point2, Point3, Rotation2, Vector2};
use serde::{Deserialize, Serialize};

/// A pose in the plane of the map.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Pose {
    /// Position in the map frame, meters.
    pub at: Point2<f64>,
    /// Heading in the map frame, radians, counter-clockwise from x.
    pub heading: f64,
}

impl Pose {
    /// A pose from its coordinates: meters, meters, radians.
    pub fn new(x: f64, y: f64, heading: f64) -> Self {
        Self { at: Point2::new(x, y), heading }
    }

    /// Distance to `other` in the plane, meters; headings do not count.
    pub fn distance_m(&self, other: &Self) -> f64 {
        (self.at - other.at).norm()
    }

    /// The point `local` of this pose's own frame in the map frame, meters.
    pub fn to_map(&self, local: Point3<f64>) -> Point3<f64> {
        let turned = Rotation2::new(self.heading) * Vector2::new(local.x, local.y);
        Point3::new(self.at.x + turned.x, self.at.y + turned.y, local.z)
    }

    /// The point `map` of the map frame in this pose's own frame, meters.
    pub fn to_local(&self, map: Point3<f64>) -> Point3<f64> {
        let turned = Rotation2::new(-self.heading) * Vector2::new(map.x - self.at.x, map.y - self.at.y);
        Point3::new(turned.x, turned.y, map.z)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn local_and_map_undo_each_other() {
        let pose = Pose::new(1.0, -2.0, 0.7);
        let there = pose.to_local(pose.to_map(Point3::new(0.5, 0.2, 0.9)));
        assert!((there - Point3::new(0.5, 0.2, 0.9)).norm() < 1e-12);
    }
}
