//! Tool poses by arc length: derivatives, sides at knots, corners.
#![allow(clippy::unwrap_used)]

use crate::common;

use arcfeed_geometry::nalgebra::{SVector, UnitQuaternion, Vector3, Vector6, vector};
use arcfeed_geometry::{ArcLengthCurve, NurbsCurve, OrientationPath, PoseJet, PosePath};
use common::published;

fn butterfly() -> ArcLengthCurve<3> {
    let flat = published("butterfly").lifted();
    let points = flat.control_points().iter().map(|p| p * 1e-3 + vector![0.4, 0.0, 0.2]).collect();
    let curve = NurbsCurve::new(3, points, flat.weights().to_vec(), flat.knots().as_slice().to_vec()).unwrap();
    ArcLengthCurve::new(curve, 1e-15).unwrap()
}

fn tumbling(curve: ArcLengthCurve<3>) -> PosePath {
    let n = curve.knots().len();
    // Every fourth key on a knot of the curve, but for rounding.
    let (knots, length) = (curve.knots(), curve.length());
    let mut keys = vec![(0.0, UnitQuaternion::identity())];
    for (i, s) in knots[1..n - 1].iter().enumerate().step_by(4) {
        let wobble = if i % 8 == 0 { 1e-15 } else { -1e-15 };
        let turn = vector![0.3 * (i as f64).sin(), 0.2, 0.05 * i as f64];
        keys.push((s + wobble, UnitQuaternion::from_scaled_axis(turn)));
    }
    keys.push((length, UnitQuaternion::from_scaled_axis(vector![0.5, 0.0, 3.0])));
    PosePath::new(curve, OrientationPath::through(&keys).unwrap())
}

fn difference<const N: usize>(f: impl Fn(f64) -> SVector<f64, N>, x: f64, h: f64) -> SVector<f64, N> {
    let weights = [4.0 / 5.0, -1.0 / 5.0, 4.0 / 105.0, -1.0 / 280.0];
    let mut sum = SVector::<f64, N>::zeros();
    for (k, w) in weights.iter().enumerate() {
        let step = (k + 1) as f64 * h;
        sum += (f(x + step) - f(x - step)) * (w / h);
    }
    sum
}

/// Displacement from one pose to another: of the tool point, and the rotation vector, in base axes.
fn displacement(from: &PoseJet, to: &PoseJet) -> Vector6<f64> {
    let linear = to.pose.translation.vector - from.pose.translation.vector;
    let angular = (to.pose.rotation * from.pose.rotation.inverse()).scaled_axis();
    Vector6::new(linear.x, linear.y, linear.z, angular.x, angular.y, angular.z)
}

#[test]
fn derivatives_are_twists_in_base_axes() {
    let path = tumbling(butterfly());
    for pair in path.knots().windows(2) {
        let (s, width) = (0.5 * (pair[0] + pair[1]), pair[1] - pair[0]);
        let jet = path.jet(s);
        let sharp = jet.d2.norm() + jet.d3.norm().sqrt() + 1.0 / width;
        let h = 0.01 / sharp;
        for (what, error, size) in [
            ("d1", difference(|x| displacement(&jet, &path.jet(x)), s, h) - jet.d1, jet.d1.norm()),
            ("d2", difference(|x| path.jet(x).d1, s, h) - jet.d2, sharp * jet.d1.norm()),
            ("d3", difference(|x| path.jet(x).d2, s, h) - jet.d3, sharp * sharp * jet.d1.norm()),
        ] {
            assert!(error.norm() < 1e-7 * size, "{what} at {s}: {} of {size}", error.norm());
        }
    }
}

