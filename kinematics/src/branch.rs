//! Choosing among inverse solutions: inside the joint limits, nearest to a seed, bounded steps.

use crate::{
    error::KinematicsError,
    joint::{JointRange, Joints},
    traits::InverseKinematics,
    turns::{LimitExcess, nearest_turns},
};
use nalgebra::Isometry3;

/// The fate of one inverse solution: see [`ParallelAxisArm::candidates`](crate::ParallelAxisArm::candidates).
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Candidate<const N: usize> {
    /// Inside the limits.
    Usable {
        /// The joint values, on the turns of 2 pi nearest to the seed.
        q: Joints<N>,
        /// The joint with the largest step from the seed, from 0.
        joint: usize,
        /// That step, rad.
        step: f64,
    },
    /// Outside the limits on every turn of 2 pi.
    OutsideLimits {
        /// The joint values, each in (-pi, pi].
        q: Joints<N>,
        /// The joint that misses its limits most.
        excess: LimitExcess,
    },
}

impl<const N: usize> Candidate<N> {
    /// The fate of `solution` (revolute joints, any turn) under `range`, seen from `seed`.
    pub(crate) fn new(solution: &Joints<N>, seed: &Joints<N>, range: &JointRange<N>) -> Self {
        match nearest_turns(solution, seed, range) {
            Ok(q) => {
                let (joint, step) = largest_step(&q, seed);
                Self::Usable { q, joint, step }
            }
            Err(excess) => Self::OutsideLimits { q: *solution, excess },
        }
    }
}

/// The joint with the largest difference between `a` and `b` (from 0), and that difference.
pub fn largest_step<const N: usize>(a: &Joints<N>, b: &Joints<N>) -> (usize, f64) {
    (0..N).map(|i| (i, (a[i] - b[i]).abs())).fold((0, 0.0), |most, one| if one.1 > most.1 { one } else { most })
}

/// The one of the `solutions` (revolute joints, any turn) inside `range` with the least largest joint step from `seed`.
///
/// The largest step and not the sum of squares: the joint that moves most decides how long the step takes, and a sum
/// would trade one jump against five small moves. Ties go to the smaller sum of squares.
///
/// # Errors
/// [`KinematicsError::OutsideLimits`] tells the least bad solution if none is inside. An empty slice is
/// [`KinematicsError::NotFinite`], as only targets that are none have no solution and no other error.
pub fn nearest_solution<const N: usize>(
    solutions: &[Joints<N>],
    seed: &Joints<N>,
    range: &JointRange<N>,
) -> Result<Joints<N>, KinematicsError> {
    let mut best: Option<(f64, f64, Joints<N>)> = None;
    let mut least: Option<LimitExcess> = None;
    for solution in solutions {
        match Candidate::new(solution, seed, range) {
            Candidate::Usable { q, step, .. } => {
                let squares = (q - seed).norm_squared();
                if best.is_none_or(|(known, sum, _)| step < known || (step == known && squares < sum)) {
                    best = Some((step, squares, q));
                }
            }
            Candidate::OutsideLimits { excess, .. } => {
                if least.is_none_or(|known| excess.excess < known.excess) {
                    least = Some(excess);
                }
            }
        }
    }
    match (best, least) {
        (Some((_, _, q)), _) => Ok(q),
        (None, Some(LimitExcess { joint, value, lower, upper, excess })) => {
            Err(KinematicsError::OutsideLimits { joint, value, lower, upper, excess, solutions: solutions.len() })
        }
        (None, None) => Err(KinematicsError::NotFinite { what: "the set of solutions (it is empty)" }),
    }
}

/// Follows a sequence of poses on one branch: each pose is solved from the joints of the one before.
///
/// ```
/// use arcfeed_kinematics::{BranchTracker, ForwardKinematics, Joints, models};
/// let arm = models::cr7();
/// let start = Joints::<6>::from([0.3, -0.2, 1.4, 0.3, -1.5, 0.0]);
/// let mut tracker = BranchTracker::new(&arm, start).with_max_step(0.1);
/// let mut pose = arm.forward(&start);
/// pose.translation.x += 0.002;
/// let q = tracker.next(&pose)?;
/// assert!((q - start).amax() < 0.01);
/// # Ok::<(), arcfeed_kinematics::KinematicsError>(())
/// ```
#[derive(Clone, Copy)]
pub struct BranchTracker<'a, const N: usize> {
    arm: &'a dyn InverseKinematics<N>,
    joints: Joints<N>,
    max_step: f64,
}

impl<'a, const N: usize> BranchTracker<'a, N> {
    /// Starts at `joints`, with steps of any size.
    pub fn new(arm: &'a dyn InverseKinematics<N>, joints: Joints<N>) -> Self {
        Self { arm, joints, max_step: f64::INFINITY }
    }

    /// Refuses steps in which a joint moves more than `max_step`, rad.
    pub fn with_max_step(self, max_step: f64) -> Self {
        Self { max_step, ..self }
    }

    /// The joints of the last pose that was solved.
    pub fn joints(&self) -> &Joints<N> {
        &self.joints
    }

    /// Solves the next pose. After an error the tracker still stands at the last pose that was solved.
    ///
    /// # Errors
    /// Those of [`InverseKinematics::inverse`], and [`KinematicsError::StepTooLarge`].
    pub fn next(&mut self, target: &Isometry3<f64>) -> Result<Joints<N>, KinematicsError> {
        let q = self.arm.inverse(target, &self.joints)?;
        let (joint, step) = largest_step(&q, &self.joints);
        if step > self.max_step {
            return Err(KinematicsError::StepTooLarge { joint, step, bound: self.max_step });
        }
        self.joints = q;
        Ok(q)
    }
}
