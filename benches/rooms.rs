//! What geometry costs a round: one mission without any, in a room with tables and walls, and there with arms that must not
//! cross and distances along paths; few objects and many. Simulated, so that no controller is waited for.

#[path = "support/table.rs"]
mod table;

use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

use ambidex::files::{self, InMemory};
use ambidex::model::{MissionEnd, MissionSpec, Record};
use ambidex::sim;
use ambidex::tree::Settings;

const SAMPLES: usize = 5;
const PLACES: usize = 6;

/// How much of a world is told.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Told {
    Stands,
    Tables,
    All,
}

fn main() {
    let titles = "objects|told|rounds|a round, µs|times stands alone";
    let mut rows = vec![titles.split('|').map(str::to_owned).collect::<Vec<_>>()];
    for objects in [4, 100] {
        let mut alone = None;
        for told in [Told::Stands, Told::Tables, Told::All] {
            let mission = mission(objects, told);
            let samples = (0..SAMPLES).map(|_| run(&mission));
            let (time, rounds) = samples.min_by_key(|(time, _)| *time).expect("several");
            let round_us = time.as_secs_f64() * 1e6 / rounds as f64;
            let alone = *alone.get_or_insert(round_us);
            rows.push(vec![
                objects.to_string(),
                format!("{told:?}").to_lowercase(),
                rounds.to_string(),
                format!("{round_us:.1}"),
                format!("{:.2}", round_us / alone),
            ]);
        }
    }
    table::print("A round of a whole simulated mission, controllers included, fastest of 5:", &rows);
    println!(
        "\nstands: no geometry. tables: surfaces and walls in the way. all: arms with a radius, and `distance: path`."
    );
}

fn run(mission: &Arc<MissionSpec>) -> (Duration, usize) {
    let mut rounds = 0;
    let settings = Settings { has_messages: false, ..Settings::default() };
    let begun = Instant::now();
    let end = sim::simulate(mission, &settings, Vec::new(), &mut |record| {
        rounds += usize::from(matches!(record, Record::Decided { .. }));
    });
    assert_eq!(end, MissionEnd::Done);
    (begun.elapsed(), rounds)
}

/// Each object goes from one place to the next; places stand in a circle.
fn mission(objects: usize, told: Told) -> Arc<MissionSpec> {
    let mut text = String::from("mission: rooms\nrobot: robot.yaml\nworld:\n  robot: {at: [0, 0]}\n");
    if told == Told::All {
        text += "  distance: path\n";
    }
    text += "  places:\n";
    for place in 0..PLACES {
        let degrees = 360.0 * place as f64 / PLACES as f64;
        let (sin, cos) = degrees.to_radians().sin_cos();
        text += &match told {
            Told::Stands => {
                format!("    p{place}: {{stand: [{}, {}], heading: {degrees} deg}}\n", 3.0 * cos, 3.0 * sin)
            }
            Told::Tables | Told::All => {
                let far_m = 3.0 + 0.05 + 0.48 + 0.3;
                format!(
                    "    p{place}: {{table: {{at: [{}, {}], heading: {degrees} deg, size: [0.6, 2.4, 0.75]}}}}\n",
                    far_m * cos,
                    far_m * sin
                )
            }
        };
    }
    if told != Told::Stands {
        text += "  walls:\n";
        for [x, y, to_x, to_y] in [[-5, -5, 5, -5], [5, -5, 5, 5], [5, 5, -5, 5], [-5, 5, -5, -5]] {
            text += &format!("    - {{from: [{x}, {y}], to: [{to_x}, {to_y}]}}\n");
        }
    }
    text += "  objects:\n";
    for object in 0..objects {
        // Near each other, so that there is room to put others down.
        let aside = (object / PLACES) as f64 / (objects / PLACES).max(1) as f64 - 0.5;
        text += &format!("    o{object}: {{at: p{}, offset: [0, {:.3}]}}\n", object % PLACES, 0.22 * aside);
    }
    text += "task:\n  and:\n";
    for object in 0..objects {
        let (from, to) = (object % PLACES, (object + 1) % PLACES);
        text +=
            &format!("    - then: [{{move: p{from}}}, {{pick: o{object}}}, {{move: p{to}}}, {{place: o{object}}}]\n");
    }
    let robot = include_str!("../config/robots/pr2.yaml");
    let robot =
        if told == Told::All { robot.into() } else { robot.replace("      radius: 0.06 m", "      # no radius") };
    let mut files = InMemory::default();
    files.insert("robot.yaml", robot);
    files.insert("rooms.yaml", text);
    let loaded = files::load_mission(&files, Path::new("rooms.yaml"), None, &[]);
    loaded.unwrap_or_else(|error| panic!("{error}: {:#?}", error.faults())).mission
}
