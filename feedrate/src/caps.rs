//! Bounds on speed, acceleration and jerk along a path that follow from its shape and from the
//! joints.
//!
//! The terms of Liu et al. 2023, algorithm 2, step 2.2, and eqs. 23 and 24, each as a pure
//! function. A bound that does not apply is `f64::INFINITY`, so the least of several is taken with
//! `min`. Invalid input (NaN, a negative limit) gives 0 or an empty interval, never NaN: what
//! cannot be judged must not move.

#[cfg(not(feature = "std"))]
use num_traits::Float;

/// An interval of admissible values; empty if `lo > hi`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Interval {
    /// Least admissible value.
    pub lo: f64,
    /// Greatest admissible value.
    pub hi: f64,
}

impl Interval {
    /// All real numbers.
    pub const ALL: Self = Self { lo: f64::NEG_INFINITY, hi: f64::INFINITY };
    /// No number at all.
    pub const EMPTY: Self = Self { lo: f64::INFINITY, hi: f64::NEG_INFINITY };

    /// Returns true if nothing is admissible.
    pub fn is_empty(&self) -> bool {
        self.lo > self.hi || self.lo.is_nan() || self.hi.is_nan()
    }

    /// The largest `b` with `[-b, b]` inside the interval; 0 if there is none.
    pub fn symmetric(&self) -> f64 {
        if self.is_empty() { 0.0 } else { self.hi.min(-self.lo).max(0.0) }
    }
}

/// A limit that is negative or NaN.
fn invalid(limit: f64) -> bool {
    limit.is_nan() || limit < 0.0
}

/// A bound that could not be evaluated counts as 0.
fn sound(bound: f64) -> f64 {
    if bound >= 0.0 { bound } else { 0.0 }
}

/// Highest speed (m/s) at which the chord between two samples `period` (s) apart deviates by at
/// most `tolerance` (m) from a circle of the given `curvature` (1/m).
///
/// `(2/T) sqrt(2 delta / kappa - delta^2)` (Liu et al. 2023, algorithm 2), which is exact on a
/// circle. For `kappa delta >= 1` the chord may be the diameter and no longer one exists: the bound
/// is `2 / (kappa T)`, where print yields values that fall again and, above 2, are not a number.
/// Infinite on a straight line.
pub fn chord_error_speed(curvature: f64, tolerance: f64, period: f64) -> f64 {
    let kappa = curvature.abs();
    if !(tolerance >= 0.0 && period > 0.0) || kappa.is_nan() {
        return 0.0;
    }
    if kappa == 0.0 {
        return f64::INFINITY;
    }
    let kd = kappa * tolerance;
    // In units of the radius, so that neither the square nor the quotient overflows before the
    // result does.
    let half_chord = if kd >= 1.0 { 1.0 } else { (kd * (2.0 - kd)).sqrt() };
    sound(2.0 * half_chord / kappa / period)
}

/// Highest speed (m/s) at which the normal acceleration `kappa v^2` stays within `a_normal` (m/s²).
pub fn normal_acceleration_speed(curvature: f64, a_normal: f64) -> f64 {
    let kappa = curvature.abs();
    if invalid(a_normal) || kappa.is_nan() {
        return 0.0;
    }
    if kappa == 0.0 { f64::INFINITY } else { sound((a_normal / kappa).sqrt()) }
}

/// Highest speed (m/s) at which the normal jerk `kappa^2 v^3` stays within `j_normal` (m/s³).
///
/// On a circle run at constant speed the third derivative of the position has the magnitude
/// `v^3 / r^2`, hence a cube root: `(J / kappa^2)^(1/3)`. Liu et al. 2023, algorithm 2, print a
/// square root, whose value is not a speed.
pub fn normal_jerk_speed(curvature: f64, j_normal: f64) -> f64 {
    let kappa = curvature.abs();
    if invalid(j_normal) || kappa.is_nan() {
        return 0.0;
    }
    if kappa == 0.0 { f64::INFINITY } else { sound((j_normal / kappa / kappa).cbrt()) }
}

/// Highest speed along the path at which every joint keeps its velocity limit: the least of
/// `qd_max_k / |q'_k|`.
///
/// Liu et al. 2023, eq. 23, divide a vector by a vector; each joint has its own bound. `dq` is the
/// derivative of the joint vector by the path coordinate (rad/m), `qd_max` the limits (rad/s).
/// Joints without an entry in both slices are not bounded.
pub fn joint_velocity_speed(dq: &[f64], qd_max: &[f64]) -> f64 {
    dq.iter().zip(qd_max).fold(f64::INFINITY, |least, (&d, &limit)| {
        let bound = if d == 0.0 && limit >= 0.0 { f64::INFINITY } else { sound(limit / d.abs()) };
        least.min(bound)
    })
}

/// Tangential accelerations at which every joint keeps its acceleration limit at speed `v`:
/// `|q'_k a + q''_k v^2| <= qdd_max_k` for all joints.
///
/// Liu et al. 2023, eq. 24, corrected: one bound per joint, and both signs (print gives one side of
/// the interval). Empty if `v` alone already breaks a limit.
pub fn joint_acceleration_interval(dq: &[f64], ddq: &[f64], qdd_max: &[f64], v: f64) -> Interval {
    dq.iter()
        .zip(ddq)
        .zip(qdd_max)
        .fold(Interval::ALL, |interval, ((&d, &dd), &limit)| intersect_row(interval, d, dd * v * v, limit))
}

