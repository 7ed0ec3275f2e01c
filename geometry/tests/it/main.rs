//! Tests of curves, editing, arc length, orientation, segments and fits, in one binary.

mod arc_length;
mod close_knots;
mod common;
mod editing;
#[cfg(feature = "fit")]
mod fit;
mod oracle;
mod orientation;
mod pose_motion;
mod pose_path;
mod segmentation;

#[path = "common/close_knots.rs"]
mod close_knots_cases;
