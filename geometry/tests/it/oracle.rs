//! Evaluation and decomposition against values computed with 50 digits.
#![allow(clippy::unwrap_used)]

use crate::common;

use arcfeed_geometry::{Curve, NurbsCurve, nalgebra::SVector};
use common::{OracleCurve, oracle, published};
use serde::Deserialize;

#[derive(Deserialize)]
struct Values {
    bezier: Vec<OracleBezier>,
    samples: Vec<Sample>,
}

#[derive(Deserialize)]
struct OracleBezier {
    a: f64,
    b: f64,
    control_points: Vec<Vec<f64>>,
    weights: Vec<f64>,
}

#[derive(Deserialize)]
struct Sample {
    u: f64,
    point: Vec<f64>,
    d1: Vec<f64>,
    d2: Vec<f64>,
    d3: Vec<f64>,
    curvature: f64,
    signed_curvature: Option<f64>,
}

/// Largest relative errors of point, d1, d2, d3, curvature, decomposition.
type Worst = [f64; 6];

/// Relative error beyond what the rounding of `u` itself, by one unit in the last place, makes unavoidable: the value
/// moves by that times its derivative. (A point near the origin of a curve of size 100, or a derivative near 0, has no
/// more digits than that in double precision.)
fn relative<const D: usize>(ours: &SVector<f64, D>, theirs: &[f64], derivative: f64, u: f64) -> f64 {
    let theirs = SVector::<f64, D>::from_column_slice(theirs);
    ((ours - theirs).norm() - f64::EPSILON * u.abs() * derivative).max(0.0) / theirs.norm()
}

fn compare<const D: usize>(c: &OracleCurve<Values>, signed: impl Fn(&NurbsCurve<D>, f64) -> Option<f64>) -> Worst {
    let curve = c.data.curve::<D>();
    let mut worst = [0.0; 6];
    for s in &c.values.samples {
        let jet = curve.jet(s.u);
        let errors = [
            relative(&jet.point, &s.point, jet.d1.norm(), s.u),
            relative(&jet.d1, &s.d1, jet.d2.norm(), s.u),
            relative(&jet.d2, &s.d2, jet.d3.norm(), s.u),
            // A third derivative of 0 (degree 2 without weights) does not occur in the data.
            relative(&jet.d3, &s.d3, 0.0, s.u),
            (jet.curvature() - s.curvature).abs() / s.curvature,
        ];
        for (w, e) in worst.iter_mut().zip(errors) {
            *w = f64::max(*w, e);
        }
        if let (Some(ours), Some(theirs)) = (signed(&curve, s.u), s.signed_curvature) {
            assert_eq!(ours.signum(), theirs.signum(), "curve {} at {}", c.id, s.u);
        }
    }
    let pieces = curve.decompose();
    assert_eq!(pieces.len(), c.values.bezier.len());
    for (ours, theirs) in pieces.iter().zip(&c.values.bezier) {
        assert_eq!(ours.interval(), (theirs.a, theirs.b));
        for (p, q) in ours.control_points().zip(&theirs.control_points) {
            worst[5] = worst[5].max(relative(&p, q, 0.0, 0.0));
        }
        // Ours are relative to the largest weight of the curve.
        let largest = c.data.weights.iter().fold(0.0f64, |m, &w| m.max(w));
        for (w, v) in ours.weights().zip(&theirs.weights) {
            worst[5] = worst[5].max((w * largest - v).abs() / v);
        }
    }
    worst
}

#[test]
fn agrees_with_fifty_digits() {
    let mut worst = [0.0; 6];
    for c in &oracle::<Values>() {
        let w = if c.dim == 2 {
            compare::<2>(c, |curve, u| Some(curve.jet(u).signed_curvature()))
        } else {
            compare::<3>(c, |_, _| None)
        };
        println!("{} dim {} degree {}: {w:?}", c.id, c.dim, c.data.degree);
        for (a, b) in worst.iter_mut().zip(w) {
            *a = f64::max(*a, b);
        }
    }
    println!("worst: {worst:?}");
    for ((what, worst), allowed) in ["point", "d1", "d2", "d3", "curvature", "decomposition"]
        .iter()
        .zip(worst)
        .zip([1e-14, 1e-14, 1e-13, 1e-11, 1e-12, 1e-14])
    {
        assert!(worst <= allowed, "{what}: relative error {worst}");
    }
}

/// The Bezier pieces printed in Liu et al. 2023, Table 1, and in Actuators 2024, 13, 108, Table 1, with one error corrected
/// in each: Bezier 1, third point, is (8.5, 11) (printed 12); Bezier 3, second point, is (6.3333, 5.3333) (x and y
/// printed the wrong way round).
#[test]
fn decomposition_gives_the_printed_pieces() {
    type Piece = [[f64; 2]; 4];
    let liu: [Piece; 3] = [
        [[5.0, 4.0], [6.0, 12.0], [8.5, 11.0], [9.25, 9.5]],
        [[9.25, 9.5], [10.0, 8.0], [9.0, 6.0], [9.5, 4.75]],
        [[9.5, 4.75], [10.0, 3.5], [12.0, 3.0], [11.0, 9.0]],
    ];
    let actuators: [Piece; 4] = [
        [[1.0, 6.0], [2.0, 3.0], [3.5, 5.5], [4.4167, 5.9167]],
        [[4.4167, 5.9167], [5.3333, 6.3333], [5.6667, 4.6667], [6.0, 5.0]],
        [[6.0, 5.0], [6.3333, 5.3333], [6.6667, 7.6667], [7.3333, 7.3333]],
        [[7.3333, 7.3333], [8.0, 7.0], [9.0, 4.0], [12.0, 3.0]],
    ];
    for (name, printed) in [("six_points", &liu[..]), ("seven_points", &actuators[..])] {
        let pieces = published(name).decompose();
        assert_eq!(pieces.len(), printed.len());
        for (piece, printed) in pieces.iter().zip(printed) {
            for (p, q) in piece.control_points().zip(printed) {
                assert!((p.x - q[0]).abs() < 5.1e-5 && (p.y - q[1]).abs() < 5.1e-5, "{name}: {p} printed as {q:?}");
            }
        }
    }
}
