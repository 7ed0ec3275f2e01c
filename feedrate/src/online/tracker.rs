//! One axis that follows a moving target, given cycle by cycle.

use crate::error::{FeedError, finite, positive};
use crate::limits::AxisLimits;
use crate::state::{AxisState, MotionState};
use crate::state_to_state::{AxisProblem, StateToState};
#[cfg(not(feature = "std"))]
use num_traits::Float;

/// Steps of the search for the meeting: forwards, and halvings after that.
const STEPS: usize = 12;
const HALVINGS: usize = 12;

/// Part of the past that counts in the next cycle.
const MEMORY: f64 = 0.98;

/// Relative difference from a prediction that counts as round-off.
const ROUND_OFF: f64 = 16.0 * f64::EPSILON;

/// Part of a cycle that counts as round-off.
const WHOLE: f64 = 1e-6;

/// What the axis does.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TrackStatus {
    /// In the state of the target, exactly.
    Following,
    /// On the way to the target.
    Approaching,
    /// The target moves faster, accelerates harder or changes its acceleration faster than the
    /// limits allow: the axis does what they allow.
    Saturated,
}

/// State and status after a cycle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrackStep {
    /// Position, velocity and acceleration, and the jerk that acts at the end of the cycle; a jerk of 0 where a plan ends in it.
    pub state: MotionState,
    /// What the axis does.
    pub status: TrackStatus,
}

/// One axis that follows a target whose state is given in every cycle.
///
/// The axis takes the shortest way to the place where it meets the target soonest. The target is
/// predicted from its state, as a motion with constant acceleration or as an oscillation, whose
/// frequency is measured from the cycles before. Once the axis can be in the state of the target at
/// the end of a cycle, it is, exactly, and it stays so while the target keeps the limits. A target
/// beyond the limits is followed as far as they allow.
///
/// Velocity, acceleration and jerk keep their limits in every cycle, whatever the target does.
/// Positions that jump from cycle to cycle (noise) are taken as they are: the axis then changes its
/// jerk in every cycle, and no error is less than the noise. Filter such a target before. Nothing
/// allocates, and a cycle costs at most some 30 exact plans.
///
/// ```
/// use arcfeed_feedrate::{AxisLimits, AxisState, TargetTracker, TrackStatus};
/// let limits = AxisLimits::symmetric(2.0, 10.0, 200.0)?;
/// let cycle = 1e-3;
/// let mut tracker = TargetTracker::new(&AxisState::rest(0.0), &limits, cycle)?;
/// let mut cycles = 0;
/// // A conveyor that passes at 0.5 / s, 0.1 ahead.
/// loop {
///     cycles += 1;
///     let target = AxisState::new(0.1 + 0.5 * f64::from(cycles) * cycle, 0.5, 0.0);
///     let step = tracker.step(&target)?;
///     if step.status == TrackStatus::Following {
///         assert_eq!((step.state.p, step.state.v, step.state.a), (target.p, target.v, target.a));
///         break;
///     }
/// }
/// assert!(cycles < 500);
/// # Ok::<(), arcfeed_feedrate::FeedError>(())
/// ```
#[derive(Debug, Clone, Copy)]
pub struct TargetTracker {
    state: AxisState,
    limits: AxisLimits,
    cycle: f64,
    /// The target in the cycle before.
    before: Option<AxisState>,
    /// Sums over the cycles of jerk times velocity and of the square of the velocity of the target.
    sums: (f64, f64),
    /// Cycles until the meeting that is under way.
    left: f64,
    plan: Option<Plan>,
}

/// The way to a meeting, kept while the target moves as predicted.
#[derive(Debug, Clone, Copy)]
struct Plan {
    motion: StateToState,
    prediction: Prediction,
    /// Cycles since it was made.
    steps: f64,
}

impl TargetTracker {
    /// At `start`, with a control cycle (s). A start outside the limits is brought back inside.
    ///
    /// # Errors
    /// [`FeedError::NotFinite`], [`FeedError::NotPositive`] for the cycle, and limits that permit
    /// one direction only ([`FeedError::NotBelowZero`]).
    pub fn new(start: &AxisState, limits: &AxisLimits, cycle: f64) -> Result<Self, FeedError> {
        for (what, value) in [("start.p", start.p), ("start.v", start.v), ("start.a", start.a)] {
            finite(what, value)?;
        }
        limits.check_both_directions()?;
        Ok(Self {
            state: *start,
            limits: *limits,
            cycle: positive("cycle", cycle)?,
            before: None,
            sums: (0.0, 0.0),
            left: 0.0,
            plan: None,
        })
    }

    /// Sets the limits from the next cycle on.
    ///
    /// # Errors
    /// As [`TargetTracker::new`].
    pub fn set_limits(&mut self, limits: &AxisLimits) -> Result<(), FeedError> {
        limits.check_both_directions()?;
        (self.limits, self.plan) = (*limits, None);
        Ok(())
    }

