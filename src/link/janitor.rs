//! Removing what the dead left in shared memory: whole instances, and dead nodes within a living one.

mod survey;

use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

use iceoryx2::node::{DeadNodeView, NodeView};
use iceoryx2::prelude::{CallbackProgression, Config, Node, NodeState};

use crate::error::IpcError;
use crate::instances::{GlobalLock, Instance, Transport, remove_instance, segments};
pub use survey::{Resident, Survey, Surveyed, survey};

/// How old something unfinished must be before its maker counts as dead.
const UNFINISHED_FOR: Duration = Duration::from_millis(500);

/// Something that was removed.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Swept {
    /// An instance without any living process.
    Instance {
        /// As its own file told it, else its tag.
        name: String,
        /// How many segments of shared memory it had left.
        segments: usize,
    },
    /// A node of a dead process.
    Node {
        /// As the transport numbers it.
        id: u128,
    },
    /// A file in the folder of a living instance, of one of its processes that is gone.
    File(PathBuf),
    /// A segment of shared memory that belonged to nothing, or that its maker did not finish.
    Segment(PathBuf),
}

/// Removes every instance of this user in which no process lives, and segments of none. Call it at the start of any instance.
///
/// # Errors
/// [`IpcError`] when the lock over all instances cannot be had.
pub fn sweep() -> Result<Vec<Swept>, IpcError> {
    Ok(sweep_under(&GlobalLock::enter()?))
}

/// The same while the lock over all instances is held: nobody else sweeps, comes or goes meanwhile.
fn sweep_under(_global: &GlobalLock) -> Vec<Swept> {
    let survey = survey::look();
    let abandoned = survey.instances.into_iter().filter(Surveyed::is_abandoned);
    let swept = abandoned.map(|Surveyed { name, folder, .. }| {
        let segments = remove_instance(&folder, &survey::prefix(&folder));
        Swept::Instance { name, segments }
    });
    let mut swept: Vec<_> = swept.collect();
    swept.extend(survey.orphans.into_iter().filter(|path| fs::remove_file(path).is_ok()).map(Swept::Segment));
    swept
}

/// Removes all that the dead have left: what [`sweep`] does, then what belongs to dead processes of living instances.
///
/// # Errors
/// [`IpcError`] when the lock over all instances cannot be had.
pub fn sweep_all() -> Result<Vec<Swept>, IpcError> {
    let (mut swept, living) = {
        let global = GlobalLock::enter()?;
        let mut swept = sweep_under(&global);
        let living = survey::look().instances;
        // Nobody takes a place meanwhile, so that what nobody holds now is nobody's.
        let stale = living.iter().flat_map(|instance| &instance.stale);
        swept.extend(stale.filter(|path| fs::remove_file(path).is_ok()).cloned().map(Swept::File));
        (swept, living)
    };
    let instances = living.iter().filter_map(|instance| Instance::new(&instance.name).ok());
    swept.extend(instances.flat_map(|instance| tidy(&instance)));
    Ok(swept)
}

/// Removes what dead processes left in an instance that may live. It takes up to 30 ms per dead node: not for an actor.
pub fn tidy(instance: &Instance) -> Vec<Swept> {
    let mut swept: Vec<_> = remove_unfinished(&instance.prefix()).into_iter().map(Swept::Segment).collect();
    let Ok(config) = instance.config() else {
        return swept;
    };
    for node in dead_nodes(&config) {
        let id = node.id().value();
        match remove_node(node, &config) {
            Ok(()) => swept.push(Swept::Node { id }),
            Err(error) => tracing::debug!(%error, id, "a dead node stays for now"),
        }
    }
    swept
}

/// How many nodes in shared memory belong to processes of the instance that are gone.
pub fn count_dead_nodes(instance: &Instance) -> usize {
    instance.config().map_or(0, |config| dead_nodes(&config).len())
}

fn dead_nodes(config: &Config) -> Vec<DeadNodeView<Transport>> {
    let mut dead = Vec::new();
    let listed = Node::<Transport>::list(config, |state| {
        match state {
            NodeState::Dead(node) => dead.push(node),
            NodeState::Alive(_) | NodeState::Inaccessible(_) | NodeState::Undefined(_) => {}
        }
        CallbackProgression::Continue
    });
    if let Err(error) = listed {
        tracing::warn!(%error, "cannot list the nodes in shared memory");
    }
    dead
}

fn remove_node(node: DeadNodeView<Transport>, config: &Config) -> Result<(), Box<dyn std::error::Error>> {
    if node.details().is_some() {
        return Ok(node.try_remove_stale_resources()?);
    }
    // Its maker died before it had written what the transport's own cleaning needs.
    Ok(remove_half_made(config, node.id().value())?)
}

