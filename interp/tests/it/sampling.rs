//! From plans to setpoints: ends, counts, corners, straight lines, very short paths, jumps of curvature.

use crate::common;

use arcfeed_feedrate::MotionLaw;
use arcfeed_geometry::{Curve, NurbsCurve};
use arcfeed_interp::{LimitError, Quantity, Setpoint, ToolLimits, Trajectory};
use arcfeed_kinematics::ForwardKinematics;
use common::{
    FEED, NORMAL_ACCELERATION, TANGENTIAL_ACCELERATION, TANGENTIAL_JERK, analytic, arm, knotted, limits, line_and_arc,
    plan, tool,
};
use nalgebra::{Vector3, vector};

fn samples(plan: &Trajectory<'_>, period: f64) -> Vec<Setpoint> {
    let sampler = plan.setpoints(period).expect("a valid period");
    let announced = sampler.samples();
    assert_eq!(sampler.size_hint(), (announced, Some(announced)));
    let all: Vec<_> = sampler.collect::<Result<_, _>>().expect("on the path");
    assert_eq!(all.len(), announced, "at a period of {period} s");
    all
}

#[test]
fn samples_end_exactly_at_the_end() {
    let arm = arm();
    for curve in [analytic(), knotted()] {
        let plan = plan(&arm, curve).expect("in reach");
        let nurbs = plan.path().tool_curve().expect("a curve").curve().curve();
        let duration = plan.duration();
        // Also periods that divide the duration exactly, or to within rounding.
        for period in [
            1e-3,
            2e-3,
            7.3e-3,
            duration,
            duration / 2.0,
            duration / 3.0,
            duration / 7.0,
            0.6 * duration,
            3.0 * duration,
        ] {
            let all = samples(&plan, period);
            let (first, last) = (&all[0], &all[all.len() - 1]);
            assert_eq!((first.t, first.s, first.feed, first.acceleration), (0.0, 0.0, 0.0, 0.0));
            assert_eq!((last.t, last.s, last.feed, last.acceleration), (duration, plan.path().length(), 0.0, 0.0));
            for rest in [first, last] {
                assert_eq!((rest.qd.amax(), rest.qdd.amax()), (0.0, 0.0));
            }
            for (at, u) in [(first, nurbs.domain().0), (last, nurbs.domain().1)] {
                assert!((arm.forward(&at.q).translation.vector - nurbs.point(u)).norm() < 1e-12);
            }
            for (i, pair) in all.windows(2).enumerate() {
                let step = pair[1].t - pair[0].t;
                let whole = i + 2 < all.len();
                assert!(step > 0.0 && step <= period * (1.0 + 1e-9), "step {step} of {period}");
                assert!(!whole || (step - period).abs() < 1e-12 * duration, "step {step} of {period}");
                assert!(pair[1].s >= pair[0].s);
            }
            let expected = (duration / period - 1e-9).ceil() as usize + 1;
            assert_eq!(all.len(), expected, "{period} over {duration}");
        }
        for period in [0.0, -1e-3, f64::NAN, f64::INFINITY] {
            assert!(matches!(plan.setpoints(period), Err(LimitError::NotPositive { what: "control period", .. })));
        }
    }
}

#[test]
fn setpoints_are_consistent_with_each_other() {
    let arm = arm();
    let plan = plan(&arm, knotted()).expect("in reach");
    let mut sampler = plan.setpoints(1e-3).expect("a valid period");
    let h = 1e-5;
    for i in 1..200 {
        let t = plan.duration() * f64::from(i) / 200.0;
        let [before, at, after] = [t - h, t, t + h].map(|t| sampler.at(t).expect("on the path"));
        assert!((arm.forward(&at.q).translation.vector - at.pose.translation.vector).norm() < 1e-13);
        assert!(
            (at.pose.translation.vector - plan.path().tool_curve().expect("a curve").pose(at.s).translation.vector)
                .norm()
                == 0.0
        );
        // Central differences miss by h^2 / 6 of the jerk where it is constant, by h / 4 of its jump where it is not.
        let jerk = before.jerk.abs().zip_map(&after.jerk.abs(), f64::max).amax() + 1.0;
        assert!(((after.q - before.q) / (2.0 * h) - at.qd).amax() < jerk * h * h + 1e-9);
        assert!(((after.qd - before.qd) / (2.0 * h) - at.qdd).amax() < 2.0 * jerk * h + 1e-8);
        assert!(((after.s - before.s) / (2.0 * h) - at.feed).abs() < 1e-8);
        let v = arm.jacobian(&at.q) * at.qd;
        assert!((v.fixed_rows::<3>(0).norm() - at.feed).abs() < 1e-12 && v.fixed_rows::<3>(3).norm() < 1e-12);
    }
    // In any order, and outside the motion: the nearest end.
    let forward: Vec<_> = (0..50).map(|i| sampler.at(0.02 * f64::from(i)).expect("on the path")).collect();
    for (i, at) in forward.iter().enumerate().rev() {
        let again = sampler.at(0.02 * i as f64).expect("on the path");
        assert!((again.q - at.q).amax() < 1e-14 && again.s == at.s);
    }
    assert_eq!(sampler.at(-1.0).expect("the start").s, 0.0);
    assert_eq!(sampler.at(1e9).expect("the end").s, plan.path().length());
}

