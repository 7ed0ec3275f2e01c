//! The fraction of each limit that a plan may use.

use arcfeed_feedrate::{LimitId, Quantity};
use arcfeed_kinematics::Joints;

/// A part of the path with less of one limit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct LoweredStretch {
    pub limit: LimitId,
    /// Values of the path's parameter.
    pub from: f64,
    pub to: f64,
    pub factor: f64,
}

/// The fractions of the limits that a plan may use: 1, or less for those that the verification found exceeded between the points of
/// the grid.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct LimitFractions {
    lowered: Vec<(LimitId, f64)>,
    /// Parts of the path with less of one limit.
    stretches: Vec<LoweredStretch>,
    /// The fraction of every limit, beside those that are lowered.
    all: f64,
}

impl Default for LimitFractions {
    /// All of every limit.
    fn default() -> Self {
        Self::uniform(1.0)
    }
}

impl LimitFractions {
    /// The fraction `used` of every limit.
    pub fn uniform(used: f64) -> Self {
        Self { lowered: Vec::new(), stretches: Vec::new(), all: used }
    }

    /// The fraction of one limit.
    pub fn of(&self, limit: LimitId) -> f64 {
        let own = self.lowered.iter().find(|(known, _)| *known == limit).map_or(1.0, |(_, fraction)| *fraction);
        own * self.all
    }

    /// The fraction of a limit of the tool.
    pub fn tool(&self, quantity: Quantity) -> f64 {
        self.of(LimitId::path(quantity))
    }

    /// The fractions of the limits of all joints.
    pub fn joints<const N: usize>(&self, quantity: Quantity) -> Joints<N> {
        Joints::from_fn(|j, _| self.of(LimitId::joint(quantity, j)))
    }

    /// Lowers one limit by `factor` more.
    pub fn lower(&mut self, limit: LimitId, factor: f64) {
        match self.lowered.iter_mut().find(|(known, _)| *known == limit) {
            Some((_, fraction)) => *fraction *= factor,
            None => self.lowered.push((limit, factor)),
        }
    }

    /// Lowers all limits by `factor` more.
    pub fn lower_all(&mut self, factor: f64) {
        self.all *= factor;
    }

    /// The fraction of every limit, beside those that are lowered.
    pub fn everywhere(&self) -> f64 {
        self.all
    }

    /// Lowers one limit by `factor` more between two values of the path's parameter.
    pub fn lower_between(&mut self, limit: LimitId, [from, to]: [f64; 2], factor: f64) {
        self.stretches.push(LoweredStretch { limit, from, to, factor });
    }

    /// The parts of the path with less of one limit; where some of the same limit overlap, their factors multiply.
    pub fn stretches(&self) -> &[LoweredStretch] {
        &self.stretches
    }

    /// The limits that are lowered, with their fractions where these are least.
    pub fn lowered(&self) -> Vec<(LimitId, f64)> {
        let mut lowered = self.lowered.clone();
        let mut ends: Vec<(f64, bool, &LoweredStretch)> =
            self.stretches.iter().flat_map(|one| [(one.from, false, one), (one.to, true, one)]).collect();
        // A stretch that starts where another one ends overlaps it.
        ends.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        // What the stretches at a place make of each limit, and the least of it so far.
        let mut along: Vec<(LimitId, f64, f64)> = Vec::new();
        for (_, ends, one) in ends {
            let i = along.iter().position(|(known, ..)| *known == one.limit).unwrap_or(along.len());
            if i == along.len() {
                along.push((one.limit, 1.0, 1.0));
            }
            let (_, now, least) = &mut along[i];
            *now = if ends { *now / one.factor } else { *now * one.factor };
            *least = least.min(*now);
        }
        for (limit, _, least) in along {
            match lowered.iter_mut().find(|(known, _)| *known == limit) {
                Some((_, own)) => *own *= least,
                None => lowered.push((limit, least)),
            }
        }
        lowered
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use arcfeed_feedrate::Quantity;

    #[test]
    fn the_least_fraction_is_that_of_stretches_at_one_place() {
        let (one, other) = (LimitId::joint(Quantity::JointJerk, 0), LimitId::joint(Quantity::JointJerk, 1));
        let mut fractions = LimitFractions::default();
        fractions.lower(one, 0.5);
        for (limit, between, factor) in
            [(one, [0.0, 10.0], 0.9), (one, [1.0, 2.0], 0.9), (one, [8.0, 9.0], 0.8), (other, [0.0, 10.0], 0.7)]
        {
            fractions.lower_between(limit, between, factor);
        }
        let lowered = fractions.lowered();
        let of = |limit| lowered.iter().find(|(known, _)| *known == limit).expect("lowered").1;
        // Not 0.9 * 0.9 * 0.8: the second and the third do not overlap.
        assert!((of(one) - 0.5 * 0.9 * 0.8).abs() < 1e-12 && (of(other) - 0.7).abs() < 1e-12, "{lowered:?}");
    }
}
