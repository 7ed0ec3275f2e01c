//! State to state of one axis: reference durations, exact ends, limits, symmetries, scales, refusals.
#![allow(clippy::unwrap_used, clippy::neg_cmp_op_on_partial_ord)]
use arcfeed_feedrate::{AxisLimits, AxisProblem, AxisState, FeedError, MotionLaw, StateToState};

use crate::common;
use arcfeed_testing::Random;
use common::axis::{Case, fault, random_case};

/// After the limits hold for the first time they hold for good. Returns the worst excess after that.
fn leaves_again(case: &Case, motion: &StateToState) -> f64 {
    let over = |x: f64, l: (f64, f64)| (x - l.1).max(l.0 - x) / (l.1 - l.0);
    let mut been_inside = false;
    let mut worst: f64 = 0.0;
    for i in 0..=4000 {
        let s = motion.at(motion.duration() * f64::from(i) / 4000.0);
        let excess = over(s.v, case.v).max(over(s.a, case.a));
        // Acceleration may still force the velocity out.
        let stop = s.v + 0.5 * s.a * s.a / if s.a > 0.0 { -case.j.0 } else { -case.j.1 };
        been_inside |= excess <= 0.0 && over(stop, case.v) <= 0.0;
        if been_inside {
            worst = worst.max(excess);
        }
    }
    worst
}

struct Reference {
    case: Case,
    family: &'static str,
    outside: bool,
    duration: f64,
    range: (f64, f64),
}

fn references() -> Vec<Reference> {
    let mut family = "";
    let mut outside = false;
    let mut all = Vec::new();
    for line in include_str!("../fixtures/state_to_state.txt").lines().filter(|l| !l.starts_with('#')) {
        if let Some(head) = line.strip_prefix("> ") {
            family = head.split(' ').next().unwrap();
            outside = head.ends_with(" outside");
            continue;
        }
        let words: Vec<&str> = line.split(' ').collect();
        let x = |i: usize| words[i].parse::<f64>().unwrap();
        let lower = |i: usize| if words[i] == "-" { -x(i - 1) } else { x(i) };
        let duration = x(11);
        let range = if words.len() > 12 { (x(12), x(13)) } else { (duration, duration) };
        let case = Case {
            start: AxisState::new(x(0), x(1), x(2)),
            target: AxisState::new(x(3), x(4), x(5)),
            v: (lower(7), x(6)),
            a: (lower(9), x(8)),
            j: (-x(10), x(10)),
        };
        all.push(Reference { case, family, outside, duration, range });
    }
    assert_eq!(all.len(), 3000);
    all
}

#[test]
fn reference_durations() {
    let mut counts = std::collections::BTreeMap::<&str, (usize, usize, usize)>::new();
    let mut failures = Vec::new();
    for r in references() {
        let entry = counts.entry(r.family).or_default();
        entry.1 += 1;
        let motion = match r.case.solve() {
            Ok(m) => m,
            Err(e) => {
                failures.push(format!("{}: {e}: {:?}", r.family, r.case));
                continue;
            }
        };
        let tolerance = 1e-9 + 1e-7 * r.duration;
        let (lo, hi) = (r.range.0 - tolerance, r.range.1 + tolerance);
        let t = motion.duration();
        let shorter = r.outside && t < lo;
        entry.2 += usize::from(shorter);
        if let Some(text) = fault(&r.case, &motion) {
            failures.push(format!("{}: {text}: {:?}", r.family, r.case));
        } else if !shorter && (t < lo || t > hi) {
            failures.push(format!("{}: {t} instead of {}: {:?}", r.family, r.duration, r.case));
        } else if r.outside && leaves_again(&r.case, &motion) > 1e-12 {
            failures.push(format!("{}: leaves the limits again: {:?}", r.family, r.case));
        } else {
            entry.0 += 1;
        }
    }
    println!("family: (passed, of, shorter than the reference) {counts:#?}");
    assert!(
        failures.is_empty(),
        "{} failures, the first ones: {:#?}",
        failures.len(),
        &failures[..failures.len().min(6)]
    );
}

