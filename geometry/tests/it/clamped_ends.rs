//! Ends of clamped curves: the point there is the control point to the last bit, with the derivatives of the curve.

use arcfeed_geometry::{Curve, NurbsCurve};
use arcfeed_testing::Random;
use nalgebra::{Vector3, vector};

/// A clamped rational curve of this degree with random points, weights and inner knots.
fn random_curve(random: &mut Random, degree: usize) -> NurbsCurve<3> {
    let count = degree + 1 + random.below(6);
    let points: Vec<Vector3<f64>> = (0..count)
        .map(|_| vector![random.between(-2.0, 2.0), random.between(-2.0, 2.0), random.between(-2.0, 2.0)])
        .collect();
    let weights = (0..count).map(|_| random.between(0.05, 4.0)).collect();
    let (start, mut knot) = (random.between(-3.0, 3.0), 0.0);
    let mut inner: Vec<f64> = (degree + 1..count)
        .map(|_| {
            knot += random.between(0.05, 1.0);
            start + knot
        })
        .collect();
    let end = start + knot + random.between(0.05, 1.0);
    let mut knots = vec![start; degree + 1];
    knots.append(&mut inner);
    knots.extend(vec![end; degree + 1]);
    NurbsCurve::new(degree, points, weights, knots).expect("a valid curve")
}

/// The first derivative at an end: `degree w1 / w0 (P1 - P0) / (width of the first inner span)` ("The NURBS Book", eq. 4.25).
fn end_derivative(degree: usize, points: [&Vector3<f64>; 2], weights: [f64; 2], width: f64) -> Vector3<f64> {
    (points[1] - points[0]) * (degree as f64 * weights[1] / (weights[0] * width))
}

#[test]
fn a_clamped_curve_ends_in_its_control_points_to_the_last_bit() {
    for seed in 0..2000_u64 {
        let mut random = Random::new(seed);
        let degree = 1 + (seed % 7) as usize;
        let curve = random_curve(&mut random, degree);
        let (points, weights, knots) = (curve.control_points(), curve.weights(), curve.knots().as_slice());
        let (a, b) = curve.domain();
        let last = points.len() - 1;
        for (u, point) in [(a, points[0]), (b, points[last]), (a - 1.0, points[0]), (b + 1.0, points[last])] {
            for found in [curve.point(u), curve.jet(u).point, curve.jet_left(u).point] {
                assert_eq!(found, point, "seed {seed}, degree {degree}, u = {u}");
            }
        }
        let start = end_derivative(degree, [&points[0], &points[1]], [weights[0], weights[1]], knots[degree + 1] - a);
        let width = b - knots[knots.len() - degree - 2];
        let end =
            -end_derivative(degree, [&points[last], &points[last - 1]], [weights[last], weights[last - 1]], width);
        for (jet, wanted) in [(curve.jet(a), start), (curve.jet_left(b), end)] {
            let off = (jet.d1 - wanted).norm() / (1.0 + wanted.norm());
            assert!(off < 1e-9, "seed {seed}, degree {degree}: derivative {} in place of {wanted}", jet.d1);
        }
    }
}
