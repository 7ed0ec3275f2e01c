//! From limits of tool and joints to bounds on speed, acceleration and jerk along the path, interval by interval.
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
//! each joint has its own bound here and the least counts.) For a scan with S-profiles the admissible set is narrowed to
//! a box `v <= V, |a| <= A, |j| <= J` on every interval that satisfies all rows with every sign.

use arcfeed_feedrate::{FeedError, Quantity, RowSource, Segment, caps};
use arcfeed_geometry::{PoseJet, PosePath};
use arcfeed_kinematics::{JointLimits, Joints, Twist};
use nalgebra::Vector3;

use crate::joint_path::{JointJet, JointPath};
use crate::limits::ToolLimits;
use crate::torque::{TorquePath, TorqueReach};

/// How the rows that couple speed, acceleration and jerk are shared out between them, as fractions of each joint's
/// limit. What one of them leaves unused goes to the others.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shares {
    /// Of a joint's acceleration limit, for the tangential acceleration.
    pub acceleration: f64,
    /// Of a joint's jerk limit, for the tangential jerk.
    pub jerk: f64,
    /// Of what is left of the jerk limit then, for the speed alone.
    pub speed: f64,
}

/// Everything that bounds the speed along a path.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Bounds<'a, const N: usize> {
    pub tool: &'a ToolLimits,
    pub joints: &'a JointLimits<N>,
    /// Chord error between two control cycles, m.
    pub chord: f64,
    /// Control period, s.
    pub period: f64,
    pub shares: Shares,
    /// Fraction of every limit that is used (1, or a little less when a check asks for it).
    pub scale: f64,
    /// Programmed feed on every interval, m/s.
    pub feeds: &'a [f64],
    pub torque: Option<&'a TorquePath<N>>,
    /// Speeds at both ends of the path, m/s.
    pub ends: [f64; 2],
}

impl<const N: usize> Bounds<'_, N> {
    /// Highest programmed feed on either side of grid point `i`.
    fn feed_around(&self, i: usize) -> f64 {
        let at = |k: Option<usize>| k.and_then(|k| self.feeds.get(k)).copied().unwrap_or(0.0);
        at(i.checked_sub(1)).max(at(Some(i)))
    }
}

/// Bounds of the path's derivatives on every interval: what the boxes are made from, once for a path.
#[derive(Debug, Clone)]
pub(crate) struct Reaches<const N: usize> {
    intervals: Vec<Reach<N>>,
    /// Jump of `q''` at every grid point.
    steps: Vec<Joints<N>>,
}

impl<const N: usize> Reaches<N> {
    /// At the grid points `stops` the tool stands, so that a jump of the derivatives there needs no bound.
    pub fn of(path: &PosePath, joints: &JointPath<N>, stops: &[usize]) -> Self {
        let mut steps = acceleration_steps(joints);
        for &i in stops {
            steps[i] = Joints::zeros();
        }
        let intervals = (0..joints.intervals())
            .map(|i| {
                let (start, end) = joints.interval(i);
                Reach::of(path, start, end)
            })
            .collect();
        Self { intervals, steps }
    }

    /// The highest speed that chord error, normal acceleration and normal jerk allow at each grid point, so that between two
    /// points the square of the speed may lie on the straight line through both.
    pub fn tool_speeds(&self, bounds: &Bounds<'_, N>) -> Vec<f64> {
        self.point_speeds(bounds, |reach| reach.bends.map(|kappa| bend_speed(kappa, bounds)))
    }

    /// The same for the angular speed of the tool, where that is limited.
    pub fn turn_speeds(&self, bounds: &Bounds<'_, N>) -> Option<Vec<f64>> {
        let limit = bounds.tool.angular_speed? * bounds.scale;
        Some(self.point_speeds(bounds, |reach| reach.turns.map(|rate| limit / rate)))
    }

    /// Speeds at the grid points from those at three places of every interval.
    fn point_speeds(&self, bounds: &Bounds<'_, N>, at: impl Fn(&Reach<N>) -> [f64; 3]) -> Vec<f64> {
        let mut squares = vec![f64::INFINITY; self.intervals.len() + 1];
        for (k, reach) in self.intervals.iter().enumerate() {
            let feed = bounds.feed_around(k).max(bounds.feed_around(k + 1));
            let [start, middle, end] = at(reach).map(|v| v.min(feed).powi(2));
            let sag = (middle / (0.5 * (start + end))).min(1.0);
            squares[k] = squares[k].min(sag * start);
            squares[k + 1] = squares[k + 1].min(sag * end);
        }
        squares.into_iter().map(f64::sqrt).collect()
    }

