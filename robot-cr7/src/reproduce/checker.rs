//! Judges a sampled motion from its samples alone.
//!
//! Every rule follows from the limits: over a cycle of length h with a jerk of at most J, velocity
//! and acceleration at the start of the cycle give the next position within J h^3 / 6 and the next
//! velocity within J h^2 / 2. The mean of a derivative over a cycle is a difference quotient of the
//! samples, and the mean of values inside limits is inside them.

use arcfeed_interp::Setpoint;

use super::Reproduction;

/// Round-off allowed in a share of a limit.
const SLACK: f64 = 1e-6;
/// Round-off of one sample, as a multiple of the machine precision.
const ROUNDING: f64 = 256.0 * f64::EPSILON;

/// Lower and upper bound of velocity, acceleration and jerk of one axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AxisBounds {
    /// Velocity.
    pub v: (f64, f64),
    /// Acceleration.
    pub a: (f64, f64),
    /// Jerk.
    pub j: (f64, f64),
}

impl AxisBounds {
    /// The same bounds for both signs.
    pub fn symmetric(v: f64, a: f64, j: f64) -> Self {
        Self { v: (-v, v), a: (-a, a), j: (-j, j) }
    }
}

/// The samples of one axis, what they should begin and end with, and the bounds in force.
#[derive(Debug, Clone, PartialEq)]
pub struct SampledAxis {
    /// Name of the axis.
    pub name: String,
    /// Positions.
    pub p: Vec<f64>,
    /// Velocities.
    pub v: Vec<f64>,
    /// Accelerations.
    pub a: Vec<f64>,
    /// Position, velocity and acceleration at the start.
    pub start: [f64; 3],
    /// Position, velocity and acceleration at the end.
    pub end: [f64; 3],
    /// Bounds, each from a time on (s); the first from 0 or earlier.
    pub bounds: Vec<(f64, AxisBounds)>,
}

impl SampledAxis {
    /// The motion along a path of this length (m), from rest at its start to rest at its end.
    pub fn of_path<'a>(setpoints: impl Iterator<Item = &'a Setpoint> + Clone, length: f64, bounds: AxisBounds) -> Self {
        Self {
            name: "path".to_owned(),
            p: setpoints.clone().map(|p| p.s).collect(),
            v: setpoints.clone().map(|p| p.feed).collect(),
            a: setpoints.map(|p| p.acceleration).collect(),
            start: [0.0; 3],
            end: [length, 0.0, 0.0],
            bounds: vec![(0.0, bounds)],
        }
    }
}

/// Samples of all axes at the same times.
#[derive(Debug, Clone, PartialEq)]
pub struct SampledMotion {
    /// Times, s.
    pub t: Vec<f64>,
    /// Axes.
    pub axes: Vec<SampledAxis>,
    /// Whether the motion reported its end before the cap on its cycles; `None` for a motion that is
    /// sampled over a known duration.
    pub arrived: Option<bool>,
    /// Largest error of the state at the start and at the end.
    pub tolerance: f64,
}

/// What the samples of a motion show; a value above 1 breaks its rule.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Findings {
    /// Shortest step of time, s.
    pub shortest_step: f64,
    /// Largest error of a position that velocity and acceleration predict, as a share of what the
    /// jerk limit allows.
    pub position: f64,
    /// The same for velocity.
    pub velocity: f64,
    /// Largest share of the velocity limit, in samples and in difference quotients of position.
    pub v: f64,
    /// Largest share of the acceleration limit, in samples and in difference quotients of velocity.
    pub a: f64,
    /// Largest share of the jerk limit in difference quotients of acceleration.
    pub j: f64,
    /// Largest error at the start.
    pub start: f64,
    /// Largest error at the end.
    pub end: f64,
}

/// Share of a limit that `x` uses, less its rounding error. NaN counts as beyond every limit.
fn share(x: f64, (lo, hi): (f64, f64), rounding: f64) -> f64 {
    let size = (x.abs() - rounding).max(0.0);
    let limit = if x >= 0.0 { hi } else { -lo };
    if x.is_nan() {
        f64::INFINITY
    } else if size == 0.0 {
        0.0
    } else {
        size / limit.max(0.0)
    }
}

/// Larger of two values, NaN taken for infinite.
fn most(a: f64, b: f64) -> f64 {
    if a.is_nan() || b.is_nan() { f64::INFINITY } else { a.max(b) }
}

impl SampledAxis {
    fn bounds_at(&self, t: f64) -> &AxisBounds {
        let found = self.bounds.iter().rev().find(|(from, _)| *from <= t + 1e-9);
        &found.unwrap_or(&self.bounds[0]).1
    }

    fn look(&self, t: &[f64], found: &mut Findings) {
        let state = |i: usize| [self.p[i], self.v[i], self.a[i]];
        let error =
            |got: [f64; 3], asked: [f64; 3]| (0..3).fold(0.0, |worst, k| most(worst, (got[k] - asked[k]).abs()));
        let last = t.len() - 1;
        found.start = most(found.start, error(state(0), self.start));
        found.end = most(found.end, error(state(last), self.end));
        for i in 0..=last {
            // At the moment of a change the sample belongs to the limits before it.
            let b = self.bounds_at(t[i.saturating_sub(1)]);
            found.v = most(found.v, share(self.v[i], b.v, 0.0));
            found.a = most(found.a, share(self.a[i], b.a, 0.0));
        }
        for i in 0..last {
            self.cycle(i, t[i], t[i + 1] - t[i], found);
        }
    }

