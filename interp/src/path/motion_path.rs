//! The interface of a path to a planner.

use arcfeed_geometry::{PoseJet, PosePath};
use arcfeed_kinematics::Joints;

use super::inverse::rounding_of_parameter;
use super::jet::JointJet;
use crate::error::PathError;
use crate::place::{PathParameter, PathPlace};

/// A path of the joints by one parameter `s`, from 0 to [`MotionPath::length`].
///
/// [`ToolPath`](crate::ToolPath) follows a curve of the tool through the inverse kinematics, [`PoseMove`](crate::PoseMove) a motion
/// between two poses, [`JointSpline`](crate::JointSpline) and [`JointLines`](crate::JointLines) run through joint way-points. A path of
/// another kind is a type that implements this trait: four methods are enough.
pub trait MotionPath<const N: usize>: std::fmt::Debug + Send + Sync {
    /// The quantity that the parameter measures.
    fn parameter(&self) -> PathParameter;

    /// Value of the parameter at the end of the path, above 0.
    fn length(&self) -> f64;

    /// Joint values at the start, rad.
    fn start(&self) -> Joints<N>;

    /// Joint values and derivatives at `s`, near the joint values `near`; where derivatives jump, those after the place.
    ///
    /// # Errors
    /// [`PathError::Arm`] where the arm cannot stand.
    fn jet(&self, s: f64, near: &Joints<N>) -> Result<JointJet<N>, PathError>;

    /// The same just before the place of `after`; it differs at knots alone.
    ///
    /// # Errors
    /// As [`MotionPath::jet`].
    fn jet_before(&self, after: &JointJet<N>) -> Result<JointJet<N>, PathError> {
        Ok(*after)
    }

    /// The places inside the path where derivatives may jump, increasing.
    fn knots(&self) -> &[f64] {
        &[]
    }

    /// The places inside the path where the motion has to stop because its direction jumps, increasing.
    fn corners(&self) -> &[f64] {
        &[]
    }

    /// The pose of the tool with its derivatives by the parameter, where the path prescribes one.
    fn tool(&self, _s: f64) -> Option<PoseJet> {
        None
    }

    /// [`MotionPath::jet`] and [`MotionPath::tool`] at once, for paths that need the tool to find the joints.
    ///
    /// # Errors
    /// As [`MotionPath::jet`].
    fn jet_with_tool(&self, s: f64, near: &Joints<N>) -> Result<(JointJet<N>, Option<PoseJet>), PathError> {
        Ok((self.jet(s, near)?, self.tool(s)))
    }

    /// The curve of the tool, where the path is one: its chords can be bounded and parts of it can have a feed of their own.
    fn tool_curve(&self) -> Option<&PosePath> {
        None
    }

    /// By how much rounding may have moved each joint of a setpoint at `s` and `q`, rad.
    fn rounding(&self, s: f64, q: &Joints<N>) -> Joints<N> {
        let slope = self.jet(s, q).map_or(Joints::repeat(0.0), |jet| jet.d1);
        q.map(|value| 16.0 * f64::EPSILON * value.abs()) + rounding_of_parameter(&slope, self.length())
    }

    /// The place at `s`, for messages.
    fn place(&self, s: f64) -> PathPlace {
        let tool = self.tool(s).map(|jet| jet.pose.translation.vector.into());
        PathPlace { s, parameter: self.parameter(), tool }
    }
}
