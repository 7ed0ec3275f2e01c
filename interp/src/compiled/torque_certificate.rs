//! The torques of the drives between the samples of a joint trajectory.

use arcfeed_feedrate::Quantity;
use arcfeed_kinematics::{Dynamics, Joints};

use super::certificate::Motion;
use super::joint_trajectory::JointTrajectory;
use super::reach::JointRateBounds;
use super::table_certificate::{Law, TableBound, TableCertificate};
use super::tool_search::{Moment, ToolBound, ToolSearch};
use crate::limits::{JointTables, TableKind};

/// A speed that has a direction and no size.
const CREEPING: f64 = 1e-200;
/// Part of the largest possible torque by which the inverse dynamics may be off through rounding.
const ROUNDING: f64 = 1e-12;

/// The largest size of the torque of one joint over a whole motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TorqueBound {
    /// Of which joint, from 0.
    pub joint: usize,
    /// The largest size found, N m (N for a joint that slides).
    pub attained: f64,
    /// The time at which it is attained, s.
    pub t: f64,
    /// The size that is not exceeded at any time.
    pub bound: f64,
}

/// Which torques the drives need at most, at all times; see [`JointTrajectory::certify_torque`].
#[derive(Debug, Clone, PartialEq)]
pub struct TorqueCertificate<const N: usize> {
    bounds: [TorqueBound; N],
}

impl<const N: usize> TorqueCertificate<N> {
    /// One for each joint.
    pub fn bounds(&self) -> &[TorqueBound; N] {
        &self.bounds
    }

    /// True where no torque exceeds its limit in `limits` (N m; infinite for none) by more than `tolerance`, relative.
    pub fn holds(&self, limits: &Joints<N>, tolerance: f64) -> bool {
        // Not `any(.. > ..)`: a NaN does not hold.
        self.bounds.iter().zip(limits.iter()).all(|(bound, limit)| bound.bound <= limit * (1.0 + tolerance))
    }
}

