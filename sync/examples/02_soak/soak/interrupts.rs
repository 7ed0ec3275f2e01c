//! The online generator while it is stopped, jogged, held, scaled and sent to other targets.
//!
//! Judged from the samples: every step is possible within the limits; a stop, a hold and a jog whose time is over end at rest in
//! the time they can take; a jog gets to its velocities; a stop on the path, a hold and a scale leave no curve that was planned.
//! With the changes of `changes` limits and ranges are set on the way, too.

use std::cell::RefCell;

use arcfeed_sync::feedrate::AxisState;
use arcfeed_sync::{
    OnlineGenerator, Route, Step, SyncError, Synchronisation, WayPoint, WayPointPlanner, WayPointTrajectory,
};
use arcfeed_testing::Random;

use super::curve::Curve;
use super::generator_input::{AXES, Limits, Scene, States};
use super::judge::{Precision, broken};
use super::{Failure, Outcome, random};

pub(super) type Verdict = Result<(), (String, f64)>;

/// What is expected of the cycles that follow.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Expect {
    Nothing,
    /// Rest, in so many cycles at most.
    Rest(u64),
    /// These velocities, in so many cycles.
    Jog([f64; AXES], u64),
}

pub(super) struct Play {
    pub(super) scene: Scene,
    pub(super) generator: OnlineGenerator<AXES, WayPointTrajectory<AXES>>,
    pub(super) now: States,
    pub(super) limits: Limits,
    /// The limits with which a stop on the path began that is not over.
    pub(super) path_limits: Option<Limits>,
    /// Axes stop in their shortest way.
    pub(super) braking: bool,
    pub(super) expect: Expect,
    /// The plan on whose curve the axes are.
    pub(super) curve: Option<Curve>,
    /// Limits were set on the way: axes may be outside.
    pub(super) lowered: bool,
    /// The scale that is set.
    scale: f64,
    pub(super) log: Vec<String>,
}

thread_local! {
    static PLANNER: RefCell<Box<WayPointPlanner<AXES>>> = RefCell::new(Box::default());
}

/// Commands without routes.
pub fn case(seed: u64) -> Outcome {
    play(seed, 9)
}

/// With routes through way-points, too.
pub fn routes(seed: u64) -> Outcome {
    play(seed, 13)
}

/// With other limits and ranges, too.
pub fn changes(seed: u64) -> Outcome {
    play(seed, 18)
}

/// The first so many kinds of command.
fn play(seed: u64, kinds: usize) -> Outcome {
    let mut rng = random(seed);
    let mut scene = Scene::new(&mut rng);
    let mut outcome = Outcome::default();
    // Inside the limits: what is outside may be so for long while time is scaled.
    scene.start = scene.start.map(|s| AxisState::rest(s.p));
    let made = OnlineGenerator::new(scene.start, scene.limits, scene.cycle, scene.mode)
        .and_then(|g| scene.ranges.map_or(Ok(g.clone()), |r| g.with_ranges(r)));
    let Ok(generator) = made.map(OnlineGenerator::with_way_points) else {
        outcome.failure = Some(("a start is refused".to_owned(), Failure { size: 1.0, seed, input: String::new() }));
        return outcome;
    };
    let mut play = Play {
        generator,
        now: scene.start,
        limits: scene.limits,
        path_limits: None,
        braking: false,
        expect: Expect::Nothing,
        curve: None,
        lowered: false,
        scale: 1.0,
        log: Vec::new(),
        scene,
    };
    for _ in 0..if kinds > 13 { 30 } else { 12 } {
        let result = play.command(kinds, &mut rng, &mut outcome).and_then(|()| {
            // Changes follow each other while the scale of time is on its way.
            let (long, most) = if kinds > 13 { (0.04, if rng.chance(0.7) { 40 } else { 400 }) } else { (0.2, 400) };
            let count = if rng.chance(long) { 2000 } else { rng.below(most) as u64 };
            (0..count).try_for_each(|_| {
                outcome.counted += 1;
                play.cycle()
            })
        });
        if let Err((what, size)) = result {
            let kind = format!("[{:?}] {what}", play.scene.mode);
            let input = format!("{:?}\n{}", play.scene, play.log.join("\n"));
            outcome.failure = Some((kind, Failure { size, seed, input }));
            break;
        }
    }
    outcome
}

pub(super) fn wrong<T>(what: String, size: f64) -> Result<T, (String, f64)> {
    Err((what, size))
}

