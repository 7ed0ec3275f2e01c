//! What the commands in joint space share: limits, rows and pictures.

use std::path::{Path, PathBuf};

use arcfeed_feedrate::{AxisLimits, StateToStateError};
use arcfeed_kinematics::{ForwardKinematics, JointLimits};
use arcfeed_sync::JointState;
use robot_cr7::plot::{Bound, JointQuantity, joint_picture, save_picture};
use robot_cr7::{InputError, Rates, Robot, TrajectoryRow};

use crate::Failure;
use crate::robots::joint_values;

/// Calls the generic function with the number of joints of the robot.
macro_rules! for_joints {
    ($robot:expr, $function:ident ( $($argument:expr),* )) => {
        match $robot.joints() {
            2 => $function::<2>($($argument),*),
            3 => $function::<3>($($argument),*),
            4 => $function::<4>($($argument),*),
            5 => $function::<5>($($argument),*),
            6 => $function::<6>($($argument),*),
            7 => $function::<7>($($argument),*),
            n => Err($crate::Failure::Undoable(format!("robots of 2 to 7 joints can be moved; this one has {n}"))),
        }
    };
}
pub(crate) use for_joints;

/// One finite number for each joint of the robot.
pub fn numbers<const N: usize>(flag: &str, values: &[f64], robot: &Robot) -> Result<[f64; N], Failure> {
    let values = joint_values(flag, values, robot)?;
    Ok(std::array::from_fn(|k| values[k]))
}

/// The limits of each joint as an axis of its own.
pub fn axis_limits<const N: usize>(limits: &JointLimits<N>) -> Result<[AxisLimits; N], StateToStateError> {
    let one = AxisLimits::symmetric(1.0, 1.0, 1.0)?;
    let mut axes = [one; N];
    for (k, axis) in axes.iter_mut().enumerate() {
        *axis = AxisLimits::symmetric(limits.velocity()[k], limits.acceleration()[k], limits.jerk()[k])?;
    }
    Ok(axes)
}

/// The same as plain numbers.
pub fn rates_of<const N: usize>(limits: &JointLimits<N>) -> Rates<N> {
    Rates {
        velocity: (*limits.velocity()).into(),
        acceleration: (*limits.acceleration()).into(),
        jerk: (*limits.jerk()).into(),
    }
}

/// A sample with the tool pose that belongs to it.
pub fn row<A: ForwardKinematics<N>, const N: usize>(arm: &A, t: f64, state: &JointState<N>) -> TrajectoryRow<N> {
    let pose = arm.forward(&state.q);
    let rotation = pose.rotation.quaternion();
    TrajectoryRow {
        t,
        q: state.q.into(),
        qd: state.qd.into(),
        qdd: state.qdd.into(),
        jerk: state.qddd.into(),
        position: pose.translation.vector.into(),
        quaternion: [rotation.i, rotation.j, rotation.k, rotation.w],
    }
}

/// A column of a trajectory, and the limit that belongs to it.
type Column<const N: usize> = fn(&TrajectoryRow<N>) -> &[f64; N];
type Limit<const N: usize> = fn(&Rates<N>) -> &[f64; N];

/// Pictures of position, velocity, acceleration and jerk of every joint: positions with the ranges of `limits`, the others
/// with the `rates` in force at each row; `marks` are the times of events.
pub fn draw<const N: usize>(
    name: &str,
    out: &Path,
    rows: &[TrajectoryRow<N>],
    limits: &JointLimits<N>,
    rates: impl Fn(usize) -> Rates<N>,
    marks: &[f64],
) -> Result<Vec<PathBuf>, Failure> {
    let t: Vec<f64> = rows.iter().map(|r| r.t).collect();
    let mut files = Vec::new();
    let pictures: [(&str, JointQuantity, Column<N>, Option<Limit<N>>); 4] = [
        ("joint_position.svg", JointQuantity::Position, |r| &r.q, None),
        ("joint_velocity.svg", JointQuantity::Velocity, |r| &r.qd, Some(|r| &r.velocity)),
        ("joint_acceleration.svg", JointQuantity::Acceleration, |r| &r.qdd, Some(|r| &r.acceleration)),
        ("joint_jerk.svg", JointQuantity::Jerk, |r| &r.jerk, Some(|r| &r.jerk)),
    ];
    for (file, quantity, of, limit) in pictures {
        let columns: [Vec<f64>; N] = std::array::from_fn(|k| rows.iter().map(|r| of(r)[k]).collect());
        let values = columns.each_ref().map(Vec::as_slice);
        let over_time: [Vec<f64>; N] = std::array::from_fn(|k| {
            limit.map_or_else(Vec::new, |limit| (0..rows.len()).map(|i| limit(&rates(i))[k]).collect())
        });
        let bounds = std::array::from_fn::<_, N, _>(|k| match limit {
            Some(_) => Bound::OverTime(&over_time[k]),
            None => Bound::Between(limits.lower()[k], limits.upper()[k]),
        });
        let path = out.join(file);
        let svg = joint_picture(name, quantity, &t, &values, &bounds, marks)
            .map_err(|source| InputError::Write { file: path.clone(), source })?;
        save_picture(&path, &svg)?;
        files.push(path);
    }
    Ok(files)
}
