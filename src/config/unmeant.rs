//! What is legal in a mission but surely not meant.
use super::document::Spot;
use super::fault::Faults;
use crate::model::MissionSpec;
pub(super) fn look_for(_mission: &MissionSpec, _spots: &[Spot], _faults: &mut Faults) {}
