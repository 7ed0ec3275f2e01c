//! Bounds of the motion on whole intervals: boxes for the scans with S-profiles, caps for motion
//! that is changed while it runs.

use super::feed_problem::FeedProblem;
use crate::error::FeedError;
use crate::row::{IntervalBound, LimitId};
use crate::scan::Segment;

/// The partition of limits that couple speed, acceleration and jerk, as fractions of each limit.
/// What one of them leaves unused goes to the others.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LimitPartition {
    /// Fraction of a limit on acceleration for the acceleration along the path.
    pub acceleration: f64,
    /// Fraction of a limit on jerk for the jerk along the path.
    pub jerk: f64,
    /// Fraction of the rest of the limit on jerk for the speed alone.
    pub speed: f64,
}

impl LimitPartition {
    /// Those that the scans try; the fastest law is kept.
    pub const ALL: [Self; 4] = [
        Self { acceleration: 0.4, jerk: 0.3, speed: 0.6 },
        Self { acceleration: 0.4, jerk: 0.4, speed: 0.5 },
        Self { acceleration: 0.4, jerk: 0.3, speed: 0.8 },
        Self { acceleration: 0.4, jerk: 0.5, speed: 0.5 },
    ];

    /// The largest box `v <= V`, `|u| <= A`, `|j| <= J` of this partition in which all `bounds`
    /// hold with every sign.
    ///
    /// First what acceleration and jerk may use at most, then the speed from what is left, then the
    /// acceleration again.
    fn narrow(&self, bounds: &[IntervalBound]) -> [f64; 3] {
        let [mut v, mut a, mut j] = [f64::INFINITY; 3];
        for bound in bounds {
            match *bound {
                IntervalBound::Speed { most, .. } => v = v.min(most),
                IntervalBound::Acceleration { a: factor, b, c, rest, limit, .. } => {
                    let share = if b == 0.0 && c == 0.0 { 1.0 } else { self.acceleration };
                    a = a.min(share * (limit - rest) / factor);
                }
                IntervalBound::Jerk { alpha, beta, gamma, step, limit, .. } => {
                    let share = if beta == 0.0 && gamma == 0.0 && step == 0.0 { 1.0 } else { self.jerk };
                    j = j.min(share * limit / alpha);
                }
            }
        }
        for bound in bounds {
            match *bound {
                IntervalBound::Acceleration { a: factor, b, c, rest, limit, .. } => {
                    v = v.min(speed_for(b, c, limit - rest - used(factor, a)));
                }
                IntervalBound::Jerk { alpha, gamma, step, limit, .. } => {
                    let left = limit - used(alpha, j);
                    if gamma > 0.0 {
                        v = v.min((self.speed * left / gamma).cbrt());
                    }
                    if step > 0.0 {
                        // Half of what the speed's own share leaves, so that something is kept for
                        // the acceleration.
                        v = v.min((0.5 * (1.0 - self.speed) * left / step).sqrt());
                    }
                }
                IntervalBound::Speed { .. } => {}
            }
        }
        for bound in bounds {
            if let IntervalBound::Jerk { alpha, beta, gamma, step, limit, .. } = *bound
                && beta * v > 0.0
            {
                a = a.min((limit - used(alpha, j) - v * v * (gamma * v + step)) / (beta * v));
            }
        }
        [v, a, j]
    }
}

/// `factor x`, where a factor of 0 uses nothing of an unbounded `x`.
fn used(factor: f64, x: f64) -> f64 {
    if factor == 0.0 { 0.0 } else { factor * x }
}

/// The greatest speed with `b v^2 + c v <= left`, without cancellation; 0 where nothing is left.
fn speed_for(b: f64, c: f64, left: f64) -> f64 {
    if b == 0.0 && c == 0.0 {
        return f64::INFINITY;
    }
    let left = left.max(0.0);
    if c == 0.0 { (left / b).sqrt() } else { 2.0 * left / (c + (c * c + 4.0 * b * left).sqrt()) }
}

