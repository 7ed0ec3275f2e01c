//! The projection synchroniser: every joint limit in every cycle, an exact end, a straight line, and what it costs in time.
#![allow(clippy::unwrap_used)]
use arcfeed_feedrate::{AxisLimits, AxisState, MotionLaw, StateToState};
use arcfeed_sync::nalgebra::SVector;
use arcfeed_sync::{JointState, ProjectionStatus, ProjectionSync, SyncError, symmetric_limits};
use arcfeed_testing::{Random, cases};

const T: f64 = 1e-3;
type V6 = SVector<f64, 6>;

/// Excess over the limits in one cycle, relative: velocity, acceleration, and jerk from the changes of the other three.
///
/// Jerk within its bound confines the change of acceleration, velocity and position over a cycle to known intervals.
fn excess(a: &JointState<6>, b: &JointState<6>, l: &[AxisLimits; 6], h: f64) -> [f64; 3] {
    let mut worst = [0.0f64; 3];
    for (k, l) in l.iter().enumerate() {
        worst[0] = worst[0].max(b.qd[k].abs() / l.v_max() - 1.0);
        worst[1] = worst[1].max(b.qdd[k].abs() / l.a_max() - 1.0);
        let j = l.j_max();
        let round = 4e-15 * (1.0 + a.q[k].abs());
        worst[2] = worst[2].max(((b.qdd[k] - a.qdd[k]).abs() - round * 10.0) / (j * h) - 1.0);
        let dv = b.qd[k] - a.qd[k] - a.qdd[k] * h;
        worst[2] = worst[2].max((dv.abs() - round) / (j * h * h / 2.0) - 1.0);
        let dp = b.q[k] - a.q[k] - a.qd[k] * h - a.qdd[k] * h * h / 2.0;
        worst[2] = worst[2].max((dp.abs() - round) / (j * h * h * h / 6.0) - 1.0);
        worst[2] = worst[2].max(b.qddd[k].abs() / j - 1.0);
    }
    worst
}

struct Case {
    start: JointState<6>,
    target: V6,
    limits: [AxisLimits; 6],
}

/// Limits like a robot's; a start from which no limit has to be broken.
fn random_case(rng: &mut Random) -> Case {
    let velocity = V6::from_fn(|_, _| 1.0 + 3.0 * rng.unit());
    let acceleration = V6::from_fn(|k, _| velocity[k] * (2.0 + 6.0 * rng.unit()));
    let jerk = V6::from_fn(|k, _| acceleration[k] * (5.0 + 20.0 * rng.unit()));
    let mut start = JointState::rest(V6::from_fn(|_, _| 3.0 * rng.signed()));
    for k in 0..6 {
        loop {
            let (v, a) = (velocity[k] * rng.signed(), acceleration[k] * rng.signed());
            if (v + 0.5 * a * a.abs() / jerk[k]).abs() <= velocity[k] {
                (start.qd[k], start.qdd[k]) = (v, a);
                break;
            }
        }
    }
    let target = V6::from_fn(|_, _| 3.0 * rng.signed());
    Case { start, target, limits: symmetric_limits(velocity, acceleration, jerk).unwrap() }
}

/// The longest of the joints' own shortest motions: no synchronised motion is shorter.
fn lower_bound(case: &Case) -> f64 {
    let l = &case.limits;
    (0..6).fold(0.0, |longest, k| {
        let limits = AxisLimits::symmetric(l[k].v_max(), l[k].a_max(), l[k].j_max()).unwrap();
        let start = AxisState::new(case.start.q[k], case.start.qd[k], case.start.qdd[k]);
        StateToState::new(&start, &AxisState::rest(case.target[k]), &limits).unwrap().duration().max(longest)
    })
}

/// Runs to the end; the worst excess, the duration, and whether the state had to be brought inside first.
fn run(case: &Case) -> ([f64; 3], f64, bool) {
    let mut sync = ProjectionSync::new(&case.start, case.target, &case.limits).unwrap();
    let (mut before, mut worst, mut t) = (sync.state(), [-1.0f64; 3], 0.0);
    let mut recovering = false;
    for _ in 0..100_000 {
        let step = sync.step(T).unwrap();
        let unused = if let ProjectionStatus::Reached { unused } = step.status { unused } else { 0.0 };
        recovering |= step.status == ProjectionStatus::Recovering;
        let e = excess(&before, &step.state, &case.limits, T - unused);
        for i in 0..3 {
            worst[i] = worst[i].max(e[i]);
        }
        t += T - unused;
        before = step.state;
        if let ProjectionStatus::Reached { .. } = step.status {
            assert_eq!(step.state, JointState::rest(case.target));
            return (worst, t, recovering);
        }
    }
    panic!("never arrives");
}

