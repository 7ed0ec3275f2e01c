//! Piecewise cubic curves of several axes, planned from rest to rest, and their motions judged by differences of
//! positions alone.

use arcfeed_feedrate::constraint::{JointAcceleration, JointVelocity, PathDerivatives, SpeedCap};
use arcfeed_feedrate::{FeedError, FeedPlanner, FeedProblem, InterpolatedReachability, MotionLaw, Quantity, SpeedLaw};

/// What rounding of positions adds to the second difference over a step of 1/4000 of the motion.
pub const ROUNDING: f64 = 1e-6;

/// A piecewise cubic curve; a piece holds, for each axis, the coefficients from the third power down, in `s` from its
/// first knot on.
pub struct Cubics {
    knots: Vec<f64>,
    pieces: Vec<Vec<[f64; 4]>>,
}

impl Cubics {
    /// Through `points` at `knots`, with these slopes.
    pub fn hermite(knots: Vec<f64>, points: &[Vec<f64>], slopes: &[Vec<f64>]) -> Self {
        let piece = |i: usize| {
            let h = knots[i + 1] - knots[i];
            let axis = |j: usize| {
                let (p, m) = ([points[i][j], points[i + 1][j]], [slopes[i][j], slopes[i + 1][j]]);
                let chord = (p[1] - p[0]) / h;
                [(m[0] + m[1] - 2.0 * chord) / (h * h), (3.0 * chord - 2.0 * m[0] - m[1]) / h, m[0], p[0]]
            };
            (0..points[0].len()).map(axis).collect()
        };
        Self { pieces: (0..points.len() - 1).map(piece).collect(), knots }
    }

    /// Straight lines through `points`, the parameter by their length. In place of a corner stands a parabola, within
    /// `tolerance` of it and of half of both lines at most: the direction passes from one to the other in proportion to
    /// the parameter.
    pub fn blended(points: &[Vec<f64>], tolerance: f64) -> Self {
        let minus = |a: &[f64], b: &[f64]| -> Vec<f64> { a.iter().zip(b).map(|(a, b)| a - b).collect() };
        let norm = |v: &[f64]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
        let lines: Vec<(f64, Vec<f64>)> = points
            .windows(2)
            .map(|w| {
                let way = minus(&w[1], &w[0]);
                let length = norm(&way);
                (length, way.iter().map(|x| x / length).collect())
            })
            .collect();
        let reach = |i: usize| {
            let (before, after) = (&lines[i], &lines[i + 1]);
            let bend = norm(&minus(&after.1, &before.1));
            (0.5 * before.0).min(0.5 * after.0).min(if bend > 1e-12 { 4.0 * tolerance / bend } else { 0.0 })
        };
        let reaches: Vec<f64> = (0..lines.len() - 1).map(reach).collect();
        let (mut knots, mut pieces) = (vec![0.0], Vec::new());
        let mut add = |length: f64, axes: Vec<[f64; 4]>| {
            if length > 0.0 {
                knots.push(knots[knots.len() - 1] + length);
                pieces.push(axes);
            }
        };
        for (i, (length, u)) in lines.iter().enumerate() {
            let before = if i == 0 { 0.0 } else { reaches[i - 1] };
            let after = reaches.get(i).copied().unwrap_or(0.0);
            let from = |j: usize| points[i][j] + before * u[j];
            add(length - before - after, (0..u.len()).map(|j| [0.0, 0.0, u[j], from(j)]).collect());
            if after > 0.0 {
                let w = &lines[i + 1].1;
                let axis = |j: usize| [0.0, (w[j] - u[j]) / (4.0 * after), u[j], points[i + 1][j] - after * u[j]];
                add(2.0 * after, (0..u.len()).map(axis).collect());
            }
        }
        Self { knots, pieces }
    }

    /// The natural spline on even knots in [0, 1].
    pub fn natural(points: &[Vec<f64>]) -> Self {
        let n = points.len() - 1;
        let h = 1.0 / n as f64;
        // Slopes m: 2 m0 + m1, m[i-1] + 4 m[i] + m[i+1] and m[n-1] + 2 m[n] are 3 / h times differences of positions.
        let slopes_of = |j: usize| {
            let p = |i: usize| points[i][j];
            let right = |i: usize| 3.0 / h * (p((i + 1).min(n)) - p(i.saturating_sub(1)));
            let (mut c, mut m) = (vec![0.0; n + 1], vec![0.0; n + 1]);
            for i in 0..=n {
                let (before, last) = if i == 0 { (0.0, 0.0) } else { (c[i - 1], m[i - 1]) };
                let diagonal = if i == 0 || i == n { 2.0 } else { 4.0 };
                c[i] = 1.0 / (diagonal - before);
                m[i] = (right(i) - last) * c[i];
            }
            for i in (0..n).rev() {
                m[i] -= c[i] * m[i + 1];
            }
            m
        };
        let by_axis: Vec<Vec<f64>> = (0..points[0].len()).map(slopes_of).collect();
        let slopes: Vec<Vec<f64>> = (0..=n).map(|i| by_axis.iter().map(|m| m[i]).collect()).collect();
        Self::hermite((0..=n).map(|i| i as f64 * h).collect(), points, &slopes)
    }

