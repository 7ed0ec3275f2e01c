//! Bounds of a path's derivatives on every interval of a grid: what its limits are made from, once for a path.
//!
//! At a place with joint derivatives `q', q'', q'''` and tool curvature `kappa` a motion `(v, a, j)` along the path means
//!
//! ```text
//! joint velocity      q' v
//! joint acceleration  q' a + q'' v^2
//! joint jerk          q' j + 3 q'' v a + q''' v^3
//! normal acceleration kappa v^2
//! ```
//!
//! (Liu et al. 2023, eqs. 21-24, corrected: the print divides vectors by vectors and drops the sign of the second term;
//! each joint has its own bound here and the least counts.)

use arcfeed_feedrate::caps;
use arcfeed_geometry::PoseJet;
use arcfeed_kinematics::{Joints, Twist};
use nalgebra::Vector3;

use super::jumps::{Jump, SPREAD, near_jumps};
use crate::path::{JointJet, JointPath, MotionPath};

/// Bounds of the derivatives of joints and tool on every interval.
#[derive(Debug, Clone)]
pub(crate) struct DerivativeBounds<const N: usize> {
    intervals: Vec<IntervalDerivatives<N>>,
    /// Jumps of `q''` that an interval is near to, added up.
    jumps: Vec<Joints<N>>,
}

impl<const N: usize> DerivativeBounds<N> {
    /// With the jumps of the second derivatives in motion.
    pub fn of(path: &dyn MotionPath<N>, joints: &JointPath<N>, jumps: &[Jump<N>]) -> Self {
        let intervals = (0..joints.intervals())
            .map(|i| {
                let (start, end) = joints.interval(i);
                IntervalDerivatives::of(path, start, end)
            })
            .collect();
        Self { intervals, jumps: near_jumps(joints, jumps) }
    }

    /// Magnitudes of first, second and third joint derivatives, joint by joint, interval by interval.
    pub fn joints(&self) -> [Vec<f64>; 3] {
        let flat = |of: fn(&IntervalDerivatives<N>) -> &Joints<N>| -> Vec<f64> {
            let mut values = Vec::with_capacity(N * self.intervals.len());
            self.intervals.iter().for_each(|interval| values.extend_from_slice(of(interval).as_slice()));
            values
        };
        [flat(|interval| &interval.d1), flat(|interval| &interval.d2), flat(|interval| &interval.d3)]
    }

    /// Jumps of the second joint derivatives, joint by joint, interval by interval, spread over `period` (s).
    pub fn steps(&self, period: f64) -> Vec<f64> {
        self.jumps.iter().flat_map(|jumps| jumps.iter().map(|jump| jump * SPREAD / period)).collect()
    }

    /// The highest speed at grid point `i` at which the step of acceleration takes no more than the limit `jerk` of any joint over
    /// `period` (s), and that joint; infinite away from jumps.
    pub fn step_speed(&self, i: usize, jerk: &Joints<N>, period: f64) -> (f64, usize) {
        let near = self.jumps[i.saturating_sub(1)..(i + 1).min(self.jumps.len())].iter();
        let each = near.flat_map(|jumps| (0..N).map(move |j| (jerk[j] * period / (jumps[j] * SPREAD), j)));
        let (square, joint) = each.fold((f64::INFINITY, 0), |least, one| if one.0 < least.0 { one } else { least });
        (square.sqrt(), joint)
    }

    /// The highest speed that `at_curvature` allows at each grid point, so that between two points the square of the speed may lie on
    /// the straight line through both; and on each interval. No speed above `feeds` is asked for.
    pub fn bend_speeds(&self, feeds: &[f64], at_curvature: impl Fn(f64) -> f64) -> [Vec<f64>; 2] {
        let at_points = self.point_speeds(feeds, |interval| interval.bends.map(&at_curvature));
        [at_points, self.intervals.iter().map(|interval| at_curvature(interval.curvature)).collect()]
    }

    /// The same for a limit on the angular speed of the tool (rad/s).
    pub fn turn_speeds(&self, feeds: &[f64], limit: f64) -> [Vec<f64>; 2] {
        let at_points = self.point_speeds(feeds, |interval| interval.turns.map(|rate| limit / rate));
        [at_points, self.intervals.iter().map(|interval| limit / interval.turning).collect()]
    }

