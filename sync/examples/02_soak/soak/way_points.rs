//! Four axes through way-points, from any state to any other, some with velocities of points, least durations and limits of sections.
//!
//! Judged phase by phase: no route is refused; every section ends where the next one begins, to 1e-8; velocity, acceleration and
//! jerk stay within their limits to 1e-12; the motion is no longer than one that stops in every point.

use std::cell::RefCell;

use arcfeed_sync::feedrate::{AxisLimits, AxisState, MotionLaw};
use arcfeed_sync::{MotionOptions, Route, SyncError, Trajectory, WayPoint, WayPointPlanner, WayPointTrajectory};
use arcfeed_testing::Random;

use super::{Failure, Outcome, random};

const AXES: usize = 4;

struct Input {
    states: Vec<[AxisState; AXES]>,
    points: Vec<WayPoint<AXES>>,
    limits: [AxisLimits; AXES],
}

impl Input {
    fn new(rng: &mut Random) -> Self {
        let limits = std::array::from_fn(|_| {
            let mut pair = |lo: f64, hi: f64| (-rng.log(lo, hi), rng.log(lo, hi));
            AxisLimits::new(pair(0.1, 5.0), pair(1.0, 30.0), pair(5.0, 500.0)).expect("limits on both sides of zero")
        });
        let count = if rng.chance(0.95) { 1 + rng.below(10) } else { 1 + rng.below(64) };
        let (kind, step, size) = (rng.below(3), rng.log(0.05, 1.5), rng.log(1e-3, 1.0));
        let mut place = [0.0; AXES];
        let mut states: Vec<[AxisState; AXES]> = (0..count + 2)
            .map(|i| {
                for (k, x) in place.iter_mut().enumerate() {
                    match kind {
                        0 => *x = rng.between(-1.0, 1.0),
                        1 => *x = (step * (k + 1) as f64 * i as f64 + k as f64).sin(),
                        // Some axes rest.
                        _ => *x += if rng.chance(0.3) { 0.0 } else { rng.between(-size, size) },
                    }
                }
                place.map(AxisState::rest)
            })
            .collect();
        for end in [0, count + 1] {
            if rng.chance(0.4) {
                for (s, l) in states[end].iter_mut().zip(&limits) {
                    let wanted =
                        AxisState::new(s.p, rng.between(l.v_min(), l.v_max()), rng.between(l.a_min(), l.a_max()));
                    let back = AxisState::new(0.0, wanted.v, -wanted.a);
                    // Neither before nor after it the velocity is outside.
                    *s = if l.contain(&wanted) && l.contain(&back) { wanted } else { *s };
                }
            }
        }
        let special = rng.chance(0.3);
        let points = states[1..=count]
            .iter()
            .map(|s| {
                let mut point = WayPoint::new(s.map(|s| s.p));
                if special && rng.chance(0.2) {
                    let (axis, part) = (rng.below(AXES), rng.between(0.0, 0.5));
                    let l: &AxisLimits = &limits[axis];
                    point = point.with_velocity(axis, part * if rng.chance(0.5) { l.v_min() } else { l.v_max() });
                }
                if special && rng.chance(0.2) {
                    point = point.with_least_duration(rng.log(1e-3, 3.0));
                }
                if special && rng.chance(0.2) {
                    // Wider limits of one section only: the velocities of its ends stay possible.
                    let scale = rng.log(1.0, 10.0);
                    let wider = |l: &AxisLimits| {
                        let pair = |lo: f64, hi: f64| (scale * lo, scale * hi);
                        AxisLimits::new(
                            pair(l.v_min(), l.v_max()),
                            pair(l.a_min(), l.a_max()),
                            pair(l.j_min(), l.j_max()),
                        )
                    };
                    point = point.with_limits(limits.map(|l| wider(&l).expect("limits on both sides of zero")));
                }
                point
            })
            .collect();
        Self { states, points, limits }
    }

