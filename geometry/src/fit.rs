//! Curves through points, or near them within a tolerance.

use nalgebra::SVector;

use crate::banded::Banded;
use crate::basis::basis_functions;
use crate::chord::check_positive;
use crate::curve::Curve;
use crate::error::GeometryError;
use crate::knots::{KnotVector, NARROWEST};
use crate::nurbs::{NurbsCurve, check_points};

/// Highest degree of a fitted curve; above it the equations lose their digits.
const MAX_DEGREE: usize = 15;

/// Parameters closer together than this are not told apart.
const RESOLVED: f64 = 2.0 * NARROWEST;

/// Rounds of knot placement after which the least-squares fit gives way to interpolation.
const MAX_ROUNDS: usize = 64;

/// The spacing of data points over the parameter.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Spacing {
    /// In proportion to the distance between neighbours: the parameter runs nearly evenly with length.
    Chord,
    /// In proportion to the root of the distance (Lee 1989): swings less where distances change abruptly.
    #[default]
    Centripetal,
}

/// A polynomial spline fitted to points.
#[derive(Debug, Clone)]
pub struct Fit<const D: usize> {
    /// The curve, over [0, 1], clamped, starting in the first point and ending in the last.
    pub curve: NurbsCurve<D>,
    /// Parameter of the curve that belongs to each data point, strictly increasing from 0 to 1.
    pub parameters: Vec<f64>,
    /// No data point is farther than this from the curve, in the points' unit.
    pub max_deviation: f64,
}

impl<const D: usize> NurbsCurve<D> {
    /// The spline of `degree` through all `points`, in order (global interpolation with averaged knots; Piegl and
    /// Tiller, "The NURBS Book", section 9.2).
    ///
    /// First and last point may coincide; the curve then closes there, without being made smooth at the seam.
    ///
    /// # Errors
    /// Fails when there are fewer than degree + 1 points, the degree is 0 or above 15, two consecutive points coincide, a
    /// coordinate is not finite, or the points are spread so unevenly that the equations are singular to rounding.
    pub fn interpolate(points: &[SVector<f64, D>], degree: usize, spacing: Spacing) -> Result<Fit<D>, GeometryError> {
        check_input(points, degree, degree.saturating_add(1))?;
        interpolate(points, degree, spaced(points, spacing)?)
    }

    /// A spline of `degree` that passes all `points` within `tolerance`, with few control points.
    ///
    /// Least squares with fixed ends; knots are added in the middle of the data wherever a point is still too far away.
    /// If that leads no further (scattered points, a tolerance near rounding) the curve is laid through all points.
    /// The deviation is measured from each point to the curve near it, after the fit.
    ///
    /// # Errors
    /// As [`NurbsCurve::interpolate`], and when the tolerance is not a finite number above 0 or is not reached.
    pub fn approximate(
        points: &[SVector<f64, D>],
        degree: usize,
        spacing: Spacing,
        tolerance: f64,
    ) -> Result<Fit<D>, GeometryError> {
        check_positive("tolerance", tolerance)?;
        check_input(points, degree, degree.saturating_add(1))?;
        let parameters = spaced(points, spacing)?;
        let mut interior: Vec<f64> = Vec::new();
        for _ in 0..MAX_ROUNDS {
            let knots = clamped(degree, &interior)?;
            if knots.point_count() >= points.len() || !determined(&knots, &parameters) {
                break;
            }
            let Ok(curve) = least_squares(points, &parameters, knots) else { break };
            let distances = distances(&curve, points, &parameters);
            let max_deviation = distances.iter().fold(0.0f64, |m, &d| m.max(d));
            if max_deviation <= tolerance {
                return Ok(Fit { curve, parameters, max_deviation });
            }
            if !add_knots(&mut interior, &parameters, &distances, tolerance) {
                break;
            }
        }
        let fit = interpolate(points, degree, parameters)?;
        if fit.max_deviation <= tolerance {
            return Ok(fit);
        }
        let control_points = fit.curve.control_points().len();
        Err(GeometryError::FitTolerance { reached: fit.max_deviation, tolerance, control_points })
    }
}

