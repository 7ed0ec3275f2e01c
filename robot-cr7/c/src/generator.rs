//! Online generation: making, setting and reading.

use std::ptr;

use arcfeed_feedrate::{AxisLimits, AxisState};
use arcfeed_sync::{OnlineGenerator, SyncError, Synchronisation, WayPointPlanner, WayPointTrajectory};

use crate::axes::{
    self, ArcfeedAxisLimits, ArcfeedAxisState, ArcfeedMotionState, ArcfeedRange, motion_states, of_axes,
};
use crate::input::{All, by_count, hand_out, held, place, read_all, same_count, take_back, write_all};
use crate::route::{ArcfeedRoute, with_route};
use crate::status::ArcfeedStatus::ArcfeedInvalid;
use crate::status::{ArcfeedStatus, Outcome, guarded, of_sync, refuse};

/// Generates the motion of 1 to 8 axes one control cycle at a time, towards targets and within limits that may change in
/// any cycle. One thread uses it at a time.
pub struct ArcfeedGenerator {
    pub(crate) inner: Box<dyn Generate>,
}

/// What happened in a cycle. Bit k of a mask belongs to axis k.
#[repr(C)]
#[derive(Debug, Clone, Copy, Default)]
pub struct ArcfeedEvents {
    /// The axes that arrived in this cycle: each is in its target exactly.
    pub arrived: u32,
    /// The axes that go on after their target and brake because their range ends.
    pub range_ends: u32,
    /// Number of way-points of the route that were passed in this cycle; one with a blend is passed where the blend ends.
    pub passed: usize,
    /// The last axis that was under way arrived in this cycle.
    pub reached: bool,
    /// A new plan took effect because the target or the limits changed.
    pub replanned: bool,
    /// Limits were set below the state of an axis: it is brought back inside while this holds.
    pub outside_limits: bool,
}

/// A generator and, once a route is to be followed, the memory that plans one.
struct Online<const N: usize> {
    generator: OnlineGenerator<N, WayPointTrajectory<N>>,
    planner: Option<Box<WayPointPlanner<N>>>,
}

/// [`OnlineGenerator`] without its number of axes.
pub(crate) trait Generate {
    fn axes(&self) -> usize;
    fn set_ranges(&mut self, ranges: &All<(f64, f64)>) -> Result<(), SyncError>;
    fn set_target(&mut self, target: &All<AxisState>) -> Result<(), SyncError>;
    fn set_axis_target(&mut self, axis: usize, target: AxisState) -> Result<(), SyncError>;
    fn set_limits(&mut self, limits: &All<AxisLimits>) -> Result<(), SyncError>;
    fn set(&mut self, target: &All<AxisState>, limits: &All<AxisLimits>) -> Result<(), SyncError>;
    fn stop(&mut self) -> Result<(), SyncError>;
    fn stop_on_path(&mut self);
    fn jog(&mut self, velocity: &All<f64>, timeout: f64) -> Result<(), SyncError>;
    fn set_scale(&mut self, scale: f64) -> Result<(), SyncError>;
    fn hold(&mut self);
    fn resume(&mut self);
    fn step(&mut self) -> (All<ArcfeedMotionState>, ArcfeedEvents);
    fn state(&self) -> &[AxisState];
    fn target(&self) -> &[AxisState];
    fn is_underway(&self) -> bool;
    fn time_left(&self) -> f64;
    fn scale(&self) -> f64;
    fn reserve_way_points(&mut self);
    /// Pointers of the route are NULL, not aligned, or point to what their names say.
    unsafe fn set_route(&mut self, route: &ArcfeedRoute) -> Outcome;
    fn section_durations(&self) -> &[f64];
    fn route_at(&self, t: f64) -> All<ArcfeedMotionState>;
}

impl<const N: usize> Generate for Online<N> {
    fn axes(&self) -> usize {
        N
    }

    fn set_ranges(&mut self, ranges: &All<(f64, f64)>) -> Result<(), SyncError> {
        self.generator = self.generator.clone().with_ranges(of_axes(ranges))?;
        Ok(())
    }

    fn set_target(&mut self, target: &All<AxisState>) -> Result<(), SyncError> {
        self.generator.set_target(of_axes(target))
    }

    fn set_axis_target(&mut self, axis: usize, target: AxisState) -> Result<(), SyncError> {
        self.generator.set_axis_target(axis, target)
    }

