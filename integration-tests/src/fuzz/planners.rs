//! Planners, each fed arbitrary finite numbers.

use std::path::Path;
use std::sync::Arc;

use arcfeed_geometry::{ArcLengthCurve, NurbsCurve, OrientationPath, PoseMotion, PosePath};
use arcfeed_interp::{JointSpline, Limits, Method, MotionPath, Planner, PoseMove, ToolLimits, ToolPath};
use arcfeed_kinematics::{ForwardKinematics, JointLimits, Joints, ParallelAxisArm, models};
use arcfeed_sync::feedrate::{AxisLimits, AxisState};
use arcfeed_sync::{MotionOptions, OnlineGenerator, Route, Synchronisation, Trajectory, WayPoint, WayPointPlanner};
use nalgebra::{Isometry3, UnitQuaternion, Vector3};
use robot_cr7::BatchItem;

use super::judge::{NoJump, fault_of};
use super::numbers::Numbers;
use super::verdict::Verdict;

const MODES: [Synchronisation; 4] =
    [Synchronisation::None, Synchronisation::Time, Synchronisation::StraightLine, Synchronisation::ForcedStraight];

fn broken(words: impl Into<String>) -> Verdict {
    Verdict::Broken(words.into())
}

fn state(numbers: &mut Numbers<'_>) -> AxisState {
    match numbers.below(3) {
        0 => AxisState::rest(numbers.value()),
        _ => AxisState::new(numbers.value(), numbers.value(), numbers.value()),
    }
}

fn states<const N: usize>(numbers: &mut Numbers<'_>) -> [AxisState; N] {
    std::array::from_fn(|_| state(numbers))
}

fn axis_limits(numbers: &mut Numbers<'_>) -> Option<AxisLimits> {
    let [v, a, j] = [(); 3].map(|()| numbers.positive());
    if numbers.below(2) == 0 {
        return AxisLimits::symmetric(v, a, j).ok();
    }
    let mut pair = |upper: f64| (-numbers.positive(), upper);
    AxisLimits::new(pair(v), pair(a), pair(j)).ok()
}

fn limits<const N: usize>(numbers: &mut Numbers<'_>) -> Option<[AxisLimits; N]> {
    let mut all = [AxisLimits::symmetric(1.0, 1.0, 1.0).ok()?; N];
    for one in &mut all {
        *one = axis_limits(numbers)?;
    }
    Some(all)
}

/// Several axes from state to state.
pub(super) fn state_to_state(bytes: &[u8]) -> Verdict {
    let numbers = &mut Numbers::new(bytes);
    let Some(limits) = limits::<3>(numbers) else { return Verdict::Refused };
    let (start, target) = (states::<3>(numbers), states::<3>(numbers));
    let mut options = MotionOptions::new(MODES[numbers.below(4)]);
    if numbers.below(4) == 0 {
        let Ok(with) = options.with_least_duration(numbers.positive()) else { return Verdict::Refused };
        options = with;
    }
    if numbers.below(4) == 0 {
        let Ok(with) = options.with_cycle(numbers.positive()) else { return Verdict::Refused };
        options = with;
    }
    let motion = match Trajectory::new(&start, &target, &limits, &options) {
        Ok(motion) => motion,
        Err(error) if error.to_string().is_empty() => return broken("an error without words"),
        Err(_) => return Verdict::Refused,
    };
    let duration = motion.duration();
    if !(duration.is_finite() && duration >= 0.0) {
        return broken(format!("a duration of {duration}"));
    }
    for i in 0..=8 {
        let state = motion.at(duration * f64::from(i) / 8.0);
        let all = [state.q, state.qd, state.qdd, state.qddd];
        if !all.iter().flatten().all(|v| v.is_finite()) {
            return broken(format!("a state that is not finite: {state:?}"));
        }
    }
    // Sizes far from each other, and starts far outside the limits, leave no digits for the sums of the judge.
    let judged = !numbers.hostile() && limits.iter().zip(&start).all(|(limits, start)| limits.contain(start));
    match fault_of(&start, &target, &limits, &motion).filter(|_| judged) {
        Some(fault) => broken(fault),
        None => Verdict::Accepted,
    }
}

fn cycle(numbers: &mut Numbers<'_>) -> f64 {
    match numbers.below(4) {
        0 => numbers.positive(),
        1 => 1e-3,
        2 => 4e-3,
        _ => 8e-3,
    }
}

