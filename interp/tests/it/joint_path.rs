//! Joint positions and derivatives along a path, against differences of the inverse; the choice of the start.

use crate::common;

use arcfeed_geometry::{NurbsCurve, OrientationPath, PosePath};
use arcfeed_interp::{JointPath, MotionPath, PathError, ToolPath};
use arcfeed_kinematics::{
    AnalyticInverse, ForwardKinematics, InverseKinematics, Joints, KinematicsError, ParallelAxisArm, ReachSide,
    smallest_singular_value,
};
use common::{analytic, arm, by_length, down, knotted, tool_down};
use nalgebra::{Unit, UnitQuaternion, Vector3, vector};

/// Weights by which values at `x` sum up to the `order`-th derivative at 0 (Fornberg 1988).
fn weights(x: &[f64], order: usize) -> Vec<f64> {
    let n = x.len();
    let mut c = vec![vec![0.0; order + 1]; n];
    c[0][0] = 1.0;
    let mut c1 = 1.0;
    for i in 1..n {
        let mut c2 = 1.0;
        for j in 0..i {
            let c3 = x[i] - x[j];
            c2 *= c3;
            if j == i - 1 {
                for k in (0..=order.min(i)).rev() {
                    let lower = if k > 0 { k as f64 * c[i - 1][k - 1] } else { 0.0 };
                    c[i][k] = c1 * (lower - x[i - 1] * c[i - 1][k]) / c2;
                }
            }
            for k in (0..=order.min(i)).rev() {
                let lower = if k > 0 { k as f64 * c[j][k - 1] } else { 0.0 };
                c[j][k] = (x[i] * c[j][k] - lower) / c3;
            }
        }
        c1 = c2;
    }
    c.into_iter().map(|row| row[order]).collect()
}

#[test]
fn the_difference_weights_are_right() {
    // The third derivative of x^5 at 1.
    let h: Vec<f64> = (-4..=4).map(|i| f64::from(i) * 0.1).collect();
    let d3: f64 = weights(&h, 3).iter().zip(&h).map(|(w, h)| w * (1.0 + h).powi(5)).sum();
    assert!((d3 - 60.0).abs() < 1e-9, "{d3}");
}

/// The `order`-th derivative by arc length of the joints at `s`, from positions at `s + h`.
fn by_differences(arm: &ParallelAxisArm, path: &PosePath, s: f64, q: &Joints<6>, h: &[f64], order: usize) -> Joints<6> {
    let mut sum = Joints::zeros();
    for (w, h) in weights(h, order).iter().zip(h) {
        sum += *w * (arm.inverse(&path.pose(s + h), q).expect("in reach") - q);
    }
    sum
}

fn paths() -> Vec<(&'static str, PosePath)> {
    let curve = by_length(analytic());
    let turn = UnitQuaternion::from_scaled_axis(vector![0.3, -0.4, 0.5]);
    let slerp = OrientationPath::slerp(curve.length(), down(), turn * down()).expect("a length above 0");
    vec![("constant", tool_down(analytic())), ("slerp", PosePath::new(curve, slerp))]
}

fn compare(name: &str, s: f64, order: usize, ours: &Joints<6>, differences: &Joints<6>, relative: f64) {
    let size = differences.amax();
    let off = (ours - differences).amax();
    assert!(off <= relative * (size + 1.0), "{name}, s = {s}, derivative {order}: {ours} and {differences}: off {off}");
}

#[test]
fn derivatives_agree_with_differences_of_the_inverse() {
    let arm = arm();
    for (name, path) in paths() {
        let followed = ToolPath::new(&arm, path.clone(), arm.range()).expect("in reach");
        let mut seed = followed.start();
        let length = path.length();
        for i in 1..20 {
            let s = length * f64::from(i) / 20.0;
            let jet = followed.jet(s, &seed).expect("in reach");
            seed = jet.q;
            let reached = arm.forward(&jet.q);
            assert!((reached.translation.vector - path.pose(s).translation.vector).norm() < 1e-13);
            assert!(reached.rotation.angle_to(&path.pose(s).rotation) < 1e-7);
            let h: Vec<f64> = (-5..=5).map(|i| f64::from(i) * 1.5e-3).collect();
            compare(name, s, 1, &jet.d1, &by_differences(&arm, &path, s, &jet.q, &h, 1), 1e-9);
            compare(name, s, 2, &jet.d2, &by_differences(&arm, &path, s, &jet.q, &h, 2), 1e-7);
            compare(name, s, 3, &jet.d3, &by_differences(&arm, &path, s, &jet.q, &h, 3), 1e-5);
        }
    }
}

