//! The status of a projection synchroniser.

/// Status of the motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ProjectionStatus {
    /// The state is being brought inside the limits, acceleration to zero.
    Recovering,
    /// The velocity across the line to the target is being taken off.
    Turning,
    /// On the straight line to the target.
    Straight,
    /// At the target, at rest.
    Reached {
        /// Part of the last period that was not needed (s).
        unused: f64,
    },
}
