//! A path of any number of intervals, planned in windows, and at once for comparison where its rows fit into memory.
//!
//! `cargo run --release -p arcfeed-feedrate --example 10_windows -- [INTERVALS] [WINDOW]`
use std::ops::Range;
use std::time::Instant;

use arcfeed_feedrate::constraint::{JointAcceleration, JointJerk, JointVelocity};
use arcfeed_feedrate::{FeedError, FeedPlanner, FeedProblem, JerkLimited, WindowedJerkLimited};
use arcfeed_testing::Random;

#[path = "../tests/it/common/spline_paths.rs"]
mod spline_paths;
use spline_paths::{A_MAX, Spline, V_A};

/// Grid intervals between two way-points, some 2.4 s.
const PER_WAY_POINT: usize = 100;

/// Paths of more intervals are not planned at once: some gigabyte of rows.
const MOST_AT_ONCE: usize = 100_000;

fn main() -> Result<(), FeedError> {
    let number = |i: usize| std::env::args().nth(i).and_then(|text| text.parse::<usize>().ok());
    let (intervals, window) = (number(1).unwrap_or(20_000), number(2).unwrap_or(2000));
    let mut rng = Random::new(1);
    let ways = (intervals / PER_WAY_POINT).max(2) + 1;
    let points: Vec<_> = (0..ways).map(|_| std::array::from_fn(|_| rng.between(-1.5, 1.5))).collect();
    let spline = Spline::natural(&points);
    let grid = spline.on_knots(intervals);
    let jerk = A_MAX.map(|a| 10.0 * a);
    let stretch = |range: Range<usize>| {
        let grid = &grid[range.start..=range.end];
        let samples = spline.samples(grid);
        let velocity = JointVelocity::new(samples.path(), &V_A)?;
        let acceleration = JointAcceleration::new(samples.path(), &A_MAX)?;
        FeedProblem::between_points(grid, &[&velocity, &acceleration, &JointJerk::new(samples.path(), &jerk)?])
    };
    let n = grid.len() - 1;
    let start = Instant::now();
    let plan = WindowedJerkLimited::new(JerkLimited::default(), window)?.plan(n, stretch)?;
    let (law, seconds) = (&plan.law, start.elapsed().as_secs_f64());
    println!("{n} intervals in {} windows: {:.3} s of motion in {seconds:.2} s", plan.windows, law.duration());
    println!("{} stops that the path does not ask for", plan.stops.len());
    if n <= MOST_AT_ONCE {
        let start = Instant::now();
        let whole = JerkLimited::default().plan(&stretch(0..n)?)?.duration();
        let (seconds, more) = (start.elapsed().as_secs_f64(), 100.0 * (law.duration() / whole - 1.0));
        println!("at once: {whole:.3} s of motion in {seconds:.2} s; windows take {more:.4} % more");
    }
    Ok(())
}
