//! The relations between two speeds and the displacement between them, with zero acceleration at
//! both.
//!
//! Liu et al. 2023, eqs. 17 and 18: one formula, since acceleration and braking mirror each other.
//! All roots are taken in a variable in which the function is monotone and of one curvature, so
//! that Newton's method closes in from one side; no tolerance is absolute.

use crate::error::{FeedError, not_negative};
use crate::limits::AxisLimits;
#[cfg(not(feature = "std"))]
use num_traits::Float;

/// [`Change`](super::closed_form::Change) between two zero accelerations under symmetric limits,
/// which the scans solve most. The two times of one acceleration leg: `ramp` for each jerk phase,
/// `hold` at constant acceleration.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Leg {
    pub ramp: f64,
    pub hold: f64,
}

impl Leg {
    /// The shortest leg that changes the speed by `dv >= 0`.
    #[inline]
    pub fn new(dv: f64, a_max: f64, j_max: f64) -> Self {
        let ramp = a_max / j_max;
        if dv <= a_max * ramp {
            Self { ramp: (dv / j_max).sqrt(), hold: 0.0 }
        } else {
            Self { ramp, hold: dv / a_max - ramp }
        }
    }

    #[inline]
    pub fn duration(&self) -> f64 {
        2.0 * self.ramp + self.hold
    }
}

/// Displacement a change of speed takes, acceleration 0 at both ends (unchecked).
#[inline]
pub(crate) fn distance(v0: f64, v1: f64, a_max: f64, j_max: f64) -> f64 {
    (0.5 * v0 + 0.5 * v1) * Leg::new((v1 - v0).abs(), a_max, j_max).duration()
}

/// Returns true if `length` suffices for a change of speed, up to the round-off that the two speeds
/// carry themselves.
#[inline]
pub(crate) fn fits(v0: f64, v1: f64, length: f64, a_max: f64, j_max: f64) -> bool {
    let dv = ((v1 - v0).abs() - 8.0 * f64::EPSILON * v0.max(v1)).max(0.0);
    (0.5 * v0 + 0.5 * v1) * Leg::new(dv, a_max, j_max).duration() <= length * (1.0 + 1e-12)
}

/// Displacement (m) that the fastest change from speed `v0` to `v1` takes, with zero acceleration
/// at both ends.
///
/// Liu et al. 2023, eqs. 17 and 18. The relation is symmetric in the two speeds. It is not monotone
/// in the lower one: braking to rest takes *less* distance than braking to a third of the speed.
///
/// # Errors
/// [`FeedError`] if a speed is negative or not finite.
pub fn distance_for_change(v0: f64, v1: f64, limits: &AxisLimits) -> Result<f64, FeedError> {
    limits.check_symmetric_acceleration()?;
    let d = distance(not_negative("v0", v0)?, not_negative("v1", v1)?, limits.a_max(), limits.j_max());
    if d.is_finite() { Ok(d) } else { Err(FeedError::OutOfRange { what: "displacement" }) }
}

/// Highest speed (m/s) reachable from `v0` over `length` (m) with zero acceleration at both ends,
/// `v_max` ignored.
///
/// The inverse of Liu et al. 2023, eq. 17; by symmetry also the highest speed from which `v0` can
/// be reached by braking.
///
/// # Errors
/// [`FeedError`] if an argument is negative or not finite.
pub fn highest_speed_over(v0: f64, length: f64, limits: &AxisLimits) -> Result<f64, FeedError> {
    limits.check_symmetric_acceleration()?;
    let v = raise(not_negative("v0", v0)?, not_negative("length", length)?, limits.a_max(), limits.j_max());
    if v.is_finite() { Ok(v) } else { Err(FeedError::OutOfRange { what: "speed" }) }
}

/// Lowest speed (m/s) reachable from `v0` over `length` (m) with zero acceleration at both ends.
///
/// The inverse of Liu et al. 2023, eq. 18. Since braking to rest takes less distance than braking
/// to a third of the speed, the answer jumps to 0 as soon as a full stop fits.
///
/// # Errors
/// [`FeedError`] if an argument is negative or not finite.
pub fn lowest_speed_over(v0: f64, length: f64, limits: &AxisLimits) -> Result<f64, FeedError> {
    limits.check_symmetric_acceleration()?;
    let (v0, length) = (not_negative("v0", v0)?, not_negative("length", length)?);
    Ok(lowest(v0, length, limits.a_max(), limits.j_max()))
}