    fn set_limits(&mut self, limits: &All<AxisLimits>) -> Result<(), SyncError> {
        self.generator.set_limits(of_axes(limits))
    }

    fn set(&mut self, target: &All<AxisState>, limits: &All<AxisLimits>) -> Result<(), SyncError> {
        self.generator.set(of_axes(target), of_axes(limits))
    }

    fn stop(&mut self) -> Result<(), SyncError> {
        self.generator.stop()
    }

    fn stop_on_path(&mut self) {
        self.generator.stop_on_path();
    }

    fn jog(&mut self, velocity: &All<f64>, timeout: f64) -> Result<(), SyncError> {
        self.generator.jog(of_axes(velocity), timeout)
    }

    fn set_scale(&mut self, scale: f64) -> Result<(), SyncError> {
        self.generator.set_scale(scale)
    }

    fn hold(&mut self) {
        self.generator.hold();
    }

    fn resume(&mut self) {
        self.generator.resume();
    }

    fn step(&mut self) -> (All<ArcfeedMotionState>, ArcfeedEvents) {
        let step = self.generator.step();
        let mask = |axes: &[bool; N]| axes.iter().rev().fold(0, |bits, &axis| bits << 1 | u32::from(axis));
        let events = ArcfeedEvents {
            arrived: mask(&step.events.arrived),
            range_ends: mask(&step.events.range_ends),
            passed: step.events.passed,
            reached: step.events.reached,
            replanned: step.events.replanned,
            outside_limits: step.events.outside_limits,
        };
        (motion_states(&step.state), events)
    }

    fn state(&self) -> &[AxisState] {
        self.generator.state()
    }

    fn target(&self) -> &[AxisState] {
        self.generator.target()
    }

    fn is_underway(&self) -> bool {
        self.generator.is_underway()
    }

    fn time_left(&self) -> f64 {
        self.generator.time_left()
    }

    fn scale(&self) -> f64 {
        self.generator.scale()
    }

    fn reserve_way_points(&mut self) {
        self.planner.get_or_insert_default();
    }

    unsafe fn set_route(&mut self, route: &ArcfeedRoute) -> Outcome {
        let Some(planner) = &mut self.planner else {
            let text = "there is no memory for routes yet; call arcfeed_generator_reserve_way_points once before";
            return Err(refuse(ArcfeedInvalid, text));
        };
        unsafe { with_route(route, |route| self.generator.set_route(route, planner)) }
    }

    fn section_durations(&self) -> &[f64] {
        self.generator.route().section_durations()
    }

    fn route_at(&self, t: f64) -> All<ArcfeedMotionState> {
        motion_states(&self.generator.route().at(t))
    }
}

fn make<const N: usize>(
    start: &All<AxisState>,
    limits: &All<AxisLimits>,
    cycle: f64,
    mode: Synchronisation,
) -> Outcome<Box<dyn Generate>> {
    let generator = OnlineGenerator::<N>::new(of_axes(start), of_axes(limits), cycle, mode).map_err(of_sync)?;
    Ok(Box::new(Online { generator: generator.with_way_points(), planner: None }))
}

/// A generator at `start`, which is the target, too, until one is set. `start` and `limits` have `axes` entries; `cycle`
/// is the control cycle (s); `synchronisation` is an ArcfeedSynchronisation. On success `*out` holds the generator, else NULL.
///
/// # Safety
/// Each pointer is valid for its type, or NULL, which is refused.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn arcfeed_generator_new(
    axes: usize,
    start: *const ArcfeedAxisState,
    limits: *const ArcfeedAxisLimits,
    cycle: f64,
    synchronisation: i32,
    out: *mut *mut ArcfeedGenerator,
) -> ArcfeedStatus {
    guarded(|| unsafe {
        *place("out", out)? = ptr::null_mut();
        let start = read_all("start", start, axes, axes::state)?;
        let limits = read_all("limits", limits, axes, axes::limits)?;
        let mode = axes::synchronisation(synchronisation)?;
        let inner = by_count!(axes, make(&start, &limits, cycle, mode))?;
        hand_out("out", out, ArcfeedGenerator { inner })
    })
}

/// Frees a generator; NULL is nothing to free.
///
/// # Safety
/// The generator is not used again.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn arcfeed_generator_free(generator: *mut ArcfeedGenerator) {
    unsafe { take_back(generator) };
}

