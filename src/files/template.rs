//! Text in which `$name` or `${name}` stands for an argument.

/// A piece of such a text.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Piece<'a> {
    /// Text that means itself.
    Plain(&'a str),
    /// The name of a parameter.
    Parameter(&'a str),
}

/// The pieces of a text in order.
pub(crate) fn pieces(mut text: &str) -> Vec<Piece<'_>> {
    let mut pieces = Vec::new();
    while let Some(at) = text.find('$') {
        let (plain, rest) = (&text[..at], &text[at + 1..]);
        let (name, behind) = match rest.strip_prefix('{').and_then(|rest| rest.split_once('}')) {
            Some((name, behind)) => (name, behind),
            None => rest.split_at(rest.find(|letter| !is_of_a_name(letter)).unwrap_or(rest.len())),
        };
        if !plain.is_empty() {
            pieces.push(Piece::Plain(plain));
        }
        // A dollar alone is only a dollar.
        pieces.push(if name.is_empty() { Piece::Plain("$") } else { Piece::Parameter(name) });
        text = behind;
    }
    if !text.is_empty() {
        pieces.push(Piece::Plain(text));
    }
    pieces
}

/// The parameter that a text stands for as a whole.
pub(crate) fn parameter(text: &str) -> Option<&str> {
    match pieces(text).as_slice() {
        [Piece::Parameter(name)] => Some(name),
        _ => None,
    }
}

fn is_of_a_name(letter: char) -> bool {
    letter.is_alphanumeric() || letter == '_'
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_stand_out_of_text() {
        use Piece::{Parameter, Plain};
        let table: [(&str, &[Piece<'_>]); 6] = [
            ("", &[]),
            ("shelf", &[Plain("shelf")]),
            ("$to", &[Parameter("to")]),
            ("at $to now", &[Plain("at "), Parameter("to"), Plain(" now")]),
            ("${a}b$c", &[Parameter("a"), Plain("b"), Parameter("c")]),
            ("5 $", &[Plain("5 "), Plain("$")]),
        ];
        for (text, expected) in table {
            assert_eq!(pieces(text), expected, "{text}");
        }
        assert_eq!([parameter("$to"), parameter("at $to")], [Some("to"), None]);
    }
}
