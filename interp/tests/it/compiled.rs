//! Compiled trajectories against the plans they were made from.

use std::sync::{Arc, OnceLock};

use arcfeed_feedrate::MotionLaw;
use arcfeed_interp::{
    CompileError, Interpolation, JointRates, JointSpline, JointTrajectory, JointTrajectoryError, Limits, Method,
    Planner, Quantity, ToolPath, Trajectory,
};
use arcfeed_kinematics::{ForwardKinematics, Joints, ParallelAxisArm};

use crate::common::{analytic, arm, knotted, limits, line_and_arc, plan, tool, tool_down};
use arcfeed_testing::Random;

fn shared_arm() -> &'static ParallelAxisArm {
    static ARM: OnceLock<ParallelAxisArm> = OnceLock::new();
    ARM.get_or_init(arm)
}

/// Plans of every kind: smooth, with jumps of the third derivative, of the curvature, and through way-points at the limits.
fn plans() -> &'static [(&'static str, Trajectory<'static>)] {
    static PLANS: OnceLock<Vec<(&'static str, Trajectory<'static>)>> = OnceLock::new();
    PLANS.get_or_init(|| {
        let arm = shared_arm();
        let points = [0.0, 0.5, -0.2, 0.3].map(|a| Joints::from([a, 0.5 * a, -a, a, 0.7 * a, 2.0 * a]));
        let spline = JointSpline::through(&points).expect("way-points");
        let through = Planner::new(arm, Limits::new(limits(arm))).plan_shared(std::sync::Arc::new(spline));
        vec![
            ("smooth", plan(arm, analytic()).expect("a plan")),
            ("knots", plan(arm, knotted()).expect("a plan")),
            ("curvature jumps", plan(arm, line_and_arc(0.1, 0.05)).expect("a plan")),
            ("way-points", through.expect("a plan")),
        ]
    })
}

fn rates(trajectory: &Trajectory<'_>, interpolation: Interpolation) -> JointRates<6> {
    let rates = JointRates::from(trajectory.limits().joints());
    match interpolation {
        Interpolation::Quintic => rates,
        Interpolation::Cubic => JointRates { jerk: Joints::repeat(f64::INFINITY), ..rates },
    }
}

#[test]
fn limits_are_kept_at_all_times_and_the_plan_within_the_bound() {
    for (name, trajectory) in plans() {
        for interpolation in [Interpolation::Quintic, Interpolation::Cubic] {
            for tolerance in [1e-4, 1e-6, 1e-7].into_iter().skip(usize::from(interpolation == Interpolation::Cubic)) {
                let case = format!("{name}, {interpolation:?}, {tolerance:e}");
                let compiled = trajectory.compile_with(tolerance, interpolation).expect(&case);
                let range = trajectory.limits().joints().range();
                let certificate = compiled.certify(range, &rates(trajectory, interpolation));
                assert!(certificate.holds(1e-6), "{case}: {certificate}");
                let deviation = compiled.deviation().expect("of a plan");
                assert!(deviation.measured <= deviation.bound && deviation.bound <= tolerance, "{case}: {deviation:?}");
                assert!(compiled.duration() == trajectory.duration(), "{case}");

                // Far more densely than the compiler looks.
                let mut planned = trajectory.setpoints(1e-3).expect("a period");
                let (mut cursor, mut most) = (compiled.cursor(), 0.0_f64);
                let steps = 8_000;
                for i in 0..=steps {
                    let t = trajectory.duration() * f64::from(i) / f64::from(steps);
                    let off = (cursor.at(t).q - planned.at(t).expect("on the path").q).amax();
                    most = most.max(off);
                }
                assert!(most <= deviation.bound, "{case}: {most:e} > {deviation:?}");
                assert!(most >= 0.5 * deviation.measured, "{case}: {most:e} << {deviation:?}");
            }
        }
    }
}

