//! Compiled plans: every limit that was asked for is certified, and kept.

use std::sync::Arc;

use arcfeed_interp::{
    CompileError, Extent, FeedSection, JointTrajectory, LimitId, Limits, MotionPath, Planner, Quantity, TableKind,
    TableKind::TorqueBySpeed, ToolLimits,
};
use arcfeed_kinematics::{Arm, Joints};

use crate::common::bent::{half_circle, way_points};
use crate::limit_tables::{Kind, Told};
use crate::qb;
use crate::torque_certificate::Unknown;

/// Largest allowed deviation of a joint from the plan, rad: so large that pieces of an ordinary plan exceed limits.
const DEVIATION: f64 = 1e-5;
const TOLERANCE: f64 = 1e-6;

/// The largest ratio of the quantity of `kind` to its limit at dense samples, by the definition of each.
fn sampled(arm: &Arm<6>, told: &Told, kind: Kind, motion: &JointTrajectory<6>) -> f64 {
    let tables = |j: usize, q: f64, qd: f64, kinds: &[TableKind]| {
        let limit = |kind: &TableKind| {
            let table = told.tables.of(*kind, j)?;
            Some(if kind.is_by_speed() { table.least_between(0.0, qd.abs()) } else { table.at(q) })
        };
        kinds.iter().filter_map(limit).fold(f64::INFINITY, f64::min)
    };
    let dynamics = arm.dynamics().expect("known");
    let mut most = 0.0f64;
    for i in 0..=30_000 {
        let p = motion.at(motion.duration() * f64::from(i) / 30_000.0);
        let configuration = || arcfeed_kinematics::ForwardKinematics::configuration(arm, &p.q);
        let point = |twist: nalgebra::Vector6<f64>| twist.fixed_rows::<3>(0).norm();
        let ratio = match kind {
            Kind::ToolAcceleration => {
                let configuration = configuration();
                let change = configuration.jacobian() * p.qdd + configuration.acceleration_bias(&p.qd);
                point(change) / told.tool.acceleration().expect("limited")
            }
            Kind::ToolJerk => {
                let configuration = configuration();
                let third = configuration.jacobian() * p.jerk + configuration.jerk_bias(&p.qd, &p.qdd);
                point(third) / told.tool.jerk().expect("limited")
            }
            _ => {
                let by_torque = kind.quantity() == Quantity::JointTorque;
                let torque = by_torque.then(|| arcfeed_kinematics::Dynamics::torque(dynamics, &p.q, &p.qd, &p.qdd));
                let one = |j: usize| {
                    let (q, qd) = (p.q[j], p.qd[j]);
                    match kind.quantity() {
                        Quantity::JointTorque => {
                            torque.expect("computed")[j].abs() / tables(j, q, qd, &[TorqueBySpeed])
                        }
                        Quantity::JointJerk => {
                            p.jerk[j].abs() / tables(j, q, qd, &[TableKind::JerkBySpeed, TableKind::JerkByPosition])
                        }
                        _ => {
                            let kinds = [TableKind::AccelerationBySpeed, TableKind::AccelerationByPosition];
                            p.qdd[j].abs() / tables(j, q, qd, &kinds)
                        }
                    }
                };
                (0..6).map(one).fold(0.0, f64::max)
            }
        };
        most = most.max(ratio);
    }
    most
}

