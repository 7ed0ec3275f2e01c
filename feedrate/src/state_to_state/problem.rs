//! One problem and its answers: the shortest motion, the durations that are possible, the motion of
//! a given duration.

use super::durations::Durations;
use super::entry::{Entry, Shortest};
use super::profile::StateToState;
use super::scale::Units;
use crate::error::{FeedError, finite};
use crate::limits::{AxisLimits, SLACK};
use crate::state::AxisState;

/// A motion of one axis from state to state whose duration is not decided yet.
///
/// Holds the shortest motion and answers which other durations are possible and how to move in one
/// of them.
///
/// ```
/// use arcfeed_feedrate::{AxisLimits, AxisProblem, AxisState, MotionLaw};
/// let limits = AxisLimits::symmetric(1.0, 2.0, 8.0)?;
/// // At full speed, and at full speed again a little later: now, or after having turned back.
/// let problem = AxisProblem::new(&AxisState::new(0.0, 1.0, 0.0), &AxisState::new(0.5, 1.0, 0.0), &limits)?;
/// let durations = problem.durations();
/// assert_eq!(durations.shortest(), 0.5);
/// let (_, above) = durations.blocked()[0];
/// assert!(problem.with_duration(1.5).is_err());
/// assert!(problem.durations().contains(above));
/// assert_eq!(problem.with_duration(above + 0.1)?.duration(), above + 0.1);
/// # Ok::<(), arcfeed_feedrate::FeedError>(())
/// ```
#[derive(Debug, Clone, Copy)]
pub struct AxisProblem {
    entry: Entry,
    units: Option<Units>,
    /// The target in the caller's units, and the jerk limits.
    target: AxisState,
    jerk: (f64, f64),
    /// Duration of the shortest motion, in the caller's units.
    duration: f64,
    shortest: Shortest,
}

impl AxisProblem {
    /// From `start` to `target` within `limits`.
    ///
    /// # Errors
    /// As [`StateToState::new`].
    pub fn new(start: &AxisState, target: &AxisState, limits: &AxisLimits) -> Result<Self, FeedError> {
        let fields = [
            ("start.p", start.p),
            ("start.v", start.v),
            ("start.a", start.a),
            ("target.p", target.p),
            ("target.v", target.v),
            ("target.a", target.a),
        ];
        for (what, value) in fields {
            finite(what, value)?;
        }
        check_target(target, limits)?;
        // Nothing can leave the range of numbers without special units.
        let units = Units::choose(start, target, limits);
        let entry = match units {
            None => Entry::new(start, target, limits)?,
            Some(u) => Entry::new(&u.state_into(start), &u.state_into(target), &u.limits_into(limits))
                .map_err(|e| rescaled_error(e, u))?,
        };
        let shortest = entry.solve();
        let duration = units.map_or(shortest.duration, |u| u.time_back(shortest.duration));
        let problem = Self { entry, units, target: *target, jerk: limits.j, duration, shortest };
        if units.is_some() {
            problem.shortest().check_sound()?;
        }
        Ok(problem)
    }

    /// The shortest motion to the velocity and acceleration of `target`, all numbers finite.
    pub(super) fn direct(s: &AxisState, t: &AxisState, l: &AxisLimits) -> Result<StateToState, FeedError> {
        let mut motion = StateToState::default();
        let Some(units) = Units::choose(s, t, l) else {
            let p = Entry::new(s, t, l)?.direct(&mut motion);
            motion.set_target(&AxisState { p, ..*t }, l.j);
            return Ok(motion);
        };
        let entry = Entry::new(&units.state_into(s), &units.state_into(t), &units.limits_into(l));
        let p = entry.map_err(|e| rescaled_error(e, units))?.direct(&mut motion);
        motion.rescale(units);
        motion.set_target(&AxisState { p: units.back(p, 0), ..*t }, l.j);
        motion.check_sound().map(|()| motion)
    }

    /// How far the motion of [`AxisProblem::direct`] goes.
    pub(super) fn direct_displacement(s: &AxisState, t: &AxisState, l: &AxisLimits) -> Result<f64, FeedError> {
        let Some(u) = Units::choose(s, t, l) else {
            return Entry::new(s, t, l).map(|entry| entry.direct_end() - s.p);
        };
        let entry = Entry::new(&u.state_into(s), &u.state_into(t), &u.limits_into(l));
        entry.map(|entry| u.back(entry.direct_end(), 0) - s.p).map_err(|e| rescaled_error(e, u))
    }

    /// The shortest motion.
    pub fn shortest(&self) -> StateToState {
        let mut motion = StateToState::default();
        self.write_shortest(&mut motion);
        motion
    }

    /// Duration of the shortest motion (s).
    pub const fn shortest_duration(&self) -> f64 {
        self.duration
    }

    pub(super) fn write_shortest(&self, out: &mut StateToState) {
        self.entry.write(&self.shortest, out);
        out.set_target(&self.target, self.jerk);
        if let Some(u) = self.units {
            out.rescale(u);
        }
    }

    /// The durations that are possible.
    ///
    /// From a start outside the limits every duration counts as possible in which either of two
    /// ways back is: settling at the velocity limit without undershooting it, or braking as hard as
    /// possible until inside. [`AxisProblem::with_duration`] may find more then; from inside the
    /// limits these are all.
    pub fn durations(&self) -> Durations {
        let lead = self.entry.lead_time;
        let gaps = self.entry.gaps(self.shortest.duration - lead, self.shortest.mirrored);
        match self.units {
            None => gaps.durations(self.duration, |t| t + lead),
            Some(u) => gaps.durations(self.duration, |t| u.time_back(t + lead)),
        }
    }