/// What the bound assumes of a plan: its acceleration changes by the jerk limit times the time between, and that of one more
/// sample of the verification.
#[test]
fn the_assumption_on_the_plan_holds_between_its_samples() {
    let peak = 1.25e-4;
    for (name, trajectory) in plans() {
        let jerk = trajectory.limits().joints().jerk();
        let jumps = trajectory.path().knots().iter().filter(|_| *name == "curvature jumps");
        let jumps: Vec<f64> =
            jumps.map(|s| trajectory.law().knots().find(|k| k.1.p >= *s).expect("on the law").0).collect();
        let mut planned = trajectory.setpoints(1e-3).expect("a period");
        let mut random = Random::new(3);
        for _ in 0..20_000 {
            let d = 10_f64.powf(random.between(-6.0, -3.0));
            let t = random.between(0.0, trajectory.duration() - d);
            if jumps.iter().any(|jump| t - 1e-9 <= *jump && *jump <= t + d + 1e-9) {
                continue;
            }
            let [a, b] = [t, t + d].map(|t| planned.at(t).expect("on the path").qdd);
            for k in 0..6 {
                let change = (b[k] - a[k]).abs();
                assert!(change <= jerk[k] * (d + peak), "{name}: {change} within {d} s at {t}, joint {}", k + 1);
            }
        }
    }
}

#[test]
fn cursor_and_random_access_agree() {
    let (_, trajectory) = &plans()[1];
    let compiled = trajectory.compile(1e-8).expect("compiles");
    let mut random = Random::new(4);
    let mut cursor = compiled.cursor();
    let duration = compiled.duration();
    let knots = compiled.times().iter().copied();
    let beside = compiled.times().iter().flat_map(|t| [t.next_down(), t.next_up()]);
    let strange = [-1.0, f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 2.0 * duration];
    let times: Vec<f64> =
        (0..5000).map(|_| random.between(0.0, duration)).chain(knots).chain(beside).chain(strange).collect();
    for t in times {
        let at = compiled.at(t);
        assert_eq!(cursor.at(t), at, "{t}");
        let piece = compiled.times().partition_point(|begin| *begin <= at.t).clamp(1, compiled.len()) - 1;
        let tau = at.t - compiled.times()[piece];
        let q = compiled.coefficients()[piece].iter().rev().fold(Joints::<6>::zeros(), |sum, c| sum * tau + c);
        assert!((at.q - q).amax() < 1e-14, "{t}");
        cursor.seek(t);
        assert_eq!(cursor.at(t), at, "{t}");
    }
    let setpoints: Vec<_> = compiled.setpoints(1e-3).expect("a period").collect();
    assert_eq!(setpoints.len(), compiled.setpoints(1e-3).expect("a period").samples());
    assert_eq!(setpoints[setpoints.len() - 1], compiled.at(duration));
    assert_eq!(setpoints[7], compiled.at(7.0 * 1e-3));
    assert!(compiled.setpoints(0.0).is_err() && compiled.setpoints(f64::NAN).is_err());
}

#[test]
fn reversed_runs_the_same_way_back() {
    for (name, trajectory) in plans() {
        let compiled = trajectory.compile(1e-6).expect("compiles");
        let back = compiled.reversed();
        let certificate =
            back.certify(trajectory.limits().joints().range(), &rates(trajectory, Interpolation::Quintic));
        assert!(certificate.holds(1.1e-6), "{name}: {certificate:?}");
        for i in 0..=1000 {
            let t = compiled.duration() * f64::from(i) / 1000.0;
            let (there, again) = (compiled.at(t), back.at(compiled.duration() - t));
            assert!((there.q - again.q).amax() < 1e-13, "{name} at {t}");
            assert!((there.qd + again.qd).amax() < 1e-10, "{name} at {t}");
            assert!((there.qdd - again.qdd).amax() < 1e-7, "{name} at {t}");
        }
    }
}

