//! Points for controllers that interpolate by quintics, such as ROS 2's joint trajectory controller.

use arcfeed_kinematics::{JointRange, Joints};

use super::error::JointTrajectoryError;
use super::joint_trajectory::{Interpolation, JointTrajectory};
use super::piece::{State, quintic};
use crate::verify::JointRates;

/// How much slower the points may become so that every limit holds with times in whole nanoseconds, the first that does.
const SLOWER: [f64; 5] = [0.0, 1e-7, 1e-6, 1e-5, 1e-4];
/// Certified ratios may exceed 1 by this much, as those of the trajectory itself.
const TOLERANCE: f64 = 1e-6;

/// Position, velocity and acceleration of all joints at a time in whole nanoseconds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointPoint<const N: usize = 6> {
    /// Time since the start, ns.
    pub nanoseconds: u64,
    /// Positions, rad.
    pub q: Joints<N>,
    /// Velocities, rad/s.
    pub qd: Joints<N>,
    /// Accelerations, rad/s^2.
    pub qdd: Joints<N>,
}

impl<const N: usize> JointTrajectory<N> {
    /// Points between which quintics are this trajectory to rounding: one at each border of two pieces, at whole nanoseconds.
    ///
    /// What a controller makes of them keeps the limits, which is certified. Where the rounding of the times costs a limit, all is slower
    /// by up to 1e-4. `None` where that does not suffice, or where this trajectory itself does not keep them.
    ///
    /// ```
    /// use arcfeed_interp::{Interpolation, JointRates, JointTrajectory};
    /// use arcfeed_kinematics::{JointRange, Joints};
    ///
    /// // One joint from 0 to 1 rad in 1 s: q = 10 t^3 - 15 t^4 + 6 t^5.
    /// let piece = [0.0, 0.0, 0.0, 10.0, -15.0, 6.0].map(Joints::<1>::repeat);
    /// let motion = JointTrajectory::from_pieces(vec![0.0, 1.0], vec![piece], Interpolation::Quintic)?;
    /// let range = JointRange::new(Joints::repeat(-2.0), Joints::repeat(2.0))?;
    /// let rates = [2.0, 6.0, 60.0].map(Joints::<1>::repeat);
    /// let rates = JointRates { velocity: rates[0], acceleration: rates[1], jerk: rates[2] };
    /// let points = motion.points(&range, &rates).ok_or("a limit is exceeded")?;
    /// assert_eq!((points.len(), points[1].nanoseconds, points[1].q[0]), (2, 1_000_000_000, 1.0));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn points(&self, range: &JointRange<N>, rates: &JointRates<N>) -> Option<Vec<JointPoint<N>>> {
        SLOWER.into_iter().find_map(|slower| {
            let points = self.points_at(1.0 + slower);
            let between = Self::through(&points).ok()?;
            between.certify(range, rates).holds(TOLERANCE).then_some(points)
        })
    }

    /// The trajectory of a controller that interpolates `points` by quintics. The first is at time 0.
    ///
    /// # Errors
    /// As [`JointTrajectory::from_pieces`].
    pub fn through(points: &[JointPoint<N>]) -> Result<Self, JointTrajectoryError> {
        let times: Vec<f64> = points.iter().map(|point| point.nanoseconds as f64 * 1e-9).collect();
        let state = |point: &JointPoint<N>| State { q: point.q, qd: point.qd, qdd: point.qdd };
        let piece = |i: usize| quintic(&state(&points[i]), &state(&points[i + 1]), times[i + 1] - times[i]);
        let pieces = (0..points.len().saturating_sub(1)).map(piece).collect();
        Self::from_pieces(times, pieces, Interpolation::Quintic)
    }

    /// The points of this trajectory with all times multiplied by `slow`.
    fn points_at(&self, slow: f64) -> Vec<JointPoint<N>> {
        let mut points: Vec<JointPoint<N>> = Vec::with_capacity(self.times().len());
        for &t in self.times() {
            let nanoseconds = (t * slow * 1e9).round() as u64;
            if points.last().is_some_and(|last| last.nanoseconds >= nanoseconds) {
                continue;
            }
            // The state at the rounded time, so that the motion between two points stays the same.
            let at = self.at(nanoseconds as f64 * 1e-9 / slow);
            points.push(JointPoint { nanoseconds, q: at.q, qd: at.qd / slow, qdd: at.qdd / (slow * slow) });
        }
        // The end is the end, whatever its time is rounded to.
        if let Some(last) = points.last_mut() {
            let end = self.at(self.duration());
            (last.q, last.qd, last.qdd) = (end.q, end.qd / slow, end.qdd / (slow * slow));
        }
        points
    }
}
