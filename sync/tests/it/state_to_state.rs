//! Several axes from state to state: reference durations, common arrival, straight lines, control cycles, refusals.
#![allow(clippy::unwrap_used)]
use arcfeed_sync::feedrate::{AxisLimits, AxisProblem, AxisState, FeedError, MotionLaw};
use arcfeed_sync::{MotionOptions, SyncError, Synchronisation, Trajectory};

use crate::common;
use arcfeed_testing::Random;
use common::{Problem, check, moving_problem};

struct Reference {
    problem: Problem<6>,
    family: String,
    outside: bool,
    duration: f64,
    range: (f64, f64),
    blocked: bool,
}

fn references() -> Vec<Reference> {
    let text = include_str!("../fixtures/state_to_state.txt");
    let (mut family, mut outside, mut all) = (String::new(), false, Vec::new());
    for line in text.lines().filter(|l| !l.starts_with('#')) {
        if let Some(head) = line.strip_prefix("> ") {
            family = head.split(' ').next().unwrap().into();
            outside = head.ends_with(" outside");
            continue;
        }
        let parts: Vec<Vec<&str>> = line.split(';').map(|p| p.split(' ').collect()).collect();
        let x = |k: usize, i: usize| parts[k][i].parse::<f64>().unwrap();
        let lower = |k: usize, i: usize| if parts[k][i] == "-" { -x(k, i - 1) } else { x(k, i) };
        let problem = Problem {
            start: std::array::from_fn(|k| AxisState::new(x(k, 0), x(k, 1), x(k, 2))),
            target: std::array::from_fn(|k| AxisState::new(x(k, 3), x(k, 4), x(k, 5))),
            limits: std::array::from_fn(|k| {
                let pair = |i| (lower(k, i + 1), x(k, i));
                AxisLimits::new(pair(6), pair(8), (-x(k, 10), x(k, 10))).unwrap()
            }),
        };
        all.push(Reference {
            problem,
            family: family.clone(),
            outside,
            duration: x(6, 0),
            range: (x(6, 1), x(6, 2)),
            blocked: parts[6][3] == "1",
        });
    }
    all
}

#[test]
fn reference_durations() {
    let mut failures = Vec::new();
    let (mut shorter, mut blocked) = (0, 0);
    let all = references();
    for (i, r) in all.iter().enumerate() {
        let name = format!("{} {i}", r.family);
        let motion = match r.problem.solve(Synchronisation::Time) {
            Ok(m) => m,
            Err(e) => {
                failures.push(format!("{name}: {e}"));
                continue;
            }
        };
        let tolerance = 1e-9 + 1e-7 * r.duration;
        let (lo, hi) = (r.range.0 - tolerance, r.range.1 + tolerance);
        let t = motion.duration();
        shorter += usize::from(t < lo && r.outside);
        blocked += usize::from(r.blocked);
        if let Err(text) = check(&r.problem, &motion) {
            failures.push(format!("{name}: {text}"));
        } else if t > hi || (t < lo && !r.outside) {
            failures.push(format!("{name}: {t} instead of {} ({})", r.duration, r.blocked));
        }
    }
    println!("{} references, {blocked} blocked, {shorter} shorter than the reference", all.len());
    assert!(failures.is_empty(), "{} failures: {:#?}", failures.len(), &failures[..failures.len().min(10)]);
}

/// Liu et al. 2024, Table 4: six joints with limits 10 rad/s, 100 rad/s², 1000 rad/s³.
#[test]
fn published_execution_times() {
    let limits = [AxisLimits::symmetric(10.0, 100.0, 1000.0).unwrap(); 6];
    let states = |p: [f64; 6], v: [f64; 6], a: [f64; 6]| std::array::from_fn(|k| AxisState::new(p[k], v[k], a[k]));
    let start =
        states([0.0, -2.0, 3.0, -4.0, 5.0, 1.0], [0.0, -4.0, 3.0, -2.0, 0.0, 3.0], [0.0, 1.0, -2.0, 3.0, 5.0, -2.0]);
    let target =
        states([4.0, -6.0, 10.0, 2.0, 0.0, -5.0], [0.0, 6.0, 7.0, -5.0, -6.0, -8.0], [0.0, 2.0, -3.0, -1.0, 4.0, 0.0]);
    let problem = Problem { start, target, limits };
    let alone = problem.solve(Synchronisation::None).unwrap();
    for (axis, printed) in alone.axes().iter().zip([0.6000, 0.6519, 0.7756, 0.9145, 0.6290, 0.7559]) {
        assert!((axis.duration() - printed).abs() <= 0.5e-4, "{} {printed}", axis.duration());
    }
    let together = problem.solve(Synchronisation::Time).unwrap();
    check(&problem, &together).unwrap();
    assert!((together.duration() - 0.914486).abs() < 1e-6);
    assert!(together.axes().iter().all(|a| a.duration() == together.duration()));
}

