//! The common parts of the methods of segmentation: measuring a part of the curve, halving it, counting.

use crate::bezier::{Homogeneous, RationalBezier, restrict};
use crate::chord::{ChordMeter, Deviation, cartesian, size_of, three};
use crate::curve::Curve;
use crate::error::GeometryError;
use crate::nurbs::NurbsCurve;

/// No segmentation has more pieces than this (about 64 MB of result).
pub const MAX_SEGMENTS: usize = 4_000_000;

/// Relative precision of the reported deviations.
const PRECISION: f64 = 1e-7;

/// The Bezier pieces of the curve, a meter, and the result so far.
pub(super) struct Cutter<'a, const D: usize> {
    pub curve: &'a NurbsCurve<D>,
    pub beziers: Vec<RationalBezier<D>>,
    pub tolerance: f64,
    meter: ChordMeter,
    /// Largest coordinate of a control point, by magnitude.
    size: f64,
    order: usize,
    pub breaks: Vec<f64>,
    pub deviations: Vec<f64>,
    part: Vec<Homogeneous>,
}

impl<'a, const D: usize> Cutter<'a, D> {
    pub fn new(curve: &'a NurbsCurve<D>, tolerance: f64) -> Result<Self, GeometryError> {
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
    pub fn deviation(&mut self, first: usize, u0: f64, u1: f64) -> Deviation {
        let a = three(&self.curve.point(u0));
        let b = three(&self.curve.point(u1));
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

    pub fn push(&mut self, end: f64, deviation: f64) -> Result<(), GeometryError> {
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
    pub fn halve(&mut self, index: usize, u0: f64, u1: f64, hull: bool) -> Result<(), GeometryError> {
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
pub(super) fn step<const D: usize>(curve: &NurbsCurve<D>, u: f64, tolerance: f64) -> f64 {
    let jet = curve.jet(u);
    let q = jet.d1.norm_squared();
    let along = if q > 0.0 { jet.d1 * (jet.d1.dot(&jet.d2) / q) } else { jet.d1 };
    (8.0 * tolerance / (jet.d2 - along).norm()).sqrt()
}
