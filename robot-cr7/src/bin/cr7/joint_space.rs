//! What the commands in joint space share: limits, rows and pictures.

use std::path::{Path, PathBuf};

use arcfeed_feedrate::{AxisLimits, StateToStateError};
use arcfeed_kinematics::{ForwardKinematics, JointLimits};
use arcfeed_sync::JointState;
use robot_cr7::plot::{Bound, JointQuantity, joint_picture, save_picture};
use robot_cr7::{InputError, Rates, TrajectoryRow};

use crate::Failure;

/// Names of six values on the command line.
pub mod six {
    pub const Q: [&str; 6] = ["Q1", "Q2", "Q3", "Q4", "Q5", "Q6"];
}

/// Six finite numbers of a flag.
pub fn numbers(flag: &str, values: &[f64]) -> Result<[f64; 6], Failure> {
    if let Some(k) = values.iter().position(|v| !v.is_finite()) {
        return Err(Failure::BadInput(format!("{flag}: value {} is {}: give ordinary numbers", k + 1, values[k])));
    }
    <[f64; 6]>::try_from(values)
        .map_err(|_| Failure::BadInput(format!("{flag}: {} values, but there are 6 joints", values.len())))
}

/// The limits of each joint as an axis of its own.
pub fn axis_limits(limits: &JointLimits<6>) -> Result<[AxisLimits; 6], StateToStateError> {
    let one = AxisLimits::symmetric(1.0, 1.0, 1.0)?;
    let mut axes = [one; 6];
    for (k, axis) in axes.iter_mut().enumerate() {
        *axis = AxisLimits::symmetric(limits.velocity()[k], limits.acceleration()[k], limits.jerk()[k])?;
    }
    Ok(axes)
}

/// The same as plain numbers.
pub fn rates_of(limits: &JointLimits<6>) -> Rates<6> {
    Rates {
        velocity: (*limits.velocity()).into(),
        acceleration: (*limits.acceleration()).into(),
        jerk: (*limits.jerk()).into(),
    }
}

/// A sample with the tool pose that belongs to it.
pub fn row<A: ForwardKinematics<6>>(arm: &A, t: f64, state: &JointState<6>) -> TrajectoryRow<6> {
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

/// Pictures of position, velocity, acceleration and jerk of every joint: positions with the ranges of `limits`, the others
/// with the `rates` in force at each row; `marks` are the times of events.
pub fn draw(
    name: &str,
    out: &Path,
    rows: &[TrajectoryRow<6>],
    limits: &JointLimits<6>,
    rates: impl Fn(usize) -> Rates<6>,
    marks: &[f64],
) -> Result<Vec<PathBuf>, Failure> {
    type Column = fn(&TrajectoryRow<6>) -> &[f64; 6];
    type Limit = fn(&Rates<6>) -> &[f64; 6];
    let t: Vec<f64> = rows.iter().map(|r| r.t).collect();
    let mut files = Vec::new();
    let pictures: [(&str, JointQuantity, Column, Option<Limit>); 4] = [
        ("joint_position.svg", JointQuantity::Position, |r| &r.q, None),
        ("joint_velocity.svg", JointQuantity::Velocity, |r| &r.qd, Some(|r| &r.velocity)),
        ("joint_acceleration.svg", JointQuantity::Acceleration, |r| &r.qdd, Some(|r| &r.acceleration)),
        ("joint_jerk.svg", JointQuantity::Jerk, |r| &r.jerk, Some(|r| &r.jerk)),
    ];
    for (file, quantity, of, limit) in pictures {
        let columns: [Vec<f64>; 6] = std::array::from_fn(|k| rows.iter().map(|r| of(r)[k]).collect());
        let values = columns.each_ref().map(Vec::as_slice);
        let over_time: [Vec<f64>; 6] = std::array::from_fn(|k| {
            limit.map_or_else(Vec::new, |limit| (0..rows.len()).map(|i| limit(&rates(i))[k]).collect())
        });
        let bounds = std::array::from_fn::<_, 6, _>(|k| match limit {
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
