//! The certificates of limits by tables, and of the magnitudes of acceleration and jerk of a tool.

use arcfeed_interp::{Interpolation, JointTables, JointTrajectory, LimitTable, TableKind};
use arcfeed_kinematics::{Chain as Arm, ForwardKinematics, Joint, Joints, models};
use arcfeed_testing::Random;
use nalgebra::{Isometry3, Vector3};

use crate::certificate::{Chain, Piece, spike};

const KINDS: [TableKind; 4] = [
    TableKind::AccelerationBySpeed,
    TableKind::JerkBySpeed,
    TableKind::AccelerationByPosition,
    TableKind::JerkByPosition,
];

/// A table between `from` and `to` of up to six points, with limits around `size`.
fn table(random: &mut Random, [from, to]: [f64; 2], size: f64) -> LimitTable {
    let mut arguments: Vec<f64> = (0..1 + random.below(6)).map(|_| random.between(from, to)).collect();
    arguments.sort_by(f64::total_cmp);
    arguments.dedup();
    let points: Vec<[f64; 2]> = arguments.into_iter().map(|x| [x, size * random.between(0.2, 2.0)]).collect();
    LimitTable::new(&points).expect("a table")
}

/// Value over limit at a time, by the definition.
fn ratio(motion: &JointTrajectory<1>, kind: TableKind, table: &LimitTable, t: f64) -> f64 {
    let p = motion.at(t);
    let value = match kind {
        TableKind::AccelerationBySpeed | TableKind::AccelerationByPosition => p.qdd[0],
        _ => p.jerk[0],
    };
    let limit = if kind.is_by_speed() { table.least_between(0.0, p.qd[0].abs()) } else { table.at(p.q[0]) };
    value.abs() / limit
}

#[test]
fn ratios_of_random_motions_to_random_tables_agree_with_dense_samples() {
    let mut random = Random::new(3);
    for case in 0..400 {
        let kind = KINDS[case % 4];
        let h = random.log(1e-3, 10.0);
        let c: [f64; 6] = std::array::from_fn(|k| random.between(-1.0, 1.0) / h.powi(k as i32));
        let piece: Piece<1> = c.map(|c| Joints::from([c]));
        let motion = JointTrajectory::from_pieces(vec![0.0, h], vec![piece], Interpolation::Quintic).expect("a piece");
        let (range, order) = if kind.is_by_speed() { ([0.0, 5.0 / h], 1) } else { ([-3.0, 3.0], 0) };
        let size = if case % 2 == 0 { 10.0 / h.powi(2) } else { 50.0 / h.powi(3) };
        let table = table(&mut random, range, size);
        let tables = JointTables::new().with(kind, 0, table.clone()).expect("a joint");
        let certificate = motion.certify_tables(&tables);
        let bound = *certificate.of(kind, 0).expect("certified");
        let sampled = (0..=20_000).map(|i| ratio(&motion, kind, &table, h * f64::from(i) / 20_000.0));
        let sampled = sampled.fold(0.0, f64::max);
        let at = format!("case {case}, {kind:?}, order {order}, {table:?}, {c:?}");
        assert!(bound.bound >= sampled * (1.0 - 1e-12), "{at}: {} < {sampled}", bound.bound);
        assert!(bound.bound <= bound.attained * (1.0 + 2e-6), "{at}: {bound:?}");
        assert!(bound.attained <= sampled * (1.0 + 2e-3), "{at}: {bound:?}, {sampled}");
        let again = ratio(&motion, kind, &table, bound.t);
        assert!((again - bound.attained).abs() <= 1e-6 * bound.attained, "{at}: {again} is not {bound:?}");
        for tolerance in [0.99, 1.01] {
            let scaled = tables.scaled(&[kind], 0, bound.bound * tolerance).expect("in range");
            assert_eq!(motion.certify_tables(&scaled).holds(0.0), tolerance > 1.0, "{at}");
        }
    }
}

#[test]
fn spikes_above_a_table_are_caught_between_samples() {
    let mut random = Random::new(4);
    let mut unseen = 0;
    for case in 0..1000 {
        let kind = KINDS[case % 4];
        let (order, size) = if case % 2 == 0 { (2, 10.0) } else { (3, 100.0) };
        let table = match kind.is_by_speed() {
            true => LimitTable::new(&[[0.0, size], [1.0, 0.5 * size]]),
            false => LimitTable::new(&[[-1.0, 0.5 * size], [0.0, size], [1.0, 0.7 * size]]),
        };
        let table = table.expect("a table");
        let tables = JointTables::new().with(kind, 0, table.clone()).expect("a joint");
        let mut chain = Chain::new();
        chain.wander(&mut random);
        assert!(chain.compiled().certify_tables(&tables).holds(1e-6), "case {case}: without a spike");
        let (begin, width) = (chain.now(), random.between(1e-8, 1e-6));
        let limit = table.at(if kind.is_by_speed() { chain.state[1].abs() } else { chain.state[0] });
        let height = limit * random.between(1.01, 2.0) * random.sign();
        spike(&mut chain, order, height, width);
        let end = chain.now();
        chain.wander(&mut random);
        let motion = chain.compiled();
        let near = (begin / 1.25e-4) as i32;
        let seen = (near - 8..near + 8).any(|i| ratio(&motion, kind, &table, f64::from(i) * 1.25e-4) > 1.0);
        unseen += usize::from(!seen);
        let certificate = motion.certify_tables(&tables);
        let bound = certificate.bounds()[0];
        assert!(!certificate.holds(1e-6) && bound.attained > 1.005, "case {case}: {bound:?}");
        assert!(bound.t >= begin - 1e-9 && bound.t <= end + 1e-9, "case {case}: {bound:?}");
    }
    assert!(unseen > 950, "samples would have seen {} spikes", 1000 - unseen);
}

