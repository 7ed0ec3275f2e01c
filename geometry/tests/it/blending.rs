//! Blends of corners and of jumps of curvature: deviation, continuity, sharing, and what stays as it is.
#![allow(clippy::unwrap_used)]

use std::f64::consts::PI;

use crate::common::polylines::{self, Seen};
use crate::common::{mixed, polylines::joined};

use arcfeed_geometry::nalgebra::{Vector3, vector};
use arcfeed_geometry::{ArcTo, BlendedPath, Blending, Curve, JoinedPathBuilder, JointOutcome, KeptJoint, PieceKind};

fn taken(blended: &BlendedPath, joint: usize) -> [f64; 2] {
    match blended.joints[joint].1 {
        JointOutcome::Blended { taken, .. } => taken,
        JointOutcome::Kept(reason) => panic!("joint {joint} stayed: {reason:?}"),
    }
}

#[test]
fn random_polylines() {
    let mut seen = Seen::default();
    for seed in 1..=2500 {
        polylines::check(seed, &mut seen).unwrap_or_else(|e| panic!("seed {seed}: {e}"));
    }
    assert!(seen.blends > 15_000 && seen.kept > 5_000, "{seen:?}");
    assert!(seen.pessimism > 1.0 && seen.pessimism < 1.1, "{seen:?}");
}

#[test]
fn random_mixed_paths() {
    let mut seen = Seen::default();
    for seed in 1..=400 {
        mixed::check(seed, &mut seen).unwrap_or_else(|e| panic!("seed {seed}: {e}"));
    }
    assert!(seen.blends > 1_500 && 500 * seen.loose < seen.blends, "{seen:?}");
}

#[test]
fn an_exact_stop_changes_nothing() {
    let path = joined(&polylines::polyline(&mut arcfeed_testing::Random::new(3)));
    let blended = path.blended(&Blending::within(0.0)).unwrap();
    assert_eq!(blended.path, path);
    let stop = |outcome| matches!(outcome, JointOutcome::Kept(KeptJoint::ExactStop | KeptJoint::Smooth));
    assert!(blended.joints.iter().all(|(_, outcome)| stop(*outcome)));
}

#[test]
fn every_joint_has_its_own_setting() {
    let points = [(0.0, 0.0), (10.0, 0.0), (10.0, 10.0), (0.0, 10.0), (0.0, 20.0)].map(|(x, y)| vector![x, y, 0.0]);
    let path = joined(&points);
    let setting = |joint: &arcfeed_geometry::Joint| match joint.sources[0] {
        0 => Blending::within(0.1),
        1 => Blending::within(0.0),
        _ => Blending { radius: 0.2, ..Blending::within(5.0) },
    };
    let blended = path.blended_by(setting).unwrap();
    let JointOutcome::Blended { deviation, piece, .. } = blended.joints[0].1 else { panic!() };
    assert!(deviation <= 0.1 && deviation > 0.0999);
    assert_eq!(blended.path.pieces()[piece].sources, [0, 1]);
    assert_eq!(blended.path.pieces()[piece].kind, PieceKind::Blend);
    assert_eq!(blended.joints[1].1, JointOutcome::Kept(KeptJoint::ExactStop));
    assert_eq!(taken(&blended, 2), [0.2, 0.2]);
    // The first half of a blend came from the line before it.
    let own = &blended.path.pieces()[piece];
    let at = |part: f64| blended.path.source_at(own.start + part * (own.end - own.start));
    assert_eq!((at(0.1), at(0.9)), (0, 1));
    assert_eq!(
        blended.deviation(),
        deviation.max(match blended.joints[2].1 {
            JointOutcome::Blended { deviation, .. } => deviation,
            JointOutcome::Kept(_) => panic!(),
        })
    );
}

