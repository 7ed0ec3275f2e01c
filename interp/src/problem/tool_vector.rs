//! Limits on the magnitude of the tool's acceleration and of its jerk, as rows.
//!
//! With derivatives `p', p'', p'''` of the tool point by the parameter a motion means
//!
//! ```text
//! acceleration  p' u + p'' x
//! jerk          (p' w + 3 p'' u + p''' x) sqrt(x)
//! ```
//!
//! Along the direction of the path and across it the acceleration has two components, of which the second has one sign. Its magnitude is
//! limited by a polygon of 16 corners inside the circle, two of them where there is one component alone: what lies between loses 1.9 %
//! of the limit at the most. Jerk has a third component off the plane of the path, a function of the speed alone: the polygon of the
//! other two shrinks with it along five straight lines in `x`, so that 3.4 % are lost at the most, and 1.9 % on plane paths.

use arcfeed_feedrate::constraint::{PathConstraint, Place, RowSink, Within};
use arcfeed_feedrate::{IntervalBound, JerkRow, LimitId, Quantity, Row};
use arcfeed_kinematics::{ForwardKinematics, Joints};
use nalgebra::Vector3;

use super::jumps::{Jump, SPREAD, intervals_near};
use crate::path::{JointJet, JointPath};

/// Corners of a polygon on a quarter of its circle, and the angle from a corner to the middle of a side.
const QUARTER: usize = 4;
const HALF_SIDE: f64 = std::f64::consts::FRAC_PI_2 / (2 * QUARTER) as f64;
/// The part of the plane that a component off it leaves, sqrt(1 - y^3), is taken as straight between these values of `y`; each line
/// loses 1.5 % of the limit at the most.
const STEPS: [f64; 6] = [0.0, 0.4221, 0.6706, 0.8486, 0.9609, 1.0];
/// For the third derivative the joints move so far, rad.
const APART: f64 = 1e-4;

/// Derivatives of the tool point by the parameter at one place.
#[derive(Debug, Clone, Copy)]
struct PointJet {
    d1: Vector3<f64>,
    d2: Vector3<f64>,
    d3: Vector3<f64>,
}

impl PointJet {
    fn of<const N: usize>(arm: &dyn ForwardKinematics<N>, jet: &JointJet<N>) -> Self {
        let both = |jet: &JointJet<N>| {
            let configuration = arm.configuration(&jet.q);
            let jacobian = configuration.jacobian();
            let d1 = (jacobian * jet.d1).fixed_rows::<3>(0).into_owned();
            let d2 = jacobian * jet.d2 + configuration.acceleration_bias(&jet.d1);
            [d1, d2.fixed_rows::<3>(0).into_owned()]
        };
        let [d1, d2] = both(jet);
        // A third derivative in closed form would need the second of the Jacobian.
        let h = APART / jet.d1.amax().max(f64::MIN_POSITIVE);
        let [back, ahead] = [-h, h].map(|h| both(&jet.shifted(h))[1]);
        let d3 = (ahead - back) / (2.0 * h);
        Self { d1, d2, d3: if d3.iter().all(|v| v.is_finite()) { d3 } else { Vector3::zeros() } }
    }

    /// Components along the path and across it: of the first derivative, and the two of the second.
    fn components(&self) -> [f64; 3] {
        let rate = self.d1.norm();
        let Some(along) = self.d1.try_normalize(0.0) else { return [0.0, 0.0, self.d2.norm()] };
        let tangential = self.d2.dot(&along);
        [rate, tangential, (self.d2 - along * tangential).norm()]
    }
}

/// Derivatives of the tool point along a path.
#[derive(Debug, Clone)]
pub(crate) struct ToolVectors {
    after: Vec<PointJet>,
    before: Vec<PointJet>,
    /// In the middle of every interval; empty where they are not looked at.
    middles: Vec<PointJet>,
    /// Grid points, but the corners, at which the second derivatives jump.
    jumps: Vec<bool>,
    /// Jumps that every interval is near to, added up.
    near: Vec<f64>,
    /// The greatest speed along the path on every interval.
    fastest: Vec<f64>,
}

