//! Motion through way-points, cycle by cycle.

use std::ptr;

use arcfeed_feedrate::AxisState;
use arcfeed_sync::{Route, SyncError, WayPointGenerator};

use crate::axes::{self, ArcfeedAxisState, ArcfeedMotionState, motion_states, of_axes};
use crate::input::{
    All, by_count, finite, hand_out, held, place, put, read, read_all, same_count, take_back, write_all,
};
use crate::route::{ArcfeedRoute, with_route};
use crate::status::ArcfeedStatus::ArcfeedInvalid;
use crate::status::{ArcfeedStatus, Outcome, guarded, of_sync, refuse};

/// Moves 1 to 8 axes through way-points without a stop, one control cycle at a time, along a route that may be replaced in
/// any cycle. One thread uses it at a time.
pub struct ArcfeedWayPoints {
    inner: Box<dyn Pass>,
}

/// How far a motion along a route has come.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct ArcfeedProgress {
    /// Number of way-points of the route that have been passed.
    pub passed: usize,
    /// The end was reached in this cycle: the target, or the rest after a stop.
    pub reached: bool,
}

/// [`WayPointGenerator`] without its number of axes.
trait Pass {
    fn axes(&self) -> usize;
    /// Pointers of the route are NULL, not aligned, or point to what their names say.
    unsafe fn set_route(&mut self, route: &ArcfeedRoute) -> Outcome;
    fn stop(&mut self) -> Result<(), SyncError>;
    fn step(&mut self) -> (All<ArcfeedMotionState>, ArcfeedProgress);
    fn state(&self) -> &[AxisState];
    fn durations(&self) -> &[f64];
    fn at(&self, t: f64) -> All<ArcfeedMotionState>;
}

impl<const N: usize> Pass for WayPointGenerator<N> {
    fn axes(&self) -> usize {
        N
    }

    unsafe fn set_route(&mut self, route: &ArcfeedRoute) -> Outcome {
        unsafe { with_route(route, |route| self.set_route(route)) }
    }

    fn stop(&mut self) -> Result<(), SyncError> {
        self.stop()
    }

    fn step(&mut self) -> (All<ArcfeedMotionState>, ArcfeedProgress) {
        let step = self.step();
        (motion_states(&step.state), ArcfeedProgress { passed: step.passed, reached: step.reached })
    }

    fn state(&self) -> &[AxisState] {
        self.state()
    }

    fn durations(&self) -> &[f64] {
        self.motion().section_durations()
    }

    fn at(&self, t: f64) -> All<ArcfeedMotionState> {
        motion_states(&self.motion().at(t))
    }
}

unsafe fn make<const N: usize>(start: &All<AxisState>, route: &ArcfeedRoute, cycle: f64) -> Outcome<Box<dyn Pass>> {
    let made = |route: &Route<'_, N>| Ok(Box::new(WayPointGenerator::<N>::new(of_axes(start), route, cycle)?));
    Ok(unsafe { with_route(route, made) }?)
}

/// A motion from `start`, which has `axes` entries, along `route`; `cycle` is the control cycle (s). A start outside the
/// limits is brought back inside. On success `*out` holds the motion, else NULL. Takes up to 2 MB of stack.
///
/// # Safety
/// Pointers, those of the route, too, are NULL or point to what their names say.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn arcfeed_way_points_new(
    axes: usize,
    start: *const ArcfeedAxisState,
    route: *const ArcfeedRoute,
    cycle: f64,
    out: *mut *mut ArcfeedWayPoints,
) -> ArcfeedStatus {
    guarded(|| unsafe {
        *place("out", out)? = ptr::null_mut();
        let start = read_all("start", start, axes, axes::state)?;
        let route = read("route", route)?;
        let inner = by_count!(axes, make(&start, &route, cycle))?;
        hand_out("out", out, ArcfeedWayPoints { inner })
    })
}

/// Frees a motion through way-points; NULL is nothing to free.
///
/// # Safety
/// The motion is not used again.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn arcfeed_way_points_free(way_points: *mut ArcfeedWayPoints) {
    unsafe { take_back(way_points) };
}