    /// A motion that takes exactly `duration` (s).
    ///
    /// With one cruise velocity wherever there is such a motion; otherwise the mean of the two that
    /// go farthest and least far in that time, which keeps the limits as those do.
    ///
    /// # Errors
    /// [`FeedError::DurationImpossible`] with the nearest possible ones, [`FeedError::NotFinite`].
    pub fn with_duration(&self, duration: f64) -> Result<StateToState, FeedError> {
        let mut motion = StateToState::default();
        self.with_duration_into(duration, &mut motion).map(|()| motion)
    }

    /// As [`AxisProblem::with_duration`], into a motion that is there already; an error leaves it
    /// undefined.
    ///
    /// # Errors
    /// As [`AxisProblem::with_duration`].
    pub fn with_duration_into(&self, duration: f64, out: &mut StateToState) -> Result<(), FeedError> {
        self.with_duration_knowing(duration, &mut None, out)
    }

    /// As [`AxisProblem::with_duration_into`]. The possible durations of the same problem are kept in `known` once they are needed: they take
    /// several times as long as a motion, and another attempt needs them again.
    ///
    /// # Errors
    /// As [`AxisProblem::with_duration`].
    pub fn with_duration_knowing(
        &self,
        duration: f64,
        known: &mut Option<Durations>,
        out: &mut StateToState,
    ) -> Result<(), FeedError> {
        if duration == self.duration {
            self.write_shortest(out);
            return Ok(());
        }
        finite("duration", duration)?;
        let inside = self.units.map_or(duration, |u| u.time_into(duration));
        // One cruise velocity proves the duration possible by itself.
        if !(duration > self.duration && self.entry.cruising(inside, out)) {
            let durations = known.get_or_insert_with(|| self.durations());
            if !durations.contains(duration) {
                let (below, above) = (durations.at_most(duration), durations.at_least(duration));
                return Err(FeedError::DurationImpossible { duration, below, above });
            }
            if !self.entry.between(inside, out) {
                // At an end of the possible durations, but for round-off.
                let (below, above) = (durations.at_most(duration * (1.0 - BESIDE)), duration * (1.0 + BESIDE));
                return Err(FeedError::DurationImpossible { duration, below, above });
            }
        }
        out.set_target(&self.target, self.jerk);
        if let Some(u) = self.units {
            out.rescale(u);
            out.check_sound()?;
        }
        out.phases.duration = duration;
        Ok(())
    }
}

/// Relative distance of a duration beside an end of the possible ones.
const BESIDE: f64 = 1e-9;

impl StateToState {
    /// The shortest motion from `start` to `target` within `limits`.
    ///
    /// A start may be outside the limits. An acceleration beyond its bound is first taken back with
    /// the largest jerk; a velocity beyond its bound (or bound to get there) is brought to the
    /// bound, or further inside, without undershooting it.
    ///
    /// # Errors
    /// [`FeedError::NotFinite`] naming the field; [`FeedError::TargetOutside`] and
    /// [`FeedError::TargetUnreachable`] if the target breaks a limit or forces to break one right
    /// before it; [`FeedError::OutOfRange`] if the motion has no finite representation.
    pub fn new(start: &AxisState, target: &AxisState, limits: &AxisLimits) -> Result<Self, FeedError> {
        Ok(AxisProblem::new(start, target, limits)?.shortest())
    }

    /// As [`StateToState::new`], in place: saves moving the result. An error leaves the motion as
    /// it was.
    ///
    /// # Errors
    /// As [`StateToState::new`].
    pub fn recompute(&mut self, start: &AxisState, target: &AxisState, limits: &AxisLimits) -> Result<(), FeedError> {
        AxisProblem::new(start, target, limits)?.write_shortest(self);
        Ok(())
    }

    /// A motion that takes exactly `duration` (s): see [`AxisProblem::with_duration`].
    ///
    /// # Errors
    /// As [`StateToState::new`] and [`AxisProblem::with_duration`].
    pub fn with_duration(
        start: &AxisState,
        target: &AxisState,
        limits: &AxisLimits,
        duration: f64,
    ) -> Result<Self, FeedError> {
        AxisProblem::new(start, target, limits)?.with_duration(duration)
    }
}

pub(super) fn check_target(target: &AxisState, limits: &AxisLimits) -> Result<(), FeedError> {
    limits.check_both_directions()?;
    check_inside("v", target.v, limits.v)?;
    check_inside("a", target.a, limits.a)
}

fn check_inside(what: &'static str, value: f64, (lower, upper): (f64, f64)) -> Result<(), FeedError> {
    let slack = SLACK * upper.max(-lower);
    let limit = if value < lower { lower } else { upper };
    if value >= lower - slack && value <= upper + slack {
        Ok(())
    } else {
        Err(FeedError::TargetOutside { what, value, limit })
    }
}

fn rescaled_error(e: FeedError, units: Units) -> FeedError {
    match e {
        FeedError::TargetUnreachable { v, a, before, limit } => FeedError::TargetUnreachable {
            v: units.back(v, 1),
            a: units.back(a, 2),
            before: units.back(before, 1),
            limit: units.back(limit, 1),
        },
        other => other,
    }
}
