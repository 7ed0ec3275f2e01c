//! An arm with everything that is known of it, and the inverse that its geometry allows.

use crate::{
    analytic::{ClosedForm, Solutions},
    branch::{Candidate, largest_step},
    chain::Chain,
    closed_form::{ClosedFormArm, ParallelAxisArm, SphericalWristArm},
    dynamics::ArmDynamics,
    error::KinematicsError,
    jacobian::Configuration,
    joint::{JointLimits, JointRange, Joints, check_finite},
    numeric::{NumericArm, NumericSettings, size},
    posture::Posture,
    singular_pose::{Search, SingularPose},
    singularity::SingularityDistances,
    singularity_kind::SingularityKind,
    traits::{AnalyticInverse, ForwardKinematics, InverseKinematics, PoseResidual},
};
use nalgebra::Isometry3;

/// The method of an arm's inverse kinematics.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum InverseMethod {
    /// Closed form for three parallel axes, see [`ParallelAxisArm`].
    ParallelAxis,
    /// Closed form for a spherical wrist, see [`SphericalWristArm`].
    SphericalWrist,
    /// Damped least squares, see [`NumericArm`].
    Numeric,
}

impl std::fmt::Display for InverseMethod {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::ParallelAxis => "closed form, three parallel axes",
            Self::SphericalWrist => "closed form, spherical wrist",
            Self::Numeric => "damped least squares",
        })
    }
}

#[derive(Debug, Clone, Copy)]
enum Solver<const N: usize> {
    ParallelAxis(ParallelAxisArm),
    SphericalWrist(SphericalWristArm),
    Numeric(NumericArm<N>),
}

/// The limits of a joint's drive, symmetric about 0; each may be unknown.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DriveLimits<const N: usize> {
    /// Greatest speeds, rad/s (m/s).
    pub velocity: Option<Joints<N>>,
    /// Greatest accelerations, rad/s^2 (m/s^2).
    pub acceleration: Option<Joints<N>>,
    /// Greatest jerks, rad/s^3 (m/s^3).
    pub jerk: Option<Joints<N>>,
    /// Greatest torques at the joint, N m (N).
    pub torque: Option<Joints<N>>,
}

impl<const N: usize> Default for DriveLimits<N> {
    /// Nothing is known.
    fn default() -> Self {
        Self { velocity: None, acceleration: None, jerk: None, torque: None }
    }
}

/// An arm of `N` joints: chain, joint range, drive limits and dynamics where known, and the inverse that fits its
/// geometry, whatever it is called.
///
/// ```
/// use arcfeed_kinematics::{Arm, Chain, InverseMethod, JointRange, Joints, models};
/// // A KR 6's chain and nothing else: its wrist is recognised.
/// let known = models::kr6_r700();
/// let arm = Arm::new(*known.chain(), *known.range());
/// assert_eq!(arm.method(), InverseMethod::SphericalWrist);
/// let panda = models::panda();
/// let arm = Arm::new(*panda.chain(), *panda.range());
/// assert_eq!(arm.method(), InverseMethod::Numeric);
/// // Seven joints with one held are six.
/// let six: Arm<6> = arm.locked(2, 0.1)?;
/// # Ok::<(), arcfeed_kinematics::KinematicsError>(())
/// ```
#[derive(Debug, Clone, Copy)]
pub struct Arm<const N: usize> {
    chain: Chain<N>,
    range: JointRange<N>,
    solver: Solver<N>,
    settings: NumericSettings<N>,
    drives: DriveLimits<N>,
    dynamics: Option<ArmDynamics<N>>,
}

/// A vector for an arm of `M` joints, which is `N` by another name.
fn renamed<const N: usize, const M: usize>(q: &Joints<N>) -> Joints<M> {
    Joints::from_fn(|i, _| q.get(i).copied().unwrap_or(0.0))
}

impl<const N: usize> Arm<N> {
    /// An arm from its chain and joint range, with the inverse its geometry allows.
    pub fn new(chain: Chain<N>, range: JointRange<N>) -> Self {
        Self::assemble(chain, range, NumericSettings::default(), DriveLimits::default(), None)
    }

