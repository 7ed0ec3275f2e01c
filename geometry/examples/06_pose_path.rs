//! A tool path with orientation: a wave that the tool follows with its x axis, or tilts along through given keys.
//!
//! `cargo run -p arcfeed-geometry --example 06_pose_path` writes `target/pictures/pose_path.svg`.

use std::fmt::Write;

use arcfeed_geometry::nalgebra::{UnitQuaternion, Vector3, vector};
use arcfeed_geometry::{ArcLengthCurve, NurbsCurve, OrientationPath, PosePath};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // In metres.
    let points = (0..9).map(|i| {
        let x = f64::from(i);
        vector![0.05 * x, if i % 2 == 0 { 0.06 } else { -0.06 }, 0.1 + 0.01 * x]
    });
    let knots = vec![0.0, 0.0, 0.0, 0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 6.0, 6.0, 6.0];
    let curve = ArcLengthCurve::new(NurbsCurve::bspline(3, points.collect(), knots)?, 1e-13)?;
    let length = curve.length();

    let tangent = curve.jet(0.0).d1;
    let start = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), tangent.y.atan2(tangent.x));
    let following = OrientationPath::following_tangent(&curve, Vector3::z_axis(), start, 1e-6)?;
    if let OrientationPath::Heading(heading) = &following {
        println!("heading within {:.1e} rad of the tangent", heading.deviation());
    }
    let turn = |angle: f64| UnitQuaternion::from_axis_angle(&Vector3::z_axis(), angle);
    let keys = [(0.0, turn(0.0)), (0.3 * length, turn(2.0)), (0.6 * length, turn(4.0)), (length, turn(2.0 * 3.2))];
    let through = OrientationPath::through(&keys)?;

    let mut svg = String::from(
        "<svg xmlns='http://www.w3.org/2000/svg' viewBox='-40 -80 480 300' font-family='sans-serif' font-size='12'>\n\
         <rect x='-40' y='-80' width='480' height='300' fill='white'/>\n",
    );
    for (shift, title, orientation) in
        [(0.0, "following the tangent", following), (150.0, "through four keys", through)]
    {
        let path = PosePath::new(curve.clone(), orientation);
        let fastest = (0..=1000)
            .map(|i| path.jet(length * f64::from(i) / 1000.0).d1.fixed_rows::<3>(3).norm())
            .fold(0.0, f64::max);
        println!("{title}: {} knots, turns by up to {fastest:.1} rad/m", path.knots().len());
        writeln!(svg, "<g transform='translate(0 {shift})'><text x='30' y='-60'>{title}</text>")?;
        let line: Vec<String> = (0..=600)
            .map(|i| path.pose(length * f64::from(i) / 600.0).translation.vector * 1e3)
            .map(|p| format!("{:.2},{:.2}", p.x, -p.y))
            .collect();
        writeln!(svg, "<polyline points='{}' fill='none' stroke='#bbb' stroke-width='1.5'/>", line.join(" "))?;
        for i in 0..=48 {
            // The tool's x axis in red, its y axis in green.
            let pose = path.pose(length * f64::from(i) / 48.0);
            let p = pose.translation.vector * 1e3;
            for (axis, colour) in [(Vector3::x(), "#c0392b"), (Vector3::y(), "#27935a")] {
                let tip = p + pose.rotation * axis * 14.0;
                writeln!(
                    svg,
                    "<line x1='{:.2}' y1='{:.2}' x2='{:.2}' y2='{:.2}' stroke='{colour}' stroke-width='1.6'/>",
                    p.x, -p.y, tip.x, -tip.y
                )?;
            }
        }
        svg.push_str("</g>\n");
    }
    svg.push_str("</svg>\n");
    std::fs::create_dir_all("target/pictures")?;
    std::fs::write("target/pictures/pose_path.svg", svg)?;
    println!("target/pictures/pose_path.svg");
    Ok(())
}