/// A piece of 1e300 s was accepted, and its motion ended at no number.
#[test]
fn a_piece_that_overflows_on_its_way_is_refused() {
    let rest = [Joints::zeros(); 6];
    let with = |power: usize, coefficient: f64| {
        let mut piece = rest;
        piece[power] = Joints::from([0.0, coefficient]);
        piece
    };
    let plan = |piece, seconds| {
        JointTrajectory::from_pieces(vec![0.0, 1.0, 1.0 + seconds], vec![rest, piece], Interpolation::Cubic)
    };
    let error = plan(with(3, 1.0), 1e103).expect_err("1e309 rad");
    let JointTrajectoryError::Overflow { piece: 1, joint: 1, quantity: Quantity::JointPosition, .. } = error else {
        panic!("{error}");
    };
    // Within a short time the jerk alone is too large.
    let error = plan(with(5, 8e306), 1.0).expect_err("4.8e308 rad/s^3");
    let JointTrajectoryError::Overflow { piece: 1, joint: 1, quantity: Quantity::JointJerk, .. } = error else {
        panic!("{error}");
    };
    let last = plan(with(3, 1.0), 1e102).expect("1e306 rad").at(f64::MAX);
    assert!(last.q[1] > 9e305 && [last.q, last.qd, last.qdd].iter().flatten().all(|v| v.is_finite()), "{last:?}");
}

#[test]
fn motions_join_at_rest_and_nowhere_else() {
    let (_, trajectory) = &plans()[0];
    let compiled = trajectory.compile(1e-6).expect("compiles");
    let both = compiled.clone().then(&compiled.reversed()).expect("at rest");
    assert_eq!(both.duration(), 2.0 * compiled.duration());
    assert_eq!(both.len(), 2 * compiled.len());
    assert_eq!(both.deviation().expect("of plans").bound, compiled.deviation().expect("of a plan").bound);
    let certificate = both.certify(trajectory.limits().joints().range(), &rates(trajectory, Interpolation::Quintic));
    assert!(certificate.holds(1e-6), "{certificate:?}");

    let error = compiled.clone().then(&compiled).expect_err("starts elsewhere");
    assert!(matches!(error, JointTrajectoryError::Elsewhere { .. }), "{error}");
    let moving = |c0: f64, c1: f64, c2: f64| {
        let piece = [c0, c1, c2, 0.0, 0.0, 0.0].map(|c| Joints::from([c]));
        JointTrajectory::from_pieces(vec![0.0, 1.0], vec![piece], Interpolation::Quintic).expect("one piece")
    };
    let error = moving(0.0, 0.0, 0.0).then(&moving(0.0, 0.5, 0.0)).expect_err("moves");
    let named = "the next motion: joint 1 has the joint velocity 5.000e-1";
    assert!(error.to_string().starts_with(named), "{error}");
    let error = moving(0.0, 0.0, 1.0).then(&moving(1.0, 0.0, 0.0)).expect_err("moves");
    assert!(
        matches!(error, JointTrajectoryError::NotAtRest { quantity: Quantity::JointVelocity, value: 2.0, .. }),
        "{error}"
    );
    let error = moving(0.0, 0.0, 0.0).then(&moving(0.0, 0.0, 1.0)).expect_err("is accelerated");
    assert!(matches!(error, JointTrajectoryError::NotAtRest { quantity: Quantity::JointAcceleration, .. }), "{error}");
    let near = moving(0.0, 0.0, 0.0).then(&moving(5e-10, 0.0, 0.0)).expect("near enough");
    assert_eq!(near.at(1.5).q[0], 0.0);
    assert!(moving(0.0, 0.0, 0.0).then(&moving(2e-9, 0.0, 0.0)).is_err());
}

#[test]
fn a_step_of_acceleration_is_spread_over_one_period() {
    let (_, trajectory) = &plans()[2];
    let compiled = trajectory.compile(1e-6).expect("compiles");
    let knot = trajectory.path().knots()[0];
    let t = trajectory.law().knots().find(|k| (k.1.p - knot).abs() < 1e-12).expect("a knot of the law").0;
    let half = 0.5 * trajectory.period();
    let piece = compiled.times().iter().position(|time| (time - (t - half)).abs() < 1e-12).expect("a piece begins");
    assert!((compiled.times()[piece + 1] - (t + half)).abs() < 1e-12, "and ends one period later");
    let c = &compiled.coefficients()[piece];
    assert!(c[3].amax() > 0.0 && c[4].amax() == 0.0 && c[5].amax() == 0.0, "its jerk is constant");
    assert!(trajectory.law().at(t).v > 0.0);
}

