//! Least squares on a window of the polyline.

use nalgebra::SVector;

use super::piece::{DEGREE, ORDER, Piece, polar};
use super::polyline::{Part, Vertex, Walk};
use crate::banded::Banded;
use crate::basis::basis_functions;
use crate::bezier::Homogeneous;
use crate::knots::KnotVector;
use crate::span::part_powers;

/// Nodes and weights of the Gauss-Legendre rule of four points on [-1, 1], exact to degree 7.
const NODES: [f64; ORDER] =
    [-0.861_136_311_594_052_6, -0.339_981_043_584_856_3, 0.339_981_043_584_856_3, 0.861_136_311_594_052_6];
const WEIGHTS: [f64; ORDER] =
    [0.347_854_845_137_453_8, 0.652_145_154_862_546_1, 0.652_145_154_862_546_1, 0.347_854_845_137_453_8];

/// The condition at the start of a window.
#[derive(Debug, Clone, Copy)]
pub(super) enum Start<const D: usize> {
    /// The curve starts in a point.
    Point(SVector<f64, D>),
    /// The curve continues: point, first and half the second derivative, and 0.
    Jet([SVector<f64, D>; ORDER]),
}

impl<const D: usize> Start<D> {
    pub fn point(&self) -> SVector<f64, D> {
        match self {
            Self::Point(point) => *point,
            Self::Jet(jet) => jet[0],
        }
    }
}

/// The condition at the end of a window.
#[derive(Debug, Clone, Copy)]
pub(super) enum End<const D: usize> {
    /// The polyline goes on.
    Open,
    /// The curve ends in a point.
    Point(SVector<f64, D>),
    /// The curve runs into another one: point, first and half the second derivative, and 0.
    Jet([SVector<f64, D>; ORDER]),
}

/// A part of the polyline that is fitted at once.
#[derive(Debug)]
pub(super) struct Window<'a, const D: usize> {
    pub vertices: &'a [Vertex<D>],
    /// Parameter of the start.
    pub at: f64,
    pub start: Start<D>,
    /// Parameter of the end.
    pub limit: f64,
    pub end: End<D>,
}

