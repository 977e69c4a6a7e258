//! Bytes changed without regard to what they mean.

use crate::rng::Rng;

/// Numbers as they lie in memory.
const DOUBLES: &[f64] =
    &[0.0, -0.0, 1.0, -1.0, 0.5, 1e-308, 5e-324, 1e9, 1e300, f64::MAX, f64::MIN, f64::INFINITY, f64::NAN];
const WHOLE: &[u64] = &[0, 1, 2, 3, 64, 65, 255, 1 << 31, (1 << 32) - 1, 1 << 53, u64::MAX >> 1, u64::MAX];

/// Changes one place.
pub fn change(input: &mut Vec<u8>, other: &[u8], rng: &mut Rng) {
    let at = rng.below(input.len() + 1);
    let most = rng.one(&[4, 64, 4096]);
    let end = (at + 1 + rng.below(most)).min(input.len());
    match rng.below(9) {
        0 if at < input.len() => input[at] ^= 1 << rng.below(8),
        1 if at < input.len() => input[at] = rng.one(&[0, 1, 0x7f, 0x80, 0xc3, 0xff, b'\n', b' ', b'{', b'"']),
        2 => input.insert(at, rng.next() as u8),
        3 => drop(input.drain(at..end)),
        4 => {
            let piece = input[at..end].to_vec();
            let piece = piece.repeat(rng.one(&[1, 1, 2, 50]));
            input.splice(at..at, piece);
        }
        5 if !other.is_empty() => {
            let from = rng.below(other.len());
            input.truncate(at);
            input.extend_from_slice(&other[from..]);
        }
        6 => overwrite(input, at / 8 * 8, &rng.one(DOUBLES).to_le_bytes()),
        7 => overwrite(input, at / 4 * 4, &(rng.one(WHOLE) as u32).to_le_bytes()),
        _ => overwrite(input, at / 8 * 8, &rng.one(WHOLE).to_le_bytes()),
    }
}

fn overwrite(input: &mut [u8], at: usize, by: &[u8]) {
    input.iter_mut().skip(at).zip(by).for_each(|(byte, new)| *byte = *new);
}
