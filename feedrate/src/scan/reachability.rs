//! Time-optimal path parametrisation by reachability analysis (TOPP-RA): complete.
//!
//! Backward, the set of squared speeds from which the end can be reached is an interval per grid point, found by two linear
//! programs in two variables (module `lp2` solves them exactly). Forward, the greatest acceleration that stays inside these
//! intervals is taken (H. Pham and Q.-C. Pham, "A new approach to time-optimal path parameterization based on reachability
//! analysis", IEEE Trans. Robot. 2018, 34, 645). Every row is tested at both ends of every interval.
//!
//! Most programs are not solved: the cap, or the point where the two rows meet that met at the grid point behind, is the optimum
//! if it keeps all other rows and these two exclude each other beyond. That takes one pass over the rows without a division.

use super::both_ends::{moves, squared_speeds};
use crate::constraint::Within;
use crate::error::FeedError;
use crate::lp2::{Band, Greatest, NoOptimum, gap, greatest_x, least_x};
use crate::problem::{FeedPlanner, FeedProblem};
use crate::row::{Quantity, Row, RowSource};
use crate::speed_law::SpeedLaw;

/// Reachability: the optimum of the rows at the grid points to 0.01 % at N = 1000, and complete: where it finds no
/// motion there is none on this grid. Passes points at which standing still is impossible.
///
/// Rows with a term in `sqrt(x)` (viscous friction) do not describe a convex set. They are replaced by straight ones inside
/// them, close to the solution of the scan (or of the cap), and then once more close to the plan found: safe, within a few
/// 0.1 % of the optimum, but no longer complete.
#[derive(Debug, Clone, Copy, Default)]
pub struct Reachability;

impl FeedPlanner for Reachability {
    fn plan(&self, problem: &FeedProblem) -> Result<SpeedLaw, FeedError> {
        let x = self.squared_speeds(problem)?;
        moves(problem, &x)?;
        SpeedLaw::from_squared_speeds(problem.grid(), &x)
    }
}

impl Reachability {
    /// Squared speeds at the grid points.
    pub(crate) fn squared_speeds(self, problem: &FeedProblem) -> Result<Vec<f64>, FeedError> {
        solve(problem, false)
    }
}

fn has_friction(problem: &FeedProblem) -> bool {
    (0..=problem.intervals()).any(|i| problem.rows(i).iter().any(|row| row.c != 0.0))
}

pub(super) fn solve(problem: &FeedProblem, between: bool) -> Result<Vec<f64>, FeedError> {
    let mut solver = Solver::new(problem, between, &[], &[]);
    if solver.straight {
        return solver.solve();
    }
    let near = squared_speeds(problem).unwrap_or_default();
    let first = Solver::new(problem, between, &near, &[]).solve()?;
    Ok(Solver::new(problem, between, &first, &[]).solve().unwrap_or(first))
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

pub(super) struct Solver<'a> {
    problem: &'a FeedProblem,
    between: bool,
    /// There is no friction.
    straight: bool,
    /// Squared speeds around which friction is made straight; empty if not known.
    near: &'a [f64],
    /// Slope `w = du/ds` on every interval; empty if 0.
    slopes: &'a [f64],
    /// Controllable sets.
    sets: Vec<[f64; 2]>,
    lines: Vec<Line>,
    bands: Vec<Band>,
    /// The lines that bounded the last set: from above and from below in `u`.
    meeting: Option<[usize; 2]>,
}

impl<'a> Solver<'a> {
    pub(super) fn new(problem: &'a FeedProblem, between: bool, near: &'a [f64], slopes: &'a [f64]) -> Self {
        Self {
            problem,
            between,
            straight: !has_friction(problem),
            near,
            slopes,
            sets: Vec::new(),
            lines: Vec::with_capacity(64),
            bands: Vec::with_capacity(64),
            meeting: None,
        }
    }

