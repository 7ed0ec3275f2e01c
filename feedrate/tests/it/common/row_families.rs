//! Random problems on rows in families, and a judge with its own arithmetic.
//!
//! A case is numbers alone: [`Case::literal`] prints it as Rust. Joints are natural cubic splines with the knots on the grid;
//! further rows have coefficients that are quadratic in `s`, so that three places of an interval determine them.
#![allow(dead_code, clippy::unwrap_used, clippy::neg_cmp_op_on_partial_ord, missing_docs)]

use std::ops::Range;

use arcfeed_feedrate::constraint::{
    Feed, JointAcceleration, JointJerk, JointVelocity, PathConstraint, PathDerivatives, Place, RowSink, Within,
};
use arcfeed_feedrate::{FeedError, FeedProblem, JerkRow, LimitId, MotionState, Quantity, Row, SpeedLaw};
use arcfeed_testing::Random;

fn below(rng: &mut Random, n: usize) -> usize {
    (rng.unit() * n as f64) as usize
}

fn bell(rng: &mut Random) -> f64 {
    (0..6).map(|_| rng.signed()).sum::<f64>() / 1.4
}

pub const FAMILIES: [&str; 8] =
    ["splines", "rows", "near-degenerate", "stiff", "scales", "zero-rows", "end-speeds", "torque"];

#[derive(Debug, Clone, PartialEq)]
pub struct Case {
    /// Length of a span between two knots, and intervals per span.
    pub h: f64,
    pub per: usize,
    /// Joint values at the knots.
    pub y: Vec<Vec<f64>>,
    /// Limits per joint.
    pub v: Vec<f64>,
    pub a: Vec<f64>,
    pub j: Vec<f64>,
    pub feed: f64,
    /// Speeds at both ends.
    pub ends: Vec<f64>,
    /// Further rows: three coefficients in `s / length` for each of `a`, `b`, `c`, `d`, then both bounds.
    pub rows: Vec<Vec<f64>>,
    /// Further jerk rows: the same for `alpha`, `beta`, `gamma`, then the limit.
    pub thirds: Vec<Vec<f64>>,
}

impl Case {
    /// The case of a number in the series of a seed.
    pub fn numbered(seed: u64, family: usize, index: u64) -> Self {
        let mut rng = Random::new(seed.wrapping_mul(0xD1B5_4A32_D192_ED03) ^ index.wrapping_mul(0x9E6C_63D0_676A_9A99));
        Self::random(family, &mut rng)
    }

    fn random(family: usize, rng: &mut Random) -> Self {
        let (m, spans, per) = (1 + below(rng, 6), 2 + below(rng, 8), 2 + below(rng, 40));
        let kind = below(rng, 5);
        let knot = |i: usize, rng: &mut Random| match kind {
            0 => bell(rng),
            1 => i as f64 / spans as f64 + 0.05 * bell(rng),
            2 => rng.log(1e-4, 1e2) * rng.sign(),
            3 => (i % 2) as f64 * rng.between(0.9, 1.1),
            _ => (if rng.unit() < 0.3 { 0.0 } else { 1.0 }) * bell(rng),
        };
        let y = (0..m).map(|_| (0..=spans).map(|i| knot(i, rng)).collect()).collect();
        let scale = if kind == 2 { 10_f64.powf(rng.between(-3.0, 3.0)) } else { 1.0 };
        let mut limits = |a: f64, b: f64| -> Vec<f64> { (0..m).map(|_| rng.log(a, b) * scale).collect() };
        let (v, a, j) = (limits(0.1, 10.0), limits(0.3, 30.0), limits(1.0, 3000.0));
        let (h, feed) = (1.0 / spans as f64, rng.log(0.05, 20.0));
        let mut case = Self { h, per, y, v, a, j, feed, ends: vec![0.0; 2], rows: Vec::new(), thirds: Vec::new() };
        match family {
            1 => case.add_rows(rng, false),
            2 => case.degenerate(rng),
            3 => case.stiffen(rng),
            4 => case.rescale(rng),
            5 => case.add_zeros(rng),
            6 => {
                case.ends =
                    (0..2).map(|_| if rng.unit() < 0.2 { 0.0 } else { case.feed * rng.log(0.01, 1.0) }).collect()
            }
            7 => case.add_rows(rng, true),
            _ => {}
        }
        case
    }

