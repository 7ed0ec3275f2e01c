//! A curve through points, and one near them with far fewer control points.
//!
//! `cargo run -p arcfeed-geometry --features fit --example 04_fit_to_points`

use arcfeed_geometry::{Curve, GeometryError, NurbsCurve, Spacing, nalgebra::vector};

fn main() -> Result<(), GeometryError> {
    // 400 points of a rose, in mm, as a scanner might deliver them: rounded to 1 um.
    let points: Vec<_> = (0..400)
        .map(|i| {
            let a = f64::from(i) / 399.0 * std::f64::consts::TAU;
            let r = 40.0 + 15.0 * (5.0 * a).cos();
            vector![(1e3 * r * a.cos()).round() / 1e3, (1e3 * r * a.sin()).round() / 1e3]
        })
        .collect();

    let through = NurbsCurve::interpolate(&points, 3, Spacing::Centripetal)?;
    println!(
        "interpolation: {} control points, largest deviation {:.1e} mm",
        through.curve.control_points().len(),
        through.max_deviation
    );
    for tolerance in [1.0, 0.1, 0.01, 0.001] {
        let near = NurbsCurve::approximate(&points, 3, Spacing::Chord, tolerance)?;
        println!(
            "within {tolerance:5} mm: {:3} control points, largest deviation {:.6} mm, closed to {:.1e} mm",
            near.curve.control_points().len(),
            near.max_deviation,
            (near.curve.point(0.0) - near.curve.point(1.0)).norm()
        );
    }
    Ok(())
}
