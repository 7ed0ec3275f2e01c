//! Rational Bezier spans, the common form of all pieces of a joined path.

use nalgebra::Vector3;

use crate::bezier::{Homogeneous, lerp, project, restrict};
use crate::quadrature::gauss_legendre;

/// Spans with more control points than this are evaluated on the heap.
const ON_STACK: usize = 8;
/// Steps of Newton's method that find the parameter of an arc length; from the middle of the error of a tame span
/// three do.
const MOST_STEPS: usize = 6;

/// Many spans, one after the other, with their lengths. The weights at both ends of a span are 1.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Spans {
    points: Vec<Homogeneous>,
    /// Number of control points up to the end of each span.
    ends: Vec<usize>,
    lengths: Vec<f64>,
}

/// A place on one of several spans.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Place {
    pub span: usize,
    /// Parameter on the span, from 0 to 1.
    pub t: f64,
}

#[cfg(test)]
thread_local! {
    /// How often this thread has looked at a span: the measure of effort in tests.
    pub(super) static LOOKS: std::cell::Cell<usize> = const { std::cell::Cell::new(0) };
}

impl Spans {
    pub fn push(&mut self, points: &[Homogeneous], length: f64) {
        self.points.extend_from_slice(points);
        self.ends.push(self.points.len());
        self.lengths.push(length);
    }

    pub fn append(&mut self, other: &Self) {
        for i in 0..other.len() {
            self.push(other.get(i), other.lengths[i]);
        }
    }

    pub fn len(&self) -> usize {
        self.ends.len()
    }

    pub fn get(&self, i: usize) -> &[Homogeneous] {
        #[cfg(test)]
        LOOKS.with(|count| count.set(count.get() + 1));
        let start = if i == 0 { 0 } else { self.ends[i - 1] };
        &self.points[start..self.ends[i]]
    }

    pub fn lengths(&self) -> &[f64] {
        &self.lengths
    }

    /// Moves the first or the last point of all spans.
    pub fn set_end(&mut self, last: bool, point: &Vector3<f64>) {
        let end = if last { self.points.last_mut() } else { self.points.first_mut() };
        if let Some(end) = end {
            *end = homogeneous(point);
        }
    }

    /// The part from one place to another.
    pub fn part(&self, from: Place, to: Place) -> Self {
        let mut out = Self::default();
        for i in from.span..=to.span {
            let t0 = if i == from.span { from.t } else { 0.0 };
            let t1 = if i == to.span { to.t } else { 1.0 };
            if t0 >= t1 {
                continue;
            }
            if t0 == 0.0 && t1 == 1.0 {
                out.push(self.get(i), self.lengths[i]);
                continue;
            }
            let mut points = self.get(i).to_vec();
            restrict(&mut points, t0, t1);
            standardise(&mut points);
            let length = if points.len() == 2 { (t1 - t0) * self.lengths[i] } else { length(&points, 0.0, 1.0) };
            out.push(&points, length);
        }
        out
    }
}

/// Point and two derivatives by the parameter of a span.
#[derive(Debug, Clone, Copy)]
pub(super) struct SpanJet {
    pub point: Vector3<f64>,
    pub d1: Vector3<f64>,
    pub d2: Vector3<f64>,
}

impl SpanJet {
    /// Unit tangent.
    pub fn tangent(&self) -> Vector3<f64> {
        self.d1 / self.d1.norm()
    }

    /// Curvature vector: the derivative of the unit tangent by arc length.
    pub fn curvature(&self) -> Vector3<f64> {
        let q = self.d1.norm_squared();
        (self.d2 - self.d1 * (self.d2.dot(&self.d1) / q)) / q
    }
}

pub(super) fn homogeneous(p: &Vector3<f64>) -> Homogeneous {
    [p.x, p.y, p.z, 1.0]
}

