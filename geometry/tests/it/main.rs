//! Tests of curves, editing, arc length, orientation, segments and fits, in one binary.

mod arc_length;
mod blend_shape;
mod blending;
mod clamped_ends;
mod close_knots;
mod common;
#[cfg(feature = "fit")]
mod dense;
mod editing;
#[cfg(feature = "fit")]
mod fit;
mod joined;
mod joined_orientation;
mod oracle;
mod orientation;
mod pose_motion;
mod pose_path;
mod segmentation;
mod standing;

#[path = "common/close_knots.rs"]
mod close_knots_cases;

#[global_allocator]
static ALLOCATOR: arcfeed_testing::Counting = arcfeed_testing::Counting;
