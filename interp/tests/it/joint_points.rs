//! Points for controllers: what quintics between them make, against the compiled motion and the limits.

use std::sync::Arc;

use arcfeed_interp::{JointPoint, JointRates, JointSpline, JointTrajectory, Limits, Planner, Quantity, Trajectory};
use arcfeed_kinematics::{Joints, ParallelAxisArm};

use crate::common::{arm, knotted, limits, line_and_arc, plan};

/// Position, velocity, acceleration and jerk a time `tau` after point `a`, of the quintic to point `b`: by the six conditions at both
/// ends, in the time from 0 to 1.
fn between(a: &JointPoint, b: &JointPoint, tau: f64) -> [Joints<6>; 4] {
    let h = (b.nanoseconds - a.nanoseconds) as f64 * 1e-9;
    let u = tau / h;
    let [p0, v0, a0] = [a.q, a.qd * h, a.qdd * (h * h)];
    let [p1, v1, a1] = [b.q, b.qd * h, b.qdd * (h * h)];
    let d = p1 - p0 - v0 - a0 * 0.5;
    let (e, f) = (v1 - v0 - a0, a1 - a0);
    let c = [d * 10.0 - e * 4.0 + f * 0.5, d * -15.0 + e * 7.0 - f, d * 6.0 - e * 3.0 + f * 0.5];
    let q = p0 + v0 * u + a0 * (0.5 * u * u) + c[0] * u.powi(3) + c[1] * u.powi(4) + c[2] * u.powi(5);
    let qd = v0 + a0 * u + c[0] * (3.0 * u * u) + c[1] * (4.0 * u.powi(3)) + c[2] * (5.0 * u.powi(4));
    let qdd = a0 + c[0] * (6.0 * u) + c[1] * (12.0 * u * u) + c[2] * (20.0 * u.powi(3));
    let jerk = c[0] * 6.0 + c[1] * (24.0 * u) + c[2] * (60.0 * u * u);
    [q, qd / h, qdd / (h * h), jerk / (h * h * h)]
}

fn plans(arm: &ParallelAxisArm) -> Vec<(&'static str, Trajectory<'_>)> {
    let points = [0.0, 0.5, -0.2, 0.3].map(|a| Joints::from([a, 0.5 * a, -a, a, 0.7 * a, 2.0 * a]));
    let spline = JointSpline::through(&points).expect("way-points");
    let through = Planner::new(arm, Limits::new(limits(arm))).plan_shared(Arc::new(spline));
    vec![
        ("knots", plan(arm, knotted()).expect("a plan")),
        ("curvature jumps", plan(arm, line_and_arc(0.1, 0.05)).expect("a plan")),
        ("way-points", through.expect("a plan")),
    ]
}

#[test]
fn quintics_between_the_points_are_the_compiled_motion_and_keep_the_limits() {
    let arm = arm();
    for (name, trajectory) in plans(&arm) {
        let joints = trajectory.limits().joints();
        let rates = JointRates::from(joints);
        for tolerance in [1e-4, 1e-7] {
            let case = format!("{name}, {tolerance:e}");
            let compiled = trajectory.compile(tolerance).expect(&case);
            let points = compiled.points(joints.range(), &rates).expect(&case);
            let slow = points[points.len() - 1].nanoseconds as f64 * 1e-9 / compiled.duration();
            assert!((1.0 - 1e-9..1.0 + 1.1e-4).contains(&slow), "{case}: {slow}");
            let controller = JointTrajectory::through(&points).expect(&case);
            for pair in points.windows(2) {
                let [a, b] = [&pair[0], &pair[1]];
                assert!(a.nanoseconds < b.nanoseconds, "{case}");
                let (begin, h) = (a.nanoseconds as f64 * 1e-9, (b.nanoseconds - a.nanoseconds) as f64 * 1e-9);
                for i in 0..=20 {
                    let tau = h * f64::from(i) / 20.0;
                    let [q, qd, qdd, jerk] = between(a, b, tau);
                    let t = begin + tau;
                    assert!((q - compiled.at(t / slow).q).amax() < 2e-9, "{case} at {t}");
                    assert!((q - controller.at(t).q).amax() < 1e-12, "{case} at {t}");
                    let limits = [(qd, &rates.velocity), (qdd, &rates.acceleration), (jerk, &rates.jerk)];
                    for (order, (value, limit)) in limits.into_iter().enumerate() {
                        let ratio = value.component_div(limit).amax();
                        assert!(ratio <= 1.0 + 3e-6, "{case} at {t}, derivative {}: {ratio}", order + 1);
                    }
                }
            }
        }
    }
}

#[test]
fn there_are_no_points_beyond_a_limit() {
    let arm = arm();
    let (_, trajectory) = &plans(&arm)[0];
    let joints = trajectory.limits().joints();
    let compiled = trajectory.compile(1e-6).expect("compiled");
    let rates = JointRates::from(joints);
    let certificate = compiled.certify(joints.range(), &rates);
    let jerks = certificate.bounds().iter().filter(|bound| bound.id.quantity == Quantity::JointJerk);
    let worst = jerks.map(|bound| bound.ratio()).fold(0.0, f64::max);
    assert!(compiled.points(joints.range(), &rates).is_some());
    let less = JointRates { jerk: rates.jerk * (0.99 * worst), ..rates };
    assert_eq!(compiled.points(joints.range(), &less), None);
}
