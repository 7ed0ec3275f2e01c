//! The last word on a motion: its setpoints against every limit, on dense samples, without the planner's help.
//!
//! Nothing here knows how the motion was planned. Setpoints are sampled several times per
//! control period; positions, velocities and accelerations of the tool are recomputed from the
//! joints by forward kinematics; jerk comes from differences of the accelerations, which are
//! averages of the true jerk and so never exceed its maximum; and each position and velocity is
//! held against the one before, so that a jump cannot hide between samples. What rounding may add
//! to a joint position follows from the residual that the arm's inverse states, see
//! [`InverseKinematics::residual`].
//!
//! [`InverseKinematics::residual`]: arcfeed_kinematics::InverseKinematics::residual

use std::collections::VecDeque;

use super::check::Verification;
use super::requirement::Requirement;
use super::sample::Sample;
use super::tally::Tally;
use crate::error::{LimitError, PlanError};
use crate::setpoint::Setpoint;

/// Samples per control period, at least.
const DENSITY: usize = 8;
/// And so many more, that they are no further apart than this, s: a bend takes the arm no less time when its controller is
/// slow.
const FINEST: f64 = 1.25e-4;
/// But not more than this many per period.
const DENSEST: usize = 4096;
/// Motions with more samples than this are refused: more than three hours at 1 ms.
const MOST_SAMPLES: f64 = 1e8;

/// Holds a motion of length `duration` (s) against `requirement`.
///
/// `setpoint` gives the setpoint at a time; it is called with times that do not decrease, eight per control period or
/// more: at least one every 0.125 ms, and at every time of `knots` (increasing), where a law may have its extremes.
///
/// # Errors
/// [`LimitError::NotPositive`] for a duration that is not a finite number of 0 or more, [`LimitError::TooLong`] for one that
/// would take too many samples; otherwise whatever `setpoint` returns.
pub fn verify<const N: usize>(
    requirement: &Requirement<'_, N>,
    duration: f64,
    knots: &[f64],
    mut setpoint: impl FnMut(f64) -> Result<Setpoint<N>, PlanError>,
) -> Result<Verification, PlanError> {
    if !(duration.is_finite() && duration >= 0.0) {
        return Err(LimitError::NotPositive { what: "duration", value: duration }.into());
    }
    let mut tally = Tally::new(requirement);
    let density = ((requirement.period / FINEST).ceil() as usize).max(DENSITY).min(DENSEST);
    let dt = requirement.period / density as f64;
    let longest = MOST_SAMPLES * dt;
    if duration > longest {
        return Err(LimitError::TooLong { duration, longest }.into());
    }
    let steps = (duration / dt * (1.0 - 1e-12)).floor() as usize;
    // Ring of the samples of the last control period.
    let mut ring: VecDeque<Sample<N>> = VecDeque::with_capacity(density + 1);
    let mut knots = knots.iter().copied().filter(|t| *t > 0.0 && *t < duration).peekable();
    let mut samples = steps + 2;
    for i in 0..=steps + 1 {
        let t = if i > steps { duration } else { i as f64 * dt };
        while let Some(knot) = knots.next_if(|knot| *knot < t) {
            let sample = Sample::new(requirement, setpoint(knot)?);
            tally.look(&sample);
            tally.look_at_jerk(&sample.at);
            samples += 1;
        }
        let sample = Sample::new(requirement, setpoint(t)?);
        tally.look(&sample);
        if i == 0 {
            tally.end(&sample, 0.0, requirement.end_speeds[0]);
        }
        if i > steps {
            tally.end(&sample, requirement.path.length(), requirement.end_speeds[1]);
        }
        // The first of them is a whole control period ago.
        if ring.len() > density {
            ring.pop_front();
        }
        if let (Some(first), Some(before)) = (ring.front(), ring.back()) {
            tally.compare([first, before, &sample], sample.at.t - before.at.t);
        }
        ring.push_back(sample);
        // One control cycle is complete: the path within it against its chord.
        if ring.len() == density + 1 && i % density == 0 {
            tally.chord(ring.make_contiguous());
        }
    }
    // The last, shorter cycle.
    let last = ring.len().saturating_sub(steps % density + 2);
    tally.chord(&ring.make_contiguous()[last..]);
    Ok(tally.finish(samples))
}
