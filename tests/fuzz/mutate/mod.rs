//! Inputs made of others: of their bytes, their lines, and of what their text means.

mod bytes;
mod extremes;
mod lines;
pub mod ordered;
mod tree;

use serde_json::Value;

use crate::limits::INPUT;
use crate::rng::Rng;
use tree::Words;

/// What inputs of a target are made of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Form {
    /// Any bytes.
    Bytes,
    /// A text of YAML.
    Yaml,
    /// A text of JSON in every line.
    JsonLines,
}

/// What makes inputs of others.
pub struct Mutator {
    form: Form,
    words: Words,
}

impl Mutator {
    /// With the words of these.
    pub fn new(form: Form, inputs: &[Vec<u8>]) -> Self {
        let mut words = Words::default();
        for input in inputs {
            match form {
                Form::Bytes => {}
                Form::Yaml => ordered::read(input).iter().for_each(|value| words.learn(value)),
                Form::JsonLines => lines::split(input).filter_map(read_json).for_each(|value| words.learn(&value)),
            }
        }
        words.end();
        Self { form, words }
    }

    /// A new input; the `sound` ones of the pool were accepted.
    pub fn mutant(&mut self, pool: &[Vec<u8>], sound: &[usize], rng: &mut Rng) -> Vec<u8> {
        let recent = |rng: &mut Rng, count: usize| {
            let from = if rng.is(30) { count.saturating_sub(40) } else { 0 };
            from + rng.below(count - from)
        };
        let one = |rng: &mut Rng| match sound {
            [] => recent(rng, pool.len()),
            sound if rng.is(70) => sound[recent(rng, sound.len())],
            _ => recent(rng, pool.len()),
        };
        let (mut input, other) = (pool[one(rng)].clone(), &pool[one(rng)]);
        let times = rng.one(&[1, 1, 1, 1, 2, 4]);
        match self.form {
            Form::Bytes => (0..times).for_each(|_| bytes::change(&mut input, other, rng)),
            Form::Yaml => self.change_yaml(&mut input, other, times, rng),
            Form::JsonLines => self.change_lines(&mut input, other, times, rng),
        }
        input.truncate(INPUT);
        input
    }

    fn change_yaml(&mut self, input: &mut Vec<u8>, other: &[u8], times: usize, rng: &mut Rng) {
        match rng.below(10) {
            0 => (0..times).for_each(|_| bytes::change(input, other, rng)),
            1 | 2 => (0..times).for_each(|_| lines::change(input, other, rng)),
            _ => {
                let Some(mut value) = ordered::read(input) else { return lines::change(input, other, rng) };
                let other = ordered::read(other).unwrap_or_default();
                (0..times).for_each(|_| tree::change(&mut value, &other, &self.words, rng));
                *input = ordered::text(&value).into_bytes();
            }
        }
    }

    /// Of many lines only one changes in what it means.
    fn change_lines(&mut self, input: &mut Vec<u8>, other: &[u8], times: usize, rng: &mut Rng) {
        for _ in 0..times {
            match rng.below(10) {
                0 => bytes::change(input, other, rng),
                1 | 2 => lines::change(input, other, rng),
                _ => {
                    let mut all: Vec<Vec<u8>> = lines::split(input).map(<[u8]>::to_vec).collect();
                    let others: Vec<&[u8]> = lines::split(other).collect();
                    if all.is_empty() || others.is_empty() {
                        return bytes::change(input, other, rng);
                    }
                    // The first line says what all others are about.
                    let at = if rng.is(15) { 0 } else { rng.below(all.len()) };
                    if let Some(mut value) = read_json(&all[at]) {
                        let other = read_json(others[rng.below(others.len())]).unwrap_or_default();
                        tree::change(&mut value, &other, &self.words, rng);
                        all[at] = (value.to_string() + "\n").into_bytes();
                    }
                    *input = all.concat();
                }
            }
        }
    }
}

fn read_json(line: &[u8]) -> Option<Value> {
    serde_json::from_slice(line).ok()
}
