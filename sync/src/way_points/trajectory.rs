//! The motion through way-points, section by section.

use arcfeed_feedrate::{AxisLimits, AxisState};

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
}

impl<const N: usize> WayPointTrajectory<N> {
    /// Duration (s).
    pub fn duration(&self) -> f64 {
        self.section_durations().iter().sum()
    }

    /// The durations of the sections (s), one more than there are way-points.
    pub fn section_durations(&self) -> &[f64] {
        &self.durations[..self.sections]
    }

    /// The states of the axes at the start, at every way-point, and at the target.
    pub fn states(&self) -> &[[AxisState; N]] {
        &self.states[..=self.sections]
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
        section((index, from, to), &self.limits[index], self.durations[index])
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
        self.section(index).map_or_else(|_| JointState::default(), |motion| motion.at(since))
    }
}

/// The shortest motion of a section in common time, whose limits have been checked at the extremes
/// of all its phases. Only the first section may begin outside its limits.
pub(super) fn section<const N: usize>(
    (index, from, to): (usize, &[AxisState; N], &[AxisState; N]),
    limits: &[AxisLimits; N],
    least_duration: f64,
) -> Result<Trajectory<N>, SyncError> {
    let options = MotionOptions::new(Synchronisation::Time).with_least_duration(least_duration)?;
    let motion = Trajectory::new(from, to, limits, &options)?;
    let exceeds = |k: &usize| {
        let (begin, l) = (&from[*k], &limits[*k]);
        (index > 0 && !l.contain(begin)) || !keeps_what_holds(&motion.axes()[*k], begin, l)
    };
    match (0..N).find(exceeds) {
        Some(axis) => Err(SyncError::SectionExceeds { axis }),
        None => Ok(motion),
    }
}
