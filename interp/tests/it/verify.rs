//! `verify` has to say no: good trajectories, each spoilt in one way.

use crate::common;

use std::sync::Arc;

use arcfeed_geometry::{NurbsCurve, OrientationPath, PosePath};
use arcfeed_interp::{
    LimitError, Limits, PlanError, Planner, Quantity, Requirement, Setpoint, Setpoints, ToolPath, Trajectory,
    Verification, verify,
};
use arcfeed_kinematics::{InverseKinematics, JointLimits, Joints, ParallelAxisArm};
use common::{arm, by_length, down, knotted, limits, line_and_arc, tool, tool_down};
use nalgebra::{Isometry3, UnitQuaternion, Vector3, vector};

const TOLERANCE: f64 = 1e-6;

/// A good plan and what it was planned for.
struct Good<'a> {
    arm: &'a ParallelAxisArm,
    plan: Trajectory<'a>,
    limits: Limits<'a>,
}

impl<'a> Good<'a> {
    fn new(arm: &'a ParallelAxisArm, curve: NurbsCurve<3>) -> Self {
        let limits = Limits::new(limits(arm)).with_tool(tool());
        let path = ToolPath::new(arm, tool_down(curve), arm.range()).expect("in reach");
        // A long control period keeps the many verifications of these tests short.
        let planner = Planner::new(arm, limits).with_period(6e-3).and_then(|p| p.with_chord_tolerance(1e-5));
        let plan = planner.expect("valid").plan_shared(Arc::new(path)).expect("in reach");
        Self { arm, plan, limits }
    }

    fn requirement(&self) -> Requirement<'_> {
        Requirement {
            arm: self.arm,
            path: self.plan.path(),
            limits: &self.limits,
            jerk_limited: true,
            chord_tolerance: self.plan.chord_tolerance(),
            path_tolerance: self.plan.chord_tolerance(),
            period: self.plan.period(),
            sections: &[],
            end_speeds: [0.0; 2],
        }
    }

    fn with_joints(&mut self, joints: JointLimits<6>) {
        self.limits = Limits::new(joints).with_tool(tool());
    }

    /// Verification of the motion after `spoil`; `duration` of it.
    fn verify_for(
        &self,
        duration: f64,
        mut spoil: impl FnMut(&mut Setpoints<'_, 'a>, f64, Setpoint) -> Setpoint,
    ) -> Verification {
        let mut sampler = self.plan.setpoints(self.plan.period()).expect("a valid period");
        verify(&self.requirement(), duration, &[], |t| {
            let at = sampler.at(t)?;
            Ok(spoil(&mut sampler, t, at))
        })
        .expect("on the path")
    }

    fn verify(&self, mut spoil: impl FnMut(f64, Setpoint) -> Setpoint) -> Verification {
        self.verify_for(self.plan.duration(), |_, t, at| spoil(t, at))
    }
}

/// The worst place for one quantity.
fn worst_of(verification: &Verification, quantity: Quantity) -> arcfeed_interp::Check {
    verification.worst_of(quantity).expect("looked at")
}

fn refused(what: &str, verification: &Verification) {
    assert!(!verification.holds(TOLERANCE), "{what} was let through: {:?}", verification.worst());
}

/// Refused, and for this reason.
fn refused_for(what: &str, verification: &Verification, quantity: Quantity) {
    refused(what, verification);
    let check = worst_of(verification, quantity);
    assert!(check.quantity() == quantity && check.ratio > 1.0 + TOLERANCE, "{what}: {check:?}");
}