#[test]
fn random_starts_inside() {
    let mut rng = Random::new(7);
    for i in 0..200_000 {
        let case = random_case(&mut rng, false);
        let motion = case.solve().unwrap_or_else(|e| panic!("case {i}: {e}: {case:?}"));
        if let Some(text) = fault(&case, &motion) {
            panic!("case {i}: {text}: {case:?}");
        }
    }
}

#[test]
fn random_starts_outside() {
    let mut rng = Random::new(8);
    let mut worst = 0.0_f64;
    for i in 0..20_000 {
        let case = random_case(&mut rng, true);
        let motion = case.solve().unwrap_or_else(|e| panic!("case {i}: {e}: {case:?}"));
        if let Some(text) = fault(&case, &motion) {
            panic!("case {i}: {text}: {case:?}");
        }
        let again = leaves_again(&case, &motion);
        assert!(again <= 1e-12, "case {i} leaves the limits again by {again:e}: {case:?}");
        worst = worst.max(again);
    }
}

/// Equal durations, unless a change of the displacement by round-off makes the duration jump.
fn same_duration(name: &str, case: &Case, t: f64, other: f64) {
    let close = |a: f64, b: f64| (a - b).abs() <= 1e-9 * a.max(b);
    if close(t, other) {
        return;
    }
    // The range of the duration under a change of the target by 1e-10.
    let nudge = 1e-10 * (case.start.p.abs() + case.target.p.abs() + case.v.1 * t);
    let near = |d: f64| {
        let mut c = *case;
        c.target.p += d;
        c.solve().unwrap().duration()
    };
    let (a, b) = (near(-nudge), near(nudge));
    let tolerance = 1e-9 * a.max(b);
    assert!(
        other >= a.min(b).min(t) - tolerance && other <= a.max(b).max(t) + tolerance,
        "{name}: {t} against {other} (nearby {a}, {b}): {case:?}"
    );
}

#[test]
fn mirror_and_time_reversal_give_the_same_duration() {
    let mut rng = Random::new(9);
    for _ in 0..100_000 {
        let case = random_case(&mut rng, false);
        let t = case.solve().unwrap().duration();
        assert_eq!(t, case.mirrored().solve().unwrap().duration(), "mirror: {case:?}");
        same_duration("time reversal", &case, t, case.reversed().solve().unwrap().duration());
    }
}

#[test]
fn answer_scales_exactly_with_the_units() {
    let mut rng = Random::new(10);
    for i in 0..50_000 {
        let case = random_case(&mut rng, i % 4 == 0);
        let length = 2f64.powi((rng.unit() * 400.0) as i32 - 200);
        let time = 2f64.powi((rng.unit() * 200.0) as i32 - 100);
        let scaled = case.scaled(length, time);
        let (here, there) = (case.solve().unwrap(), scaled.solve().unwrap());
        assert_eq!(here.duration() * time, there.duration(), "{length:e} {time:e}: {case:?}");
        if let Some(text) = fault(&scaled, &there) {
            panic!("{length:e} {time:e}: {text}: {case:?}");
        }
    }
}

