//! Plans whose compiled motion keeps the limits of the tool as well.

use std::sync::Arc;

use arcfeed_feedrate::{LimitId, Quantity};

use super::error::CompileError;
use super::joint_trajectory::JointTrajectory;
use super::tool_certificate::ToolCertificate;
use crate::path::MotionPath;
use crate::place::PathParameter;
use crate::planner::Planner;
use crate::problem::Held;
use crate::trajectory::Trajectory;

/// By how much a limit may seem to be exceeded through rounding.
const TOLERANCE: f64 = 1e-6;

/// A plan, its compiled motion, and what the tool of that does.
#[derive(Debug, Clone)]
pub struct CompiledPlan<'p, const N: usize = 6> {
    /// The plan.
    pub trajectory: Trajectory<'p, N>,
    /// Its motion as polynomials of the time.
    pub compiled: JointTrajectory<N>,
    /// Bounds on the motion of the tool that these polynomials make.
    pub tool: ToolCertificate,
}

impl<'a, const N: usize> Planner<'a, N> {
    /// Plans the motion along `path` and compiles it with quintic pieces, no joint of which deviates from the plan by more than
    /// `tolerance`, rad.
    ///
    /// The compiled motion was certified. At all times it keeps the limits on position, velocity, acceleration and jerk of the joints,
    /// and those on feed, angular speed, tangential and normal acceleration of the tool. Where the pieces would exceed a limit of the
    /// tool, the motion is planned again with less of it. Limits on tangential and normal jerk, torque and chord error are those of
    /// the plan alone, and feeds of sections are.
    ///
    /// # Errors
    /// [`CompileError::Plan`] as [`Planner::plan`], others as [`Trajectory::compile_with`]; [`CompileError::Tool`] where the tool still
    /// exceeds a limit after the last round.
    pub fn plan_compiled<'p>(
        &self,
        path: Arc<dyn MotionPath<N> + 'p>,
        tolerance: f64,
    ) -> Result<CompiledPlan<'p, N>, CompileError>
    where
        'a: 'p,
    {
        let arm = self.settings().arm;
        let make = |trajectory: &Trajectory<'p, N>| -> Result<_, CompileError> {
            let compiled = trajectory.compile(tolerance)?;
            let tool = compiled.certify_tool(arm);
            Ok((compiled, tool))
        };
        let mut last = None;
        let trajectory = self.plan_until::<CompileError>(Held::Shared(path), |trajectory| {
            let made = make(trajectory)?;
            let ratios =
                exceeded(trajectory, &made.1).into_iter().map(|(id, value, limit)| (id, value / limit)).collect();
            last = Some(made);
            Ok(ratios)
        })?;
        let (compiled, tool) = match last {
            Some(made) => made,
            None => make(&trajectory)?,
        };
        if let Some((limit, value, allowed)) = exceeded(&trajectory, &tool).into_iter().next() {
            let t = tool.of(limit.quantity).map_or(0.0, |bound| bound.t);
            return Err(CompileError::Tool { limit, value, allowed, t });
        }
        Ok(CompiledPlan { trajectory, compiled, tool })
    }
}

/// The limits of the tool that the bounds exceed: which, the bound and the limit, SI.
fn exceeded<const N: usize>(trajectory: &Trajectory<'_, N>, tool: &ToolCertificate) -> Vec<(LimitId, f64, f64)> {
    let limits = trajectory.limits().tool();
    let by_length = |limit: Option<f64>| limit.filter(|_| trajectory.path().parameter() == PathParameter::ArcLength);
    let fastest = trajectory
        .sections()
        .iter()
        .map(|section| section.feed)
        .fold(limits.feed(), |most, feed| Some(most.map_or(feed, |most| most.max(feed))));
    let one = |(quantity, limit): (Quantity, Option<f64>)| {
        let (bound, limit) = (tool.of(quantity)?.bound, limit?);
        let within = bound <= limit * (1.0 + TOLERANCE);
        (!within).then_some((LimitId::path(quantity), bound, limit))
    };
    [
        (Quantity::Feed, fastest),
        (Quantity::AngularSpeed, limits.angular_speed()),
        (Quantity::TangentialAcceleration, by_length(limits.tangential_acceleration())),
        (Quantity::NormalAcceleration, by_length(limits.normal_acceleration())),
    ]
    .into_iter()
    .filter_map(one)
    .collect()
}
