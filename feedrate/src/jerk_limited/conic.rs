//! The same problem as a sequence of conic programs, solved by a general solver: a yardstick for
//! the method of this module.
//!
//! Knots, rows and the rest intervals are those of [`BarrierProblem`]; the time is summed over half
//! intervals, on which `2 h / (sqrt(x_0) + sqrt(x_1))` stands for the integral.

use super::barrier_problem::BarrierProblem;
use super::parts::{Part, Prepared, prepare};
use super::solution::{Solution, assemble};
use super::spline::{End, Knots, Values};
use super::start;
use crate::conic_program::{Optimum, Program, straight};
use crate::constraint::Within;
use crate::error::FeedError;
use crate::problem::FeedProblem;
use crate::speed_law::SpeedLaw;

/// More programs than are needed.
const MOST_PROGRAMS: usize = 8;

/// Relative gain of a program below which it is the last.
const GAIN: f64 = 1e-5;

/// The best plan of the sequence, and whether the solver was accurate in every program.
pub(crate) fn solve(problem: &FeedProblem) -> Result<(SpeedLaw, bool), FeedError> {
    straight(problem)?;
    let prepared = prepare(problem)?;
    let Prepared { problem, parts, .. } = &prepared;
    let mut solutions = Vec::with_capacity(parts.len());
    let mut accurate = true;
    for part in parts {
        let (solution, solved) = sequence(&prepared, part)?;
        solutions.push(solution);
        accurate &= solved;
    }
    Ok((assemble(problem, &solutions)?, accurate))
}

fn sequence(prepared: &Prepared<'_>, part: &Part) -> Result<(Solution, bool), FeedError> {
    let Prepared { problem, fastest, .. } = prepared;
    let mut barrier_problem = BarrierProblem::new(problem, [part.grid.start, part.grid.end], part.speeds, fastest);
    let mut c = start::start(prepared, &mut barrier_problem);
    // The true bounds at once: a tangent may touch anywhere.
    barrier_problem.narrow(1.0);
    let grid = problem.grid();
    let length = grid[part.grid.end] - grid[part.grid.start];
    let units = Units { length, x: (length / part.shortest(problem, fastest)).powi(2) };
    let (mut cost, mut accurate) = (f64::INFINITY, true);
    for _ in 0..MOST_PROGRAMS {
        let program = program(problem, &barrier_problem, &c, units);
        // What has been found stays when a later program fails.
        let Optimum { variables, dual, accurate: solved } = match program.solve() {
            Ok(optimum) => optimum,
            Err(_) if cost < f64::INFINITY => {
                accurate = false;
                break;
            }
            Err(error) => return Err(error),
        };
        accurate &= solved;
        let m = barrier_problem.knots.coefficients();
        c = variables[..m].iter().map(|c| c * units.x).collect();
        let ratios = barrier_problem.ratios();
        for (i, (outer, inner)) in [(0, 1), (m - 1, m - 2)].into_iter().enumerate() {
            if let End::Moving { x, .. } = barrier_problem.ends[i] {
                c[outer] = x;
            }
            c[inner] = c[outer] * ratios[i];
        }
        let gain = 1.0 - dual / cost;
        cost = dual;
        if gain.abs() < GAIN {
            break;
        }
    }
    Ok((Solution { barrier_problem, c, converged: accurate, grid_costs: Vec::new() }, accurate))
}

/// In these all numbers are near 1.
#[derive(Debug, Clone, Copy)]
struct Units {
    length: f64,
    x: f64,
}

/// Combinations of `c[k]`, `c[k + 1]`, `c[k + 2]`.
type Terms = [(usize, f64); 3];

/// `alpha w + beta u + gamma x` at one end of interval `k`, or in its middle.
fn terms(knots: &Knots, k: usize, within: Within, [alpha, beta, gamma]: [f64; 3]) -> Terms {
    let ([pa, pb, p], [na, nb, n]) = (knots.weights[k], knots.weights[k + 1]);
    let (w, middle) = knots.on_interval(k);
    let (x, u) = match within {
        Within::Start => ([pa, pb, 0.0], [-p, p, 0.0]),
        Within::Middle => (middle, [-0.5 * p, 0.5 * (p - n), 0.5 * n]),
        Within::End => ([0.0, na, nb], [0.0, -n, n]),
    };
    std::array::from_fn(|i| (k + i, alpha * w[i] + beta * u[i] + gamma * x[i]))
}

/// Columns of the program: coefficients, roots at the knots and in the middles in turn, inverses on
/// the half intervals and in both rest intervals.
#[derive(Clone, Copy)]
struct Columns {
    coefficients: usize,
    intervals: usize,
}

impl Columns {
    fn root(self, i: usize) -> usize {
        self.coefficients + i
    }

    fn inverse(self, i: usize) -> usize {
        self.root(2 * self.intervals + 1) + i
    }
}