/// Tables, torques and the vectors of the tool: pieces of an ordinary plan exceed some of these limits. Those of a compiled plan keep all
/// of them at dense samples, and its certificate says so.
#[test]
fn a_compiled_plan_keeps_every_limit() {
    let arm = qb::arm();
    let paths: [(&str, Arc<dyn MotionPath<6>>); 2] =
        [("half circle", Arc::new(half_circle(&arm))), ("spline", Arc::new(way_points()))];
    let mut exceeded = 0;
    for (name, path) in paths {
        for kind in Kind::ALL {
            let told = if kind == Kind::TorqueBySpeed { kind.told(0.7) } else { kind.told(1.0) };
            let at = format!("{kind:?} on a {name}");
            let planner = told.planner(&arm);
            let ordinary = planner.plan_shared(path.clone()).unwrap_or_else(|error| panic!("{at}: {error}"));
            let pieces = ordinary.compile(DEVIATION).unwrap_or_else(|error| panic!("{at}: {error}"));
            exceeded += usize::from(sampled(&arm, &told, kind, &pieces) > 1.0 + TOLERANCE);
            let plan = planner.plan_compiled(path.clone(), DEVIATION).unwrap_or_else(|error| panic!("{at}: {error}"));
            let ratio = sampled(&arm, &told, kind, &plan.compiled);
            assert!(ratio <= 1.0 + TOLERANCE, "{at}: {ratio}");
            assert!(plan.certificate.holds(TOLERANCE), "{at}: {:?}", plan.certificate);
            let lines = plan.certificate.limits().iter().filter(|line| line.id.quantity == kind.quantity());
            let by_table = !matches!(kind, Kind::ToolAcceleration | Kind::ToolJerk);
            let worst = lines
                .filter(|line| line.table.is_some() == by_table)
                .map(|line| [line.ratio(), line.attained / line.limit]);
            let [bound, seen] = worst.fold([0.0f64; 2], |m, x| [m[0].max(x[0]), m[1].max(x[1])]);
            assert!(bound >= ratio && seen <= bound && seen >= 0.999 * ratio, "{at}: {bound} {seen} {ratio}");
            assert!(bound > 0.85, "{at}: {bound} does not bind");
            // Pieces that do not follow the jerk of the plan cost up to 1.16. The magnitude of the tool's jerk is followed joint by joint, which
            // costs more than a table.
            let most = if kind.quantity() == Quantity::ToolJerk { 1.035 } else { 1.01 };
            let slower = plan.trajectory.duration() / ordinary.duration();
            assert!(slower < most, "{at}: {slower} times as long");
        }
    }
    assert!(exceeded > 3, "pieces of {exceeded} ordinary plans exceed a limit: nothing to mend");
}

/// Feeds of sections are certified each on its own part of the path: by the compiled tool itself, whose place on a half circle is an
/// angle.
#[test]
fn the_feed_of_each_section_is_certified_on_its_part() {
    let arm = qb::arm();
    let path = Arc::new(half_circle(&arm));
    let length = path.length();
    let tool = ToolLimits::new().with_feed(0.2).expect("positive");
    let planner = Planner::new(&arm, Limits::new(qb::joints(&arm, 300.0)).with_tool(tool));
    let section = |[from, to, feed]: [f64; 3]| FeedSection {
        extent: Extent::Length { from: from * length, to: to * length },
        feed,
    };
    for (sections, feeds) in [
        (vec![], vec![[0.0, 1.0, 0.2]]),
        (vec![[0.0, 0.5, 0.04], [0.5, 1.0, 0.08]], vec![[0.0, 0.5, 0.04], [0.5, 1.0, 0.08]]),
        (vec![[0.0, 0.5, 0.08], [0.6, 1.0, 0.04]], vec![[0.0, 0.5, 0.08], [0.5, 0.6, 0.2], [0.6, 1.0, 0.04]]),
        (vec![[0.3, 0.7, 0.05]], vec![[0.0, 0.3, 0.2], [0.3, 0.7, 0.05], [0.7, 1.0, 0.2]]),
    ] {
        let planner = planner.clone().with_sections(sections.into_iter().map(section).collect());
        let plan = planner.plan_compiled(path.clone(), DEVIATION).expect("compiles");
        let lines = plan.certificate.feeds();
        assert_eq!(lines.len(), feeds.len(), "{lines:?}");
        let mut seen = vec![0.0_f64; feeds.len()];
        for i in 0..=40_000 {
            let p = plan.compiled.at(plan.compiled.duration() * f64::from(i) / 40_000.0);
            let configuration = arcfeed_kinematics::ForwardKinematics::configuration(&arm, &p.q);
            let speed = (configuration.jacobian() * p.qd).fixed_rows::<3>(0).norm();
            let at = arcfeed_kinematics::ForwardKinematics::forward(&arm, &p.q).translation.vector;
            let part = 0.5 + (at.y / (at.x - 0.36)).atan() / std::f64::consts::PI;
            // Not within the deviation of a border.
            let inside = |[from, to, _]: &[f64; 3]| from + 1e-4 < part && part < to - 1e-4;
            if let Some(k) = feeds.iter().position(inside) {
                seen[k] = seen[k].max(speed);
            }
        }
        for ((line, [.., feed]), seen) in lines.iter().zip(&feeds).zip(seen) {
            let limit = line.limit;
            assert!(limit.limit == *feed && limit.holds(TOLERANCE), "{feed}: {line:?}");
            // Between two slow sections 0.2 m/s are not reached.
            let least = if *feed == 0.2 { 0.5 } else { 0.9 };
            assert!(seen <= limit.bound && seen > least * feed, "{feed}: {seen} {line:?}");
            assert!(limit.attained <= limit.bound && line.from <= limit.t && limit.t <= line.to, "{line:?}");
        }
        let worst = plan.certificate.of_limit(LimitId::path(Quantity::Feed)).expect("certified");
        assert!(lines.iter().all(|line| line.limit.ratio() <= worst.ratio()), "{worst:?} {lines:?}");
        assert!(plan.certificate.holds(TOLERANCE));
    }
}

