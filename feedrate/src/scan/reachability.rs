//! Time-optimal path parametrisation by reachability analysis (TOPP-RA): complete, and certified between the points.
//!
//! Backward, the set of squared speeds from which the end can be reached is an interval per grid point, found by two linear
//! programs in two variables ([`crate::lp2`] solves them exactly). Forward, the greatest acceleration that stays inside these
//! intervals is taken (H. Pham and Q.-C. Pham, "A new approach to time-optimal path parameterization based on reachability
//! analysis", IEEE Trans. Robot. 2018, 34, 645). Every row is tested at both ends of every interval.
//!
//! # Between the grid points
//! `u` is constant on an interval, so `x` is linear in `s`. Where the path is cubic in `s` there, the acceleration of a joint
//! is quadratic and its square speed times `x` of degree five: both lie in the hull of their Bernstein coefficients, which are
//! linear in `(u, x)`. [`CertifiedReachability`] bounds those, so that nothing is exceeded anywhere on such a path.

use super::both_ends::{moves, squared_speeds};
use crate::error::FeedError;
use crate::grid_plan::GridPlan;
use crate::lp2::{Band, NoOptimum, gap, greatest_x, least_x};
use crate::problem::{FeedPlanner, FeedProblem, matching};
use crate::row::{Quantity, Row, RowSource};

/// Reachability: the optimum of the rows at the grid points to 0.01 % at N = 1000, and complete: where it finds no
/// motion there is none on this grid. Passes points at which standing still is impossible.
///
/// Rows with a term in `sqrt(x)` (viscous friction) do not describe a convex set. They are replaced by straight ones inside
/// them, close to the solution of the scan (or of the cap), and then once more close to the plan found: safe, within a few
/// 0.1 % of the optimum, but no longer complete.
#[derive(Debug, Clone, Copy, Default)]
pub struct Reachability;

/// Reachability that keeps the limits between the grid points too; needs [`FeedProblem::between_points`].
///
/// Velocity and acceleration of joints and feeds are kept everywhere if the path is piecewise cubic on the grid (put the knots
/// of its spline on the grid). On other paths, and for torque, the same rows hold for the interpolation of the rows through
/// both ends and the middle: what is left is the error of that, which falls with the third power of the interval.
#[derive(Debug, Clone, Copy, Default)]
pub struct CertifiedReachability;

impl FeedPlanner for Reachability {
    fn plan(&self, problem: &FeedProblem) -> Result<GridPlan, FeedError> {
        plan(problem, false)
    }
}

impl FeedPlanner for CertifiedReachability {
    fn plan(&self, problem: &FeedProblem) -> Result<GridPlan, FeedError> {
        if !problem.is_between_points() {
            return Err(FeedError::Empty { what: "rows between the grid points (FeedProblem::between_points)" });
        }
        plan(problem, true)
    }
}

impl Reachability {
    /// Squared speeds at the grid points.
    pub(crate) fn squared_speeds(self, problem: &FeedProblem) -> Result<Vec<f64>, FeedError> {
        solve(problem, false)
    }
}

fn plan(problem: &FeedProblem, between: bool) -> Result<GridPlan, FeedError> {
    let x = solve(problem, between)?;
    moves(problem, &x)?;
    GridPlan::from_squared_speeds(problem.grid(), &x)
}

fn solve(problem: &FeedProblem, between: bool) -> Result<Vec<f64>, FeedError> {
    let n = problem.intervals();
    let friction = (0..=n).any(|i| problem.rows(i).iter().any(|row| row.c != 0.0));
    if !friction {
        return Solver::new(problem, between, &[]).solve();
    }
    let near = squared_speeds(problem).unwrap_or_default();
    let first = Solver::new(problem, between, &near).solve()?;
    Ok(Solver::new(problem, between, &first).solve().unwrap_or(first))
}

/// A row `lo <= a u + b x <= hi` over one interval, `x` at its start.
#[derive(Debug, Clone, Copy)]
struct Line {
    a: f64,
    b: f64,
    lo: f64,
    hi: f64,
    source: RowSource,
}

struct Solver<'a> {
    problem: &'a FeedProblem,
    between: bool,
    /// Squared speeds around which friction is made straight; empty if not known.
    near: &'a [f64],
    /// Controllable sets.
    sets: Vec<[f64; 2]>,
    lines: Vec<Line>,
    bands: Vec<Band>,
}

impl<'a> Solver<'a> {
    fn new(problem: &'a FeedProblem, between: bool, near: &'a [f64]) -> Self {
        Self { problem, between, near, sets: Vec::new(), lines: Vec::with_capacity(64), bands: Vec::with_capacity(64) }
    }

