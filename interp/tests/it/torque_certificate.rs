//! The certificate of the torques of the drives.

use arcfeed_interp::{Interpolation, JointTables, JointTrajectory, LimitTable, TableKind};
use arcfeed_kinematics::nalgebra::{Isometry3, Matrix3, SMatrix, Vector3};
use arcfeed_kinematics::{
    ArmDynamics, Chain as Links, Dynamics, Friction, Inertial, Joint, Joints, PathTorque, models,
};
use arcfeed_testing::Random;

use crate::certificate::{Chain, spike};

/// A point of 2 kg at 0.5 m from a horizontal axis: 0.5 kg m^2.
fn pendulum(gravity: f64) -> ArmDynamics<1> {
    let joint = Joint::revolute(Isometry3::identity(), Vector3::y()).expect("a joint");
    let links = Links::new([joint]).expect("an arm");
    let point = Inertial::new(2.0, Vector3::new(0.5, 0.0, 0.0), Matrix3::zeros()).expect("a point");
    let arm = ArmDynamics::new(&links, [point]).expect("an arm");
    arm.with_gravity(Vector3::new(0.0, 0.0, -gravity)).expect("gravity")
}

fn friction<const N: usize>(viscous: f64, forward: f64, backward: f64) -> Friction<N> {
    Friction::new(Joints::repeat(viscous), Joints::repeat(forward), Joints::repeat(backward)).expect("friction")
}

/// All joints through random states, at the same times.
fn wander<const N: usize>(random: &mut Random, pieces: usize) -> JointTrajectory<N> {
    let durations: Vec<f64> = (0..pieces).map(|_| random.log(0.02, 1.0)).collect();
    let chains: [Chain; N] = std::array::from_fn(|_| {
        let mut chain = Chain::new();
        chain.state[0] = random.between(-2.0, 2.0);
        for h in &durations {
            let [q, v, _] = chain.state;
            let end = [q + h * random.between(-1.5, 1.5), random.between(-1.5, 1.5), random.between(-5.0, 5.0)];
            // Some end at rest, as motions do.
            let end = if random.below(4) == 0 { [q + 0.5 * h * v, 0.0, 0.0] } else { end };
            chain.to(end, *h);
        }
        chain
    });
    let piece = |i: usize| std::array::from_fn(|k| Joints::from_fn(|j, _| chains[j].pieces[i][k][0]));
    let all = (0..pieces).map(piece).collect();
    JointTrajectory::from_pieces(chains[0].times.clone(), all, Interpolation::Quintic).expect("joined")
}

#[test]
fn torques_of_random_motions_are_those_of_dense_samples() {
    let mut random = Random::new(21);
    let robot = models::description("ur5e").expect("built in").build::<6>().expect("an arm");
    let bare = *robot.dynamics().expect("known");
    for case in 0..24 {
        let size = [0.0, 8.0][case % 2];
        let arm = bare.with_friction(friction(size, size, 0.5 * size));
        let motion = wander::<6>(&mut random, 6);
        let certificate = motion.certify_torque(&arm).expect("known");
        let mut sampled = Joints::<6>::zeros();
        for i in 0..=20_000 {
            let p = motion.at(motion.duration() * f64::from(i) / 20_000.0);
            sampled = sampled.sup(&arm.torque(&p.q, &p.qd, &p.qdd).abs());
        }
        for (bound, sampled) in certificate.bounds().iter().zip(sampled.iter()) {
            assert!(bound.bound >= *sampled, "case {case}: {bound:?} < {sampled}");
            assert!(bound.bound <= bound.attained * 1.002 + 0.02, "case {case}: {bound:?}");
            assert!(bound.attained <= sampled * 1.01 + 0.02, "case {case}: {bound:?} >> {sampled}");
            let p = motion.at(bound.t);
            let again = arm.torque(&p.q, &p.qd, &p.qdd)[bound.joint].abs();
            // At the border of two pieces, and at rest to rounding, the sampler may find the other direction.
            let jump = if p.qd[bound.joint].abs() < 1e-9 { 2.0 * size } else { 0.0 };
            assert!((again - bound.attained).abs() <= 1e-6 * again + jump, "case {case}: {bound:?}, {again}");
        }
        let most = Joints::from_fn(|j, _| certificate.bounds()[j].bound);
        assert!(certificate.holds(&most, 0.0) && !certificate.holds(&(most * 0.999), 1e-6), "case {case}");
    }
}

