//! Draws the time of a square of 100 mm on the CR7 against the tolerance of its corners: `03_blend_times [FOLDER, else target/pictures]`.
//!
//! Three lines: the time under all limits; the time along the same paths when no limit on jerk holds, of the joints or of the tool; and
//! the time of one straight motion of the same length under the tool's limits along the path, which no motion along the path can beat.

use std::f64::consts::PI;
use std::path::Path;

use arcfeed_feedrate::{AxisLimits, MotionLaw, SProfile};
use arcfeed_geometry::{ArcLengthCurve, Blending, JoinedPathBuilder, OrientationPath, PosePath};
use arcfeed_interp::{Limits, Method, Planner, ToolLimits, ToolPath};
use arcfeed_kinematics::{Joints, models};
use nalgebra::{UnitQuaternion, Vector3};
use robot_cr7::plot::{Line, lines_picture, save_picture};
use robot_cr7::{ACCELERATION, JERK, VELOCITY};

/// mm.
const TOLERANCES: [f64; 11] = [0.0, 0.01, 0.03, 0.1, 0.25, 0.5, 1.0, 2.0, 3.0, 4.0, 5.0];
/// m/s, m/s^2, m/s^3.
const FEED: f64 = 0.1;
const TANGENTIAL: [f64; 2] = [1.0, 20.0];
const NORMAL: f64 = 1.0;

type Failure = Box<dyn std::error::Error>;

fn main() -> Result<(), Failure> {
    let folder = std::env::args().nth(1).unwrap_or_else(|| "target/pictures".to_owned());
    std::fs::create_dir_all(&folder)?;
    let mut lines: [Vec<(f64, f64)>; 3] = Default::default();
    println!("tolerance, mm | all limits, s | no limit on jerk, s | without corners, s");
    for tolerance in TOLERANCES {
        let times = times(1e-3 * tolerance)?;
        println!("{tolerance} | {:.4} | {:.4} | {:.4}", times[0], times[1], times[2]);
        lines.iter_mut().zip(times).for_each(|(line, time)| line.push((tolerance, time)));
    }
    let names = ["all limits", "without limits on jerk", "one straight motion of the same length"];
    let facts = format!(
        "{} mm/s, {} m/s^2 along and across, {} m/s^3 along; joints 180 deg/s, {ACCELERATION} rad/s^2, {JERK} rad/s^3; dashed: a stop in each corner",
        1e3 * FEED,
        TANGENTIAL[0],
        TANGENTIAL[1]
    );
    let drawn: Vec<Line> = names.iter().zip(&lines).map(|(&name, points)| Line { name, points }).collect();
    let labels = ("tolerance of the corners [mm]", "time [s]");
    let svg = lines_picture("A square of 100 mm on the CR7", &facts, labels, &drawn, &[lines[0][0].1])?;
    save_picture(&Path::new(&folder).join("blend_times.svg"), &svg)?;
    Ok(())
}

/// The three times, s.
fn times(tolerance: f64) -> Result<[f64; 3], Failure> {
    let at = |x: f64, y: f64| Vector3::new(0.42 + x, y, 0.15);
    let mut square = JoinedPathBuilder::new(at(0.0, 0.0), 1e-9)?;
    for (line, (x, y)) in [(0.1, 0.0), (0.1, 0.1), (0.0, 0.1), (0.0, 0.0)].into_iter().enumerate() {
        square.line_to(at(x, y), line)?;
    }
    let path = square.build()?.blended(&Blending::within(tolerance))?.path;
    let arm = models::cr7();
    let rates = [VELOCITY, ACCELERATION, JERK].map(Joints::repeat);
    let range = arm.range().with_rates(rates[0], rates[1], rates[2])?;
    let down = UnitQuaternion::from_euler_angles(PI, 0.0, 0.0);
    let path = PosePath::new(ArcLengthCurve::new(path.to_curve()?, 1e-15)?, OrientationPath::Constant(down));
    let path = ToolPath::new(&arm, path, range.range())?;
    let tool = ToolLimits::new()
        .with_feed(FEED)?
        .with_tangential_acceleration(TANGENTIAL[0])?
        .with_tangential_jerk(TANGENTIAL[1])?
        .with_normal_acceleration(NORMAL)?;
    let planner = Planner::new(&arm, Limits::new(range).with_tool(tool));
    let [all, free] = [Method::JerkLimited, Method::Reachability]
        .map(|method| planner.clone().with_method(method).plan(&path).map(|plan| plan.duration()));
    let length = path.pose_path().curve().length();
    let straight = SProfile::new(length, 0.0, 0.0, &AxisLimits::symmetric(FEED, TANGENTIAL[0], TANGENTIAL[1])?)?;
    Ok([all?, free?, straight.duration()])
}
