//! The result of a verification.

use arcfeed_feedrate::{LimitId, Quantity};

/// The worst place of a motion for one limit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Check {
    /// Which limit.
    pub id: LimitId,
    /// The value there, SI.
    pub value: f64,
    /// Its limit, SI.
    pub limit: f64,
    /// Value over limit: above 1 the limit is broken.
    pub ratio: f64,
    /// Value of the path's parameter there, m or rad.
    pub s: f64,
    /// Time, s.
    pub t: f64,
}

impl Check {
    /// The quantity that was checked.
    pub fn quantity(&self) -> Quantity {
        self.id.quantity
    }

    /// Which joint, from 0, where it is a joint's limit.
    pub fn joint(&self) -> Option<usize> {
        self.id.joint.map(usize::from)
    }
}

/// The intervals in which one limit binds: 99.9 % of its bound or more is used.
#[derive(Debug, Clone, PartialEq)]
pub struct Binding {
    /// Which limit.
    pub id: LimitId,
    /// From where to where, by the path's parameter, increasing.
    pub intervals: Vec<(f64, f64)>,
}

impl Binding {
    /// Length of all its intervals, in units of the parameter.
    pub fn length(&self) -> f64 {
        self.intervals.iter().map(|(a, b)| b - a).sum()
    }
}

/// A time during which a motion exceeds one limit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Excess {
    /// Which limit.
    pub id: LimitId,
    /// Times of its first and of its last sample, s.
    pub from: f64,
    pub until: f64,
    /// The largest ratio of value to limit.
    pub ratio: f64,
}

/// For every limit the place where a motion comes closest to it, and where limits bind.
#[derive(Debug, Clone, PartialEq)]
pub struct Verification {
    pub(super) checks: Vec<Check>,
    pub(super) bindings: Vec<Binding>,
    pub(super) excesses: Vec<Excess>,
    pub(super) samples: usize,
}

impl Verification {
    /// The worst place for each limit, joint by joint.
    pub fn checks(&self) -> &[Check] {
        &self.checks
    }

    /// The limits that bind somewhere, in the same order.
    pub fn bindings(&self) -> &[Binding] {
        &self.bindings
    }

    /// When the motion exceeds one limit.
    pub(crate) fn excesses(&self, id: LimitId) -> impl Iterator<Item = &Excess> {
        self.excesses.iter().filter(move |excess| excess.id == id)
    }

    /// The intervals in which one limit binds; empty if it does not.
    pub fn binding(&self, id: LimitId) -> &[(f64, f64)] {
        self.bindings.iter().find(|binding| binding.id == id).map_or(&[], |binding| &binding.intervals)
    }

    /// The check with the largest ratio; one that is not a number where nothing was checked.
    pub fn worst(&self) -> Check {
        let nothing = Check {
            id: LimitId::path(Quantity::Continuity),
            value: f64::NAN,
            limit: f64::NAN,
            ratio: f64::NAN,
            s: 0.0,
            t: 0.0,
        };
        let checks = self.checks.iter().copied();
        checks.reduce(|m, c| if c.ratio > m.ratio || c.ratio.is_nan() { c } else { m }).unwrap_or(nothing)
    }

    /// The check of one limit, where it was looked at.
    pub fn of(&self, id: LimitId) -> Option<&Check> {
        self.checks.iter().find(|check| check.id == id)
    }

    /// The check of one quantity with the largest ratio over all joints, where it was looked at.
    pub fn worst_of(&self, quantity: Quantity) -> Option<Check> {
        let of = self.checks.iter().copied().filter(|check| check.quantity() == quantity);
        of.reduce(|m, c| if c.ratio > m.ratio || c.ratio.is_nan() { c } else { m })
    }

    /// True where no ratio exceeds `1 + tolerance`.
    pub fn holds(&self, tolerance: f64) -> bool {
        // NaN does not hold, and neither does nothing.
        !self.checks.is_empty() && self.checks.iter().all(|check| check.ratio <= 1.0 + tolerance)
    }

    /// Number of setpoints looked at.
    pub fn samples(&self) -> usize {
        self.samples
    }
}
