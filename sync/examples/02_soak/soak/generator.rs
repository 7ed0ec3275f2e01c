//! The online generator in all modes, with targets, limits and ranges that change.
//!
//! Judged from the samples alone: every step is possible within the limits; an axis arrives in its target exactly, in the cycle
//! whose event says so, and no later than promised; after it the velocity stays what it is once the acceleration is zero, unless
//! the range ends; no position leaves its range; from rest to rest the line is straight; a setting is refused only for a reason.

use arcfeed_sync::feedrate::AxisState;
use arcfeed_sync::{Events, OnlineGenerator, SyncError, Synchronisation};

use super::generator_input::{AXES, Kind, Limits, Scene, States, printed};
use super::judge::{Precision, broken, stays_inside, velocity_at_zero_acceleration};
use arcfeed_testing::Random;

use super::{Failure, Outcome, random};

/// The part of a limit by which it may be exceeded.
const EXACT: f64 = 1e-12;

/// Cycles after which nothing changes any more.
const QUIET: u64 = 800;

/// What was set last, from where, for the report.
#[derive(Debug, Clone, Copy)]
struct Setting {
    from: States,
    target: States,
    limits: Limits,
    /// Cycles since.
    age: u64,
}

/// One case while it is played.
struct Play {
    scene: Scene,
    generator: OnlineGenerator<AXES>,
    now: States,
    limits: Limits,
    /// The target of the axes that have still to arrive.
    due: [Option<AxisState>; AXES],
    /// The velocity at which an axis that has arrived is to stay.
    cruise: [f64; AXES],
    /// Seconds until everything is to have arrived.
    promised: f64,
    /// Both ends of a line on which all axes must be.
    line: Option<(States, States)>,
    setting: Setting,
}

pub fn case(seed: u64) -> Outcome {
    let mut rng = random(seed);
    let scene = Scene::new(&mut rng);
    let mut outcome = Outcome::default();
    let made = OnlineGenerator::new(scene.start, scene.limits, scene.cycle, scene.mode)
        .and_then(|g| scene.ranges.map_or(Ok(g.clone()), |r| g.with_ranges(r)));
    let generator = match made {
        Ok(generator) => generator,
        // A start that moves may be unable to stop inside its range.
        Err(SyncError::CannotStop { .. }) => {
            outcome.see("start refused: cannot stop inside its range");
            return outcome;
        }
        Err(e) => {
            let input = format!("{e}\n{scene:?}");
            outcome.failure = Some(("a start is refused".to_owned(), Failure { size: 1.0, seed, input }));
            return outcome;
        }
    };
    let cruise = std::array::from_fn(|k| cruise_after(&scene.start[k], &scene, &scene.limits, k));
    let setting = Setting { from: scene.start, target: scene.start, limits: scene.limits, age: 0 };
    let mut play = Play {
        generator,
        now: scene.start,
        limits: scene.limits,
        due: [None; AXES],
        cruise,
        promised: 0.0,
        line: None,
        setting,
        scene,
    };
    let horizon = QUIET + 700 + rng.below(1500) as u64;
    for cycle in 0..horizon {
        outcome.counted += 1;
        let change = if cycle + QUIET < horizon { play.change(cycle, &mut rng, &mut outcome) } else { Ok(()) };
        if let Err((what, size)) = change.and_then(|()| play.cycle(&mut outcome)) {
            let kind = format!("[{:?}, {:?}] {what}", play.scene.mode, play.scene.kind);
            outcome.failure = Some((kind, Failure { size, seed, input: play.code() }));
            break;
        }
    }
    outcome
}

type Verdict = Result<(), (String, f64)>;

fn wrong(what: &str, size: f64) -> Verdict {
    Err((what.to_owned(), size))
}

/// The velocity an axis keeps after `s`; not a number where that cannot be told.
fn cruise_after(s: &AxisState, scene: &Scene, limits: &Limits, k: usize) -> f64 {
    let v = velocity_at_zero_acceleration(s, &limits[k]);
    let moves_against = scene.ranges.is_some() && s.a != 0.0;
    if stays_inside(s, &limits[k], EXACT) && !moves_against { v } else { f64::NAN }
}