#[test]
fn random_problems_arrive_together() {
    let mut rng = Random::new(41);
    for i in 0..20_000 {
        let problem = moving_problem::<4>(&mut rng, 0.7);
        let motion = problem.solve(Synchronisation::Time).unwrap_or_else(|e| panic!("case {i}: {e}: {problem:?}"));
        check(&problem, &motion).unwrap_or_else(|e| panic!("case {i}: {e}: {problem:?}"));
        assert!(motion.axes().iter().all(|a| a.duration() == motion.duration()));
        let alone = problem.solve(Synchronisation::None).unwrap();
        assert!(alone.duration() <= motion.duration());
        // No earlier common duration: one axis needs that long, or ends a blocked interval there.
        let binding = (0..4).any(|k| {
            let d = AxisProblem::new(&problem.start[k], &problem.target[k], &problem.limits[k]).unwrap().durations();
            d.shortest() == motion.duration() || d.blocked().iter().any(|b| b.1 == motion.duration())
        });
        assert!(binding, "case {i}: {problem:?}");
    }
}

#[test]
fn duration_is_a_multiple_of_the_cycle_and_not_below_the_least() {
    let mut rng = Random::new(42);
    for i in 0..5000 {
        let problem = moving_problem::<3>(&mut rng, 0.8);
        let cycle = rng.log(1e-4, 0.1);
        let least = if rng.unit() < 0.5 { rng.between(0.0, 10.0) } else { 0.0 };
        for mode in [Synchronisation::None, Synchronisation::Time] {
            let options = MotionOptions::new(mode).with_cycle(cycle).unwrap().with_least_duration(least).unwrap();
            let motion = Trajectory::new(&problem.start, &problem.target, &problem.limits, &options).unwrap();
            check(&problem, &motion).unwrap_or_else(|e| panic!("case {i}: {e}: {problem:?} {options:?}"));
            for axis in motion.axes() {
                assert_eq!((axis.duration() / cycle).round() * cycle, axis.duration());
                assert!(axis.duration() >= least);
            }
            // Any earlier multiple is impossible for one of the axes.
            if mode == Synchronisation::Time {
                let earlier = ((motion.duration() / cycle).round() - 1.0) * cycle;
                let possible = (0..3).all(|k| {
                    let p = AxisProblem::new(&problem.start[k], &problem.target[k], &problem.limits[k]).unwrap();
                    p.durations().contains(earlier)
                });
                assert!(earlier < least || !possible, "case {i}: {problem:?} {options:?}");
            }
        }
    }
}

