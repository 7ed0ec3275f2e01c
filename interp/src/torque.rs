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
use arcfeed_feedrate::{Quantity, Row, RowSource};
use arcfeed_kinematics::{Dynamics, Joints};

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

/// The torque at one place: factors of `a`, `v^2`, `v`, and the least and greatest constant part.
#[derive(Debug, Clone, Copy)]
struct Terms<const N: usize> {
    inertia: Joints<N>,
    velocity: Joints<N>,
    viscous: Joints<N>,
    low: Joints<N>,
    high: Joints<N>,
}

impl<const N: usize> Terms<N> {
    /// For the joints of `turns` either direction of the Coulomb friction is possible.
    fn at(dynamics: &dyn Dynamics<N>, jet: &JointJet<N>, turns: &[bool; N]) -> Self {
        let forward = dynamics.along_path(&jet.q, &jet.d1, &jet.d2);
        let (mut low, mut high) = (forward.constant, forward.constant);
        if turns.contains(&true) {
            // A joint at rest has neither value.
            let eps = STILL * jet.d1.amax();
            let away = |sign: f64| jet.d1.map(|d| if d.abs() > eps { sign * d } else { sign });
            for way in [away(1.0), away(-1.0)] {
                let constant = dynamics.along_path(&jet.q, &way, &jet.d2).constant;
                for j in (0..N).filter(|&j| turns[j]) {
                    low[j] = low[j].min(constant[j]);
                    high[j] = high[j].max(constant[j]);
                }
            }
        }
        Self { inertia: forward.inertia, velocity: forward.velocity, viscous: forward.viscous, low, high }
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
    pub fn of(joints: &JointPath<N>, torque: &TorqueLimits<'_, N>) -> Self {
        let dynamics = torque.dynamics;
        let n = joints.intervals();
        let middles: Vec<JointJet<N>> = (0..n).map(|k| middle(joints, k)).collect();
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

    /// Bounds on interval `k` for a box.
    pub fn reach(&self, k: usize) -> TorqueReach<N> {
        let near = &self.points[k];
        let far = self.before[k + 1].as_ref().unwrap_or(&self.points[k + 1]);
        let three = [near, &self.middles[k], far];
        // The parabola through three values lies between its Bernstein coefficients.
        let enclose = |of: &dyn Fn(&Terms<N>) -> f64| {
            let [p, m, q] = three.map(of);
            p.abs().max(q.abs()).max((2.0 * m - 0.5 * (p + q)).abs())
        };
        let each = |of: &dyn Fn(&Terms<N>, usize) -> f64| Joints::from_fn(|j, _| enclose(&|terms| of(terms, j)));
        TorqueReach {
            limits: self.limits,
            inertia: each(&|terms, j| terms.inertia[j]),
            velocity: each(&|terms, j| terms.velocity[j]),
            viscous: each(&|terms, j| terms.viscous[j]),
            constant: each(&|terms, j| terms.low[j]).zip_map(&each(&|terms, j| terms.high[j]), f64::max),
        }
    }
}

/// Largest magnitudes of the terms on one interval.
#[derive(Debug, Clone, Copy)]
pub(crate) struct TorqueReach<const N: usize> {
    pub limits: Joints<N>,
    pub inertia: Joints<N>,
    pub velocity: Joints<N>,
    pub viscous: Joints<N>,
    pub constant: Joints<N>,
}

/// Joint values and derivatives in the middle of an interval, from both its ends.
fn middle<const N: usize>(joints: &JointPath<N>, k: usize) -> JointJet<N> {
    let (a, b) = joints.interval(k);
    let h = 0.5 * (b.s - a.s);
    let first = |jet: &JointJet<N>, h: f64| jet.d1 + (jet.d2 + jet.d3 * (h / 2.0)) * h;
    JointJet {
        s: a.s + h,
        q: (a.ahead(h) + b.ahead(-h)) / 2.0,
        d1: (first(a, h) + first(b, -h)) / 2.0,
        d2: (a.d2 + a.d3 * h + b.d2 - b.d3 * h) / 2.0,
        d3: (a.d3 + b.d3) / 2.0,
    }
}

/// `|inertia u + velocity x + viscous sqrt(x) + constant| <= limit` of every joint.
#[derive(Debug)]
pub(crate) struct TorqueRows<'a, const N: usize> {
    path: &'a TorquePath<N>,
    scale: f64,
}

impl<const N: usize> TorqueRows<'_, N> {
    fn push(&self, terms: &Terms<N>, out: &mut RowSink<'_>) {
        for j in (0..N).filter(|&j| self.path.limits[j].is_finite()) {
            let (middle, half) = (0.5 * (terms.low[j] + terms.high[j]), 0.5 * (terms.high[j] - terms.low[j]));
            let limit = self.path.limits[j] - half;
            // What is taken off is taken from the motion, not from what holds the arm.
            let lower = |room: f64| if room > 0.0 { room * self.scale } else { room };
            out.row(Row {
                a: terms.inertia[j],
                b: terms.velocity[j],
                c: terms.viscous[j],
                d: middle,
                lo: middle - lower(middle + limit),
                hi: middle + lower(limit - middle),
                source: RowSource::joint(Quantity::JointTorque, j),
            });
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
}
