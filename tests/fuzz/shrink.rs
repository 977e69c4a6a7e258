//! An input that is wrong made smaller, as long as the same is wrong with it.

use std::time::{Duration, Instant};

use crate::mutate::Form;

const AT_MOST: Duration = Duration::from_secs(20);

/// The smallest that is found by leaving out pieces, first lines and then bytes.
pub fn shrunk(form: Form, input: &[u8], is_wrong: impl Fn(&[u8]) -> bool) -> Vec<u8> {
    let by = Instant::now() + AT_MOST;
    let mut pieces: Vec<Vec<u8>> = input.split_inclusive(|byte| *byte == b'\n').map(<[u8]>::to_vec).collect();
    if form != Form::Bytes {
        leave_out(&mut pieces, by, &is_wrong);
    }
    let mut bytes: Vec<Vec<u8>> = pieces.concat().into_iter().map(|byte| vec![byte]).collect();
    leave_out(&mut bytes, by, &is_wrong);
    bytes.concat()
}

fn leave_out(pieces: &mut Vec<Vec<u8>>, by: Instant, is_wrong: &impl Fn(&[u8]) -> bool) {
    let mut length = pieces.len() / 2;
    while length > 0 {
        let mut at = 0;
        while at < pieces.len() {
            if Instant::now() > by {
                return;
            }
            let end = (at + length).min(pieces.len());
            let rest = [&pieces[..at], &pieces[end..]].concat();
            match is_wrong(&rest.concat()) {
                true => *pieces = rest,
                false => at = end,
            }
        }
        length /= 2;
    }
}
