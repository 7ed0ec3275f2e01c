//! Motion of the tool from one pose to another: pure translation, pure orientation, or both in step.
//!
//! Quaternion-Based Velocity Scheduling for Robotic Systems, Electronics 2025, 14, 3869, section 2.4. The parameter of a
//! motion is the length covered where the tool point moves, and the angle turned where it does not; the paper's `s2`
//! (eq. 12: the arc cosine of the product of two quaternions) is **half** the rotation angle, while
//! everything here is the full angle. Position and orientation change at constant rates by the parameter, so that
//! the ratio of rotation to length is constant (eq. 13) and higher derivatives of the twist vanish.

use std::fmt;

use nalgebra::{Isometry3, Translation3, Unit, UnitQuaternion, Vector3, Vector6};

use crate::error::GeometryError;
use crate::pose_path::PoseJet;

/// Tool points closer than this are the same, m, and orientations closer than this are, rad.
const SAME: f64 = 1e-9;

/// The quantity that the parameter of a motion measures.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum PathParameter {
    /// Length covered by the tool point, m.
    ArcLength,
    /// Angle turned by the tool (the full angle, not half of it), rad.
    RotationAngle,
}

impl PathParameter {
    /// Unit of the parameter: "m" or "rad".
    pub const fn unit(self) -> &'static str {
        match self {
            Self::ArcLength => "m",
            Self::RotationAngle => "rad",
        }
    }
}

impl fmt::Display for PathParameter {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::ArcLength => "arc length",
            Self::RotationAngle => "rotation angle",
        })
    }
}

/// The three types of motion between two poses (Electronics 2025, 14, 3869, section 2.4).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum MotionType {
    /// PT: the tool point moves, the orientation stays.
    PureTranslation,
    /// PO: the tool turns about its point.
    PureOrientation,
    /// TO: both, in constant ratio.
    Composite,
}

impl fmt::Display for MotionType {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::PureTranslation => "pure translation",
            Self::PureOrientation => "pure orientation",
            Self::Composite => "composite motion",
        })
    }
}

/// The tool's way from a start pose to a goal pose: straight, and turning about one axis on the shorter arc.
///
/// ```
/// use arcfeed_geometry::nalgebra::{Isometry3, Vector3};
/// use arcfeed_geometry::{MotionType, PathParameter, PoseMotion};
/// let start = Isometry3::translation(0.3, 0.0, 0.2);
/// // Half a metre along y while the tool turns by 1 rad about z.
/// let goal = Isometry3::new(Vector3::new(0.3, 0.5, 0.2), Vector3::z());
/// let motion = PoseMotion::new(&start, &goal)?;
/// assert_eq!((motion.kind(), motion.parameter()), (MotionType::Composite, PathParameter::ArcLength));
/// assert_eq!((motion.end(), motion.rotation_per_length()), (0.5, Some(2.0)));
/// assert!((motion.jet(0.25).pose.rotation.angle() - 0.5).abs() < 1e-15);
/// # Ok::<(), arcfeed_geometry::GeometryError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PoseMotion {
    start: Isometry3<f64>,
    goal: Isometry3<f64>,
    kind: MotionType,
    length: f64,
    angle: f64,
    /// Unit direction of travel and unit axis of rotation in base axes; zero where there is none.
    direction: Vector3<f64>,
    axis: Vector3<f64>,
}

