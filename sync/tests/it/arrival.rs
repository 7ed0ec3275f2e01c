//! What happens on arrival and after it: axes that arrive at different times, targets with velocity and acceleration.
#![allow(clippy::unwrap_used)]
use arcfeed_sync::feedrate::{AxisLimits, AxisState, FeedError, MotionLaw};
use arcfeed_sync::{MotionOptions, OnlineGenerator, SyncError, Synchronisation, Trajectory};

use crate::common;
use arcfeed_testing::Random;
use common::moving_problem;

const CYCLE: f64 = 1e-3;

fn degrees(p: f64, v: f64, a: f64) -> AxisState {
    AxisState::new(p.to_radians(), v.to_radians(), a.to_radians())
}

fn arm() -> [AxisLimits; 2] {
    [AxisLimits::symmetric(100f64.to_radians(), 500f64.to_radians(), 5000f64.to_radians()).unwrap(); 2]
}

/// The largest jerk by differences, as a part of its limit, and the largest jump of the position.
fn roughness(samples: &[AxisState], dt: f64, jerk: f64) -> (f64, f64) {
    samples.windows(2).fold((0.0_f64, 0.0_f64), |(j, jump), w| {
        let off = (w[1].p - w[0].p - 0.5 * dt * (w[0].v + w[1].v)).abs();
        (j.max((w[1].a - w[0].a).abs() / dt / jerk), jump.max(off))
    })
}

/// Joint 1 arrives with 20 deg/s in 0.35 s, joint 2 in 1.2 s: joint 1 jumped back by 17 degrees then.
#[test]
fn independent_axis_jumped_back_17_degrees_when_the_last_one_arrived() {
    let start = [AxisState::rest(0.0); 2];
    let target = [degrees(10.0, 20.0, 0.0), degrees(90.0, 0.0, 0.0)];
    let mut g = OnlineGenerator::new(start, arm(), CYCLE, Synchronisation::None).unwrap();
    g.set_target(target).unwrap();
    let mut samples = [vec![start[0]], vec![start[1]]];
    let mut arrivals = [None; 2];
    for n in 1..2000 {
        let step = g.step();
        for k in 0..2 {
            samples[k].push(AxisState::new(step.state.q[k], step.state.qd[k], step.state.qdd[k]));
            if step.events.arrived[k] {
                assert_eq!((samples[k][n], arrivals[k]), (target[k], None));
                arrivals[k] = Some(n);
            }
        }
        assert_eq!(step.events.reached, step.events.arrived[1], "the last one to arrive is joint 2");
    }
    for (axis, l) in samples.iter().zip(arm()) {
        let (jerk, jump) = roughness(axis, CYCLE, l.j_max());
        assert!(jerk <= 1.0 + 1e-6 && jump <= l.j_max() * CYCLE.powi(3) / 12.0 + 1e-14, "jerk {jerk}, jump {jump}");
    }
    let early = arrivals[0].unwrap();
    assert!(early < arrivals[1].unwrap());
    let gone = (1999 - early) as f64 * CYCLE * 20f64.to_radians();
    assert!((samples[0][1999].p - target[0].p - gone).abs() < 1e-12);
}

/// An axis that had arrived with 300 deg/s² went on without acceleration: 5163 % of the jerk limit.
#[test]
fn early_axis_dropped_its_acceleration_with_52_times_its_jerk_limit() {
    let target = [degrees(10.0, 20.0, 300.0), degrees(90.0, 0.0, 0.0)];
    let options = MotionOptions::new(Synchronisation::None);
    let motion = Trajectory::new(&[AxisState::rest(0.0); 2], &target, &arm(), &options).unwrap();
    let early = motion.axes()[0].duration();
    assert!(early + 0.1 < motion.duration());
    let samples: Vec<AxisState> = (0..=(motion.duration() / CYCLE) as usize)
        .map(|n| motion.at(n as f64 * CYCLE))
        .map(|s| AxisState::new(s.q[0], s.qd[0], s.qdd[0]))
        .collect();
    let (jerk, jump) = roughness(&samples, CYCLE, arm()[0].j_max());
    assert!(jerk <= 1.0 + 1e-6 && jump <= 1e-8, "jerk {jerk}, jump {jump}");
    // 300² / (2 · 5000) = 9 deg/s more, after 60 ms.
    let end = motion.at(motion.duration());
    assert!((end.qd[0].to_degrees() - 29.0).abs() < 1e-9 && end.qdd[0] == 0.0);
    let after = motion.at(early + 0.06 - 1e-9);
    assert!((after.qd[0].to_degrees() - 29.0).abs() < 1e-6 && after.qdd[0] > 0.0);
}

