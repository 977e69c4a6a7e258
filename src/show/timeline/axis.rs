//! Robot time along a row of cells: where a moment lies, and the ruler below.

use ambidex_model::Time;

use crate::text::{columns, round_step};

/// Fewest cells between two ticks, so that their labels stand apart.
const TICK_CELLS: f64 = 6.0;

/// A stretch of robot time over a number of cells.
#[derive(Debug, Clone, Copy)]
pub(super) struct Axis {
    span_s: f64,
    pub(super) cells: usize,
}

impl Axis {
    /// From the beginning to a moment.
    pub(super) fn new(end: Time, cells: usize) -> Self {
        let span_s = end.seconds();
        Self { span_s: if span_s > 0.0 { span_s } else { 1.0 }, cells }
    }

    /// The cell that begins nearest to a moment, from 0 to the number of cells.
    pub(super) fn cell(&self, at: Time) -> usize {
        self.cell_of(at.seconds())
    }

    fn cell_of(&self, at_s: f64) -> usize {
        let share = at_s / self.span_s;
        (share.clamp(0.0, 1.0) * self.cells as f64).round() as usize
    }

    /// Ticks and their labels in seconds.
    pub(super) fn ruler(&self) -> [String; 2] {
        let step_s = round_step(self.span_s / self.cells as f64 * TICK_CELLS);
        let mut line = vec!['─'; self.cells];
        let mut labels = String::new();
        for tick in (0_u64..).map(|tick| tick as f64 * step_s) {
            let cell = self.cell_of(tick);
            if tick > self.span_s || cell >= self.cells {
                break;
            }
            line[cell] = '┴';
            let label = match step_s < 1.0 {
                true => format!("{tick:.1}"),
                false => format!("{tick:.0}"),
            };
            let from = cell.saturating_sub((label.len() - 1) / 2);
            let used = columns(&labels);
            if from + label.len() <= self.cells && (from > used || used == 0) {
                labels.push_str(&" ".repeat(from - used));
                labels.push_str(&label);
            }
        }
        [line.into_iter().collect(), labels]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(end_s: u64, cells: usize, line: &str, labels: &str) {
        let axis = Axis::new(Time(end_s * 1_000_000), cells);
        assert_eq!(axis.ruler(), [line.to_owned(), labels.to_owned()]);
    }

    #[test]
    fn ticks_are_round_and_apart() {
        check(100, 30, "┴─────┴─────┴─────┴─────┴─────", "0     20    40    60    80");
        check(1, 20, "┴─────────┴─────────", "0.0      0.5");
        check(0, 20, "┴─────────┴─────────", "0.0      0.5");
    }

    #[test]
    fn moments_beyond_the_end_stay_on_the_axis() {
        let axis = Axis::new(Time(2_000_000), 10);
        let cells = [0, 1_000_000, 2_000_000, 9_000_000].map(|at| axis.cell(Time(at)));
        assert_eq!(cells, [0, 5, 10, 10]);
    }
}
