//! Arms of seven joints on tool paths: one joint stands still.

use arcfeed_geometry::PosePath;
use arcfeed_kinematics::{
    AnalyticInverse, Arm, Configuration, ForwardKinematics, InverseKinematics, JointDerivatives, Joints,
    KinematicsError, PoseResidual, Solutions, ToolDerivatives, joint_derivatives,
};
use nalgebra::Isometry3;

use super::motion_path::MotionPath;
use super::tool_path::ToolPath;
use crate::arm::{MIN_SINGULAR_VALUE, PathArm};
use crate::error::PathError;
use crate::place::{PathParameter, PathPlace};

/// An arm of seven joints one of which is held, so that a tool pose determines the others.
///
/// A tool pose leaves a seventh joint free. Holding one is the simplest rule that makes the joints a function of the pose
/// with exact derivatives: what is left is an arm of six joints. Which joint is held, and where, decides how well the
/// arm can follow a path; [`LockedArm::for_path`] chooses.
#[derive(Debug, Clone, Copy)]
pub struct LockedArm {
    arm: Arm<7>,
    six: Arm<6>,
    joint: usize,
    value: f64,
}

impl LockedArm {
    /// `arm` with `joint` (from 0) held at `value` (rad, m).
    ///
    /// # Errors
    /// [`KinematicsError::InvalidLock`] if there is no such joint or the value is outside its range.
    pub fn new(arm: &Arm<7>, joint: usize, value: f64) -> Result<Self, KinematicsError> {
        Ok(Self { arm: *arm, six: arm.locked(joint, value)?, joint, value })
    }

    /// `arm` with the joint held, and the start, from which `path` can be followed best: of every joint at five places
    /// of its range the one that stays farthest from singular poses and joint limits (as [`ToolPath::new`] counts it).
    ///
    /// # Errors
    /// [`PathError`] of the choice that came farthest, if none gets to the end.
    pub fn for_path(arm: &Arm<7>, path: &PosePath) -> Result<(Self, Joints<7>), PathError> {
        const PLACES: usize = 5;
        let (lower, upper) = (arm.range().lower(), arm.range().upper());
        let mut best: Option<(f64, Self, Joints<7>)> = None;
        let mut failed: Option<PathError> = None;
        for joint in 0..7 {
            for place in 0..PLACES {
                let share = (place as f64 + 1.0) / (PLACES as f64 + 1.0);
                let value = lower[joint] + share * (upper[joint] - lower[joint]);
                let Ok(locked) = Self::new(arm, joint, value) else { continue };
                match ToolPath::judged(&locked, path.clone(), arm.range()) {
                    Ok((quality, followed)) if best.as_ref().is_none_or(|b| quality > b.0) => {
                        best = Some((quality, locked, followed.start()));
                    }
                    Ok(_) => {}
                    // A start out of reach says less than a path that ends half-way.
                    Err(e @ PathError::NoConfiguration { .. }) => failed = Some(e),
                    Err(e) => failed = failed.or(Some(e)),
                }
            }
        }
        match (best, failed) {
            (Some((_, locked, start)), _) => Ok((locked, start)),
            (None, Some(error)) => Err(error),
            // No joint can be held at all: say what a held first joint is told.
            (None, None) => {
                let tool = Some(path.pose(0.0).translation.vector.into());
                let place = PathPlace { s: 0.0, parameter: PathParameter::ArcLength, tool };
                let locked = Self::new(arm, 0, lower[0]).map_err(|source| PathError::Arm { place, source })?;
                let start = ToolPath::new(&locked, path.clone(), arm.range())?.start();
                Ok((locked, start))
            }
        }
    }

    /// The whole arm.
    pub fn arm(&self) -> &Arm<7> {
        &self.arm
    }

    /// The joint that is held, from 0, and where (rad, m).
    pub fn held(&self) -> (usize, f64) {
        (self.joint, self.value)
    }

    fn with_held(&self, q: &Joints<6>, held: f64) -> Joints<7> {
        Joints::from_fn(|k, _| match k.cmp(&self.joint) {
            std::cmp::Ordering::Less => q[k],
            std::cmp::Ordering::Equal => held,
            std::cmp::Ordering::Greater => q[k - 1],
        })
    }

    fn others(&self, q: &Joints<7>) -> Joints<6> {
        Joints::from_fn(|k, _| q[k + usize::from(k >= self.joint)])
    }
}

impl ForwardKinematics<7> for LockedArm {
    #[inline]
    fn configuration(&self, q: &Joints<7>) -> Configuration<7> {
        self.arm.configuration(q)
    }
}

impl InverseKinematics<7> for LockedArm {
    fn inverse(&self, target: &Isometry3<f64>, seed: &Joints<7>) -> Result<Joints<7>, KinematicsError> {
        let q = self.six.inverse(target, &self.others(seed))?;
        Ok(self.with_held(&q, self.value))
    }

    fn residual(&self, q: &Joints<7>) -> PoseResidual {
        self.six.residual(&self.others(q))
    }
}

impl AnalyticInverse<7> for LockedArm {
    /// The solutions with the joint held; other positions of it give others.
    fn inverse_all(&self, target: &Isometry3<f64>) -> Result<Solutions<7>, KinematicsError> {
        Ok(self.six.inverse_all(target)?.map(|q| self.with_held(q, self.value)))
    }
}

impl PathArm<7> for LockedArm {
    fn derivatives(&self, q: &Joints<7>, tool: &ToolDerivatives) -> Result<JointDerivatives<7>, KinematicsError> {
        let d = joint_derivatives(&self.six, &self.others(q), tool, MIN_SINGULAR_VALUE)?;
        let [first, second, third] = [d.first, d.second, d.third].map(|d| self.with_held(&d, 0.0));
        Ok(JointDerivatives { first, second, third })
    }
}
