//! One axis that follows ramps, sinusoids, steps and noise.
#![allow(clippy::unwrap_used)]

use arcfeed_feedrate::{
    AxisLimits, AxisProblem, AxisState, FeedError, MotionLaw, StateToState, TargetTracker, TrackStatus, TrackStep,
};
use arcfeed_testing::{Random, allocations_in};

const CYCLE: f64 = 1e-3;

/// Follows a target and checks every cycle: jerk, acceleration, velocity, and no jump.
struct Watch {
    tracker: TargetTracker,
    limits: AxisLimits,
    time: f64,
}

impl Watch {
    fn new(start: AxisState, limits: AxisLimits) -> Self {
        Self { tracker: TargetTracker::new(&start, &limits, CYCLE).unwrap(), limits, time: 0.0 }
    }

    fn step(&mut self, target: impl Fn(f64) -> AxisState) -> TrackStep {
        self.time += CYCLE;
        let was = *self.tracker.state();
        let step = self.tracker.step(&target(self.time)).unwrap();
        let (now, l) = (*self.tracker.state(), &self.limits);
        assert_eq!((step.state.p, step.state.v, step.state.a), (now.p, now.v, now.a));
        let jerk = l.j_max().max(-l.j_min());
        let text = || format!("at {}: {was:?} -> {step:?} within {l:?}", self.time);
        let round_off = 1e-13 * (1.0 + now.p.abs() + was.p.abs());
        let mean = (now.a - was.a) / CYCLE;
        assert!(mean <= l.j_max() * (1.0 + 1e-9) && mean >= l.j_min() * (1.0 + 1e-9), "jerk {}", text());
        let dv = now.v - was.v - 0.5 * CYCLE * (was.a + now.a);
        assert!(dv.abs() <= jerk * CYCLE.powi(2) / 4.0 * (1.0 + 1e-6) + round_off, "velocity jumps {}", text());
        let dp = now.p - was.p - 0.5 * CYCLE * (was.v + now.v);
        assert!(dp.abs() <= jerk * CYCLE.powi(3) / 12.0 * (1.0 + 1e-6) + round_off, "position jumps {}", text());
        assert!(l.contain(&now), "limits {}", text());
        step
    }

    /// Steps until it follows, and the time that takes.
    fn until_following(&mut self, most: f64, target: impl Fn(f64) -> AxisState) -> f64 {
        let from = self.time;
        while self.step(&target).status != TrackStatus::Following {
            assert!(self.time - from < most, "not there after {most} s: {:?} {:?}", self.tracker, target(self.time));
        }
        self.time - from
    }

    /// Zero error for so many cycles.
    fn stays(&mut self, cycles: usize, target: impl Fn(f64) -> AxisState) {
        for _ in 0..cycles {
            let step = self.step(&target);
            let wanted = target(self.time);
            assert_eq!(step.status, TrackStatus::Following, "at {}: {step:?} {wanted:?}", self.time);
            assert_eq!(*self.tracker.state(), wanted);
        }
    }
}

fn limits(rng: &mut Random) -> AxisLimits {
    let pair = |rng: &mut Random, lo: f64, hi: f64| (-rng.log(lo, hi), rng.log(lo, hi));
    AxisLimits::new(pair(rng, 0.5, 5.0), pair(rng, 2.0, 30.0), pair(rng, 20.0, 500.0)).unwrap()
}

#[test]
fn a_step_is_followed_in_the_least_time() {
    let mut rng = Random::new(101);
    for i in 0..200 {
        let l = limits(&mut rng);
        let goal = AxisState::rest(rng.between(-2.0, 2.0));
        let shortest = StateToState::new(&AxisState::rest(0.0), &goal, &l).unwrap().duration();
        let taken = Watch::new(AxisState::rest(0.0), l).until_following(10.0 * shortest + 1.0, |_| goal);
        assert!(taken <= shortest + 3.0 * CYCLE, "case {i}: {taken} instead of {shortest}");
    }
}

