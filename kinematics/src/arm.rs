//! A six-joint arm with three parallel axes: chain, joint range and closed-form solver in one.

use crate::{
    analytic::{ParallelAxisSolver, Solutions},
    branch::{Candidate, nearest_solution},
    chain::Chain,
    error::KinematicsError,
    jacobian::{Configuration, Twist},
    joint::{JointRange, Joints},
    lu::Lu6,
    singularity::SingularityKind,
    traits::{AnalyticInverse, ForwardKinematics, InverseKinematics},
};
use nalgebra::{Isometry3, Vector3};

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
#[derive(Debug, Clone, Copy)]
pub struct ParallelAxisArm {
    chain: Chain<6>,
    range: JointRange<6>,
    solver: ParallelAxisSolver,
}

impl ParallelAxisArm {
    /// An arm from its chain and joint range; the geometry is recognised, not the name.
    ///
    /// # Errors
    /// [`KinematicsError::NotParallelAxis`] names the rule of the geometry that the chain breaks.
    pub fn new(chain: Chain<6>, range: JointRange<6>) -> Result<Self, KinematicsError> {
        let solver = ParallelAxisSolver::recognise(&chain.configuration(&Joints::zeros()))?;
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

    /// Where the joints may stand.
    pub fn range(&self) -> &JointRange<6> {
        &self.range
    }

    /// What becomes of each inverse solution of `target` when seen from `seed`: inside the limits with which step, or
    /// outside by how much. The long form of [`KinematicsError::OutsideLimits`].
    ///
    /// # Errors
    /// As [`AnalyticInverse::inverse_all`]; [`KinematicsError::NotFinite`] also for the seed.
    pub fn candidates(
        &self,
        target: &Isometry3<f64>,
        seed: &Joints<6>,
    ) -> Result<impl Iterator<Item = Candidate<6>>, KinematicsError> {
        let solutions = self.solve(target, seed)?;
        let (seed, range) = (*seed, self.range);
        Ok((0..solutions.len()).map(move |i| Candidate::new(&solutions[i], &seed, &range)))
    }

    fn solve(&self, target: &Isometry3<f64>, seed: &Joints<6>) -> Result<Solutions<6>, KinematicsError> {
        if !seed.iter().all(|v| v.is_finite()) {
            return Err(KinematicsError::NotFinite { what: "the seed" });
        }
        let mut solutions = self.solver.solve(target, seed)?;
        if !self.solver.is_exact() {
            solutions.retain_map(|q| self.polish(target, q));
            if solutions.is_empty() {
                return Err(KinematicsError::Unreachable { distance: 0.0, side: crate::error::ReachSide::TooFar });
            }
        }
        Ok(solutions)
    }

    /// Newton steps from a solution of the ideal geometry to one of the real chain.
    fn polish(&self, target: &Isometry3<f64>, start: &Joints<6>) -> Option<Joints<6>> {
        const STEPS: usize = 8;
        const DONE: f64 = 1e-13;
        let mut q = *start;
        let mut last = f64::INFINITY;
        for _ in 0..STEPS {
            let at = self.chain.configuration(&q);
            let error = pose_error(target, &at);
            let size = error.amax();
            if size < DONE || (size < 1e-12 && size >= last) {
                return Some(q);
            }
            last = size;
            q += Lu6::new(&at.jacobian())?.solve(&error);
        }
        None
    }
}

/// The twist that leads from `at` to `target`, to first order.
fn pose_error(target: &Isometry3<f64>, at: &Configuration<6>) -> Twist {
    let linear = target.translation.vector - at.position();
    let wanted = target.rotation.to_rotation_matrix();
    let angular: Vector3<f64> = (0..3)
        .map(|i| {
            let is: Vector3<f64> = at.rotation().column(i).into();
            let should: Vector3<f64> = wanted.matrix().column(i).into();
            is.cross(&should) * 0.5
        })
        .sum();
    Twist::new(linear.x, linear.y, linear.z, angular.x, angular.y, angular.z)
}

impl ForwardKinematics<6> for ParallelAxisArm {
    #[inline]
    fn configuration(&self, q: &Joints<6>) -> Configuration<6> {
        self.chain.configuration(q)
    }

    fn nearest_singularity(&self, q: &Joints<6>) -> Option<SingularityKind> {
        Some(self.solver.nearest_singularity(&self.chain.configuration(q)))
    }
}

impl AnalyticInverse<6> for ParallelAxisArm {
    fn inverse_all(&self, target: &Isometry3<f64>) -> Result<Solutions<6>, KinematicsError> {
        self.solve(target, &Joints::zeros())
    }
}

impl InverseKinematics<6> for ParallelAxisArm {
    fn inverse(&self, target: &Isometry3<f64>, seed: &Joints<6>) -> Result<Joints<6>, KinematicsError> {
        nearest_solution(&self.solve(target, seed)?, seed, &self.range)
    }
}
