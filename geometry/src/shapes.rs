//! Straight lines, polylines and circular arcs as exact curves.

use std::f64::consts::{FRAC_PI_2, TAU};

use nalgebra::{Isometry3, Point3, SVector, Vector2, vector};

use crate::chord::check_positive;
use crate::error::GeometryError;
use crate::nurbs::{NurbsCurve, check_points};

impl<const D: usize> NurbsCurve<D> {
    /// The straight line from `a` to `b`; its parameter is the length along it.
    ///
    /// # Errors
    /// Fails when the points coincide or are not finite.
    pub fn line(a: SVector<f64, D>, b: SVector<f64, D>) -> Result<Self, GeometryError> {
        Self::polyline(vec![a, b])
    }

    /// The polyline through `points` (degree 1); its parameter is the length along it.
    ///
    /// ```
    /// use arcfeed_geometry::{Curve, NurbsCurve, nalgebra::vector};
    ///
    /// let corner = NurbsCurve::polyline(vec![vector![0.0, 0.0], vector![2.0, 0.0], vector![2.0, 1.0]])?;
    /// assert_eq!(corner.domain(), (0.0, 3.0));
    /// assert_eq!(corner.point(2.5), vector![2.0, 0.5]);
    /// # Ok::<(), arcfeed_geometry::GeometryError>(())
    /// ```
    ///
    /// # Errors
    /// Fails when there are fewer than 2 points, one is not finite, or two consecutive ones coincide or are closer together
    /// than the parameter resolves ([`GeometryError::KnotsTooClose`], 1e-12 of the length).
    pub fn polyline(points: Vec<SVector<f64, D>>) -> Result<Self, GeometryError> {
        if points.len() < 2 {
            return Err(GeometryError::TooFewDataPoints { points: points.len(), needed: 2 });
        }
        check_points("point", &points)?;
        let mut knots = Vec::with_capacity(points.len() + 2);
        let mut length = 0.0;
        knots.extend([0.0, 0.0]);
        for (index, pair) in points.windows(2).enumerate() {
            let distance = (pair[1] - pair[0]).norm();
            // The second condition: a step so short that it is lost in the length so far.
            if distance == 0.0 || length + distance == length {
                return Err(GeometryError::DuplicatePoints { index, distance });
            }
            length += distance;
            knots.push(length);
        }
        knots.push(length);
        Self::bspline(1, points, knots)
    }
}

impl NurbsCurve<2> {
    /// The circular arc about `centre` that starts at the angle `start` from the x axis and sweeps the angle `sweep`
    /// (rad, positive to the left, at most a full turn), as an exact rational curve of degree 2 over [0, 1].
    ///
    /// # Errors
    /// Fails when the radius is not above 0, the sweep is 0 or more than a full turn, or a number is not finite.
    pub fn arc(centre: Vector2<f64>, radius: f64, start: f64, sweep: f64) -> Result<Self, GeometryError> {
        check_points("centre", &[centre])?;
        let (points, weights, knots) = unit_arc(radius, start, sweep)?;
        Self::new(2, points.into_iter().map(|p| centre + p * radius).collect(), weights, knots)
    }

    /// The full circle about `centre`, from the x axis on to the left.
    ///
    /// # Errors
    /// As [`NurbsCurve::<2>::arc`].
    pub fn circle(centre: Vector2<f64>, radius: f64) -> Result<Self, GeometryError> {
        Self::arc(centre, radius, 0.0, TAU)
    }
}

impl NurbsCurve<3> {
    /// The circular arc about the origin of `frame` in its xy plane: it starts at the angle `start` from the frame's x
    /// axis and sweeps the angle `sweep` about its z axis (rad, at most a full turn). Exact, of degree 2, over [0, 1].
    ///
    /// # Errors
    /// As [`NurbsCurve::<2>::arc`].
    pub fn arc(frame: &Isometry3<f64>, radius: f64, start: f64, sweep: f64) -> Result<Self, GeometryError> {
        let (points, weights, knots) = unit_arc(radius, start, sweep)?;
        let place = |p: Vector2<f64>| (frame * Point3::from(p.push(0.0) * radius)).coords;
        Self::new(2, points.into_iter().map(place).collect(), weights, knots)
    }

    /// The full circle about the origin of `frame` in its xy plane, from its x axis on about its z axis.
    ///
    /// # Errors
    /// As [`NurbsCurve::<2>::arc`].
    pub fn circle(frame: &Isometry3<f64>, radius: f64) -> Result<Self, GeometryError> {
        Self::arc(frame, radius, 0.0, TAU)
    }
}

/// Control points, weights and knots of an arc of the unit circle, in pieces of a quarter turn at most (Piegl and
/// Tiller, "The NURBS Book", section 7.5).
#[allow(clippy::type_complexity)]
fn unit_arc(radius: f64, start: f64, sweep: f64) -> Result<(Vec<Vector2<f64>>, Vec<f64>, Vec<f64>), GeometryError> {
    check_positive("radius", radius)?;
    if !start.is_finite() {
        return Err(GeometryError::ArcAngle { what: "start angle", value: start });
    }
    // A few units in the last place above 2 pi still mean a full turn.
    if sweep.is_nan() || sweep == 0.0 || sweep.abs() > TAU * (1.0 + 1e-14) {
        return Err(GeometryError::ArcAngle { what: "sweep", value: sweep });
    }
    let pieces = ((sweep.abs() / FRAC_PI_2 - 1e-13).ceil() as usize).max(1);
    let half = 0.5 * sweep / pieces as f64;
    let on_circle = |angle: f64| vector![angle.cos(), angle.sin()];
    let mut points = vec![on_circle(start)];
    let mut weights = vec![1.0];
    let mut knots = vec![0.0; 3];
    for i in 0..pieces {
        let middle = start + (2 * i + 1) as f64 * half;
        points.extend([on_circle(middle) / half.cos(), on_circle(middle + half)]);
        weights.extend([half.cos(), 1.0]);
        knots.extend([(i + 1) as f64 / pieces as f64; 2]);
    }
    knots.push(1.0);
    if (sweep.abs() - TAU).abs() <= 1e-14 * TAU {
        // Exactly closed.
        let last = points.len() - 1;
        points[last] = points[0];
    }
    Ok((points, weights, knots))
}