#[test]
fn a_ramp_is_met_in_the_least_time_and_followed_without_error() {
    let mut rng = Random::new(102);
    for i in 0..200 {
        let l = limits(&mut rng);
        let speed = 0.8 * rng.between(l.v_min(), l.v_max());
        let ahead = rng.between(-1.0, 1.0);
        let target = |t: f64| AxisState::new(ahead + speed * t, speed, 0.0);
        // In the frame of the target.
        let frame =
            AxisLimits::new((l.v_min() - speed, l.v_max() - speed), (l.a_min(), l.a_max()), (l.j_min(), l.j_max()));
        let from = AxisState::new(-ahead, -speed, 0.0);
        let shortest = StateToState::new(&from, &AxisState::rest(0.0), &frame.unwrap()).unwrap().duration();
        let mut watch = Watch::new(AxisState::rest(0.0), l);
        let taken = watch.until_following(10.0 * shortest + 1.0, target);
        assert!(taken <= 1.01 * shortest + 3.0 * CYCLE, "case {i}: {taken} instead of {shortest}");
        watch.stays(300, target);
    }
}

#[test]
fn a_sinusoid_is_met_and_followed_without_error() {
    let mut rng = Random::new(103);
    let mut ratios = Vec::new();
    for i in 0..200 {
        let l = limits(&mut rng);
        let w = rng.log(0.5, 15.0);
        let least = |lo: f64, hi: f64| hi.min(-lo);
        // Within 60 % of each limit.
        let size = (least(l.v_min(), l.v_max()) / w)
            .min(least(l.a_min(), l.a_max()) / w.powi(2))
            .min(least(l.j_min(), l.j_max()) / w.powi(3));
        let (size, middle) = (0.6 * size, rng.between(-1.0, 1.0));
        let phase = rng.between(0.0, 6.0);
        let target = |t: f64| {
            let x = w * t + phase;
            AxisState::new(middle + size * x.sin(), size * w * x.cos(), -size * w * w * x.sin())
        };
        let mut watch = Watch::new(AxisState::rest(0.0), l);
        let taken = watch.until_following(60.0, target);
        watch.stays(2000, target);
        // The least time with hindsight: the first meeting that is possible.
        let meets = |t: f64| {
            let problem = AxisProblem::new(&AxisState::rest(0.0), &target(t), &l).unwrap();
            problem.shortest_duration() <= t
        };
        let best = (1..).map(|n| 1e-2 * f64::from(n)).find(|&t| meets(t)).unwrap();
        ratios.push(taken / best);
        assert!(taken < best + 0.5, "case {i}: {taken} instead of {best}");
    }
    ratios.sort_by(f64::total_cmp);
    println!(
        "time to meet a sinusoid by the least with hindsight: median {:.3}, 90 % {:.3}, worst {:.3}",
        ratios[100], ratios[180], ratios[199]
    );
}

/// A target that is too fast is followed at the limit, and met again when it is not.
#[test]
fn a_target_beyond_the_limits_saturates_smoothly() {
    let mut rng = Random::new(104);
    for _ in 0..60 {
        let l = limits(&mut rng);
        let fast = 1.5 * l.v_max();
        let target = |t: f64| {
            if t < 1.0 { AxisState::new(fast * t, fast, 0.0) } else { AxisState::rest(fast) }
        };
        let mut watch = Watch::new(AxisState::rest(0.0), l);
        let (mut changes, mut before) = (0, 0.0);
        while watch.time < 0.999 {
            let step = watch.step(target);
            assert_eq!(step.status, TrackStatus::Saturated);
            changes += usize::from(step.state.j * before < 0.0);
            before = step.state.j;
        }
        assert!(changes <= 3, "{changes} changes of the sign of the jerk");
        watch.until_following(20.0, target);
        watch.stays(100, target);
    }
}

