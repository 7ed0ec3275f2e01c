//! A curve of the tool as the joints of an arm follow it.

use arcfeed_geometry::{PoseJet, PosePath};
use arcfeed_kinematics::{AnalyticInverse, JointRange, Joints, KinematicsError, Posture};

use super::configuration::{Walked, find_passages, select_configuration};
use super::inverse;
use super::jet::JointJet;
use super::motion_path::MotionPath;
use super::passage::{Passage, passage_at};
use crate::arm::PathArm;
use crate::error::PathError;
use crate::place::PathParameter;

/// Directions that turn by less than this at a knot (rad) count as smooth.
const CORNER: f64 = 1e-6;

/// A [`PosePath`] that an arm follows on one branch of its inverse; the parameter is the arc length, m.
///
/// Where the path crosses a singular pose and the joints stay smooth, as when a wrist straightens while its first joint stands still,
/// the joints on a short interval around that pose are a polynomial of the arc length. The tool is off the path there by no more than
/// 1e-7 m and 2e-7 rad.
///
/// ```
/// use arcfeed_geometry::{ArcLengthCurve, NurbsCurve, OrientationPath, PosePath};
/// use arcfeed_interp::{MotionPath, ToolPath};
/// use arcfeed_kinematics::models;
/// use nalgebra::{UnitQuaternion, Vector3};
///
/// let arm = models::ur5e();
/// let line = NurbsCurve::line(Vector3::new(0.4, -0.1, 0.2), Vector3::new(0.4, 0.1, 0.3))?;
/// let down = OrientationPath::Constant(UnitQuaternion::from_euler_angles(std::f64::consts::PI, 0.0, 0.0));
/// let path = ToolPath::new(&arm, PosePath::new(ArcLengthCurve::new(line, 1e-15)?, down), arm.range())?;
/// assert!((path.length() - 0.05_f64.sqrt()).abs() < 1e-15);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone)]
pub struct ToolPath<'a, const N: usize = 6> {
    arm: &'a dyn PathArm<N>,
    path: PosePath,
    start: Joints<N>,
    knots: Vec<f64>,
    corners: Vec<f64>,
    passages: Vec<Passage<N>>,
}

impl<const N: usize> std::fmt::Debug for ToolPath<'_, N> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("ToolPath").field("length", &self.length()).field("start", &self.start).finish_non_exhaustive()
    }
}

