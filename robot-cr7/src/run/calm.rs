//! Less jerk, until what a motion leaves shaking is within the limits of the job.
//!
//! The limit on the jerk of all joints is lowered by one factor: halved until every residual vibration is within its limit, and raised
//! again by bisection as long as it stays so. Each plan is made and verified in full, and its vibration is computed from the
//! trajectory itself. A residual does not fall steadily with the jerk: the factor is the highest of those tried, and none above it is
//! known to fail.

use std::sync::Arc;

use arcfeed_interp::{LimitError, MotionPath, PathArm, Trajectory};

use super::error::Cr7Error;
use super::side_effects::VibrationLine;
use super::task::Task;
use super::task_limits::TaskLimits;
use crate::text::number;

/// The jerk is halved so often at the most.
const HALVINGS: usize = 14;
/// Bisections of the factor, by its logarithm.
const BISECTIONS: usize = 5;

impl<A: PathArm<N>, const N: usize> Task<A, N> {
    /// The limits of the job with the part `factor` of the joints' jerk.
    pub(crate) fn limits_with_jerk(&self, factor: f64) -> Result<TaskLimits<N>, Cr7Error> {
        let own = self.own_limits();
        let joints = &own.joints;
        let (velocity, acceleration, jerk) = (*joints.velocity(), *joints.acceleration(), joints.jerk() * factor);
        let joints = joints.range().with_rates(velocity, acceleration, jerk).map_err(LimitError::from);
        Ok(TaskLimits { joints: joints.map_err(|source| self.error(source.into()))?, ..own.clone() })
    }

    /// The trajectory along `path`, with the part of the joints' jerk that keeps the limits on vibration.
    pub(crate) fn calm_trajectory<'p>(
        &'p self,
        path: &Arc<dyn MotionPath<N> + 'p>,
    ) -> Result<(Trajectory<'p, N>, f64), Cr7Error> {
        let plan = |factor: f64| {
            let limits = if factor == 1.0 { self.own_limits().clone() } else { self.limits_with_jerk(factor)? };
            let planner = self.planner_beside(&limits, &self.own_limits().tables)?;
            planner.plan_shared(path.clone()).map_err(|source| self.error(source))
        };
        let worst = |trajectory: &Trajectory<'p, N>| {
            let lines = VibrationLine::all(self.vibrations(), trajectory).map_err(|source| self.error(source))?;
            Ok::<_, Cr7Error>(lines.into_iter().max_by(|a, b| a.used().total_cmp(&b.used())))
        };
        let holds =
            |trajectory: &Trajectory<'p, N>| Ok::<_, Cr7Error>(worst(trajectory)?.is_none_or(|line| line.holds()));
        let limited = self.vibrations().iter().any(|vibration| vibration.limit.is_some());
        if limited && !self.method().limits_jerk() {
            return Err(self.residual(
                "the planner of the job limits no jerk: choose plan.planner = \"jerk-limited\", or remove the limit",
            ));
        }
        let mut trajectory = plan(1.0)?;
        if holds(&trajectory)? {
            return Ok((trajectory, 1.0));
        }
        let (mut low, mut high) = (1.0, 1.0);
        for halving in 0..=HALVINGS {
            if halving == HALVINGS {
                return Err(self.shaking(worst(&trajectory)?, low));
            }
            (low, high) = (0.5 * low, low);
            trajectory = plan(low)?;
            if holds(&trajectory)? {
                break;
            }
        }
        for _ in 0..BISECTIONS {
            let middle = (low * high).sqrt();
            let other = plan(middle)?;
            if holds(&other)? {
                (trajectory, low) = (other, middle);
            } else {
                high = middle;
            }
        }
        Ok((trajectory, low))
    }

    /// A limit on residual vibration that cannot be kept here.
    pub(crate) fn residual(&self, why: &'static str) -> Cr7Error {
        Cr7Error::Residual { file: self.file().to_owned(), why }
    }

    fn shaking(&self, worst: Option<VibrationLine>, factor: f64) -> Cr7Error {
        let words = |line: &VibrationLine| {
            let limit = line.residual_limit.map(|limit| line.shown(limit)).unwrap_or_default();
            let key = if line.joint.is_some() { "residual_limit_deg" } else { "residual_limit_mm" };
            (format!("{}: {} after the end, above {limit}", line.place(), line.shown(line.residual)), key)
        };
        let (what, key) = worst.as_ref().map(words).unwrap_or_default();
        Cr7Error::Shaking { file: self.file().to_owned(), what, factor: number(factor), key }
    }
}
