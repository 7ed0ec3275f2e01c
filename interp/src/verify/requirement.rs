//! All requirements on a motion.

use arcfeed_kinematics::ForwardKinematics;

use crate::limits::{Feeds, Limits, Section};
use crate::path::MotionPath;

/// All requirements on a motion, for [`verify`](crate::verify).
#[derive(Clone, Copy)]
pub struct Requirement<'a, const N: usize = 6> {
    /// The arm.
    pub arm: &'a (dyn ForwardKinematics<N> + Sync),
    /// The path that is followed.
    pub path: &'a dyn MotionPath<N>,
    /// Limits of joints, tool and drives.
    pub limits: &'a Limits<'a, N>,
    /// True if jerk is limited. Accelerations may step where it is not.
    pub jerk_limited: bool,
    /// Largest chord error between two control cycles, m.
    pub chord_tolerance: f64,
    /// Largest deviation of the tool from the path, m.
    pub path_tolerance: f64,
    /// Control period, s.
    pub period: f64,
    /// Parts of the path with a feed of their own, in their order on it, without overlap.
    pub sections: &'a [Section],
    /// Speeds at the start and at the end, units of the parameter per s.
    pub end_speeds: [f64; 2],
}

impl<const N: usize> std::fmt::Debug for Requirement<'_, N> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Requirement")
            .field("path", &self.path)
            .field("limits", &self.limits)
            .field("jerk_limited", &self.jerk_limited)
            .field("chord_tolerance", &self.chord_tolerance)
            .field("path_tolerance", &self.path_tolerance)
            .field("period", &self.period)
            .field("sections", &self.sections)
            .field("end_speeds", &self.end_speeds)
            .finish_non_exhaustive()
    }
}

impl<const N: usize> Requirement<'_, N> {
    /// Programmed feed at `s`, m/s; infinite where there is none.
    pub(super) fn feed_at(&self, s: f64) -> f64 {
        self.feeds().at(s)
    }

    fn feeds(&self) -> Feeds<'_> {
        Feeds { elsewhere: self.limits.tool().feed().unwrap_or(f64::INFINITY), sections: self.sections }
    }

    /// A speed and an acceleration of the tool beside which an error is measured, m/s and m/s^2.
    pub(super) fn scales(&self) -> [f64; 2] {
        let (tool, joints) = (self.limits.tool(), self.limits.joints());
        let feed = self.feeds().highest();
        [
            if feed.is_finite() { feed } else { joints.velocity().min() },
            tool.tangential_acceleration().unwrap_or(joints.acceleration().min()),
        ]
    }
}