#[test]
fn what_cannot_be_compiled_is_named() {
    let (_, trajectory) = &plans()[2];
    for tolerance in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(trajectory.compile(tolerance), Err(CompileError::Tolerance(_))), "{tolerance}");
    }
    // The step alone moves a joint by more.
    let error = trajectory.compile(1e-10).expect_err("too fine");
    let CompileError::Deviation { bound, tolerance, .. } = error else { panic!("{error}") };
    assert!(bound > tolerance && tolerance == 1e-10, "{error}");
    for tolerance in [1e-15, 1e-300] {
        assert!(plans()[0].1.compile(tolerance).is_err(), "{tolerance:e}");
    }
    let arm = shared_arm();
    let spline = JointSpline::through(&[Joints::repeat(0.0), Joints::repeat(0.4)]).expect("way-points");
    let planner = Planner::new(arm, Limits::new(limits(arm))).with_method(Method::Reachability);
    let without_jerk = planner.plan(&spline).expect("a plan");
    assert_eq!(without_jerk.compile(1e-6), Err(CompileError::AccelerationSteps));
    let cubic = without_jerk.compile_with(1e-5, Interpolation::Cubic).expect("cubic pieces");
    assert!(cubic.certify(limits(arm).range(), &rates(&without_jerk, Interpolation::Cubic)).holds(1e-6));
}

#[cfg(feature = "json")]
#[test]
fn json_gives_the_same_motion_back_and_refuses_what_is_none() {
    let names: [String; 6] = std::array::from_fn(|k| format!("joint {k}"));
    for (name, trajectory) in plans() {
        for interpolation in [Interpolation::Quintic, Interpolation::Cubic] {
            let compiled = trajectory.compile_with(1e-6, interpolation).expect("compiles");
            let text = compiled.to_json(&names);
            let (again, read) = JointTrajectory::<6>::from_json(&text).expect(name);
            assert_eq!((&again, &read), (&compiled, &names), "{name}");
        }
    }
    let text = plans()[0].1.compile(1e-4).expect("compiles").to_json(&names);
    let first = text
        .split("\"coefficients_rad_per_s_k\":[[[")
        .nth(1)
        .and_then(|rest| rest.split(',').next())
        .expect("a number");
    for (from, to, says) in [
        ("joint-trajectory/1", "joint-trajectory/2", "format"),
        ("\"times_s\":[0.0", "\"times_s\":[0.5", "time 0"),
        ("\"times_s\":[0.0,", "\"times_s\":[0.0,0.0,", "times"),
        ("quintic", "quartic", "quartic"),
        ("\"joint 0\",", "", "5 joint names"),
        ("\"format\"", "\"form\"", "form"),
        ("deviation_measured_rad\":", "deviation_measured_rad\":1", "deviations"),
        (first, "1e999", "number out of range"),
        (first, "3.0", "jumps"),
    ] {
        let spoilt = text.replacen(from, to, 1);
        assert_ne!(spoilt, text, "{from}");
        let error = JointTrajectory::<6>::from_json(&spoilt).expect_err(from).to_string();
        assert!(error.contains(says), "{from} -> {to}: {error}");
    }
    for cut in (0..text.len()).step_by(97) {
        assert!(JointTrajectory::<6>::from_json(&text[..cut]).is_err());
    }
}

