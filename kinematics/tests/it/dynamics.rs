//! Rigid-body dynamics against Pinocchio, and against laws that hold for every arm.
#![allow(clippy::unwrap_used, reason = "a test fails by panic")]

use crate::common;

use arcfeed_kinematics::{
    ArmDynamics, Chain, Dynamics, ForwardKinematics, Friction, Inertial, Joint, JointKind, Joints, KinematicsError,
    models,
};
use common::{ArmState, chain, inertials, records};
use nalgebra::{Cholesky, Isometry3, Matrix3, SMatrix, Vector3};
use proptest::prelude::*;
use serde::Deserialize;

#[derive(Deserialize)]
struct Sample {
    #[serde(flatten)]
    at: ArmState,
    qdd: Vec<f64>,
    tau: Vec<f64>,
    gravity: Vec<f64>,
    nle: Vec<f64>,
    mass_matrix: Vec<f64>,
}

/// Largest difference from the record, relative to the largest number of its kind.
fn dynamics_error<const N: usize>(arm: &ArmDynamics<N>, sample: &Sample) -> f64 {
    let vector = |v: &[f64]| Joints::<N>::from_column_slice(v);
    let (q, qd, qdd) = (vector(&sample.at.q), vector(&sample.at.qd), vector(&sample.qdd));
    let relative = |ours: Joints<N>, theirs: &[f64]| (ours - vector(theirs)).amax() / vector(theirs).amax().max(1e-3);
    let mut worst = relative(arm.torque(&q, &qd, &qdd), &sample.tau);
    worst = worst.max(relative(arm.gravity_torque(&q), &sample.gravity));
    worst = worst.max(relative(arm.bias(&q, &qd), &sample.nle));
    let mass = arm.mass_matrix(&q);
    let mut entries = sample.mass_matrix.iter();
    let mut theirs = SMatrix::<f64, N, N>::zeros();
    for i in 0..N {
        for j in 0..=i {
            theirs[(i, j)] = *entries.next().unwrap();
            theirs[(j, i)] = theirs[(i, j)];
        }
    }
    worst = worst.max((mass - theirs).amax() / theirs.amax());
    // Along a path: the motion itself is a path by time.
    let path = arm.along_path(&q, &qd, &qdd);
    worst = worst.max(relative(path.at(1.0, 0.0), &sample.tau));
    let forward = arm.acceleration(&q, &qd, &vector(&sample.tau)).unwrap();
    assert!((forward - qdd).amax() <= 1e-8 * qdd.amax().max(1.0), "{} {}", sample.at.arm, sample.at.id);
    worst
}

#[test]
fn five_arms_agree_with_pinocchio() {
    let mut counts = std::collections::BTreeMap::new();
    for sample in records::<Sample>("dynamics.jsonl") {
        let error = if sample.at.arm == "panda" {
            let arm = ArmDynamics::new(&chain::<7>("panda"), inertials("panda")).unwrap();
            dynamics_error::<7>(&arm, &sample)
        } else {
            let arm = ArmDynamics::new(&chain::<6>(&sample.at.arm), inertials(&sample.at.arm)).unwrap();
            dynamics_error::<6>(&arm, &sample)
        };
        assert!(error < 1e-10, "{} {}: {error:e}", sample.at.arm, sample.at.id);
        *counts.entry(sample.at.arm).or_insert(0) += 1;
    }
    assert_eq!(counts.into_values().collect::<Vec<_>>(), [16; 5]);
}

/// An arm with turning and sliding joints in no particular direction.
fn mixed_arm() -> (Chain<4>, ArmDynamics<4>) {
    arm_of([JointKind::Revolute, JointKind::Prismatic, JointKind::Revolute, JointKind::Prismatic])
}

