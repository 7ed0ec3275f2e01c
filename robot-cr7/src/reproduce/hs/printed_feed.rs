//! The online feed rate of Liu et al. 2024, section 3, as printed and as corrected.
//!
//! Eqs. 2 to 16. As corrected: eqs. 3 and 4 use the largest velocity and acceleration and predict
//! with the jerk that ends the present acceleration; the acceleration of eq. 5 is reached with a
//! bounded jerk; the situation is chosen when limits change; the branch of the brake follows the
//! sign of ve - v; eqs. 14 to 16 start from v0 and s0.

use super::conditions::{END, START, TABLE_3, Window};

/// Which equations are taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scheme {
    /// As they stand in print.
    Printed,
    /// With the corrections.
    Corrected,
}

/// What a run of the scheme came to.
#[derive(Debug, Clone, PartialEq)]
pub struct FeedOutcome {
    /// Time, and position, velocity, acceleration.
    pub samples: Vec<(f64, [f64; 3])>,
    /// Whether the brake came to its end.
    pub arrived: bool,
}

impl FeedOutcome {
    /// Time and state of the last sample.
    pub fn last(&self) -> (f64, [f64; 3]) {
        self.samples.last().copied().unwrap_or((0.0, START))
    }
}

/// The three stages of a brake from `a` to the end state (eqs. 6, 7, 10, 11).
#[derive(Debug, Clone, Copy)]
struct Brake {
    first: f64,
    last: f64,
    total: f64,
    /// Jerk of the first and of the last stage.
    jerks: (f64, f64),
}

impl Brake {
    fn new(v: f64, a: f64, limit: f64, jerks: (f64, f64)) -> Self {
        let (ve, ae) = (END[1], END[2]);
        let (j1, j2) = jerks;
        let (first, last) = ((limit - a) / j1, (ae - limit) / j2);
        let total = (ve - v) / limit + first * (limit - a) / (2.0 * limit) + last * (limit - ae) / (2.0 * limit);
        if total - first - last > 0.0 {
            return Self { first, last, total, jerks };
        }
        let root = ((j2 - j1) * (a * a * j2 - j1 * (ae * ae + 2.0 * j2 * (v - ve)))).sqrt();
        let (first, last) = (-a / j1 + root / (j1 * (j1 - j2)), ae / j2 + root / (j2 * (j2 - j1)));
        Self { first, last, total: first + last, jerks }
    }

    /// Eqs. 8 and 12.
    fn length(&self, v: f64, a: f64) -> f64 {
        let (t, t1, t3) = (self.total, self.first, self.last);
        let bend = self.jerks.0 * t1 * (3.0 * t * t - 3.0 * t * t1 + t1 * t1) + self.jerks.1 * t3.powi(3);
        0.5 * a * t * t + bend / 6.0 + t * v
    }

    /// Eqs. 14 to 16, corrected.
    fn at(&self, t: f64, [s0, v0, a0]: [f64; 3]) -> [f64; 3] {
        let t = t.min(self.total);
        let early = t.min(self.first);
        let late = (t - (self.total - self.last)).max(0.0);
        let (j1, j2) = self.jerks;
        let after = t - early;
        let a = a0 + j1 * early + j2 * late;
        let v = v0 + a0 * t + 0.5 * j1 * early * early + j1 * early * after + 0.5 * j2 * late * late;
        let bend = early.powi(3) / 6.0 + 0.5 * early * early * after + 0.5 * early * after * after;
        [s0 + v0 * t + 0.5 * a0 * t * t + j1 * bend + j2 * late.powi(3) / 6.0, v, a]
    }
}