    /// Speeds at the grid points from those at three places of every interval.
    fn point_speeds(&self, feeds: &[f64], at: impl Fn(&IntervalDerivatives<N>) -> [f64; 3]) -> Vec<f64> {
        let feed_around = |i: usize| {
            if feeds.is_empty() {
                return f64::INFINITY;
            }
            let at = |k: Option<usize>| k.and_then(|k| feeds.get(k)).copied().unwrap_or(0.0);
            at(i.checked_sub(1)).max(at(Some(i)))
        };
        let mut squares = vec![f64::INFINITY; self.intervals.len() + 1];
        for (k, interval) in self.intervals.iter().enumerate() {
            let feed = feed_around(k).max(feed_around(k + 1));
            let [start, middle, end] = at(interval).map(|v| v.min(feed).powi(2));
            let sag = (middle / (0.5 * (start + end))).min(1.0);
            squares[k] = squares[k].min(sag * start);
            squares[k + 1] = squares[k + 1].min(sag * end);
        }
        squares.into_iter().map(f64::sqrt).collect()
    }
}

/// Bounds of the path's derivatives on one interval.
#[derive(Debug, Clone)]
struct IntervalDerivatives<const N: usize> {
    d1: Joints<N>,
    d2: Joints<N>,
    d3: Joints<N>,
    curvature: f64,
    /// Curvature at the start, in the middle and at the end.
    bends: [f64; 3],
    /// Angle that the tool turns by per length, rad/m: the most, and at the start, in the middle and at the end.
    turning: f64,
    turns: [f64; 3],
}

impl<const N: usize> IntervalDerivatives<N> {
    fn of(path: &dyn MotionPath<N>, start: &JointJet<N>, end: &JointJet<N>) -> Self {
        let h = end.s - start.s;
        let inset = 1e-9 * h;
        let [a, m, b] = [start.s + inset, start.s + 0.5 * h, end.s - inset].map(|s| path.tool(s));
        // Without a tool that is prescribed the joints are a spline, which the cubics below reproduce.
        let tool = a.zip(m).zip(b).map(|((a, m), b)| [a, m, b]);
        let error =
            tool.as_ref().map_or(InterpolationError { second: 0.0, third: 0.0 }, |t| InterpolationError::of(t, h));
        // Values and slopes at both ends give a cubic; its Bernstein coefficients enclose it.
        let enclose = |f0: f64, g0: f64, f1: f64, g1: f64| {
            f0.abs().max((f0 + h * g0 / 3.0).abs()).max((f1 - h * g1 / 3.0).abs()).max(f1.abs())
        };
        let d1 = Joints::<N>::from_fn(|k, _| enclose(start.d1[k], start.d2[k], end.d1[k], end.d2[k]));
        let d2 =
            Joints::<N>::from_fn(|k, _| enclose(start.d2[k], start.d3[k], end.d2[k], end.d3[k]) * (1.0 + error.second));
        // Of the third derivative only the ends are known: a margin for what lies between.
        let d3 = Joints::<N>::from_fn(|k, _| {
            let (a, b) = (start.d3[k], end.d3[k]);
            a.abs().max(b.abs()) * (1.0 + error.third) + 0.15 * (b - a).abs()
        });
        let Some(tool) = tool else {
            return Self { d1, d2, d3, curvature: 0.0, bends: [0.0; 3], turning: 0.0, turns: [0.0; 3] };
        };
        let bends = tool.map(|jet| linear(&jet.d2).norm());
        let [c0, _, c1] = tool.map(|jet| (linear(&jet.d2), linear(&jet.d3)));
        let curvature = c0.0.norm().max((c0.0 + c0.1 * (h / 3.0)).norm()).max((c1.0 - c1.1 * (h / 3.0)).norm());
        let curvature = curvature.max(c1.0.norm()) * (1.0 + error.second);
        let turns = tool.map(|jet| angular(&jet.d1).norm());
        let [first, _, last] = tool.map(|jet| (angular(&jet.d1), angular(&jet.d2)));
        // As for the joints: a cubic through values and slopes at both ends.
        let inner = [first.0 + first.1 * (h / 3.0), last.0 - last.1 * (h / 3.0)];
        let turning = inner
            .iter()
            .fold(turns.iter().fold(0.0, |most: f64, turn| most.max(*turn)), |most, turn| most.max(turn.norm()));
        Self { d1, d2, d3, curvature, bends, turning, turns }
    }
}

