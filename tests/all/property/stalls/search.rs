//! A brute-force search over schedules: whatever starts next, with whatever resources, in whatever way of an OR.
//!
//! One behavior runs at a time and succeeds as its kind promises; what runs already ends in any order. Lapses, sending
//! back, leaving ways and going on behind what others did happen whenever the rules allow them at all, so the search
//! allows more than the runtime does. It tries no two behaviors at once: that matters only where each of two makes the
//! other impossible.

use std::collections::{BTreeMap, HashSet};

use ambidex::model::MissionSpec;

use crate::property::number;
use crate::property::reference::{Freedom, Model, Next};

/// Most states that one search looks at, unless `AMBIDEX_BUDGET` says otherwise.
const BUDGET: usize = 20_000;

#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Found {
    /// What happens one after the other until the mission is done.
    Schedule(Vec<Next>),
    Nothing,
    CutOff,
}

/// Searches of one mission, which share what leads nowhere.
pub struct Search<'m> {
    mission: &'m MissionSpec,
    freedom: Freedom,
    dead: HashSet<Vec<u32>>,
    budget: usize,
}

impl<'m> Search<'m> {
    pub fn new(mission: &'m MissionSpec, freedom: Freedom) -> Self {
        let budget = number("AMBIDEX_BUDGET").unwrap_or(BUDGET);
        Self { mission, freedom, dead: HashSet::new(), budget }
    }

    pub fn from(&mut self, model: &Model<'m>) -> Found {
        let start = model.for_search(self.mission, self.freedom);
        let mut seen = BTreeMap::new();
        let mut found = None;
        let mut stack = vec![(start, None::<(Vec<u32>, Next)>)];
        while let Some((model, from)) = stack.pop() {
            let key = model.key(self.freedom);
            if self.dead.contains(&key) || seen.contains_key(&key) {
                continue;
            }
            seen.insert(key.clone(), from);
            if model.is_won() {
                found = Some(key);
                break;
            }
            if seen.len() > self.budget {
                return Found::CutOff;
            }
            // What was found first is looked at first.
            let next = model.next(self.freedom).into_iter().rev();
            stack.extend(next.map(|(next, model)| (model, Some((key.clone(), next)))));
        }
        let Some(mut at) = found else {
            self.dead.extend(seen.into_keys());
            return Found::Nothing;
        };
        let mut schedule = Vec::new();
        while let Some(Some((before, next))) = seen.remove(&at) {
            schedule.push(next);
            at = before;
        }
        schedule.reverse();
        Found::Schedule(schedule)
    }
}