/// The greatest speed with `gamma v^3 + step v^2 + cross v <= left`, up to `most`.
fn speed_for_jerk([gamma, step, cross]: [f64; 3], left: f64, most: f64) -> f64 {
    let sum = |v: f64| v * (cross + v * (step + v * gamma));
    // One term alone is above the sum's root.
    let alone = [left / cross, (left / step).sqrt(), (left / gamma).cbrt()];
    let v = alone.into_iter().filter(|v| v.is_finite()).fold(most, f64::min);
    if v.is_infinite() || sum(v) <= left {
        return v;
    }
    // The sum grows with v.
    let (mut low, mut high) = (0.0, v);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        *(if sum(middle) <= left { &mut low } else { &mut high }) = middle;
    }
    low
}

/// The greatest speed at which all `bounds` hold whatever the motion does within
/// `|u| <= acceleration` and `|j| <= jerk`.
pub fn live_speed(bounds: &[IntervalBound], acceleration: f64, jerk: f64) -> f64 {
    bounds.iter().fold(f64::INFINITY, |v: f64, bound| {
        v.min(match *bound {
            IntervalBound::Speed { most, .. } => most,
            IntervalBound::Acceleration { a, b, c, rest, limit, .. } => {
                speed_for(b, c, limit - rest - used(a, acceleration))
            }
            IntervalBound::Jerk { alpha, beta, gamma, step, limit, .. } => {
                let left = (limit - used(alpha, jerk)).max(0.0);
                speed_for_jerk([gamma, step, used(beta, acceleration)], left, v)
            }
        })
    })
}

impl FeedProblem {
    /// Bounds of the motion on the whole of interval `k`; nothing unless built by
    /// [`FeedProblem::between_points`].
    pub fn interval_bounds(&self, k: usize) -> &[IntervalBound] {
        self.bounds.of(k)
    }

    /// One segment per interval with bounds on speed, acceleration and jerk along the path that are
    /// safe anywhere inside it.
    ///
    /// # Errors
    /// [`FeedError::StaticallyInfeasible`] where standing still breaks a limit,
    /// [`FeedError::Empty`] without limits on jerk, [`FeedError::Unbounded`] where nothing limits
    /// the speed.
    pub fn segments(&self, partition: &LimitPartition) -> Result<Vec<Segment>, FeedError> {
        self.holds_still()?;
        if !self.has_jerk() {
            return Err(FeedError::Empty { what: "limits on jerk" });
        }
        (0..self.intervals())
            .map(|k| {
                let [v, a, j] = partition.narrow(self.bounds.of(k));
                if v == f64::INFINITY {
                    return Err(FeedError::Unbounded { index: k, s: self.grid()[k] });
                }
                // Where nothing moves that is limited, reaching the speed and the acceleration
                // within the interval is as good as at once.
                let h = self.h(k);
                let a = if a == f64::INFINITY { v * v / h } else { a };
                let j = if j == f64::INFINITY { v * a / h } else { j };
                Segment::new(h, v, a, j)
            })
            .collect()
    }

    /// Largest acceleration and jerk along the path that no limit forbids at a standstill,
    /// anywhere.
    ///
    /// # Errors
    /// [`FeedError::StaticallyInfeasible`] where standing still breaks a limit.
    pub fn rest_limits(&self) -> Result<(f64, f64), FeedError> {
        self.holds_still()?;
        let (mut a, mut j) = (f64::INFINITY, f64::INFINITY);
        for bound in self.bounds.all() {
            match *bound {
                IntervalBound::Acceleration { a: factor, rest, limit, .. } => a = a.min((limit - rest) / factor),
                IntervalBound::Jerk { alpha, limit, .. } => j = j.min(limit / alpha),
                IntervalBound::Speed { .. } => {}
            }
        }
        Ok((a, j))
    }

    /// The greatest speed on every interval at which all limits hold whatever the motion does
    /// within `|u| <= acceleration` and `|j| <= jerk`, both below [`FeedProblem::rest_limits`].
    ///
    /// # Errors
    /// As [`FeedProblem::rest_limits`].
    pub fn live_caps(&self, acceleration: f64, jerk: f64) -> Result<Vec<f64>, FeedError> {
        self.holds_still()?;
        Ok((0..self.intervals()).map(|k| live_speed(self.bounds.of(k), acceleration, jerk)).collect())
    }

