//! Way-points of the tests of MoveIt's time-optimal trajectory generation, and of reports of its users: each motion
//! keeps its limits, and takes the shortest time where that is known.
//!
//! Origin: moveit/moveit2 (BSD-3-Clause), `test_time_optimal_trajectory_generation.cpp`, and the issues named in the
//! data. Only numbers are taken. Corners are rounded by parabolas here and by arcs of circles there, within the same
//! tolerance.

use arcfeed_feedrate::{AxisLimits, AxisState, MotionLaw, SpeedLaw, StateToState};
use arcfeed_kinematics::nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion};
use arcfeed_kinematics::{ForwardKinematics, InverseKinematics, JointRange, Joints, models};
use serde::Deserialize;

use crate::cubics::{Cubics, ROUNDING};

const CASES: &str = include_str!("../data/moveit_cases.json");

#[derive(Deserialize)]
struct File {
    lines: Vec<Case>,
    equal_steps: EqualSteps,
    corners: Vec<Case>,
    zero_limits: Vec<ZeroLimit>,
    users: Vec<Case>,
    panda_goals: PandaGoals,
    panda_turn: PandaTurn,
}

#[derive(Deserialize)]
struct Case {
    case: String,
    points: Vec<Vec<f64>>,
    v: Vec<f64>,
    a: Vec<f64>,
    tolerance: Option<f64>,
    /// The duration that the suite states, s.
    published: Option<f64>,
    /// How far the suite lets it differ, s.
    within: Option<f64>,
}

#[derive(Deserialize)]
struct EqualSteps {
    steps: usize,
    step: f64,
    end: f64,
    v: f64,
    a: f64,
}

#[derive(Deserialize)]
struct ZeroLimit {
    case: String,
    end: [f64; 2],
    a: [f64; 2],
    /// There is a motion, although an axis has an acceleration limit of 0.
    moves: bool,
}

#[derive(Deserialize)]
struct PandaGoals {
    ready: [f64; 7],
    goals: Vec<[f64; 3]>,
    orientation_xyzw: [f64; 4],
    v: Vec<f64>,
    a: Vec<f64>,
}

#[derive(Deserialize)]
struct PandaTurn {
    from_deg: f64,
    to_deg: f64,
    v: f64,
    a: f64,
    j: f64,
}

fn cases() -> File {
    serde_json::from_str(CASES).expect("valid cases")
}

/// The certified motion along `path`, its limits and its ends held by positions alone.
fn judged(path: &Cubics, intervals: usize, (v, a): (&[f64], &[f64]), ends: [&[f64]; 2], name: &str) -> SpeedLaw {
    let law = path.planned(&path.grid(intervals), v, a, None, name);
    let worst = path.worst(&law, |_, j| v[j], a);
    // Places far from 0 are rounded more.
    let (step, size) = (law.duration() / 4000.0, ends[0].iter().fold(1.0, |size: f64, q| size.max(q.abs())));
    let rounding =
        ROUNDING + 4.0 * f64::EPSILON * size / (step * step) / a.iter().copied().fold(f64::INFINITY, f64::min);
    assert!(worst[0] <= 1.0 + 1e-6 && worst[1] <= 1.0 + rounding, "{name}: {worst:?}");
    for (t, point) in [0.0, law.duration()].into_iter().zip(ends) {
        for (j, place) in point.iter().enumerate() {
            let q = path.position(&law, t, j);
            assert!((q - place).abs() <= 1e-12 * (1.0 + place.abs()), "{name}: axis {} at {q}, not {place}", j + 1);
        }
    }
    law
}

fn ends(points: &[Vec<f64>]) -> [&[f64]; 2] {
    [&points[0], &points[points.len() - 1]]
}

/// The shortest time on a line: all axes in proportion, speed and acceleration by the axis that allows the least.
fn shortest(points: &[Vec<f64>], v: &[f64], a: &[f64]) -> f64 {
    let [first, last] = ends(points);
    let least = |limits: &[f64]| {
        let shares = first.iter().zip(last).zip(limits).filter(|((from, to), _)| from != to);
        shares.map(|((from, to), limit)| limit / (to - from).abs()).fold(f64::INFINITY, f64::min)
    };
    let (v, a) = (least(v), least(a));
    if v * v < a { 1.0 / v + v / a } else { 2.0 / a.sqrt() }
}

