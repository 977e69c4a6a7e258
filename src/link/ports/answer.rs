//! What may come on the stream of one request, and in which order: all else is refused, however much of it there is.

use std::time::Duration;

use crate::wire::{WireId, request_kind};
use ambidex_model::{FromController, Rejection};

/// How often feedback of one goal is passed on, wall time: the newest then. A good controller gives it half as often.
const FEEDBACK_EVERY: Duration = Duration::from_millis(50);

/// How far a request's answer is.
#[derive(Debug)]
pub(super) struct Answer {
    pub(super) kind: u32,
    pub(super) id: WireId,
    is_accepted: bool,
    is_over: bool,
    /// Feedback that is passed on by and by.
    news: Option<FromController>,
    /// When some was passed on last, nanoseconds.
    told_ns: Option<u64>,
}

impl Answer {
    /// To a request of that kind.
    pub(super) fn new(kind: u32, id: WireId) -> Self {
        Self { kind, id, is_accepted: false, is_over: false, news: None, told_ns: None }
    }

    pub(super) fn is_of_goal(&self) -> bool {
        self.kind == request_kind::GOAL
    }

    /// Whether the last word has come.
    pub(super) fn is_over(&self) -> bool {
        self.is_over
    }

    /// The last word came, and is none.
    pub(super) fn end(&mut self) {
        (self.is_over, self.news) = (true, None);
    }

    /// Takes a message; gives what is to be passed on at once.
    ///
    /// # Errors
    /// [`Rejection::Unknown`] when such a message cannot come here or now.
    pub(super) fn take(&mut self, message: FromController) -> Result<Option<FromController>, Rejection> {
        if self.is_over {
            return Err(Rejection::Unknown);
        }
        match (&message, self.kind) {
            (FromController::Configured { .. }, request_kind::CONFIGURE)
            | (FromController::Rejected { .. }, request_kind::CONFIGURE | request_kind::GOAL)
            | (FromController::Result { .. }, request_kind::GOAL) => self.end(),
            (FromController::Accepted { .. }, request_kind::GOAL) if !self.is_accepted => self.is_accepted = true,
            (FromController::Feedback { .. }, request_kind::GOAL) => {
                self.news = Some(message);
                return Ok(None);
            }
            (
                FromController::Configured { .. }
                | FromController::Accepted { .. }
                | FromController::Rejected { .. }
                | FromController::Feedback { .. }
                | FromController::Result { .. },
                _,
            ) => return Err(Rejection::Unknown),
        }
        Ok(Some(message))
    }

    /// The newest feedback, if it is time to pass it on.
    pub(super) fn news(&mut self, now_ns: u64) -> Option<FromController> {
        let since = |told_ns: u64| Duration::from_nanos(now_ns.saturating_sub(told_ns));
        if self.told_ns.is_some_and(|told_ns| since(told_ns) < FEEDBACK_EVERY) {
            return None;
        }
        let news = self.news.take()?;
        self.told_ns = Some(now_ns);
        Some(news)
    }
}

#[cfg(test)]
mod tests {
    use ambidex_model::{CommandId, ControllerState, PartEnd, Time};

    use super::*;

    const ID: CommandId = CommandId { generation: 1, number: 1 };
    const MS: u64 = 1_000_000;

    fn feedback(progress: f64) -> FromController {
        FromController::Feedback { id: ID, progress, state: ControllerState::Device }
    }

    fn words() -> [FromController; 5] {
        let state = ControllerState::Device;
        let (began, ended) = (Time(1), Time(2));
        [
            FromController::Configured { generation: 1, state },
            FromController::Accepted { id: ID, at: began },
            FromController::Rejected { id: ID, why: Rejection::Busy },
            feedback(0.5),
            FromController::Result { id: ID, end: PartEnd::Succeeded, began, ended, state },
        ]
    }

    /// After these words, which of `words` are refused.
    fn check(kind: u32, before: &[usize], expected: [bool; 5]) {
        let refused = std::array::from_fn(|index| {
            let mut answer = Answer::new(kind, WireId::default());
            before.iter().for_each(|word| assert!(answer.take(words()[*word].clone()).is_ok()));
            answer.take(words()[index].clone()).is_err()
        });
        assert_eq!(refused, expected, "{kind} after {before:?}");
    }

    #[test]
    fn nothing_comes_out_of_order() {
        let (configure, goal, cancel) = (request_kind::CONFIGURE, request_kind::GOAL, request_kind::CANCEL);
        let all = [true; 5];
        check(configure, &[], [false, true, false, true, true]);
        check(configure, &[0], all);
        check(configure, &[2], all);
        check(goal, &[], [true, false, false, false, false]);
        check(goal, &[1], [true, true, false, false, false]);
        check(goal, &[1, 3], [true, true, false, false, false]);
        check(goal, &[1, 4], all);
        check(goal, &[4], all);
        check(goal, &[2], all);
        check(cancel, &[], all);
    }

    #[test]
    fn the_newest_feedback_is_passed_on_at_a_pace_and_none_after_the_end() {
        let mut answer = Answer::new(request_kind::GOAL, WireId::default());
        let mut told = Vec::new();
        for ms in 0..200_u32 {
            assert_eq!(answer.take(feedback(f64::from(ms) / 1e3)), Ok(None));
            told.extend(answer.news(u64::from(ms) * MS).map(|news| (ms, news)));
        }
        assert_eq!(told, [0, 50, 100, 150].map(|ms| (ms, feedback(f64::from(ms) / 1e3))));
        assert!(matches!(answer.take(words()[4].clone()), Ok(Some(FromController::Result { .. }))));
        assert_eq!(answer.news(u64::MAX), None);
    }
}