impl ToolVectors {
    /// With the `jumps` of the second derivatives in motion, and the greatest speeds on the intervals.
    pub fn of<const N: usize>(
        arm: &dyn ForwardKinematics<N>,
        (joints, middles): (&JointPath<N>, &[JointJet<N>]),
        jumps: &[Jump<N>],
        fastest: Vec<f64>,
    ) -> Self {
        let sides = |i: usize| joints.sides(i);
        let of = |jet: &JointJet<N>| PointJet::of(arm, jet);
        let points = joints.nodes().len();
        let after: Vec<PointJet> = (0..points).map(|i| of(sides(i).1)).collect();
        let same = |a: &Joints<N>, b: &Joints<N>| (a - b).amax() <= 1e-7 * (1.0 + a.amax());
        let before = (0..points)
            .map(|i| {
                let (left, right) = sides(i);
                if left == right { after[i] } else { of(left) }
            })
            .collect::<Vec<_>>();
        let jumps_at = (0..points)
            .map(|i| {
                let (left, right) = sides(i);
                same(&left.d1, &right.d1) && !same(&left.d2, &right.d2)
            })
            .collect();
        let mut near = vec![0.0; joints.intervals()];
        for jump in jumps {
            let size = (after[jump.at].d2 - before[jump.at].d2).norm();
            intervals_near(joints, jump).for_each(|k| near[k] += size);
        }
        Self { after, before, middles: middles.iter().map(of).collect(), jumps: jumps_at, near, fastest }
    }

    /// A limit (m/s^2) on the magnitude of the acceleration.
    pub fn acceleration(&self, limit: f64) -> ToolAcceleration<'_> {
        ToolAcceleration { vectors: self, limit }
    }

    /// A limit (m/s^3) on the magnitude of the jerk, of which rows keep the part `margin` back; jumps of the acceleration are spread over
    /// `period` (s).
    pub fn jerk(&self, limit: f64, margin: f64, period: f64) -> ToolJerk<'_> {
        let frames: Vec<Frame> = (0..self.middles.len()).map(|k| self.frame(k, limit)).collect();
        // As many lines as the component off the plane can reach.
        let reached =
            |k: usize| if frames[k].off_plane == 0.0 { 0.0 } else { frames[k].off_plane * self.fastest[k].powi(2) };
        let most = (0..frames.len()).map(reached).fold(0.0, f64::max);
        let lines = STEPS.iter().skip(1).position(|y| *y >= most).map_or(STEPS.len() - 1, |last| last + 1);
        ToolJerk { vectors: self, frames, lines, limit, of_rows: 1.0 - margin, period }
    }

    fn three(&self, k: usize) -> [&PointJet; 3] {
        let (start, end) = (&self.after[k], &self.before[k + 1]);
        [start, self.middles.get(k).unwrap_or(start), end]
    }

    /// The plane of the path in the middle of interval `k`, under a limit on the jerk (m/s^3).
    fn frame(&self, k: usize, limit: f64) -> Frame {
        let three = self.three(k);
        let PointJet { d1, d2, d3 } = *three[1];
        let along = d1.try_normalize(0.0).unwrap_or_else(Vector3::x);
        // Across the path, in the plane of its curvature; where it is straight, in that in which it begins to bend.
        let off = |v: &Vector3<f64>| v - along * v.dot(&along);
        let across = (off(&d2) + off(&d3) * APART).try_normalize(f64::MIN_POSITIVE.sqrt());
        let across = across.or_else(|| off(&least_axis(&along)).try_normalize(0.0)).unwrap_or_else(Vector3::y);
        let normal = along.cross(&across);
        let off_plane = three.iter().map(|jet| jet.d3.dot(&normal).abs()).fold(0.0, f64::max);
        let off_plane = (off_plane / limit).powf(2.0 / 3.0);
        Frame { along, across, off_plane }
    }
}

/// The axis of the base that a direction is farthest from.
fn least_axis(direction: &Vector3<f64>) -> Vector3<f64> {
    let mut axis = Vector3::zeros();
    axis[direction.iamin()] = 1.0;
    axis
}

/// The plane of the path on an interval, and `y / x`: off the plane, `y^(3/2)` of the limit on the jerk is used.
#[derive(Debug, Clone, Copy)]
struct Frame {
    along: Vector3<f64>,
    across: Vector3<f64>,
    off_plane: f64,
}

/// `|p' u + p'' x| <= limit`.
#[derive(Debug)]
pub(crate) struct ToolAcceleration<'a> {
    vectors: &'a ToolVectors,
    limit: f64,
}