/// Tangential jerks at which every joint keeps its jerk limit at speed `v` and tangential
/// acceleration `a`: `|q'_k j + 3 q''_k v a + q'''_k v^3| <= qddd_max_k` for all joints.
pub fn joint_jerk_interval(dq: &[f64], ddq: &[f64], dddq: &[f64], qddd_max: &[f64], v: f64, a: f64) -> Interval {
    dq.iter().zip(ddq).zip(dddq).zip(qddd_max).fold(Interval::ALL, |interval, (((&d, &dd), &ddd), &limit)| {
        intersect_row(interval, d, 3.0 * dd * v * a + ddd * v * v * v, limit)
    })
}

/// Intersects with `{ x : |slope x + offset| <= limit }`.
fn intersect_row(interval: Interval, slope: f64, offset: f64, limit: f64) -> Interval {
    if invalid(limit) || slope.is_nan() || offset.is_nan() {
        return Interval::EMPTY;
    }
    if slope == 0.0 {
        return if offset.abs() <= limit { interval } else { Interval::EMPTY };
    }
    let (x, y) = ((-limit - offset) / slope, (limit - offset) / slope);
    if x.is_nan() || y.is_nan() {
        return Interval::EMPTY;
    }
    Interval { lo: interval.lo.max(x.min(y)), hi: interval.hi.min(x.max(y)) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chord_of_a_circle_deviates_by_exactly_the_tolerance() {
        for kd in [1e-9_f64, 1e-4, 0.3, 0.9] {
            let (radius, period) = (0.02, 1e-3);
            let v = chord_error_speed(1.0 / radius, kd * radius, period);
            let angle = 2.0 * (0.5 * v * period / radius).asin();
            // r (1 - cos(angle / 2)), written without cancellation.
            let sagitta = 2.0 * radius * (0.25 * angle).sin().powi(2);
            assert!((sagitta / (kd * radius) - 1.0).abs() < 1e-9, "kd {kd}: {sagitta}");
        }
    }

    #[test]
    fn chord_never_exceeds_the_diameter() {
        for kd in [1.0, 1.5, 2.0, 2.16, 1e6] {
            assert_eq!(chord_error_speed(50.0, kd / 50.0, 1e-3), 2.0 / (50.0 * 1e-3));
        }
        assert_eq!(chord_error_speed(0.0, 1e-3, 1e-3), f64::INFINITY);
    }

    #[test]
    fn circle_at_the_cap_has_the_given_normal_acceleration_and_jerk() {
        // Position on a circle, differentiated by central differences in time.
        let (kappa, limit) = (40.0_f64, 3.0);
        let third = |v: f64| {
            let w = v * kappa;
            let h = 1e-2 / w;
            let x = |t: f64| (w * t).cos() / kappa;
            let y = |t: f64| (w * t).sin() / kappa;
            let d3 = |f: &dyn Fn(f64) -> f64| (f(2.0 * h) - 2.0 * f(h) + 2.0 * f(-h) - f(-2.0 * h)) / (2.0 * h * h * h);
            d3(&x).hypot(d3(&y))
        };
        assert!((third(normal_jerk_speed(kappa, limit)) / limit - 1.0).abs() < 1e-3);
        let v = normal_acceleration_speed(kappa, limit);
        assert!((v * v * kappa - limit).abs() < 1e-12);
    }

    #[test]
    fn joint_bounds_are_tight_and_safe() {
        let (dq, ddq, dddq) = ([0.5, -2.0, 0.0], [1.0, 3.0, -0.5], [0.2, -4.0, 1.0]);
        let (qd, qdd, qddd) = ([1.0, 1.0, 1.0], [2.0, 3.0, 4.0], [20.0, 30.0, 40.0]);
        assert_eq!(joint_velocity_speed(&dq, &qd), 0.5);
        let v = 0.4;
        let a = joint_acceleration_interval(&dq, &ddq, &qdd, v);
        let acc = |a: f64| (0..3).map(|k| (dq[k] * a + ddq[k] * v * v).abs() / qdd[k]).fold(0.0, f64::max);
        assert!((acc(a.lo) - 1.0).abs() < 1e-12 && (acc(a.hi) - 1.0).abs() < 1e-12);
        let j = joint_jerk_interval(&dq, &ddq, &dddq, &qddd, v, a.hi);
        let jerk = |j: f64| {
            (0..3)
                .map(|k| (dq[k] * j + 3.0 * ddq[k] * v * a.hi + dddq[k] * v * v * v).abs() / qddd[k])
                .fold(0.0, f64::max)
        };
        assert!((jerk(j.lo) - 1.0).abs() < 1e-12 && (jerk(j.hi) - 1.0).abs() < 1e-12);
        assert!(joint_acceleration_interval(&dq, &ddq, &qdd, 10.0).is_empty());
        assert_eq!(joint_acceleration_interval(&dq, &ddq, &qdd, 10.0).symmetric(), 0.0);
    }

    #[test]
    fn nothing_is_ever_not_a_number() {
        let odd = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, -1.0, 0.0, 1e-308, 1e308, 1.0];
        for a in odd {
            for b in odd {
                assert!(!normal_acceleration_speed(a, b).is_nan());
                assert!(!normal_jerk_speed(a, b).is_nan());
                assert!(!joint_velocity_speed(&[a], &[b]).is_nan());
                for c in odd {
                    assert!(!chord_error_speed(a, b, c).is_nan());
                    let i = joint_acceleration_interval(&[a], &[b], &[c], 1e3);
                    assert!(!i.lo.is_nan() && !i.hi.is_nan() && !i.symmetric().is_nan());
                    let i = joint_jerk_interval(&[a], &[b], &[c], &[1.0], 1e3, -2.0);
                    assert!(!i.lo.is_nan() && !i.hi.is_nan());
                }
            }
        }
    }
}