    fn solve(&mut self) -> Result<Vec<f64>, FeedError> {
        let problem = self.problem;
        let n = problem.intervals();
        let (x_start, x_end) = (problem.v_start().powi(2), problem.v_end().powi(2));
        if x_end > problem.x_max(n) {
            return Err(self.out_of_reach("end speed", n, [0.0, problem.x_max(n)]));
        }
        self.sets = vec![[x_end; 2]; n + 1];
        for k in (0..n).rev() {
            self.collect(k);
            let (least, most) = self.to_bands(problem.x_max(k));
            let greatest = greatest_x(&self.bands, least, most).map_err(|why| self.explain(k, why))?;
            let least = least_x(&self.bands, least, greatest).unwrap_or(greatest);
            self.sets[k] = [least, greatest];
        }
        let [lowest, highest] = self.sets[0];
        if x_start > highest * (1.0 + 1e-12) || x_start < lowest * (1.0 - 1e-12) {
            return Err(self.out_of_reach("start speed", 0, [lowest, highest]));
        }
        let mut x = Vec::with_capacity(n + 1);
        x.push(x_start);
        for k in 0..n {
            self.collect(k);
            let h2 = 2.0 * problem.h(k);
            let here = x[k];
            let [low, high] = self.sets[k + 1];
            let mut u = f64::INFINITY;
            for line in &self.lines {
                // The least bound wins; a vanishing factor bounds nothing.
                let bound = if line.a > 0.0 { line.hi } else { line.lo };
                if line.a != 0.0 {
                    u = u.min((bound - line.b * here) / line.a);
                }
            }
            x.push((here + h2 * u).max(low).min(high));
        }
        Ok(x)
    }

    /// The rows of interval `k`, the set of its end included.
    fn collect(&mut self, k: usize) {
        let problem = self.problem;
        let h2 = 2.0 * problem.h(k);
        self.lines.clear();
        let lines = &mut self.lines;
        for row in problem.rows(k) {
            straight(row, problem.x_max(k), self.near.get(k), |a, b, lo, hi| {
                lines.push(Line { a, b, lo, hi, source: row.source });
            });
        }
        for row in problem.rows(k + 1) {
            straight(row, problem.x_max(k + 1), self.near.get(k + 1), |a, b, lo, hi| {
                lines.push(Line { a: a + h2 * b, b, lo, hi, source: row.source });
            });
        }
        if self.between {
            self.collect_between(k, h2);
        }
        let [lo, hi] = self.sets[k + 1];
        self.lines.push(Line { a: h2, b: 1.0, lo, hi, source: RowSource::path(Quantity::Ahead) });
    }

    fn collect_between(&mut self, k: usize, h2: f64) {
        let problem = self.problem;
        let (near, middle, far) = (problem.rows(k), problem.middle_rows(k), problem.rows(k + 1));
        for (j, row) in middle.iter().enumerate() {
            let near_row = matching(near, row, j, middle.len(), false).map(|j| &near[j]);
            let far_row = matching(far, row, j, middle.len(), true).map(|j| &far[j]);
            let x_max = problem.middle_x_max(k).min(problem.x_max(k).max(problem.x_max(k + 1)));
            let around = self.near.get(k).zip(self.near.get(k + 1)).map(|(p, q)| 0.5 * (p + q));
            let lines = &mut self.lines;
            match (near_row, far_row) {
                (Some(p), Some(q)) if row.c == 0.0 && p.c == 0.0 && q.c == 0.0 => {
                    // The middle Bernstein coefficient of the quadratic through both ends and the middle.
                    let b = 2.0 * row.b - 0.5 * (p.b + q.b);
                    let a = 2.0 * row.a - 0.5 * (p.a + q.a) + h2 * (row.b - 0.5 * q.b);
                    let d = 2.0 * row.d - 0.5 * (p.d + q.d);
                    lines.push(Line { a, b, lo: row.lo - d, hi: row.hi - d, source: row.source });
                }
                _ => straight(row, x_max, around.as_ref(), |a, b, lo, hi| {
                    lines.push(Line { a: a + 0.5 * h2 * b, b, lo, hi, source: row.source });
                }),
            }
        }
        let bound = problem.speed_bound(k);
        let p = &bound.coefficients;
        for i in 1..5 {
            // Coefficient i of p(s) x(s), times 5: ((5 - i) p_i x_k + i p_(i-1) x_(k+1)) <= 5.
            let (start, end) = ((5 - i) as f64 * p[i], i as f64 * p[i - 1]);
            if start + end > 0.0 {
                let (a, b) = (h2 * end, start + end);
                self.lines.push(Line { a, b, lo: f64::NEG_INFINITY, hi: 5.0, source: bound.source });
            }
        }
    }

