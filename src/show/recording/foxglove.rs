//! Messages of Foxglove's schemas, as far as they are used here.

use ambidex_model::Pose as PlanePose;
use nalgebra::Point3;
use serde::Serialize;

/// A list that a schema has and nothing here fills.
pub(super) const NONE: [(); 0] = [];

/// A moment, or a span of time.
#[derive(Debug, Clone, Copy, Default, Serialize)]
pub(super) struct Stamp {
    sec: u64,
    nsec: u64,
}

impl From<u64> for Stamp {
    /// From nanoseconds.
    fn from(ns: u64) -> Self {
        Self { sec: ns / 1_000_000_000, nsec: ns % 1_000_000_000 }
    }
}

/// A point or a size, meters.
#[derive(Debug, Clone, Copy, Serialize)]
pub(super) struct Vector {
    pub(super) x: f64,
    pub(super) y: f64,
    pub(super) z: f64,
}

impl Vector {
    /// The same along each axis.
    pub(super) fn all(length_m: f64) -> Self {
        Self { x: length_m, y: length_m, z: length_m }
    }
}

impl From<Point3<f64>> for Vector {
    fn from(point: Point3<f64>) -> Self {
        Self { x: point.x, y: point.y, z: point.z }
    }
}

/// A rotation as a unit quaternion.
#[derive(Debug, Clone, Copy, Serialize)]
pub(super) struct Quaternion {
    x: f64,
    y: f64,
    z: f64,
    w: f64,
}

impl Quaternion {
    /// No rotation.
    pub(super) const NONE: Self = Self { x: 0.0, y: 0.0, z: 0.0, w: 1.0 };

    /// To the left by `pan`, then downwards by `tilt`, radians.
    pub(super) fn turned(pan: f64, tilt: f64) -> Self {
        let ((pan_sin, pan_cos), (tilt_sin, tilt_cos)) = ((pan / 2.0).sin_cos(), (tilt / 2.0).sin_cos());
        Self { x: -pan_sin * tilt_sin, y: pan_cos * tilt_sin, z: pan_sin * tilt_cos, w: pan_cos * tilt_cos }
    }
}

/// Where something is, and how it is turned.
#[derive(Debug, Clone, Copy, Serialize)]
pub(super) struct Pose {
    position: Vector,
    orientation: Quaternion,
}

impl From<PlanePose> for Pose {
    fn from(pose: PlanePose) -> Self {
        Self {
            position: Vector { x: pose.at.x, y: pose.at.y, z: 0.0 },
            orientation: Quaternion::turned(pose.heading, 0.0),
        }
    }
}

impl From<Point3<f64>> for Pose {
    fn from(point: Point3<f64>) -> Self {
        Self { position: point.into(), orientation: Quaternion::NONE }
    }
}

impl Pose {
    /// A point and a rotation about it.
    pub(super) fn new(position: Vector, orientation: Quaternion) -> Self {
        Self { position, orientation }
    }

    /// Somewhere else, turned the same.
    pub(super) fn moved_to(self, point: Point3<f64>) -> Self {
        Self { position: point.into(), ..self }
    }
}

/// `foxglove.PoseInFrame`.
#[derive(Debug, Serialize)]
pub(super) struct PoseInFrame<'a> {
    pub(super) timestamp: Stamp,
    pub(super) frame_id: &'a str,
    pub(super) pose: Pose,
}

/// `foxglove.FrameTransforms`.
#[derive(Debug, Serialize)]
pub(super) struct FrameTransforms<'a> {
    pub(super) transforms: Vec<FrameTransform<'a>>,
}

/// `foxglove.FrameTransform`: where a frame is in that above it.
#[derive(Debug, Serialize)]
pub(super) struct FrameTransform<'a> {
    pub(super) timestamp: Stamp,
    pub(super) parent_frame_id: &'a str,
    pub(super) child_frame_id: &'a str,
    pub(super) translation: Vector,
    pub(super) rotation: Quaternion,
}

impl<'a> FrameTransform<'a> {
    /// A frame that is so in another.
    pub(super) fn new(timestamp: Stamp, parent: &'a str, child: &'a str, pose: Pose) -> Self {
        Self {
            timestamp,
            parent_frame_id: parent,
            child_frame_id: child,
            translation: pose.position,
            rotation: pose.orientation,
        }
    }
}