impl Play {
    fn command(&mut self, kinds: usize, rng: &mut Random, outcome: &mut Outcome) -> Verdict {
        let which = rng.below(kinds);
        match which {
            3 | 4 => {
                self.stop_on_path(outcome);
                return Ok(());
            }
            9..13 => return self.set_route(rng, outcome),
            13.. => return self.change(which, rng, outcome),
            _ => {}
        }
        let g = &mut self.generator;
        let mut done = Ok(());
        let text;
        match which {
            0 | 1 => {
                let rest = rng.chance(0.6);
                let target = self.scene.target(rest, &self.limits, rng);
                text = format!("set_target {target:?}");
                done = g.set_target(target);
                if done.is_ok() {
                    self.expect = Expect::Nothing;
                    self.curve = (g.is_underway() && rest).then(|| Curve::of(vec![*g.plan()]));
                }
            }
            2 => {
                text = "stop".to_owned();
                done = g.stop();
                if done.is_ok() {
                    self.expect = Expect::Rest(cycles(self.scene.cycle, stop_time(&self.now, &self.limits)));
                    self.curve = None;
                }
            }
            5 => {
                let velocity = std::array::from_fn(|k| rng.between(self.limits[k].v_min(), self.limits[k].v_max()));
                let time = rng.log(0.01, 3.0);
                text = format!("jog {velocity:?} {time}");
                done = g.jog(velocity, time);
                if done.is_ok() {
                    let free = self.scene.ranges.is_none() && self.scale == 1.0 && g.scale() == 1.0 && !g.is_held();
                    let count = cycles(self.scene.cycle, time);
                    let enough = time
                        > stop_time(&self.now, &self.limits)
                            + stop_time(&velocity.map(|v| AxisState::new(0.0, v, 0.0)), &self.limits);
                    self.expect = if free && enough { Expect::Jog(velocity, count) } else { Expect::Nothing };
                    self.curve = None;
                }
            }
            6 => {
                let scale = rng.one_of(&[0.0, 0.1, 0.5, 0.9, 1.0, 1.0, 1.2, 1.5]);
                text = format!("set_scale {scale}");
                done = g.set_scale(scale);
                self.scale = scale;
                if let Expect::Jog(..) = self.expect {
                    self.expect = Expect::Nothing;
                }
            }
            7 => {
                text = "hold".to_owned();
                g.hold();
                if let Expect::Jog(..) = self.expect {
                    self.expect = Expect::Nothing;
                }
            }
            _ => {
                text = "resume".to_owned();
                g.resume();
            }
        }
        if done.is_ok() && matches!(which, 0..=2 | 5) {
            (self.path_limits, self.braking) = (None, which == 2);
        }
        let name = text.split(' ').next().unwrap_or_default().to_owned();
        outcome.see(&format!("{name}{}", if done.is_err() { ", refused" } else { "" }));
        self.log.push(format!("{text}: {done:?}"));
        if done.is_err() && which > 1 && self.scene.ranges.is_none() {
            return wrong(format!("refused without a reason: {text}: {done:?}"), 1.0);
        }
        Ok(())
    }

    fn stop_on_path(&mut self, outcome: &mut Outcome) {
        let g = &mut self.generator;
        // A jog has no target, but changes of velocity to be waited for.
        let left = 2.0 * g.time_left().max(g.plan().duration());
        let limit = cycles(self.scene.cycle, left + stop_time(&self.now, &self.limits) + 1.0);
        let plan = *g.plan();
        g.stop_on_path();
        // A stop on a line is a plan of its own; during a stop nothing changes.
        self.braking |= *g.plan() != plan;
        if !self.braking {
            self.path_limits.get_or_insert(self.limits);
        }
        self.expect = Expect::Rest(limit);
        outcome.see("stop_on_path");
        self.log.push("stop_on_path".to_owned());
    }

    /// A route from wherever the axes are.
    fn set_route(&mut self, rng: &mut Random, outcome: &mut Outcome) -> Verdict {
        let scene = &self.scene;
        let count = 1 + rng.below(6);
        let (near, straight, here) = (rng.chance(0.5), rng.chance(0.4), self.now);
        let points: Vec<_> = (0..count)
            .map(|_| {
                let place = scene.target(true, &self.limits, rng);
                // Close to where the axes are sections are short.
                let close = |k: usize| here[k].p + 0.05 * (place[k].p - here[k].p);
                let point = WayPoint::new(std::array::from_fn(|k| if near { close(k) } else { place[k].p }));
                let blend = rng.log(1e-5, 0.1);
                if straight { point.with_straight_section().with_blend(blend) } else { point }
            })
            .collect();
        let rest = straight || rng.chance(0.7);
        let target = scene.target(rest, &self.limits, rng);
        let route = Route::new(&points, target, self.limits);
        let route = if straight { route.with_straight_section() } else { route };
        let g = &mut self.generator;
        let done = PLANNER.with_borrow_mut(|planner| g.set_route(&route, planner));
        self.log.push(format!("set_route straight: {straight} {points:?} {target:?}: {done:?}"));
        outcome.see(if done.is_ok() { "set_route" } else { "set_route, refused" });
        match done {
            Ok(()) => {
                self.path_over();
                let g = &self.generator;
                let sections = 0..g.route().section_durations().len();
                let motions: Result<Vec<_>, SyncError> = sections.map(|i| g.route().section(i)).collect();
                self.curve = motions.ok().filter(|_| rest).map(Curve::of);
                Ok(())
            }
            Err(e) if rest && scene.ranges.is_none() => wrong(format!("refused without a reason: {e}"), 1.0),
            Err(_) => Ok(()),
        }
    }

