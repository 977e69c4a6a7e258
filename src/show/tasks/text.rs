//! Tasks as text.

use super::detail::TaskDetail;
use super::summary::TaskSummary;
use crate::Palette;
use crate::status::Outline;
use crate::text::table::{Column, head, line as row, rest};
use crate::text::{clip, columns};

/// A task in one line: `3 fetch the mug  waiting, 1 of 4 done: pick: needs 2 grippers, 1 free`.
pub fn line(task: &TaskSummary, width: usize, palette: &Palette) -> String {
    let name = Palette::paint(palette.strong, &task.name);
    let number = Palette::paint(palette.faint, task.task);
    let room = width.saturating_sub(columns(&format!("{} {}  ", task.task, task.name)));
    let note = clip(&format!("{}{}", task.state.word(), note(task)), room);
    format!("{number} {name}  {}", Palette::paint(palette.of(task.state.looks_like()), note))
}

/// All tasks, a line each below a head.
pub fn table(tasks: &[TaskSummary], width: usize, palette: &Palette) -> String {
    let states = tasks.iter().map(|task| task.state.word());
    let mut table = vec![
        Column::number("task", 4),
        Column::of("name", tasks.iter().map(|task| task.name.as_str()), width / 3),
        Column::of("state", states, 10),
        Column::number("priority", 8),
        Column::wide("done", 9),
    ];
    table.push(Column::wide("why", rest(&table, width)));
    let cells = |task: &TaskSummary| {
        let plain = Palette::plain().strong;
        row(
            &table,
            &[
                (palette.faint, task.task.to_string()),
                (plain, task.name.clone()),
                (palette.of(task.state.looks_like()), task.state.word().to_owned()),
                (plain, task.priority.to_string()),
                (plain, format!("{} of {}", task.done, task.of)),
                (plain, task.said.clone().unwrap_or_default()),
            ],
        )
    };
    let lines = std::iter::once(head(&table, palette)).chain(tasks.iter().map(cells));
    lines.map(|line| line + "\n").collect()
}

/// A task in one line, and its tree below it.
pub fn tree(task: &TaskDetail, width: usize, palette: &Palette) -> String {
    let outline = Outline::new(&task.nodes, width, *palette);
    let lines = std::iter::once(line(&task.summary, width, palette)).chain(outline.lines(outline.height()));
    lines.map(|line| line + "\n").collect()
}

fn note(task: &TaskSummary) -> String {
    let said = task.said.as_ref().map_or(String::new(), |said| format!(": {said}"));
    format!(", {} of {} done{said}", task.done, task.of)
}
