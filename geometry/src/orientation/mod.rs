//! Tool orientation along a path: constant, through given orientations, or following the tangent.

mod heading;
mod keys;
mod rotation;

use nalgebra::{Unit, UnitQuaternion, Vector3};

pub use heading::Heading;
pub(crate) use keys::Stretch;
pub use keys::Through;
pub use rotation::OrientationJet;
pub(crate) use rotation::shorter_way;

use crate::arc_length::ArcLengthCurve;
use crate::error::GeometryError;

/// Orientation of the tool as a function of arc length.
#[derive(Debug, Clone)]
pub enum OrientationPath {
    /// The same orientation everywhere.
    Constant(UnitQuaternion<f64>),
    /// Through given orientations; see [`OrientationPath::through`].
    Through(Through),
    /// Turning about a fixed axis to follow the tangent; see [`OrientationPath::following_tangent`].
    Heading(Heading),
}

impl OrientationPath {
    /// Through the orientations `keys`, pairs of arc length and orientation with increasing arc length.
    ///
    /// Two keys give the spherical linear interpolation ("slerp") in step with `s`, on the shorter arc, with a constant
    /// angular rate. More keys give the rotational counterpart of a natural cubic spline: through every key, on the shorter
    /// way from one to the next, with a continuous angular acceleration, where a chain of slerps would have the rate jump.
    /// Before the first and after the last key the orientation goes on as the spline does.
    ///
    /// # Errors
    /// Fails when there are fewer than two keys, their arc lengths do not increase, or a quaternion is not finite.
    pub fn through(keys: &[(f64, UnitQuaternion<f64>)]) -> Result<Self, GeometryError> {
        if keys.len() < 2 {
            return Err(GeometryError::TooFewPoints { points: keys.len(), degree: 1 });
        }
        for (index, key) in keys.iter().enumerate() {
            let previous = if index > 0 { keys[index - 1].0 } else { f64::NEG_INFINITY };
            // Written so that NaN fails.
            if !(key.0.is_finite() && key.0 > previous) {
                let start = if index > 0 { previous } else { 0.0 };
                return Err(GeometryError::OrientationKey { index, value: key.0, start, end: f64::INFINITY });
            }
            if let Some(&value) = key.1.coords.iter().find(|x| !x.is_finite()) {
                return Err(GeometryError::QuaternionNotFinite { index, value });
            }
        }
        Ok(Self::Through(Through::new(keys)))
    }

    /// From `from` at the start of a path of length `length` to `to` at its end, in step with arc length (slerp).
    ///
    /// # Errors
    /// Fails when the length is not above 0.
    pub fn slerp(length: f64, from: UnitQuaternion<f64>, to: UnitQuaternion<f64>) -> Result<Self, GeometryError> {
        if !(length.is_finite() && length > 0.0) {
            return Err(GeometryError::NotPositive { what: "length", value: length });
        }
        Self::through(&[(0.0, from), (length, to)])
    }

    /// Turns the tool about the fixed `axis` (base axes) so that it follows the tangent of `curve`: with `start` as the
    /// orientation at the beginning of the path, the tool turns by as much as the tangent, seen along the axis, does.
    ///
    /// The angle is a cubic spline through the true heading, refined until it is within `tolerance` (rad) of it, so that
    /// angular acceleration is continuous even where the curvature of the path has kinks (at its knots).
    /// A tolerance out of reach of double precision, or of 100 000 knots, ends the refinement early; [`Heading::deviation`]
    /// tells what was reached.
    ///
    /// # Errors
    /// Fails when the tolerance is not above 0, the path runs along the axis somewhere, or it has a corner.
    pub fn following_tangent(
        curve: &ArcLengthCurve<3>,
        axis: Unit<Vector3<f64>>,
        start: UnitQuaternion<f64>,
        tolerance: f64,
    ) -> Result<Self, GeometryError> {
        if !(tolerance.is_finite() && tolerance > 0.0) {
            return Err(GeometryError::NotPositive { what: "tolerance", value: tolerance });
        }
        if let Some(corner) = curve.corners(tolerance).first() {
            return Err(GeometryError::HeadingJump { s: corner.s, angle: corner.angle });
        }
        Ok(Self::Heading(Heading::following(curve, axis, start, tolerance)?))
    }

    /// Orientation, rate and the rate's derivatives at the arc length `s`.
    #[inline]
    pub fn jet(&self, s: f64) -> OrientationJet {
        match self {
            Self::Constant(rotation) => OrientationJet {
                rotation: *rotation,
                rate: Vector3::zeros(),
                d_rate: Vector3::zeros(),
                dd_rate: Vector3::zeros(),
            },
            Self::Through(t) => t.jet(t.find(s), s),
            Self::Heading(h) => h.jet(s),
        }
    }

    /// Like [`OrientationPath::jet`], with the third derivative from the left where it jumps.
    pub fn jet_left(&self, s: f64) -> OrientationJet {
        match self {
            Self::Constant(_) => self.jet(s),
            Self::Through(t) => t.jet_left(s),
            Self::Heading(h) => h.jet_left(s),
        }
    }

    /// Moves knots that are within `tolerance` of one of `places` (sorted) onto it, so that both count as one.
    pub(crate) fn snap_knots(&mut self, places: &[f64], tolerance: f64) {
        if let Self::Through(through) = self {
            through.snap_knots(places, tolerance);
        }
    }

    /// Arc lengths where the third derivative of the orientation may jump.
    pub fn knots(&self) -> &[f64] {
        match self {
            Self::Constant(_) => &[],
            Self::Through(t) => t.knots(),
            Self::Heading(h) => h.knots(),
        }
    }
}
