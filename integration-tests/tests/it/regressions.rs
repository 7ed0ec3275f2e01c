//! Inputs that once went wrong, each a test by what went wrong.

use std::sync::Arc;

use arcfeed_geometry::{ArcLengthCurve, GeometryError, NurbsCurve, OrientationPath, PosePath};
use arcfeed_interp::{Limits, MotionPath, PlanError, Planner, Requirement, ToolLimits, ToolPath, Trajectory, verify};
use arcfeed_kinematics::{JointLimits, Joints, ParallelAxisArm, models};
use nalgebra::{UnitQuaternion, Vector3, vector};

/// Weights that the random search came up with.
const WEIGHTS: [f64; 14] = [
    1.6391262646869673,
    1.195893308149745,
    0.8179094319116863,
    1.1819753309301477,
    1.6370931518868532,
    1.4285363769530997,
    0.8878050172476418,
    1.1338881503105607,
    1.590696824516621,
    0.781670732711393,
    1.4594845677428305,
    1.6391558509985567,
    1.5328147040784745,
    0.6393585983797155,
];

fn joints(arm: &ParallelAxisArm) -> JointLimits<6> {
    arm.range().with_rates(Joints::repeat(1.643), Joints::repeat(9.936), Joints::repeat(375.3)).expect("valid")
}

fn tool([feed, tangential_acceleration, tangential_jerk, normal_acceleration]: [f64; 4]) -> ToolLimits {
    ToolLimits::new()
        .with_feed(feed)
        .and_then(|t| t.with_tangential_acceleration(tangential_acceleration))
        .and_then(|t| t.with_tangential_jerk(tangential_jerk))
        .and_then(|t| t.with_normal_acceleration(normal_acceleration))
        .expect("valid limits")
}

fn tool_down(curve: ArcLengthCurve<3>) -> PosePath {
    PosePath::new(curve, OrientationPath::Constant(UnitQuaternion::from_euler_angles(std::f64::consts::PI, 0.0, 0.0)))
}

fn plan(arm: &ParallelAxisArm, curve: ArcLengthCurve<3>) -> Result<Trajectory<'_>, PlanError> {
    let path = ToolPath::new(arm, tool_down(curve), arm.range())?;
    let limits = Limits::new(joints(arm)).with_tool(tool([0.2105, 1.229, 13.53, 1.959]));
    let planner = Planner::new(arm, limits).with_chord_tolerance(1.143e-5)?.with_period(7.602e-3)?;
    planner.plan_shared(Arc::new(path))
}

/// Jumps of curvature and the third derivative together claimed more than all of a joint's jerk, which left a negative
/// acceleration for the scan.
#[test]
fn many_jumps_of_curvature_leave_some_acceleration() {
    let points = [
        [0.391651, -0.059695, 0.120337],
        [0.391162, -0.073206, 0.123141],
        [0.410252, -0.076058, 0.153578],
        [0.394748, -0.046753, 0.130834],
        [0.397160, -0.063823, 0.142012],
        [0.384203, -0.046828, 0.120718],
        [0.405236, -0.060402, 0.130531],
        [0.414245, -0.057203, 0.143460],
        [0.383591, -0.048734, 0.123057],
        [0.401359, -0.073418, 0.150328],
        [0.397271, -0.048873, 0.125724],
        [0.402650, -0.046791, 0.129356],
        [0.409554, -0.055416, 0.155275],
        [0.411827, -0.066395, 0.152334],
    ];
    let mut knots = vec![0.0; 5];
    for (knot, times) in [(0.6645, 3), (1.59, 3), (2.0197, 3), (2.3872, 5)] {
        knots.extend(vec![knot; times]);
    }
    let points = points.map(Vector3::from).to_vec();
    let curve = NurbsCurve::new(4, points, WEIGHTS.to_vec(), knots).expect("a valid curve");
    let (arm, curve) = (models::cr7(), ArcLengthCurve::new(curve, 1e-15).expect("a curve of some length"));
    let plan = plan(&arm, curve).expect("it can be followed");
    assert_eq!(plan.stops().len(), 0);
    assert!(plan.verification().holds(1e-6));
}

