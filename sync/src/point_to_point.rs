//! Rest-to-rest motion on a straight line in joint space.

use arcfeed_feedrate::{AxisLimits, MotionLaw, SProfile};
use nalgebra::SVector;

use crate::error::SyncError;
use crate::joint_state::JointState;
use crate::limits::check_symmetric;

/// The fastest motion from rest to rest on the straight line between two joint positions.
///
/// With `q = start + sigma (goal - start)` every bound of an axis is a bound of the one scalar `sigma`, so
/// its limits are the least of `bound_k / |goal_k - start_k|` over the axes and one seven-phase S-profile over
/// `sigma` in `[0, 1]` is time-optimal among all motions on that line.
///
/// ```
/// use arcfeed_sync::{PointToPoint, symmetric_limits};
/// use nalgebra::Vector3;
/// let limits = symmetric_limits(Vector3::repeat(2.0), Vector3::repeat(10.0), Vector3::repeat(200.0))?;
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
    pub fn new(start: SVector<f64, N>, goal: SVector<f64, N>, limits: &[AxisLimits; N]) -> Result<Self, SyncError> {
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
        limits: &[AxisLimits; N],
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
        check_symmetric(limits)?;
        let tightest = |bound: fn(&AxisLimits) -> f64| {
            limits.iter().zip(delta.iter()).fold(f64::INFINITY, |least, (l, &d)| least.min(bound(l) / d.abs()))
        };
        if delta.iter().all(|&d| d == 0.0) {
            return Ok(Self { start, goal, delta, profile: None, stretch: 1.0 });
        }
        let limits = AxisLimits::symmetric(
            tightest(AxisLimits::v_max),
            tightest(AxisLimits::a_max),
            tightest(AxisLimits::j_max),
        )?;
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
