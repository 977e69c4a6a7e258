//! A named instance of the robot: where its files lie and what its transport is configured with.

use std::path::PathBuf;
use std::sync::atomic::{AtomicU32, Ordering};

use iceoryx2::prelude::{Config, FileName, Path as TransportPath, SemanticString};

use super::paths::{base, prefix_of, segments};
use crate::clock::monotonic_ns;
use crate::error::IpcError;

const NAME_MAX: usize = 32;
const CONTROL_SOCKET: &str = "control.sock";

/// What only a daemon has in the folder of its instance, beside its lock: where it is asked, half made and made, and what
/// whoever asks has to know.
pub(crate) const DAEMONS_FILES: [&str; 3] = [CONTROL_SOCKET, "control.new", "token"];

/// One robot's runtime and controllers. Processes of two instances do not meet.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Instance {
    name: String,
}

impl Instance {
    /// An instance by its name.
    ///
    /// # Errors
    /// [`IpcError::InstanceName`] unless it is 1 to 32 of a-z, 0-9 and -.
    pub fn new(name: &str) -> Result<Self, IpcError> {
        let fits = |byte: u8| byte.is_ascii_lowercase() || byte.is_ascii_digit() || byte == b'-';
        if !is_name(name, fits) {
            return Err(IpcError::InstanceName(name.to_owned()));
        }
        Ok(Self { name: name.to_owned() })
    }

    /// An instance that no other process has.
    pub fn fresh() -> Self {
        static COUNT: AtomicU32 = AtomicU32::new(0);
        let count = COUNT.fetch_add(1, Ordering::Relaxed);
        let salt = fnv(&format!("{} {count}", monotonic_ns()));
        Self { name: format!("run-{}-{:08x}", std::process::id(), salt as u32) }
    }

    /// As it is given on the command line.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Whether a file of the instance is left anywhere, be it alive or not.
    pub fn has_left_anything(&self) -> bool {
        self.dir().exists() || !segments(&self.prefix()).is_empty()
    }

    /// Where the daemon of the instance can be asked, as long as there is one.
    pub fn control_socket(&self) -> PathBuf {
        self.dir().join(CONTROL_SOCKET)
    }

    /// What whoever changes something over that socket must know, as long as there is a daemon.
    pub fn token_file(&self) -> PathBuf {
        self.dir().join("token")
    }

    /// Where the daemon of the instance can be asked over TCP, if it can.
    pub fn address_file(&self) -> PathBuf {
        self.dir().join("http")
    }

    /// The folder of the instance. It is named by a tag, since paths of sockets are short.
    pub(crate) fn dir(&self) -> PathBuf {
        base().join(self.tag())
    }

    /// What the instance's files in shared memory begin with.
    pub(crate) fn prefix(&self) -> String {
        prefix_of(&self.tag())
    }

    fn tag(&self) -> String {
        let uid = rustix::process::getuid().as_raw();
        format!("{:010x}", fnv(&format!("{uid} {}", self.name)) & 0xff_ffff_ffff)
    }

    /// The configuration that every process of the instance must use.
    pub(crate) fn config(&self) -> Result<Config, IpcError> {
        let dir = self.dir();
        let unfit = || IpcError::Path(dir.clone());
        let mut config = Config::default();
        config.global.prefix = FileName::new(self.prefix().as_bytes()).map_err(|_| unfit())?;
        let root = dir.to_str().ok_or_else(unfit)?;
        let root = TransportPath::new(root.as_bytes()).map_err(|_| unfit())?;
        config.global.set_root_path(&root);
        // The janitor does this, behind its guards; unguarded it can spin for ever.
        config.global.node.cleanup_dead_nodes_on_creation = false;
        config.global.node.cleanup_dead_nodes_on_destruction = false;
        config.global.service.cleanup_dead_nodes_on_open = false;
        Ok(config)
    }
}

pub(crate) fn check_controller_name(name: &str) -> Result<(), IpcError> {
    let fits = |byte: u8| byte.is_ascii_lowercase() || byte.is_ascii_digit() || byte == b'-' || byte == b'_';
    if is_name(name, fits) {
        return Ok(());
    }
    Err(IpcError::ControllerName(name.to_owned()))
}

fn is_name(name: &str, fits: impl Fn(u8) -> bool) -> bool {
    (1..=NAME_MAX).contains(&name.len()) && name.bytes().all(fits)
}

/// FNV-1a: stable over versions, unlike the hashers of std.
fn fnv(text: &str) -> u64 {
    text.bytes().fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_short_and_plain() {
        for good in ["default", "run-12", "a", "0123456789abcdef0123456789abcdef"] {
            assert!(Instance::new(good).is_ok(), "{good}");
        }
        let long = "x".repeat(33);
        for bad in ["", "Default", "a b", "a/b", "..", "a_b", "é", long.as_str()] {
            assert!(Instance::new(bad).is_err(), "{bad}");
        }
        assert!(check_controller_name("left_arm").is_ok());
        assert!(check_controller_name("left/arm").is_err());
        assert!(Instance::new(Instance::fresh().name()).is_ok());
        assert_ne!(Instance::fresh(), Instance::fresh());
    }

    #[test]
    fn the_longest_socket_path_fits() {
        let digits_of_an_id = 39;
        let dir = "/dev/shm/ambidex-4294967294/0123456789/".len();
        let file = prefix_of("0123456789").len() + digits_of_an_id + ".event".len();
        assert!(dir + file < 108);
    }
}
