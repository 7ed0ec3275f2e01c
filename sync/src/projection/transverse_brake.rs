//! One coordinate of the motion across the line: a brake to rest, wherever that is.

use arcfeed_feedrate::{AxisLimits, MotionLaw, MotionState, SpeedChange};

/// Ranges of velocity, acceleration and jerk over some time, zero included, and a bound of the
/// displacement.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Ranges {
    /// Zero also where all coordinates that belong together keep to one direction. It does not
    /// shrink: what has been covered remains.
    pub p: f64,
    pub v: (f64, f64),
    pub a: (f64, f64),
    pub j: (f64, f64),
}

fn widen(range: &mut (f64, f64), x: f64) {
    *range = (range.0.min(x), range.1.max(x));
}

/// Limits of a brake.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct BrakeLimits {
    pub a: f64,
    pub j: f64,
    /// True if the coordinates that belong together all brake in proportion, so that their
    /// direction stays.
    pub in_proportion: bool,
}

/// A brake from velocity and acceleration to rest.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct TransverseBrake {
    brake: Option<SpeedChange>,
    /// Bound of the displacement; see [`Ranges::p`].
    reach: f64,
}

impl TransverseBrake {
    /// `None` if the limits leave nothing to brake with, or if the numbers leave the range of
    /// `f64`.
    pub fn new(v: f64, a: f64, limits: BrakeLimits) -> Option<Self> {
        if v == 0.0 && a == 0.0 {
            return Some(Self::default());
        }
        let brake = AxisLimits::symmetric(1.0, limits.a, limits.j).and_then(|l| SpeedChange::brake(v, a, &l)).ok()?;
        let (low, high) = (brake.lowest_speed(), brake.highest_speed());
        let reach = match limits.in_proportion {
            true => 0.0,
            // Without turning back it is farthest at the end.
            false if low >= 0.0 || high <= 0.0 => brake.length().abs(),
            false => brake.duration() * high.max(-low),
        };
        Some(Self { brake: Some(brake), reach })
    }

    /// Displacement up to the halt.
    pub fn length(&self) -> f64 {
        self.brake.as_ref().map_or(0.0, SpeedChange::length)
    }

    pub fn duration(&self) -> f64 {
        self.brake.as_ref().map_or(0.0, SpeedChange::duration)
    }

    #[inline]
    pub fn at(&self, t: f64) -> MotionState {
        self.brake.as_ref().map_or(MotionState::default(), |brake| brake.at(t))
    }

    /// The ranges of velocity, acceleration and jerk after time `t`.
    pub fn ranges_after(&self, t: f64) -> Ranges {
        let mut ranges = Ranges { p: self.reach, ..Ranges::default() };
        let Some(brake) = &self.brake else { return ranges };
        for (phase, dt) in brake.phases() {
            let from = (t - phase.t).max(0.0);
            if from >= dt {
                continue;
            }
            let turn = phase.turn(dt).filter(|turn| *turn > from);
            for x in [from, dt, turn.unwrap_or(from)] {
                let s = phase.after(x);
                widen(&mut ranges.v, s.v);
                widen(&mut ranges.a, s.a);
            }
            widen(&mut ranges.j, phase.j);
        }
        ranges
    }
}
