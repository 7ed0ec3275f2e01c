//! Motions of a given duration: every duration that is possible is met exactly, the others are refused with the nearest.
#![allow(clippy::unwrap_used, clippy::neg_cmp_op_on_partial_ord)]
use arcfeed_feedrate::{AxisLimits, AxisProblem, AxisState, FeedError, MotionLaw};

use crate::common;
use arcfeed_testing::Random;
use common::axis::{Case, fault, random_case};

/// Durations worth a try: shortest, slightly longer, much longer, both sides of every blocked interval.
fn durations_to_try(rng: &mut Random, problem: &AxisProblem) -> Vec<f64> {
    let durations = problem.durations();
    let t = durations.shortest();
    let mut all = vec![
        t,
        t * (1.0 + 1e-15),
        t * (1.0 + rng.log(1e-12, 1.0)),
        t * (1.0 + rng.log(0.01, 30.0)),
        t + rng.log(1e-6, 10.0),
    ];
    for &(a, b) in durations.blocked() {
        all.extend([a, b, t + (a - t) * rng.unit(), b * (1.0 + rng.log(1e-12, 0.1))]);
    }
    all.retain(|t| durations.contains(*t));
    all
}

#[test]
fn every_possible_duration_is_met() {
    let mut rng = Random::new(21);
    let (mut motions, mut blocked) = (0, [0; 5]);
    for i in 0..60_000 {
        let case = random_case(&mut rng, i % 6 == 5);
        let problem = AxisProblem::new(&case.start, &case.target, &case.limits()).unwrap();
        blocked[problem.durations().blocked().len()] += 1;
        for t in durations_to_try(&mut rng, &problem) {
            let motion = problem
                .with_duration(t)
                .unwrap_or_else(|e| panic!("case {i}: {e}: {case:?} in {t}, {:?}", problem.durations()));
            assert_eq!(motion.duration(), t);
            if let Some(text) = fault(&case, &motion) {
                panic!("case {i}: {text}: {case:?} in {t:?}, {:?}", problem.durations());
            }
            motions += 1;
        }
    }
    println!("{motions} motions; problems by number of blocked intervals: {blocked:?}");
}

#[test]
fn impossible_durations_name_the_nearest() {
    let mut rng = Random::new(22);
    let mut refused = 0;
    for _ in 0..60_000 {
        let case = random_case(&mut rng, false);
        let problem = AxisProblem::new(&case.start, &case.target, &case.limits()).unwrap();
        let durations = problem.durations();
        for &(a, b) in durations.blocked() {
            assert!(durations.shortest() <= a && a < b, "{durations:?}: {case:?}");
            let t = a + (b - a) * rng.unit();
            if !(a < t && t < b) {
                continue;
            }
            match problem.with_duration(t) {
                Err(FeedError::DurationImpossible { duration, below, above }) => {
                    assert_eq!((duration, below, above), (t, Some(a), b));
                    refused += 1;
                }
                other => panic!("{other:?} instead of a refusal of {t} in {durations:?}: {case:?}"),
            }
        }
        let short = 0.999 * durations.shortest();
        if short < durations.shortest() {
            assert!(matches!(problem.with_duration(short), Err(FeedError::DurationImpossible { below: None, .. })));
        }
    }
    assert!(refused > 800, "{refused}");
    let limits = AxisLimits::symmetric(1.0, 1.0, 1.0).unwrap();
    let problem = AxisProblem::new(&AxisState::rest(0.0), &AxisState::rest(1.0), &limits).unwrap();
    assert!(matches!(problem.with_duration(f64::NAN), Err(FeedError::NotFinite { what: "duration", .. })));
    assert!(matches!(problem.with_duration(-1.0), Err(FeedError::DurationImpossible { below: None, .. })));
}

#[test]
fn mirror_and_units_change_nothing() {
    let mut rng = Random::new(23);
    for i in 0..20_000 {
        let case = random_case(&mut rng, i % 4 == 0);
        let problem = |c: &common::axis::Case| AxisProblem::new(&c.start, &c.target, &c.limits()).unwrap();
        let here = problem(&case);
        let mirror = problem(&case.mirrored());
        assert_eq!(here.durations(), mirror.durations(), "{case:?}");
        let (length, time) =
            (2f64.powi((rng.unit() * 400.0) as i32 - 200), 2f64.powi((rng.unit() * 200.0) as i32 - 100));
        let there = problem(&case.scaled(length, time));
        let scaled: Vec<_> = here.durations().blocked().iter().map(|&(a, b)| (a * time, b * time)).collect();
        assert_eq!(scaled, there.durations().blocked(), "{case:?} {length:e} {time:e}");
        for t in durations_to_try(&mut rng, &here) {
            let (Ok(a), Ok(b)) = (here.with_duration(t), there.with_duration(t * time)) else {
                panic!(
                    "{:?} {:?} in {t} of {:?}: {case:?} {length:e} {time:e}",
                    here.with_duration(t),
                    there.with_duration(t * time),
                    here.durations()
                );
            };
            let (s, z) = (a.at(0.3 * t), b.at(0.3 * t * time));
            assert_eq!((s.p * length, s.v * length / time), (z.p, z.v), "{case:?}");
        }
    }
}