#[test]
fn the_tool_keeps_its_bounds_between_samples() {
    let arm = shared_arm();
    for (name, trajectory) in plans() {
        let compiled = trajectory.compile(1e-6).expect("compiles");
        let tool = compiled.certify_tool(arm);
        let [off, turned] = tool.deviation().expect("of a plan");
        let mut planned = trajectory.setpoints(1e-3).expect("a period");
        let mut most = [0.0_f64; 4];
        let steps = 40_000;
        for i in 0..=steps {
            let at = compiled.at(compiled.duration() * f64::from(i) / f64::from(steps));
            let (pose, jacobian) = arm.forward_jacobian(&at.q);
            let twist = jacobian * at.qd;
            let change = jacobian * at.qdd + arm.jacobian_dot_qd(&at.q, &at.qd);
            let (v, a) = (twist.fixed_rows::<3>(0).into_owned(), change.fixed_rows::<3>(0).into_owned());
            let along = a.dot(&v) / v.norm();
            let across = v.cross(&a).norm() / v.norm();
            for (most, size) in most.iter_mut().zip([v.norm(), twist.fixed_rows::<3>(3).norm(), along.abs(), across]) {
                *most = most.max(size);
            }
            if i % 16 == 0 {
                let plan = planned.at(at.t).expect("on the path").pose;
                let distance = (plan.translation.vector - pose.translation.vector).norm();
                assert!(distance <= off + 1e-12, "{name} at {}: {distance:e} > {off:e}", at.t);
                let angle = plan.rotation.angle_to(&pose.rotation);
                assert!(angle <= turned + 1e-7, "{name} at {}: {angle:e} > {turned:e}", at.t);
            }
        }
        for (bound, most) in tool.bounds().iter().zip(most) {
            assert!(most <= bound.bound, "{name}: {most} > {bound:?}");
            assert!(bound.attained <= bound.bound, "{name}: {bound:?}");
            if bound.quantity == Quantity::Feed || bound.quantity == Quantity::AngularSpeed {
                assert!(bound.bound <= bound.attained * (1.0 + 1.1e-3) + 1e-3, "{name}: {bound:?}");
            }
        }
    }
}

/// Pieces that follow the plan within the tolerance accelerate the tool a little differently. The planner leaves room for that: by the
/// poses of the compiled joints alone, the tool keeps limits that pieces of an ordinary plan exceed.
#[test]
fn the_tool_of_a_compiled_plan_keeps_its_limits() {
    let arm = shared_arm();
    let path = || Arc::new(ToolPath::new(arm, tool_down(knotted()), arm.range()).expect("in reach"));
    let planner = Planner::new(arm, Limits::new(limits(arm)).with_tool(tool())).with_chord_tolerance(1e-5);
    let planner = planner.and_then(|planner| planner.with_period(2e-3)).expect("valid");
    let most = tool().tangential_acceleration().expect("limited");
    let steepest = |motion: &JointTrajectory<6>| {
        const STEP: f64 = 1e-4;
        let place = |t: f64| arm.forward(&motion.at(t).q).translation.vector;
        let speed = |t: f64| (place(t + 0.5 * STEP) - place(t - 0.5 * STEP)).norm() / STEP;
        let times = (20..(motion.duration() / STEP) as usize - 20).map(|i| i as f64 * STEP);
        times.map(|t| (speed(t + 0.5 * STEP) - speed(t - 0.5 * STEP)).abs() / STEP).fold(0.0, f64::max)
    };
    let ordinary = planner.plan_shared(path()).expect("in reach").compile(1e-5).expect("compiles");
    assert!(steepest(&ordinary) > 1.001 * most, "nothing to mend: {}", steepest(&ordinary) / most);
    let plan = planner.plan_compiled(path(), 1e-5).expect("compiles");
    assert!(steepest(&plan.compiled) < most * (1.0 + 1e-5), "{}", steepest(&plan.compiled) / most);
    assert!(plan.compiled.certify(arm.range(), &(&limits(arm)).into()).holds(1e-6));
    let bound = plan.certificate.tool().of(Quantity::TangentialAcceleration).expect("is bounded");
    assert!(bound.bound <= most * (1.0 + 1e-6) && bound.bound > 0.99 * most, "{bound:?}");
    assert!(plan.trajectory.duration() < 1.02 * ordinary.duration());
}