/// A constant limit on the torque has a line for each joint.
#[test]
fn a_compiled_plan_keeps_torques() {
    let arm = qb::arm();
    let told = Told { torque: Some(0.45), ..Told::loose() };
    let plan = told.planner(&arm).plan_compiled(Arc::new(half_circle(&arm)), DEVIATION).expect("compiles");
    let limits = *plan.trajectory.limits().torque().expect("limited").limits();
    let (mut most, dynamics) = (Joints::<6>::zeros(), arm.dynamics().expect("known"));
    for i in 0..=50_000 {
        let p = plan.compiled.at(plan.compiled.duration() * f64::from(i) / 50_000.0);
        most = most.sup(&arcfeed_kinematics::Dynamics::torque(dynamics, &p.q, &p.qd, &p.qdd).abs());
    }
    for j in 0..6 {
        let line = plan.certificate.of_limit(LimitId::joint(Quantity::JointTorque, j)).expect("certified");
        assert!(most[j] <= line.bound && line.bound <= limits[j] * (1.0 + TOLERANCE), "{line:?}, {}", most[j]);
        assert!(line.attained >= 0.999 * most[j] && line.limit == limits[j], "{line:?}, {}", most[j]);
    }
    assert!(most.component_div(&limits).max() > 0.9, "{most} does not bind");
}

#[test]
fn torques_of_dynamics_without_bounds_are_refused() {
    let arm = qb::arm();
    let unknown = Unknown(*arm.dynamics().expect("known"));
    let joints = *Told::loose().planner(&arm).limits().joints();
    let limits = Limits::new(joints).with_torque(&unknown, Joints::repeat(500.0)).expect("above 0");
    let error = Planner::new(&arm, limits).plan_compiled(Arc::new(way_points()), DEVIATION).expect_err("no bounds");
    assert_eq!(error, CompileError::UnboundedTorque);
    assert!(error.to_string().contains("torque_bounds"), "{error}");
    // Without a limit there is nothing to certify.
    let free = Limits::new(joints).with_torque(&unknown, Joints::repeat(f64::INFINITY)).expect("above 0");
    assert!(Planner::new(&arm, free).plan_compiled(Arc::new(way_points()), DEVIATION).is_ok());
}
