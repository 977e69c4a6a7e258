//! Controller processes as children of `run`: started with it, gone with it.

use std::os::unix::process::CommandExt;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use ambidex::ipc::Instance;
use ambidex::model::RobotSpec;
use miette::{IntoDiagnostic, Result};

/// How often the end of a child is looked for.
const POLL: Duration = Duration::from_millis(5);

/// One child per controller; dropping kills what is left.
#[derive(Debug)]
pub struct Children {
    children: Vec<Child>,
}

impl Children {
    /// Starts every controller of a robot as a process of this very program.
    pub fn start(robot: &RobotSpec, file: &Path, instance: &Instance) -> Result<Self> {
        let program = std::env::current_exe().into_diagnostic()?;
        let mut children = Self { children: Vec::new() };
        for controller in &robot.controllers {
            let child = Command::new(&program)
                .args(["controller", &controller.name, "--once", "--instance", instance.name()])
                .arg("--robot")
                .arg(file)
                .args(["--parent", &std::process::id().to_string()])
                .stdin(Stdio::null())
                .stdout(Stdio::null())
                // A group of its own: Ctrl-C reaches this process alone, which then ends the children in order.
                .process_group(0)
                .spawn()
                .into_diagnostic()?;
            children.children.push(child);
        }
        Ok(children)
    }

    /// Waits for all to end by themselves; kills those that have not when the time is over.
    pub fn wait(mut self, timeout: Duration) {
        let by = Instant::now() + timeout;
        while Instant::now() < by {
            self.children.retain_mut(|child| matches!(child.try_wait(), Ok(None)));
            if self.children.is_empty() {
                return;
            }
            std::thread::sleep(POLL);
        }
    }
}

impl Drop for Children {
    fn drop(&mut self) {
        for child in &mut self.children {
            drop(child.kill());
            drop(child.wait());
        }
    }
}
