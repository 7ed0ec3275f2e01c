//! Tool paths as pure shape: NURBS curves, their arc length, and the orientation of the tool along them. No time, no
//! robot.
//!
//! # The problem
//!
//! A tool path arrives as a curve `C(u)` (CAD, G-code, fitted points) with a parameter that means nothing to a machine:
//! equal steps of `u` are unequal steps of the tool. A controller wants, at an arc length `s` it has chosen, the pose of the
//! tool and its derivatives by `s`; a planner wants to know where these derivatives jump and where the path has corners; a
//! controller that only knows straight lines wants few chords that stay within a tolerance. All of this is answered here,
//! to the last few digits of double precision, at sampling speed and without allocation after construction.
//!
//! # The rooms
//!
//! | you want | take |
//! |---|---|
//! | a curve | [`NurbsCurve::new`], [`NurbsCurve::bspline`], or a ready shape: `line`, `polyline`, `arc`, `circle` |
//! | a curve through points | `NurbsCurve::interpolate`, `NurbsCurve::approximate` (feature `fit`) |
//! | smooth curves through dense points of a machine program | `DenseFit`, `NurbsCurve::fit_dense` (feature `fit`) |
//! | point and derivatives by `u` | [`Curve::jet`], [`Jet::curvature`] |
//! | another form of the same curve | [`NurbsCurve::with_knot`], [`NurbsCurve::split`], [`NurbsCurve::elevated`], [`NurbsCurve::decompose`], ... |
//! | one path of lines, arcs, helices and curves | [`JoinedPathBuilder`], [`JoinedPath`] |
//! | its corners rounded within a tolerance | [`JoinedPath::blended`], [`Blending`] |
//! | the tool's orientation along it | [`JoinedPath::orientation`] |
//! | chords within a tolerance | [`NurbsCurve::segment`], [`SegmentationMethod`] |
//! | the length | [`NurbsCurve::arc_length`], [`NurbsCurve::arc_length_between`] |
//! | point and derivatives by arc length | [`ArcLengthCurve`] |
//! | the tool's orientation | [`OrientationPath`]: constant, from pose to pose, through keys, along the tangent |
//! | the tool's pose and derivatives by arc length | [`PosePath`] |
//! | the tool's way from pose to pose, turning on the spot included | [`PoseMotion`] |
//!
//! # Units and conventions
//!
//! * Curves keep the unit they are given in (m, or mm), and so do tolerances and lengths. [`PosePath`] and everything that
//!   goes on to a robot is in metres; angles are in rad.
//! * Control points are Cartesian, not multiplied by their weights; knot vectors are full (`points + degree + 1` entries).
//! * Parameters and arc lengths outside their range, NaN too, are taken to an end of it. At a knot, where derivatives may
//!   jump, `jet` gives those from the right and `jet_left` those from the left.
//! * Rotations map tool axes to base axes. A rate is a rotation vector per unit of length in base axes; in a [`PoseJet`]
//!   the rows are linear x y z, then angular x y z.
//! * What cannot be followed is an error at construction, never a NaN later: see [`GeometryError`].
//!
//! ```
//! use arcfeed_geometry::nalgebra::{UnitQuaternion, vector};
//! use arcfeed_geometry::{ArcLengthCurve, NurbsCurve, OrientationPath, PosePath};
//!
//! let curve = NurbsCurve::bspline(
//!     3,
//!     vec![vector![0.0, 0.0, 0.1], vector![0.1, 0.2, 0.1], vector![0.3, 0.2, 0.2], vector![0.4, 0.0, 0.1]],
//!     vec![0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0],
//! )?;
//! let curve = ArcLengthCurve::new(curve, 1e-12)?;
//! let tilted = UnitQuaternion::from_euler_angles(0.5, 0.0, 0.0);
//! let turning = OrientationPath::slerp(curve.length(), UnitQuaternion::identity(), tilted)?;
//! let path = PosePath::new(curve, turning);
//!
//! let middle = path.jet(0.5 * path.length());
//! assert!((middle.pose.rotation.angle() - 0.25).abs() < 1e-12);
//! assert!((middle.d1.fixed_rows::<3>(0).norm() - 1.0).abs() < 1e-12);
//! # Ok::<(), arcfeed_geometry::GeometryError>(())
//! ```
#![forbid(unsafe_code)]

pub use nalgebra;

mod arc_length;
#[cfg(feature = "fit")]
mod banded;
mod basis;
mod bezier;
mod chord;
mod curve;
#[cfg(feature = "fit")]
mod dense;
mod error;
#[cfg(feature = "fit")]
mod fit;
mod joined;
mod knots;
mod nurbs;
mod nurbs_edit;
mod orientation;
mod pieces;
mod pose_motion;
mod pose_path;
mod quadrature;
mod segmentation;
mod shapes;
mod span;
mod spline;

pub use arc_length::{ArcLengthCurve, Corner};
pub use basis::basis_functions;
pub use bezier::RationalBezier;
pub use chord::{ChordMeter, Deviation};
pub use curve::{Curve, Jet};
#[cfg(feature = "fit")]
pub use dense::{DenseFit, FittedStretch, StretchShape};
pub use error::GeometryError;
#[cfg(feature = "fit")]
pub use fit::{Fit, Spacing};
pub use joined::{
    ArcTo, BlendedPath, Blending, JoinedPath, JoinedPathBuilder, Joint, JointOutcome, KeptJoint, PathPiece, PieceKind,
};
pub use knots::KnotVector;
pub use nurbs::NurbsCurve;
pub use orientation::{Heading, OrientationJet, OrientationPath, Through};
pub use pose_motion::{MotionType, PathParameter, PoseMotion};
pub use pose_path::{PoseJet, PosePath};
pub use quadrature::{adaptive_gauss_legendre, gauss_legendre};
pub use segmentation::{MAX_SEGMENTS, Segmentation, SegmentationMethod};