fn spread(mut ratios: Vec<f64>) -> (f64, f64) {
    ratios.sort_by(f64::total_cmp);
    (ratios[ratios.len() / 2], ratios[ratios.len() - 1])
}

/// What it costs against the time-optimal bound: from a start at rest, in motion, and in motion close to the target.
#[test]
fn limits_hold_from_random_starts() {
    let mut rng = Random::new(3);
    let (mut rest, mut moving, mut close, mut recovered) = (Vec::new(), Vec::new(), Vec::new(), 0);
    for i in 0..600 {
        let mut case = random_case(&mut rng);
        match i % 3 {
            0 => case.start = JointState::rest(case.start.q),
            1 => {}
            _ => case.target = case.start.q + 0.05 * case.target,
        }
        let (worst, t, recovering) = run(&case);
        assert!(
            worst.iter().all(|&x| x <= 1e-9),
            "case {i}: {worst:?} {:?} {:?} {:?}",
            case.start,
            case.target,
            case.limits
        );
        recovered += usize::from(recovering);
        let ratio = t / lower_bound(&case);
        assert!(ratio >= 1.0 - 1e-12, "case {i}: {ratio}");
        [&mut rest, &mut moving, &mut close][i % 3].push(ratio);
    }
    let (rest, moving, close) = (spread(rest), spread(moving), spread(close));
    println!("median and worst: at rest {rest:.3?}, moving {moving:.3?}, close {close:.3?}; {recovered} recovered");
    assert!(rest.0 < 1.01 && rest.1 < 1.15, "{rest:?}");
    assert!(moving.0 < 1.08 && moving.1 < 1.5, "{moving:?}");
    assert!(close.0 < 1.6 && close.1 < 3.0, "{close:?}");
    assert!(recovered < 100, "{recovered}");
}

/// A target that changes in every cycle, jumps now and then, and comes to rest at last.
#[test]
fn limits_hold_while_the_target_moves() {
    let mut rng = Random::new(8);
    for i in cases(5) {
        let case = random_case(&mut rng);
        let mut sync = ProjectionSync::new(&case.start, case.target, &case.limits).unwrap();
        let (mut before, mut target) = (sync.state(), case.target);
        let drift = V6::from_fn(|_, _| 0.5 * T * rng.signed());
        let mut done = false;
        let mut longest_rest = 0;
        for cycle in 0..8000 {
            if cycle < 1500 {
                target += drift;
                if rng.unit() < 0.01 {
                    target[(rng.unit() * 6.0) as usize] = 3.0 * rng.signed();
                }
                sync.set_target(target).unwrap();
            }
            let step = sync.step(T).unwrap();
            let unused = if let ProjectionStatus::Reached { unused } = step.status { unused } else { 0.0 };
            let e = excess(&before, &step.state, &case.limits, T - unused);
            assert!(e.iter().all(|&x| x <= 1e-9), "run {i} cycle {cycle}: {e:?} {before:?} {:?}", step.state);
            longest_rest = if step.state.qd.amax() < 1e-3 { longest_rest + 1 } else { 0 };
            assert!(longest_rest < 50 || cycle > 1500, "run {i} cycle {cycle}: does not follow");
            before = step.state;
            done = matches!(step.status, ProjectionStatus::Reached { .. });
            if done && cycle >= 1500 {
                break;
            }
        }
        assert!(done && sync.state() == JointState::rest(target), "run {i}");
    }
}

/// Following a target that moves at constant velocity costs no more than a lag.
#[test]
fn a_drifting_target_is_followed() {
    let limits = symmetric_limits(V6::repeat(1.0), V6::repeat(5.0), V6::repeat(50.0)).unwrap();
    let velocity = V6::from([0.3, -0.2, 0.25, 0.1, 0.0, -0.3]);
    let mut sync = ProjectionSync::new(&JointState::rest(V6::zeros()), velocity * T, &limits).unwrap();
    let mut lag = 0.0;
    for cycle in 1..4000 {
        let target = velocity * (T * f64::from(cycle));
        sync.set_target(target).unwrap();
        let state = sync.step(T).unwrap().state;
        lag = (target - state.q).amax();
    }
    assert!(lag < 0.1, "{lag}");
}

