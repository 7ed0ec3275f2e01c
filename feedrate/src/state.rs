//! The state of a motion on one scalar, and the trait of everything that yields it over time.

/// Position, speed, acceleration and jerk at one moment.
///
/// The scalar may be an arc length (m) or any other path coordinate; the units of the other fields
/// follow from it and from seconds.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct MotionState {
    /// Position (m).
    pub p: f64,
    /// Speed (m/s).
    pub v: f64,
    /// Acceleration (m/s²).
    pub a: f64,
    /// Jerk (m/s³).
    pub j: f64,
}

/// A motion of one scalar over time.
pub trait MotionLaw {
    /// Duration of the motion (s).
    fn duration(&self) -> f64;

    /// The state at time `t` (s), with `t` clamped to `[0, duration]` (NaN counts as 0).
    ///
    /// At both ends position, speed and acceleration are exactly the ones planned. Jerk is the one
    /// that acts from `t` on; at the end it is 0.
    fn at(&self, t: f64) -> MotionState;
}

/// Position, velocity and acceleration of one axis at one moment.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct AxisState {
    /// Position (m or rad).
    pub p: f64,
    /// Velocity (1/s).
    pub v: f64,
    /// Acceleration (1/s²).
    pub a: f64,
}

impl AxisState {
    /// A state of motion.
    pub const fn new(p: f64, v: f64, a: f64) -> Self {
        Self { p, v, a }
    }

    /// At rest at a position.
    pub const fn rest(p: f64) -> Self {
        Self { p, v: 0.0, a: 0.0 }
    }
}
