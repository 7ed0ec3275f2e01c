//! Sample arms, so that a first program needs no file.
//!
//! Numbers are the makers' (source and licence at each arm). Acceleration and jerk limits are not published by either
//! maker and depend on the task: add your own with [`JointRange::with_rates`].

use crate::{
    arm::ParallelAxisArm,
    chain::Chain,
    dh::DhRow,
    joint::{Joint, JointRange, Joints},
};
use nalgebra::{Isometry3, Vector3};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Joint speed of the CR7, rad/s, for all joints: 180 deg/s, **assumed** from the maker's catalogue class (the published
/// description holds placeholders).
pub const CR7_VELOCITY: f64 = PI;

/// Joint speed of the UR5e, rad/s, for all joints: 180 deg/s, from the maker's description.
pub const UR5E_VELOCITY: f64 = PI;

/// A planar arm of two revolute joints about z, with links of 0.4 m and 0.3 m along x at zero: an arm to think with.
pub fn planar_2r() -> Chain<2> {
    let joint = |x| Joint::revolute(Isometry3::translation(x, 0.0, 0.0), Vector3::z());
    let build = || Chain::new([joint(0.0)?, joint(0.4)?])?.with_tool(Isometry3::translation(0.3, 0.0, 0.0));
    build().expect("the numbers above are finite")
}

/// Dobot CR7: base to flange, z out of the tool face.
///
/// The zero is the maker's: at q = 0 the arm stands upright. (Universal Robots' zero is at q2 = q4 = pi/2.)
/// Joint range +-6.27 rad, joint 3 +-2.79 rad; for the speed see [`CR7_VELOCITY`].
///
/// Source: github.com/Dobot-Arm/DOBOT_6Axis_ROS2_V4, `dobot_rviz/urdf/cr7_robot.urdf`, commit a1eabef, MIT licence,
/// (c) Dobot. Angles are snapped to multiples of pi/2 and lengths rounded to 1e-5 m, which moves the flange by at most
/// 1.31e-5 m; the range of joint 3 is that of the maker's other description of the arm (TCP-IP-ROS-6AXis).
pub fn cr7() -> ParallelAxisArm {
    let range = Joints::from([6.27, 6.27, 2.79, 6.27, 6.27, 6.27]);
    six_axis(
        [
            DhRow::revolute(0.0, FRAC_PI_2, 0.147, 0.0),
            DhRow::revolute(-0.377, 0.0, 0.0, -FRAC_PI_2),
            DhRow::revolute(-0.307, 0.0, 0.0, 0.0),
            DhRow::revolute(0.0, FRAC_PI_2, 0.141, -FRAC_PI_2),
            DhRow::revolute(0.0, -FRAC_PI_2, 0.116, 0.0),
            DhRow::revolute(0.0, 0.0, 0.105, 0.0),
        ],
        range,
    )
}

/// Universal Robots UR5e: controller's base to flange (tool0), z out of the tool face.
///
/// The base is the controller's, turned by pi about z against the `base_link` of ROS. Joint range +-2 pi, joint 3 +-pi
/// (the description's own narrowing); for the speed see [`UR5E_VELOCITY`].
///
/// Source: github.com/UniversalRobots/Universal_Robots_ROS2_Description, `config/ur5e`, commit 2221ec0, BSD-3-Clause.
/// Calibration residues of 2e-11 m and angles of 1.570796327 are rounded to exact values.
pub fn ur5e() -> ParallelAxisArm {
    let range = Joints::from([TAU, TAU, PI, TAU, TAU, TAU]);
    six_axis(
        [
            DhRow::revolute(0.0, FRAC_PI_2, 0.1625, 0.0),
            DhRow::revolute(-0.425, 0.0, 0.0, 0.0),
            DhRow::revolute(-0.3922, 0.0, 0.0, 0.0),
            DhRow::revolute(0.0, FRAC_PI_2, 0.1333, 0.0),
            DhRow::revolute(0.0, -FRAC_PI_2, 0.0997, 0.0),
            DhRow::revolute(0.0, 0.0, 0.0996, 0.0),
        ],
        range,
    )
}

fn six_axis(rows: [DhRow; 6], range: Joints<6>) -> ParallelAxisArm {
    let build = || ParallelAxisArm::new(Chain::from_dh(&rows)?, JointRange::new(-range, range)?);
    build().expect("the tables above are of arms with three parallel axes")
}