    /// The first grid point at which the joints' accelerations have to step while the tool does not stand.
    pub fn first_step(&self) -> Option<usize> {
        self.steps.iter().position(|step| step.amax() > 0.0)
    }

    /// One box per interval, safe anywhere inside it.
    pub fn boxes(&self, bounds: &Bounds<'_, N>) -> Result<Vec<Segment>, FeedError> {
        let boxes = self.intervals.iter().zip(self.steps.windows(2)).enumerate().map(|(k, (reach, steps))| {
            let step = steps[0].zip_map(&steps[1], f64::max);
            let (v, a, j) = one_box(reach, &step, bounds.feeds[k], bounds);
            let (v, a) = match bounds.torque {
                Some(torque) => {
                    let held = torque.reach(k);
                    if let Some(joint) = (0..N).find(|&j| held.constant[j] >= held.limits[j]) {
                        let row = RowSource::joint(Quantity::JointTorque, joint);
                        let (value, limit) = (held.constant[joint], held.limits[joint]);
                        return Err(FeedError::StaticallyInfeasible { index: k, s: reach.start, row, value, limit });
                    }
                    within_torque(&held, v, a, bounds)
                }
                None => (v, a),
            };
            Segment::new(reach.length, v, a, j)
        });
        boxes.collect()
    }
}

/// Where the curvature of the joint path jumps (a path that is only tangent-continuous), joint acceleration steps by
/// `|jump of q''| v^2`. No jerk limit can allow that in zero time, so it is spread over one control period. Returns the
/// jump at every grid point, zero where there is none.
fn acceleration_steps<const N: usize>(joints: &JointPath<N>) -> Vec<Joints<N>> {
    (0..joints.nodes().len())
        .map(|i| {
            let (left, right) = joints.sides(i);
            let jump = (right.d2 - left.d2).abs();
            let size = left.d2.abs().zip_map(&right.d2.abs(), f64::max);
            // Below this it is rounding.
            jump.zip_map(&size, |j, s| if j > 1e-7 * (s + 1.0) { j } else { 0.0 })
        })
        .collect()
}