/// The acceleration alone is more than the limits allow: no chatter, and the error stays small.
#[test]
fn a_target_that_accelerates_too_hard_is_kept_near_without_chatter() {
    let mut rng = Random::new(106);
    for _ in 0..40 {
        let l = limits(&mut rng);
        // A wrong acceleration of a target that stands: the axis comes to rest in its place.
        let wrong = AxisState::new(0.0, 0.0, 1.1 * l.a_max());
        let mut watch = Watch::new(AxisState::rest(-1.0), l);
        let rest = StateToState::new(&AxisState::rest(-1.0), &AxisState::rest(0.0), &l).unwrap().duration();
        while watch.time < 1.1 * rest + 0.1 {
            watch.step(|_| wrong);
        }
        for _ in 0..1000 {
            let step = watch.step(|_| wrong);
            assert_eq!(step.status, TrackStatus::Saturated);
            assert!(step.state.p.abs() < 1e-9 && step.state.v.abs() < 1e-6, "{step:?} within {l:?}");
        }
    }
}

/// Whatever the target does, the limits hold; and noise costs no more than its size.
#[test]
fn noise_and_jumps_break_no_limit() {
    let mut rng = Random::new(105);
    for _ in 0..40 {
        let l = limits(&mut rng);
        let mut watch = Watch::new(AxisState::rest(0.0), l);
        let mut wild = |size: f64| AxisState::new(size * rng.signed(), size * rng.signed(), size * rng.signed());
        for _ in 0..1500 {
            let target = wild(3.0);
            watch.step(|_| target);
        }
        let mut worst = 0.0_f64;
        // Noise of the position alone, which no motion can follow.
        for n in 0..12_000 {
            let noise = wild(1e-4);
            watch.step(|_| AxisState::rest(noise.p));
            if n > 10_000 {
                worst = worst.max(watch.tracker.state().p.abs());
            }
        }
        assert!(worst < 1.1e-4, "{worst}");
    }
}

#[test]
fn wrong_numbers_change_nothing_and_nothing_allocates() {
    let l = AxisLimits::symmetric(1.0, 5.0, 50.0).unwrap();
    let mut tracker = TargetTracker::new(&AxisState::rest(0.0), &l, CYCLE).unwrap();
    let before = *tracker.state();
    for bad in [f64::NAN, f64::INFINITY] {
        assert!(matches!(tracker.step(&AxisState::rest(bad)), Err(FeedError::NotFinite { what: "target.p", .. })));
        assert!(tracker.step(&AxisState::new(0.0, bad, 0.0)).is_err());
        assert!(tracker.step(&AxisState::new(0.0, 0.0, bad)).is_err());
        assert!(TargetTracker::new(&AxisState::rest(0.0), &l, bad).is_err());
    }
    assert_eq!(*tracker.state(), before);
    assert!(TargetTracker::new(&AxisState::rest(0.0), &l, 0.0).is_err());
    let count = allocations_in(|| {
        for n in 0..3000 {
            let t = f64::from(n) * CYCLE;
            let _ = tracker.step(&AxisState::new((3.0 * t).sin(), 3.0 * (3.0 * t).cos(), -9.0 * (3.0 * t).sin()));
        }
    });
    assert_eq!(count, 0);
    // Numbers of any size: no panic and no NaN.
    let mut rng = Random::new(106);
    for _ in 0..20_000 {
        let mut any = || rng.sign() * rng.log(1e-150, 1e150);
        let start = AxisState::new(any(), any(), any());
        let mut tracker = TargetTracker::new(&start, &l, CYCLE).unwrap();
        if let Ok(step) = tracker.step(&AxisState::new(any(), any(), any())) {
            let s = step.state;
            assert!(!(s.p.is_nan() || s.v.is_nan() || s.a.is_nan() || s.j.is_nan()), "{step:?}");
        }
    }
}

