//! "Did you mean": what to say of a name that nothing has.

/// More names than that are only counted.
const MAX_LISTED: usize = 12;
/// Most names that are told of those that hold what was written.
const MAX_MEANT: usize = 3;

/// The name that was probably meant: the one that a few letters turn into what was found.
pub fn nearest<'a>(found: &str, allowed: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let letters = found.chars().count();
    let most = (letters / 3).clamp(1, 3);
    let found = found.to_lowercase();
    let length = found.chars().count();
    let distance = |word: &'a str| {
        let lower = word.to_lowercase();
        // A letter more is a change, and a long text is not compared letter by letter with every name.
        let is_near = lower.chars().count().abs_diff(length) <= most;
        is_near.then(|| (word, strsim::osa_distance(&found, &lower)))
    };
    let (nearest, changes) = allowed.into_iter().filter_map(distance).min_by_key(|(_, changes)| *changes)?;
    // Another letter is not a misspelled one.
    (changes < letters.max(1) && changes <= most).then_some(nearest)
}

/// What was probably meant, and what is allowed; `what` is the noun of the thing.
pub fn suggestion<'a>(found: &str, what: &str, allowed: impl IntoIterator<Item = &'a str>) -> String {
    let allowed: Vec<&str> = allowed.into_iter().collect();
    if allowed.is_empty() {
        return format!("there is no {what} at all");
    }
    let nearest = nearest(found, allowed.iter().copied());
    let listed = allowed.iter().take(MAX_LISTED).map(|word| format!("`{word}`"));
    let mut listed = listed.collect::<Vec<_>>().join(", ");
    if allowed.len() > MAX_LISTED {
        listed += &format!(" and {} more", allowed.len() - MAX_LISTED);
    }
    // A part of a name is what one remembers of it.
    let part = || allowed.iter().filter(|word| found.len() > 2 && word.to_lowercase().contains(&found.to_lowercase()));
    let meant: Vec<_> = nearest.iter().chain(part().take(MAX_MEANT)).map(|word| format!("`{word}`")).collect();
    match meant.split_first() {
        Some((first, _)) if nearest.is_some() => format!("did you mean {first}? Allowed: {listed}"),
        Some(_) => format!("did you mean {}? Allowed: {listed}", meant.join(" or ")),
        None => format!("allowed: {listed}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(found: &str, expected: &str) {
        assert_eq!(suggestion(found, "node", ["pick 1", "pick 2", "move 1"]), expected);
    }

    #[test]
    fn a_near_name_is_suggested_and_all_are_told() {
        check("pik 2", "did you mean `pick 2`? Allowed: `pick 1`, `pick 2`, `move 1`");
        check("MOVE 1", "did you mean `move 1`? Allowed: `pick 1`, `pick 2`, `move 1`");
        check("pick", "did you mean `pick 1` or `pick 2`? Allowed: `pick 1`, `pick 2`, `move 1`");
        check("shelf", "allowed: `pick 1`, `pick 2`, `move 1`");
        assert_eq!(suggestion("x", "fact", []), "there is no fact at all");
    }
}
