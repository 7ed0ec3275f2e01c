//! The checker catches a planner that breaks a limit: every kind of limit on every kind of path, one row each.
//!
//! A mutation is a planner that is told a limit a little higher than the true one, where that limit binds. Its law, held against
//! the true limits, has to be refused by the name of that very limit, and the plan under the true limits has to hold.

use crate::common::bent::paths_of_every_kind;
use crate::qb;

use arcfeed_interp::{
    Extent, FeedSection, LimitError, Limits, MotionPath, PlanError, Planner, Quantity, Requirement, RowsNeeded,
    Setpoint, ToolLimits, Verification, verify,
};
use arcfeed_kinematics::{Arm, InverseKinematics, Joints};
use nalgebra::Translation3;

const TOLERANCE: f64 = 1e-6;
/// How much higher than the true one a mutated limit is; jerk, which a plan uses less evenly, is raised by more.
const RAISED: f64 = 1.02;
const RAISED_JERK: f64 = 1.05;
/// Rows of the table: eight kinds of limits on three kinds of paths.
const ROWS: usize = 24;

#[derive(Debug, Clone, Copy, PartialEq)]
enum Kind {
    Velocity,
    Acceleration,
    Jerk,
    Torque,
    Feed,
    Chord,
    Sections,
    Ends,
}

impl Kind {
    const ALL: [Self; 8] = [
        Self::Velocity,
        Self::Acceleration,
        Self::Jerk,
        Self::Torque,
        Self::Feed,
        Self::Chord,
        Self::Sections,
        Self::Ends,
    ];

    /// What the checker has to name.
    fn quantity(self) -> Quantity {
        match self {
            Self::Velocity => Quantity::JointVelocity,
            Self::Acceleration => Quantity::JointAcceleration,
            Self::Jerk => Quantity::JointJerk,
            Self::Torque => Quantity::JointTorque,
            Self::Feed | Self::Sections => Quantity::Feed,
            Self::Chord => Quantity::ChordError,
            Self::Ends => Quantity::Ends,
        }
    }

    /// True limits under which this one binds.
    fn truth(self) -> Setup {
        let loose = Setup {
            rates: [20.0, 200.0, 5000.0],
            torque: None,
            feed: 2.0,
            chord: 1e-6,
            period: 1e-3,
            section: None,
            ends: [0.0; 2],
        };
        match self {
            Self::Velocity => Setup { rates: [0.6, 200.0, 5000.0], ..loose },
            Self::Acceleration => Setup { rates: [20.0, 3.0, 5000.0], ..loose },
            Self::Jerk => Setup { rates: [20.0, 200.0, 60.0], ..loose },
            Self::Torque => Setup { torque: Some(1.0), ..loose },
            Self::Feed | Self::Ends => Setup { feed: 0.15, ..loose },
            // The longer the cycle, the longer its chord.
            Self::Chord => Setup { period: 8e-3, ..loose },
            Self::Sections => Setup { feed: 0.3, section: Some(0.1), ..loose },
        }
    }

    /// What the planner is told in place of them; for the ends both ends in turn.
    fn mutations(self) -> Vec<Setup> {
        let truth = self.truth();
        let raised = |value: Option<f64>| value.map(|value| RAISED * value);
        let [v, a, j] = truth.rates;
        match self {
            Self::Velocity => vec![Setup { rates: [RAISED * v, a, j], ..truth }],
            Self::Acceleration => vec![Setup { rates: [v, RAISED * a, j], ..truth }],
            Self::Jerk => vec![Setup { rates: [v, a, RAISED_JERK * j], ..truth }],
            Self::Torque => vec![Setup { torque: raised(truth.torque), ..truth }],
            Self::Feed => vec![Setup { feed: RAISED * truth.feed, ..truth }],
            Self::Chord => vec![Setup { chord: RAISED * truth.chord, ..truth }],
            Self::Sections => vec![Setup { section: raised(truth.section), ..truth }],
            Self::Ends => [[0.05, 0.0], [0.0, 0.05]].map(|ends| Setup { ends, ..truth }).to_vec(),
        }
    }
}

/// What a planner is told.
#[derive(Debug, Clone, Copy)]
struct Setup {
    /// Velocity, acceleration and jerk of every joint.
    rates: [f64; 3],
    /// Part of the drives' torque.
    torque: Option<f64>,
    feed: f64,
    chord: f64,
    period: f64,
    /// Feed between 0.1 and 0.2 of the path's parameter.
    section: Option<f64>,
    ends: [f64; 2],
}

impl Setup {
    fn limits(self, arm: &Arm<6>) -> Limits<'_> {
        let [v, a, j] = self.rates.map(Joints::repeat);
        let mut limits = Limits::new(arm.range().with_rates(v, a, j).expect("valid limits"));
        if let Some(part) = self.torque {
            let torque = Joints::from([150.0, 150.0, 80.0, 30.0, 25.0, 20.0]) * part;
            limits = limits.with_torque(arm.dynamics().expect("known"), torque).expect("above 0");
        }
        limits.with_tool(ToolLimits::new().with_feed(self.feed).expect("above 0"))
    }

    fn planner(self, arm: &Arm<6>) -> Planner<'_> {
        let planner = Planner::new(arm, self.limits(arm))
            .with_chord_tolerance(self.chord)
            .and_then(|planner| planner.with_period(self.period))
            .expect("valid")
            .with_end_speeds(self.ends[0], self.ends[1])
            .expect("valid");
        let section = |feed| FeedSection { extent: Extent::Length { from: 0.1, to: 0.2 }, feed };
        planner.with_sections(self.section.map(section).into_iter().collect())
    }

    fn requirement<'r>(self, arm: &'r Arm<6>, path: &'r dyn MotionPath<6>, limits: &'r Limits<'r>) -> Requirement<'r> {
        Requirement {
            arm,
            path,
            limits,
            jerk_limited: true,
            chord_tolerance: self.chord,
            path_tolerance: self.chord,
            period: self.period,
            sections: &[],
            end_speeds: self.ends,
        }
    }
}

