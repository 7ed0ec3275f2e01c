//! One moment of a trajectory, as a controller takes it.

use arcfeed_kinematics::Joints;
use nalgebra::Isometry3;

/// What the joints do at one moment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Setpoint<const N: usize = 6> {
    /// Time since the start, s.
    pub t: f64,
    /// Arc length along the path, m.
    pub s: f64,
    /// Feed rate, m/s.
    pub feed: f64,
    /// Tangential acceleration, m/s^2.
    pub acceleration: f64,
    /// Joint positions, rad.
    pub q: Joints<N>,
    /// Joint velocities, rad/s.
    pub qd: Joints<N>,
    /// Joint accelerations, rad/s^2.
    pub qdd: Joints<N>,
    /// Joint jerks, rad/s^3.
    pub jerk: Joints<N>,
    /// Commanded tool pose in base.
    pub pose: Isometry3<f64>,
}
