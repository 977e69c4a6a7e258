//! Pictures of runs and trees, read back as XML and compared with the journals that they were drawn from.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use ambidex::model::*;
use ambidex::record::{History, Journal, Phase, Reader};
use ambidex::show::{Palette, timeline, tree};
use roxmltree::{Document, Node};

use crate::fixtures::{HANDS_FULL, experiment_file, experiments, file, history, mission};
use crate::home::Home;

/// Hundredths are written: two of them may add up.
const NEAR: f64 = 0.021;

/// Simulates a mission; where its log is.
fn log(home: &Home, name: &str, mission: &Path, more: &[&str]) -> PathBuf {
    let log = home.path(name);
    let args = ["simulate".as_ref(), "--quiet".as_ref(), "--log".as_ref(), log.as_os_str(), mission.as_os_str()];
    home.start(args.into_iter().chain(more.iter().map(AsRef::as_ref))).wait();
    log
}

/// Draws into a file of the home and gives what stands in it.
fn draw(home: &Home, args: &[&str]) -> String {
    let picture = home.path("picture.svg");
    let output = ["-o".as_ref(), picture.as_os_str()];
    let drawn = home.start(args.iter().map(AsRef::as_ref).chain(output)).ends(0);
    assert_eq!((drawn.stdout.as_str(), drawn.stderr.as_str()), ("", ""));
    fs::read_to_string(picture).expect("a picture")
}

fn text(path: &Path) -> &str {
    path.to_str().expect("a path in UTF-8")
}

fn records(log: &Path) -> Vec<Record> {
    Reader::open(log).expect("a journal").map(|record| record.expect("a record")).collect()
}

/// When a leaf ran, the last one without an end where it runs on.
fn runs(history: &History, leaf: NodeId) -> Vec<(Time, Option<Time>)> {
    let phases = history.leaf(leaf).expect("a leaf").phases();
    let nexts = phases.iter().skip(1).map(|(next, _)| Some(*next)).chain([None]);
    let runs = phases.iter().zip(nexts).filter(|((_, phase), _)| *phase == Phase::Active);
    runs.map(|((from, _), to)| (*from, to)).collect()
}

/// Everything of a class in the order of the picture.
fn all<'a>(node: Node<'a, 'a>, class: &'a str) -> impl Iterator<Item = Node<'a, 'a>> {
    let has_class =
        move |node: &Node| node.attribute("class").is_some_and(|list| list.split(' ').any(|one| one == class));
    node.descendants().filter(has_class)
}

fn number(node: Node, name: &str) -> f64 {
    node.attribute(name).expect("an attribute").parse().expect("a number")
}

fn title<'a>(node: Node<'a, 'a>) -> &'a str {
    let title = node.children().find(|child| child.has_tag_name("title"));
    title.and_then(|title| title.text()).expect("a title")
}

/// Rows and lanes with what is written before them.
fn bands<'a>(node: Node<'a, 'a>, class: &'a str) -> Vec<(&'a str, Node<'a, 'a>)> {
    let bands = all(node, class).map(|band| {
        let label = band.prev_siblings().find(|before| before.attribute("class") == Some("label"));
        (title(label.expect("a label")), band)
    });
    bands.collect()
}

/// Where a moment lies, read from the first and the last tick.
fn ruler<'a>(document: &'a Document) -> impl Fn(Time) -> f64 + use<'a> {
    let axes: Vec<_> = all(document.root(), "axis").collect();
    assert_eq!(axes.len(), 1, "there is one axis");
    let places: Vec<f64> = all(axes[0], "tick").map(|tick| number(tick, "x1")).collect();
    let seconds: Vec<f64> =
        all(axes[0], "small").map(|label| label.text().expect("seconds").parse().expect("a number")).collect();
    let last = places.len() - 1;
    assert!(last > 1 && last + 1 == seconds.len());
    let scale = (places[last] - places[0]) / (seconds[last] - seconds[0]);
    let (place, second) = (places[0], seconds[0]);
    move |at| place + (at.seconds() - second) * scale
}

