//! One sample of a joint motion, as it is written and checked.

use arcfeed_interp::{JointSample, Setpoint};
use arcfeed_kinematics::Joints;
use nalgebra::Isometry3;

/// One sample of a joint trajectory with the pose of the tool tip in the base frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrajectoryRow<const N: usize = 6> {
    /// Time in s.
    pub t: f64,
    /// Joint positions in rad.
    pub q: [f64; N],
    /// Joint velocities in rad/s.
    pub qd: [f64; N],
    /// Joint accelerations in rad/s^2.
    pub qdd: [f64; N],
    /// Joint jerks in rad/s^3.
    pub jerk: [f64; N],
    /// Tool tip in m.
    pub position: [f64; 3],
    /// Tool orientation as a unit quaternion x, y, z, w.
    pub quaternion: [f64; 4],
}

impl<const N: usize> TrajectoryRow<N> {
    /// The row of a time (s), of position, velocity, acceleration and jerk of the joints, and of the tool pose.
    pub fn new(t: f64, joints: [&Joints<N>; 4], tool: &Isometry3<f64>) -> Self {
        let [q, qd, qdd, jerk] = joints.map(|values| (*values).into());
        let r = tool.rotation.quaternion();
        Self { t, q, qd, qdd, jerk, position: tool.translation.vector.into(), quaternion: [r.i, r.j, r.k, r.w] }
    }
}

impl<const N: usize> From<&TrajectoryRow<N>> for JointSample<N> {
    fn from(row: &TrajectoryRow<N>) -> Self {
        Self { t: row.t, q: row.q.into(), qd: row.qd.into(), qdd: row.qdd.into() }
    }
}

impl<const N: usize> From<&Setpoint<N>> for TrajectoryRow<N> {
    fn from(at: &Setpoint<N>) -> Self {
        Self::new(at.t, [&at.q, &at.qd, &at.qdd, &at.jerk], &at.pose)
    }
}