impl<const N: usize> JointTrajectory<N> {
    /// Bounds on the torques of the joints of an arm with `dynamics` at all times, N m; `None` where these state no
    /// [bounds](Dynamics::torque_bounds) of their own.
    ///
    /// Between two samples of one piece a torque without Coulomb friction is near the straight line between its values, by its second
    /// derivative, which the rates of the joints and the inertia of the links bound. Coulomb friction counts in every direction in which the
    /// joint may move between the samples, and as none where it may rest. Intervals are divided until the bound is within 1e-3 of the
    /// largest size at a sample, or within 1e-4 of what the joints could do.
    ///
    /// ```
    /// use arcfeed_interp::{Interpolation, JointTrajectory};
    /// use arcfeed_kinematics::{ArmDynamics, Inertial, Joints, models, nalgebra::{Matrix3, Vector3}};
    ///
    /// // Two point masses of 1 kg in a horizontal plane; the first joint turns by 1 rad within 1 s, at most by 5.77 rad/s^2.
    /// let point = |x: f64| Inertial::new(1.0, Vector3::new(x, 0.0, 0.0), Matrix3::zeros());
    /// let arm = ArmDynamics::new(&models::planar_2r(), [point(0.4)?, point(0.0)?])?;
    /// let piece = [0.0, 0.0, 0.0, 10.0, -15.0, 6.0].map(|c| Joints::from([c, 0.0]));
    /// let motion = JointTrajectory::from_pieces(vec![0.0, 1.0], vec![piece], Interpolation::Quintic)?;
    /// let torque = motion.certify_torque(&arm).ok_or("an arm with bounds")?;
    /// let expected = 2.0 * 0.4 * 0.4 * 10.0 / 3f64.sqrt();
    /// let bound = torque.bounds()[0];
    /// assert!(bound.bound >= expected && bound.bound < 1.002 * expected);
    /// assert!(torque.holds(&Joints::from([2.0, 2.0]), 1e-6) && !torque.holds(&Joints::from([1.8, 2.0]), 1e-6));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn certify_torque(&self, dynamics: &(dyn Dynamics<N> + Sync)) -> Option<TorqueCertificate<N>> {
        let found = self.search_torque(dynamics, |_, _| 1.0)?;
        let bound = |joint: usize, found: ToolBound| TorqueBound {
            joint,
            attained: found.attained,
            t: found.t,
            bound: found.bound,
        };
        Some(TorqueCertificate { bounds: std::array::from_fn(|joint| bound(joint, found[joint])) })
    }

    /// Holds the torques of an arm with `dynamics` against tables of speed, at all times: the parts of the limits that are used at most.
    /// `None` where the dynamics state no [bounds](Dynamics::torque_bounds).
    ///
    /// As [`JointTrajectory::certify_torque`], and as [`JointTrajectory::certify_tables`] for other tables: between two samples the least
    /// limit at a speed that is possible there counts.
    pub fn certify_torque_tables(
        &self,
        dynamics: &(dyn Dynamics<N> + Sync),
        tables: &JointTables<N>,
    ) -> Option<TableCertificate> {
        let kind = TableKind::TorqueBySpeed;
        let laws: [Option<Law>; N] = std::array::from_fn(|j| tables.of(kind, j).map(|table| Law::new(table, true)));
        if laws.iter().all(Option::is_none) {
            return Some(TableCertificate::of_bounds(Vec::new()));
        }
        let found = self.search_torque(dynamics, |j, speeds| {
            let least = |law: &Law| law.certain_least(speeds).max(0.0);
            laws[j].as_ref().map_or(f64::INFINITY, least)
        })?;
        let with_table = (0..N).filter(|joint| laws[*joint].is_some());
        let bounds = with_table.map(|joint| {
            let ToolBound { attained, t, bound, .. } = found[joint];
            TableBound { kind, joint, attained, t, bound }
        });
        Some(TableCertificate::of_bounds(bounds.collect()))
    }

    /// Looks for the largest torque over the `least` limit at speeds within a range, joint by joint.
    fn search_torque(
        &self,
        dynamics: &(dyn Dynamics<N> + Sync),
        least: impl Fn(usize, [f64; 2]) -> f64,
    ) -> Option<[ToolBound; N]> {
        let motion = Motion { times: self.times(), pieces: self.coefficients() };
        let resting = resting(&motion);
        let coulomb = |direction: f64| dynamics.friction_torque(&Joints::repeat(direction * CREEPING));
        let friction = [-1.0, 1.0].map(coulomb);
        let mut search = ToolSearch::new(motion, |[q, qd, qdd, _]| {
            let creeping = qd.map(|speed| if speed == 0.0 { 0.0 } else { CREEPING.copysign(speed) });
            let smooth = dynamics.torque(&q, &qd, &qdd) - dynamics.friction_torque(&creeping);
            let size = |j: usize| {
                let speed = qd[j].abs();
                let jump = directed(&friction, j, [qd[j], qd[j]], resting[j]);
                widest(smooth[j], smooth[j], jump) / least(j, [speed, speed])
            };
            (std::array::from_fn(size), Sampled { smooth, qd })
        });
        let pieces: Vec<_> =
            (0..self.len()).map(|piece| PieceBounds::of(&motion, piece, dynamics)).collect::<Option<_>>()?;
        for (piece, of) in pieces.iter().enumerate() {
            search.look(piece, std::array::from_fn(|j| of.size[j] / least(j, sizes(of.speeds[j]))));
        }
        for (piece, of) in pieces.iter().enumerate() {
            search.enclose(piece, |a, b| {
                std::array::from_fn(|j| {
                    let (torque, speeds) = of.between(a, b, j);
                    let jump = directed(&friction, j, speeds, resting[j]);
                    let size = widest(torque[0], torque[1], jump) + ROUNDING * of.size[j];
                    size / least(j, sizes(speeds))
                })
            });
        }
        Some(search.finish([Quantity::JointTorque; N]))
    }
}

/// Torques without Coulomb friction at one time, and speeds.
#[derive(Clone, Copy)]
struct Sampled<const N: usize> {
    smooth: Joints<N>,
    qd: Joints<N>,
}

