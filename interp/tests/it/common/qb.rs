//! The arm and the two motions of Quaternion-Based Velocity Scheduling for Robotic Systems (Electronics 2025, 14, 3869).
//!
//! The paper's arm (Delta DRV70L) is not published. In its place stands a synthetic one: geometry and links of the KR 6 R700-2
//! (kroshu/kuka_robot_descriptions, Apache-2.0) with scaled masses and fitted friction and rotors, so that the printed
//! clamps come out approximately; limits are Table 1. Poses: Tables 2 and 3 in the degrees that they round,
//! R = Rz(gamma) Ry(beta) Rx(alpha).
#![allow(dead_code, reason = "every test uses some of it")]

use arcfeed_geometry::PoseMotion;
use arcfeed_interp::Limits;
use arcfeed_kinematics::{Arm, Inertial, JointLimits, Joints, models};
use nalgebra::{Isometry3, Translation3, UnitQuaternion};

pub const VELOCITY: [f64; 6] = [1.02, 0.77, 1.16, 1.25, 1.25, 1.86];
pub const ACCELERATION: [f64; 6] = [3.06, 2.31, 3.47, 3.74, 3.74, 5.5];
pub const TORQUE: [f64; 6] = [44.65, 40.66, 18.95, 9.06, 10.05, 5.69];
pub const COULOMB: [f64; 6] = [33.5, 11.9, 6.4, 6.0, 3.4, 2.3];
pub const VISCOUS: [f64; 6] = [25.3, 12.0, 2.65, 1.5, 3.0, 1.5];
pub const ROTOR: [f64; 6] = [3.0, 0.05, 0.97, 0.14, 0.02, 0.07];
pub const SCALE: f64 = 0.67;

/// Joint values at the start that were used with the reference durations.
pub const PO_NEAR: [f64; 6] = [-0.927, -0.854, 1.722, 0.0, 0.702, 2.214];
pub const TO_NEAR: [f64; 6] = [-1.326, -1.352, 1.956, 0.0, 0.966, 1.990];

pub fn arm() -> Arm<6> {
    arm_with(SCALE, COULOMB, VISCOUS)
}

/// The arm with other masses and friction.
pub fn arm_with(scale: f64, coulomb: [f64; 6], viscous: [f64; 6]) -> Arm<6> {
    let mut description = models::description("kr6_r700").expect("a built-in arm");
    for (i, joint) in description.joints.iter_mut().enumerate() {
        let link = joint.inertial.expect("its links are known");
        let scaled = Inertial::new(link.mass() * scale, *link.centre(), *link.tensor() * scale);
        joint.inertial = Some(scaled.expect("a body stays one"));
        joint.rotor_inertia = Some(ROTOR[i]);
        joint.friction = Some([viscous[i], coulomb[i], coulomb[i]]);
    }
    description.build().expect("six joints")
}

pub fn pose(position: [f64; 3], alpha_beta_gamma_deg: [f64; 3]) -> Isometry3<f64> {
    let [a, b, c] = alpha_beta_gamma_deg.map(f64::to_radians);
    Isometry3::from_parts(Translation3::from(position), UnitQuaternion::from_euler_angles(a, b, c))
}

/// Table 2.
pub fn po() -> PoseMotion {
    let at = [0.3, 0.4, 0.3];
    PoseMotion::new(&pose(at, [180.0, 0.0, 0.0]), &pose(at, [140.0, 55.0, 30.0])).expect("two poses")
}

/// Table 3.
pub fn to() -> PoseMotion {
    PoseMotion::new(&pose([0.1, 0.4, 0.45], [180.0, 0.0, 10.0]), &pose([0.45, -0.35, 0.2], [180.0, 0.0, 25.0]))
        .expect("two poses")
}

/// A limit that no motion of these tests comes to.
pub const FREE: f64 = 1e6;

/// The limits of the joints in Table 1, which names none on jerk.
pub fn joints(arm: &Arm<6>, jerk: f64) -> JointLimits<6> {
    let rates = arm.range().with_rates(Joints::from(VELOCITY), Joints::from(ACCELERATION), Joints::repeat(jerk));
    rates.expect("valid limits")
}

pub fn kinematic(arm: &Arm<6>) -> Limits<'_, 6> {
    Limits::new(joints(arm, FREE))
}

pub fn with_torque(arm: &Arm<6>) -> Limits<'_, 6> {
    kinematic(arm).with_torque(arm.dynamics().expect("known"), Joints::from(TORQUE)).expect("valid limits")
}
