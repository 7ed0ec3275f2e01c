//! Whether a step from one sample to the next is possible within limits, by arithmetic of its own.

use arcfeed_sync::feedrate::{AxisLimits, AxisState};

/// How much of a limit the differences of samples may use for a step to count as within it.
const FULL: f64 = 1.0 + 1e-6;

/// Whether a state is within its limits, but for a part of them, and can stay there.
pub fn stays_inside(s: &AxisState, l: &AxisLimits, slack: f64) -> bool {
    let within = |x: f64, lo: f64, hi: f64| lo * (1.0 + slack) <= x && x <= hi * (1.0 + slack);
    let later = velocity_at_zero_acceleration(s, l);
    within(s.v, l.v_min(), l.v_max()) && within(s.a, l.a_min(), l.a_max()) && within(later, l.v_min(), l.v_max())
}

/// The velocity once the largest jerk has brought the acceleration to zero.
pub fn velocity_at_zero_acceleration(s: &AxisState, l: &AxisLimits) -> f64 {
    let time = if s.a > 0.0 { -s.a / l.j_min() } else { -s.a / l.j_max() };
    s.v + 0.5 * time * s.a
}

/// The precision asked for: the part of a limit that may be exceeded, and the size of the positions.
#[derive(Debug, Clone, Copy)]
pub struct Precision {
    pub slack: f64,
    pub size: f64,
}

/// The first limit that a step of `dt` seconds breaks, and how much of it is used. A step that begins inside, but for the slack, must
/// stay there.
///
/// With the jerk between -J and J the trapezoid of the velocities differs from the change of position by J dt³ / 12 at most, that
/// of the accelerations from the change of velocity by J dt² / 4. Any jump is more than that.
pub fn broken(
    from: &AxisState,
    to: &AxisState,
    dt: f64,
    l: &AxisLimits,
    precision: Precision,
) -> Option<(&'static str, f64)> {
    let Precision { slack, size } = precision;
    let jerk = l.j_max().max(-l.j_min());
    let sum = |x: f64, y: f64| x.abs() + y.abs();
    let off = (to.p - from.p - 0.5 * dt * (from.v + to.v)).abs();
    let most =
        jerk * dt * dt * dt / 12.0 + 1e-14 * (1.0 + size.max(sum(from.p, to.p))) + 1e-13 * dt * sum(from.v, to.v);
    let position = off / most;
    let off = (to.v - from.v - 0.5 * dt * (from.a + to.a)).abs();
    let most = jerk * dt * dt / 4.0 + 1e-14 * (1.0 + sum(from.v, to.v)) + 1e-13 * dt * sum(from.a, to.a);
    let velocity = off / most;
    let change = to.a - from.a;
    let left = (change.abs() - 1e-14 * (1.0 + sum(from.a, to.a))).max(0.0) / dt;
    let mean_jerk = if change > 0.0 { left / l.j_max() } else { -left / l.j_min() };
    let mut all = [
        ("a jump of the position", position, FULL),
        ("a jump of the velocity", velocity, FULL),
        ("jerk", mean_jerk, FULL),
        ("velocity", (to.v / l.v_max()).max(to.v / l.v_min()), 1.0 + 2.0 * slack),
        ("acceleration", (to.a / l.a_max()).max(to.a / l.a_min()), 1.0 + 2.0 * slack),
        ("bound to exceed its velocity", if stays_inside(to, l, 2.0 * slack) { 0.0 } else { 2.0 }, 1.0),
    ];
    if !stays_inside(from, l, slack) {
        all[3..].iter_mut().for_each(|x| x.1 = 0.0);
    }
    all.into_iter().find(|(_, used, most)| used.is_nan() || used > most).map(|(what, used, _)| (what, used))
}
