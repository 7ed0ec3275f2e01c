//! Grid points next to rest, where the acceleration builds up.

use std::borrow::Cow;

use crate::constraint::Within;
use crate::problem::FeedProblem;
use crate::row::{JerkRow, Row};

/// Ratio of successive distances from rest.
const GROWTH: f64 = 3.0;

/// The last place at which an interval is split, as a part of it: where the acceleration has built up, or beyond. A constant jerk
/// over more than the way that it takes to build up is a lower one.
const LAST_BUILD_UP: f64 = 0.95;
const LAST: f64 = 0.6;

/// The problem with its intervals next to rest split where the acceleration has built up, and
/// coarser beyond: rows in between are interpolated, exactly so on a piecewise cubic path.
pub(super) fn refined(problem: &FeedProblem) -> Cow<'_, FeedProblem> {
    let n = problem.intervals();
    let mut cuts = Vec::new();
    for k in 0..n {
        let stops = [k, k + 1].map(|i| match i {
            0 => problem.v_start() == 0.0,
            i if i == n => problem.v_end() == 0.0,
            i => problem.x_max(i) == 0.0,
        });
        // An interval between two stops is refused elsewhere.
        let fractions = match stops {
            [true, false] => from_rest(problem, k, [k, k + 1], Within::Start),
            [false, true] => from_rest(problem, k, [k + 1, k], Within::End).iter().rev().map(|f| 1.0 - f).collect(),
            _ => Vec::new(),
        };
        if !fractions.is_empty() {
            cuts.push((k, fractions));
        }
    }
    if cuts.is_empty() { Cow::Borrowed(problem) } else { Cow::Owned(problem.split(&cuts)) }
}

/// Places at which to split interval `k`, in parts of its length from the end at rest.
fn from_rest(problem: &FeedProblem, k: usize, [rest, next]: [usize; 2], at: Within) -> Vec<f64> {
    let u = greatest_u(problem.rows(rest)).min(greatest_u(problem.rows(next)));
    let one = |row: &JerkRow| row.limit / row.alpha.abs();
    let jerk = problem.jerk_rows(k, at).iter().map(one).fold(f64::INFINITY, f64::min);
    // s = j t^3 / 6 with t = u / j, or with half the greatest speed reached.
    let time = (u / jerk).min((problem.x_max(next).sqrt() / jerk).sqrt());
    let first = jerk * time * time * time / 6.0 / problem.h(k);
    // Shorter intervals would gain nothing.
    let mut fraction = first.max(1e-4);
    let mut fractions = Vec::new();
    if fraction < LAST_BUILD_UP {
        fractions.push(fraction);
        fraction *= GROWTH;
    }
    while fraction < LAST {
        fractions.push(fraction);
        fraction *= GROWTH;
    }
    fractions
}

/// The greatest acceleration of either sign that the rows allow from rest.
pub(super) fn greatest_u(rows: &[Row]) -> f64 {
    let one = |row: &Row| ((row.hi - row.d) / row.a).abs().min(((row.lo - row.d) / row.a).abs());
    rows.iter().filter(|row| row.a != 0.0).map(one).fold(f64::INFINITY, f64::min)
}
