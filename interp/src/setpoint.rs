//! One moment of a motion, as a controller takes it.

use arcfeed_kinematics::Joints;
use nalgebra::Isometry3;

/// The motion of the joints at one moment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Setpoint<const N: usize = 6> {
    /// Time since the start, s.
    pub t: f64,
    /// Value of the path's parameter, m or rad.
    pub s: f64,
    /// Its derivative by time: the feed rate on a tool path, m/s (rad/s).
    pub feed: f64,
    /// Its second derivative by time: the tangential acceleration on a tool path, m/s^2 (rad/s^2).
    pub acceleration: f64,
    /// Joint positions, rad.
    pub q: Joints<N>,
    /// Joint velocities, rad/s.
    pub qd: Joints<N>,
    /// Joint accelerations, rad/s^2.
    pub qdd: Joints<N>,
    /// Joint jerks, rad/s^3.
    pub jerk: Joints<N>,
    /// Commanded tool pose in base.
    pub pose: Isometry3<f64>,
}

/// Number of control cycles of a motion, the last one of which may be shorter: it ends at the end.
///
/// The last full cycle may fall on the end to within rounding: then the end is not sampled twice.
pub(crate) fn cycles(duration: f64, period: f64) -> usize {
    ((duration / period * (1.0 - 1e-12)).floor() as usize).saturating_add(1)
}

/// The times of the setpoints of a motion, s: one per control period and one exactly at the end.
#[derive(Debug, Clone)]
pub(crate) struct SetpointTimes {
    duration: f64,
    period: f64,
    cycle: usize,
    cycles: usize,
}

impl SetpointTimes {
    pub(crate) fn new(duration: f64, period: f64) -> Self {
        Self { duration, period, cycle: 0, cycles: cycles(duration, period) }
    }

    /// Number of times in all, both ends included.
    pub(crate) fn samples(&self) -> usize {
        self.cycles.saturating_add(1)
    }
}

impl Iterator for SetpointTimes {
    type Item = f64;

    #[inline]
    fn next(&mut self) -> Option<f64> {
        if self.cycle > self.cycles {
            return None;
        }
        let t = if self.cycle == self.cycles { self.duration } else { self.cycle as f64 * self.period };
        self.cycle += 1;
        Some(t)
    }

    fn size_hint(&self) -> (usize, Option<usize>) {
        let rest = self.samples().saturating_sub(self.cycle);
        (rest, Some(rest))
    }
}
