//! An arm with a numeric inverse, and how hard that tries.

use crate::{
    chain::Chain,
    error::KinematicsError,
    jacobian::Configuration,
    joint::{JointRange, Joints},
    traits::ForwardKinematics,
};
use nalgebra::Isometry3;

/// The use of the freedom that is left when the tool stands at its target.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum NullSpace<const N: usize> {
    /// Nothing: the joints move as little as can be.
    LeastMotion,
    /// Each call moves the joints towards `posture` by at most `gain` (0 to 1) of the way, as far
    /// as the tool allows.
    Towards {
        /// Preferred joint values, rad (m).
        posture: Joints<N>,
        /// Part of the way per call.
        gain: f64,
    },
}

/// The effort of a search.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NumericSettings<const N: usize> {
    /// Error of position that counts as reached, m. A target that is reached is then met to
    /// rounding.
    pub position: f64,
    /// Error of orientation that counts as reached, rad.
    pub orientation: f64,
    /// Steps per attempt.
    pub steps: usize,
    /// Attempts from other places after the one from the seed. 0 for following a path.
    pub restarts: usize,
    /// The use of redundant joints.
    pub null_space: NullSpace<N>,
}

impl<const N: usize> Default for NumericSettings<N> {
    /// 1e-11 m and rad, 60 steps, 100 restarts, least motion.
    fn default() -> Self {
        Self { position: 1e-11, orientation: 1e-11, steps: 60, restarts: 100, null_space: NullSpace::LeastMotion }
    }
}

/// An arm of any geometry with its joint range and a numeric inverse.
///
/// ```
/// use arcfeed_kinematics::{ForwardKinematics, InverseKinematics, Joints, models};
/// let arm = models::panda();
/// let q = Joints::<7>::from([0.1, -0.4, 0.2, -2.0, 0.1, 1.6, 0.7]);
/// let target = arm.forward(&q);
/// let found = arm.inverse(&target, &Joints::<7>::from([0.0, -0.3, 0.0, -1.8, 0.0, 1.5, 0.5]))?;
/// assert!((arm.forward(&found).translation.vector - target.translation.vector).norm() < 1e-11);
/// assert!(arm.range().contains(&found));
/// # Ok::<(), arcfeed_kinematics::KinematicsError>(())
/// ```
#[derive(Debug, Clone, Copy)]
pub struct NumericArm<const N: usize> {
    pub(super) chain: Chain<N>,
    pub(super) range: JointRange<N>,
    pub(super) settings: NumericSettings<N>,
    /// Weighs angles against lengths, m/rad: the size of the arm.
    pub(super) size: f64,
}

impl<const N: usize> NumericArm<N> {
    /// An arm from its chain and joint range, with default settings.
    pub fn new(chain: Chain<N>, range: JointRange<N>) -> Self {
        let size = size(&chain);
        Self { chain, range, settings: NumericSettings::default(), size }
    }

    /// The same arm with other settings.
    ///
    /// # Errors
    /// [`KinematicsError::InvalidSetting`].
    pub fn with_settings(&self, settings: NumericSettings<N>) -> Result<Self, KinematicsError> {
        let fail = |what, value, rule| Err(KinematicsError::InvalidSetting { what, value, rule });
        for (what, value) in
            [("position tolerance", settings.position), ("orientation tolerance", settings.orientation)]
        {
            if !(value.is_finite() && value > 0.0) {
                return fail(what, value, "finite and greater than 0");
            }
        }
        if let NullSpace::Towards { posture, gain } = settings.null_space {
            if !(0.0..=1.0).contains(&gain) {
                return fail("null-space gain", gain, "from 0 to 1");
            }
            if !posture.iter().all(|v| v.is_finite()) {
                return Err(KinematicsError::NotFinite { what: "the preferred posture" });
            }
        }
        Ok(Self { settings, ..*self })
    }

    /// The same arm with its tool point at `tool` in the frame of the flange.
    ///
    /// # Errors
    /// [`KinematicsError::NotFinite`] or [`KinematicsError::NotUnit`].
    pub fn with_tool(&self, tool: Isometry3<f64>) -> Result<Self, KinematicsError> {
        Ok(Self { settings: self.settings, ..Self::new(self.chain.with_tool(tool)?, self.range) })
    }

    /// The same arm standing at `base` in the working frame.
    ///
    /// # Errors
    /// [`KinematicsError::NotFinite`] or [`KinematicsError::NotUnit`].
    pub fn with_base(&self, base: Isometry3<f64>) -> Result<Self, KinematicsError> {
        Ok(Self { settings: self.settings, ..Self::new(self.chain.with_base(base)?, self.range) })
    }

    /// The same arm with another joint range.
    pub fn with_range(&self, range: JointRange<N>) -> Self {
        Self { range, ..*self }
    }

    /// The chain of joints.
    pub fn chain(&self) -> &Chain<N> {
        &self.chain
    }

    /// The ranges of the joints.
    pub fn range(&self) -> &JointRange<N> {
        &self.range
    }

    /// The effort of a search.
    pub fn settings(&self) -> &NumericSettings<N> {
        &self.settings
    }
}

impl<const N: usize> ForwardKinematics<N> for NumericArm<N> {
    #[inline]
    fn configuration(&self, q: &Joints<N>) -> Configuration<N> {
        self.chain.configuration(q)
    }

    #[inline]
    fn forward(&self, q: &Joints<N>) -> Isometry3<f64> {
        self.chain.forward(q)
    }
}

/// A length that weighs angles against lengths: half of the way along the arm from its first joint
/// to the tool, m.
pub(crate) fn size<const N: usize>(chain: &Chain<N>) -> f64 {
    let at = chain.configuration(&Joints::zeros());
    let mut size = 0.0;
    let mut last = at.points().first().copied();
    for point in at.points().iter().chain(std::iter::once(at.position())) {
        size += last.map_or(0.0, |last| (point - last).norm());
        last = Some(*point);
    }
    // An arm of turning joints in one point has no length; any weight will do.
    if size > 1e-6 { 0.5 * size } else { 1.0 }
}