/// Durations of every extremal of one direction found by scanning its first peak, without any of the algebra of the solver:
/// jerk `+ [0] - [0] +` with the second peak from the velocity equation, the displacement by adding up phases.
fn scan_up(c: &Case, found: &mut Vec<f64>) {
    let (u, d) = (1.0 / c.j.1, -1.0 / c.j.0);
    let (s, e) = (c.start, c.target);
    // The five phases for a first peak and a time at it; the second peak from the branch of the square root.
    let phases = |peak: f64, hold: f64, branch: f64| -> Option<[(f64, f64); 5]> {
        let t1 = (peak - s.a) * u;
        let after = s.v + 0.5 * t1 * (s.a + peak) + peak * hold;
        // Falling to `low` and rising to the end: after + (peak² - low²) d/2 + (af² - low²) u/2 = vf.
        let square = (after - e.v + 0.5 * peak * peak * d + 0.5 * e.a * e.a * u) / (0.5 * (u + d));
        if square < 0.0 {
            return None;
        }
        let mut low = branch * square.sqrt();
        let mut low_hold = 0.0;
        if low < c.a.0 {
            low_hold = 0.5 * (u + d) * (square - c.a.0 * c.a.0) / -c.a.0;
            low = c.a.0;
        }
        let out = [(t1, c.j.1), (hold, 0.0), ((peak - low) * d, c.j.0), (low_hold, 0.0), ((e.a - low) * u, c.j.1)];
        out.iter().all(|x| x.0 >= 0.0).then_some(out)
    };
    let run = |list: &[(f64, f64); 5]| {
        let (mut p, mut v, mut a, mut t, mut top) = (0.0, s.v, s.a, 0.0, s.v);
        for &(dt, j) in list {
            if a > 0.0 && j < 0.0 && -a / j < dt {
                top = v - 0.5 * a * a / j;
            }
            p += dt * (v + dt * (0.5 * a + dt * j / 6.0));
            v += dt * (a + 0.5 * dt * j);
            a += dt * j;
            t += dt;
        }
        (p - (e.p - s.p), t, top)
    };
    const N: usize = 600;
    let longest = 2.0 * (c.v.1 - c.v.0) / c.a.1;
    // Denser towards both ends of the first peak's range.
    let place = |i: usize| 0.5 - 0.5 * (std::f64::consts::PI * i as f64 / N as f64).cos();
    let setting = |x: f64| {
        if x <= 1.0 { (s.a + (c.a.1 - s.a) * x, 0.0) } else { (c.a.1, longest * (x - 1.0)) }
    };
    for branch in [1.0, -1.0] {
        let value = |x: f64| {
            let (peak, hold) = setting(x);
            phases(peak, hold, branch).map(|l| run(&l))
        };
        let xs = (0..=N).map(place).chain((1..=N).map(|i| 1.0 + place(i)));
        let mut before: Option<(f64, f64)> = None;
        for x in xs {
            let now = value(x);
            if let (Some((x0, f0)), Some((f1, ..))) = (before, now)
                && (f0 < 0.0) != (f1 < 0.0)
            {
                let (mut lo, mut hi) = (x0, x);
                for _ in 0..80 {
                    let mid = 0.5 * (lo + hi);
                    match value(mid) {
                        Some((f, ..)) if (f < 0.0) == (f0 < 0.0) => lo = mid,
                        _ => hi = mid,
                    }
                }
                if let Some((f, t, top)) = value(lo)
                    && f.abs() <= 1e-9 * (e.p - s.p).abs().max((c.v.1 - c.v.0) * t)
                    && top <= c.v.1
                {
                    found.push(t);
                }
            }
            before = now.map(|n| (x, n.0));
        }
    }
}

#[test]
fn no_extremal_is_shorter() {
    let mut rng = Random::new(11);
    let mut compared = 0;
    for i in 0..12000 {
        let case = random_case(&mut rng, false);
        let t = case.solve().unwrap().duration();
        let mut found = Vec::new();
        scan_up(&case, &mut found);
        scan_up(&case.mirrored(), &mut found);
        if let Some(best) = found.iter().copied().reduce(f64::min) {
            compared += 1;
            assert!(t <= best * (1.0 + 1e-8), "case {i}: {t}, but {best} is possible: {case:?}");
        }
    }
    assert!(compared > 4000, "only {compared} compared");
}

#[test]
fn rest_to_rest_closed_forms() {
    let (v, a, j) = (2.0_f64, 3.0_f64, 5.0_f64);
    let limits = AxisLimits::symmetric(v, a, j).unwrap();
    let duration = |d: f64| {
        let t = StateToState::new(&AxisState::rest(0.7), &AxisState::rest(0.7 + d), &limits).unwrap().duration();
        let back = StateToState::new(&AxisState::rest(0.7), &AxisState::rest(0.7 - d), &limits).unwrap().duration();
        assert!((t - back).abs() < 1e-13 * t);
        t
    };
    // Jerk alone; acceleration limit reached; velocity limit reached.
    let (d1, d2) = (2.0 * a.powi(3) / (j * j), v * v / a + v * a / j);
    let close = |x: f64, y: f64| assert!((x - y).abs() <= 1e-12 * y, "{x} {y}");
    for d in [1e-3 * d1, 0.3 * d1, d1] {
        close(duration(d), (32.0 * d / j).cbrt());
    }
    for d in [1.01 * d1, 0.5 * (d1 + d2), d2] {
        close(duration(d), a / j + (a * a / (j * j) + 4.0 * d / a).sqrt());
    }
    for d in [1.01 * d2, 30.0 * d2] {
        close(duration(d), d / v + v / a + a / j);
    }
    // Micrometres and a jerk of 1e12.
    let sharp = AxisLimits::symmetric(1.0, 1e4, 1e12).unwrap();
    let t = StateToState::new(&AxisState::rest(1.0), &AxisState::rest(1.0 + 1e-6), &sharp).unwrap().duration();
    let d = (1.0 + 1e-6) - 1.0;
    close(t, 1e-8 + (1e-16 + 4.0 * d / 1e4_f64).sqrt());
}

