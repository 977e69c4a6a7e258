//! Generated missions for the PR2: things to be carried between places, in the forms that a task can have.

use std::fmt::Write;

use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

/// Most things to be carried.
const MOST_OBJECTS: usize = 5;

/// The text of a mission file, drawn from a seed; `robot` is the path of its robot file.
pub fn mission(seed: u64, robot: &str) -> String {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let places = rng.random_range(2..=4);
    let objects = rng.random_range(1..=MOST_OBJECTS);
    let mut text = format!("mission: room {seed}\nrobot: {robot:?}\nworld:\n  robot: {{at: [0 m, 0 m]}}\n  places:\n");
    let has_tables = rng.random_bool(0.5);
    for place in 0..places {
        // Far enough from each other, and from the middle.
        let angle = (place as f64 + rng.random_range(0.0..0.5)) / places as f64 * std::f64::consts::TAU;
        let radius = rng.random_range(2.0..3.5);
        let _ = writeln!(text, "    place {place}: {}", spot(&mut rng, angle, radius, has_tables));
    }
    if has_tables && rng.random_bool(0.5) {
        text += "  obstacles: [{at: [0.9 m, 0.3 m], size: [0.3 m, 0.4 m], heading: 20 deg}]\n";
    }
    text += "  objects:\n";
    let at: Vec<usize> = (0..objects).map(|_| rng.random_range(0..places)).collect();
    for (object, place) in at.iter().enumerate() {
        let _ = writeln!(text, "    thing {object}: {{at: place {place}}}");
    }
    text += "  facts: {someone waits: {holds: true, outside: true}}\n";
    text += "behaviors:\n  rest: {potential: 1, goal: [{fact: someone waits}], takes: 2 s}\ntask:\n  and:\n";
    for (object, from) in at.iter().enumerate() {
        let to = (from + rng.random_range(1..places)) % places;
        let _ = writeln!(text, "    - {}", carry(&mut rng, object, *from, to));
    }
    if rng.random_bool(0.3) {
        text += "    - rest\n";
    }
    text
}

/// A place in that direction from the middle: where to stand alone, or a table with one or two sides to stand at.
fn spot(rng: &mut ChaCha8Rng, angle: f64, radius: f64, is_table: bool) -> String {
    // A table keeps off what stands in the middle.
    let radius = if is_table { radius + 0.8 } else { radius };
    let (x, y) = (radius * angle.cos(), radius * angle.sin());
    if !is_table {
        return format!("{{stand: [{x:.2} m, {y:.2} m]}}");
    }
    let stands =
        if rng.random_bool(0.5) { "{near: {side: front}}" } else { "{near: {side: front}, far: {side: back}}" };
    let heading = angle.to_degrees();
    format!(
        "{{table: {{at: [{x:.2} m, {y:.2} m], heading: {heading:.1} deg, size: [0.6 m, 1.2 m, 0.75 m], stands: {stands}}}}}"
    )
}

/// Carries a thing, in one of the forms in which a task can say so.
fn carry(rng: &mut ChaCha8Rng, object: usize, from: usize, to: usize) -> String {
    // By the thing itself, so that a dropped one is fetched from where it lies, or by the place.
    let fetch = if rng.random_bool(0.5) { format!("thing {object}") } else { format!("place {from}") };
    let steps =
        format!("[{{move: {fetch}}}, {{pick: thing {object}}}, {{move: place {to}}}, {{place: thing {object}}}]");
    let then = format!("then: {steps}");
    match rng.random_range(0..6) {
        0 => format!("{{priority: 1, {then}}}"),
        1 => format!("{{retries: 2, timeout: 90 s, {then}}}"),
        2 => format!(
            "{{{then}, cleanup: {{then: [{{move: place {from}}}, {{place: {{object: thing {object}, at: place {from}}}}}]}}}}"
        ),
        3 => {
            let other = format!(
                "[{{move: thing {object}}}, {{pick: thing {object}}}, {{move: place {to}}}, {{place: thing {object}}}]"
            );
            format!("{{or: [{{{then}}}, {{then: {other}}}]}}")
        }
        _ => format!("{{{then}}}"),
    }
}
