//! Lists in sentences.

/// Most names that a list tells; of more, the rest is counted.
const MAX_LISTED: usize = 6;

/// `a`, `a and b`, `a, b and c`; of many, the first and how many more.
pub(crate) fn listed<T: AsRef<str>>(items: &[T]) -> String {
    let most = if items.len() > MAX_LISTED + 1 { MAX_LISTED } else { items.len() };
    let shown: Vec<&str> = items[..most].iter().map(AsRef::as_ref).collect();
    match (shown.as_slice(), items.len() - most) {
        ([], _) => String::new(),
        (shown, more) if more > 0 => format!("{} and {more} more", shown.join(", ")),
        ([only], _) => (*only).to_owned(),
        ([all @ .., last], _) => format!("{} and {last}", all.join(", ")),
    }
}
