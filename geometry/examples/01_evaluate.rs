//! A NURBS curve from numbers: position, tangent and curvature along it. Needs no file.
//!
//! `cargo run -p arcfeed-geometry --example 01_evaluate`

use arcfeed_geometry::{Curve, GeometryError, KnotVector, NurbsCurve, nalgebra::vector};

fn main() -> Result<(), GeometryError> {
    // A plane cubic with six control points (Liu et al. 2023, Table 1), in mm.
    let points = vec![
        vector![5.0, 4.0],
        vector![6.0, 12.0],
        vector![11.0, 10.0],
        vector![8.0, 4.0],
        vector![12.0, 3.0],
        vector![11.0, 9.0],
    ];
    let knots = KnotVector::clamped_uniform(3, points.len())?;
    let curve = NurbsCurve::bspline(3, points, knots.as_slice().to_vec())?;

    println!("    u         x         y   direction    curvature");
    println!("             mm        mm         deg       1 / mm");
    for i in 0..=10 {
        let u = f64::from(i) / 10.0;
        // One call: the point and its first three derivatives.
        let jet = curve.jet(u);
        let direction = jet.d1.y.atan2(jet.d1.x).to_degrees();
        println!(
            "{u:5.2}  {:8.4}  {:8.4}  {direction:10.3}  {:11.5}",
            jet.point.x,
            jet.point.y,
            jet.signed_curvature()
        );
    }

    println!("\nIts rational Bezier pieces:");
    for piece in curve.decompose() {
        let (m, n) = piece.interval();
        let points: Vec<_> = piece.control_points().map(|p| format!("({:.3}, {:.3})", p.x, p.y)).collect();
        println!("  u in [{m:.4}, {n:.4}]: {}", points.join(" "));
    }
    Ok(())
}
