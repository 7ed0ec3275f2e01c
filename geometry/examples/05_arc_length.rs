//! Arc length: a curve whose parameter runs unevenly, and the same curve at even steps.
//!
//! `cargo run -p arcfeed-geometry --example 05_arc_length` writes `target/pictures/arc_length.svg`.

use std::fmt::Write;

use arcfeed_geometry::nalgebra::{Vector2, vector};
use arcfeed_geometry::{ArcLengthCurve, Curve, NurbsCurve};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // A flower in mm: the control points at the petals pull harder than the others, each in its own measure.
    let points: Vec<Vector2<f64>> = (0..=10)
        .map(|i| {
            let angle = f64::from(i) * 0.2 * std::f64::consts::PI;
            let radius = if i % 2 == 1 { 70.0 } else { 15.0 };
            vector![radius * angle.sin(), radius * angle.cos()]
        })
        .collect();
    let weights = vec![1.0, 2.0, 1.0, 4.0, 1.0, 8.0, 1.0, 4.0, 1.0, 2.0, 1.0];
    let mut knots = vec![0.0; 4];
    knots.extend((1..8).map(|i| f64::from(i) / 8.0));
    knots.extend([1.0; 4]);
    let curve = NurbsCurve::new(3, points, weights, knots)?;

    let length = curve.arc_length(1e-12)?;
    let path = ArcLengthCurve::new(curve.clone(), 1e-12)?;
    println!("length {length:.12} mm, map s -> u in {} pieces", path.map_pieces());

    // Steps of a tool that moves by equal steps of u, and of one that moves by equal steps of s.
    let n = 90;
    let by_u: Vec<_> = (0..=n).map(|i| curve.point(f64::from(i) / f64::from(n))).collect();
    let by_s: Vec<_> = (0..=n).map(|i| path.point(length * f64::from(i) / f64::from(n))).collect();
    let parts = |at: &dyn Fn(i32) -> f64| -> Result<(f64, f64), arcfeed_geometry::GeometryError> {
        let (mut least, mut most) = (f64::INFINITY, 0.0f64);
        for i in 0..n {
            let step = curve.arc_length_between(at(i), at(i + 1), 1e-13)?;
            (least, most) = (least.min(step), most.max(step));
        }
        Ok((least, most))
    };
    let (least, most) = parts(&|i| f64::from(i) / f64::from(n))?;
    println!("equal steps of u: the tool moves by {least:.3} to {most:.3} mm");
    let (least, most) = parts(&|i| path.parameter(length * f64::from(i) / f64::from(n)))?;
    println!("equal steps of s: the tool moves by {least:.12} to {most:.12} mm");
    let jet = path.jet(0.25 * length);
    println!("at a quarter: |tangent| = {:.15}, radius {:.3} mm", jet.d1.norm(), 1.0 / jet.d2.norm());

    let mut svg = String::from(
        "<svg xmlns='http://www.w3.org/2000/svg' viewBox='-75 -85 300 160' font-family='sans-serif' font-size='6'>\n\
         <rect x='-75' y='-85' width='300' height='160' fill='white'/>\n",
    );
    for (shift, title, dots, colour) in
        [(0.0, "equal steps of u", &by_u, "#c0392b"), (150.0, "equal steps of arc length", &by_s, "#1f6fb2")]
    {
        let line: Vec<String> = (0..=1500)
            .map(|i| path.point(length * f64::from(i) / 1500.0))
            .map(|p| format!("{:.3},{:.3}", p.x, -p.y))
            .collect();
        writeln!(svg, "<g transform='translate({shift} 0)'><text x='0' y='-74' text-anchor='middle'>{title}</text>")?;
        writeln!(svg, "<polyline points='{}' fill='none' stroke='#ccc' stroke-width='0.6'/>", line.join(" "))?;
        for p in dots {
            writeln!(svg, "<circle cx='{:.3}' cy='{:.3}' r='1.2' fill='{colour}'/>", p.x, -p.y)?;
        }
        svg.push_str("</g>\n");
    }
    svg.push_str("</svg>\n");
    std::fs::create_dir_all("target/pictures")?;
    std::fs::write("target/pictures/arc_length.svg", svg)?;
    println!("target/pictures/arc_length.svg");
    Ok(())
}