impl<const D: usize> Window<'_, D> {
    /// Least number of spans of a curve that keeps the conditions at both ends.
    pub fn least_spans(&self) -> usize {
        match (&self.start, &self.end) {
            (Start::Jet(_), End::Jet(_)) => DEGREE,
            _ => 1,
        }
    }

    /// The cubic spline with the given ends of spans (simple knots inside) that is nearest to the polyline and
    /// keeps the start of the window and the condition `end`, with its bounds: the integral of the squared
    /// distance over the parameter is least. `visits` counts the parts of chords that are read.
    ///
    /// The polyline is projected on the cubics over each span. By Gauss's rule that turns the integral into a
    /// sum of four terms for each span, without an error.
    pub fn fit(&self, breaks: &[f64], end: &End<D>, visits: &mut u64) -> Option<Vec<Piece<D>>> {
        let (first, last) = (breaks[0], breaks[breaks.len() - 1]);
        let mut knots = vec![first; DEGREE];
        knots.extend_from_slice(breaks);
        knots.extend([last; DEGREE]);
        let knots = KnotVector::new(DEGREE, knots).ok()?;
        if knots.spans().count() + 1 != breaks.len() {
            return None;
        }
        let mut walk = Walk::new(self.vertices, first);
        let origin = walk.point();
        let control = self.control_points(&knots, end, &mut walk, &origin)?;
        let homogeneous: Vec<Homogeneous> = control.iter().map(lanes).collect();
        let mut walk = Walk::new(self.vertices, first);
        let mut powers = Vec::with_capacity(ORDER);
        let mut pieces = Vec::with_capacity(breaks.len());
        for k in knots.spans() {
            powers.clear();
            part_powers(knots.as_slice(), &homogeneous, (DEGREE, k), (0.0, 1.0), &mut powers);
            let mut coefficients: [SVector<f64, D>; ORDER] =
                std::array::from_fn(|order| SVector::from_fn(|axis, _| powers[order][axis]));
            coefficients[0] += origin;
            let (start, end) = (knots.as_slice()[k], knots.as_slice()[k + 1]);
            let mut piece = Piece { start, end, coefficients, deviation: 0.0, straight: false };
            piece.measure(walk.parts(end).inspect(|_| *visits += 1));
            pieces.push(piece);
        }
        pieces.iter().all(|p| p.deviation.is_finite()).then_some(pieces)
    }

    /// Control points relative to `origin`.
    fn control_points(
        &self,
        knots: &KnotVector,
        end: &End<D>,
        walk: &mut Walk<'_, D>,
        origin: &SVector<f64, D>,
    ) -> Option<Vec<SVector<f64, D>>> {
        let (t, n) = (knots.as_slice(), knots.point_count());
        let mut control = vec![SVector::zeros(); n];
        let (known, free_end) = self.known(t, end, origin, &mut control);
        let unknowns = free_end.checked_sub(known)?;
        let mut matrix = Banded::zeros(unknowns, DEGREE, DEGREE);
        let mut right = vec![SVector::zeros(); unknowns];
        let mut values = Vec::with_capacity(ORDER);
        for k in knots.spans() {
            let (middle, half) = (0.5 * (t[k] + t[k + 1]), 0.5 * (t[k + 1] - t[k]));
            let samples = projected(walk, (t[k], t[k + 1]), origin);
            for g in 0..ORDER {
                let first = basis_functions(knots, middle + half * NODES[g], &mut values);
                let mut sample = samples[g] / WEIGHTS[g];
                let outside = |i: usize| !(known..free_end).contains(&i);
                for (j, &v) in values.iter().enumerate().filter(|(j, _)| outside(first + j)) {
                    sample -= control[first + j] * v;
                }
                for (j, &v) in values.iter().enumerate().filter(|(j, _)| !outside(first + j)) {
                    let weighted = v * WEIGHTS[g] * half;
                    right[first + j - known] += sample * weighted;
                    for (l, &w) in values.iter().enumerate().filter(|(l, _)| !outside(first + l)) {
                        matrix.add(first + j - known, first + l - known, weighted * w);
                    }
                }
            }
        }
        let solution = matrix.solve(right)?;
        control[known..free_end].copy_from_slice(&solution);
        Some(control)
    }

    /// Sets the control points that the ends determine, and returns the range of the others.
    fn known(
        &self,
        t: &[f64],
        end: &End<D>,
        origin: &SVector<f64, D>,
        control: &mut [SVector<f64, D>],
    ) -> (usize, usize) {
        let n = control.len();
        let of = |jet: &[SVector<f64, D>; ORDER], at: f64, i: usize| {
            polar(jet, std::array::from_fn(|r| t[i + 1 + r] - at)) - origin
        };
        let known = match &self.start {
            Start::Point(point) => {
                control[0] = point - origin;
                1
            }
            Start::Jet(jet) => {
                (0..DEGREE).for_each(|i| control[i] = of(jet, t[0], i));
                DEGREE
            }
        };
        let free_end = match end {
            End::Open => n,
            End::Point(point) => {
                control[n - 1] = point - origin;
                n - 1
            }
            End::Jet(jet) => {
                (n - DEGREE..n).for_each(|i| control[i] = of(jet, t[n], i));
                n - DEGREE
            }
        };
        (known, free_end)
    }
}

fn lanes<const D: usize>(point: &SVector<f64, D>) -> Homogeneous {
    let mut lanes = [0.0, 0.0, 0.0, 1.0];
    lanes[..D].copy_from_slice(point.as_slice());
    lanes
}

