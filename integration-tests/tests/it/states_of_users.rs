//! States and limits that users of ruckig reported, because there was no motion or a wrong one: each has a motion,
//! judged by differences of its positions alone.
//!
//! Origin: issues of pantor/ruckig, named in the data. Only numbers are taken.

use arcfeed_feedrate::{AxisLimits, AxisState, MotionLaw, StateToState};
use arcfeed_sync::{MotionOptions, OnlineGenerator, Synchronisation, Trajectory};
use serde::Deserialize;

const CASES: &str = include_str!("../data/ruckig_issues.json");
/// Steps of the whole motion.
const STEPS: usize = 4000;
/// Windows of the motion, from its start to its end, and the steps of each.
const WINDOWS: usize = 21;
const FINE: usize = 400;

#[derive(Deserialize)]
struct File {
    cases: Vec<Case>,
    lowered_velocity: LoweredVelocity,
}

#[derive(Deserialize)]
struct Case {
    issue: u32,
    start: [Vec<f64>; 3],
    target: [Vec<f64>; 3],
    v: Vec<f64>,
    a: Vec<f64>,
    j: Vec<f64>,
    interface: Option<String>,
    cycle: Option<f64>,
    /// What the error says where the target cannot be reached within the limits.
    refused: Option<String>,
}

/// A velocity limit that is lowered on the way.
#[derive(Deserialize)]
struct LoweredVelocity {
    cycle: f64,
    target: f64,
    v: f64,
    a: f64,
    j: f64,
    at: f64,
    lowered: f64,
}

/// Positions of one axis at even times: over the whole motion, and in windows of it.
struct Axis {
    whole: Positions,
    windows: Vec<Positions>,
}

struct Positions {
    q: Vec<f64>,
    step: f64,
}

fn cases() -> File {
    serde_json::from_str(CASES).expect("valid cases")
}

fn states<const N: usize>(numbers: &[Vec<f64>; 3]) -> [AxisState; N] {
    std::array::from_fn(|k| AxisState::new(numbers[0][k], numbers[1][k], numbers[2][k]))
}

fn motion<const N: usize>(case: &Case) -> Result<Vec<Axis>, String> {
    let limits: [AxisLimits; N] =
        std::array::from_fn(|k| AxisLimits::symmetric(case.v[k], case.a[k], case.j[k]).expect("above 0"));
    let (start, target) = (states::<N>(&case.start), states::<N>(&case.target));
    if case.interface.is_some() {
        let one = |k: usize| StateToState::to_velocity(&start[k], target[k].v, target[k].a, &limits[k]);
        let motions = (0..N).map(one).collect::<Result<Vec<_>, _>>().map_err(|error| error.to_string())?;
        let duration = motions.iter().map(MotionLaw::duration).fold(0.0, f64::max);
        return Ok(axes(case, duration, |t, k| motions[k].at(t).p));
    }
    let options = MotionOptions::new(Synchronisation::Time);
    let options = case.cycle.map_or(Ok(options), |cycle| options.with_cycle(cycle)).expect("a cycle");
    let motion = Trajectory::new(&start, &target, &limits, &options).map_err(|error| error.to_string())?;
    if let Some(cycle) = case.cycle {
        let cycles = motion.duration() / cycle;
        assert!((cycles - cycles.round()).abs() < 1e-9, "issue {}: {cycles} cycles", case.issue);
    }
    Ok(axes(case, motion.duration(), |t, k| motion.at(t).q[k]))
}

/// Each window lasts twice as long as an axis takes to its velocity limit.
fn axes(case: &Case, duration: f64, at: impl Fn(f64, usize) -> f64) -> Vec<Axis> {
    let positions = |k: usize, from: f64, lasting: f64, steps: usize| {
        let step = lasting / steps as f64;
        Positions { q: (0..=steps).map(|i| at((from + i as f64 * step).min(duration), k)).collect(), step }
    };
    let axis = |k: usize| {
        let lasting = duration.min(2.0 * (case.v[k] / case.a[k] + case.a[k] / case.j[k]));
        let begin = |i: usize| (duration - lasting) * i as f64 / (WINDOWS - 1) as f64;
        let windows = (0..WINDOWS).map(|i| positions(k, begin(i), lasting, FINE)).collect();
        Axis { whole: positions(k, 0.0, duration, STEPS), windows }
    };
    (0..case.v.len()).map(axis).collect()
}

