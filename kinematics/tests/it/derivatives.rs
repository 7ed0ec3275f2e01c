//! Acceleration, jerk and joint derivatives against truncated power series.
//!
//! The oracle multiplies the chain's transforms with every number a power series in time to t^3: exact derivatives that
//! share nothing with the recursion under test.
#![allow(clippy::unwrap_used, reason = "a test fails by panic")]

use crate::common;

use arcfeed_kinematics::{
    Chain, ForwardKinematics, Joint, JointKind, Joints, KinematicsError, MIN_SINGULAR_VALUE, SingularityKind,
    ToolDerivatives, Twist, joint_derivatives, models, smallest_singular_value,
};
use common::chain;
use nalgebra::{Isometry3, SVector, UnitQuaternion, Vector3};
use proptest::prelude::*;
use std::array::from_fn;

/// Coefficients of 1, t, t^2, t^3.
type Series = [f64; 4];
type Matrix = [[Series; 3]; 3];

fn add(a: Series, b: Series) -> Series {
    from_fn(|k| a[k] + b[k])
}

fn mul(a: Series, b: Series) -> Series {
    from_fn(|k| (0..=k).map(|i| a[i] * b[k - i]).sum())
}

fn scale(a: Series, by: f64) -> Series {
    a.map(|x| x * by)
}

/// By the addition theorem: sine and cosine of the part without constant end after the cubic term.
fn sin_cos(a: Series) -> (Series, Series) {
    let h = [0.0, a[1], a[2], a[3]];
    let square = mul(h, h);
    let sin = add(h, scale(mul(square, h), -1.0 / 6.0));
    let cos = add([1.0, 0.0, 0.0, 0.0], scale(square, -0.5));
    let (s, c) = a[0].sin_cos();
    (add(scale(cos, s), scale(sin, c)), add(scale(cos, c), scale(sin, -s)))
}

fn matmul(a: &Matrix, b: &Matrix) -> Matrix {
    from_fn(|r| from_fn(|c| (0..3).fold([0.0; 4], |sum, k| add(sum, mul(a[r][k], b[k][c])))))
}

fn constant(pose: &Isometry3<f64>) -> (Matrix, [Series; 3]) {
    let rotation = pose.rotation.to_rotation_matrix();
    (
        from_fn(|r| from_fn(|c| [rotation[(r, c)], 0.0, 0.0, 0.0])),
        from_fn(|r| [pose.translation.vector[r], 0.0, 0.0, 0.0]),
    )
}

fn compose(a: &(Matrix, [Series; 3]), b: &(Matrix, [Series; 3])) -> (Matrix, [Series; 3]) {
    let moved = from_fn(|r| (0..3).fold(a.1[r], |sum, k| add(sum, mul(a.0[r][k], b.1[k]))));
    (matmul(&a.0, &b.0), moved)
}

/// The joint's motion by Rodrigues' formula.
fn motion(joint: &Joint, q: Series) -> (Matrix, [Series; 3]) {
    let a = joint.axis();
    let mut pose = constant(&Isometry3::identity());
    match joint.kind() {
        JointKind::Prismatic => pose.1 = from_fn(|r| scale(q, a[r])),
        JointKind::Revolute => {
            let cross = a.cross_matrix();
            let (sin, cos) = sin_cos(q);
            let rest = add([1.0, 0.0, 0.0, 0.0], scale(cos, -1.0));
            let square = cross * cross;
            pose.0 = from_fn(|r| {
                from_fn(|c| add(pose.0[r][c], add(scale(sin, cross[(r, c)]), scale(rest, square[(r, c)]))))
            });
        }
    }
    pose
}

/// First, second and third derivative of the tool at t = 0 for joints with the given derivatives there.
fn oracle<const N: usize>(arm: &Chain<N>, q: &[Joints<N>; 4]) -> [Twist; 3] {
    let mut pose = constant(arm.base());
    for (i, joint) in arm.joints().iter().enumerate() {
        let series = [q[0][i], q[1][i], q[2][i] / 2.0, q[3][i] / 6.0];
        pose = compose(&compose(&pose, &constant(joint.origin())), &motion(joint, series));
    }
    let (rotation, position) = compose(&pose, &constant(&(arm.flange() * arm.tool())));
    // w = vee(R' R^T), known to t^2.
    let rate: Matrix =
        from_fn(|r| from_fn(|c| [rotation[r][c][1], 2.0 * rotation[r][c][2], 3.0 * rotation[r][c][3], 0.0]));
    let transposed: Matrix = from_fn(|r| from_fn(|c| rotation[c][r]));
    let spin = matmul(&rate, &transposed);
    let angular = [spin[2][1], spin[0][2], spin[1][0]];
    let factorial = [1.0, 1.0, 2.0, 6.0];
    from_fn(|order| {
        Twist::from_fn(|row, _| match row {
            0..3 => position[row][order + 1] * factorial[order + 1],
            _ => angular[row - 3][order] * factorial[order],
        })
    })
}

fn joints<const N: usize>(range: f64) -> impl Strategy<Value = Joints<N>> {
    prop::collection::vec(-range..range, N).prop_map(|values| SVector::from_column_slice(&values))
}

fn check<const N: usize>(arm: &Chain<N>, q: &[Joints<N>; 4]) -> Result<(), TestCaseError> {
    let expected = oracle(arm, q);
    let jacobian = arm.jacobian(&q[0]);
    let velocity = jacobian * q[1];
    let acceleration = jacobian * q[2] + arm.jacobian_dot_qd(&q[0], &q[1]);
    let jerk = jacobian * q[3] + arm.jerk_bias(&q[0], &q[1], &q[2]);
    for (found, expected) in [velocity, acceleration, jerk].iter().zip(expected) {
        let error = (found - expected).amax() / (1.0 + expected.amax());
        prop_assert!(error < 1e-12, "{found} should be {expected}");
    }
    Ok(())
}

