//! Random curves for the property tests.

use arcfeed_geometry::{NurbsCurve, nalgebra::SVector};
use proptest::prelude::*;

/// Curves of degree 1 to 5 with weights 0.2 to 5, interior knots of multiplicity 1 to degree, clamped, on domains away
/// from [0, 1] too.
pub fn curve<const D: usize>() -> impl Strategy<Value = NurbsCurve<D>> {
    (1usize..=5, proptest::collection::vec((0.05f64..1.0, 1usize..=5), 0..6), -3.0f64..3.0).prop_flat_map(
        |(degree, spans, start)| {
            let mut knots = vec![start; degree + 1];
            let mut u = start;
            for &(step, multiplicity) in &spans {
                u += step;
                knots.extend(std::iter::repeat_n(u, multiplicity.min(degree)));
            }
            knots.extend(std::iter::repeat_n(u + 0.4, degree + 1));
            let count = knots.len() - degree - 1;
            let points = proptest::collection::vec(proptest::collection::vec(-100.0f64..100.0, D), count);
            let weights = prop_oneof![proptest::collection::vec(0.2f64..5.0, count), Just(vec![1.0; count]),];
            (points, weights).prop_map(move |(points, weights)| {
                let points = points.iter().map(|p| SVector::from_column_slice(p)).collect();
                NurbsCurve::new(degree, points, weights, knots.clone()).unwrap()
            })
        },
    )
}

/// A clamped curve's knots with the repetitions at both ends pulled apart, so that it starts and ends inside.
pub fn unclamped<const D: usize>() -> impl Strategy<Value = NurbsCurve<D>> {
    curve::<D>().prop_map(|c| {
        let p = c.degree();
        let mut knots = c.knots().as_slice().to_vec();
        let n = knots.len();
        for i in 0..p {
            knots[i] -= 0.3 * (p - i) as f64;
            knots[n - 1 - i] += 0.2 * (p - i) as f64;
        }
        NurbsCurve::new(p, c.control_points().to_vec(), c.weights().to_vec(), knots).unwrap()
    })
}

/// So many cases; failing input is printed, not written to files.
pub fn cases(cases: u32) -> ProptestConfig {
    ProptestConfig { cases, failure_persistence: None, ..ProptestConfig::default() }
}