fn deviation(sync: &mut ProjectionSync<6>, from: &V6, to: &V6) -> f64 {
    let along = (to - from).normalize();
    let mut worst = 0.0f64;
    for _ in 0..100_000 {
        let step = sync.step(T).unwrap();
        let off = step.state.q - from;
        worst = worst.max((off - along * off.dot(&along)).norm());
        if let ProjectionStatus::Reached { .. } = step.status {
            break;
        }
    }
    worst
}

#[test]
fn straight_from_rest_and_when_moving_along_the_error() {
    let mut rng = Random::new(5);
    for i in 0..40 {
        let mut case = random_case(&mut rng);
        let way = case.target - case.start.q;
        let k = 0.3 * (0..6).fold(f64::INFINITY, |k, i| case.limits[i].v_max().min(k * way[i].abs()) / way[i].abs());
        case.start = JointState::rest(case.start.q);
        if i % 2 == 0 {
            case.start.qd = way * k;
            case.start.qdd = way * (2.0 * k);
        }
        let mut sync = ProjectionSync::new(&case.start, case.target, &case.limits).unwrap();
        let off = deviation(&mut sync, &case.start.q, &case.target);
        assert!(off < 1e-12, "case {i}: {off}");
    }
}

/// Once the transverse part has faded, the rest is a straight line, whatever the start.
#[test]
fn straight_at_last() {
    let mut rng = Random::new(6);
    for i in 0..40 {
        let case = random_case(&mut rng);
        let mut sync = ProjectionSync::new(&case.start, case.target, &case.limits).unwrap();
        while sync.step(T).unwrap().status != ProjectionStatus::Straight {
            if sync.remaining() == Some(0.0) {
                break;
            }
        }
        let from = sync.state().q;
        let off = deviation(&mut sync, &from, &case.target);
        assert!(off < 1e-10, "case {i}: {off}");
    }
}

/// Starts anywhere outside: jerk always, acceleration on the straight way back, velocity by the hardest braking.
#[test]
fn starts_outside_are_brought_inside() {
    let mut rng = Random::new(12);
    for i in 0..200 {
        let mut case = random_case(&mut rng);
        for k in 0..6 {
            case.start.qd[k] = 2.0 * case.limits[k].v_max() * rng.signed();
            case.start.qdd[k] = 2.0 * case.limits[k].a_max() * rng.signed();
        }
        let l = &case.limits;
        let mut sync = ProjectionSync::new(&case.start, case.target, l).unwrap();
        let mut before = sync.state();
        // When braking with all there is brings each velocity inside; it must stay there from the next cycle on.
        let inside: Vec<f64> = (0..6).map(|k| first_inside(case.start.qd[k], case.start.qdd[k], l, k)).collect();
        let mut t = 0.0;
        loop {
            let step = sync.step(T).unwrap();
            let unused = if let ProjectionStatus::Reached { unused } = step.status { unused } else { 0.0 };
            t += T - unused;
            let e = excess(&before, &step.state, l, T - unused);
            assert!(e[2] <= 1e-9, "case {i} jerk {e:?}");
            for (k, &first) in inside.iter().enumerate() {
                let (a, a0, most) = (step.state.qdd[k], before.qdd[k], l[k].a_max());
                let back = (a0.abs() - l[k].j_max() * (T - unused)).max(most);
                assert!(a.abs() <= back * (1.0 + 1e-9), "case {i} joint {k} at {t}: {a} after {a0}, limit {most}");
                let v = step.state.qd[k].abs();
                assert!(
                    v <= l[k].v_max() * (1.0 + 1e-9) || t <= first + 1e-9,
                    "case {i} joint {k} at {t}: {v}, inside from {first}"
                );
            }
            before = step.state;
            if let ProjectionStatus::Reached { .. } = step.status {
                assert_eq!(step.state, JointState::rest(case.target));
                break;
            }
            assert!(t < 100.0);
        }
    }
}

/// By small steps: jerk towards the lowest acceleration, held there; the last time at which the velocity is above its limit.
fn first_inside(v: f64, a: f64, l: &[AxisLimits; 6], k: usize) -> f64 {
    let (most_v, most_a, j) = (l[k].v_max(), l[k].a_max(), l[k].j_max());
    let side = if v.abs() > most_v { v.signum() } else { (v + 0.5 * a * a.abs() / j).signum() };
    let (mut v, mut a, mut t, mut last) = (side * v, side * a, 0.0, 0.0);
    let h = 1e-5;
    while t < 20.0 && (v > most_v || a > 0.0) {
        let step = (-most_a - a).clamp(-j * h, j * h);
        v += h * (a + 0.5 * step);
        a += step;
        t += h;
        if v > most_v {
            last = t;
        }
    }
    last + h
}

