//! From the feed rate to the curve's parameter, cycle by cycle: four ways behind one trait, and a measure to compare them.
//!
//! A path given by its own parameter `u` has to be run through so that arc length grows by what the feed asks for. The
//! Taylor steps of common interpolators lose a little each cycle; the closed-loop step does not; the arc-length map has
//! the answer ready. [`fluctuation`] measures each by true arc length.

mod arc_length;
mod compensated;
mod taylor;

pub use arc_length::ArcLengthStep;
pub use compensated::CompensatedTaylor;
pub use taylor::{FirstTaylor, SecondTaylor};

use arcfeed_feedrate::MotionLaw;
use arcfeed_geometry::{ArcLengthCurve, Curve};

use crate::error::{PlanError, positive};
use crate::setpoint::cycles;

/// The demand of the feed on one control cycle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FeedCycle {
    /// Length of the cycle, s.
    pub period: f64,
    /// Feed rate at its start, m/s.
    pub feed: f64,
    /// Tangential acceleration at its start, m/s^2.
    pub acceleration: f64,
    /// Arc length from the start of the path to be reached at its end, m.
    pub s: f64,
}

/// A way to advance the parameter of a curve by one control cycle.
pub trait ParameterStep {
    /// Name in words.
    fn name(&self) -> &'static str;

    /// The parameter at the end of the cycle; it never decreases and never leaves the curve's domain.
    fn step(&mut self, cycle: &FeedCycle) -> f64;
}

/// The feed accuracy of a [`ParameterStep`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fluctuation {
    /// Largest relative difference between the arc length run through in a cycle and the one asked for. Cycles of less
    /// than a thousandth of the largest step are left out: near a standstill the ratio means nothing.
    pub largest: f64,
    /// Root of the mean square of the same.
    pub rms: f64,
    /// Parameter at the end of the motion, as a fraction of the domain; 1 is the end of the curve.
    pub end: f64,
    /// Arc length missing (or surplus) at the end of the motion, m: the accumulated truncation error.
    pub truncation: f64,
}

/// Runs `step` over the motion `law` along `curve` at the control `period` (s) and measures what comes out, by adaptive
/// quadrature of the arc length.
///
/// # Errors
/// Fails when the period is not a finite number above 0.
pub fn fluctuation(
    curve: &ArcLengthCurve<3>,
    law: &impl MotionLaw,
    period: f64,
    step: &mut dyn ParameterStep,
) -> Result<Fluctuation, PlanError> {
    positive("control period", period)?;
    let nurbs = curve.curve();
    let (start, end) = nurbs.domain();
    let precision = 1e-17 * curve.length().max(f64::MIN_POSITIVE * 1e20);
    let cycles = cycles(law.duration(), period);
    let mut steps = Vec::with_capacity(cycles);
    let (mut u, mut before) = (start, law.at(0.0));
    for i in 1..=cycles {
        let now = law.at(i as f64 * period);
        let next = step.step(&FeedCycle { period, feed: before.v, acceleration: before.a, s: now.p });
        steps.push((now.p - before.p, nurbs.arc_length_between(u, next, precision)?));
        (u, before) = (next, now);
    }
    let longest = steps.iter().fold(0.0f64, |m, s| m.max(s.0));
    let (mut largest, mut sum, mut count) = (0.0f64, 0.0, 0usize);
    for &(asked, got) in steps.iter().filter(|s| s.0 > 1e-3 * longest) {
        let relative = (got - asked) / asked;
        largest = largest.max(relative.abs());
        sum += relative * relative;
        count += 1;
    }
    Ok(Fluctuation {
        largest,
        rms: (sum / count.max(1) as f64).sqrt(),
        end: (u - start) / (end - start),
        truncation: before.p - nurbs.arc_length_between(start, u, precision)?,
    })
}
