//! The commands of a motion.

use arcfeed_feedrate::LiveSection;
use arcfeed_kinematics::Joints;

use super::error::{HybridError, MAX_POINTS};

/// The way in which a tool path is left.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum LeaveBy {
    /// Brake on the path first: the tool stays on it until it stands.
    #[default]
    Braking,
    /// From the present motion straight into joint space: position, velocity and acceleration of the joints go on without a jump.
    AtOnce,
}

/// The way in which all joints come to a point together.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum JointMoveBy {
    /// All joints arrive at the same time, which is the shortest possible one
    /// ([`OnlineGenerator`](arcfeed_sync::OnlineGenerator)).
    #[default]
    LeastTime,
    /// On a straight line of the joint space, as soon as motion across it has been braked
    /// ([`ProjectionSync`](arcfeed_sync::ProjectionSync); Liu et al. 2024, section 4.2, corrected).
    Projection,
}

/// A way through joint space: points between, and a goal where the arm waits. It stands at each point for a moment, unless
/// [`Excursion::with_passing`] lets it pass.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Excursion<const N: usize = 6> {
    points: [Joints<N>; MAX_POINTS],
    count: usize,
    within: f64,
    /// The way in which the path is left.
    pub leave: LeaveBy,
    /// The way in which the joints come to each point.
    pub by: JointMoveBy,
}

impl<const N: usize> Excursion<N> {
    /// Through `points` (rad) in order; the last one is the goal.
    ///
    /// # Errors
    /// [`HybridError::Points`] for none or more than [`MAX_POINTS`].
    pub fn new(points: &[Joints<N>], leave: LeaveBy) -> Result<Self, HybridError> {
        if points.is_empty() || points.len() > MAX_POINTS {
            return Err(HybridError::Points { count: points.len() });
        }
        let mut all = [Joints::zeros(); MAX_POINTS];
        all[..points.len()].copy_from_slice(points);
        Ok(Self { points: all, count: points.len(), within: 0.0, leave, by: JointMoveBy::LeastTime })
    }

    /// Passes the points before the goal without a stop, on the way out and back: as soon as every joint is `within` (rad) of a point,
    /// the arm goes for the next one from its present motion. 0 stops at each point. Where the next point cannot be gone for without
    /// leaving the range of a joint the arm stops at the point.
    ///
    /// # Errors
    /// [`HybridError::Within`] for a number that is negative or not finite.
    pub fn with_passing(mut self, within: f64) -> Result<Self, HybridError> {
        if !(within.is_finite() && within >= 0.0) {
            return Err(HybridError::Within { value: within });
        }
        self.within = within;
        Ok(self)
    }

    /// Sets the way in which the joints come to each point, and back to the path.
    pub fn with_joint_moves(mut self, by: JointMoveBy) -> Self {
        self.by = by;
        self
    }

    /// The distance of every joint from a point at which the next one is gone for, rad.
    pub fn within(&self) -> f64 {
        self.within
    }

    /// The points, the goal last.
    pub fn points(&self) -> &[Joints<N>] {
        &self.points[..self.count]
    }
}

/// One order to a [`HybridMotion`](super::HybridMotion), given in a cycle.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[non_exhaustive]
pub enum Command<const N: usize = 6> {
    /// Go on.
    #[default]
    None,
    /// Another programmed feed, m/s.
    Feed(f64),
    /// Feed override, 1 for 100 %; 0 holds.
    Override(f64),
    /// A feed of its own on a stretch of the path, besides those set before.
    Section(LiveSection),
    /// No more stretches with feeds of their own.
    ClearSections,
    /// Brake and stay, on the path or in joint space.
    Hold,
    /// Go on after a hold or a step back.
    Resume,
    /// Back along the path to this arc length, m, and hold there.
    StepBack(f64),
    /// An event: into joint space, or to other points if the arm is there already.
    Leave(Excursion<N>),
    /// Back to where the path was left, through the points that were passed, and on along it.
    Return,
    /// Brake and stay for good.
    Stop,
}
