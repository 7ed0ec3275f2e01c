//! Torque limits of the joints along a path.
//!
//! At a place with joint derivatives `q', q''` the torque of a motion is (Electronics 2025, 14, 3869, eq. 8)
//!
//! ```text
//! inertia a + velocity v^2 + viscous v + constant
//! ```
//!
//! where the constant part is gravity and Coulomb friction. Friction jumps where a joint turns back. Such places are grid points
//! of pose moves and way-points, at which both of its values are allowed for; where a joint turns back inside an interval of a curve of
//! the tool, or all but stands still, they are allowed for on the whole interval.

use arcfeed_feedrate::constraint::{PathConstraint, Place, RowSink};
use arcfeed_feedrate::{IntervalBound, LimitId, Quantity, Row};
use arcfeed_kinematics::{Dynamics, Joints, PathTorque};

use super::fractions::LimitFractions;
use super::joint_tables::{JointLines, push_line};
use crate::limits::TorqueLimits;
use crate::path::{JointJet, JointPath};

/// A joint whose part in the motion is below this counts as one that may turn either way.
const STILL: f64 = 1e-9;

/// The directions in which a joint may move at a place or on an interval.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Directions {
    forward: bool,
    backward: bool,
}

impl Directions {
    const BOTH: Self = Self { forward: true, backward: true };
    const NONE: Self = Self { forward: false, backward: false };

    /// From the rates at three places of an interval; below `least` a rate is rounding.
    fn of(rates: [f64; 3], least: f64) -> Self {
        let [_, middle, _] = rates;
        if rates.iter().all(|rate| *rate == 0.0) {
            Self::NONE
        } else if rates.iter().all(|rate| *rate >= 0.0) && middle > least {
            Self { forward: true, backward: false }
        } else if rates.iter().all(|rate| *rate <= 0.0) && middle < -least {
            Self { forward: false, backward: true }
        } else {
            Self::BOTH
        }
    }

    fn or(self, other: Self) -> Self {
        Self { forward: self.forward || other.forward, backward: self.backward || other.backward }
    }
}

/// The torque at one place: factors of `a`, `v^2` and `v`, gravity, and between what Coulomb friction lies.
#[derive(Debug, Clone, Copy)]
struct Terms<const N: usize> {
    /// Of the joints along the path.
    rate: Joints<N>,
    inertia: Joints<N>,
    velocity: Joints<N>,
    viscous: Joints<N>,
    gravity: Joints<N>,
    low: Joints<N>,
    high: Joints<N>,
}

impl<const N: usize> Terms<N> {
    fn at(dynamics: &dyn Dynamics<N>, jet: &JointJet<N>, directions: &[Directions; N]) -> Self {
        let PathTorque { inertia, velocity, viscous, constant } = dynamics.along_path(&jet.q, &jet.d1, &jet.d2);
        let gravity = dynamics.gravity_torque(&jet.q);
        let (mut low, mut high) = (constant - gravity, constant - gravity);
        let known = |j: usize| {
            let moves = Directions { forward: jet.d1[j] > 0.0, backward: jet.d1[j] < 0.0 };
            moves == directions[j]
        };
        if !(0..N).all(known) {
            let coulomb = |way: f64| dynamics.along_path(&jet.q, &Joints::repeat(way), &jet.d2).constant - gravity;
            let (forward, backward) = (coulomb(1.0), coulomb(-1.0));
            for j in (0..N).filter(|&j| !known(j)) {
                (low[j], high[j]) = match directions[j] {
                    Directions { forward: true, backward: false } => (forward[j], forward[j]),
                    Directions { forward: false, backward: true } => (backward[j], backward[j]),
                    Directions { forward: true, backward: true } => {
                        (forward[j].min(backward[j]), forward[j].max(backward[j]))
                    }
                    Directions { forward: false, backward: false } => (0.0, 0.0),
                };
            }
        }
        Self { rate: jet.d1, inertia, velocity, viscous, gravity, low, high }
    }
}

/// The torque along a whole path, at the points of its grid and in the middle between them.
#[derive(Debug, Clone)]
pub(crate) struct TorquePath<const N: usize> {
    limits: Joints<N>,
    /// Lines below the limits by the speed of a joint.
    lines: JointLines<N>,
    points: Vec<Terms<N>>,
    /// Just before a grid point, where that differs.
    before: Vec<Option<Terms<N>>>,
    middles: Vec<Terms<N>>,
}

