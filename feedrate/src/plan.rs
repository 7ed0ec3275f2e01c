//! A planned motion along a path: constant-jerk phases, searched or walked.

use crate::error::FeedError;
use crate::scurve::phases::Phase;
use crate::scurve::profile::SProfile;
use crate::state::{MotionLaw, MotionState};

/// A motion along a path as a sequence of constant-jerk phases.
///
/// The phases are anchored to positions on the path, not accumulated from one another, so errors do not grow with their number; the end
/// is exactly the end of the path.
#[derive(Debug, Clone, PartialEq)]
pub struct SpeedPlan {
    phases: Vec<Phase>,
    end: MotionState,
    duration: f64,
}

impl SpeedPlan {
    pub(crate) fn from_parts(phases: Vec<Phase>, end: MotionState, duration: f64) -> Self {
        Self { phases, end, duration }
    }

    /// Refuses a plan whose numbers left the range of `f64`.
    pub(crate) fn checked(self) -> Result<Self, FeedError> {
        let sound = self.duration.is_finite()
            && self.end.p.is_finite()
            && self.phases.iter().all(|p| (p.t + p.s + p.v + p.a + p.j).is_finite());
        if sound { Ok(self) } else { Err(FeedError::OutOfRange { what: "duration of the plan" }) }
    }

    /// Plans one after the other, as where a path has corners at which the tool stands. Each is taken to start where the
    /// one before ends; without any the result is the empty motion.
    pub fn chain(parts: impl IntoIterator<Item = SpeedPlan>) -> Self {
        let mut chained = Self { phases: Vec::new(), end: MotionState::default(), duration: 0.0 };
        for part in parts {
            let (t0, s0) = (chained.duration, chained.end.p);
            chained.phases.extend(part.phases.iter().map(|p| Phase { t: t0 + p.t, s: s0 + p.s, ..*p }));
            chained.end = MotionState { p: s0 + part.end.p, ..part.end };
            chained.duration = t0 + part.duration;
        }
        chained
    }

    /// The constant-jerk phases, by time; each lasts until the next one starts, the last one until [`MotionLaw::duration`].
    pub fn phases(&self) -> &[Phase] {
        &self.phases
    }

    /// Length of the path (m).
    pub fn length(&self) -> f64 {
        self.end.p
    }

    /// The state at the end of the path.
    pub fn end(&self) -> MotionState {
        self.end
    }

    fn end_time(&self, i: usize) -> f64 {
        self.phases.get(i + 1).map_or(self.duration, |next| next.t)
    }

    fn state_in(&self, i: usize, t: f64) -> MotionState {
        match self.phases.get(i) {
            Some(phase) => {
                let mut state = phase.after(t - phase.t);
                // Round-off may carry the ends of a full stop below 0 or a hair beyond the path.
                state.v = state.v.max(0.0);
                state.p = state.p.min(self.end.p);
                state
            }
            None => self.end,
        }
    }

    /// Speed (m/s) at position `s` (m), clamped to the path (NaN counts as 0).
    pub fn v_at_s(&self, s: f64) -> f64 {
        self.at_position(s).v
    }

    /// The state at position `s` (m), clamped to the path (NaN counts as 0).
    pub fn at_position(&self, s: f64) -> MotionState {
        if s >= self.end.p || self.phases.is_empty() {
            return self.end;
        }
        let s = if s.is_nan() { 0.0 } else { s.max(0.0) };
        let i = self.phases.partition_point(|phase| phase.s <= s).saturating_sub(1);
        let phase = &self.phases[i];
        let dt = phase.time_to_cover(s - phase.s, self.end_time(i) - phase.t);
        let state = phase.after(dt);
        MotionState { p: s, v: state.v.max(0.0), ..state }
    }

    /// A sampler that remembers its place: amortised constant time for increasing `t`, no allocation.
    ///
    /// ```
    /// use arcfeed_feedrate::{MotionLaw, Segment, plan_per_segment};
    /// let segments = [Segment::new(0.01, 0.1, 1.0, 50.0)?; 4];
    /// let plan = plan_per_segment(&segments, 0.0, 0.0)?;
    /// let mut cursor = plan.cursor();
    /// let mut t = 0.0;
    /// while t < plan.duration() {
    ///     assert_eq!(cursor.at(t), plan.at(t));
    ///     t += 1e-3;
    /// }
    /// # Ok::<(), arcfeed_feedrate::FeedError>(())
    /// ```
    pub fn cursor(&self) -> Cursor<'_> {
        Cursor { plan: self, i: 0 }
    }
}

impl MotionLaw for SpeedPlan {
    fn duration(&self) -> f64 {
        self.duration
    }

    fn at(&self, t: f64) -> MotionState {
        if t >= self.duration {
            return self.end;
        }
        let t = if t.is_nan() { 0.0 } else { t.max(0.0) };
        let i = self.phases.partition_point(|phase| phase.t <= t).saturating_sub(1);
        self.state_in(i, t)
    }
}

/// A place in a [`SpeedPlan`] from which sampling goes on; see [`SpeedPlan::cursor`].
#[derive(Debug, Clone)]
pub struct Cursor<'a> {
    plan: &'a SpeedPlan,
    i: usize,
}

impl Cursor<'_> {
    /// The state at time `t` (s), the same as [`MotionLaw::at`] of the plan. Times may also go back; that costs a search.
    pub fn at(&mut self, t: f64) -> MotionState {
        let plan = self.plan;
        if t >= plan.duration {
            return plan.end;
        }
        let t = if t.is_nan() { 0.0 } else { t.max(0.0) };
        if plan.phases.get(self.i).is_some_and(|phase| phase.t > t) {
            self.i = plan.phases.partition_point(|phase| phase.t <= t).saturating_sub(1);
        }
        while plan.phases.get(self.i + 1).is_some_and(|next| next.t <= t) {
            self.i += 1;
        }
        plan.state_in(self.i, t)
    }
}

/// Collects phases into a plan, keeping time in compensated form so that thousands of phases do not drift.
#[derive(Debug)]
pub(crate) struct PlanBuilder {
    phases: Vec<Phase>,
    time: f64,
    lost: f64,
}

impl PlanBuilder {
    pub fn with_capacity(n: usize) -> Self {
        Self { phases: Vec::with_capacity(n), time: 0.0, lost: 0.0 }
    }

    /// Appends a phase that starts in the given state and lasts `dt`; one too short to move the clock is dropped.
    pub fn push(&mut self, s: f64, v: f64, a: f64, j: f64, dt: f64) {
        if self.time + dt > self.time {
            self.phases.push(Phase { t: self.time, s, v, a, j });
            // Neumaier's sum is not needed: the time never falls, so Kahan's is enough.
            let y = dt - self.lost;
            let sum = self.time + y;
            self.lost = (sum - self.time) - y;
            self.time = sum;
        }
    }

    /// Appends an S-profile that starts at `s0`.
    pub fn push_profile(&mut self, s0: f64, profile: &SProfile) {
        let phases = profile.phases();
        for (i, phase) in phases.iter().enumerate() {
            let end = phases.get(i + 1).map_or(profile.duration(), |next| next.t);
            self.push(s0 + phase.s, phase.v, phase.a, phase.j, end - phase.t);
        }
    }

    pub fn finish(self, length: f64, v_end: f64) -> SpeedPlan {
        SpeedPlan::from_parts(self.phases, MotionState { p: length, v: v_end, a: 0.0, j: 0.0 }, self.time)
    }
}