fn arm_of(kinds: [JointKind; 4]) -> (Chain<4>, ArmDynamics<4>) {
    let pose = |x: f64, y: f64, z: f64| Isometry3::new(Vector3::new(x, y, z), Vector3::new(y, -z, x) * 3.0);
    let chain = Chain::new([
        Joint::new(pose(0.1, 0.2, 0.3), Vector3::new(1.0, 2.0, -0.5), kinds[0]).unwrap(),
        Joint::new(pose(0.2, -0.1, 0.4), Vector3::new(0.3, -1.0, 0.7), kinds[1]).unwrap(),
        Joint::new(pose(-0.3, 0.1, 0.2), Vector3::new(-1.0, 0.2, 0.9), kinds[2]).unwrap(),
        Joint::new(pose(0.0, 0.25, -0.1), Vector3::new(0.0, 0.5, 1.0), kinds[3]).unwrap(),
    ])
    .unwrap()
    .with_base(pose(0.5, 0.1, -0.2))
    .unwrap();
    let body = |m: f64| {
        let turn = Isometry3::rotation(Vector3::new(m, 0.4, -0.2));
        let tensor = Matrix3::from_diagonal(&Vector3::new(0.02, 0.03, 0.04)) * m;
        Inertial::new(m, Vector3::new(0.03, -0.02, 0.1), tensor).unwrap().seen_from(&turn)
    };
    let dynamics = ArmDynamics::new(&chain, [body(3.0), body(2.0), body(1.0), body(0.5)]).unwrap();
    (chain, dynamics)
}

/// Kinetic and potential energy from the links' velocities, by sums over point masses: nothing of the recursions.
fn energy(chain: &Chain<4>, dynamics: &ArmDynamics<4>, q: &Joints<4>, qd: &Joints<4>) -> (f64, f64) {
    let (mut kinetic, mut potential) = (0.0, 0.0);
    for (i, body) in dynamics.inertials().iter().enumerate() {
        // Six points with the body's mass and tensor: pairs on its principal axes.
        let eigen = body.tensor().symmetric_eigen();
        for axis in 0..3 {
            let others = eigen.eigenvalues.sum() - 2.0 * eigen.eigenvalues[axis];
            let arm = (0.5 * others * 3.0 / body.mass()).max(0.0).sqrt();
            for side in [arm, -arm] {
                let point = body.centre() + eigen.eigenvectors.column(axis) * side;
                let at = |q: &Joints<4>| point_on_link(chain, i, q, &point);
                let mut velocity = Vector3::zeros();
                for k in 0..4 {
                    let h = Joints::<4>::from_fn(|r, _| if r == k { 1e-5 } else { 0.0 });
                    velocity += (at(&(q + h)) - at(&(q - h))) / 2e-5 * qd[k];
                }
                let mass = body.mass() / 6.0;
                kinetic += 0.5 * mass * velocity.norm_squared();
                potential -= mass * dynamics.gravity().dot(&at(q));
            }
        }
    }
    (kinetic, potential)
}

fn point_on_link(chain: &Chain<4>, link: usize, q: &Joints<4>, point: &Vector3<f64>) -> Vector3<f64> {
    let mut pose = *chain.base();
    for (i, joint) in chain.joints().iter().enumerate().take(link + 1) {
        pose *= joint.origin();
        pose *= match joint.kind() {
            arcfeed_kinematics::JointKind::Revolute => Isometry3::rotation(joint.axis().into_inner() * q[i]),
            arcfeed_kinematics::JointKind::Prismatic => {
                let slide = joint.axis().into_inner() * q[i];
                Isometry3::translation(slide.x, slide.y, slide.z)
            }
        };
    }
    (pose * nalgebra::Point3::from(*point)).coords
}

