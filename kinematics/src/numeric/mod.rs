//! Inverse kinematics of any arm by damped least squares.
//!
//! Each step solves `min |J dq - e|^2 + mu |dq|^2` for the pose error e with damping mu = |e|^2 / 2
//! (Sugihara 2011, "Solvability-unconcerned inverse kinematics by the Levenberg-Marquardt method"):
//! far from the target and at singular poses it cannot blow up, near the target it becomes Newton's
//! method. A joint at a limit that the step would push outwards is taken out and the step solved
//! again, so that the others make up for it.
//!
//! The tolerances say when a target counts as reached. From there on the steps continue until
//! rounding ends them: Newton's method needs one or two, and solutions along a path are then as
//! smooth as those of a closed form.

mod descent;

use crate::{
    analytic::Solutions,
    branch::nearest_turns,
    chain::Chain,
    error::KinematicsError,
    jacobian::{Configuration, Target},
    joint::{JointKind, JointRange, Joints, check_finite, checked_pose},
    traits::{AnalyticInverse, ForwardKinematics, InverseKinematics, PoseResidual},
    trig::principal,
};
use descent::Attempt;
use nalgebra::Isometry3;
use std::f64::consts::TAU;

/// Restarts over which the search moves away from the seed.
const NEAR_RESTARTS: f64 = 10.0;
/// Attempts that are made to find several solutions.
const SURVEY: usize = 64;

/// What to do with the freedom that is left when the tool stands at its target.
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

/// How hard to try.
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

/// Where the search ended: at the target or not.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NumericSolution<const N: usize> {
    /// Joint values inside the joint range: the solution, or the best that was found.
    pub q: Joints<N>,
    /// Distance of the tool point from the target, m.
    pub position: f64,
    /// Angle between the tool and the target, rad.
    pub orientation: f64,
    /// Whether both are inside the tolerances.
    pub converged: bool,
    /// A joint that stands at a limit there, from 0.
    pub at_limit: Option<usize>,
    /// Attempts from places other than the seed.
    pub restarts: usize,
    /// Steps taken, all attempts together.
    pub steps: usize,
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
    chain: Chain<N>,
    range: JointRange<N>,
    settings: NumericSettings<N>,
    /// Weighs angles against lengths, m/rad: the size of the arm.
    size: f64,
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

    /// Where the joints may stand.
    pub fn range(&self) -> &JointRange<N> {
        &self.range
    }

    /// How hard it tries.
    pub fn settings(&self) -> &NumericSettings<N> {
        &self.settings
    }

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
