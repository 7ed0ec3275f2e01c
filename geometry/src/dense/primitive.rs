//! Lines and arcs that stand for runs of vertices.

use std::f64::consts::{FRAC_PI_2, TAU};

use nalgebra::{Matrix3, SVector, Vector3};

use super::piece::ORDER;
use super::polyline::Vertex;
use crate::error::GeometryError;
use crate::nurbs::NurbsCurve;

/// An arc rises over its chord by at least so many tolerances: a flatter one is not told from a line.
const LEAST_RISE: f64 = 4.0;
/// No radius is larger than so many times the extent of the run: the centre would be lost in rounding.
const LARGEST_RADIUS: f64 = 1e3;
/// Steps of the power iteration for the plane of an arc.
const POWERS: usize = 2;

/// The shape of a primitive, as a function of the length along the polyline.
#[derive(Debug, Clone, Copy)]
pub(super) enum Shape<const D: usize> {
    /// `point + direction (t - at)`.
    Line { at: f64, point: SVector<f64, D>, direction: SVector<f64, D> },
    /// `centre + radius (out cos a + across sin a)` with the angle `a = rate (t - at)`.
    Arc { at: f64, centre: SVector<f64, D>, out: SVector<f64, D>, across: SVector<f64, D>, radius: f64, rate: f64 },
}

impl<const D: usize> Shape<D> {
    /// The line through a run that is nearest to it on the whole, and passes the vertex `fixed` if there is one.
    pub fn line(run: &[Vertex<D>], fixed: Option<&Vertex<D>>) -> Self {
        let Vertex { point, at, .. } = *fixed.unwrap_or(&run[0]);
        let mut sums = (0.0, 0.0, 0.0);
        let (mut points, mut moments) = (SVector::<f64, D>::zeros(), SVector::<f64, D>::zeros());
        samples(run, |weight, t, p| {
            let (t, p) = (t - at, p - point);
            sums = (sums.0 + weight, sums.1 + weight * t, sums.2 + weight * t * t);
            points += p * weight;
            moments += p * (weight * t);
        });
        if fixed.is_some() {
            return Self::Line { at, point, direction: moments / sums.2 };
        }
        let (mean_t, mean) = (sums.1 / sums.0, points / sums.0);
        let direction = (moments - mean * sums.1) / (sums.2 - mean_t * sums.1);
        Self::Line { at: at + mean_t, point: point + mean, direction }
    }

    /// The arc through a run that is nearest to it on the whole, if the run bends.
    ///
    /// In the plane of the run the circle `x^2 + y^2 = a x + b y + c` is fitted by least squares (Kasa, "A circle fitting
    /// procedure and its error analysis", 1976). The residual is the distance from the circle times twice the radius, up to the
    /// square of the distance.
    pub fn arc(run: &[Vertex<D>], tolerance: f64) -> Option<Self> {
        let (first, last) = (run[0], run[run.len() - 1]);
        let distance = |v: &&Vertex<D>| (v.point - first.point).norm_squared();
        let far = run.iter().max_by(|a, b| distance(a).total_cmp(&distance(b)))?.point - first.point;
        let extent = far.norm();
        let e1 = far.try_normalize(0.0)?;
        let (mut whole, mut mean) = (0.0, SVector::<f64, D>::zeros());
        samples(run, |weight, _, p| {
            whole += weight;
            mean += (p - first.point) * weight;
        });
        let mean = first.point + mean / whole;
        let e2 = second_axis(run, &mean, &e1)?;
        let (mut matrix, mut right) = (Matrix3::zeros(), Vector3::zeros());
        samples(run, |weight, _, p| {
            let d = (p - mean) / extent;
            let row = Vector3::new(d.dot(&e1), d.dot(&e2), 1.0);
            matrix += row * row.transpose() * weight;
            right += row * (weight * (row.x * row.x + row.y * row.y));
        });
        let solution = matrix.cholesky()?.solve(&right);
        let (x, y) = (0.5 * solution.x, 0.5 * solution.y);
        let radius = extent * (solution.z + x * x + y * y).sqrt();
        if !(radius > LEAST_RISE * tolerance && radius < LARGEST_RADIUS * extent) {
            return None;
        }
        let centre = mean + (e1 * x + e2 * y) * extent;
        let place = |v: &Vertex<D>| ((v.point - centre).dot(&e1), (v.point - centre).dot(&e2));
        let angle = |v: &Vertex<D>| {
            let (x, y) = place(v);
            y.atan2(x)
        };
        let (from, to) = (angle(&first), angle(&last));
        // Twice the area that the arm from the centre passes over tells the side to which the run turns.
        let area: f64 = run
            .windows(2)
            .map(|pair| {
                let (a, b) = (place(&pair[0]), place(&pair[1]));
                a.0 * b.1 - a.1 * b.0
            })
            .sum();
        let side = area.signum();
        let expected = (last.at - first.at) / radius;
        let sweep = (side * (to - from)).rem_euclid(TAU);
        let sweep = sweep + TAU * ((expected - sweep) / TAU).round();
        let rise = radius * (1.0 - (0.5 * sweep.min(TAU)).cos());
        if !(sweep > 0.0 && rise > LEAST_RISE * tolerance) {
            return None;
        }
        let (sine, cosine) = from.sin_cos();
        let (out, across) = (e1 * cosine + e2 * sine, (e2 * cosine - e1 * sine) * side);
        Some(Self::Arc { at: first.at, centre, out, across, radius, rate: sweep / (last.at - first.at) })
    }

