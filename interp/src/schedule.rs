//! Speed scheduling between poses and through joint way-points, under limits of joints, drives and tool.
//!
//! A [`SchedulePath`] is a way of the joints by one parameter: an [`ArmMotion`] follows a
//! [`PoseMotion`](arcfeed_geometry::PoseMotion) (pure translation, pure orientation, composite: Quaternion-Based Velocity
//! Scheduling for Robotic Systems, Electronics 2025, 14, 3869, section 2.4) through the inverse kinematics, a
//! [`JointSpline`] runs through way-points. The [`Scheduler`] turns limits into rows on a grid along it, hands them to
//! any [`FeedPlanner`](arcfeed_feedrate::FeedPlanner), and returns a [`Schedule`]: the motion law `s(t)` as planned, setpoints at the control
//! period, and an [`ScheduleCheck`] on dense samples that knows nothing of the rows.
//!
//! ```
//! use arcfeed_geometry::PoseMotion;
//! use arcfeed_interp::{ArmMotion, ScheduleLimits, Scheduler, SpeedPlanner};
//! use arcfeed_kinematics::{ForwardKinematics, Joints, models};
//! use nalgebra::{Isometry3, Vector3};
//!
//! let arm = models::kr6_r700();
//! let q = Joints::<6>::from([0.0, -1.2, 1.8, 0.0, 0.9, 0.0]);
//! // The tool turns by 40 degrees about the vertical through its point.
//! let start = arm.forward(&q);
//! let mut goal = start;
//! goal.append_rotation_wrt_center_mut(&nalgebra::UnitQuaternion::new(Vector3::z() * 0.7));
//! let path = ArmMotion::new(&arm, PoseMotion::new(&start, &goal)?, &q)?;
//! let limits = ScheduleLimits { velocity: Some(Joints::repeat(1.0)), acceleration: Some(Joints::repeat(3.0)), ..ScheduleLimits::default() };
//! let schedule = Scheduler::new(&arm, limits)?.plan(&path, SpeedPlanner::Certified)?;
//! let check = schedule.check(20)?;
//! assert!(check.worst_ratio() < 1.0 + 1e-5, "{}", check.worst_ratio());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod arm_motion;
mod check;
mod joint_spline;
mod plan;
mod rows;
mod scheduler;

pub use arm_motion::ArmMotion;
pub use check::{Binding, LimitUse, ScheduleCheck};
pub use joint_spline::JointSpline;
pub use plan::{LimitPoint, Schedule, ScheduleSampler};
pub use scheduler::{RowsNeeded, Scheduler, SpeedPlanner};

use std::fmt;

use arcfeed_geometry::PathParameter;
use arcfeed_kinematics::{Joints, KinematicsError};

use crate::error::PlanError;
use crate::joint_path::JointJet;

/// What the parameter of a [`SchedulePath`] measures.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum ScheduleParameter {
    /// Length covered by the tool point, m.
    ArcLength,
    /// Angle turned by the tool (full, not half), rad.
    RotationAngle,
    /// Sum of the straight distances between joint way-points (Euclidean, over all joints), rad.
    JointDistance,
}

impl ScheduleParameter {
    /// Unit of the parameter.
    pub const fn unit(self) -> &'static str {
        match self {
            Self::ArcLength => "m",
            Self::RotationAngle | Self::JointDistance => "rad",
        }
    }
}

impl From<PathParameter> for ScheduleParameter {
    fn from(parameter: PathParameter) -> Self {
        match parameter {
            PathParameter::ArcLength => Self::ArcLength,
            PathParameter::RotationAngle => Self::RotationAngle,
        }
    }
}

impl fmt::Display for ScheduleParameter {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::ArcLength => "arc length",
            Self::RotationAngle => "rotation angle",
            Self::JointDistance => "joint distance",
        })
    }
}

/// A way of the joints by one parameter from 0 to [`SchedulePath::end`].
pub trait SchedulePath<const N: usize> {
    /// What the parameter measures.
    fn parameter(&self) -> ScheduleParameter;

    /// Its value at the end of the path, above 0.
    fn end(&self) -> f64;

    /// Joint values at the start.
    fn start(&self) -> Joints<N>;

    /// Where third derivatives may jump, inside the path, increasing.
    fn knots(&self) -> &[f64] {
        &[]
    }

    /// Joint values and derivatives by the parameter at `s`, near the joint values `near`; where derivatives jump, those after it.
    ///
    /// # Errors
    /// Where the arm cannot stand: [`PlanError::OnPath`].
    fn jet(&self, s: f64, near: &Joints<N>) -> Result<JointJet<N>, PlanError>;

    /// The third derivatives just before `s`, where they differ from those of `after`, which belongs to the same place.
    fn third_before(&self, after: &JointJet<N>) -> Joints<N> {
        after.d3
    }
}

/// What a schedule has to keep; `None`, and infinity for a single joint, mean no limit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ScheduleLimits<const N: usize> {
    /// Joint velocity, rad/s.
    pub velocity: Option<Joints<N>>,
    /// Joint acceleration, rad/s^2.
    pub acceleration: Option<Joints<N>>,
    /// Joint jerk, rad/s^3; kept by [`SpeedPlanner::JerkLimited`] alone.
    pub jerk: Option<Joints<N>>,
    /// Torque of the drives at the joints, N m; needs [`Scheduler::with_dynamics`].
    pub torque: Option<Joints<N>>,
    /// Speed of the tool point, m/s.
    pub linear_speed: Option<f64>,
    /// Angular speed of the tool, rad/s.
    pub angular_speed: Option<f64>,
}

impl<const N: usize> Default for ScheduleLimits<N> {
    /// No limits at all; at least one on a velocity is needed for a plan.
    fn default() -> Self {
        Self { velocity: None, acceleration: None, jerk: None, torque: None, linear_speed: None, angular_speed: None }
    }
}

impl<const N: usize> ScheduleLimits<N> {
    /// Checks that every limit is above 0.
    ///
    /// # Errors
    /// [`PlanError::JointLimit`] names the joint, [`PlanError::Limit`] the limit of the tool.
    pub fn validate(&self) -> Result<(), PlanError> {
        for (what, values) in [
            ("velocity", &self.velocity),
            ("acceleration", &self.acceleration),
            ("jerk", &self.jerk),
            ("torque", &self.torque),
        ] {
            let Some(values) = values else { continue };
            if let Some(joint) = (0..N).find(|&j| values[j].is_nan() || values[j] <= 0.0) {
                let (value, rule) = (values[joint], "greater than 0 (infinite for none)");
                return Err(PlanError::JointLimit(KinematicsError::InvalidLimit { joint, what, value, rule }));
            }
        }
        for (what, value) in [("linear speed", self.linear_speed), ("angular speed", self.angular_speed)] {
            if let Some(value) = value.filter(|v| v.is_nan() || *v <= 0.0) {
                return Err(PlanError::Limit { what, value });
            }
        }
        Ok(())
    }
}