/// Revolute and prismatic joints in turn, with skew axes, a base and a tool.
fn mixed() -> Chain<5> {
    let origin = |x: f64, y: f64| Isometry3::new(Vector3::new(x, y, 0.1), Vector3::new(0.3 * y, 0.7, x));
    let joints = [
        Joint::prismatic(origin(0.1, 0.2), Vector3::new(1.0, 2.0, -1.0)),
        Joint::revolute(origin(0.3, -0.1), Vector3::new(0.0, -1.0, 0.2)),
        Joint::prismatic(origin(-0.2, 0.4), Vector3::new(0.0, 0.0, -3.0)),
        Joint::revolute(origin(0.0, 0.3), Vector3::new(1.0, 1.0, 1.0)),
        Joint::revolute(origin(0.2, 0.0), Vector3::x()),
    ]
    .map(Result::unwrap);
    Chain::new(joints)
        .unwrap()
        .with_base(origin(1.0, -2.0))
        .unwrap()
        .with_flange(origin(0.05, 0.0))
        .unwrap()
        .with_tool(origin(0.0, 0.07))
        .unwrap()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn chains_agree_with_power_series(six in prop::array::uniform4(joints::<6>(3.0)), seven in prop::array::uniform4(joints::<7>(3.0))) {
        for name in ["cr7", "kr6_r700_2", "kr6_r700_sixx"] {
            check(&chain::<6>(name), &six)?;
        }
        check(&chain::<7>("panda"), &seven)?;
    }

    #[test]
    fn sliding_joints_agree_with_power_series(q in prop::array::uniform4(joints::<5>(2.0))) {
        check(&mixed(), &q)?;
    }

    #[test]
    fn joint_derivatives_undo_the_tool_derivatives(q in prop::array::uniform4(joints::<6>(2.7))) {
        let tool = Isometry3::new(Vector3::new(0.02, -0.05, 0.2), Vector3::new(0.3, -0.4, 0.1));
        let arm = models::cr7().with_tool(tool).unwrap();
        let sigma = smallest_singular_value(&arm.jacobian(&q[0]));
        prop_assume!(sigma > 1e-3);
        let [first, second, third] = oracle(arm.chain(), &q);
        let found = joint_derivatives(&arm, &q[0], &ToolDerivatives { first, second, third }, MIN_SINGULAR_VALUE).unwrap();
        // What rounding of the tool's derivatives alone makes of the joints'.
        let bound = |twist: &Twist| 1e-14 * (1.0 + twist.amax()) / sigma;
        prop_assert!((found.first - q[1]).amax() < bound(&first));
        prop_assert!((found.second - q[2]).amax() < (bound(&first) + bound(&second)) / sigma);
        prop_assert!((found.third - q[3]).amax() < (bound(&first) + bound(&second) + bound(&third)) / sigma.powi(2));
    }
}

#[test]
fn singular_poses_are_named() {
    let arm = models::cr7();
    let tool = ToolDerivatives { first: Twist::repeat(1.0), second: Twist::zeros(), third: Twist::zeros() };
    let at = |q: [f64; 6]| joint_derivatives(&arm, &Joints::from(q), &tool, MIN_SINGULAR_VALUE).unwrap_err();
    for (q, expected) in [
        ([0.3, -0.4, 1.2, 0.5, 0.0, 0.3], SingularityKind::Wrist),
        ([0.3, -0.4, 1.2, 0.5, std::f64::consts::PI, 0.3], SingularityKind::Wrist),
        ([0.3, -0.4, 0.0, 0.5, 1.0, 0.3], SingularityKind::Elbow),
    ] {
        match at(q) {
            KinematicsError::Singular { kind, sigma_min, required, condition } => {
                assert_eq!(kind, Some(expected));
                assert!(sigma_min < required && condition > 1e6);
            }
            error => panic!("{error}"),
        }
    }
    let text = at([0.3, -0.4, 1.2, 0.5, 0.0, 0.3]).to_string();
    assert!(text.contains("wrist singularity"), "{text}");
}

#[test]
fn nearly_singular_is_what_the_argument_says() {
    let arm = models::cr7();
    let q = Joints::from([0.3, -0.4, 1.2, 0.5, 1e-3, 0.3]);
    let sigma = smallest_singular_value(&arm.jacobian(&q));
    let tool = ToolDerivatives { first: Twist::repeat(1.0), second: Twist::zeros(), third: Twist::zeros() };
    assert!(joint_derivatives(&arm, &q, &tool, sigma * 0.999).is_ok());
    assert!(joint_derivatives(&arm, &q, &tool, sigma * 1.001).is_err());
}

#[test]
fn a_turn_about_the_first_axis_is_exact() {
    // Closed form: the tool on a circle at unit joint speed.
    let arm = models::ur5e();
    let q = Joints::from([0.7, -1.2, 1.1, -0.9, -1.4, 0.2]);
    let at = arm.configuration(&q);
    let (w, r) = (Vector3::z(), *at.position() - at.points()[0]);
    let bias = arm.jerk_bias(&q, &Joints::from([1.0, 0.0, 0.0, 0.0, 0.0, 0.0]), &Joints::zeros());
    let expected = w.cross(&w.cross(&w.cross(&r)));
    assert!((bias.fixed_rows::<3>(0) - expected).norm() < 1e-15 && bias.fixed_rows::<3>(3).norm() < 1e-15);
    assert!(UnitQuaternion::from_matrix(at.rotation()).angle_to(&arm.forward(&q).rotation) < 1e-7);
}