/// A problem and a duration.
fn meets(case: Case, t: f64) {
    let problem = AxisProblem::new(&case.start, &case.target, &case.limits()).unwrap();
    assert!(problem.durations().contains(t));
    let motion = problem.with_duration(t).unwrap_or_else(|e| panic!("{e}: {case:?}"));
    assert_eq!(fault(&case, &motion), None);
}

#[test]
fn changes_of_jerk_that_coincide() {
    // The farthest and the least far motion mirror each other and change their phases at the same times but for round-off.
    meets(
        Case {
            start: AxisState::new(0.7450752118122299, 0.0, -0.4733030029363917),
            target: AxisState::new(0.7449136924707555, 0.0, -0.4733030029363917),
            v: (-5.910584261909129, 0.7124145875358869),
            a: (-0.4733030029363917, 0.4733030029363917),
            j: (-0.8240039754160629, 0.8240039754160629),
        },
        2.330781683108013,
    );
}

#[test]
fn jerk_of_half_a_million_million() {
    // A time that is off by its round-off changes the acceleration by 1e-5 under this jerk.
    meets(
        Case {
            start: AxisState::new(-0.7529546930654196, 0.0, -0.031139339726549434),
            target: AxisState::new(-0.7530348659665556, 0.0, -0.006615995340923858),
            v: (-0.9159208184250437, 0.34044565907763247),
            a: (-0.10680124376160477, 0.10680124376160477),
            j: (-584499454811.0502, 584499454811.0502),
        },
        0.05479699857080011,
    );
}

#[test]
fn a_move_of_a_hundred_round_offs() {
    meets(
        Case {
            start: AxisState::new(0.7413287505676165, 0.0, -0.00039837034539402794),
            target: AxisState::new(0.7413287505676073, 0.0, 0.0),
            v: (-0.17806707822506418, 0.1596408526016259),
            a: (-2.653699155294133, 2.653699155294133),
            j: (-68.01325719736538, 68.01325719736538),
        },
        0.00001414064159759503,
    );
}

#[test]
fn a_mean_jerk_beside_one_thousands_of_times_larger_keeps_its_limit() {
    let case = Case {
        start: AxisState::new(0.7555631559620029, -1.4198469278446262, 7.982207113305039),
        target: AxisState::new(0.7555955575676981, 1.3867158516335545, 2.7587713660481876),
        v: (-1.4198469278446262, 1.4198469278446262),
        a: (-0.22221250688338304, 7.982207113305039),
        j: (-66076.66915975732, 1.7725261199938538),
    };
    let problem = AxisProblem::new(&case.start, &case.target, &case.limits()).unwrap();
    for i in 1..2000 {
        let t = problem.shortest_duration() * (1.0 + 1e-3 * f64::from(i));
        if let Ok(motion) = problem.with_duration(t) {
            assert_eq!(fault(&case, &motion), None, "{t}");
        }
    }
}

/// The shortest duration and the first impossible one are 1e-16 s apart, which is the round-off of acceleration over jerk. The farthest
/// motion did not count as lasting one in between.
#[test]
fn durations_closer_than_the_round_off_of_their_phases() {
    let case = Case {
        start: AxisState::new(-0.67109721177482, 0.0, 2.0),
        target: AxisState::new(-0.67109721177482, 2.686852531859186e-8, 1.9999999592090087),
        v: (-0.5, 0.5),
        a: (-2.0, 2.0),
        j: (-4.0, 4.0),
    };
    for case in [case, case.mirrored(), case.reversed()] {
        let problem = AxisProblem::new(&case.start, &case.target, &case.limits()).unwrap();
        let durations = problem.durations();
        let (shortest, end) = (durations.shortest(), durations.blocked()[0].0);
        assert!(shortest < end && end - shortest < 1.2e-16, "{durations:?}");
        for i in 0..=20 {
            meets(case, (shortest + (end - shortest) * f64::from(i) / 20.0).clamp(shortest, end));
        }
    }
}

/// Braking from 5000 km/s and going back for 100 000 years: the speed of the way back had the round-off of that of the braking, which was
/// 6 km in the end, and was sought by bisection.
#[test]
fn a_cruise_of_years_is_as_exact_as_its_way() {
    let case = Case {
        start: AxisState::new(-0.018419397036586682, 0.04457538200992197, -2424.6551281618677),
        target: AxisState::new(2.779529602892227, 0.13297941182209874, 0.0),
        v: (-0.021608800084235387, 0.13299193960706374),
        a: (-855.6128217375118, 28.994454565743993),
        j: (-0.5741915548765064, 0.5741915548765064),
    };
    let t = 3507592856221.0176;
    for case in [case, case.mirrored()] {
        let problem = AxisProblem::new(&case.start, &case.target, &case.limits()).unwrap();
        let phases: Vec<_> = problem.with_duration(t).unwrap().phases().collect();
        for pair in phases.windows(2) {
            let ((before, dt), (after, _)) = (pair[0], pair[1]);
            // Round-off of a way of 5e11 m and of a speed of 5e6 m/s.
            let end = before.after(dt);
            let (position, velocity) = ((end.p - after.s).abs(), (end.v - after.v).abs());
            assert!(position <= 1e-3 && velocity <= 2e-9, "{position} m, {velocity} m/s at {} s", after.t);
        }
    }
}