impl PoseMotion {
    /// The motion from `start` to `goal` (tool in base). Less than 1e-9 m counts as no translation and less than 1e-9 rad
    /// as no rotation.
    ///
    /// At 180 degrees both arcs are equally short: the tool then turns about that one of the two opposite axes whose
    /// component of greatest magnitude is positive in base axes (within 1e-9 rad of 180 degrees, so that rounding
    /// does not choose).
    ///
    /// # Errors
    /// [`GeometryError::SamePose`]; [`GeometryError::PoseNotFinite`] for numbers that are not finite or a quaternion that is not of unit length.
    pub fn new(start: &Isometry3<f64>, goal: &Isometry3<f64>) -> Result<Self, GeometryError> {
        for (what, pose) in [("start", start), ("goal", goal)] {
            let norm = pose.rotation.quaternion().norm();
            let place = pose.translation.vector.sum();
            if !(place.is_finite() && (norm - 1.0).abs() < 1e-6) {
                return Err(GeometryError::PoseNotFinite { what, place, norm });
            }
        }
        let unit = |pose: &Isometry3<f64>| {
            Isometry3::from_parts(pose.translation, UnitQuaternion::new_normalize(pose.rotation.into_inner()))
        };
        let (start, goal) = (unit(start), unit(goal));
        let way = goal.translation.vector - start.translation.vector;
        let length = way.norm();
        if !length.is_finite() {
            return Err(GeometryError::PoseNotFinite { what: "goal", place: length, norm: 1.0 });
        }
        let (axis, angle) = shorter_arc(&(goal.rotation * start.rotation.inverse()));
        let (moves, turns) = (length > SAME, angle > SAME);
        let kind = match (moves, turns) {
            (true, true) => MotionType::Composite,
            (true, false) => MotionType::PureTranslation,
            (false, true) => MotionType::PureOrientation,
            (false, false) => return Err(GeometryError::SamePose { distance: length, angle }),
        };
        Ok(Self {
            start,
            goal,
            kind,
            length: if moves { length } else { 0.0 },
            angle: if turns { angle } else { 0.0 },
            direction: if moves { way / length } else { Vector3::zeros() },
            axis: if turns { axis } else { Vector3::zeros() },
        })
    }

    /// Which of the three types it is.
    pub fn kind(&self) -> MotionType {
        self.kind
    }

    /// The quantity that its parameter measures: the arc length, or the rotation angle of a pure orientation.
    pub fn parameter(&self) -> PathParameter {
        match self.kind {
            MotionType::PureOrientation => PathParameter::RotationAngle,
            _ => PathParameter::ArcLength,
        }
    }

    /// Value of the parameter at the goal, m or rad; 0 at the start.
    pub fn end(&self) -> f64 {
        match self.kind {
            MotionType::PureOrientation => self.angle,
            _ => self.length,
        }
    }

    /// Distance between the tool points, m.
    pub fn length(&self) -> f64 {
        self.length
    }

    /// Angle between the orientations, rad, at most pi (to rounding).
    pub fn angle(&self) -> f64 {
        self.angle
    }

    /// Axis of the rotation, in base axes; none for a pure translation.
    pub fn axis(&self) -> Option<Unit<Vector3<f64>>> {
        (self.angle > 0.0).then(|| Unit::new_unchecked(self.axis))
    }

    /// Rotation per length, rad/m: the constant ratio of eq. 13 in full angles; none for a pure orientation.
    pub fn rotation_per_length(&self) -> Option<f64> {
        (self.length > 0.0).then(|| self.angle / self.length)
    }

    /// The pose it starts from.
    pub fn start(&self) -> &Isometry3<f64> {
        &self.start
    }

    /// The pose it goes to.
    pub fn goal(&self) -> &Isometry3<f64> {
        &self.goal
    }

    /// Pose and derivatives by the parameter (m or rad, see [`PoseMotion::parameter`]), taken to the nearest end outside
    /// `[0, end]` (NaN to the start). The rows are those of a twist; `d2` and `d3` are zero.
    #[inline]
    pub fn jet(&self, s: f64) -> PoseJet {
        let end = self.end();
        let s = s.max(0.0).min(end);
        let share = s / end;
        let position = self.start.translation.vector + self.direction * (self.length * share);
        let turn = UnitQuaternion::new(self.axis * (self.angle * share));
        let (linear, angular) = (self.direction * (self.length / end), self.axis * (self.angle / end));
        PoseJet {
            pose: Isometry3::from_parts(Translation3::from(position), turn * self.start.rotation),
            d1: Vector6::new(linear.x, linear.y, linear.z, angular.x, angular.y, angular.z),
            d2: Vector6::zeros(),
            d3: Vector6::zeros(),
        }
    }

    /// Pose at the parameter value `s`.
    pub fn pose(&self, s: f64) -> Isometry3<f64> {
        self.jet(s).pose
    }
}

/// Axis and angle of a rotation, the angle at most pi but for rounding.
fn shorter_arc(turn: &UnitQuaternion<f64>) -> (Vector3<f64>, f64) {
    let (w, v) = (turn.w, turn.imag());
    let (mut w, mut v) = if w < 0.0 { (-w, -v) } else { (w, v) };
    if w < 0.5 * SAME && v[v.iamax()] < 0.0 {
        // The other way round is as short: an angle that is larger than pi by rounding at most.
        (w, v) = (-w, -v);
    }
    let sine = v.norm();
    (v / sine.max(f64::MIN_POSITIVE), 2.0 * sine.atan2(w))
}
