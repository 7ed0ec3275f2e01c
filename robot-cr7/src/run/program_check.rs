//! The samples of a program against the limits of the joints, without the help of its planner.

use arcfeed_feedrate::AxisState;
use arcfeed_interp::{JointCheck, JointRates, JointSample, Method, Verification};
use arcfeed_kinematics::{JointLimits, Joints};

use super::trajectory_row::TrajectoryRow;

/// Holds the rows of a trajectory against the limits of the joints and against each other.
///
/// It sees nothing but the rows: jumps between parts show as they do within one.
#[derive(Debug, Clone)]
pub struct ProgramCheck<const N: usize = 6> {
    check: JointCheck<N>,
    rates: JointRates<N>,
    period: f64,
    before: Option<TrajectoryRow<N>>,
}

impl<const N: usize> ProgramCheck<N> {
    /// A check of nothing yet, for rows one `period` (s) apart.
    pub(crate) fn new(limits: &JointLimits<N>, method: Method, period: f64) -> Self {
        let mut rates = JointRates::from(limits);
        if !method.limits_jerk() {
            rates.jerk = Joints::repeat(f64::INFINITY);
        }
        Self { check: JointCheck::new(limits.range()), rates, period, before: None }
    }

    /// The next row.
    pub fn see(&mut self, row: &TrajectoryRow<N>) {
        // Differences of times lose digits as these grow; the last row may come sooner.
        let dt = self.before.map_or(0.0, |before| row.t - before.t);
        let whole = (dt - self.period).abs() <= 1e-6 * self.period;
        self.check.see(&JointSample::from(row), if whole { self.period } else { dt }, &self.rates);
        self.before = Some(*row);
    }

    /// For every limit the place where the rows come closest to it; `at_rest` says whether the last row has to rest.
    pub fn finish(mut self, at_rest: bool) -> Verification {
        if let Some(last) = self.before.filter(|_| at_rest) {
            let state = |k: usize| AxisState::new(last.q[k], last.qd[k], last.qdd[k]);
            let states: [AxisState; N] = std::array::from_fn(state);
            let wanted: [AxisState; N] = std::array::from_fn(|k| AxisState::new(last.q[k], 0.0, 0.0));
            self.check.see_end(last.t, &states, &wanted);
        }
        self.check.finish()
    }
}
