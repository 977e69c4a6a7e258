//! The text at the end of a run: how it ended, its steps, what was skipped, and why where it did not get to its end.

use std::fmt::Write;

use ambidex_model::{End, Header, MissionEnd, NodeId, Reason, Tally};

use super::course::Course;
use super::text::{MIN_WIDTH, clip, columns, count, flow, hang};
use super::{LeafState, Palette, fault_sentence, last_reasons};

/// Most reasons that are all told; of more, those of leaves that were asked.
const MAX_REASONS: usize = 60;

/// What came of a run, in words.
pub fn summary(tally: &Tally, width: usize, palette: &Palette) -> String {
    let width = width.max(MIN_WIDTH);
    let Some(header) = tally.header.as_deref() else {
        return "nothing was run\n".into();
    };
    let mut text = outcome(tally, header, width, palette);
    text.push_str(&figures(tally, width));
    text.push('\n');
    text.push_str(&steps(tally, header, width, palette));
    text.push_str(&skipped(tally, header, width, palette));
    match tally.end {
        Some(MissionEnd::Stalled) => text.push_str(&reasons(tally, header, width, palette)),
        Some(
            MissionEnd::Done
            | MissionEnd::Failed(_)
            | MissionEnd::Canceled
            | MissionEnd::ControllerLost(_)
            | MissionEnd::NotAttached
            | MissionEnd::NodeLost(_)
            | MissionEnd::TaskLost,
        )
        | None => {}
    }
    text
}

/// The mission, how it ended, and at what.
fn outcome(tally: &Tally, header: &Header, width: usize, palette: &Palette) -> String {
    let (state, word, why) = ending(tally, header);
    let mission = clip(&header.mission, width / 2);
    let head = format!("{}: {}", Palette::paint(palette.strong, &mission), Palette::paint(palette.of(state), word));
    if why.is_empty() {
        return head + "\n";
    }
    let lines = flow(why.split(' '), width - 2);
    format!("{head}\n{}", hang("  ", 2, &lines))
}

/// What the mission itself came to, the word for it, and at what; the last is empty where there is nothing to say.
pub(super) fn ending(tally: &Tally, header: &Header) -> (LeafState, &'static str, String) {
    let failed = |why: String| (LeafState::Failed, "failed", why);
    match tally.end {
        None => (LeafState::Canceled, "not ended", format!("its records stop at {}", tally.now)),
        Some(MissionEnd::Done) => (LeafState::Done, "done", String::new()),
        Some(MissionEnd::Stalled) => (LeafState::Failed, "stalled", "nothing runs and nothing can".into()),
        Some(MissionEnd::Canceled) => (LeafState::Canceled, "cancelled", "it was told to end".into()),
        Some(MissionEnd::Failed(leaf)) => failed(failure(tally, header, leaf)),
        Some(MissionEnd::ControllerLost(controller)) => {
            let at = tally.lost.get(&controller).map_or(String::new(), |at| format!(" at {at}"));
            failed(format!("the controller {} was lost{at}", header.names.controller(controller)))
        }
        Some(MissionEnd::NotAttached) => failed("not every controller attached in time".into()),
        Some(MissionEnd::TaskLost) => failed("a task of the runtime is gone, which is a defect of ambidex".into()),
        Some(MissionEnd::NodeLost(node)) => {
            let node = header.names.node(node);
            failed(format!("the task of node {node} is gone, which is a defect of ambidex"))
        }
    }
}

/// Which behavior failed, when and how.
fn failure(tally: &Tally, header: &Header, leaf: NodeId) -> String {
    let name = header.names.node(leaf);
    let course = Course::new(tally);
    let failed = |end: Option<End>| match end {
        Some(End::Failed(fault)) => Some(fault),
        Some(End::Succeeded | End::Canceled) | None => None,
    };
    let faults: Vec<_> = course.runs(leaf).iter().filter_map(|run| Some((run.to?, failed(run.end)?))).collect();
    match faults.last() {
        None => format!("{name} failed"),
        Some(&(at, fault)) => {
            let fault = fault_sentence(fault, &header.names);
            match faults.len() {
                1 => format!("{name} failed at {at}: {fault}"),
                times => format!("{name} failed {times} times, at last at {at}: {fault}"),
            }
        }
    }
}

