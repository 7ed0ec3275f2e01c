//! Straight lines: where the displacement is round-off, and where the axes have less jerk together than alone.
#![allow(clippy::unwrap_used)]
use arcfeed_sync::feedrate::{AxisLimits, AxisState, MotionLaw};
use arcfeed_sync::{MotionOptions, OnlineGenerator, SyncError, Synchronisation, Trajectory};

use crate::common;
use arcfeed_testing::Random;
use common::{Problem, check};

fn line<const N: usize>(p: &Problem<N>) -> Trajectory<N> {
    Trajectory::new(&p.start, &p.target, &p.limits, &MotionOptions::new(Synchronisation::StraightLine)).unwrap()
}

/// `--from-deg 10 20 --from-deg-s 30 -50 --to-deg 10.000000000000002 20 --mode line`: joint 2 began with 0 instead of -50 deg/s,
/// because the displacement of one unit in the last place was taken for the direction of the line.
#[test]
fn a_displacement_of_round_off_was_taken_for_the_direction() {
    let r = f64::to_radians;
    let start = [AxisState::new(r(10.0), r(30.0), 0.0), AxisState::new(r(20.0), r(-50.0), 0.0)];
    let target = [AxisState::rest(r(10.000000000000002)), AxisState::rest(r(20.0))];
    let limits = [AxisLimits::symmetric(r(180.0), r(573.0), r(5730.0)).unwrap(); 2];
    let p = Problem { start, target, limits };
    let motion = line(&p);
    let first = motion.at(0.0);
    assert!((first.qd[0] - start[0].v).abs() < 1e-15 && (first.qd[1] - start[1].v).abs() < 1e-15);
    check(&p, &motion).unwrap();
    // It brakes along its velocity and comes back on the same line.
    assert!(motion.is_straight());
    for n in 0..=100 {
        let s = motion.at(motion.duration() * f64::from(n) / 100.0);
        let (x, y) = (s.q[0] - start[0].p, s.q[1] - start[1].p);
        assert!((x * start[1].v - y * start[0].v).abs() < 1e-15);
    }
}

/// "Stop here" while moving on a line: joint 3 went from -1.03 to 1.36 rad/s within a millisecond. Stops along the present
/// direction, whichever way the place is rounded.
#[test]
fn stop_here_turned_a_joint_around_in_one_cycle() {
    let degrees = |q: [f64; 6]| q.map(|x| AxisState::rest(x.to_radians()));
    let limits = [AxisLimits::symmetric(std::f64::consts::PI, 10.0, 100.0).unwrap(); 6];
    let start = degrees([0.1, -30.0, 90.0, 30.0, -90.0, 0.0]);
    let target = degrees([60.1, 0.0, 60.0, 30.0, -90.0, 45.0]);
    let mut straight = 0;
    // Written in degrees with fifteen digits, and in radians with fewer and more.
    let written = [47.8219919151757, -6.13900404241213, 66.1390040424121, 30.0, -90.0, 35.7914939363818];
    for digits in 7..18 {
        let mut g = OnlineGenerator::new(start, limits, 1e-3, Synchronisation::StraightLine).unwrap();
        g.set_target(target).unwrap();
        for _ in 0..500 {
            g.step();
        }
        let here = match digits {
            7 => degrees(written),
            _ => g.state().map(|s| AxisState::rest(format!("{:.digits$e}", s.p).parse().unwrap())),
        };
        g.set_target(here).unwrap();
        straight += usize::from(g.plan().is_straight());
        let mut was = *g.state();
        loop {
            let step = g.step();
            for (k, l) in limits.iter().enumerate() {
                let jerk = (step.state.qdd[k] - was[k].a).abs() / 1e-3;
                assert!(jerk <= l.j_max() * (1.0 + 1e-6), "{digits} digits, joint {k}: jerk {jerk}");
                let jump = step.state.qd[k] - was[k].v - 0.5e-3 * (step.state.qdd[k] + was[k].a);
                assert!(jump.abs() <= l.j_max() * 1e-6 / 4.0 + 1e-14, "{digits} digits, joint {k}: jump {jump}");
            }
            was = *g.state();
            if step.events.reached {
                break;
            }
        }
        assert_eq!(*g.state(), here);
    }
    // Written to the last digit, the place is on the line.
    assert!(straight >= 1, "{straight}");
}

