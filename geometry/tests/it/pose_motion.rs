//! Motions between poses: their types, their parameter, their derivatives, and what is refused.

use std::f64::consts::{FRAC_PI_2, PI};

use arcfeed_geometry::nalgebra::{Isometry3, Quaternion, Translation3, Unit, UnitQuaternion, Vector3};
use arcfeed_geometry::{GeometryError, MotionType, PathParameter, PoseMotion};
use proptest::prelude::*;

fn pose(position: [f64; 3], turn: [f64; 3]) -> Isometry3<f64> {
    Isometry3::new(Vector3::from(position), Vector3::from(turn))
}

#[test]
fn the_type_names_the_parameter() {
    let start = pose([0.3, 0.1, 0.2], [0.0, 0.0, 0.0]);
    let shifted = pose([0.3, 0.1, 0.7], [0.0, 0.0, 0.0]);
    let turned = pose([0.3, 0.1, 0.2], [0.0, 0.7, 0.0]);
    let both = pose([0.3, 0.1, 0.7], [0.0, 0.7, 0.0]);
    let motion = |goal: &Isometry3<f64>| PoseMotion::new(&start, goal).expect("a motion");
    let (pt, po, to) = (motion(&shifted), motion(&turned), motion(&both));
    assert_eq!((pt.kind(), pt.parameter()), (MotionType::PureTranslation, PathParameter::ArcLength));
    assert_eq!((po.kind(), po.parameter()), (MotionType::PureOrientation, PathParameter::RotationAngle));
    assert_eq!((to.kind(), to.parameter()), (MotionType::Composite, PathParameter::ArcLength));
    assert!((pt.end() - 0.5).abs() < 1e-15 && pt.angle() == 0.0 && pt.axis().is_none());
    // The full angle, not the arc cosine of the product of the quaternions.
    assert!((po.end() - 0.7).abs() < 1e-15 && po.length() == 0.0 && po.rotation_per_length().is_none());
    assert!((to.rotation_per_length().expect("it moves") - 1.4).abs() < 1e-14);
    assert_eq!((pt.parameter().unit(), po.parameter().unit()), ("m", "rad"));
}

/// Table 2 and Table 3 of Electronics 2025, 14, 3869, in the degrees that they round: length and rotation are printed as 0.86 m
/// and 0.13 rad, the latter half of the angle.
#[test]
fn the_motions_of_the_paper() {
    let at = |p: [f64; 3], deg: [f64; 3]| {
        let [a, b, c] = deg.map(f64::to_radians);
        Isometry3::from_parts(Translation3::from(p), UnitQuaternion::from_euler_angles(a, b, c))
    };
    let to = PoseMotion::new(&at([0.1, 0.4, 0.45], [180.0, 0.0, 10.0]), &at([0.45, -0.35, 0.2], [180.0, 0.0, 25.0]));
    let to = to.expect("a motion");
    assert!((to.length() - 0.35f64.hypot(0.75).hypot(0.25)).abs() < 1e-15);
    assert!((to.angle() - 15f64.to_radians()).abs() < 1e-14);
    let (from, goal) = (at([0.3, 0.4, 0.3], [180.0, 0.0, 0.0]), at([0.3, 0.4, 0.3], [140.0, 55.0, 30.0]));
    let po = PoseMotion::new(&from, &goal).expect("a motion");
    assert_eq!(po.kind(), MotionType::PureOrientation);
    let half = from.rotation.coords.dot(&goal.rotation.coords).abs().acos();
    assert!((0.5 * po.angle() - half).abs() < 1e-14 && (half - 0.7009).abs() < 5e-5, "{half}");
}

#[test]
fn half_a_turn_goes_about_the_positive_axis() {
    let start = pose([0.0; 3], [0.3, -0.2, 0.5]);
    for axis in [Vector3::x(), -Vector3::x(), Vector3::new(0.6, -0.8, 0.0)] {
        for wobble in [-1e-12, 0.0, 1e-12] {
            let turn = UnitQuaternion::from_axis_angle(&Unit::new_normalize(axis), PI + wobble);
            let goal = Isometry3::from_parts(start.translation, turn * start.rotation);
            let motion = PoseMotion::new(&start, &goal).expect("a motion");
            let taken = motion.axis().expect("it turns");
            assert!(taken[taken.iamax()] > 0.0, "{taken:?}");
            assert!((motion.angle() - PI).abs() < 1e-11);
            assert!(motion.pose(motion.end()).rotation.angle_to(&goal.rotation) < 1e-7);
            let away = (motion.pose(motion.end()).rotation.coords.dot(&goal.rotation.coords)).abs();
            assert!((away - 1.0).abs() < 1e-14, "{away}");
        }
    }
}

