//! Squares with rounded corners from dense points, on the CR7: by cubics alone, with the lines and arcs that the fit recognises, and from
//! the exact lines and arcs. `dense_arcs [all]`; without an argument one square.
//!
//! The jumps of curvature of the exact path are blended within the tolerance of the fit.

use std::f64::consts::FRAC_PI_2;

use arcfeed_geometry::{ArcTo, Blending, Curve, DenseFit, JoinedPathBuilder, NurbsCurve};
use arcfeed_kinematics::models;
use integration_tests::on_cr7::{Failure, TOOL, planned};
use nalgebra::Vector3;

/// Side of the squares, m.
const SIDE: f64 = 0.06;

fn main() -> Result<(), Failure> {
    let all = std::env::args().any(|argument| argument == "all");
    let (radii, tolerances): (&[f64], &[f64]) =
        if all { (&[1e-3, 5e-3, 2e-2], &[2e-6, 5e-6, 2e-5]) } else { (&[5e-3], &[5e-6]) };
    println!(
        "| radius, mm | tolerance, um | pieces: cubics, recognised, exact | intervals | time, s | largest curvature, 1/mm |"
    );
    println!("|---|---|---|---|---|---|");
    for &radius in radii {
        for &tolerance in tolerances {
            let paths =
                [fitted(radius, tolerance, false)?, fitted(radius, tolerance, true)?, exact(radius, tolerance)?];
            let [cubics, recognised, exact] = paths.map(|path| measure(&path));
            let all = [cubics?, recognised?, exact?];
            let list = |of: fn(&Measured) -> String| all.iter().map(of).collect::<Vec<_>>().join(", ");
            println!(
                "| {} | {} | {} | {} | {} | {} |",
                1e3 * radius,
                1e6 * tolerance,
                list(|m| m.pieces.to_string()),
                list(|m| m.intervals.to_string()),
                list(|m| format!("{:.4}", m.time)),
                list(|m| format!("{:.4}", 1e-3 * m.curvature)),
            );
        }
    }
    Ok(())
}

struct Measured {
    pieces: usize,
    intervals: usize,
    time: f64,
    curvature: f64,
}

/// Half of the first side, then each corner with the side behind it: the end of the line, the centre and the end of the arc.
fn corners(radius: f64) -> (Vector3<f64>, Vec<[Vector3<f64>; 3]>) {
    let middle = Vector3::new(0.42, -0.05, 0.2);
    let half = 0.5 * SIDE;
    let corner = |i: usize| {
        let turned = |x: f64, y: f64| {
            let (sine, cosine) = (FRAC_PI_2 * i as f64).sin_cos();
            middle + Vector3::new(x * cosine - y * sine, x * sine + y * cosine, 0.0)
        };
        [turned(half - radius, -half), turned(half - radius, -half + radius), turned(half, -half + radius)]
    };
    let start = middle - Vector3::new(0.0, half, 0.0);
    (start, (0..4).map(corner).collect())
}

/// The curve through points of the square every 0.1 mm, rounded to a micrometre.
fn fitted(radius: f64, tolerance: f64, recognise: bool) -> Result<NurbsCurve<3>, Failure> {
    let (start, corners) = corners(radius);
    let fit = DenseFit::<3>::new(tolerance)?;
    let mut fit = if recognise { fit } else { fit.with_cubics_only() };
    let round = |p: Vector3<f64>| p.map(|x| (x * 1e6).round() / 1e6);
    let mut points = vec![start];
    let line = |points: &mut Vec<Vector3<f64>>, to: Vector3<f64>| {
        let from = points[points.len() - 1];
        let count = ((to - from).norm() / 1e-4).ceil();
        points.extend((1..=count as u32).map(|i| from.lerp(&to, f64::from(i) / count)));
    };
    for [from, centre, to] in corners {
        line(&mut points, from);
        let count = (FRAC_PI_2 * radius / 1e-4).ceil();
        let at = |i: u32| FRAC_PI_2 * f64::from(i) / count;
        let arc = |angle: f64| centre + (from - centre) * angle.cos() + (to - centre) * angle.sin();
        points.extend((1..=count as u32).map(|i| arc(at(i))));
    }
    line(&mut points, start);
    points.into_iter().try_for_each(|point| fit.push(round(point)))?;
    fit.finish()?;
    let mut path = JoinedPathBuilder::new(start, 1e-9)?;
    while let Some(stretch) = fit.next_stretch() {
        path.curve(&stretch.curve, 1)?;
    }
    Ok(path.build()?.to_curve()?)
}

/// The lines and arcs themselves.
fn exact(radius: f64, tolerance: f64) -> Result<NurbsCurve<3>, Failure> {
    let (start, corners) = corners(radius);
    let mut path = JoinedPathBuilder::new(start, 1e-9)?;
    for [from, centre, to] in corners {
        path.line_to(from, 1)?.arc(&ArcTo::new(centre, Vector3::z_axis(), to), 2)?;
    }
    path.line_to(start, 3)?;
    Ok(path.build()?.blended(&Blending::within(tolerance))?.path.to_curve()?)
}

fn measure(curve: &NurbsCurve<3>) -> Result<Measured, Failure> {
    let (start, end) = curve.domain();
    let curvature = |i: u32| curve.jet(start + (end - start) * f64::from(i) / 20_000.0).curvature();
    let arm = models::cr7();
    let plan = planned(&arm, curve.clone(), TOOL)?;
    Ok(Measured {
        pieces: curve.knots().spans().count(),
        intervals: plan.info().intervals,
        time: plan.duration(),
        curvature: (0..=20_000).map(curvature).fold(0.0, f64::max),
    })
}