/// Goes along another route from the state of the last step on. Plans it, in a time bounded by the number of its points and with up
/// to 0.4 MB of stack.
///
/// # Safety
/// Pointers, those of the route, too, are NULL or point to what their names say.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn arcfeed_way_points_set_route(
    way_points: *mut ArcfeedWayPoints,
    axes: usize,
    route: *const ArcfeedRoute,
) -> ArcfeedStatus {
    guarded(|| unsafe {
        let inner = &mut place("way_points", way_points)?.inner;
        same_count(axes, inner.axes())?;
        inner.set_route(&read("route", route)?)
    })
}

/// Brings every axis to rest in the shortest way of its own, and gives up the route.
///
/// # Safety
/// The motion is NULL or one that is in use nowhere else.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn arcfeed_way_points_stop(way_points: *mut ArcfeedWayPoints) -> ArcfeedStatus {
    guarded(|| unsafe { place("way_points", way_points)?.inner.stop().map_err(of_sync) })
}

/// Moves on by one cycle. `states` gets what to command at its end, one entry for each axis; `progress`, if it is not
/// NULL, how far the motion has come. After the end the axes go on with the velocity of the target.
///
/// # Safety
/// Pointers are NULL or point to what their names say; `states` has room for `axes` entries.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn arcfeed_way_points_step(
    way_points: *mut ArcfeedWayPoints,
    axes: usize,
    states: *mut ArcfeedMotionState,
    progress: *mut ArcfeedProgress,
) -> ArcfeedStatus {
    guarded(|| unsafe {
        let inner = &mut place("way_points", way_points)?.inner;
        same_count(axes, inner.axes())?;
        place("states", states)?;
        // All before the step, so that a call that fails has moved nothing.
        let wanted = if progress.is_null() { None } else { Some(place("progress", progress)?) };
        let (all, what) = inner.step();
        write_all("states", states, all.into_iter().take(axes))?;
        if let Some(progress) = wanted {
            *progress = what;
        }
        Ok(())
    })
}

/// Copies the state of the last step.
///
/// # Safety
/// Pointers are NULL or point to what their names say; `states` has room for `axes` entries.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn arcfeed_way_points_state(
    way_points: *const ArcfeedWayPoints,
    axes: usize,
    states: *mut ArcfeedAxisState,
) -> ArcfeedStatus {
    guarded(|| unsafe {
        let inner = &held("way_points", way_points)?.inner;
        same_count(axes, inner.axes())?;
        write_all("states", states, inner.state().iter().map(|s| ArcfeedAxisState::from(*s)))
    })
}

/// Duration of the motion along the route set last, from its beginning (s).
///
/// # Safety
/// Pointers are NULL or point to what their names say.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn arcfeed_way_points_duration(
    way_points: *const ArcfeedWayPoints,
    seconds: *mut f64,
) -> ArcfeedStatus {
    guarded(|| unsafe { put("seconds", seconds, held("way_points", way_points)?.inner.durations().iter().sum()) })
}

/// Durations of the sections of the route set last (s): one more than it has way-points, which `count` must be.
///
/// # Safety
/// Pointers are NULL or point to what their names say; `seconds` has room for `count` entries.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn arcfeed_way_points_section_durations(
    way_points: *const ArcfeedWayPoints,
    count: usize,
    seconds: *mut f64,
) -> ArcfeedStatus {
    guarded(|| unsafe {
        let durations = held("way_points", way_points)?.inner.durations();
        if count != durations.len() {
            let own = durations.len();
            return Err(refuse(ArcfeedInvalid, format_args!("count is {count}; this route has {own} sections")));
        }
        write_all("seconds", seconds, durations.iter().copied())
    })
}

/// The state of the motion along the route set last at time `t` (s) from its beginning, one entry of `states` for each
/// axis, without regard to cycles and stops. Computes the section of `t` anew.
///
/// # Safety
/// Pointers are NULL or point to what their names say; `states` has room for `axes` entries.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn arcfeed_way_points_at(
    way_points: *const ArcfeedWayPoints,
    t: f64,
    axes: usize,
    states: *mut ArcfeedMotionState,
) -> ArcfeedStatus {
    guarded(|| unsafe {
        let inner = &held("way_points", way_points)?.inner;
        same_count(axes, inner.axes())?;
        let all = inner.at(finite(&"t", "", t)?);
        write_all("states", states, all.into_iter().take(axes))
    })
}
