//! Kinematics and dynamics beside rs-opw-kinematics 3 and k 0.32 in one run, at random joint values inside the limits.
//!
//! Measured on a 2-core AMD EPYC VM, medians of one run:
//!
//! | KR 6 R700 | arcfeed | rs-opw-kinematics 3.0.0 | k 0.32.0 |
//! |---|---|---|---|
//! | forward | 78 ns | 161 ns | 356 ns |
//! | forward and Jacobian | 121 ns | | 1.08 us |
//! | all inverse solutions | 0.73 us | 3.53 us | |
//! | torque (Newton-Euler) | 220 ns | | |
//! | mass matrix | 274 ns | | |
//! | all torque coefficients along a path | 0.59 us | | |
//!
//! All solutions of the Puma 560 0.79 us, of the UR5e 0.62 us. The Panda's inverse from a seed 0.01 rad away: 1.57 us to
//! 1e-11 m and rad, k 21 us to 1e-3 m and 5e-3 rad.

use arcfeed_kinematics::{
    AnalyticInverse, ArmDynamics, Dynamics, ForwardKinematics, InverseKinematics, JointRange, Joints, models,
};
use criterion::{BatchSize, Criterion, criterion_group, criterion_main};
use k::{InverseKinematicsSolver, SerialChain};
use nalgebra::Isometry3;
use rs_opw_kinematics::{
    glam::{DQuat, DVec3},
    kinematic_traits::Kinematics,
    kinematics_impl::OPWKinematics,
    parameters::opw_kinematics::Parameters,
    pose::Pose,
};
use std::{hint::black_box, time::Duration};

const COUNT: usize = 512;

/// Joint values spread over the range, the same on every machine.
fn samples<const N: usize>(range: &JointRange<N>) -> Vec<Joints<N>> {
    let mut state = 20_260_101_u64;
    let mut draw = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    };
    let (lower, upper) = (range.lower(), range.upper());
    (0..COUNT).map(|_| Joints::from_fn(|i, _| lower[i] + draw() * (upper[i] - lower[i]))).collect()
}

/// The KR 6 R700 as rs-opw-kinematics describes it.
fn opw() -> OPWKinematics {
    OPWKinematics::new(Parameters {
        a1: 0.025,
        a2: -0.025,
        b: 0.0,
        c1: 0.4,
        c2: 0.335,
        c3: 0.365,
        c4: 0.09,
        offsets: [0.0, -std::f64::consts::FRAC_PI_2, 0.0, 0.0, 0.0, 0.0],
        sign_corrections: [-1, 1, 1, -1, 1, -1],
        dof: 6,
    })
}

fn opw_pose(pose: &Isometry3<f64>) -> Pose {
    let (t, q) = (pose.translation, pose.rotation.coords);
    Pose::from_parts(DVec3::new(t.x, t.y, t.z), DQuat::from_xyzw(q.x, q.y, q.z, q.w))
}

/// A built-in arm in k, by way of URDF.
fn k_chain(name: &str) -> SerialChain<f64> {
    let text = models::description(name).expect("built in").to_urdf();
    let robot = urdf_for_k(&text);
    SerialChain::from_end(robot.find("flange_joint").expect("written by us"))
}

fn urdf_for_k(text: &str) -> k::Chain<f64> {
    let path = std::env::temp_dir().join(format!("arcfeed_bench_{}.urdf", std::process::id()));
    std::fs::write(&path, text).expect("a temporary folder that can be written to");
    let chain = k::Chain::<f64>::from_urdf_file(&path).expect("written by us");
    // Nothing depends on its being gone.
    let _ = std::fs::remove_file(path);
    chain
}

fn distance(ours: &Isometry3<f64>, translation: [f64; 3]) -> f64 {
    (ours.translation.vector - nalgebra::Vector3::from(translation)).norm()
}

/// The numbers of the samples, round and round.
fn turns() -> impl FnMut() -> usize {
    let mut i = 0;
    move || {
        i = (i + 1) % COUNT;
        i
    }
}

