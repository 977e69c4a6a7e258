//! YAML text as a tree in which every key and value knows its line and column; what the keys mean is not known here.

use std::fmt;
use std::io::ErrorKind;
use std::str::Utf8Error;

use serde::de::{self, Deserialize, Deserializer, MapAccess, SeqAccess, Visitor};
use serde_saphyr::budget::BudgetBreach;
use serde_saphyr::{DuplicateKeyPolicy, Error, Location, NonFiniteFloatPolicy, Options, Spanned};

/// Largest file that is read, bytes.
pub(crate) const MAX_BYTES: u64 = 1 << 20;
/// Most keys and values in one file: ten to each node of the greatest tree that fits the bytes.
const MAX_NODES: usize = 250_000;
/// Deepest nesting of lists and maps: 64 levels of a task, each a map and a list, and what is in and around them.
const MAX_DEPTH: usize = 132;
/// Stack of the parser: it takes up to 40 KiB for one level in a debug build, more than a thread may have to spare.
const STACK_BYTES: usize = 32 << 20;

/// The place among the files of the behaviors of the paper.
pub(crate) const PAPER_FILE: usize = 0;

/// Where something stands in the files.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct SourceSpan {
    /// Which file, in the order of opening.
    pub(crate) file: usize,
    /// Line, counted from 1; 0 for the file as a whole.
    pub(crate) line: usize,
    /// Letter of the line, counted from 1.
    pub(crate) column: usize,
    /// Bytes of the file before it.
    pub(crate) offset: usize,
    /// Its length in bytes.
    pub(crate) length: usize,
}

/// A value and where it stands.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Located<T> {
    /// What stands there.
    pub(crate) value: T,
    /// Where: of a list or a map where it begins.
    pub(crate) span: SourceSpan,
}

/// A value of YAML text with its place.
pub(crate) type Node = Located<Value>;

/// A key and its value.
pub(crate) type Entry = (Located<String>, Node);

/// What a YAML value is.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Value {
    /// What is left empty, `null` or `~`.
    Null,
    /// A word, number or text as written; numbers also as YAML understands them, `!degrees 90` included.
    Scalar {
        /// As written, without quotes.
        text: String,
        /// As a number, angles in radians; none for what is no number to YAML.
        number: Option<f64>,
    },
    /// A list in the order of the file.
    List(Vec<Node>),
    /// A map in the order of the file.
    Map(Vec<Entry>),
}

impl Value {
    /// Whether the same is written, wherever it stands.
    pub(crate) fn is_like(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Null, Self::Null) => true,
            (Self::Scalar { text, number }, Self::Scalar { text: other_text, number: other }) => {
                text == other_text && number.map(f64::to_bits) == other.map(f64::to_bits)
            }
            (Self::List(list), Self::List(other)) => {
                list.len() == other.len()
                    && std::iter::zip(list, other).all(|(one, other)| one.value.is_like(&other.value))
            }
            (Self::Map(map), Self::Map(other)) => {
                let mut pairs = std::iter::zip(map, other);
                let is_like = |(one, other): (&Entry, &Entry)| {
                    one.0.value == other.0.value && one.1.value.is_like(&other.1.value)
                };
                map.len() == other.len() && pairs.all(is_like)
            }
            (Self::Null | Self::Scalar { .. } | Self::List(_) | Self::Map(_), _) => false,
        }
    }
}

/// What is wrong with the YAML itself.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct SyntaxFault {
    /// Where the parser gave up.
    pub(crate) span: SourceSpan,
    /// What it found, in words for people.
    pub(crate) message: String,
}

/// Reads the text of a file, on a stack of its own where there are threads.
pub(crate) fn parse(file: usize, text: &str) -> Result<Node, SyntaxFault> {
    let whole = SourceSpan { file, ..SourceSpan::default() };
    let gave_up = |message: String| SyntaxFault { span: whole, message };
    std::thread::scope(|scope| {
        let stack = std::thread::Builder::new().name("yaml".to_owned()).stack_size(STACK_BYTES);
        match stack.spawn_scoped(scope, || parse_here(Text { file, text })) {
            Ok(parsed) => parsed.join().unwrap_or_else(|_| Err(gave_up("the YAML parser gave up on it".to_owned()))),
            // A browser has no threads, and a stack of a size that somebody else chose.
            Err(error) if error.kind() == ErrorKind::Unsupported => parse_here(Text { file, text }),
            Err(error) => Err(gave_up(format!("cannot start to read it: {error}"))),
        }
    })
}

