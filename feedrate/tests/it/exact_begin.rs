//! A motion begins in its start, to the last bit: round-off is where its halves meet, or at its end.
#![allow(clippy::unwrap_used)]
use arcfeed_feedrate::{AxisLimits, AxisProblem, AxisState, MotionLaw, StateToState};
use arcfeed_testing::Random;

use crate::common::axis::random_case;

fn begin(motion: &StateToState) -> AxisState {
    let s = motion.at(0.0);
    AxisState::new(s.p, s.v, s.a)
}

/// Such a motion has one phase, which was written backward from the target: it began up to the round-off of the whole way beside
/// its start, and so did a section of a route.
#[test]
fn a_motion_at_full_acceleration_throughout_begins_in_its_start() {
    let mut rng = Random::new(41);
    let mut ends = 0;
    for case in 0..20_000 {
        let limits = AxisLimits::new((-9.0, 8.0), (-rng.log(1.0, 9.0), rng.log(1.0, 9.0)), (-50.0, 60.0)).unwrap();
        let a = rng.one_of(&[limits.a_min(), limits.a_max()]);
        let start = AxisState::new(rng.between(-2.0, 2.0), rng.between(-3.0, 3.0), a);
        let t = rng.log(1e-6, 0.3);
        let target = AxisState::new(start.p + t * (start.v + 0.5 * t * a), start.v + t * a, a);
        let motion = StateToState::new(&start, &target, &limits).unwrap();
        assert_eq!(begin(&motion), start, "case {case}: {target:?} {limits:?}");
        let end = motion.phases().last().map(|(phase, dt)| phase.after(dt)).unwrap();
        assert!(
            (end.p - target.p).abs() < 1e-14 && (end.v - target.v).abs() < 1e-14,
            "case {case}: {end:?} {target:?}"
        );
        ends += usize::from(motion.phases().len() == 1);
    }
    assert!(ends > 5000, "{ends}");
}

/// Starts inside, in the shortest time and in others.
#[test]
fn random_motions_begin_in_their_start() {
    let mut rng = Random::new(42);
    let (mut shortest, mut longer) = (0, 0);
    for number in 0..100_000 {
        let case = random_case(&mut rng, false);
        let limits = case.limits();
        let Ok(problem) = AxisProblem::new(&case.start, &case.target, &limits) else { continue };
        if problem.shortest_duration() > 0.0 {
            assert_eq!(begin(&problem.shortest()), case.start, "case {number}: {case:?}");
            shortest += 1;
        }
        let t = problem.shortest_duration() * rng.between(1.0, 3.0);
        if let Ok(motion) = problem.with_duration(t) {
            assert_eq!(begin(&motion), case.start, "case {number} in {t}: {case:?}");
            longer += 1;
        }
    }
    assert!(shortest > 99_000 && longer > 90_000, "{shortest} {longer}");
}