#[inline]
pub(crate) fn lowest(v0: f64, length: f64, a_max: f64, j_max: f64) -> f64 {
    if distance(v0, 0.0, a_max, j_max) <= length { 0.0 } else { lower(v0, length, a_max, j_max) }
}

/// Highest speed reachable from `v0` over `length`.
#[inline]
pub(crate) fn raise(v0: f64, length: f64, a_max: f64, j_max: f64) -> f64 {
    let ramp = a_max / j_max;
    let q = a_max * ramp;
    if length >= (2.0 * v0 + q) * ramp {
        // (v0 + dv/2) (dv/a + a/j) = length, a quadratic in dv.
        let b = 2.0 * v0 + q;
        let d = 2.0 * v0 - q;
        let root = (d * d + 8.0 * a_max * length).sqrt();
        v0 + 4.0 * a_max * (length - v0 * ramp) / (root + b)
    } else {
        // y^3 + 2 v0 y = length sqrt(j), y = sqrt(dv): convex and increasing, so Newton descends
        // from an upper bound.
        let c = length * j_max.sqrt();
        if c <= 0.0 {
            return v0;
        }
        let mut y = c.cbrt();
        if v0 > 0.0 {
            y = y.min(c / (2.0 * v0));
        }
        for _ in 0..40 {
            let f = y * (y * y + 2.0 * v0) - c;
            let step = f / (3.0 * y * y + 2.0 * v0);
            y -= step;
            if step <= 1e-9 * y {
                // Convergence is quadratic: the next step would be below rounding.
                break;
            }
        }
        v0 + y * y
    }
}

/// Highest speed from which every speed between `v0` and it can be reached over `length`.
///
/// Braking takes the most length to a third of the speed, or to `a_max^2 / (2 j_max)` below the
/// lower one of two speeds that reach `a_max`. Unlike [`raise`], the result never falls when `v0`
/// rises.
#[cfg(feature = "std")]
pub(crate) fn raise_from_any(v0: f64, length: f64, a_max: f64, j_max: f64) -> f64 {
    let q = a_max * (a_max / j_max);
    // The speed to which braking from `v` takes longest.
    let worst = |v: f64| if v <= 1.5 * q { v / 3.0 } else { 0.5 * q };
    let v = raise(v0, length, a_max, j_max);
    if v0 >= worst(v) {
        return v;
    }
    // (4 v / 3) sqrt(2 v / (3 j)) = length, or (v + q / 2)^2 / (2 a) = length.
    let short = (0.75 * length * (1.5 * j_max).sqrt()).cbrt().powi(2);
    if short <= 1.5 * q { short } else { (2.0 * a_max * length).sqrt() - 0.5 * q }
}

/// Lowest speed reachable from `v0` over `length` without using the shorter way to a full stop: the
/// branch on which the reachable speed falls continuously from `v0`. 0 if the whole branch is
/// reachable.
pub(crate) fn lower(v0: f64, length: f64, a_max: f64, j_max: f64) -> f64 {
    let ramp = a_max / j_max;
    let q = a_max * ramp;
    if q < v0 && length >= (2.0 * v0 - q) * ramp {
        let disc = (2.0 * v0 + q) * (2.0 * v0 + q) - 8.0 * a_max * length;
        if disc < 0.0 {
            return 0.0;
        }
        let denominator = 2.0 * v0 - q + disc.sqrt();
        let dv = 4.0 * a_max * (length - v0 * ramp) / denominator;
        if dv >= q {
            return (v0 - dv).max(0.0);
        }
    }
    // 2 v0 y - y^3 = length sqrt(j), y = sqrt(dv): concave and increasing up to y^2 = 2 v0 / 3, so
    // Newton climbs towards the smaller root without passing it.
    let c = length * j_max.sqrt();
    let top = (2.0 / 3.0 * v0).min(q).sqrt();
    if c >= top * (2.0 * v0 - top * top) {
        return (v0 - top * top).max(0.0);
    }
    let mut y = c / (2.0 * v0);
    for _ in 0..60 {
        let f = c - y * (2.0 * v0 - y * y);
        let slope = 2.0 * v0 - 3.0 * y * y;
        if f <= 0.0 || slope <= 0.0 {
            break;
        }
        let step = f / slope;
        y = (y + step).min(top);
        if step <= 1e-9 * y {
            break;
        }
    }
    (v0 - y * y).max(0.0)
}