#[test]
fn staying_takes_no_time() {
    let limits = AxisLimits::symmetric(1.0, 2.0, 3.0).unwrap();
    for s in [AxisState::rest(0.3), AxisState::new(1.0, 0.5, 0.2), AxisState::new(-1.0, 1.0, 0.0)] {
        let motion = StateToState::new(&s, &s, &limits).unwrap();
        assert_eq!(motion.duration(), 0.0);
        assert_eq!(motion.phases().len(), 0);
        let at = motion.at(0.0);
        assert_eq!((at.p, at.v, at.a), (s.p, s.v, s.a));
        assert_eq!(motion.position_range().max, s.p);
    }
}

#[test]
fn lowered_velocity_limit_brakes_without_coming_back() {
    let limits = AxisLimits::symmetric(1.0, 2.0, 4.0).unwrap();
    let motion = StateToState::new(&AxisState::new(0.0, 3.0, 0.0), &AxisState::rest(20.0), &limits).unwrap();
    let t = motion.duration();
    let mut slowed = false;
    for i in 0..=10_000 {
        let s = motion.at(t * f64::from(i) / 10_000.0);
        slowed |= s.v <= 1.0;
        assert!(s.v >= 0.0 && (!slowed || s.v <= 1.0 + 1e-12), "{s:?}");
        if s.p < 15.0 {
            assert!(s.v >= 1.0 - 1e-12, "dips: {s:?}");
        }
    }
}

#[test]
fn position_range_is_the_extreme_of_the_samples() {
    let mut rng = Random::new(12);
    for i in 0..2000 {
        let case = random_case(&mut rng, i % 5 == 0);
        let motion = case.solve().unwrap();
        let range = motion.position_range();
        let (mut lo, mut hi) = (f64::INFINITY, f64::NEG_INFINITY);
        for k in 0..=2000 {
            let p = motion.at(motion.duration() * f64::from(k) / 2000.0).p;
            lo = lo.min(p);
            hi = hi.max(p);
        }
        let size = hi - lo;
        let eps = 1e-12 * (size + lo.abs() + hi.abs());
        assert!(range.min <= lo + eps && range.max >= hi - eps, "{range:?} {lo} {hi}: {case:?}");
        assert!((motion.at(range.t_min).p - range.min).abs() <= eps);
        assert!((motion.at(range.t_max).p - range.max).abs() <= eps);
    }
}

#[test]
fn any_finite_input_is_answered_or_refused() {
    let mut rng = Random::new(13);
    let special = [0.0, 1.0, 5e-324, 1e-300, 1e300, f64::MAX, f64::MIN_POSITIVE, 1e-10, 1e10];
    let mut any = |signed: bool| {
        let x = match (rng.unit() * 3.0) as u32 {
            0 => special[(rng.unit() * special.len() as f64) as usize],
            1 => f64::from_bits((rng.unit() * 9.2e18) as u64),
            _ => rng.log(1e-3, 1e3),
        };
        let x = if x.is_finite() { x } else { 1.0 };
        if signed && rng.unit() < 0.5 { -x } else { x }
    };
    let mut solved = 0;
    for _ in 0..300_000 {
        let positive = |x: f64| if x > 0.0 { x } else { 1.0 };
        let mut pair = || (-positive(any(false)), positive(any(false)));
        let (v, a, j) = (pair(), pair(), pair());
        let mut state = || AxisState::new(any(true), any(true), any(true));
        let (start, mut target) = (state(), state());
        target.v = target.v.clamp(v.0, v.1);
        target.a = 0.0;
        let limits = AxisLimits::new(v, a, j).unwrap();
        if let Ok(motion) = StateToState::new(&start, &target, &limits) {
            solved += 1;
            assert!(motion.duration() >= 0.0 && motion.duration().is_finite());
            for k in 0..=8 {
                let s = motion.at(motion.duration() * f64::from(k) / 8.0);
                assert!(!s.a.is_nan() && !s.j.is_nan(), "{start:?} {target:?} {limits:?}");
            }
        }
    }
    assert!(solved > 30_000, "{solved}");
}

