//! The runs as tables: how they ended, how long they took, why not, and what went wrong.

use std::fmt::Write;

use ambidex_record::MissionOutcome;

use super::{Trials, bounds};
use crate::Palette;
use crate::text::{MIN_WIDTH, columns, count, fit, hang, mark, of_end};

/// Most causes that are told one by one.
const MAX_CAUSES: usize = 20;
/// Cells of the bar of a share.
const BAR: usize = 24;
const OUTCOMES: [MissionOutcome; 4] =
    [MissionOutcome::Done, MissionOutcome::Failed, MissionOutcome::Stalled, MissionOutcome::Canceled];

/// All of it, each line with its end.
pub fn text(trials: &Trials, width: usize, palette: &Palette) -> String {
    let width = width.max(MIN_WIDTH);
    let mission = Palette::paint(palette.strong, &trials.mission);
    let percent = trials.probability * 100.0;
    let mut text = format!("{mission}: {}, {percent} % of attempts go wrong\n\n", count(trials.trials.len(), "run"));
    text += &outcomes(trials, palette);
    text += &times(trials, width);
    text += &causes(trials, width, palette);
    text += &survived(trials, palette);
    text
}

fn outcomes(trials: &Trials, palette: &Palette) -> String {
    let of = trials.trials.len();
    let mut text = String::new();
    for outcome in OUTCOMES {
        let seen = trials.count(outcome);
        if seen == 0 && outcome != MissionOutcome::Done {
            continue;
        }
        let share = seen as f64 / of.max(1) as f64;
        let state = of_end(outcome);
        let mark = Palette::paint(palette.of(state), mark(state));
        let _ = write!(text, "  {mark} {:<8} {seen:>6}  {:>5.1} %  ", outcome.word(), share * 100.0);
        text += &palette.bar(share, BAR);
        if outcome == MissionOutcome::Done && of > 0 {
            let (least, most) = bounds(seen, of);
            let said = format!("  {:.1} to {:.1} % with 95 % confidence", least * 100.0, most * 100.0);
            text += &Palette::paint(palette.faint, said);
        }
        text.push('\n');
    }
    text
}

/// How long the runs took that were done.
fn times(trials: &Trials, width: usize) -> String {
    let times = trials.times_s();
    let undisturbed = match trials.undisturbed_s {
        Some(seconds) => format!("{seconds:.1} s where nothing goes wrong"),
        None => "where nothing goes wrong it is not done either".to_owned(),
    };
    let at = |share: f64| times[((times.len() - 1) as f64 * share).round() as usize];
    let said = match times.len() {
        0 => undisturbed,
        1 => format!("done in {:.1} s of robot time; {undisturbed}", at(0.0)),
        _ => format!(
            "done in {:.1} to {:.1} s of robot time, half of them within {:.1} s, 9 of 10 within {:.1} s; {undisturbed}",
            at(0.0),
            at(1.0),
            at(0.5),
            at(0.9)
        ),
    };
    format!("\n{}", hang("  ", 2, &said, width))
}

fn causes(trials: &Trials, width: usize, palette: &Palette) -> String {
    let groups = trials.groups();
    if groups.is_empty() {
        return String::new();
    }
    let mut text = format!("\n{}\n", Palette::paint(palette.strong, "why not"));
    let name = |at: &Option<String>| at.clone().unwrap_or_else(|| "–".to_owned());
    let longest = groups.iter().take(MAX_CAUSES).map(|group| columns(&name(&group.cause.at))).max();
    let name_width = longest.unwrap_or_default().min(width / 3);
    for group in groups.iter().take(MAX_CAUSES) {
        let state = of_end(group.outcome);
        let mark = Palette::paint(palette.of(state), mark(state));
        let head = format!("  {mark} {:>6}  {}  ", group.count, fit(&name(&group.cause.at), name_width));
        let said = format!("{} (seed {})", group.cause.why, group.seed);
        text += &hang(&head, name_width + 14, &said, width);
    }
    if groups.len() > MAX_CAUSES {
        let _ = writeln!(text, "  and {}", count(groups.len() - MAX_CAUSES, "more cause"));
    }
    text
}

fn survived(trials: &Trials, palette: &Palette) -> String {
    let survived = trials.survived();
    if survived.is_empty() {
        return String::new();
    }
    let mut text = format!("\n{}\n", Palette::paint(palette.strong, "what went wrong, and was done all the same"));
    for (kind, (runs, done)) in survived {
        let share = done as f64 / runs as f64;
        let word: &str = kind.into();
        let bar = palette.bar(share, BAR);
        let _ = writeln!(text, "  {word:<28}  {done:>6} of {runs:<6} {:>5.1} %  {bar}", share * 100.0);
    }
    text
}
