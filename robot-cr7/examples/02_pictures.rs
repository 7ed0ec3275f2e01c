//! Draws the pictures of a plan from plain numbers, into `target/pictures/`.
//!
//! The path is the real butterfly, cut at equal steps of its parameter; feed and joint curves are made up, with the
//! real speed limit of 100 mm/s and of the chord error, (2/T) sqrt(2 delta/kappa - delta^2).

use std::f64::consts::{PI, TAU};
use std::path::Path;

use arcfeed_geometry::Curve;
use robot_cr7::plot::{
    Along, Bound, JointQuantity, Line, feed_picture, joint_picture, lines_picture, path_picture, save_picture,
};
use robot_cr7::{PathGeometry, butterfly};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder = Path::new("target/pictures");
    std::fs::create_dir_all(folder)?;
    let save = |name: &str, svg: String| {
        println!("{name}: {} kB", svg.len() / 1024);
        save_picture(&folder.join(name), &svg)
    };

    let PathGeometry::Curve(curve) = butterfly()?.geometry else { return Ok(()) };
    let (start, end) = curve.domain();
    let at = |f: f64| {
        let p = curve.point(start + (end - start) * f);
        [p.x, p.y, 0.0]
    };
    for count in [160, 1579] {
        let segments: Vec<Vec<[f64; 3]>> = (0..count)
            .map(|i| (0..=20).map(|k| at((f64::from(i) + f64::from(k) / 20.0) / f64::from(count))).collect())
            .collect();
        let deviations: Vec<f64> = segments.iter().map(|s| deviation(s)).collect();
        let tolerance = if count == 160 { 5e-4 } else { 1e-5 };
        let title = format!("Butterfly in {count} equal steps of its parameter");
        save(&format!("path_{count}.svg"), path_picture(&title, &segments, &deviations, tolerance, None)?)?;
    }

    // A feed that keeps under the limit: the least limit of the neighbourhood, smoothed over it.
    let n = 100_000;
    let mut s = 0.0;
    let mut limit = Vec::with_capacity(n);
    for i in 0..n {
        let jet = curve.jet(start + (end - start) * (i as f64 + 0.5) / n as f64);
        s += jet.speed() * (end - start) / n as f64;
        let (delta, kappa) = (1e-6, jet.curvature());
        let v = if kappa * delta < 1.0 {
            2.0 / 1e-3 * (2.0 * delta / kappa - delta * delta).sqrt()
        } else {
            2.0 / (kappa * 1e-3)
        };
        limit.push((s, v.min(0.1)));
    }
    let least: Vec<f64> = limit.chunks(200).map(|c| c.iter().fold(0.1, |a: f64, p| a.min(p.1))).collect();
    let feed: Vec<(f64, f64)> = (0..n)
        .map(|i| {
            let (k, f) = (i / 200, (i % 200) as f64 / 200.0);
            let around =
                |k: usize| (k.saturating_sub(1)..(k + 2).min(least.len())).fold(f64::INFINITY, |a, j| a.min(least[j]));
            let blend = f * f * (3.0 - 2.0 * f);
            (limit[i].0, 0.95 * (around(k) * (1.0 - blend) + around((k + 1).min(least.len() - 1)) * blend))
        })
        .collect();
    save("feed.svg", feed_picture("Feed along the butterfly", Along::Length, &feed, &limit)?)?;

    let t: Vec<f64> = (0..n).map(|i| 5.4 * i as f64 / n as f64).collect();
    let joints: Vec<Vec<f64>> = (1..=6)
        .map(|j| t.iter().map(|t| (0.3 * f64::from(j)) * (TAU * t / 5.4 * f64::from(j)).sin().powi(3)).collect())
        .collect();
    let values: [&[f64]; 6] = std::array::from_fn(|j| joints[j].as_slice());
    let svg = joint_picture(
        "Butterfly",
        JointQuantity::Velocity,
        &t,
        &values,
        &[PI, PI, PI, 1.2, 1.6, 1.7].map(Bound::Constant),
        &[],
    )?;
    save("joint_velocity.svg", svg)?;

    let series: Vec<Vec<(f64, f64)>> =
        values.iter().map(|v| t.iter().copied().zip(v.iter().copied()).collect()).collect();
    let names = ["J1", "J2", "J3", "J4", "J5", "J6"];
    let lines: Vec<Line> = names.iter().zip(&series).map(|(&name, points)| Line { name, points }).collect();
    let svg =
        lines_picture("All joints together", "velocity in rad/s", ("time t [s]", "velocity [rad/s]"), &lines, &[1.7])?;
    save("lines.svg", svg)?;
    Ok(())
}

/// Largest distance of a dense polyline in the plane from the chord between its ends.
fn deviation(points: &[[f64; 3]]) -> f64 {
    let (a, b) = (points[0], points[points.len() - 1]);
    let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
    let l2 = dx * dx + dy * dy;
    points.iter().fold(0.0, |worst: f64, p| {
        let f = (((p[0] - a[0]) * dx + (p[1] - a[1]) * dy) / l2).clamp(0.0, 1.0);
        worst.max((p[0] - a[0] - f * dx).hypot(p[1] - a[1] - f * dy))
    })
}
