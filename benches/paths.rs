//! One search of a path against the number of obstacles: across a square full of boxes.
//!
//! Beside it the grid of 10 cm that was searched before, as far as it comes to an end in seconds.

#[path = "support/grid.rs"]
mod grid;
#[path = "support/table.rs"]
mod table;

use std::time::Instant;

use ambidex::model::{Obstacle, Pose};
use ambidex::world::{Found, FreeSpace, NoPath, find_path};
use nalgebra::Point3;

const SIZES: [usize; 8] = [25, 50, 100, 200, 400, 800, 1_600, 2_000];
/// The grid beyond takes minutes.
const MOST_OF_GRID: usize = 400;
const WORLDS: u64 = 3;
const RADIUS_M: f64 = 0.3;
/// Ground per box where the density stays: more than a third of it is closed to the base's middle.
const GROUND_M2: f64 = 4.0;
/// Side of the square where the density grows, meters.
const SIDE_M: f64 = 30.0;
/// Around both ends nothing stands, meters.
const CLEAR_M: f64 = 1.5;
const REPEATS: usize = 5;
const ROUNDING_M: f64 = 0.01;

fn main() {
    tell("Constant density, 4 m² per box, from corner to corner:", 0.0, |n| (n as f64 * GROUND_M2).sqrt());
    tell("Constant area, 30 m by 30 m, from a quarter of its diagonal to three quarters:", 0.25, |_| SIDE_M);
    println!(
        "\nsteps: boxes and groups of boxes held against a leg; each row is the mean of {WORLDS} worlds, the fastest of \
         {REPEATS} searches each;\nthe grid is searched once. exponent: growth of the time from the row above."
    );
}

/// What one world comes to.
struct Row {
    found: Found,
    search_us: f64,
    index_us: f64,
    path_m: Option<f64>,
    /// Time and length of the grid.
    grid: Option<(f64, Option<f64>)>,
}

fn tell(title: &str, inset: f64, side_m: impl Fn(usize) -> f64) {
    let titles = "boxes|index µs|search µs|exponent|steps|expansions|path m|found|grid ms|grid path m|grid/search";
    let mut rows = vec![titles.split('|').map(str::to_owned).collect::<Vec<_>>()];
    let mut above: Option<(usize, f64)> = None;
    for n in SIZES {
        let worlds: Vec<_> = (0..WORLDS).map(|seed| measure(n, side_m(n), inset, seed)).collect();
        let mean = |of: &dyn Fn(&Row) -> f64| worlds.iter().map(of).sum::<f64>() / worlds.len() as f64;
        let search_us = mean(&|row| row.search_us);
        let exponent = above.map(|(m, us)| (search_us / us).ln() / (n as f64 / m as f64).ln());
        above = Some((n, search_us));
        let grid_ms = (n <= MOST_OF_GRID).then(|| mean(&|row| row.grid.map_or(0.0, |(ms, _)| ms)));
        let lengths = |of: &dyn Fn(&Row) -> Option<f64>| {
            let lengths: Option<Vec<_>> = worlds.iter().filter(|row| row.path_m.is_some()).map(of).collect();
            let lengths = lengths.filter(|lengths| !lengths.is_empty())?;
            Some(lengths.iter().sum::<f64>() / lengths.len() as f64)
        };
        let number = |value: Option<f64>, digits: usize| value.map_or("-".into(), |value| format!("{value:.digits$}"));
        rows.push(vec![
            n.to_string(),
            number(Some(mean(&|row| row.index_us)), 0),
            number(Some(search_us), 0),
            number(exponent, 2),
            number(Some(mean(&|row| f64::from(row.found.steps))), 0),
            number(Some(mean(&|row| f64::from(row.found.expansions))), 0),
            number(lengths(&|row| row.path_m), 3),
            worlds.iter().map(|row| verdict(&row.found)).collect::<Vec<_>>().join(" "),
            number(grid_ms, 1),
            number(lengths(&|row| row.grid.and_then(|(_, path_m)| path_m)), 3),
            number(grid_ms.map(|ms| ms * 1e3 / search_us), 0),
        ]);
    }
    table::print(title, &rows);
}

fn verdict(found: &Found) -> &'static str {
    match found.path {
        Ok(_) => "yes",
        Err(NoPath::Closed) => "no",
        Err(NoPath::Beyond(_)) => "beyond",
    }
}

fn measure(n: usize, side_m: f64, inset: f64, seed: u64) -> Row {
    let ends = [side_m * inset, side_m * (1.0 - inset)];
    let obstacles = scattered(n, side_m, ends, seed);
    let [from, to] = ends.map(|end| Pose::new(end, end, 0.0));
    let begun = Instant::now();
    let free_space = FreeSpace::new(&obstacles, RADIUS_M);
    let index_us = begun.elapsed().as_secs_f64() * 1e6;
    let search = || {
        let begun = Instant::now();
        let found = find_path(&free_space, from, to);
        (begun.elapsed().as_secs_f64() * 1e6, found)
    };
    let all: Vec<_> = (0..REPEATS).map(|_| search()).collect();
    assert!(all.iter().all(|(_, found)| *found == all[0].1), "a search is a function of its inputs");
    let search_us = all.iter().map(|(us, _)| *us).fold(f64::INFINITY, f64::min);
    let found = all[0].1.clone();
    let path_m = found.path.as_ref().ok().map(|path| length_m(from, path));
    let grid = (n <= MOST_OF_GRID).then(|| {
        let begun = Instant::now();
        let path = grid::find(&obstacles, RADIUS_M, from, to);
        (begun.elapsed().as_secs_f64() * 1e3, path.map(|path| length_m(from, &path)))
    });
    if let Some((_, Some(grid_m))) = grid {
        assert!(path_m.is_some_and(|path_m| path_m < grid_m + ROUNDING_M), "no path is longer than the grid's");
    }
    Row { found, search_us, index_us, path_m, grid }
}

fn length_m(from: Pose, path: &[Pose]) -> f64 {
    let begins = std::iter::once(&from).chain(path);
    begins.zip(path).map(|(a, b)| a.distance_m(b)).sum()
}

/// Boxes of 0.2 m to 1 m with their middles in a square, none around both ends.
fn scattered(n: usize, side_m: f64, ends: [f64; 2], seed: u64) -> Vec<Obstacle> {
    let mut random = Random(seed);
    let mut obstacles = Vec::new();
    while obstacles.len() < n {
        let (x, y) = (random.next() * side_m, random.next() * side_m);
        let (half_x, half_y) = (0.1 + 0.4 * random.next(), 0.1 + 0.4 * random.next());
        if ends.iter().all(|end| (x - end).abs() > CLEAR_M || (y - end).abs() > CLEAR_M) {
            obstacles.push(Obstacle::between(
                Point3::new(x - half_x, y - half_y, 0.0),
                Point3::new(x + half_x, y + half_y, 1.0),
            ));
        }
    }
    obstacles
}

/// Splitmix: the same worlds on every run.
struct Random(u64);

impl Random {
    /// From 0 up to 1.
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut bits = self.0;
        bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        (bits ^ (bits >> 31)) as f64 / u64::MAX as f64
    }
}