/// The jet of a span at `t`, by de Casteljau's algorithm.
pub(super) fn jet(points: &[Homogeneous], t: f64) -> SpanJet {
    let mut stack = [[0.0; 4]; ON_STACK];
    let mut heap = Vec::new();
    let h = if points.len() <= ON_STACK {
        &mut stack[..points.len()]
    } else {
        heap.resize(points.len(), [0.0; 4]);
        &mut heap[..]
    };
    h.copy_from_slice(points);
    let n = points.len() - 1;
    for r in (3..=n).rev() {
        for i in 0..r {
            h[i] = lerp(&h[i], &h[i + 1], t);
        }
    }
    let degree = n as f64;
    let (left, right, second) = if n == 1 {
        (h[0], h[1], [0.0; 4])
    } else {
        let bend = |l: usize| degree * (degree - 1.0) * ((h[2][l] - h[1][l]) - (h[1][l] - h[0][l]));
        (lerp(&h[0], &h[1], t), lerp(&h[1], &h[2], t), std::array::from_fn(bend))
    };
    let value = lerp(&left, &right, t);
    let first: Homogeneous = std::array::from_fn(|l| degree * (right[l] - left[l]));
    // Quotient rule.
    let point: Vector3<f64> = project(&value);
    let d1 = (vector(&first) - point * first[3]) / value[3];
    let d2 = (vector(&second) - d1 * (2.0 * first[3]) - point * second[3]) / value[3];
    SpanJet { point, d1, d2 }
}

fn vector(h: &Homogeneous) -> Vector3<f64> {
    Vector3::new(h[0], h[1], h[2])
}

/// Arc length of a span between two parameters, by one Gauss-Legendre rule of 16 nodes.
pub(super) fn length(points: &[Homogeneous], t0: f64, t1: f64) -> f64 {
    gauss_legendre(&|t| jet(points, t).d1.norm(), t0, t1)
}

/// The parameter at the arc length `x` from the start of a span that is `whole` long.
pub(super) fn parameter(points: &[Homogeneous], whole: f64, x: f64) -> f64 {
    let mut t = (x / whole).max(0.0).min(1.0);
    if points.len() == 2 {
        return t;
    }
    for _ in 0..MOST_STEPS {
        let step = (length(points, 0.0, t) - x) / jet(points, t).d1.norm();
        let next = (t - step).max(0.0).min(1.0);
        let change = (next - t).abs();
        t = next;
        if change < 1e-12 {
            break;
        }
    }
    t
}

/// Gives the span weights of 1 at both ends, by a linear rational change of its parameter: the shape stays.
pub(super) fn standardise(points: &mut [Homogeneous]) {
    let n = points.len() - 1;
    let (first, last) = (points[0][3], points[n][3]);
    if first == 1.0 && last == 1.0 {
        return;
    }
    let ratio = (first / last).powf(1.0 / n as f64);
    let mut factor = 1.0 / first;
    for (i, h) in points.iter_mut().enumerate() {
        *h = h.map(|x| x * factor);
        if i == 0 || i == n {
            let w = h[3];
            *h = h.map(|x| x / w);
        }
        factor *= ratio;
    }
}

/// Control points of the same span with a degree higher by one, appended to `out`.
pub(super) fn elevate(points: &[Homogeneous], out: &mut Vec<Homogeneous>) {
    let n = points.len();
    out.clear();
    out.push(points[0]);
    for i in 1..n {
        out.push(lerp(&points[i], &points[i - 1], i as f64 / n as f64));
    }
    out.push(points[n - 1]);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn quarter() -> Vec<Homogeneous> {
        let w = std::f64::consts::FRAC_1_SQRT_2;
        vec![[1.0, 0.0, 0.0, 1.0], [w, w, 0.0, w], [0.0, 1.0, 0.0, 1.0]]
    }

    #[test]
    fn a_part_of_a_circle_is_one_and_keeps_it_when_elevated() {
        let mut part = quarter();
        restrict(&mut part, 0.2, 0.7);
        standardise(&mut part);
        let mut higher = Vec::new();
        elevate(&part, &mut higher);
        assert_eq!((part[0][3], part[2][3], higher.len()), (1.0, 1.0, 4));
        for i in 0..=10 {
            let t = f64::from(i) / 10.0;
            let (a, b) = (jet(&part, t), jet(&higher, t));
            assert!((a.point.norm() - 1.0).abs() < 1e-15);
            assert!((a.curvature() + a.point).norm() < 1e-14);
            assert!((a.point - b.point).norm() < 1e-15 && (a.d1 - b.d1).norm() < 1e-14 && (a.d2 - b.d2).norm() < 1e-13);
        }
    }

    #[test]
    fn the_parameter_of_an_arc_length_on_a_circle_is_that_of_its_angle() {
        let points = quarter();
        for x in [0.0, 0.1, 0.7, 1.5] {
            let p = jet(&points, parameter(&points, std::f64::consts::FRAC_PI_2, x)).point;
            assert!((p.y.atan2(p.x) - x).abs() < 1e-13);
        }
    }
}
