//! Several axes that follow a moving target, given cycle by cycle.

use arcfeed_feedrate::{AxisLimits, AxisState, TargetTracker, TrackStatus, TrackStep};

use crate::error::SyncError;
use crate::joint_state::JointState;

/// State of all axes after a cycle, and what each of them does.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrackingStep<const N: usize> {
    /// Position, velocity, acceleration and jerk of the axes at the end of the cycle.
    pub state: JointState<N>,
    /// What each axis does.
    pub status: [TrackStatus; N],
}

impl<const N: usize> TrackingStep<N> {
    /// Returns true if every axis is in the state of its target, exactly.
    pub fn is_following(&self) -> bool {
        self.status.iter().all(|s| *s == TrackStatus::Following)
    }
}

/// `N` axes that follow a target whose state is given in every cycle, each within its own limits.
///
/// Every axis is a [`TargetTracker`] of its own: it meets its target as soon as it can, keeps to it
/// without error while the target keeps the limits, and stays as near as the limits allow while it
/// does not. The axes do not wait for each other, so that they arrive at different times; once all
/// of them follow, their common path is that of the target.
///
/// A cycle with a number that is not finite moves no axis. Nothing allocates.
///
/// ```
/// use arcfeed_sync::TrackingGenerator;
/// use arcfeed_sync::feedrate::{AxisLimits, AxisState};
/// let limits = [AxisLimits::symmetric(2.0, 10.0, 200.0)?; 2];
/// let mut tracking = TrackingGenerator::new(&[AxisState::rest(0.0); 2], &limits, 1e-3)?;
/// let mut cycles = 0;
/// loop {
///     cycles += 1;
///     // A place on a conveyor that runs along the first axis.
///     let along = AxisState::new(0.1 + 0.5e-3 * f64::from(cycles), 0.5, 0.0);
///     let step = tracking.step(&[along, AxisState::rest(0.2)])?;
///     if step.is_following() {
///         assert_eq!((step.state.q[0], step.state.qd[0], step.state.q[1]), (along.p, 0.5, 0.2));
///         break;
///     }
/// }
/// assert!(cycles < 600);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Copy)]
pub struct TrackingGenerator<const N: usize> {
    axes: [TargetTracker; N],
}

impl<const N: usize> TrackingGenerator<N> {
    /// At `start`, with a control cycle (s). A start outside the limits is brought back inside.
    ///
    /// # Errors
    /// [`SyncError::Cycle`]; [`SyncError::State`] naming the axis, and the field in its source: a
    /// start that is not finite, or limits that permit one direction only.
    pub fn new(start: &[AxisState; N], limits: &[AxisLimits; N], cycle: f64) -> Result<Self, SyncError> {
        if !(cycle.is_finite() && cycle > 0.0) {
            return Err(SyncError::Cycle { value: cycle });
        }
        let mut trackers = [None; N];
        for (axis, tracker) in trackers.iter_mut().enumerate() {
            let made = TargetTracker::new(&start[axis], &limits[axis], cycle);
            *tracker = Some(made.map_err(|source| SyncError::State { axis, source })?);
        }
        let axes = trackers.map(|tracker| tracker.unwrap_or_else(|| unreachable!("every axis has been made")));
        Ok(Self { axes })
    }

    /// Sets the limits from the next cycle on.
    ///
    /// # Errors
    /// [`SyncError::State`] naming an axis whose limits permit one direction only. Nothing changes
    /// then.
    pub fn set_limits(&mut self, limits: &[AxisLimits; N]) -> Result<(), SyncError> {
        let mut axes = self.axes;
        for (axis, (tracker, l)) in axes.iter_mut().zip(limits).enumerate() {
            tracker.set_limits(l).map_err(|source| SyncError::State { axis, source })?;
        }
        self.axes = axes;
        Ok(())
    }

    /// Moves on by one cycle, at whose end the axes of the target are in the states `target`.
    ///
    /// # Errors
    /// [`SyncError::State`] naming the axis, and the field of its target in the source. No axis
    /// moves then.
    pub fn step(&mut self, target: &[AxisState; N]) -> Result<TrackingStep<N>, SyncError> {
        let mut axes = self.axes;
        let mut step = TrackingStep { state: JointState::default(), status: [TrackStatus::Following; N] };
        for (axis, (tracker, target)) in axes.iter_mut().zip(target).enumerate() {
            let TrackStep { state, status } =
                tracker.step(target).map_err(|source| SyncError::State { axis, source })?;
            step.status[axis] = status;
            (step.state.q[axis], step.state.qd[axis]) = (state.p, state.v);
            (step.state.qdd[axis], step.state.qddd[axis]) = (state.a, state.j);
        }
        self.axes = axes;
        Ok(step)
    }

    /// The state at the end of the last cycle.
    pub fn state(&self) -> [AxisState; N] {
        std::array::from_fn(|k| *self.axes[k].state())
    }
}