/// A color, each part from 0 to 1.
#[derive(Debug, Clone, Copy, Serialize)]
pub(super) struct Color {
    pub(super) r: f64,
    pub(super) g: f64,
    pub(super) b: f64,
    pub(super) a: f64,
}

/// A box around its middle.
#[derive(Debug, Serialize)]
pub(super) struct Cube {
    pub(super) pose: Pose,
    pub(super) size: Vector,
    pub(super) color: Color,
}

/// An upright cylinder around its middle.
#[derive(Debug, Serialize)]
pub(super) struct Cylinder {
    pub(super) pose: Pose,
    pub(super) size: Vector,
    pub(super) bottom_scale: f64,
    pub(super) top_scale: f64,
    pub(super) color: Color,
}

/// A text that faces whoever looks.
#[derive(Debug, Serialize)]
pub(super) struct Text {
    pub(super) pose: Pose,
    pub(super) billboard: bool,
    pub(super) font_size: f64,
    pub(super) scale_invariant: bool,
    pub(super) color: Color,
    pub(super) text: String,
}

/// `foxglove.SceneEntity`: what is seen of one thing.
#[derive(Debug, Serialize)]
pub(super) struct Entity<'a> {
    pub(super) timestamp: Stamp,
    pub(super) frame_id: &'a str,
    pub(super) id: String,
    pub(super) lifetime: Stamp,
    pub(super) frame_locked: bool,
    pub(super) metadata: [(); 0],
    pub(super) arrows: [(); 0],
    pub(super) cubes: Vec<Cube>,
    pub(super) spheres: [(); 0],
    pub(super) cylinders: Vec<Cylinder>,
    pub(super) lines: [(); 0],
    pub(super) triangles: [(); 0],
    pub(super) texts: Vec<Text>,
    pub(super) models: [(); 0],
}

impl<'a> Entity<'a> {
    /// A thing of which nothing is seen yet; it stays until it is told otherwise, and goes with its frame.
    pub(super) fn new(timestamp: Stamp, frame_id: &'a str, id: String) -> Self {
        Self {
            timestamp,
            frame_id,
            id,
            lifetime: Stamp::default(),
            frame_locked: true,
            metadata: NONE,
            arrows: NONE,
            cubes: Vec::new(),
            spheres: NONE,
            cylinders: Vec::new(),
            lines: NONE,
            triangles: NONE,
            texts: Vec::new(),
            models: NONE,
        }
    }
}

/// `foxglove.SceneEntityDeletion`.
#[derive(Debug, Serialize)]
pub(super) struct Deletion {
    pub(super) timestamp: Stamp,
    /// 0: the one with the id.
    #[serde(rename = "type")]
    pub(super) ty: u8,
    pub(super) id: String,
}

/// `foxglove.SceneUpdate`.
#[derive(Debug, Default, Serialize)]
pub(super) struct SceneUpdate<'a> {
    pub(super) deletions: Vec<Deletion>,
    pub(super) entities: Vec<Entity<'a>>,
}

/// `foxglove.LogLevel`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Level {
    Info = 2,
    Warning = 3,
    Error = 4,
    Fatal = 5,
}

impl Serialize for Level {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_u8(*self as u8)
    }
}

/// `foxglove.Log`.
#[derive(Debug, Serialize)]
pub(super) struct Log<'a> {
    pub(super) timestamp: Stamp,
    pub(super) level: Level,
    pub(super) message: String,
    pub(super) name: &'a str,
    pub(super) file: &'a str,
    pub(super) line: u32,
}

#[cfg(test)]
mod tests {
    use nalgebra::{UnitQuaternion, Vector3};

    use super::*;

    #[test]
    fn a_head_turns_left_and_downwards() {
        for (pan, tilt) in [(0.0, 0.0), (0.7, 0.0), (0.0, 0.4), (-1.2, 0.9)] {
            let Quaternion { x, y, z, w } = Quaternion::turned(pan, tilt);
            let turned = UnitQuaternion::from_quaternion(nalgebra::Quaternion::new(w, x, y, z)) * Vector3::x();
            let expected = Vector3::new(pan.cos() * tilt.cos(), pan.sin() * tilt.cos(), -tilt.sin());
            assert!((turned - expected).norm() < 1e-12, "{pan} {tilt}: {turned}");
        }
    }
}
