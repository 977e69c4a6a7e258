//! What the daemon itself says of its controllers: the numbers of the last second, which no log has.

use std::time::{Duration, Instant};

use ambidex::http;
use ambidex::link::Instance;
use ambidex::model::Diagnostics;
use ambidex::show::status::Daemon;

/// How often it is asked; it says something new as often.
const ASK_EVERY: Duration = Duration::from_secs(1);
/// How long an answer is awaited: a daemon that hangs must not hold up who looks at its log.
const ANSWER_WITHIN: Duration = Duration::from_millis(250);

/// A daemon that is asked now and then.
#[derive(Debug)]
pub struct Vitals {
    instance: Option<Instance>,
    asked: Option<Instant>,
    told: Vec<Diagnostics>,
}

impl Vitals {
    /// Of the daemon of an instance; of none there is nothing to be told.
    pub fn of(instance: Option<Instance>) -> Self {
        Self { instance, asked: None, told: Vec::new() }
    }

    /// What was told last; nothing where no daemon lives or answers.
    pub fn told(&mut self, daemon: Daemon) -> &[Diagnostics] {
        match (&self.instance, daemon) {
            (Some(instance), Daemon::Running { .. }) => {
                if self.asked.is_none_or(|asked| asked.elapsed() >= ASK_EVERY) {
                    self.told = diagnostics(instance);
                    self.asked = Some(Instant::now());
                }
            }
            (None, _) | (_, Daemon::Gone) => self.told.clear(),
        }
        &self.told
    }
}

fn diagnostics(instance: &Instance) -> Vec<Diagnostics> {
    // What the log has is told all the same.
    let about = http::about(instance, ANSWER_WITHIN);
    about.map_or_else(|_| Vec::new(), |about| about.controllers.into_iter().map(|named| named.diagnostics).collect())
}
