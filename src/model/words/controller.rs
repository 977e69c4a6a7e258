//! The controllers of a robot: what each moves, within which limits, and what it may say of the world.

use std::time::Duration;

use nalgebra::Point3;
use serde::{Deserialize, Serialize};

use super::Reportable;

/// A controller process.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ControllerSpec {
    /// What its process is started with.
    pub name: String,
    /// What it moves, and its limits.
    pub kind: ControllerKind,
    /// How long it may take to end what it was told to end, wall time; past that it counts as hung.
    pub cancel_grace: Duration,
    /// Of an arm, how thick it is: the radius of its links, meters; none where nothing tells.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub radius_m: Option<f64>,
    /// Of an arm, how long its hand is: from the wrist to what it takes, meters.
    #[serde(default, skip_serializing_if = "is_none")]
    pub hand_m: f64,
    /// What it may say of the world beyond what it moves.
    #[serde(default)]
    pub reports: Reportable,
}

/// What a controller moves.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ControllerKind {
    /// An arm with a gripper.
    Arm(ArmSpec),
    /// A base that drives in the plane.
    Base(BaseSpec),
    /// A head that pans and tilts.
    Head(HeadSpec),
    /// A device of another kind, which does what its robot file says that it offers.
    Device,
}

/// An arm with a gripper.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ArmSpec {
    /// The shoulder in the base frame, meters.
    pub shoulder: Point3<f64>,
    /// Where the gripper is carried, base frame, meters.
    pub tuck: Point3<f64>,
    /// How far the gripper reaches from the shoulder, meters.
    pub reach_m: f64,
    /// Top speed of the gripper, meters per second.
    pub speed: f64,
    /// Top acceleration of the gripper, meters per second squared.
    pub acceleration: f64,
    /// Time to close or open the gripper, seconds.
    pub grip_s: f64,
    /// How far it lifts what it took, meters.
    pub lift_m: f64,
}

/// A base that drives in the plane in any direction.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct BaseSpec {
    /// Top speed, meters per second.
    pub speed: f64,
    /// Top acceleration, meters per second squared.
    pub acceleration: f64,
    /// Top turning speed, radians per second.
    pub turn_speed: f64,
    /// Top turning acceleration, radians per second squared.
    pub turn_acceleration: f64,
}

/// A head that pans and tilts.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct HeadSpec {
    /// The crossing of its axes in the base frame, meters.
    pub neck: Point3<f64>,
    /// Top speed of each axis, radians per second.
    pub speed: f64,
    /// Top acceleration of each axis, radians per second squared.
    pub acceleration: f64,
}

fn is_none(length_m: &f64) -> bool {
    *length_m == 0.0
}