    /// The lines divided by their factor of `u`; those without one bound `x` alone.
    fn to_bands(&mut self, x_max: f64) -> (f64, f64) {
        let (mut least, mut most) = (0.0_f64, x_max);
        self.bands.clear();
        for (id, line) in self.lines.iter().enumerate() {
            let inverse = 1.0 / line.a;
            let (p, lo, hi) = (-line.b * inverse, line.lo * inverse, line.hi * inverse);
            if p.is_finite() && inverse.is_finite() {
                let (lo, hi) = if inverse > 0.0 { (lo, hi) } else { (hi, lo) };
                self.bands.push(Band { p, lo, hi, id });
            } else if line.b > 0.0 {
                (least, most) = (least.max(line.lo / line.b), most.min(line.hi / line.b));
            } else if line.b < 0.0 {
                (least, most) = (least.max(line.hi / line.b), most.min(line.lo / line.b));
            } else if !(line.lo <= 0.0 && 0.0 <= line.hi) {
                most = f64::NEG_INFINITY;
            }
        }
        (least, most)
    }

    fn explain(&self, k: usize, why: NoOptimum) -> FeedError {
        let s = self.problem.grid()[k];
        let NoOptimum::Infeasible(x) = why else { return FeedError::Unbounded { index: k, s } };
        let now = gap(&self.bands, x);
        let line = |band: usize| self.bands.get(band).map(|band| self.lines[band.id]);
        let (Some(mut first), Some(mut second)) = (line(now.upper), line(now.lower)) else {
            return FeedError::Infeasible {
                index: k,
                s,
                row: self.problem.cap(k).1,
                against: RowSource::path(Quantity::Ahead),
                excess: 0.0,
                limit: self.problem.x_max(k).sqrt(),
            };
        };
        // Name the limit, not what follows it.
        let mut upper = true;
        if first.source.quantity == Quantity::Ahead {
            std::mem::swap(&mut first, &mut second);
            upper = false;
        }
        let limit = if (first.a > 0.0) == upper { first.hi } else { first.lo };
        let excess = (now.room * first.a).abs();
        FeedError::Infeasible { index: k, s, row: first.source, against: second.source, excess, limit }
    }

    fn out_of_reach(&self, what: &'static str, i: usize, [lowest, highest]: [f64; 2]) -> FeedError {
        let problem = self.problem;
        let speed = if i == 0 { problem.v_start() } else { problem.v_end() };
        let (cap, source) = problem.cap(i);
        let row = if highest >= cap { source } else { RowSource::path(Quantity::Ahead) };
        let (lowest, highest, s) = (lowest.sqrt(), highest.sqrt(), problem.grid()[i]);
        FeedError::SpeedOutOfReach { what, speed, lowest, highest, row, s }
    }
}

/// Passes a row on as `lo <= a u + b x <= hi`. Friction `c sqrt(x)` is bounded by a tangent from above and, up to `x_max`, by
/// a chord from below, so each side becomes a row of its own that is inside the true one.
fn straight(row: &Row, x_max: f64, near: Option<&f64>, mut push: impl FnMut(f64, f64, f64, f64)) {
    let Row { a, b, c, d, lo, hi, .. } = *row;
    let (lo, hi) = (lo - d, hi - d);
    if c == 0.0 || x_max == 0.0 {
        return push(a, b, lo, hi);
    }
    // Any place to touch is safe; without a cap there is no scale to choose one by.
    let default = if x_max < f64::INFINITY { 0.25 * x_max } else { 1.0 };
    let around = near.copied().filter(|&x| x > 0.0 && x < f64::INFINITY).unwrap_or(default).max(1e-9 * default);
    let (slope, base, chord) = (0.5 / around.sqrt(), 0.5 * around.sqrt(), 1.0 / x_max.sqrt());
    // Upper side: c sqrt(x) from above; lower side: from below.
    let (above, below) = ((slope, base), (chord, 0.0));
    let ((up_b, up_d), (down_b, down_d)) = if c > 0.0 { (above, below) } else { (below, above) };
    push(a, b + c * up_b, f64::NEG_INFINITY, hi - c * up_d);
    push(a, b + c * down_b, lo - c * down_d, f64::INFINITY);
}
