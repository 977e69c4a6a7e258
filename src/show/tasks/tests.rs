//! The one task of experiment 1, at moments of it.

use ambidex_model::{Blocked, MissionEnd, Reason, Record, TypeId};
use ambidex_record::History;

use super::{TaskState, TaskSummary, detail, line, summaries, table, tree};
use crate::Palette;
use crate::sample::{decided, experiment_1, named, seconds};

fn own(records: &[Record]) -> TaskSummary {
    let history = History::of(records).expect("a header");
    let [task] = <[TaskSummary; 1]>::try_from(summaries(&history)).expect("the mission alone");
    task
}

#[test]
fn it_waits_runs_and_is_done() {
    let all = experiment_1();
    let first = all.iter().position(|record| matches!(record, Record::Decided { .. })).expect("a decision");
    let check = |records: usize, expected: (TaskState, usize)| {
        let task = own(&all[..records]);
        assert_eq!((task.state, task.done), expected, "{task:?}");
        assert_eq!((task.task, task.name.as_str(), task.of), (1, "experiment 1", 16));
    };
    check(1, (TaskState::Waiting, 0));
    check(first + 1, (TaskState::Running, 0));
    check(all.len(), (TaskState::Done, 16));
    assert!(TaskState::Done.is_end() && !TaskState::Stalled.is_end());
}

#[test]
fn it_says_why_it_does_not_go_on() {
    let all = experiment_1();
    let header = &all[0];
    let told_to_end = Record::Ending { at: seconds(1.0), end: MissionEnd::Canceled, until: seconds(1.0) };
    let check = |records: &[Record], expected: (TaskState, Option<&str>)| {
        let records: Vec<Record> = [header].into_iter().chain(records).cloned().collect();
        let task = own(&records);
        assert_eq!((task.state, task.said.as_deref()), expected);
    };
    let mut waits = decided(1.0, 1, Vec::new());
    if let Record::Decided { refused, .. } = &mut waits {
        refused.push(Blocked { leaf: named("pick 1"), reason: Reason::NoneFree { of: TypeId(2) } });
    }
    check(&[waits], (TaskState::Waiting, Some("pick 1: every gripper is held or full")));
    check(std::slice::from_ref(&told_to_end), (TaskState::Ending, None));
    let ended = Record::Ended { at: seconds(2.0), end: MissionEnd::Canceled };
    check(&[told_to_end, ended], (TaskState::Canceled, Some("it was told to end")));
}

#[test]
fn it_is_shown() {
    let history = History::of(&experiment_1()).expect("a header");
    let (tasks, plain) = (summaries(&history), Palette::plain());
    assert_eq!(line(&tasks[0], 60, &plain), "1 experiment 1  done, 16 of 16 done");
    let shown = table(&tasks, 80, &plain);
    let lines: Vec<&str> = shown.lines().collect();
    assert_eq!(lines[0], "task  name          state  priority  done       why");
    assert_eq!(lines[1], "   1  experiment 1  done          0  16 of 16");
    let detail = detail(&history, 1).expect("the mission");
    let shown = tree(&detail, 80, &plain);
    let lines: Vec<&str> = shown.lines().collect();
    assert!(lines[2].contains("all objects") && lines[3].contains("object 1"), "{shown}");
    assert_eq!(lines.len(), 2 + detail.nodes.len(), "{shown}");
    assert_eq!(super::detail(&history, 2), None);
}