#[test]
fn a_heading_that_follows_the_tangent_has_the_right_derivatives() {
    let arm = arm();
    let curve = by_length(analytic());
    let tangent = curve.jet(0.0).d1;
    let x = (tangent - Vector3::z() * tangent.z).normalize();
    let z = -Vector3::z();
    let axes = nalgebra::Rotation3::from_basis_unchecked(&[x, z.cross(&x), z]);
    let start = UnitQuaternion::from_rotation_matrix(&axes);
    let heading =
        OrientationPath::following_tangent(&curve, Unit::new_normalize(z), start, 1e-3).expect("a heading everywhere");
    let knots = heading.knots().to_vec();
    let path = PosePath::new(curve, heading);
    let followed = ToolPath::new(&arm, path.clone(), arm.range()).expect("in reach");
    let mut seed = followed.start();
    let mut looked_at = 0;
    // Between the knots of the heading's spline everything is smooth.
    for pair in knots.windows(2) {
        let (s, room) = (0.5 * (pair[0] + pair[1]), 0.5 * (pair[1] - pair[0]));
        let jet = followed.jet(s, &seed).expect("in reach");
        seed = jet.q;
        let h: Vec<f64> = (-4..=4).map(|i| f64::from(i) * room.min(8e-3) / 4.5).collect();
        compare("tangent", s, 1, &jet.d1, &by_differences(&arm, &path, s, &jet.q, &h, 1), 1e-6);
        compare("tangent", s, 2, &jet.d2, &by_differences(&arm, &path, s, &jet.q, &h, 2), 1e-4);
        // Rounding of the third difference grows with the cube of the step's inverse.
        if room > 2e-3 {
            compare("tangent", s, 3, &jet.d3, &by_differences(&arm, &path, s, &jet.q, &h, 3), 1e-3);
        }
        looked_at += 1;
        // The tool's x axis follows the tangent, seen from above.
        let (x, t) = (path.pose(s).rotation * Vector3::x(), path.curve().jet(s).d1);
        let angle = (x.x * t.y - x.y * t.x).atan2(x.x * t.x + x.y * t.y);
        assert!(angle.abs() <= 1.1e-3, "the tool's x axis is {angle} rad off the tangent at s = {s}");
    }
    assert!(looked_at > 3);
}

#[test]
fn both_sides_of_a_knot_are_right() {
    let arm = arm();
    let path = tool_down(knotted());
    let knots = path.knots();
    assert_eq!(knots.len(), 5, "three inner knots and the ends");
    let mut grid: Vec<f64> =
        (0..=50).map(|i| path.length() * f64::from(i) / 50.0).chain(knots.iter().copied()).collect();
    grid.sort_by(f64::total_cmp);
    grid.dedup();
    let followed = ToolPath::new(&arm, path.clone(), arm.range()).expect("in reach");
    let joints = JointPath::follow(&followed, &grid).expect("in reach");
    assert_eq!(joints.nodes().len(), grid.len());
    assert_eq!(joints.intervals(), grid.len() - 1);
    let mut jumps = 0;
    for (i, &s) in grid.iter().enumerate() {
        let (left, right) = joints.sides(i);
        assert_eq!((left.s, right.s, left.q), (s, s, right.q));
        if !knots[1..4].contains(&s) {
            assert_eq!(left, right, "no knot at s = {s}");
            continue;
        }
        for (side, jet, sign) in [("left", left, -1.0), ("right", right, 1.0)] {
            let h: Vec<f64> = (0..9).map(|i| sign * f64::from(i) * 1e-3).collect();
            compare(side, s, 1, &jet.d1, &by_differences(&arm, &path, s, &jet.q, &h, 1), 1e-7);
            compare(side, s, 2, &jet.d2, &by_differences(&arm, &path, s, &jet.q, &h, 2), 1e-5);
            compare(side, s, 3, &jet.d3, &by_differences(&arm, &path, s, &jet.q, &h, 3), 1e-3);
        }
        // A cubic spline with single knots keeps position, tangent and curvature, not the third derivative.
        assert!((left.d1 - right.d1).amax() < 1e-9 * right.d1.amax());
        assert!((left.d2 - right.d2).amax() < 1e-8 * right.d2.amax());
        assert!((left.d3 - right.d3).amax() > 1e-2 * right.d3.amax());
        jumps += 1;
        // Intervals take the side that lies inside them.
        assert_eq!(joints.interval(i - 1).1, left);
        assert_eq!(joints.interval(i).0, right);
    }
    assert_eq!(jumps, 3);
    // `near` predicts between the grid points.
    for i in 0..200 {
        let s = path.length() * (f64::from(i) + 0.3) / 200.0;
        let q = arm.inverse(&path.pose(s), &joints.near(s).q).expect("in reach");
        assert!((q - joints.near(s).q).amax() < 1e-3, "at s = {s}");
    }
}