/// Without gravity the torque of a pendulum is its inertia times the acceleration: a quadratic whose largest value between two samples is
/// off their line by all that the bound on the second derivative allows. Half of that bound is not enough.
#[test]
fn a_largest_torque_between_two_samples_is_within_the_bound() {
    let (mut random, arm) = (Random::new(22), pendulum(0.0));
    for case in 0..300 {
        let h = random.log(0.01, 1.0);
        // qdd = 1 - (t - peak)^2 / h^2.
        let peak = h * random.between(0.1, 0.9);
        let c = [0.0, 0.0, 0.5 * (1.0 - peak.powi(2) / h.powi(2)), peak / (3.0 * h * h), -1.0 / (12.0 * h * h), 0.0];
        let piece = c.map(|c| Joints::from([c]));
        let motion = JointTrajectory::from_pieces(vec![0.0, h], vec![piece], Interpolation::Quintic).expect("a piece");
        let bound = motion.certify_torque(&arm).expect("known").bounds()[0];
        let p = motion.at(peak);
        let most = arm.torque(&p.q, &p.qd, &p.qdd)[0];
        assert!(
            (most - 0.5).abs() < 1e-9 && bound.bound >= most && bound.bound < 1.002 * most,
            "case {case}: {bound:?}"
        );
    }
}

#[test]
fn spikes_of_torque_are_caught_between_samples() {
    let mut random = Random::new(23);
    let arm = pendulum(9.81).with_friction(friction(0.1, 0.5, 0.5));
    let falling = LimitTable::new(&[[0.0, 16.0], [1.0, 14.0]]).expect("a table");
    let tables = JointTables::new().with(TableKind::TorqueBySpeed, 0, falling).expect("a joint");
    let mut unseen = 0;
    for case in 0..600 {
        let mut chain = Chain::new();
        chain.wander(&mut random);
        let limit = 16.0;
        let calm = chain.compiled();
        assert!(calm.certify_torque(&arm).expect("known").holds(&Joints::from([0.8 * limit]), 0.0), "case {case}");
        assert!(calm.certify_torque_tables(&arm, &tables).expect("known").holds(0.0), "case {case}");
        let (begin, width) = (chain.now(), random.between(1e-8, 1e-6));
        // Weight is 9.81 N m at the most.
        let height = (limit + 11.0) / 0.5 * random.between(1.01, 2.0) * random.sign();
        spike(&mut chain, 2, height, width);
        let end = chain.now();
        chain.wander(&mut random);
        let motion = chain.compiled();
        let near = (begin / 1.25e-4) as i32;
        let seen = (near - 8..near + 8).any(|i| {
            let p = motion.at(f64::from(i) * 1.25e-4);
            arm.torque(&p.q, &p.qd, &p.qdd)[0].abs() > limit
        });
        unseen += usize::from(!seen);
        let certificate = motion.certify_torque(&arm).expect("known");
        let bound = certificate.bounds()[0];
        assert!(!certificate.holds(&Joints::from([limit]), 1e-6) && bound.attained > limit, "case {case}: {bound:?}");
        assert!(bound.t >= begin - 1e-9 && bound.t <= end + 1e-9, "case {case}: {bound:?}");
        let table = motion.certify_torque_tables(&arm, &tables).expect("known");
        assert!(!table.holds(1e-6) && table.bounds()[0].attained > 1.0, "case {case}: {table:?}");
    }
    assert!(unseen > 550, "samples would have seen {} spikes", 600 - unseen);
}