    /// The state at the end of the last cycle.
    pub const fn state(&self) -> &AxisState {
        &self.state
    }

    /// Moves on by one cycle, at whose end the target is in the state `target`.
    ///
    /// # Errors
    /// [`FeedError::NotFinite`] naming the field; [`FeedError::OutOfRange`]. The axis stays where
    /// it is then.
    pub fn step(&mut self, target: &AxisState) -> Result<TrackStep, FeedError> {
        for (what, value) in [("target.p", target.p), ("target.v", target.v), ("target.a", target.a)] {
            finite(what, value)?;
        }
        let sums = self.before.map_or((0.0, 0.0), |b| {
            let (v, j) = (0.5 * (target.v + b.v), (target.a - b.a) / self.cycle);
            (MEMORY * self.sums.0 + j * v, MEMORY * self.sums.1 + v * v)
        });
        let square = (-sums.0 / sums.1).max(0.0);
        let prediction = Prediction { from: *target, square: if square.is_finite() { square } else { 0.0 } };
        let step = if let Some(state) = self.landing(target) {
            (self.left, self.plan) = (0.0, None);
            TrackStep { state, status: TrackStatus::Following }
        } else if let Some(step) = self.go_on(target) {
            step
        } else {
            self.approach(&prediction)?
        };
        let sound = sums.0.is_finite() && sums.1.is_finite();
        self.sums = if sound { sums } else { (0.0, 0.0) };
        self.before = Some(*target);
        self.state = AxisState::new(step.state.p, step.state.v, step.state.a);
        Ok(step)
    }

    /// The state of the target, if three equal parts of the cycle with constant jerk lead there.
    fn landing(&self, target: &AxisState) -> Option<MotionState> {
        let (s, h) = (&self.state, self.cycle / 3.0);
        let t = self.cycle;
        let p = (target.p - s.p - t * (s.v + 0.5 * t * s.a)) / h.powi(3);
        let v = (target.v - s.v - t * s.a) / (h * h);
        let a = (target.a - s.a) / h;
        // 19/6 x + 7/6 y + 1/6 z = p,  5/2 x + 3/2 y + 1/2 z = v,  x + y + z = a.
        let x = p - v + a / 3.0;
        let y = -2.0 * p + 3.0 * v - 7.0 / 6.0 * a;
        let z = a - x - y;
        let (mut now, l) = (*s, &self.limits);
        let mean = (target.a - s.a) / t;
        if !(l.j_min() <= mean && mean <= l.j_max()) {
            return None;
        }
        // What the round-off of the position makes of the jerk of a third.
        let slack = 8.0 * f64::EPSILON * ((target.p.abs() + s.p.abs()) / h.powi(3) + l.j_max() - l.j_min());
        for j in [x, y, z] {
            if !(l.j_min() - slack <= j && j <= l.j_max() + slack) {
                return None;
            }
            let turn = -now.a / j;
            let turned = if turn > 0.0 && turn < h { now.v + 0.5 * now.a * turn } else { now.v };
            now = AxisState::new(
                now.p + h * (now.v + h * (0.5 * now.a + h * j / 6.0)),
                now.v + h * (now.a + 0.5 * h * j),
                now.a + h * j,
            );
            if !(l.contain(&now) && l.contain_now(&AxisState::new(0.0, turned, 0.0))) {
                return None;
            }
        }
        Some(MotionState { p: target.p, v: target.v, a: target.a, j: z })
    }

    /// A cycle of the plan that is kept; `None` if the target does not move as it was predicted.
    fn go_on(&mut self, target: &AxisState) -> Option<TrackStep> {
        let plan = self.plan.as_mut()?;
        let due = plan.prediction.at(plan.steps * self.cycle);
        let close = |x: f64, y: f64, size: f64| (x - y).abs() <= ROUND_OFF * (size + x.abs());
        let l = &self.limits;
        let as_predicted = close(target.p, due.p, self.state.p.abs())
            && close(target.v, due.v, l.v_max() - l.v_min())
            && close(target.a, due.a, l.a_max() - l.a_min());
        if !as_predicted || self.left < 1.0 {
            self.plan = None;
            return None;
        }
        plan.steps += 1.0;
        self.left -= 1.0;
        if self.left > 0.0 {
            let state = plan.motion.at_or_after(plan.steps * self.cycle);
            return Some(TrackStep { state, status: TrackStatus::Approaching });
        }
        self.plan = None;
        let AxisState { p, v, a } = *target;
        Some(TrackStep { state: MotionState { p, v, a, j: 0.0 }, status: TrackStatus::Following })
    }