/// Runs the scheme over the way `length` (mm) with cycles of `period` (s), for at most `longest`
/// (s).
pub fn run(scheme: Scheme, length: f64, period: f64, longest: f64) -> FeedOutcome {
    let mut outcome = FeedOutcome { samples: vec![(0.0, START)], arrived: false };
    let (mut window, mut slow) = (&TABLE_3[0], START[1] <= TABLE_3[0].v.1);
    let (mut state, mut jerk) = (START, 0.0);
    for cycle in 0..(longest / period).round() as u32 {
        let t = period * f64::from(cycle);
        let now = TABLE_3.iter().rev().find(|w| w.from <= t + 0.5 * period).unwrap_or(&TABLE_3[0]);
        if now.from > window.from {
            (window, slow) = (now, state[1] <= now.v.1);
        }
        if scheme == Scheme::Printed {
            slow = START[1] <= window.v.1;
        }
        if let Some(brake) = brake_now(scheme, window, state, length) {
            let steps = (brake.total / period).ceil() as u32;
            outcome.samples.extend((1..steps).map(|i| f64::from(i) * period).map(|dt| (t + dt, brake.at(dt, state))));
            outcome.samples.push((t + brake.total, brake.at(brake.total, state)));
            outcome.arrived = true;
            break;
        }
        (state, jerk) = match scheme {
            Scheme::Printed => printed_cycle(window, slow, (state, jerk), period),
            Scheme::Corrected => corrected_cycle(window, slow, state, period),
        };
        outcome.samples.push((t + period, state));
    }
    outcome
}

fn brake_now(scheme: Scheme, w: &Window, [s, v, a]: [f64; 3], length: f64) -> Option<Brake> {
    let down = Brake::new(v, a, w.a.0, w.j);
    let up = Brake::new(v, a, w.a.1, (w.j.1, w.j.0));
    let chosen = match scheme {
        Scheme::Printed if up.length(v, a) > down.length(v, a) => up,
        Scheme::Printed => down,
        Scheme::Corrected if END[1] > v => up,
        Scheme::Corrected => down,
    };
    (chosen.length(v, a) > length - s).then_some(chosen)
}

/// Eqs. 2 to 5 to the letter: where eq. 5 has no row, the integrated acceleration stays.
fn printed_cycle(w: &Window, slow: bool, ([s, v, a], before): ([f64; 3], f64), ts: f64) -> ([f64; 3], f64) {
    let (rise, fall) = (v - a * a / (2.0 * w.j.0), v - a * a / (2.0 * w.j.1));
    let jerk = if slow {
        match (rise < w.v.0, a) {
            (true, a) if a < w.a.0 => w.j.1,
            (false, a) if a > 0.0 => w.j.0,
            _ => 0.0,
        }
    } else {
        match (fall > w.v.1, a) {
            (true, a) if a > w.a.0 => w.j.0,
            (false, a) if a < 0.0 => w.j.1,
            _ => 0.0,
        }
    };
    let mut next = a + 0.5 * ts * (before + jerk);
    if rise < w.v.1 && a >= w.a.1 {
        next = w.a.1;
    } else if fall > w.v.1 && a <= w.a.0 {
        next = w.a.0;
    } else if (rise >= w.v.1 && a <= 0.0) || (fall <= w.v.1 && a >= 0.0) {
        next = 0.0;
    }
    let speed = v + 0.5 * ts * (a + next);
    ([s + 0.5 * ts * (v + speed), speed, next], jerk)
}

fn corrected_cycle(w: &Window, slow: bool, [s, v, a]: [f64; 3], ts: f64) -> ([f64; 3], f64) {
    // The velocity at which the present acceleration ends.
    let coming = v - a * a / (2.0 * if a > 0.0 { w.j.0 } else { w.j.1 });
    let wanted = match (slow, coming < w.v.1) {
        (true, true) => w.a.1,
        (false, false) if coming > w.v.1 => w.a.0,
        _ => 0.0,
    };
    let jerk = ((wanted - a) / ts).max(w.j.0).min(w.j.1);
    let next = a + jerk * ts;
    let speed = v + 0.5 * ts * (a + next);
    ([s + 0.5 * ts * (v + speed), speed, next], jerk)
}