#[test]
fn torques_over_tables_of_speed_are_those_of_dense_samples() {
    let mut random = Random::new(24);
    let arm = pendulum(9.81).with_friction(friction(0.3, 1.0, 2.0));
    for case in 0..60 {
        let motion = wander::<1>(&mut random, 4);
        let points: Vec<[f64; 2]> = (0..1 + random.below(5))
            .map(|i| [i as f64 * random.between(0.9, 1.0), random.between(5.0, 20.0)])
            .collect();
        let table = LimitTable::new(&points).expect("a table");
        let tables = JointTables::new().with(TableKind::TorqueBySpeed, 0, table.clone()).expect("a joint");
        let bound = motion.certify_torque_tables(&arm, &tables).expect("known").bounds()[0];
        let mut sampled = 0.0f64;
        for i in 0..=20_000 {
            let p = motion.at(motion.duration() * f64::from(i) / 20_000.0);
            let limit = table.least_between(0.0, p.qd[0].abs());
            sampled = sampled.max(arm.torque(&p.q, &p.qd, &p.qdd)[0].abs() / limit);
        }
        let at = format!("case {case}, {points:?}");
        assert!(bound.bound >= sampled * (1.0 - 1e-12), "{at}: {bound:?} < {sampled}");
        assert!(bound.bound <= bound.attained * 1.002 && bound.attained <= 1.01 * sampled, "{at}: {bound:?} {sampled}");
    }
}

/// The joint starts from rest against its weight, of 9.81 N m: friction has the direction of the motion and does not count against it.
#[test]
fn friction_has_the_directions_of_the_motion() {
    let arm = pendulum(9.81).with_friction(friction(0.0, 3.0, 3.0));
    let way = |size: f64| {
        let mut chain = Chain::new();
        chain.to([size, 0.0, 0.0], 2.0);
        chain.compiled().certify_torque(&arm).expect("known").bounds()[0]
    };
    // Positive turns lower the weight, which pulls with -9.81 N m: friction helps.
    assert!(arm.gravity_torque(&Joints::from([0.0]))[0] < -9.8);
    let [down, up] = [0.01, -0.01].map(way);
    assert!(down.bound > 9.81 && down.bound < 9.84, "{down:?}");
    assert!(up.bound > 12.81 && up.bound < 12.85, "{up:?}");
    // To and fro, both count.
    let mut chain = Chain::new();
    chain.to([0.01, 0.0, 0.0], 2.0);
    chain.to([0.0, 0.0, 0.0], 2.0);
    let both = chain.compiled().certify_torque(&arm).expect("known").bounds()[0];
    assert!(both.bound > 12.81 && both.bound < 12.85, "{both:?}");
    // A joint that rests is held without friction.
    let rest = JointTrajectory::resting(&Joints::from([0.0]), 1.0).expect("rests");
    let held = rest.certify_torque(&arm).expect("known").bounds()[0];
    assert!((held.bound - 9.81).abs() < 1e-6 && held.attained <= held.bound, "{held:?}");
}

/// Dynamics that state no bounds.
pub(crate) struct Unknown<const N: usize>(pub ArmDynamics<N>);

impl<const N: usize> Dynamics<N> for Unknown<N> {
    fn torque(&self, q: &Joints<N>, qd: &Joints<N>, qdd: &Joints<N>) -> Joints<N> {
        self.0.torque(q, qd, qdd)
    }

    fn mass_matrix(&self, q: &Joints<N>) -> SMatrix<f64, N, N> {
        self.0.mass_matrix(q)
    }

    fn bias(&self, q: &Joints<N>, qd: &Joints<N>) -> Joints<N> {
        self.0.bias(q, qd)
    }

    fn friction_torque(&self, qd: &Joints<N>) -> Joints<N> {
        self.0.friction_torque(qd)
    }

    fn along_path(&self, q: &Joints<N>, d1: &Joints<N>, d2: &Joints<N>) -> PathTorque<N> {
        self.0.along_path(q, d1, d2)
    }
}

#[test]
fn dynamics_without_bounds_are_not_certified() {
    let rest = JointTrajectory::resting(&Joints::from([0.0]), 1.0).expect("rests");
    let unknown = Unknown(pendulum(9.81));
    assert!(rest.certify_torque(&unknown).is_none());
    let flat = LimitTable::new(&[[0.0, 1.0]]).expect("a table");
    let tables = JointTables::new().with(TableKind::TorqueBySpeed, 0, flat).expect("a joint");
    assert!(rest.certify_torque_tables(&unknown, &tables).is_none());
    let none = rest.certify_torque_tables(&unknown, &JointTables::new()).expect("nothing to look at");
    assert!(none.bounds().is_empty() && none.holds(0.0));
}
