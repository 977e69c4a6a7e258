//! Lines and the words in them moved about; what they mean is not known here.

use super::extremes;
use crate::rng::Rng;

/// Lines with their ends.
pub fn split(input: &[u8]) -> impl Iterator<Item = &[u8]> {
    input.split_inclusive(|byte| *byte == b'\n')
}

/// Changes one place.
pub fn change(input: &mut Vec<u8>, other: &[u8], rng: &mut Rng) {
    let mut lines: Vec<Vec<u8>> = split(input).map(<[u8]>::to_vec).collect();
    if lines.is_empty() {
        lines.push(b"a: b\n".to_vec());
    }
    let (at, to) = (rng.below(lines.len()), rng.below(lines.len()));
    match rng.below(9) {
        0 => {
            let times = rng.one(&[1, 1, 1, 10, 1000]);
            let line = lines[at].clone();
            lines.splice(at..at, std::iter::repeat_n(line, times));
        }
        1 => drop(lines.remove(at)),
        2 => lines.swap(at, to),
        3 => {
            let line = lines.remove(at);
            lines.insert(to.min(lines.len()), line);
        }
        4 => {
            let others: Vec<Vec<u8>> = split(other).map(<[u8]>::to_vec).collect();
            let from = rng.below(others.len() + 1);
            lines.truncate(at);
            lines.extend_from_slice(&others[from..]);
        }
        5 => swap_words(&mut lines, at, to),
        6 => {
            let indent = rng.one(&[" ", "  ", "\t", "- ", "    ", "? ", "&a ", "*a ", "!!map "]);
            lines[at].splice(0..0, indent.bytes());
        }
        _ => replace_word(&mut lines[at], extremes::text(rng).as_bytes(), rng),
    }
    *input = lines.concat();
}

/// Where words of a line begin and end.
fn words(line: &[u8]) -> Vec<(usize, usize)> {
    let mut words = Vec::new();
    let mut from = None;
    for (at, byte) in line.iter().chain(b" ").enumerate() {
        let is_part = byte.is_ascii_alphanumeric() || matches!(byte, b'_' | b'.' | b'$') || *byte >= 0x80;
        match (from, is_part) {
            (None, true) => from = Some(at),
            (Some(begin), false) => {
                words.push((begin, at));
                from = None;
            }
            (None, false) | (Some(_), true) => {}
        }
    }
    words
}

fn replace_word(line: &mut Vec<u8>, by: &[u8], rng: &mut Rng) {
    let words = words(line);
    let (from, to) = if words.is_empty() { (0, 0) } else { rng.one(&words) };
    line.splice(from..to, by.iter().copied());
}

fn swap_words(lines: &mut [Vec<u8>], one: usize, other: usize) {
    let (Some(first), Some(second)) = (words(&lines[one]).last().copied(), words(&lines[other]).last().copied()) else {
        return;
    };
    if one == other {
        return;
    }
    let (a, b) = (lines[one][first.0..first.1].to_vec(), lines[other][second.0..second.1].to_vec());
    lines[one].splice(first.0..first.1, b);
    lines[other].splice(second.0..second.1, a);
}
