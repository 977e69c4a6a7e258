//! What a parameter can stand for.

/// What an argument stands for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Type {
    Object,
    Place,
    Resource,
    /// A type of resources.
    Kind,
    Number,
    Offset,
    Text,
}

impl Type {
    /// All of them, in the order of [`Self::WORDS`].
    pub(crate) const ALL: [Self; 7] =
        [Self::Object, Self::Place, Self::Resource, Self::Kind, Self::Number, Self::Offset, Self::Text];
    /// How each is written.
    pub(crate) const WORDS: [&'static str; 7] = ["object", "place", "resource", "type", "number", "offset", "text"];

    /// How it is written.
    pub(crate) fn word(self) -> &'static str {
        Self::WORDS[self as usize]
    }

    /// With its article, as faults call it.
    pub(crate) fn what(self) -> &'static str {
        match self {
            Self::Object => "an object",
            Self::Place => "a place",
            Self::Resource => "a resource",
            Self::Kind => "a type of resource",
            Self::Number => "a number",
            Self::Offset => "two lengths: [x, y]",
            Self::Text => "a text",
        }
    }
}
