//! Continuous acceleration across segments.

use super::Segment;
use crate::error::FeedError;
use crate::plan::SpeedPlan;

/// Placeholder.
pub fn plan_joined(segments: &[Segment], v_start: f64, v_end: f64) -> Result<SpeedPlan, FeedError> {
    super::segment::plan_per_segment(segments, v_start, v_end)
}