/// Smallest singular value and room to the joint limits on a fine walk, or `None` where the branch ends.
fn quality(arm: &ParallelAxisArm, path: &PosePath, start: &Joints<6>) -> Option<f64> {
    let mut q = *start;
    let mut least = f64::INFINITY;
    for i in 0..=1000 {
        let s = path.length() * f64::from(i) / 1000.0;
        let next = arm.inverse(&path.pose(s), &q).ok()?;
        if (next - q).amax() > 0.3 {
            return None;
        }
        let (lower, upper) = (arm.range().lower(), arm.range().upper());
        let room = (next - lower).zip_map(&(upper - next), f64::min).min();
        least = least.min(smallest_singular_value(&arm.jacobian(&next))).min(0.1 * room);
        q = next;
    }
    Some(least)
}

#[test]
fn the_best_start_is_the_best_of_all_branches() {
    let arm = arm();
    for (name, path) in paths().into_iter().chain([("knotted", tool_down(knotted()))]) {
        let start = ToolPath::new(&arm, path.clone(), arm.range()).expect("in reach").start();
        let reached = arm.forward(&start);
        assert!((reached.translation.vector - path.pose(0.0).translation.vector).norm() < 1e-12, "{name}");
        let best = quality(&arm, &path, &start).expect("the chosen branch goes to the end");
        for other in &arm.inverse_all(&path.pose(0.0)).expect("in reach") {
            // The walk of the library is coarser than the one here.
            let other = quality(&arm, &path, other).unwrap_or(0.0);
            assert!(best >= 0.98 * other, "{name}: {best} chosen, {other} there");
        }
    }
}

#[test]
fn a_start_out_of_reach_says_by_how_much() {
    let arm = arm();
    let best = |a, b| ToolPath::new(&arm, tool_down(NurbsCurve::line(a, b).expect("a line")), arm.range());
    match best(vector![2.0, 0.1, 0.2], vector![2.1, 0.1, 0.2]) {
        Err(PathError::Arm { place, source: KinematicsError::Unreachable { distance, side } }) => {
            assert_eq!((place.s, side), (0.0, ReachSide::TooFar));
            let position = place.tool.expect("a tool path");
            assert!((Vector3::from(position) - vector![2.0, 0.1, 0.2]).norm() < 1e-12, "{position:?}");
            // The stretched arm reaches 0.8172 m from the shoulder, plus offsets of the wrist.
            assert!((0.9..1.3).contains(&distance), "{distance}");
        }
        other => panic!("{other:?}"),
    }
    // It starts in reach and leaves it: every branch is named as failing, the best one with the place.
    match best(vector![0.5, 0.1, 0.2], vector![1.5, 0.1, 0.2]) {
        Err(PathError::NoConfiguration { candidates, best }) => {
            assert_eq!(candidates, arm.inverse_all(&tool_down(analytic()).pose(0.0)).expect("in reach").len());
            match *best {
                PathError::Arm { place, .. } => {
                    let (s, position) = (place.s, place.tool.expect("a tool path"));
                    assert!((position[0] - 0.5 - s).abs() < 1e-12, "{position:?} at {s}");
                    assert!((0.2..0.5).contains(&s), "the reach ends at {s} m");
                }
                other => panic!("{other:?}"),
            }
        }
        other => panic!("{other:?}"),
    }
}
