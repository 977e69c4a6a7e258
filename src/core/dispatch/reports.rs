//! What controllers report of the world: who may, and how often it is passed on. What was said last always is.

use std::collections::BTreeMap;
use std::time::Duration;

use super::{Dispatch, Effect};
use ambidex_model::motion::Report;
use ambidex_model::session::{REPEAT_EVERY, REPORT_EVERY};
use ambidex_model::{Change, ControllerId, ControllerMessage, FactId, Misreport, ObjectId, Time};

/// How often a report that is not heard is told of, wall time; one for each controller.
const TELL_EVERY: Duration = Duration::from_secs(1);

/// What controllers say, by whom and of what.
#[derive(Debug, Default)]
pub(super) struct Reports {
    said: BTreeMap<(ControllerId, Subject), Said>,
    /// When a report was told of that was not heard.
    misreported: BTreeMap<ControllerId, Time>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Subject {
    Fact(FactId),
    Object(ObjectId),
}

/// What a controller says of one fact or object.
#[derive(Debug, Default)]
struct Said {
    passed_on: Option<(Change, Time)>,
    /// What is to be passed on by and by.
    next: Option<Change>,
}

impl Said {
    /// From when on something else may be passed on.
    fn is_due(&self, change: Change, every: impl Fn(Duration) -> Duration) -> Option<Time> {
        let (before, at) = self.passed_on?;
        Some(at + every(if before == change { REPEAT_EVERY } else { REPORT_EVERY }))
    }
}

impl Dispatch {
    /// A controller says what it sees of the world.
    pub(super) fn reported(&mut self, now: Time, id: ControllerId, report: Report) {
        // What it said before it was attached, or when it was lost already, it says once more.
        if self.is_ending || !self.attachments[id.index()].is_ready() {
            return;
        }
        let change = match self.understood(id, &report) {
            Ok(change) => change,
            Err(why) => return self.misreported(now, id, report, why),
        };
        let subject = match change {
            Change::Fact(fact, _) => Subject::Fact(fact),
            Change::Object(object, _) | Change::Laid(object, ..) => Subject::Object(object),
            Change::Base(_) | Change::Taken(..) | Change::Emptied(_) | Change::Blocked(_) | Change::Cleared(_) => {
                return;
            }
        };
        let limits = self.limits;
        let said = self.reports.said.entry((id, subject)).or_default();
        let due = said.is_due(change, |wall| limits.robot(wall));
        let is_repeated = said.passed_on.is_some_and(|(before, _)| before == change);
        let is_late = due.is_none_or(|due| due <= now);
        said.next = (is_late || !is_repeated).then_some(change);
        self.pass_on(now);
    }

    /// Passes on what is due.
    pub(super) fn pass_on(&mut self, now: Time) {
        if !self.is_ready {
            return;
        }
        let limits = self.limits;
        for (&(id, _), said) in &mut self.reports.said {
            let Some(change) = said.next else { continue };
            if said.is_due(change, |wall| limits.robot(wall)).is_none_or(|due| due <= now) {
                (said.passed_on, said.next) = (Some((change, now)), None);
                self.effects.push(Effect::Reported(id, change));
            }
        }
    }

    /// When something that was said is to be passed on.
    pub(super) fn next_report(&self) -> Option<Time> {
        let waiting = self.reports.said.values().filter_map(|said| {
            let change = said.next?;
            said.is_due(change, |wall| self.limits.robot(wall))
        });
        waiting.min().filter(|_| self.is_ready && !self.is_ending)
    }

    /// A controller is away: what it says when it is back is news.
    pub(super) fn forget_reports(&mut self, of: ControllerId) {
        self.reports.said.retain(|(id, _), _| *id != of);
    }

    fn understood(&self, id: ControllerId, report: &Report) -> Result<Change, Misreport> {
        if !self.mission.robot.controllers[id.index()].reports.allows(report) {
            return Err(Misreport::NotAllowed);
        }
        self.labels.reported(report)
    }

    fn misreported(&mut self, now: Time, id: ControllerId, report: Report, why: Misreport) {
        let every = self.limits.robot(TELL_EVERY);
        if self.reports.misreported.get(&id).is_none_or(|at| *at + every <= now) {
            self.reports.misreported.insert(id, now);
            self.record(now, id, ControllerMessage::Misreported { report, why });
        }
    }
}