#[test]
fn a_reversal_stays() {
    for (angle, kept) in [(PI, true), (PI - 0.0199, true), (PI - 0.0201, false)] {
        let end = vector![10.0 + 10.0 * angle.cos(), 10.0 * angle.sin(), 0.0];
        let path = joined(&[vector![0.0, 0.0, 0.0], vector![10.0, 0.0, 0.0], end]);
        let outcome = path.blended(&Blending::within(0.1)).unwrap().joints[0].1;
        assert_eq!(outcome == JointOutcome::Kept(KeptJoint::Reversal), kept, "{angle}");
    }
}

#[test]
fn a_short_segment_is_shared() {
    let zigzag =
        |wide: f64| [(0.0, 0.0), (10.0, 0.0), (10.0, 1.0), (10.0 + wide, 1.0)].map(|(x, y)| vector![x, y, 0.0]);
    // Both want more than there is: they meet in the middle.
    let both = joined(&zigzag(10.0)).blended(&Blending::within(1.0)).unwrap();
    assert_eq!((taken(&both, 0), taken(&both, 1)), ([0.5, 0.5], [0.5, 0.5]));
    assert_eq!(both.path.pieces().len(), 4);
    // One wants less: the other takes the rest, but for a tenth where they would nearly meet.
    let setting = |joint: &arcfeed_geometry::Joint| Blending::within(if joint.piece == 0 { 0.01 } else { 1.0 });
    let one = joined(&zigzag(10.0)).blended_by(setting).unwrap();
    let small = taken(&one, 0)[1];
    assert!(small < 0.1 && (taken(&one, 1)[0] + small - 1.0).abs() < 1e-12);
    // One cannot use it.
    let held = joined(&zigzag(0.25)).blended(&Blending::within(1.0)).unwrap();
    assert_eq!((taken(&held, 0), taken(&held, 1)), ([0.75, 0.75], [0.25, 0.25]));
}

#[test]
fn a_line_into_an_arc_gets_a_blend_above_the_threshold() {
    let mut builder = JoinedPathBuilder::new(vector![-50.0, 0.0, 0.0], 1e-6).unwrap();
    builder.line_to(vector![0.0, 0.0, 0.0], 1).unwrap();
    builder.arc(&ArcTo::new(vector![0.0, 10.0, 0.0], Vector3::z_axis(), vector![0.0, 20.0, 0.0]), 2).unwrap();
    let path = builder.build().unwrap();
    assert!(path.joints()[0].angle == 0.0 && (path.joints()[0].curvature_jump - 0.1).abs() < 1e-15);
    let blended = path.blended(&Blending::within(0.01)).unwrap();
    let JointOutcome::Blended { deviation, taken, piece } = blended.joints[0].1 else { panic!() };
    assert!(deviation <= 0.01 && deviation > 0.008, "{deviation}");
    assert!(taken[0] > 2.5 && taken[0] < 3.2, "{taken:?}");
    // The curvature goes over from 0 to that of the arc, and hardly beyond.
    let own = &blended.path.pieces()[piece];
    let curve = blended.path.to_curve().unwrap();
    let largest = (0..=100)
        .map(|k| curve.jet(own.start + (own.end - own.start) * f64::from(k) / 100.0).curvature())
        .fold(0.0, f64::max);
    assert!(largest < 0.11, "{largest}");
    let kept = path.blended(&Blending { curvature_jump: 1.0, ..Blending::within(0.01) }).unwrap();
    assert_eq!(kept.joints[0].1, JointOutcome::Kept(KeptJoint::Smooth));
    assert_eq!(kept.path, path);
}

#[test]
fn blending_again_finds_nothing_to_do() {
    for seed in 0..50 {
        let path = joined(&polylines::polyline(&mut arcfeed_testing::Random::new(seed)));
        let once = path.blended(&Blending::within(0.1)).unwrap().path;
        let again = once.blended(&Blending::within(0.1)).unwrap();
        let reversal = |outcome| outcome == JointOutcome::Kept(KeptJoint::Reversal);
        // Rounding of short pieces may look like a corner of 1e-9.
        let corner = again.joints.iter().find(|(j, o)| j.angle > 1e-7 && !reversal(*o));
        assert!(corner.is_none(), "seed {seed}: {corner:?}");
    }
}
