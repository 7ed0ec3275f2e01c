//! The motion through way-points, section by section.

use arcfeed_feedrate::{AxisLimits, AxisState, StateToState};

use super::{NODES, SECTIONS};
use crate::error::SyncError;
use crate::joint_state::JointState;
use crate::mode::{MotionOptions, Synchronisation};
use crate::state_to_state::{Trajectory, keeps_what_holds};

/// A motion of `N` axes through way-points, which all axes pass at the same times.
///
/// Holds the states at the points and the durations between them. The phases of a section are
/// computed again where they are needed, in some microseconds and with the same result.
#[derive(Debug, Clone, PartialEq)]
pub struct WayPointTrajectory<const N: usize> {
    pub(super) sections: usize,
    pub(super) states: [[AxisState; N]; NODES],
    pub(super) durations: [f64; SECTIONS],
    pub(super) limits: [[AxisLimits; N]; SECTIONS],
    pub(super) kinds: [SectionKind; SECTIONS],
}

/// What a section of a motion through way-points is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum SectionKind {
    /// The shortest motion of all axes in common time.
    Free,
    /// The shortest motion on a straight line.
    Line,
    /// From one line to the next, past the point between them.
    Blend,
    /// To rest before the first line, every axis in the shortest way of its own.
    Stop,
    /// A point that was given again, in no time.
    Again,
}

impl<const N: usize> WayPointTrajectory<N> {
    /// Duration (s).
    pub fn duration(&self) -> f64 {
        self.section_durations().iter().sum()
    }

    /// The durations of the sections (s), one more than there are way-points. A blend is a section of
    /// its own, and so is the stop before a straight line that begins in motion.
    pub fn section_durations(&self) -> &[f64] {
        &self.durations[..self.sections]
    }

    /// The states of the axes at the start, at every way-point, and at the target; of a blend those at
    /// its begin and its end.
    pub fn states(&self) -> &[[AxisState; N]] {
        &self.states[..=self.sections]
    }

    /// The motion before any: a place, without a section.
    pub(crate) fn standing(place: &[AxisState; N], limits: &[AxisLimits; N]) -> Self {
        Self {
            sections: 0,
            states: [place.map(|s| AxisState::rest(s.p)); NODES],
            durations: [0.0; SECTIONS],
            limits: [*limits; SECTIONS],
            kinds: [SectionKind::Free; SECTIONS],
        }
    }

    /// Becomes the motion before any.
    pub(super) fn stand(&mut self, place: &[AxisState; N], limits: &[AxisLimits; N]) {
        self.sections = 0;
        self.states = [place.map(|s| AxisState::rest(s.p)); NODES];
        self.durations = [0.0; SECTIONS];
        self.limits = [*limits; SECTIONS];
        self.kinds = [SectionKind::Free; SECTIONS];
    }

    /// The state at the end.
    pub(crate) const fn target(&self) -> &[AxisState; N] {
        &self.states[self.sections]
    }

    /// The limits of a section; the last one counts after the last.
    pub(crate) fn limits(&self, section: usize) -> &[AxisLimits; N] {
        &self.limits[section.min(self.sections.saturating_sub(1))]
    }

    /// The motion of a section.
    ///
    /// # Errors
    /// [`SyncError::NoSuchSection`].
    pub fn section(&self, index: usize) -> Result<Trajectory<N>, SyncError> {
        if index >= self.sections {
            return Err(SyncError::NoSuchSection { index, count: self.sections });
        }
        let (from, to) = (&self.states[index], &self.states[index + 1]);
        // What stands before it takes no time.
        let first = self.kinds[..index].iter().all(|kind| *kind == SectionKind::Again);
        match self.kinds[index] {
            SectionKind::Free => section((first, from, to), &self.limits[index], self.durations[index]),
            kind => unfree(kind, (from, to), &self.limits[index], self.durations[index]),
        }
    }

    /// What a section is.
    ///
    /// # Errors
    /// [`SyncError::NoSuchSection`].
    pub fn section_kind(&self, index: usize) -> Result<SectionKind, SyncError> {
        let count = self.sections;
        self.kinds[..count].get(index).copied().ok_or(SyncError::NoSuchSection { index, count })
    }

    /// Returns true if a section ends in a way-point or the target, not within a blend or a stop.
    pub(crate) fn ends_in_point(&self, index: usize) -> bool {
        let blend = index + 1 < self.sections && self.kinds[index + 1] == SectionKind::Blend;
        self.kinds[index] != SectionKind::Stop && !blend
    }

    /// Returns true if a section is a straight line.
    pub(crate) fn is_line(&self, index: usize) -> bool {
        self.kinds[index] == SectionKind::Line
    }

    /// The section that acts at time `t` (s), and the time since it began. After the end it is the
    /// last one.
    pub fn section_at(&self, t: f64) -> (usize, f64) {
        let mut left = t;
        for (i, duration) in self.section_durations().iter().enumerate() {
            if left < *duration || i + 1 == self.sections {
                return (i, left);
            }
            left -= duration;
        }
        (0, t)
    }

    /// The state at time `t` (s), as [`Trajectory::at`] before the start and after the end.
    ///
    /// Computes the section anew: [`WayPointTrajectory::section`] serves many samples.
    pub fn at(&self, t: f64) -> JointState<N> {
        let (index, since) = self.section_at(t);
        self.section(index).map_or_else(|_| JointState::of(&self.states[index]), |motion| motion.at(since))
    }
}

/// A section that is not free, inside its limits.
pub(super) fn unfree<const N: usize>(
    kind: SectionKind,
    (from, to): (&[AxisState; N], &[AxisState; N]),
    limits: &[AxisLimits; N],
    duration: f64,
) -> Result<Trajectory<N>, SyncError> {
    let motion = if kind == SectionKind::Line {
        let options = MotionOptions::new(Synchronisation::ForcedStraight).with_least_duration(duration)?;
        Trajectory::new(from, to, limits, &options)?
    } else {
        let mut motions = [StateToState::default(); N];
        for (axis, motion) in motions.iter_mut().enumerate() {
            *motion = match kind {
                SectionKind::Blend | SectionKind::Again => StateToState::blend(&from[axis], &to[axis], duration),
                _ => StateToState::stop(&from[axis], &limits[axis]),
            }
            .map_err(|source| SyncError::State { axis, source })?;
        }
        Trajectory::of(motions)
    };
    match (0..N).find(|&k| !keeps_what_holds(&motion.axes()[k], &from[k], &limits[k])) {
        Some(axis) => Err(SyncError::SectionExceeds { axis }),
        None => Ok(motion),
    }
}

/// The shortest motion of a section in common time, whose limits have been checked at the extremes
/// of all its phases. Only the first section that takes time may begin outside its limits.
pub(super) fn section<const N: usize>(
    (first, from, to): (bool, &[AxisState; N], &[AxisState; N]),
    limits: &[AxisLimits; N],
    least_duration: f64,
) -> Result<Trajectory<N>, SyncError> {
    let options = MotionOptions::new(Synchronisation::Time).with_least_duration(least_duration)?;
    let motion = Trajectory::new(from, to, limits, &options)?;
    let exceeds = |k: &usize| {
        let (begin, l) = (&from[*k], &limits[*k]);
        (!first && !l.contain(begin)) || !keeps_what_holds(&motion.axes()[*k], begin, l)
    };
    match (0..N).find(exceeds) {
        Some(axis) => Err(SyncError::SectionExceeds { axis }),
        None => Ok(motion),
    }
}
