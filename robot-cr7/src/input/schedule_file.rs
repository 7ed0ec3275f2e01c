//! The file of `cr7 schedule`: a motion between two poses or through joint way-points, with its limits, as TOML.

use std::path::{Path, PathBuf};

use arcfeed_kinematics::Inertial;
use nalgebra::{Isometry3, Matrix3, Vector3};
use serde::Deserialize;

use super::error::{InputError, read_text};
use super::job_file::{RawFrame, RawJoints, RawSampling};
use super::joint_values::{JointOverrides, JointValues};
use super::toml_check::{Check, read_toml};
use super::unit::DEGREE;

const EXPECTED: &str = "a TOML file such as schedules/pick.toml";

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, default)]
#[derive(Default)]
struct RawFile {
    motion: RawMotion,
    sampling: RawSampling,
    tool: RawFrame,
    payload: Option<RawPayload>,
    start: Option<RawPlace>,
    goal: Option<RawPlace>,
    waypoint: Vec<RawWaypoint>,
    limits: RawLimits,
}

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
struct RawMotion {
    intervals: Option<i64>,
    start_speed: Option<f64>,
    end_speed: Option<f64>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct RawPayload {
    mass_kg: f64,
    #[serde(default)]
    centre_mm: [f64; 3],
    #[serde(default)]
    inertia_kg_m2: [f64; 3],
}

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
struct RawPlace {
    position_mm: Option<[f64; 3]>,
    rotation_rpy_deg: Option<[f64; 3]>,
    q_deg: Option<JointValues>,
    near_deg: Option<JointValues>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct RawWaypoint {
    q_deg: JointValues,
}

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
struct RawLimits {
    velocity_deg_s: Option<JointValues>,
    acceleration_deg_s2: Option<JointValues>,
    jerk_deg_s3: Option<JointValues>,
    torque_nm: Option<JointValues>,
    linear_mm_s: Option<f64>,
    angular_deg_s: Option<f64>,
}

/// The place of the tool at one end of a motion.
#[derive(Debug, Clone, PartialEq)]
pub enum SchedulePlace {
    /// Tool tip in the base frame.
    Pose(Isometry3<f64>),
    /// The pose at these joint values, rad.
    Joints(JointValues),
}

/// The way of a [`ScheduleFile`].
#[derive(Debug, Clone, PartialEq)]
pub enum ScheduleWay {
    /// From pose to pose.
    Poses {
        /// The start.
        start: SchedulePlace,
        /// The goal.
        goal: SchedulePlace,
        /// Joint values near which the start is looked for, rad.
        near: Option<JointValues>,
    },
    /// Through joint way-points, rad.
    Waypoints(Vec<JointValues>),
}

/// A checked schedule, in SI units.
#[derive(Debug, Clone, PartialEq)]
pub struct ScheduleFile {
    /// The file.
    pub file: PathBuf,
    text: String,
    /// The way.
    pub way: ScheduleWay,
    /// Tool tip in the flange frame.
    pub tool: Isometry3<f64>,
    /// The load at the flange.
    pub payload: Option<Inertial>,
    /// Intervals of the grid.
    pub intervals: usize,
    /// Speeds at start and end as written: mm/s or deg/s, which the motion decides.
    pub speeds: [f64; 2],
    /// Control period, s.
    pub period: f64,
    /// Whether the motion lasts a whole number of control periods.
    pub whole_cycles: bool,
    /// Limits of velocity, acceleration and jerk that replace the robot's own.
    pub joints: JointOverrides,
    /// Torque limits that replace the robot's own, N m.
    pub torque: Option<JointValues>,
    /// Speed of the tool tip, m/s.
    pub linear_speed: Option<f64>,
    /// Angular speed of the tool, rad/s.
    pub angular_speed: Option<f64>,
    /// Values that are allowed but look like a slip of the unit.
    pub warnings: Vec<String>,
}

impl ScheduleFile {
    /// A file with every key and what it means.
    pub const EXAMPLE: &'static str = include_str!("../../schedules/pick.toml");
    /// A file with joint way-points.
    pub const WAYPOINTS: &'static str = include_str!("../../schedules/waypoints.toml");

    /// Reads and checks a file.
    ///
    /// # Errors
    /// Fails when the file cannot be read, is not TOML, has an unknown key, or a value breaks its rule.
    pub fn read(file: &Path) -> Result<Self, InputError> {
        Self::parse(&read_text(file, EXPECTED)?, file)
    }

