//! Values that somebody forgot.

use serde_json::{Value, json};

use crate::rng::Rng;

/// Numbers at the ends of what can be written.
pub const NUMBERS: &[&str] = &[
    "0",
    "1",
    "-1",
    "2",
    "3",
    "64",
    "65",
    "255",
    "1000",
    "1000000",
    "0.1",
    "-0.0",
    "1e-308",
    "5e-324",
    "1e9",
    "1e15",
    "1e18",
    "1e100",
    "1e300",
    "1e308",
    "-1e308",
    "4294967295",
    "4294967296",
    "2147483647",
    "9007199254740991",
    "9007199254740992",
    "9007199254740993",
    "9223372036854775807",
    "-9223372036854775808",
    "18446744073709551615",
    "18446744073709551616",
    "1e999",
    "86400",
    "10000",
];

/// Words that mean something to somebody.
const WORDS: &[&str] = &[
    "",
    " ",
    "~",
    "null",
    "true",
    "no",
    ".nan",
    ".inf",
    "-.inf",
    "0x10",
    "0o7",
    "1_000",
    "1:30",
    "1e999",
    "NaN",
    "0 m",
    "1e308 m",
    "-1 m",
    "1e-300 m",
    "10000 m",
    "0 s",
    "86400 s",
    "1e-9 s",
    "0.01 s",
    "1e300 s",
    "-1 s",
    "360 deg",
    "1e9 deg",
    "1 km",
    "high",
    "all",
    "forever",
    "every",
    "physical",
    "stand",
    "$",
    "$to",
    "$$",
    "${to}",
    "$before",
    "$start",
    "at $to",
    "root",
    ".",
    "..",
    "/",
    "a/b",
    "*",
    "[",
    "{",
    "]",
    "- a",
    "a: b",
    "#",
    "&a",
    "*a",
    "!!str",
    "|",
    ">",
    "%",
    "@",
    "`",
    "\"",
    "'",
    "\t",
    "\n",
    "\r\n",
    "\u{0}",
    "\u{1b}[2J",
    "\u{202e}",
    "\u{feff}",
    "\u{85}",
    "\u{2028}",
    "日本語",
    "👩‍👩‍👧‍👦",
    "é",
    "e\u{301}",
    "\u{ffff}",
];

/// A value that nobody would write.
pub fn value(rng: &mut Rng) -> Value {
    match rng.below(12) {
        0..5 => number(rng),
        5..9 => rng.one(WORDS).into(),
        9 => {
            let piece = rng.one(&["a", "é", "日", "\u{301}", "a ", "$a", "\t", "👩"]);
            piece.repeat(rng.one(&[10, 63, 64, 65, 300, 5000, 60_000])).into()
        }
        10 => rng.one(&[json!(null), json!([]), json!({}), json!([[]]), json!({"": {}}), json!(true), json!(false)]),
        _ => {
            let (depth, is_list) = (rng.one(&[3, 20, 60, 100]), rng.is(50));
            (0..depth).fold(Value::Null, |inner, _| if is_list { json!([inner]) } else { json!({"and": [inner]}) })
        }
    }
}

/// A number at an end.
pub fn number(rng: &mut Rng) -> Value {
    // What JSON has no number for is a word, which YAML takes as one.
    let text = rng.one(NUMBERS);
    serde_json::from_str(text).unwrap_or_else(|_| Value::from(text))
}

/// The same as text, also of kinds that JSON does not have.
pub fn text(rng: &mut Rng) -> String {
    match rng.below(4) {
        0 => rng.one(NUMBERS).to_owned(),
        1 | 2 => rng.one(WORDS).to_owned(),
        _ => rng.one(&["[", "{", "? ", "- ", "["]).repeat(rng.one(&[1, 10, 70, 200, 3000])),
    }
}
