//! A curve of the tool, a motion between poses and way-points of the joints, on three arms, by the same ten lines.
//!
//! `cargo run -p arcfeed-interp --example 05_any_path_any_arm`

use arcfeed_geometry::{ArcLengthCurve, NurbsCurve, OrientationPath, PoseMotion, PosePath};
use arcfeed_interp::nalgebra::{Translation3, UnitQuaternion, Vector3, vector};
use arcfeed_interp::{JointSpline, Limits, LockedArm, MotionPath, PathArm, Planner, PoseMove, ToolLimits, ToolPath};
use arcfeed_kinematics::{AnalyticInverse, Arm, JointRange, Joints, models};

type Failure = Box<dyn std::error::Error>;

/// A curve in front of the arms, tool down.
fn curve() -> Result<PosePath, Failure> {
    let points = vec![vector![0.40, -0.10, 0.30], vector![0.50, 0.00, 0.32], vector![0.40, 0.10, 0.30]];
    let arc = NurbsCurve::bspline(2, points, vec![0.0, 0.0, 0.0, 1.0, 1.0, 1.0])?;
    let down = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI);
    Ok(PosePath::new(ArcLengthCurve::new(arc, 1e-15)?, OrientationPath::Constant(down)))
}

fn plan_all<A, const N: usize>(name: &str, arm: &A, range: &JointRange<N>) -> Result<(), Failure>
where
    A: PathArm<N> + AnalyticInverse<N>,
{
    let joints = range.with_rates(Joints::repeat(2.0), Joints::repeat(8.0), Joints::repeat(100.0))?;
    let tool = ToolLimits::new().with_feed(0.15)?;
    let planner = Planner::new(arm, Limits::new(joints).with_tool(tool));

    let tool_path = ToolPath::new(arm, curve()?, range)?;
    let start = arm.forward(&tool_path.start());
    let motion = PoseMotion::new(&start, &(Translation3::new(0.0, 0.15, 0.05) * start))?;
    let pose_move = PoseMove::starting_near(arm, motion, &tool_path.start())?;
    let there = tool_path.start() + Joints::repeat(0.2);
    let way_points = JointSpline::through(&[tool_path.start(), there, tool_path.start() + Joints::repeat(-0.1)])?;

    let paths: [(&str, &dyn MotionPath<N>); 3] =
        [("tool path", &tool_path), ("pose move", &pose_move), ("way-points", &way_points)];
    for (kind, path) in paths {
        let trajectory = planner.plan(path)?;
        let setpoints = trajectory.setpoints(1e-3)?.collect::<Result<Vec<_>, _>>()?;
        let worst = trajectory.verification().worst();
        println!(
            "{name:<6} {kind:<11} {:.3} s, {} setpoints, {} uses {:.3} % ({})",
            trajectory.duration(),
            setpoints.len(),
            worst.id,
            100.0 * worst.ratio,
            trajectory.info()
        );
    }
    Ok(())
}

fn main() -> Result<(), Failure> {
    let (cr7, ur5e, panda) = (models::cr7(), models::ur5e(), Arm::from(models::panda()));
    plan_all("CR7", &cr7, cr7.range())?;
    plan_all("UR5e", &ur5e, ur5e.range())?;
    // Of seven joints one is held.
    let (locked, _) = LockedArm::for_path(&panda, &curve()?)?;
    plan_all("Panda", &locked, panda.range())
}
