//! The status as text without color, in terminals of any size.

use crate::Palette;
use crate::sample::experiment_1;
use crate::status::Snapshot;
use crate::text::{MIN_WIDTH, columns};

use super::{LIVES, picking, snapshot};

fn check(snapshot: &Snapshot, width: usize, height: usize, expected: &str) {
    let text = snapshot.lines(width, height, &Palette::plain()).join("\n");
    let trimmed: Vec<&str> = text.lines().map(str::trim_end).collect();
    assert_eq!(trimmed.join("\n"), expected.trim_matches('\n'), "\n{text}");
}

const PICKING_80X23: &str = "
experiment 1  running · 8.00 s · round 2 · step 2 · 2 of 16 done
pr2, greedy · daemon pid 7 · 3 messages between nodes
resource       type     owners  channel     locked  held by
base           base          2  at shelf    yes     pick 1 + pick 2 (running)
head           head          0              no
left_gripper   gripper       1  alone       yes     pick 1 (running)
right_gripper  gripper       1  alone       yes     holds object 4, object 4 (p…
controller  health  why, and its goal
base        OK      standing · pick 1 + pick 2
head        OK      idle
left_arm    OK      grasping · pick 1                 ━━━━━━━━━───────────  45 %
right_arm   OK      idle
world    base at (2.00, -1.00), heading 0°
objects  object 1 at shelf · object 2 at counter · object 3 at sink ·
         object 4 in right_gripper
task                    potential  state, and why
● root                             active, 2 of 16 done
└─ ● all objects  and              active, 2 of 16 done, 5 not shown
   ├─ ● object 1  then             active, 1 of 4 done, 3 not shown
   │  └─ ● pick 1           9.000  active, 45 %
   ├─ ● object 2  then             active, 1 of 4 done, 3 not shown
   │  └─ ● pick 2                  active
   └─ ○ object 3  then             0/4 done, move 3-1: base is held by pick 1 f…
";

const WAITING_40X17: &str = "
experiment 1  waiting for base, head, l…
pr2, greedy · daemon pid 7 · 0 messages…
resource  type   own  channel  lock  he…
base      base     0           no
head      head     0           no
left_gr…  grip…    0           no
right_g…  grip…    0           no
controller  health  why, and its goal
base        STALE   not yet attached
head        STALE   not yet attached
… 2 more
world    base at (0.00, 0.00), heading …
task               pot.  state, and why
○ root                   waiting, 0 of …
└─ ○ all objects         waiting, 0 of …
   ├─ ○ object 1         waiting, 0 of …
   └─ ○ object 2         waiting, 0 of …
";

const WAITING_40X12: &str = "
experiment 1  waiting for base, head, l…
pr2, greedy · daemon pid 7 · 0 messages…
resource  type   own  channel  lock  he…
… 4 more
controller  health  why, and its goal
… 4 more
world    base at (0.00, 0.00), heading …
task               pot.  state, and why
○ root                   waiting, 0 of …
└─ ○ all objects         waiting, 0 of …
   ├─ ○ object 1         waiting, 0 of …
   └─ ○ object 2         waiting, 0 of …
";

#[test]
fn it_fits_a_small_terminal() {
    check(&snapshot(&picking(), LIVES), 80, 23, PICKING_80X23);
    let waiting = snapshot(&picking()[..1], LIVES);
    check(&waiting, MIN_WIDTH, 17, WAITING_40X17);
    check(&waiting, MIN_WIDTH, 12, WAITING_40X12);
}

#[test]
fn every_size_is_kept_to() {
    for records in [picking(), experiment_1(), experiment_1()[..1].to_vec()] {
        let snapshot = snapshot(&records, LIVES);
        for width in [0, MIN_WIDTH, 41, 57, 80, 120, 300] {
            for height in [0, 1, 2, 5, 9, 12, 16, 20, 24, 30, 40, 100] {
                let lines = snapshot.lines(width, height, &Palette::plain());
                assert!(lines.len() <= height, "{width}x{height}: {lines:#?}");
                for line in &lines {
                    assert!(columns(line) <= width.max(MIN_WIDTH), "{width}x{height}: {line:?}");
                }
            }
            let whole = snapshot.lines(width, 100, &Palette::plain());
            assert_eq!(whole.iter().filter(|line| line.contains("plac")).count(), 4, "{whole:#?}");
        }
    }
}
