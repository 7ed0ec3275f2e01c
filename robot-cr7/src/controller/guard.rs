//! What every setpoint is held against before it is sent.

use arcfeed_kinematics::{JointLimits, Joints};

use super::fault::Fault;
use super::setpoints::NextSetpoint;

/// By how much a value may exceed its limit through rounding, relative to the limit.
const TOLERANCE: f64 = 1e-6;
/// Rounding of a position, rad.
const ROUNDING: f64 = 1e-14;

/// The limits of an arm and the setpoints before the next one.
///
/// Differences of positions one period apart are means of velocity, acceleration and jerk between them: a motion within its limits keeps
/// them at any period, and a step of a setpoint does not.
#[derive(Debug, Clone)]
pub(super) struct Guard<const N: usize> {
    limits: JointLimits<N>,
    period: f64,
    /// The last three setpoints, the latest first, rad.
    last: [Joints<N>; 3],
    /// Number of setpoints so far.
    seen: usize,
}

impl<const N: usize> Guard<N> {
    /// For an arm at rest at `start` (rad), with a setpoint every `period` (s).
    pub fn new(start: Joints<N>, limits: JointLimits<N>, period: f64) -> Self {
        Self { limits, period, last: [start; 3], seen: 0 }
    }

    /// Takes the next setpoint; the last one has to be a place at which the arm can stay.
    ///
    /// # Errors
    /// [`Fault::Unsafe`].
    pub fn check(&mut self, next: &NextSetpoint<N>) -> Result<(), Fault> {
        let index = self.seen;
        self.seen += 1;
        self.take(index, &next.q)?;
        if next.is_last {
            let mut rest = self.clone();
            (0..3).try_for_each(|_| rest.take(index, &next.q))?;
        }
        Ok(())
    }

    /// Takes the positions of setpoint `index`.
    fn take(&mut self, index: usize, q: &Joints<N>) -> Result<(), Fault> {
        let [a, b, c] = &self.last;
        let differences = [q - a, q - a * 2.0 + b, q - a * 3.0 + b * 3.0 - c];
        let limits = [self.limits.velocity(), self.limits.acceleration(), self.limits.jerk()];
        let unsafe_value = |what, joint, value, limit| Fault::Unsafe { index, what, joint, value, limit };
        for joint in 0..N {
            let (low, high) = (self.limits.lower()[joint], self.limits.upper()[joint]);
            let inside = q[joint] >= low - TOLERANCE && q[joint] <= high + TOLERANCE;
            if !inside {
                let end = if q[joint] < low { low } else { high };
                return Err(unsafe_value("position", joint, q[joint], end));
            }
            for (order, what) in ["velocity", "acceleration", "jerk"].into_iter().enumerate() {
                let step = self.period.powi(order as i32 + 1);
                let (value, limit) = (differences[order][joint] / step, limits[order][joint]);
                // Not `>`: a NaN has to show.
                let holds = value.abs() <= limit * (1.0 + TOLERANCE) + ROUNDING / step;
                if !holds {
                    return Err(unsafe_value(what, joint, value, limit));
                }
            }
        }
        self.last = [*q, *a, *b];
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use arcfeed_kinematics::JointRange;

    use super::*;

    const PERIOD: f64 = 0.03;

    fn guard() -> Guard<2> {
        let range = JointRange::new(Joints::repeat(-1.0), Joints::repeat(1.0)).expect("a range");
        let limits = range.with_rates(Joints::repeat(1.0), Joints::repeat(5.0), Joints::repeat(50.0)).expect("limits");
        Guard::new(Joints::zeros(), limits, PERIOD)
    }

    /// The first doubt in these positions of joint 2.
    fn doubt(positions: &[f64]) -> Option<(usize, &'static str)> {
        let mut guard = guard();
        let last = positions.len() - 1;
        positions.iter().enumerate().find_map(|(i, q)| {
            match guard.check(&NextSetpoint { q: Joints::from([0.0, *q]), is_last: i == last }) {
                Err(Fault::Unsafe { index, what, joint, .. }) => {
                    assert_eq!((index, joint), (i, 1));
                    Some((i, what))
                }
                Err(other) => panic!("{other:?}"),
                Ok(()) => None,
            }
        })
    }

    /// Positions after whole periods of a motion with this jerk in each of them.
    fn integrated(jerk: &[f64]) -> Vec<f64> {
        let (mut q, mut v, mut a, mut out) = (0.0, 0.0, 0.0, vec![0.0]);
        for j in jerk {
            q += PERIOD * (v + PERIOD * (a / 2.0 + PERIOD * j / 6.0));
            v += PERIOD * (a + PERIOD * j / 2.0);
            a += PERIOD * j;
            out.push(q);
        }
        out
    }

    #[test]
    fn a_motion_at_its_limits_passes() {
        // Up to 4.5 rad/s^2 with all of the jerk, and back to rest.
        let ramp = [50.0, 50.0, 50.0, 0.0, 0.0, -50.0, -50.0, -50.0];
        let back: Vec<f64> = ramp.iter().map(|j| -j).collect();
        let whole = integrated(&[&ramp[..], &[0.0; 5], &back[..], &[0.0; 3]].concat());
        assert_eq!(doubt(&whole), None);
    }

    #[test]
    fn each_limit_shows_at_the_setpoint_that_breaks_it() {
        let flat = [0.0; 4];
        assert_eq!(doubt(&[&flat[..], &[0.01]].concat()), Some((4, "acceleration")));
        assert_eq!(doubt(&[&flat[..], &[0.04]].concat()), Some((4, "velocity")));
        assert_eq!(doubt(&[&flat[..], &[2.0]].concat()), Some((4, "position")));
        assert_eq!(doubt(&[&flat[..], &[f64::NAN]].concat()), Some((4, "position")));
        assert_eq!(doubt(&[&flat[..], &[0.002]].concat()), Some((4, "jerk")));
        // The start counts as well: an arm at rest.
        assert_eq!(doubt(&[0.002, 0.002]), Some((0, "jerk")));
    }

    #[test]
    fn the_last_setpoint_is_one_at_which_the_arm_can_stay() {
        let moving = integrated(&[50.0, 50.0, 50.0, 0.0, 0.0]);
        assert_eq!(doubt(&moving).map(|(i, _)| i), Some(5));
    }
}
