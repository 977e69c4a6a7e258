//! Values of options, as they are written.

use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::time::Duration;

use clap::ValueEnum;

use ambidex::link::Instance;

/// The name of a runtime.
pub fn instance(name: &str) -> Result<Instance, String> {
    Instance::new(name).map_err(|error| error.to_string())
}

/// An address of this machine that no other one reaches.
pub fn loopback(text: &str) -> Result<SocketAddr, String> {
    match text.parse::<SocketAddr>() {
        Ok(address) if address.ip().is_loopback() => Ok(address),
        Ok(address) => Err(format!("{} is no address of loopback; write 127.0.0.1:PORT or [::1]:PORT", address.ip())),
        Err(_) => Err("an address of loopback with its port, such as 127.0.0.1:8080".into()),
    }
}

/// Robot seconds per wall second.
pub fn speed(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(speed) if (0.01..=1000.0).contains(&speed) => Ok(speed),
        Ok(_) | Err(_) => Err("a number from 0.01 to 1000".into()),
    }
}

/// MiB, as bytes.
pub fn mebibytes(text: &str) -> Result<u64, String> {
    match text.parse::<f64>() {
        Ok(mebibytes) if (0.01..=1_048_576.0).contains(&mebibytes) => Ok((mebibytes * f64::from(1 << 20)) as u64),
        Ok(_) | Err(_) => Err("MiB, a number from 0.01 to 1048576".into()),
    }
}

/// A time in seconds.
pub fn seconds(text: &str) -> Result<Duration, String> {
    match text.parse::<f64>() {
        Ok(seconds) if (0.0..=86_400.0).contains(&seconds) => Ok(Duration::from_secs_f64(seconds)),
        Ok(_) | Err(_) => Err("seconds, a number from 0 to 86400".into()),
    }
}

/// What goes wrong on purpose.
#[derive(Debug, Clone, PartialEq)]
pub enum Fail {
    /// What a file says.
    File(PathBuf),
    /// Something, in each attempt of a behavior with this probability.
    Chance(f64),
}

impl Fail {
    /// The file.
    pub fn file(&self) -> Option<&Path> {
        match self {
            Self::File(path) => Some(path),
            Self::Chance(_) => None,
        }
    }

    /// The probability.
    pub fn probability(&self) -> Option<f64> {
        match self {
            Self::File(_) => None,
            Self::Chance(probability) => Some(*probability),
        }
    }
}

/// A file, or a number from 0 to 1; a file that is called like a number is written with its folder.
pub fn fail(text: &str) -> Result<Fail, String> {
    match text.parse::<f64>() {
        Ok(probability) if (0.0..=1.0).contains(&probability) => Ok(Fail::Chance(probability)),
        Ok(_) => Err("a file, or a probability from 0 to 1".into()),
        Err(_) => Ok(Fail::File(text.into())),
    }
}

/// Forms of log lines.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum LogFormat {
    /// For people.
    Text,
    /// For programs.
    Json,
}