fn check_input<const D: usize>(points: &[SVector<f64, D>], degree: usize, needed: usize) -> Result<(), GeometryError> {
    if degree == 0 {
        return Err(GeometryError::DegreeZero);
    }
    if degree > MAX_DEGREE {
        return Err(GeometryError::FitDegree { degree, limit: MAX_DEGREE });
    }
    if points.len() < needed {
        return Err(GeometryError::TooFewDataPoints { points: points.len(), needed });
    }
    check_points("data point", points)
}

/// Parameters of the points, from 0 to 1.
fn spaced<const D: usize>(points: &[SVector<f64, D>], spacing: Spacing) -> Result<Vec<f64>, GeometryError> {
    let step = |a: &SVector<f64, D>, b: &SVector<f64, D>| match spacing {
        Spacing::Chord => (b - a).norm(),
        Spacing::Centripetal => (b - a).norm().sqrt(),
    };
    let total: f64 = points.windows(2).map(|w| step(&w[0], &w[1])).sum();
    let mut sum = 0.0;
    let mut out = vec![0.0];
    for (index, w) in points.windows(2).enumerate() {
        sum += step(&w[0], &w[1]);
        let u = if index + 2 == points.len() { 1.0 } else { sum / total };
        // Also where two points differ, but by less than the parameter can resolve.
        let last = out[index];
        if u.is_nan() || u - last < RESOLVED || (1.0 - u < RESOLVED && index + 2 < points.len()) {
            return Err(GeometryError::DuplicatePoints { index, distance: (w[1] - w[0]).norm() });
        }
        out.push(u);
    }
    Ok(out)
}

fn clamped(degree: usize, interior: &[f64]) -> Result<KnotVector, GeometryError> {
    let mut knots = vec![0.0; degree + 1];
    knots.extend_from_slice(interior);
    knots.extend(std::iter::repeat_n(1.0, degree + 1));
    KnotVector::new(degree, knots)
}

fn interpolate<const D: usize>(
    points: &[SVector<f64, D>],
    degree: usize,
    parameters: Vec<f64>,
) -> Result<Fit<D>, GeometryError> {
    let n = points.len();
    let interior: Vec<f64> =
        (1..n - degree).map(|j| parameters[j..j + degree].iter().sum::<f64>() / degree as f64).collect();
    let knots = clamped(degree, &interior)?;
    // With averaged knots the basis function of every point is not 0 there (Schoenberg and Whitney), so that no entry is
    // farther than the degree from the diagonal.
    let mut matrix = Banded::zeros(n, degree, degree);
    let mut values = Vec::new();
    for (row, &u) in parameters.iter().enumerate() {
        let first = basis_functions(&knots, u, &mut values);
        if !(first..=first + degree).contains(&row) {
            return Err(SINGULAR);
        }
        for (j, &v) in values.iter().enumerate() {
            matrix.add(row, first + j, v);
        }
    }
    let mut control = solved(matrix, points.to_vec())?;
    // The ends are known exactly.
    (control[0], control[n - 1]) = (points[0], points[n - 1]);
    let curve = NurbsCurve::bspline(degree, control, knots.as_slice().to_vec())?;
    let max_deviation = distances(&curve, points, &parameters).into_iter().fold(0.0f64, f64::max);
    Ok(Fit { curve, parameters, max_deviation })
}

/// Least squares with the end points fixed (Piegl and Tiller, section 9.4.1), by the banded normal equations.
fn least_squares<const D: usize>(
    points: &[SVector<f64, D>],
    parameters: &[f64],
    knots: KnotVector,
) -> Result<NurbsCurve<D>, GeometryError> {
    let (p, n, m) = (knots.degree(), knots.point_count(), points.len());
    let (start, end) = (points[0], points[m - 1]);
    let mut control = vec![start; n];
    control[n - 1] = end;
    let unknowns = n - 2;
    if unknowns > 0 {
        let mut matrix = Banded::zeros(unknowns, p, p);
        let mut right = vec![SVector::zeros(); unknowns];
        let mut values = Vec::new();
        for (point, &u) in points.iter().zip(parameters).skip(1).take(m - 2) {
            let first = basis_functions(&knots, u, &mut values);
            let mut rest = *point;
            for (j, &v) in values.iter().enumerate() {
                match first + j {
                    0 => rest -= start * v,
                    i if i == n - 1 => rest -= end * v,
                    _ => {}
                }
            }
            for (j, &v) in values.iter().enumerate() {
                let i = first + j;
                if i == 0 || i == n - 1 {
                    continue;
                }
                right[i - 1] += rest * v;
                for (k, &w) in values.iter().enumerate() {
                    if first + k > 0 && first + k < n - 1 {
                        matrix.add(i - 1, first + k - 1, v * w);
                    }
                }
            }
        }
        control[1..n - 1].copy_from_slice(&solved(matrix, right)?);
    }
    NurbsCurve::bspline(p, control, knots.as_slice().to_vec())
}

