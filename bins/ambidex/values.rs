//! Values of options, as they are written.

use std::path::{Path, PathBuf};
use std::time::Duration;

use clap::ValueEnum;

use ambidex::link::Instance;

/// The name of a runtime.
pub fn instance(name: &str) -> Result<Instance, String> {
    Instance::new(name).map_err(|error| error.to_string())
}

/// Robot seconds per wall second.
pub fn speed(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(speed) if (0.01..=1000.0).contains(&speed) => Ok(speed),
        Ok(_) | Err(_) => Err("a number from 0.01 to 1000".into()),
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