/// Difference of the tool path's derivatives in the middle of an interval from what its ends foretell, relative to
/// their size: by so much more than their ends say derivatives may reach in between.
struct InterpolationError {
    second: f64,
    third: f64,
}

/// The peak between two points where a misfit was measured in the middle is higher than the middle, if a little.
const PEAK: f64 = 1.25;

impl InterpolationError {
    fn of(tool: &[PoseJet; 3], h: f64) -> Self {
        let [a, m, b] = tool;
        let relative = |part: fn(&Twist) -> Vector3<f64>| {
            let second = part(&m.d2) - (part(&a.d2) + part(&b.d2)) * 0.5 - (part(&a.d3) - part(&b.d3)) * (h / 8.0);
            let third = part(&m.d3) - (part(&a.d3) + part(&b.d3)) * 0.5;
            let size = |f: fn(&PoseJet) -> Twist| part(&f(a)).norm().max(part(&f(b)).norm());
            let over = |x: f64, size: f64| if x > 0.0 { PEAK * x / size.max(f64::MIN_POSITIVE) } else { 0.0 };
            // A derivative that is rounding is no measure of anything: it counts against the one below it.
            let (s2, s3) = (size(|jet| jet.d2), size(|jet| jet.d3));
            (over(second.norm(), s2.max(1e-6 * h * s3)), over(third.norm(), s3.max(1e-6 * s2 / h)))
        };
        let (by_shift, by_turn) = (relative(linear), relative(angular));
        Self { second: by_shift.0.max(by_turn.0).min(1.0), third: by_shift.1.max(by_turn.1).min(1.0) }
    }
}

fn linear(twist: &Twist) -> Vector3<f64> {
    twist.fixed_rows::<3>(0).into_owned()
}

fn angular(twist: &Twist) -> Vector3<f64> {
    twist.fixed_rows::<3>(3).into_owned()
}

/// The bounds of the speed of the tool in a bend.
#[derive(Debug, Clone, Copy)]
pub(crate) struct BendLimits {
    /// Chord error, m, over one control period, s.
    pub chord: f64,
    pub period: f64,
    /// Normal acceleration, m/s^2, and normal jerk, m/s^3, where they are limited.
    pub normal_acceleration: Option<f64>,
    pub normal_jerk: Option<f64>,
}

impl BendLimits {
    /// The highest speed at the curvature `kappa` (1/m), m/s.
    pub fn speed(&self, kappa: f64) -> f64 {
        let by =
            |limit: Option<f64>, speed: fn(f64, f64) -> f64| limit.map_or(f64::INFINITY, |limit| speed(kappa, limit));
        caps::chord_error_speed(kappa, self.chord, self.period)
            .min(by(self.normal_acceleration, caps::normal_acceleration_speed))
            .min(by(self.normal_jerk, caps::normal_jerk_speed))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Isometry3;

    /// A tool of which one component has the second derivative `x^power` and its derivative, over a length of 2.
    fn tool(power: i32, component: usize) -> [PoseJet; 3] {
        [0.0, 1.0, 2.0].map(|x: f64| {
            let of = |value: f64| Twist::from_fn(|k, _| if k == component { value } else { 0.0 });
            let (d2, d3) = (of(x.powi(power)), of(f64::from(power) * x.powi(power - 1)));
            PoseJet { pose: Isometry3::identity(), d1: Twist::zeros(), d2, d3 }
        })
    }

    /// Of a cubic second derivative both ends say all; of `x^4` it is 1 in the middle of 0 and 16, where they say 0, and of its
    /// derivative 4 in the middle of 0 and 32, where they say 16.
    #[test]
    fn the_error_is_what_the_middle_differs_from_the_ends_by() {
        for component in [1, 4] {
            let cubic = InterpolationError::of(&tool(3, component), 2.0);
            assert!(cubic.second < 1e-12, "{}", cubic.second);
            let quartic = InterpolationError::of(&tool(4, component), 2.0);
            assert!((quartic.second - PEAK / 16.0).abs() < 1e-12, "{}", quartic.second);
            assert!((quartic.third - PEAK * 12.0 / 32.0).abs() < 1e-12, "{}", quartic.third);
        }
    }
}
