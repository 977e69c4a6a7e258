//! The journal of a simulation is a function of its inputs alone.

use std::path::Path;
use std::process::Command;

use crate::fixtures::{experiment_file, file};
use crate::home::Home;

fn journal(home: &Home, mission: &Path, adapt: impl FnOnce(&mut Command)) -> String {
    let log = home.path("simulated.jsonl");
    let args = ["simulate", "--quiet", "--log"].map(AsRef::as_ref);
    let args = args.into_iter().chain([log.as_os_str(), mission.as_os_str()]);
    home.start_with(args, adapt).ends(0);
    std::fs::read_to_string(log).expect("a journal")
}

#[test]
fn the_same_input_gives_the_same_bytes() {
    for number in 1..=4 {
        let (one, other) = (Home::new(), Home::new());
        let mission = experiment_file(number);
        let first = journal(&one, &mission, |_| {});
        let again = journal(&one, &mission, |_| {});
        let elsewhere = journal(&other, Path::new(&format!("missions/experiment-{number}.yaml")), |command| {
            command
                .current_dir(file("config"))
                .env("RUST_LOG", "trace")
                .env("TZ", "Pacific/Auckland")
                .env("LANG", "de_DE.UTF-8")
                .env("NO_COLOR", "1");
        });
        assert!(first == again, "experiment {number}: two runs differ");
        assert!(first == elsewhere, "experiment {number}: the surroundings show");
        // Files are told by their paths from the mission's folder.
        let here = file("");
        let is_here = first.contains(here.to_str().expect("a path"));
        assert!(!is_here && !first.contains("simulated"), "a path shows");
        assert!(first.lines().count() > 500);
    }
}
