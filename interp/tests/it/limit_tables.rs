//! Limits that depend on the state of a joint, and limits on the vectors of the tool: planned, checked, and checked by differences.

use crate::common::bent::{half_circle, paths_of_every_kind, way_points};
use crate::common::{line_and_arc, tool_down};
use crate::qb;

use arcfeed_interp::{
    JointSpline, JointTables, LimitError, LimitTable, Limits, Method, MotionPath, PlanError, Planner, Quantity,
    RowsNeeded, TableKind, ToolLimits, ToolPath, Trajectory, Verification,
};
use arcfeed_kinematics::{Arm, ForwardKinematics, Joints};
use arcfeed_testing::Random;
use nalgebra::Vector3;

const TOLERANCE: f64 = 1e-6;
/// How much higher than the true one a mutated limit is.
const RAISED: f64 = 1.01;

/// What a planner is told.
#[derive(Debug, Clone)]
pub(crate) struct Told {
    pub rates: [f64; 3],
    pub torque: Option<f64>,
    pub tool: ToolLimits,
    pub tables: JointTables<6>,
}

impl Told {
    pub fn loose() -> Self {
        let tool = ToolLimits::new().with_feed(1.0).expect("above 0");
        Self { rates: [3.0, 60.0, 2000.0], torque: None, tool, tables: JointTables::new() }
    }

    pub fn planner<'a>(&'a self, arm: &'a Arm<6>) -> Planner<'a> {
        let [v, a, j] = self.rates.map(Joints::repeat);
        let mut limits = Limits::new(arm.range().with_rates(v, a, j).expect("valid limits"));
        if let Some(part) = self.torque {
            let torque = Joints::from([150.0, 150.0, 80.0, 30.0, 25.0, 20.0]) * part;
            limits = limits.with_torque(arm.dynamics().expect("known"), torque).expect("above 0");
        }
        Planner::new(arm, limits.with_tool(self.tool).with_tables(&self.tables))
            .with_chord_tolerance(1e-3)
            .expect("valid")
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    AccelerationBySpeed,
    AccelerationByPosition,
    JerkBySpeed,
    JerkByPosition,
    TorqueBySpeed,
    ToolAcceleration,
    ToolJerk,
}

impl Kind {
    pub const ALL: [Self; 7] = [
        Self::AccelerationBySpeed,
        Self::AccelerationByPosition,
        Self::JerkBySpeed,
        Self::JerkByPosition,
        Self::TorqueBySpeed,
        Self::ToolAcceleration,
        Self::ToolJerk,
    ];

    pub fn quantity(self) -> Quantity {
        match self {
            Self::AccelerationBySpeed | Self::AccelerationByPosition => Quantity::JointAcceleration,
            Self::JerkBySpeed | Self::JerkByPosition => Quantity::JointJerk,
            Self::TorqueBySpeed => Quantity::JointTorque,
            Self::ToolAcceleration => Quantity::ToolAcceleration,
            Self::ToolJerk => Quantity::ToolJerk,
        }
    }

