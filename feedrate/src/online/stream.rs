//! Segments that arrive while the motion runs.

use super::plan::Plan;
use super::window::Window;
use crate::error::{FeedError, not_negative};
use crate::limits::AxisLimits;
use crate::scan::Segment;
use crate::scan::per_segment::forward;
use crate::scurve::phase::Phase;
use crate::scurve::profile::{Adjusted, SProfile};
use crate::state::{AxisState, MotionState};

/// Halvings in the search for the highest speed at the end of a segment.
const HALVINGS: usize = 24;
/// A speed counts as higher than another from this on, relative.
const HIGHER: f64 = 1e-9;

/// Status of a streamed motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum StreamStatus {
    /// On the way.
    Moving {
        /// True if the motion leaves the present segment slower than it could, because it has to be
        /// able to stop within what has arrived.
        held_back: bool,
    },
    /// At rest at the end of the last segment that has arrived; more may follow.
    Waiting,
    /// At rest at the end of the path.
    Reached {
        /// Part of the last period that was not needed (s).
        unused: f64,
    },
}

/// State and status after a cycle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StreamStep {
    /// Position from the start of the first segment, speed, acceleration, and the jerk that acts
    /// from here on.
    pub state: MotionState,
    /// Status of the motion.
    pub status: StreamStatus,
    /// Index of the segment, from 0; the number of segments where all that have arrived are done.
    pub segment: usize,
}

/// Motion along segments that arrive while it runs (Liu et al. 2023, algorithm 2, as a stream).
///
/// Each segment has one S-profile with zero acceleration at both ends, as in
/// [`plan_per_segment`](crate::plan_per_segment). The speed at the end of a segment is the highest
/// from which the motion can stop at the end of the last segment that has arrived. A segment that
/// arrives later raises it, also in the middle of the present segment.
///
/// **Guarantees**: speed, acceleration and jerk are inside the bounds of the segment in every
/// moment, whatever arrives and whenever. The motion stops only where no other segment had arrived
/// when it entered the last one, and goes on as soon as one arrives. With all segments pushed and
/// [`SegmentStream::finish`] called before the first step the motion is that of
/// [`plan_per_segment`](crate::plan_per_segment), without the stops on the way of the latter.
/// Nothing but [`SegmentStream::new`] allocates. A cycle costs a few operations for each segment
/// that it completes, and a push a few for each segment that waits, and at most 26 exact plans.
///
/// ```
/// use arcfeed_feedrate::{Segment, SegmentStream, StreamStatus};
/// let segment = Segment::new(0.01, 0.1, 1.0, 50.0)?; // 10 mm
/// let mut stream = SegmentStream::new(&[segment], 0.0, 8)?;
/// let mut cycle = 0;
/// let last = loop {
///     if cycle % 50 == 0 && cycle < 500 {
///         stream.push(segment)?; // every 50 ms
///     } else if cycle == 500 {
///         stream.finish();
///     }
///     let step = stream.step(1e-3)?;
///     if let StreamStatus::Reached { .. } = step.status {
///         break step.state;
///     }
///     cycle += 1;
/// };
/// assert!((last.p - 0.11).abs() < 1e-15 && last.v == 0.0);
/// # Ok::<(), arcfeed_feedrate::FeedError>(())
/// ```
#[derive(Debug, Clone)]
pub struct SegmentStream {
    window: Window,
    /// The segment that is run, and its profile from its start on or from where it was replaced.
    present: Option<(Segment, Plan)>,
    /// Time since the profile was made.
    t: f64,
    /// Whether the profile begins at the start of the segment.
    from_start: bool,
    held_back: bool,
    /// Position of the start of the present segment, with the part that the sum has lost.
    base: (f64, f64),
    /// Segments that are done.
    done: usize,
}

