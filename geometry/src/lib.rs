//! Tool paths as pure shape: no time, no robot.
#![forbid(unsafe_code)]

pub use nalgebra;

mod basis;
mod bezier;
mod chord;
mod curve;
mod decompose;
mod error;
#[cfg(feature = "fit")]
mod fit;
mod knots;
mod nurbs;
mod nurbs_edit;
mod segmentation;
mod shapes;

pub use basis::basis_functions;
pub use bezier::RationalBezier;
pub use chord::{ChordMeter, Deviation};
pub use curve::{Curve, Jet};
pub use error::GeometryError;
#[cfg(feature = "fit")]
pub use fit::{Fit, Spacing};
pub use knots::KnotVector;
pub use nurbs::NurbsCurve;
pub use segmentation::{MAX_SEGMENTS, Segmentation, SegmentationMethod};