    fn add_rows(&mut self, rng: &mut Random, torque: bool) {
        for _ in 0..1 + below(rng, 4) {
            let mut row: Vec<f64> = (0..9).map(|_| bell(rng)).collect();
            let limit = rng.log(0.5, 30.0);
            let friction = if torque && rng.unit() < 0.7 { rng.log(0.01, 3.0) } else { 0.0 };
            if friction == 0.0 {
                row[6..9].fill(0.0);
            }
            row[6..9].iter_mut().for_each(|c| *c *= friction);
            // Gravity and Coulomb friction, mostly below the limit.
            let gravity = if torque { rng.between(0.0, 0.45) * limit } else { 0.0 };
            row.extend((0..3).map(|_| gravity * rng.between(-1.0, 1.0)));
            row.extend(if rng.unit() < 0.8 { [-limit, limit] } else { [-limit * rng.log(0.1, 10.0), limit] });
            self.rows.push(row);
        }
        for _ in 0..below(rng, 3) {
            let mut row: Vec<f64> = (0..9).map(|_| bell(rng)).collect();
            row.push(rng.log(1.0, 300.0));
            self.thirds.push(row);
        }
    }

    /// Joints that hardly move, rows that all but coincide, turning points on the grid.
    fn degenerate(&mut self, rng: &mut Random) {
        let m = self.y.len();
        match below(rng, 4) {
            0 => {
                let tiny = rng.log(1e-15, 1e-6);
                self.y[0].iter_mut().for_each(|y| *y *= tiny);
                if rng.unit() < 0.5 {
                    [&mut self.v, &mut self.a, &mut self.j].into_iter().for_each(|limits| limits[0] *= tiny);
                }
            }
            1 => {
                let near = 1.0 + rng.sign() * rng.log(1e-15, 1e-7);
                let again = self.y[m - 1].iter().map(|y| y * near).collect();
                self.y.push(again);
                for limits in [&mut self.v, &mut self.a, &mut self.j] {
                    limits.push(limits[m - 1]);
                }
            }
            2 => {
                // Symmetric about its middle, where every joint turns around.
                for y in &mut self.y {
                    let n = y.len();
                    (0..n / 2).for_each(|i| y[n - 1 - i] = y[i]);
                }
            }
            _ => {
                let mut row = vec![0.0; 12];
                (row[0], row[1], row[3]) = (rng.sign() * rng.log(1e-16, 1e-8), bell(rng) * 1e-12, bell(rng));
                let limit = rng.log(0.5, 30.0);
                row.extend([-limit, limit]);
                self.rows.push(row);
            }
        }
    }

    fn stiffen(&mut self, rng: &mut Random) {
        for limits in [&mut self.v, &mut self.a, &mut self.j] {
            limits.iter_mut().for_each(|limit| *limit *= 10_f64.powf(rng.between(-3.0, 3.0)));
        }
    }

    fn rescale(&mut self, rng: &mut Random) {
        let (length, joints, time) = (
            10_f64.powf(rng.between(-6.0, 6.0)),
            10_f64.powf(rng.between(-6.0, 6.0)),
            10_f64.powf(rng.between(-4.0, 4.0)),
        );
        self.h *= length;
        self.feed *= length / time;
        self.y.iter_mut().flatten().for_each(|y| *y *= joints);
        for (limits, power) in [(&mut self.v, 1), (&mut self.a, 2), (&mut self.j, 3)] {
            limits.iter_mut().for_each(|limit| *limit *= joints / time.powi(power));
        }
    }

