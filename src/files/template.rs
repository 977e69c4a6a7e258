//! Text in which `$name` or `${name}` stands for an argument.

use ambidex_model::split_argument;

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
    while let Some((plain, name, behind)) = split_argument(text) {
        if !plain.is_empty() {
            pieces.push(Piece::Plain(plain));
        }
        pieces.push(Piece::Parameter(name));
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
            ("5 $", &[Plain("5 $")]),
        ];
        for (text, expected) in table {
            assert_eq!(pieces(text), expected, "{text}");
        }
        assert_eq!([parameter("$to"), parameter("at $to")], [Some("to"), None]);
    }
}