/// The cruise speed at which the two legs from `v0` and to `v1` together take `length`, at most
/// `v_max`.
///
/// Requires `distance(v0, v1) <= length`. The answer is rounded so that the legs do not take more
/// than `length` by more than rounding.
pub(crate) fn peak(v0: f64, v1: f64, length: f64, limits: &AxisLimits) -> f64 {
    let (a_max, j_max, v_max) = (limits.a_max(), limits.j_max(), limits.v_max());
    let total = |v: f64| distance(v0, v, a_max, j_max) + distance(v, v1, a_max, j_max);
    if total(v_max) <= length {
        return v_max;
    }
    let (low, high) = if v0 < v1 { (v0, v1) } else { (v1, v0) };
    if distance(low, high, a_max, j_max) >= length * (1.0 - 1e-12) {
        // One leg uses up the length, as it does wherever a speed was adjusted to it; cruising
        // takes what is left.
        return high;
    }
    let gap = high - low;
    let ramp = a_max / j_max;
    let q = a_max * ramp;

    // Both legs reach a_max: (v^2 - mean of squares) / a + ramp (v + mean) = length.
    if length >= total(high + q) {
        // v^2 + q v = a length + (v0^2 + v1^2) / 2 - q (v0 + v1) / 2
        let rhs = a_max * length + 0.5 * (v0 * v0 + v1 * v1) - 0.5 * q * (v0 + v1);
        let v = 2.0 * rhs / (q + (q * q + 4.0 * rhs).sqrt());
        return v.clamp(high, v_max);
    }
    // Otherwise in y = sqrt(v - high), in which both legs are smooth and increasing: Newton inside
    // a bracket, started from the root for two equal short legs or two long ones, whichever is
    // lower.
    let (mut lo_y, mut hi_y) = (0.0_f64, (v_max - high).sqrt());
    let c = 0.5 * length * j_max.sqrt();
    let mut y = c.cbrt().min(hi_y);
    if high > 0.0 {
        y = y.min(0.5 * c / high);
    }
    for _ in 0..60 {
        let d = y * y;
        let v = high + d;
        let (f0, g0) = leg_distance_dy(high, v, d, y, a_max, j_max);
        let (f1, g1) = leg_distance_dy(low, v, d + gap, y, a_max, j_max);
        let f = f0 + f1 - length;
        if f > 0.0 {
            hi_y = hi_y.min(y);
        } else {
            lo_y = lo_y.max(y);
        }
        let newton = y - f / (g0 + g1);
        let next = if newton >= lo_y && newton <= hi_y { newton } else { 0.5 * (lo_y + hi_y) };
        let step = (next - y).abs();
        y = next;
        if step <= 1e-9 * y {
            break;
        }
    }
    (high + y * y).clamp(high, v_max)
}

/// Displacement of the leg between `v_low` and `v = v_low + dv`, and its derivative by y where
/// dv/dy = 2 y.
#[inline]
fn leg_distance_dy(v_low: f64, v: f64, dv: f64, y: f64, a_max: f64, j_max: f64) -> (f64, f64) {
    let leg = Leg::new(dv, a_max, j_max);
    let t = leg.duration();
    // dt/dv = 1 / (peak acceleration): 1/(j ramp) in both cases; y cancels the square root for dv =
    // y^2.
    let peak_a = j_max * leg.ramp;
    let ratio = if peak_a > 0.0 { y / peak_a } else { 1.0 / j_max.sqrt() };
    ((0.5 * v_low + 0.5 * v) * t, y * t + (v_low + v) * ratio)
}
