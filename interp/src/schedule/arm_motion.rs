//! A motion between poses as the joints of an arm make it.

use arcfeed_geometry::PoseMotion;
use arcfeed_kinematics::{
    AnalyticInverse, JointRange, Joints, KinematicsError, ToolDerivatives, largest_step, smallest_singular_value,
};

use super::{ScheduleParameter, SchedulePath};
use crate::arm::PathArm;
use crate::error::PlanError;
use crate::joint_path::JointJet;

/// A joint that moves less than this part of the fastest one stands still: it is rounding of the inverse, which must not
/// choose a sign for Coulomb friction.
const STANDSTILL: f64 = 1e-12;
/// Places of the walk that judges a start.
const WALK: usize = 64;

/// A [`PoseMotion`] followed by an arm on one branch of its inverse.
#[derive(Debug, Clone, Copy)]
pub struct ArmMotion<'a, A: ?Sized, const N: usize = 6> {
    arm: &'a A,
    motion: PoseMotion,
    start: Joints<N>,
}

impl<'a, A: PathArm<N> + ?Sized, const N: usize> ArmMotion<'a, A, N> {
    /// The motion from that configuration at its start pose which is nearest to `near`.
    ///
    /// # Errors
    /// [`PlanError::OnPath`] when the arm cannot stand there.
    pub fn new(arm: &'a A, motion: PoseMotion, near: &Joints<N>) -> Result<Self, PlanError> {
        let start = arm.inverse(motion.start(), near).map_err(|source| on(&motion, 0.0, source))?;
        Ok(Self { arm, motion, start })
    }

    /// The motion between poses.
    pub fn motion(&self) -> &PoseMotion {
        &self.motion
    }

    /// Least of the smallest singular value and a tenth of the distance to the end of a joint's range, on a walk along
    /// the motion; or how far it came and why it stopped.
    fn quality(&self, range: &JointRange<N>) -> Result<f64, (f64, PlanError)> {
        let mut quality = f64::INFINITY;
        let mut last: Option<JointJet<N>> = None;
        for i in 0..=WALK {
            let s = self.motion.end() * i as f64 / WALK as f64;
            let near = last.map_or(self.start, |jet| jet.ahead(s - jet.s));
            let jet = self.jet(s, &near).map_err(|e| (s, e))?;
            if last.is_some() {
                same_branch(self.parameter(), s, &jet.q, &near, 1.0).map_err(|e| (s, e))?;
            }
            let room = (jet.q - range.lower()).zip_map(&(range.upper() - jet.q), f64::min).min();
            quality = quality.min(smallest_singular_value(&self.arm.jacobian(&jet.q))).min(0.1 * room);
            last = Some(jet);
        }
        Ok(quality)
    }
}

impl<'a, A: PathArm<N> + AnalyticInverse<N> + ?Sized, const N: usize> ArmMotion<'a, A, N> {
    /// The motion from that of all configurations at its start pose which stays farthest from singular poses and from
    /// the ends of `range`.
    ///
    /// # Errors
    /// [`PlanError::OnPath`] when the start is out of reach, [`PlanError::NoConfiguration`] when no branch gets to the end.
    pub fn from_best_start(arm: &'a A, motion: PoseMotion, range: &JointRange<N>) -> Result<Self, PlanError> {
        let candidates = arm.inverse_all(motion.start()).map_err(|source| on(&motion, 0.0, source))?;
        let middle = (range.lower() + range.upper()) / 2.0;
        let mut best: Option<(f64, Self)> = None;
        let mut farthest: Option<(f64, PlanError)> = None;
        for candidate in candidates.iter() {
            // The turn nearest to the middle of the joint ranges leaves most room.
            let near = candidate
                .zip_map(&middle, |q, m| q + ((m - q) / std::f64::consts::TAU).round() * std::f64::consts::TAU);
            let judged = Self::new(arm, motion, &near).map_err(|e| (0.0, e)).and_then(|path| {
                // The inverse may have gone to another branch where this one breaks a joint's range.
                same_branch(path.parameter(), 0.0, &path.start, &near, 1e-3).map_err(|e| (0.0, e))?;
                Ok((path.quality(range)?, path))
            });
            match judged {
                Ok((quality, path)) if best.as_ref().is_none_or(|b| quality > b.0) => best = Some((quality, path)),
                Ok(_) => {}
                Err((s, error)) if farthest.as_ref().is_none_or(|f| s > f.0) => farthest = Some((s, error)),
                Err(_) => {}
            }
        }
        match (best, farthest) {
            (Some((_, path)), _) => Ok(path),
            (None, Some((_, error))) => {
                Err(PlanError::NoConfiguration { candidates: candidates.len(), best: Box::new(error) })
            }
            // `inverse_all` is never empty, so one of the two is there.
            (None, None) => Self::new(arm, motion, &middle),
        }
    }
}

impl<A: PathArm<N> + ?Sized, const N: usize> SchedulePath<N> for ArmMotion<'_, A, N> {
    fn parameter(&self) -> ScheduleParameter {
        self.motion.parameter().into()
    }

    fn end(&self) -> f64 {
        self.motion.end()
    }

    fn start(&self) -> Joints<N> {
        self.start
    }

    fn jet(&self, s: f64, near: &Joints<N>) -> Result<JointJet<N>, PlanError> {
        let tool = self.motion.jet(s);
        let refused = |source| on(&self.motion, s, source);
        let q = self.arm.inverse(&tool.pose, near).map_err(refused)?;
        let by_s = ToolDerivatives { first: tool.d1, second: tool.d2, third: tool.d3 };
        let d = self.arm.derivatives(&q, &by_s).map_err(refused)?;
        Ok(JointJet { s, q, d1: settled(d.first), d2: settled(d.second), d3: settled(d.third) })
    }
}

/// Zeros in place of what is rounding beside the largest component.
fn settled<const N: usize>(derivatives: Joints<N>) -> Joints<N> {
    let rounding = STANDSTILL * derivatives.amax();
    derivatives.map(|d| if d.abs() <= rounding { 0.0 } else { d })
}

fn on(motion: &PoseMotion, s: f64, source: KinematicsError) -> PlanError {
    PlanError::OnPath { s, parameter: motion.parameter().into(), source }
}

/// A step that misses the prediction by more than `allowed` (rad) is a change of branch.
pub(super) fn same_branch<const N: usize>(
    parameter: ScheduleParameter,
    s: f64,
    q: &Joints<N>,
    predicted: &Joints<N>,
    allowed: f64,
) -> Result<(), PlanError> {
    let (joint, step) = largest_step(q, predicted);
    if step <= allowed {
        return Ok(());
    }
    let source = KinematicsError::StepTooLarge { joint, step, bound: allowed };
    Err(PlanError::OnPath { s, parameter, source })
}
