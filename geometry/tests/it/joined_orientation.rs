//! Orientation along paths of many pieces.
#![allow(clippy::unwrap_used)]

use crate::common::{mixed, polylines::joined};

use arcfeed_geometry::nalgebra::{UnitQuaternion, Vector3, vector};
use arcfeed_geometry::{ArcLengthCurve, Blending, GeometryError, JoinedPath, JointOutcome, OrientationPath, PieceKind};
use arcfeed_testing::Random;

fn rotation(r: &mut Random, largest: f64) -> UnitQuaternion<f64> {
    UnitQuaternion::from_scaled_axis(vector![r.signed(), r.signed(), r.signed()].normalize() * r.between(0.0, largest))
}

fn by_length(path: &JoinedPath) -> ArcLengthCurve<3> {
    ArcLengthCurve::new(path.to_curve().unwrap(), 1e-10).unwrap()
}

/// The programmed orientation at a place of the blended path, told from the report alone: pieces are numbered in
/// order, each is shortened by what the blends at its ends take, and each half of a blend runs through what is
/// taken on its side.
fn programmed(
    place: (usize, f64),
    blends: &[Option<[f64; 2]>],
    lengths: &[f64],
    keys: &[UnitQuaternion<f64>],
) -> UnitQuaternion<f64> {
    let (index, part) = place;
    // Pieces and blends in their order along the path.
    let mut order = Vec::new();
    for (i, length) in lengths.iter().enumerate() {
        let from = if i > 0 { blends[i - 1].map_or(0.0, |t| t[1]) } else { 0.0 };
        let to = length - blends.get(i).copied().flatten().map_or(0.0, |t| t[0]);
        if to - from > 1e-6 * length {
            order.push((i, from, to, None));
        }
        if let Some(Some(t)) = blends.get(i) {
            order.push((i, length - t[0], *length, Some(t[1])));
        }
    }
    let (piece, from, to, next) = order[index];
    let (piece, x) = match next {
        Some(_) if part <= 0.5 => (piece, from + 2.0 * part * (to - from)),
        Some(taken) => (piece + 1, (2.0 * part - 1.0) * taken),
        None => (piece, from + part * (to - from)),
    };
    keys[piece].slerp(&keys[piece + 1], x / lengths[piece])
}

#[test]
fn random_orientations_are_within_the_tolerance_and_continuous() {
    for seed in 0..150 {
        let r = &mut Random::new(seed);
        let path = if seed % 3 == 0 {
            mixed::path(r)
        } else {
            joined(&(0..6).map(|i| vector![10.0 * f64::from(i), 8.0 * r.signed(), r.signed()]).collect::<Vec<_>>())
        };
        let sources = path.pieces().iter().map(|p| p.sources[0]).max().unwrap();
        if sources + 1 != path.pieces().len() {
            continue;
        }
        let mut keys = vec![rotation(r, 3.0)];
        for i in 0..path.pieces().len() {
            keys.push(keys[i] * rotation(r, 2.0));
        }
        let tolerance = r.log(1e-5, 1e-1);
        let blended = path.blended(&Blending::within(r.log(1e-3, 1.0))).unwrap();
        let curve = by_length(&blended.path);
        let orientation = blended.path.orientation(&curve, &keys, tolerance).unwrap();
        let blends: Vec<Option<[f64; 2]>> = blended
            .joints
            .iter()
            .map(|(_, o)| if let JointOutcome::Blended { taken, .. } = o { Some(*taken) } else { None })
            .collect();
        let lengths: Vec<f64> = path.pieces().iter().map(|p| p.length).collect();
        let mut largest = 0.0f64;
        for (index, piece) in blended.path.pieces().iter().enumerate() {
            let middle = curve.arc_length_at(0.5 * (piece.start + piece.end));
            let (s0, s1) = (curve.arc_length_at(piece.start), curve.arc_length_at(piece.end));
            for k in 0..=100 {
                let part = f64::from(k) / 100.0;
                // Halves of a blend in the parameter, each in step with the arc length.
                let s = match piece.kind {
                    PieceKind::Blend if part <= 0.5 => s0 + 2.0 * part * (middle - s0),
                    PieceKind::Blend => middle + (2.0 * part - 1.0) * (s1 - middle),
                    _ => s0 + part * (s1 - s0),
                };
                let expected = programmed((index, part), &blends, &lengths, &keys);
                largest = largest.max(orientation.jet(s).rotation.angle_to(&expected));
            }
        }
        assert!(largest <= tolerance * (1.0 + 1e-6) + 1e-8, "seed {seed}: {largest:e} of {tolerance:e}");
        let knots = orientation.knots();
        for around in knots.windows(3) {
            let (left, right) = (orientation.jet_left(around[1]), orientation.jet(around[1]));
            let width = (around[1] - around[0]).min(around[2] - around[1]);
            assert!(left.rotation.angle_to(&right.rotation) < 1e-9, "seed {seed}");
            let rate = |k: i32| orientation.jet(around[0] + (around[2] - around[0]) * f64::from(k) / 40.0).rate.norm();
            let within = |k: i32, a: f64| orientation.jet(a + width * f64::from(k) / 20.0).rate.norm();
            let near = (-20..=20).map(|k| within(k, around[1]));
            let fastest = near.chain((0..=40).map(rate)).fold(0.0, f64::max);
            assert!((left.rate - right.rate).norm() < 1e-7 * fastest + 1e-9, "seed {seed}: {left:?} {right:?}");
            assert!(
                (left.d_rate - right.d_rate).norm() * width < 1e-6 * fastest + 1e-9,
                "seed {seed}: {left:?} {right:?}"
            );
        }
        for (i, key) in [(0.0, keys[0]), (curve.length(), keys[keys.len() - 1])] {
            assert!(orientation.jet(i).rotation.angle_to(&key) < 1e-12);
        }
    }
}