#[test]
fn lines_take_the_time_that_moveit_states() {
    for case in cases().lines {
        let shortest = shortest(&case.points, &case.v, &case.a);
        if let Some(published) = case.published {
            let within = case.within.expect("a tolerance beside the duration");
            assert!((shortest - published).abs() <= within, "{}: {shortest} s, {published} s", case.case);
        }
        let path = Cubics::blended(&case.points, 0.0);
        let law = judged(&path, 200, (&case.v, &case.a), ends(&case.points), &case.case);
        let ratio = law.duration() / shortest;
        assert!((1.0 - 1e-9..1.01).contains(&ratio), "{}: {ratio} of {shortest} s", case.case);
    }
}

/// 89 way-points, 88 equal steps, printed to nine digits: the end is the last one.
#[test]
fn equal_small_steps_end_at_the_last_way_point() {
    let EqualSteps { steps, step, end, v, a } = cases().equal_steps;
    let value = |i: usize| if i == steps { end } else { (i as f64 * step * 1e9).round() / 1e9 };
    let points: Vec<Vec<f64>> = (0..=steps).map(|i| vec![value(i); 2]).collect();
    let law = judged(&Cubics::natural(&points), 2 * steps, (&[v; 2], &[a; 2]), ends(&points), "equal steps");
    let ratio = law.duration() / shortest(&points, &[v; 2], &[a; 2]);
    assert!((1.0 - 1e-9..1.01).contains(&ratio), "{ratio}");
}

/// How far a parabola that takes half of the shorter line at most is from the corner, within the tolerance.
fn corner(points: &[Vec<f64>], tolerance: f64) -> f64 {
    let way = |k: usize| -> Vec<f64> { points[k + 1].iter().zip(&points[k]).map(|(a, b)| a - b).collect() };
    let [before, after] = [way(0), way(1)];
    let norm = |v: &[f64]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
    let (d, e) = (norm(&before), norm(&after));
    let bend: Vec<f64> = before.iter().zip(&after).map(|(a, b)| b / e - a / d).collect();
    tolerance.min(norm(&bend) * d.min(e) / 8.0)
}

/// Where way-points lie near to one another or on a line, a corner needs less than the tolerance: no more is allowed.
/// Those of `testLargeAccel` lie on one line, and each is passed.
#[test]
fn corners_keep_their_tolerance_and_the_limits() {
    for case in cases().corners {
        let tolerance = case.tolerance.expect("a tolerance");
        let path = Cubics::blended(&case.points, tolerance);
        let law = judged(&path, 2000, (&case.v, &case.a), ends(&case.points), &case.case);
        let last = case.points.len() - 1;
        for (i, point) in case.points.iter().enumerate() {
            let within = if i == 0 || i == last { 0.0 } else { corner(&case.points[i - 1..=i + 1], tolerance) };
            let away = |t: f64| (0..path.axes()).map(|j| (path.position(&law, t, j) - point[j]).powi(2)).sum::<f64>();
            let nearest = (0..=20_000).map(|k| away(law.duration() * f64::from(k) / 20_000.0));
            let nearest = nearest.fold(f64::INFINITY, f64::min).sqrt();
            // Between two samples the motion goes on by a part of this.
            let step = law.duration() / 20_000.0 * case.v.iter().map(|v| v * v).sum::<f64>().sqrt();
            assert!(nearest <= within + step, "{}: {nearest}, not {within} from way-point {}", case.case, i + 1);
        }
        if let Some(published) = case.published {
            // Another curve within the same tolerance, with a bend that suits the limits of single axes better.
            let ratio = law.duration() / published;
            assert!((0.95..1.0).contains(&ratio), "{}: {} s, {published} s", case.case, law.duration());
        }
    }
}

/// The planner of paths takes an acceleration limit of 0. It holds an axis that has to move, and the error names axis
/// and limit; it does not matter to an axis that stands still.
#[test]
fn an_acceleration_limit_of_zero_holds_the_axis_that_moves() {
    for ZeroLimit { case, end, a, moves } in cases().zero_limits {
        let points = [vec![0.0; 2], end.to_vec()];
        let path = Cubics::blended(&points, 0.0);
        match path.plan(&path.grid(200), &[1.0; 2], &a, None) {
            Ok(_) => {
                assert!(moves, "{case}: a motion");
                let law = judged(&path, 200, (&[1.0; 2], &a), ends(&points), &case);
                let ratio = law.duration() / shortest(&points, &[1.0; 2], &a);
                assert!((1.0 - 1e-9..1.01).contains(&ratio), "{case}: {ratio}");
            }
            Err(error) => {
                let held =
                    1 + (0..2).find(|k| a[*k] == 0.0 && end[*k] != 0.0).unwrap_or_else(|| panic!("{case}: {error}"));
                let text = error.to_string();
                assert!(
                    !moves && text.contains(&format!("joint {held}")) && text.contains("acceleration"),
                    "{case}: {text}"
                );
            }
        }
    }
}