impl Play {
    fn change(&mut self, cycle: u64, rng: &mut Random, outcome: &mut Outcome) -> Verdict {
        let scene = self.scene;
        let often = match scene.kind {
            Kind::Wave => true,
            Kind::Limits => cycle.is_multiple_of(3),
            _ => cycle == 0 || rng.chance(0.02),
        };
        if !often {
            return Ok(());
        }
        let mut target = *self.generator.target();
        let mut limits = self.limits;
        if scene.kind != Kind::Limits && scene.kind != Kind::Wave && rng.chance(0.3) {
            limits = scene.any_limits(rng);
        }
        match scene.kind {
            Kind::Rest => target = std::array::from_fn(|k| AxisState::rest(scene.place(k, rng))),
            Kind::Moving => target = std::array::from_fn(|k| scene.moving(k, &limits[k], rng)),
            Kind::Wave => target = scene.on_wave(&limits, cycle as f64 * scene.cycle),
            Kind::Limits => {
                limits = scene.drifted(&limits, rng);
                if rng.chance(0.02) {
                    target = std::array::from_fn(|k| AxisState::rest(scene.place(k, rng)));
                }
            }
            Kind::Tiny => {
                let size = rng.log(1e-16, 1e-6);
                target = self.now.map(|s| AxisState::rest(s.p + rng.sign() * size));
            }
            Kind::StopHere => {
                target = if rng.chance(0.5) {
                    printed(&self.now, 9 + rng.below(8))
                } else {
                    std::array::from_fn(|k| AxisState::rest(scene.place(k, rng)))
                };
            }
            Kind::Single => {
                let k = rng.below(AXES);
                if rng.chance(0.5) {
                    limits = self.limits;
                    target[k] = scene.moving(k, &limits[k], rng);
                } else {
                    let other = scene.any_limits(rng);
                    limits = self.limits;
                    limits[k] = other[k];
                }
            }
        }
        self.set(target, limits, outcome)
    }

    fn set(&mut self, target: States, limits: Limits, outcome: &mut Outcome) -> Verdict {
        let before = *self.generator.target();
        if let Err(e) = self.generator.set(target, limits) {
            return self.refused(&e, &target, &limits, outcome);
        }
        outcome.see("settings taken");
        for k in 0..AXES {
            let taken = *self.generator.target();
            let alone = self.scene.mode == Synchronisation::None;
            let undisturbed = taken[k] == before[k] && (alone || taken == before);
            if (target[k].p - taken[k].p).abs() > 1e-14 * (target[k].p.abs() + self.now[k].p.abs()) {
                return wrong("a target is not taken", (target[k].p - taken[k].p).abs());
            }
            if !undisturbed || self.due[k].is_some() {
                self.due[k] = Some(self.generator.target()[k]);
            } else if limits[k] != self.limits[k] || !alone && limits != self.limits {
                // It goes on from where it is. What limits held down goes back to the velocity of its target once they allow that: from
                // then on its velocity cannot be told until it arrives anew.
                if !self.cruise[k].is_nan() {
                    self.cruise[k] = cruise_after(&self.now[k], &self.scene, &limits, k);
                }
            }
        }
        self.limits = limits;
        self.promised = self.generator.time_left();
        self.setting = Setting { from: self.now, target, limits, age: 0 };
        let still = |all: &States| all.iter().all(|s| s.v == 0.0 && s.a == 0.0);
        let lines = self.scene.mode == Synchronisation::StraightLine;
        self.line = (lines && still(&self.now) && still(&target)).then_some((self.now, target));
        // A setting that is the same up to round-off leaves what has arrived where it is.
        if !self.generator.is_underway() {
            self.due = [None; AXES];
        }
        Ok(())
    }

    /// Whether there is a reason that shows in the input.
    fn refused(&self, e: &SyncError, target: &States, limits: &Limits, outcome: &mut Outcome) -> Verdict {
        let places = |f: &dyn Fn(usize, f64, f64) -> bool| {
            self.scene.ranges.is_some_and(|ranges| (0..AXES).any(|k| f(k, ranges[k].0, ranges[k].1)))
        };
        let entered = |k: usize| {
            let (t, l) = (&target[k], &limits[k]);
            let back = AxisState::new(t.p, t.v, -t.a);
            // Backwards in time the way in is a way out, with the signs of acceleration exchanged.
            let Ok(mirrored) = arcfeed_sync::feedrate::AxisLimits::new(
                (l.v_min(), l.v_max()),
                (-l.a_max(), -l.a_min()),
                (l.j_min(), l.j_max()),
            ) else {
                return false;
            };
            stays_inside(t, l, EXACT) && stays_inside(&back, &mirrored, EXACT)
        };
        let moves = self.now.iter().any(|s| s.v != 0.0 || s.a != 0.0) || target.iter().any(|t| t.v != 0.0);
        let (reason, what) = match e {
            SyncError::OutsideRange { .. } => (places(&|k, lo, hi| target[k].p < lo || target[k].p > hi), "outside"),
            SyncError::LeavesRange { .. } => (places(&|_, _, _| moves), "would leave its range"),
            SyncError::CannotStop { .. } => (places(&|_, _, _| moves), "cannot stop inside its range"),
            SyncError::State { .. } => ((0..AXES).any(|k| !entered(k)), "beyond the limits"),
            _ => (false, "another reason"),
        };
        outcome.see(&format!("settings refused: {what}"));
        if reason { Ok(()) } else { wrong(&format!("refused without a reason: {e} for {target:?} {limits:?}"), 1.0) }
    }

