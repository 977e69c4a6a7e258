//! Robot time along a page: where a moment lies, and the round seconds below.

use crate::text::round_step;
use ambidex_model::Time;

/// Least distance of two ticks, user units.
const TICK: f64 = 42.0;

/// A stretch of seconds over a stretch of the page.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Scale {
    pub(crate) left: f64,
    pub(crate) width: f64,
    span_s: f64,
}

impl Scale {
    /// From the beginning to a moment.
    pub(crate) fn new(end: Time, left: f64, width: f64) -> Self {
        let span_s = end.seconds();
        Self { left, width, span_s: if span_s > 0.0 { span_s } else { 1.0 } }
    }

    /// Where a moment lies; what is beyond the ends lies there.
    pub(crate) fn x(&self, at: Time) -> f64 {
        self.x_of(at.seconds())
    }

    /// Right end.
    pub(crate) fn right(&self) -> f64 {
        self.left + self.width
    }

    /// Round seconds with their places.
    pub(crate) fn ticks(&self) -> Vec<(f64, String)> {
        let step_s = round_step(self.span_s / self.width * TICK);
        let count = (self.span_s / step_s + 1e-9).floor();
        let decimals = usize::from(step_s < 1.0);
        let tick = |index: u32| {
            let at_s = f64::from(index) * step_s;
            (self.x_of(at_s), format!("{at_s:.decimals$}"))
        };
        (0..=count as u32).map(tick).collect()
    }

    fn x_of(&self, at_s: f64) -> f64 {
        self.left + (at_s / self.span_s).clamp(0.0, 1.0) * self.width
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(end_s: u64, expected: &[&str]) {
        let scale = Scale::new(Time(end_s * 1_000_000), 100.0, 300.0);
        let ticks = scale.ticks();
        let labels: Vec<_> = ticks.iter().map(|(_, label)| label.as_str()).collect();
        assert_eq!(labels, expected);
        assert!(ticks.windows(2).all(|pair| pair[1].0 - pair[0].0 >= TICK - 0.01), "{ticks:?}");
    }

    #[test]
    fn ticks_are_round_and_apart() {
        check(60, &["0", "10", "20", "30", "40", "50", "60"]);
        check(1, &["0.0", "0.2", "0.4", "0.6", "0.8", "1.0"]);
        check(0, &["0.0", "0.2", "0.4", "0.6", "0.8", "1.0"]);
        check(1_000_000, &["0", "200000", "400000", "600000", "800000", "1000000"]);
    }

    #[test]
    fn moments_lie_between_the_ends() {
        let scale = Scale::new(Time(10_000_000), 100.0, 300.0);
        assert_eq!(scale.x(Time(5_000_000)), 250.0);
        assert_eq!(scale.x(Time(50_000_000)), 400.0);
    }
}