/// The text of a file, which places are found in.
#[derive(Debug, Clone, Copy)]
struct Text<'a> {
    file: usize,
    text: &'a str,
}

fn parse_here(text: Text<'_>) -> Result<Node, SyntaxFault> {
    match serde_saphyr::from_str_with_options::<Spanned<Parsed>>(text.text, options()) {
        Ok(parsed) => Ok(located(parsed, text)),
        Err(error) => Err(SyntaxFault {
            span: error.location().map_or(SourceSpan { file: text.file, ..SourceSpan::default() }, |at| span(at, text)),
            message: sentence(&error),
        }),
    }
}

/// Where in bytes there is a text no more.
pub(crate) fn not_text(file: usize, bytes: &[u8], error: Utf8Error) -> SyntaxFault {
    let before = String::from_utf8_lossy(&bytes[..error.valid_up_to()]);
    let (line, behind) = (before.matches('\n').count() + 1, before.rsplit('\n').next().unwrap_or_default());
    // In the text that is shown one letter stands for what is none.
    let length = char::REPLACEMENT_CHARACTER.len_utf8();
    let span = SourceSpan { file, line, column: behind.chars().count() + 1, offset: before.len(), length };
    SyntaxFault { span, message: "this is not UTF-8".to_owned() }
}

/// What is wrong, without the place, which is told beside it, and without advice to programmers.
fn sentence(error: &Error) -> String {
    let error = error.without_snippet();
    match error {
        Error::Budget { breach: BudgetBreach::Depth { .. }, .. } => {
            format!("nested more than {MAX_DEPTH} lists and maps deep")
        }
        Error::Budget { breach: BudgetBreach::Nodes { .. }, .. } => format!("more than {MAX_NODES} keys and values"),
        Error::Budget { breach: BudgetBreach::Documents { .. }, .. } => {
            "a second document: a file is one mission, robot or library".to_owned()
        }
        _ => {
            let whole = error.to_string();
            let end = whole.rfind(" at line ").unwrap_or(whole.len());
            in_words(&whole[..end])
        }
    }
}

/// What the parser calls by the names of its own parts.
fn in_words(said: &str) -> String {
    if said.starts_with("alias replay") {
        return format!("aliases that stand for more than {MAX_NODES} keys and values");
    }
    match said {
        "recursion limit exceeded" => format!("nested more than {MAX_DEPTH} lists and maps deep"),
        "expected string scalar" | "cannot deserialize null into string; use Option<String>" => {
            "a key is a word, a number or quoted text".to_owned()
        }
        said => said.to_owned(),
    }
}

fn options() -> Options {
    serde_saphyr::options! {
        budget: serde_saphyr::budget! {
            max_depth: MAX_DEPTH,
            max_nodes: MAX_NODES,
            max_documents: 1,
        },
        alias_limits: serde_saphyr::alias_limits! {
            max_total_replayed_events: MAX_NODES,
        },
        angle_conversions: true,
        // Nobody here reads them, and as events only so many may stand in a row.
        emit_comments: false,
        // The reader tells of them beside all else that is wrong.
        duplicate_keys: DuplicateKeyPolicy::PassThrough,
        non_finite_float_policy: NonFiniteFloatPolicy::PassThrough,
        with_snippet: false,
    }
}

fn located(parsed: Spanned<Parsed>, text: Text<'_>) -> Node {
    let value = match parsed.value {
        Parsed::Null => Value::Null,
        Parsed::Text(text) => Value::Scalar { text, number: None },
        Parsed::Flag(flag) => {
            Value::Scalar { text: written(parsed.defined, text.text).unwrap_or_else(|| flag.to_string()), number: None }
        }
        Parsed::Number(number) => Value::Scalar {
            text: written(parsed.defined, text.text).unwrap_or_else(|| number.to_string()),
            number: Some(number),
        },
        Parsed::List(list) => Value::List(list.into_iter().map(|item| located(item, text)).collect()),
        Parsed::Map(entries) => Value::Map(
            entries
                .into_iter()
                .map(|(key, value)| {
                    let key = Located { span: span(key.referenced, text), value: key.value };
                    (key, located(value, text))
                })
                .collect(),
        ),
    };
    Located { value, span: span(parsed.referenced, text) }
}