/// Liu et al. 2024, table 5: their ideal planner takes 2.930 s, and breaks the limits on the way.
#[test]
fn table_5() {
    let from = V6::from([0.0, -5.0, 3.0, -2.0, 6.0, 0.0]);
    let to = V6::from([-3.0, 3.0, -5.0, 6.0, 5.0, -6.0]);
    // The limits of table 7; no jerk is printed, ten times the acceleration is taken.
    let case = Case { start: JointState::rest(from), target: to, limits: table_7_limits() };
    let (worst, t, _) = run(&case);
    assert!(worst.iter().all(|&x| x <= 1e-9), "{worst:?}");
    assert!(t / lower_bound(&case) < 1.0 + 1e-9, "{t}");
}

fn table_7_limits() -> [AxisLimits; 6] {
    let a = V6::from([10.0, 12.0, 14.0, 16.0, 18.0, 20.0]);
    symmetric_limits(V6::from([6.0, 3.0, 4.0, 5.0, 6.0, 7.0]), a, 10.0 * a).unwrap()
}

/// Liu et al. 2024, table 7. Joint 2 starts at -15 rad/s² with a limit of 12, so that no motion conforms before
/// (15 - 12) / 120 s; everything else does at once.
#[test]
fn table_7() {
    let limits = table_7_limits();
    let start = JointState {
        q: V6::from([0.0, -5.0, 3.0, -2.0, 6.0, 0.0]),
        qd: V6::from([1.0, 2.0, 0.0, 3.0, -4.0, 0.0]),
        qdd: V6::from([10.0, -15.0, 5.0, 0.0, 1.0, 0.0]),
        qddd: V6::zeros(),
    };
    let targets = [
        (0, V6::from([-3.0, 3.0, -5.0, 6.0, 6.0, -6.0])),
        (500, V6::from([6.0, 3.0, 2.0, 6.0, -10.0, -6.0])),
        (1000, V6::from([6.0, -5.0, 2.0, 20.0, -10.0, -1.0])),
        (2000, V6::from([5.0, 10.0, -5.0, 3.0, -6.0, 0.0])),
    ];
    let mut sync = ProjectionSync::new(&start, targets[0].1, &limits).unwrap();
    let (mut before, mut least) = (start, 0.0);
    for cycle in 0..20_000 {
        if let Some(change) = targets.iter().find(|t| t.0 == cycle) {
            sync.set_target(change.1).unwrap();
            least = lower_bound(&Case { start: before, target: change.1, limits });
        }
        let step = sync.step(T).unwrap();
        let unused = if let ProjectionStatus::Reached { unused } = step.status { unused } else { 0.0 };
        let e = excess(&before, &step.state, &limits, T - unused);
        let t = f64::from(cycle + 1) * T;
        assert!(e[0] <= 1e-9 && e[2] <= 1e-9 && (e[1] <= 1e-9 || t < 0.025), "{t}: {e:?}");
        before = step.state;
        if cycle > 2000 && unused > 0.0 {
            assert_eq!(step.state, JointState::rest(targets[3].1));
            // Joint 2 has to go 15 rad at 3 rad/s: no motion from here is shorter than `least`.
            assert!(t - unused <= 2.0 + 1.1 * least, "{t} {least}");
            return;
        }
    }
    panic!("never arrives");
}

#[test]
fn changed_limits_are_returned_to() {
    let mut rng = Random::new(21);
    for i in 0..60 {
        let case = random_case(&mut rng);
        let mut sync = ProjectionSync::new(&case.start, case.target, &case.limits).unwrap();
        for _ in 0..200 {
            sync.step(T).unwrap();
        }
        let f = 0.3 + 0.7 * rng.unit();
        let lower = case.limits.map(|l| AxisLimits::symmetric(f * l.v_max(), f * l.a_max(), l.j_max()).unwrap());
        sync.set_limits(&lower).unwrap();
        let mut before = sync.state();
        let (mut last_above, mut t) = (0.0, 0.0);
        loop {
            let step = sync.step(T).unwrap();
            let unused = if let ProjectionStatus::Reached { unused } = step.status { unused } else { 0.0 };
            let e = excess(&before, &step.state, &lower, T - unused);
            t += T;
            assert!(e[2] <= 1e-9, "case {i}: {e:?}");
            if e[0] > 1e-9 || e[1] > 1e-9 {
                last_above = t;
            }
            before = step.state;
            if let ProjectionStatus::Reached { .. } = step.status {
                break;
            }
        }
        assert!(last_above < 1.5, "case {i}: {last_above}");
    }
}

