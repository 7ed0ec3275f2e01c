//! Motion from state to state.

use std::ptr;

use arcfeed_feedrate::{AxisLimits, AxisState};
use arcfeed_sync::{MotionOptions, Trajectory};

use crate::axes::{self, ArcfeedAxisLimits, ArcfeedAxisState, ArcfeedMotionState, motion_states, of_axes};
use crate::input::{
    All, by_count, finite, hand_out, held, place, put, read, read_all, same_count, take_back, write_all,
};
use crate::status::{ArcfeedStatus, Outcome, guarded, of_sync};

/// The shortest motion of 1 to 8 axes from a state to a state. It does not change: several threads may read it.
pub struct ArcfeedTrajectory {
    inner: Box<dyn Motion>,
}

/// Choices for a motion from state to state.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct ArcfeedMotionOptions {
    /// An ArcfeedSynchronisation.
    pub synchronisation: i32,
    /// The motion takes at least this long (s): exactly, unless that duration is impossible. 0 for the shortest.
    pub least_duration: f64,
    /// The duration is a multiple of this (s), the shortest that is possible. 0 for any duration.
    pub cycle: f64,
}

/// [`Trajectory`] without its number of axes.
trait Motion {
    fn axes(&self) -> usize;
    fn duration(&self) -> f64;
    fn is_straight(&self) -> bool;
    fn at(&self, t: f64) -> All<ArcfeedMotionState>;
}

impl<const N: usize> Motion for Trajectory<N> {
    fn axes(&self) -> usize {
        N
    }

    fn duration(&self) -> f64 {
        self.duration()
    }

    fn is_straight(&self) -> bool {
        self.is_straight()
    }

    fn at(&self, t: f64) -> All<ArcfeedMotionState> {
        motion_states(&self.at(t))
    }
}

fn make<const N: usize>(
    start: &All<AxisState>,
    target: &All<AxisState>,
    limits: &All<AxisLimits>,
    options: &MotionOptions,
) -> Outcome<Box<dyn Motion>> {
    let motion = Trajectory::<N>::new(&of_axes(start), &of_axes(target), &of_axes(limits), options);
    Ok(Box::new(motion.map_err(of_sync)?))
}

fn choices(c: &ArcfeedMotionOptions) -> Outcome<MotionOptions> {
    let options = MotionOptions::new(axes::synchronisation(c.synchronisation)?);
    let options = options.with_least_duration(c.least_duration).map_err(of_sync)?;
    if c.cycle == 0.0 { Ok(options) } else { options.with_cycle(c.cycle).map_err(of_sync) }
}

/// The shortest motion from `start` to `target` within `limits`, each with `axes` entries. On success `*out` holds the
/// motion, else NULL.
///
/// # Safety
/// Each pointer is valid for its type, or NULL, which is refused.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn arcfeed_trajectory_new(
    axes: usize,
    start: *const ArcfeedAxisState,
    target: *const ArcfeedAxisState,
    limits: *const ArcfeedAxisLimits,
    options: *const ArcfeedMotionOptions,
    out: *mut *mut ArcfeedTrajectory,
) -> ArcfeedStatus {
    guarded(|| unsafe {
        *place("out", out)? = ptr::null_mut();
        let start = read_all("start", start, axes, axes::state)?;
        let target = read_all("target", target, axes, axes::state)?;
        let limits = read_all("limits", limits, axes, axes::limits)?;
        let options = choices(&read("options", options)?)?;
        let inner = by_count!(axes, make(&start, &target, &limits, &options))?;
        hand_out("out", out, ArcfeedTrajectory { inner })
    })
}

/// Frees a motion; NULL is nothing to free.
///
/// # Safety
/// The motion is not used again.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn arcfeed_trajectory_free(trajectory: *mut ArcfeedTrajectory) {
    unsafe { take_back(trajectory) };
}

/// Duration (s): when the last axis arrives.
///
/// # Safety
/// Each pointer is valid for its type, or NULL, which is refused.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn arcfeed_trajectory_duration(
    trajectory: *const ArcfeedTrajectory,
    seconds: *mut f64,
) -> ArcfeedStatus {
    guarded(|| unsafe { put("seconds", seconds, held("trajectory", trajectory)?.inner.duration()) })
}

/// Whether all axes move in proportion, on a straight line.
///
/// # Safety
/// Each pointer is valid for its type, or NULL, which is refused.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn arcfeed_trajectory_is_straight(
    trajectory: *const ArcfeedTrajectory,
    is_straight: *mut bool,
) -> ArcfeedStatus {
    guarded(|| unsafe { put("is_straight", is_straight, held("trajectory", trajectory)?.inner.is_straight()) })
}

/// The state at time `t` (s), one entry of `states` for each axis. Before 0 it is the start; an axis that has arrived
/// goes on with the velocity of its target.
///
/// # Safety
/// Each pointer is valid for its type, or NULL, which is refused; `states` has room for `axes` entries.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn arcfeed_trajectory_at(
    trajectory: *const ArcfeedTrajectory,
    t: f64,
    axes: usize,
    states: *mut ArcfeedMotionState,
) -> ArcfeedStatus {
    guarded(|| unsafe {
        let inner = &held("trajectory", trajectory)?.inner;
        same_count(axes, inner.axes())?;
        let all = inner.at(finite(&"t", "", t)?);
        write_all("states", states, all.into_iter().take(axes))
    })
}
