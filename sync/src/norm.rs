//! Limits on the speed and acceleration of a point whose coordinates are axes.

use arcfeed_feedrate::AxisLimits;

use crate::error::SyncError;
#[cfg(not(feature = "std"))]
use num_traits::Float;

/// The least share of an axis, relative to the largest that one axis can have.
const LEAST_SHARE: f64 = 0.2;

/// Bounds on speed and acceleration of a point: the norms of the vectors that some of the axes form.
///
/// The norms are kept by limits of the single axes: every axis of the point gets a share `w` of the
/// bound, and the squares of the shares sum to 1. Every motion inside these limits keeps the
/// norms at all times, whatever the axes do. That is conservative:
///
/// * [`NormLimits::limits`] gives equal shares. Of `n` axes that move together, one alone reaches
///   `1 / sqrt(n)` of the bound (0.58 for three axes), and a straight diagonal all of it. No
///   direction is worse than one axis alone.
/// * [`NormLimits::limits_along`] gives shares for one direction, in which a straight motion reaches
///   at least `1 / sqrt(1 + 0.04 (n - 1))` of the bound: 0.96 for three axes. An axis across that
///   direction has 0.19 to 0.2 of it.
///
/// Jerk is not bounded by a norm. A motion that begins outside the limits keeps the norms only once
/// every axis is inside: with shares that change from target to target let the motion come to rest
/// before, or keep to equal shares.
///
/// ```
/// use arcfeed_sync::feedrate::{AxisLimits, AxisState};
/// use arcfeed_sync::{NormLimits, OnlineGenerator, Synchronisation};
/// let axes = [AxisLimits::symmetric(2.0, 10.0, 100.0)?; 3];
/// // The tool moves at 1 m/s at most.
/// let norm = NormLimits::new(&[0, 1, 2], 1.0, 5.0)?;
/// let rest = [AxisState::rest(0.0); 3];
/// let mut generator =
///     OnlineGenerator::new(rest, norm.limits_along(&axes, &[2.0, 1.0, 0.0])?, 1e-3, Synchronisation::Time)?;
/// generator.set_target([2.0, 1.0, 0.0].map(AxisState::rest))?;
/// let mut fastest = 0.0_f64;
/// loop {
///     let step = generator.step();
///     fastest = fastest.max(step.state.qd.norm());
///     if step.events.reached {
///         break;
///     }
/// }
/// assert!(fastest <= 1.0 && fastest > 0.96);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NormLimits<const N: usize> {
    axes: [bool; N],
    speed: f64,
    acceleration: f64,
}

impl<const N: usize> NormLimits<N> {
    /// Bounds on the speed (1/s) and the acceleration (1/s²) of the point that `axes`, by index,
    /// form.
    ///
    /// # Errors
    /// [`SyncError::NoSuchAxis`]; [`SyncError::Tool`] naming a bound that is not finite or not above
    /// 0, or the number of axes if there is none.
    pub fn new(axes: &[usize], speed: f64, acceleration: f64) -> Result<Self, SyncError> {
        for (what, value) in [
            ("speed limit", speed),
            ("acceleration limit", acceleration),
            ("number of axes of the point", axes.len() as f64),
        ] {
            if !(value.is_finite() && value > 0.0) {
                return Err(SyncError::Tool { what, value, rule: "finite and greater than 0" });
            }
        }
        let mut all = [false; N];
        for &axis in axes {
            *all.get_mut(axis).ok_or(SyncError::NoSuchAxis { axis, count: N })? = true;
        }
        Ok(Self { axes: all, speed, acceleration })
    }

    /// Limits of the axes that keep the norms, with equal shares. Limits that are lower already stay.
    ///
    /// # Errors
    /// [`SyncError::State`] naming an axis that cannot be given its share: one whose limits are those of a forward motion
    /// ([`AxisLimits::forward`], `v_min` is 0), with which no motion to a target can be planned either, or whose share is too small a
    /// number. Give such an axis limits in both directions, or use larger units.
    pub fn limits(&self, limits: &[AxisLimits; N]) -> Result<[AxisLimits; N], SyncError> {
        self.shared(limits, [1.0; N])
    }

    /// Limits of the axes that keep the norms, with shares for a straight motion along `direction`,
    /// of any length; a direction that is zero or not finite counts as equal shares.
    ///
    /// # Errors
    /// As [`NormLimits::limits`].
    pub fn limits_along(&self, limits: &[AxisLimits; N], direction: &[f64; N]) -> Result<[AxisLimits; N], SyncError> {
        let length = self.norm(direction);
        if !(length.is_finite() && length > 0.0) {
            return self.limits(limits);
        }
        self.shared(limits, direction.map(|x| (x.abs() / length).max(LEAST_SHARE)))
    }

    /// The norm of the vector of the point's axes.
    fn norm(&self, vector: &[f64; N]) -> f64 {
        let largest = self.of_point(vector).fold(0.0, |m: f64, x| m.max(x.abs()));
        let sum: f64 = self.of_point(vector).map(|x| (x / largest).powi(2)).sum();
        largest * sum.sqrt()
    }

    fn of_point(&self, vector: &[f64; N]) -> impl Iterator<Item = f64> {
        vector.iter().zip(&self.axes).filter(|(_, is_one)| **is_one).map(|(x, _)| *x)
    }

    fn shared(&self, limits: &[AxisLimits; N], shares: [f64; N]) -> Result<[AxisLimits; N], SyncError> {
        let all = self.norm(&shares) * ROUND_UP;
        let mut lowered = *limits;
        for (axis, l) in lowered.iter_mut().enumerate().filter(|(axis, _)| self.axes[*axis]) {
            let [v, a] = [self.speed, self.acceleration].map(|bound| bound * shares[axis] / all);
            let inside = |(lower, upper): (f64, f64), most: f64| (lower.max(-most), upper.min(most));
            let velocity = inside((l.v_min(), l.v_max()), v);
            let acceleration = inside((l.a_min(), l.a_max()), a);
            *l = AxisLimits::new(velocity, acceleration, (l.j_min(), l.j_max()))
                .map_err(|source| SyncError::State { axis, source })?;
        }
        Ok(lowered)
    }
}

/// More than what round-off and the slack of limits add to a norm.
const ROUND_UP: f64 = 1.0 + 1e-12;