    fn add_zeros(&mut self, rng: &mut Random) {
        let still = bell(rng);
        self.y[0].fill(still);
        match below(rng, 3) {
            0 => self.v[0] = 0.0,
            1 => self.a[0] = 0.0,
            _ => {
                let mut row = vec![0.0; 12];
                row.extend(if rng.unit() < 0.5 { [0.0, 0.0] } else { [0.0, f64::INFINITY] });
                self.rows.push(row);
            }
        }
    }

    pub fn literal(&self) -> String {
        format!("{self:?}").replace('[', "vec![").replace("inf", "f64::INFINITY")
    }

    fn spans(&self) -> usize {
        self.y[0].len() - 1
    }

    fn length(&self) -> f64 {
        self.spans() as f64 * self.h
    }

    pub fn grid(&self) -> Vec<f64> {
        let at = |i: usize| (i / self.per) as f64 * self.h + self.h * ((i % self.per) as f64 / self.per as f64);
        (0..=self.spans() * self.per).map(at).collect()
    }
}

/// The joints of a case as piecewise cubics.
pub struct Path<'a> {
    pub case: &'a Case,
    pub grid: Vec<f64>,
    /// Second derivatives at the knots.
    bend: Vec<Vec<f64>>,
}

impl<'a> Path<'a> {
    pub fn new(case: &'a Case) -> Self {
        Self { case, grid: case.grid(), bend: case.y.iter().map(|y| natural_spline(y, case.h)).collect() }
    }

    /// First three derivatives of joint `k` at `s` by the cubic of a span.
    fn jet(&self, k: usize, span: usize, s: f64) -> [f64; 3] {
        let (h, y) = (self.case.h, &self.case.y[k]);
        let x = s - span as f64 * h;
        let (a, b) = (self.bend[k][span], self.bend[k][span + 1]);
        let start = (y[span + 1] - y[span]) / h - h * (2.0 * a + b) / 6.0;
        [start + a * x + 0.5 * (b - a) / h * x * x, a + (b - a) / h * x, (b - a) / h]
    }

    fn span(&self, interval: usize) -> usize {
        (interval / self.case.per).min(self.case.spans() - 1)
    }

    /// What the planners are given.
    pub fn problem(&self, between: bool, jerk: bool) -> Result<FeedProblem, FeedError> {
        self.problem_on(0..self.grid.len() - 1, between, jerk)
    }

    /// The same on a range of the intervals.
    pub fn problem_on(&self, range: Range<usize>, between: bool, jerk: bool) -> Result<FeedProblem, FeedError> {
        let (case, from) = (self.case, range.start);
        let grid = &self.grid[from..=range.end];
        let (n, m) = (grid.len(), case.y.len());
        let (mut d, mut before, mut mid) = ([vec![], vec![], vec![]], vec![], [vec![], vec![]]);
        for i in 0..n {
            for k in 0..m {
                let jet = self.jet(k, self.span(from + i), grid[i]);
                (0..3).for_each(|o| d[o].push(jet[o]));
                before.push(self.jet(k, self.span((from + i).saturating_sub(1)), grid[i])[2]);
                if i + 1 < n {
                    let jet = self.jet(k, self.span(from + i), 0.5 * (grid[i] + grid[i + 1]));
                    (0..2).for_each(|o| mid[o].push(jet[o]));
                }
            }
        }
        let path = PathDerivatives::new(m, &d[0], &d[1])?
            .with_third(&d[2])?
            .with_values_before(&[], &[], &before)?
            .with_middles(&mid[0], &mid[1])?;
        let feeds = vec![case.feed; n - 1];
        let (velocity, acceleration, feed) =
            (JointVelocity::new(path, &case.v)?, JointAcceleration::new(path, &case.a)?, Feed::new(&feeds)?);
        let (joint_jerk, further) = (JointJerk::new(path, &case.j)?, Further { path: self, jerk, from });
        let mut all: Vec<&dyn PathConstraint> = vec![&velocity, &acceleration, &feed, &further];
        if jerk {
            all.push(&joint_jerk);
        }
        let problem =
            if between { FeedProblem::between_points(grid, &all) } else { FeedProblem::at_points(grid, &all) };
        let start = if from == 0 { case.ends[0] } else { 0.0 };
        let end = if range.end + 1 == self.grid.len() { case.ends[1] } else { 0.0 };
        problem?.with_end_speeds(start, end)
    }

