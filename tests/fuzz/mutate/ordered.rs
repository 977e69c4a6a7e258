//! YAML as values of JSON whose maps keep the order of the file, which tells what an argument without a name is for: every
//! key is written behind its number.

use std::fmt;

use serde::de::{Deserialize, Deserializer, Error, MapAccess, SeqAccess, Visitor};
use serde_json::{Map, Number, Value};

/// Stands between the number of a key and the key.
const MARK: char = '\u{1}';
/// The same in a text of JSON.
const WRITTEN: &str = "\\u0001";
const DIGITS: usize = 5;

/// A key behind its number.
pub fn key(number: usize, plain: &str) -> String {
    format!("{number:0DIGITS$}{MARK}{plain}")
}

/// A key without its number.
pub fn plain(key: &str) -> &str {
    key.split_once(MARK).map_or(key, |(_, plain)| plain)
}

/// Another key with the number of this one.
pub fn renamed(key: &str, plain: &str) -> String {
    key.split_once(MARK).map_or_else(|| plain.to_owned(), |(number, _)| format!("{number}{MARK}{plain}"))
}

/// The value of a key.
pub fn get<'a>(map: &'a Value, wanted: &str) -> Option<&'a Value> {
    map.as_object()?.iter().find(|(key, _)| plain(key) == wanted).map(|(_, value)| value)
}

/// As text, with the keys as they are called.
pub fn text(value: &Value) -> String {
    let numbered = value.to_string();
    let mut parts = numbered.split(WRITTEN).peekable();
    let mut text = String::with_capacity(numbered.len());
    while let Some(part) = parts.next() {
        // Only behind a number it is ours; that of a text of the file was lost with its first mutation.
        let end = part.len().saturating_sub(if parts.peek().is_some() { DIGITS } else { 0 });
        text.push_str(&part[..part.floor_char_boundary(end)]);
    }
    text
}

/// What a text of YAML means, read on a stack that suffices for what is deep.
pub fn read(text: &[u8]) -> Option<Value> {
    let text = std::str::from_utf8(text).ok()?;
    let read = || serde_saphyr::from_str(text).ok().map(|Ordered(value)| value);
    std::thread::scope(|scope| {
        let thread = std::thread::Builder::new().stack_size(64 << 20).spawn_scoped(scope, read);
        thread.expect("a thread").join().ok().flatten()
    })
}

struct Ordered(Value);

impl<'de> Deserialize<'de> for Ordered {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(InOrder).map(Self)
    }
}

struct InOrder;

impl<'de> Visitor<'de> for InOrder {
    type Value = Value;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a value")
    }

    fn visit_unit<E: Error>(self) -> Result<Value, E> {
        Ok(Value::Null)
    }

    fn visit_bool<E: Error>(self, flag: bool) -> Result<Value, E> {
        Ok(flag.into())
    }

    fn visit_i64<E: Error>(self, number: i64) -> Result<Value, E> {
        Ok(number.into())
    }

    fn visit_u64<E: Error>(self, number: u64) -> Result<Value, E> {
        Ok(number.into())
    }

    fn visit_f64<E: Error>(self, number: f64) -> Result<Value, E> {
        Ok(Number::from_f64(number).map_or_else(|| number.to_string().into(), Value::Number))
    }

    fn visit_str<E: Error>(self, text: &str) -> Result<Value, E> {
        Ok(text.replace(MARK, " ").into())
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut items: A) -> Result<Value, A::Error> {
        let mut list = Vec::new();
        while let Some(Ordered(item)) = items.next_element()? {
            list.push(item);
        }
        Ok(list.into())
    }

    fn visit_map<A: MapAccess<'de>>(self, mut entries: A) -> Result<Value, A::Error> {
        let mut map = Map::new();
        while let Some((name, Ordered(value))) = entries.next_entry::<String, _>()? {
            map.insert(key(map.len(), &name.replace(MARK, " ")), value);
        }
        Ok(map.into())
    }
}