/// Left and right side of every bar of a class.
fn extents<'a>(band: Node<'a, 'a>, class: &'a str) -> Vec<(f64, f64)> {
    let sides = |bar| (number(bar, "x"), number(bar, "x") + number(bar, "width"));
    all(band, class).filter(|bar| bar.has_tag_name("rect")).map(sides).collect()
}

fn assert_same(found: &[(f64, f64)], expected: &[(f64, f64)], what: &str) {
    let is_near =
        |one: &(f64, f64), other: &(f64, f64)| (one.0 - other.0).abs() < NEAR && (one.1 - other.1).abs() < NEAR;
    let is_same = found.len() == expected.len() && found.iter().zip(expected).all(|(one, other)| is_near(one, other));
    assert!(is_same, "{what}: drawn {found:?}, in the journal {expected:?}");
}

/// Compares one run of a picture with its journal.
fn check(run: Node, x: &impl Fn(Time) -> f64, records: &[Record]) {
    let history = history(records);
    let header = history.header();
    let rows = bands(run, "row");
    let named: Vec<(&str, NodeId)> = history.leaves().map(|leaf| (header.names.node(leaf), leaf)).collect();
    assert!(rows.iter().map(|row| row.0).eq(named.iter().map(|(name, _)| *name)));
    let end = history.last_moment();
    let sides = |&(from, to): &(Time, Option<Time>)| (x(from), x(to.unwrap_or(end)));
    for ((name, row), (_, leaf)) in rows.into_iter().zip(named) {
        let runs = runs(&history, leaf);
        assert_same(&extents(row, "active"), &runs.iter().map(sides).collect::<Vec<_>>(), name);
        let is_skipped = history.skipped().iter().any(|(skipped, _)| *skipped == leaf);
        assert_eq!(all(row, "mark-skipped").count(), usize::from(is_skipped), "{name}");
    }
    let lanes = bands(run, "lane");
    assert_eq!(lanes.iter().map(|lane| lane.0).collect::<Vec<_>>(), header.names.resources);
    let mut held: BTreeMap<&str, Vec<(f64, f64)>> = BTreeMap::new();
    let mut seen: BTreeMap<NodeId, usize> = BTreeMap::new();
    for record in records {
        let Record::Decided { granted, .. } = record else { continue };
        for grant in granted {
            let run = seen.entry(grant.leaf()).or_default();
            let sides = sides(&runs(&history, grant.leaf())[*run]);
            *run += 1;
            for resource in grant.bindings.iter().map(|binding| header.names.resource(binding.resource)) {
                held.entry(resource).or_default().push(sides);
            }
        }
    }
    let sorted = |mut sides: Vec<(f64, f64)>| {
        sides.sort_by(|one, other| one.partial_cmp(other).expect("numbers"));
        sides
    };
    for (name, lane) in lanes {
        let expected = held.remove(name).unwrap_or_default();
        assert_same(&sorted(extents(lane, "active")), &sorted(expected), name);
    }
}

#[test]
fn timelines_show_what_the_journals_tell() {
    let home = Home::new();
    for number in experiments().into_keys() {
        for allocator in ["greedy", "serial"] {
            let log = log(&home, "run.jsonl", &experiment_file(number), &["--allocator", allocator]);
            let picture = draw(&home, &["timeline", text(&log)]);
            let document = Document::parse(&picture).expect("XML");
            check(all(document.root(), "run").next().expect("a run"), &ruler(&document), &records(&log));
            let channels: BTreeSet<_> = all(document.root(), "channel-name").filter_map(|name| name.text()).collect();
            assert!(channels.iter().any(|channel| channel.starts_with("at ")), "{channels:?}");
        }
    }
}

