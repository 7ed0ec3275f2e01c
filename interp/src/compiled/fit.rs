//! Whether one piece keeps the limits of the joints and stays near the plan.

use arcfeed_feedrate::{LimitId, Quantity};
use arcfeed_kinematics::{JointLimits, Joints};

use super::error::CompileError;
use super::nodes::{Node, PEAK};
use super::piece::{Coefficients, evaluate};

/// By how much a piece may exceed a limit, relative: less than the certificate allows.
const EXCESS: f64 = 8e-7;
/// Halvings of an interval with one root.
const HALVINGS: usize = 60;
/// Places of a piece at which positions near the end of a range are looked at.
const PLACES: usize = 64;

/// What pieces are held against.
#[derive(Debug, Clone, Copy)]
pub(super) struct Bounds<const N: usize> {
    limits: JointLimits<N>,
    /// The limit on jerk; infinite where the acceleration may jump.
    jerk: Joints<N>,
    /// The limit on the jerk of the plan; infinite where it has none.
    plan_jerk: Joints<N>,
    /// Whether the jerk of a piece stays between the smallest and the largest of the plan.
    follows_jerk: bool,
    tolerance: f64,
}

/// Deviation of one piece from the plan, rad.
#[derive(Debug, Clone, Copy)]
pub(super) struct PieceDeviation {
    pub bound: f64,
    pub measured: f64,
}

/// Why a piece does not do, and by how much: 1 would do.
#[derive(Debug, Clone)]
pub(super) struct Misfit {
    pub excess: f64,
    pub error: CompileError,
}

impl<const N: usize> Bounds<N> {
    /// For pieces with limited jerk (`keeps_jerk`), of a plan that limits it (`plan_keeps_jerk`).
    pub fn new(limits: &JointLimits<N>, tolerance: f64, keeps_jerk: bool, plan_keeps_jerk: bool) -> Self {
        let jerk = |kept: bool| if kept { *limits.jerk() } else { Joints::repeat(f64::INFINITY) };
        Self {
            limits: *limits,
            jerk: jerk(keeps_jerk),
            plan_jerk: jerk(plan_keeps_jerk),
            follows_jerk: false,
            tolerance,
        }
    }

    /// The same for pieces whose jerk stays between the smallest and the largest of the plan over their time: a limit on jerk that is
    /// not constant, or not one of the joints, is kept as the plan keeps it.
    pub fn following_jerk(self, follows_jerk: bool) -> Self {
        Self { follows_jerk, ..self }
    }

    /// Whether the jerk of pieces follows that of the plan.
    pub fn follows_jerk(&self) -> bool {
        self.follows_jerk
    }

