//! Cutting a curve into pieces that stay within a tolerance of their chords.

mod c_type;
mod cutter;
mod hull;
mod longest;

use nalgebra::SVector;

use crate::chord::check_positive;
use crate::curve::Curve;
use crate::error::GeometryError;
use crate::nurbs::NurbsCurve;
use cutter::Cutter;
pub use cutter::MAX_SEGMENTS;

/// The choice of the pieces. All methods are closed-loop: the deviation of every piece is measured, not estimated from
/// the curvature.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum SegmentationMethod {
    /// Halve every Bezier piece until its control points lie within the tolerance of the chord (Actuators 2024, 13, 108,
    /// algorithm 1). The simplest; makes the most pieces, because control points lie farther out than the curve.
    Hull,
    /// Split where the curvature vanishes, then halve until the exact extreme deviation is within the tolerance (Liu et
    /// al. 2023, algorithm 1). Every piece is of C type: it bends to one side only.
    CType,
    /// From the start on, each time the longest piece that keeps the tolerance by its exact deviation. The fewest
    /// pieces of the three.
    Greedy {
        /// False: pieces end at the knots, so that each lies in one polynomial span. True: pieces may run across knots
        /// (and across corners, where the deviation allows it).
        across_knots: bool,
    },
}

/// A curve cut into pieces, each with the deviation it achieves.
#[derive(Debug, Clone, PartialEq)]
pub struct Segmentation {
    breaks: Vec<f64>,
    deviations: Vec<f64>,
    tolerance: f64,
}

impl Segmentation {
    /// Parameters of the curve where pieces start and end: one more than there are pieces, strictly increasing, from
    /// the start of the domain to its end.
    pub fn breaks(&self) -> &[f64] {
        &self.breaks
    }

    /// Largest distance of each piece from its chord, in the curve's unit: never below the true one, and above it by no
    /// more than 1e-6 of it or what rounding of the coordinates makes unavoidable.
    pub fn deviations(&self) -> &[f64] {
        &self.deviations
    }

    /// Largest of the deviations, in the curve's unit; never above the tolerance.
    pub fn max_deviation(&self) -> f64 {
        self.deviations.iter().fold(0.0, |m, &d| m.max(d))
    }

    /// The tolerance asked for, in the curve's unit.
    pub fn tolerance(&self) -> f64 {
        self.tolerance
    }

    /// Number of pieces, at least 1.
    #[allow(clippy::len_without_is_empty)]
    pub fn len(&self) -> usize {
        self.deviations.len()
    }

    /// Start parameter, end parameter and deviation of each piece, in order.
    pub fn pieces(&self) -> impl ExactSizeIterator<Item = (f64, f64, f64)> + '_ {
        self.breaks.windows(2).zip(&self.deviations).map(|(b, &d)| (b[0], b[1], d))
    }

    /// The corners of the chord polygon: the points of `curve` at the breaks.
    pub fn points<const D: usize>(&self, curve: &NurbsCurve<D>) -> Vec<SVector<f64, D>> {
        self.breaks.iter().map(|&u| curve.point(u)).collect()
    }
}

impl<const D: usize> NurbsCurve<D> {
    /// Cuts the curve into pieces that deviate from their chords by no more than `tolerance` (in the curve's unit).
    ///
    /// The guarantee is the same for every `method`: no point of a piece is farther than `tolerance` from the straight
    /// segment between the two ends of the piece.
    ///
    /// ```
    /// use arcfeed_geometry::{NurbsCurve, SegmentationMethod, nalgebra::vector};
    ///
    /// let points = vec![vector![0.0, 0.0], vector![0.5, 1.0], vector![1.0, 0.0]];
    /// let curve = NurbsCurve::bspline(2, points, vec![0.0, 0.0, 0.0, 1.0, 1.0, 1.0])?;
    /// let pieces = curve.segment(SegmentationMethod::Greedy { across_knots: false }, 1e-3)?;
    /// assert!(pieces.max_deviation() <= 1e-3);
    /// assert_eq!(pieces.len(), 19);
    /// # Ok::<(), arcfeed_geometry::GeometryError>(())
    /// ```
    ///
    /// # Errors
    /// Fails when the tolerance is not a finite number above 0, is lost in the rounding of the coordinates (below 1e-12 of the
    /// largest of them), or asks for more than [`MAX_SEGMENTS`] pieces.
    pub fn segment(&self, method: SegmentationMethod, tolerance: f64) -> Result<Segmentation, GeometryError> {
        check_positive("tolerance", tolerance)?;
        let mut cutter = Cutter::new(self, tolerance)?;
        match method {
            SegmentationMethod::Hull => hull::cut(&mut cutter)?,
            SegmentationMethod::CType => c_type::cut(&mut cutter)?,
            SegmentationMethod::Greedy { across_knots } => longest::cut(&mut cutter, across_knots)?,
        }
        Ok(Segmentation { breaks: cutter.breaks, deviations: cutter.deviations, tolerance })
    }
}