/// A first span whose points coincide is a stand-still; the plan took 6e54 s, and the verification of so many samples
/// wrapped around and looked at one.
#[test]
fn a_span_without_length_is_refused_and_not_planned_for_ever() {
    let points =
        [vec![vector![0.3, 0.0, 0.1]; 6], vec![vector![0.3, 0.0, 0.0933], vector![0.314, 0.0043, 0.1062]]].concat();
    let mut knots = vec![0.0; 5];
    knots.extend([0.66, 0.66, 0.66, 1.6, 1.6, 1.6, 1.6, 1.6]);
    let curve = NurbsCurve::new(4, points, WEIGHTS[..8].to_vec(), knots);
    match curve.and_then(|curve| ArcLengthCurve::new(curve, 1e-15)) {
        Err(GeometryError::StandsStill { .. }) => {}
        Err(other) => panic!("another reason: {other}"),
        Ok(curve) => match plan(&models::cr7(), curve) {
            Err(_) => {}
            Ok(plan) => assert!(plan.duration() < 1e3, "a plan of {} s was let through", plan.duration()),
        },
    }
}

/// A duration that no number of samples covers.
#[test]
fn an_endless_motion_is_not_verified() {
    let line = NurbsCurve::line(vector![0.4, 0.0, 0.2], vector![0.4, 0.01, 0.2]).expect("a line");
    let arm = models::cr7();
    let plan = plan(&arm, ArcLengthCurve::new(line, 1e-15).expect("a line")).expect("in reach");
    let limits = Limits::new(joints(&arm)).with_tool(tool([1.0, 10.0, 100.0, 10.0]));
    let requirement = Requirement {
        arm: &arm,
        path: plan.path(),
        limits: &limits,
        jerk_limited: true,
        chord_tolerance: 1e-5,
        path_tolerance: 1e-5,
        period: plan.period(),
        sections: &[],
        end_speeds: [0.0; 2],
    };
    let mut sampler = plan.setpoints(plan.period()).expect("a valid period");
    for duration in [f64::INFINITY, f64::NAN, 1e300, -1.0] {
        let result = verify(&requirement, duration, &[], |t| sampler.at(t));
        assert!(!result.as_ref().is_ok_and(|v| v.holds(1e-6)), "{duration} s hold: {result:?}");
    }
}