    /// A cycle of the shortest way to the target.
    fn approach(&mut self, prediction: &Prediction) -> Result<TrackStep, FeedError> {
        let t = self.cycle;
        let saturated = !self.limits.contain(&prediction.from);
        let status = if saturated { TrackStatus::Saturated } else { TrackStatus::Approaching };
        self.plan = None;
        let Some((cycles, problem)) = self.meeting(prediction) else {
            self.left = 0.0;
            return Ok(TrackStep { state: self.chase(&prediction.from)?, status });
        };
        self.left = cycles - 1.0;
        let motion = problem.with_duration(cycles * t);
        if let (true, Ok(_)) = (cycles == 1.0, &motion) {
            let AxisState { p, v, a } = prediction.from;
            return Ok(TrackStep { state: MotionState { p, v, a, j: 0.0 }, status: TrackStatus::Following });
        }
        if let (false, Ok(motion)) = (saturated, &motion) {
            self.plan = Some(Plan { motion: *motion, prediction: *prediction, steps: 1.0 });
        }
        let possible = problem.durations().at_least(cycles * t);
        let motion = motion.or_else(|_| problem.with_duration(possible)).unwrap_or_else(|_| problem.shortest());
        Ok(TrackStep { state: motion.at_or_after(t), status })
    }

    /// The least number of cycles found after which the target is met, and the way there.
    fn meeting(&self, prediction: &Prediction) -> Option<(f64, AxisProblem)> {
        let cycle = self.cycle;
        // The time needed for the meeting after so many cycles, less that time.
        let lack = |n: f64| {
            let there = prediction.at((n - 1.0) * cycle);
            // The limits must hold after the meeting, too.
            if !self.limits.contain(&there) {
                return None;
            }
            let problem = AxisProblem::new(&self.state, &there, &self.limits).ok()?;
            // Not every longer duration is possible between states that move.
            Some((problem.durations().at_least(n * cycle) / cycle - n, problem))
        };
        let (mut early, mut late, mut slope) = (0.0, self.left.max(1.0), 0.0_f64);
        let mut best: Option<(f64, AxisProblem)> = None;
        let mut before: Option<(f64, f64)> = None;
        for _ in 0..STEPS {
            let found = lack(late);
            if let Some((short, problem)) = found
                && short <= WHOLE
            {
                best = Some((late, problem));
                break;
            }
            early = late;
            let step = found.map_or(late, |(short, _)| {
                if let Some((n, other)) = before {
                    slope = ((short - other) / (late - n)).max(-1.0).min(-0.05);
                    short / -slope * 1.02
                } else {
                    short
                }
            });
            before = found.map(|(short, _)| (late, short));
            late += step.max(1.0).ceil();
        }
        let mut best = best?;
        for _ in 0..HALVINGS {
            if best.0 - early <= 1.0 {
                break;
            }
            // One cycle earlier first: the plan of the cycle before meets it here.
            let middle = if best.0 == self.left { best.0 - 1.0 } else { (0.5 * (early + best.0)).floor() };
            match lack(middle) {
                Some((short, problem)) if short <= WHOLE => best = (middle, problem),
                _ => early = middle,
            }
        }
        Some(best)
    }

    /// A cycle towards a target that is not met. One that is no faster than the limits is gone to with its velocity and no
    /// acceleration; otherwise the axis moves at its velocity or faster, as far as the limits go.
    fn chase(&self, target: &AxisState) -> Result<MotionState, FeedError> {
        let l = &self.limits;
        let steady = AxisState::new(target.p, target.v, 0.0);
        if l.contain(&steady)
            && let Ok(problem) = AxisProblem::new(&self.state, &steady, l)
        {
            return Ok(problem.shortest().at_or_after(self.cycle));
        }
        let v = if target.v > l.v_max() {
            l.v_max()
        } else if target.v < l.v_min() {
            l.v_min()
        } else if target.p > self.state.p {
            l.v_max()
        } else {
            l.v_min()
        };
        Ok(StateToState::to_velocity(&self.state, v, 0.0, l)?.at_or_after(self.cycle))
    }
}

/// A target from now on.
#[derive(Debug, Clone, Copy)]
struct Prediction {
    from: AxisState,
    /// Square of the angular frequency (1/s²); 0 for constant acceleration.
    square: f64,
}

impl Prediction {
    /// The state after a time (s): `v'' = -square v`.
    fn at(&self, t: f64) -> AxisState {
        let (AxisState { p, v, a }, w) = (self.from, self.square.sqrt());
        let x = w * t;
        if x < 1e-3 {
            return AxisState::new(p + t * (v + 0.5 * t * a), v + t * a, a);
        }
        let (sin, cos) = x.sin_cos();
        AxisState::new(p + (v * sin + a / w * (1.0 - cos)) / w, v * cos + a / w * sin, a * cos - v * w * sin)
    }
}
