//! What the dead have left, and of which instance it is.

use std::fs;
use std::path::Path;

use ambidex::link::{Instance, Survey, Surveyed, count_dead_nodes};
use ambidex::record::shown;
use ambidex::show::doctor::{Check, Topic};

use super::bytes;
use crate::diagnostics::legible;

const TOPIC: Topic = Topic::Leftovers;
const FIX: &str = "`ambidex doctor --fix` removes it, and so does whatever runs next";
const FIX_ALONE: &str = "`ambidex doctor --fix` removes it";

/// Looks at all instances of this user.
pub(super) fn checks(survey: &Survey) -> Vec<Check> {
    let mut checks: Vec<Check> = survey.instances.iter().flat_map(of_instance).collect();
    if let [first, ..] = survey.orphans.as_slice() {
        let found = format!("{} of no instance, as {}", segments(survey.orphans.len()), shown(first));
        checks.push(TOPIC.warn("shared memory", found, FIX));
    }
    if checks.is_empty() {
        checks.push(TOPIC.ok("instances", living(survey)));
    }
    checks
}

fn of_instance(instance: &Surveyed) -> Vec<Check> {
    let name = legible(&instance.name);
    let (many, size) = (segments(instance.segments.len()), bytes(instance.bytes));
    if instance.is_abandoned() {
        return vec![TOPIC.warn(name, format!("no process lives in it; {many}, {size} are left"), FIX)];
    }
    let mut checks = Vec::new();
    if !instance.stale.is_empty() {
        let files: Vec<_> = instance.stale.iter().filter_map(|path| path.file_name()).collect();
        let files: Vec<_> = files.into_iter().map(|name| shown(Path::new(name))).collect();
        let found = format!("of processes that are gone: {}", files.join(", "));
        checks.push(TOPIC.warn(&name, found, FIX_ALONE));
    }
    // While one is not finished nobody can look at nodes without waiting for it.
    let is_empty = |path: &Path| fs::metadata(path).is_ok_and(|about| about.len() == 0);
    let unfinished = instance.segments.iter().filter(|path| is_empty(path)).count();
    let nodes = match (unfinished, Instance::new(&instance.name)) {
        (0, Ok(instance)) => count_dead_nodes(&instance),
        (_, _) => 0,
    };
    if unfinished > 0 {
        let found = format!("{} whose maker has not finished it", segments(unfinished));
        checks.push(TOPIC.warn(&name, found, format!("if it is still so in a second, {FIX_ALONE}")));
    }
    if nodes > 0 {
        let noun = if nodes == 1 { "a process" } else { "processes" };
        checks.push(TOPIC.warn(&name, format!("{nodes} places in shared memory of {noun} that were killed"), FIX));
    }
    checks
}

/// Who lives.
fn living(survey: &Survey) -> String {
    let said = |instance: &Surveyed| {
        let controllers = instance.residents.len() - usize::from(instance.daemon().is_some());
        let daemon = instance.daemon().map_or("no daemon".to_owned(), |pid| format!("daemon pid {pid}"));
        format!("{} ({daemon}, {controllers} controllers)", legible(&instance.name))
    };
    match survey.instances.as_slice() {
        [] => "nothing is left, and nothing runs".to_owned(),
        some => format!("nothing is left of dead ones; {}", some.iter().map(said).collect::<Vec<_>>().join(", ")),
    }
}

fn segments(number: usize) -> String {
    format!("{number} segment{} of shared memory", if number == 1 { "" } else { "s" })
}

#[cfg(test)]
mod tests {
    use super::*;
    use ambidex::link::Resident;
    use ambidex::show::doctor::Verdict;

    fn instance(residents: &[&str], stale: &[&str]) -> Surveyed {
        let resident = |lock: &&str| Resident { lock: (*lock).to_owned(), pid: 7 };
        Surveyed {
            name: "No\u{1b}Such".to_owned(),
            folder: "/none".into(),
            residents: residents.iter().map(resident).collect(),
            stale: stale.iter().map(Into::into).collect(),
            segments: Vec::new(),
            bytes: 3 << 20,
        }
    }

    #[test]
    fn what_is_left_is_told_with_its_instance() {
        let check = |survey: Survey, verdict: Verdict, said: &str| {
            let checks = checks(&survey);
            assert!(checks.iter().all(|check| check.verdict == verdict), "{checks:?}");
            assert!(checks.iter().any(|check| check.found.contains(said)), "{said}: {checks:?}");
            assert!(checks.iter().all(|check| !check.what.contains('\u{1b}')), "{checks:?}");
        };
        let of = |instances: Vec<Surveyed>| Survey { instances, ..Survey::default() };
        check(of(vec![]), Verdict::Ok, "nothing is left, and nothing runs");
        check(
            of(vec![instance(&["daemon.lock", "controller-a.lock"], &[])]),
            Verdict::Ok,
            "daemon pid 7, 1 controllers",
        );
        check(of(vec![instance(&[], &["/none/daemon.lock"])]), Verdict::Warn, "no process lives in it; 0 segments");
        check(of(vec![instance(&["controller-a.lock"], &["/x/control.sock"])]), Verdict::Warn, "gone: control.sock");
        let orphans = Survey { orphans: vec!["/dev/shm/ambidex_x".into()], ..Survey::default() };
        check(orphans, Verdict::Warn, "1 segment of shared memory of no instance, as /dev/shm/ambidex_x");
    }
}