/// Starts so far outside the limits that the way back takes more than 2^53 cycles, where the next multiple of the cycle is no other
/// number: the duration was rounded down, and tried until the motion was refused as not representable.
#[test]
fn more_cycles_than_numbers_can_count() {
    let asymmetric = |v, a, j| AxisLimits::new(v, a, j).unwrap();
    let cases = [
        (
            AxisState::new(196.50991985591324, 2049.667976032321, 10732.557350999641),
            0.20542918120663067,
            AxisLimits::symmetric(0.126455534280041, 0.777992151724994, 2.2058694310355427).unwrap(),
            1e-3,
        ),
        (
            AxisState::new(-10618.182111046339, -16577.738627866165, -12939.160034652481),
            -0.9834201099053872,
            asymmetric(
                (-0.03658653447034571, 0.04519111737496433),
                (-7007.344555634209, 6365.596064913367),
                (-2.545376821429532, 1.1501436924562656),
            ),
            1e-3,
        ),
        (
            AxisState::new(-148.0731917930151, -3161.4971368481874, -33947.53482580323),
            -0.28459758682723946,
            asymmetric(
                (-0.026024325998462938, 0.016276131641911808),
                (-1.056438530313729, 1.6800140368793741),
                (-16.4880301335024, 7.168323754637861),
            ),
            1e-3,
        ),
        (
            AxisState::new(-179847.54122827703, -73102.68558906796, -14854.311462014655),
            0.6500785453084355,
            AxisLimits::symmetric(0.007865241818031204, 17767.661748913073, 1.243118707550245).unwrap(),
            0.008,
        ),
        (
            AxisState::new(-25623.042148257944, -15526.710521316269, -4703.644338649821),
            1.1608921802972678,
            AxisLimits::symmetric(0.0018002534099585442, 2362.366952533289, 0.3749518070262952).unwrap(),
            0.004,
        ),
    ];
    for (i, (start, goal, limits, cycle)) in cases.into_iter().enumerate() {
        let target = AxisState::rest(goal);
        let shortest = AxisProblem::new(&start, &target, &limits).unwrap().shortest_duration();
        assert!(shortest > 9e15 * cycle, "case {i}: {shortest}");
        for mode in [Synchronisation::None, Synchronisation::Time] {
            let options = MotionOptions::new(mode).with_cycle(cycle).unwrap();
            let motion =
                Trajectory::new(&[start], &[target], &[limits], &options).unwrap_or_else(|e| panic!("{i}: {e}"));
            assert!((shortest..=shortest * (1.0 + 1e-15)).contains(&motion.duration()), "case {i}: {shortest}");
        }
    }
    // A number of cycles that is none.
    let options = MotionOptions::default().with_cycle(1e-300).unwrap();
    let limits = [AxisLimits::symmetric(1.0, 1.0, 1.0).unwrap()];
    let far = Trajectory::new(&[AxisState::rest(0.0)], &[AxisState::rest(1e15)], &limits, &options).unwrap();
    assert_eq!(far.duration(), 1e15 + 2.0);
}

/// Both states of every axis in proportion to those of the first.
fn on_a_line(rng: &mut Random, moving: f64) -> Problem<4> {
    let mut p = moving_problem::<4>(rng, moving);
    let (s, t) = (p.start[0], p.target[0]);
    for k in 1..4 {
        let r = rng.between(-1.0, 1.0);
        let from = p.start[k].p;
        p.start[k] = AxisState::new(from, r * s.v, r * s.a);
        p.target[k] = AxisState::new(from + r * (t.p - s.p), r * t.v, r * t.a);
        // Wide enough for the states in proportion.
        let l = p.limits[0];
        let w = rng.log(1.0, 3.0);
        p.limits[k] = AxisLimits::symmetric(
            w * l.v_max().max(-l.v_min()),
            w * l.a_max().max(-l.a_min()),
            w * l.j_max().max(-l.j_min()),
        )
        .unwrap();
    }
    p
}

#[test]
fn straight_whenever_the_states_lie_on_a_line() {
    let mut rng = Random::new(43);
    for i in 0..5000 {
        let problem = on_a_line(&mut rng, if i % 2 == 0 { 0.0 } else { 1.0 });
        for mode in [Synchronisation::StraightLine, Synchronisation::ForcedStraight] {
            let motion = problem.solve(mode).unwrap_or_else(|e| panic!("case {i}: {e}: {problem:?}"));
            assert!(motion.is_straight());
            check(&problem, &motion).unwrap_or_else(|e| panic!("case {i}: {e}: {problem:?}"));
            let way = |k: usize| problem.target[k].p - problem.start[k].p;
            for n in 0..=50 {
                let s = motion.at(motion.duration() * f64::from(n) / 50.0);
                for k in 1..4 {
                    let off = (s.q[k] - problem.start[k].p) * way(0) - (s.q[0] - problem.start[0].p) * way(k);
                    let size: f64 = (s.q[k].abs() + 3.0) * way(0).abs() + (s.q[0].abs() + 3.0) * way(k).abs();
                    // The direction of the way has the round-off of the positions, and states that move lead far beyond its ends.
                    let far = (s.q[k] - problem.start[k].p).abs() + (s.q[0] - problem.start[0].p).abs();
                    let blur = 3.0 * f64::EPSILON * far;
                    assert!(off.abs() <= 1e-13 * size + blur, "case {i}: {off:e}: {problem:?}");
                }
            }
            let together = problem.solve(Synchronisation::Time).unwrap();
            assert!(together.duration() <= motion.duration() * (1.0 + 1e-12), "case {i}: {problem:?}");
        }
        // Rest to rest is straight from anywhere to anywhere.
        let anywhere = moving_problem::<4>(&mut rng, 0.0);
        assert!(anywhere.solve(Synchronisation::ForcedStraight).unwrap().is_straight());
    }
}