#[test]
fn tables_without_a_motion_to_hold_and_numbers_that_are_none() {
    let motion = Chain { times: vec![0.0, 1.0], pieces: vec![[Joints::zeros(); 6]], state: [0.0; 3] }.compiled();
    assert!(motion.certify_tables(&JointTables::new()).holds(0.0));
    let flat = LimitTable::new(&[[0.0, 1.0]]).expect("a table");
    let torque = JointTables::new().with(TableKind::TorqueBySpeed, 0, flat.clone()).expect("a joint");
    assert!(motion.certify_tables(&torque).bounds().is_empty());
    let tables = JointTables::new().with(TableKind::JerkBySpeed, 0, flat).expect("a joint");
    let bound = motion.certify_tables(&tables).bounds()[0];
    assert!(bound.attained == 0.0 && bound.bound < 1e-300, "{bound:?}");
}

/// An arm of one joint with a tool at a distance of 0.8 m from its axis.
fn lever() -> Arm<1> {
    let joint = Joint::revolute(Isometry3::identity(), Vector3::z()).expect("a joint");
    let arm = Arm::new([joint]).expect("an arm");
    arm.with_tool(Isometry3::translation(0.8, 0.0, 0.0)).expect("a tool")
}

#[test]
fn spikes_of_the_tool_are_caught_between_samples() {
    let (mut random, arm) = (Random::new(5), lever());
    for case in 0..400 {
        let which = case % 2;
        let limit = [8.0, 80.0][which];
        let mut chain = Chain::new();
        chain.wander(&mut random);
        let calm = chain.compiled().certify_tool_magnitudes(&arm)[which];
        assert!(calm.bound < limit, "case {case}: {calm:?} without a spike");
        let (begin, width) = (chain.now(), random.between(1e-8, 1e-6));
        let height = 1.25 * limit * random.between(1.01, 2.0) * random.sign();
        spike(&mut chain, 2 + which, height, width);
        let end = chain.now();
        chain.wander(&mut random);
        let bound = chain.compiled().certify_tool_magnitudes(&arm)[which];
        assert!(bound.bound >= bound.attained && bound.attained > 1.005 * limit, "case {case}: {bound:?}");
        assert!(bound.t >= begin - 1e-9 && bound.t <= end + 1e-9, "case {case}: {bound:?}");
    }
}

#[test]
fn magnitudes_of_random_motions_are_those_of_dense_samples() {
    let mut random = Random::new(6);
    let arm = models::cr7();
    let mut inside = [0; 2];
    for case in 0..60 {
        let h = random.log(0.02, 0.5);
        // From rest to rest: the acceleration, and with large ways the jerk as well, is largest inside.
        let size = random.log(0.05, 4.0);
        let [start, way] = [1.0, size].map(|size| Joints::<6>::from_fn(|_, _| size * random.signed()));
        let zero = Joints::zeros();
        let piece: Piece<6> =
            [start, zero, zero, way * (10.0 / h.powi(3)), way * (-15.0 / h.powi(4)), way * (6.0 / h.powi(5))];
        let motion = JointTrajectory::from_pieces(vec![0.0, h], vec![piece], Interpolation::Quintic).expect("a piece");
        let bounds = motion.certify_tool_magnitudes(&arm);
        let mut sampled = [0.0f64; 2];
        for i in 0..=4000 {
            let p = motion.at(h * f64::from(i) / 4000.0);
            let change = arm.jacobian(&p.q) * p.qdd + arm.configuration(&p.q).acceleration_bias(&p.qd);
            let third = arm.jacobian(&p.q) * p.jerk + arm.configuration(&p.q).jerk_bias(&p.qd, &p.qdd);
            sampled[0] = sampled[0].max(change.fixed_rows::<3>(0).norm());
            sampled[1] = sampled[1].max(third.fixed_rows::<3>(0).norm());
        }
        for ((bound, sampled), inside) in bounds.iter().zip(sampled).zip(&mut inside) {
            *inside += usize::from(bound.t > 0.0 && bound.t < h);
            assert!(bound.bound >= sampled, "case {case}: {bound:?} < {sampled}");
            assert!(bound.bound <= 1.01 * sampled, "case {case}: {bound:?} >> {sampled}");
        }
    }
    assert!(inside[0] > 50 && inside[1] > 5, "{inside:?}");
}