    pub(super) fn solve(&mut self) -> Result<Vec<f64>, FeedError> {
        let problem = self.problem;
        let n = problem.intervals();
        let (x_start, x_end) = (problem.v_start().powi(2), problem.v_end().powi(2));
        if x_end > problem.x_max(n) {
            return Err(self.out_of_reach("end speed", n, [0.0, problem.x_max(n)]));
        }
        self.sets = vec![[x_end; 2]; n + 1];
        // Only the rows at the points are few enough that looking ahead pays.
        let plain = self.straight && !self.between && self.slopes.is_empty();
        let mut rests = [false, self.rests(n)];
        for k in (0..n).rev() {
            rests[0] = self.rests(k);
            let quick = if plain && rests == [true; 2] { self.quick(k) } else { None };
            rests[1] = rests[0];
            self.sets[k] = match quick {
                Some(greatest) => [0.0, greatest],
                None => self.set(k)?,
            };
        }
        let [lowest, highest] = self.sets[0];
        if x_start > highest * (1.0 + 1e-12) || x_start < lowest * (1.0 - 1e-12) {
            return Err(self.out_of_reach("start speed", 0, [lowest, highest]));
        }
        let mut x = Vec::with_capacity(n + 1);
        x.push(x_start);
        for k in 0..n {
            let here = x[k];
            let u = if plain { self.greatest_u_plain(k, here) } else { self.greatest_u(k, here) };
            let [low, high] = self.sets[k + 1];
            x.push((here + 2.0 * problem.h(k) * u).max(low).min(high));
        }
        Ok(x)
    }

    /// The squared speeds at point `k` from which the set of the next point can be reached.
    fn set(&mut self, k: usize) -> Result<[f64; 2], FeedError> {
        self.collect(k);
        let (least, most) = self.divide(self.problem.x_max(k), 2.0 * self.problem.h(k));
        let Greatest { x: greatest, meeting } =
            greatest_x(&self.bands, least, most).map_err(|why| self.explain(k, why))?;
        self.meeting = meeting.map(|bands| bands.map(|band| self.bands[band].id));
        Ok([least_x(&self.bands, least, greatest).unwrap_or(greatest), greatest])
    }

    /// Whether standing still at point `i` keeps all rows.
    fn rests(&self, i: usize) -> bool {
        self.problem.rows(i).iter().fold(true, |rests, row| rests & (row.lo <= row.d) & (row.d <= row.hi))
    }

    /// The greatest squared speed at point `k` by a guess that proves right, of rows at the points alone, where standing still
    /// keeps them: the cap, or where the same two lines meet as at the next point.
    fn quick(&self, k: usize) -> Option<f64> {
        let problem = self.problem;
        let [low, high] = self.sets[k + 1];
        // Then x = 0 is in the set of this point too.
        if low != 0.0 {
            return None;
        }
        let (cap, h2) = (problem.x_max(k), 2.0 * problem.h(k));
        if cap < f64::INFINITY && self.holds(k, h2, ((high - cap) / h2).min(0.0), cap, [usize::MAX; 2]) {
            return Some(cap);
        }
        let meeting = self.meeting?;
        let [upper, lower] = meeting.map(|id| self.line(k, h2, id));
        let (upper, lower) = (upper?, lower?);
        let bound = |line: &Line, above: bool| if (line.a > 0.0) == above { line.hi } else { line.lo } / line.a;
        let (p, q) = (-upper.b / upper.a, -lower.b / lower.a);
        let (hi, lo) = (bound(&upper, true), bound(&lower, false));
        let x = (hi - lo) / (q - p);
        // Beyond it these two exclude each other, so a greater x is none; NaN ends here too.
        let proves = p < q && (0.0..=cap).contains(&x) && p.abs().max(q.abs()) * h2 < 1e6;
        (proves && self.holds(k, h2, p * x + hi, x, meeting)).then_some(x)
    }