/// A generator whose targets, limits and scale change on the way.
pub(super) fn online(bytes: &[u8]) -> Verdict {
    let numbers = &mut Numbers::new(bytes);
    let Some(first) = limits::<2>(numbers) else { return Verdict::Refused };
    let (start, cycle) = (states::<2>(numbers), cycle(numbers));
    let Ok(mut generator) = OnlineGenerator::new(start, first, cycle, MODES[numbers.below(3)]) else {
        return Verdict::Refused;
    };
    let mut judge = NoJump::new(start, &first, cycle);
    let mut accepted = false;
    for _ in 0..24 {
        if numbers.is_empty() {
            break;
        }
        accepted |= command(&mut generator, numbers, &mut judge);
        for _ in 0..1 + numbers.below(40) {
            generator.step();
            let fault = judge.see(generator.state());
            // Sizes far from each other leave no digits for differences.
            if let Some(fault) = fault.filter(|fault| !numbers.hostile() || fault.contains("is at")) {
                return broken(fault);
            }
        }
        if !generator.time_left().is_finite() {
            return broken(format!("{} s left", generator.time_left()));
        }
    }
    if accepted { Verdict::Accepted } else { Verdict::Refused }
}

/// One command; true if it is accepted.
fn command(generator: &mut OnlineGenerator<2>, numbers: &mut Numbers<'_>, judge: &mut NoJump<2>) -> bool {
    match numbers.below(10) {
        0 => generator.set_axis_target(numbers.below(3), state(numbers)).is_ok(),
        1 => {
            let (axis, Some(one)) = (numbers.below(2), axis_limits(numbers)) else { return false };
            judge.permit(&[one; 2]);
            generator.set_axis_limits(axis, one).is_ok()
        }
        2 => generator.stop().is_ok(),
        3 => {
            generator.stop_on_path();
            true
        }
        4 => generator.jog(numbers.values(), numbers.positive()).is_ok(),
        5 => generator.set_scale(numbers.unit() * 1.5).is_ok(),
        6 => {
            generator.hold();
            true
        }
        7 => {
            generator.resume();
            true
        }
        8 => {
            let (target, Some(all)) = (states(numbers), limits(numbers)) else { return false };
            judge.permit(&all);
            generator.set(target, all).is_ok()
        }
        _ => generator.set_target(states(numbers)).is_ok(),
    }
}

/// A generator along way-points, whose route changes once.
pub(super) fn way_points(bytes: &[u8]) -> Verdict {
    let numbers = &mut Numbers::new(bytes);
    let Some(all) = limits::<2>(numbers) else { return Verdict::Refused };
    let (start, cycle) = (states::<2>(numbers), cycle(numbers));
    let points = points(numbers, &all);
    let target = states(numbers);
    let Ok(generator) = OnlineGenerator::new(start, all, cycle, Synchronisation::Time) else { return Verdict::Refused };
    let (mut generator, mut planner) = (Box::new(generator.with_way_points()), Box::new(WayPointPlanner::new()));
    if generator.set_route(&Route::new(&points, target, all), &mut planner).is_err() {
        return Verdict::Refused;
    }
    let mut judge = NoJump::new(start, &all, cycle);
    for round in 0..2 {
        let duration = generator.route().duration();
        if !(duration.is_finite() && duration >= 0.0) {
            return broken(format!("a duration of {duration}"));
        }
        let cycles = (duration / cycle).ceil() + 2.0;
        let watched = if round == 0 { numbers.below(256) as f64 } else { 3000.0 };
        let mut reached = false;
        for _ in 0..cycles.min(watched) as usize {
            reached |= generator.step().events.reached;
            if let Some(fault) =
                judge.see(generator.state()).filter(|fault| !numbers.hostile() || fault.contains("is at"))
            {
                return broken(fault);
            }
        }
        if cycles <= watched && !reached && !numbers.hostile() {
            return broken(format!("not at the target after {cycles} cycles of {cycle} s, {duration} s in all"));
        }
        let points = self::points(numbers, &all);
        if generator.set_route(&Route::new(&points, states(numbers), all), &mut planner).is_err() {
            break;
        }
    }
    Verdict::Accepted
}

