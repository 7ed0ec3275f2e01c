//! Families of random cases.
//!
//! The first five are the distributions of ruckig's own suite (crate ruckig 0.19.4, `test/test_target.cpp`, MIT licence), with
//! other random numbers: positions normal with deviation 4, velocities and accelerations normal with deviation 0.8 or 0 in a
//! share of the cases, limits even from 0.08 to 16 above those of the target.

use arcfeed_feedrate::AxisState;
use arcfeed_testing::Random;

use crate::case::{AXES, Case, Interface};

/// Draws a case.
pub type Draw = fn(&mut Random) -> Case;

/// Name, seed and distribution.
pub const FAMILIES: [(&str, u64, Draw); 9] = [
    ("position-random-3, time", 42, |rng| position(rng, Interface::Position)),
    ("position-random-3, phase", 43, |rng| position(rng, Interface::Straight)),
    ("random-discrete-3", 44, discrete),
    ("random-3-high", 45, high),
    ("velocity-random-3", 46, velocity),
    ("limits and states x 1000", 47, large),
    ("moves of 1e-15, from rest to rest", 48, tiny),
    ("moves of 1e-15, in motion", 50, tiny_in_motion),
    ("jerk limits of 1e6", 49, stiff),
];

fn normal(rng: &mut Random, deviation: f64) -> f64 {
    deviation * (-2.0 * (1.0 - rng.unit()).ln()).sqrt() * (std::f64::consts::TAU * rng.unit()).cos()
}

fn sparse(rng: &mut Random, share: f64) -> f64 {
    let value = normal(rng, 0.8);
    if rng.chance(share) { value } else { 0.0 }
}

fn state(rng: &mut Random, share: [f64; 2]) -> AxisState {
    AxisState::new(normal(rng, 4.0), sparse(rng, share[0]), sparse(rng, share[1]))
}

fn position(rng: &mut Random, interface: Interface) -> Case {
    let start = std::array::from_fn(|_| state(rng, [0.9, 0.8]));
    let target: [AxisState; AXES] = std::array::from_fn(|_| state(rng, [0.7, 0.6]));
    let limits = target
        .map(|t| [rng.between(0.08, 16.0) + t.v.abs(), rng.between(0.08, 16.0) + t.a.abs(), rng.between(0.08, 16.0)]);
    Case { interface, start, target, limits }
}

/// ruckig has no velocity limit here, and arcfeed has one: it is out of reach.
fn velocity(rng: &mut Random) -> Case {
    let case = position(rng, Interface::Velocity);
    Case { limits: case.limits.map(|[v, a, j]| [1e3 + v, a, j]), ..case }
}

fn discrete(rng: &mut Random) -> Case {
    let whole = |rng: &mut Random| rng.below(3) as f64 - 1.0;
    let state = |rng: &mut Random| AxisState::new(whole(rng), whole(rng), whole(rng));
    let start = std::array::from_fn(|_| state(rng));
    let target: [AxisState; AXES] = std::array::from_fn(|_| state(rng));
    let limit = |rng: &mut Random| 1.0 + rng.below(2) as f64;
    let limits = target.map(|t| [limit(rng) + t.v.abs(), limit(rng) + t.a.abs(), limit(rng)]);
    Case { interface: Interface::Position, start, target, limits }
}

fn high(rng: &mut Random) -> Case {
    let start = std::array::from_fn(|_| state(rng, [0.1, 0.1]));
    let target: [AxisState; AXES] = std::array::from_fn(|_| state(rng, [0.1, 0.1]));
    let limit = |rng: &mut Random| rng.between(10.0, 1e6);
    let limits = target.map(|t| [limit(rng) + t.v.abs(), limit(rng) + t.a.abs(), limit(rng)]);
    Case { interface: Interface::Position, start, target, limits }
}

fn large(rng: &mut Random) -> Case {
    let case = position(rng, Interface::Position);
    let scale = |s: AxisState| AxisState::new(1e3 * s.p, 1e3 * s.v, 1e3 * s.a);
    Case {
        start: case.start.map(scale),
        target: case.target.map(scale),
        limits: case.limits.map(|l| l.map(|x| 1e3 * x)),
        ..case
    }
}

/// From rest to rest, less than the spacing of numbers near 1 away.
fn tiny(rng: &mut Random) -> Case {
    let start = [AxisState::default(); AXES];
    let target = start.map(|_| AxisState::rest(rng.sign() * rng.log(1e-16, 1e-14)));
    let limits = start.map(|_| [rng.between(0.08, 16.0), rng.between(0.08, 16.0), rng.between(0.08, 16.0)]);
    Case { interface: Interface::Position, start, target, limits }
}

/// The same way, and back in the state of motion of the start.
fn tiny_in_motion(rng: &mut Random) -> Case {
    let case = position(rng, Interface::Position);
    let within = |s: AxisState| AxisState::new(0.0, s.v, s.a);
    let start = case.target.map(within);
    let target = start.map(|s| AxisState::new(rng.sign() * rng.log(1e-16, 1e-14), s.v, s.a));
    Case { start, target, ..case }
}

fn stiff(rng: &mut Random) -> Case {
    let case = position(rng, Interface::Position);
    Case { limits: case.limits.map(|[v, a, _]| [v, a, 1e6]), ..case }
}
