//! The common parts of the commands in joint space: limits, rows, files and pictures.

use std::fs::File;

use crate::plot::{Bound, JointQuantity, joint_picture};
use crate::{LimitLine, Robot, Series, Staging, TrajectoryRow, TrajectoryWriter, limit_lines};
use arcfeed_feedrate::{AxisLimits, AxisState, FeedError};
use arcfeed_interp::{JointCheck, JointRates, JointSample, PathParameter};
use arcfeed_kinematics::{ForwardKinematics, JointLimits};
use arcfeed_sync::JointState;

use crate::cli::Failure;
use crate::cli::output::REPORTS;
use crate::cli::robot_args::joint_values;

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
            n => Err($crate::cli::Failure::Undoable(format!("robots of 2 to 7 joints can be moved; this one has {n}"))),
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
pub fn axis_limits<const N: usize>(limits: &JointLimits<N>) -> Result<[AxisLimits; N], FeedError> {
    let one = AxisLimits::symmetric(1.0, 1.0, 1.0)?;
    let mut axes = [one; N];
    for (k, axis) in axes.iter_mut().enumerate() {
        *axis = AxisLimits::symmetric(limits.velocity()[k], limits.acceleration()[k], limits.jerk()[k])?;
    }
    Ok(axes)
}

/// A sample with the tool pose that belongs to it.
pub fn row<A: ForwardKinematics<N>, const N: usize>(arm: &A, t: f64, state: &JointState<N>) -> TrajectoryRow<N> {
    TrajectoryRow::new(t, [&state.q, &state.qd, &state.qdd, &state.qddd], &arm.forward(&state.q))
}

/// A joint motion on its way into its files: each row is checked, written and kept for the pictures.
pub struct JointWriter<'s, const N: usize> {
    staging: &'s mut Staging,
    trajectory: TrajectoryWriter<File, N>,
    check: JointCheck<N>,
    series: Series,
    limits: JointLimits<N>,
    rates: Option<JointRates<N>>,
    last: Option<TrajectoryRow<N>>,
    rows: usize,
}

/// The files of the commands in joint space.
pub const FILES: [&str; 7] = [
    TRAJECTORY,
    "joint_position.svg",
    "joint_velocity.svg",
    "joint_acceleration.svg",
    "joint_jerk.svg",
    REPORTS[0],
    REPORTS[1],
];
const TRAJECTORY: &str = "trajectory.csv";

/// Columns of the series: time, then four quantities of every joint, then the limits of three of them.
const QUANTITIES: [JointQuantity; 4] =
    [JointQuantity::Position, JointQuantity::Velocity, JointQuantity::Acceleration, JointQuantity::Jerk];

impl<'s, const N: usize> JointWriter<'s, N> {
    /// Begins the files of a motion of `robot`, for about `samples` rows.
    pub fn new(
        staging: &'s mut Staging,
        robot: &Robot,
        limits: &JointLimits<N>,
        samples: usize,
    ) -> Result<Self, Failure> {
        let (file, names) = (staging.create(TRAJECTORY)?, robot.any().joint_names());
        let trajectory = TrajectoryWriter::new(file, names).map_err(|source| staging.failed(TRAJECTORY, source))?;
        Ok(Self {
            staging,
            trajectory,
            check: JointCheck::new(limits.range()),
            series: Series::new(1 + 7 * N, samples),
            limits: *limits,
            rates: None,
            last: None,
            rows: 0,
        })
    }

    /// The next row, `dt` (s) after the one before; `rates` are in force from it on.
    pub fn write(&mut self, row: &TrajectoryRow<N>, dt: f64, rates: &JointRates<N>) -> Result<(), Failure> {
        self.check.see(&JointSample::from(row), dt, rates);
        self.trajectory.write(row).map_err(|source| self.staging.failed(TRAJECTORY, source))?;
        if self.rates.is_some_and(|before| before != *rates) {
            self.series.cut();
        }
        let (r, l) = (row, rates);
        let rows = [&r.q, &r.qd, &r.qdd, &r.jerk].into_iter().flatten();
        let limits = [&l.velocity, &l.acceleration, &l.jerk].into_iter().flatten();
        self.series.push(std::iter::once(r.t).chain(rows.chain(limits).copied()));
        (self.rates, self.last) = (Some(*rates), Some(*row));
        self.rows += 1;
        Ok(())
    }

    /// Number of rows so far.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// The last row.
    pub fn last(&self) -> Option<&TrajectoryRow<N>> {
        self.last.as_ref()
    }

    /// Holds the states of the joints at one end of the motion against those asked for.
    pub fn see_end(&mut self, t: f64, states: &[AxisState; N], wanted: &[AxisState; N]) {
        self.check.see_end(t, states, wanted);
    }

    /// Ends the trajectory, draws the pictures with `marks` at the times of events, and returns every limit.
    pub fn finish(self, name: &str, marks: &[f64]) -> Result<Vec<LimitLine>, Failure> {
        let Self { staging, trajectory, check, mut series, limits, .. } = self;
        trajectory.finish().map_err(|source| staging.failed(TRAJECTORY, source))?;
        series.cut();
        for (i, (quantity, file)) in QUANTITIES.into_iter().zip(&FILES[1..]).enumerate() {
            let values: [&[f64]; N] = std::array::from_fn(|k| series.column(1 + i * N + k));
            let bounds: [Bound<'_>; N] = std::array::from_fn(|k| match i {
                0 => Bound::Between(limits.lower()[k], limits.upper()[k]),
                _ => Bound::OverTime(series.column(1 + (3 + i) * N + k)),
            });
            let svg = joint_picture(name, quantity, series.column(0), &values, &bounds, marks);
            staging.write_picture(file, svg)?;
        }
        Ok(limit_lines(&check.finish(), PathParameter::JointDistance))
    }
}

/// Joint by joint, of a state.
pub fn axes_of<const N: usize>(state: &JointState<N>) -> [AxisState; N] {
    std::array::from_fn(|k| AxisState::new(state.q[k], state.qd[k], state.qdd[k]))
}
