//! Places inside a span at which it stands still: its cusps.
//!
//! A rational span `N / w` has the derivative `D / w^2` with `D = N' w - N w'`. `D` is a polynomial, and it lies in the hull of
//! its Bernstein coefficients. Where some direction has a positive product with all of them, no point of the span
//! stands still. Any other interval is halved, until `D` is too small on the whole of it to tell it from 0. So no cusp is
//! missed, wherever it is.

use nalgebra::Vector3;

use super::spans::jet;
use super::standing::coincide;
use crate::bezier::{Homogeneous, project};

/// Intervals are not halved beyond this width.
const NARROWEST: f64 = 1e-13;
/// A wider interval without speed holds more than one simple cusp: its ends take the place of these.
const WIDE: f64 = 1e-7;
/// Intervals of one span that are looked at; more than any curve of the tests needs by far.
const MOST_INTERVALS: usize = 20_000;
/// Steps of the search for the least speed, each to two thirds.
const THIRDS: usize = 90;
/// A cusp so near to an end that stands still itself is that end, by the parameter.
const SAME_PLACE: f64 = 1e-12;

/// Parameters inside a span at which it stands still, in order. The speed is at most `still` there.
///
/// The speed grows from a cusp in proportion to the distance on both sides, so that a search for the least speed between
/// three places finds it to rounding. Cusps that are so near to each other that the span has no speed between them have both ends of
/// their interval instead.
pub(super) fn cusps(span: &[Homogeneous], still: f64) -> Vec<f64> {
    // A polynomial of degree 2 that stands still is straight.
    if span.len() < 4 || still.is_nan() || still <= 0.0 {
        return Vec::new();
    }
    let Hodograph { coefficients, rounding } = Hodograph::of(span);
    let least_weight = span.iter().map(|h| h[3]).fold(f64::INFINITY, f64::min);
    let small = (0.5 * still * least_weight * least_weight).max(2.0 * rounding);
    let speed = |t: f64| jet(span, t).d1.norm();
    let points: Vec<Vector3<f64>> = span.iter().map(project).collect();
    let [from, to] = coincide(&points).map(|count| if count > 1 { SAME_PLACE } else { 0.0 });
    let inside = |&t: &f64| t > from && t < 1.0 - to && speed(t) <= still;
    let least = |[a, b]: [f64; 2]| {
        let (mut low, mut high) = ((a - (b - a)).max(0.0), (b + (b - a)).min(1.0));
        for _ in 0..THIRDS {
            let (x, y) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
            if speed(x) < speed(y) { high = y } else { low = x }
        }
        0.5 * (low + high)
    };
    let places = |[a, b]: [f64; 2]| if b - a > WIDE { vec![a, b] } else { vec![least([a, b])] };
    slow_intervals(coefficients, rounding, small).into_iter().flat_map(places).filter(inside).collect()
}

/// `N' w - N w'` of a span, and what rounding leaves of it where it vanishes.
struct Hodograph {
    coefficients: Vec<Vector3<f64>>,
    rounding: f64,
}

impl Hodograph {
    fn of(span: &[Homogeneous]) -> Self {
        let n = span.len() - 1;
        // A shift of the curve does not change it, and costs no digits where the curve starts in 0.
        let first: Vector3<f64> = project(&span[0]);
        let points: Vec<(Vector3<f64>, f64)> =
            span.iter().map(|h| (Vector3::new(h[0], h[1], h[2]) - first * h[3], h[3])).collect();
        let steps: Vec<(Vector3<f64>, f64)> = points.windows(2).map(|w| (w[1].0 - w[0].0, w[1].1 - w[0].1)).collect();
        let (lower, upper, product) = (binomials(n - 1), binomials(n), binomials(2 * n - 1));
        let mut coefficients = vec![Vector3::zeros(); 2 * n];
        for (i, (step, weight_step)) in steps.iter().enumerate() {
            for (k, (point, weight)) in points.iter().enumerate() {
                let share = n as f64 * lower[i] * upper[k] / product[i + k];
                coefficients[i + k] += (step * *weight - point * *weight_step) * share;
            }
        }
        let most = |values: &[(Vector3<f64>, f64)], part: fn(&(Vector3<f64>, f64)) -> f64| {
            values.iter().map(part).fold(0.0, f64::max)
        };
        let size = most(&points, |p| p.0.norm());
        let scale =
            n as f64 * (most(&steps, |p| p.0.norm()) * most(&points, |p| p.1) + size * most(&steps, |p| p.1.abs()));
        Self { coefficients, rounding: 32.0 * n as f64 * f64::EPSILON * scale }
    }
}

/// Binomial coefficients of `n`.
fn binomials(n: usize) -> Vec<f64> {
    let mut row = vec![1.0];
    for k in 0..n {
        row.push(row[k] * (n - k) as f64 / (k + 1) as f64);
    }
    row
}

/// Intervals of [0, 1] on which a vector polynomial may vanish, neighbours joined. It is at most `small` there.
fn slow_intervals(coefficients: Vec<Vector3<f64>>, rounding: f64, small: f64) -> Vec<[f64; 2]> {
    let mut found: Vec<[f64; 2]> = Vec::new();
    // The next interval is the last one, so that they come in order.
    let mut open = vec![(coefficients, [0.0, 1.0])];
    let mut looked = 0;
    while let Some((coefficients, [a, b])) = open.pop() {
        if points_forward(&coefficients, rounding) {
            continue;
        }
        looked += 1;
        let is_small = coefficients.iter().all(|c| c.norm() <= small);
        if is_small || b - a <= NARROWEST || looked > MOST_INTERVALS {
            match found.last_mut() {
                Some(last) if last[1] == a => last[1] = b,
                _ => found.push([a, b]),
            }
            continue;
        }
        let middle = 0.5 * (a + b);
        let (left, right) = halves(coefficients);
        open.push((right, [middle, b]));
        open.push((left, [a, middle]));
    }
    found
}

/// True where the sum of vectors has a product with each of them that rounding does not explain.
fn points_forward(vectors: &[Vector3<f64>], rounding: f64) -> bool {
    let Some(direction) = vectors.iter().sum::<Vector3<f64>>().try_normalize(0.0) else { return false };
    vectors.iter().all(|v| v.dot(&direction) > rounding)
}

/// Bernstein coefficients of both halves, by de Casteljau's algorithm.
fn halves(mut right: Vec<Vector3<f64>>) -> (Vec<Vector3<f64>>, Vec<Vector3<f64>>) {
    let n = right.len();
    let mut left = Vec::with_capacity(n);
    for r in (0..n).rev() {
        left.push(right[0]);
        for i in 0..r {
            right[i] = (right[i] + right[i + 1]) * 0.5;
        }
    }
    (left, right)
}