    /// Value, first and half the second derivative, and 0.
    pub fn jet(&self, t: f64) -> [SVector<f64, D>; ORDER] {
        match self {
            Self::Line { at, point, direction } => {
                [point + direction * (t - at), *direction, SVector::zeros(), SVector::zeros()]
            }
            Self::Arc { at, centre, out, across, radius, rate } => {
                let (sine, cosine) = (rate * (t - at)).sin_cos();
                let outwards = out * cosine + across * sine;
                let along = across * cosine - out * sine;
                [
                    centre + outwards * *radius,
                    along * (radius * rate),
                    outwards * (-0.5 * radius * rate * rate),
                    SVector::zeros(),
                ]
            }
        }
    }

    pub fn point(&self, t: f64) -> SVector<f64, D> {
        self.jet(t)[0]
    }

    /// Number of rational spans, each of a quarter turn at most; 1 for a line.
    pub fn spans(&self, (from, to): (f64, f64)) -> usize {
        match self {
            Self::Line { .. } => 1,
            Self::Arc { rate, .. } => ((rate * (to - from) / FRAC_PI_2 - 1e-9).ceil()).max(1.0) as usize,
        }
    }

    /// Norm of the second derivative.
    fn bend(&self) -> f64 {
        match self {
            Self::Line { .. } => 0.0,
            Self::Arc { radius, rate, .. } => radius * rate * rate,
        }
    }

    /// A bound on the distance between the shape and the chord from `a` to `b`, at the same length.
    ///
    /// Between two places the difference leaves the straight line between its values by an eighth of the squared step
    /// times the second derivative, at most.
    pub fn deviation(&self, a: &Vertex<D>, b: &Vertex<D>) -> f64 {
        let ends = (self.point(a.at) - a.point).norm().max((self.point(b.at) - b.point).norm());
        let bend = self.bend();
        if bend == 0.0 {
            return ends;
        }
        let (width, middle) = (b.at - a.at, 0.5 * (a.at + b.at));
        let inside = (self.point(middle) - (a.point + b.point) * 0.5).norm();
        ends.max(inside) + width * width * bend / 32.0
    }

    /// The largest of [`Shape::deviation`] over a run, if it is within `tolerance`.
    pub fn within(&self, run: &[Vertex<D>], tolerance: f64) -> Option<f64> {
        let mut largest = 0.0f64;
        for pair in run.windows(2) {
            let deviation = self.deviation(&pair[0], &pair[1]);
            if deviation.is_nan() || deviation > tolerance {
                return None;
            }
            largest = largest.max(deviation);
        }
        Some(largest)
    }
}

/// An exact arc between two lengths along the polyline, of degree 2, over the difference of both.
pub(super) fn arc_curve<const D: usize>(
    shape: &Shape<D>,
    (from, to): (f64, f64),
    ends: (SVector<f64, D>, SVector<f64, D>),
) -> Result<NurbsCurve<D>, GeometryError> {
    let &Shape::Arc { centre, rate, .. } = shape else { return super::fitted::line(ends, to - from) };
    let spans = shape.spans((from, to));
    let at = |i: usize| from + (to - from) * (i as f64 / spans as f64);
    let cosine = (0.5 * rate * (to - from) / spans as f64).cos();
    let (mut points, mut weights, mut knots) = (vec![ends.0], vec![1.0], vec![0.0; 3]);
    for i in 0..spans {
        let middle = shape.point(0.5 * (at(i) + at(i + 1)));
        points.push(centre + (middle - centre) / cosine);
        points.push(if i + 1 == spans { ends.1 } else { shape.point(at(i + 1)) });
        weights.extend([cosine, 1.0]);
        knots.extend([at(i + 1) - from; 2]);
    }
    knots.push(to - from);
    NurbsCurve::new(2, points, weights, knots)
}

/// Simpson's rule along the chords of a run: weight, length and point.
fn samples<const D: usize>(run: &[Vertex<D>], mut take: impl FnMut(f64, f64, SVector<f64, D>)) {
    for pair in run.windows(2) {
        let (a, b) = (&pair[0], &pair[1]);
        let width = b.at - a.at;
        take(width / 6.0, a.at, a.point);
        take(width * (2.0 / 3.0), 0.5 * (a.at + b.at), (a.point + b.point) * 0.5);
        take(width / 6.0, b.at, b.point);
    }
}

/// The direction across `e1` in which a run extends most, by a power iteration from its farthest vertex.
fn second_axis<const D: usize>(
    run: &[Vertex<D>],
    mean: &SVector<f64, D>,
    e1: &SVector<f64, D>,
) -> Option<SVector<f64, D>> {
    let off = |p: &SVector<f64, D>| {
        let d = p - mean;
        d - e1 * d.dot(e1)
    };
    let mut axis = SVector::<f64, D>::zeros();
    for vertex in run {
        let d = off(&vertex.point);
        if d.norm_squared() > axis.norm_squared() {
            axis = d;
        }
    }
    let mut axis = axis.try_normalize(0.0)?;
    for _ in 0..if D == 2 { 0 } else { POWERS } {
        let mut next = SVector::<f64, D>::zeros();
        samples(run, |weight, _, p| {
            let d = off(&p);
            next += d * (weight * d.dot(&axis));
        });
        axis = next.try_normalize(0.0)?;
    }
    // Off the first axis by rounding only.
    (axis - e1 * axis.dot(e1)).try_normalize(0.0)
}