/// The program with the tangents at the motion of coefficients `c`.
fn program(problem: &FeedProblem, barrier_problem: &BarrierProblem, c: &[f64], units: Units) -> Program {
    let knots = &barrier_problem.knots;
    let columns = Columns { coefficients: knots.coefficients(), intervals: knots.intervals() };
    let mut program = Program::new(columns.inverse(2 * columns.intervals + 2));
    demand_rows(&mut program, problem, barrier_problem, c, units);
    demand_ends(&mut program, barrier_problem, columns, units);
    for k in 0..=columns.intervals {
        program.root(columns.root(2 * k), at_knot(knots, k, [0.0, 0.0, 1.0]));
    }
    for (k, h) in knots.h.iter().enumerate() {
        program.root(columns.root(2 * k + 1), terms(knots, k, Within::Middle, [0.0, 0.0, 1.0]));
        for half in [2 * k, 2 * k + 1] {
            program.inverse(columns.inverse(half), [columns.root(half), columns.root(half + 1)]);
            program.cost(columns.inverse(half), h / units.length);
        }
    }
    program
}

/// As [`terms`] at knot `k`, as the start of its interval or the end of the last.
fn at_knot(knots: &Knots, k: usize, factors: [f64; 3]) -> Terms {
    let m = knots.intervals();
    if k < m { terms(knots, k, Within::Start, factors) } else { terms(knots, m - 1, Within::End, factors) }
}

/// Demands `lo <= terms <= hi`.
fn demand(program: &mut Program, units: Units, terms: Terms, (lo, hi): (f64, f64)) {
    for (sign, bound) in [(1.0, hi), (-1.0, -lo)] {
        if bound < f64::INFINITY {
            let unit = if bound == 0.0 { 1.0 } else { 1.0 / bound.abs() };
            let scaled = terms.map(|(column, value)| (column, sign * value * unit * units.x));
            program.at_most(bound * unit, &scaled);
        }
    }
}

/// Demands all rows, those on jerk by their tangents at the motion of coefficients `c`.
fn demand_rows(
    program: &mut Program,
    problem: &FeedProblem,
    barrier_problem: &BarrierProblem,
    c: &[f64],
    units: Units,
) {
    let knots = &barrier_problem.knots;
    let mut values = Values::default();
    knots.evaluate(c, &mut values);
    for k in 0..=knots.intervals() {
        for row in &barrier_problem.points[barrier_problem.first[k]..barrier_problem.first[k + 1]] {
            demand(program, units, at_knot(knots, k, [0.0, row.a, row.b]), (row.lo, row.hi));
        }
        demand(program, units, at_knot(knots, k, [0.0, 0.0, 1.0]), (f64::NEG_INFINITY, barrier_problem.caps[k][0]));
    }
    // |value| <= y (1.5 - x / 2 x0) with y = x0^(-1/2).
    // Of the step likewise: step sqrt(x) <= step sqrt(x0) (0.5 + x / 2 x0).
    let jerk = |program: &mut Program, k: usize, within: Within, (factors, step): ([f64; 3], f64), x0: f64| {
        let y = 1.0 / x0.sqrt();
        for sign in [1.0, -1.0] {
            let [alpha, beta, gamma] = factors.map(|factor| sign * factor / y);
            let row = terms(knots, k, within, [alpha, beta, gamma + 0.5 / x0 + 0.5 * step]);
            program.at_most(1.5 - 0.5 * step * x0, &row.map(|(column, value)| (column, value * units.x)));
        }
    };
    for (k, end, inner, thirds) in barrier_problem.places() {
        let within = if end == k { Within::Start } else { Within::End };
        for row in &barrier_problem.inner[inner] {
            demand(program, units, terms(knots, k, within, [row.alpha, row.beta, row.gamma]), (row.lo, row.hi));
        }
        for row in &barrier_problem.thirds[thirds] {
            jerk(program, k, within, ([row.alpha, row.beta, row.gamma], row.step), values.x[end]);
        }
    }
    for k in 0..knots.intervals() {
        for row in problem.jerk_rows(barrier_problem.from + k, Within::Middle) {
            let factors = [row.alpha, row.beta, row.gamma].map(|factor| factor / row.limit);
            jerk(program, k, Within::Middle, (factors, row.step / row.limit), values.middle[k]);
        }
    }
}

/// Demands speed and acceleration at both ends, and adds the time of the rest intervals to the
/// cost.
fn demand_ends(program: &mut Program, barrier_problem: &BarrierProblem, columns: Columns, units: Units) {
    let (knots, m) = (&barrier_problem.knots, columns.intervals);
    let ratios = barrier_problem.ratios();
    let last = m + 1;
    for (i, (outer, inner, knot)) in [(0, 1, 0), (last, last - 1, m)].into_iter().enumerate() {
        program.equal(0.0, &[(inner, 1.0), (outer, -ratios[i])]);
        let inverse = columns.inverse(2 * m + i);
        match barrier_problem.ends[i] {
            End::Moving { x, .. } => {
                program.equal(x / units.x, &[(outer, 1.0)]);
                program.equal(0.0, &[(inverse, 1.0)]);
            }
            End::Rest { h } => {
                // Constant jerk: r x <= x^(-1/2).
                let rest = barrier_problem.rest[i];
                if rest > 0.0 {
                    let most = (f64::NEG_INFINITY, rest.powf(-2.0 / 3.0));
                    demand(program, units, at_knot(knots, knot, [0.0, 0.0, 1.0]), most);
                }
                // It takes 3 h / sqrt(x).
                program.inverse(inverse, [columns.root(2 * knot); 2]);
                program.cost(inverse, 6.0 * h / units.length);
            }
        }
    }
}
