//! What the tool does between the samples of a joint trajectory.

use arcfeed_feedrate::Quantity;
use arcfeed_kinematics::{ForwardKinematics, Twist};
use nalgebra::Vector3;

use super::certificate::Motion;
use super::joint_trajectory::JointTrajectory;
use super::reach::{JointRateBounds, Reach};
use super::tool_search::{Moment, ToolBound, ToolSearch};

/// The quantities, in the order of the values of a moment.
const QUANTITIES: [Quantity; 4] =
    [Quantity::Feed, Quantity::AngularSpeed, Quantity::TangentialAcceleration, Quantity::NormalAcceleration];

/// Bounds on the motion of a tool that a joint trajectory moves, at all times; see [`JointTrajectory::certify_tool`].
#[derive(Debug, Clone, PartialEq)]
pub struct ToolCertificate {
    bounds: [ToolBound; 4],
    deviation: Option<[f64; 2]>,
}

impl ToolCertificate {
    /// Feed, angular speed, tangential and normal acceleration.
    pub fn bounds(&self) -> &[ToolBound] {
        &self.bounds
    }

    /// The bound of one of these quantities.
    pub fn of(&self, quantity: Quantity) -> Option<&ToolBound> {
        self.bounds.iter().find(|bound| bound.quantity == quantity)
    }

    /// The distance of the tool point from where the plan has it at the same time, m, and the angle between both orientations, rad,
    /// that are not exceeded; `None` for a motion without a plan. They follow from [`Deviation::bound`](crate::Deviation::bound) and
    /// the reach of the arm.
    pub fn deviation(&self) -> Option<[f64; 2]> {
        self.deviation
    }
}

impl<const N: usize> JointTrajectory<N> {
    /// Bounds on the motion of the tool of `arm` at all times, from samples and from what can lie between two of them.
    ///
    /// Between two samples the derivatives of the tool are bounded by those of the joints on the piece and by the reach of each joint.
    /// Intervals are divided until the bound is within 1e-3 of the largest size at a sample, or within 1e-4 of what the joints could
    /// do. Where the tool comes to rest at once and turns back, the direction of its motion is unknown, and both accelerations are
    /// bounded by the size of the whole. The lengths between the axes of the arm have to be constant, as they are for an arm whose
    /// joints turn, or known from the joints that slide.
    ///
    /// ```
    /// use arcfeed_interp::{Interpolation, JointTrajectory, Quantity};
    /// use arcfeed_kinematics::{Joints, models};
    ///
    /// // The first joint of a planar arm, stretched out, turns by 1 rad within 1 s.
    /// let arm = models::planar_2r();
    /// let piece = [0.0, 0.0, 0.0, 10.0, -15.0, 6.0].map(|c| Joints::from([c, 0.0]));
    /// let motion = JointTrajectory::from_pieces(vec![0.0, 1.0], vec![piece], Interpolation::Quintic)?;
    /// let tool = motion.certify_tool(&arm);
    /// let turning = tool.of(Quantity::AngularSpeed).expect("is bounded");
    /// assert!(turning.bound >= 1.875 && turning.bound < 1.88 && (turning.t - 0.5).abs() < 0.02);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn certify_tool(&self, arm: &dyn ForwardKinematics<N>) -> ToolCertificate {
        let motion = Motion { times: self.times(), pieces: self.coefficients() };
        let reach = Reach::of(arm, &motion);
        let mut search = ToolSearch::new(motion, |[q, qd, qdd, _]| {
            let configuration = arm.configuration(&q);
            let jacobian = configuration.jacobian();
            sizes_of(jacobian * qd, jacobian * qdd + configuration.acceleration_bias(&qd))
        });
        let pieces = || (0..self.len()).map(|piece| (piece, JointRateBounds::of(&motion, piece)));
        for (piece, rates) in pieces() {
            let [point, change, turning] = reach.largest_rates(&rates);
            search.look(piece, [point, turning, change, change]);
        }
        for (piece, rates) in pieces() {
            let [third, fourth] = reach.point_rates(&rates);
            let rates = [third, fourth, reach.turning_rate(&rates)];
            search.enclose(piece, |a, b| bounds_between(a, b, rates));
        }
        let deviation = self.deviation().map(|deviation| reach.per_unit().map(|moved| moved * deviation.bound));
        ToolCertificate { bounds: search.finish(QUANTITIES), deviation }
    }

    /// Bounds on the feed of the tool between two times (s) each.
    pub(super) fn certify_feeds(&self, arm: &dyn ForwardKinematics<N>, stretches: &[[f64; 2]]) -> Vec<ToolBound> {
        let motion = Motion { times: self.times(), pieces: self.coefficients() };
        let reach = Reach::of(arm, &motion);
        let one = |&[from, to]: &[f64; 2]| {
            let mut search = ToolSearch::new(motion, |[q, qd, _, _]| {
                let twist: Twist = arm.configuration(&q).jacobian() * qd;
                ([twist.fixed_rows::<3>(0).norm()], ())
            });
            // What begins where the motion ends is bounded at its last moment.
            let last = self.len().saturating_sub(1);
            let first = self.times().partition_point(|t| *t <= from).saturating_sub(1).min(last);
            let pieces = (first..self.len()).take_while(|&piece| piece == first || self.times()[piece] < to);
            let of = |piece: usize| {
                let (begin, h) = (self.times()[piece], motion.duration(piece));
                let within = [from, to].map(|t| (t - begin).max(0.0).min(h));
                (piece, within, JointRateBounds::of(&motion, piece))
            };
            for (piece, within, rates) in pieces.clone().map(of) {
                let [point, ..] = reach.largest_rates(&rates);
                search.look_within(piece, within, [point]);
            }
            for (piece, within, rates) in pieces.map(of) {
                let [third, _] = reach.point_rates(&rates);
                search.enclose_within(piece, within, |a, b| {
                    let d = b.tau - a.tau;
                    [a.sizes[0].max(b.sizes[0]) + 0.125 * d * d * third]
                });
            }
            let [feed] = search.finish([Quantity::Feed]);
            feed
        };
        stretches.iter().map(one).collect()
    }
}

