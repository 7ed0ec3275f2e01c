//! The bidirectional scan as published, a planner like any other: **it breaks the limits it is
//! given.**
//!
//! Forward it tests the right end of an accelerating interval alone, backward the left end of a
//! decelerating one. The other ends exceed their acceleration by 4 % to 60 % in ordinary cases. The
//! scan that keeps every limit is [`ForwardBackwardScan`](arcfeed_feedrate::ForwardBackwardScan).

use arcfeed_feedrate::{FeedError, FeedPlanner, FeedProblem, PathEnd, Row, SpeedLaw};

/// The scan of Huang et al. 2025 (eqs. 16 to 19 and Appendix A; backward pass with the sign of the
/// acceleration corrected).
#[derive(Debug, Clone, Copy, Default)]
pub struct PublishedScan;

impl FeedPlanner for PublishedScan {
    fn plan(&self, problem: &FeedProblem) -> Result<SpeedLaw, FeedError> {
        let initial = initial_velocity_limit(problem)?;
        let n = problem.intervals();
        let (x_start, x_end) = (problem.v_start().powi(2), problem.v_end().powi(2));
        for (end, i, x) in [(PathEnd::Start, 0, x_start), (PathEnd::End, n, x_end)] {
            if x > initial[i] {
                return Err(out_of_reach(problem, end, i, initial[i]));
            }
        }
        let forward = pass(problem, &initial, x_start, 0..=n)?;
        if forward[n] < x_end * (1.0 - 1e-12) {
            return Err(out_of_reach(problem, PathEnd::End, n, forward[n]));
        }
        let backward = pass(problem, &initial, x_end, (0..=n).rev())?;
        if backward[n] < x_start * (1.0 - 1e-12) {
            return Err(out_of_reach(problem, PathEnd::Start, 0, backward[n]));
        }
        let speeds = forward.iter().zip(backward.iter().rev()).map(|(a, b)| a.min(*b).sqrt());
        SpeedLaw::from_knots(problem.grid(), &speeds.collect::<Vec<_>>())
    }
}

/// The first `x` above `from` at which `p x + c sqrt(x)` leaves `lo..=hi`, inside which it is at
/// `from`; infinite where it stays inside.
fn leaves(p: f64, c: f64, (lo, hi): (f64, f64), from: f64) -> f64 {
    let crossing = |limit: f64| {
        // p w^2 + c w = limit with w = sqrt(x); the pair of roots without cancellation.
        let q = -0.5 * (c + (c * c + 4.0 * p * limit).sqrt().copysign(c));
        let w = from.max(0.0).sqrt() * (1.0 - 1e-14);
        let roots = if c == 0.0 { [(limit / p).sqrt(), f64::NAN] } else { [q / p, -limit / q] };
        let beyond = roots.into_iter().filter(|&root| root >= w && root > 0.0);
        beyond.fold(f64::INFINITY, |least, root| least.min(root * root))
    };
    crossing(lo).min(crossing(hi))
}

/// The initial velocity limit, squared: the greatest `x` for each grid point up to which all rows
/// hold at constant speed (eq. 16).
fn initial_velocity_limit(problem: &FeedProblem) -> Result<Vec<f64>, FeedError> {
    let at = |(i, &s): (usize, &f64)| {
        problem.rows(i).iter().try_fold(problem.cap(i).0, |most, row: &Row| {
            if !(row.lo <= row.d && row.d <= row.hi) {
                let limit = if row.d > row.hi { row.hi } else { row.lo };
                let (row, value) = (row.source, row.d);
                return Err(FeedError::StaticallyInfeasible { index: i, s, row, value, limit });
            }
            Ok(most.min(leaves(row.b, row.c, (row.lo - row.d, row.hi - row.d), 0.0)))
        })
    };
    problem.grid().iter().enumerate().map(at).collect()
}

/// Squared speeds along a pass (eqs. 17 to 19), in its order: each point takes the greatest one up
/// to which its own rows hold with the acceleration from the point before.
fn pass(
    problem: &FeedProblem,
    initial: &[f64],
    x: f64,
    order: impl Iterator<Item = usize>,
) -> Result<Vec<f64>, FeedError> {
    let s = problem.grid();
    let mut speeds: Vec<f64> = Vec::with_capacity(s.len());
    let mut before: Option<(usize, f64)> = None;
    for i in order {
        let next = match before {
            None => x,
            // Steps 5 and 21: a limit below the last speed is taken as it is.
            Some((_, old)) if initial[i] <= old => initial[i],
            Some((k, old)) => {
                let per_u = 0.5 / (s[i] - s[k]);
                let most = problem.rows(i).iter().fold(initial[i], |most, row| {
                    let (a, rest) = (row.a * per_u, row.d - row.a * per_u * old);
                    most.min(leaves(a + row.b, row.c, (row.lo - rest, row.hi - rest), old))
                });
                most.max(old)
            }
        };
        if next == f64::INFINITY {
            return Err(FeedError::Unbounded { index: i, s: s[i] });
        }
        speeds.push(next);
        before = Some((i, next));
    }
    Ok(speeds)
}

fn out_of_reach(problem: &FeedProblem, end: PathEnd, i: usize, highest: f64) -> FeedError {
    let speed = if i == 0 { problem.v_start() } else { problem.v_end() };
    let (row, s) = (problem.cap(i).1, problem.grid()[i]);
    FeedError::SpeedOutOfReach { end, speed, lowest: 0.0, highest: highest.sqrt(), row, s }
}
