//! The display and its plain lines.

use crate::draw::progress::Progress;
use crate::draw::{Palette, sample, summary, timing, tree};

#[test]
fn look() {
    let records = sample::experiment_1();
    let mut progress = Progress::new(&sample::robot());
    for record in &records {
        progress.add(record);
        if let Some(line) = progress.plain_line(record) {
            println!("{line}");
        }
    }
    for palette in [Palette::plain(), Palette::ansi()] {
        for width in [40, 80, 120, 200] {
            println!("{}", "=".repeat(width));
            println!("{}", timing(progress.tally(), width, &palette));
        }
        println!("{}", summary(progress.tally(), 80, &palette));
        println!(
            "{}",
            tree(&sample::header(), Some(progress.tally()), 80, &palette)
        );
    }
}
