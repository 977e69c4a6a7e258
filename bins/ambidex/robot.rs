//! The daemon's way to the controllers of a robot.

use std::sync::Arc;

use ambidex::link::{DaemonPort, GuardedPort, Instance, IpcError, IpcNode, fresh_epoch, sweep};
use ambidex::model::{Labels, MissionSpec};
use ambidex::runtime::{Clock, Port, Readable};

/// Sweeps what dead instances left, takes the instance, and opens a link to every controller, in their order.
///
/// # Errors
/// When another daemon has the instance, or shared memory cannot be used.
pub fn links(
    mission: &MissionSpec,
    instance: &Instance,
    clock: &Clock,
) -> Result<(IpcNode, Vec<Box<dyn Port>>), IpcError> {
    sweep()?;
    let node = IpcNode::open(instance.lock_daemon()?)?;
    let controllers = mission.robot.controllers.iter();
    let epoch = fresh_epoch();
    let labels = Arc::new(Labels::new(&mission.names));
    let open = |name: &str| DaemonPort::open(&node, name, &labels, epoch, clock.origin());
    let guarded = |name: &str| Ok(Box::new(Readable::new(GuardedPort::new(open(name)?))) as Box<dyn Port>);
    let links: Result<Vec<_>, _> = controllers.map(|spec| guarded(&spec.name)).collect();
    Ok((node.clone(), links?))
}