impl SegmentStream {
    /// A motion that starts with `v_start` (m/s) on the segments that are there already, and looks
    /// ahead over at most `look_ahead` segments behind the present one.
    ///
    /// # Errors
    /// [`FeedError::StartTooFast`] if the motion cannot stop within `first`; [`FeedError::Empty`]
    /// if `first` is empty and `v_start` is above 0; [`FeedError::Negative`] or
    /// [`FeedError::NotFinite`] for an invalid speed; [`FeedError::NotPositive`] or
    /// [`FeedError::TooMany`] for a look-ahead of 0 or of more than a million;
    /// [`FeedError::StreamFull`] for more segments than that; [`FeedError::OutOfRange`] as
    /// [`SegmentStream::push`].
    pub fn new(first: &[Segment], v_start: f64, look_ahead: usize) -> Result<Self, FeedError> {
        not_negative("v_start", v_start)?;
        let mut stream = Self {
            window: Window::new(look_ahead)?,
            present: None,
            t: 0.0,
            from_start: true,
            held_back: false,
            base: (0.0, 0.0),
            done: 0,
        };
        if first.is_empty() && v_start > 0.0 {
            return Err(FeedError::Empty { what: "segments to start on with a speed" });
        }
        let Some((&present, others)) = first.split_first() else { return Ok(stream) };
        representable(&present)?;
        stream.window.follows(&present);
        for &segment in others {
            representable(&segment)?;
            stream.window.push(segment)?;
        }
        let highest = present.v_max().min(stream.window.before(&present, stream.window.bound()));
        if v_start > highest {
            let (speed, allowed) = (v_start, highest);
            return Err(FeedError::StartTooFast { speed, segment: 0, allowed, lowest: speed, highest_start: highest });
        }
        stream.enter(present, v_start);
        Ok(stream)
    }

    /// Appends a segment, and raises the speed at the end of the present one where that helps.
    ///
    /// # Errors
    /// [`FeedError::StreamFull`] while the window is full; [`FeedError::StreamEnded`] after
    /// [`SegmentStream::finish`]; [`FeedError::OutOfRange`] for a segment whose duration is no
    /// finite number. The motion then goes on as before.
    pub fn push(&mut self, segment: Segment) -> Result<(), FeedError> {
        representable(&segment)?;
        self.window.push(segment)?;
        self.adjust();
        Ok(())
    }

    /// States that no segment follows: the end of the last one is the end of the path.
    pub fn finish(&mut self) {
        self.window.finish();
        self.adjust();
    }

    /// Number of segments that [`SegmentStream::push`] takes now.
    pub fn free(&self) -> usize {
        self.window.vacant()
    }

    /// Advances by `period` (s).
    ///
    /// # Errors
    /// [`FeedError::NotFinite`] or [`FeedError::Negative`] for the period; the motion then stays
    /// where it is.
    pub fn step(&mut self, period: f64) -> Result<StreamStep, FeedError> {
        self.step_with(period, |_, _| {})
    }

    /// As [`SegmentStream::step`], and reports each part of the cycle with constant jerk, with its
    /// duration (s). Waiting is not reported.
    ///
    /// # Errors
    /// As [`SegmentStream::step`].
    pub fn step_with(&mut self, period: f64, mut passed: impl FnMut(Phase, f64)) -> Result<StreamStep, FeedError> {
        let mut left = not_negative("period", period)?;
        loop {
            let Some((segment, plan)) = self.present else {
                let Some(next) = self.window.pop() else { break };
                self.enter(next, 0.0);
                continue;
            };
            let until = (self.t + left).min(plan.phases.duration);
            for (phase, dt) in plan.phases.remaining(self.t) {
                let dt = dt.min(until - phase.t);
                if dt > 0.0 {
                    passed(Phase { s: self.base.0 + phase.s, ..phase }, dt);
                }
            }
            if self.t + left < plan.phases.duration {
                self.t = until;
                break;
            }
            left -= plan.phases.duration - self.t;
            self.complete(&segment);
            if let Some(next) = self.window.pop() {
                self.enter(next, plan.phases.end.v);
            }
        }
        let status = match (&self.present, self.window.is_finished()) {
            (Some(_), _) => StreamStatus::Moving { held_back: self.held_back },
            (None, true) => StreamStatus::Reached { unused: left.max(0.0) },
            (None, false) => StreamStatus::Waiting,
        };
        Ok(StreamStep { state: self.state(), status, segment: self.done })
    }

