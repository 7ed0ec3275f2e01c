//! The arc-length map: no step at all, a look-up.

use arcfeed_geometry::ArcLengthCurve;

use super::{FeedCycle, ParameterStep};

/// Looks `u(s)` up in the map of an [`ArcLengthCurve`]: the way the planner's own sampler goes.
#[derive(Debug, Clone)]
pub struct ArcLengthStep<'a> {
    curve: &'a ArcLengthCurve<3>,
}

impl<'a> ArcLengthStep<'a> {
    /// Uses the map of `curve`.
    pub fn new(curve: &'a ArcLengthCurve<3>) -> Self {
        Self { curve }
    }
}

impl ParameterStep for ArcLengthStep<'_> {
    fn name(&self) -> &'static str {
        "arc-length map"
    }

    fn step(&mut self, cycle: &FeedCycle) -> f64 {
        self.curve.parameter(cycle.s)
    }
}