impl<const N: usize> TorquePath<N> {
    /// `middles` are the joints in the middle of every interval, or nothing where they are not looked at; `lines` are below the limits by
    /// the speed of a joint.
    pub fn of(
        joints: &JointPath<N>,
        middles: &[JointJet<N>],
        torque: &TorqueLimits<'_, N>,
        lines: JointLines<N>,
    ) -> Self {
        let dynamics = torque.dynamics();
        let n = joints.intervals();
        let directions: Vec<[Directions; N]> = (0..n)
            .map(|k| {
                let (start, end) = joints.interval(k);
                let middle = middles.get(k).map_or((start.d1 + end.d1) * 0.5, |jet| jet.d1);
                let least = STILL * [start.d1, middle, end.d1].iter().fold(0.0, |most: f64, d| most.max(d.amax()));
                std::array::from_fn(|j| Directions::of([start.d1[j], middle[j], end.d1[j]], least))
            })
            .collect();
        let around = |i: usize| {
            let sides = [i.checked_sub(1).and_then(|k| directions.get(k)), directions.get(i)];
            std::array::from_fn(|j| sides.into_iter().flatten().fold(Directions::NONE, |all, side| all.or(side[j])))
        };
        let points = (0..=n).map(|i| Terms::at(dynamics, joints.sides(i).1, &around(i))).collect();
        let before = (0..=n)
            .map(|i| {
                let (left, right) = joints.sides(i);
                // At a smooth knot both sides are the same but for rounding.
                let apart = |a: &Joints<N>, b: &Joints<N>| (a - b).amax() > 1e-7 * (1.0 + a.amax());
                let differ = apart(&left.d1, &right.d1) || apart(&left.d2, &right.d2);
                differ.then(|| Terms::at(dynamics, left, &around(i)))
            })
            .collect();
        let middles = middles.iter().zip(&directions).map(|(jet, ways)| Terms::at(dynamics, jet, ways)).collect();
        Self { limits: *torque.limits(), lines, points, before, middles }
    }

    /// Rows that use `fractions` of what the constant part leaves of every limit.
    pub fn rows<'a>(&'a self, fractions: &LimitFractions) -> TorqueRows<'a, N> {
        TorqueRows { path: self, used: fractions.joints(Quantity::JointTorque) }
    }

    /// Largest magnitudes of the terms of joint `j` on interval `k`: factors of acceleration, squared speed and speed, what remains at
    /// rest, and the rate of the joint.
    fn most(&self, k: usize, j: usize) -> [f64; 5] {
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
        let of_motion: [fn(&Terms<N>) -> &Joints<N>; 4] =
            [|terms| &terms.inertia, |terms| &terms.velocity, |terms| &terms.viscous, |terms| &terms.rate];
        let [inertia, velocity, viscous, rate] = of_motion.map(enclose);
        [inertia, velocity, viscous, rest, rate]
    }
}

/// `|inertia u + velocity x + viscous sqrt(x) + constant| <= limit` of every joint.
#[derive(Debug)]
pub(crate) struct TorqueRows<'a, const N: usize> {
    path: &'a TorquePath<N>,
    used: Joints<N>,
}

impl<const N: usize> TorqueRows<'_, N> {
    /// What is taken off is taken from the motion, not from what holds the arm.
    fn lowered(&self, j: usize, left: f64) -> f64 {
        if left > 0.0 { left * self.used[j] } else { left }
    }

    fn push(&self, terms: &Terms<N>, out: &mut RowSink<'_>) {
        for j in 0..N {
            let rest = terms.gravity[j];
            let (a, b, c) = (terms.inertia[j], terms.velocity[j], terms.viscous[j]);
            let within = |limit: f64| {
                let hi = rest + self.lowered(j, limit - terms.high[j] - rest);
                let lo = rest - self.lowered(j, limit + terms.low[j] + rest);
                // Friction beyond the limit leaves nothing.
                let lo = lo.min(hi);
                Row { a, b, c, d: rest, lo, hi, source: LimitId::joint(Quantity::JointTorque, j) }
            };
            if self.path.limits[j].is_finite() {
                out.row(within(self.path.limits[j]));
            }
            for line in &self.path.lines[j] {
                push_line(within(line.rest), line.slope, terms.rate[j], out);
            }
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
        for j in 0..N {
            let [a, b, c, rest, rate] = self.path.most(k, j);
            let source = LimitId::joint(Quantity::JointTorque, j);
            let mut push = |most: f64, slope: f64| {
                let limit = rest + self.lowered(j, most - rest);
                out.push(IntervalBound::Acceleration { a, b, c: c + slope * rate, rest, limit, source });
            };
            if self.path.limits[j].is_finite() {
                push(self.path.limits[j], 0.0);
            }
            self.path.lines[j].iter().for_each(|line| push(line.rest, line.slope));
        }
    }
}
