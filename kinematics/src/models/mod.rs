//! Sample arms, so that a first program needs no file.
//!
//! Numbers are the makers' (source and licence at each arm). Acceleration and jerk limits are not published by either
//! maker and depend on the task: add your own with [`JointRange::with_rates`].

#[cfg(feature = "std")]
mod described;
// Without descriptions some of the tables are not read.
#[cfg_attr(not(feature = "std"), allow(dead_code))]
mod tables;

#[cfg(feature = "std")]
pub use described::{NAMES, description};

use crate::{
    chain::Chain,
    closed_form::{ParallelAxisArm, SphericalWristArm},
    dh::DhRow,
    joint::{Joint, JointRange, Joints},
    numeric::NumericArm,
};
use nalgebra::{Isometry3, UnitQuaternion, Vector3};
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
            [0.0, FRAC_PI_2, 0.147, 0.0],
            [-0.377, 0.0, 0.0, -FRAC_PI_2],
            [-0.307, 0.0, 0.0, 0.0],
            [0.0, FRAC_PI_2, 0.141, -FRAC_PI_2],
            [0.0, -FRAC_PI_2, 0.116, 0.0],
            [0.0, 0.0, 0.105, 0.0],
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
            [0.0, FRAC_PI_2, 0.1625, 0.0],
            [-0.425, 0.0, 0.0, 0.0],
            [-0.3922, 0.0, 0.0, 0.0],
            [0.0, FRAC_PI_2, 0.1333, 0.0],
            [0.0, -FRAC_PI_2, 0.0997, 0.0],
            [0.0, 0.0, 0.0996, 0.0],
        ],
        range,
    )
}

/// KUKA KR 6 R700-2 (Agilus): base to flange (tool0), z out of the tool face.
///
/// Source: github.com/kroshu/kuka_robot_descriptions, `kuka_agilus_support`, commit 7766e92, Apache-2.0; its readme marks
/// this model as verified. Joint ranges are the source's.
pub fn kr6_r700() -> SphericalWristArm {
    let build = || {
        let joint = |row: &tables::Row| Joint::revolute(frame(&row.origin), Vector3::z());
        let rows = &tables::KR6_R700.joints;
        let mut joints = [joint(&rows[0])?; 6];
        for (joint_at, row) in joints.iter_mut().zip(rows.iter()) {
            *joint_at = joint(row)?;
        }
        let chain = Chain::new(joints)?.with_flange(frame(&tables::KR6_R700.flange))?;
        let end = |which: usize| Joints::from_fn(|i, _| rows[i].range[which]);
        SphericalWristArm::new(chain, JointRange::new(end(0), end(1))?)
    };
    build().expect("the table is of an arm with a spherical wrist")
}

/// Unimation Puma 560: base to the **wrist centre**, as in its source; the mounting face is 0.05625 m further along z.
///
/// Source: Corke and Armstrong-Helouvry, ICRA 1994, as in github.com/petercorke/robotics-toolbox-python,
/// `models/DH/Puma560.py`, commit a9ed8d4, MIT. Joint ranges are the source's.
pub fn puma560() -> SphericalWristArm {
    let rows = [
        [0.0, FRAC_PI_2, 0.67183, 0.0],
        [0.4318, 0.0, 0.0, 0.0],
        [0.0203, -FRAC_PI_2, 0.15005, 0.0],
        [0.0, FRAC_PI_2, 0.4318, 0.0],
        [0.0, -FRAC_PI_2, 0.0, 0.0],
        [0.0, 0.0, 0.0, 0.0],
    ];
    let range = Joints::from([160.0_f64, 110.0, 135.0, 266.0, 100.0, 266.0].map(f64::to_radians));
    let build = || SphericalWristArm::new(Chain::from_dh(&revolute(rows))?, JointRange::new(-range, range)?);
    build().expect("the table above is of an arm with a spherical wrist")
}

/// Franka Emika Panda, seven joints: base to flange (link 8), z out of the mounting face.
///
/// Source: github.com/frankaemika/franka_ros, `franka_description`, commit c11f000, Apache-2.0. Joint ranges are the
/// source's; joint 4 cannot be stretched out.
pub fn panda() -> NumericArm<7> {
    let rows = [
        [0.0, 0.0, 0.333, 0.0],
        [0.0, -FRAC_PI_2, 0.0, 0.0],
        [0.0, FRAC_PI_2, 0.316, 0.0],
        [0.0825, FRAC_PI_2, 0.0, 0.0],
        [-0.0825, -FRAC_PI_2, 0.384, 0.0],
        [0.0, FRAC_PI_2, 0.0, 0.0],
        [0.088, FRAC_PI_2, 0.0, 0.0],
    ];
    let lower = Joints::from([-2.8973, -1.7628, -2.8973, -3.0718, -2.8973, -0.0175, -2.8973]);
    let upper = Joints::from([2.8973, 1.7628, 2.8973, -0.0698, 2.8973, 3.7525, 2.8973]);
    let build = || {
        let chain = Chain::from_modified_dh(&revolute(rows))?.with_flange(Isometry3::translation(0.0, 0.0, 0.107))?;
        Ok::<_, crate::KinematicsError>(NumericArm::new(chain, JointRange::new(lower, upper)?))
    };
    build().expect("the numbers above are finite")
}

/// A frame from xyz (m) and fixed-axis roll, pitch, yaw (rad).
fn frame(numbers: &[f64; 6]) -> Isometry3<f64> {
    let [x, y, z, roll, pitch, yaw] = *numbers;
    Isometry3::from_parts([x, y, z].into(), UnitQuaternion::from_euler_angles(roll, pitch, yaw))
}

/// Rows of revolute joints from their a (m), alpha (rad), d (m) and theta (rad).
fn revolute<const N: usize>(rows: [[f64; 4]; N]) -> [DhRow; N] {
    rows.map(|[a, alpha, d, theta]| DhRow::revolute(a, alpha, d, theta))
}

fn six_axis(rows: [[f64; 4]; 6], range: Joints<6>) -> ParallelAxisArm {
    let build = || ParallelAxisArm::new(Chain::from_dh(&revolute(rows))?, JointRange::new(-range, range)?);
    build().expect("the tables above are of arms with three parallel axes")
}
