//! Small signs that say without color what became of a behavior, drawn and not typed: no font has to have them.

use super::page::Shape;

/// A sign.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Mark {
    /// Not yet run: a ring.
    Waiting,
    /// Runs: a disk.
    Active,
    /// Done by running: a check mark.
    Done,
    /// Done without running: a diamond.
    Skipped,
    /// Failed: a cross.
    Failed,
    /// Ended by being told to: a ring with a stroke.
    Canceled,
    /// Not to run any more: a stroke.
    NotAsked,
    /// Not to run any more since something else did it: a small ring with a long stroke.
    NotNeeded,
    /// In a way that was left: a corner.
    Left,
    /// Not done any more: an arrow back.
    Reopened,
    /// Interrupted, and to run again: two bars.
    Interrupted,
    /// To be done once more: a ring that is open.
    Again,
    /// Runs when the log ends: an arrow on.
    RunsOn,
}

/// A sign around a point, of a radius.
pub(crate) fn mark(mark: Mark, (x, y): (f64, f64), radius: f64) -> Shape {
    let r = radius;
    match mark {
        Mark::Waiting => Shape::circle("mark-waiting", (x, y), r * 0.8),
        Mark::Active => Shape::circle("mark-active", (x, y), r * 0.85),
        Mark::Done => {
            let points = [(x - r, y), (x - r * 0.25, y + r * 0.8), (x + r, y - r * 0.8)];
            Shape::path("mark-done", &points, false)
        }
        Mark::Skipped => {
            let points = [(x - r, y), (x, y - r), (x + r, y), (x, y + r)];
            Shape::path("mark-skipped", &points, true)
        }
        Mark::Failed => {
            let r = r * 0.85;
            let strokes = [((x - r, y - r), (x + r, y + r)), ((x - r, y + r), (x + r, y - r))];
            Shape::group("cross", strokes.map(|(from, to)| Shape::line("mark-failed", from, to)))
        }
        Mark::Canceled => {
            let ring = Shape::circle("mark-failed", (x, y), r * 0.9);
            let d = r * 0.63;
            Shape::group("barred", [ring, Shape::line("mark-failed", (x - d, y + d), (x + d, y - d))])
        }
        Mark::NotAsked => Shape::line("line", (x - r * 0.7, y), (x + r * 0.7, y)),
        Mark::NotNeeded => {
            let ring = Shape::circle("line", (x, y), r * 0.7);
            Shape::group("left", [ring, Shape::line("line", (x - r * 0.8, y + r * 0.8), (x + r * 0.8, y - r * 0.8))])
        }
        Mark::Left => {
            let points = [(x - r, y - r * 0.7), (x + r * 0.2, y - r * 0.7), (x + r * 0.2, y + r)];
            let tip = [(x - r * 0.5, y + r * 0.4), (x + r * 0.2, y + r), (x + r * 0.9, y + r * 0.4)];
            let strokes = [points, tip].map(|points| Shape::path("mark-reopened", &points, false));
            Shape::group("turn", strokes)
        }
        Mark::Reopened => {
            let points = [(x + r, y - r), (x + r, y + r * 0.2), (x - r, y + r * 0.2)];
            let tip = [(x - r * 0.3, y - r * 0.6), (x - r, y + r * 0.2), (x - r * 0.3, y + r)];
            let strokes = [points, tip].map(|points| Shape::path("mark-reopened", &points, false));
            Shape::group("back", strokes)
        }
        Mark::Interrupted => {
            let bars = [-0.45, 0.45].map(|aside| {
                let x = x + r * aside;
                Shape::line("mark-failed", (x, y - r * 0.85), (x, y + r * 0.85))
            });
            Shape::group("bars", bars)
        }
        Mark::Again => {
            let points =
                [(x + r * 0.8, y - r * 0.2), (x, y - r), (x - r * 0.8, y), (x, y + r), (x + r * 0.8, y + r * 0.2)];
            let tip = [(x + r * 0.2, y - r * 0.2), (x + r * 0.8, y - r * 0.2), (x + r * 0.8, y - r * 0.9)];
            let strokes = [Shape::path("mark-reopened", &points, false), Shape::path("mark-reopened", &tip, false)];
            Shape::group("again", strokes)
        }
        Mark::RunsOn => {
            let points = [(x - r, y - r), (x + r, y), (x - r, y + r)];
            Shape::path("mark-runs-on", &points, true)
        }
    }
}