    fn coefficients(&self, row: &[f64], s: f64) -> [f64; 4] {
        let z = s / self.case.length();
        let at = |i: usize| row.get(3 * i..3 * i + 3).map_or(0.0, |c| c[0] + z * (c[1] + z * c[2]));
        [at(0), at(1), at(2), at(3)]
    }
}

/// Second derivatives of the natural spline through equidistant values.
fn natural_spline(y: &[f64], h: f64) -> Vec<f64> {
    let n = y.len() - 1;
    let (mut diagonal, mut right, mut bend) = (vec![1.0; n + 1], vec![0.0; n + 1], vec![0.0; n + 1]);
    for i in 1..n {
        let above = if i > 1 { 1.0 / diagonal[i - 1] } else { 0.0 };
        diagonal[i] = 4.0 - above;
        right[i] = 6.0 * (y[i + 1] - 2.0 * y[i] + y[i - 1]) / h / h - above * right[i - 1];
    }
    for i in (1..n).rev() {
        bend[i] = (right[i] - if i + 1 < n { bend[i + 1] } else { 0.0 }) / diagonal[i];
    }
    bend
}

/// The further rows of a case.
struct Further<'a> {
    path: &'a Path<'a>,
    jerk: bool,
    /// The first interval.
    from: usize,
}

impl PathConstraint for Further<'_> {
    fn points(&self) -> Option<usize> {
        None
    }

    fn rows(&self, place: Place, out: &mut RowSink<'_>) {
        let s = match place {
            Place::Point(i) => self.path.grid[self.from + i],
            Place::Middle { k, h } => self.path.grid[self.from + k] + 0.5 * h,
        };
        for (id, row) in self.path.case.rows.iter().enumerate() {
            let [a, b, c, d] = self.path.coefficients(row, s);
            out.row(Row { a, b, c, d, lo: row[12], hi: row[13], source: LimitId::joint(Quantity::Other, id) });
        }
    }

    fn jerk_rows(&self, k: usize, h: f64, within: Within, out: &mut Vec<JerkRow>) {
        let s = self.path.grid[self.from + k] + [0.0, 0.5, 1.0][within as usize] * h;
        for (id, row) in self.path.case.thirds.iter().enumerate().filter(|_| self.jerk) {
            let [alpha, beta, gamma, _] = self.path.coefficients(&row[..9], s);
            out.push(JerkRow {
                alpha,
                beta,
                gamma,
                step: 0.0,
                limit: row[9],
                source: LimitId::joint(Quantity::Other, id),
            });
        }
    }
}

/// By how much a plan exceeds its limits, in parts of them, and which.
#[derive(Debug, Clone, Default)]
pub struct Excess {
    pub at_grid: f64,
    pub between: f64,
    pub what: [String; 2],
}

impl Excess {
    fn see(&mut self, at_grid: bool, excess: f64, what: impl FnOnce() -> String) {
        let worst = if at_grid { &mut self.at_grid } else { &mut self.between };
        // A NaN, once seen, stays.
        if !(excess <= *worst) && !worst.is_nan() {
            *worst = excess;
            self.what[usize::from(!at_grid)] = what();
        }
    }
}

/// Differences of terms this many times the limit are not told apart to 1e-9 of it.
const ROUND_OFF: f64 = 1e-5;

/// Places between two grid points at which a plan is judged.
const BETWEEN: usize = 20;