fn remove_half_made(config: &Config, id: u128) -> std::io::Result<()> {
    let nodes = PathBuf::from(config.global.node_dir().to_string());
    let id = id.to_string();
    for entry in fs::read_dir(&nodes)?.flatten() {
        let path = entry.path();
        if !entry.file_name().to_string_lossy().contains(&id) || !is_old(&path) {
            continue;
        }
        if path.is_dir() {
            fs::remove_dir_all(&path)?;
        } else {
            fs::remove_file(&path)?;
        }
    }
    Ok(())
}

/// A segment without a size makes every later node creation and cleaning wait for ever.
fn remove_unfinished(prefix: &str) -> Vec<PathBuf> {
    let mut found = segments(prefix);
    found.retain(|path| {
        let is_empty = fs::metadata(path).is_ok_and(|about| about.len() == 0);
        is_empty && is_old(path) && fs::remove_file(path).is_ok()
    });
    found
}

fn is_old(path: &Path) -> bool {
    let changed = fs::symlink_metadata(path).and_then(|about| about.modified());
    changed.is_ok_and(|at| SystemTime::now().duration_since(at).is_ok_and(|age| age > UNFINISHED_FOR))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::instances::shared_memory;

    #[test]
    fn a_dead_instance_is_swept_and_a_living_one_is_not() {
        let (dead, living) = (Instance::fresh(), Instance::fresh());
        let lock = living.lock_daemon().unwrap();
        let global = GlobalLock::enter().unwrap();
        // What a process leaves that was killed: a folder, a lock file that nobody holds, and a segment.
        fs::create_dir_all(dead.dir()).unwrap();
        fs::write(dead.dir().join("daemon.lock"), "1\n").unwrap();
        fs::write(dead.dir().join("name"), dead.name()).unwrap();
        let segment = shared_memory().join(format!("{}1.data", dead.prefix()));
        fs::write(&segment, "x").unwrap();

        let swept = sweep_under(&global);
        drop(global);
        assert!(swept.contains(&Swept::Instance { name: dead.name().to_owned(), segments: 1 }), "{swept:?}");
        assert!(!dead.dir().exists() && !segment.exists());
        assert!(living.dir().exists());
        drop(lock);
    }

    #[test]
    fn what_dead_processes_left_in_a_living_instance_is_seen_and_removed() {
        let instance = Instance::fresh();
        let head = instance.lock_controller("head").unwrap();
        // As killed processes leave it: a lock that nobody holds, and a socket that nobody serves.
        let left =
            ["control.sock", "controller-base.lock", "daemon.lock", "token"].map(|name| instance.dir().join(name));
        left.iter().for_each(|path| fs::write(path, "1\n").unwrap());
        let other = instance.dir().join("control.txt");
        fs::write(&other, "x").unwrap();

        let surveyed = || survey().unwrap().instances.into_iter().find(|found| found.name == instance.name()).unwrap();
        let found = surveyed();
        let resident = Resident { lock: "controller-head.lock".to_owned(), pid: std::process::id() };
        assert_eq!((found.residents.as_slice(), found.daemon(), found.is_abandoned()), (&[resident][..], None, false));
        let mut stale = found.stale.clone();
        stale.sort();
        assert_eq!(stale, left);
        assert!(left.iter().all(|path| path.exists()), "looking removes nothing");

        let swept = sweep_all().unwrap();
        assert!(left.iter().all(|path| swept.contains(&Swept::File(path.clone())) && !path.exists()), "{swept:?}");
        assert!(other.exists() && surveyed().stale.is_empty());

        // What a living daemon has is no leftover.
        let daemon = instance.lock_daemon().unwrap();
        fs::write(&left[0], "").unwrap();
        let found = surveyed();
        assert_eq!((found.daemon(), found.stale.as_slice()), (Some(std::process::id()), &[][..]));
        sweep_all().unwrap();
        assert!(left[0].exists());
        drop((daemon, head));
        assert!(!instance.has_left_anything());
    }

    #[test]
    fn only_old_segments_without_a_size_are_removed() {
        let instance = Instance::fresh();
        let lock = instance.lock_daemon().unwrap();
        let segment = shared_memory().join(format!("{}2.data", instance.prefix()));
        let file = fs::File::create(&segment).unwrap();
        assert!(tidy(&instance).is_empty());
        let old = SystemTime::now() - 2 * UNFINISHED_FOR;
        file.set_modified(old).unwrap();
        assert_eq!(tidy(&instance), [Swept::Segment(segment.clone())]);
        drop(lock);
    }
}
