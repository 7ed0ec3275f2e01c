//! Rest-to-rest motion on a straight line in joint space.

use arcfeed_feedrate::{MotionLaw, MotionLimits, SProfile};
use nalgebra::SVector;

use crate::error::SyncError;

/// Symmetric bounds of each axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AxisLimits<const N: usize> {
    velocity: SVector<f64, N>,
    acceleration: SVector<f64, N>,
    jerk: SVector<f64, N>,
}

impl<const N: usize> AxisLimits<N> {
    /// Bounds on velocity (rad/s), acceleration (rad/s²) and jerk (rad/s³), for each axis.
    ///
    /// # Errors
    /// [`SyncError::Axis`] naming the axis and the bound that is not finite or not above 0.
    pub fn new(
        velocity: SVector<f64, N>,
        acceleration: SVector<f64, N>,
        jerk: SVector<f64, N>,
    ) -> Result<Self, SyncError> {
        for (what, bounds) in
            [("velocity limit", &velocity), ("acceleration limit", &acceleration), ("jerk limit", &jerk)]
        {
            for (axis, &value) in bounds.iter().enumerate() {
                if !(value.is_finite() && value > 0.0) {
                    return Err(SyncError::Axis { axis, what, value, rule: "finite and greater than 0" });
                }
            }
        }
        Ok(Self { velocity, acceleration, jerk })
    }

    /// The bounds axis by axis, as motions between states take them.
    pub fn per_axis(&self) -> [arcfeed_feedrate::AxisLimits; N] {
        std::array::from_fn(|k| {
            arcfeed_feedrate::AxisLimits::symmetric(self.velocity[k], self.acceleration[k], self.jerk[k])
                .unwrap_or_else(|_| unreachable!("the constructor has checked the same"))
        })
    }

    /// Velocity bounds (rad/s).
    pub const fn velocity(&self) -> &SVector<f64, N> {
        &self.velocity
    }

    /// Acceleration bounds (rad/s²).
    pub const fn acceleration(&self) -> &SVector<f64, N> {
        &self.acceleration
    }

    /// Jerk bounds (rad/s³).
    pub const fn jerk(&self) -> &SVector<f64, N> {
        &self.jerk
    }
}

/// Position of all axes and its first three derivatives by time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointState<const N: usize> {
    /// Position (rad).
    pub q: SVector<f64, N>,
    /// Velocity (rad/s).
    pub qd: SVector<f64, N>,
    /// Acceleration (rad/s²).
    pub qdd: SVector<f64, N>,
    /// Jerk (rad/s³).
    pub qddd: SVector<f64, N>,
}

impl<const N: usize> JointState<N> {
    /// At rest at a position (rad).
    pub fn rest(q: SVector<f64, N>) -> Self {
        let still = SVector::zeros();
        Self { q, qd: still, qdd: still, qddd: still }
    }
}

impl<const N: usize> Default for JointState<N> {
    fn default() -> Self {
        let zero = SVector::zeros();
        Self { q: zero, qd: zero, qdd: zero, qddd: zero }
    }
}

/// The fastest motion from rest to rest on the straight line between two joint positions.
///
/// With `q = start + sigma (goal - start)` every bound of an axis is a bound of the one scalar `sigma`, so
/// its limits are the least of `bound_k / |goal_k - start_k|` over the axes and one seven-phase S-profile over
/// `sigma` in `[0, 1]` is time-optimal among all motions on that line.
///
/// ```
/// use arcfeed_sync::{AxisLimits, PointToPoint};
/// use nalgebra::Vector3;
/// let limits = AxisLimits::new(Vector3::repeat(2.0), Vector3::repeat(10.0), Vector3::repeat(200.0))?;
/// let goal = Vector3::new(1.0, -0.5, 0.0);
/// let motion = PointToPoint::new(Vector3::zeros(), goal, &limits)?;
/// assert_eq!(motion.at(motion.duration()).q, goal);
/// # Ok::<(), arcfeed_sync::SyncError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PointToPoint<const N: usize> {
    start: SVector<f64, N>,
    goal: SVector<f64, N>,
    delta: SVector<f64, N>,
    profile: Option<SProfile>,
    /// How many times slower than the profile the motion runs.
    stretch: f64,
}

impl<const N: usize> PointToPoint<N> {
    /// The fastest motion from `start` to `goal` (rad). If the two are equal its duration is 0.
    ///
    /// # Errors
    /// [`SyncError::Axis`] if a position is not finite; [`SyncError::Line`] if the numbers leave the range of `f64`.
    pub fn new(start: SVector<f64, N>, goal: SVector<f64, N>, limits: &AxisLimits<N>) -> Result<Self, SyncError> {
        Self::lasting_at_least(start, goal, limits, 0.0)
    }

    /// As [`PointToPoint::new`], but lasting at least `least` (s). A motion that would be faster is run slower as a whole, so
    /// that it lasts exactly that long.
    ///
    /// # Errors
    /// As [`PointToPoint::new`], and [`SyncError::Duration`] if `least` is negative or not finite. A motion
    /// without length stays where it is, whatever `least` is.
    pub fn lasting_at_least(
        start: SVector<f64, N>,
        goal: SVector<f64, N>,
        limits: &AxisLimits<N>,
        least: f64,
    ) -> Result<Self, SyncError> {
        if !(least.is_finite() && least >= 0.0) {
            return Err(SyncError::Duration { value: least });
        }
        let delta = goal - start;
        for (what, vector) in [("start", &start), ("goal", &goal), ("distance", &delta)] {
            for (axis, &value) in vector.iter().enumerate() {
                if !value.is_finite() {
                    return Err(SyncError::Axis { axis, what, value, rule: "finite" });
                }
            }
        }
        let tightest = |bounds: &SVector<f64, N>| {
            bounds.iter().zip(delta.iter()).fold(f64::INFINITY, |least, (&bound, &d)| least.min(bound / d.abs()))
        };
        if delta.iter().all(|&d| d == 0.0) {
            return Ok(Self { start, goal, delta, profile: None, stretch: 1.0 });
        }
        let limits =
            MotionLimits::new(tightest(&limits.velocity), tightest(&limits.acceleration), tightest(&limits.jerk))?;
        let profile = SProfile::new(1.0, 0.0, 0.0, &limits)?;
        let stretch = (least / profile.duration()).max(1.0);
        Ok(Self { start, goal, delta, profile: Some(profile), stretch })
    }

    /// Duration (s).
    pub fn duration(&self) -> f64 {
        self.profile.map_or(0.0, |profile| profile.duration() * self.stretch)
    }

    /// The state at time `t` (s), clamped to `[0, duration]`; at the ends exactly `start` and `goal`, at rest. Allocates nothing.
    pub fn at(&self, t: f64) -> JointState<N> {
        let still = SVector::zeros();
        let Some(profile) = &self.profile else {
            return JointState { q: self.goal, qd: still, qdd: still, qddd: still };
        };
        let k = 1.0 / self.stretch;
        if t >= self.duration() {
            return JointState { q: self.goal, qd: still, qdd: still, qddd: still };
        }
        let sigma = profile.at(t * k);
        JointState {
            q: self.start + self.delta * sigma.p,
            qd: self.delta * (sigma.v * k),
            qdd: self.delta * (sigma.a * k * k),
            qddd: self.delta * (sigma.j * k * k * k),
        }
    }
}
