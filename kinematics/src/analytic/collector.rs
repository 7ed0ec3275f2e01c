//! What becomes of the solutions that a closed form finds.

use nalgebra::Isometry3;

use super::Solutions;
use crate::error::KinematicsError;
use crate::joint::{JointRange, Joints};
use crate::turns::nearest_turn;

/// A branch is left out if one of its joints is further from the seed than all joints of a solution that was found, by this much, rad:
/// more than rounding.
const FURTHER: f64 = 1e-9;

/// The part of [`ClosedForm`](super::ClosedForm) that only this crate implements.
pub trait Collect {
    /// Finds the solutions for `target` that `found` wants. Where a singular pose leaves a joint free it takes its value from
    /// `seed` (which must be finite).
    ///
    /// # Errors
    /// [`KinematicsError::Unreachable`], or what is wrong with the target.
    fn collect(
        &self,
        target: &Isometry3<f64>,
        seed: &Joints<6>,
        found: &mut Collector<'_>,
    ) -> Result<(), KinematicsError>;
}

/// Takes the solutions of one target: all, or those that may be the nearest one to a seed.
///
/// The nearest solution is the one whose joint with the largest step has the smallest (see
/// [`nearest_solution`](crate::nearest_solution)). So the step of any one joint bounds the step of a branch from below, and a branch
/// whose first joints are further from the seed than a solution that was found need not be solved. Nothing is left out before a
/// solution inside the joint range was found. What is left out can therefore change neither the nearest solution nor an error.
pub struct Collector<'s> {
    solutions: Solutions<6>,
    near: Option<(&'s Joints<6>, &'s JointRange<6>)>,
    /// Largest step of a joint in the nearest solution so far, rad.
    least: f64,
}

impl<'s> Collector<'s> {
    /// Takes all solutions.
    pub(crate) fn all() -> Self {
        Self { solutions: Solutions::new(), near: None, least: f64::INFINITY }
    }

    /// Takes those that may be the nearest one to `seed` inside `range`.
    pub(crate) fn nearest(seed: &'s Joints<6>, range: &'s JointRange<6>) -> Self {
        Self { near: Some((seed, range)), ..Self::all() }
    }

    /// The solutions that were taken.
    pub(crate) fn into_solutions(self) -> Solutions<6> {
        self.solutions
    }

    /// The solutions so far.
    pub(super) fn solutions(&mut self) -> &mut Solutions<6> {
        &mut self.solutions
    }

    /// Whether a solution with these values of some joints, counted from 0, may be wanted.
    #[inline]
    pub(super) fn wants<const K: usize>(&self, joints: [(usize, f64); K]) -> bool {
        self.least == f64::INFINITY
            || joints.iter().all(|&(joint, value)| self.step(joint, value) <= self.least + FURTHER)
    }

    /// Whether the second of two values of a joint is nearer to the seed.
    #[inline]
    pub(super) fn is_second_nearer(&self, joint: usize, [first, second]: [f64; 2]) -> bool {
        self.near.is_some() && self.step(joint, second) < self.step(joint, first)
    }

    /// Takes a solution.
    #[inline]
    pub(super) fn push(&mut self, q: Joints<6>) {
        if self.near.is_some() {
            self.least = self.least.min((0..6).map(|joint| self.step(joint, q[joint])).fold(0.0, f64::max));
        }
        self.solutions.push(q);
    }

    /// The way of a joint from the seed to the nearest turn of `value` inside the range, rad; infinite if there is none, 0 if no
    /// seed matters.
    #[inline]
    fn step(&self, joint: usize, value: f64) -> f64 {
        let Some((seed, range)) = self.near else { return 0.0 };
        nearest_turn(value, seed[joint], joint, range).map_or(f64::INFINITY, |near| (near - seed[joint]).abs())
    }
}
