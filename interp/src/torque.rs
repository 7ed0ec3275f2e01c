//! Torque limits of the joints along a path.
//!
//! At a place with joint derivatives `q', q''` the torque of a motion is (Electronics 2025, 14, 3869, eq. 8)
//!
//! ```text
//! inertia a + velocity v^2 + viscous v + constant
//! ```
//!
//! where the constant part is gravity and Coulomb friction. The latter jumps where a joint turns back; near such a place both of its
//! values are allowed for.

use std::fmt;

use arcfeed_feedrate::constraint::{PathConstraint, Place, RowSink};
use arcfeed_feedrate::{IntervalBound, Quantity, Row, RowSource};
use arcfeed_kinematics::{Dynamics, Joints, PathTorque};

use crate::error::PlanError;
use crate::joint_path::{JointJet, JointPath};

/// What the drives can do, and what they have to move: dynamics of the arm with its payload, and greatest torques.
#[derive(Clone, Copy)]
pub struct TorqueLimits<'a, const N: usize = 6> {
    dynamics: &'a dyn Dynamics<N>,
    limits: Joints<N>,
}

impl<const N: usize> fmt::Debug for TorqueLimits<'_, N> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("TorqueLimits").field("limits", &self.limits).finish_non_exhaustive()
    }
}

impl<'a, const N: usize> TorqueLimits<'a, N> {
    /// The greatest torques `limits` (N m, either sign; infinite means none) of an arm with `dynamics`.
    ///
    /// # Errors
    /// [`PlanError::Limit`] for a torque that is not above 0.
    pub fn new(dynamics: &'a dyn Dynamics<N>, limits: Joints<N>) -> Result<Self, PlanError> {
        match limits.iter().find(|limit| limit.is_nan() || **limit <= 0.0) {
            Some(&value) => Err(PlanError::Limit { what: "torque limit", value }),
            None => Ok(Self { dynamics, limits }),
        }
    }

    /// Greatest torques, N m.
    pub fn limits(&self) -> &Joints<N> {
        &self.limits
    }

    /// The torque of a motion, N m.
    pub fn torque(&self, q: &Joints<N>, qd: &Joints<N>, qdd: &Joints<N>) -> Joints<N> {
        self.dynamics.torque(q, qd, qdd)
    }
}

/// A joint whose part in the motion is below this counts as one that may turn either way.
const STILL: f64 = 1e-9;

/// The torque at one place: factors of `a`, `v^2` and `v`, gravity, and between what Coulomb friction lies.
#[derive(Debug, Clone, Copy)]
struct Terms<const N: usize> {
    inertia: Joints<N>,
    velocity: Joints<N>,
    viscous: Joints<N>,
    gravity: Joints<N>,
    low: Joints<N>,
    high: Joints<N>,
}

impl<const N: usize> Terms<N> {
    /// For the joints of `turns` either direction of the Coulomb friction is possible.
    fn at(dynamics: &dyn Dynamics<N>, jet: &JointJet<N>, turns: &[bool; N]) -> Self {
        let forward = dynamics.along_path(&jet.q, &jet.d1, &jet.d2);
        let gravity = dynamics.gravity_torque(&jet.q);
        let (mut low, mut high) = (forward.constant - gravity, forward.constant - gravity);
        if turns.contains(&true) {
            for way in [Joints::repeat(1.0), Joints::repeat(-1.0)] {
                let coulomb = dynamics.along_path(&jet.q, &way, &jet.d2).constant - gravity;
                for j in (0..N).filter(|&j| turns[j]) {
                    low[j] = low[j].min(coulomb[j]);
                    high[j] = high[j].max(coulomb[j]);
                }
            }
        }
        let PathTorque { inertia, velocity, viscous, .. } = forward;
        Self { inertia, velocity, viscous, gravity, low, high }
    }
}

/// The torque along a whole path, at the points of its grid and in the middle between them.
#[derive(Debug, Clone)]
pub(crate) struct TorquePath<const N: usize> {
    limits: Joints<N>,
    points: Vec<Terms<N>>,
    /// Just before a grid point, where that differs.
    before: Vec<Option<Terms<N>>>,
    middles: Vec<Terms<N>>,
}

