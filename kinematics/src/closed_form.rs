//! A six-joint arm with a closed-form inverse: chain, joint range and solver in one.

use crate::{
    analytic::{ClosedForm, Collector, ParallelAxes, Solutions, SphericalWrist},
    branch::{Candidate, nearest_solution},
    chain::Chain,
    error::KinematicsError,
    jacobian::{Configuration, Target},
    joint::{JointRange, Joints, check_finite},
    lu::Lu6,
    numeric::{NumericArm, NumericSettings},
    posture::Posture,
    singularity::SingularityDistances,
    singularity_kind::SingularityKind,
    traits::{AnalyticInverse, ForwardKinematics, InverseKinematics, PoseResidual},
};
use nalgebra::Isometry3;

/// How far out of reach of the ideal geometry a target may be that the real chain is tried at, m: ten times the largest
/// deviation that is accepted.
const BESIDE: f64 = 1e-3;

/// A six-joint arm whose axes 2, 3 and 4 are parallel (Universal Robots, Dobot CR and their kin), with its joint range.
///
/// ```
/// use arcfeed_kinematics::{AnalyticInverse, ForwardKinematics, InverseKinematics, Joints, models};
/// let arm = models::ur5e();
/// let q = Joints::<6>::from([0.4, -1.2, 1.1, -0.9, -1.4, 0.2]);
/// let pose = arm.forward(&q);
/// assert_eq!(arm.inverse_all(&pose)?.len(), 8);
/// assert!((arm.inverse(&pose, &q)? - q).amax() < 1e-12);
/// # Ok::<(), arcfeed_kinematics::KinematicsError>(())
/// ```
pub type ParallelAxisArm = ClosedFormArm<ParallelAxes>;

/// A six-joint arm whose last three axes meet in a point, with its joint range: KUKA, ABB, Fanuc and their kin, the Puma.
///
/// ```
/// use arcfeed_kinematics::{AnalyticInverse, ForwardKinematics, InverseKinematics, Joints, models};
/// let arm = models::kr6_r700();
/// let q = Joints::<6>::from([0.4, -1.2, 1.1, -0.9, -1.4, 0.2]);
/// let pose = arm.forward(&q);
/// assert_eq!(arm.inverse_all(&pose)?.len(), 8);
/// assert!((arm.inverse(&pose, &q)? - q).amax() < 1e-12);
/// # Ok::<(), arcfeed_kinematics::KinematicsError>(())
/// ```
pub type SphericalWristArm = ClosedFormArm<SphericalWrist>;

/// A six-joint arm with a closed-form inverse: a [`ParallelAxisArm`] or a [`SphericalWristArm`].
#[derive(Debug, Clone, Copy)]
pub struct ClosedFormArm<S> {
    chain: Chain<6>,
    range: JointRange<6>,
    solver: S,
}

impl<S: ClosedForm> ClosedFormArm<S> {
    /// An arm from its chain and joint range; the geometry is recognised, not the name.
    ///
    /// # Errors
    /// [`KinematicsError::NoClosedForm`] names the rule of the geometry that the chain breaks.
    pub fn new(chain: Chain<6>, range: JointRange<6>) -> Result<Self, KinematicsError> {
        let solver = S::recognise(&chain.configuration(&Joints::zeros()))?;
        Ok(Self { chain, range, solver })
    }

    /// The same arm with its tool point at `tool` in the frame of the flange.
    ///
    /// # Errors
    /// [`KinematicsError::NotFinite`] or [`KinematicsError::NotUnit`].
    pub fn with_tool(&self, tool: Isometry3<f64>) -> Result<Self, KinematicsError> {
        Self::new(self.chain.with_tool(tool)?, self.range)
    }

    /// The same arm standing at `base` in the working frame.
    ///
    /// # Errors
    /// [`KinematicsError::NotFinite`] or [`KinematicsError::NotUnit`].
    pub fn with_base(&self, base: Isometry3<f64>) -> Result<Self, KinematicsError> {
        Self::new(self.chain.with_base(base)?, self.range)
    }

    /// The same arm with another joint range.
    pub fn with_range(&self, range: JointRange<6>) -> Self {
        Self { range, ..*self }
    }

    /// The chain of joints.
    pub fn chain(&self) -> &Chain<6> {
        &self.chain
    }

    /// The ranges of the joints.
    pub fn range(&self) -> &JointRange<6> {
        &self.range
    }

    /// Distances of the arm at `q` from its singular poses, kind by kind.
    pub fn singularity_distances(&self, q: &Joints<6>) -> SingularityDistances {
        self.solver.singularity_distances(&self.chain.configuration(q))
    }

    /// The fate of each inverse solution of `target` when seen from `seed`: inside the limits with which step, or
    /// outside by how much. The long form of [`KinematicsError::OutsideLimits`].
    ///
    /// # Errors
    /// As [`AnalyticInverse::inverse_all`]; [`KinematicsError::JointNotFinite`] for the seed.
    pub fn candidates(
        &self,
        target: &Isometry3<f64>,
        seed: &Joints<6>,
    ) -> Result<impl Iterator<Item = Candidate<6>>, KinematicsError> {
        let solutions = self.solve(target, seed)?;
        let (seed, range) = (*seed, self.range);
        Ok((0..solutions.len()).map(move |i| Candidate::new(&solutions[i], &seed, &range)))
    }

