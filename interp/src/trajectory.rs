//! One moment of a trajectory, as a controller takes it.

use arcfeed_kinematics::Joints;
use nalgebra::Isometry3;

use crate::limits::AXES;

/// What the joints do at one moment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Setpoint {
    /// Time since the start, s.
    pub t: f64,
    /// Arc length along the path, m.
    pub s: f64,
    /// Feed rate, m/s.
    pub feed: f64,
    /// Tangential acceleration, m/s^2.
    pub acceleration: f64,
    /// Joint positions, rad.
    pub q: Joints<AXES>,
    /// Joint velocities, rad/s.
    pub qd: Joints<AXES>,
    /// Joint accelerations, rad/s^2.
    pub qdd: Joints<AXES>,
    /// Joint jerks, rad/s^3.
    pub jerk: Joints<AXES>,
    /// Commanded tool pose in base.
    pub pose: Isometry3<f64>,
}