/// The polyline over `[start, end]`, projected on the cubics: values at the nodes, times the weights of the nodes.
///
/// They are the integrals of the polyline times the Lagrange polynomials of the nodes. The integrals of the
/// polyline times the powers of the local parameter come from integration by parts, because its slope is
/// constant on a chord.
fn projected<const D: usize>(
    walk: &mut Walk<'_, D>,
    (start, end): (f64, f64),
    origin: &SVector<f64, D>,
) -> [SVector<f64, D>; ORDER] {
    let (middle, scale) = (0.5 * (start + end), 2.0 / (end - start));
    // x^(k + 2) / ((k + 1) (k + 2)), the second integral of x^k.
    let second = |x: f64| {
        let x2 = x * x;
        [x2 / 2.0, x2 * x / 6.0, x2 * x2 / 12.0, x2 * x2 * x / 20.0]
    };
    let from = walk.point() - origin;
    let mut moments = [SVector::<f64, D>::zeros(); ORDER];
    let mut before = second(-1.0);
    let mut x = -1.0;
    for Part { end, from, to, .. } in walk.parts(end) {
        let next = (end - middle) * scale;
        let after = second(next);
        if next > x {
            let slope = (to - from) / (next - x);
            for k in 0..ORDER {
                moments[k] -= slope * (after[k] - before[k]);
            }
        }
        (x, before) = (next, after);
    }
    let to = walk.point() - origin;
    for (k, moment) in moments.iter_mut().enumerate() {
        let sign = if k % 2 == 0 { 1.0 } else { -1.0 };
        *moment += (to + from * sign) / (k + 1) as f64;
    }
    let lagrange = lagrange();
    std::array::from_fn(|g| (0..ORDER).map(|k| moments[k] * lagrange[g][k]).sum())
}

/// Coefficients in powers of the polynomials that are 1 at one node and 0 at the others.
fn lagrange() -> [[f64; ORDER]; ORDER] {
    std::array::from_fn(|g| {
        let mut polynomial = [1.0, 0.0, 0.0, 0.0];
        for other in (0..ORDER).filter(|&other| other != g) {
            let scale = 1.0 / (NODES[g] - NODES[other]);
            for k in (0..ORDER).rev() {
                let lower = if k > 0 { polynomial[k - 1] } else { 0.0 };
                polynomial[k] = (lower - NODES[other] * polynomial[k]) * scale;
            }
        }
        polynomial
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::vector;

    /// On one span the fit is the projection, and its residual has no component along any cubic.
    #[test]
    fn the_projection_leaves_no_component_along_a_cubic() {
        let points = [vector![0.0, 0.0], vector![0.3, 0.1], vector![0.4, -0.2], vector![1.0, 0.5]];
        let mut at = 0.0;
        let vertices: Vec<_> = (0..4)
            .map(|index| {
                at += if index > 0 { (points[index] - points[index - 1]).norm() } else { 0.0 };
                Vertex { point: points[index], at, index }
            })
            .collect();
        let mut walk = Walk::new(&vertices, 0.1);
        let samples = projected(&mut walk, (0.1, at), &vector![0.2, 0.3]);
        // The same integrals by the midpoint rule.
        let n = 200_000;
        let mut sums = [SVector::<f64, 2>::zeros(); ORDER];
        for i in 0..n {
            let x = -1.0 + (2 * i + 1) as f64 / n as f64;
            let t = 0.1 + (at - 0.1) * 0.5 * (1.0 + x);
            let value = Walk::new(&vertices, t).point() - vector![0.2, 0.3];
            for (g, sum) in sums.iter_mut().enumerate() {
                let l: f64 = (0..ORDER).filter(|&o| o != g).map(|o| (x - NODES[o]) / (NODES[g] - NODES[o])).product();
                *sum += value * (l * 2.0 / n as f64);
            }
        }
        for g in 0..ORDER {
            assert!((samples[g] - sums[g]).norm() < 1e-9, "{g}: {} {}", samples[g], sums[g]);
        }
    }
}