#[test]
fn the_unspoilt_motion_holds() {
    let arm = arm();
    for curve in [knotted(), line_and_arc(0.1, 0.05)] {
        let good = Good::new(&arm, curve);
        let same = good.verify(|_, at| at);
        assert!(same.holds(TOLERANCE), "{:?}", same.worst());
        // With a look at every knot of the law and just before it, it is the one that the plan has passed.
        let (law, period, duration) = (good.plan.law(), good.plan.period(), good.plan.duration());
        let before = |t: f64| t - (1e-10 * period).max(4.0 * f64::EPSILON * t);
        let knots: Vec<f64> = law.knots().skip(1).flat_map(|(t, _)| [before(t), t]).collect();
        let mut setpoints = good.plan.setpoints(period).expect("a valid period");
        let whole = verify(&good.requirement(), duration, &knots, |t| setpoints.at(t)).expect("on the path");
        assert_eq!(&whole, good.plan.verification());
        let looked_at = knots.iter().filter(|t| **t > 0.0 && **t < duration).count();
        assert_eq!(whole.samples(), same.samples() + looked_at);
        // Eight per period, and at least one every eighth of a millisecond.
        let dense = good.plan.duration() / (good.plan.period() / 8.0).min(1.25e-4);
        assert!(same.samples() as f64 > dense && (same.samples() as f64) < dense + 3.0);
    }
}

#[test]
fn a_jump_of_a_micro_radian_is_seen() {
    let arm = arm();
    for curve in [knotted(), line_and_arc(0.1, 0.05)] {
        let good = Good::new(&arm, curve);
        let duration = good.plan.duration();
        for joint in 0..6 {
            for when in if joint == 0 { vec![0.03, 0.77, 0.999] } else { vec![0.5] } {
                let jumped = good.verify(|t, mut at| {
                    at.q[joint] += if t > when * duration { 1e-6 } else { 0.0 };
                    at
                });
                refused_for(&format!("a jump of joint {} at {when}", joint + 1), &jumped, Quantity::Continuity);
                let check = worst_of(&jumped, Quantity::Continuity);
                assert!(
                    (check.t - when * duration).abs() < good.plan.period(),
                    "{check:?}, jumped at {}",
                    when * duration
                );
            }
        }
        // For one control cycle only.
        let spike = good.verify(|t, mut at| {
            at.q[2] -= if (t - 0.4 * duration).abs() < 0.5 * good.plan.period() { 1e-6 } else { 0.0 };
            at
        });
        refused_for("a spike", &spike, Quantity::Continuity);
    }
}

#[test]
fn speeds_just_above_the_limit_are_seen() {
    let arm = arm();
    // The straight line is run at the feed itself.
    let line = NurbsCurve::line(vector![0.35, -0.15, 0.20], vector![0.45, 0.15, 0.30]).expect("a line");
    let good = Good::new(&arm, line);
    assert!(worst_of(&good.verify(|_, at| at), Quantity::Feed).ratio > 0.9999);
    let faster = good.verify_for(good.plan.duration() / 1.001, |sampler, t, _| {
        // The whole motion, consistently, in less time.
        let mut at = sampler.at(1.001 * t).expect("on the path");
        (at.t, at.qd, at.qdd, at.jerk) = (t, at.qd * 1.001, at.qdd * 1.001f64.powi(2), at.jerk * 1.001f64.powi(3));
        at
    });
    refused_for("feed of 100.1 %", &faster, Quantity::Feed);

    // Each joint with its limits at exactly what the motion takes: all of it holds, a thousandth more does not.
    let mut good = Good::new(&arm, knotted());
    let open = good.verify(|_, at| at);
    let peak = |quantity| {
        Joints::from_fn(|k, _| {
            open.checks()
                .iter()
                .find(|c| c.quantity() == quantity && c.joint() == Some(k))
                .expect("checked")
                .value
                .abs()
                .max(1e-3)
        })
    };
    let (velocity, acceleration, jerk) =
        (peak(Quantity::JointVelocity), peak(Quantity::JointAcceleration), peak(Quantity::JointJerk));
    good.with_joints(arm.range().with_rates(velocity, acceleration, jerk).expect("above 0"));
    let tight = good.verify(|_, at| at);
    assert!(
        worst_of(&tight, Quantity::JointVelocity).ratio <= 1.0
            && worst_of(&tight, Quantity::JointVelocity).ratio > 0.99999
    );
    for k in 0..6 {
        if velocity[k] <= 1e-3 {
            continue;
        }
        for (quantity, power) in
            [(Quantity::JointVelocity, 1), (Quantity::JointAcceleration, 2), (Quantity::JointJerk, 3)]
        {
            let spoilt = good.verify(|_, mut at| {
                match power {
                    1 => at.qd[k] *= 1.001,
                    2 => at.qdd[k] *= 1.001,
                    _ => {
                        at.qdd[k] *= 1.001;
                        at.jerk[k] *= 1.001;
                    }
                }
                at
            });
            refused(&format!("{} of joint {} at 100.1 %", quantity.name(), k + 1), &spoilt);
            let check =
                spoilt.checks().iter().find(|c| c.quantity() == quantity && c.joint() == Some(k)).expect("checked");
            assert!((check.ratio - 1.001).abs() < 1e-6, "{check:?}");
        }
    }
}

