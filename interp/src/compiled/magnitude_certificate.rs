//! The magnitudes of acceleration and jerk of the tool point, between the samples of a joint trajectory.

use arcfeed_feedrate::Quantity;
use arcfeed_kinematics::ForwardKinematics;

use super::certificate::Motion;
use super::joint_trajectory::JointTrajectory;
use super::reach::{JointRateBounds, Reach};
use super::tool_search::{ToolBound, ToolSearch};

const QUANTITIES: [Quantity; 2] = [Quantity::ToolAcceleration, Quantity::ToolJerk];

impl<const N: usize> JointTrajectory<N> {
    /// Bounds on the magnitudes of acceleration (m/s^2) and jerk (m/s^3) of the tool point of `arm` at all times.
    ///
    /// As [`JointTrajectory::certify_tool`]: between two samples of one piece both vectors are near the straight line between their
    /// values, by the fourth and the fifth derivative of the tool point, which the joints and the reach of the arm bound. The jerk
    /// may jump from piece to piece; both sides count.
    ///
    /// ```
    /// use arcfeed_interp::{Interpolation, JointTrajectory};
    /// use arcfeed_kinematics::{Joints, models};
    ///
    /// // The first joint of a planar arm, stretched out, turns by 1 rad within 1 s.
    /// let arm = models::planar_2r();
    /// let piece = [0.0, 0.0, 0.0, 10.0, -15.0, 6.0].map(|c| Joints::from([c, 0.0]));
    /// let motion = JointTrajectory::from_pieces(vec![0.0, 1.0], vec![piece], Interpolation::Quintic)?;
    /// let [_, jerk] = motion.certify_tool_magnitudes(&arm);
    /// // 60 rad/s^3 at both ends, and the length of the arm.
    /// let length = arcfeed_kinematics::ForwardKinematics::forward(&arm, &Joints::zeros()).translation.vector.norm();
    /// assert!((jerk.attained - 60.0 * length).abs() < 1e-9 && jerk.bound < 60.1 * length);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn certify_tool_magnitudes(&self, arm: &dyn ForwardKinematics<N>) -> [ToolBound; 2] {
        let motion = Motion { times: self.times(), pieces: self.coefficients() };
        let reach = Reach::of(arm, &motion);
        let mut search = ToolSearch::new(motion, |[q, qd, qdd, jerk]| {
            let configuration = arm.configuration(&q);
            let jacobian = configuration.jacobian();
            let change = jacobian * qdd + configuration.acceleration_bias(&qd);
            let third = jacobian * jerk + configuration.jerk_bias(&qd, &qdd);
            ([change, third].map(|twist| twist.fixed_rows::<3>(0).norm()), ())
        });
        let pieces = || (0..self.len()).map(|piece| (piece, JointRateBounds::of(&motion, piece)));
        for (piece, rates) in pieces() {
            let [third, _] = reach.point_rates(&rates);
            let [_, change, _] = reach.largest_rates(&rates);
            search.look(piece, [change, third]);
        }
        for (piece, rates) in pieces() {
            // They bound the second derivatives of both vectors.
            let rates = [reach.point_rates(&rates)[1], reach.fifth_rate(&rates)];
            search.enclose(piece, |a, b| {
                let d = b.tau - a.tau;
                std::array::from_fn(|k| a.sizes[k].max(b.sizes[k]) + 0.125 * d * d * rates[k])
            });
        }
        search.finish(QUANTITIES)
    }
}
