//! Whether a daemon may open as many files as it has to.

use ambidex::record::Reader;
use ambidex::show::doctor::{Check, Topic};
use rustix::process::{Resource, Rlimit, getrlimit};

use super::{Subject, first_line};
use crate::descriptors::{links_within, needed};

const TOPIC: Topic = Topic::Descriptors;
/// A robot of whose controllers nothing is known.
const SOME: usize = 8;

/// Looks at the limits of this process, which are those of what is started as it was, and of the system.
pub(super) fn checks(subject: &Subject) -> Vec<Check> {
    let controllers = subject.log.as_deref().and_then(|log| Reader::open(log).ok());
    let controllers = controllers.map(|reader| reader.header().names.controllers.len());
    let own = of_process(getrlimit(Resource::Nofile), controllers);
    [Some(own), first_line("/proc/sys/fs/file-nr").and_then(|line| of_system(&line))].into_iter().flatten().collect()
}

fn of_process(limit: Rlimit, controllers: Option<usize>) -> Check {
    let number = controllers.unwrap_or(SOME);
    let whose = match controllers {
        Some(number) => format!("the robot of the newest log, of {number} controllers"),
        None => format!("a robot of {SOME} controllers"),
    };
    let needed = needed(number);
    let shown = |limit: Option<u64>| limit.map_or("no limit".to_owned(), |limit| limit.to_string());
    let found = format!(
        "{}, at most {}; {whose} needs {needed}, and {} could be served",
        shown(limit.current),
        shown(limit.maximum),
        limit.maximum.map_or("any number".to_owned(), |most| links_within(most).to_string()),
    );
    if limit.maximum.is_some_and(|most| most < needed) {
        let todo = format!("`ulimit -Hn {needed}` as root, in a unit `LimitNOFILE={needed}`");
        return TOPIC.error("open files", found, todo);
    }
    // What lies between both limits a daemon takes by itself.
    TOPIC.ok("open files", found)
}

/// Of the line in which the system tells how many are open, free, and allowed.
fn of_system(line: &str) -> Option<Check> {
    let numbers: Vec<u64> = line.split_whitespace().filter_map(|number| number.parse().ok()).collect();
    let [open, _, most] = numbers.as_slice() else { return None };
    let found = format!("{open} are open in the whole system, of {most}");
    let todo = "see who has them with `lsof | awk '{print $1}' | sort | uniq -c | sort -n`, or raise fs.file-max";
    let is_scarce = open.saturating_mul(10) > most.saturating_mul(9);
    Some(if is_scarce { TOPIC.warn("system", found, todo) } else { TOPIC.ok("system", found) })
}

#[cfg(test)]
mod tests {
    use super::*;
    use ambidex::show::doctor::Verdict;

    #[test]
    fn a_limit_is_enough_for_so_many_controllers() {
        let check = |current, maximum, controllers, expected| {
            let check = of_process(Rlimit { current, maximum }, controllers);
            assert_eq!(check.verdict, expected, "{check:?}");
        };
        check(Some(1024), Some(4096), Some(4), Verdict::Ok);
        check(Some(16), Some(4096), Some(4), Verdict::Ok);
        check(Some(1024), Some(1024), Some(40), Verdict::Error);
        check(Some(64), Some(64), None, Verdict::Error);
        check(None, None, Some(4000), Verdict::Ok);
        assert_eq!(links_within(needed(7)), 7);
        assert_eq!(links_within(0), 0);
    }

    #[test]
    fn a_system_that_has_no_more_is_told() {
        let verdict = |line| of_system(line).map(|check| check.verdict);
        assert_eq!(verdict("1000\t0\t9223372036854775807"), Some(Verdict::Ok));
        assert_eq!(verdict("950 0 1000"), Some(Verdict::Warn));
        assert_eq!(verdict("what"), None);
    }
}
