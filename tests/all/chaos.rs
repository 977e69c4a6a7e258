//! `ambidex chaos`, its short form: real processes to which things are done, audited. The long one is a command.

use crate::fixtures::file;
use crate::home::Home;

#[test]
fn nothing_is_found_whatever_is_done() {
    let home = Home::new();
    let missions = ["experiment-1", "tray", "door"].map(|name| file(&format!("config/missions/{name}.yaml")));
    let (robot, kept) = (file("config/robots/pr2.yaml"), home.path("kept"));
    let args = ["chaos", "--runs", "8", "--rooms", "2", "--seed", "7", "--limit", "15", "--keep"];
    let args = args.iter().map(AsRef::as_ref).chain([kept.as_os_str(), "--robot".as_ref(), robot.as_os_str()]);
    let temporary = home.path("tmp");
    std::fs::create_dir_all(&temporary).expect("a folder");
    let chaos = home.start_with(args.chain(missions.iter().map(|path| path.as_os_str())), |command| {
        command.env("TMPDIR", &temporary);
    });
    let said = chaos.ends(0).stdout;
    assert!(said.contains("nothing was found in 8 runs") && said.contains("what was done"), "{said}");
    assert!(!kept.exists(), "runs without findings are not kept");
    let left = std::fs::read_dir(&temporary).expect("a folder").count();
    assert_eq!(left, 0, "its folder is gone");
    home.is_empty();
}

#[test]
fn what_cannot_be_run_is_told() {
    let home = Home::new();
    let wrong = home.write("wrong.yaml", "mission: x\nrobot: none.yaml\ntask: {then: []}\n");
    let finished = home.start(["chaos".as_ref(), wrong.as_os_str()]).ends(2);
    assert!(finished.words().contains("none.yaml"), "{}", finished.stderr);
    assert!(home.start(["chaos"]).ends(2).stderr.contains("MISSIONS"));
    home.is_empty();
}