#[test]
fn velocities_and_accelerations_that_are_not_the_derivatives_are_seen() {
    let arm = arm();
    let good = Good::new(&arm, knotted());
    type Lie = fn(&mut Setpoint);
    let lies: [(&str, Lie); 7] = [
        ("velocity of 99.9 %", |at| at.qd *= 0.999),
        ("velocity reversed", |at| at.qd = -at.qd),
        ("velocity of another joint", |at| at.qd.swap_rows(0, 2)),
        ("no acceleration", |at| at.qdd *= 0.0),
        ("half the acceleration", |at| at.qdd *= 0.5),
        ("acceleration reversed", |at| at.qdd = -at.qdd),
        ("acceleration of another joint", |at| at.qdd.swap_rows(0, 2)),
    ];
    for (what, lie) in lies {
        let spoilt = good.verify(|_, mut at| {
            lie(&mut at);
            at
        });
        refused_for(what, &spoilt, Quantity::Continuity);
    }
}

/// The inverse with the whole path moved by a constant transform on the tool's or on the base's side.
fn displaced(good: &Good<'_>, place: impl Fn(&Isometry3<f64>) -> Isometry3<f64>) -> Verification {
    good.verify(|_, mut at| {
        at.pose = place(&at.pose);
        at.q = good.arm.inverse(&at.pose, &at.q).expect("in reach");
        at
    })
}

#[test]
fn a_tool_beside_the_path_is_seen() {
    let arm = arm();
    let good = Good::new(&arm, knotted());
    let tolerance = good.plan.chord_tolerance();
    for direction in [Vector3::x(), Vector3::y(), Vector3::z()] {
        let beside = displaced(&good, |pose| nalgebra::Translation3::from(direction * (1.2 * tolerance)) * pose);
        refused_for("a tool beside the path", &beside, Quantity::PathDeviation);
        let check = worst_of(&beside, Quantity::PathDeviation);
        assert!((check.value - 1.2 * tolerance).abs() < 1e-9, "{check:?}");
    }
    // With a tolerance of 1 um, 2 um are too much.
    let path = ToolPath::new(&arm, tool_down(knotted()), arm.range()).expect("in reach");
    let limits = Limits::new(limits(&arm)).with_tool(tool());
    let plan = Planner::new(&arm, limits).plan(&path).expect("in reach");
    assert_eq!(plan.chord_tolerance(), 1e-6);
    let fine = Good { arm: &arm, plan, limits };
    let beside = displaced(&fine, |pose| nalgebra::Translation3::new(0.0, 0.0, 2e-6) * pose);
    refused_for("a tool 2 um above the path", &beside, Quantity::PathDeviation);
}