fn figures(tally: &Tally, width: usize) -> String {
    let items = [
        format!("{} in {:.1} s of robot time,", count(tally.steps.len(), "step"), tally.makespan_s()),
        format!("{},", count(tally.rounds as usize, "round")),
        format!("{} between nodes", count(usize::try_from(tally.messages).unwrap_or(usize::MAX), "message")),
    ];
    let words = items.iter().flat_map(|item| item.split(' '));
    hang("  ", 2, &flow(words, width - 2))
}

/// The steps with their numbers.
fn steps(tally: &Tally, header: &Header, width: usize, palette: &Palette) -> String {
    let digits = tally.steps.len().to_string().len().max(2);
    let mut text = String::new();
    for (index, step) in tally.steps.iter().enumerate() {
        let mut names: Vec<&str> = step.iter().map(|&leaf| header.names.node(leaf)).collect();
        names.sort_unstable();
        let last = names.len() - 1;
        let items: Vec<String> = names
            .iter()
            .enumerate()
            .map(|(at, name)| if at < last { format!("{name} +") } else { (*name).to_owned() })
            .collect();
        let number = Palette::paint(palette.faint, format!("{:>digits$}", index + 1));
        let lines = flow(items.iter().map(String::as_str), width - digits - 4);
        text.push_str(&hang(&format!("  {number}  "), digits + 4, &lines));
    }
    text
}

/// What was done without running, with its moment.
fn skipped(tally: &Tally, header: &Header, width: usize, palette: &Palette) -> String {
    if tally.skipped.is_empty() {
        return String::new();
    }
    let rows: Vec<(&str, String)> = tally
        .skipped
        .iter()
        .map(|(leaf, at)| (header.names.node(*leaf), format!("its goal was met already ({at})")))
        .collect();
    let head = format!("\n{}\n", Palette::paint(palette.strong, "skipped"));
    let mark = Palette::paint(palette.skipped, LeafState::Skipped.mark());
    head + &table(&rows, &mark, width)
}

/// Every leaf that cannot run, with its last reason.
fn reasons(tally: &Tally, header: &Header, width: usize, palette: &Palette) -> String {
    let mut open = last_reasons(tally);
    let all = open.len();
    if all > MAX_REASONS {
        open.retain(|(_, reason)| !matches!(reason, None | Some(Reason::NotItsTurn { .. })));
        open.truncate(MAX_REASONS);
    }
    let rows: Vec<(&str, String)> = open
        .iter()
        .map(|(leaf, reason)| {
            let sentence = match reason {
                Some(reason) => reason.sentence(&header.names),
                None => "it was not asked".into(),
            };
            (header.names.node(*leaf), sentence)
        })
        .collect();
    let mut text = format!("\n{}\n", Palette::paint(palette.strong, "what cannot run, and why"));
    let mark = Palette::paint(palette.waiting, LeafState::Waiting.mark());
    text.push_str(&table(&rows, &mark, width));
    if rows.len() < all {
        let _ = writeln!(text, "  {} more", count(all - rows.len(), "behavior"));
    }
    text
}

/// Names at the left, wrapped sentences at the right.
fn table(rows: &[(&str, String)], mark: &str, width: usize) -> String {
    let longest = rows.iter().map(|(name, _)| columns(name)).max();
    let name_width = longest.unwrap_or_default().min(width / 3);
    rows.iter()
        .map(|(name, sentence)| {
            let head = format!("  {mark} {:<name_width$}  ", clip(name, name_width));
            let indent = name_width + 6;
            hang(&head, indent, &flow(sentence.split(' '), width - indent))
        })
        .collect()
}
