//! Lines of the control socket, on both sides.

use std::sync::{Arc, LazyLock};

use ambidex::model::MissionSpec;
use ambidex::runtime::control::{asked, read_answer};

use super::Taken;
use super::files::loaded;

/// Longest line of either side, and what stands around an answer in it.
const LINE: usize = 4096;
const AROUND: usize = 32;

/// A line as a request, and as an answer.
pub fn control(line: &[u8]) -> Taken {
    static MISSION: LazyLock<Arc<MissionSpec>> = LazyLock::new(|| {
        let text = include_str!("../../../config/missions/door.yaml");
        loaded(text.as_bytes()).expect("a shipped mission loads").mission
    });
    // Whoever serves the socket reads no longer ones.
    let line = &line[..line.len().min(LINE)];
    let mut taken = Taken::default();
    match asked(line, &MISSION.names) {
        Ok(change) => {
            taken.accepted = true;
            taken.said(&format!("{change:?}"));
        }
        Err(answer) => {
            let text = serde_json::to_string(&answer).expect("an answer is plain");
            assert!(text.len() + AROUND <= LINE, "an answer is too long: {} bytes", text.len());
            taken.said(&format!("{answer:?}"));
        }
    }
    match read_answer(line) {
        Ok(answer) => taken.said(&format!("{answer:?}")),
        Err(error) => taken.said(&error.to_string()),
    }
    taken
}