/// How far rounding of positions may move a difference of this order.
fn rounding(order: i32, Positions { q, step }: &Positions) -> f64 {
    let size = q.iter().fold(0.0, |size: f64, q| size.max(q.abs()));
    f64::powi(2.0, order + 1) * f64::EPSILON * size / step.powi(order)
}

/// The difference that exceeds its limit, of velocity, acceleration and jerk.
fn beyond(limits: [f64; 3], positions: &Positions) -> Option<String> {
    let mut differences = positions.q.clone();
    (1..).zip(limits).find_map(|(order, limit)| {
        differences = differences.windows(2).map(|w| (w[1] - w[0]) / positions.step).collect();
        let worst = differences.iter().fold(0.0, |worst: f64, d| worst.max(d.abs()));
        let exceeded = worst > limit * (1.0 + 1e-7) + rounding(order, positions);
        exceeded.then(|| format!("difference {order} is {worst}, limit {limit}, steps of {} s", positions.step))
    })
}

/// What differs from `state`, in which the positions begin; their velocity and acceleration by differences.
fn begins_elsewhere(state: [f64; 3], jerk: f64, positions: &Positions) -> Option<String> {
    let (Positions { q, step }, [p, v, a]) = (positions, state);
    let near = |is: f64, goal: f64, order: i32, within: f64| {
        let off = (is - goal).abs();
        (off > within * (1.0 + 1e-7) + rounding(order, positions)).then(|| format!("order {order}: {is}, not {goal}"))
    };
    // From the state on the jerk is within its limit: what that adds to the means over one step and over two.
    let (rate, change) = ((q[1] - q[0]) / step, (q[2] - 2.0 * q[1] + q[0]) / (step * step));
    near(q[0], p, 0, 1e-9 * (1.0 + p.abs()))
        .or_else(|| near(rate, v + 0.5 * a * step, 1, jerk * step * step / 6.0))
        .or_else(|| near(change, a, 2, jerk * step))
}

/// What one axis exceeds by differences, or where it does not begin and end as told.
fn fault(case: &Case, k: usize, axis: &Axis) -> Option<String> {
    let [start, target] = [&case.start, &case.target].map(|s| [s[0][k], s[1][k], s[2][k]]);
    // A state outside the limits is brought back inside, and its acceleration cannot end at once.
    let outward = start[2] * start[2] / (2.0 * case.j[k]) * if start[1] * start[2] > 0.0 { 1.0 } else { 0.0 };
    let limits = [case.v[k].max(start[1].abs() + outward), case.a[k].max(start[2].abs()), case.j[k]];
    let exceeded = std::iter::once(&axis.whole).chain(&axis.windows).find_map(|positions| beyond(limits, positions));
    let begin = &axis.windows[0];
    // Backward in time velocities change their sign.
    let last = &axis.windows[WINDOWS - 1];
    let end = Positions { q: last.q.iter().rev().copied().collect(), step: last.step };
    let place = if case.interface.is_some() { end.q[0] } else { target[0] };
    exceeded.or_else(|| begins_elsewhere(start, case.j[k], begin).map(|what| format!("start, {what}"))).or_else(|| {
        let target = [place, -target[1], target[2]];
        begins_elsewhere(target, case.j[k], &end).map(|what| format!("target, backward, {what}"))
    })
}

