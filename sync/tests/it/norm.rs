//! Limits on the norms of velocity and acceleration.
#![allow(clippy::unwrap_used)]

use arcfeed_sync::feedrate::{AxisLimits, AxisState, FeedError};
use arcfeed_sync::{NormLimits, OnlineGenerator, SyncError, Synchronisation};
use arcfeed_testing::Random;

fn free() -> [AxisLimits; 4] {
    [AxisLimits::symmetric(5.0, 40.0, 800.0).unwrap(); 4]
}

#[test]
fn the_norms_hold_while_targets_change_in_any_cycle() {
    let norm = NormLimits::new(&[0, 1, 3], 1.0, 6.0).unwrap();
    let limits = norm.limits(&free()).unwrap();
    assert_eq!(limits[2], free()[2]);
    let mut generator = OnlineGenerator::new([AxisState::rest(0.0); 4], limits, 1e-3, Synchronisation::Time).unwrap();
    let (mut rng, mut fastest, mut hardest) = (Random::new(3), 0.0_f64, 0.0_f64);
    for n in 0..60_000 {
        if n % 150 == 0 {
            generator.set_target(std::array::from_fn(|_| AxisState::rest(rng.between(-1.0, 1.0)))).unwrap();
        }
        let s = generator.step().state;
        let of = |x: [f64; 4]| (x[0] * x[0] + x[1] * x[1] + x[3] * x[3]).sqrt();
        fastest = fastest.max(of(s.qd.into()));
        hardest = hardest.max(of(s.qdd.into()));
    }
    assert!(fastest <= 1.0 && hardest <= 6.0, "{fastest} {hardest}");
    // Diagonals use the bound.
    assert!(fastest > 0.9 && hardest > 5.0, "{fastest} {hardest}");
}

#[test]
fn a_straight_motion_loses_what_the_documentation_says() {
    let mut rng = Random::new(4);
    for _ in 0..2000 {
        let d: [f64; 4] = std::array::from_fn(|_| if rng.chance(0.3) { 0.0 } else { rng.between(-1.0, 1.0) });
        let length = (d[0] * d[0] + d[1] * d[1] + d[3] * d[3]).sqrt();
        let norm = NormLimits::new(&[0, 1, 3], 1.0, 6.0).unwrap();
        // The speed along the line at which the first axis is at its limit.
        let reached = |limits: &[AxisLimits; 4]| {
            [0, 1, 3]
                .iter()
                .filter(|&&k| d[k] != 0.0)
                .map(|&k| limits[k].v_max() * length / d[k].abs())
                .fold(f64::INFINITY, f64::min)
        };
        let (along, equal) = (norm.limits_along(&free(), &d).unwrap(), norm.limits(&free()).unwrap());
        for limits in [along, equal] {
            let sum: f64 = [0, 1, 3].iter().map(|&k| limits[k].v_max().powi(2)).sum();
            let hard: f64 = [0, 1, 3].iter().map(|&k| limits[k].a_max().powi(2)).sum();
            assert!(sum <= 1.0 && hard <= 36.0);
        }
        if length > 0.0 {
            assert!(reached(&along) >= 1.0 / 1.08_f64.sqrt() - 1e-9, "{d:?}: {}", reached(&along));
            assert!(reached(&equal) >= 1.0 / 3.0_f64.sqrt() - 1e-9, "{d:?}: {}", reached(&equal));
        }
    }
}

#[test]
fn what_bounds_nothing_is_refused_by_name() {
    let e = NormLimits::<4>::new(&[0], f64::NAN, 1.0).unwrap_err();
    assert!(matches!(e, SyncError::Tool { what: "speed limit", .. }), "{e}");
    let e = NormLimits::<4>::new(&[0], 1.0, -1.0).unwrap_err();
    assert!(matches!(e, SyncError::Tool { what: "acceleration limit", value: -1.0, .. }), "{e}");
    let e = NormLimits::<4>::new(&[], 1.0, 1.0).unwrap_err();
    assert!(matches!(e, SyncError::Tool { what: "number of axes of the point", .. }), "{e}");
    let e = NormLimits::<4>::new(&[0, 4], 1.0, 1.0).unwrap_err();
    assert!(matches!(e, SyncError::NoSuchAxis { axis: 4, count: 4 }), "{e}");
}

#[test]
fn limits_that_cannot_be_lowered_are_refused_by_axis() {
    let mut limits = free();
    // Forward only: refused with the bound that is to blame, also where it is below its share already.
    for fastest in [5.0, 0.1] {
        limits[3] = AxisLimits::forward(fastest, (-40.0, 40.0), (-800.0, 800.0)).unwrap();
        let norm = NormLimits::new(&[0, 1, 3], 1.0, 6.0).unwrap();
        for error in [norm.limits(&limits).unwrap_err(), norm.limits_along(&limits, &[0.0, 0.0, 0.0, 1.0]).unwrap_err()]
        {
            let source = FeedError::NotBelowZero { what: "v_min", value: 0.0 };
            assert_eq!(error, SyncError::State { axis: 3, source });
            assert_eq!(error.to_string(), "axis 4: v_min is 0; it must be less than 0");
        }
        // An axis that is none of the point stays as it is.
        assert_eq!(NormLimits::new(&[0, 1], 1.0, 6.0).unwrap().limits(&limits).unwrap()[3], limits[3]);
    }
    // A bound whose shares are no numbers above 0.
    let norm = NormLimits::new(&[0, 1, 2, 3], f64::from_bits(1), 6.0).unwrap();
    assert!(matches!(norm.limits(&free()), Err(SyncError::State { axis: 0, .. })));
}
