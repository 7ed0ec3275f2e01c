//! Tool paths as pure shape: no time, no robot.
#![forbid(unsafe_code)]

pub use nalgebra;

mod arc_length;
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
mod orientation;
mod pose_path;
mod quadrature;
mod segmentation;
mod shapes;
mod spline;

pub use arc_length::{ArcLengthCurve, Corner};
pub use basis::basis_functions;
pub use bezier::RationalBezier;
pub use chord::{ChordMeter, Deviation};
pub use curve::{Curve, Jet};
pub use error::GeometryError;
#[cfg(feature = "fit")]
pub use fit::{Fit, Spacing};
pub use knots::KnotVector;
pub use nurbs::NurbsCurve;
pub use orientation::{Heading, OrientationJet, OrientationPath, Through};
pub use pose_path::{PoseJet, PosePath};
pub use quadrature::{adaptive_gauss_legendre, gauss_legendre};
pub use segmentation::{MAX_SEGMENTS, Segmentation, SegmentationMethod};