    pub fn axes(&self) -> usize {
        self.pieces[0].len()
    }

    pub fn end(&self) -> f64 {
        self.knots[self.pieces.len()]
    }

    /// At least so many even intervals in all, the same number on each piece.
    pub fn grid(&self, intervals: usize) -> Vec<f64> {
        let per = intervals.div_ceil(self.pieces.len());
        let point = |k: usize| {
            let (piece, i) = (k / per, k % per);
            let from = self.knots[piece];
            if i == 0 { from } else { from + (self.knots[piece + 1] - from) * i as f64 / per as f64 }
        };
        (0..=per * self.pieces.len()).map(point).collect()
    }

    /// The piece that `s` is on; of two, the one after it where `after`.
    pub fn piece(&self, s: f64, after: bool) -> usize {
        let passed = |knot: &&f64| if after { **knot <= s } else { **knot < s };
        self.knots.iter().filter(passed).count().clamp(1, self.pieces.len()) - 1
    }

    /// Position and two derivatives of axis `j`.
    pub fn jet(&self, piece: usize, s: f64, j: usize) -> [f64; 3] {
        let [a, b, c, d] = self.pieces[piece][j];
        let x = s - self.knots[piece];
        [((a * x + b) * x + c) * x + d, (3.0 * a * x + 2.0 * b) * x + c, 6.0 * a * x + 2.0 * b]
    }

    fn values(&self, grid: &[f64], after: bool, derivative: usize) -> Vec<f64> {
        let at = |&s: &f64| {
            let piece = self.piece(s, after);
            (0..self.axes()).map(move |j| self.jet(piece, s, j)[derivative])
        };
        grid.iter().flat_map(at).collect()
    }

    /// The certified plan from rest to rest, which there must be.
    pub fn planned(&self, grid: &[f64], v: &[f64], a: &[f64], caps: Option<(&[f64], &[f64])>, name: &str) -> SpeedLaw {
        self.plan(grid, v, a, caps).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    /// The certified plan from rest to rest.
    pub fn plan(
        &self,
        grid: &[f64],
        v: &[f64],
        a: &[f64],
        caps: Option<(&[f64], &[f64])>,
    ) -> Result<SpeedLaw, FeedError> {
        let [first, second] = [1, 2].map(|derivative| self.values(grid, true, derivative));
        let before = self.values(grid, false, 2);
        let path = PathDerivatives::new(self.axes(), &first, &second)
            .and_then(|path| path.with_values_before(&[], &before, &[]))
            .expect("arrays of equal length");
        let velocity = JointVelocity::new(path, v)?;
        let acceleration = JointAcceleration::new(path, a)?;
        let problem = match caps {
            None => FeedProblem::between_points(grid, &[&velocity, &acceleration]),
            Some((points, intervals)) => {
                let cap = SpeedCap::new(points, Quantity::Feed).and_then(|cap| cap.with_intervals(intervals));
                FeedProblem::between_points(grid, &[&velocity, &acceleration, &cap.expect("above 0")])
            }
        };
        InterpolatedReachability.plan(&problem?)
    }

    /// Position of axis `j` at time `t`. The law must not leave the path.
    pub fn position(&self, law: &SpeedLaw, t: f64, j: usize) -> f64 {
        let (p, end) = (law.at(t).p, self.end());
        assert!((0.0..=end * (1.0 + 1e-12)).contains(&p), "at {t} s the law is at {p} of {end}");
        let s = p.min(end);
        self.jet(self.piece(s, true), s, j)[0]
    }

    /// The largest ratio of velocities and accelerations to their limits, by differences of positions alone: a mean
    /// velocity over some time, and the change of two of them, are within the limits where these are kept at all times.
    pub fn worst(&self, law: &SpeedLaw, v: impl Fn(f64, usize) -> f64, a: &[f64]) -> [f64; 2] {
        const STEPS: usize = 4000;
        let step = law.duration() / STEPS as f64;
        let mut worst = [0.0_f64; 2];
        for (j, limit) in a.iter().enumerate() {
            let q: Vec<f64> = (0..=STEPS).map(|i| self.position(law, i as f64 * step, j)).collect();
            for i in 1..STEPS {
                // Across the border of two limits the higher one holds.
                let [here, next] = [i, i + 1].map(|i| v(law.at(i as f64 * step).p, j));
                worst[0] = worst[0].max((q[i + 1] - q[i]).abs() / step / here.max(next));
                worst[1] = worst[1].max((q[i + 1] - 2.0 * q[i] + q[i - 1]).abs() / (step * step) / limit);
            }
        }
        worst
    }
}