#[test]
fn what_is_not_on_a_line_is_synchronised_by_time_or_refused() {
    let mut rng = Random::new(44);
    for _ in 0..500 {
        let mut problem = on_a_line(&mut rng, 1.0);
        problem.target[2].v = 0.5 * problem.target[2].v + 0.01 * problem.limits[2].v_max();
        let straight = problem.solve(Synchronisation::StraightLine).unwrap();
        assert!(!straight.is_straight());
        assert_eq!(straight, problem.solve(Synchronisation::Time).unwrap());
        let refused = problem.solve(Synchronisation::ForcedStraight).unwrap_err();
        assert!(matches!(refused, SyncError::NotStraight { axis: 0..4 }), "{refused}");
    }
}

#[test]
fn an_early_axis_goes_on_with_its_velocity() {
    let limits = [AxisLimits::symmetric(2.0, 5.0, 50.0).unwrap(); 2];
    let start = [AxisState::rest(0.0); 2];
    let target = [AxisState::new(0.2, 0.5, 0.0), AxisState::rest(3.0)];
    let motion = Problem { start, target, limits }.solve(Synchronisation::None).unwrap();
    let early = motion.axes()[0].duration();
    assert!(early < motion.duration());
    let s = motion.at(early + 0.1);
    assert!((s.q[0] - 0.25).abs() < 1e-15 && s.qd[0] == 0.5 && s.qdd[0] == 0.0);
}

#[test]
fn the_sampler_changes_nothing() {
    let mut rng = Random::new(45);
    for _ in 0..200 {
        let motion = moving_problem::<3>(&mut rng, 0.8).solve(Synchronisation::Time).unwrap();
        let mut sampler = motion.sampler();
        for _ in 0..50 {
            let t = rng.between(-0.1, 1.2) * motion.duration();
            assert_eq!(sampler.at(t), motion.at(t));
        }
    }
}

#[test]
fn refusals_name_the_axis() {
    let limits = [AxisLimits::symmetric(1.0, 1.0, 1.0).unwrap(); 3];
    let start = [AxisState::rest(0.0); 3];
    let mut target = [AxisState::rest(1.0); 3];
    for mode in
        [Synchronisation::None, Synchronisation::Time, Synchronisation::StraightLine, Synchronisation::ForcedStraight]
    {
        target[1] = AxisState::rest(f64::NAN);
        let e = Problem { start, target, limits }.solve(mode).unwrap_err();
        let named = matches!(e, SyncError::State { axis: 1, source: FeedError::NotFinite { what: "target.p", .. } });
        assert!(named || matches!(e, SyncError::NotStraight { .. }), "{mode:?}: {e}");
        target[1] = AxisState::rest(1.0);
        target[2] = AxisState::new(1.0, 1.5, 0.0);
        let e = Problem { start, target, limits }.solve(mode).unwrap_err();
        let named = matches!(e, SyncError::State { axis: 2, source: FeedError::TargetOutside { what: "v", .. } });
        assert!(named || matches!(e, SyncError::NotStraight { .. }), "{mode:?}: {e}");
        target[2] = AxisState::rest(1.0);
    }
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(MotionOptions::default().with_cycle(bad), Err(SyncError::Cycle { .. })));
    }
    for bad in [-1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(MotionOptions::default().with_least_duration(bad), Err(SyncError::Duration { .. })));
    }
}
