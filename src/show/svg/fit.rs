//! How wide a text is, about: no font is asked. The widths are those of a wide sans-serif (DejaVu Sans), so that text
//! fits in the narrower ones too.

/// Sizes of the classes of text, user units.
pub(crate) const TEXT: f64 = 10.0;
/// Size of the title.
pub(crate) const TITLE: f64 = 14.0;
/// Size of notes.
pub(crate) const NOTE: f64 = 9.5;
/// Of labels at ticks.
pub(crate) const SMALL: f64 = 9.0;
/// Of labels in bars.
pub(crate) const INNER: f64 = 8.5;
/// Of the names of channels.
pub(crate) const CHANNEL: f64 = 8.5;

/// Width of a text of a size, user units.
pub(crate) fn width(text: &str, size: f64) -> f64 {
    text.chars().map(share).sum::<f64>() * size
}

/// The text, cut with an ellipsis where it is wider than the room.
pub(crate) fn clip(text: &str, size: f64, room: f64) -> String {
    if width(text, size) <= room {
        return text.to_owned();
    }
    let mut used = share('…') * size;
    let mut cut = String::new();
    for letter in text.chars() {
        used += share(letter) * size;
        if used > room {
            break;
        }
        cut.push(letter);
    }
    cut.truncate(cut.trim_end().len());
    cut + "…"
}

/// The text as far as there is room: whole, its words but the last cut to their first letters, or cut with an ellipsis;
/// none where not two letters have room.
pub(crate) fn shortened(text: &str, size: f64, room: f64) -> Option<String> {
    let words: Vec<&str> = text.split(' ').collect();
    let (last, before) = words.split_last()?;
    let initials: String = before.iter().filter_map(|word| word.chars().next()).collect();
    let short = [text.to_owned(), format!("{initials} {last}"), format!("{initials}{last}")];
    let short = if before.is_empty() { &short[..1] } else { &short[..] };
    if let Some(fits) = first_that_fits(short, size, room) {
        return Some(fits.to_owned());
    }
    let cut = clip(short.last()?, size, room);
    (cut.chars().count() > 2 && width(&cut, size) <= room).then_some(cut)
}

/// The first of these texts that fits, whole.
pub(crate) fn first_that_fits(texts: &[String], size: f64, room: f64) -> Option<&str> {
    texts.iter().map(String::as_str).find(|text| width(text, size) <= room)
}

/// The text in at most two lines, broken at the space that makes the wider one narrowest.
pub(crate) fn two_lines(text: &str, size: f64) -> Vec<String> {
    let breaks = text.match_indices(' ').map(|(at, _)| (&text[..at], &text[at + 1..]));
    let wider = |(one, other): &(&str, &str)| width(one, size).max(width(other, size));
    match breaks.min_by(|one, other| wider(one).total_cmp(&wider(other))) {
        Some((one, other)) => vec![one.to_owned(), other.to_owned()],
        None => vec![text.to_owned()],
    }
}

/// Width of a letter in parts of the size.
fn share(letter: char) -> f64 {
    match letter {
        'i' | 'j' | 'l' | '\'' | '|' => 0.28,
        ' ' => 0.32,
        '.' | ',' | ':' | ';' | '!' | 'I' | '·' => 0.34,
        'f' | 't' | 'r' | '(' | ')' | '[' | ']' | '/' | '-' | '"' => 0.42,
        'c' | 's' | 'z' => 0.55,
        'a' | 'e' | 'o' => 0.62,
        'k' | 'v' | 'x' | 'y' => 0.6,
        'm' | 'M' | 'W' | '%' | '@' | '…' => 1.0,
        'w' | 'O' | 'Q' | 'G' | 'D' | 'H' | 'N' | 'U' | '+' | '=' => 0.84,
        'A'..='Z' => 0.72,
        ' '..='~' => 0.64,
        '\u{a0}'..='\u{5ff}' => 0.7,
        _ => 1.1,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_is_cut_to_its_room() {
        for (text, room) in [("left_gripper", 40.0), ("物体を取る", 30.0), ("a b c d e f", 25.0), ("MMMMMM", 12.0)]
        {
            let cut = clip(text, TEXT, room);
            assert!(cut.ends_with('…') && width(&cut, TEXT) <= room, "{cut}");
        }
        assert_eq!(clip("pick 1", TEXT, 100.0), "pick 1");
        assert_eq!(clip("pick 1", TEXT, 0.0), "…");
    }

    #[test]
    fn what_does_not_fit_is_shortened_before_it_is_dropped() {
        let check = |room: f64, expected: Option<&str>| {
            assert_eq!(shortened("place 4", TEXT, room).as_deref(), expected, "{room}");
        };
        check(40.0, Some("place 4"));
        check(17.0, Some("p 4"));
        check(13.0, Some("p4"));
        check(12.0, None);
        assert_eq!(shortened("fetch placemat", TEXT, 40.0).as_deref(), Some("fplac…"));
    }

    #[test]
    fn two_lines_are_about_alike() {
        assert_eq!(two_lines("move 1-1", TEXT), ["move", "1-1"]);
        assert_eq!(two_lines("pick the red cup", TEXT), ["pick the", "red cup"]);
        assert_eq!(two_lines("place", TEXT), ["place"]);
    }

    #[test]
    fn the_longest_that_fits_is_taken() {
        let texts = ["kept by object 1".to_owned(), "object 1".to_owned()];
        assert_eq!(first_that_fits(&texts, TEXT, 200.0), Some("kept by object 1"));
        assert_eq!(first_that_fits(&texts, TEXT, 55.0), Some("object 1"));
        assert_eq!(first_that_fits(&texts, TEXT, 10.0), None);
    }
}