/// The limits of an arm are above 0, whatever its path.
#[test]
fn an_arm_with_an_acceleration_limit_of_zero_is_refused() {
    let range = JointRange::<2>::new(Joints::repeat(-2.0), Joints::repeat(2.0)).expect("a range");
    for ZeroLimit { case, a, .. } in cases().zero_limits {
        let error = range.with_rates(Joints::repeat(1.0), Joints::from(a), Joints::repeat(20.0)).expect_err(&case);
        let zero = 1 + (0..2).find(|k| a[*k] == 0.0).expect("a limit of 0");
        let expected = format!("joint {zero}: acceleration limit 0 ");
        assert!(error.to_string().starts_with(&expected), "{case}: {error}");
    }
}

#[test]
fn way_points_of_users_keep_their_limits() {
    for case in cases().users {
        let path = Cubics::natural(&case.points);
        for intervals in [60, 600] {
            judged(&path, intervals, (&case.v, &case.a), ends(&case.points), &case.case);
        }
    }
}

/// MoveIt commanded joints 1 and 3 of the Panda up to 10 % faster than its limits on the way between these goals.
#[test]
fn goals_that_made_the_panda_too_fast_keep_its_limits() {
    let case = cases().panda_goals;
    let arm = models::panda();
    let [x, y, z, w] = case.orientation_xyzw;
    let turn = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z));
    let mut points = vec![Joints::from(case.ready)];
    for goal in &case.goals {
        let pose = Isometry3::from_parts(Translation3::from(*goal), turn);
        let q = arm.inverse(&pose, &points[points.len() - 1]).unwrap_or_else(|error| panic!("{goal:?}: {error}"));
        assert!((arm.forward(&q).translation.vector - pose.translation.vector).norm() < 1e-9, "{goal:?}");
        points.push(q);
    }
    let points: Vec<Vec<f64>> = points.iter().map(|q| q.iter().copied().collect()).collect();
    let limits = (&case.v[..], &case.a[..]);
    for w in points.windows(2) {
        let law = judged(&Cubics::blended(w, 0.0), 200, limits, [&w[0], &w[1]], "goal to goal");
        let ratio = law.duration() / shortest(w, &case.v, &case.a);
        assert!((1.0 - 1e-9..1.01).contains(&ratio), "{ratio}");
    }
    let path = Cubics::natural(&points);
    let law = judged(&path, 600, limits, ends(&points), "through all goals");
    let worst = path.worst(&law, |_, j| case.v[j], &case.a);
    assert!(worst[0].max(worst[1]) > 0.99, "no limit binds: {worst:?}");
}

/// Half a turn of one joint oscillated at its end: here it turns one way, and no faster at the end than braking asks
/// for.
#[test]
fn half_a_turn_ends_without_oscillation() {
    let PandaTurn { from_deg, to_deg, v, a, j } = cases().panda_turn;
    let limits = AxisLimits::symmetric(v, a, j).expect("above 0");
    let (start, target) = (AxisState::rest(f64::to_radians(from_deg)), AxisState::rest(f64::to_radians(to_deg)));
    let motion = StateToState::new(&start, &target, &limits).expect("a motion");
    let closed = (target.p - start.p).abs() / v + v / a + a / j;
    assert!((motion.duration() / closed - 1.0).abs() < 1e-12, "{} s, {closed} s", motion.duration());
    let step = motion.duration() / 20_000.0;
    let q: Vec<f64> = (0..=20_000).map(|i| motion.at(f64::from(i) * step).p).collect();
    let speeds: Vec<f64> = q.windows(2).map(|w| (w[0] - w[1]) / step).collect();
    let top = speeds.iter().position(|s| *s >= v * (1.0 - 1e-9)).expect("the limit is reached");
    let rounding = 4.0 * f64::EPSILON * 2.0 / step;
    assert!(speeds[..=top].windows(2).all(|w| w[1] >= w[0] - rounding), "it speeds up in one go");
    assert!(speeds[top..].windows(2).all(|w| w[1] <= w[0] + rounding && w[1] >= -rounding), "and slows down in one go");
}
