//! What a thing can be called, wherever its name comes from.

use std::fmt;

use super::{NAME_MAX, is_obeyed};

/// Why a text is no name for a thing.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Misnamed {
    /// Nothing stands in it.
    Empty,
    /// It has more than [`NAME_MAX`] bytes.
    TooLong,
    /// A terminal would obey something in it.
    Obeyed,
    /// It holds what stands for an argument where the thing is named.
    Argument(String),
    /// Another thing of its kind is called so.
    Taken,
}

impl Misnamed {
    /// Why nothing can be written so; none where something can.
    pub fn by_letters(text: &str) -> Option<Self> {
        if text.trim().is_empty() {
            Some(Self::Empty)
        } else if text.len() > NAME_MAX {
            Some(Self::TooLong)
        } else {
            text.chars().any(is_obeyed).then_some(Self::Obeyed)
        }
    }

    /// Why no thing can be called so, since it could not be named in a task.
    pub fn by_arguments(text: &str) -> Option<Self> {
        split_argument(text).map(|(_, argument, _)| Self::Argument(argument.to_owned()))
    }
}

impl fmt::Display for Misnamed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Empty => f.write_str("a name cannot be empty"),
            Self::TooLong => write!(f, "a name has at most {NAME_MAX} bytes"),
            Self::Obeyed => f.write_str("a name is one line of printable letters"),
            Self::Argument(argument) => write!(f, "`${argument}` stands for an argument, and there is none here"),
            Self::Taken => f.write_str("the name is taken"),
        }
    }
}

impl std::error::Error for Misnamed {}

/// The first argument that a text asks for, as `$name` or `${name}`, between what stands before and behind it.
pub fn split_argument(text: &str) -> Option<(&str, &str, &str)> {
    let is_of_a_name = |letter: char| letter.is_alphanumeric() || letter == '_';
    text.match_indices('$').find_map(|(at, _)| {
        let (before, behind) = (&text[..at], &text[at + 1..]);
        let (name, behind) = match behind.strip_prefix('{').and_then(|rest| rest.split_once('}')) {
            Some(found) => found,
            None => behind.split_at(behind.find(|letter| !is_of_a_name(letter)).unwrap_or(behind.len())),
        };
        // A dollar alone is only a dollar.
        (!name.is_empty()).then_some((before, name, behind))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_nothing_can_be_called() {
        let check = |text: &str, expected: Option<Misnamed>| {
            let found = Misnamed::by_letters(text).or_else(|| Misnamed::by_arguments(text));
            assert_eq!(found, expected, "{text:?}");
        };
        check("mug", None);
        check("5 $ a piece", None);
        check("${}", None);
        check(" ", Some(Misnamed::Empty));
        check(&"é".repeat(33), Some(Misnamed::TooLong));
        check("mug\u{1b}[31m", Some(Misnamed::Obeyed));
        check("the $object", Some(Misnamed::Argument("object".to_owned())));
        check("${the object}", Some(Misnamed::Argument("the object".to_owned())));
    }
}