    /// Checks the piece `c` that starts at `t`, over the samples `nodes` at which it begins and ends and all between.
    pub fn check<'n>(
        &self,
        c: &Coefficients<N>,
        h: f64,
        nodes: impl Iterator<Item = &'n Node<N>> + Clone,
    ) -> Result<PieceDeviation, Misfit> {
        let t = nodes.clone().next().map_or(0.0, |node| node.t);
        let mut largest = [Joints::zeros(); 2];
        for joint in 0..N {
            let c: [f64; 6] = std::array::from_fn(|k| c[k][joint]);
            let [acceleration, jerk] = self.check_limits(&c, h, joint, t)?;
            (largest[0][joint], largest[1][joint]) = (acceleration, jerk);
        }
        if self.follows_jerk {
            self.check_jerk_of_plan(c, h, nodes.clone())?;
        }
        self.check_deviation(c, &largest, nodes)
    }

    /// The largest sizes of acceleration and jerk of one joint.
    fn check_limits(&self, c: &[f64; 6], h: f64, joint: usize, t: f64) -> Result<[f64; 2], Misfit> {
        let [velocity, acceleration] = [self.limits.velocity()[joint], self.limits.acceleration()[joint]];
        let exceeds = |quantity, (value, tau): (f64, f64), allowed: f64| {
            let excess = value.abs() / allowed;
            // Not `>`: a NaN has to show.
            let keeps = excess <= 1.0 + EXCESS;
            let limit = LimitId::joint(quantity, joint);
            let error = CompileError::Limit { limit, value, allowed, t: t + tau };
            if keeps { Ok(()) } else { Err(Misfit { excess, error }) }
        };
        let jerk_at = |x: f64| 6.0 * c[3] + x * (24.0 * c[4] + x * (60.0 * c[5]));
        let vertex = -0.2 * c[4] / c[5];
        let largest_jerk = largest(jerk_at, [0.0, h, inside(vertex, h)]);
        exceeds(Quantity::JointJerk, largest_jerk, self.jerk[joint])?;

        let acceleration_at = |x: f64| 2.0 * c[2] + x * (6.0 * c[3] + x * (12.0 * c[4] + x * (20.0 * c[5])));
        let turns = quadratic_roots(60.0 * c[5], 24.0 * c[4], 6.0 * c[3]).map(|x| inside(x, h));
        let largest_acceleration = largest(acceleration_at, [0.0, h, turns[0], turns[1]]);
        exceeds(Quantity::JointAcceleration, largest_acceleration, acceleration)?;

        let velocity_at = |x: f64| c[1] + x * (2.0 * c[2] + x * (3.0 * c[3] + x * (4.0 * c[4] + x * (5.0 * c[5]))));
        let ends = largest(velocity_at, [0.0, h]);
        let coarse = ends.0.abs() + 0.5 * h * largest_acceleration.0.abs();
        if coarse > velocity {
            let mut at = [0.0, turns[0], turns[1], h];
            at.sort_by(f64::total_cmp);
            let roots = [0, 1, 2].map(|i| root(acceleration_at, at[i], at[i + 1]));
            exceeds(Quantity::JointVelocity, largest(velocity_at, roots), velocity)?;
            exceeds(Quantity::JointVelocity, ends, velocity)?;
        }
        let (lower, upper) = (self.limits.lower()[joint], self.limits.upper()[joint]);
        let (middle, half) = (0.5 * (lower + upper), 0.5 * (upper - lower));
        let off = |x: f64| c[0] - middle + x * (c[1] + x * (c[2] + x * (c[3] + x * (c[4] + x * c[5]))));
        if largest(off, [0.0, h]).0.abs() + 0.5 * h * coarse > half {
            let places: [f64; PLACES] = std::array::from_fn(|i| h * i as f64 / (PLACES - 1) as f64);
            exceeds(Quantity::JointPosition, largest(off, places), half)?;
        }
        Ok([largest_acceleration.0.abs(), largest_jerk.0.abs()])
    }

    /// The jerk of the piece between the smallest and the largest of the plan: at its samples, on both sides of knots, and on the mean
    /// between two of them.
    fn check_jerk_of_plan<'n>(
        &self,
        c: &Coefficients<N>,
        h: f64,
        nodes: impl Iterator<Item = &'n Node<N>>,
    ) -> Result<(), Misfit> {
        // By so much of the largest jerk, and of the limit, the jerk may be beyond.
        const BEYOND: f64 = 2e-3;
        const NEGLIGIBLE: f64 = 1e-3;
        let [mut least, mut most] = [f64::INFINITY, f64::NEG_INFINITY].map(Joints::<N>::repeat);
        let (mut last, mut start): (Option<&Node<N>>, _) = (None, 0.0);
        for node in nodes {
            let mut count = |jerk: Joints<N>| (least, most) = (least.inf(&jerk), most.sup(&jerk));
            if let Some(last) = last {
                // The mean between two samples is among its values, too.
                count((node.before - last.state.qdd) / (node.t - last.t));
                last.jerk.into_iter().for_each(|[_, after]| count(after));
                node.jerk.into_iter().for_each(|[before, _]| count(before));
            } else {
                start = node.t;
            }
            last = Some(node);
        }
        for joint in 0..N {
            let [j0, j1, j2] = [6.0 * c[3][joint], 24.0 * c[4][joint], 60.0 * c[5][joint]];
            let (middle, half) = (0.5 * (least[joint] + most[joint]), 0.5 * (most[joint] - least[joint]));
            let size = least[joint].abs().max(most[joint].abs());
            let allowed = half + BEYOND * size + NEGLIGIBLE * self.jerk[joint].min(self.plan_jerk[joint]);
            let off = |x: f64| j0 + x * (j1 + x * j2) - middle;
            let (value, tau) = largest(off, [0.0, h, inside(-0.5 * j1 / j2, h)]);
            // Not `>`: a NaN has to show.
            let keeps = value.abs() <= allowed;
            if !keeps {
                let limit = LimitId::joint(Quantity::JointJerk, joint);
                let (value, t) = (middle + value, start + tau);
                let error = CompileError::Limit { limit, value, allowed: middle.abs() + allowed, t };
                return Err(Misfit { excess: (value - middle).abs() / allowed, error });
            }
        }
        Ok(())
    }

    /// The bound of the deviation: the larger one of two neighbouring samples, and what the second derivative of the deviation can
    /// add between them. See `docs/certificate.md`.
    fn check_deviation<'n>(
        &self,
        c: &Coefficients<N>,
        [acceleration, jerk]: &[Joints<N>; 2],
        nodes: impl Iterator<Item = &'n Node<N>>,
    ) -> Result<PieceDeviation, Misfit> {
        let mut deviation = PieceDeviation { bound: 0.0, measured: 0.0 };
        let mut last: Option<(f64, Joints<N>, Joints<N>)> = None;
        let mut start = 0.0;
        for node in nodes {
            let first = last.is_none();
            if first {
                start = node.t;
            }
            let [q, _, qdd, _] = evaluate(c, node.t - start);
            let off = (q - node.state.q).abs();
            deviation.measured = deviation.measured.max(off.amax());
            if let Some((t, off_before, second_before)) = last {
                let d = node.t - t;
                let second_after = (qdd - node.before).abs();
                for k in 0..N {
                    let planned = self.plan_jerk[k];
                    let second = if planned.is_finite() {
                        second_before[k].max(second_after[k]) + 0.5 * d * (jerk[k] + planned) + PEAK * planned
                    } else {
                        acceleration[k] + self.limits.acceleration()[k]
                    };
                    let bound = off_before[k].max(off[k]) + 0.125 * d * d * second;
                    // Not `>`: a NaN has to show.
                    let keeps = bound <= self.tolerance;
                    if !keeps {
                        let tolerance = self.tolerance;
                        let error = CompileError::Deviation { joint: k, t: node.t, bound, tolerance };
                        return Err(Misfit { excess: bound / tolerance, error });
                    }
                    deviation.bound = deviation.bound.max(bound);
                }
            }
            last = Some((node.t, off, (qdd - node.state.qdd).abs()));
        }
        Ok(deviation)
    }
}

/// The value of largest size at some places, and the place.
fn largest<const M: usize>(f: impl Fn(f64) -> f64, places: [f64; M]) -> (f64, f64) {
    let values = places.map(|x| (f(x), x));
    values.into_iter().fold((0.0, 0.0), |m, v| if v.0.abs() > m.0.abs() || v.0.is_nan() { v } else { m })
}

/// The place if it is inside a piece, its start otherwise.
fn inside(x: f64, h: f64) -> f64 {
    if x > 0.0 && x < h { x } else { 0.0 }
}

/// The real roots of `a x^2 + b x + c`; NaN where there is none.
fn quadratic_roots(a: f64, b: f64, c: f64) -> [f64; 2] {
    let q = -0.5 * (b + (b * b - 4.0 * a * c).sqrt().copysign(b));
    [q / a, c / q]
}

/// The root of a monotone function between two places; one of them where there is none.
fn root(f: impl Fn(f64) -> f64, mut low: f64, mut high: f64) -> f64 {
    let rises = f(low) < 0.0;
    if (f(high) < 0.0) == rises {
        return high;
    }
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if (f(middle) < 0.0) == rises { low = middle } else { high = middle }
    }
    high
}