    /// The state now.
    pub fn state(&self) -> MotionState {
        let rest = MotionState { p: self.base.0, ..MotionState::default() };
        self.present.as_ref().map_or(rest, |(_, plan)| {
            let state = plan.phases.at(self.t);
            // Round-off may carry the last speeds of a full stop below 0.
            MotionState { p: self.base.0 + state.p, v: state.v.max(0.0), ..state }
        })
    }

    /// Moves the base over a segment that is done; the same sum as
    /// [`boundaries`](crate::boundaries).
    fn complete(&mut self, segment: &Segment) {
        let (sum, lost) = self.base;
        let y = segment.length() - lost;
        let next = sum + y;
        self.base = (next, (next - sum) - y);
        self.present = None;
        self.done += 1;
    }

    fn enter(&mut self, segment: Segment, v: f64) {
        self.present = Some((segment, self.profile(&segment, v)));
        self.plan_exit(v);
    }

    /// The profile over a whole segment to the highest speed at its end.
    fn profile(&self, segment: &Segment, v: f64) -> Plan {
        let exit = forward(segment, v, self.window.bound());
        Plan::of(&SProfile::build(segment.length(), v, exit, &limits_of(segment), Adjusted::No))
    }

    /// Plans the present segment from its start, entered at speed `v`.
    fn plan_exit(&mut self, v: f64) {
        (self.t, self.from_start) = (0.0, true);
        let Some((segment, _)) = self.present else { return };
        let plan = self.profile(&segment, v);
        self.held_back = plan.phases.end.v < forward(&segment, v, self.window.free()) * (1.0 - HIGHER);
        self.present = Some((segment, plan));
    }

    /// Raises the speed at the end of the present segment after another one has arrived.
    fn adjust(&mut self) {
        let Some((segment, plan)) = self.present else { return };
        if self.from_start && self.t == 0.0 {
            return self.plan_exit(plan.phases.at(0.0).v);
        }
        let (bound, now) = (self.window.bound(), plan.phases.end.v);
        if bound > now * (1.0 + HIGHER)
            && let Some(better) = self.highest(&segment, &plan, bound)
        {
            (self.t, self.from_start) = (0.0, false);
            self.present = Some((segment, better));
        }
        let exit = self.present.map_or(0.0, |(_, plan)| plan.phases.end.v);
        self.held_back = exit >= bound * (1.0 - HIGHER) && bound < self.window.free() * (1.0 - HIGHER);
    }

    /// The motion from the present state to the highest speed at the end of the segment, at most
    /// `bound`; `None` where that of the present plan is the highest.
    fn highest(&self, segment: &Segment, plan: &Plan, bound: f64) -> Option<Plan> {
        let limits = limits_of(segment);
        let now = plan.phases.at(self.t);
        let from = AxisState::new(now.p, now.v, now.a);
        let to = |v: f64| {
            let end = AxisState::new(segment.length(), v, 0.0);
            let plan = Plan::new(&from, &end, &limits, limits.j_max()).ok()?;
            (plan.arrives && plan.keeps(&limits, 0.0)).then_some(plan)
        };
        if let Some(plan) = to(bound) {
            return Some(plan);
        }
        // The speed that is left when the acceleration is taken off: from there upwards a higher
        // speed takes more length. Below it a full stop takes less than braking to a third, so
        // there the search begins at the present end speed.
        let released = now.v + 0.5 * now.a * (now.a.abs() / limits.j_max());
        let floor = released.min(bound).max(plan.phases.end.v);
        let mut best = to(floor);
        let (mut low, mut high) = if best.is_some() { (floor, bound) } else { (plan.phases.end.v, floor) };
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            match to(middle) {
                Some(plan) => (low, best) = (middle, Some(plan)),
                None => high = middle,
            }
        }
        best
    }
}

fn limits_of(segment: &Segment) -> AxisLimits {
    AxisLimits::symmetric_unchecked(segment.v_max(), segment.a_max(), segment.j_max())
}

/// From rest to rest a segment takes longest: if that is a number, every profile is.
fn representable(segment: &Segment) -> Result<(), FeedError> {
    SProfile::new(segment.length(), 0.0, 0.0, &limits_of(segment)).map(|_| ())
}