/// On a small curve with sharp bends and a long control period the peak of the normal jerk lay between the points that
/// the planner bounded and those that the verification looked at.
#[test]
fn a_peak_between_the_samples_is_not_missed() {
    let points = [
        [0.30208555013430294, -0.23729530939784332, 0.13873308109837132],
        [0.30181776774862284, -0.23977999105427844, 0.13781553776989333],
        [0.30431660615110384, -0.2341687395698689, 0.14208992997236605],
        [0.29900130279749165, -0.2368715751679512, 0.13876336245754908],
        [0.3039759978912815, -0.2412331039272951, 0.13826142860191917],
        [0.3023819949984762, -0.23870063956858192, 0.14314608371140597],
        [0.29813319731251153, -0.23833440361934088, 0.14180167177949618],
        [0.30411011062657095, -0.23528854166790142, 0.14430428962468012],
        [0.3000523695737658, -0.23640150725834835, 0.13803041272606345],
        [0.3002692504639956, -0.24150578576991666, 0.14311025294054733],
    ];
    let weights = vec![
        1.0787736019999021,
        1.8959839666689215,
        0.7078005755397311,
        1.3114722030382544,
        1.7061921013546748,
        1.742827043209806,
        0.5831071957998701,
        1.9093968085583395,
        0.8637644547487716,
        1.0731034097459264,
    ];
    let mut knots = vec![0.0; 5];
    let spans = [
        0.5102190527026235,
        0.6960437612885193,
        0.3154871904980457,
        0.8727091595184764,
        0.3150384668410981,
        0.3944130669937037,
    ];
    for (i, span) in spans.iter().enumerate() {
        let next = knots[knots.len() - 1] + span;
        knots.extend(vec![next; if i == 5 { 5 } else { 1 }]);
    }
    let curve = NurbsCurve::new(4, points.map(Vector3::from).to_vec(), weights, knots).expect("a valid curve");
    let path = tool_down(ArcLengthCurve::new(curve, 1e-15).expect("a curve of some length"));
    let arm = models::cr7();
    let limits = arm
        .range()
        .with_rates(
            Joints::repeat(1.0785187511629948),
            Joints::repeat(3.5912201085154303),
            Joints::repeat(375.61177008562095),
        )
        .expect("valid");
    let tool = tool([0.21096931205794667, 2.4906292510949273, 153.59805801344237, 1.1559040291987546]);
    let limits = Limits::new(limits).with_tool(tool.with_normal_jerk(55.61613716602325).expect("valid"));
    let path = ToolPath::new(&arm, path, arm.range()).expect("in reach");
    let (chord_tolerance, period) = (8.757132687754506e-6, 0.004731580506084866);
    let planner = Planner::new(&arm, limits).with_period(period).and_then(|p| p.with_chord_tolerance(chord_tolerance));
    let plan = planner.expect("valid").plan(&path).expect("it can be followed");
    // Held against the same limits at a hundredth of the period.
    let requirement = Requirement {
        arm: &arm,
        path: &path,
        limits: &limits,
        jerk_limited: true,
        chord_tolerance,
        path_tolerance: chord_tolerance,
        period: 0.01 * period,
        sections: &[],
        end_speeds: [0.0; 2],
    };
    let mut sampler = plan.setpoints(period).expect("a valid period");
    let dense = verify(&requirement, plan.duration(), &[], |t| sampler.at(t)).expect("on the path");
    assert!(dense.holds(1e-6), "{:?}", dense.worst());
}

/// On a straight line the tool turned back within a span, where the curve stands still; the plan ended in "continuity reaches
/// 83977441 % of its limit".
#[test]
fn a_path_that_turns_back_on_itself_is_refused_with_its_place() {
    let heights = [0.1, 0.035, 0.1, 0.1, 0.134, 0.1, 0.059];
    let points = heights.map(|z| vector![0.3, 0.0, z]).to_vec();
    let mut knots = vec![0.0; 4];
    knots.extend([1.0, 2.0, 3.0]);
    knots.extend([4.0; 4]);
    let curve = NurbsCurve::bspline(3, points, knots).expect("a valid curve");
    let error = ArcLengthCurve::new(curve, 1e-15).expect_err("it turns back");
    let GeometryError::StandsStill { u, .. } = error else { panic!("{error}") };
    // The first place where z'(u) = 0, on the first span: z = 0.1 - 0.065 (3 u (1 - u)^2) + ... falls, then rises.
    assert!((0.0..1.0).contains(&u), "{error}");
}

/// Several turns between two places of the coarse walk: it took what lay between for a joint at the end of its range.
#[test]
fn a_winding_path_is_followed_from_its_start() {
    let turns = 30.0 * std::f64::consts::TAU;
    let points: Vec<_> = (0..600)
        .map(|i| {
            let share = f64::from(i) / 599.0;
            let (radius, angle) = (0.005 + 0.03 * share, turns * share);
            vector![0.45 + radius * angle.cos(), radius * angle.sin(), 0.2]
        })
        .collect();
    let mut knots = vec![0.0; 4];
    knots.extend((1..597).map(f64::from));
    knots.extend([597.0; 4]);
    let curve = NurbsCurve::bspline(3, points, knots).expect("a valid curve");
    let path = tool_down(ArcLengthCurve::new(curve, 1e-15).expect("of some length"));
    let arm = models::cr7();
    let start = ToolPath::new(&arm, path, arm.range()).expect("well inside the reach").start();
    assert!(arm.range().contains(&start));
}