#[test]
fn both_sides_of_every_knot() {
    let path = tumbling(butterfly());
    let knots = path.knots();
    // The keys have not added any: all are knots of the curve.
    assert_eq!(knots, path.curve().knots());
    assert!(knots.windows(2).all(|k| k[0] < k[1]));
    assert_eq!((knots[0], knots[knots.len() - 1]), (0.0, path.length()));
    let mut jumps = 0;
    for k in knots.windows(3) {
        let s = k[1];
        let (left, right) = (path.jet_left(s), path.jet(s));
        let (a, b) = (1e-7 * (k[1] - k[0]), 1e-7 * (k[2] - k[1]));
        // The one-sided values go on into their own side.
        for (here, there) in [(left, path.jet(s - a)), (right, path.jet(s + b))] {
            assert!(displacement(&here, &there).norm() < 1e-5);
            let scale = here.d3.norm() + 1.0;
            assert!((here.d3 - there.d3).norm() < 1e-4 * scale, "at {s}");
            let angular = here.d3.fixed_rows::<3>(3) - there.d3.fixed_rows::<3>(3);
            assert!(angular.norm() < 1e-4 * (here.d3.fixed_rows::<3>(3).norm() + 1.0), "at {s}");
        }
        // Pose and first derivative are continuous; so is the angular acceleration.
        // (The keys were moved by 1e-15 m, at rates of up to 1e3 rad/m.)
        assert!(displacement(&left, &right).norm() < 1e-11);
        assert!((left.d1 - right.d1).norm() < 1e-9 * right.d1.norm());
        let angular = (left.d2 - right.d2).fixed_rows::<3>(3).norm();
        assert!(angular < 1e-9 * right.d2.fixed_rows::<3>(3).norm().max(1e3));
        jumps += usize::from((left.d3 - right.d3).norm() > 1e-3 * right.d3.norm());
    }
    assert!(jumps > knots.len() / 2, "{jumps}");
}

#[test]
fn outside_means_the_nearest_end() {
    let path = tumbling(butterfly());
    for s in [-1.0, f64::NEG_INFINITY, f64::NAN] {
        assert_eq!(path.jet(s), path.jet(0.0));
        assert_eq!(path.jet_left(s), path.jet_left(0.0));
    }
    for s in [path.length() + 1.0, f64::INFINITY] {
        assert_eq!(path.jet(s), path.jet(path.length()));
    }
}

#[test]
fn keys_between_the_knots_of_the_curve() {
    let line = NurbsCurve::line(vector![0.0, 0.0, 0.0], vector![1.0, 0.0, 0.0]).unwrap();
    let q = |angle: f64| UnitQuaternion::from_axis_angle(&Vector3::z_axis(), angle);
    let keys = [(0.0, q(0.0)), (0.25, q(1.0)), (0.5, q(0.5)), (1.0, q(2.0))];
    let path = PosePath::new(ArcLengthCurve::new(line, 1e-14).unwrap(), OrientationPath::through(&keys).unwrap());
    assert_eq!(path.knots(), [0.0, 0.25, 0.5, 1.0]);
    let (left, right) = (path.jet_left(0.25), path.jet(0.25));
    assert!((left.d3[5] - path.jet(0.2).d3[5]).abs() < 1e-9);
    assert!((right.d3[5] - path.jet(0.3).d3[5]).abs() < 1e-9);
    assert!((left.d3[5] - right.d3[5]).abs() > 1.0);
    assert!((left.d2[5] - right.d2[5]).abs() < 1e-12 * right.d2[5].abs());
    for (s, key) in keys {
        assert!(path.pose(s).rotation.angle_to(&key) < 1e-14);
        assert!((path.pose(s).translation.vector - vector![s, 0.0, 0.0]).norm() < 1e-15);
    }
}

#[test]
fn corners_are_those_of_the_curve() {
    let corner = NurbsCurve::polyline(vec![vector![0.0, 0.0, 0.0], vector![1.0, 0.0, 0.0], vector![1.0, 1.0, 0.0]]);
    let curve = ArcLengthCurve::new(corner.unwrap(), 1e-12).unwrap();
    let path = PosePath::new(curve, OrientationPath::Constant(UnitQuaternion::identity()));
    let corners = path.corners(0.01);
    assert_eq!(corners.len(), 1);
    let s = corners[0].s;
    assert_eq!(path.jet_left(s).d1, Vector6::new(1.0, 0.0, 0.0, 0.0, 0.0, 0.0));
    assert_eq!(path.jet(s).d1, Vector6::new(0.0, 1.0, 0.0, 0.0, 0.0, 0.0));
}