impl ToolAcceleration<'_> {
    fn push(&self, jet: &PointJet, out: &mut RowSink<'_>) {
        let [rate, tangential, normal] = jet.components();
        let limit = self.limit * HALF_SIDE.cos();
        for side in 0..QUARTER {
            let (sin, cos) = ((2 * side + 1) as f64 * HALF_SIDE).sin_cos();
            for cos in [cos, -cos] {
                // The other bound of each row follows from the row beside it.
                let (a, b) = (cos * rate, cos * tangential + sin * normal);
                out.row(Row::symmetric(a, b, limit, LimitId::path(Quantity::ToolAcceleration)));
            }
        }
    }
}

impl PathConstraint for ToolAcceleration<'_> {
    fn points(&self) -> Option<usize> {
        Some(self.vectors.after.len())
    }

    fn rows(&self, place: Place, out: &mut RowSink<'_>) {
        match place {
            Place::Point(i) => {
                self.push(&self.vectors.after[i], out);
                if self.vectors.jumps[i] {
                    self.push(&self.vectors.before[i], out);
                }
            }
            Place::Middle { k, .. } => self.push(&self.vectors.middles[k], out),
        }
    }

    fn interval_bounds(&self, k: usize, _h: f64, out: &mut Vec<IntervalBound>) {
        let three = self.vectors.three(k);
        let [a, b] = [most(three.map(|jet| jet.d1.norm())), most(three.map(|jet| jet.d2.norm()))];
        let (limit, source) = (self.limit, LimitId::path(Quantity::ToolAcceleration));
        out.push(IntervalBound::Acceleration { a, b, c: 0.0, rest: 0.0, limit, source });
    }
}

/// The greatest Bernstein coefficient of the parabola through three values.
fn most([p, m, q]: [f64; 3]) -> f64 {
    p.max(q).max(2.0 * m - 0.5 * (p + q))
}

/// `|(p' w + 3 p'' u + p''' x) sqrt(x)| <= limit`.
#[derive(Debug)]
pub(crate) struct ToolJerk<'a> {
    vectors: &'a ToolVectors,
    frames: Vec<Frame>,
    /// Lines along which the part in the plane shrinks with the part off it.
    lines: usize,
    limit: f64,
    of_rows: f64,
    period: f64,
}

impl ToolJerk<'_> {
    fn jump(&self, k: usize) -> f64 {
        self.vectors.near[k] * SPREAD / self.period
    }
}

impl PathConstraint for ToolJerk<'_> {
    fn points(&self) -> Option<usize> {
        Some(self.vectors.after.len())
    }

    fn rows(&self, _place: Place, _out: &mut RowSink<'_>) {}

    fn jerk_rows(&self, k: usize, _h: f64, within: Within, out: &mut Vec<JerkRow>) {
        let (jet, frame) = (self.vectors.three(k)[within as usize], &self.frames[k]);
        let plane = |v: &Vector3<f64>| [v.dot(&frame.along), v.dot(&frame.across)];
        let terms = [plane(&jet.d1), plane(&jet.d2).map(|v| 3.0 * v), plane(&jet.d3)];
        let inner = HALF_SIDE.cos() * self.limit;
        let left = |y: f64| (1.0 - y.powi(3)).max(0.0).sqrt();
        for ends in STEPS.windows(2).take(self.lines) {
            let slope = (left(ends[0]) - left(ends[1])) / (ends[1] - ends[0]);
            let limit = self.of_rows * inner * (left(ends[0]) + slope * ends[0]);
            let fall = self.jump(k) + inner * slope * frame.off_plane;
            for side in 0..2 * QUARTER {
                let (sin, cos) = ((2 * side + 1) as f64 * HALF_SIDE).sin_cos();
                let [alpha, beta, gamma] = terms.map(|[along, across]| cos * along + sin * across);
                let source = LimitId::path(Quantity::ToolJerk);
                out.push(JerkRow { alpha, beta, gamma, step: fall, limit, source });
            }
        }
    }

    fn interval_bounds(&self, k: usize, _h: f64, out: &mut Vec<IntervalBound>) {
        let three = self.vectors.three(k);
        let of = |of: fn(&PointJet) -> &Vector3<f64>| most(three.map(|jet| of(jet).norm()));
        let (alpha, beta, gamma) = (of(|jet| &jet.d1), 3.0 * of(|jet| &jet.d2), of(|jet| &jet.d3));
        let (step, limit, source) = (self.jump(k), self.limit, LimitId::path(Quantity::ToolJerk));
        out.push(IntervalBound::Jerk { alpha, beta, gamma, step, limit, source });
    }
}