#[test]
fn refusals_name_what_is_wrong() {
    let limits = AxisLimits::new((-1.0, 2.0), (-3.0, 4.0), (-5.0, 6.0)).unwrap();
    let rest = AxisState::rest(0.0);
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        for k in 0..6 {
            let mut x = [0.0; 6];
            x[k] = bad;
            let r = StateToState::new(&AxisState::new(x[0], x[1], x[2]), &AxisState::new(x[3], x[4], x[5]), &limits);
            let names = ["start.p", "start.v", "start.a", "target.p", "target.v", "target.a"];
            assert!(matches!(r, Err(FeedError::NotFinite { what, .. }) if what == names[k]), "{r:?}");
            let mut l = [-1.0, 1.0, -1.0, 1.0, -1.0, 1.0];
            l[k] = bad;
            let r = AxisLimits::new((l[0], l[1]), (l[2], l[3]), (l[4], l[5]));
            let names = ["v_min", "v_max", "a_min", "a_max", "j_min", "j_max"];
            assert!(matches!(r, Err(FeedError::NotFinite { what, .. }) if what == names[k]), "{r:?}");
        }
    }
    assert!(matches!(AxisLimits::symmetric(1.0, 0.0, 1.0), Err(FeedError::NotPositive { what: "a_max", .. })));
    let to = |v, a| StateToState::new(&rest, &AxisState::new(1.0, v, a), &limits).unwrap_err();
    assert!(matches!(to(2.1, 0.0), FeedError::TargetOutside { what: "v", limit: 2.0, .. }));
    assert!(matches!(to(0.0, -3.1), FeedError::TargetOutside { what: "a", limit: -3.0, .. }));
    // 3² / (2 * 5) = 0.9 more just before.
    assert!(matches!(to(1.5, -3.0), FeedError::TargetUnreachable { limit: 2.0, .. }));
    assert!(matches!(to(-0.9, 4.0), FeedError::TargetUnreachable { limit: -1.0, .. }));
    assert!(to(1.5, -3.0).to_string().contains("2.4"), "{}", to(1.5, -3.0));
}

/// Where start and target are one state that brakes, the change of velocity was taken for a rise, with its peak on the wrong side
/// of zero: 16 s for nothing, and 0 s in the mirrored problem.
#[test]
fn already_there_with_a_negative_acceleration_took_16_s() {
    let limits = AxisLimits::symmetric(4.0, 2.0, 0.5).unwrap();
    for a in [2.0, 1.0, -1.0, -2.0] {
        let state = AxisState::new(0.7450538634956339, 0.0, a);
        assert_eq!(StateToState::new(&state, &state, &limits).unwrap().duration(), 0.0, "{a}");
    }
    // One phase of constant jerk, from wherever to wherever on one side of zero: nothing is shorter.
    let mut rng = Random::new(91);
    for i in 0..100_000 {
        let limits = AxisLimits::symmetric(10.0, 4.0, 8.0).unwrap();
        let mut grid = |x: f64| (x * (2.0 * rng.unit() - 1.0) * 16.0).round() / 16.0;
        let (from, to, v) = (grid(4.0), grid(4.0), grid(2.0));
        let t = (to - from).abs() / 8.0;
        let j = if to > from { 8.0 } else { -8.0 };
        let start = AxisState::new(0.0, v, from);
        let end = AxisState::new(t * (v + t * (0.5 * from + t * j / 6.0)), v + 0.5 * t * (from + to), to);
        let motion = StateToState::to_velocity(&start, end.v, end.a, &limits).unwrap();
        assert!(
            (motion.duration() - t).abs() <= 1e-15,
            "case {i}: {} s instead of {t} s: {start:?} {end:?}",
            motion.duration()
        );
    }
}

