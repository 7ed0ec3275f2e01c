//! One coordinate of the part of the motion that fades away: a brake to rest, wherever that is.

use arcfeed_feedrate::{MotionLaw, MotionLimits, MotionState, SpeedChange};

/// Ranges of velocity, acceleration and jerk over some time, zero included.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Ranges {
    pub v: (f64, f64),
    pub a: (f64, f64),
    pub j: (f64, f64),
}

fn widen(range: &mut (f64, f64), x: f64) {
    *range = (range.0.min(x), range.1.max(x));
}

/// A brake from velocity and acceleration to rest.
#[derive(Debug, Clone, Copy)]
pub(super) struct Fade(Option<SpeedChange>);

impl Fade {
    /// `None` if there is nothing to brake, or if the numbers leave the range of `f64`.
    pub fn new(v: f64, a: f64, a_max: f64, j_max: f64) -> Self {
        if v == 0.0 && a == 0.0 {
            return Self(None);
        }
        Self(MotionLimits::new(1.0, a_max, j_max).and_then(|l| SpeedChange::brake(v, a, &l)).ok())
    }

    /// Displacement up to the halt.
    pub fn length(&self) -> f64 {
        self.0.as_ref().map_or(0.0, SpeedChange::length)
    }

    pub fn duration(&self) -> f64 {
        self.0.as_ref().map_or(0.0, SpeedChange::duration)
    }

    #[inline]
    pub fn at(&self, t: f64) -> MotionState {
        self.0.as_ref().map_or(MotionState::default(), |brake| brake.at(t))
    }

    /// What velocity, acceleration and jerk still run through after time `t`.
    pub fn ranges_after(&self, t: f64) -> Ranges {
        let mut ranges = Ranges::default();
        let Some(brake) = &self.0 else { return ranges };
        let phases = brake.phases();
        for (i, phase) in phases.iter().enumerate() {
            let end = phases.get(i + 1).map_or(brake.duration(), |next| next.t);
            if end <= t || end <= phase.t {
                continue;
            }
            let (from, to) = ((t - phase.t).max(0.0), end - phase.t);
            let turn = -phase.a / phase.j;
            for x in [from, to, if turn > from && turn < to { turn } else { from }] {
                let s = phase.after(x);
                widen(&mut ranges.v, s.v);
                widen(&mut ranges.a, s.a);
            }
            widen(&mut ranges.j, phase.j);
        }
        ranges
    }
}