#[test]
fn every_state_of_a_user_has_a_motion_within_its_limits() {
    for case in cases().cases {
        let motion = match case.v.len() {
            1 => motion::<1>(&case),
            2 => motion::<2>(&case),
            4 => motion::<4>(&case),
            6 => motion::<6>(&case),
            _ => motion::<7>(&case),
        };
        match (&case.refused, motion) {
            (Some(what), Err(text)) => assert!(text.contains(what), "issue {}: {text}", case.issue),
            (Some(_), Ok(_)) => panic!("issue {}: a motion to a target out of reach", case.issue),
            (None, Err(text)) => panic!("issue {}: {text}", case.issue),
            (None, Ok(axes)) => {
                for (k, axis) in axes.iter().enumerate() {
                    if let Some(fault) = fault(&case, k, axis) {
                        panic!("issue {}, axis {}: {fault}", case.issue, k + 1);
                    }
                }
            }
        }
    }
}

/// A unit is a choice: the same motion in units a hundred times as large lasts as long (issue 27: `-9.3e61` s).
#[test]
fn a_unit_does_not_change_the_duration() {
    let case = cases().cases.into_iter().find(|case| case.issue == 27).expect("in the data");
    let duration = |unit: f64| {
        let limits = AxisLimits::symmetric(case.v[0] * unit, case.a[0] * unit, case.j[0] * unit).expect("above 0");
        let [start, target] = [&case.start, &case.target].map(|s| AxisState::rest(s[0][0] * unit));
        StateToState::new(&start, &target, &limits).expect("a motion").duration()
    };
    let known = duration(1.0);
    // Ramps to the velocity limit reach the acceleration limit: distance over v, and one ramp v / a + a / j.
    let closed = 900.0 / 2000.0 + 2000.0 / 18000.0 + 18000.0 / 190_000.0;
    assert!((known / closed - 1.0).abs() < 1e-12, "{known}, {closed}");
    for power in -12..=12 {
        let other = duration(f64::powi(10.0, power));
        assert!((other / known - 1.0).abs() < 1e-9, "unit 1e{power}: {other} s, {known} s");
    }
}

/// A velocity limit that is lowered on the way: the axis slows down to it, and neither falls below it nor turns back
/// before it brakes for the target (issue 146).
#[test]
fn a_lowered_velocity_limit_is_met_from_above() {
    let case = cases().lowered_velocity;
    let limits = |v: f64| [AxisLimits::symmetric(v, case.a, case.j).expect("above 0")];
    let start = [AxisState::rest(0.0)];
    let mut generator =
        OnlineGenerator::new(start, limits(case.v), case.cycle, Synchronisation::Time).expect("a generator");
    generator.set_target([AxisState::rest(case.target)]).expect("a target");
    let (mut q, mut lowered) = (vec![0.0], None);
    loop {
        if lowered.is_none() && (q.len() - 1) as f64 * case.cycle > case.at {
            generator.set_limits(limits(case.lowered)).expect("limits");
            lowered = Some(q.len());
        }
        let step = generator.step();
        q.push(step.state.q[0]);
        if step.events.reached {
            break;
        }
        assert!(q.len() < 100_000, "no end");
    }
    let v: Vec<f64> = q.windows(2).map(|w| (w[1] - w[0]) / case.cycle).collect();
    let lowered = lowered.expect("the motion lasts longer");
    let met = lowered + v[lowered..].iter().position(|v| *v <= case.lowered * (1.0 + 1e-9)).expect("it slows down");
    // Braking from the lower limit to rest takes v / a + a / j at most, and so many cycles before the end it has not
    // begun.
    let braking = ((case.lowered / case.a + case.a / case.j) / case.cycle).ceil() as usize + 2;
    assert!((q[q.len() - 1] - case.target).abs() < 1e-12 && v.iter().all(|v| *v >= -1e-9), "turns back");
    assert!(v[lowered..met].windows(2).all(|w| w[1] <= w[0] + 1e-9), "slows down in one go");
    // The motion lasts whole cycles, and is slower than the limit by a part of one of them in all.
    let slower = 1.0 / (v.len() - braking - met) as f64;
    for (i, v) in v.iter().enumerate().take(v.len() - braking).skip(met) {
        let share = v / case.lowered;
        assert!((1.0 - slower..=1.0 + 1e-9).contains(&share), "cycle {i} of {}: {v}", q.len());
    }
}
