//! One curve cut by three methods into pieces that keep a chord tolerance, with a picture.
//!
//! `cargo run -p arcfeed-geometry --example 02_segment` writes `target/pictures/segments.svg`.

use std::fmt::Write as _;

use arcfeed_geometry::{Curve, NurbsCurve, Segmentation, SegmentationMethod, nalgebra::vector};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // A clover of four leaves, in mm: a closed cubic with weights.
    let count = 24;
    let mut points: Vec<_> = (0..count)
        .map(|i| {
            let a = f64::from(i) / f64::from(count) * std::f64::consts::TAU;
            let r = if i % 6 == 3 { 12.0 } else { 26.0 + 14.0 * (4.0 * a).cos() };
            vector![r * a.cos(), r * a.sin()]
        })
        .collect();
    points.push(points[0]);
    let weights = (0..points.len()).map(|i| if i % 3 == 0 { 2.0 } else { 1.0 }).collect();
    let spans = points.len() - 3;
    let mut knots = vec![0.0; 4];
    knots.extend((1..spans).map(|i| i as f64 / spans as f64));
    knots.extend([1.0; 4]);
    let curve = NurbsCurve::new(3, points, weights, knots)?;

    let tolerance = 0.1;
    let methods = [
        ("control polygon, halving", SegmentationMethod::Hull),
        ("C-type pieces, halving", SegmentationMethod::CType),
        ("longest pieces", SegmentationMethod::Greedy { across_knots: false }),
        ("longest, across knots", SegmentationMethod::Greedy { across_knots: true }),
    ];
    let mut svg = String::new();
    writeln!(
        svg,
        "<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 420 118' width='1680' height='472' \
         font-family='sans-serif'><rect width='420' height='118' fill='#fcfcfa'/>"
    )?;
    println!("chord tolerance {tolerance} mm");
    for (i, (name, method)) in methods.into_iter().enumerate() {
        let pieces = curve.segment(method, tolerance)?;
        println!("{name:26} {:4} pieces, largest deviation {:.6} mm", pieces.len(), pieces.max_deviation());
        draw(&mut svg, &curve, &pieces, name, 52.5 + 105.0 * i as f64)?;
    }
    svg.push_str("</svg>\n");
    std::fs::create_dir_all("target/pictures")?;
    std::fs::write("target/pictures/segments.svg", svg)?;
    println!("wrote target/pictures/segments.svg");
    Ok(())
}

/// The pieces in alternating colours, the darker the nearer their deviation comes to the tolerance.
fn draw(
    svg: &mut String,
    curve: &NurbsCurve<2>,
    pieces: &Segmentation,
    name: &str,
    x: f64,
) -> Result<(), std::fmt::Error> {
    writeln!(svg, "<g transform='translate({x} 52) scale(1 -1)'>")?;
    for (i, (u0, u1, deviation)) in pieces.pieces().enumerate() {
        let hue = [205, 18, 140][i % 3];
        let lightness = 72.0 - 34.0 * deviation / pieces.tolerance();
        let line: String = (0..=12)
            .map(|j| curve.point(u0 + (u1 - u0) * f64::from(j) / 12.0))
            .fold(String::new(), |line, p| line + &format!("{:.3},{:.3} ", p.x, p.y));
        writeln!(
            svg,
            "<polyline points='{line}' fill='none' stroke='hsl({hue} 75% {lightness:.0}%)' stroke-width='1.1'/>"
        )?;
    }
    for p in pieces.points(curve) {
        writeln!(svg, "<circle cx='{:.3}' cy='{:.3}' r='0.75' fill='#222'/>", p.x, p.y)?;
    }
    writeln!(
        svg,
        "</g><text x='{x}' y='107' font-size='5' text-anchor='middle'>{name}</text>\
         <text x='{x}' y='113.5' font-size='5' text-anchor='middle' fill='#555'>{} pieces, {:.4} mm</text>",
        pieces.len(),
        pieces.max_deviation()
    )
}
