//! Text changed in what it means: parts of lists and maps swapped, copied, left out, multiplied, wrapped.

use std::collections::BTreeSet;
use std::mem;

use serde_json::{Map, Value, json};

use super::{extremes, ordered};
use crate::rng::Rng;

/// Keys and scalars that are in use.
#[derive(Default)]
pub struct Words {
    known: BTreeSet<String>,
    keys: Vec<String>,
    scalars: Vec<Value>,
}

impl Words {
    pub fn learn(&mut self, value: &Value) {
        match value {
            Value::Object(map) => {
                for (key, value) in map {
                    let key = ordered::plain(key);
                    if self.known.insert(format!("key {key}")) {
                        self.keys.push(key.to_owned());
                    }
                    self.learn(value);
                }
            }
            Value::Array(list) => list.iter().for_each(|value| self.learn(value)),
            Value::Null | Value::Bool(_) | Value::Number(_) | Value::String(_) => {
                if self.known.insert(value.to_string()) {
                    self.scalars.push(value.clone());
                }
            }
        }
    }

    /// There is always something to choose.
    pub fn end(&mut self) {
        self.keys.extend(["and".to_owned(), "to".to_owned()]);
        self.scalars.push(json!(1));
    }
}

/// The way to a value: which entry at each level.
type Path = Vec<usize>;

/// Most values that are chosen from.
const MOST: usize = 10_000;
/// Largest number of copies at once.
const COPIES: &[usize] = &[1, 1, 1, 2, 10, 100, 1000];

fn paths(value: &Value) -> Vec<Path> {
    let mut found = Vec::new();
    walk(value, &mut Vec::new(), &mut found);
    found
}

fn walk(value: &Value, path: &mut Path, found: &mut Vec<Path>) {
    if found.len() >= MOST {
        return;
    }
    found.push(path.clone());
    let mut enter = |(index, value): (usize, &Value)| {
        path.push(index);
        walk(value, path, found);
        path.pop();
    };
    match value {
        Value::Object(map) => map.values().enumerate().for_each(&mut enter),
        Value::Array(list) => list.iter().enumerate().for_each(&mut enter),
        Value::Null | Value::Bool(_) | Value::Number(_) | Value::String(_) => {}
    }
}

fn at<'a>(value: &'a Value, path: &[usize]) -> Option<&'a Value> {
    path.iter().try_fold(value, |value, index| match value {
        Value::Object(map) => map.values().nth(*index),
        Value::Array(list) => list.get(*index),
        Value::Null | Value::Bool(_) | Value::Number(_) | Value::String(_) => None,
    })
}

fn at_mut<'a>(value: &'a mut Value, path: &[usize]) -> Option<&'a mut Value> {
    path.iter().try_fold(value, |value, index| match value {
        Value::Object(map) => map.values_mut().nth(*index),
        Value::Array(list) => list.get_mut(*index),
        Value::Null | Value::Bool(_) | Value::Number(_) | Value::String(_) => None,
    })
}

/// The key of the nearest map above.
fn key<'a>(value: &'a Value, path: &[usize]) -> Option<&'a str> {
    (0..path.len()).rev().find_map(|end| match at(value, &path[..end])? {
        Value::Object(map) => map.keys().nth(path[end]).map(|key| ordered::plain(key)),
        _ => None,
    })
}

fn is_scalar(value: &Value) -> bool {
    !matches!(value, Value::Object(_) | Value::Array(_))
}

/// Changes one place.
pub fn change(value: &mut Value, other: &Value, words: &Words, rng: &mut Rng) {
    let all = paths(value);
    let one = rng.one(&all);
    let is_leaf = |path: &Path| at(value, path).is_some_and(is_scalar);
    let leaves: Vec<&Path> = all.iter().filter(|path| is_leaf(path)).collect();
    let leaf = if leaves.is_empty() { one.clone() } else { leaves[rng.below(leaves.len())].clone() };
    match rng.below(14) {
        0 | 1 => set(value, &leaf, extremes::value(rng)),
        2 => {
            // A number becomes another number: that is what is read further.
            let is_number = at(value, &leaf).is_some_and(Value::is_number);
            let new = if is_number { extremes::number(rng) } else { with_another_number(at(value, &leaf), rng) };
            set(value, &leaf, new);
        }
        3 => set(value, &leaf, rng.one(&words.scalars)),
        4 => exchange(value, &one, &rng.one(&all)),
        5 => {
            let copy = at(value, &rng.one(&all)).cloned().unwrap_or_default();
            set(value, &one, copy);
        }
        6 => remove(value, &one),
        7 | 8 => multiply(value, &one, rng),
        9 => rename(value, &one, words, rng),
        10 => insert(value, &one, words, rng),
        11 => wrap(value, &one, rng),
        _ => transplant(value, &one, other, rng),
    }
}