    /// Like [`ScheduleFile::read`], from text; `file` is the name used in messages.
    ///
    /// # Errors
    /// As [`ScheduleFile::read`].
    pub fn parse(text: &str, file: &Path) -> Result<Self, InputError> {
        let raw: RawFile = read_toml(text, file, "schedules/pick.toml")?;
        let mut check = Check::new(text, file);
        let tool = check.frame("tool", &raw.tool, Isometry3::identity())?;
        let way = way(&mut check, &raw)?;
        let intervals = match raw.motion.intervals {
            None => 500,
            Some(n) => usize::try_from(n).ok().filter(|n| (4..=1_000_000).contains(n)).ok_or_else(|| {
                let rule = "a grid has 4 to 1000000 intervals";
                check.wrong("motion.intervals", n, rule, "200 to 2000 are usual")
            })?,
        };
        let speed = |key: &str, value: Option<f64>| match value.unwrap_or(0.0) {
            v if v.is_finite() && v >= 0.0 => Ok(v),
            v => Err(check.wrong(key, v, "a speed is finite and not negative", "write 0 for a motion from or to rest")),
        };
        let speeds =
            [speed("motion.start_speed", raw.motion.start_speed)?, speed("motion.end_speed", raw.motion.end_speed)?];
        let limits = &raw.limits;
        let joints = RawJoints {
            velocity_deg_s: limits.velocity_deg_s.clone(),
            acceleration_deg_s2: limits.acceleration_deg_s2.clone(),
            jerk_deg_s3: limits.jerk_deg_s3.clone(),
        };
        let torque = match &limits.torque_nm {
            None => None,
            Some(values) => Some(check.limits("limits.torque_nm", values, 1.0)?),
        };
        Ok(Self {
            way,
            tool,
            payload: raw.payload.as_ref().map(|raw| payload(&check, raw)).transpose()?,
            intervals,
            speeds,
            period: check.period(raw.sampling.period_ms)?.unwrap_or(1e-3),
            whole_cycles: check.whole_cycles(&raw.sampling, speeds)?,
            joints: check.overrides("limits", &joints)?,
            torque,
            linear_speed: check.limit("limits.linear_mm_s", limits.linear_mm_s, 1e3)?,
            angular_speed: check.limit("limits.angular_deg_s", limits.angular_deg_s, 1.0 / DEGREE)?,
            warnings: std::mem::take(&mut check.warnings),
            file: file.to_owned(),
            text: text.to_owned(),
        })
    }

    /// Line of a key, from 1, where it is known.
    pub(crate) fn line_of(&self, key: &str) -> Option<usize> {
        Check::new(&self.text, &self.file).line_of(key)
    }

    /// The error of a key.
    pub(crate) fn wrong(&self, key: &str, value: &str, rule: &'static str, remedy: &'static str) -> InputError {
        Check::new(&self.text, &self.file).wrong(key, value, rule, remedy)
    }

    /// The values for an arm of `N` joints.
    ///
    /// # Errors
    /// [`InputError::Value`] for a list of another length.
    pub fn of<const N: usize>(&self, key: &str, values: &JointValues) -> Result<[f64; N], InputError> {
        Check::new(&self.text, &self.file).of(key, values)
    }
}

fn way(check: &mut Check<'_>, raw: &RawFile) -> Result<ScheduleWay, InputError> {
    let remedy = "schedules/pick.toml and schedules/waypoints.toml show both";
    match (&raw.start, &raw.goal, raw.waypoint.as_slice()) {
        (Some(start), Some(goal), []) => {
            let near = match (&start.near_deg, &start.q_deg) {
                (Some(near), _) => Some(check.places("start.near_deg", near, DEGREE)?),
                (None, Some(q)) => Some(check.places("start.q_deg", q, DEGREE)?),
                (None, None) => None,
            };
            if goal.near_deg.is_some() {
                let rule = "the configuration is chosen at the start";
                return Err(check.wrong("goal.near_deg", "given", rule, "move it to [start]"));
            }
            Ok(ScheduleWay::Poses { start: place(check, "start", start)?, goal: place(check, "goal", goal)?, near })
        }
        (None, None, points @ [_, _, ..]) => {
            let each =
                |(i, point): (usize, &RawWaypoint)| check.places(&format!("waypoint[{i}].q_deg"), &point.q_deg, DEGREE);
            Ok(ScheduleWay::Waypoints(points.iter().enumerate().map(each).collect::<Result<_, _>>()?))
        }
        (None, None, points) => {
            let rule = "a motion needs [start] and [goal], or two [[waypoint]] at least";
            Err(check.wrong("waypoint", format!("a list of {}", points.len()), rule, remedy))
        }
        (Some(_), Some(_), _) => {
            let rule = "a motion goes either from [start] to [goal] or through way-points";
            Err(check.wrong("waypoint", "given beside [start] and [goal]", rule, remedy))
        }
        (start, _, _) => {
            let (there, missing) = if start.is_some() { ("start", "[goal]") } else { ("goal", "[start]") };
            let rule = "a motion between poses has both ends";
            Err(check.wrong(there, format!("given without {missing}"), rule, remedy))
        }
    }
}

fn place(check: &mut Check<'_>, section: &str, raw: &RawPlace) -> Result<SchedulePlace, InputError> {
    match (&raw.q_deg, raw.position_mm) {
        (Some(_), Some(_)) => {
            let rule = "a place is given by a pose or by joint angles";
            Err(check.wrong(&format!("{section}.q_deg"), "given beside position_mm", rule, "drop one of the two"))
        }
        (Some(q), None) => Ok(SchedulePlace::Joints(check.places(&format!("{section}.q_deg"), q, DEGREE)?)),
        (None, position_mm) => {
            if position_mm.is_none() {
                let rule = "a place needs position_mm and rotation_rpy_deg, or q_deg";
                return Err(check.wrong(section, "without a position", rule, "add one of them"));
            }
            let frame = RawFrame { position_mm, rotation_rpy_deg: raw.rotation_rpy_deg };
            Ok(SchedulePlace::Pose(check.frame(section, &frame, Isometry3::identity())?))
        }
    }
}

fn payload(check: &Check<'_>, raw: &RawPayload) -> Result<Inertial, InputError> {
    let centre = check.finite("payload.centre_mm", raw.centre_mm)? / 1e3;
    let moments = check.finite("payload.inertia_kg_m2", raw.inertia_kg_m2)?;
    let tensor = Matrix3::from_diagonal(&Vector3::new(moments.x, moments.y, moments.z));
    Inertial::new(raw.mass_kg, centre, tensor).map_err(|e| {
        let rule = "mass and moments are those of a body that can exist";
        check.wrong("payload", e, rule, "give mass_kg, centre_mm and inertia_kg_m2 as in schedules/pick.toml")
    })
}
