//! Curves through dense points: the G1 micro segments of machine programs.

mod corners;
mod element;
mod fitted;
mod junction;
mod march;
mod piece;
mod polyline;
mod primitive;
mod recognition;
mod stretch;
mod window;

use std::collections::VecDeque;

use nalgebra::SVector;

pub use fitted::{FittedStretch, StretchShape};

use crate::chord::check_positive;
use crate::error::GeometryError;
use crate::nurbs::NurbsCurve;
use corners::CornerFinder;
use polyline::Vertex;
use stretch::{Output, StretchFit};

/// Corners turn by more than this, in rad, unless [`DenseFit::with_corner_angle`] states another angle: 20 degrees.
const CORNER_ANGLE: f64 = 0.349_065_850_398_865_9;
/// Least tolerance, as a part of the size of the coordinates.
const LEAST_TOLERANCE: f64 = 1e-9;

/// A fit of smooth curves to the points of a polyline, as they arrive.
///
/// Machine programs come as up to a million points, with coordinates rounded to a micrometre. The fit divides
/// the polyline at its corners and lays a cubic B-spline with continuous curvature through each stretch between
/// two corners. No curve is farther than the tolerance from the polyline, anywhere: the bound is calculated from
/// the coefficients of the curve, and not from samples.
///
/// * **Corners.** A vertex is a corner where the polyline turns by more than an angle (20 degrees) and no curve
///   turns there so within the tolerance. The angle is measured over a distance of `8 tolerance / angle`, so
///   that the angles between short chords with rounded coordinates do not count.
/// * **Lines.** A chord that is far longer than its neighbours, or that an arc cannot replace within the
///   tolerance, is a straight line in its middle part. The curve continues it with continuous curvature.
/// * **Lines and arcs of many points.** A run of at least eight chords that lies on a line or on an arc within 0.6
///   tolerances, and that the polyline leaves soon at both ends, becomes that line or arc. Three cubic spans lead from
///   one to the next with continuous curvature, as long as the tolerance permits. Between two corners they are kept
///   where they are no more pieces than cubics alone; a polyline of more than some thousand points is compared in parts.
/// * **Spans.** The integral of the squared distance between curve and polyline is least, window by window.
///   Spans are as wide as the tolerance permits. A window starts with point and two derivatives of the one
///   before.
///
/// The time grows in proportion to the number of points. Some thousand points are kept until the curve ahead of
/// them is known, and at most some ten thousand (or those within 32 tolerances, if these are more). Curves come
/// out as soon as they are finished; a stretch of more than 8192 spans, or 1e7 times as long as its narrowest
/// span, comes out in several curves that continue each other.
///
/// The tolerance has to exceed the rounding of the coordinates and should be no less than two thirds of the
/// chord error with which the points were made. Otherwise the curve has to follow each chord.
///
/// ```
/// use arcfeed_geometry::{Curve, DenseFit, StretchShape, nalgebra::vector};
///
/// // A half circle of radius 20 mm and a line behind a corner, every 0.1 mm, rounded to 1 um.
/// let round = |x: f64| (x * 1e3).round() / 1e3;
/// let mut fit = DenseFit::new(0.005)?;
/// for i in 0..=628 {
///     let a = std::f64::consts::PI * f64::from(i) / 628.0;
///     fit.push(vector![round(20.0 * a.cos()), round(20.0 * a.sin())])?;
/// }
/// for i in 1..=400 {
///     fit.push(vector![round(-20.0 + 0.1 * f64::from(i)), 0.0])?;
/// }
/// fit.finish()?;
/// let stretches: Vec<_> = std::iter::from_fn(|| fit.next_stretch()).collect();
///
/// // The arc, with a cubic to each of its ends, and the line.
/// let arc = stretches.iter().find(|s| s.shape == StretchShape::Arc).expect("an arc");
/// assert!(stretches.iter().all(|s| s.max_deviation <= 0.005) && stretches.len() == 4);
/// assert!((arc.curve.jet(arc.curve.domain().0).curvature() * 20.0 - 1.0).abs() < 0.001);
/// let line = &stretches[3];
/// assert_eq!((line.shape, line.first, line.last), (StretchShape::Line, 628, 1028));
/// # Ok::<(), arcfeed_geometry::GeometryError>(())
/// ```
#[derive(Debug, Clone)]
pub struct DenseFit<const D: usize> {
    tolerance: f64,
    corner_angle: f64,
    /// Lines and arcs are recognised.
    primitives: bool,
    /// Largest coordinate so far.
    size: f64,
    /// Number of points so far.
    count: usize,
    corners: Option<CornerFinder<D>>,
    stretch: Option<StretchFit<D>>,
    visits: u64,
    out: Output<D>,
}

impl<const D: usize> DenseFit<D> {
    /// A fit without points yet. The tolerance has the unit of the points.
    ///
    /// # Errors
    /// Fails when the tolerance is not a finite number above 0.
    pub fn new(tolerance: f64) -> Result<Self, GeometryError> {
        const { assert!(D == 2 || D == 3, "curves live in the plane or in space") };
        check_positive("tolerance", tolerance)?;
        Ok(Self {
            tolerance,
            corner_angle: CORNER_ANGLE,
            primitives: true,
            size: 0.0,
            count: 0,
            corners: None,
            stretch: None,
            visits: 0,
            out: VecDeque::new(),
        })
    }

