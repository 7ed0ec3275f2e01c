//! Random programs of lines, arcs and waves, fitted and checked; and a million points, timed.
//!
//! `cargo run --release -p arcfeed-geometry --features fit --example soak_dense -- COUNT SEED`

use std::time::Instant;

use arcfeed_geometry::nalgebra::{Vector3, vector};
use arcfeed_geometry::{Curve, NurbsCurve};

#[path = "../tests/it/common/dense.rs"]
mod dense;

fn main() -> Result<(), String> {
    let argument = |i: usize| std::env::args().nth(i).and_then(|a| a.parse::<u64>().ok());
    let (count, first) = (argument(1).unwrap_or(5000), argument(2).unwrap_or(1));
    let (mut points, mut pieces, mut wrong_corners) = (0usize, 0usize, 0usize);
    let (mut polylines, mut slowest) = (0usize, f64::INFINITY);
    for seed in first..first + count {
        let program = dense::program(seed);
        let fitted = NurbsCurve::fit_dense(program.points.iter().copied(), program.tolerance);
        let fitted = fitted.map_err(|e| format!("seed {seed}: {e}"))?;
        if let Err(e) = dense::check(&program.points, &fitted, program.tolerance) {
            println!("seed {seed}: {e}");
        }
        if dense::corners(&fitted) != program.corners {
            wrong_corners += 1;
            let found = dense::corners(&fitted);
            println!(
                "seed {seed}: {} corners {:?} for {:?}",
                found.len(),
                &found[..found.len().min(12)],
                program.corners
            );
        }
        points += program.points.len();
        pieces += fitted.iter().map(|s| s.pieces()).sum::<usize>();
        polylines += fitted.iter().filter(|s| s.shape == arcfeed_geometry::StretchShape::Polyline).count();
        for s in &fitted {
            for k in s.curve.knots().spans() {
                slowest = slowest.min(s.curve.jet(s.curve.knots().as_slice()[k]).speed());
            }
        }
    }
    println!("{count} programs: {points} points, {pieces} pieces, {wrong_corners} with other corners");
    println!("{polylines} stretches kept as polyline, least speed at a knot {slowest}");

    for (name, step) in [("every 0.1 mm", 0.1), ("every 0.01 mm", 0.01), ("every 0.5 mm", 0.5)] {
        let points: Vec<Vector3<f64>> = (0..1_000_000).map(|i| dense::rounded(meander(f64::from(i) * step))).collect();
        let start = Instant::now();
        let fitted = NurbsCurve::fit_dense(points.iter().copied(), 0.005).map_err(|e| e.to_string())?;
        let time = start.elapsed().as_secs_f64();
        let pieces: usize = fitted.iter().map(|s| s.pieces()).sum();
        println!("1e6 points {name}: {time:.2} s, {} stretches, {pieces} pieces", fitted.len());
    }
    Ok(())
}

/// A path on a wavy torus.
fn meander(s: f64) -> Vector3<f64> {
    let (angle, radius) = (s / 200.0, 200.0 + 10.0 * (s / 37.0).sin());
    vector![radius * angle.cos(), radius * angle.sin(), 5.0 * (s / 25.0).sin()]
}
