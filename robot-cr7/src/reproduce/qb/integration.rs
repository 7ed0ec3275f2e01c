//! Numerical integration with switching points, the method that Huang et al. 2025 compare with
//! (section 4.1, their references 32 to 35 and 40): bang-bang in the phase plane.
//!
//! The paper does not print reference 40. This is the scheme that the references share, with
//! velocity limits: the greatest acceleration up to the limit curve, along the curve where the least
//! and the greatest acceleration enclose its slope, and otherwise on to the next switching point,
//! from which the least acceleration leads back to the speeds found so far.

use std::time::Instant;

use arcfeed_feedrate::{FeedError, FeedPlanner, FeedProblem, ForwardBackwardScan, Reachability, Row};

use super::scan::first_break;
use crate::reproduce::Reproduction;

/// Share of a limit below which a row bounds no acceleration.
const FLAT: f64 = 1e-12;
/// How far below the limit curve a switching point is tried, as shares of the squared speed.
const BELOW: [f64; 7] = [0.0, 1e-4, 3e-4, 1e-3, 3e-3, 1e-2, 3e-2];
/// Largest difference of the duration from that of reachability, as a share.
const AGREES: f64 = 5e-3;
/// Runs of which the best time counts.
const RUNS: usize = 5;

/// The speeds of the integration on the grid of a problem.
#[derive(Debug, Clone, PartialEq)]
pub struct IntegrationRun {
    /// Grid.
    pub s: Vec<f64>,
    /// Squared speeds.
    pub x: Vec<f64>,
    /// Switching points on the limit curve, between the first and the last switch.
    pub switches: Vec<f64>,
    /// Duration by reachability on the same rows, s.
    pub reachability: f64,
    /// Duration by the forward-backward scan on the same rows, s.
    pub scan: f64,
    /// Time from rows to speeds: integration, forward-backward scan, s.
    pub times: [f64; 2],
}

/// Least and greatest acceleration at a squared speed; `None` where there is none.
fn accelerations(rows: &[Row], x: f64) -> Option<(f64, f64)> {
    let (mut least, mut most) = (f64::NEG_INFINITY, f64::INFINITY);
    for row in rows {
        let rest = row.b * x + row.c * x.sqrt() + row.d;
        let (lo, hi) = (row.lo - rest, row.hi - rest);
        if row.a.abs() <= FLAT * (row.hi - row.lo) {
            if lo > 0.0 || hi < 0.0 {
                return None;
            }
            continue;
        }
        let (a, b) = (lo / row.a, hi / row.a);
        least = least.max(a.min(b));
        most = most.min(a.max(b));
    }
    (least <= most).then_some((least, most))
}

/// The phase plane of a problem on its grid.
struct Plane<'a> {
    rows: &'a FeedProblem,
    /// Squared limit curve: maximum velocity curve and velocity limits.
    limit: Vec<f64>,
}

impl Plane<'_> {
    fn new(rows: &FeedProblem) -> Plane<'_> {
        let top = |i: usize| {
            let keeps = |v: f64| accelerations(rows.rows(i), v * v).is_some();
            // Just inside, where the least and the greatest acceleration differ.
            first_break(0.0, rows.cap(i).0.sqrt(), &keeps).powi(2) * (1.0 - 1e-9)
        };
        Plane { rows, limit: (0..rows.grid().len()).map(top).collect() }
    }

    /// Squared speed at the neighbour `to` of point `i` with the least or the greatest
    /// acceleration, by Heun's rule.
    fn step(&self, i: usize, to: usize, x: f64, pick: fn((f64, f64)) -> f64) -> Option<f64> {
        let h = self.rows.grid()[to] - self.rows.grid()[i];
        let first = pick(accelerations(self.rows.rows(i), x)?);
        let guess = (x + 2.0 * h * first).max(0.0);
        let second = accelerations(self.rows.rows(to), guess).map_or(first, pick);
        Some(x + h * (first + second))
    }

    /// Integrates forward from the last of `x`; stops where the motion would leave the limit curve.
    fn forward(&self, x: &mut Vec<f64>) {
        while x.len() < self.limit.len() {
            let (i, last) = (x.len() - 1, x[x.len() - 1]);
            let top = self.limit[i + 1];
            match self.step(i, i + 1, last, |(_, most)| most) {
                Some(next) if next <= top => x.push(next.max(0.0)),
                // Along the curve, if the least acceleration stays below it.
                Some(_) if self.step(i, i + 1, last, |(least, _)| least).is_some_and(|low| low <= top) => x.push(top),
                _ => return,
            }
        }
    }

    /// Integrates backward from squared speed `end` at point `j` until it meets `x`, and replaces
    /// what lies behind. False if it leaves the limit curve before.
    fn backward(&self, j: usize, end: f64, x: &mut Vec<f64>) -> bool {
        let mut back = vec![end];
        let mut i = j;
        while i > 0 {
            let last = back[back.len() - 1];
            let Some(before) = self.step(i, i - 1, last, |(least, _)| least) else { return false };
            let lowest = self.step(i, i - 1, last, |(_, most)| most).unwrap_or(before);
            i -= 1;
            if i < x.len() && before >= x[i] {
                x.truncate(i + 1);
                x.extend(back.iter().rev());
                return true;
            }
            // Along the curve, if the greatest acceleration comes from below it.
            if before < 0.0 || lowest > self.limit[i] {
                return false;
            }
            back.push(before.min(self.limit[i]));
        }
        false
    }

    /// The next point on the limit curve behind `from` that leads back to `x` and on along the
    /// curve or below it. Where the curve has a minimum between two points of the grid, its point
    /// there is below both.
    fn switch(&self, from: usize, x: &mut Vec<f64>) -> Option<usize> {
        (from..self.limit.len() - 1).find(|&j| {
            let is_minimum = self.limit[j] <= self.limit[j - 1].min(self.limit[j + 1]);
            let below = if is_minimum { &BELOW[..] } else { &BELOW[..1] };
            below.iter().any(|share| {
                let on = self.limit[j] * (1.0 - share);
                let goes_on = self.step(j, j + 1, on, |(least, _)| least).is_some_and(|next| next <= self.limit[j + 1]);
                goes_on && self.backward(j, on, x)
            })
        })
    }
}

