//! A tool path with an operator and an event: slower, faster, away into joint space, back, and on from where it was left.
//!
//! `cargo run -p arcfeed-interp --example 04_leave_and_come_back`

use arcfeed_geometry::{ArcLengthCurve, NurbsCurve, OrientationPath, PosePath};
use arcfeed_interp::{
    Command, Excursion, HybridMotion, HybridState, LeaveBy, Limits, MotionPath, Planner, SingularityPolicy, ToolLimits,
    ToolPath,
};
use arcfeed_kinematics::{Joints, models};
use nalgebra::{UnitQuaternion, Vector3, vector};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let curve = NurbsCurve::bspline(
        3,
        vec![
            vector![0.35, -0.15, 0.25],
            vector![0.45, -0.10, 0.22],
            vector![0.50, 0.00, 0.25],
            vector![0.40, 0.08, 0.28],
            vector![0.38, 0.18, 0.25],
        ],
        vec![0.0, 0.0, 0.0, 0.0, 0.5, 1.0, 1.0, 1.0, 1.0],
    )?;
    let down = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI);
    let path = PosePath::new(ArcLengthCurve::new(curve, 1e-15)?, OrientationPath::Constant(down));

    let arm = models::cr7();
    let limits = arm.range().with_rates(Joints::repeat(3.1), Joints::repeat(10.0), Joints::repeat(100.0))?;
    let tool = ToolLimits::new()
        .with_feed(0.15)? // the highest that any override leads to
        .with_tangential_acceleration(1.0)?
        .with_tangential_jerk(20.0)?
        .with_normal_acceleration(1.0)?;
    let path = ToolPath::new(&arm, path, arm.range())?;
    let start = path.start();
    let planner = Planner::new(&arm, Limits::new(limits).with_tool(tool));
    let route = planner.route(&arm, path, SingularityPolicy::GoRound { stall: 0.05 })?;
    let mut motion = HybridMotion::along(&route, 0.1)?;

    let beside = start + Joints::from([0.4, 0.0, 0.0, 0.0, 0.0, 0.0]);
    let park = Excursion::new(&[beside, Joints::from([0.8, 0.2, 1.2, 0.2, -1.5, 0.0])], LeaveBy::AtOnce)?;
    let (mut last, mut waited) = (None, 0);
    for cycle in 0_u64.. {
        waited += u32::from(motion.state() == HybridState::Waiting);
        let command = match cycle {
            800 => Command::Override(0.3),
            1600 => Command::Override(1.5),
            2200 => Command::Leave(park),
            // Once it has waited for half a second.
            _ if motion.state() == HybridState::Waiting && waited > 500 => Command::Return,
            _ => Command::None,
        };
        let step = motion.step(&command);
        if let Some(refused) = step.refused {
            println!("{:8.3} s  refused: {refused}", step.setpoint.t);
        }
        if last != Some(step.state) {
            let now = &step.setpoint;
            println!(
                "{:8.3} s  {:<12} s = {:6.1} mm at {:5.1} mm/s",
                now.t,
                step.state.name(),
                now.s * 1e3,
                now.feed * 1e3
            );
            last = Some(step.state);
        }
        if step.state == HybridState::Done {
            break;
        }
    }
    Ok(())
}