    /// Limits among which this one binds, it being `factor` times as high; without it for an infinite factor.
    pub fn told(self, factor: f64) -> Told {
        let mut told = Told::loose();
        if self == Self::TorqueBySpeed {
            told.torque = Some(1.0);
        }
        if factor == f64::INFINITY {
            return told;
        }
        let all = |kind: TableKind, points: &dyn Fn(usize) -> Vec<[f64; 2]>| {
            (0..6).fold(JointTables::new(), |tables, j| {
                let points: Vec<[f64; 2]> = points(j).into_iter().map(|[x, y]| [x, factor * y]).collect();
                tables.with(kind, j, LimitTable::new(&points).expect("a table")).expect("a joint")
            })
        };
        match self {
            // A knee, and a fall that is not concave.
            Self::AccelerationBySpeed => {
                told.tables = all(TableKind::AccelerationBySpeed, &|_| vec![[0.2, 4.0], [0.6, 2.5], [1.2, 2.0]]);
            }
            Self::AccelerationByPosition => {
                told.tables = all(TableKind::AccelerationByPosition, &|_| vec![[-1.0, 2.0], [0.2, 4.0], [1.5, 2.5]]);
            }
            Self::JerkBySpeed => {
                told.tables = all(TableKind::JerkBySpeed, &|_| vec![[0.1, 60.0], [0.5, 40.0], [1.0, 35.0]]);
            }
            Self::JerkByPosition => {
                told.tables = all(TableKind::JerkByPosition, &|_| vec![[-1.0, 40.0], [0.2, 70.0], [1.5, 50.0]]);
            }
            Self::TorqueBySpeed => {
                let most = [150.0, 150.0, 80.0, 30.0, 25.0, 20.0];
                told.tables = all(TableKind::TorqueBySpeed, &|j| vec![[0.2, most[j]], [1.5, 0.7 * most[j]]]);
            }
            Self::ToolAcceleration => told.tool = told.tool.with_acceleration(0.8 * factor).expect("above 0"),
            Self::ToolJerk => told.tool = told.tool.with_jerk(12.0 * factor).expect("above 0"),
        }
        told
    }
}

/// Refused for `quantity`, and for nothing but what follows from it.
fn named(row: &str, verification: &Verification, quantity: Quantity, least: f64) {
    let check = verification.worst_of(quantity).expect("looked at");
    assert!(check.ratio > least, "{row}: {check:?} is not what was broken");
    for broken in verification.checks().iter().filter(|check| check.ratio > 1.0 + TOLERANCE || check.ratio.is_nan()) {
        assert!(broken.quantity() == quantity, "{row}: {broken:?} is broken too");
    }
}

/// A planner that raises a limit by 1 %, and one that ignores it, are caught by its name; the true one holds and uses the limit.
fn mutated(row: &str, arm: &Arm<6>, path: &dyn MotionPath<6>, kind: Kind) {
    let truth = kind.told(1.0);
    let planner = truth.planner(arm);
    let plan = planner.plan(path).unwrap_or_else(|error| panic!("{row}: {error}"));
    let worst = plan.verification().worst_of(kind.quantity()).expect("looked at");
    assert!(plan.verification().holds(TOLERANCE), "{row}: {:?}", plan.verification().worst());
    // What the lines below a table and the polygons inside a circle leave.
    assert!(worst.ratio > 0.9, "{row}: {worst:?} does not bind");
    let problem = planner.prepare(path, RowsNeeded::Jerk).expect("it was planned");
    for (factor, least) in [(RAISED / worst.ratio, 1.0 + 0.5 * (RAISED - 1.0)), (f64::INFINITY, 1.05)] {
        let told = kind.told(factor);
        let wrong = told.planner(arm).plan(path).unwrap_or_else(|error| panic!("{row}, {factor}: {error}"));
        let verification = planner.verify(&problem, wrong.law(), true).expect("on the path");
        named(&format!("{row}, {factor} times"), &verification, kind.quantity(), least);
    }
}

#[test]
fn the_checker_names_what_a_planner_without_or_with_higher_limits_breaks() {
    let arm = qb::arm();
    for (name, path) in &paths_of_every_kind(&arm) {
        let path = &**path;
        for kind in Kind::ALL {
            mutated(&format!("{kind:?} on a {name}"), &arm, path, kind);
        }
    }
}

/// Limits of joint `j` at a position and a velocity, in units of which its acceleration and its jerk are below 1.
fn limits_at(told: &Told, j: usize, q: f64, qd: f64) -> [f64; 2] {
    let least = |constant: f64, kinds: [(TableKind, f64); 2]| {
        kinds.iter().filter_map(|(kind, x)| Some(told.tables.of(*kind, j)?.at(*x))).fold(constant, f64::min)
    };
    let by = |speed, position| [(speed, qd.abs()), (position, q)];
    [
        least(told.rates[1], by(TableKind::AccelerationBySpeed, TableKind::AccelerationByPosition)),
        least(told.rates[2], by(TableKind::JerkBySpeed, TableKind::JerkByPosition)),
    ]
}

/// The largest ratios of acceleration and jerk to their limits, joints and tool, by differences of positions `dt` apart.
fn by_differences(arm: &Arm<6>, told: &Told, plan: &Trajectory<'_>) -> [f64; 4] {
    let n = 20_000.min((plan.duration() / 1e-3) as usize).max(50);
    let dt = plan.duration() / n as f64;
    let mut setpoints = plan.setpoints(1e-3).expect("a period");
    let q: Vec<Joints<6>> = (0..=n).map(|i| setpoints.at(dt * i as f64).expect("on the path").q).collect();
    let p: Vec<Vector3<f64>> = q.iter().map(|q| arm.forward(q).translation.vector).collect();
    let mut most = [0.0_f64; 4];
    for i in 0..n - 2 {
        for j in 0..6 {
            let [a, b, c, d] = [0, 1, 2, 3].map(|k| q[i + k][j]);
            // Differences are means over their time: the highest limit over that time bounds them.
            let [v0, v1, v2] = [b - a, c - b, d - c].map(|step| step / dt);
            let highest = |which: usize, v: &[f64], places: &[f64]| {
                let turns = v.iter().any(|x| x * v[0] <= 0.0);
                let speeds = v.iter().copied().chain(turns.then_some(0.0));
                let all = speeds.flat_map(|v| places.iter().map(move |q| (*q, v)));
                all.map(|(q, v)| limits_at(told, j, q, v)[which]).fold(0.0, f64::max)
            };
            let margin = told.rates[1] * dt;
            let over =
                |v: &[f64]| v.iter().flat_map(|v| [v.abs() - margin, v.abs() + margin]).map(|v| v.max(0.0)).collect();
            let (two, three): (Vec<f64>, Vec<f64>) = (over(&[v0, v1]), over(&[v0, v1, v2]));
            most[0] = most[0].max((v1 - v0).abs() / dt / highest(0, &two, &[a, b, c]));
            most[1] = most[1].max((v2 - 2.0 * v1 + v0).abs() / dt / dt / highest(1, &three, &[a, b, c, d]));
        }
        let second = (p[i + 2] - p[i + 1] * 2.0 + p[i]) / (dt * dt);
        let third = (p[i + 3] - p[i + 2] * 3.0 + p[i + 1] * 3.0 - p[i]) / (dt * dt * dt);
        most[2] = most[2].max(second.norm() / told.tool.acceleration().unwrap_or(f64::INFINITY));
        most[3] = most[3].max(third.norm() / told.tool.jerk().unwrap_or(f64::INFINITY));
    }
    most
}

/// A line runs into a quarter circle: the acceleration of the tool steps by v^2 / radius, spread over a control period.
#[test]
fn tool_jerk_holds_where_the_curvature_jumps() {
    let arm = qb::arm();
    let path = ToolPath::new(&arm, tool_down(line_and_arc(0.1, 0.05)), arm.range()).expect("in reach");
    let loose = Told::loose();
    let free = loose.planner(&arm).plan(&path).expect("it can be followed");
    let tool = loose.tool.with_acceleration(3.0).and_then(|tool| tool.with_jerk(150.0)).expect("above 0");
    let told = Told { tool, ..loose.clone() };
    let plan = told.planner(&arm).plan(&path).expect("it can be followed");
    assert!(plan.duration() > 1.05 * free.duration(), "{} and {} s", plan.duration(), free.duration());
    let worst = plan.verification().worst_of(Quantity::ToolJerk).expect("looked at");
    assert!((0.97..=1.0 + TOLERANCE).contains(&worst.ratio), "{worst:?}");
    // At the bend v^2 / radius steps within a control period.
    let bend = plan.law().v_at_s(0.1);
    assert!(bend * bend / 0.05 <= 150.0 * 1e-3 * (1.0 + TOLERANCE), "{bend} m/s");
    assert!(bend * bend / 0.05 > 0.9 * 150.0 * 1e-3, "{bend} m/s");
    // The free plan breaks both limits.
    let planner = told.planner(&arm);
    let problem = planner.prepare(&path, RowsNeeded::Jerk).expect("it was planned");
    let verification = planner.verify(&problem, free.law(), true).expect("on the path");
    for quantity in [Quantity::ToolJerk, Quantity::ToolAcceleration] {
        assert!(verification.worst_of(quantity).expect("looked at").ratio > 1.5, "{quantity}");
    }
}

/// Every planner keeps them; those that limit jerk keep the tables of jerk as well.
#[test]
fn every_planner_keeps_tables_and_vectors() {
    let arm = qb::arm();
    let (half_circle, spline) = (half_circle(&arm), way_points());
    let mut told = Kind::TorqueBySpeed.told(0.6);
    for kind in [Kind::AccelerationBySpeed, Kind::JerkBySpeed] {
        let more = kind.told(1.0).tables;
        for table in TableKind::ALL {
            for j in 0..6 {
                if let Some(found) = more.of(table, j) {
                    told.tables = told.tables.with(table, j, found.clone()).expect("a joint");
                }
            }
        }
    }
    told.tool = told.tool.with_acceleration(1.5).and_then(|tool| tool.with_jerk(30.0)).expect("above 0");
    for path in [&half_circle as &dyn MotionPath<6>, &spline] {
        for method in Method::ALL {
            let plan = told.planner(&arm).with_method(method).plan(path);
            let plan = plan.unwrap_or_else(|error| panic!("{method}: {error}"));
            assert!(plan.verification().holds(TOLERANCE), "{method}: {:?}", plan.verification().worst());
            for quantity in [Quantity::JointAcceleration, Quantity::JointTorque, Quantity::ToolAcceleration] {
                assert!(plan.verification().worst_of(quantity).is_some(), "{method}: {quantity} was not looked at");
            }
            let looked_at = plan.verification().worst_of(Quantity::ToolJerk).is_some();
            assert_eq!(looked_at, method.limits_jerk(), "{method}");
        }
    }
}

#[test]
fn a_table_of_torque_needs_the_dynamics() {
    let arm = qb::arm();
    let told = Told { torque: None, ..Kind::TorqueBySpeed.told(1.0) };
    let error = told.planner(&arm).plan(&way_points()).expect_err("no dynamics");
    assert!(matches!(error, PlanError::Limit(LimitError::Unsuited { .. })), "{error}");
    assert!(error.to_string().contains("Limits::with_torque"), "{error}");
}

/// Constant tables on limits that are the same as constants give the same motion.
#[test]
fn constant_tables_are_constant_limits() {
    let arm = qb::arm();
    let path = way_points();
    let told = Told { rates: [3.0, 4.0, 80.0], ..Told::loose() };
    let plain = told.planner(&arm).plan(&path).expect("it can be followed").duration();
    let kinds = [
        (TableKind::AccelerationBySpeed, 4.0),
        (TableKind::AccelerationByPosition, 4.0),
        (TableKind::JerkBySpeed, 80.0),
        (TableKind::JerkByPosition, 80.0),
    ];
    for (kind, limit) in kinds {
        let table = LimitTable::new(&[[0.3, limit]]).expect("a table");
        let tables = (0..6).fold(JointTables::new(), |all, j| all.with(kind, j, table.clone()).expect("a joint"));
        let by_table = Told { rates: [3.0, 4000.0, 80_000.0], tables, ..Told::loose() };
        let rates = match kind {
            TableKind::AccelerationBySpeed | TableKind::AccelerationByPosition => [3.0, 4000.0, 80.0],
            _ => [3.0, 4.0, 80_000.0],
        };
        let duration = Told { rates, ..by_table }.planner(&arm).plan(&path).expect("it can be followed").duration();
        assert!((duration / plain - 1.0).abs() < 2e-4, "{kind:?}: {duration} and {plain} s");
    }
}

fn random_table(random: &mut Random, from: f64, most: f64) -> LimitTable {
    let (mut x, mut points) = (from, Vec::new());
    for _ in 0..1 + random.below(4) {
        x += random.between(0.05, 0.8);
        points.push([x, most * random.between(0.3, 1.0)]);
    }
    LimitTable::new(&points).expect("a table")
}

#[test]
fn random_tables_are_kept_by_differences_of_positions() {
    let arm = qb::arm();
    let half_circle = half_circle(&arm);
    let seed = 20_261_129;
    let mut random = Random::new(seed);
    for case in 0..24 {
        let mut told = Told::loose();
        told.rates = [random.between(0.5, 3.0), random.between(2.0, 8.0), random.between(40.0, 200.0)];
        for j in 0..6 {
            for (kind, from, most) in [
                (TableKind::AccelerationBySpeed, 0.0, told.rates[1]),
                (TableKind::AccelerationByPosition, -2.0, told.rates[1]),
                (TableKind::JerkBySpeed, 0.0, told.rates[2]),
                (TableKind::JerkByPosition, -2.0, told.rates[2]),
            ] {
                if random.between(0.0, 1.0) < 0.5 {
                    told.tables = told.tables.with(kind, j, random_table(&mut random, from, most)).expect("a joint");
                }
            }
        }
        if case % 3 != 0 {
            told.tool = told.tool.with_acceleration(random.between(0.3, 2.0)).expect("above 0");
        }
        if case % 3 != 1 {
            told.tool = told.tool.with_jerk(random.between(5.0, 40.0)).expect("above 0");
        }
        let points: Vec<Joints<6>> = (0..3 + random.below(3))
            .map(|_| Joints::from([0.0, -1.1, 1.5, 0.0, 0.9, 0.0]) + Joints::from_fn(|_, _| random.between(-0.5, 0.5)))
            .collect();
        let spline = JointSpline::through(&points).expect("points");
        let path: &dyn MotionPath<6> = if case % 2 == 0 { &spline } else { &half_circle };
        let plan = told.planner(&arm).plan(path).unwrap_or_else(|error| panic!("seed {seed}, case {case}: {error}"));
        let most = by_differences(&arm, &told, &plan);
        // Rows that hold need no second round.
        let info = plan.info();
        assert!(info.fallback.is_none() && info.rounds <= 2, "seed {seed}, case {case}: {info:?}");
        assert!(most.iter().all(|ratio| *ratio <= 1.0 + TOLERANCE), "seed {seed}, case {case}: {most:?}");
        assert!(most.iter().any(|ratio| *ratio > 0.8), "seed {seed}, case {case}: nothing binds, {most:?}");
    }
}