/// Velocity and acceleration of the tool point.
#[derive(Clone, Copy)]
struct PointRates {
    velocity: Vector3<f64>,
    acceleration: Vector3<f64>,
}

/// The sizes of [`QUANTITIES`], from the twist of the tool and its derivative by time.
fn sizes_of(twist: Twist, change: Twist) -> ([f64; 4], PointRates) {
    let velocity: Vector3<f64> = twist.fixed_rows::<3>(0).into();
    let acceleration: Vector3<f64> = change.fixed_rows::<3>(0).into();
    let direction = velocity.try_normalize(0.0).unwrap_or_else(Vector3::zeros);
    let tangential = acceleration.dot(&direction);
    let normal = (acceleration - direction * tangential).norm();
    let [speed, turning] = [velocity.norm(), twist.fixed_rows::<3>(3).norm()];
    // At rest the acceleration has no parts.
    let parts = if speed > 0.0 { [tangential.abs(), normal] } else { [0.0; 2] };
    ([speed, turning, parts[0], parts[1]], PointRates { velocity, acceleration })
}

/// Bounds of [`QUANTITIES`] between two moments of one piece, from bounds on the third and fourth derivative of the tool point and on
/// the second derivative of its angular velocity.
fn bounds_between(
    a: &Moment<PointRates, 4>,
    b: &Moment<PointRates, 4>,
    [third, fourth, turning]: [f64; 3],
) -> [f64; 4] {
    let d = b.tau - a.tau;
    let curved = |second: f64| 0.125 * d * d * second;
    let larger = |k: usize| a.sizes[k].max(b.sizes[k]);
    let feed = larger(0) + curved(third);
    let angular = larger(1) + curved(turning);
    let acceleration = a.data.acceleration.norm().max(b.data.acceleration.norm()) + curved(fourth);
    let slowest = distance_of_line([a.data.velocity, b.data.velocity]) - curved(third);
    if slowest <= 0.0 {
        return [feed, angular, acceleration, acceleration];
    }
    // How fast the direction of the motion turns.
    let turn = acceleration / slowest;
    let tangential = larger(2) + 0.5 * d * (third + turn * acceleration);
    let normal = larger(3) + 0.5 * d * (third + 2.0 * turn * acceleration);
    [feed, angular, tangential.min(acceleration), normal.min(acceleration)]
}

/// Distance of the line between two points from the origin.
fn distance_of_line([a, b]: [Vector3<f64>; 2]) -> f64 {
    let along = b - a;
    let length = along.norm_squared();
    let part = if length > 0.0 { (-a.dot(&along) / length).max(0.0).min(1.0) } else { 0.0 };
    (a + along * part).norm()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Points that move along cubics of the time: what is sampled between two moments is within the bounds, also where the tool nearly
    /// stops and turns between them.
    #[test]
    fn feeds_and_accelerations_between_two_moments_are_within_their_bounds() {
        let mut random = arcfeed_testing::Random::new(3);
        let mut closest = [0.0_f64; 4];
        for case in 0..3000 {
            let mut vector = |size: f64| Vector3::from_fn(|_, _| size * random.signed());
            // Slow in the middle, with every kind of change of the acceleration.
            let third = [0.0, 1e-3, 1.0, 10.0][case % 4];
            let (v, a, j) = (vector([0.01, 0.1, 1.0][case % 3]), vector(1.0), vector(third));
            let (w, spin) = (vector(1.0), vector(0.5));
            let moment = |tau: f64| {
                let twist = |linear: Vector3<f64>, angular: Vector3<f64>| {
                    Twist::from_iterator(linear.iter().chain(angular.iter()).copied())
                };
                let velocity = v + a * tau + j * (tau * tau / 2.0);
                let (sizes, data) =
                    sizes_of(twist(velocity, w + spin * (tau * tau / 2.0)), twist(a + j * tau, spin * tau));
                Moment { tau, sizes, data }
            };
            let width = [0.01, 0.1, 0.5][case / 7 % 3];
            let (first, last) = (moment(-width), moment(width));
            let bounds = bounds_between(&first, &last, [j.norm(), 0.0, spin.norm()]);
            for i in 0..=40 {
                let sizes = moment(width * (f64::from(i) / 20.0 - 1.0)).sizes;
                for (k, (size, bound)) in sizes.iter().zip(bounds).enumerate() {
                    assert!(*size <= bound * (1.0 + 1e-12), "case {case}, {}: {size} {bound}", QUANTITIES[k]);
                    closest[k] = closest[k].max(size / bound);
                }
            }
        }
        assert!(closest.iter().all(|part| *part > 0.99), "{closest:?}");
    }
}