/// Runs a call on a generator whose number of axes the caller gives.
unsafe fn on(
    generator: *mut ArcfeedGenerator,
    axes: usize,
    call: impl FnOnce(&mut dyn Generate) -> Outcome,
) -> ArcfeedStatus {
    guarded(|| {
        let generator = unsafe { place("generator", generator) }?;
        same_count(axes, generator.inner.axes())?;
        call(&mut *generator.inner)
    })
}

/// Sets the range of positions of each axis. What is under way must stay inside, else the call is refused.
///
/// # Safety
/// Each pointer is valid for its type, or NULL, which is refused.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn arcfeed_generator_set_ranges(
    generator: *mut ArcfeedGenerator,
    axes: usize,
    ranges: *const ArcfeedRange,
) -> ArcfeedStatus {
    unsafe {
        on(generator, axes, |inner| inner.set_ranges(&read_all("ranges", ranges, axes, axes::range)?).map_err(of_sync))
    }
}

/// Sets the state to reach. A call that is refused changes nothing.
///
/// # Safety
/// Each pointer is valid for its type, or NULL, which is refused.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn arcfeed_generator_set_target(
    generator: *mut ArcfeedGenerator,
    axes: usize,
    target: *const ArcfeedAxisState,
) -> ArcfeedStatus {
    unsafe {
        on(generator, axes, |inner| inner.set_target(&read_all("target", target, axes, axes::state)?).map_err(of_sync))
    }
}

/// Sets the state that one axis, counted from 0, is to reach.
///
/// # Safety
/// Each pointer is valid for its type, or NULL, which is refused.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn arcfeed_generator_set_axis_target(
    generator: *mut ArcfeedGenerator,
    axis: usize,
    target: *const ArcfeedAxisState,
) -> ArcfeedStatus {
    guarded(|| unsafe {
        let generator = place("generator", generator)?;
        let target = read_all("target", target, 1, axes::state)?[0];
        generator.inner.set_axis_target(axis, target).map_err(of_sync)
    })
}

/// Sets the limits of all axes. The target must be inside of them, else the call is refused; so it is on a route, which has its own
/// limits, until the axes have left it.
///
/// # Safety
/// Each pointer is valid for its type, or NULL, which is refused.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn arcfeed_generator_set_limits(
    generator: *mut ArcfeedGenerator,
    axes: usize,
    limits: *const ArcfeedAxisLimits,
) -> ArcfeedStatus {
    unsafe {
        on(generator, axes, |inner| inner.set_limits(&read_all("limits", limits, axes, axes::limits)?).map_err(of_sync))
    }
}

/// Sets target and limits at once: where neither goes with the other's old value.
///
/// # Safety
/// Each pointer is valid for its type, or NULL, which is refused.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn arcfeed_generator_set(
    generator: *mut ArcfeedGenerator,
    axes: usize,
    target: *const ArcfeedAxisState,
    limits: *const ArcfeedAxisLimits,
) -> ArcfeedStatus {
    let call = |inner: &mut dyn Generate| unsafe {
        let target = read_all("target", target, axes, axes::state)?;
        let limits = read_all("limits", limits, axes, axes::limits)?;
        inner.set(&target, &limits).map_err(of_sync)
    };
    unsafe { on(generator, axes, call) }
}

/// Copies the state of the last step.
///
/// # Safety
/// Each pointer is valid for its type, or NULL, which is refused; `states` has room for `axes` entries.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn arcfeed_generator_state(
    generator: *const ArcfeedGenerator,
    axes: usize,
    states: *mut ArcfeedAxisState,
) -> ArcfeedStatus {
    guarded(|| unsafe {
        let inner = &held("generator", generator)?.inner;
        same_count(axes, inner.axes())?;
        write_all("states", states, inner.state().iter().map(|s| ArcfeedAxisState::from(*s)))
    })
}

/// Copies the target; after a stop the place where the axes will stand.
///
/// # Safety
/// Each pointer is valid for its type, or NULL, which is refused; `target` has room for `axes` entries.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn arcfeed_generator_target(
    generator: *const ArcfeedGenerator,
    axes: usize,
    target: *mut ArcfeedAxisState,
) -> ArcfeedStatus {
    guarded(|| unsafe {
        let inner = &held("generator", generator)?.inner;
        same_count(axes, inner.axes())?;
        write_all("target", target, inner.target().iter().map(|s| ArcfeedAxisState::from(*s)))
    })
}
