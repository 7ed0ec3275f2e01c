//! Way-points from the tests and the reports of toppra's users: each is planned, keeps its limits, and is as fast as its closed form.
//!
//! Origin: hungpham2511/toppra (MIT), `tests/tests/retime/robustness/problem_suite_1.yaml`, `cpp/tests/test_issue_198.cpp`, and the
//! numbers of its issues 15, 22 and 51. Only numbers are taken; the curve through the points is a natural cubic spline.

use arcfeed_feedrate::constraint::{JointAcceleration, JointVelocity, PathDerivatives, SpeedCap};
use arcfeed_feedrate::{FeedPlanner, FeedProblem, InterpolatedReachability, MotionLaw, Quantity, SpeedLaw};
use serde::Deserialize;

const CASES: &str = include_str!("../data/toppra_cases.json");

#[derive(Deserialize)]
struct File {
    line_problems: Vec<LineProblem>,
    issue_198: Hermite,
    issue_22: Sections,
}

/// Points between which all axes move on one line, forth or forth and back: the shortest time is known.
#[derive(Deserialize)]
struct LineProblem {
    name: String,
    points: Vec<Vec<f64>>,
    intervals: Vec<usize>,
    v: Vec<f64>,
    a: Vec<f64>,
    /// The shortest time, s, where the suite states it.
    published: Option<f64>,
}

/// Positions and velocities at equal times: cubics between them.
#[derive(Deserialize)]
struct Hermite {
    duration: f64,
    q: Vec<Vec<f64>>,
    qd: Vec<Vec<f64>>,
    v: f64,
    a_lower: Vec<f64>,
    a_upper: Vec<f64>,
}

/// Velocity limits that are `reduced` between the second and the third point.
#[derive(Deserialize)]
struct Sections {
    points: Vec<Vec<f64>>,
    v: f64,
    a: f64,
    reduced: f64,
}

/// A piecewise cubic curve; a piece holds, for each axis, the coefficients from the third power down, in `s` from its first knot on.
struct Cubics {
    knots: Vec<f64>,
    pieces: Vec<Vec<[f64; 4]>>,
}

