//! One process's place in an instance: its lock and its node in shared memory, kept until the last port is gone.

use std::sync::Arc;

use iceoryx2::prelude::{Node, NodeBuilder, SignalHandlingMode};

use crate::error::IpcError;
use crate::instances::{Instance, Lock, Transport, restrict};
use crate::janitor;

/// A place in an instance. Cheap to clone; ports hold one, so that the lock outlives them.
#[derive(Debug, Clone)]
pub struct IpcNode {
    inner: Arc<Inner>,
}

/// Node before lock: whoever gets the lock next finds no node of ours.
#[derive(Debug)]
struct Inner {
    node: Node<Transport>,
    lock: Lock,
}

impl IpcNode {
    /// Enters the instance whose lock is held, after removing what dead processes left in it.
    ///
    /// # Errors
    /// [`IpcError`] when the folder or the node cannot be made.
    pub fn open(lock: Lock) -> Result<Self, IpcError> {
        let instance = lock.instance();
        janitor::tidy(instance);
        let config = instance.config()?;
        let node = NodeBuilder::new()
            .config(&config)
            .signal_handling_mode(SignalHandlingMode::Disabled)
            .create::<Transport>()
            .map_err(|source| IpcError::Node { instance: instance.name().to_owned(), source: Box::new(source) })?;
        let opened = Self { inner: Arc::new(Inner { node, lock }) };
        opened.restrict();
        Ok(opened)
    }

    /// The instance that the node takes part in.
    pub fn instance(&self) -> &Instance {
        self.inner.lock.instance()
    }

    /// Sees to it that nobody else can open what the transport has made for this instance so far.
    pub(crate) fn restrict(&self) {
        restrict(&self.instance().prefix());
    }

    pub(super) fn node(&self) -> &Node<Transport> {
        &self.inner.node
    }
}
