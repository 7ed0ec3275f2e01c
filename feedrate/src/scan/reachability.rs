//! Time-optimal path parametrisation by reachability analysis (TOPP-RA): complete.
//!
//! Backward, the set of squared speeds from which the end can be reached is an interval per grid
//! point, found by two linear programs in two variables (module `lp2` solves them exactly).
//! Forward, the greatest acceleration that stays inside these intervals is taken (H. Pham and Q.-C.
//! Pham, "A new approach to time-optimal path parameterization based on reachability analysis",
//! IEEE Trans. Robot. 2018, 34, 645). Every row is tested at both ends of every interval.
//!
//! Most programs are not solved: the cap, or the point where the two rows meet that met at the grid
//! point behind, is the optimum if it keeps all other rows and these two exclude each other beyond.
//! That takes one pass over the rows without a division.

mod collect;

use super::feasible_pairs::{FeasiblePairs, Line, greatest_beside};
use super::forward_backward::{moves, squared_speeds};
use crate::error::{FeedError, PathEnd};
use crate::lp2::{Band, NoOptimum, gap, greatest_x};
use crate::problem::{FeedPlanner, FeedProblem};
use crate::row::{LimitId, Quantity, Row};
use crate::speed_law::SpeedLaw;

/// Reachability: the optimum of the rows at the grid points to 0.01 % at N = 1000, and complete:
/// where it finds no motion there is none on this grid. Passes points at which standing still is
/// impossible.
///
/// Rows with a term in `sqrt(x)` (viscous friction) do not describe a convex set. They are replaced
/// by straight ones inside them, close to the solution of the scan (or of the cap), and then once
/// more close to the plan found: safe, within a few 0.1 % of the optimum, but no longer complete.
#[derive(Debug, Clone, Copy, Default)]
pub struct Reachability;

impl FeedPlanner for Reachability {
    fn plan(&self, problem: &FeedProblem) -> Result<SpeedLaw, FeedError> {
        let x = solve_moving(problem, false)?;
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

/// Part of the greatest squared speed that is kept at least between two stops, where a motion at
/// rest came out.
const LEAST_PART_BETWEEN_STOPS: f64 = 0.1;

/// Squared speeds of a motion that rests nowhere over a whole interval.
///
/// The greatest speed at one point may be such that only rest can be reached at the next, from
/// which the end is an interval of rest away. Then a part of the speed is kept everywhere.
pub(super) fn solve_moving(problem: &FeedProblem, between: bool) -> Result<Vec<f64>, FeedError> {
    let x = solve(problem, between)?;
    let Err(rests) = moves(problem, &x) else { return Ok(x) };
    let again = Solver { floor: LEAST_PART_BETWEEN_STOPS, ..Solver::new(problem, between, &x, &[]) }.solve();
    again.ok().filter(|x| moves(problem, x).is_ok()).ok_or(rests)
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
    /// Vertices of the pairs of squared speeds that keep all rows, of the last interval first;
    /// where those of each end.
    vertices: Vec<[f64; 2]>,
    ends: Vec<usize>,
    pairs: FeasiblePairs,
    /// Part of the greatest squared speed at a point that must be reached there; 0 for none.
    floor: f64,
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
            vertices: Vec::new(),
            ends: Vec::new(),
            pairs: FeasiblePairs::default(),
            floor: 0.0,
        }
    }

    pub(super) fn solve(&mut self) -> Result<Vec<f64>, FeedError> {
        let problem = self.problem;
        let n = problem.intervals();
        let (x_start, x_end) = (problem.v_start().powi(2), problem.v_end().powi(2));
        if x_end > problem.x_max(n) {
            return Err(self.out_of_reach(PathEnd::End, n, [0.0, problem.x_max(n)]));
        }
        self.sets = vec![[x_end; 2]; n + 1];
        // Only the rows at the points are few enough that looking ahead pays.
        let plain = self.straight && !self.between && self.slopes.is_empty() && self.floor == 0.0;
        let mut rests = [false, self.rests(n)];
        for k in (0..n).rev() {
            rests[0] = self.rests(k);
            let quick = if plain && rests == [true; 2] { self.quick(k) } else { None };
            rests[1] = rests[0];
            self.sets[k] = match quick {
                Some(greatest) => [0.0, greatest],
                None => {
                    let set = self.set_of_pairs(k)?;
                    if plain {
                        self.meet(k);
                    } else {
                        self.vertices.extend_from_slice(self.pairs.vertices());
                        self.ends.push(self.vertices.len());
                    }
                    set
                }
            };
        }
        let [lowest, highest] = self.sets[0];
        if x_start > highest * (1.0 + 1e-12) || x_start < lowest * (1.0 - 1e-12) {
            return Err(self.out_of_reach(PathEnd::Start, 0, [lowest, highest]));
        }
        let mut x = Vec::with_capacity(n + 1);
        x.push(x_start);
        for k in 0..n {
            let here = x[k];
            let [low, high] = self.sets[k + 1];
            let next = if plain {
                self.greatest_next_plain(k, here)?
            } else {
                greatest_beside(self.vertices_of(k), here).unwrap_or(low)
            };
            x.push(next.max(low).min(high));
        }
        Ok(x)
    }