#[test]
fn the_tolerance_is_used() {
    // A turn of 1 rad along the first line, none along the second: the rate jumps by 0.1 rad/mm.
    let path = joined(&[vector![0.0, 0.0, 0.0], vector![10.0, 0.0, 0.0], vector![20.0, 0.0, 0.0]]);
    let turned = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), 1.0);
    let keys = [UnitQuaternion::identity(), turned, turned];
    let curve = by_length(&path);
    let orientation = path.orientation(&curve, &keys, 1e-3).unwrap();
    assert!((orientation.jet(10.0).rotation.angle_to(&turned) - 1e-3).abs() < 1e-12);
    let half = 1e-3 / (3.0 / 16.0 * 0.1);
    for (s, angle) in [(0.0, 0.0), (5.0, 0.5), (10.0 - half, 1.0 - 0.1 * half), (10.0 + half, 1.0), (20.0, 1.0)] {
        assert!((orientation.jet(s).rotation.angle() - angle).abs() < 1e-12, "at {s}");
    }
    // A tolerance that is wider than the pieces: half of each.
    let wide = path.orientation(&curve, &keys, 1.0).unwrap();
    assert_eq!(wide.knots(), [0.0, 5.0, 15.0, 20.0]);
}

#[test]
fn equal_keys_are_constant_and_bad_ones_refused() {
    let path = joined(&[vector![0.0, 0.0, 0.0], vector![10.0, 0.0, 0.0], vector![10.0, 5.0, 0.0]]);
    let curve = by_length(&path);
    let q = UnitQuaternion::from_euler_angles(0.1, 0.2, 0.3);
    assert!(matches!(path.orientation(&curve, &[q; 3], 1e-3), Ok(OrientationPath::Constant(c)) if c == q));
    assert_eq!(
        path.orientation(&curve, &[q; 2], 1e-3).unwrap_err(),
        GeometryError::OrientationCount { keys: 2, pieces: 2 }
    );
    let nan = UnitQuaternion::new_unchecked(q.into_inner() * f64::NAN);
    assert!(matches!(
        path.orientation(&curve, &[q, nan, q], 1e-3),
        Err(GeometryError::QuaternionNotFinite { index: 1, .. })
    ));
    for tolerance in [0.0, f64::NAN, -1.0] {
        assert!(matches!(path.orientation(&curve, &[q; 3], tolerance), Err(GeometryError::NotPositive { .. })));
    }
    let other = joined(&[vector![0.0, 0.0, 0.0], vector![9.0, 0.0, 0.0]]);
    assert!(matches!(path.orientation(&by_length(&other), &[q; 3], 1e-3), Err(GeometryError::OtherCurve { .. })));
}
