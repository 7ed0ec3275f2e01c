//! A motion between poses or through joint way-points: from a [`ScheduleFile`] and a robot to a
//! planned and verified trajectory.

use arcfeed_interp::{
    JointSpline, LimitError, Limits, Method, MotionPath, PathParameter, PlanError, Planner, ToolLimits, Trajectory,
};
use arcfeed_kinematics::{Arm, ArmDynamics, JointLimits, Joints};

use super::error::Cr7Error;
use super::plan_error::plan_error;
use super::pose_way::pose_way;
use super::robot::Robot;
use super::samples::few_enough;
use crate::input::schedule_file::{ScheduleFile, ScheduleWay};

/// A schedule made ready for one arm. Nothing is planned yet.
#[derive(Debug)]
pub struct SpeedTask<'a, const N: usize> {
    pub(crate) file: &'a ScheduleFile,
    pub(crate) robot: String,
    pub(crate) method: Method,
    /// Kind of motion, in words.
    pub(crate) motion: String,
    /// Rotation of the tool between poses, rad.
    pub(crate) rotation: Option<f64>,
    pub(crate) warnings: Vec<String>,
    arm: &'a Arm<N>,
    path: Box<dyn MotionPath<N> + 'a>,
    limits: OwnLimits<N>,
}

/// Limits of the arm as the file changes them.
#[derive(Debug)]
struct OwnLimits<const N: usize> {
    joints: JointLimits<N>,
    tool: ToolLimits,
    drives: Option<(ArmDynamics<N>, Joints<N>)>,
}

impl<'a, const N: usize> SpeedTask<'a, N> {
    /// The motion through the joint way-points of `file`.
    ///
    /// # Errors
    /// [`Cr7Error::Input`] for a value of the file that the robot cannot take or a file without
    /// way-points, [`Cr7Error::Plan`] for a path that leaves the range of a joint.
    pub fn way_points(
        file: &'a ScheduleFile,
        robot: &Robot,
        arm: &'a Arm<N>,
        method: Method,
    ) -> Result<Self, Cr7Error> {
        let ScheduleWay::Waypoints(points) = &file.way else {
            return Err(other_kind(file, "a motion between poses, where way-points are asked for"));
        };
        let (limits, warnings) = OwnLimits::new(file, robot, arm, method)?;
        let joints = |(i, point)| Ok(Joints::from(file.of::<N>(&format!("waypoint[{i}].q_deg"), point)?));
        let points = points.iter().enumerate().map(joints).collect::<Result<Vec<_>, Cr7Error>>()?;
        let failed = |source: arcfeed_interp::PathError| plan_error(&file.file.display().to_string(), source.into());
        let spline = JointSpline::through(&points).map_err(failed)?;
        spline.within(arm.range()).map_err(failed)?;
        Ok(Self {
            file,
            robot: robot.description().name.clone(),
            method,
            motion: "joint way-points".to_owned(),
            rotation: None,
            warnings,
            arm,
            path: Box::new(spline),
            limits,
        })
    }

    /// The planned and verified motion.
    ///
    /// # Errors
    /// [`Cr7Error::Plan`] with the place, [`Cr7Error::TooManySamples`] for a motion too long to be written.
    pub fn plan(&self) -> Result<Trajectory<'_, N>, Cr7Error> {
        let to_si = if self.path.parameter() == PathParameter::ArcLength { 1e-3 } else { 1f64.to_radians() };
        let [v_start, v_end] = self.file.speeds.map(|v| v * to_si);
        let plan = || {
            let mut limits = Limits::new(self.limits.joints).with_tool(self.limits.tool);
            if let Some((dynamics, torque)) = &self.limits.drives {
                limits = limits.with_torque(dynamics, *torque)?;
            }
            let planner = Planner::new(self.arm, limits)
                .with_method(self.method)
                .with_period(self.file.period)?
                .with_intervals(self.file.intervals)?
                .with_end_speeds(v_start, v_end)?;
            let planner = if self.file.whole_cycles { planner.with_whole_cycles() } else { planner };
            planner.plan(&*self.path)
        };
        let trajectory = plan().map_err(|source| self.error(source))?;
        self.few_enough(trajectory.duration())?;
        Ok(trajectory)
    }

    /// Names of the limited quantities of the joints, with the limits.
    pub(crate) fn limited(&self) -> Vec<(&'static str, Joints<N>)> {
        let joints = &self.limits.joints;
        let mut limited = vec![("velocity", *joints.velocity()), ("acceleration", *joints.acceleration())];
        limited.extend(self.limits.drives.as_ref().map(|(_, torque)| ("torque", *torque)));
        limited.extend(self.method.limits_jerk().then(|| ("jerk", *joints.jerk())));
        limited
    }

    /// The error of a planner, with the file.
    pub(crate) fn error(&self, source: impl Into<PlanError>) -> Cr7Error {
        let source = source.into();
        // A motion that is too long to be planned has too many samples to be written.
        if let PlanError::Limit(LimitError::TooLong { duration, .. }) = source
            && let Err(error) = self.few_enough(duration)
        {
            return error;
        }
        plan_error(&self.file.file.display().to_string(), source)
    }

    fn few_enough(&self, duration: f64) -> Result<(), Cr7Error> {
        few_enough(duration, self.file.period, "the [limits] of the file")
            .map_err(|source| Cr7Error::TooManySamples { file: self.file.file.display().to_string(), source })
    }
}