#[test]
fn at_corners_the_tool_stands() {
    let arm = arm();
    let corners =
        [vector![0.40, -0.05, 0.20], vector![0.45, -0.05, 0.20], vector![0.45, 0.02, 0.22], vector![0.40, 0.02, 0.25]];
    let plan = plan(&arm, NurbsCurve::polyline(corners.to_vec()).expect("a polyline")).expect("in reach");
    let stops: Vec<f64> = plan.stops().collect();
    let lengths: Vec<f64> = corners.windows(2).map(|p| (p[1] - p[0]).norm()).collect();
    assert_eq!(stops.len(), 2);
    assert!((stops[0] - lengths[0]).abs() < 1e-12 && (stops[1] - lengths[0] - lengths[1]).abs() < 1e-12, "{stops:?}");
    assert!(plan.verification().holds(1e-6));
    for &s in &stops {
        assert!(plan.law().at_position(s).v < 1e-6, "{}", plan.law().at_position(s).v);
        // When the law is there, it stands, and before and after it moves.
        let t = crossing(&plan, s);
        let mut sampler = plan.setpoints(1e-3).expect("a valid period");
        let at = sampler.at(t).expect("on the path");
        assert!((at.s - s).abs() < 1e-12 && at.feed < 1e-9 && at.qd.amax() < 1e-8, "{at:?}");
        assert!(sampler.at(t - 0.02).expect("on the path").feed > 1e-4);
        assert!(sampler.at(t + 0.02).expect("on the path").feed > 1e-4);
    }
    // Every corner is touched, and no setpoint leaves the lines.
    let all = samples(&plan, 1e-3);
    for corner in &corners {
        let nearest = all.iter().map(|p| (p.pose.translation.vector - corner).norm()).fold(f64::INFINITY, f64::min);
        assert!(nearest < 2e-8, "{nearest}");
    }
    for at in &all {
        let p = arm.forward(&at.q).translation.vector;
        let off = corners.windows(2).map(|l| distance(&p, &l[0], &l[1])).fold(f64::INFINITY, f64::min);
        assert!(off < 1e-12, "{off} m off the lines at s = {}", at.s);
    }
}

fn distance(p: &Vector3<f64>, a: &Vector3<f64>, b: &Vector3<f64>) -> f64 {
    let f = ((p - a).dot(&(b - a)) / (b - a).norm_squared()).clamp(0.0, 1.0);
    (p - a - (b - a) * f).norm()
}

#[test]
fn a_straight_line_takes_the_time_of_its_s_profile() {
    let arm = arm();
    let (a, b) = (vector![0.35, -0.15, 0.20], vector![0.45, 0.15, 0.30]);
    let plan = plan(&arm, NurbsCurve::line(a, b).expect("a line")).expect("in reach");
    let length = (b - a).norm();
    assert!((plan.path().length() - length).abs() < 1e-15);
    assert_eq!(plan.segmentation().expect("a curve").len(), 1);
    assert_eq!(plan.stops().len(), 0);
    // The joints are fast enough here: feed, acceleration and jerk of the tool alone give the time.
    let (v, acc, j) = (FEED, TANGENTIAL_ACCELERATION, TANGENTIAL_JERK);
    let ideal = length / v + v / acc + acc / j;
    assert!(plan.duration() >= ideal * (1.0 - 1e-9), "{} below {ideal}", plan.duration());
    assert!(plan.duration() <= ideal * 1.02, "{} against {ideal}", plan.duration());
    let verification = plan.verification();
    assert!(verification.worst_of(Quantity::Feed).expect("looked at").ratio > 0.999);
    assert!(verification.worst_of(Quantity::NormalAcceleration).expect("looked at").value < 1e-9);
    assert!(verification.worst_of(Quantity::ChordError).expect("looked at").value < 1e-12);
}