    fn cycle(&self, i: usize, t: f64, h: f64, found: &mut Findings) {
        let b = self.bounds_at(t);
        let jerk = b.j.1.max(-b.j.0);
        let (p, v, a) = (&self.p[i..=i + 1], &self.v[i..=i + 1], &self.a[i..=i + 1]);
        let p_round = ROUNDING * (p[0].abs() + p[1].abs());
        let v_round = ROUNDING * (v[0].abs() + v[1].abs());
        let a_round = ROUNDING * (a[0].abs() + a[1].abs());
        let off = p[1] - p[0] - v[0] * h - 0.5 * a[0] * h * h;
        let allowed = jerk * h.powi(3) / 6.0;
        found.position = most(found.position, share(off, (-allowed, allowed), p_round + v_round * h));
        let off = v[1] - v[0] - a[0] * h;
        let allowed = 0.5 * jerk * h * h;
        found.velocity = most(found.velocity, share(off, (-allowed, allowed), v_round + a_round * h));
        found.v = most(found.v, share((p[1] - p[0]) / h, b.v, p_round / h));
        found.a = most(found.a, share((v[1] - v[0]) / h, b.a, v_round / h));
        found.j = most(found.j, share((a[1] - a[0]) / h, b.j, a_round / h));
    }
}

impl SampledMotion {
    /// What the samples show. A motion without two samples, or with rows of different lengths,
    /// breaks every rule.
    pub fn findings(&self) -> Findings {
        let whole = |axis: &SampledAxis| [&axis.p, &axis.v, &axis.a].iter().all(|x| x.len() == self.t.len());
        if self.t.len() < 2 || self.axes.is_empty() || !self.axes.iter().all(|x| whole(x) && !x.bounds.is_empty()) {
            let x = f64::INFINITY;
            return Findings { shortest_step: -x, position: x, velocity: x, v: x, a: x, j: x, start: x, end: x };
        }
        let steps = self.t.windows(2).map(|w| w[1] - w[0]);
        let shortest_step = steps.fold(f64::INFINITY, |least, h| if h < least || h.is_nan() { h } else { least });
        let mut found = Findings { shortest_step, ..Findings::default() };
        self.axes.iter().for_each(|axis| axis.look(&self.t, &mut found));
        found
    }

    /// Adds a row for each rule.
    pub fn judge(&self, r: &mut Reproduction, place: &str, of: &str) {
        let found = self.findings();
        let duration = self.t.last().copied().unwrap_or(f64::NAN);
        if let Some(arrived) = self.arrived {
            r.independent(place, format!("{of}: arrives, in s"), "", format!("{duration:.4}"), arrived);
        }
        let step = format!("{:.2e}", found.shortest_step);
        r.independent(place, format!("{of}: shortest step of time, s"), "above 0", step, found.shortest_step > 0.0);
        let shares = [
            ("position from velocity / bound by jerk", found.position),
            ("velocity from acceleration / bound by jerk", found.velocity),
            ("velocity / limit", found.v),
            ("acceleration / limit", found.a),
            ("jerk / limit", found.j),
        ];
        for (what, share) in shares {
            r.independent(place, format!("{of}: {what}"), "at most 1", format!("{share:.6}"), share <= 1.0 + SLACK);
        }
        for (what, error) in [("error at the start", found.start), ("error at the end", found.end)] {
            r.independent(place, format!("{of}: {what}"), "0", format!("{error:.1e}"), error <= self.tolerance);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// From rest with a jerk of 1 for 1 s, sampled every 0.01 s.
    fn ramp() -> SampledMotion {
        let t: Vec<f64> = (0..=100).map(|i| f64::from(i) * 0.01).collect();
        let over = |f: fn(f64) -> f64| t.iter().map(|&t| f(t)).collect::<Vec<_>>();
        let axis = SampledAxis {
            name: "x".to_owned(),
            p: over(|t| t.powi(3) / 6.0),
            v: over(|t| t * t / 2.0),
            a: over(|t| t),
            start: [0.0; 3],
            end: [1.0 / 6.0, 0.5, 1.0],
            bounds: vec![(0.0, AxisBounds::symmetric(0.5, 1.0, 1.0))],
        };
        SampledMotion { t, axes: vec![axis], arrived: None, tolerance: 1e-12 }
    }

    #[test]
    fn a_motion_at_its_limits_holds_and_each_spoiled_sample_breaks_a_rule() {
        let broken = |motion: &SampledMotion| {
            let mut r = Reproduction::new("test");
            motion.judge(&mut r, "here", "x");
            r.broken().count()
        };
        assert_eq!(broken(&ramp()), 0);
        let spoils: [fn(&mut SampledMotion); 7] = [
            |m| m.axes[0].p[50] += 1e-6,
            |m| m.axes[0].v[50] += 1e-4,
            |m| m.axes[0].a[50] += 1e-3,
            |m| m.axes[0].a[50] = f64::NAN,
            |m| m.t[50] = m.t[49],
            |m| m.axes[0].bounds[0].1.v.1 = 0.49,
            |m| m.axes[0].end[0] += 1e-9,
        ];
        for (i, spoil) in spoils.into_iter().enumerate() {
            let mut motion = ramp();
            spoil(&mut motion);
            assert!(broken(&motion) > 0, "{i}");
        }
    }
}
