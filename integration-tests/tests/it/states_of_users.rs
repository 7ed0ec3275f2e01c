//! States and limits that users of ruckig reported, because there was no motion or a wrong one: each has a motion, judged by differences of
//! its positions alone.
//!
//! Origin: issues of pantor/ruckig, named in the data. Only numbers are taken.

use arcfeed_feedrate::{AxisLimits, AxisState, MotionLaw, StateToState};
use arcfeed_sync::{MotionOptions, OnlineGenerator, Synchronisation, Trajectory};
use serde::Deserialize;

const CASES: &str = include_str!("../data/ruckig_issues.json");
const STEPS: usize = 4000;

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

/// Positions at even times, axis by axis, and the time between two.
struct Positions {
    axes: Vec<Vec<f64>>,
    step: f64,
}

fn cases() -> File {
    serde_json::from_str(CASES).expect("valid cases")
}

fn states<const N: usize>(numbers: &[Vec<f64>; 3]) -> [AxisState; N] {
    std::array::from_fn(|k| AxisState::new(numbers[0][k], numbers[1][k], numbers[2][k]))
}

fn motion<const N: usize>(case: &Case) -> Result<Positions, String> {
    let limits: [AxisLimits; N] =
        std::array::from_fn(|k| AxisLimits::symmetric(case.v[k], case.a[k], case.j[k]).expect("above 0"));
    let (start, target) = (states::<N>(&case.start), states::<N>(&case.target));
    if case.interface.is_some() {
        let one = |k: usize| StateToState::to_velocity(&start[k], target[k].v, target[k].a, &limits[k]);
        let motions = (0..N).map(one).collect::<Result<Vec<_>, _>>().map_err(|error| error.to_string())?;
        let duration = motions.iter().map(MotionLaw::duration).fold(0.0, f64::max);
        return Ok(positions(duration, N, |t, k| motions[k].at(t).p));
    }
    let options = MotionOptions::new(Synchronisation::Time);
    let options = case.cycle.map_or(Ok(options), |cycle| options.with_cycle(cycle)).expect("a cycle");
    let motion = Trajectory::new(&start, &target, &limits, &options).map_err(|error| error.to_string())?;
    if let Some(cycle) = case.cycle {
        let cycles = motion.duration() / cycle;
        assert!((cycles - cycles.round()).abs() < 1e-9, "issue {}: {cycles} cycles", case.issue);
    }
    Ok(positions(motion.duration(), N, |t, k| motion.at(t).q[k]))
}

fn positions(duration: f64, axes: usize, at: impl Fn(f64, usize) -> f64) -> Positions {
    let step = duration / STEPS as f64;
    let axis = |k| (0..=STEPS).map(|i| at(i as f64 * step, k)).collect();
    Positions { axes: (0..axes).map(axis).collect(), step }
}

/// What the differences of one axis exceed, or where it does not begin and end as told.
fn fault(case: &Case, k: usize, q: &[f64], step: f64) -> Option<String> {
    let [start, target] = [&case.start, &case.target].map(|s| [s[0][k], s[1][k], s[2][k]]);
    let size = q.iter().fold(0.0, |size: f64, q| size.max(q.abs()));
    // A state outside the limits is brought back inside, and its acceleration cannot end at once.
    let outward = start[2] * start[2] / (2.0 * case.j[k]) * if start[1] * start[2] > 0.0 { 1.0 } else { 0.0 };
    let limits = [case.v[k].max(start[1].abs() + outward), case.a[k].max(start[2].abs()), case.j[k]];
    let mut differences = q.to_vec();
    for (order, limit) in limits.iter().enumerate() {
        differences = differences.windows(2).map(|w| (w[1] - w[0]) / step).collect();
        let rounding = f64::powi(2.0, order as i32 + 2) * f64::EPSILON * size / step.powi(order as i32 + 1);
        let worst = differences.iter().fold(0.0, |worst: f64, d| worst.max(d.abs()));
        if worst > limit * (1.0 + 1e-7) + rounding {
            return Some(format!("difference {} is {worst}, limit {limit}", order + 1));
        }
    }
    let ends = |at: f64, place: f64| (at - place).abs() <= 1e-9 * (1.0 + place.abs());
    let speed = |from: usize| (q[from + 1] - q[from]) / step;
    let near = |v: f64, goal: f64| (v - goal).abs() <= limits[1] * step + 4.0 * f64::EPSILON * size / step;
    if !ends(q[0], start[0]) || !near(speed(0), start[1]) {
        return Some(format!("begins at {} with {}", q[0], speed(0)));
    }
    let placed = case.interface.is_some() || ends(q[STEPS], target[0]);
    (!placed || !near(speed(STEPS - 1), target[1])).then(|| format!("ends at {} with {}", q[STEPS], speed(STEPS - 1)))
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
            (None, Ok(Positions { axes, step })) => {
                for (k, q) in axes.iter().enumerate() {
                    if let Some(fault) = fault(&case, k, q, step) {
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

/// A velocity limit that is lowered on the way: the axis slows down to it, and neither falls below it nor turns back before it brakes
/// for the target (issue 146).
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
    // Braking from the lower limit to rest takes v / a + a / j at most, and as many cycles before the end it has not begun.
    let braking = ((case.lowered / case.a + case.a / case.j) / case.cycle).ceil() as usize + 2;
    assert!((q[q.len() - 1] - case.target).abs() < 1e-12 && v.iter().all(|v| *v >= -1e-9), "turns back");
    assert!(v[lowered..met].windows(2).all(|w| w[1] <= w[0] + 1e-3), "slows down in one go");
    // The motion lasts whole cycles, and is slower than the limit by a part of one of them in all.
    let slower = 1.0 / (v.len() - braking - met) as f64;
    for (i, v) in v.iter().enumerate().take(v.len() - braking).skip(met) {
        let share = v / case.lowered;
        assert!((1.0 - slower..=1.0 + 1e-9).contains(&share), "cycle {i} of {}: {v}", q.len());
    }
}
