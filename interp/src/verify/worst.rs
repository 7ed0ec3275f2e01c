//! The worst place of one limit, and where it binds.

use arcfeed_feedrate::LimitId;

use super::check::{Binding, Check, Excess, Verification};
use crate::setpoint::Setpoint;

/// A limit binds where it is used to this part at the least.
const BINDS: f64 = 1.0 - 1e-3;

/// A limit is exceeded where it is used by more than this: twice of it is forgiven as rounding.
const EXCEEDED: f64 = 1.0 + 5e-7;
/// Excesses of one limit that are no further apart than this, s, are one.
const APART: f64 = 1e-3;
/// Stretches of one limit that are noted, at the most.
const MOST_STRETCHES: usize = 1000;

/// Place and time of a sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Moment {
    /// Value of the path's parameter, m or rad.
    pub s: f64,
    /// Time, s.
    pub t: f64,
}

impl Moment {
    /// For a motion without a path.
    pub fn at_time(t: f64) -> Self {
        Self { s: 0.0, t }
    }
}

impl<const N: usize> From<&Setpoint<N>> for Moment {
    fn from(at: &Setpoint<N>) -> Self {
        Self { s: at.s, t: at.t }
    }
}

/// Largest ratio found so far for one limit.
#[derive(Debug, Clone)]
pub(super) struct Worst {
    check: Check,
    intervals: Vec<(f64, f64)>,
    excesses: Vec<Excess>,
}

impl Worst {
    pub fn new(id: LimitId, limit: f64) -> Self {
        Self {
            check: Check { id, value: 0.0, limit, ratio: 0.0, s: 0.0, t: 0.0 },
            intervals: Vec::new(),
            excesses: Vec::new(),
        }
    }

    pub fn ratio(&self) -> f64 {
        self.check.ratio
    }

    pub fn see(&mut self, value: f64, at: impl Into<Moment>) {
        self.see_against(value, self.check.limit, at);
    }

    /// The same, for a limit that is not the same everywhere.
    pub fn see_against(&mut self, value: f64, limit: f64, at: impl Into<Moment>) {
        let at = at.into();
        let ratio = if value == 0.0 && !limit.is_nan() { 0.0 } else { value.abs() / limit };
        // A NaN, once seen, stays.
        if self.check.ratio.is_nan() {
            return;
        }
        if ratio > EXCEEDED {
            self.note(ratio, at);
        }
        // A check without a limit so far takes the first that it is given.
        if ratio > self.check.ratio || ratio.is_nan() || self.check.limit == f64::INFINITY {
            self.check = Check { value, limit, ratio, s: at.s, t: at.t, ..self.check };
        }
    }

    fn note(&mut self, ratio: f64, at: Moment) {
        let full = self.excesses.len() == MOST_STRETCHES;
        match self.excesses.last_mut().filter(|last| full || at.t - last.until <= APART) {
            Some(last) => (last.until, last.ratio) = (last.until.max(at.t), last.ratio.max(ratio)),
            None => self.excesses.push(Excess { id: self.check.id, from: at.t, until: at.t, ratio }),
        }
    }

    /// The same, noting where the limit binds; gaps of up to `gap` in the parameter do not count.
    pub fn see_binding(&mut self, value: f64, limit: f64, at: impl Into<Moment>, gap: f64) {
        let at = at.into();
        self.see_against(value, limit, at);
        if value.abs() >= BINDS * limit {
            match self.intervals.last_mut() {
                Some(last) if at.s - last.1 <= gap => last.1 = last.1.max(at.s),
                _ => self.intervals.push((at.s, at.s)),
            }
        }
    }

    pub fn check(&self) -> Check {
        self.check
    }

    pub fn binding(self) -> Option<Binding> {
        (!self.intervals.is_empty()).then_some(Binding { id: self.check.id, intervals: self.intervals })
    }
}

/// The result, from the worst places of all limits.
pub(super) fn sum_up(all: impl Iterator<Item = Worst>, samples: usize) -> Verification {
    // An infinite limit is none. What is not a number stays, whatever its limit.
    let mut all: Vec<Worst> = all.filter(|w| w.check.limit != f64::INFINITY || w.check.ratio.is_nan()).collect();
    if samples == 0 {
        // What nobody has looked at does not hold.
        all.iter_mut().for_each(|worst| worst.check.ratio = f64::NAN);
    }
    Verification {
        checks: all.iter().map(Worst::check).collect(),
        excesses: all.iter().flat_map(|worst| worst.excesses.iter().copied()).collect(),
        bindings: all.into_iter().filter_map(Worst::binding).collect(),
        samples,
    }
}
