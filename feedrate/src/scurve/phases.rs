//! Motions as a sequence of phases of constant jerk.

use super::phase::Phase;
use crate::state::MotionState;

/// At most `CAP` phases of constant jerk in order, and the state they end in. Allocates nothing.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Phases<const CAP: usize> {
    phases: [Phase; CAP],
    /// Durations of the phases. The difference of two start times would carry the round-off of the
    /// whole duration.
    durations: [f64; CAP],
    count: usize,
    pub duration: f64,
    pub end: MotionState,
}

impl<const CAP: usize> Phases<CAP> {
    /// No phases: the motion rests at `end`.
    pub const fn at_rest(end: MotionState) -> Self {
        let none = Phase { t: 0.0, s: 0.0, v: 0.0, a: 0.0, j: 0.0 };
        Self { phases: [none; CAP], durations: [0.0; CAP], count: 0, duration: 0.0, end }
    }

    /// Appends a phase that lasts `dt`; its start time is the end of the phase before. A phase
    /// without duration is dropped, and so is one beyond `CAP`.
    #[inline]
    pub fn push(&mut self, phase: Phase, dt: f64) {
        if dt > 0.0 && self.count < CAP {
            self.phases[self.count] = Phase { t: self.duration, ..phase };
            self.durations[self.count] = dt;
            self.count += 1;
            self.duration += dt;
        }
    }

    /// Position, velocity and acceleration at the begin, which are those of the first phase but for round-off.
    pub fn begin_at(&mut self, [s, v, a]: [f64; 3]) {
        if let Some(first) = self.phases[..self.count].first_mut() {
            *first = Phase { s, v, a, ..*first };
        }
    }

    /// Removes all phases.
    pub fn clear(&mut self) {
        self.count = 0;
        self.duration = 0.0;
    }

    /// Makes the last phase longer by `dt`.
    pub fn extend_last(&mut self, dt: f64) {
        if self.count > 0 {
            self.durations[self.count - 1] += dt;
            self.duration += dt;
        }
    }

    pub const fn len(&self) -> usize {
        self.count
    }

    #[inline]
    pub fn get(&self, i: usize) -> (Phase, f64) {
        (self.phases[i], self.durations[i])
    }

    /// The phases in order, each with its duration (s), which is not zero.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = (Phase, f64)> + DoubleEndedIterator + '_ {
        self.phases[..self.count].iter().copied().zip(self.durations[..self.count].iter().copied())
    }

    /// Replaces every phase and its duration.
    pub fn map(&mut self, f: impl Fn(Phase, f64) -> (Phase, f64)) {
        for (phase, dt) in self.phases[..self.count].iter_mut().zip(&mut self.durations) {
            (*phase, *dt) = f(*phase, *dt);
        }
    }

    /// Index of the phase that acts at time `t` (s) within the duration; of two phases that meet at
    /// `t` the later one.
    #[inline]
    pub fn index_at(&self, t: f64) -> usize {
        (1..self.count).take_while(|&i| self.phases[i].t <= t).count()
    }

    /// The state at time `t` (s), clamped to `[0, duration]` (NaN counts as 0).
    #[inline]
    pub fn at(&self, t: f64) -> MotionState {
        if t >= self.duration {
            return self.end;
        }
        let t = if t > 0.0 { t } else { 0.0 };
        let i = self.index_at(t);
        let phase = &self.phases[i];
        phase.after((t - phase.t).min(self.durations[i]))
    }

    /// The remainder of the phases after time `t` (s).
    pub fn remaining(&self, t: f64) -> impl Iterator<Item = (Phase, f64)> + '_ {
        self.iter().filter_map(move |(phase, dt)| {
            let gone = t - phase.t;
            if gone >= dt {
                return None;
            }
            if gone <= 0.0 {
                return Some((phase, dt));
            }
            let now = phase.after(gone);
            Some((Phase { t, s: now.p, v: now.v, a: now.a, j: now.j }, dt - gone))
        })
    }

    /// Returns true if all numbers are finite.
    pub fn is_finite(&self) -> bool {
        // Finite numbers times zero are zero. What a phase adds is finite at any time inside if it is at the end, term by term.
        let way = |p: &Phase, dt: f64| p.v.abs() * dt + dt * dt * (p.a.abs() + p.j.abs() * dt);
        let sum: f64 = self.iter().map(|(p, dt)| 0.0 * (p.t + p.s + p.v + p.a + p.j + way(&p, dt))).sum();
        sum == 0.0 && self.duration.is_finite() && self.end.p.is_finite()
    }
}

/// A standstill at 0.
impl<const CAP: usize> Default for Phases<CAP> {
    fn default() -> Self {
        Self::at_rest(MotionState::default())
    }
}

/// Only phases that are in use count.
impl<const CAP: usize> PartialEq for Phases<CAP> {
    fn eq(&self, other: &Self) -> bool {
        self.duration == other.duration && self.end == other.end && self.iter().eq(other.iter())
    }
}
