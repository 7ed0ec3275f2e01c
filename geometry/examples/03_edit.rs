//! Inserting knots, splitting, raising the degree, turning around: the curve stays where it is.
//!
//! `cargo run -p arcfeed-geometry --example 03_edit`

use arcfeed_geometry::{Curve, GeometryError, NurbsCurve, nalgebra::vector};

fn main() -> Result<(), GeometryError> {
    // A full circle of radius 50 mm, exactly.
    let circle = NurbsCurve::<2>::circle(vector![0.0, 0.0], 50.0)?;
    show("circle", &circle);
    show("a knot at 0.1, twice", &circle.with_knot(0.1, 2)?);
    show("knots at 0.3, 0.6, 0.9", &circle.refined(&[0.3, 0.6, 0.9])?);
    show("degree raised", &circle.elevated()?);
    show("degree raised twice", &circle.elevated()?.elevated()?);
    show("reversed", &circle.reversed()?);
    show("in metres", &circle.scaled(0.001)?);
    let (left, right) = circle.split(0.4)?;
    show("first part, split at 0.4", &left);
    show("second part", &right);

    let corner = NurbsCurve::polyline(vec![vector![0.0, 0.0], vector![30.0, 0.0], vector![30.0, 40.0]])?;
    show("polyline", &corner);
    Ok(())
}

fn show(name: &str, curve: &NurbsCurve<2>) {
    let (a, b) = curve.domain();
    let curvature = curve.jet(0.5 * (a + b)).curvature();
    println!(
        "{name:26} degree {}, {:2} points, domain [{a}, {b}], curvature in the middle {curvature:.12}",
        curve.degree(),
        curve.control_points().len(),
    );
}