#[test]
fn a_tilted_tool_is_seen() {
    let arm = arm();
    let good = Good::new(&arm, knotted());
    for axis in [Vector3::x(), Vector3::y(), Vector3::z()] {
        let tilt = UnitQuaternion::from_scaled_axis(axis * 0.01);
        let tilted = displaced(&good, |pose| Isometry3::from_parts(pose.translation, pose.rotation * tilt));
        refused(&format!("a tool turned by 0.01 rad about {axis}"), &tilted);
    }
}

#[test]
fn a_pose_that_the_joints_do_not_reach_is_seen() {
    let arm = arm();
    let good = Good::new(&arm, knotted());
    let moved = good.verify(|_, mut at| {
        at.pose.translation.vector.x += 1e-3;
        at
    });
    refused("a commanded pose 1 mm from where the joints put the tool", &moved);
}

#[test]
fn a_motion_that_does_not_run_from_rest_to_rest_over_the_whole_path_is_seen() {
    let arm = arm();
    let good = Good::new(&arm, knotted());
    let duration = good.plan.duration();
    let stopped_dead = good.verify_for(0.6 * duration, |_, _, at| at);
    refused("a motion that ends at speed", &stopped_dead);
    let flying_start = good.verify_for(0.6 * duration, |sampler, t, _| {
        let mut at = sampler.at(t + 0.4 * duration).expect("on the path");
        at.t = t;
        at
    });
    refused("a motion that starts at speed", &flying_start);
    // Standing at the start all the time keeps every limit, but follows no path.
    let lazy = good.verify_for(0.1, |sampler, t, _| {
        let mut at = sampler.at(0.0).expect("on the path");
        at.t = t;
        at
    });
    refused("a motion that stays at the start", &lazy);
}

#[test]
fn the_last_moment_without_a_stop_is_seen() {
    let arm = arm();
    let good = Good::new(&arm, knotted());
    // All is well until the last setpoint, which still moves.
    let spoilt = good.verify(|t, mut at| {
        if t == good.plan.duration() {
            at.qd[0] += 0.01;
        }
        at
    });
    refused_for("a last setpoint that moves", &spoilt, Quantity::Continuity);
}

#[test]
fn not_a_number_is_never_let_through() {
    let arm = arm();
    let good = Good::new(&arm, knotted());
    let when = 0.5 * good.plan.duration();
    type Slot = fn(&mut Setpoint) -> &mut f64;
    let slots: [(&str, Slot); 9] = [
        ("q", |at| &mut at.q[3]),
        ("qd", |at| &mut at.qd[3]),
        ("qdd", |at| &mut at.qdd[3]),
        ("jerk", |at| &mut at.jerk[3]),
        ("s", |at| &mut at.s),
        ("t", |at| &mut at.t),
        ("feed", |at| &mut at.feed),
        ("acceleration", |at| &mut at.acceleration),
        ("pose", |at| &mut at.pose.translation.vector.z),
    ];
    for (what, slot) in slots {
        for bad in [f64::NAN, f64::INFINITY] {
            for once in [true, false] {
                let mut seen = false;
                let spoilt = good.verify(|t, mut at| {
                    if t >= when && !(once && seen) {
                        *slot(&mut at) = bad;
                        seen = true;
                    }
                    at
                });
                refused(&format!("{what} = {bad}, {}", if once { "once" } else { "from then on" }), &spoilt);
            }
        }
    }
}

#[test]
fn a_joint_outside_its_range_is_seen() {
    let arm = arm();
    let mut good = Good::new(&arm, knotted());
    let open = good.verify(|_, at| at);
    let joints = limits(&arm);
    let (mut lower, mut upper) = (*joints.lower(), *joints.upper());
    let sampler = good.plan.setpoints(1e-2).expect("a valid period");
    let most = sampler.map(|p| p.expect("on the path").q[0]).fold(f64::MIN, f64::max);
    assert!(open.holds(TOLERANCE));
    (lower[0], upper[0]) = (most - 1.0, most - 1e-3);
    let range = arcfeed_kinematics::JointRange::new(lower, upper).expect("lower below upper");
    good.with_joints(range.with_rates(*joints.velocity(), *joints.acceleration(), *joints.jerk()).expect("valid"));
    let out = good.verify(|_, at| at);
    refused_for("joint 1 outside its range", &out, Quantity::JointPosition);
    assert_eq!(worst_of(&out, Quantity::JointPosition).joint(), Some(0));
}

