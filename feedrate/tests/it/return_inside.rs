//! Starts above the velocity limit, without acceleration and on the way to rest, come back inside as soon as that does not lengthen the
//! motion. With an acceleration at the start, or a moving target, some of 10000 do not.
use arcfeed_feedrate::{AxisState, MotionLaw, StateToState};
use arcfeed_testing::Random;

use crate::common::axis::{Case, random_case};

/// Excess over a limit that counts as round-off, relative to the width of the limits.
const ROUND_OFF: f64 = 1e-9;
/// Difference of two times of return that counts, and of two durations, relative to the duration.
const SOONER: f64 = 1e-7;
const LONGER: f64 = 1e-11;
/// Places on the hardest braking from which the rest is planned anew.
const PLACES: usize = 16;

/// The last time at which velocity or acceleration is outside its limits; 0 if never.
fn outside_until(case: &Case, motion: &StateToState) -> f64 {
    let over = |x: f64, l: (f64, f64)| (x - l.1).max(l.0 - x) > ROUND_OFF * (l.1 - l.0);
    let mut last = 0.0;
    for (phase, dt) in motion.phases() {
        // Times at which a limit is crossed: between two of them the phase is outside all the time or never.
        let mut times = vec![0.0, dt];
        for limit in [case.v.0, case.v.1] {
            let (half, rest) = (phase.a / phase.j, 2.0 * (phase.v - limit) / phase.j);
            let root = (half * half - rest).sqrt();
            times.extend([-half - root, -half + root, (limit - phase.v) / phase.a]);
        }
        times.extend([case.a.0, case.a.1].map(|limit| (limit - phase.a) / phase.j));
        times.retain(|t| (0.0..=dt).contains(t));
        times.sort_by(f64::total_cmp);
        for pair in times.windows(2) {
            let middle = phase.after(0.5 * (pair[0] + pair[1]));
            if over(middle.v, case.v) || over(middle.a, case.a) {
                last = phase.t + pair[1];
            }
        }
    }
    last
}

/// The state after `t` of the hardest braking: the acceleration goes to its lower limit with the largest jerk and stays there.
fn braked(case: &Case, t: f64) -> AxisState {
    let AxisState { p, v, a } = case.start;
    let jerk = if a > case.a.0 { case.j.0 } else { case.j.1 };
    let turn = ((case.a.0 - a) / jerk).min(t);
    let hold = t - turn;
    let a1 = a + jerk * turn;
    let v1 = v + turn * (a + 0.5 * jerk * turn);
    let p1 = p + turn * (v + turn * (0.5 * a + jerk * turn / 6.0));
    AxisState::new(p1 + hold * (v1 + 0.5 * a1 * hold), v1 + a1 * hold, a1)
}

/// The time at which the hardest braking is at the upper velocity limit, by bisection. The start is above it.
fn time_to_limit(case: &Case) -> f64 {
    let above = |t: f64| braked(case, t).v > case.v.1;
    let (mut low, mut high) = (0.0, 1e-3);
    while above(high) {
        high *= 2.0;
    }
    for _ in 0..100 {
        let middle = 0.5 * (low + high);
        if above(middle) { low = middle } else { high = middle }
    }
    high
}

/// The shortest time from the start, without acceleration, to the velocity limit without acceleration: a trapezoid of acceleration,
/// or a triangle.
fn time_to_settle(case: &Case) -> f64 {
    let (drop, fall, ramps) = (case.start.v - case.v.1, -case.a.0, 1.0 / -case.j.0 + 1.0 / case.j.1);
    if drop >= 0.5 * fall * fall * ramps { drop / fall + 0.5 * fall * ramps } else { (2.0 * drop * ramps).sqrt() }
}

/// A random problem that starts above the upper velocity limit, without acceleration, and ends at rest.
fn start_above(rng: &mut Random) -> Case {
    loop {
        let mut case = random_case(rng, true);
        (case.start.a, case.target.v, case.target.a) = (0.0, 0.0, 0.0);
        let case = if case.start.v < case.v.0 { case.mirrored() } else { case };
        if case.start.v > case.v.1 * (1.0 + 1e-3) {
            return case;
        }
    }
}

#[test]
fn a_start_above_the_limit_is_inside_as_soon_as_that_costs_no_time() {
    let (mut soonest, mut later) = (0, 0);
    for seed in 0..20_000 {
        let case = start_above(&mut Random::new(seed));
        let motion = case.solve().unwrap_or_else(|e| panic!("seed {seed}: {e}: {case:?}"));
        let (duration, back) = (motion.duration(), outside_until(&case, &motion));
        let limit = time_to_limit(&case);
        let tolerance = SOONER * (duration + limit);
        assert!(
            back >= limit - tolerance,
            "seed {seed}: inside at {back}, which no braking reaches before {limit}: {case:?}"
        );
        let settled = time_to_settle(&case);
        assert!(
            back <= settled + tolerance,
            "seed {seed}: inside at {back}, though the velocity settles at the limit in {settled}: {case:?}"
        );
        if back <= limit + tolerance {
            soonest += 1;
            continue;
        }
        // Braking harder for longer, and the shortest motion from there: where it is inside sooner it takes longer.
        for place in 1..=PLACES {
            let t = limit * place as f64 / PLACES as f64;
            let rest = Case { start: braked(&case, t), ..case };
            let Ok(other) = rest.solve() else { continue };
            let (total, inside) = (t + other.duration(), t + outside_until(&rest, &other));
            let sooner = inside < back - tolerance;
            assert!(
                !(sooner && total <= duration * (1.0 + LONGER)),
                "seed {seed}: inside at {back} and there at {duration}, but braking hard for {t} is inside at {inside} and \
                 there at {total}: {case:?}"
            );
            later += usize::from(sooner);
        }
    }
    println!("{soonest} starts inside at the soonest, {later} harder ways that take longer");
    assert!(soonest > 10_000 && later > 4000, "{soonest} starts, {later} ways: the test shows too little");
}
