//! How much of what a peer does is taken up in a while, so that one who floods takes neither time nor memory of others.

use std::time::Duration;

/// So many in a window of time, which begins with the first in it. Time is handed in, nanoseconds.
#[derive(Debug, Clone, Copy)]
pub struct Pace {
    most: u32,
    window_ns: u64,
    began_ns: u64,
    taken: u32,
    passed_over: u64,
}

impl Pace {
    /// At most so many in a window of that length.
    pub const fn new(most: u32, window: Duration) -> Self {
        Self { most, window_ns: window.as_nanos() as u64, began_ns: 0, taken: 0, passed_over: 0 }
    }

    /// Whether one more is taken now; one that is not is counted.
    pub fn takes(&mut self, now_ns: u64) -> bool {
        if !self.is_within(now_ns) {
            (self.began_ns, self.taken) = (now_ns, 0);
        }
        let is_taken = self.taken < self.most;
        if is_taken {
            self.taken += 1;
        } else {
            self.passed_over += 1;
        }
        is_taken
    }

    /// When more is taken, if none is now.
    pub fn spent_until(&self, now_ns: u64) -> Option<u64> {
        (self.is_within(now_ns) && self.taken >= self.most).then(|| self.began_ns.saturating_add(self.window_ns))
    }

    /// How many were not taken, once the window in which they came is over.
    pub fn passed_over(&mut self, now_ns: u64) -> Option<u64> {
        (self.passed_over > 0 && !self.is_within(now_ns)).then(|| std::mem::take(&mut self.passed_over))
    }

    fn is_within(&self, now_ns: u64) -> bool {
        self.taken > 0 && now_ns.saturating_sub(self.began_ns) < self.window_ns
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_window_takes_so_many_and_the_next_as_many_again() {
        let mut pace = Pace::new(2, Duration::from_nanos(10));
        let taken: Vec<_> = [0, 5, 9, 9, 10, 30, 39, 39, 40].into_iter().map(|at| pace.takes(at)).collect();
        assert_eq!(taken, [true, true, false, false, true, true, true, false, true]);
        assert_eq!((pace.spent_until(40), pace.takes(41), pace.spent_until(41)), (None, true, Some(50)));
        assert_eq!((pace.passed_over(41), pace.passed_over(50), pace.passed_over(50)), (None, Some(3), None));
    }
}