#[test]
fn tool_limits_are_held_against_what_the_tool_does() {
    let arm = arm();
    // Each limit set a little below what the motion takes.
    let good = Good::new(&arm, knotted());
    let open = good.verify(|_, at| at);
    for quantity in [
        Quantity::Feed,
        Quantity::TangentialAcceleration,
        Quantity::TangentialJerk,
        Quantity::NormalAcceleration,
        Quantity::ChordError,
    ] {
        let value = worst_of(&open, quantity).value.abs() * 0.999;
        let (mut limited, mut requirement) = (tool(), good.requirement());
        match quantity {
            Quantity::Feed => limited = limited.with_feed(value).expect("valid"),
            Quantity::TangentialAcceleration => {
                limited = limited.with_tangential_acceleration(value).expect("valid");
            }
            Quantity::TangentialJerk => limited = limited.with_tangential_jerk(value).expect("valid"),
            Quantity::NormalAcceleration => limited = limited.with_normal_acceleration(value).expect("valid"),
            _ => requirement.chord_tolerance = value,
        }
        let limits = good.limits.with_tool(limited);
        requirement.limits = &limits;
        let mut sampler = good.plan.setpoints(good.plan.period()).expect("a valid period");
        let verification = verify(&requirement, good.plan.duration(), &[], |t| sampler.at(t)).expect("on the path");
        refused_for(quantity.name(), &verification, quantity);
        assert!((worst_of(&verification, quantity).ratio - 1.0 / 0.999).abs() < 1e-9);
    }
    // The jerk across the path at constant speed, kappa^2 v^3.
    let mut largest = 0.0f64;
    let curve = good.plan.path().tool_curve().expect("a curve").curve();
    for at in good.plan.setpoints(1e-3).expect("a valid period") {
        let at = at.expect("on the path");
        largest = largest.max(curve.jet(at.s).d2.norm_squared() * at.feed.powi(3));
    }
    let limited = good.limits.with_tool(tool().with_normal_jerk(0.5 * largest).expect("valid"));
    let verification = Planner::new(&arm, limited).verify(good.plan.problem(), good.plan.law(), true);
    let verification = verification.expect("on the path");
    refused_for("twice the normal jerk", &verification, Quantity::NormalJerk);
}

#[test]
fn a_setpoint_that_fails_stops_the_verification() {
    let arm = arm();
    let good = Good::new(&arm, knotted());
    let error = PlanError::Limit(LimitError::NotPositive { what: "anything", value: 1.0 });
    let result = verify(&good.requirement(), 1.0, &[], |_| Err(error.clone()));
    assert_eq!(result, Err(error));
}

#[test]
fn a_turning_tool_is_verified_too() {
    let arm = arm();
    let curve = by_length(knotted());
    let last = UnitQuaternion::from_scaled_axis(Vector3::new(0.2, 0.3, 0.8)) * down();
    let turning = OrientationPath::slerp(curve.length(), down(), last).expect("a length above 0");
    let plan = common::plan_path(&arm, PosePath::new(curve, turning), tool()).expect("in reach");
    let limits = Limits::new(limits(&arm)).with_tool(tool());
    let good = Good { arm: &arm, plan, limits };
    assert!(good.verify(|_, at| at).holds(TOLERANCE));
    // The tool keeps its first orientation instead.
    let stiff = displaced(&good, |pose| Isometry3::from_parts(pose.translation, down()));
    refused("a tool that does not turn", &stiff);
}