    fn cycle(&mut self) -> Verdict {
        let dt = self.scene.cycle;
        let target = *self.generator.target();
        let step = self.generator.step();
        // The time of a jog is over, or the stop is.
        self.braking |= *self.generator.target() != target;
        self.braking &= !step.events.reached;
        let was = self.now;
        let size = was.iter().fold(0.0, |m: f64, s| m.max(s.p.abs()));
        for k in 0..AXES {
            self.now[k] = AxisState::new(step.state.q[k], step.state.qd[k], step.state.qdd[k]);
            let precision = Precision { slack: 1e-12, size };
            let limits = &self.path_limits.as_ref().unwrap_or(&self.limits)[k];
            if let Some((what, size)) = broken(&was[k], &self.now[k], dt, limits, precision) {
                let scale = self.generator.scale();
                return wrong(format!("{what}, axis {k}: {:?} -> {:?} at scale {scale}", was[k], self.now[k]), size);
            }
            if step.events.outside_limits && !self.lowered {
                return wrong("outside its limits".to_owned(), 1.0);
            }
            if let Some(ranges) = &self.scene.ranges {
                let p = self.now[k].p;
                if !(ranges[k].0 <= p && p <= ranges[k].1) {
                    return wrong("outside its range".to_owned(), (p - ranges[k].1).max(ranges[k].0 - p));
                }
            }
        }
        if step.events.reached && self.now.iter().all(|s| s.v == 0.0 && s.a == 0.0) {
            self.path_limits = None;
        }
        self.expected(&step)?;
        self.on_curve()
    }

    fn expected(&mut self, step: &Step<AXES>) -> Verdict {
        let rests = self.now.iter().all(|s| s.v == 0.0 && s.a == 0.0);
        self.expect = match self.expect {
            // A target that moves is left again at once.
            Expect::Rest(_) if step.events.reached && rests => {
                if self.now != *self.generator.target() {
                    return wrong("the stop does not end in the target".to_owned(), 1.0);
                }
                self.curve = None;
                Expect::Nothing
            }
            Expect::Rest(0) => return wrong("the stop takes too long".to_owned(), 1.0),
            Expect::Rest(left) => Expect::Rest(left - 1),
            // A stop of less than a cycle.
            Expect::Jog(..) if step.events.reached => Expect::Nothing,
            Expect::Jog(_, 0) => {
                let time = stop_time(&self.now, &self.limits);
                Expect::Rest(cycles(self.scene.cycle, time) + 1)
            }
            Expect::Jog(velocity, left) => {
                let off = (0..AXES).map(|k| (self.now[k].v - velocity[k]).abs()).fold(0.0, f64::max);
                let size = self.limits.iter().fold(0.0, |m: f64, l| m.max(l.v_max() - l.v_min()));
                if off > 1e-9 * size && left == 4 {
                    return wrong("the jog does not get to its velocities".to_owned(), off);
                }
                Expect::Jog(velocity, left - 1)
            }
            Expect::Nothing => Expect::Nothing,
        };
        Ok(())
    }

    /// Another command took the place of what was followed.
    pub(super) fn path_over(&mut self) {
        (self.expect, self.curve, self.path_limits, self.braking) = (Expect::Nothing, None, None, false);
    }

    /// Looks for the time of the plan at which the axis that moves fastest is where it is, and compares the other axes.
    fn on_curve(&mut self) -> Verdict {
        let Some(curve) = &mut self.curve else { return Ok(()) };
        if !self.generator.is_underway() {
            self.curve = None;
            return Ok(());
        }
        // Axes that arrive on their own keep the time of their plan only together.
        if self.scene.mode == Synchronisation::None && self.generator.section().is_none() {
            return Ok(());
        }
        let size = self.limits.iter().fold(0.0, |m: f64, l| m.max(l.v_max() - l.v_min()));
        let near_enough = 1e-9 * (1.0 + size * self.scene.cycle);
        let scale = self.generator.scale();
        let off = curve.advance(&self.now, (scale, self.scene.cycle), 0.5 * near_enough);
        let now = self.now;
        if curve.runs_back() {
            return wrong(format!("runs back on its curve {curve:?}, scale {scale}: {now:?}"), 1.0);
        }
        if off > near_enough {
            return wrong(
                format!("leaves the curve of its plan {curve:?}, scale {scale}: {now:?} {:?}", curve.here()),
                off,
            );
        }
        Ok(())
    }
}

pub(super) fn cycles(cycle: f64, time: f64) -> u64 {
    (time / cycle).ceil() as u64 + 2
}

/// A time in which any axis comes to rest: acceleration to zero, velocity to zero with half the limits.
pub(super) fn stop_time(states: &States, limits: &Limits) -> f64 {
    let time = |s: &AxisState, l: &arcfeed_sync::feedrate::AxisLimits| {
        let (a, j) = (l.a_max().min(-l.a_min()), l.j_max().min(-l.j_min()));
        let release = s.a.abs() / j;
        let v = s.v.abs() + s.a.abs() * release;
        // A stop that turns at the end of a range goes back as well.
        2.0 * (release + 2.0 * v / a + 4.0 * (v / j).sqrt() + a / j)
    };
    states.iter().zip(limits).map(|(s, l)| time(s, l)).fold(0.0, f64::max)
}