impl<const N: usize> TorquePath<N> {
    /// `middles` are the joints in the middle of every interval.
    pub fn of(joints: &JointPath<N>, middles: &[JointJet<N>], torque: &TorqueLimits<'_, N>) -> Self {
        let dynamics = torque.dynamics;
        let n = joints.intervals();
        let turning: Vec<[bool; N]> = (0..n)
            .map(|k| {
                let (start, end) = joints.interval(k);
                let rates = [&start.d1, &middles[k].d1, &end.d1];
                let least = STILL * rates.iter().fold(0.0, |most: f64, d| most.max(d.amax()));
                std::array::from_fn(|j| !(rates.iter().all(|d| d[j] > least) || rates.iter().all(|d| d[j] < -least)))
            })
            .collect();
        let turns = |i: usize| {
            let (left, right) = (i.checked_sub(1).and_then(|k| turning.get(k)), turning.get(i));
            std::array::from_fn(|j| [left, right].into_iter().flatten().any(|turns| turns[j]))
        };
        let points = (0..=n).map(|i| Terms::at(dynamics, joints.sides(i).1, &turns(i))).collect();
        let before = (0..=n)
            .map(|i| {
                let (left, right) = joints.sides(i);
                // At a smooth knot both sides are the same but for rounding.
                let apart = |a: &Joints<N>, b: &Joints<N>| (a - b).amax() > 1e-7 * (1.0 + a.amax());
                let differ = apart(&left.d1, &right.d1) || apart(&left.d2, &right.d2);
                differ.then(|| Terms::at(dynamics, left, &turns(i)))
            })
            .collect();
        let middles = middles.iter().zip(&turning).map(|(jet, turns)| Terms::at(dynamics, jet, turns)).collect();
        Self { limits: *torque.limits(), points, before, middles }
    }

    /// Rows that use the fraction `scale` of what the constant part leaves of every limit.
    pub fn rows(&self, scale: f64) -> TorqueRows<'_, N> {
        TorqueRows { path: self, scale }
    }

    /// Largest magnitudes of the terms of joint `j` on interval `k`: factors of acceleration, squared speed and speed, and what remains
    /// at rest.
    fn most(&self, k: usize, j: usize) -> [f64; 4] {
        let near = &self.points[k];
        let far = self.before[k + 1].as_ref().unwrap_or(&self.points[k + 1]);
        let three = [near, &self.middles[k], far];
        // The parabola through three values lies between its Bernstein coefficients.
        let enclose = |of: fn(&Terms<N>) -> &Joints<N>| {
            let [p, m, q] = three.map(|terms| of(terms)[j]);
            p.abs().max(q.abs()).max((2.0 * m - 0.5 * (p + q)).abs())
        };
        let [p, m, q] = three.map(|terms| terms.gravity[j]);
        let inner = 2.0 * m - 0.5 * (p + q);
        let high = three.map(|terms| terms.high[j]).into_iter().fold(f64::NEG_INFINITY, f64::max);
        let low = three.map(|terms| terms.low[j]).into_iter().fold(f64::INFINITY, f64::min);
        let rest = (p.max(q).max(inner) + high).max(-(p.min(q).min(inner) + low));
        [enclose(|terms| &terms.inertia), enclose(|terms| &terms.velocity), enclose(|terms| &terms.viscous), rest]
    }
}

/// `|inertia u + velocity x + viscous sqrt(x) + constant| <= limit` of every joint.
#[derive(Debug)]
pub(crate) struct TorqueRows<'a, const N: usize> {
    path: &'a TorquePath<N>,
    scale: f64,
}

impl<const N: usize> TorqueRows<'_, N> {
    /// What is taken off is taken from the motion, not from what holds the arm.
    fn lowered(&self, left: f64) -> f64 {
        if left > 0.0 { left * self.scale } else { left }
    }

    fn push(&self, terms: &Terms<N>, out: &mut RowSink<'_>) {
        for j in (0..N).filter(|&j| self.path.limits[j].is_finite()) {
            let (limit, rest) = (self.path.limits[j], terms.gravity[j]);
            let hi = rest + self.lowered(limit - terms.high[j] - rest);
            let lo = rest - self.lowered(limit + terms.low[j] + rest);
            // Friction beyond the limit leaves nothing.
            let lo = lo.min(hi);
            let (a, b, c) = (terms.inertia[j], terms.velocity[j], terms.viscous[j]);
            out.row(Row { a, b, c, d: rest, lo, hi, source: RowSource::joint(Quantity::JointTorque, j) });
        }
    }
}

impl<const N: usize> PathConstraint for TorqueRows<'_, N> {
    fn points(&self) -> Option<usize> {
        Some(self.path.points.len())
    }

    fn rows(&self, place: Place, out: &mut RowSink<'_>) {
        match place {
            Place::Point(i) => {
                self.push(&self.path.points[i], out);
                if let Some(before) = &self.path.before[i] {
                    self.push(before, out);
                }
            }
            Place::Middle { k, .. } => self.push(&self.path.middles[k], out),
        }
    }

    fn interval_bounds(&self, k: usize, _h: f64, out: &mut Vec<IntervalBound>) {
        for j in (0..N).filter(|&j| self.path.limits[j].is_finite()) {
            let [a, b, c, rest] = self.path.most(k, j);
            let limit = rest + self.lowered(self.path.limits[j] - rest);
            let source = RowSource::joint(Quantity::JointTorque, j);
            out.push(IntervalBound::Acceleration { a, b, c, rest, limit, source });
        }
    }
}