fn kr6(criterion: &mut Criterion) {
    let kr6 = models::kr6_r700();
    let kr6_links: ArmDynamics<6> = *models::description("kr6_r700")
        .and_then(|arm| arm.build::<6>().ok()?.dynamics().copied())
        .as_ref()
        .expect("known");
    let (opw, k_kr6) = (opw(), k_chain("kr6_r700"));
    let joints = samples(kr6.range());
    let poses: Vec<Isometry3<f64>> = joints.iter().map(|q| kr6.forward(q)).collect();
    // The same arm, or the times mean nothing.
    for (q, pose) in joints.iter().zip(&poses) {
        let theirs = opw.forward(&(*q).into()).translation;
        assert!(distance(pose, theirs.into()) < 1e-9, "rs-opw-kinematics has another arm");
        k_kr6.set_joint_positions_unchecked(q.as_slice());
        let theirs = k_kr6.end_transform().translation;
        assert!(distance(pose, [theirs.x, theirs.y, theirs.z]) < 1e-9, "k has another arm");
    }
    let mut next = turns();
    let mut group = criterion.benchmark_group("kr6");
    group.warm_up_time(Duration::from_millis(500)).measurement_time(Duration::from_secs(2)).sample_size(50);
    group.bench_function("forward", |b| b.iter(|| kr6.forward(black_box(&joints[next()]))));
    group.bench_function("forward/opw", |b| b.iter(|| opw.forward(black_box(&joints[next()].into()))));
    group.bench_function("forward/k", |b| {
        b.iter(|| {
            k_kr6.set_joint_positions_unchecked(black_box(joints[next()].as_slice()));
            k_kr6.end_transform()
        })
    });
    group.bench_function("forward_jacobian", |b| b.iter(|| kr6.forward_jacobian(black_box(&joints[next()]))));
    group.bench_function("forward_jacobian/k", |b| {
        b.iter(|| {
            k_kr6.set_joint_positions_unchecked(black_box(joints[next()].as_slice()));
            k::jacobian(&k_kr6)
        })
    });
    group.bench_function("inverse_all", |b| b.iter(|| kr6.inverse_all(black_box(&poses[next()]))));
    let theirs: Vec<Pose> = poses.iter().map(opw_pose).collect();
    group.bench_function("inverse_all/opw", |b| b.iter(|| opw.inverse(black_box(&theirs[next()]))));
    group.bench_function("torque", |b| {
        let (qd, qdd) = (Joints::repeat(0.5), Joints::repeat(-2.0));
        b.iter(|| kr6_links.torque(black_box(&joints[next()]), &qd, &qdd))
    });
    group.bench_function("mass_matrix", |b| b.iter(|| kr6_links.mass_matrix(black_box(&joints[next()]))));
    group.bench_function("along_path", |b| {
        let (d1, d2) = (Joints::repeat(0.5), Joints::repeat(-2.0));
        b.iter(|| kr6_links.along_path(black_box(&joints[next()]), &d1, &d2))
    });
    group.finish();
}

fn other_closed_forms(criterion: &mut Criterion) {
    let mut next = turns();
    let mut group = criterion.benchmark_group("other closed forms");
    group.warm_up_time(Duration::from_millis(500)).measurement_time(Duration::from_secs(2)).sample_size(50);
    let puma = models::puma560();
    let puma_poses: Vec<_> = samples(puma.range()).iter().map(|q| puma.forward(q)).collect();
    group.bench_function("puma560 inverse_all", |b| b.iter(|| puma.inverse_all(black_box(&puma_poses[next()]))));
    let ur = models::ur5e();
    let ur_poses: Vec<_> = samples(ur.range()).iter().map(|q| ur.forward(q)).collect();
    group.bench_function("ur5e inverse_all", |b| b.iter(|| ur.inverse_all(black_box(&ur_poses[next()]))));
    group.finish();
}

fn panda(criterion: &mut Criterion) {
    let mut next = turns();
    let panda = models::panda();
    let k_panda = k_chain("panda");
    let panda_joints = samples(panda.range());
    let panda_poses: Vec<_> = panda_joints.iter().map(|q| panda.forward(q)).collect();
    let seeds: Vec<_> = panda_joints.iter().map(|q| q.map(|v| v + 0.01)).collect();
    let mut group = criterion.benchmark_group("panda");
    group.warm_up_time(Duration::from_millis(500)).measurement_time(Duration::from_secs(2)).sample_size(50);
    group.bench_function("inverse from a seed 0.01 rad away, to 1e-11", |b| {
        b.iter(|| {
            let k = next();
            panda.inverse(black_box(&panda_poses[k]), &seeds[k])
        })
    });
    // k's own default: 1 mm and 0.005 rad.
    let solver = k::JacobianIkSolver::<f64>::default();
    let targets: Vec<_> = panda_joints
        .iter()
        .map(|q| {
            k_panda.set_joint_positions_unchecked(q.as_slice());
            k_panda.end_transform()
        })
        .collect();
    group.bench_function("inverse/k from a seed 0.01 rad away, to 1e-3", |b| {
        b.iter_batched(
            || {
                let k = next();
                k_panda.set_joint_positions_clamped(seeds[k].as_slice());
                k
            },
            |k| solver.solve(&k_panda, black_box(&targets[k])),
            BatchSize::PerIteration,
        )
    });
    group.finish();
}

criterion_group!(all, kr6, other_closed_forms, panda);
criterion_main!(all);
