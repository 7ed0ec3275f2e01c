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
        for one in &self.stretches {
            let overlapping = self
                .stretches
                .iter()
                .filter(|other| other.limit == one.limit && other.from <= one.to && one.from <= other.to);
            let everywhere = self.lowered.iter().find(|(known, _)| *known == one.limit).map_or(1.0, |(_, own)| *own);
            let fraction = everywhere * overlapping.map(|other| other.factor).product::<f64>();
            match lowered.iter_mut().find(|(known, _)| *known == one.limit) {
                Some((_, least)) => *least = least.min(fraction),
                None => lowered.push((one.limit, fraction)),
            }
        }
        lowered
    }
}