const SINGULAR: GeometryError =
    GeometryError::SingularFit { reason: "the points leave a control point undetermined; lower the degree" };

fn solved<const D: usize>(matrix: Banded, right: Vec<SVector<f64, D>>) -> Result<Vec<SVector<f64, D>>, GeometryError> {
    let solution = matrix.solve(right).ok_or(SINGULAR)?;
    if solution.iter().all(|p| p.iter().all(|x| x.is_finite())) { Ok(solution) } else { Err(SINGULAR) }
}

/// True where every basis function has a data point of its own (Schoenberg and Whitney), so that the least-squares fit is
/// unique.
fn determined(knots: &KnotVector, parameters: &[f64]) -> bool {
    let (t, p, n) = (knots.as_slice(), knots.degree(), knots.point_count());
    let mut j = 0;
    (0..n).all(|i| {
        let (from, to) = (t[i], t[i + p + 1]);
        let inside = |u: f64| (from < u && u < to) || (i == 0 && u == from) || (i == n - 1 && u == to);
        while j < parameters.len() && !inside(parameters[j]) {
            j += 1;
        }
        j += 1;
        j <= parameters.len()
    })
}

/// Adds a knot in the middle of the data of every span that holds a point farther away than the tolerance. False where
/// no span can be divided any more.
fn add_knots(interior: &mut Vec<f64>, parameters: &[f64], distances: &[f64], tolerance: f64) -> bool {
    let mut added = Vec::new();
    let mut begin = 0;
    for end_knot in interior.iter().copied().chain([f64::INFINITY]) {
        let end = parameters.partition_point(|&u| u < end_knot);
        let data = begin..end;
        begin = end;
        if data.len() < 2 || distances[data.clone()].iter().all(|&d| d <= tolerance) {
            continue;
        }
        let middle = data.start + data.len() / 2;
        let knot = 0.5 * (parameters[middle - 1] + parameters[middle]);
        if parameters[middle - 1] < knot && knot < 1.0 {
            added.push(knot);
        }
    }
    let any = !added.is_empty();
    interior.extend(added);
    interior.sort_by(f64::total_cmp);
    any
}

/// Distance of each point from the curve between the parameters of its neighbours.
fn distances<const D: usize>(curve: &NurbsCurve<D>, points: &[SVector<f64, D>], parameters: &[f64]) -> Vec<f64> {
    let last = parameters.len() - 1;
    let near = |i: usize| (parameters[i.saturating_sub(1)], parameters[(i + 1).min(last)]);
    points.iter().zip(parameters).enumerate().map(|(i, (p, &u))| distance_near(curve, p, u, near(i))).collect()
}

/// Distance of a point from the curve, from the parameter `u` on and within a range around it: never below the true distance.
fn distance_near<const D: usize>(
    curve: &NurbsCurve<D>,
    point: &SVector<f64, D>,
    u: f64,
    (least, most): (f64, f64),
) -> f64 {
    let mut best = (curve.point(u) - point).norm();
    let mut u = u;
    for _ in 0..4 {
        let jet = curve.jet(u);
        let away = jet.point - point;
        // Newton's method on the squared distance, with the curvature term left out where it would turn the step around.
        let bend = jet.d1.norm_squared();
        let full = bend + away.dot(&jet.d2);
        let step = away.dot(&jet.d1) / if full > 0.5 * bend { full } else { bend };
        if !step.is_finite() {
            break;
        }
        u = (u - step).max(least).min(most);
        let distance = (curve.point(u) - point).norm();
        if distance >= best {
            break;
        }
        best = distance;
    }
    best
}