/// At full acceleration a moment is much shorter than the ramps from zero acceleration that the formulas add up: their round-off
/// was a jump of 9e-16 where the way is 1e-18.
#[test]
fn a_moment_at_full_acceleration_had_a_jump_of_the_position() {
    let limits = AxisLimits::new((-8.0, 8.0), (-8.0, 8.0), (-4.0, 4.0)).unwrap();
    let start = AxisState::new(0.0, -5.3357027850489806e-11, -7.999999999972972);
    let target = AxisState::new(0.0, -6.603150212335418e-9, -7.999999998834919);
    let problem = AxisProblem::new(&start, &target, &limits).unwrap();
    let t = 8.187237568245084e-10;
    assert!(problem.durations().contains(t));
    let motion = problem.with_duration(t).unwrap();
    let mut end = (start.p, start.v, start.a);
    for (phase, dt) in motion.phases() {
        let gap = ((phase.s - end.0).abs(), (phase.v - end.1).abs(), (phase.a - end.2).abs());
        assert!(gap.0 <= 1e-17 && gap.1 <= 1e-14 && gap.2 <= 1e-14, "{gap:?} at {}", phase.t);
        let s = phase.after(dt);
        end = (s.p, s.v, s.a);
    }
    assert!((end.0 - target.p).abs() <= 1e-17 && (end.1 - target.v).abs() <= 1e-14, "{end:?}");
    assert!((end.2 - target.a).abs() <= 1e-14, "{end:?}");
}

/// One phase of the hardest braking leads from a start that is bound to exceed its velocity limit to a target at that limit. Rise and fall of
/// its extremals cancel, and round-off of 1e-17 m decided whether the motion ended 0.15 m beside its target.
#[test]
fn one_phase_that_ends_at_the_velocity_limit_ends_in_its_target() {
    let mut rng = Random::new(93);
    for i in 0..20_000 {
        let (v, a, j) = (rng.log(1e-3, 10.0), rng.log(1e-3, 10.0), rng.log(1e-2, 100.0));
        // From rest with the acceleration `b`, which falls to `a` while the velocity rises to `v`.
        let b = (a * a + 2.0 * j * v).sqrt();
        let t = (b - a) / j;
        let d = 0.5 * t * t * (b - j * t / 3.0);
        let from = rng.between(-1.0, 1.0);
        let side = rng.sign();
        let pair = |least: f64, most: f64| if side > 0.0 { (-least, most) } else { (-most, least) };
        let case = Case {
            start: AxisState::new(side * from, 0.0, side * b),
            target: AxisState::new(side * (from + d), side * v, side * a),
            v: pair((v + 0.5 * a * a / j) * rng.log(1.0, 10.0), v),
            a: pair(2.0 * b, 2.0 * b),
            j: pair(j, j),
        };
        let motion = case.solve().unwrap();
        let mut end = (case.start.p, case.start.v, case.start.a);
        for (phase, dt) in motion.phases() {
            let gap = ((phase.s - end.0).abs(), (phase.v - end.1).abs(), (phase.a - end.2).abs());
            let way = 1.0 + d + v * motion.duration();
            assert!(gap.0 <= 1e-8 * way && gap.1 <= 1e-8 * v && gap.2 <= 1e-8 * b, "case {i}: {gap:?}: {case:?}");
            let s = phase.after(dt);
            end = (s.p, s.v, s.a);
        }
        let miss = ((end.0 - case.target.p).abs(), (end.1 - case.target.v).abs());
        assert!(
            miss.0 <= 1e-8 * (1.0 + d + v * motion.duration()) && miss.1 <= 1e-8 * v,
            "case {i}: {miss:?}: {case:?}"
        );
    }
}