/// Bounds of the path's derivatives on one interval.
#[derive(Debug, Clone)]
struct Reach<const N: usize> {
    /// Arc length where it begins.
    start: f64,
    length: f64,
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

impl<const N: usize> Reach<N> {
    fn of(path: &PosePath, start: &JointJet<N>, end: &JointJet<N>) -> Self {
        let h = end.s - start.s;
        let inset = 1e-9 * h;
        let tool = [start.s + inset, start.s + 0.5 * h, end.s - inset].map(|s| path.jet(s));
        let misfit = Misfit::of(&tool, h);
        // Values and slopes at both ends give a cubic; its Bernstein coefficients enclose it.
        let enclose = |f0: f64, g0: f64, f1: f64, g1: f64| {
            f0.abs().max((f0 + h * g0 / 3.0).abs()).max((f1 - h * g1 / 3.0).abs()).max(f1.abs())
        };
        let d1 = Joints::<N>::from_fn(|k, _| enclose(start.d1[k], start.d2[k], end.d1[k], end.d2[k]));
        let d2 = Joints::<N>::from_fn(|k, _| {
            enclose(start.d2[k], start.d3[k], end.d2[k], end.d3[k]) * (1.0 + misfit.second)
        });
        // Of the third derivative only the ends are known: a margin for what lies between.
        let d3 = Joints::<N>::from_fn(|k, _| {
            let (a, b) = (start.d3[k], end.d3[k]);
            a.abs().max(b.abs()) * (1.0 + misfit.third) + 0.15 * (b - a).abs()
        });
        let bends = tool.map(|jet| linear(&jet.d2).norm());
        let [c0, _, c1] = tool.map(|jet| (linear(&jet.d2), linear(&jet.d3)));
        let curvature = c0.0.norm().max((c0.0 + c0.1 * (h / 3.0)).norm()).max((c1.0 - c1.1 * (h / 3.0)).norm());
        let curvature = curvature.max(c1.0.norm()) * (1.0 + misfit.second);
        let turns = tool.map(|jet| angular(&jet.d1).norm());
        let [first, _, last] = tool.map(|jet| (angular(&jet.d1), angular(&jet.d2)));
        // As for the joints: a cubic through values and slopes at both ends.
        let inner = [first.0 + first.1 * (h / 3.0), last.0 - last.1 * (h / 3.0)];
        let turning = inner
            .iter()
            .fold(turns.iter().fold(0.0, |most: f64, turn| most.max(*turn)), |most, turn| most.max(turn.norm()));
        Self { start: start.s, length: h, d1, d2, d3, curvature, bends, turning, turns }
    }
}

/// How much the tool path's derivatives in the middle of an interval differ from what its ends foretell, relative to
/// their size: by so much more than their ends say derivatives may reach in between.
struct Misfit {
    second: f64,
    third: f64,
}

/// The peak between two points where a misfit was measured in the middle is higher than the middle, if a little.
const PEAK: f64 = 1.25;

impl Misfit {
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

/// The highest speed that chord error, normal acceleration and normal jerk allow at the curvature `kappa`.
fn bend_speed<const N: usize>(kappa: f64, bounds: &Bounds<'_, N>) -> f64 {
    let (tool, scale) = (bounds.tool, bounds.scale);
    let v = caps::chord_error_speed(kappa, bounds.chord * scale, bounds.period)
        .min(caps::normal_acceleration_speed(kappa, tool.normal_acceleration * scale));
    match tool.normal_jerk {
        Some(jerk) => v.min(caps::normal_jerk_speed(kappa, jerk * scale)),
        None => v,
    }
}

/// Speed and acceleration narrowed so far that the torque keeps its limits with every sign of its terms.
fn within_torque<const N: usize>(reach: &TorqueReach<N>, v: f64, a: f64, bounds: &Bounds<'_, N>) -> (f64, f64) {
    let (mut v, mut a) = (v, a);
    let room = (reach.limits - reach.constant) * bounds.scale;
    for k in 0..N {
        if reach.inertia[k] > 0.0 {
            a = a.min(bounds.shares.acceleration * room[k] / reach.inertia[k]);
        }
    }
    for k in 0..N {
        // velocity v^2 + viscous v <= rest, solved without cancellation.
        let (p, c, rest) = (reach.velocity[k], reach.viscous[k], room[k] - reach.inertia[k] * a);
        if rest.is_finite() && (p > 0.0 || c > 0.0) {
            v = v.min(2.0 * rest / (c + (c * c + 4.0 * p * rest.max(0.0)).sqrt()));
        }
    }
    (v, a)
}

fn one_box<const N: usize>(reach: &Reach<N>, step: &Joints<N>, feed: f64, bounds: &Bounds<'_, N>) -> (f64, f64, f64) {
    let (tool, joints, scale) = (bounds.tool, bounds.joints, bounds.scale);
    let mut v = bend_speed(reach.curvature, bounds).min(feed * scale);
    if let Some(limit) = tool.angular_speed {
        v = v.min(limit * scale / reach.turning);
    }
    let mut a = tool.tangential_acceleration * scale;
    let mut j = tool.tangential_jerk * scale;
    // First what acceleration and jerk may use at most, then the speed from what is left, then both again.
    for k in 0..N {
        let d1 = reach.d1[k];
        if d1 > 0.0 {
            v = v.min(joints.velocity()[k] * scale / d1);
            a = a.min(bounds.shares.acceleration * joints.acceleration()[k] * scale / d1);
            j = j.min(bounds.shares.jerk * joints.jerk()[k] * scale / d1);
        }
    }
    let mut left = Joints::<N>::zeros();
    for k in 0..N {
        let (d1, d2, d3) = (reach.d1[k], reach.d2[k], reach.d3[k]);
        left[k] = joints.jerk()[k] * scale - d1 * j;
        if d2 > 0.0 {
            v = v.min(((joints.acceleration()[k] * scale - d1 * a) / d2).sqrt());
        }
        if d3 > 0.0 {
            v = v.min((bounds.shares.speed * left[k] / d3).cbrt());
        }
        if step[k] > 0.0 {
            // Half of what the speed's own share leaves, so that something is kept for the acceleration.
            let share = 0.5 * (1.0 - bounds.shares.speed);
            v = v.min((share * left[k] * bounds.period / step[k]).sqrt());
        }
    }
    for k in 0..N {
        let cross = 3.0 * reach.d2[k] * v;
        if cross > 0.0 {
            let spent = reach.d3[k] * v * v * v + step[k] * v * v / bounds.period;
            a = a.min((left[k] - spent) / cross);
        }
    }
    (v, a, j)
}