    fn assemble(
        chain: Chain<N>,
        range: JointRange<N>,
        settings: NumericSettings<N>,
        drives: DriveLimits<N>,
        dynamics: Option<ArmDynamics<N>>,
    ) -> Self {
        let numeric = NumericArm::new(chain, range);
        let numeric = numeric.with_settings(settings).unwrap_or(numeric);
        let solver = match six_joints(&chain, &range) {
            None => Solver::Numeric(numeric),
            Some((chain, range)) => match (ClosedFormArm::new(chain, range), ClosedFormArm::new(chain, range)) {
                (Ok(arm), _) => Solver::ParallelAxis(arm),
                (_, Ok(arm)) => Solver::SphericalWrist(arm),
                _ => Solver::Numeric(numeric),
            },
        };
        Self { chain, range, solver, settings, drives, dynamics }
    }

    /// The same arm with its tool point at `tool` in the frame of the flange.
    ///
    /// # Errors
    /// [`KinematicsError::NotFinite`] or [`KinematicsError::NotUnit`].
    pub fn with_tool(&self, tool: Isometry3<f64>) -> Result<Self, KinematicsError> {
        self.with_chain(self.chain.with_tool(tool)?)
    }

    /// The same arm standing at `base` in the working frame. Gravity stays along the axes of the working frame.
    ///
    /// # Errors
    /// [`KinematicsError::NotFinite`] or [`KinematicsError::NotUnit`].
    pub fn with_base(&self, base: Isometry3<f64>) -> Result<Self, KinematicsError> {
        self.with_chain(self.chain.with_base(base)?)
    }

    fn with_chain(&self, chain: Chain<N>) -> Result<Self, KinematicsError> {
        let dynamics = self.dynamics.as_ref().map(|dynamics| dynamics.with_chain(&chain)).transpose()?;
        Ok(Self::assemble(chain, self.range, self.settings, self.drives, dynamics))
    }

    /// The same arm with another joint range.
    pub fn with_range(&self, range: JointRange<N>) -> Self {
        Self::assemble(self.chain, range, self.settings, self.drives, self.dynamics)
    }

    /// The same arm with other limits of its drives.
    ///
    /// # Errors
    /// [`KinematicsError::InvalidLimit`] names the joint, the value and the rule.
    pub fn with_drive_limits(&self, drives: DriveLimits<N>) -> Result<Self, KinematicsError> {
        for (what, values) in [
            ("velocity", &drives.velocity),
            ("acceleration", &drives.acceleration),
            ("jerk", &drives.jerk),
            ("torque", &drives.torque),
        ] {
            let Some(values) = values else { continue };
            if let Some(joint) = (0..N).find(|i| !(values[*i].is_finite() && values[*i] > 0.0)) {
                let rule = "finite and greater than 0";
                return Err(KinematicsError::InvalidLimit { joint, what, value: values[joint], rule });
            }
        }
        Ok(Self { drives, ..*self })
    }

    /// The same arm with dynamics, which must be those of its own chain: see [`ArmDynamics::new`].
    pub fn with_dynamics(&self, dynamics: ArmDynamics<N>) -> Self {
        Self { dynamics: Some(dynamics), ..*self }
    }

    /// The same arm with other settings for the numeric inverse; a closed form has none.
    ///
    /// # Errors
    /// [`KinematicsError::InvalidSetting`].
    pub fn with_settings(&self, settings: NumericSettings<N>) -> Result<Self, KinematicsError> {
        NumericArm::new(self.chain, self.range).with_settings(settings)?;
        Ok(Self::assemble(self.chain, self.range, settings, self.drives, self.dynamics))
    }

    /// The arm that is left when `joint` (from 0) is held at `value`: `M` is N - 1. Limits, links, rotors and friction
    /// of the other joints stay; a payload stays where it is.
    ///
    /// A redundant arm with one joint held follows a tool path with well-defined derivatives.
    ///
    /// # Errors
    /// [`KinematicsError::InvalidLock`] if the joint is none, M is not N - 1 or `value` is outside the joint's range.
    pub fn locked<const M: usize>(&self, joint: usize, value: f64) -> Result<Arm<M>, KinematicsError> {
        let (lower, upper) = (self.range.lower(), self.range.upper());
        if joint >= N || M + 1 != N || !(lower[joint] <= value && value <= upper[joint]) {
            return Err(KinematicsError::InvalidLock { joint, value, joints: N, left: M });
        }
        let left = |values: &Joints<N>| Joints::<M>::from_fn(|i, _| values[i + usize::from(i >= joint)]);
        let range = JointRange::new(left(lower), left(upper))?;
        let chain = self.chain.locked::<M>(joint, value)?;
        let drives = DriveLimits {
            velocity: self.drives.velocity.as_ref().map(left),
            acceleration: self.drives.acceleration.as_ref().map(left),
            jerk: self.drives.jerk.as_ref().map(left),
            torque: self.drives.torque.as_ref().map(left),
        };
        let dynamics = match &self.dynamics {
            Some(dynamics) => Some(dynamics.locked::<M>(&self.chain, &chain, joint, value)?),
            None => None,
        };
        let settings = NumericSettings {
            position: self.settings.position,
            orientation: self.settings.orientation,
            steps: self.settings.steps,
            restarts: self.settings.restarts,
            ..NumericSettings::default()
        };
        Ok(Arm::assemble(chain, range, settings, drives, dynamics))
    }