impl<'a> SpeedTask<'a, 6> {
    /// The motion between the poses of `file`.
    ///
    /// # Errors
    /// As [`SpeedTask::way_points`]; [`Cr7Error::Configuration`] for joints that the motion does not lead to.
    pub fn pose_move(file: &'a ScheduleFile, robot: &Robot, arm: &'a Arm<6>, method: Method) -> Result<Self, Cr7Error> {
        let ScheduleWay::Poses { start, goal, near } = &file.way else {
            return Err(other_kind(file, "way-points, where a motion between poses is asked for"));
        };
        let (limits, warnings) = OwnLimits::new(file, robot, arm, method)?;
        let path = pose_way(file, arm, [start, goal], near.as_ref())?;
        let motion = *path.motion();
        Ok(Self {
            file,
            robot: robot.description().name.clone(),
            method,
            motion: motion.kind().to_string(),
            rotation: Some(motion.angle()),
            warnings,
            arm,
            path: Box::new(path),
            limits,
        })
    }
}

fn other_kind(file: &ScheduleFile, value: &str) -> Cr7Error {
    let rule = "a motion runs between poses or through way-points";
    file.wrong("waypoint", value, rule, "give [start] and [goal], or [[waypoint]]").into()
}

impl<const N: usize> OwnLimits<N> {
    /// The limits, and what a person should know of them.
    fn new(file: &ScheduleFile, robot: &Robot, arm: &Arm<N>, method: Method) -> Result<(Self, Vec<String>), Cr7Error> {
        let (joints, assumed) = robot.limits::<N>(&file.joints)?;
        let mut warnings = file.warnings.clone();
        warnings.extend(assumed.into_iter().filter(|text| method.limits_jerk() || !text.contains(" jerk")));
        let dynamics = match (arm.dynamics(), file.payload) {
            (Some(dynamics), Some(payload)) => Some(dynamics.with_payload(payload)?),
            (dynamics, _) => dynamics.copied(),
        };
        let torque = match &file.torque {
            Some(values) => Some(Joints::from(file.of::<N>("limits.torque_nm", values)?)),
            None => {
                let own = arm.drive_limits().torque;
                if own.is_some() && dynamics.is_none() {
                    warnings.push(format!(
                        "the torque limits of the robot file are NOT kept: the inertia of the links behind the joints {} is not \
                         known; give a robot file that states it, or limits.torque_nm to have the motion refused",
                        robot.without_inertia()
                    ));
                }
                own.filter(|_| dynamics.is_some())
            }
        };
        if torque.is_some() && dynamics.is_none() {
            return Err(robot.no_dynamics("give a robot file that states it, or drop limits.torque_nm"));
        }
        let drives = dynamics.zip(torque);
        if file.payload.is_some() && drives.is_none() {
            warnings.push("the payload has no effect: no torques are limited".to_owned());
        }
        if !method.limits_jerk() && file.joints.jerk.is_some() {
            warnings.push(format!("--planner {method} does not limit jerk; jerk-limited does"));
        }
        let tool = tool_of(file).map_err(|source| plan_error(&file.file.display().to_string(), source.into()))?;
        Ok((Self { joints, tool, drives }, warnings))
    }
}

fn tool_of(file: &ScheduleFile) -> Result<ToolLimits, LimitError> {
    let mut tool = ToolLimits::new();
    if let Some(speed) = file.linear_speed {
        tool = tool.with_feed(speed)?;
    }
    if let Some(speed) = file.angular_speed {
        tool = tool.with_angular_speed(speed)?;
    }
    Ok(tool)
}
