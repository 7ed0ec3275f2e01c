//! Segmentation by the hull bound: Actuators 2024, 13, 108, algorithm 1.

use super::cutter::Cutter;
use crate::error::GeometryError;

/// Halves every Bezier piece until its control points lie within the tolerance of the chord.
///
/// The distance is taken to the chord itself, not to the line through it: in print a loop could pass.
pub(super) fn cut<const D: usize>(cutter: &mut Cutter<'_, D>) -> Result<(), GeometryError> {
    for index in 0..cutter.beziers.len() {
        let (u0, u1) = cutter.beziers[index].interval();
        cutter.halve(index, u0, u1, true)?;
    }
    Ok(())
}