#[test]
fn a_target_that_cannot_be_left_within_the_limits_is_refused() {
    // With its acceleration the velocity goes on to 95 + 9 deg/s.
    let target = [degrees(10.0, 95.0, 300.0), degrees(90.0, 0.0, 0.0)];
    let start = [AxisState::rest(0.0); 2];
    let overshoots = |e: &SyncError| {
        matches!(e, SyncError::State { axis: 0, source: FeedError::TargetOvershoots { after, .. } }
            if (after.to_degrees() - 104.0).abs() < 1e-9)
    };
    let independent = MotionOptions::new(Synchronisation::None);
    assert!(overshoots(&Trajectory::new(&start, &target, &arm(), &independent).unwrap_err()));
    // The end of a motion by itself is a state like any other.
    Trajectory::new(&start, &target, &arm(), &MotionOptions::default()).unwrap();
    for mode in [Synchronisation::Time, Synchronisation::None, Synchronisation::StraightLine] {
        let mut g = OnlineGenerator::new(start, arm(), CYCLE, mode).unwrap();
        let e = g.set_target(target).unwrap_err();
        assert!(overshoots(&e), "{mode:?}: {e}");
        assert!(!g.is_underway());
    }
}

/// With independent axes each one moves as if it were alone, whatever the others are told.
#[test]
fn independent_axes_do_not_disturb_each_other() {
    let mut rng = Random::new(71);
    for _ in 0..200 {
        let p = moving_problem::<3>(&mut rng, 0.7);
        let mut all = OnlineGenerator::new(p.start, p.limits, CYCLE, Synchronisation::None).unwrap();
        let mut each: [OnlineGenerator<1>; 3] = std::array::from_fn(|k| {
            OnlineGenerator::new([p.start[k]], [p.limits[k]], CYCLE, Synchronisation::None).unwrap()
        });
        let mut done = [false; 3];
        for _ in 0..1500 {
            if rng.unit() < 0.02 {
                let k = (3.0 * rng.unit()) as usize;
                let other = moving_problem::<3>(&mut rng, 0.7);
                if rng.unit() < 0.7 {
                    let target = AxisState::rest(other.target[k].p);
                    assert_eq!(all.set_axis_target(k, target), Ok(()));
                    assert_eq!(each[k].set_axis_target(0, target), Ok(()));
                } else {
                    let taken = all.set_axis_limits(k, other.limits[k]).is_ok();
                    assert_eq!(taken, each[k].set_axis_limits(0, other.limits[k]).is_ok());
                }
                done[k] = false;
            }
            let step = all.step();
            for k in 0..3 {
                let alone = each[k].step();
                assert_eq!(step.state.q[k], alone.state.q[0]);
                assert_eq!((step.state.qd[k], step.state.qdd[k]), (alone.state.qd[0], alone.state.qdd[0]));
                assert_eq!(step.events.arrived[k], alone.events.reached);
                done[k] |= alone.events.reached;
            }
        }
        assert_eq!(all.is_underway(), each.iter().any(OnlineGenerator::is_underway));
    }
}

/// All axes are in their targets in the cycle of `reached` where they arrive together; with independent axes each is in its own
/// arrival cycle.
#[test]
fn every_axis_is_exactly_in_its_target_when_it_arrives() {
    let mut rng = Random::new(72);
    for i in 0..600 {
        let p = moving_problem::<3>(&mut rng, 0.8);
        let mode = [Synchronisation::None, Synchronisation::Time, Synchronisation::StraightLine][i % 3];
        let mut g = OnlineGenerator::new(p.start, p.limits, CYCLE, mode).unwrap();
        if g.set_target(p.target).is_err() {
            continue;
        }
        let mut left = [true; 3];
        while left.contains(&true) {
            assert!(g.is_underway());
            let step = g.step();
            for (k, due) in left.iter_mut().enumerate() {
                if step.events.arrived[k] {
                    assert!(*due);
                    *due = false;
                    assert_eq!(g.state()[k], p.target[k]);
                }
            }
            assert_eq!(step.events.reached, !left.contains(&true));
            assert!(mode == Synchronisation::None || step.events.reached == step.events.arrived[0]);
        }
    }
}