/// States near each other, in proportion or not, at all sizes of the displacement: each axis starts as it is.
#[test]
fn states_off_the_line_are_never_treated_as_on_it() {
    let mut rng = Random::new(81);
    let mut straight = 0;
    for i in 0..100_000 {
        let limits: [AxisLimits; 3] = std::array::from_fn(|_| {
            AxisLimits::symmetric(rng.log(0.3, 5.0), rng.log(1.0, 20.0), rng.log(10.0, 1000.0)).unwrap()
        });
        let ratios: [f64; 3] = std::array::from_fn(|_| rng.between(-0.9, 0.9));
        let (v, a) = (rng.between(-0.25, 0.25), if i % 2 == 0 { 0.0 } else { rng.between(-0.5, 0.5) });
        let size = rng.log(1e-18, 1e-3);
        let off = if i % 3 == 0 { 0.0 } else { rng.log(1e-18, 1e-3) };
        let start: [AxisState; 3] = std::array::from_fn(|k| {
            AxisState::new(rng.between(-2.0, 2.0), ratios[k] * v + if i % 5 == 0 { off } else { 0.0 }, ratios[k] * a)
        });
        let target =
            std::array::from_fn(|k| AxisState::rest(start[k].p + ratios[k] * size + off * rng.between(-1.0, 1.0)));
        let p = Problem { start, target, limits };
        let motion = line(&p);
        straight += usize::from(motion.is_straight());
        for k in 0..3 {
            let (first, s, l) = (motion.axes()[k].at(0.0), &start[k], &limits[k]);
            assert!(
                (first.v - s.v).abs() <= 1e-14 * l.v_max() && (first.a - s.a).abs() <= 1e-14 * l.a_max(),
                "case {i}: {p:?}"
            );
        }
        check(&p, &motion).unwrap_or_else(|e| panic!("case {i}: {e}: {p:?}"));
    }
    assert!(straight > 10_000, "{straight}");
}

/// Together the axes have the jerk of the weakest one: an axis whose acceleration its own jerk takes back in time went beyond its
/// velocity limit, by up to 6 % where limits changed on the way.
#[test]
fn on_the_line_an_axis_exceeded_its_velocity_with_the_jerk_of_another() {
    // Axis 1 alone settles at 0.9 + 2² / (2 · 1000) = 0.902; with the jerk of axis 2 at 0.9 + 2² / (2 · 10) = 1.1.
    let limits = [AxisLimits::symmetric(1.0, 10.0, 1000.0).unwrap(), AxisLimits::symmetric(2.0, 10.0, 10.0).unwrap()];
    let start = [AxisState::new(0.0, 0.9, 2.0), AxisState::new(0.0, 0.9, 2.0)];
    let target = [AxisState::rest(3.0), AxisState::rest(3.0)];
    let p = Problem { start, target, limits };
    let motion = line(&p);
    check(&p, &motion).unwrap();
    assert!(!motion.is_straight());
    let refused = p.solve(Synchronisation::ForcedStraight).unwrap_err();
    assert_eq!(refused, SyncError::LineExceeds { axis: 0 });
    // With less acceleration the line is possible.
    let start = start.map(|s| AxisState::new(s.p, s.v, 0.5));
    assert!(p.solve(Synchronisation::Time).is_ok());
    assert!(Problem { start, target, limits }.solve(Synchronisation::ForcedStraight).unwrap().is_straight());
}

/// An acceleration beyond its limit was taken back with the jerk of another axis, and the velocity went beyond its own limit.
#[test]
fn on_the_line_an_acceleration_was_taken_back_too_slowly_for_the_velocity() {
    let limits = [AxisLimits::symmetric(1.0, 1.9, 1000.0).unwrap(), AxisLimits::symmetric(2.0, 10.0, 10.0).unwrap()];
    let start = [AxisState::new(0.0, 0.9, 2.0); 2];
    let p = Problem { start, target: [AxisState::rest(3.0); 2], limits };
    let motion = line(&p);
    let fastest = (0..=1000).map(|n| motion.at(motion.duration() * f64::from(n) / 1000.0).qd[0]).fold(0.0, f64::max);
    assert!(fastest <= 1.0 + 1e-12, "{fastest}");
    // A velocity beyond its limit is brought back on the line: nothing else is there earlier.
    let limits = [AxisLimits::symmetric(0.5, 10.0, 1000.0).unwrap(), limits[1]];
    let start = [AxisState::new(0.0, 0.9, 0.0); 2];
    assert!(line(&Problem { start, target: [AxisState::rest(3.0); 2], limits }).is_straight());
}