/// Squared speeds from rest to rest, and the switching points.
fn integrate(rows: &FeedProblem) -> Option<(Vec<f64>, Vec<f64>)> {
    let (plane, last) = (Plane::new(rows), rows.grid().len() - 1);
    let (mut x, mut switches) = (vec![0.0], Vec::new());
    loop {
        plane.forward(&mut x);
        if x.len() > last {
            break;
        }
        let from = x.len();
        let j = plane.switch(from, &mut x)?;
        switches.push(rows.grid()[j]);
    }
    plane.backward(last, 0.0, &mut x).then_some((x, switches))
}

fn timed<T>(run: impl Fn() -> T) -> f64 {
    let time = || {
        let begin = Instant::now();
        std::hint::black_box(run());
        begin.elapsed().as_secs_f64()
    };
    (0..RUNS).map(|_| time()).fold(f64::INFINITY, f64::min)
}

impl IntegrationRun {
    /// Integrates over the rows of a motion from rest to rest, which has to have a limit of velocity everywhere.
    ///
    /// # Errors
    /// [`FeedError`] of the planners beside it. A motion that the integration does not find has no
    /// speeds.
    pub fn measure(rows: &FeedProblem) -> Result<Self, FeedError> {
        let (x, switches) = integrate(rows).unwrap_or_default();
        Ok(Self {
            s: rows.grid().to_vec(),
            x,
            switches,
            reachability: Reachability.plan(rows)?.duration(),
            scan: ForwardBackwardScan.plan(rows)?.duration(),
            times: [timed(|| integrate(rows)), timed(|| ForwardBackwardScan.plan(rows))],
        })
    }

    /// Duration with constant acceleration between the points, s; infinite without speeds.
    pub fn duration(&self) -> f64 {
        if self.x.len() != self.s.len() {
            return f64::INFINITY;
        }
        let steps = self.s.windows(2).zip(self.x.windows(2));
        steps.map(|(s, x)| 2.0 * (s[1] - s[0]) / (x[0].sqrt() + x[1].sqrt())).sum()
    }

    /// Adds the rows.
    pub fn judge(&self, r: &mut Reproduction, place: &str) {
        let duration = self.duration();
        r.information(place, "numerical integration, duration, s", "", format!("{duration:.4}")).note(format!(
            "{} switching points on the limit curve; on the same {} intervals reachability {:.4} s, forward-backward \
             {:.4} s",
            self.switches.len(),
            self.s.len() - 1,
            self.reachability,
            self.scan
        ));
        let off = (duration / self.reachability - 1.0).abs();
        r.independent(
            place,
            "duration by numerical integration beside reachability",
            "equal",
            format!("{:.3} % off", off * 1e2),
            off <= AGREES,
        )
        .note("two methods for the same optimum, on rows of the same grid");
        let [integration, scan] = self.times.map(|t| t * 1e3);
        r.information(
            place,
            "numerical integration, time from rows to speeds, ms",
            "more than 30",
            format!("{integration:.2}"),
        )
        .note(format!("forward-backward scan {scan:.2} ms; best of {RUNS}, inverse kinematics not included"));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use arcfeed_feedrate::constraint::{JointAcceleration, JointVelocity, PathDerivatives};

    /// Two joints, the second on a wave: the limit curve dips at each crest, and the optimum touches it there.
    #[test]
    fn a_wave_is_passed_by_switching_points_as_fast_as_by_reachability() {
        let n = 2000;
        for (height, waves) in [(0.05, 2.0), (0.1, 3.0), (0.02, 5.0)] {
            let grid: Vec<f64> = (0..=n).map(|i| f64::from(i) / f64::from(n)).collect();
            let k = waves * std::f64::consts::TAU;
            let first: Vec<f64> = grid.iter().flat_map(|s| [1.0, height * k * (k * s).cos()]).collect();
            let second: Vec<f64> = grid.iter().flat_map(|s| [0.0, -height * k * k * (k * s).sin()]).collect();
            let path = PathDerivatives::new(2, &first, &second).expect("finite");
            let limit = JointAcceleration::new(path, &[1.0, 1.0]).expect("positive");
            let velocity = JointVelocity::new(path, &[2.0, 2.0]).expect("positive");
            let rows = FeedProblem::at_points(&grid, &[&velocity, &limit]).expect("a problem");
            let run = IntegrationRun::measure(&rows).expect("a motion");
            let ratio = run.duration() / run.reachability;
            assert!((ratio - 1.0).abs() < AGREES && !run.switches.is_empty(), "{ratio} {:?}", run.switches);
        }
    }
}