impl<'a, const N: usize> ToolPath<'a, N> {
    /// The path from that of all configurations at its start which stays farthest from singular poses and from the ends of
    /// `range`.
    ///
    /// # Errors
    /// [`PathError::Arm`] when the start is out of reach, [`PathError::NoConfiguration`] when no branch gets to the end.
    pub fn new<A>(arm: &'a A, path: PosePath, range: &JointRange<N>) -> Result<Self, PathError>
    where
        A: PathArm<N> + AnalyticInverse<N>,
    {
        Self::judged(arm, path, range).map(|(_, path)| path)
    }

    /// The path from a configuration of this posture.
    ///
    /// # Errors
    /// [`PathError::NoPosture`] when no solution at the start stands like that; else as [`ToolPath::new`].
    pub fn in_posture<A>(arm: &'a A, path: PosePath, range: &JointRange<N>, posture: Posture) -> Result<Self, PathError>
    where
        A: PathArm<N> + AnalyticInverse<N>,
    {
        let bare = Self::bare(arm, path);
        let all = arm.inverse_all(&bare.pose(0.0)).map_err(bare.refused(0.0))?;
        let there = |q: &Joints<N>| arm.posture(q);
        let wanted: Vec<_> = all.iter().filter(|q| there(q) == Some(posture)).collect();
        if wanted.is_empty() {
            let there = all.iter().filter_map(there).collect();
            return Err(PathError::NoPosture { wanted: posture, there });
        }
        let Walked { start, passages, .. } = select_configuration(&bare, arm, wanted.into_iter(), range)?;
        Ok(Self { start, passages, ..bare })
    }

    /// The path of [`ToolPath::new`] with the quality of its configuration: the least of the smallest singular value and a tenth
    /// of the distance (rad) to the end of a joint's range, over some sixty places of the path. The more, the better.
    ///
    /// # Errors
    /// As [`ToolPath::new`].
    pub fn judged<A>(arm: &'a A, path: PosePath, range: &JointRange<N>) -> Result<(f64, Self), PathError>
    where
        A: PathArm<N> + AnalyticInverse<N>,
    {
        let bare = Self::bare(arm, path);
        let candidates = arm.inverse_all(&bare.pose(0.0)).map_err(bare.refused(0.0))?;
        let Walked { quality, start, passages } = select_configuration(&bare, arm, candidates.iter(), range)?;
        Ok((quality, Self { start, passages, ..bare }))
    }

    /// The path from that configuration at its start which is nearest to `near` (rad).
    ///
    /// # Errors
    /// [`PathError::Arm`] when the arm cannot stand there.
    pub fn starting_near<A: PathArm<N>>(arm: &'a A, path: PosePath, near: &Joints<N>) -> Result<Self, PathError> {
        let bare = Self::bare(arm, path);
        let start = arm.inverse(&bare.pose(0.0), near).map_err(bare.refused(0.0))?;
        let passages = find_passages(&bare, arm, &start);
        Ok(Self { start, passages, ..bare })
    }

    /// Without a configuration yet.
    fn bare<A: PathArm<N>>(arm: &'a A, path: PosePath) -> Self {
        let mut knots = path.knots();
        let length = path.length();
        knots.retain(|&s| s > 0.0 && s < length);
        let corners = path.corners(CORNER).iter().map(|corner| corner.s).filter(|s| *s > 0.0 && *s < length).collect();
        Self { arm, path, start: Joints::zeros(), knots, corners, passages: Vec::new() }
    }

    /// The same path with stops at these arc lengths (m) besides its corners. Places that are not inside the path are left out.
    pub fn with_stops(mut self, stops: &[f64]) -> Self {
        let length = self.length();
        // Nearer to one another they are the same place.
        let same = 1e-9 * length;
        for &s in stops.iter().filter(|s| **s > same && **s < length - same) {
            for list in [&mut self.knots, &mut self.corners] {
                let at = list.partition_point(|&other| other < s - same);
                if list.get(at).is_none_or(|&other| other > s + same) {
                    list.insert(at, s);
                }
            }
        }
        self
    }

    /// The curve of the tool with its orientation.
    pub fn pose_path(&self) -> &PosePath {
        &self.path
    }

    /// The arm.
    pub fn arm(&self) -> &'a dyn PathArm<N> {
        self.arm
    }

    fn pose(&self, s: f64) -> nalgebra::Isometry3<f64> {
        self.path.jet(s).pose
    }

    fn refused(&self, s: f64) -> impl Fn(KinematicsError) -> PathError + '_ {
        move |source| PathError::Arm { place: self.place(s), source }
    }
}

impl<const N: usize> MotionPath<N> for ToolPath<'_, N> {
    fn parameter(&self) -> PathParameter {
        PathParameter::ArcLength
    }

    fn length(&self) -> f64 {
        self.path.length()
    }

    fn start(&self) -> Joints<N> {
        self.start
    }

    fn jet(&self, s: f64, near: &Joints<N>) -> Result<JointJet<N>, PathError> {
        if let Some(passage) = passage_at(&self.passages, s) {
            return Ok(passage.jet(s));
        }
        inverse::jet_near(self.arm, s, &self.path.jet(s), near).map_err(self.refused(s))
    }

    fn jet_with_tool(&self, s: f64, near: &Joints<N>) -> Result<(JointJet<N>, Option<PoseJet>), PathError> {
        let tool = self.path.jet(s);
        let jet = match passage_at(&self.passages, s) {
            Some(passage) => passage.jet(s),
            None => inverse::jet_near(self.arm, s, &tool, near).map_err(self.refused(s))?,
        };
        Ok((jet, Some(tool)))
    }

    fn jet_before(&self, after: &JointJet<N>) -> Result<JointJet<N>, PathError> {
        if passage_at(&self.passages, after.s).is_some() {
            return Ok(*after);
        }
        inverse::jet_at(self.arm, after.s, &self.path.jet_left(after.s), after.q).map_err(self.refused(after.s))
    }

    fn knots(&self) -> &[f64] {
        &self.knots
    }

    fn corners(&self) -> &[f64] {
        &self.corners
    }

    fn tool(&self, s: f64) -> Option<PoseJet> {
        Some(self.path.jet(s))
    }

    fn tool_curve(&self) -> Option<&PosePath> {
        Some(&self.path)
    }

    fn rounding(&self, s: f64, q: &Joints<N>) -> Joints<N> {
        let slope = self.jet(s, q).map_or(Joints::repeat(0.0), |jet| jet.d1);
        inverse::rounding(self.arm, q) + inverse::rounding_of_parameter(&slope, self.length())
    }
}
