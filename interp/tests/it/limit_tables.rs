//! Limits that depend on the state of a joint, and limits on the vectors of the tool: planned, checked, and checked by differences.

use crate::common::{line_and_arc, tool_down};
use crate::qb;

use arcfeed_geometry::{ArcLengthCurve, NurbsCurve, OrientationPath, PosePath};
use arcfeed_interp::{
    JointSpline, JointTables, LimitError, LimitTable, Limits, MotionPath, PlanError, Planner, PoseMove, Quantity,
    RowsNeeded, TableKind, ToolLimits, ToolPath, Trajectory, Verification,
};
use arcfeed_kinematics::{Arm, ForwardKinematics, Joints};
use arcfeed_testing::Random;
use nalgebra::{Isometry3, UnitQuaternion, Vector3};

const TOLERANCE: f64 = 1e-6;
/// How much higher than the true one a mutated limit is.
const RAISED: f64 = 1.01;

/// What a planner is told.
#[derive(Debug, Clone)]
struct Told {
    rates: [f64; 3],
    torque: Option<f64>,
    tool: ToolLimits,
    tables: JointTables<6>,
}

impl Told {
    fn loose() -> Self {
        let tool = ToolLimits::new().with_feed(1.0).expect("above 0");
        Self { rates: [3.0, 60.0, 2000.0], torque: None, tool, tables: JointTables::new() }
    }

    fn planner<'a>(&'a self, arm: &'a Arm<6>) -> Planner<'a> {
        let [v, a, j] = self.rates.map(Joints::repeat);
        let mut limits = Limits::new(arm.range().with_rates(v, a, j).expect("valid limits"));
        if let Some(part) = self.torque {
            let torque = Joints::from([150.0, 150.0, 80.0, 30.0, 25.0, 20.0]) * part;
            limits = limits.with_torque(arm.dynamics().expect("known"), torque).expect("above 0");
        }
        Planner::new(arm, limits.with_tool(self.tool).with_tables(&self.tables)).with_chord_tolerance(1e-3).expect("valid")
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    AccelerationBySpeed,
    AccelerationByPosition,
    JerkBySpeed,
    JerkByPosition,
    TorqueBySpeed,
    ToolAcceleration,
    ToolJerk,
}

impl Kind {
    const ALL: [Self; 7] = [
        Self::AccelerationBySpeed,
        Self::AccelerationByPosition,
        Self::JerkBySpeed,
        Self::JerkByPosition,
        Self::TorqueBySpeed,
        Self::ToolAcceleration,
        Self::ToolJerk,
    ];

    fn quantity(self) -> Quantity {
        match self {
            Self::AccelerationBySpeed | Self::AccelerationByPosition => Quantity::JointAcceleration,
            Self::JerkBySpeed | Self::JerkByPosition => Quantity::JointJerk,
            Self::TorqueBySpeed => Quantity::JointTorque,
            Self::ToolAcceleration => Quantity::ToolAcceleration,
            Self::ToolJerk => Quantity::ToolJerk,
        }
    }

    /// Limits among which this one binds, it being `factor` times as high; without it for an infinite factor.
    fn told(self, factor: f64) -> Told {
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

/// A half circle of the tool, pointing down.
fn half_circle(arm: &Arm<6>) -> ToolPath<'_> {
    let frame = Isometry3::translation(0.36, 0.0, 0.25);
    let arc = NurbsCurve::<3>::arc(&frame, 0.1, -0.5 * std::f64::consts::PI, std::f64::consts::PI);
    let curve = ArcLengthCurve::new(arc.expect("an arc"), 1e-15).expect("of some length");
    let down = UnitQuaternion::from_euler_angles(std::f64::consts::PI, 0.0, 0.0);
    ToolPath::new(arm, PosePath::new(curve, OrientationPath::Constant(down)), arm.range()).expect("in reach")
}

fn way_points() -> JointSpline<6> {
    let centre = Joints::from([0.0, -1.1, 1.5, 0.0, 0.9, 0.0]);
    let offsets = [
        [-0.4, 0.2, -0.1, 0.3, 0.2, -0.5],
        [0.1, -0.2, 0.2, -0.2, -0.3, 0.2],
        [0.4, 0.1, -0.3, 0.4, 0.1, 0.5],
        [0.0, 0.3, 0.1, -0.1, 0.4, -0.2],
    ];
    JointSpline::through(&offsets.map(|offset| centre + Joints::from(offset))).expect("four points")
}

/// Refused for `quantity`, and for nothing but what follows from it.
fn named(row: &str, verification: &Verification, quantity: Quantity, least: f64) {
    let check = verification.worst_of(quantity).expect("looked at");
    assert!(check.ratio > least, "{row}: {check:?} is not what was broken");
    for broken in verification.checks().iter().filter(|check| !(check.ratio <= 1.0 + TOLERANCE)) {
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
    let tool_path = half_circle(&arm);
    let pose_move = PoseMove::starting_near(&arm, qb::to(), &Joints::from(qb::TO_NEAR)).expect("in reach");
    let spline = way_points();
    let paths: [(&str, &dyn MotionPath<6>); 3] =
        [("tool path", &tool_path), ("pose move", &pose_move), ("joint spline", &spline)];
    for (name, path) in paths {
        for kind in Kind::ALL {
            mutated(&format!("{kind:?} on a {name}"), &arm, path, kind);
        }
    }
}
