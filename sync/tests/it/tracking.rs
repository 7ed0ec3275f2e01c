//! Several axes after a moving target: ramps, sinusoids, steps and noise.
#![allow(clippy::unwrap_used)]

use arcfeed_sync::feedrate::{AxisLimits, AxisState, FeedError, TrackStatus};
use arcfeed_sync::{SyncError, TrackingGenerator};
use arcfeed_testing::Random;

const CYCLE: f64 = 1e-3;

fn limits() -> [AxisLimits; 3] {
    [(2.0, 10.0, 200.0), (1.0, 8.0, 100.0), (3.0, 20.0, 400.0)].map(|(v, a, j)| AxisLimits::symmetric(v, a, j).unwrap())
}

/// Plays a target, checks every cycle by differences, and returns the cycles without error.
fn play(cycles: u32, target: impl Fn(f64) -> [AxisState; 3]) -> (u32, TrackingGenerator<3>) {
    let limits = limits();
    let mut tracking = TrackingGenerator::new(&[AxisState::rest(0.0); 3], &limits, CYCLE).unwrap();
    let mut following = 0;
    for n in 1..=cycles {
        let (was, goal) = (tracking.state(), target(f64::from(n) * CYCLE));
        let step = tracking.step(&goal).unwrap();
        following += u32::from(step.is_following());
        for (k, l) in limits.iter().enumerate() {
            let now = tracking.state()[k];
            assert_eq!((now.p, now.v, now.a), (step.state.q[k], step.state.qd[k], step.state.qdd[k]));
            assert!(step.status[k] != TrackStatus::Following || now == goal[k], "cycle {n}, axis {k}");
            assert!(l.contain(&now), "cycle {n}, axis {k}: {now:?}");
            assert!((now.a - was[k].a).abs() <= l.j_max() * CYCLE * (1.0 + 1e-9), "cycle {n}, axis {k}");
            let off = now.p - was[k].p - 0.5 * CYCLE * (was[k].v + now.v);
            assert!(off.abs() <= l.j_max() * CYCLE.powi(3) / 12.0 + 1e-13, "cycle {n}, axis {k}: {off}");
        }
    }
    (following, tracking)
}

#[test]
fn ramps_and_sinusoids_are_followed_without_error() {
    let (following, _) = play(3000, |t| {
        let wave = |size: f64, w: f64| {
            let (sin, cos) = (w * t).sin_cos();
            AxisState::new(size * sin, size * w * cos, -size * w * w * sin)
        };
        [AxisState::new(0.2 + 0.7 * t, 0.7, 0.0), wave(0.2, 2.0), wave(-0.1, 5.0)]
    });
    assert!(following > 2200, "{following} of 3000 cycles");
}

#[test]
fn steps_are_met_and_targets_beyond_the_limits_are_left_behind_in_order() {
    let (following, _) = play(4000, |t| {
        let place = if t < 2.0 { 0.3 } else { -0.2 };
        [AxisState::rest(place), AxisState::rest(2.0 * place), AxisState::rest(place)]
    });
    // The slowest axis takes 0.6 / 1 + 1 / 8 + 8 / 100 = 0.805 s, and 1.205 s for the step of 1.
    assert!((1988..=1993).contains(&following), "{following} of 4000 cycles");
    // The second axis is too slow for its target, the others are not.
    let (following, tracking) =
        play(3000, |t| [AxisState::new(t, 1.0, 0.0), AxisState::new(2.0 * t, 2.0, 0.0), AxisState::rest(0.1)]);
    let state = tracking.state();
    assert_eq!((following, state[0].v, state[1].v, state[2].p), (0, 1.0, 1.0, 0.1));
}

#[test]
fn noise_keeps_the_limits() {
    let noise: Vec<[f64; 3]> = {
        let mut rng = Random::new(5);
        (0..3001).map(|_| std::array::from_fn(|_| rng.between(-1e-3, 1e-3))).collect()
    };
    let (_, tracking) = play(3000, |t| {
        let n = (t / CYCLE).round() as usize;
        std::array::from_fn(|k| AxisState::new(0.4 * t + noise[n][k], 0.4, 0.0))
    });
    for s in tracking.state() {
        assert!((s.p - 1.2).abs() < 0.05, "{s:?}");
    }
}

#[test]
fn what_is_not_finite_is_refused_by_axis_and_field_and_moves_nothing() {
    let limits = limits();
    let mut tracking = TrackingGenerator::new(&[AxisState::rest(0.0); 3], &limits, CYCLE).unwrap();
    tracking.step(&[AxisState::rest(0.5); 3]).unwrap();
    let was = tracking.state();
    let mut target = [AxisState::rest(0.5); 3];
    target[2].v = f64::NAN;
    let e = tracking.step(&target).unwrap_err();
    assert!(matches!(e, SyncError::State { axis: 2, source: FeedError::NotFinite { what: "target.v", .. } }), "{e}");
    assert_eq!(tracking.state(), was);
    let e = TrackingGenerator::new(&[AxisState::rest(0.0); 3], &limits, 0.0).unwrap_err();
    assert!(matches!(e, SyncError::Cycle { value: 0.0 }), "{e}");
    let start = [AxisState::rest(0.0), AxisState::new(0.0, f64::INFINITY, 0.0), AxisState::rest(0.0)];
    let e = TrackingGenerator::new(&start, &limits, CYCLE).unwrap_err();
    assert!(matches!(e, SyncError::State { axis: 1, source: FeedError::NotFinite { what: "start.v", .. } }), "{e}");
}
