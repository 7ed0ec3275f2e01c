//! Plans whose compiled motion keeps every limit that its certificate lists.

use std::sync::Arc;

use super::error::CompileError;
use super::joint_trajectory::{Interpolation, JointTrajectory};
use super::motion_certificate::MotionCertificate;
use crate::limits::{JointTables, TableKind};
use crate::path::MotionPath;
use crate::planner::Planner;
use crate::problem::Held;
use crate::trajectory::Trajectory;

/// By how much a limit may seem to be exceeded through rounding.
const TOLERANCE: f64 = 1e-6;
/// Pieces that exceed a limit by more than this, relative, are made closer to the plan: that costs pieces. Those that exceed it by less
/// are mended by a slower plan.
const COARSE: f64 = 1e-2;
/// So are pieces of a slower plan that exceed limits by more than this part of what those before did.
const STUCK: f64 = 0.5;
/// Parts of the tolerance that are tried.
const CLOSER: [f64; 4] = [1.0, 1.0 / 16.0, 1.0 / 256.0, 1.0 / 4096.0];

/// By how many times its excess a limit is lowered where that is slight, and by how much more: less of a limit lowers by less what pieces
/// add to it.
const MORE: f64 = 1.5;
const MARGIN: f64 = 1e-5;

/// How close to a plan its pieces are made.
struct Closeness {
    /// Which of [`CLOSER`].
    closer: usize,
    /// By how much the pieces of the last plan exceeded limits at most, relative.
    last: f64,
}

/// Polynomials, and what they make of the limits.
type Made<const N: usize> = (JointTrajectory<N>, MotionCertificate);

/// A plan, its compiled motion, and what that makes of the limits.
#[derive(Debug, Clone)]
pub struct CompiledPlan<'p, const N: usize = 6> {
    /// The plan.
    pub trajectory: Trajectory<'p, N>,
    /// Its motion as polynomials of the time.
    pub compiled: JointTrajectory<N>,
    /// For each limit the largest value found, and the value that these polynomials do not exceed.
    pub certificate: MotionCertificate,
}

impl<'a, const N: usize> Planner<'a, N> {
    /// Plans the motion along `path` and compiles it with quintic pieces, no joint of which deviates from the plan by more than
    /// `tolerance`, rad.
    ///
    /// The compiled motion was certified. At all times it keeps the limits that a [`MotionCertificate`] lists: those of the joints,
    /// constant or by tables, of their torques, and of the tool. Where the pieces would exceed a limit of the tool, a torque or a table
    /// by more than 1 %, they are made closer to the plan than `tolerance` asks for; what is exceeded by less, or still, is planned again with
    /// less of that limit. Where the tool exceeds the feed of one section, the feeds of all are lowered. Limits on tangential and normal jerk and on the chord error are those of the plan alone.
    ///
    /// # Errors
    /// [`CompileError::Plan`] as [`Planner::plan`], others as [`Trajectory::compile_with`]; [`CompileError::Exceeded`] where the motion
    /// still exceeds a limit after the last round; [`CompileError::UnboundedTorque`] for a limit on the torque of dynamics that state no
    /// bounds.
    pub fn plan_compiled<'p>(
        &self,
        path: Arc<dyn MotionPath<N> + 'p>,
        tolerance: f64,
    ) -> Result<CompiledPlan<'p, N>, CompileError>
    where
        'a: 'p,
    {
        let mut last = None;
        let mut closeness = Closeness { closer: 0, last: f64::INFINITY };
        let trajectory = self.plan_until::<CompileError>(Held::Shared(path), |trajectory| {
            let made = self.make_close(trajectory, tolerance, &mut closeness)?;
            let mut ratios: Vec<_> = Vec::new();
            for limit in made.1.exceeded(TOLERANCE) {
                let excess = limit.ratio() - 1.0;
                let less = 1.0 + if excess > COARSE { excess } else { MORE * excess } + MARGIN;
                // A constant limit and a table of the same quantity are one limit to the planner.
                match ratios.iter_mut().find(|(id, _)| *id == limit.id) {
                    Some((_, ratio)) => *ratio = less.max(*ratio),
                    None => ratios.push((limit.id, less)),
                }
            }
            // What has no bound is mended by no lower limit.
            if ratios.iter().any(|(_, ratio)| !ratio.is_finite()) {
                ratios.clear();
            }
            last = Some(made);
            Ok(ratios)
        })?;
        let (compiled, certificate) = match last {
            Some(made) => made,
            None => self.make_close(&trajectory, tolerance, &mut closeness)?,
        };
        if let Some(limit) = certificate.exceeded(TOLERANCE).next() {
            return Err(CompileError::Exceeded { limit: *limit });
        }
        Ok(CompiledPlan { trajectory, compiled, certificate })
    }

    /// Polynomials that deviate from a plan by a part of `tolerance`: by less than before where they exceed a limit by far, or where the
    /// plan that was made slower did not help.
    fn make_close(
        &self,
        plan: &Trajectory<'_, N>,
        tolerance: f64,
        closeness: &mut Closeness,
    ) -> Result<Made<N>, CompileError> {
        // The fit knows constant limits of the joints.
        let by_table = |tables: &JointTables<N>| {
            [TableKind::JerkBySpeed, TableKind::JerkByPosition].iter().any(|kind| tables.has(*kind))
        };
        let limits = plan.limits();
        let follows_jerk = limits.tool().jerk().is_some() || limits.tables().is_some_and(by_table);
        let make = |part: f64| -> Result<(f64, Made<N>), CompileError> {
            let compiled = plan.compile_following(tolerance * part, Interpolation::Quintic, follows_jerk)?;
            let certificate = MotionCertificate::of(self.settings().arm, plan, &compiled)?;
            let excess = certificate.exceeded(TOLERANCE).map(|limit| limit.ratio() - 1.0).fold(0.0, f64::max);
            Ok((excess, (compiled, certificate)))
        };
        // Pieces that close may not exist for this plan.
        let mut best = loop {
            match make(CLOSER[closeness.closer]) {
                Err(_) if closeness.closer > 0 => closeness.closer -= 1,
                made => break made?,
            }
        };
        let enough = COARSE.min(STUCK * closeness.last);
        for (i, part) in CLOSER.into_iter().enumerate().skip(closeness.closer + 1) {
            if best.0 <= enough {
                break;
            }
            match make(part) {
                Ok(made) if made.0 < best.0 => (best, closeness.closer) = (made, i),
                _ => break,
            }
        }
        closeness.last = best.0;
        Ok(best.1)
    }
}
