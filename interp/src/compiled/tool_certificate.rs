//! What the tool does between the samples of a joint trajectory.

use arcfeed_feedrate::Quantity;
use arcfeed_kinematics::ForwardKinematics;
use nalgebra::Vector3;

use super::certificate::Motion;
use super::joint_trajectory::JointTrajectory;
use super::piece::evaluate;
use super::reach::{JointRateBounds, Reach};

/// Bound and largest value attained agree to this part where [`MOST_DIVISIONS`] suffice.
pub(super) const AGREEMENT: f64 = 1e-3;
/// Or to this part of what the joints could do to the tool if all pulled in one direction: a tool that does not turn has an angular
/// speed of rounding.
pub(super) const NEGLIGIBLE: f64 = 1e-4;
/// Divisions of one piece, at most.
pub(super) const MOST_DIVISIONS: usize = 20_000;
/// Part by which bounds are raised for the rounding of forward kinematics.
pub(super) const ROUNDING: f64 = 1e-9;
/// The longest interval at the start of the search, s.
pub(super) const LONGEST: f64 = 2e-3;

/// The quantities, in the order of the values of a moment.
const QUANTITIES: [Quantity; 4] =
    [Quantity::Feed, Quantity::AngularSpeed, Quantity::TangentialAcceleration, Quantity::NormalAcceleration];

/// The largest size of one quantity of the tool over a whole motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ToolBound {
    /// Feed (m/s), angular speed (rad/s), tangential, normal or whole acceleration (m/s^2), or jerk (m/s^3).
    pub quantity: Quantity,
    /// The largest size found.
    pub attained: f64,
    /// The time at which it is attained, s.
    pub t: f64,
    /// The size that is not exceeded at any time.
    pub bound: f64,
}

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
        let mut search = Search { arm, motion, largest: [(0.0, 0.0); 4], least: [0.0; 4], bounds: [0.0; 4] };
        for piece in 0..self.len() {
            let [point, change, turning] = reach.largest_rates(&JointRateBounds::of(&motion, piece));
            for (least, rate) in search.least.iter_mut().zip([point, turning, change, change]) {
                *least = least.max(NEGLIGIBLE * rate);
            }
            search.look(piece);
        }
        for piece in 0..self.len() {
            search.enclose(piece, &reach);
        }
        let bound = |k: usize| ToolBound {
            quantity: QUANTITIES[k],
            attained: search.largest[k].0,
            t: search.largest[k].1,
            bound: search.bounds[k] * (1.0 + ROUNDING),
        };
        let deviation = self.deviation().map(|deviation| reach.per_unit().map(|moved| moved * deviation.bound));
        ToolCertificate { bounds: std::array::from_fn(bound), deviation }
    }
}

/// The tool at one time.
#[derive(Clone, Copy)]
struct Moment {
    /// Time since the start of the piece, s.
    tau: f64,
    velocity: Vector3<f64>,
    acceleration: Vector3<f64>,
    /// The sizes of [`QUANTITIES`].
    sizes: [f64; 4],
}

struct Search<'a, const N: usize> {
    arm: &'a dyn ForwardKinematics<N>,
    motion: Motion<'a, N>,
    /// Largest sizes at samples, and their times.
    largest: [(f64, f64); 4],
    /// Sizes below which a bound is not made closer.
    least: [f64; 4],
    /// Sizes that are not exceeded on the intervals that are done.
    bounds: [f64; 4],
}

impl<const N: usize> Search<'_, N> {
    fn moment(&mut self, piece: usize, tau: f64) -> Moment {
        let [q, qd, qdd, _] = evaluate(&self.motion.pieces[piece], tau);
        let configuration = self.arm.configuration(&q);
        let jacobian = configuration.jacobian();
        let (twist, change) = (jacobian * qd, jacobian * qdd + configuration.acceleration_bias(&qd));
        let velocity: Vector3<f64> = twist.fixed_rows::<3>(0).into();
        let acceleration: Vector3<f64> = change.fixed_rows::<3>(0).into();
        let direction = velocity.try_normalize(0.0).unwrap_or_else(Vector3::zeros);
        let tangential = acceleration.dot(&direction);
        let normal = (acceleration - direction * tangential).norm();
        let sizes = [velocity.norm(), twist.fixed_rows::<3>(3).norm(), tangential.abs(), normal];
        // At rest the acceleration has no parts.
        let sizes = if sizes[0] > 0.0 { sizes } else { [sizes[0], sizes[1], 0.0, 0.0] };
        for (largest, size) in self.largest.iter_mut().zip(sizes) {
            if size > largest.0 {
                *largest = (size, self.motion.times[piece] + tau);
            }
        }
        Moment { tau, velocity, acceleration, sizes }
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

    /// Divides a piece until its bounds are near the largest sizes found anywhere.
    fn enclose(&mut self, piece: usize, reach: &Reach<N>) {
        let rates = JointRateBounds::of(&self.motion, piece);
        let [third, fourth] = reach.point_rates(&rates);
        let turning = reach.turning_rate(&rates);
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
            let bounds = bounds_between(&a, &b, [third, fourth, turning]);
            let near = |k: usize| bounds[k] <= (self.largest[k].0 * (1.0 + AGREEMENT)).max(self.least[k]);
            let close = (0..4).all(near);
            let middle = 0.5 * (a.tau + b.tau);
            if close || divisions == MOST_DIVISIONS || !(a.tau < middle && middle < b.tau) {
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

/// Bounds of [`QUANTITIES`] between two moments of one piece, from bounds on the third and fourth derivative of the tool point and on
/// the second derivative of its angular velocity.
fn bounds_between(a: &Moment, b: &Moment, [third, fourth, turning]: [f64; 3]) -> [f64; 4] {
    let d = b.tau - a.tau;
    let curved = |second: f64| 0.125 * d * d * second;
    let larger = |k: usize| a.sizes[k].max(b.sizes[k]);
    let feed = larger(0) + curved(third);
    let angular = larger(1) + curved(turning);
    let acceleration = a.acceleration.norm().max(b.acceleration.norm()) + curved(fourth);
    let slowest = distance_of_line([a.velocity, b.velocity]) - curved(third);
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