/// Evaluates every limit of the case along the plan, at both ends of every interval and at 20 places between.
pub fn judge(path: &Path<'_>, plan: &SpeedLaw, jerk: bool) -> Excess {
    let (case, mut worst) = (path.case, Excess::default());
    for k in 0..path.grid.len() - 1 {
        let (s, h) = (path.grid[k], path.grid[k + 1] - path.grid[k]);
        for i in 0..=BETWEEN + 1 {
            let fraction = i as f64 / (BETWEEN + 1) as f64;
            // The end of an interval belongs to the next one: a hair before it.
            let at = if i == BETWEEN + 1 { s + h * (1.0 - 1e-11) } else { s + fraction * h };
            let mut state = plan.at_position(at);
            if i == BETWEEN + 1 {
                let next = plan.at_position(path.grid[k + 1]);
                (state.p, state.v) = (next.p, next.v);
            }
            let grid = i == 0 || i == BETWEEN + 1;
            worst.see(grid, state.v / case.feed - 1.0, || format!("feed at {at}: {state:?}"));
            judge_joints(path, k, &state, jerk, |excess, what| {
                worst.see(grid, excess, || format!("{what} at {at}: {state:?}"))
            });
            judge_rows(path, h, &state, jerk, |excess, what| {
                worst.see(grid, excess, || format!("{what} at {at}: {state:?}"))
            });
        }
    }
    let (start, end) = (plan.at_position(path.grid[0]), plan.end());
    for (asked, got) in case.ends.iter().zip([start.v, end.v]) {
        worst.see(true, (got - asked).abs() / case.feed, || format!("end speed {got} instead of {asked}"));
    }
    if !(plan.duration() > 0.0 && plan.duration().is_finite()) {
        worst.see(true, f64::NAN, || "duration".to_owned());
    }
    worst
}

fn judge_joints(path: &Path<'_>, k: usize, at: &MotionState, jerk: bool, mut see: impl FnMut(f64, &str)) {
    let (case, h) = (path.case, path.grid[k + 1] - path.grid[k]);
    let (v, u, x) = (at.v, at.a, at.v * at.v);
    for joint in 0..case.y.len() {
        let [p, q, r] = path.jet(joint, path.span(k), at.p);
        let part =
            |value: f64, limit: f64, terms: f64| (value.abs() - limit) / limit.max(ROUND_OFF * terms).max(1e-300);
        see(part(p * v, case.v[joint], 0.0), &format!("velocity of {joint}"));
        see(part(p * u + q * x, case.a[joint], (p * x / h).abs() + (q * x).abs()), &format!("acceleration of {joint}"));
        if jerk {
            let terms = ((p * x / (h * h)).abs() + (3.0 * q * u).abs() + (r * x).abs()) * v;
            let value = p * at.j + v * (3.0 * q * u + r * x);
            see(part(value, case.j[joint], terms), &format!("jerk of {joint}"));
        }
    }
}

fn judge_rows(path: &Path<'_>, h: f64, at: &MotionState, jerk: bool, mut see: impl FnMut(f64, &str)) {
    let (v, u, x) = (at.v, at.a, at.v * at.v);
    for (id, row) in path.case.rows.iter().enumerate() {
        let [a, b, c, d] = path.coefficients(row, at.p);
        let (value, terms) = (a * u + b * x + c * v + d, (a * x / h).abs() + (b * x).abs() + (c * v).abs() + d.abs());
        for (over, bound) in [(value - row[13], row[13]), (row[12] - value, row[12])] {
            if bound.is_finite() {
                see(over / bound.abs().max(ROUND_OFF * terms).max(1e-300), &format!("row {id}"));
            }
        }
    }
    for (id, row) in path.case.thirds.iter().enumerate().filter(|_| jerk) {
        let [alpha, beta, gamma, _] = path.coefficients(&row[..9], at.p);
        let terms = ((alpha * x / (h * h)).abs() + (beta * u).abs() + (gamma * x).abs()) * v;
        let value = alpha * at.j + v * (beta * u + gamma * x);
        see((value.abs() - row[9]) / row[9].max(ROUND_OFF * terms), &format!("jerk row {id}"));
    }
}