#[test]
fn two_runs_stand_on_one_axis() {
    let home = Home::new();
    let greedy = log(&home, "greedy.jsonl", &experiment_file(1), &[]);
    let serial = log(&home, "serial.jsonl", &experiment_file(1), &["--allocator", "serial"]);
    let picture = draw(&home, &["timeline", text(&greedy), "--compare", text(&serial)]);
    let document = Document::parse(&picture).expect("XML");
    let x = ruler(&document);
    let runs: Vec<_> = all(document.root(), "run").collect();
    let both = [&greedy, &serial].map(|log| records(log));
    assert_eq!(runs.len(), 2);
    for (run, records) in runs.into_iter().zip(&both) {
        check(run, &x, records);
    }
    let [one, other] = both.map(|records| history(&records).makespan_s());
    let said =
        format!("makespans: greedy {one:.2} s, serial {other:.2} s; serial takes {:.2} times as long", other / one);
    assert!(picture.contains(&said), "{said}");
    let only_one = draw(&home, &["timeline", text(&greedy)]);
    assert_eq!(only_one.matches(r#"class="axis""#).count(), 1);
}

/// Names that would end an element, an attribute or a picture.
const HOSTILE: &str = "\
objects: {1: {at: shelf}}
task:
  name: \"</svg>]]>\"
  then: [{move: {to: shelf}, name: \"\\\"' onload='x\"}, {pick: {object: 1}, name: \"</text><script>&amp;<!--\"}]
";

#[test]
fn hostile_names_stay_names() {
    let home = Home::new();
    let file = home.write("hostile.yaml", &mission(HOSTILE));
    let log = log(&home, "hostile.jsonl", &file, &[]);
    // Mission files refuse what turns the direction of writing; a journal can hold anything.
    let turned = fs::read_to_string(&log).expect("a log").replace("&amp;<!--", "&amp;<!--\u{202e}");
    fs::write(&log, turned).expect("a file");
    let [plain, odd] = ["\"' onload='x", "</text><script>&amp;<!--"];
    let turned = format!("{odd}\u{fffd}");
    for (args, odd) in
        [(["timeline", text(&log)], &*turned), (["tree", text(&log)], &*turned), (["tree", text(&file)], odd)]
    {
        let names = [plain, odd];
        let picture = draw(&home, &args);
        let document = Document::parse(&picture).expect("XML");
        let root = document.root_element();
        assert!(root.descendants().all(|node| !node.has_tag_name("script") && node.attribute("onload").is_none()));
        let titles: Vec<_> =
            root.descendants().filter(|node| node.has_tag_name("title")).filter_map(|node| node.text()).collect();
        for name in names {
            assert!(titles.iter().any(|title| title.starts_with(name)), "{args:?}: {name} is not in {titles:?}");
        }
    }
}

#[test]
fn trees_show_every_node() {
    let home = Home::new();
    for number in experiments().into_keys() {
        let mission = experiment_file(number);
        let log = log(&home, "run.jsonl", &mission, &[]);
        let (plain, colored) = (draw(&home, &["tree", text(&mission)]), draw(&home, &["tree", text(&log)]));
        for (picture, skipped) in [(plain, 0), (colored, history(&records(&log)).skipped().len())] {
            let document = Document::parse(&picture).expect("XML");
            assert_eq!(all(document.root(), "task").count(), 6, "root, AND and four THEN");
            assert_eq!(all(document.root(), "behavior").count(), 16);
            assert_eq!(all(document.root(), "order").count(), 16, "children of a THEN are numbered");
            assert_eq!(all(document.root(), "leaf-skipped").count(), skipped);
        }
    }
}

#[test]
fn without_a_file_there_is_text_on_stdout() {
    let home = Home::new();
    let log = log(&home, "run.jsonl", &experiment_file(1), &[]);
    let history = history(&records(&log));
    let header = history.header();
    let printed = |args: &[&str]| {
        let finished = home.start(args).ends(0);
        assert_eq!(finished.stderr, "");
        finished.stdout
    };
    let plain = Palette::plain();
    assert_eq!(printed(&["timeline", text(&log)]), timeline::text(&history, 100, &plain));
    assert_eq!(printed(&["tree", text(&log)]), tree::text(header, Some(&history), 100, &plain));
    assert_eq!(printed(&["tree", text(&experiment_file(1))]), tree::text(header, None, 100, &plain));
    let picture = printed(&["timeline", text(&log), "-o", "-"]);
    assert_eq!(picture, draw(&home, &["timeline", text(&log)]));
}

#[test]
fn an_instance_means_its_log() {
    let home = Home::new();
    home.start(["simulate", "--quiet", text(&experiment_file(1))]).ends(0);
    for verb in ["timeline", "tree"] {
        assert!(draw(&home, &[verb, "simulate"]).contains(">skipped<"));
    }
}

#[test]
fn a_log_that_is_cut_off_is_drawn_to_the_cut() {
    let home = Home::new();
    let log = log(&home, "run.jsonl", &experiment_file(1), &[]);
    let whole = fs::read_to_string(&log).expect("a log");
    let cut = home.write("cut.jsonl", &whole[..whole.len() / 2]);
    for verb in ["timeline", "tree"] {
        let finished = home.start([verb, text(&cut), "-o", "-"]).ends(0);
        assert!(finished.words().contains("the log was cut off in its last line"), "{}", finished.stderr);
        Document::parse(&finished.stdout).expect("XML");
    }
}

#[test]
fn what_cannot_be_read_is_refused() {
    let home = Home::new();
    let log = log(&home, "run.jsonl", &mission_file(&home), &[]);
    let text_of = fs::read_to_string(&log).expect("a log");
    let version = format!("\"version\":{JOURNAL_VERSION}");
    let newer = home.write("newer.jsonl", &text_of.replacen(&version, "\"version\":77", 1));
    let check = |args: &[&str], said: &[&str]| {
        let finished = home.start(args).ends(2);
        assert_eq!(finished.stdout, "");
        said.iter().for_each(|said| assert!(finished.words().contains(said), "{}", finished.stderr));
    };
    let known = format!("reads version {JOURNAL_VERSION}");
    check(&["timeline", text(&newer)], &["has version 77", &known]);
    check(&["tree", text(&newer)], &["has version 77", &known]);
    check(&["timeline", text(&mission_file(&home))], &["is no journal"]);
    check(&["timeline", "nowhere"], &["there is no log `nowhere`"]);
    check(&["tree", "nowhere"], &["cannot read nowhere"]);
    check(&["timeline", text(&log), "-o", text(&log)], &["would be written over"]);
    check(&["tree", text(&log), "-o", "/nowhere/x.svg"], &["cannot write /nowhere/x.svg"]);
    assert_eq!(fs::read_to_string(&log).expect("a log"), text_of, "the log is as it was");
}

fn mission_file(home: &Home) -> PathBuf {
    home.write("small.yaml", &mission(HANDS_FULL))
}

/// A run of very many behaviors, each of which fails again and again.
fn long_run(behaviors: usize, rounds: u32) -> Vec<u8> {
    let mut journal = Journal::new(Vec::new());
    let entry = |kind: &str| NodeEntry { parent: NodeId(0), kind: EntryKind::from(kind.to_owned()) };
    let nodes = std::iter::once(entry("root")).chain(std::iter::repeat_n(entry("pick"), behaviors)).collect();
    let name = |node: usize| format!("pick {node}");
    let names = Names { nodes: (0..=behaviors).map(name).collect(), resources: vec!["arm".into()], ..Names::default() };
    let (version, resource_types) = (JOURNAL_VERSION, vec![TypeId(0)]);
    let [mission, robot, allocator] = ["long", "arm", "greedy"].map(str::to_owned);
    let header = Header {
        version,
        mission,
        robot,
        allocator,
        nodes,
        resource_types,
        names,
        movers: Vec::new(),
        start: None,
        waits_when_stalled: false,
        reattach_us: 0,
        cleanup_grace_us: 0,
        has_messages: true,
        source: None,
    };
    let mut write = |record: &Record| journal.write(record).expect("memory takes all");
    write(&Record::Header(Box::new(header)));
    for round in 1..=rounds {
        let leaf = NodeId(1 + round % (behaviors as u32 / 2));
        let at = Time(u64::from(round) * 1_000_000);
        let request = Request {
            leaf,
            priority: 0,
            iterations: 0,
            potential: 1.0,
            heir: false,
            claims: vec![],
            changes: vec![],
            skips: vec![],
            place: None,
            stand: None,
            spots: Vec::new(),
            distance: None,
        };
        let grant = Grant { request: request.into(), bindings: vec![], met: vec![], way: vec![] };
        write(&Record::Decided {
            at,
            round,
            granted: vec![grant],
            refused: vec![],
            reopened: None,
            deadlines: Vec::new(),
            urged: None,
            overdue: None,
        });
        let at = Time(at.0 + 900_000);
        let end = End::Failed(Fault::TimedOut);
        write(&Record::Released {
            at,
            leaf,
            end,
            consequences: Consequences::default(),
            changes: vec![],
            waits_until: None,
            unfit: Vec::new(),
        });
    }
    journal.into_inner()
}

#[test]
fn a_long_run_makes_no_long_picture() {
    let home = Home::new();
    let path = home.path("long.jsonl");
    for (behaviors, rounds, left_out) in
        [(100, 20_000, "50 of 100 behaviors did not run"), (1000, 20_000, "300 that ran")]
    {
        fs::write(&path, long_run(behaviors, rounds)).expect("a file");
        let picture = draw(&home, &["timeline", text(&path)]);
        Document::parse(&picture).expect("XML");
        assert!(picture.len() < 8_000_000, "{} bytes", picture.len());
        assert!(picture.contains(left_out), "it is said what is left out");
        let tree = draw(&home, &["tree", text(&path)]);
        assert!(tree.len() < 2_000_000, "{} bytes", tree.len());
    }
}

#[test]
fn the_pictures_of_the_docs_are_what_their_commands_draw() {
    let home = Home::new();
    let docs = fs::read_to_string(file("docs/pictures/README.md")).expect("the commands");
    let commands: Vec<&str> = docs.lines().filter_map(|line| line.strip_prefix("ambidex ")).collect();
    for command in &commands {
        let here = |word: &str| match word.rsplit_once('/') {
            Some(("docs/pictures", name)) => home.path(name),
            Some(_) => file(word),
            None if word.ends_with(".jsonl") => home.path(word),
            None => PathBuf::from(word),
        };
        let code = if command.contains("cancel.yaml") { 130 } else { 0 };
        home.start(command.split(' ').map(here)).ends(code);
    }
    let folder = fs::read_dir(file("docs/pictures")).expect("pictures");
    let names = folder.map(|entry| entry.expect("an entry").file_name().into_string().expect("a name"));
    for name in names.filter(|name| name.ends_with(".svg")) {
        let read = |path: PathBuf| fs::read_to_string(path).expect("a picture");
        let (drawn, committed) = (read(home.path(&name)), read(file("docs/pictures").join(&name)));
        let is_same = !PINNED.contains(&name.as_str()) || drawn == committed;
        assert!(is_same, "{name} is not what its command draws: see docs/pictures/README.md");
        assert_eq!(contents(&drawn), contents(&committed), "{name} shows something else: see docs/pictures/README.md");
    }
}

/// The pictures of which every byte is kept: one of each kind.
const PINNED: [&str; 3] = ["experiment-1-timeline.svg", "hand-over-tree.svg", "detour-map.svg"];

/// Everything that a picture says, wherever it stands.
fn contents(picture: &str) -> Vec<String> {
    let document = Document::parse(picture).expect("XML");
    let texts = document.descendants().filter(|node| node.has_tag_name("title") || node.has_tag_name("desc"));
    let mut said: Vec<String> = texts.filter_map(|node| node.text()).map(str::to_owned).collect();
    said.sort();
    assert!(said.len() > 3, "{said:?}");
    said
}