/// Refused for `quantity`, and for nothing that does not follow from it.
fn named(row: &str, verification: &Verification, quantity: Quantity, least: f64) {
    assert!(!verification.holds(TOLERANCE), "{row} was let through");
    let check = verification.worst_of(quantity).expect("looked at");
    assert!(check.ratio > least, "{row}: {check:?} is not what was broken");
    for broken in verification.checks().iter().filter(|check| check.ratio > 1.0 + TOLERANCE || check.ratio.is_nan()) {
        let follows = match quantity {
            // What a joint may move from one sample to the next follows from its jerk.
            Quantity::JointJerk => broken.quantity() == Quantity::Continuity,
            // Beside the path the velocities are no longer those of the joints and of the tool.
            Quantity::PathDeviation => match broken.quantity() {
                Quantity::Continuity | Quantity::SetpointAgreement => true,
                // The same rates of displaced joints move the tool otherwise, by the displacement over its distance from the joints.
                Quantity::Feed => broken.ratio < 1.0 + 1e-5,
                _ => false,
            },
            _ => false,
        };
        assert!(broken.quantity() == quantity || follows, "{row}: {broken:?} is broken too");
    }
}

/// The motion under the true limits, each setpoint moved by `displace`, is off its path.
fn displaced(row: &str, arm: &Arm<6>, path: &dyn MotionPath<6>, displace: impl Fn(Setpoint) -> Setpoint) {
    let truth = Kind::Chord.truth();
    let limits = truth.limits(arm);
    let requirement = truth.requirement(arm, path, &limits);
    let plan = truth.planner(arm).plan(path).expect("it can be followed");
    let held = |displace: &dyn Fn(Setpoint) -> Setpoint| {
        let mut setpoints = plan.setpoints(truth.period).expect("a period");
        verify(&requirement, plan.duration(), &[], |t| setpoints.at(t).map(displace)).expect("on the path")
    };
    let same = held(&|at| at);
    assert!(same.holds(TOLERANCE), "{row}: {:?}", same.worst());
    named(row, &held(&displace), Quantity::PathDeviation, 1.0 + TOLERANCE);
}

/// A planner with sections refuses a path without a curve of the tool.
fn unsuited(row: &str, arm: &Arm<6>, path: &dyn MotionPath<6>) {
    let truth = Kind::Sections.truth();
    let plain = Setup { section: None, ..truth };
    assert!(plain.planner(arm).plan(path).expect("it can be followed").verification().holds(TOLERANCE), "{row}");
    let error = truth.planner(arm).plan(path).expect_err("no curve of the tool");
    assert!(matches!(error, PlanError::Limit(LimitError::Unsuited { .. })), "{row}: {error}");
}

/// The plan under the true limits holds; the laws of the mutated planners do not, and the limit is named.
fn mutated(row: &str, arm: &Arm<6>, path: &dyn MotionPath<6>, kind: Kind) {
    let truth = kind.truth();
    let planner = truth.planner(arm);
    let plan = planner.plan(path).unwrap_or_else(|error| panic!("{row}: {error}"));
    assert!(plan.verification().holds(TOLERANCE), "{row}: {:?}", plan.verification().worst());
    let problem = planner.prepare(path, RowsNeeded::Jerk).expect("it was planned");
    // The raise itself, less what a plan leaves of a limit that binds.
    let least = match kind {
        Kind::Jerk => 1.0 + 0.8 * (RAISED_JERK - 1.0),
        Kind::Ends => 1.0 + TOLERANCE,
        _ => 1.0 + 0.8 * (RAISED - 1.0),
    };
    for told in kind.mutations() {
        let wrong = told.planner(arm).plan(path).unwrap_or_else(|error| panic!("{row}, {told:?}: {error}"));
        let verification = planner.verify(&problem, wrong.law(), true).expect("on the path");
        named(row, &verification, kind.quantity(), least);
        if kind == Kind::Sections {
            let check = verification.worst_of(Quantity::Feed).expect("looked at");
            assert_eq!(Some(check.limit), truth.section, "{row}: {check:?}");
        }
    }
}

#[test]
fn the_checker_names_what_a_mutated_planner_breaks() {
    let arm = qb::arm();
    let mut rows = 0;
    for (name, path) in &paths_of_every_kind(&arm) {
        let path = &**path;
        for kind in Kind::ALL {
            let row = format!("{kind:?} on a {name}");
            let prescribed = path.tool(0.0).is_some();
            match kind {
                Kind::Chord | Kind::Sections if path.tool_curve().is_some() => mutated(&row, &arm, path, kind),
                // No curve, no chord: what is left of it is the distance from the path.
                Kind::Chord if prescribed => displaced(&row, &arm, path, |mut at| {
                    at.pose = Translation3::new(1.2 * kind.truth().chord, 0.0, 0.0) * at.pose;
                    at.q = arm.inverse(&at.pose, &at.q).expect("in reach");
                    at
                }),
                Kind::Chord => displaced(&row, &arm, path, |mut at| {
                    at.q[2] += 2e-9;
                    at
                }),
                Kind::Sections => unsuited(&row, &arm, path),
                _ => mutated(&row, &arm, path, kind),
            }
            rows += 1;
        }
    }
    assert_eq!(rows, ROWS);
}
