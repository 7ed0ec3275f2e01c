//! The shortest change of speed and acceleration, wherever it ends.

use crate::limits::AxisLimits;

/// A stretch of constant jerk: how long, and the jerk.
pub(super) type Leg = (f64, f64);

/// From `(v, a)` to `to` with the largest jerk up, acceleration held at its limit, and the largest jerk back; mirrored if the speed has to
/// come down (Liu et al. 2024, eqs. 6, 7, 10 and 11, corrected, for either sign of everything). An acceleration
/// outside its limits is brought back first.
#[derive(Debug, Clone, Copy)]
pub(super) struct Change {
    pub legs: [Leg; 4],
    /// Displacement (m).
    pub length: f64,
}

impl Change {
    pub fn new((v, a): (f64, f64), to: (f64, f64), l: &AxisLimits) -> Self {
        let bound = a.min(l.a.1).max(l.a.0);
        let jerk = if a > bound { l.j.0 } else { l.j.1 };
        let t0 = (bound - a) / jerk;
        let (v0, a0) = (v + 0.5 * t0 * (a + bound), bound);

        // Going straight from one acceleration to the other changes the speed by this much.
        let single = 0.5 * (to.1 * to.1 - a0 * a0) / if to.1 >= a0 { l.j.1 } else { l.j.0 };
        let sign = if to.0 - v0 >= single { 1.0 } else { -1.0 };
        // In the frame in which the speed goes up: jerk `up` first, `down` at the end.
        let (up, down, cap) = if sign > 0.0 { (l.j.1, -l.j.0, l.a.1) } else { (-l.j.0, l.j.1, -l.a.0) };
        let (a1, a3) = (sign * a0, sign * to.1);
        let k = 0.5 / up + 0.5 / down;
        let square = (sign * (to.0 - v0) + 0.5 * a1 * (a1 / up) + 0.5 * a3 * (a3 / down)) / k;
        let free = square.max(0.0).sqrt().max(a1).max(a3);
        let peak = free.min(cap);
        let hold = if free > cap { k * (free - cap) * (free + cap) / cap } else { 0.0 };
        let legs = [
            (t0, jerk),
            ((peak - a1).max(0.0) / up, sign * up),
            (hold, 0.0),
            ((peak - a3).max(0.0) / down, -sign * down),
        ];
        let (mut p, mut v, mut a) = (0.0, v, a);
        for (dt, j) in legs {
            p += dt * (v + dt * (0.5 * a + dt * j / 6.0));
            v += dt * (a + 0.5 * dt * j);
            a += dt * j;
        }
        Self { legs, length: p }
    }
}
