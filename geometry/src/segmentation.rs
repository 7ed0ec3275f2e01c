//! Cutting a curve into pieces that stay within a tolerance of their chords.

mod c_type;
mod hull;
mod longest;

use nalgebra::SVector;

use crate::bezier::{Homogeneous, RationalBezier, restrict};
use crate::chord::{ChordMeter, Deviation, cartesian, check_positive, size_of};
use crate::curve::Curve;
use crate::error::GeometryError;
use crate::nurbs::NurbsCurve;

/// No segmentation has more pieces than this (about 64 MB of result).
pub const MAX_SEGMENTS: usize = 4_000_000;

/// Relative precision of the reported deviations.
const PRECISION: f64 = 1e-7;

/// How to choose the pieces. All methods are closed-loop: the deviation of every piece is measured, not estimated from
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
    Longest {
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
    /// let pieces = curve.segment(SegmentationMethod::Longest { across_knots: false }, 1e-3)?;
    /// assert!(pieces.max_deviation() <= 1e-3);
    /// assert_eq!(pieces.len(), 19);
    /// # Ok::<(), arcfeed_geometry::GeometryError>(())
    /// ```
    ///
    /// # Errors
    /// When the tolerance is not a finite number above 0, is lost in the rounding of the coordinates (below 1e-12 of the
    /// largest of them), or asks for more than [`MAX_SEGMENTS`] pieces.
    pub fn segment(&self, method: SegmentationMethod, tolerance: f64) -> Result<Segmentation, GeometryError> {
        check_positive("tolerance", tolerance)?;
        let mut cutter = Cutter::new(self, tolerance)?;
        match method {
            SegmentationMethod::Hull => hull::cut(&mut cutter)?,
            SegmentationMethod::CType => c_type::cut(&mut cutter)?,
            SegmentationMethod::Longest { across_knots } => longest::cut(&mut cutter, across_knots)?,
        }
        Ok(Segmentation { breaks: cutter.breaks, deviations: cutter.deviations, tolerance })
    }
}

/// What the methods share: the Bezier pieces of the curve, a meter, and the result so far.
struct Cutter<'a, const D: usize> {
    curve: &'a NurbsCurve<D>,
    beziers: Vec<RationalBezier<D>>,
    tolerance: f64,
    meter: ChordMeter,
    /// Largest coordinate of a control point, by magnitude.
    size: f64,
    order: usize,
    breaks: Vec<f64>,
    deviations: Vec<f64>,
    part: Vec<Homogeneous>,
}

impl<'a, const D: usize> Cutter<'a, D> {
    fn new(curve: &'a NurbsCurve<D>, tolerance: f64) -> Result<Self, GeometryError> {
        let size = curve.homogeneous().iter().map(size_of).fold(0.0, f64::max);
        let smallest = 1e-12 * size;
        if tolerance < smallest {
            return Err(GeometryError::ToleranceTooSmall { tolerance, smallest });
        }
        let this = Self {
            curve,
            beziers: curve.decompose(),
            tolerance,
            meter: ChordMeter::new(),
            size,
            order: curve.degree() + 1,
            breaks: vec![curve.domain().0],
            deviations: Vec::new(),
            part: Vec::new(),
        };
        let estimate = this.estimate();
        // The estimate is a lower one for halving and smooth curves; what it lets pass is counted while cutting.
        if estimate > 1.5 * MAX_SEGMENTS as f64 {
            return Err(GeometryError::TooManySegments { tolerance, estimate, limit: MAX_SEGMENTS });
        }
        Ok(this)
    }

    /// Number of longest pieces to expect: a short piece of length `h` in the parameter deviates by `|C''| h^2 / 8`,
    /// of `C''` what is normal to the curve.
    fn estimate(&self) -> f64 {
        const SAMPLES: usize = 8;
        let mut sum = 0.0;
        for bezier in &self.beziers {
            let (a, b) = bezier.interval();
            let h = (b - a) / SAMPLES as f64;
            for i in 0..SAMPLES {
                sum += h / step(self.curve, a + (i as f64 + 0.5) * h, self.tolerance);
            }
        }
        sum
    }

    /// Deviation of the curve between two parameters from the chord between them; `first` is the Bezier piece that
    /// holds `u0`.
    fn deviation(&mut self, first: usize, u0: f64, u1: f64) -> Deviation {
        let a = crate::chord::three(&self.curve.point(u0));
        let b = crate::chord::three(&self.curve.point(u1));
        self.meter.begin(&a, &b, self.size, self.order);
        for bezier in &self.beziers[first..] {
            let (m, n) = bezier.interval();
            if m >= u1 {
                break;
            }
            let (v0, v1) = (u0.max(m), u1.min(n));
            let il = 1.0 / (n - m);
            let t1 = if v1 < n { (v1 - m) * il } else { 1.0 };
            self.meter.add(bezier.homogeneous(), (v0, v1), ((v0 - m) * il, t1));
        }
        self.meter.measure_loaded(PRECISION)
    }

    fn push(&mut self, end: f64, deviation: f64) -> Result<(), GeometryError> {
        if self.deviations.len() == MAX_SEGMENTS {
            let (start, stop) = self.curve.domain();
            let estimate = MAX_SEGMENTS as f64 * (stop - start) / (end - start);
            return Err(GeometryError::TooManySegments { tolerance: self.tolerance, estimate, limit: MAX_SEGMENTS });
        }
        self.breaks.push(end);
        self.deviations.push(deviation);
        Ok(())
    }

    /// Halves the part of Bezier piece `index` between `u0` and `u1` until `measure` calls every part good, from left
    /// to right.
    fn halve(&mut self, index: usize, u0: f64, u1: f64, hull: bool) -> Result<(), GeometryError> {
        let (m, n) = self.beziers[index].interval();
        let mut ends = vec![u1];
        let mut start = u0;
        while let Some(&end) = ends.last() {
            let (t0, t1) = ((start - m) / (n - m), if end < n { (end - m) / (n - m) } else { 1.0 });
            self.part.clear();
            self.part.extend_from_slice(self.beziers[index].homogeneous());
            restrict(&mut self.part, t0, t1);
            let (a, b) = (cartesian(&self.part[0]), cartesian(&self.part[self.order - 1]));
            self.meter.begin(&a, &b, self.size, self.order);
            self.meter.add(&self.part, (start, end), (0.0, 1.0));
            let good = !hull || self.meter.hull_loaded() <= self.tolerance;
            // Of the hull method too the true deviation is reported.
            let deviation = if good { self.meter.measure_loaded(PRECISION).upper } else { f64::INFINITY };
            if deviation <= self.tolerance {
                self.push(end, deviation)?;
                ends.pop();
                start = end;
            } else {
                let middle = 0.5 * (start + end);
                if !(start < middle && middle < end) {
                    return Err(GeometryError::ParameterTooCoarse { u: start, tolerance: self.tolerance });
                }
                ends.push(middle);
            }
        }
        Ok(())
    }
}

/// Length in the parameter of a short piece at `u` that deviates by `tolerance`, from the second derivative; infinite
/// where the curve is straight.
fn step<const D: usize>(curve: &NurbsCurve<D>, u: f64, tolerance: f64) -> f64 {
    let jet = curve.jet(u);
    let q = jet.d1.norm_squared();
    let along = if q > 0.0 { jet.d1 * (jet.d1.dot(&jet.d2) / q) } else { jet.d1 };
    (8.0 * tolerance / (jet.d2 - along).norm()).sqrt()
}
