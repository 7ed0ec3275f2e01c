//! The message trajectory_msgs/JointTrajectory.

use std::fmt::Write;

use arcfeed_interp::{JointPoint, JointTrajectory};
use arcfeed_kinematics::JointLimits;
use serde::Serialize;
use thiserror::Error;

/// Why there is no message.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum RosError {
    /// The compiled motion does not keep the limits of the joints.
    #[error("the quintics between the points do not keep the limits of the joints: compile with another --compile-rad")]
    Limits,
    /// The message holds whole seconds in 32 bits.
    #[error("the motion takes {seconds} s, more than the message can hold")]
    TooLong {
        /// Its duration, s.
        seconds: u64,
    },
}

/// A trajectory_msgs/JointTrajectory: a controller that interpolates its points by quintics executes the compiled motion and keeps
/// the limits of the joints.
///
/// ROS 2's joint trajectory controller interpolates so where positions, velocities and accelerations are given.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RosTrajectory {
    header: Header,
    joint_names: Vec<String>,
    points: Vec<Point>,
}

#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize)]
struct Header {
    stamp: Duration,
    frame_id: String,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
struct Duration {
    sec: i32,
    nanosec: u32,
}

#[derive(Debug, Clone, PartialEq, Serialize)]
struct Point {
    positions: Vec<f64>,
    velocities: Vec<f64>,
    accelerations: Vec<f64>,
    effort: Vec<f64>,
    time_from_start: Duration,
}

const NANOSECONDS: u64 = 1_000_000_000;

impl Point {
    fn new<const N: usize>(point: &JointPoint<N>) -> Result<Self, RosError> {
        let seconds = point.nanoseconds / NANOSECONDS;
        let sec = i32::try_from(seconds).map_err(|_| RosError::TooLong { seconds })?;
        let nanosec = (point.nanoseconds % NANOSECONDS) as u32;
        Ok(Self {
            positions: point.q.as_slice().to_vec(),
            velocities: point.qd.as_slice().to_vec(),
            accelerations: point.qdd.as_slice().to_vec(),
            effort: Vec::new(),
            time_from_start: Duration { sec, nanosec },
        })
    }
}

impl RosTrajectory {
    /// The message of a compiled motion.
    ///
    /// # Errors
    /// [`RosError::Limits`] where what the controller makes of the points exceeds a limit; [`RosError::TooLong`].
    pub fn new<const N: usize>(
        compiled: &JointTrajectory<N>,
        joint_names: &[String],
        limits: &JointLimits<N>,
    ) -> Result<Self, RosError> {
        let points = compiled.points(limits.range(), &limits.into()).ok_or(RosError::Limits)?;
        let points = points.iter().map(Point::new).collect::<Result<_, _>>()?;
        Ok(Self { header: Header::default(), joint_names: joint_names.to_vec(), points })
    }

    /// Number of points.
    pub fn len(&self) -> usize {
        self.points.len()
    }

    /// True if there is no point.
    pub fn is_empty(&self) -> bool {
        self.points.is_empty()
    }

    /// As JSON, as `rosbridge` takes it.
    pub fn to_json(&self) -> String {
        crate::text::json(self)
    }

    /// As YAML, as `ros2 topic pub` takes it; a goal of FollowJointTrajectory holds it under `trajectory`.
    pub fn to_yaml(&self) -> String {
        let mut text = String::with_capacity(64 + 64 * self.points.len() * (1 + 3 * self.joint_names.len()));
        // A JSON string is a YAML one.
        let names: Vec<String> = self.joint_names.iter().map(crate::text::json).collect();
        text.push_str("header:\n  stamp: {sec: 0, nanosec: 0}\n  frame_id: ''\n");
        let _ = writeln!(text, "joint_names: [{}]\npoints:", names.join(", "));
        for point in &self.points {
            for (mark, key, values) in [
                ("- ", "positions", &point.positions),
                ("  ", "velocities", &point.velocities),
                ("  ", "accelerations", &point.accelerations),
            ] {
                let values: Vec<String> = values.iter().map(|value| yaml_number(*value)).collect();
                let _ = writeln!(text, "{mark}{key}: [{}]", values.join(", "));
            }
            let Duration { sec, nanosec } = point.time_from_start;
            let _ = writeln!(text, "  time_from_start: {{sec: {sec}, nanosec: {nanosec}}}");
        }
        text
    }
}

/// A number that every YAML reader takes for a float: with a point, without an exponent.
fn yaml_number(value: f64) -> String {
    let text = value.to_string();
    if text.contains('.') { text } else { text + ".0" }
}

#[cfg(feature = "mcap")]
impl super::cdr::Message for RosTrajectory {
    fn write(&self, cdr: &mut super::cdr::Cdr) {
        let time = |cdr: &mut super::cdr::Cdr, time: Duration| {
            cdr.i32(time.sec);
            cdr.u32(time.nanosec);
        };
        time(cdr, self.header.stamp);
        cdr.string(&self.header.frame_id);
        cdr.strings(&self.joint_names);
        cdr.count(self.points.len());
        for point in &self.points {
            for values in [&point.positions, &point.velocities, &point.accelerations, &point.effort] {
                cdr.numbers(values);
            }
            time(cdr, point.time_from_start);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_floats_to_every_reader() {
        let of = |value: f64| yaml_number(value);
        assert_eq!([of(0.0), of(-1.0), of(1e-9), of(0.25)], ["0.0", "-1.0", "0.000000001", "0.25"]);
        assert_eq!(of(1e300).parse::<f64>(), Ok(1e300));
    }
}