    /// The chain of joints.
    pub fn chain(&self) -> &Chain<N> {
        &self.chain
    }

    /// The ranges of the joints.
    pub fn range(&self) -> &JointRange<N> {
        &self.range
    }

    /// The limits of the drives, as far as they are known.
    pub fn drive_limits(&self) -> &DriveLimits<N> {
        &self.drives
    }

    /// Range, velocity, acceleration and jerk in one, if all are known.
    pub fn limits(&self) -> Option<JointLimits<N>> {
        let DriveLimits { velocity, acceleration, jerk, .. } = self.drives;
        self.range.with_rates(velocity?, acceleration?, jerk?).ok()
    }

    /// The dynamics, if known.
    pub fn dynamics(&self) -> Option<&ArmDynamics<N>> {
        self.dynamics.as_ref()
    }

    /// The method of the inverse.
    pub fn method(&self) -> InverseMethod {
        match self.solver {
            Solver::ParallelAxis(_) => InverseMethod::ParallelAxis,
            Solver::SphericalWrist(_) => InverseMethod::SphericalWrist,
            Solver::Numeric(_) => InverseMethod::Numeric,
        }
    }

    /// Why there is no closed form for an arm of six joints: the rule of each family that it breaks. None for arms that
    /// have one and for other numbers of joints.
    pub fn closed_form_refusals(&self) -> Option<[KinematicsError; 2]> {
        let (chain, range) = six_joints(&self.chain, &self.range)?;
        Some([ParallelAxisArm::new(chain, range).err()?, SphericalWristArm::new(chain, range).err()?])
    }

    /// The fate of each inverse solution of `target` when seen from `seed`: inside the limits with which step, or
    /// outside by how much. A numeric inverse finds only solutions inside, and not all.
    ///
    /// # Errors
    /// As [`AnalyticInverse::inverse_all`]; [`KinematicsError::JointNotFinite`] for the seed.
    pub fn candidates(
        &self,
        target: &Isometry3<f64>,
        seed: &Joints<N>,
    ) -> Result<impl Iterator<Item = Candidate<N>>, KinematicsError> {
        let solutions: Solutions<N> = match &self.solver {
            Solver::ParallelAxis(arm) => arm.solve(target, &renamed(seed))?.for_joints(),
            Solver::SphericalWrist(arm) => arm.solve(target, &renamed(seed))?.for_joints(),
            Solver::Numeric(arm) => arm.inverse_all(target)?,
        };
        check_finite("the seed", seed)?;
        let (arm, seed) = (*self, *seed);
        Ok((0..solutions.len()).map(move |i| match &arm.solver {
            Solver::Numeric(numeric) => {
                let q = numeric.turned_towards(&solutions[i], &seed);
                let (joint, step) = largest_step(&q, &seed);
                Candidate::Usable { q, joint, step }
            }
            _ => Candidate::new(&solutions[i], &seed, &arm.range),
        }))
    }

    /// Distances of the arm at `q` from its singular poses, kind by kind, if it has a closed form.
    pub fn singularity_distances(&self, q: &Joints<N>) -> Option<SingularityDistances> {
        match &self.solver {
            Solver::ParallelAxis(arm) => Some(arm.singularity_distances(&renamed(q))),
            Solver::SphericalWrist(arm) => Some(arm.singularity_distances(&renamed(q))),
            Solver::Numeric(_) => None,
        }
    }