    /// Whether the lines of interval `k`, but for two, hold at `(u, x)`.
    fn holds(&self, k: usize, h2: f64, u: f64, x: f64, except: [usize; 2]) -> bool {
        let (near, far) = (self.problem.rows(k), self.problem.rows(k + 1));
        let next = x + h2 * u;
        let inside = |id: usize, row: &Row, x: f64| {
            let value = row.a * u + row.b * x + row.d;
            (row.lo <= value) & (value <= row.hi) | (id == except[0]) | (id == except[1])
        };
        let ahead = near.len() + far.len();
        let [low, high] = self.sets[k + 1];
        // In the order of the rows; the first that does not hold ends it.
        ((low <= next && next <= high) || except.contains(&ahead))
            && near.iter().enumerate().all(|(j, row)| inside(j, row, x))
            && far.iter().enumerate().all(|(j, row)| inside(near.len() + j, row, next))
    }

    /// The line of interval `k` that `collect` would put at this place.
    fn line(&self, k: usize, h2: f64, id: usize) -> Option<Line> {
        let (near, far) = (self.problem.rows(k), self.problem.rows(k + 1));
        if let Some(Row { a, b, d, lo, hi, source, .. }) = near.get(id).copied() {
            return Some(Line { a, b, lo: lo - d, hi: hi - d, source });
        }
        if let Some(Row { a, b, d, lo, hi, source, .. }) = far.get(id - near.len()).copied() {
            return Some(Line { a: a + h2 * b, b, lo: lo - d, hi: hi - d, source });
        }
        let [lo, hi] = self.sets[k + 1];
        let ahead = Line { a: h2, b: 1.0, lo, hi, source: RowSource::path(Quantity::Ahead) };
        (id == near.len() + far.len()).then_some(ahead)
    }

    /// The greatest `u` on interval `k` from squared speed `x`.
    fn greatest_u(&mut self, k: usize, x: f64) -> f64 {
        self.collect(k);
        let mut u = f64::INFINITY;
        for line in &self.lines {
            // The least bound wins; a vanishing factor bounds nothing.
            let bound = if line.a > 0.0 { line.hi } else { line.lo };
            if line.a != 0.0 {
                u = u.min((bound - line.b * x) / line.a);
            }
        }
        u
    }

    /// The same for rows at the points alone: most allow what others have left, which takes no division.
    fn greatest_u_plain(&self, k: usize, x: f64) -> f64 {
        let h2 = 2.0 * self.problem.h(k);
        let mut u = (self.sets[k + 1][1] - x) / h2;
        let mut lower = |row: &Row, a: f64| {
            let rest = row.b * x + row.d;
            let value = a * u + rest;
            if !((row.lo <= value) & (value <= row.hi)) && a != 0.0 {
                let bound = if a > 0.0 { row.hi } else { row.lo };
                u = u.min((bound - rest) / a);
            }
        };
        self.problem.rows(k).iter().for_each(|row| lower(row, row.a));
        self.problem.rows(k + 1).iter().for_each(|row| lower(row, row.a + h2 * row.b));
        u
    }

    /// The rows of interval `k`, the set of its end included.
    fn collect(&mut self, k: usize) {
        let problem = self.problem;
        let h2 = 2.0 * problem.h(k);
        self.lines.clear();
        let lines = &mut self.lines;
        let w = self.slopes.get(k).copied().unwrap_or(0.0);
        let half = 0.25 * h2 * w;
        for row in problem.rows(k) {
            straight(row, problem.x_max(k), self.near.get(k), |a, b, lo, hi| {
                let shift = a * half;
                lines.push(Line { a, b, lo: lo + shift, hi: hi + shift, source: row.source });
            });
        }
        for row in problem.rows(k + 1) {
            straight(row, problem.x_max(k + 1), self.near.get(k + 1), |a, b, lo, hi| {
                let shift = a * half;
                lines.push(Line { a: a + h2 * b, b, lo: lo - shift, hi: hi - shift, source: row.source });
            });
        }
        if self.between {
            self.collect_between(k, w);
        }
        let [lo, hi] = self.sets[k + 1];
        self.lines.push(Line { a: h2, b: 1.0, lo, hi, source: RowSource::path(Quantity::Ahead) });
    }