    fn holds_still(&self) -> Result<(), FeedError> {
        // The rows name a place, the bounds an interval.
        for i in 0..self.grid().len() {
            if let Some(row) = self.rows(i).iter().find(|row| !(row.lo <= row.d && row.d <= row.hi)) {
                let limit = if row.d > row.hi { row.hi } else { row.lo };
                return Err(self.not_still(i, row.source, row.d, limit));
            }
        }
        for k in 0..self.intervals() {
            for bound in self.bounds.of(k) {
                // A joint that takes no part in the motion may have nothing left.
                if let IntervalBound::Acceleration { a, b, c, rest, limit, source } = *bound
                    && (rest > limit || rest == limit && a + b + c > 0.0)
                {
                    return Err(self.not_still(k, source, rest, limit));
                }
            }
        }
        Ok(())
    }

    fn not_still(&self, index: usize, row: LimitId, value: f64, limit: f64) -> FeedError {
        FeedError::StaticallyInfeasible { index, s: self.grid()[index], row, value, limit }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::row::Quantity;

    /// Every corner of a box keeps every bound, and some bound holds with equality.
    #[test]
    fn boxes_keep_all_bounds_at_every_corner() {
        let mut seed = 7_u64;
        let mut random = move |from: f64, to: f64| {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            from + (to - from) * ((seed >> 11) as f64 / (1_u64 << 53) as f64)
        };
        let source = LimitId::path(Quantity::Other);
        for _ in 0..2000 {
            let mut bounds = vec![
                IntervalBound::Speed { most: random(0.1, 2.0), source },
                IntervalBound::Acceleration { a: 1.0, b: 0.0, c: 0.0, rest: 0.0, limit: random(0.5, 3.0), source },
                IntervalBound::Jerk { alpha: 1.0, beta: 0.0, gamma: 0.0, step: 0.0, limit: random(5.0, 30.0), source },
            ];
            for _ in 0..3 {
                let (a, b, c) = (random(0.0, 5.0), random(0.0, 50.0), random(0.0, 1.0));
                bounds.push(IntervalBound::Acceleration {
                    a,
                    b,
                    c,
                    rest: random(0.0, 0.5),
                    limit: random(1.0, 9.0),
                    source,
                });
                let (alpha, gamma) = (random(0.0, 5.0), random(0.0, 500.0));
                let (beta, step) = (random(0.0, 50.0), random(0.0, 20.0));
                bounds.push(IntervalBound::Jerk { alpha, beta, gamma, step, limit: random(20.0, 90.0), source });
            }
            let partition = LimitPartition::ALL[(random(0.0, 4.0)) as usize % 4];
            let [v, a, j] = partition.narrow(&bounds);
            assert!(v > 0.0 && a > 0.0 && j > 0.0);
            let caps = |v: f64| {
                bounds.iter().fold(0.0, |most: f64, bound| {
                    most.max(match *bound {
                        IntervalBound::Speed { most, .. } => v / most,
                        IntervalBound::Acceleration { a: x, b, c, rest, limit, .. } => {
                            (x * a + b * v * v + c * v) / (limit - rest)
                        }
                        IntervalBound::Jerk { alpha, beta, gamma, step, limit, .. } => {
                            (alpha * j + beta * v * a + gamma * v.powi(3) + step * v * v) / limit
                        }
                    })
                })
            };
            assert!(caps(v) <= 1.0 + 1e-12, "{bounds:?}: {}", caps(v));
            // The greatest speed for this acceleration and jerk: what they use may be all that there is.
            let live = live_speed(&bounds, a, j);
            assert!(live >= v * (1.0 - 1e-9), "{bounds:?}: {live} for {v}");
            let (kept, beyond) = (caps(live), caps(live * (1.0 + 1e-6) + 1e-12));
            assert!(kept <= 1.0 + 1e-9 && beyond > 1.0, "{bounds:?}: {kept}, {beyond}");
        }
    }
}