#[test]
fn other_numbers_of_axes_and_odd_targets() {
    let one = symmetric_limits(SVector::<f64, 1>::repeat(1.0), SVector::repeat(4.0), SVector::repeat(40.0)).unwrap();
    let mut start = JointState::rest(SVector::<f64, 1>::repeat(0.2));
    start.qd[0] = -0.9;
    start.qdd[0] = 1.0;
    // Also the place itself, and next to nothing beside it.
    for target in [0.2, 0.2 + 1e-15, 0.2 - 1e-300, 1e6, -0.5] {
        let mut sync = ProjectionSync::new(&start, SVector::from([target]), &one).unwrap();
        let mut done = false;
        for _ in 0..3_000_000 {
            let step = sync.step(2e-3).unwrap();
            assert!(step.state.qd[0].abs() <= 1.0 + 1e-9 && step.state.qdd[0].abs() <= 4.0 + 1e-8);
            done = matches!(step.status, ProjectionStatus::Reached { .. });
            if done {
                break;
            }
        }
        assert!(done || target == 1e6);
    }
    let at = SVector::<f64, 9>::from_fn(|k, _| k as f64);
    let nine = symmetric_limits(SVector::repeat(1.0), SVector::repeat(4.0), SVector::repeat(40.0)).unwrap();
    let mut sync = ProjectionSync::new(&JointState::rest(at), at, &nine).unwrap();
    assert!(matches!(sync.step(T).unwrap().status, ProjectionStatus::Reached { unused } if unused == T));
}

#[test]
fn refusals_name_the_joint_and_change_nothing() {
    let limits = table_7_limits();
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let rest = JointState::rest(V6::zeros());
        let mut target = V6::zeros();
        target[3] = bad;
        let message = ProjectionSync::new(&rest, target, &limits).unwrap_err().to_string();
        assert!(message.contains("axis 4") && message.contains("target"), "{message}");
        for field in 0..3 {
            let mut start = rest;
            [&mut start.q, &mut start.qd, &mut start.qdd][field][5] = bad;
            let message = ProjectionSync::new(&start, V6::zeros(), &limits).unwrap_err().to_string();
            let name = ["start position", "start velocity", "start acceleration"][field];
            assert!(message.contains("axis 6") && message.contains(name), "{message}");
        }
        let mut sync = ProjectionSync::new(&rest, V6::repeat(1.0), &limits).unwrap();
        assert!(sync.set_target(target).is_err() && sync.target() == &V6::repeat(1.0));
        assert!(matches!(sync.step(bad), Err(SyncError::Period { .. })));
    }
    let mut sync = ProjectionSync::new(&JointState::rest(V6::zeros()), V6::repeat(1.0), &limits).unwrap();
    assert!(sync.step(-1.0).is_err());
}

#[test]
fn any_finite_numbers_are_answered() {
    let mut rng = Random::new(40);
    let special = [0.0, 1.0, 5e-324, 1e-300, 1e300, f64::MAX, f64::MIN_POSITIVE, 1e-9, 1e9];
    let mut any = |signed: bool| {
        let x = match (rng.unit() * 3.0) as u32 {
            0 => special[(rng.unit() * special.len() as f64) as usize],
            1 => f64::from_bits((rng.unit() * 9.2e18) as u64),
            _ => 1e-3 * (rng.unit() * 13.8).exp(),
        };
        if signed && rng.unit() < 0.5 { -x } else { x }
    };
    let mut answered = 0;
    for _ in 0..10_000 {
        let mut vector = |signed| SVector::<f64, 2>::from_fn(|_, _| any(signed));
        let Ok(limits) = symmetric_limits(vector(false), vector(false), vector(false)) else { continue };
        let start = JointState { q: vector(true), qd: vector(true), qdd: vector(true), qddd: SVector::zeros() };
        let Ok(mut sync) = ProjectionSync::new(&start, vector(true), &limits) else { continue };
        answered += 1;
        for _ in 0..4 {
            let h = sync.remaining().map_or(1e-3, |left| 0.3 * left);
            let Ok(step) = sync.step(h) else { continue };
            let s = step.state;
            assert!(
                !(s.q.sum() + s.qd.sum() + s.qdd.sum()).is_nan() || s.q.amax() > 1e300,
                "{start:?} {limits:?} {s:?}"
            );
        }
    }
    assert!(answered > 1000, "{answered}");
}