    fn route(&self) -> Route<'_, AXES> {
        Route::new(&self.points, self.states[self.states.len() - 1], self.limits)
    }

    /// The duration with a stop in every point, or with the velocities that are given; `None` where one of its sections is impossible.
    fn stopping(&self) -> Option<f64> {
        let mut states = self.states.clone();
        for (state, point) in states[1..].iter_mut().zip(&self.points) {
            for (s, v) in state.iter_mut().zip(point.velocity()) {
                s.v = v.unwrap_or(0.0);
            }
        }
        let route = self.route();
        let made = |(i, pair): (usize, &[[AxisState; AXES]])| {
            let options = MotionOptions::default().with_least_duration(route.least_duration(i))?;
            Trajectory::new(&pair[0], &pair[1], route.limits(i), &options).map(|motion| motion.duration())
        };
        states.windows(2).enumerate().map(made).sum::<Result<f64, SyncError>>().ok()
    }

    /// By how much the motion breaks what must hold, and what that is.
    fn judge(&self, motion: &WayPointTrajectory<AXES>) -> Option<(String, f64)> {
        let route = self.route();
        for (state, point) in motion.states()[1..].iter().zip(&self.points) {
            let passes =
                |k: usize| state[k].p == point.position()[k] && point.velocity()[k].is_none_or(|v| v == state[k].v);
            if !(0..AXES).all(passes) {
                return Some(("passes beside a point".to_owned(), 1.0));
            }
        }
        for (i, pair) in motion.states().windows(2).enumerate() {
            let Ok(section) = motion.section(i) else { return Some((format!("section {i} is refused"), 1.0)) };
            if section.duration() < route.least_duration(i) * (1.0 - 1e-12) {
                return Some(("least duration".to_owned(), section.duration()));
            }
            for (k, axis) in section.axes().iter().enumerate() {
                let (l, to) = (&route.limits(i)[k], pair[1][k]);
                let last = axis.phases().last().map_or(axis.at(0.0), |(phase, dt)| phase.after(dt));
                let off = (last.p - to.p).abs().max((last.v - to.v).abs());
                if off.is_nan() || off > 1e-8 {
                    return Some(("end".to_owned(), off));
                }
                let over = |x: f64, lo: f64, hi: f64| (x / hi).max(x / lo) - 1.0;
                for (phase, dt) in axis.phases() {
                    for s in [0.0, phase.turn(dt).unwrap_or(0.0), dt].map(|t| phase.after(t)) {
                        let excess = over(s.v, l.v_min(), l.v_max()).max(over(s.a, l.a_min(), l.a_max())).max(over(
                            s.j,
                            l.j_min(),
                            l.j_max(),
                        ));
                        if excess.is_nan() || excess > 1e-12 {
                            return Some(("limits".to_owned(), excess));
                        }
                    }
                }
            }
        }
        None
    }
}

thread_local! {
    static PLANNER: RefCell<Box<WayPointPlanner<AXES>>> = RefCell::new(Box::default());
}

/// One route.
pub fn case(seed: u64) -> Outcome {
    let input = Input::new(&mut random(seed));
    let mut outcome = Outcome { counted: 1, ..Outcome::default() };
    let (start, target) = (input.states[0], input.states[input.states.len() - 1]);
    let planned = PLANNER.with_borrow_mut(|planner| planner.plan(&start, &input.route()));
    let failure = match planned {
        Err(e) => input.stopping().map(|_| (format!("refused: {e}"), 1.0)),
        Ok(motion) => {
            let longer = input.stopping().is_some_and(|t| motion.duration() > t * (1.0 + 1e-9));
            let stops = motion.states()[1..=input.points.len()].iter().flatten().all(|s| s.v == 0.0);
            outcome.see(if stops { "rests in every point" } else { "passes points" });
            if longer { Some(("longer than with stops".to_owned(), motion.duration())) } else { input.judge(&motion) }
        }
    };
    outcome.failure = failure.map(|(kind, size)| {
        let input = format!("{start:?} {:?} {target:?} {:?}", input.points, input.limits);
        (kind, Failure { size, seed, input })
    });
    outcome
}
