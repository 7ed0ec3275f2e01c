//! The magnitudes of acceleration and jerk of the tool point, between the samples of a joint trajectory.

use arcfeed_feedrate::Quantity;
use arcfeed_kinematics::ForwardKinematics;

use super::certificate::Motion;
use super::joint_trajectory::JointTrajectory;
use super::piece::evaluate;
use super::reach::{JointRateBounds, Reach};
use super::tool_certificate::{AGREEMENT, LONGEST, MOST_DIVISIONS, NEGLIGIBLE, ROUNDING, ToolBound};

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
        let mut search = Search { arm, motion, largest: [(0.0, 0.0); 2], least: [0.0; 2], bounds: [0.0; 2] };
        for piece in 0..self.len() {
            let rates = JointRateBounds::of(&motion, piece);
            let [third, _] = reach.point_rates(&rates);
            let [_, change, _] = reach.largest_rates(&rates);
            for (least, rate) in search.least.iter_mut().zip([change, third]) {
                *least = least.max(NEGLIGIBLE * rate);
            }
            search.look(piece);
        }
        for piece in 0..self.len() {
            let rates = JointRateBounds::of(&motion, piece);
            search.enclose(piece, [reach.point_rates(&rates)[1], reach.fifth_rate(&rates)]);
        }
        std::array::from_fn(|k| ToolBound {
            quantity: QUANTITIES[k],
            attained: search.largest[k].0,
            t: search.largest[k].1,
            bound: search.bounds[k] * (1.0 + ROUNDING),
        })
    }
}

/// Acceleration and jerk of the tool point at a time since the start of a piece, s.
#[derive(Clone, Copy)]
struct Moment {
    tau: f64,
    sizes: [f64; 2],
}

struct Search<'a, const N: usize> {
    arm: &'a dyn ForwardKinematics<N>,
    motion: Motion<'a, N>,
    /// Largest sizes at samples, and their times.
    largest: [(f64, f64); 2],
    /// Sizes below which a bound is not made closer.
    least: [f64; 2],
    /// Sizes that are not exceeded on the intervals that are done.
    bounds: [f64; 2],
}

impl<const N: usize> Search<'_, N> {
    fn moment(&mut self, piece: usize, tau: f64) -> Moment {
        let [q, qd, qdd, jerk] = evaluate(&self.motion.pieces[piece], tau);
        let configuration = self.arm.configuration(&q);
        let jacobian = configuration.jacobian();
        let change = jacobian * qdd + configuration.acceleration_bias(&qd);
        let third = jacobian * jerk + configuration.jerk_bias(&qd, &qdd);
        let sizes = [change, third].map(|twist| twist.fixed_rows::<3>(0).norm());
        for (largest, size) in self.largest.iter_mut().zip(sizes) {
            if size > largest.0 {
                *largest = (size, self.motion.times[piece] + tau);
            }
        }
        Moment { tau, sizes }
    }

    fn intervals(&self, piece: usize) -> usize {
        (self.motion.duration(piece) / LONGEST).ceil().max(1.0).min(MOST_DIVISIONS as f64) as usize
    }

    /// Samples a piece.
    fn look(&mut self, piece: usize) {
        let (h, n) = (self.motion.duration(piece), self.intervals(piece));
        for i in 0..=n {
            self.moment(piece, h * i as f64 / n as f64);
        }
    }

    /// Divides a piece until its bounds are near the largest sizes found anywhere. `rates` bound the second derivatives of the
    /// quantities.
    fn enclose(&mut self, piece: usize, rates: [f64; 2]) {
        let (h, n) = (self.motion.duration(piece), self.intervals(piece));
        let mut open = Vec::with_capacity(n + 32);
        let mut begin = self.moment(piece, 0.0);
        for i in 1..=n {
            let end = self.moment(piece, h * i as f64 / n as f64);
            open.push((begin, end));
            begin = end;
        }
        let mut divisions = 0;
        while let Some((a, b)) = open.pop() {
            let d = b.tau - a.tau;
            let bounds: [f64; 2] = std::array::from_fn(|k| a.sizes[k].max(b.sizes[k]) + 0.125 * d * d * rates[k]);
            let near = |k: usize| bounds[k] <= (self.largest[k].0 * (1.0 + AGREEMENT)).max(self.least[k]);
            let middle = 0.5 * (a.tau + b.tau);
            if (0..2).all(near) || divisions == MOST_DIVISIONS || !(a.tau < middle && middle < b.tau) {
                for (bound, of) in self.bounds.iter_mut().zip(bounds) {
                    // Not `max`: a NaN bounds nothing.
                    if of > *bound || of.is_nan() {
                        *bound = if of.is_nan() { f64::INFINITY } else { of };
                    }
                }
                continue;
            }
            divisions += 1;
            let middle = self.moment(piece, middle);
            open.push((a, middle));
            open.push((middle, b));
        }
    }
}