fn set(value: &mut Value, path: &[usize], new: Value) {
    if let Some(old) = at_mut(value, path) {
        *old = new;
    }
}

/// `0.25 m` with another number before its unit.
fn with_another_number(old: Option<&Value>, rng: &mut Rng) -> Value {
    let unit = old.and_then(Value::as_str).and_then(|text| text.split_once(' ')).map(|(_, unit)| unit);
    match unit {
        Some(unit) => format!("{} {unit}", rng.one(extremes::NUMBERS)).into(),
        None => extremes::value(rng),
    }
}

fn exchange(value: &mut Value, one: &[usize], other: &[usize]) {
    if one.starts_with(other) || other.starts_with(one) {
        return;
    }
    let first = at_mut(value, one).map(mem::take).unwrap_or_default();
    let second = at_mut(value, other).map(|place| mem::replace(place, first)).unwrap_or_default();
    set(value, one, second);
}

fn remove(value: &mut Value, path: &[usize]) {
    let Some((last, above)) = path.split_last() else { return };
    match at_mut(value, above) {
        Some(Value::Array(list)) => drop(list.remove(*last)),
        Some(Value::Object(map)) => {
            let key = map.keys().nth(*last).cloned();
            key.map(|key| map.remove(&key));
        }
        _ => {}
    }
}

/// The same again beside it, in a map under other names.
fn multiply(value: &mut Value, path: &[usize], rng: &mut Rng) {
    let Some((last, above)) = path.split_last() else { return };
    let copy = at(value, path).cloned().unwrap_or_default();
    let most = 200_000 / (copy.to_string().len() + 1);
    let times = rng.one(COPIES).min(most);
    match at_mut(value, above) {
        Some(Value::Array(list)) => drop(list.splice(*last..*last, std::iter::repeat_n(copy, times))),
        Some(Value::Object(map)) => {
            let name = map.keys().nth(*last).cloned().unwrap_or_default();
            map.extend((0..times).map(|number| (format!("{name} {number}"), copy.clone())));
        }
        _ => {}
    }
}

fn rename(value: &mut Value, path: &[usize], words: &Words, rng: &mut Rng) {
    let Some((last, above)) = path.split_last() else { return };
    if let Some(Value::Object(map)) = at_mut(value, above)
        && let Some(old) = map.keys().nth(*last).cloned()
        && let Some(part) = map.remove(&old)
    {
        let new = if rng.is(70) { rng.one(&words.keys) } else { extremes::text(rng) };
        map.insert(ordered::renamed(&old, &new), part);
    }
}

fn insert(value: &mut Value, path: &[usize], words: &Words, rng: &mut Rng) {
    let new = if rng.is(60) { rng.one(&words.scalars) } else { extremes::value(rng) };
    match at_mut(value, path) {
        Some(Value::Object(map)) => drop(map.insert(ordered::key(map.len(), &rng.one(&words.keys)), new)),
        Some(Value::Array(list)) => list.insert(rng.below(list.len() + 1), new),
        _ => set(value, path, json!({ rng.one(&words.keys): new })),
    }
}

/// As a part of a node of a task; and of that as many levels as are asked for.
fn wrap(value: &mut Value, path: &[usize], rng: &mut Rng) {
    let Some(place) = at_mut(value, path) else { return };
    let kind = rng.one(&["and", "or", "then"]);
    for _ in 0..rng.one(&[1, 1, 1, 3, 30]) {
        let inner = mem::take(place);
        let mut node = Map::from_iter([(kind.to_owned(), json!([inner]))]);
        match rng.below(8) {
            0 => drop(node.insert("repeat".into(), rng.one(&[json!(2), json!(1000000), json!("forever")]))),
            1 => drop(node.insert("timeout".into(), rng.one(&[json!("0.01 s"), json!("5 s"), json!("86400 s")]))),
            2 => drop(node.insert("priority".into(), rng.one(&[json!(1), json!(-1000), json!(1000)]))),
            3 => drop(node.insert("retries".into(), rng.one(&[json!(1), json!(1000)]))),
            4 => drop(node.insert("cleanup".into(), json!({ kind: [] }))),
            5 => drop(node.insert("every".into(), rng.one(&[json!("0.01 s"), json!("86400 s")]))),
            _ => {}
        }
        *place = Value::Object(node);
    }
}

/// What stands under the same key elsewhere.
fn transplant(value: &mut Value, path: &[usize], other: &Value, rng: &mut Rng) {
    let here = key(value, path).map(str::to_owned);
    let all = paths(other);
    let fitting: Vec<&Path> = all.iter().filter(|path| key(other, path) == here.as_deref()).collect();
    if let Some(from) = (!fitting.is_empty()).then(|| fitting[rng.below(fitting.len())])
        && let Some(part) = at(other, from)
    {
        set(value, path, part.clone());
    }
}
