//! What an import does not carry over: said at its place in the file, and once more as a comment in what is written.

use crate::document::{Node, SourceSpan, Value};
use crate::fault::Faults;
use crate::reader::Fields;
use ambidex_model::{is_obeyed, split_argument, suggestion};

/// Longest piece of a foreign file in one line, letters.
const MAX_SHOWN: usize = 200;
/// So many mistakes are told with what was meant, since to look for it takes long among thousands of names.
const MAX_SUGGESTED: usize = 30;

/// Keys that dHTT knows and Ambidex has nothing like, with the reason.
const FOREIGN: &[(&str, &str)] = &[
    ("goitr_type", "nodes that its plugin adds while it runs are not in the file"),
    ("potential_type", "how its plugin computes a potential is not in the file"),
];

/// One thing that is not carried over.
#[derive(Debug, Clone)]
pub(super) struct Note {
    /// The node or resource; empty for the file as a whole.
    pub(super) of: String,
    pub(super) span: SourceSpan,
    pub(super) message: String,
    pub(super) help: Option<String>,
}

impl Note {
    pub(super) fn new(of: &str, span: SourceSpan, message: String, help: Option<String>) -> Self {
        Self { of: of.to_owned(), span, message, help }
    }

    /// As a comment at what it is about.
    pub(super) fn comment(&self) -> String {
        format!("dHTT: {}", self.message)
    }
}

/// Every key of a map that its form does not know; where a key is lacking, such a one is a mistake.
pub(super) fn unknown(of: &str, fields: &Fields<'_>, faults: &mut Faults) -> Vec<Note> {
    let shape = fields.shape;
    let keys: Vec<_> = shape.keys().collect();
    if shape.fields.iter().any(|field| field.is_required && fields.get(field.key).is_none()) {
        for (key, _) in fields.others() {
            fields.unknown(key, keys.iter().copied(), faults);
        }
        return Vec::new();
    }
    let note = |key: &str, span, value: &Node| {
        let written = format!("`{}: {}` is left out", line(key), line(&flow(value)));
        let (message, help) = match FOREIGN.iter().find(|(foreign, _)| *foreign == key) {
            Some((_, reason)) => (format!("{written}: {reason}"), None),
            None => (written, Some(suggestion(key, "key", keys.iter().copied()))),
        };
        Note::new(of, span, message, help)
    };
    fields.others().map(|(key, item)| note(&key.value, key.span, &item.node())).collect()
}

/// What was meant, while somebody reads it.
pub(super) fn suggested<'a>(
    found: &str,
    what: &str,
    allowed: impl IntoIterator<Item = &'a str>,
    faults: &Faults,
) -> Option<String> {
    (faults.errors() < MAX_SUGGESTED).then(|| suggestion(found, what, allowed))
}

/// Whether a `$` in it stands for an argument.
pub(super) fn is_template(text: &str) -> bool {
    split_argument(text).is_some()
}

/// A text as one line of bounded length.
pub(super) fn line(text: &str) -> String {
    let is_odd = |letter: char| is_obeyed(letter) || letter == '\u{feff}';
    let mut letters = text.chars().map(|letter| if is_odd(letter) { ' ' } else { letter });
    let shown: String = letters.by_ref().take(MAX_SHOWN).collect();
    if letters.next().is_some() { format!("{shown}…") } else { shown }
}

/// A value in one line, for people.
fn flow(node: &Node) -> String {
    match &node.value {
        Value::Null => "null".to_owned(),
        Value::Scalar { text, .. } => text.clone(),
        Value::List(list) => format!("[{}]", list.iter().map(flow).collect::<Vec<_>>().join(", ")),
        Value::Map(entries) => {
            let entries = entries.iter().map(|(key, value)| format!("{}: {}", key.value, flow(value)));
            format!("{{{}}}", entries.collect::<Vec<_>>().join(", "))
        }
    }
}
