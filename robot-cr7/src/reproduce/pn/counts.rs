//! Counts of segments, judged by halving and by a greedy walk on dense samples.

use arcfeed_geometry::SegmentationMethod;

use super::curves::{curve_of, failed};
use crate::input::sample_paths::SamplePath;
use crate::reproduce::Reproduction;
use crate::reproduce::spline::{Spline, off_segment};
use crate::run::error::Cr7Error;

/// Places on which a deviation is measured, and the share of the tolerance that this may miss.
const SAMPLES: u32 = 48;
const SMALL: f64 = 2e-3;

/// One curve, cut by one method.
#[derive(Debug, Clone, PartialEq)]
pub struct CountRun {
    /// Curve and tolerance in words.
    pub name: &'static str,
    /// The method.
    pub method: SegmentationMethod,
    /// Chord tolerance, m.
    pub tolerance: f64,
    /// The curve.
    pub curve: Spline,
    /// Parameters where segments end.
    pub breaks: Vec<f64>,
    /// Least and greatest count by the second path.
    pub bounds: (usize, usize),
}

impl CountRun {
    /// Cuts an embedded curve.
    ///
    /// # Errors
    /// [`Cr7Error::Curve`] when the curve cannot be cut.
    pub fn measure(
        name: &'static str,
        path: SamplePath,
        method: SegmentationMethod,
        tolerance: f64,
    ) -> Result<Self, Cr7Error> {
        let nurbs = curve_of(path)?;
        let breaks = nurbs.segment(method, tolerance).map_err(failed)?.breaks().to_vec();
        let curve = Spline::new(&nurbs);
        let count = |tolerance: f64| match method {
            SegmentationMethod::CType => halved(&curve, &type_c(&curve), tolerance, by_curve),
            SegmentationMethod::Hull => halved(&curve, &curve.breaks(), tolerance, by_hull),
            SegmentationMethod::Greedy { across_knots: true } => {
                let (a, b) = curve.domain();
                greedy(&curve, &[a, b], tolerance)
            }
            _ => greedy(&curve, &curve.breaks(), tolerance),
        };
        let least = match method {
            // A walk that stops at the first failure may be longer than the best one: its reach is
            // not monotone.
            SegmentationMethod::Greedy { .. } => count(tolerance * 1.1),
            _ => count(tolerance * (1.0 + SMALL)),
        };
        let bounds = (least, count(tolerance * (1.0 - SMALL)));
        Ok(Self { name, method, tolerance, curve, breaks, bounds })
    }

    fn words(&self) -> &'static str {
        match self.method {
            SegmentationMethod::CType => "type C, halved",
            SegmentationMethod::Hull => "convex hull, halved",
            SegmentationMethod::Greedy { across_knots: true } => "longest pieces across knots",
            _ => "longest pieces",
        }
    }

    /// Adds the rows; `printed` is the count of the paper, empty for none.
    pub fn judge(&self, r: &mut Reproduction, place: &str, printed: &str) {
        let (name, count) = (format!("{}: {}", self.name, self.words()), self.breaks.len() - 1);
        let deviation = self.curve.largest_deviation(&self.breaks, 200);
        let shown = format!("{:.7}", deviation * 1e3);
        let (from, to) = self.curve.domain();
        let whole = self.breaks.first() == Some(&from) && self.breaks.last() == Some(&to);
        let allowed = format!("{}", self.tolerance * 1e3);
        r.independent(place, format!("{name}, chord error, mm"), allowed, shown, whole && deviation <= self.tolerance);
        let (least, greatest) = self.bounds;
        r.independent(
            place,
            format!("{name}, count"),
            format!("{least} to {greatest}"),
            count.to_string(),
            (least..=greatest).contains(&count),
        )
        .note("the bounds come from a second path on dense samples, not from the paper");
        if !printed.is_empty() {
            r.information(place, format!("{name}, count of the paper"), printed, count.to_string())
                .note("no reading of the paper gives its count; the tolerance is the requirement");
        }
    }
}

type Measure = fn(&Spline, f64, f64) -> f64;

fn by_curve(curve: &Spline, a: f64, b: f64) -> f64 {
    curve.deviation(a, b, SAMPLES)
}

fn by_hull(curve: &Spline, a: f64, b: f64) -> f64 {
    let points: Vec<_> = curve.bezier(a, b).iter().map(|p| p.xyz() / p.w).collect();
    let last = points.len() - 1;
    points[1..last].iter().fold(0.0, |worst: f64, p| worst.max(off_segment(p, &points[0], &points[last])))
}

/// Number of pieces when each is halved until it keeps the tolerance.
fn halved(curve: &Spline, breaks: &[f64], tolerance: f64, measure: Measure) -> usize {
    let mut open: Vec<(f64, f64)> = breaks.windows(2).map(|w| (w[0], w[1])).collect();
    let mut count = 0;
    while let Some((a, b)) = open.pop() {
        if measure(curve, a, b) <= tolerance {
            count += 1;
        } else {
            let middle = 0.5 * (a + b);
            open.extend([(a, middle), (middle, b)]);
        }
    }
    count
}

/// Number of pieces of a walk that ends each piece where the tolerance is first exceeded.
fn greedy(curve: &Spline, breaks: &[f64], tolerance: f64) -> usize {
    let mut count = 0;
    for w in breaks.windows(2) {
        let (mut u, end) = (w[0], w[1]);
        let mut step = end - u;
        while u < end {
            // Grow from a step that keeps the tolerance, then halve the interval between good and
            // bad.
            while curve.deviation(u, (u + step).min(end), SAMPLES) > tolerance {
                step *= 0.5;
            }
            let (mut good, mut bad) = (step, f64::INFINITY);
            while bad.is_infinite() && u + good < end {
                let next = good * 1.25;
                if curve.deviation(u, (u + next).min(end), SAMPLES) <= tolerance { good = next } else { bad = next }
            }
            while bad.is_finite() && bad - good > 1e-4 * good {
                let middle = 0.5 * (good + bad);
                if curve.deviation(u, (u + middle).min(end), SAMPLES) <= tolerance {
                    good = middle
                } else {
                    bad = middle
                }
            }
            (u, step) = (u + good, good);
            count += 1;
        }
    }
    count
}

/// Knots, and places where the curvature changes its sign, from samples and halving.
pub fn type_c(curve: &Spline) -> Vec<f64> {
    let mut breaks = Vec::new();
    for w in curve.breaks().windows(2) {
        breaks.push(w[0]);
        let n = 400;
        // Curvature by differences is not trusted at the ends of a span.
        let at = |i: i32| w[0] + (w[1] - w[0]) * (1e-4 + (1.0 - 2e-4) * f64::from(i) / f64::from(n));
        for i in 0..n {
            let (mut a, mut b) = (at(i), at(i + 1));
            let side = curve.curvature(a);
            if side * curve.curvature(b) < 0.0 {
                for _ in 0..40 {
                    let middle = 0.5 * (a + b);
                    if curve.curvature(middle) * side > 0.0 { a = middle } else { b = middle }
                }
                breaks.push(0.5 * (a + b));
            }
        }
    }
    breaks.push(curve.domain().1);
    breaks
}
