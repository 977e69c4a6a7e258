//! Whether this program, the daemons that live, their controllers and the newest log are of one version.

use std::path::Path;
use std::time::Duration;

use ambidex::http::{self, AskError};
use ambidex::link::{Instance, Surveyed, WIRE_VERSION};
use ambidex::model::{Diagnosis, JOURNAL_VERSION, Rejection};
use ambidex::record::{JournalError, Reader, shown};
use ambidex::runtime::control::About;
use ambidex::show::doctor::{Check, Topic};

use super::Subject;
use crate::diagnostics::legible;

const TOPIC: Topic = Topic::Versions;
/// How long a daemon may take for an answer that it has at hand.
const ANSWER_WITHIN: Duration = Duration::from_secs(1);

/// Asks and reads who is of which version.
pub(super) fn checks(subject: &Subject) -> Vec<Check> {
    let own = format!("ambidex {}, wire {WIRE_VERSION}, log {JOURNAL_VERSION}", env!("CARGO_PKG_VERSION"));
    let mut checks = vec![TOPIC.ok("this program", own)];
    let is_meant = |of: &&Surveyed| subject.instance.as_ref().is_none_or(|instance| instance.name() == of.name);
    let with_daemon = |of: &Surveyed| of.daemon().and_then(|pid| Some((pid, Instance::new(&of.name).ok()?)));
    for (pid, instance) in subject.survey.instances.iter().filter(is_meant).filter_map(with_daemon) {
        let what = format!("daemon {}", instance.name());
        checks.extend(daemon(&what, pid, http::about(&instance, ANSWER_WITHIN)));
    }
    checks.push(log(subject.log.as_deref()));
    checks
}

fn daemon(what: &str, pid: u32, answer: Result<About, AskError>) -> Vec<Check> {
    let about = match answer {
        Ok(about) => about,
        Err(error @ AskError::Late { .. }) => {
            let todo =
                format!("see whether it is stopped or hangs: `cat /proc/{pid}/status`; a robot does not move by it");
            return vec![TOPIC.error(what, format!("pid {pid}: {error}"), todo)];
        }
        Err(error @ (AskError::NoDaemon(_) | AskError::Ended(_) | AskError::Socket { .. })) => {
            return vec![TOPIC.warn(
                what,
                format!("pid {pid}: {error}"),
                "if it does not just begin or end, start it anew",
            )];
        }
        Err(AskError::Answer { .. }) => {
            let found = format!("pid {pid} does not say which version it is: it is of another");
            return vec![TOPIC.warn(what, found, "start it anew with this program, or ask it with its own")];
        }
    };
    let mut checks = vec![daemon_version(what, pid, &about)];
    checks.extend(about.controllers.iter().filter_map(|controller| {
        let is_strange = controller.diagnostics.message == Diagnosis::Unheard(Rejection::Version);
        let todo = format!("build it with ambidex-link of wire version {}", about.wire_version);
        let name = format!("controller {}", legible(&controller.name));
        is_strange.then(|| TOPIC.error(name, controller.diagnostics.message.to_string(), todo))
    }));
    checks
}

fn daemon_version(what: &str, pid: u32, about: &About) -> Check {
    let About { version, wire_version, log_version, .. } = about;
    let found = format!("pid {pid}: ambidex {}, wire {wire_version}, log {log_version}", legible(version));
    if *wire_version != WIRE_VERSION {
        let todo = "start daemon and controllers with the same program: controllers of this one would be refused";
        return TOPIC.error(what, found, todo);
    }
    if (version.as_str(), *log_version) != (env!("CARGO_PKG_VERSION"), JOURNAL_VERSION) {
        return TOPIC.warn(what, found, "start it anew with this program when its mission has ended");
    }
    TOPIC.ok(what, found)
}

/// The newest log, or that of the instance.
fn log(path: Option<&Path>) -> Check {
    let what = "newest log";
    let Some(path) = path else { return TOPIC.ok(what, "there is none yet") };
    match Reader::open(path) {
        Ok(reader) => TOPIC.ok(what, format!("version {}: {}", reader.header().version, shown(path))),
        Err(error @ JournalError::Version { .. }) => {
            let todo =
                "read it with the program that wrote it; a run that it tells of cannot be gone on with by this one";
            TOPIC.warn(what, error.to_string(), todo)
        }
        Err(error) => TOPIC.warn(
            what,
            format!("it cannot be read: {error}"),
            "remove it, or move it to where it is not looked for",
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ambidex::model::{ControllerId, Diagnostics, Vitals};
    use ambidex::runtime::control::ControllerDiagnostics;
    use ambidex::show::doctor::Verdict;

    fn about(wire_version: u32, log_version: u32, message: Diagnosis) -> About {
        let diagnostics =
            Diagnostics { controller: ControllerId(0), level: message.level(), message, values: Vitals::default() };
        let controllers = vec![ControllerDiagnostics { name: "arm".into(), diagnostics }];
        About { version: env!("CARGO_PKG_VERSION").into(), wire_version, log_version, controllers }
    }

    #[test]
    fn whoever_is_of_another_version_is_named() {
        let check = |answer: Result<About, AskError>, expected: &[Verdict]| {
            let found = daemon("daemon lab", 7, answer);
            let verdicts: Vec<_> = found.iter().map(|check| check.verdict).collect();
            assert_eq!(verdicts, expected, "{found:?}");
        };
        let well = |wire, log| Ok(about(wire, log, Diagnosis::Serves));
        check(well(WIRE_VERSION, JOURNAL_VERSION), &[Verdict::Ok]);
        check(well(WIRE_VERSION, JOURNAL_VERSION + 1), &[Verdict::Warn]);
        check(well(WIRE_VERSION + 1, JOURNAL_VERSION), &[Verdict::Error]);
        let strange = about(WIRE_VERSION, JOURNAL_VERSION, Diagnosis::Unheard(Rejection::Version));
        check(Ok(strange), &[Verdict::Ok, Verdict::Error]);
        check(Err(AskError::Late { instance: "lab".into(), within: ANSWER_WITHIN }), &[Verdict::Error]);
        check(Err(AskError::NoDaemon("lab".into())), &[Verdict::Warn]);
    }

    #[test]
    fn a_log_of_another_version_is_told_with_both() {
        let home = tempfile::tempdir().expect("a folder");
        let path = home.path().join("journal.jsonl");
        assert_eq!(log(None).verdict, Verdict::Ok);
        for (text, verdict, said) in [
            ("{\"record\":\"header\",\"version\":1}\n", Verdict::Warn, "has version 1"),
            ("no log\n", Verdict::Warn, "cannot be read"),
        ] {
            std::fs::write(&path, text).expect("a file");
            let check = log(Some(&path));
            assert!(check.verdict == verdict && check.found.contains(said), "{check:?}");
        }
    }
}
