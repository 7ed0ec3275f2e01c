//! Open-loop Taylor steps of first and second order.

use arcfeed_geometry::{Curve, NurbsCurve};

use super::{FeedCycle, ParameterStep};

/// `u += T v / |C'|`: the first-order Taylor step. What it loses each cycle accumulates.
#[derive(Debug, Clone)]
pub struct FirstTaylor<'a> {
    curve: &'a NurbsCurve<3>,
    u: f64,
}

impl<'a> FirstTaylor<'a> {
    /// Starts at the beginning of `curve`.
    pub fn new(curve: &'a NurbsCurve<3>) -> Self {
        Self { curve, u: curve.domain().0 }
    }
}

impl ParameterStep for FirstTaylor<'_> {
    fn name(&self) -> &'static str {
        "first-order Taylor"
    }

    fn step(&mut self, cycle: &FeedCycle) -> f64 {
        let speed = self.curve.jet(self.u).speed();
        self.u = advance(self.curve, self.u, cycle.period * cycle.feed / speed);
        self.u
    }
}

/// The second-order Taylor step (Liu et al. 2023, eqs. 33 and 34), open-loop: it loses less, but still accumulates.
#[derive(Debug, Clone)]
pub struct SecondTaylor<'a> {
    curve: &'a NurbsCurve<3>,
    u: f64,
}

impl<'a> SecondTaylor<'a> {
    /// Starts at the beginning of `curve`.
    pub fn new(curve: &'a NurbsCurve<3>) -> Self {
        Self { curve, u: curve.domain().0 }
    }
}

impl ParameterStep for SecondTaylor<'_> {
    fn name(&self) -> &'static str {
        "second-order Taylor"
    }

    fn step(&mut self, cycle: &FeedCycle) -> f64 {
        let (t, v, a) = (cycle.period, cycle.feed, cycle.acceleration);
        let jet = self.curve.jet(self.u);
        let q = jet.d1.norm_squared();
        let by_feed = v / q.sqrt();
        let change = a / q.sqrt() - v * v * jet.d1.dot(&jet.d2) / (q * q);
        self.u = advance(self.curve, self.u, t * by_feed + 0.5 * t * t * change);
        self.u
    }
}

/// `u + du`, not backwards and not past the end.
pub(super) fn advance(curve: &NurbsCurve<3>, u: f64, du: f64) -> f64 {
    let end = curve.domain().1;
    // `max` first: where the curve stands still the step is NaN and u stays.
    u + du.max(0.0).min(end - u)
}
