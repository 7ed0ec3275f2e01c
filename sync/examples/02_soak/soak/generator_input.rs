//! Random input for the online generator.

use arcfeed_sync::Synchronisation;
use arcfeed_sync::feedrate::{AxisLimits, AxisState};

use arcfeed_testing::Random;

pub const AXES: usize = 3;
pub type States = [AxisState; AXES];
pub type Limits = [AxisLimits; AXES];

/// What changes on the way.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Kind {
    /// Targets at rest, now and then.
    Rest,
    /// Targets with velocity, half of them with acceleration.
    Moving,
    /// A target that follows a wave, in every cycle.
    Wave,
    /// Limits that drift, in every third cycle.
    Limits,
    /// Targets within round-off to micrometres of the present place.
    Tiny,
    /// Stop here: the present place, printed and read back.
    StopHere,
    /// Target or limits of single axes.
    Single,
}

const KINDS: [Kind; 7] = [Kind::Rest, Kind::Moving, Kind::Wave, Kind::Limits, Kind::Tiny, Kind::StopHere, Kind::Single];

/// The circumstances of one case.
#[derive(Debug, Clone, Copy)]
pub struct Scene {
    pub mode: Synchronisation,
    pub kind: Kind,
    pub cycle: f64,
    /// Limits many decades apart.
    hostile: bool,
    /// Not the same in both directions.
    skewed: bool,
    pub limits: Limits,
    pub ranges: Option<[(f64, f64); AXES]>,
    pub start: States,
    wave: (f64, f64),
}

impl Scene {
    pub fn new(rng: &mut Random) -> Self {
        let modes = [Synchronisation::Time, Synchronisation::StraightLine, Synchronisation::None];
        let mut scene = Self {
            mode: rng.one_of(&modes),
            kind: rng.one_of(&KINDS),
            cycle: rng.one_of(&[2.5e-4, 1e-3, 2e-3, 4e-3, 8e-3, 1e-2]),
            hostile: rng.chance(0.4),
            skewed: rng.chance(0.3),
            limits: [AxisLimits::symmetric(1.0, 1.0, 1.0).expect("above zero"); AXES],
            ranges: None,
            start: std::array::from_fn(|_| AxisState::rest(rng.between(-2.0, 2.0))),
            wave: (rng.between(0.2, 6.0), rng.log(1e-3, 1.0)),
        };
        scene.limits = scene.any_limits(rng);
        if rng.chance(0.3) {
            for (s, l) in scene.start.iter_mut().zip(&scene.limits) {
                let beyond = if rng.chance(0.3) { 2.0 } else { 0.9 };
                s.v = beyond * rng.between(l.v_min(), l.v_max());
                s.a = beyond * rng.between(l.a_min(), l.a_max());
            }
        }
        if rng.chance(0.4) {
            let tight = rng.chance(0.3);
            scene.ranges = Some(std::array::from_fn(|k| {
                let (lo, hi) = if tight { (1e-3, 0.3) } else { (0.3, 4.0) };
                (scene.start[k].p - rng.log(lo, hi), scene.start[k].p + rng.log(lo, hi))
            }));
        }
        scene
    }

    pub fn any_limits(&self, rng: &mut Random) -> Limits {
        std::array::from_fn(|_| {
            let (v, a, j) = if self.hostile {
                (rng.log(1e-2, 50.0), rng.log(0.1, 1e4), rng.log(1.0, 1e8))
            } else {
                (rng.log(0.3, 4.0), rng.log(1.0, 20.0), rng.log(10.0, 1000.0))
            };
            let mut pair = |x: f64| if self.skewed { (-x * rng.log(0.3, 3.0), x) } else { (-x, x) };
            AxisLimits::new(pair(v), pair(a), pair(j)).expect("on both sides of zero")
        })
    }

    /// Other limits close to the present ones.
    pub fn drifted(&self, now: &Limits, rng: &mut Random) -> Limits {
        now.map(|l| {
            let mut pair = |lo: f64, hi: f64| {
                let factor = rng.between(0.9, 1.1);
                (lo * factor, hi * factor)
            };
            AxisLimits::new(pair(l.v_min(), l.v_max()), pair(l.a_min(), l.a_max()), pair(l.j_min(), l.j_max()))
                .expect("on both sides of zero")
        })
    }

    /// A place anywhere, mostly inside the range; at its end, too.
    pub fn place(&self, k: usize, rng: &mut Random) -> f64 {
        let Some(ranges) = &self.ranges else { return rng.between(-2.0, 2.0) };
        let (lower, upper) = ranges[k];
        match rng.below(12) {
            0 => lower,
            1 => upper,
            2 => rng.between(lower - 0.1, upper + 0.1),
            _ => rng.between(lower, upper),
        }
    }

    /// A target with velocity, and half of the time with acceleration; some cannot be entered or left.
    pub fn moving(&self, k: usize, l: &AxisLimits, rng: &mut Random) -> AxisState {
        let p = self.place(k, rng);
        if rng.chance(0.2) {
            return AxisState::rest(p);
        }
        let v = rng.between(l.v_min(), l.v_max());
        AxisState::new(p, v, if rng.chance(0.5) { 0.0 } else { rng.between(l.a_min(), l.a_max()) })
    }

    /// A target for all axes, at rest or moving.
    pub fn target(&self, rest: bool, limits: &Limits, rng: &mut Random) -> States {
        std::array::from_fn(
            |k| {
                if rest { AxisState::rest(self.place(k, rng)) } else { self.moving(k, &limits[k], rng) }
            },
        )
    }

    /// The wave at time `t`, as far as the limits allow it to be followed.
    pub fn on_wave(&self, limits: &Limits, t: f64) -> States {
        let (w, mut size) = self.wave;
        for l in limits {
            size = size.min(0.8 * l.v_max().min(-l.v_min()) / w).min(0.8 * l.a_max().min(-l.a_min()) / (w * w));
        }
        std::array::from_fn(|k| {
            let x = w * t + k as f64;
            AxisState::new(self.start[k].p + size * x.sin(), size * w * x.cos(), 0.0)
        })
    }
}

/// Places written with so many digits, and read back.
pub fn printed(states: &States, digits: usize) -> States {
    states.map(|s| AxisState::rest(format!("{:.digits$e}", s.p).parse().unwrap_or(s.p)))
}