#[test]
fn on_a_very_short_path_the_feed_is_never_reached() {
    let arm = arm();
    for length in [1e-3, 1e-5, 1e-7] {
        let a = vector![0.4, 0.1, 0.2];
        let plan = plan(&arm, NurbsCurve::line(a, a + Vector3::y() * length).expect("a line")).expect("in reach");
        // All of it is jerk: t = 4 (L / 2 J)^(1/3), or longer where the joints are the limit.
        let ideal = 4.0 * (length / 2.0 / TANGENTIAL_JERK).cbrt();
        assert!(plan.duration() >= ideal * (1.0 - 1e-6), "{length} m in {} s, below {ideal}", plan.duration());
        assert!(plan.duration() <= 3.0 * ideal, "{length} m in {} s, far above {ideal}", plan.duration());
        let fastest = plan.verification().worst_of(Quantity::Feed).expect("looked at");
        assert!(fastest.ratio < 0.9 && fastest.ratio > 0.0, "{fastest:?}");
        let all = samples(&plan, 1e-3);
        assert_eq!(all[all.len() - 1].s, plan.path().length());
    }
}

#[test]
fn a_jump_of_curvature_steps_the_joints_no_more_than_a_period_of_jerk_allows() {
    let arm = arm();
    let radius = 0.04;
    let plan = plan(&arm, line_and_arc(0.1, radius)).expect("in reach");
    assert_eq!(plan.stops().len(), 0, "the tangent is continuous");
    let limits = limits(&arm);
    assert!(plan.verification().holds(1e-6));
    let knot = 0.1;
    let v = plan.law().at_position(knot).v;
    assert!(v > 1e-3 && v * v / radius <= NORMAL_ACCELERATION, "v = {v}");
    // Joint acceleration right before and right after the knot.
    let mut sampler = plan.setpoints(1e-3).expect("a valid period");
    let t = crossing(&plan, knot);
    let (before, after) = (sampler.at(t - 1e-9).expect("on the path"), sampler.at(t + 1e-9).expect("on the path"));
    assert!(before.s < knot && after.s > knot);
    let step = (after.qdd - before.qdd).abs();
    assert!(step.amax() > 1e-3, "the curvature jumps: {step}");
    for k in 0..6 {
        assert!(step[k] <= limits.jerk()[k] * plan.period() * (1.0 + 1e-6), "joint {}: {}", k + 1, step[k]);
    }
}

/// The time at which the law passes `s`, by bisection.
fn crossing(plan: &Trajectory<'_>, s: f64) -> f64 {
    let (mut a, mut b) = (0.0, plan.duration());
    for _ in 0..80 {
        let t = 0.5 * (a + b);
        if plan.law().at(t).p < s { a = t } else { b = t }
    }
    0.5 * (a + b)
}

#[test]
fn limits_that_are_none_are_refused() {
    type With = fn(ToolLimits, f64) -> Result<ToolLimits, LimitError>;
    let limits: [(&str, With); 6] = [
        ("feed rate", ToolLimits::with_feed),
        ("tangential acceleration", ToolLimits::with_tangential_acceleration),
        ("tangential jerk", ToolLimits::with_tangential_jerk),
        ("normal acceleration", ToolLimits::with_normal_acceleration),
        ("normal jerk", ToolLimits::with_normal_jerk),
        ("angular speed", ToolLimits::with_angular_speed),
    ];
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        for (what, with) in limits {
            match with(tool(), bad) {
                Err(error @ LimitError::NotPositive { what: named, .. }) => {
                    assert_eq!(named, what);
                    assert!(error.to_string().contains(what), "{error}");
                }
                other => panic!("{what} {bad}: {other:?}"),
            }
        }
    }
}

/// Jumps in time led the sampler to another solution of the inverse: it took the Taylor series of the last place as a guess wherever
/// the first derivatives there were small.
#[test]
fn times_in_any_order_give_the_same_setpoints() {
    let arm = arm();
    let mut random = arcfeed_testing::Random::new(5);
    for _ in 0..4 {
        // A tangle within 10 cm, in which the joints turn back many times.
        let points = (0..9).map(|_| vector![0.4, 0.0, 0.25] + Vector3::from_fn(|_, _| random.between(-0.1, 0.1)));
        let knots = vec![0.0, 0.0, 0.0, 0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 6.0, 6.0, 6.0];
        let curve = NurbsCurve::bspline(3, points.collect(), knots).expect("a valid curve");
        let trajectory = plan(&arm, curve).expect("a plan");
        let (mut jumping, mut fresh) = (trajectory.setpoints(1e-3).expect("a period"), trajectory.setpoints(1e-3));
        let fresh = fresh.as_mut().expect("a period");
        let in_order: Vec<_> =
            (0..=2000).map(|i| fresh.at(trajectory.duration() * f64::from(i) / 2000.0).expect("on the path")).collect();
        for _ in 0..20_000 {
            let expected = &in_order[random.between(0.0, 2000.0) as usize];
            let got = jumping.at(expected.t).expect("on the path");
            assert!((got.q - expected.q).amax() < 1e-9, "at {}: {} is not {}", got.t, got.q, expected.q);
        }
    }
}