    pub(crate) fn solve(&self, target: &Isometry3<f64>, seed: &Joints<6>) -> Result<Solutions<6>, KinematicsError> {
        check_finite("the seed", seed)?;
        self.polished(target, self.solver.solve(target, seed)?)
    }

    /// The solutions of which the nearest to `seed` is the nearest of all. What a singular pose leaves free takes its value from
    /// `free`.
    fn solve_near(
        &self,
        target: &Isometry3<f64>,
        free: &Joints<6>,
        seed: &Joints<6>,
    ) -> Result<Solutions<6>, KinematicsError> {
        // Polish may change which one is nearest.
        if !self.solver.is_exact() {
            return self.solve(target, free);
        }
        check_finite("the seed", free)?;
        let mut found = Collector::nearest(seed, &self.range);
        self.solver.collect(target, free, &mut found)?;
        Ok(found.into_solutions())
    }

    /// The solutions of the real chain from those of the ideal geometry.
    fn polished(&self, target: &Isometry3<f64>, mut solutions: Solutions<6>) -> Result<Solutions<6>, KinematicsError> {
        if !self.solver.is_exact() {
            solutions.retain_map(|q| self.polish(target, q));
            if solutions.is_empty() {
                return Err(KinematicsError::Unreachable { distance: 0.0, side: crate::error::ReachSide::TooFar });
            }
        }
        Ok(solutions)
    }

    /// Newton steps from a solution of the ideal geometry to one of the real chain, until rounding
    /// ends them.
    fn polish(&self, target: &Isometry3<f64>, start: &Joints<6>) -> Option<Joints<6>> {
        const STEPS: usize = 8;
        const DONE: f64 = 1e-12;
        let target = Target::new(target);
        let rounding = self.chain.residual(start);
        let mut q = *start;
        let mut last = (f64::INFINITY, q);
        for _ in 0..STEPS {
            let at = self.chain.configuration(&q);
            let error = target.error(&at);
            if rounding.covers(error.fixed_rows::<3>(0).norm(), error.fixed_rows::<3>(3).norm()) {
                return Some(q);
            }
            let size = error.amax();
            if size < DONE && size > 0.5 * last.0 {
                return Some(if size < last.0 { q } else { last.1 });
            }
            last = (size, q);
            q += Lu6::new(&at.jacobian())?.solve(&error);
        }
        None
    }
}

impl<S: ClosedForm> ClosedFormArm<S> {
    /// The solution nearest to `seed` inside the range.
    fn nearest(&self, target: &Isometry3<f64>, seed: &Joints<6>) -> Result<Joints<6>, KinematicsError> {
        // What a singular pose leaves free takes its value from the seed, so that must be a possible one.
        let possible = |seed: &Joints<6>| seed.zip_zip_map(self.range.lower(), self.range.upper(), f64::clamp);
        let solutions = self.solve_near(target, &possible(seed), seed)?;
        let found = nearest_solution(&solutions, seed, &self.range);
        match found {
            Err(KinematicsError::OutsideLimits { excess, .. }) if solutions.wrist_singular() => {
                // One of a family was tried; the one that moves the free joint by the excess may be inside.
                let other = |shift: f64| {
                    let mut moved = *seed;
                    moved[S::FREE_JOINT] += shift;
                    nearest_solution(&self.solve(target, &possible(&moved))?, seed, &self.range)
                };
                other(excess).or_else(|_| other(-excess)).or(found)
            }
            found => found,
        }
    }

    /// A solution of the real chain that a search from `seed` finds in at most 60 steps. It need not be the nearest.
    fn searched(&self, target: &Isometry3<f64>, seed: &Joints<6>) -> Result<Joints<6>, KinematicsError> {
        let settings = NumericSettings { restarts: 0, ..NumericSettings::default() };
        NumericArm::new(self.chain, self.range).with_settings(settings)?.inverse(target, seed)
    }
}

impl<S: ClosedForm> ForwardKinematics<6> for ClosedFormArm<S> {
    #[inline]
    fn configuration(&self, q: &Joints<6>) -> Configuration<6> {
        self.chain.configuration(q)
    }

    #[inline]
    fn forward(&self, q: &Joints<6>) -> Isometry3<f64> {
        self.chain.forward(q)
    }

    fn nearest_singularity(&self, q: &Joints<6>) -> Option<SingularityKind> {
        Some(self.singularity_distances(q).nearest)
    }
}

impl<S: ClosedForm> AnalyticInverse<6> for ClosedFormArm<S> {
    fn inverse_all(&self, target: &Isometry3<f64>) -> Result<Solutions<6>, KinematicsError> {
        self.solve(target, &Joints::zeros())
    }

    fn posture(&self, q: &Joints<6>) -> Option<Posture> {
        Some(self.solver.posture(&self.chain.configuration(q)))
    }
}

impl<S: ClosedForm> InverseKinematics<6> for ClosedFormArm<S> {
    fn inverse(&self, target: &Isometry3<f64>, seed: &Joints<6>) -> Result<Joints<6>, KinematicsError> {
        let found = self.nearest(target, seed);
        match found {
            // The real chain may reach what the ideal geometry misses by a hair: beside a singular pose.
            Err(KinematicsError::Unreachable { distance, .. }) if distance < BESIDE && !self.solver.is_exact() => {
                self.searched(target, seed).or(found)
            }
            found => found,
        }
    }

    fn residual(&self, q: &Joints<6>) -> PoseResidual {
        self.chain.residual(q)
    }
}