#[test]
fn what_is_no_motion_is_refused() {
    let start = pose([0.3, 0.1, 0.2], [0.1, 0.2, 0.3]);
    let error = PoseMotion::new(&start, &start).expect_err("the same pose");
    assert!(matches!(error, GeometryError::SamePose { .. }), "{error}");
    // The other sign of the quaternion is the same orientation.
    let same = Isometry3::from_parts(start.translation, UnitQuaternion::new_unchecked(-start.rotation.into_inner()));
    assert!(matches!(PoseMotion::new(&start, &same), Err(GeometryError::SamePose { .. })));
    let mut bad = start;
    bad.translation.x = f64::NAN;
    assert!(matches!(PoseMotion::new(&start, &bad), Err(GeometryError::PoseNotFinite { what: "goal", .. })));
    assert!(matches!(PoseMotion::new(&bad, &start), Err(GeometryError::PoseNotFinite { what: "start", .. })));
    let long =
        Isometry3::from_parts(start.translation, UnitQuaternion::new_unchecked(Quaternion::new(2.0, 0.0, 0.0, 0.0)));
    assert!(matches!(PoseMotion::new(&start, &long), Err(GeometryError::PoseNotFinite { .. })));
    let far = |x: f64| Isometry3::translation(x, 0.0, 0.0);
    assert!(PoseMotion::new(&far(-1e308), &far(1e308)).is_err());
}

#[test]
fn outside_its_range_a_motion_stands_at_its_ends() {
    let motion = PoseMotion::new(&pose([0.0; 3], [0.0; 3]), &pose([0.0, 1.0, 0.0], [FRAC_PI_2, 0.0, 0.0]));
    let motion = motion.expect("a motion");
    assert_eq!(motion.pose(-1.0), motion.pose(0.0));
    assert_eq!(motion.pose(f64::NAN), motion.pose(0.0));
    assert_eq!(motion.pose(f64::INFINITY), motion.pose(motion.end()));
}

proptest! {
    /// Ends are met, the way is straight and the rotation even, and the twist is the difference quotient of the pose.
    #[test]
    fn a_motion_is_straight_and_even(
        a in prop::array::uniform3(-1.0..1.0f64), b in prop::array::uniform3(-1.0..1.0f64),
        u in prop::array::uniform3(-3.0..3.0f64), v in prop::array::uniform3(-3.0..3.0f64), share in 0.1..0.9f64,
    ) {
        let (start, goal) = (pose(a, u), pose(b, v));
        let motion = PoseMotion::new(&start, &goal).expect("random poses differ");
        let end = motion.end();
        for (s, target) in [(0.0, &start), (end, &goal)] {
            let there = motion.pose(s);
            prop_assert!((there.translation.vector - target.translation.vector).norm() < 1e-14);
            prop_assert!((there.rotation.coords.dot(&target.rotation.coords).abs() - 1.0).abs() < 1e-13);
        }
        prop_assert!(motion.angle() <= PI + 1e-9);
        let (s, h) = (share * end, 1e-5 * end);
        let (before, at, after) = (motion.pose(s - h), motion.jet(s), motion.pose(s + h));
        let linear = (after.translation.vector - before.translation.vector) / (2.0 * h);
        let angular = (after.rotation * before.rotation.inverse()).scaled_axis() / (2.0 * h);
        prop_assert!((linear - at.d1.fixed_rows::<3>(0)).norm() < 1e-8);
        prop_assert!((angular - at.d1.fixed_rows::<3>(3)).norm() < 1e-6 * (1.0 + angular.norm()));
        prop_assert!((at.d1.fixed_rows::<3>(0).norm() - 1.0).abs() < 1e-12);
        prop_assert_eq!((at.d2.norm(), at.d3.norm()), (0.0, 0.0));
    }
}
