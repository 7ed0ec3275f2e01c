//! Limits of several axes.

use arcfeed_feedrate::AxisLimits;
use nalgebra::SVector;

use crate::error::SyncError;

/// Limits of each axis, the same in both directions, from vectors of velocity (rad/s), acceleration
/// (rad/s²) and jerk (rad/s³).
///
/// # Errors
/// [`SyncError::Axis`] naming the axis and the limit that is not finite or not above 0.
///
/// ```
/// use nalgebra::Vector2;
/// let limits = arcfeed_sync::symmetric_limits(Vector2::new(2.0, 1.0), Vector2::repeat(10.0), Vector2::repeat(200.0))?;
/// assert_eq!((limits[1].v_min(), limits[1].v_max()), (-1.0, 1.0));
/// # Ok::<(), arcfeed_sync::SyncError>(())
/// ```
pub fn symmetric_limits<const N: usize>(
    velocity: SVector<f64, N>,
    acceleration: SVector<f64, N>,
    jerk: SVector<f64, N>,
) -> Result<[AxisLimits; N], SyncError> {
    let named = [("velocity limit", &velocity), ("acceleration limit", &acceleration), ("jerk limit", &jerk)];
    for (what, bounds) in named {
        for (axis, &value) in bounds.iter().enumerate() {
            if !(value.is_finite() && value > 0.0) {
                return Err(SyncError::Axis { axis, what, value, rule: "finite and greater than 0" });
            }
        }
    }
    Ok(std::array::from_fn(|k| {
        AxisLimits::symmetric(velocity[k], acceleration[k], jerk[k])
            .unwrap_or_else(|_| unreachable!("the numbers have been checked"))
    }))
}

/// Returns an error naming the first axis whose limits differ in the two directions.
pub(crate) fn check_symmetric<const N: usize>(limits: &[AxisLimits; N]) -> Result<(), SyncError> {
    limits
        .iter()
        .enumerate()
        .try_for_each(|(axis, limits)| limits.check_symmetric().map_err(|source| SyncError::State { axis, source }))
}