    /// The same fit with corners from another angle on, in rad, at most 3. It has an effect before the first
    /// point only.
    ///
    /// # Errors
    /// Fails when the angle is not a finite number above 0. Values below 0.02 count as 0.02, and above 3 as 3.
    pub fn with_corner_angle(mut self, angle: f64) -> Result<Self, GeometryError> {
        check_positive("corner angle", angle)?;
        self.corner_angle = angle.max(0.02).min(3.0);
        Ok(self)
    }

    /// The same fit without the recognition of lines and arcs: cubic spans alone. It has an effect before the first point
    /// only.
    pub fn with_cubics_only(mut self) -> Self {
        self.primitives = false;
        self
    }

    /// Takes the next point. A point that equals the one before is counted and left out.
    ///
    /// # Errors
    /// Fails when a coordinate is not a finite number of magnitude below 1e100, or is so large that the
    /// tolerance is lost in the rounding of the curve (1e-9 of it). The point is then not taken, and the fit may
    /// go on with another.
    pub fn push(&mut self, point: SVector<f64, D>) -> Result<(), GeometryError> {
        let index = self.count;
        for axis in 0..D {
            // NaN has to fail too.
            if point[axis].is_nan() || point[axis].abs() >= 1e100 {
                return Err(GeometryError::PointNotFinite { what: "data point", index, axis, value: point[axis] });
            }
        }
        let size = self.size.max(point.amax());
        let smallest = LEAST_TOLERANCE * size;
        if self.tolerance < smallest {
            return Err(GeometryError::ToleranceTooSmall { tolerance: self.tolerance, smallest });
        }
        (self.size, self.count) = (size, index + 1);
        let corners = self.corners.get_or_insert_with(|| CornerFinder::new(self.tolerance, self.corner_angle));
        let at = match corners.last() {
            Some(last) => {
                let distance = (point - last.point).norm();
                // The second condition: a step that is lost in the length so far.
                if distance == 0.0 || last.at + distance == last.at {
                    return Ok(());
                }
                last.at + distance
            }
            None => 0.0,
        };
        corners.push(Vertex { point, at, index });
        self.hand_on()
    }

    /// Ends the polyline in the last point. The next point starts another one.
    ///
    /// # Errors
    /// Fails when there are fewer than two different points.
    pub fn finish(&mut self) -> Result<(), GeometryError> {
        if let Some(corners) = &mut self.corners {
            corners.finish();
            self.hand_on()?;
        }
        self.corners = None;
        let Some(mut stretch) = self.stretch.take() else {
            return Err(GeometryError::TooFewDataPoints { points: self.count, needed: 2 });
        };
        if stretch.is_a_point() {
            return Err(GeometryError::TooFewDataPoints { points: 1, needed: 2 });
        }
        stretch.finish(&mut self.out)?;
        self.visits += stretch.visits();
        Ok(())
    }

    /// The next finished stretch, in the order of the points.
    pub fn next_stretch(&mut self) -> Option<FittedStretch<D>> {
        self.out.pop_front()
    }

    /// Number of parts of chords that the fit has read so far: the work done, some twenty-five for each chord.
    pub fn parts_read(&self) -> u64 {
        self.visits + self.stretch.as_ref().map_or(0, StretchFit::visits)
    }

    /// Hands vertices on from the search for corners to the fit.
    fn hand_on(&mut self) -> Result<(), GeometryError> {
        let Some(corners) = &mut self.corners else { return Ok(()) };
        while let Some((vertex, corner)) = corners.pop() {
            let start = || StretchFit::new(self.tolerance, self.primitives, vertex.point, vertex.index);
            match &mut self.stretch {
                None => self.stretch = Some(start()),
                Some(stretch) => {
                    stretch.push(vertex.point, vertex.index, &mut self.out)?;
                    if corner {
                        stretch.finish(&mut self.out)?;
                        self.visits += stretch.visits();
                        self.stretch = Some(start());
                    }
                }
            }
        }
        Ok(())
    }
}

impl<const D: usize> NurbsCurve<D> {
    /// Curves with continuous curvature within `tolerance` of the polyline through dense points, one for each stretch
    /// between two corners. See [`DenseFit`], which takes the points one by one.
    ///
    /// # Errors
    /// Fails when the tolerance is not a finite number above 0 or is below 1e-9 of the largest coordinate, a
    /// coordinate is not finite, or there are fewer than two different points.
    pub fn fit_dense(
        points: impl IntoIterator<Item = SVector<f64, D>>,
        tolerance: f64,
    ) -> Result<Vec<FittedStretch<D>>, GeometryError> {
        let mut fit = DenseFit::new(tolerance)?;
        points.into_iter().try_for_each(|point| fit.push(point))?;
        fit.finish()?;
        Ok(fit.out.into())
    }
}