fn points(numbers: &mut Numbers<'_>, limits: &[AxisLimits; 2]) -> Vec<WayPoint<2>> {
    let mut points = Vec::new();
    for _ in 0..numbers.below(8) {
        let mut point = WayPoint::new(numbers.values());
        if numbers.below(4) == 0 {
            point = point.with_velocity(numbers.below(2), numbers.value());
        }
        if numbers.below(6) == 0 {
            point = point.with_least_duration(numbers.positive());
        }
        if numbers.below(8) == 0 {
            point = point.with_limits(*limits);
        }
        if numbers.below(3) == 0 {
            point = point.with_straight_section();
        }
        if numbers.below(4) == 0 {
            point = point.with_blend(numbers.positive());
        }
        points.push(point);
    }
    points
}

/// Limits of the joints of the CR7: such as arms have, or any.
fn joint_limits(arm: &ParallelAxisArm, numbers: &mut Numbers<'_>) -> Option<JointLimits<6>> {
    let mut rates = [1.0, 10.0, 100.0].map(|size| Joints::repeat(size * (0.2 + 4.0 * numbers.unit())));
    if numbers.hostile() {
        rates = [(); 3].map(|()| Joints::from_fn(|_, _| numbers.positive()));
    }
    arm.range().with_rates(rates[0], rates[1], rates[2]).ok()
}

/// A joint value: some within an arm's range, some anywhere.
fn joint_value(numbers: &mut Numbers<'_>) -> f64 {
    if numbers.hostile() { numbers.value() } else { numbers.unit().mul_add(3.0, -1.5) }
}

/// Plans along a path, and holds what comes out against the limits of the joints.
fn plan<'p>(
    planner: Planner<'p, 6>,
    path: Arc<dyn MotionPath<6> + 'p>,
    limits: &JointLimits<6>,
    numbers: &mut Numbers<'_>,
) -> Verdict {
    let method = Method::ALL[numbers.below(Method::ALL.len())];
    let trajectory = match planner.with_method(method).plan_shared(path) {
        Ok(trajectory) => trajectory,
        Err(error) if error.to_string().is_empty() => return broken("an error without words"),
        Err(_) => return Verdict::Refused,
    };
    let duration = trajectory.duration();
    if !(duration.is_finite() && duration >= 0.0) {
        return broken(format!("a duration of {duration}"));
    }
    let Ok(mut setpoints) = trajectory.setpoints(duration.max(1e-3) / 64.0) else { return Verdict::Refused };
    for i in 0..=64 {
        let point = match setpoints.at(duration * f64::from(i) / 64.0) {
            Ok(point) => point,
            Err(error) => return broken(format!("verified, but no setpoint {i}: {error}")),
        };
        for k in 0..6 {
            let rates = [(point.qd[k], limits.velocity()[k]), (point.qdd[k], limits.acceleration()[k])];
            let (low, high) = (limits.lower()[k], limits.upper()[k]);
            let inside = (low - 1e-9..=high + 1e-9).contains(&point.q[k]);
            if !inside || rates.iter().any(|(value, limit)| value.is_nan() || value.abs() > limit * (1.0 + 1e-6)) {
                return broken(format!("{method}: joint {k} leaves its limits in setpoint {i}: {point:?}"));
            }
        }
    }
    Verdict::Accepted
}

/// A spline of the joints.
pub(super) fn joint_spline(bytes: &[u8]) -> Verdict {
    let numbers = &mut Numbers::new(bytes);
    let arm = models::cr7();
    let Some(limits) = joint_limits(&arm, numbers) else { return Verdict::Refused };
    let count = 2 + numbers.below(5);
    let points: Vec<Joints<6>> = (0..count).map(|_| Joints::from_fn(|_, _| joint_value(numbers))).collect();
    let Ok(spline) = JointSpline::through(&points) else { return Verdict::Refused };
    plan(Planner::new(&arm, Limits::new(limits)), Arc::new(spline), &limits, numbers)
}

fn rotation(numbers: &mut Numbers<'_>) -> UnitQuaternion<f64> {
    let angles = numbers.values::<3>();
    UnitQuaternion::from_euler_angles(angles[0], angles[1], angles[2])
}

/// A pose: of the arm somewhere, or any.
fn pose(arm: &ParallelAxisArm, numbers: &mut Numbers<'_>) -> Isometry3<f64> {
    if numbers.below(4) == 0 {
        return Isometry3::from_parts(Vector3::from(numbers.values()).into(), rotation(numbers));
    }
    arm.forward(&Joints::from_fn(|_, _| joint_value(numbers)))
}