/// The square of its velocity overflows in one cycle. From the cycle after on, the tracker does what one does that begins there.
#[test]
fn a_target_that_overflows_is_not_remembered() {
    let mut rng = Random::new(111);
    for case in 0..10 {
        let l = limits(&mut rng);
        let w = rng.log(2.0, 15.0);
        let least = |lo: f64, hi: f64| hi.min(-lo);
        let size = (least(l.v_min(), l.v_max()) / w)
            .min(least(l.a_min(), l.a_max()) / w.powi(2))
            .min(least(l.j_min(), l.j_max()) / w.powi(3));
        let (size, middle) = (0.6 * size, rng.between(-1.0, 1.0));
        let target = |t: f64| {
            let x = w * t;
            AxisState::new(middle + size * x.sin(), size * w * x.cos(), -size * w * w * x.sin())
        };
        let mut watch = Watch::new(AxisState::rest(0.0), l);
        watch.step(target);
        watch.step(|t| AxisState { v: 1e200, ..target(t) });
        let mut other = Watch { tracker: TargetTracker::new(watch.tracker.state(), &l, CYCLE).unwrap(), ..watch };
        let mut follows = false;
        for cycle in 0..2000 {
            let step = watch.step(target);
            assert_eq!(step, other.step(target), "case {case}, cycle {cycle}");
            follows |= step.status == TrackStatus::Following;
        }
        assert!(follows, "case {case}");
    }
}

/// Three equal parts of a cycle with constant jerk lead to the target: the axis is in its state one cycle later. It never is where no
/// motion within the limits takes one cycle.
#[test]
fn a_target_within_one_cycle_is_landed_on() {
    let mut rng = Random::new(112);
    let (mut landed, mut refused) = (0, 0);
    for case in 0..3000 {
        let l = limits(&mut rng);
        let part = |rng: &mut Random, (lo, hi): (f64, f64)| 0.5 * rng.between(lo, hi);
        let (v, a) = (part(&mut rng, (l.v_min(), l.v_max())), part(&mut rng, (l.a_min(), l.a_max())));
        let start = AxisState::new(rng.between(-1.0, 1.0), v, a);
        if !l.contain(&AxisState::new(0.0, 1.5 * v, 1.5 * a)) {
            continue;
        }
        let (h, wide) = (CYCLE / 3.0, rng.one_of(&[0.999, 1.5, 3.0]));
        let jerks = [0; 3].map(|_| wide * rng.between(l.j_min(), l.j_max()));
        let after = |s: AxisState, j: &f64| {
            let (v, a) = (s.v + h * (s.a + 0.5 * h * j), s.a + h * j);
            AxisState::new(s.p + h * (s.v + h * (0.5 * s.a + h * j / 6.0)), v, a)
        };
        let target = jerks.iter().fold(start, after);
        let step = TargetTracker::new(&start, &l, CYCLE).unwrap().step(&target).unwrap();
        let (there, what) = (step.status == TrackStatus::Following, format!("case {case}: {jerks:?} within {l:?}"));
        if jerks.iter().all(|j| l.j_min() <= *j && *j <= l.j_max()) {
            assert!(there, "{what}: {step:?}");
            assert_eq!(AxisState::new(step.state.p, step.state.v, step.state.a), target, "{what}");
            assert!((step.state.j - jerks[2]).abs() < 1e-4 * (l.j_max() - l.j_min()), "{what}: {step:?}");
            landed += 1;
        } else {
            let wider = |(lo, hi): (f64, f64)| (1.001 * lo, 1.001 * hi);
            let all = [(l.v_min(), l.v_max()), (l.a_min(), l.a_max()), (l.j_min(), l.j_max())].map(wider);
            let all = AxisLimits::new(all[0], all[1], all[2]).unwrap();
            let possible =
                AxisProblem::new(&start, &target, &all).is_ok_and(|p| p.durations().at_least(CYCLE) <= CYCLE);
            assert!(possible || !there, "{what}: {step:?}");
            refused += usize::from(!there);
        }
    }
    assert!(landed > 500 && refused > 500, "{landed} {refused}");
}
