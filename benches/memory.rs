//! Memory of a tree of actors per node, beside a bare tokio task with its channel.

#[path = "support/counting.rs"]
mod counting;
#[path = "support/mission.rs"]
mod mission;
#[path = "support/rounds.rs"]
mod rounds;
#[path = "support/table.rs"]
mod table;

use std::sync::atomic::Ordering;

use counting::IN_USE;
use rounds::{Actors, Load, current_thread, tree_of};
use tokio::sync::mpsc;

const SIZES: [usize; 2] = [125, 2500];

fn main() {
    let mut rows =
        vec!["nodes|behaviors|mission|bare task|actors|actors/bare".split('|').map(str::to_owned).collect::<Vec<_>>()];
    for (n, load) in SIZES.into_iter().flat_map(|n| Load::ALL.map(|load| (n, load))) {
        let nodes = 2 + 5 * n;
        let per_node = |bytes: usize| bytes as f64 / nodes as f64;
        let (mission, kept) = used(|| tree_of(n, load));
        drop(kept);
        let (bare, kept) = used(|| bare(nodes));
        drop(kept);
        let (actors, kept) = used(|| {
            let mut actors = Actors::start(n, load, false);
            actors.rounds(10);
            actors
        });
        kept.end();
        let own = per_node(actors.saturating_sub(mission));
        rows.push(vec![
            nodes.to_string(),
            load.name().to_owned(),
            format!("{:.0}", per_node(mission)),
            format!("{:.0}", per_node(bare)),
            format!("{own:.0}"),
            format!("{:.2}", own / per_node(bare)),
        ]);
    }
    table::print("Bytes on the heap per node:", &rows);
    println!(
        "\nactors: all that a run needs beside the mission after ten rounds: task, inbox, machine, state, topics, answers.\n\
         bare: a task that waits for its channel of pointers, with the sender."
    );
}

/// What something keeps in use.
fn used<T>(make: impl FnOnce() -> T) -> (usize, T) {
    let before = IN_USE.load(Ordering::Relaxed);
    let made = make();
    (IN_USE.load(Ordering::Relaxed).saturating_sub(before), made)
}

fn bare(nodes: usize) -> (tokio::runtime::Runtime, Vec<mpsc::Sender<Box<u64>>>) {
    let tokio = current_thread();
    let senders = (0..nodes).map(|_| {
        let (sender, mut inbox) = mpsc::channel::<Box<u64>>(8);
        tokio.spawn(async move { while inbox.recv().await.is_some() {} });
        sender
    });
    let senders = senders.collect();
    tokio.block_on(tokio::task::yield_now());
    (tokio, senders)
}