fn joints<const N: usize>(range: f64) -> impl Strategy<Value = Joints<N>> {
    prop::collection::vec(-range..range, N).prop_map(|v| Joints::from_column_slice(&v))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn the_mass_matrix_is_the_kinetic_energy(q in joints::<4>(2.0), qd in joints::<4>(2.0)) {
        let (chain, dynamics) = mixed_arm();
        let (kinetic, _) = energy(&chain, &dynamics, &q, &qd);
        let ours = 0.5 * qd.dot(&(dynamics.mass_matrix(&q) * qd));
        prop_assert!((ours - kinetic).abs() < 1e-7 * kinetic.max(1.0), "{ours} {kinetic}");
    }

    #[test]
    fn gravity_is_the_slope_of_the_potential_energy(q in joints::<4>(2.0), k in 0_usize..4) {
        let (chain, dynamics) = mixed_arm();
        let h = Joints::<4>::from_fn(|r, _| if r == k { 1e-5 } else { 0.0 });
        let potential = |q: &Joints<4>| energy(&chain, &dynamics, q, &Joints::zeros()).1;
        let slope = (potential(&(q + h)) - potential(&(q - h))) / 2e-5;
        prop_assert!((dynamics.gravity_torque(&q)[k] - slope).abs() < 1e-7, "{slope}");
    }

    #[test]
    fn power_is_the_change_of_energy(q in joints::<4>(2.0), qd in joints::<4>(1.0), qdd in joints::<4>(1.0)) {
        let (chain, dynamics) = mixed_arm();
        let power = dynamics.torque(&q, &qd, &qdd).dot(&qd);
        let total = |t: f64| {
            let (kinetic, potential) =
                energy(&chain, &dynamics, &(q + qd * t + qdd * (t * t / 2.0)), &(qd + qdd * t));
            kinetic + potential
        };
        let change = (total(1e-4) - total(-1e-4)) / 2e-4;
        prop_assert!((power - change).abs() < 1e-4 * (1.0 + power.abs()), "{power} {change}");
    }

    #[test]
    fn forward_undoes_inverse(q in joints::<4>(2.0), qd in joints::<4>(1.0), qdd in joints::<4>(5.0)) {
        let (_, dynamics) = mixed_arm();
        let dynamics = dynamics
            .with_rotor_inertia(Joints::<4>::repeat(0.3)).unwrap()
            .with_friction(Friction::new(Joints::repeat(2.0), Joints::repeat(1.0), Joints::repeat(0.5)).unwrap());
        let found = dynamics.acceleration(&q, &qd, &dynamics.torque(&q, &qd, &qdd)).unwrap();
        prop_assert!((found - qdd).amax() < 1e-9, "{found}");
        prop_assert!(Cholesky::new(dynamics.mass_matrix(&q)).is_some());
    }

    #[test]
    fn a_path_has_the_torque_of_its_motion(
        q in joints::<4>(2.0), d1 in joints::<4>(2.0), d2 in joints::<4>(2.0), speed in 0.01..3.0, u in -5.0..5.0,
    ) {
        let (_, dynamics) = mixed_arm();
        let dynamics = dynamics
            .with_rotor_inertia(Joints::<4>::repeat(0.3)).unwrap()
            .with_friction(Friction::new(Joints::repeat(2.0), Joints::repeat(1.0), Joints::repeat(0.5)).unwrap());
        let motion = dynamics.torque(&q, &(d1 * speed), &(d1 * u + d2 * (speed * speed)));
        let path = dynamics.along_path(&q, &d1, &d2).at(speed, u);
        prop_assert!((motion - path).amax() < 1e-10 * (1.0 + motion.amax()), "{motion} {path}");
    }
}

#[test]
fn a_payload_is_a_part_of_the_last_link() {
    let chain = chain::<6>("ur5e");
    let load = Inertial::new(2.0, Vector3::new(0.01, 0.0, 0.06), Matrix3::identity() * 0.004).unwrap();
    let flange = Isometry3::new(Vector3::new(0.0, 0.02, 0.01), Vector3::new(0.3, 0.0, 0.1));
    let chain = chain.with_flange(flange).unwrap();
    let mut bodies = inertials::<6>("ur5e");
    let carried = ArmDynamics::new(&chain, bodies).unwrap().with_payload(load).unwrap();
    bodies[5] = bodies[5].joined(&load.seen_from(&flange));
    let welded = ArmDynamics::new(&chain, bodies).unwrap();
    let q = Joints::from([0.3, -1.2, 1.1, 0.4, 0.9, -0.3]);
    assert!((carried.torque(&q, &q, &q) - welded.torque(&q, &q, &q)).amax() < 1e-12);
    // Its weight, held up, is J^T f at its centre of mass.
    let bare = ArmDynamics::new(&chain, inertials("ur5e")).unwrap();
    let at = chain.with_tool(Isometry3::translation(0.01, 0.0, 0.06)).unwrap().jacobian(&q);
    let weight = at.fixed_rows::<3>(0).transpose() * Vector3::new(0.0, 0.0, 2.0 * 9.81);
    assert!((carried.gravity_torque(&q) - bare.gravity_torque(&q) - weight).amax() < 1e-12);
}

