//! Large fits: their banded equations against a general sparse solver that knows nothing of bands.

use arcfeed_geometry::nalgebra::SVector;
use arcfeed_geometry::{Curve, KnotVector, NurbsCurve, Spacing, basis_functions};
use faer::linalg::solvers::Solve;
use faer::sparse::{SparseColMat, Triplet};
use faer::{Mat, Side};

/// The basis functions that do not vanish at each parameter, as (row, column, value).
fn collocation(knots: &KnotVector, parameters: &[f64]) -> Vec<(usize, usize, f64)> {
    let mut entries = Vec::new();
    let mut values = Vec::new();
    for (row, &u) in parameters.iter().enumerate() {
        let first = basis_functions(knots, u, &mut values);
        entries.extend(values.iter().enumerate().map(|(j, &v)| (row, first + j, v)));
    }
    entries
}

fn matrix(n: usize, entries: &[Triplet<usize, usize, f64>]) -> SparseColMat<usize, f64> {
    SparseColMat::try_new_from_triplets(n, n, entries).expect("solvable")
}

fn rows<const D: usize>(m: &Mat<f64>) -> Vec<SVector<f64, D>> {
    (0..m.nrows()).map(|i| SVector::from_fn(|l, _| m[(i, l)])).collect()
}

/// Control points of the spline through `points`.
fn interpolated<const D: usize>(
    knots: &KnotVector,
    parameters: &[f64],
    points: &[SVector<f64, D>],
) -> Vec<SVector<f64, D>> {
    let n = points.len();
    let entries: Vec<_> = collocation(knots, parameters).iter().map(|&(i, j, v)| Triplet::new(i, j, v)).collect();
    rows(&matrix(n, &entries).sp_lu().expect("solvable").solve(Mat::from_fn(n, D, |i, l| points[i][l])))
}

/// Control points of the spline that is nearest to `points` in the sum of squares and starts and ends in the first and last.
fn least_squares<const D: usize>(
    knots: &KnotVector,
    parameters: &[f64],
    points: &[SVector<f64, D>],
) -> Vec<SVector<f64, D>> {
    let last = knots.point_count() - 1;
    let (start, end) = (points[0], points[points.len() - 1]);
    let mut normal = Vec::new();
    let mut right: Mat<f64> = Mat::zeros(last - 1, D);
    for row in collocation(knots, parameters).chunk_by(|a, b| a.0 == b.0) {
        let fixed = |rest: SVector<f64, D>, &(_, j, v): &(usize, usize, f64)| match j {
            0 => rest - start * v,
            _ if j == last => rest - end * v,
            _ => rest,
        };
        let rest = row.iter().fold(points[row[0].0], fixed);
        let inner = || row.iter().filter(|&&(_, j, _)| 0 < j && j < last);
        for &(_, j, v) in inner() {
            (0..D).for_each(|l| right[(j - 1, l)] += v * rest[l]);
            normal.extend(inner().map(|&(_, k, w)| Triplet::new(j - 1, k - 1, v * w)));
        }
    }
    let solution = matrix(last - 1, &normal).sp_cholesky(Side::Lower).expect("solvable").solve(&right);
    [vec![start], rows(&solution), vec![end]].concat()
}

/// Greatest difference of two control polygons, by the size of the second.
fn apart<const D: usize>(a: &[SVector<f64, D>], b: &[SVector<f64, D>]) -> f64 {
    assert_eq!(a.len(), b.len());
    let size = b.iter().fold(0.0f64, |m, p| m.max(p.amax()));
    a.iter().zip(b).map(|(a, b)| (a - b).amax()).fold(0.0, f64::max) / size
}

#[test]
fn large_fits_agree_with_general_sparse_solvers() {
    let butterfly = robot_cr7::butterfly().expect("built in").plane_curve().expect("a plane curve");
    let points: Vec<_> = (0..=20_000).map(|i| butterfly.point(f64::from(i) / 20_000.0)).collect();
    for degree in [2, 3, 5] {
        let fit = NurbsCurve::interpolate(&points, degree, Spacing::Centripetal).expect("distinct points");
        let expected = interpolated(fit.curve.knots(), &fit.parameters, &points);
        let apart = apart(fit.curve.control_points(), &expected);
        println!("interpolation of degree {degree}: {apart}");
        assert!(apart < 1e-13);
    }
    for (degree, tolerance) in [(2, 1e-3), (3, 1e-4), (5, 1e-4)] {
        let fit = NurbsCurve::approximate(&points, degree, Spacing::Chord, tolerance).expect("distinct points");
        assert!(fit.curve.control_points().len() < points.len());
        let expected = least_squares(fit.curve.knots(), &fit.parameters, &points);
        let apart = apart(fit.curve.control_points(), &expected);
        println!("least squares of degree {degree}, {} points: {apart}", expected.len());
        assert!(apart < 1e-12);
    }
}
