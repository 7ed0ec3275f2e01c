//! Motions inside a range of positions: limits, ends, durations, refusals, and an oracle.
#![allow(clippy::unwrap_used)]

use arcfeed_feedrate::{AxisLimits, AxisState, BoundedProblem, FeedError, MotionLaw, PositionLimits, StateToState};
use arcfeed_testing::{Random, allocations_in};

use crate::common;
use common::axis::{Case, fault, random_case};

/// The same state backwards in time, and the limits that hold then.
fn backwards(case: &Case) -> (AxisState, AxisLimits) {
    let AxisState { p, v, a } = case.target;
    let limits = AxisLimits::new((-case.v.1, -case.v.0), case.a, (-case.j.1, -case.j.0)).unwrap();
    (AxisState::new(p, -v, a), limits)
}

/// A case with a range around both of its ends that the shortest motion leaves, although braking from the start and running up
/// to the target do not.
pub fn ranged_case(rng: &mut Random) -> (Case, PositionLimits) {
    loop {
        let case = random_case(rng, false);
        let (lo, hi) = (case.start.p.min(case.target.p), case.start.p.max(case.target.p));
        let Ok(free) = case.solve() else { continue };
        let way = free.position_range();
        if way.min >= lo && way.max <= hi {
            continue;
        }
        let (back, reversed) = backwards(&case);
        for _ in 0..20 {
            let mut end = |near: f64, far: f64, wide: f64| {
                if near == far { near + wide * rng.log(1e-3, 1.0) } else { near + (far - near) * rng.unit() }
            };
            let size = (hi - lo) + (way.max - way.min);
            let positions = PositionLimits::new(end(lo, way.min, -size), end(hi, way.max, size)).unwrap();
            let safe = positions.can_stay(&case.start, &case.limits()) && positions.can_stay(&back, &reversed);
            if safe && !positions.contain_all_of(&free) {
                return (case, positions);
            }
        }
    }
}

fn samples_inside(motion: &StateToState, positions: &PositionLimits) -> bool {
    let slack = 1e-12 * (1.0 + positions.upper().abs().max(positions.lower().abs()));
    (0..=2000).all(|i| {
        let p = motion.at(motion.duration() * f64::from(i) / 2000.0).p;
        positions.lower() - slack <= p && p <= positions.upper() + slack
    })
}

#[test]
fn random_motions_stay_inside_and_keep_the_limits() {
    let mut rng = Random::new(81);
    let (mut longer, mut none) = (Vec::new(), 0);
    for i in 0..600 {
        let (case, positions) = ranged_case(&mut rng);
        let free = case.solve().unwrap();
        match BoundedProblem::new(&case.start, &case.target, &case.limits(), &positions) {
            Ok(problem) => {
                let motion = problem.shortest();
                assert!(motion.duration() >= free.duration() * (1.0 - 1e-12), "case {i}");
                longer.push(motion.duration() / free.duration());
                let wrong = fault(&case, &motion);
                assert!(wrong.is_none(), "case {i}: {} {case:?} {positions:?}", wrong.unwrap());
                assert!(samples_inside(&motion, &positions), "case {i}: {case:?} {positions:?}");
            }
            Err(e) => {
                if none < 5 {
                    println!("case {i}: {e}: {case:?} {positions:?}");
                }
                none += 1;
            }
        }
    }
    longer.sort_by(f64::total_cmp);
    let n = longer.len();
    println!("{n} bent, {none} refused; longer by median {} worst {}", longer[n / 2], longer[n - 1]);
    assert!(none == 0);
}