/// Arms in space, two with joints that slide, of which one stands on a rail, and one whose identified bodies cannot exist: the second
/// derivative of the torque of random motions, by differences, within the bounds.
#[test]
fn torques_of_random_motions_keep_their_bounds() {
    fn holds<const N: usize>(arm: &ArmDynamics<N>, seed: u64) -> [f64; 2] {
        let mut seed = seed;
        let mut random = || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (seed >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
        };
        let mut most = [0.0; 2];
        for case in 0..4000 {
            let scale = [3.0, 1.0, 2.0, 3.0, 4.0].map(|size| size * 10f64.powf(random()));
            let c = scale.map(|size| Joints::<N>::from_fn(|_, _| size * random()));
            let torque = |t: f64| {
                let q = c[0] + c[1] * t + c[2] * (t * t / 2.0) + c[3] * (t.powi(3) / 6.0) + c[4] * (t.powi(4) / 24.0);
                let qd = c[1] + c[2] * t + c[3] * (t * t / 2.0) + c[4] * (t.powi(3) / 6.0);
                let qdd = c[2] + c[3] * t + c[4] * (t * t / 2.0);
                (arm.torque(&q, &qd, &qdd), arm.friction_torque(&qd.map(|speed| 1e-200 * speed.signum())))
            };
            let smooth = |t: f64| torque(t).0 - torque(t).1;
            let h = 1e-4;
            let second = (smooth(h) + smooth(-h) - smooth(0.0) * 2.0) / (h * h);
            let bounds = arm.torque_bounds(&c.map(|c| c.abs())).unwrap();
            for j in 0..N {
                let size = torque(0.0).0[j].abs() / bounds.size[j];
                // Rounding and the fourth derivative of the torque.
                let noise = 1e-15 * bounds.size[j] / (h * h) + 1e-5 * bounds.second_derivative[j];
                let curved = (second[j].abs() - noise) / bounds.second_derivative[j];
                assert!(size <= 1.0 && curved <= 1.0, "case {case}, joint {j}: {size} {curved}, {c:?}");
                most = [size.max(most[0]), curved.max(most[1])];
            }
        }
        most
    }
    let friction = |n: f64| Friction::new(Joints::repeat(n), Joints::repeat(2.0 * n), Joints::repeat(n)).unwrap();
    let (_, mixed) = mixed_arm();
    let (_, on_rail) = arm_of([JointKind::Prismatic, JointKind::Revolute, JointKind::Prismatic, JointKind::Revolute]);
    let ur5e = ArmDynamics::new(&chain::<6>("ur5e"), inertials("ur5e")).unwrap();
    let puma = ArmDynamics::new(&chain::<6>("puma560"), inertials("puma560")).unwrap();
    let rotors = Joints::repeat(0.4);
    for most in [
        holds(&mixed.with_rotor_inertia(Joints::repeat(0.4)).unwrap(), 1),
        holds(&on_rail, 5),
        holds(&ur5e.with_friction(friction(3.0)), 2),
        holds(&puma.with_rotor_inertia(rotors).unwrap(), 3),
        holds(&ArmDynamics::new(&chain::<7>("panda"), inertials("panda")).unwrap(), 4),
    ] {
        // The bounds say something.
        assert!(most[0] > 0.3 && most[1] > 0.3, "{most:?}");
    }
}

#[test]
fn gravity_follows_the_base() {
    // An arm hung from the ceiling feels what the standing one feels under gravity upwards.
    let standing = chain::<6>("ur5e");
    let hung = standing.with_base(Isometry3::rotation(Vector3::x() * std::f64::consts::PI)).unwrap();
    let up = ArmDynamics::new(&standing, inertials("ur5e")).unwrap().with_gravity(Vector3::z() * 9.81).unwrap();
    let down = ArmDynamics::new(&hung, inertials("ur5e")).unwrap();
    let q = Joints::from([0.3, -1.2, 1.1, 0.4, 0.9, -0.3]);
    assert!((up.gravity_torque(&q) - down.gravity_torque(&q)).amax() < 1e-12);
    assert!((down.with_chain(&standing).unwrap().gravity_torque(&q) + up.gravity_torque(&q)).amax() < 1e-12);
}