#[cfg(test)]
mod tests {
    use arcfeed_testing::Random;

    use super::*;

    fn jets(jet: PointJet, fastest: f64) -> ToolVectors {
        let two = vec![jet; 2];
        ToolVectors {
            after: two.clone(),
            before: two,
            middles: vec![jet],
            jumps: vec![false; 2],
            near: vec![0.0],
            fastest: vec![fastest],
        }
    }

    fn vector(random: &mut Random, size: f64) -> Vector3<f64> {
        Vector3::from_fn(|_, _| size * random.signed())
    }

    /// How far a motion may grow before a row holds it back, in units of the limit on the magnitude: the least and the most of all.
    fn kept(seed: u64, of: impl Fn(&mut Random) -> f64) -> [f64; 2] {
        let mut random = Random::new(seed);
        (0..20_000)
            .map(|_| of(&mut random))
            .fold([f64::INFINITY, 0.0], |[low, high], kept| [low.min(kept), high.max(kept)])
    }

    #[test]
    fn acceleration_rows_lie_inside_the_circle_and_lose_two_percent_at_most() {
        let [low, high] = kept(5, |random| {
            let jet = PointJet { d1: vector(random, 1.0), d2: vector(random, 5.0), d3: Vector3::zeros() };
            let vectors = jets(jet, 1.0);
            let (mut rows, limit) = (Vec::new(), 2.0);
            let constraint = vectors.acceleration(limit);
            collect(&constraint, &mut rows);
            let (u, x) = (random.signed() * 4.0, random.unit());
            // Rows and magnitude grow alike.
            let used = rows.iter().map(|row| row.value(u, x).abs() / row.hi).fold(0.0, f64::max);
            (jet.d1 * u + jet.d2 * x).norm() / limit / used
        });
        assert!(high <= 1.0 + 1e-12 && low >= 0.9807, "{low} to {high}");
    }

    fn collect(constraint: &ToolAcceleration<'_>, rows: &mut Vec<Row>) {
        // The sink is the problem's: two points from rest to rest.
        let problem = arcfeed_feedrate::FeedProblem::at_points(&[0.0, 1.0], &[constraint]).expect("finite rows");
        rows.extend_from_slice(problem.rows(0));
    }

    #[test]
    fn jerk_rows_lie_inside_the_ball_and_lose_three_and_a_half_percent_at_most() {
        let [low, high] = kept(6, |random| {
            let jet = PointJet { d1: vector(random, 1.0), d2: vector(random, 5.0), d3: vector(random, 50.0) };
            let (limit, x) = (2.0, random.unit().powi(3));
            let vectors = jets(jet, 1.0);
            let constraint = vectors.jerk(limit, 0.0, 1e-3);
            let mut rows = Vec::new();
            constraint.jerk_rows(0, 1.0, Within::Middle, &mut rows);
            let (u, w) = (random.signed() * 4.0, random.signed() * 40.0);
            let jerk = |scale: f64| {
                // Time runs faster by the scale.
                let (x, root) = (x * scale * scale, x.sqrt() * scale);
                let (u, w) = (u * scale * scale, w * scale * scale);
                let used = |row: &JerkRow| (row.value(w, u, x).abs() + row.step * x) / row.limit;
                let magnitude = (jet.d1 * w + jet.d2 * (3.0 * u) + jet.d3 * x).norm() * root;
                (rows.iter().map(used).fold(0.0, f64::max), magnitude)
            };
            // The scale at which a row holds the motion back.
            let (mut slow, mut fast) = (0.0, 1e6);
            for _ in 0..200 {
                let middle = 0.5 * (slow + fast);
                *(if jerk(middle).0 <= 1.0 { &mut slow } else { &mut fast }) = middle;
            }
            // Beyond the greatest speed there are no rows for what is off the plane.
            if x * slow * slow <= 1.0 { jerk(slow).1 / limit } else { 1.0 }
        });
        assert!(high <= 1.0 + 1e-9 && low >= 0.965, "{low} to {high}");
    }
}
