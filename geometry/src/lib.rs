//! Tool paths as pure shape: no time, no robot.
#![forbid(unsafe_code)]

pub use nalgebra;

mod basis;
mod bezier;
mod chord;
mod curve;
mod decompose;
mod error;
mod knots;
mod nurbs;
mod segmentation;

pub use basis::basis_functions;
pub use bezier::RationalBezier;
pub use chord::{ChordMeter, Deviation};
pub use curve::{Curve, Jet};
pub use error::GeometryError;
pub use knots::KnotVector;
pub use nurbs::NurbsCurve;
pub use segmentation::{MAX_SEGMENTS, Segmentation, SegmentationMethod};
