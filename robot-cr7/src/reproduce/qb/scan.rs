//! The scan of Huang et al. 2025 (Appendix A), written a second time from the paper, with its
//! curves beta and alpha.

use arcfeed_feedrate::{FeedProblem, Row};

/// The curves of the scan at the points of a grid.
#[derive(Debug, Clone, PartialEq)]
pub struct ScanRun {
    /// Grid.
    pub s: Vec<f64>,
    /// Initial velocity limit (eq. 16).
    pub initial: Vec<f64>,
    /// Forward scan: the curves beta.
    pub forward: Vec<f64>,
    /// Backward scan: the curves alpha.
    pub backward: Vec<f64>,
}

/// Relative slack of a row, so that a row that is tight at the start of a step is not broken by
/// rounding.
const SLACK: f64 = 1e-12;

fn holds(row: &Row, u: f64, v: f64) -> bool {
    let value = row.a * u + row.b * v * v + row.c * v + row.d;
    let slack = SLACK * (row.hi - row.lo);
    value <= row.hi + slack && value >= row.lo - slack
}

/// The first speed above `from` at which a row breaks, at most `to`: a walk, then halving.
pub(super) fn first_break(from: f64, to: f64, keeps: &dyn Fn(f64) -> bool) -> f64 {
    const STEPS: u32 = 400;
    let at = |i: u32| from + (to - from) * f64::from(i) / f64::from(STEPS);
    let Some(i) = (1..=STEPS).find(|&i| !keeps(at(i))) else { return to };
    let (mut good, mut bad) = (at(i - 1), at(i));
    for _ in 0..60 {
        let middle = 0.5 * (good + bad);
        if keeps(middle) { good = middle } else { bad = middle }
    }
    good
}

impl ScanRun {
    /// Scans the rows of a motion from rest to rest.
    pub fn measure(rows: &FeedProblem) -> Self {
        let s = rows.grid().to_vec();
        let n = s.len();
        let initial: Vec<f64> = (0..n)
            .map(|i| first_break(0.0, rows.cap(i).0.sqrt(), &|v| rows.rows(i).iter().all(|row| holds(row, 0.0, v))))
            .collect();
        let pass = |order: &[usize]| {
            let mut speeds = vec![0.0; n];
            let mut old = 0.0;
            for w in order.windows(2) {
                let (before, k) = (w[0], w[1]);
                let h = s[k] - s[before];
                let top = initial[k];
                // Steps 5 and 21: a limit below the last speed is taken as it is.
                old = if top <= old {
                    top
                } else {
                    first_break(old, top, &|v| {
                        let u = (v * v - old * old) / (2.0 * h);
                        rows.rows(k).iter().all(|row| holds(row, u, v))
                    })
                };
                speeds[k] = old;
            }
            speeds
        };
        let up: Vec<usize> = (0..n).collect();
        let down: Vec<usize> = (0..n).rev().collect();
        let (forward, backward) = (pass(&up), pass(&down));
        Self { s, initial, forward, backward }
    }

    /// The final speed at a grid point.
    pub fn speed(&self, i: usize) -> f64 {
        self.forward[i].min(self.backward[i])
    }

    /// Where the final speed lies on the initial limit: ends of the clamps longer than a hundredth
    /// of the motion.
    pub fn clamps(&self) -> Vec<(f64, f64)> {
        let end = self.s[self.s.len() - 1];
        let mut clamps: Vec<(f64, f64)> = Vec::new();
        for i in (0..self.s.len()).filter(|&i| self.speed(i) >= (1.0 - 1e-3) * self.initial[i]) {
            match clamps.last_mut() {
                Some(last) if self.s[i] - last.1 < 4e-3 * end => last.1 = self.s[i],
                _ => clamps.push((self.s[i], self.s[i])),
            }
        }
        clamps.retain(|(from, to)| to - from > 0.01 * end);
        clamps
    }
}