/// What holds on a whole piece.
struct PieceBounds<const N: usize> {
    /// Largest possible size of a torque, and of its second derivative by time.
    size: Joints<N>,
    second: Joints<N>,
    /// Ranges of the speeds, and the largest jerks.
    speeds: [[f64; 2]; N],
    jerk: [f64; N],
}

impl<const N: usize> PieceBounds<N> {
    fn of(motion: &Motion<'_, N>, piece: usize, dynamics: &(dyn Dynamics<N> + Sync)) -> Option<Self> {
        let rates = JointRateBounds::of(motion, piece);
        let position = std::array::from_fn(|joint| motion.bernstein(piece, joint, 0, 0.0).bound());
        let sizes = [position, rates.velocity, rates.acceleration, rates.jerk, rates.snap].map(Joints::from);
        let bounds = dynamics.torque_bounds(&sizes)?;
        let speeds = std::array::from_fn(|joint| motion.bernstein(piece, joint, 1, 0.0).range());
        Some(Self { size: bounds.size, second: bounds.second_derivative, speeds, jerk: rates.jerk })
    }

    /// Ranges of the torque without Coulomb friction and of the speed of one joint between two moments.
    fn between(&self, a: &Moment<Sampled<N>, N>, b: &Moment<Sampled<N>, N>, j: usize) -> ([f64; 2], [f64; 2]) {
        let d = b.tau - a.tau;
        let range = |x: f64, y: f64, second: f64| {
            let curved = 0.125 * d * d * second;
            [x.min(y) - curved, x.max(y) + curved]
        };
        let (from, to) = (&a.data, &b.data);
        let torque = range(from.smooth[j], to.smooth[j], self.second[j]);
        let [low, high] = range(from.qd[j], to.qd[j], self.jerk[j]);
        // Not `min` alone, which loses a NaN.
        let torque = if (from.smooth[j] + to.smooth[j]).is_nan() { [f64::NAN; 2] } else { torque };
        let [least, most] = self.speeds[j];
        (torque, [low.max(least), high.min(most)])
    }
}

/// Speeds below which a joint counts as resting: rounding explains them.
fn resting<const N: usize>(motion: &Motion<'_, N>) -> [f64; N] {
    let of = |joint| {
        let pieces = 0..motion.pieces.len();
        pieces.map(|piece| 2.0 * motion.rounding(piece, joint, 1)).fold(0.0, f64::max)
    };
    std::array::from_fn(of)
}

/// The least and the greatest of the Coulomb torques `friction` (backward, forward) that speeds of joint `j` within a range allow; none at
/// speeds below `resting`.
fn directed<const N: usize>(friction: &[Joints<N>; 2], j: usize, speeds: [f64; 2], resting: f64) -> [f64; 2] {
    // A range that rounding turned over, and a NaN, exclude nothing.
    let above = speeds.iter().all(|speed| *speed > resting);
    let below = speeds.iter().all(|speed| *speed < -resting);
    let forward = !speeds.iter().all(|speed| *speed <= resting);
    let backward = !speeds.iter().all(|speed| *speed >= -resting);
    let possible = [(backward, friction[0][j]), (!above && !below, 0.0), (forward, friction[1][j])];
    let values = || possible.iter().filter(|(possible, _)| *possible).map(|(_, value)| *value);
    [values().fold(f64::INFINITY, f64::min), values().fold(f64::NEG_INFINITY, f64::max)]
}

/// The largest size of a sum of a value between `low` and `high` and one between those of `jump`.
fn widest(low: f64, high: f64, jump: [f64; 2]) -> f64 {
    let (least, most) = (low + jump[0], high + jump[1]);
    // Not `max`, which loses a NaN.
    if most >= -least { most } else { -least }
}

/// The range of the sizes of values within a range.
fn sizes([low, high]: [f64; 2]) -> [f64; 2] {
    let least = if low <= 0.0 && high >= 0.0 { 0.0 } else { low.abs().min(high.abs()) };
    [least, low.abs().max(high.abs())]
}