    /// What holds between the ends of interval `k`, where `u` is `u_mean + w (s - s_mid)`.
    fn collect_between(&mut self, k: usize, w: f64) {
        let problem = self.problem;
        let h = problem.h(k);
        let half = 0.5 * h * w;
        let lines = &mut self.lines;
        for row in problem.inner_rows(k, Within::Start) {
            let shift = (row.alpha - 0.5 * h * row.beta) * w;
            let (lo, hi) = (row.lo - shift, row.hi - shift);
            lines.push(Line { a: row.beta, b: row.gamma, lo, hi, source: row.source });
        }
        for row in problem.inner_rows(k, Within::End) {
            let shift = (row.alpha + 0.5 * h * row.beta) * w;
            let (lo, hi) = (row.lo - shift, row.hi - shift);
            lines.push(Line { a: row.beta + 2.0 * h * row.gamma, b: row.gamma, lo, hi, source: row.source });
        }
        // Friction is no polynomial: in the middle alone.
        for row in problem.middle_rows(k).iter().filter(|row| row.c != 0.0) {
            let x_max = problem.middle_x_max(k).min(problem.x_max(k).max(problem.x_max(k + 1)));
            let around = self.near.get(k).zip(self.near.get(k + 1)).map(|(p, q)| 0.5 * (p + q));
            // x is x_k + h u_mean - h^2 w / 8 there.
            let lower = row.b * 0.25 * h * half;
            straight(row, x_max, around.as_ref(), |a, b, lo, hi| {
                lines.push(Line { a: a + h * b, b, lo: lo + lower, hi: hi + lower, source: row.source });
            });
        }
        let source = problem.speed_bound(k).source;
        for [of_start, of_middle, of_end] in problem.speed_rows(k) {
            // x_k, x_k + h (u_mean - h w / 2) and x_k + 2 h u_mean.
            let (a, b) = (h * (of_middle + 2.0 * of_end), of_start + of_middle + of_end);
            if b > 0.0 {
                lines.push(Line { a, b, lo: f64::NEG_INFINITY, hi: 1.0 + of_middle * h * half, source });
            }
        }
        if w != 0.0 {
            // x stays positive inside.
            let source = RowSource::path(Quantity::Ahead);
            lines.push(Line { a: h, b: 1.0, lo: h * half, hi: f64::INFINITY, source });
        }
    }

    /// The lines divided by their factor of `u`; those without one bound `x` alone.
    fn divide(&mut self, x_max: f64, h2: f64) -> (f64, f64) {
        let (mut least, mut most) = (0.0_f64, x_max);
        self.bands.clear();
        for (id, line) in self.lines.iter().enumerate() {
            let inverse = 1.0 / line.a;
            let (p, lo, hi) = (-line.b * inverse, line.lo * inverse, line.hi * inverse);
            // As u is of the size of x / h2, a factor of u this small is lost beside that of x.
            if p.abs() * h2 < 1e14 && inverse.is_finite() {
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
    let around = near.copied().filter(|x| x.is_finite()).unwrap_or(default).max(1e-9 * default);
    let (slope, base, chord) = (0.5 / around.sqrt(), 0.5 * around.sqrt(), 1.0 / x_max.sqrt());
    // Upper side: c sqrt(x) from above; lower side: from below.
    let (above, below) = ((slope, base), (chord, 0.0));
    let ((up_b, up_d), (down_b, down_d)) = if c > 0.0 { (above, below) } else { (below, above) };
    push(a, b + c * up_b, f64::NEG_INFINITY, hi - c * up_d);
    push(a, b + c * down_b, lo - c * down_d, f64::INFINITY);
}