    fn cycle(&mut self, outcome: &mut Outcome) -> Verdict {
        let dt = self.scene.cycle;
        // On a line an axis has the round-off of the one it is in proportion to.
        let line = self.generator.plan().is_straight();
        let step = self.generator.step();
        self.setting.age += 1;
        self.promised -= dt;
        let was = self.now;
        let size = if line { was.iter().fold(0.0, |m: f64, s| m.max(s.p.abs())) } else { 0.0 };
        let precision = Precision { slack: EXACT, size };
        for k in 0..AXES {
            self.now[k] = AxisState::new(step.state.q[k], step.state.qd[k], step.state.qdd[k]);
            if let Some((what, size)) = broken(&was[k], &self.now[k], dt, &self.limits[k], precision) {
                let late = if step.events.arrived[k] { " on arrival" } else { "" };
                return wrong(&format!("{what}{late}, axis {k}: {:?} -> {:?}", was[k], self.now[k]), size);
            }
            if !step.events.outside_limits && !stays_inside(&self.now[k], &self.limits[k], EXACT) {
                return wrong("outside its limits without an event", 1.0);
            }
            if let Some(ranges) = &self.scene.ranges {
                let p = self.now[k].p;
                if !(ranges[k].0 <= p && p <= ranges[k].1) {
                    return wrong("outside its range", (p - ranges[k].1).max(ranges[k].0 - p));
                }
            }
            self.arrival(k, &was[k], &step.events, outcome)?;
        }
        let all = self.due.iter().all(Option::is_none);
        if step.events.reached != (step.events.arrived.contains(&true) && all) {
            return wrong("`reached` is not the arrival of the last axis", 1.0);
        }
        if !all && self.promised < -0.5 * dt {
            return wrong("arrives later than promised", -self.promised);
        }
        match self.off_line() {
            Some(off) if !all => wrong("off the line from rest to rest", off),
            _ => Ok(()),
        }
    }

    fn arrival(&mut self, k: usize, was: &AxisState, events: &Events<AXES>, outcome: &mut Outcome) -> Verdict {
        let now = self.now[k];
        if events.arrived[k] {
            let Some(target) = self.due[k].take() else { return wrong("arrives without a target", 1.0) };
            outcome.see("arrivals");
            if now != target && self.setting.age > 1 {
                return wrong("arrives beside its target", (now.p - target.p).abs());
            }
            self.cruise[k] = cruise_after(&now, &self.scene, &self.limits, k);
            return Ok(());
        }
        if events.range_ends[k] {
            outcome.see("cycles of braking before the end of the range");
            self.cruise[k] = f64::NAN;
        }
        let size = self.limits[k].v_max() - self.limits[k].v_min();
        if self.due[k].is_none() && was.a == 0.0 && (now.v - self.cruise[k]).abs() > 1e-9 * size {
            return wrong("does not go on at constant velocity", (now.v - self.cruise[k]).abs() / size);
        }
        Ok(())
    }

    /// How far the axes are off the line, if that is more than round-off.
    fn off_line(&self) -> Option<f64> {
        let (from, to) = self.line.as_ref()?;
        let way = |k: usize| to[k].p - from[k].p;
        let gone = |k: usize| self.now[k].p - from[k].p;
        let m = (0..AXES).fold(0, |m, k| if way(k).abs() > way(m).abs() { k } else { m });
        let off = (0..AXES).map(|k| (gone(k) - gone(m) * way(k) / way(m)).abs()).fold(0.0, f64::max);
        let size = from.iter().chain(to).fold(1.0, |m: f64, s| m.max(s.p.abs()));
        (off > 1e-13 * size).then_some(off)
    }

    /// The last setting as code.
    fn code(&self) -> String {
        let states = |all: &States| {
            let each: Vec<String> =
                all.iter().map(|s| format!("AxisState::new({:?}, {:?}, {:?})", s.p, s.v, s.a)).collect();
            format!("[{}]", each.join(", "))
        };
        let limits: Vec<String> = self
            .setting
            .limits
            .iter()
            .map(|l| {
                let pairs = [(l.v_min(), l.v_max()), (l.a_min(), l.a_max()), (l.j_min(), l.j_max())];
                format!("AxisLimits::new({:?}, {:?}, {:?})?", pairs[0], pairs[1], pairs[2])
            })
            .collect();
        let ranges = self.scene.ranges.map_or(String::new(), |r| format!(".with_ranges({r:?})?"));
        format!(
            "let mut g = OnlineGenerator::new({}, [{}], {:?}, Synchronisation::{:?})?{ranges};\n\
             g.set_target({})?;\nfor _ in 0..{} {{ g.step(); }}",
            states(&self.setting.from),
            limits.join(", "),
            self.scene.cycle,
            self.scene.mode,
            states(&self.setting.target),
            self.setting.age
        )
    }
}
