//! From a plan to setpoints at the control period.

use arcfeed_feedrate::Cursor;
use arcfeed_kinematics::Joints;

use crate::arm::PathArm;
use crate::error::PlanError;
use crate::joint_path::joint_jet;
use crate::plan::Plan;
use crate::trajectory::Setpoint;

/// Yields the setpoints of a plan, one per control period and one exactly at the end.
///
/// `s(t)` is the plan's own piecewise-cubic law, the pose at `s` is exact, and the joints come from the closed-form
/// inverse nearest to the setpoint before, so that nothing accumulates. Sampling allocates nothing.
#[derive(Debug, Clone)]
pub struct Sampler<'a, A: ?Sized, const N: usize = 6> {
    plan: &'a Plan<N>,
    arm: &'a A,
    cursor: Cursor<'a>,
    period: f64,
    cycle: usize,
    cycles: usize,
    seed: Joints<N>,
}

impl<'a, A, const N: usize> Sampler<'a, A, N>
where
    A: PathArm<N> + ?Sized,
{
    pub(crate) fn new(plan: &'a Plan<N>, arm: &'a A, period: f64) -> Self {
        let duration = plan.speed().duration();
        // The last full cycle may fall on the end to within rounding: then the end is not sampled twice.
        let cycles = (duration / period * (1.0 - 1e-12)).floor() as usize + 1;
        Self {
            plan,
            arm,
            cursor: plan.speed().cursor(),
            period,
            cycle: 0,
            cycles,
            seed: plan.joint_path().nodes()[0].q,
        }
    }

    /// Number of setpoints in all, both ends included.
    pub fn samples(&self) -> usize {
        self.cycles + 1
    }

    /// The setpoint at any time `t` (taken to the nearest end of the motion).
    ///
    /// # Errors
    /// [`PlanError::Arm`] where the arm cannot stand; after a successful plan that does not happen on its path.
    #[inline]
    pub fn at(&mut self, t: f64) -> Result<Setpoint<N>, PlanError> {
        let state = self.cursor.at(t);
        let tool = self.plan.path().jet(state.p);
        let jet = joint_jet(self.arm, state.p, &tool, &self.seed)?;
        self.seed = jet.q;
        let (v, a, j) = (state.v, state.a, state.j);
        Ok(Setpoint {
            t,
            s: state.p,
            feed: v,
            acceleration: a,
            q: jet.q,
            qd: jet.d1 * v,
            qdd: jet.d1 * a + jet.d2 * (v * v),
            jerk: jet.d1 * j + jet.d2 * (3.0 * v * a) + jet.d3 * (v * v * v),
            pose: tool.pose,
        })
    }

    /// The next setpoint, or `None` after the one at the end of the motion.
    ///
    /// # Errors
    /// As [`Sampler::at`].
    #[inline]
    pub fn next_setpoint(&mut self) -> Option<Result<Setpoint<N>, PlanError>> {
        if self.cycle > self.cycles {
            return None;
        }
        let t = if self.cycle == self.cycles { self.plan.speed().duration() } else { self.cycle as f64 * self.period };
        self.cycle += 1;
        Some(self.at(t))
    }
}

impl<A, const N: usize> Iterator for Sampler<'_, A, N>
where
    A: PathArm<N> + ?Sized,
{
    type Item = Result<Setpoint<N>, PlanError>;

    fn next(&mut self) -> Option<Self::Item> {
        self.next_setpoint()
    }

    fn size_hint(&self) -> (usize, Option<usize>) {
        let rest = (self.cycles + 1).saturating_sub(self.cycle);
        (rest, Some(rest))
    }
}
