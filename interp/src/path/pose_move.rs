//! A motion between two poses as the joints of an arm make it.

use arcfeed_geometry::{PoseJet, PoseMotion};
use arcfeed_kinematics::{AnalyticInverse, JointRange, Joints};

use super::configuration::{Walked, find_passages, select_configuration};
use super::inverse;
use super::jet::JointJet;
use super::motion_path::MotionPath;
use super::passage::{Passage, passage_at};
use crate::arm::PathArm;
use crate::error::PathError;
use crate::place::PathParameter;

/// A joint that moves less than this part of the fastest one stands still: it is rounding of the inverse, which must not
/// choose a sign for Coulomb friction.
const STANDSTILL: f64 = 1e-12;

/// A [`PoseMotion`] that an arm follows on one branch of its inverse: pure translation, pure orientation or both in step
/// (Quaternion-Based Velocity Scheduling for Robotic Systems, Electronics 2025, 14, 3869, section 2.4).
///
/// Smooth passages through singular poses are as those of a [`ToolPath`](crate::ToolPath).
#[derive(Clone)]
pub struct PoseMove<'a, const N: usize = 6> {
    arm: &'a dyn PathArm<N>,
    motion: PoseMotion,
    start: Joints<N>,
    passages: Vec<Passage<N>>,
}

impl<const N: usize> std::fmt::Debug for PoseMove<'_, N> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("PoseMove").field("motion", &self.motion).field("start", &self.start).finish_non_exhaustive()
    }
}

impl<'a, const N: usize> PoseMove<'a, N> {
    /// The motion from that of all configurations at its start pose which stays farthest from singular poses and from the
    /// ends of `range`.
    ///
    /// # Errors
    /// [`PathError::Arm`] when the start is out of reach, [`PathError::NoConfiguration`] when no branch gets to the end.
    pub fn new<A>(arm: &'a A, motion: PoseMotion, range: &JointRange<N>) -> Result<Self, PathError>
    where
        A: PathArm<N> + AnalyticInverse<N>,
    {
        let bare = Self { arm, motion, start: Joints::zeros(), passages: Vec::new() };
        let refused = |source| PathError::Arm { place: bare.place(0.0), source };
        let candidates = arm.inverse_all(motion.start()).map_err(refused)?;
        let Walked { start, passages, .. } = select_configuration(&bare, arm, candidates.iter(), range)?;
        Ok(Self { start, passages, ..bare })
    }

    /// The motion from that configuration at its start pose which is nearest to `near` (rad).
    ///
    /// # Errors
    /// [`PathError::Arm`] when the arm cannot stand there.
    pub fn starting_near<A: PathArm<N>>(arm: &'a A, motion: PoseMotion, near: &Joints<N>) -> Result<Self, PathError> {
        let bare = Self { arm, motion, start: Joints::zeros(), passages: Vec::new() };
        let refused = |source| PathError::Arm { place: bare.place(0.0), source };
        let start = arm.inverse(motion.start(), near).map_err(refused)?;
        let passages = find_passages(&bare, arm, &start);
        Ok(Self { start, passages, ..bare })
    }

    /// The motion between poses.
    pub fn motion(&self) -> &PoseMotion {
        &self.motion
    }
}

impl<const N: usize> MotionPath<N> for PoseMove<'_, N> {
    fn parameter(&self) -> PathParameter {
        self.motion.parameter().into()
    }

    fn length(&self) -> f64 {
        self.motion.end()
    }

    fn start(&self) -> Joints<N> {
        self.start
    }

    fn jet(&self, s: f64, near: &Joints<N>) -> Result<JointJet<N>, PathError> {
        self.jet_with_tool(s, near).map(|(jet, _)| jet)
    }

    fn jet_with_tool(&self, s: f64, near: &Joints<N>) -> Result<(JointJet<N>, Option<PoseJet>), PathError> {
        let tool = self.motion.jet(s);
        let jet = match passage_at(&self.passages, s) {
            Some(passage) => passage.jet(s),
            None => inverse::jet_near(self.arm, s, &tool, near)
                .map_err(|source| PathError::Arm { place: self.place(s), source })?,
        };
        let jet = JointJet { d1: settled(jet.d1), d2: settled(jet.d2), d3: settled(jet.d3), ..jet };
        Ok((jet, Some(tool)))
    }

    fn tool(&self, s: f64) -> Option<PoseJet> {
        Some(self.motion.jet(s))
    }

    fn rounding(&self, s: f64, q: &Joints<N>) -> Joints<N> {
        let slope = self.jet(s, q).map_or(Joints::repeat(0.0), |jet| jet.d1);
        inverse::rounding(self.arm, q) + inverse::rounding_of_parameter(&slope, self.length())
    }
}

/// Zeros in place of what is rounding beside the largest component.
fn settled<const N: usize>(derivatives: Joints<N>) -> Joints<N> {
    let rounding = STANDSTILL * derivatives.amax();
    derivatives.map(|d| if d.abs() <= rounding { 0.0 } else { d })
}