fn written(at: Location, text: &str) -> Option<String> {
    let from = usize::try_from(at.span().byte_offset()?).ok()?;
    let length = usize::try_from(at.span().byte_len()?).ok()?;
    text.get(from..from.checked_add(length)?).map(String::from)
}

fn span(at: Location, Text { file, text }: Text<'_>) -> SourceSpan {
    let number = |value: u64| usize::try_from(value).unwrap_or(0);
    let (line, column) = (number(at.line()), number(at.column()));
    let known = at.span().byte_offset().map(number);
    let offset = known.unwrap_or_else(|| offset_of(line, column, text));
    let length = at.span().byte_len().map_or(0, number);
    let offset = text.floor_char_boundary(offset);
    // Of a text of several lines the first is enough to point at. Nothing behind it is looked at: a whole file may be one
    // line, and every key and value in it has a span.
    let end = text.floor_char_boundary(offset.saturating_add(length));
    let first = text.get(offset..end).and_then(|text| text.lines().next()).unwrap_or_default();
    SourceSpan { file, line, column, offset, length: first.len() }
}

/// Bytes before a line and column, for the places that the parser counts in characters alone.
fn offset_of(line: usize, column: usize, text: &str) -> usize {
    let mut lines = text.split_inclusive('\n');
    let before: usize = lines.by_ref().take(line.saturating_sub(1)).map(str::len).sum();
    let characters = lines.next().unwrap_or("").chars();
    let within: usize = characters.take(column.saturating_sub(1)).map(char::len_utf8).sum();
    before + within
}

enum Parsed {
    Null,
    Flag(bool),
    Number(f64),
    Text(String),
    List(Vec<Spanned<Parsed>>),
    Map(Vec<(Spanned<String>, Spanned<Parsed>)>),
}

impl<'de> Deserialize<'de> for Parsed {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(ParsedVisitor)
    }
}

struct ParsedVisitor;

/// Whole numbers of any width, as the number that a file can mean by them.
macro_rules! numbers {
    ($($visit:ident: $of:ty),*) => {
        $(fn $visit<E: de::Error>(self, number: $of) -> Result<Parsed, E> {
            Ok(Parsed::Number(number as f64))
        })*
    };
}

impl<'de> Visitor<'de> for ParsedVisitor {
    type Value = Parsed;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a YAML value")
    }

    fn visit_unit<E: de::Error>(self) -> Result<Parsed, E> {
        Ok(Parsed::Null)
    }

    fn visit_none<E: de::Error>(self) -> Result<Parsed, E> {
        Ok(Parsed::Null)
    }

    fn visit_some<D: Deserializer<'de>>(self, deserializer: D) -> Result<Parsed, D::Error> {
        Parsed::deserialize(deserializer)
    }

    fn visit_bool<E: de::Error>(self, flag: bool) -> Result<Parsed, E> {
        Ok(Parsed::Flag(flag))
    }

    numbers!(visit_i64: i64, visit_u64: u64, visit_i128: i128, visit_u128: u128);

    fn visit_f64<E: de::Error>(self, number: f64) -> Result<Parsed, E> {
        Ok(Parsed::Number(number))
    }

    fn visit_str<E: de::Error>(self, text: &str) -> Result<Parsed, E> {
        Ok(Parsed::Text(text.to_owned()))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut items: A) -> Result<Parsed, A::Error> {
        let mut list = Vec::new();
        while let Some(item) = items.next_element()? {
            list.push(item);
        }
        Ok(Parsed::List(list))
    }

    fn visit_map<A: MapAccess<'de>>(self, mut entries: A) -> Result<Parsed, A::Error> {
        let mut map = Vec::new();
        while let Some(entry) = entries.next_entry()? {
            map.push(entry);
        }
        Ok(Parsed::Map(map))
    }
}
