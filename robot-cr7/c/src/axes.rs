//! Plain values of axes.

use arcfeed_feedrate::{AxisLimits, AxisState, MotionState};
use arcfeed_sync::{JointState, Synchronisation};
use nalgebra::SVector;

use crate::input::{All, Item, finite};
use crate::status::ArcfeedStatus::ArcfeedInvalid;
use crate::status::{Outcome, refuse};

/// Position (rad or m), velocity and acceleration of an axis.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct ArcfeedAxisState {
    /// Position (rad or m).
    pub position: f64,
    /// Velocity (rad/s or m/s).
    pub velocity: f64,
    /// Acceleration (rad/s^2 or m/s^2).
    pub acceleration: f64,
}

/// Position (rad or m) of an axis and its first three derivatives by time.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct ArcfeedMotionState {
    /// Position (rad or m).
    pub position: f64,
    /// Velocity (rad/s or m/s).
    pub velocity: f64,
    /// Acceleration (rad/s^2 or m/s^2).
    pub acceleration: f64,
    /// Jerk (rad/s^3 or m/s^3).
    pub jerk: f64,
}

/// Limits of an axis. Lower ones are below 0, upper ones above.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct ArcfeedAxisLimits {
    /// Lowest velocity, below 0.
    pub v_min: f64,
    /// Highest velocity, above 0.
    pub v_max: f64,
    /// Lowest acceleration, below 0.
    pub a_min: f64,
    /// Highest acceleration, above 0.
    pub a_max: f64,
    /// Lowest jerk, below 0.
    pub j_min: f64,
    /// Highest jerk, above 0.
    pub j_max: f64,
}

/// The range of positions of an axis; infinite ends for none.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct ArcfeedRange {
    /// Lower end (rad or m).
    pub lower: f64,
    /// Upper end (rad or m), above the lower one.
    pub upper: f64,
}

/// How the axes move together. Functions take it as an `int32_t`, so that another number is an error and no defect.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ArcfeedSynchronisation {
    /// Every axis moves as fast as it can and arrives on its own.
    ArcfeedSyncNone = 0,
    /// All axes arrive at the same time, the earliest that is possible.
    ArcfeedSyncTime = 1,
    /// A straight line wherever both states lie on one, otherwise as `ARCFEED_SYNC_TIME`.
    ArcfeedSyncStraight = 2,
    /// A straight line, or an error.
    ArcfeedSyncForcedStraight = 3,
}

/// The synchronisation of a number from C.
pub fn synchronisation(value: i32) -> Outcome<Synchronisation> {
    use ArcfeedSynchronisation as C;
    const MODES: [(C, Synchronisation); 4] = [
        (C::ArcfeedSyncNone, Synchronisation::None),
        (C::ArcfeedSyncTime, Synchronisation::Time),
        (C::ArcfeedSyncStraight, Synchronisation::StraightLine),
        (C::ArcfeedSyncForcedStraight, Synchronisation::ForcedStraight),
    ];
    match MODES.into_iter().find(|(number, _)| *number as i32 == value) {
        Some((_, mode)) => Ok(mode),
        None => Err(refuse(
            ArcfeedInvalid,
            format_args!("synchronisation is {value}; it must be one of ArcfeedSynchronisation"),
        )),
    }
}

/// The state of one axis.
pub fn state(of: &Item, c: ArcfeedAxisState) -> Outcome<AxisState> {
    Ok(AxisState::new(
        finite(of, ".position", c.position)?,
        finite(of, ".velocity", c.velocity)?,
        finite(of, ".acceleration", c.acceleration)?,
    ))
}

/// The limits of one axis.
pub fn limits(of: &Item, c: ArcfeedAxisLimits) -> Outcome<AxisLimits> {
    AxisLimits::new((c.v_min, c.v_max), (c.a_min, c.a_max), (c.j_min, c.j_max))
        .map_err(|error| refuse(ArcfeedInvalid, format_args!("{of}.{error}")))
}

/// The range of one axis.
pub fn range(of: &Item, c: ArcfeedRange) -> Outcome<(f64, f64)> {
    if c.lower < c.upper {
        return Ok((c.lower, c.upper));
    }
    let (lower, upper) = (c.lower, c.upper);
    Err(refuse(ArcfeedInvalid, format_args!("{of} is [{lower}, {upper}]; lower must be below upper")))
}

/// One number for each axis.
pub fn number(of: &Item, value: f64) -> Outcome<f64> {
    finite(of, "", value)
}

/// The values of `N` axes.
pub fn of_axes<T: Copy, const N: usize>(all: &All<T>) -> [T; N] {
    std::array::from_fn(|k| all[k])
}

impl From<MotionState> for ArcfeedMotionState {
    fn from(s: MotionState) -> Self {
        Self { position: s.p, velocity: s.v, acceleration: s.a, jerk: s.j }
    }
}

impl From<AxisState> for ArcfeedAxisState {
    fn from(s: AxisState) -> Self {
        Self { position: s.p, velocity: s.v, acceleration: s.a }
    }
}

/// The states of all axes; those past `N` are 0.
pub fn motion_states<const N: usize>(state: &JointState<N>) -> All<ArcfeedMotionState> {
    let of = |values: &SVector<f64, N>, k: usize| values.get(k).copied().unwrap_or(0.0);
    std::array::from_fn(|k| ArcfeedMotionState {
        position: of(&state.q, k),
        velocity: of(&state.qd, k),
        acceleration: of(&state.qdd, k),
        jerk: of(&state.qddd, k),
    })
}