impl Cubics {
    /// Through `points` at `knots`, with these slopes.
    fn hermite(knots: Vec<f64>, points: &[Vec<f64>], slopes: &[Vec<f64>]) -> Self {
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

    /// The natural spline on even knots in [0, 1].
    fn natural(points: &[Vec<f64>]) -> Self {
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

    fn axes(&self) -> usize {
        self.pieces[0].len()
    }

    fn end(&self) -> f64 {
        self.knots[self.pieces.len()]
    }

    /// At least so many even intervals in all, the same number on each piece.
    fn grid(&self, intervals: usize) -> Vec<f64> {
        let per = intervals.div_ceil(self.pieces.len());
        let point = |k: usize| {
            let (piece, i) = (k / per, k % per);
            let from = self.knots[piece];
            if i == 0 { from } else { from + (self.knots[piece + 1] - from) * i as f64 / per as f64 }
        };
        (0..=per * self.pieces.len()).map(point).collect()
    }

    /// The piece that `s` is on; of two, the one after it where `after`.
    fn piece(&self, s: f64, after: bool) -> usize {
        let passed = |knot: &&f64| if after { **knot <= s } else { **knot < s };
        self.knots.iter().filter(passed).count().clamp(1, self.pieces.len()) - 1
    }

    /// Position and two derivatives of axis `j`.
    fn jet(&self, piece: usize, s: f64, j: usize) -> [f64; 3] {
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

    /// The certified plan from rest to rest.
    fn planned(&self, grid: &[f64], v: &[f64], a: &[f64], caps: Option<(&[f64], &[f64])>, name: &str) -> SpeedLaw {
        let [first, second] = [1, 2].map(|derivative| self.values(grid, true, derivative));
        let before = self.values(grid, false, 2);
        let path = PathDerivatives::new(self.axes(), &first, &second)
            .and_then(|path| path.with_values_before(&[], &before, &[]))
            .expect("arrays of equal length");
        let velocity = JointVelocity::new(path, v).expect("above 0");
        let acceleration = JointAcceleration::new(path, a).expect("above 0");
        let problem = match caps {
            None => FeedProblem::between_points(grid, &[&velocity, &acceleration]),
            Some((points, intervals)) => {
                let cap = SpeedCap::new(points, Quantity::Feed).and_then(|cap| cap.with_intervals(intervals));
                FeedProblem::between_points(grid, &[&velocity, &acceleration, &cap.expect("above 0")])
            }
        };
        InterpolatedReachability.plan(&problem.expect("rows")).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    /// Position of axis `j` at time `t`.
    fn position(&self, law: &SpeedLaw, t: f64, j: usize) -> f64 {
        let s = law.at(t).p.clamp(0.0, self.end());
        self.jet(self.piece(s, true), s, j)[0]
    }

    /// The largest ratio of velocities and accelerations to their limits, by differences of positions alone: a mean velocity over some
    /// time, and the change of two of them, are within the limits where these are kept at all times.
    fn worst(&self, law: &SpeedLaw, v: impl Fn(f64, usize) -> f64, a: &[f64]) -> [f64; 2] {
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

fn cases() -> File {
    serde_json::from_str(CASES).expect("valid cases")
}

/// What rounding of positions adds to the second difference over a step of 1/4000 of the motion.
const ROUNDING: f64 = 1e-6;

#[test]
fn lines_of_any_size_take_their_shortest_time() {
    for case in cases().line_problems {
        let path = Cubics::natural(&case.points);
        // On a line all axes are in proportion: the time follows from the axis that its limits allow least.
        let reach = |i: usize, j: usize| (case.points[i][j] - case.points[0][j]).abs();
        let (far, back) = (0..case.points.len()).fold((0, false), |(far, _), i| {
            let is_far = (0..path.axes()).any(|j| reach(i, j) > reach(far, j));
            if is_far { (i, false) } else { (far, i > far) }
        });
        let once = (0..path.axes()).map(|j| 2.0 * (reach(far, j) / case.a[j]).sqrt()).fold(0.0, f64::max);
        let shortest = if back { 2.0 * once } else { once };
        if let Some(published) = case.published {
            assert!((shortest / published - 1.0).abs() < 1e-9, "{}: {shortest}", case.name);
        }
        for &intervals in &case.intervals {
            let name = format!("{}, {intervals} intervals", case.name);
            let law = path.planned(&path.grid(intervals), &case.v, &case.a, None, &name);
            let ratio = law.duration() / shortest;
            assert!((1.0 - 1e-9..1.02).contains(&ratio), "{name}: {ratio} of the shortest time {shortest} s");
            let worst = path.worst(&law, |_, j| case.v[j], &case.a);
            assert!(worst[0] <= 1.0 + 1e-6 && worst[1] <= 1.0 + ROUNDING, "{name}: {worst:?}");
        }
    }
}

/// Ten joints, cubics with jumps of the second derivative at every point: toppra exceeded an acceleration limit between its grid points.
#[test]
fn ten_joints_keep_their_acceleration_limits() {
    let case = cases().issue_198;
    let n = case.q.len() - 1;
    let knots = (0..=n).map(|i| case.duration * i as f64 / n as f64).collect();
    let path = Cubics::hermite(knots, &case.q, &case.qd);
    let v = vec![case.v; path.axes()];
    // The smaller one of both directions.
    let a: Vec<f64> = case.a_lower.iter().zip(&case.a_upper).map(|(lower, upper)| (-lower).min(*upper)).collect();
    let durations = [90, 360, 1440].map(|intervals| {
        let law = path.planned(&path.grid(intervals), &v, &a, None, "issue 198");
        let worst = path.worst(&law, |_, j| v[j], &a);
        assert!(worst[0] <= 1.0 + 1e-6 && worst[1] <= 1.0 + ROUNDING, "{intervals}: {worst:?}");
        assert!(worst[1] > 0.9, "{intervals}: no acceleration binds, {worst:?}");
        law.duration()
    });
    assert!(durations[0] < 1.1 * durations[2] && durations[1] < 1.015 * durations[2], "{durations:?}");
}

/// Velocity limits that are a twentieth on the middle section: toppra's motion was faster there.
#[test]
fn velocity_limits_of_a_section_are_kept_to_its_ends() {
    let case = cases().issue_22;
    let path = Cubics::natural(&case.points);
    let (v, a) = (vec![case.v; path.axes()], vec![case.a; path.axes()]);
    let inside = |s: f64| (1.0 / 3.0..=2.0 / 3.0).contains(&s);
    let limit = |s: f64| if inside(s) { case.v * case.reduced } else { case.v };
    for intervals in [60, 600] {
        let grid = path.grid(intervals);
        let cap = |from: f64, to: f64| {
            let slope = |i: usize| {
                let s = from + (to - from) * i as f64 / 20.0;
                (0..path.axes()).map(|j| path.jet(path.piece(s, true), s, j)[1].abs()).fold(0.0, f64::max)
            };
            limit(0.5 * (from + to)) / (0..=20).map(slope).fold(0.0, f64::max)
        };
        let between: Vec<f64> = grid.windows(2).map(|w| cap(w[0], w[1])).collect();
        let at = |i: usize| between[i.saturating_sub(1)].min(between[i.min(between.len() - 1)]);
        let points: Vec<f64> = (0..grid.len()).map(at).collect();
        let law = path.planned(&grid, &v, &a, Some((&points, &between)), "issue 22");
        let worst = path.worst(&law, |s, _| limit(s), &a);
        let borders = [law.time_at_position(1.0 / 3.0), law.time_at_position(2.0 / 3.0)];
        assert!(worst[0] <= 1.0 + 1e-6 && worst[1] <= 1.0 + ROUNDING, "{intervals}: {worst:?}, borders at {borders:?}");
        // The slow section takes most of the time: 2 units at 0.5.
        assert!(borders[1] - borders[0] > 4.0, "{borders:?}");
    }
}

/// The duration hardly depends on the grid, and goes with the square root of the size: toppra had a floor of 0.2 s (issues 15 and 51).
#[test]
fn small_motions_scale_as_large_ones() {
    for power in [0, 10, 20, 30] {
        // Without rounding in the points.
        let size = f64::powi(0.5, power);
        let points = [[-0.25, 0.25], [-0.25 - size, 0.25 + size], [-0.25, 0.25]].map(Vec::from);
        let path = Cubics::natural(&points);
        let shortest = 4.0 * f64::sqrt(size / 2.0);
        for intervals in [40, 100, 1000] {
            let law = path.planned(&path.grid(intervals), &[1e3, 1e3], &[2.0, 2.0], None, "forth and back");
            let ratio = law.duration() / shortest;
            assert!((1.0 - 1e-6..1.01).contains(&ratio), "{size}, {intervals}: {ratio}");
        }
    }
}