#[test]
fn bodies_that_cannot_exist_are_refused() {
    let diagonal = |a: f64, b: f64, c: f64| Matrix3::from_diagonal(&Vector3::new(a, b, c));
    let refused = |mass: f64, tensor: Matrix3<f64>| Inertial::new(mass, Vector3::zeros(), tensor).unwrap_err();
    assert!(matches!(refused(-1.0, Matrix3::identity()), KinematicsError::InvalidInertial { what: "mass", .. }));
    assert!(matches!(refused(f64::NAN, Matrix3::identity()), KinematicsError::InvalidInertial { .. }));
    let error = refused(1.0, diagonal(0.01, 0.02, 0.04));
    let KinematicsError::InvalidInertial { value, bound, .. } = error else { panic!("{error}") };
    assert!((value - 0.04).abs() < 1e-12 && (bound - 0.03).abs() < 1e-12);
    assert!(Inertial::identified(1.0, Vector3::zeros(), diagonal(0.01, 0.02, 0.04)).is_ok());
    let mut skew = Matrix3::identity();
    skew[(0, 1)] = 0.1;
    refused(1.0, skew);
    skew[(0, 1)] = f64::NAN;
    refused(1.0, skew);
    refused(1.0, diagonal(-0.01, 0.02, 0.02));
    // The triangle inequality does not depend on the axes it is written in.
    let turn = Isometry3::rotation(Vector3::new(0.3, 0.8, -0.4));
    let bad = Inertial::identified(1.0, Vector3::zeros(), diagonal(0.01, 0.02, 0.04)).unwrap();
    assert!(!bad.seen_from(&turn).is_physical());
    for name in ["cr7", "ur5e", "kr6_r700_2"] {
        assert!(inertials::<6>(name).iter().all(Inertial::is_physical), "{name}");
    }
    let puma = inertials::<6>("puma560").map(|body| body.is_physical());
    assert_eq!(puma, [false, true, false, true, true, true]);
}

#[test]
fn an_arm_without_mass_has_no_forward_dynamics() {
    let arm = ArmDynamics::new(&models::planar_2r(), [Inertial::none(); 2]).unwrap();
    let rest = Joints::<2>::zeros();
    assert_eq!(arm.acceleration(&rest, &rest, &rest).unwrap_err(), KinematicsError::MassMatrix);
    let nan = Joints::<2>::repeat(f64::NAN);
    assert!(arm.torque(&nan, &rest, &rest).iter().all(|t| t.is_nan() || *t == 0.0));
    assert!(arm.acceleration(&nan, &nan, &nan).is_err());
    assert!(arm.with_gravity(Vector3::new(0.0, f64::NAN, 0.0)).is_err());
    assert!(arm.with_rotor_inertia(Joints::<2>::new(-1.0, 0.0)).is_err());
    assert!(Friction::<2>::new(rest, rest, Joints::<2>::new(0.0, -1.0)).is_err());
    let heavy = Inertial::new(1e308, Vector3::repeat(1e10), Matrix3::zeros()).unwrap();
    assert!(ArmDynamics::new(&models::planar_2r(), [heavy; 2]).is_err());
}

/// No moment of it overflows, nor does their sum, though the product of any two would.
#[test]
fn an_arm_whose_moments_are_near_the_end_of_all_numbers_is_taken() {
    let arm = |unit: f64| {
        let body = Inertial::new(unit, Vector3::new(0.1, 0.2, 0.3), Matrix3::identity() * (0.02 * unit)).unwrap();
        ArmDynamics::new(&models::planar_2r(), [body; 2]).unwrap().with_gravity(Vector3::new(0.0, -9.81, 0.0)).unwrap()
    };
    let unit = 2.0_f64.powi(530);
    let (light, heavy) = (arm(1.0), arm(unit));
    let q = Joints::<2>::new(0.4, -0.7);
    assert!(light.gravity_torque(&q).amax() > 1.0);
    assert_eq!(heavy.gravity_torque(&q), light.gravity_torque(&q) * unit);
    assert_eq!(heavy.mass_matrix(&q), light.mass_matrix(&q) * unit);
}
