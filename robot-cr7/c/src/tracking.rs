//! Tracking: axes that follow a moving target, given in every cycle.

use std::ptr;

use arcfeed_feedrate::{AxisLimits, AxisState, TrackStatus};
use arcfeed_sync::{SyncError, TrackingGenerator};

use crate::axes::{self, ArcfeedAxisLimits, ArcfeedAxisState, ArcfeedMotionState, motion_states, of_axes};
use crate::input::{All, by_count, hand_out, held, place, read_all, same_count, take_back, write_all};
use crate::status::{ArcfeedStatus, Outcome, guarded, of_sync};

/// Follows a moving target with 1 to 8 axes, each within its own limits: a conveyor, a teleoperator. One thread uses it at
/// a time.
pub struct ArcfeedTracking {
    inner: Box<dyn Track>,
}

/// What the axes do in a cycle. Bit k of a mask belongs to axis k.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct ArcfeedTrackingStatus {
    /// The axes that are in the state of the target exactly.
    pub following: u32,
    /// The axes that do what their limits allow, because the target exceeds them.
    pub saturated: u32,
    /// Every axis is in the state of its target. Axes in neither mask are on their way.
    pub is_following: bool,
}

/// [`TrackingGenerator`] without its number of axes.
trait Track {
    fn axes(&self) -> usize;
    fn set_limits(&mut self, limits: &All<AxisLimits>) -> Result<(), SyncError>;
    fn step(&mut self, target: &All<AxisState>) -> Result<(All<ArcfeedMotionState>, ArcfeedTrackingStatus), SyncError>;
    fn state(&self) -> All<ArcfeedAxisState>;
}

impl<const N: usize> Track for TrackingGenerator<N> {
    fn axes(&self) -> usize {
        N
    }

    fn set_limits(&mut self, limits: &All<AxisLimits>) -> Result<(), SyncError> {
        self.set_limits(&of_axes(limits))
    }

    fn step(&mut self, target: &All<AxisState>) -> Result<(All<ArcfeedMotionState>, ArcfeedTrackingStatus), SyncError> {
        let step = self.step(&of_axes(target))?;
        let mask = |wanted| step.status.iter().rev().fold(0, |bits, &status| bits << 1 | u32::from(status == wanted));
        let status = ArcfeedTrackingStatus {
            following: mask(TrackStatus::Following),
            saturated: mask(TrackStatus::Saturated),
            is_following: step.is_following(),
        };
        Ok((motion_states(&step.state), status))
    }

    fn state(&self) -> All<ArcfeedAxisState> {
        let state = self.state();
        std::array::from_fn(|k| state.get(k).copied().unwrap_or_default().into())
    }
}

fn make<const N: usize>(start: &All<AxisState>, limits: &All<AxisLimits>, cycle: f64) -> Outcome<Box<dyn Track>> {
    let tracking = TrackingGenerator::<N>::new(&of_axes(start), &of_axes(limits), cycle).map_err(of_sync)?;
    Ok(Box::new(tracking))
}

/// Axes at `start` that follow a target. `start` and `limits` have `axes` entries; `cycle` is the control cycle (s). A start
/// outside the limits is brought back inside. On success `*out` holds the axes, else NULL.
///
/// # Safety
/// Each pointer is valid for its type, or NULL, which is refused.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn arcfeed_tracking_new(
    axes: usize,
    start: *const ArcfeedAxisState,
    limits: *const ArcfeedAxisLimits,
    cycle: f64,
    out: *mut *mut ArcfeedTracking,
) -> ArcfeedStatus {
    guarded(|| unsafe {
        *place("out", out)? = ptr::null_mut();
        let start = read_all("start", start, axes, axes::state)?;
        let limits = read_all("limits", limits, axes, axes::limits)?;
        let inner = by_count!(axes, make(&start, &limits, cycle))?;
        hand_out("out", out, ArcfeedTracking { inner })
    })
}

/// Frees axes that follow; NULL is nothing to free.
///
/// # Safety
/// The value is not used again.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn arcfeed_tracking_free(tracking: *mut ArcfeedTracking) {
    unsafe { take_back(tracking) };
}

/// Sets the limits of all axes from the next cycle on.
///
/// # Safety
/// Each pointer is valid for its type, or NULL, which is refused.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn arcfeed_tracking_set_limits(
    tracking: *mut ArcfeedTracking,
    axes: usize,
    limits: *const ArcfeedAxisLimits,
) -> ArcfeedStatus {
    guarded(|| unsafe {
        let inner = &mut place("tracking", tracking)?.inner;
        same_count(axes, inner.axes())?;
        inner.set_limits(&read_all("limits", limits, axes, axes::limits)?).map_err(of_sync)
    })
}

/// Moves on by one cycle, at whose end the target is in the state `target`. `states` gets what to command then; `status`,
/// if it is not NULL, what the axes do. A call that is refused moves no axis.
///
/// # Safety
/// Each pointer is valid for its type, or NULL, which is refused; `target` has `axes` entries, and `states` room for as many.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn arcfeed_tracking_step(
    tracking: *mut ArcfeedTracking,
    axes: usize,
    target: *const ArcfeedAxisState,
    states: *mut ArcfeedMotionState,
    status: *mut ArcfeedTrackingStatus,
) -> ArcfeedStatus {
    guarded(|| unsafe {
        let inner = &mut place("tracking", tracking)?.inner;
        same_count(axes, inner.axes())?;
        let target = read_all("target", target, axes, axes::state)?;
        place("states", states)?;
        // All before the step, so that a call that fails has moved nothing.
        let wanted = if status.is_null() { None } else { Some(place("status", status)?) };
        let (all, what) = inner.step(&target).map_err(of_sync)?;
        write_all("states", states, all.into_iter().take(axes))?;
        if let Some(status) = wanted {
            *status = what;
        }
        Ok(())
    })
}

/// Copies the state of the last step.
///
/// # Safety
/// Each pointer is valid for its type, or NULL, which is refused; `states` has room for `axes` entries.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn arcfeed_tracking_state(
    tracking: *const ArcfeedTracking,
    axes: usize,
    states: *mut ArcfeedAxisState,
) -> ArcfeedStatus {
    guarded(|| unsafe {
        let inner = &held("tracking", tracking)?.inner;
        same_count(axes, inner.axes())?;
        write_all("states", states, inner.state().into_iter().take(axes))
    })
}
