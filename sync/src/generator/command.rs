//! What the axes were told last.

use arcfeed_feedrate::AxisLimits;

/// The command that is carried out.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Command<const N: usize> {
    /// To the target, and on from there.
    Target,
    /// Along the route to its target.
    Route,
    /// To rest, every axis in the shortest way or all on a line.
    Stop,
    /// To rest without leaving the curve of the plan, within the limits at its begin.
    PathStop { limits: [AxisLimits; N] },
    /// Velocities, for so many cycles more.
    Jog { velocity: [f64; N], left: f64 },
}
