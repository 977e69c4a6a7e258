//! What keeps a picture of a long run small: how much is drawn at most, and what of it.

use std::collections::BTreeSet;

use ambidex_model::NodeId;

use ambidex_record::History;

/// Most behaviors that are all drawn; of more, those that ran.
const MAX_ROWS: usize = 60;
/// Most of those that ran; of more, the first.
const MAX_RAN: usize = 200;
/// Most resources that are drawn.
pub(super) const MAX_LANES: usize = 30;
/// Most leases of one resource at once that are drawn.
pub(super) const MAX_TRACKS: usize = 4;
/// Things in a row beyond which those are left out that nobody could tell apart.
const MANY: usize = 100;
/// What is nearer than this cannot be told apart, user units.
const NEAR: f64 = 6.0;

/// The behaviors to draw, and what is said of the others.
pub(super) fn rows(history: &History) -> (Vec<NodeId>, Option<String>) {
    let mut leaves: Vec<NodeId> = history.leaves().collect();
    let all = leaves.len();
    if all > MAX_ROWS {
        leaves.retain(|&leaf| history.leaf(leaf).is_some_and(|leaf| leaf.has_run()));
    }
    let ran = leaves.len();
    leaves.truncate(MAX_RAN);
    let idle = all - ran;
    let note = match (idle, ran - leaves.len()) {
        (0, 0) => None,
        (idle, 0) => Some(format!("{idle} of {all} behaviors did not run and are left out")),
        (idle, cut) => Some(format!("of {all} behaviors {idle} that did not run and {cut} that ran are left out")),
    };
    (leaves, note)
}

/// Leaves out, where there are many, what begins and ends where something stands already.
///
/// `place` says where a thing begins and ends and on which track it lies.
pub(super) fn thinned<T>(things: Vec<T>, place: impl Fn(&T) -> (f64, f64, usize)) -> (Vec<T>, bool) {
    if things.len() <= MANY {
        return (things, false);
    }
    let all = things.len();
    let mut taken = BTreeSet::new();
    let cell = |x: f64| (x / NEAR) as i64;
    let mut is_new = |thing: &T| {
        let (from, to, track) = place(thing);
        taken.insert((track, cell(from))) || to - from >= NEAR
    };
    let kept: Vec<T> = things.into_iter().filter(|thing| is_new(thing)).collect();
    let is_less = kept.len() < all;
    (kept, is_less)
}

/// Those of rising places that are at least so far apart.
pub(super) fn apart(places: impl Iterator<Item = f64>, least: f64) -> Vec<f64> {
    let mut kept: Vec<f64> = Vec::new();
    for place in places {
        if kept.last().is_none_or(|last| place - last >= least) {
            kept.push(place);
        }
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn few_things_are_all_kept() {
        let things = vec![0.0, 0.1, 0.2];
        assert_eq!(thinned(things.clone(), |x| (*x, *x, 0)), (things, false));
    }

    #[test]
    fn many_things_are_bounded_by_the_room() {
        let things: Vec<f64> = (0..100_000).map(|index| f64::from(index) * 0.006).collect();
        let (kept, is_less) = thinned(things, |x| (*x, x + 0.003, 0));
        assert!(is_less && kept.len() == 100, "{}", kept.len());
    }

    #[test]
    fn places_stand_apart() {
        assert_eq!(apart([0.0, 1.0, 2.0, 2.5, 4.0].into_iter(), 2.0), [0.0, 2.0, 4.0]);
    }
}