/// A motion between two poses.
pub(super) fn pose_move(bytes: &[u8]) -> Verdict {
    let numbers = &mut Numbers::new(bytes);
    let arm = models::cr7();
    let Some(limits) = joint_limits(&arm, numbers) else { return Verdict::Refused };
    let start = pose(&arm, numbers);
    let goal = match numbers.below(3) {
        0 => pose(&arm, numbers),
        // A small move succeeds more often.
        _ => {
            let way = Vector3::from_fn(|_, _| 0.2 * numbers.unit() - 0.1);
            Isometry3::from_parts((start.translation.vector + way).into(), start.rotation)
        }
    };
    let Ok(motion) = PoseMotion::new(&start, &goal) else { return Verdict::Refused };
    let Ok(path) = PoseMove::new(&arm, motion, limits.range()) else { return Verdict::Refused };
    plan(Planner::new(&arm, Limits::new(limits)), Arc::new(path), &limits, numbers)
}

fn tool_limits(numbers: &mut Numbers<'_>) -> Option<ToolLimits> {
    let mut limit =
        |usual: f64| if numbers.hostile() { numbers.positive() } else { usual * (0.1 + 2.0 * numbers.unit()) };
    ToolLimits::new()
        .with_feed(limit(0.1))
        .and_then(|tool| tool.with_tangential_acceleration(limit(1.0)))
        .and_then(|tool| tool.with_tangential_jerk(limit(30.0)))
        .and_then(|tool| tool.with_normal_acceleration(limit(1.0)))
        .ok()
}

/// A curve of the tool: any knots, weights and control points.
pub(super) fn tool_path(bytes: &[u8]) -> Verdict {
    let numbers = &mut Numbers::new(bytes);
    let arm = models::cr7();
    let (Some(limits), Some(tool)) = (joint_limits(&arm, numbers), tool_limits(numbers)) else {
        return Verdict::Refused;
    };
    let (degree, spans) = (1 + numbers.below(5), 1 + numbers.below(6));
    let mut knots = vec![0.0; degree + 1];
    let mut last = 0.0;
    for _ in 1..spans {
        last += if numbers.below(5) == 0 { 0.0 } else { 0.1 + numbers.unit() };
        knots.push(last);
    }
    knots.extend(std::iter::repeat_n(last + 1.0, degree + 1));
    let count = degree + spans;
    let size = 0.001 + 0.1 * numbers.unit();
    let centre = Vector3::new(0.4, 0.0, 0.25);
    let place = |numbers: &mut Numbers<'_>| match numbers.hostile() && numbers.below(4) == 0 {
        true => Vector3::from(numbers.values()),
        false => centre + Vector3::from_fn(|_, _| size * (2.0 * numbers.unit() - 1.0)),
    };
    let points: Vec<Vector3<f64>> = (0..count).map(|_| place(numbers)).collect();
    let weights = (0..count).map(|_| if numbers.below(4) == 0 { numbers.positive() } else { 1.0 }).collect();
    let Ok(curve) = NurbsCurve::new(degree, points, weights, knots) else { return Verdict::Refused };
    let Ok(curve) = ArcLengthCurve::new(curve, 1e-12) else { return Verdict::Refused };
    let down = UnitQuaternion::from_euler_angles(std::f64::consts::PI, 0.0, 0.0);
    let path = PosePath::new(curve, OrientationPath::Constant(down));
    let Ok(path) = ToolPath::new(&arm, path, limits.range()) else { return Verdict::Refused };
    plan(Planner::new(&arm, Limits::new(limits).with_tool(tool)), Arc::new(path), &limits, numbers)
}

/// A whole job, from its text to its report.
pub(super) fn job_plan(bytes: &[u8]) -> Verdict {
    let Ok(text) = std::str::from_utf8(bytes) else { return Verdict::Refused };
    let result = BatchItem::from_line(text, 1, Path::new("jobs.jsonl")).run(None);
    match (result.error, result.duration_s, result.worst_ratio) {
        (Some(error), ..) if error.contains("a defect of this program") => broken(error),
        (Some(_), ..) => Verdict::Refused,
        (None, Some(duration), Some(ratio)) if duration.is_finite() && ratio <= 1.0 + 1e-6 => Verdict::Accepted,
        (None, duration, ratio) => broken(format!("a motion of {duration:?} s at {ratio:?} of its limits")),
    }
}
