//! Attempt after attempt: from the seed, from ever farther places, and all over the joint range.

use super::{
    arm::{NumericArm, NumericSettings},
    descent::Attempt,
};
use crate::{
    analytic::Solutions,
    error::KinematicsError,
    jacobian::Target,
    joint::{JointKind, Joints, check_finite, checked_pose},
    traits::{AnalyticInverse, InverseKinematics, PoseResidual},
    trig::principal,
    turns::nearest_turns,
};
use nalgebra::Isometry3;
use std::f64::consts::TAU;

/// Restarts over which the search moves away from the seed.
const NEAR_RESTARTS: f64 = 10.0;
/// Attempts that are made to find several solutions.
const SURVEY: usize = 64;

/// The end of the search: at the target or not.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NumericSolution<const N: usize> {
    /// Joint values inside the joint range: the solution, or the best that was found.
    pub q: Joints<N>,
    /// Distance of the tool point from the target, m.
    pub position: f64,
    /// Angle between the tool and the target, rad.
    pub orientation: f64,
    /// True if both are inside the tolerances.
    pub converged: bool,
    /// A joint that stands at a limit there, from 0.
    pub at_limit: Option<usize>,
    /// Attempts from places other than the seed.
    pub restarts: usize,
    /// Steps taken, all attempts together.
    pub steps: usize,
}

impl<const N: usize> NumericArm<N> {
    /// Searches from `seed` (put into the joint range), then from places ever farther from it, at
    /// last from places spread evenly over the range, until the tool stands at `target`; the best
    /// that was found if it never does.
    ///
    /// # Errors
    /// [`KinematicsError::NotFinite`] or [`KinematicsError::NotUnit`] for a target that is none,
    /// [`KinematicsError::JointNotFinite`] for such a seed.
    pub fn search(&self, target: &Isometry3<f64>, seed: &Joints<N>) -> Result<NumericSolution<N>, KinematicsError> {
        let target = Target::new(&checked_pose("target", target)?);
        check_finite("the seed", seed)?;
        let moved = self.moved_to_posture(&target, seed);
        let mut best = self.attempt(&target, moved.as_ref().unwrap_or(seed));
        let (mut steps, mut restarts) = (best.steps + usize::from(moved.is_some()), 0);
        // A step that leads nowhere, or past the nearest place to the posture, is taken back.
        if moved.is_some() && !(best.converged && self.posture_distance(&best.q) <= self.posture_distance(seed)) {
            let plain = self.attempt(&target, seed);
            steps += plain.steps;
            let nearer = self.posture_distance(&plain.q) < self.posture_distance(&best.q);
            if !best.converged || (plain.converged && nearer) {
                best = plain;
            }
        }
        while !best.converged && restarts < self.settings.restarts {
            restarts += 1;
            let away = (restarts as f64 / NEAR_RESTARTS).min(1.0);
            let attempt = self.attempt(&target, &(seed + (self.place(restarts) - seed) * away));
            steps += attempt.steps;
            let miss = |a: &Attempt<N>| a.position + self.size * a.orientation;
            if attempt.converged || miss(&attempt) < miss(&best) || miss(&best).is_nan() {
                best = attempt;
            }
        }
        if best.converged && restarts > 0 {
            best.q = self.turned_towards(&best.q, seed);
        }
        let Attempt { q, position, orientation, converged, .. } = best;
        let at_limit = (0..N).find(|&i| q[i] <= self.range.lower()[i] || q[i] >= self.range.upper()[i]);
        Ok(NumericSolution { q, position, orientation, converged, at_limit, restarts, steps })
    }

    /// The `k`-th of a sequence of places that fills the joint range evenly (Halton).
    fn place(&self, k: usize) -> Joints<N> {
        const PRIMES: [usize; 12] = [2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37];
        let (lower, upper) = (self.range.lower(), self.range.upper());
        Joints::from_fn(|i, _| {
            // One turn is enough of a joint that turns further.
            let width = match self.chain.joints()[i].kind() {
                JointKind::Revolute => (upper[i] - lower[i]).min(TAU),
                JointKind::Prismatic => upper[i] - lower[i],
            };
            let middle = 0.5 * (lower[i] + upper[i]);
            // The first terms of large bases are in step with each other; later ones are not.
            middle + width * (radical_inverse(k + 20, PRIMES[i % PRIMES.len()]) - 0.5)
        })
    }

    /// `q` with every turning joint on the turn inside the range that is nearest to `seed`.
    pub(crate) fn turned_towards(&self, q: &Joints<N>, seed: &Joints<N>) -> Joints<N> {
        let turned = nearest_turns(q, seed, &self.range).unwrap_or(*q);
        Joints::from_fn(|i, _| if self.chain.joints()[i].kind() == JointKind::Revolute { turned[i] } else { q[i] })
    }
}

impl<const N: usize> InverseKinematics<N> for NumericArm<N> {
    /// The solution that the search from `seed` runs into, not necessarily the nearest of all.
    ///
    /// # Errors
    /// [`KinematicsError::NotConverged`] tells how near the best attempt came.
    fn inverse(&self, target: &Isometry3<f64>, seed: &Joints<N>) -> Result<Joints<N>, KinematicsError> {
        let end = self.search(target, seed)?;
        if end.converged {
            return Ok(end.q);
        }
        Err(end.failure())
    }

    fn residual(&self, q: &Joints<N>) -> PoseResidual {
        self.chain.residual(q)
    }
}

impl<const N: usize> NumericSolution<N> {
    fn failure(&self) -> KinematicsError {
        let NumericSolution { position, orientation, restarts, at_limit, .. } = *self;
        KinematicsError::NotConverged { position, orientation, attempts: restarts + 1, at_limit }
    }
}

impl<const N: usize> AnalyticInverse<N> for NumericArm<N> {
    /// Different solutions inside the joint range, as far as a search from places spread over the
    /// range finds them: [`Solutions::is_complete`] is false.
    ///
    /// # Errors
    /// [`KinematicsError::NotConverged`] tells how near the best attempt came.
    fn inverse_all(&self, target: &Isometry3<f64>) -> Result<Solutions<N>, KinematicsError> {
        let mut solutions = Solutions::new();
        solutions.mark_incomplete();
        let once = Self { settings: NumericSettings { restarts: 0, ..self.settings }, ..*self };
        for k in 0..SURVEY {
            let found = once.search(target, &self.place(k))?;
            let turning = |i: usize| self.chain.joints()[i].kind() == JointKind::Revolute;
            let q = Joints::from_fn(|i, _| if turning(i) { principal(found.q[i]) } else { found.q[i] });
            let same = |other: &Joints<N>| {
                (0..N).all(|i| {
                    let apart = q[i] - other[i];
                    (if turning(i) { principal(apart) } else { apart }).abs() < 1e-6
                })
            };
            if found.converged && !solutions.iter().any(same) {
                solutions.push(q);
            }
        }
        if solutions.is_empty() {
            let end = self.search(target, &self.place(0))?;
            if !end.converged {
                return Err(end.failure());
            }
            solutions.push(self.turned_towards(&end.q, &Joints::zeros()));
        }
        Ok(solutions)
    }
}

/// The digits of `k` in `base`, mirrored at the point: a number in [0, 1).
fn radical_inverse(mut k: usize, base: usize) -> f64 {
    let (mut value, mut digit) = (0.0, 1.0);
    while k > 0 {
        digit /= base as f64;
        value += digit * (k % base) as f64;
        k /= base;
    }
    value
}