    /// The nearest singular pose that a search around `q` finds inside the joint range; none if it finds none. For arms of
    /// any geometry; takes a few milliseconds at most.
    ///
    /// Its distance is an upper bound: some other singular pose may be nearer.
    ///
    /// ```
    /// use arcfeed_kinematics::{Arm, Joints, SingularityKind, models};
    /// // Joint 5 is 0.2 rad from where axes 4 and 6 line up.
    /// let arm = Arm::from(models::kr6_r700());
    /// let near = arm.nearest_singular_pose(&Joints::<6>::from([0.3, -1.2, 1.1, 0.4, 0.2, -0.3])).expect("there is one");
    /// assert!((near.distance - 0.2).abs() < 1e-7);
    /// assert_eq!(near.kind, Some(SingularityKind::Wrist));
    /// ```
    pub fn nearest_singular_pose(&self, q: &Joints<N>) -> Option<SingularPose<N>> {
        self.singular_poses().around(q)
    }

    fn singular_poses(&self) -> Search<'_, N> {
        Search { chain: &self.chain, range: &self.range, size: size(&self.chain) }
    }

    /// A length that the flange cannot go beyond, m, from the first joint: the sum of the links.
    pub fn reach(&self) -> f64 {
        let joints = self.chain.joints();
        let mut reach = self.chain.flange().translation.vector.norm();
        for (i, joint) in joints.iter().enumerate() {
            if i > 0 {
                reach += joint.origin().translation.vector.norm();
            }
            if joint.kind() == crate::JointKind::Prismatic {
                reach += self.range.lower()[i].abs().max(self.range.upper()[i].abs());
            }
        }
        reach
    }
}

/// Chain and range as those of six joints, if they are.
fn six_joints<const N: usize>(chain: &Chain<N>, range: &JointRange<N>) -> Option<(Chain<6>, JointRange<6>)> {
    let joints = chain.joints().as_slice().try_into().ok()?;
    let same = Chain::<6>::new(joints).ok()?;
    let same = same.with_base(*chain.base()).ok()?.with_flange(*chain.flange()).ok()?.with_tool(*chain.tool()).ok()?;
    Some((same, JointRange::new(renamed(range.lower()), renamed(range.upper())).ok()?))
}

impl<S: ClosedForm> From<ClosedFormArm<S>> for Arm<6> {
    fn from(arm: ClosedFormArm<S>) -> Self {
        Self::new(*arm.chain(), *arm.range())
    }
}

impl<const N: usize> From<NumericArm<N>> for Arm<N> {
    /// With the settings of the numeric arm, should its geometry not allow a closed form.
    fn from(arm: NumericArm<N>) -> Self {
        Self::assemble(*arm.chain(), *arm.range(), *arm.settings(), DriveLimits::default(), None)
    }
}

impl<const N: usize> ForwardKinematics<N> for Arm<N> {
    #[inline]
    fn configuration(&self, q: &Joints<N>) -> Configuration<N> {
        self.chain.configuration(q)
    }

    #[inline]
    fn forward(&self, q: &Joints<N>) -> Isometry3<f64> {
        self.chain.forward(q)
    }

    fn nearest_singularity(&self, q: &Joints<N>) -> Option<SingularityKind> {
        match self.singularity_distances(q) {
            Some(distances) => Some(distances.nearest),
            None => self.singular_poses().from(q, q)?.kind,
        }
    }
}

impl<const N: usize> InverseKinematics<N> for Arm<N> {
    fn inverse(&self, target: &Isometry3<f64>, seed: &Joints<N>) -> Result<Joints<N>, KinematicsError> {
        match &self.solver {
            Solver::ParallelAxis(arm) => arm.inverse(target, &renamed(seed)).map(|q| renamed(&q)),
            Solver::SphericalWrist(arm) => arm.inverse(target, &renamed(seed)).map(|q| renamed(&q)),
            Solver::Numeric(arm) => arm.inverse(target, seed),
        }
    }

    fn residual(&self, q: &Joints<N>) -> PoseResidual {
        self.chain.residual(q)
    }
}

impl<const N: usize> AnalyticInverse<N> for Arm<N> {
    fn inverse_all(&self, target: &Isometry3<f64>) -> Result<Solutions<N>, KinematicsError> {
        match &self.solver {
            Solver::ParallelAxis(arm) => arm.inverse_all(target).map(|all| all.for_joints()),
            Solver::SphericalWrist(arm) => arm.inverse_all(target).map(|all| all.for_joints()),
            Solver::Numeric(arm) => arm.inverse_all(target),
        }
    }

    fn posture(&self, q: &Joints<N>) -> Option<Posture> {
        match &self.solver {
            Solver::ParallelAxis(arm) => arm.posture(&renamed(q)),
            Solver::SphericalWrist(arm) => arm.posture(&renamed(q)),
            Solver::Numeric(_) => None,
        }
    }
}
