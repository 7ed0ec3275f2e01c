//! Follow a straight line and watch the distance from singular poses: the picture shows the arm along the way, and how
//! fast the joints must move where it comes close to one.
//!
//! `cargo run --release -p arcfeed-kinematics --example 04_line` writes `target/pictures/kinematics_04_line.svg`.

use arcfeed_kinematics::{
    BranchTracker, ForwardKinematics, Joints, MIN_SINGULAR_VALUE, ToolDerivatives, Twist, joint_derivatives, models,
    smallest_singular_value,
};
use nalgebra::{Isometry3, Vector3};
use std::error::Error;
use std::fmt::Write;

const STEPS: usize = 300;
const COLOURS: [&str; 6] = ["#1f77b4", "#ff7f0e", "#2ca02c", "#d62728", "#9467bd", "#8c564b"];

fn main() -> Result<(), Box<dyn Error>> {
    let arm = models::cr7();
    // Tool down, sideways past the base at 0.16 m from axis 1: close to where the shoulder is singular.
    let (start, end): (Vector3<f64>, Vector3<f64>) =
        (Vector3::new(-0.45, -0.16, 0.25), Vector3::new(0.45, -0.16, 0.25));
    let down = nalgebra::UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI);
    let length = (end - start).norm();
    let direction = (end - start) / length;
    let by_s = ToolDerivatives {
        first: Twist::new(direction.x, direction.y, direction.z, 0.0, 0.0, 0.0),
        second: Twist::zeros(),
        third: Twist::zeros(),
    };
    let mut tracker = BranchTracker::new(&arm, Joints::from([-2.5, -0.6, 1.6, 0.5, -1.57, 0.5])).with_max_step(3.0);

    let mut rows = Vec::new();
    for k in 0..=STEPS {
        let s = length * k as f64 / STEPS as f64;
        let q = tracker.next(&Isometry3::from_parts((start + direction * s).into(), down))?;
        let speeds = joint_derivatives(&arm, &q, &by_s, MIN_SINGULAR_VALUE)?.first;
        rows.push((s, q, speeds, smallest_singular_value(&arm.jacobian(&q))));
    }
    let (s, _, speeds, sigma) = rows.iter().min_by(|a, b| a.3.total_cmp(&b.3)).ok_or("the line has no points")?;
    println!("{} points on one branch; closest to a singular pose at s = {s:.3} m:", rows.len());
    println!("smallest singular value {sigma:.4}; at 0.1 m/s the joints move at (deg/s)");
    println!("{}", speeds.iter().map(|v| format!("{:8.1}", (0.1 * v).to_degrees())).collect::<String>());

    let mut svg = String::from(
        "<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 900 760' font-family='sans-serif' font-size='13'>\
         <rect width='900' height='760' fill='white'/>",
    );
    draw_arm(&mut svg, &arm, &rows)?;
    draw_speeds(&mut svg, &rows, length)?;
    svg.push_str("</svg>");
    std::fs::create_dir_all("target/pictures")?;
    std::fs::write("target/pictures/kinematics_04_line.svg", svg)?;
    println!("picture: target/pictures/kinematics_04_line.svg");
    Ok(())
}

type Row = (f64, Joints<6>, Joints<6>, f64);

/// The arm from above-front at a few places, darker where it is closer to a singular pose.
fn draw_arm(svg: &mut String, arm: &dyn ForwardKinematics<6>, rows: &[Row]) -> std::fmt::Result {
    let flat = |p: &Vector3<f64>| (450.0 + 480.0 * p.x - 120.0 * p.y, 350.0 - 420.0 * p.z + 150.0 * p.y);
    write!(svg, "<text x='20' y='30' font-size='17'>CR7 along a straight line, tool down</text>")?;
    let largest = rows.iter().map(|row| row.3).fold(0.0, f64::max);
    for row in rows.iter().step_by(STEPS / 10) {
        let at = arm.configuration(&row.1);
        let points: String = std::iter::once(&Vector3::zeros())
            .chain(at.points())
            .chain([at.position()])
            .map(flat)
            .fold(String::new(), |text, (x, y)| format!("{text}{x:.1},{y:.1} "));
        let opacity = 1.0 - 0.8 * row.3 / largest;
        write!(svg, "<polyline points='{points}' fill='none' stroke='#204a87' stroke-width='7' ")?;
        write!(svg, "stroke-linejoin='round' stroke-linecap='round' opacity='{opacity:.2}'/>")?;
    }
    if let [first, .., last] = rows {
        // The path of the tool, over the arms.
        let mut ends = String::new();
        for row in [first, last] {
            let (x, y) = flat(arm.configuration(&row.1).position());
            write!(ends, "{x:.1},{y:.1} ")?;
        }
        write!(svg, "<polyline points='{ends}' stroke='#cc0000' stroke-width='3'/>")?;
    }
    Ok(())
}

/// Joint speeds per m/s of the tool, and the smallest singular value, over s.
fn draw_speeds(svg: &mut String, rows: &[Row], length: f64) -> std::fmt::Result {
    let (left, top, width, height) = (60.0, 440.0, 800.0, 260.0);
    let fastest = rows.iter().map(|row| row.2.amax()).fold(0.0, f64::max);
    let largest = rows.iter().map(|row| row.3).fold(0.0, f64::max);
    let x = |s: f64| left + width * s / length;
    write!(svg, "<rect x='{left}' y='{top}' width='{width}' height='{height}' fill='none' stroke='#888'/>")?;
    for joint in 0..6 {
        let points = rows.iter().fold(String::new(), |text, row| {
            format!("{text}{:.1},{:.1} ", x(row.0), top + height * 0.5 * (1.0 - row.2[joint] / fastest))
        });
        let colour = COLOURS[joint];
        write!(svg, "<polyline points='{points}' fill='none' stroke='{colour}' stroke-width='2'/>")?;
        let place = left + 70.0 * joint as f64;
        write!(svg, "<text x='{place}' y='728' fill='{colour}'>joint {}</text>", joint + 1)?;
    }
    let points = rows.iter().fold(String::new(), |text, row| {
        format!("{text}{:.1},{:.1} ", x(row.0), top + height * (1.0 - row.3 / largest))
    });
    write!(svg, "<polyline points='{points}' fill='none' stroke='black' stroke-dasharray='6 4' stroke-width='2'/>")?;
    write!(svg, "<text x='500' y='728'>dashed: smallest singular value, 0 to {largest:.3}</text>")?;
    write!(svg, "<text x='{left}' y='{}'>joint speed, +-{fastest:.1} rad/s per m/s of the tool</text>", top - 10.0)?;
    write!(svg, "<text x='{left}' y='750'>s = 0</text><text x='820' y='750'>{length} m</text>")
}
