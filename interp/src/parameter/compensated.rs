//! The second-order Taylor step with the loop closed by arc length.

use arcfeed_geometry::{Curve, GeometryError, NurbsCurve};

use super::{FeedCycle, ParameterStep};

/// The compensated step of Liu et al. 2023, eqs. 37-39 (corrected: the objective is `(S(u) - s)^2`).
///
/// A Taylor step to the arc length asked for gives a first value, Newton steps on the true arc length correct it. Since
/// each cycle aims at the absolute arc length, nothing accumulates, and the last cycle ends exactly on the end of the
/// curve.
#[derive(Debug, Clone)]
pub struct CompensatedTaylor<'a> {
    curve: &'a NurbsCurve<3>,
    length: f64,
    u: f64,
    s: f64,
}

/// At most so many Newton steps a cycle. Each squares the relative error of the Taylor step, which at a sharp bend can
/// be most of the step; elsewhere one or two are enough and the rest is skipped.
const CORRECTIONS: usize = 8;

impl<'a> CompensatedTaylor<'a> {
    /// Starts at the beginning of `curve`, whose length is measured to `tolerance` (m).
    ///
    /// # Errors
    /// Fails when the tolerance is not above 0.
    pub fn new(curve: &'a NurbsCurve<3>, tolerance: f64) -> Result<Self, GeometryError> {
        Ok(Self { curve, length: curve.arc_length(tolerance)?, u: curve.domain().0, s: 0.0 })
    }

    /// Arc length from the present place to `u`.
    fn onward(&self, u: f64) -> f64 {
        // The tolerance is a constant above 0, the only thing the call refuses.
        self.curve.arc_length_between(self.u, u, 1e-17 * self.length.max(f64::MIN_POSITIVE * 1e20)).unwrap_or(0.0)
    }
}

impl ParameterStep for CompensatedTaylor<'_> {
    fn name(&self) -> &'static str {
        "compensated Taylor"
    }

    fn step(&mut self, cycle: &FeedCycle) -> f64 {
        let end = self.curve.domain().1;
        if cycle.s >= self.length * (1.0 - 1e-15) {
            (self.u, self.s) = (end, self.length);
            return self.u;
        }
        // Eq. 37: u', u'' by arc length at the present place, over the distance that is really left of this cycle.
        let ds = cycle.s - self.s;
        let jet = self.curve.jet(self.u);
        let q = jet.d1.norm_squared();
        let (du, ddu) = (1.0 / q.sqrt(), -jet.d1.dot(&jet.d2) / (q * q));
        let mut u = super::taylor::advance(self.curve, self.u, du * ds + 0.5 * ddu * ds * ds);
        let mut covered = self.onward(u);
        for _ in 0..CORRECTIONS {
            let correction = (covered - ds) / self.curve.jet(u).speed();
            // A correction of 0 (or NaN, where the curve stands still) ends the search.
            if correction.is_nan() || correction.abs() <= f64::EPSILON * (end - self.u).abs() {
                break;
            }
            u = (u - correction).max(self.u).min(end);
            covered = self.onward(u);
        }
        self.s += covered;
        self.u = u;
        u
    }
}