    /// Keeps which lines of the last interval collected meet where the squared speed is greatest: a
    /// guess for the next one.
    fn meet(&mut self, k: usize) {
        let (least, most) = self.divide(self.problem.x_max(k), 2.0 * self.problem.h(k));
        let meeting = greatest_x(&self.bands, least, most).ok().and_then(|greatest| greatest.meeting);
        self.meeting = meeting.map(|bands| bands.map(|band| self.bands[band].id));
    }

    /// The squared speeds at point `k` from which the set of the next point can be reached, by the
    /// pairs that keep all rows.
    fn set_of_pairs(&mut self, k: usize) -> Result<[f64; 2], FeedError> {
        self.collect(k);
        let (problem, h2) = (self.problem, 2.0 * self.problem.h(k));
        let x_max = problem.x_max(k);
        let most = if x_max < f64::INFINITY {
            x_max
        } else {
            let (least, most) = self.divide(x_max, h2);
            // Not less than the rows allow, whatever round-off says.
            2.0 * greatest_x(&self.bands, least, most).map_err(|why| self.explain(k, why))?.x
        };
        let [low, high] = self.sets[k + 1];
        let low = if k + 1 < problem.intervals() { low.max(self.floor * high) } else { low };
        self.pairs.reset([0.0, most], [low, high]);
        let some = self.lines.iter().all(|line| self.pairs.keep(line, h2));
        let [least, greatest] = self.pairs.range();
        if !(some && least <= greatest) {
            let (least, most) = self.divide(x_max, h2);
            let why = greatest_x(&self.bands, least, most).map_or_else(|why| why, |most| NoOptimum::Infeasible(most.x));
            return Err(self.explain(k, why));
        }
        Ok([least, greatest])
    }

    /// The stored vertices of interval `k`.
    fn vertices_of(&self, k: usize) -> &[[f64; 2]] {
        let i = self.ends.len() - 1 - k;
        &self.vertices[if i > 0 { self.ends[i - 1] } else { 0 }..self.ends[i]]
    }

    /// Returns true if standing still at point `i` keeps all rows.
    fn rests(&self, i: usize) -> bool {
        self.problem.rows(i).iter().fold(true, |rests, row| rests & (row.lo <= row.d) & (row.d <= row.hi))
    }

    /// The greatest squared speed at point `k` by a guess that proves right, of rows at the points
    /// alone, where standing still keeps them: the cap, or where the same two lines meet as at the
    /// next point.
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

    /// Returns true if the lines of interval `k`, but for two, hold at `(u, x)`.
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
        let ahead = Line { a: h2, b: 1.0, lo, hi, source: LimitId::path(Quantity::ControllableSet) };
        (id == near.len() + far.len()).then_some(ahead)
    }

    /// The greatest squared speed after interval `k` from squared speed `x`, of rows at the points
    /// alone.
    fn greatest_next_plain(&mut self, k: usize, x: f64) -> Result<f64, FeedError> {
        /// Excess in units of the terms from which on a row counts as broken.
        const BROKEN: f64 = 1e-13;
        let (problem, h2) = (self.problem, 2.0 * self.problem.h(k));
        let u = self.greatest_u_plain(k, x);
        let next = (x + h2 * u).max(self.sets[k + 1][0]).min(self.sets[k + 1][1]);
        let u = (next - x) / h2;
        let kept = |row: &Row, x: f64| {
            let (p, q) = (row.a * u, row.b * x);
            row.excess(u, x) <= BROKEN * (row.a.abs() * (x + next) / h2 + q.abs() + row.d.abs() + p.abs())
        };
        if problem.rows(k).iter().all(|row| kept(row, x)) && problem.rows(k + 1).iter().all(|row| kept(row, next)) {
            return Ok(next);
        }
        // A small factor of u has made round-off a bound.
        self.set_of_pairs(k)?;
        Ok(greatest_beside(self.pairs.vertices(), x).unwrap_or(next))
    }

    /// The greatest `u` on interval `k` from squared speed `x`, of rows at the points alone: most
    /// allow what others have left, which takes no division.
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
                against: LimitId::path(Quantity::ControllableSet),
                excess: 0.0,
                limit: self.problem.x_max(k).sqrt(),
            };
        };
        // Name the limit, not what follows it.
        let mut upper = true;
        if first.source.quantity == Quantity::ControllableSet {
            std::mem::swap(&mut first, &mut second);
            upper = false;
        }
        let limit = if (first.a > 0.0) == upper { first.hi } else { first.lo };
        let excess = (now.width * first.a).abs();
        FeedError::Infeasible { index: k, s, row: first.source, against: second.source, excess, limit }
    }

    fn out_of_reach(&self, end: PathEnd, i: usize, [lowest, highest]: [f64; 2]) -> FeedError {
        let problem = self.problem;
        let speed = if i == 0 { problem.v_start() } else { problem.v_end() };
        let (cap, source) = problem.cap(i);
        let row = if highest >= cap { source } else { LimitId::path(Quantity::ControllableSet) };
        let (lowest, highest, s) = (lowest.sqrt(), highest.sqrt(), problem.grid()[i]);
        FeedError::SpeedOutOfReach { end, speed, lowest, highest, row, s }
    }
}
